/* SPDX-License-Identifier: GPL-3.0-or-later
 * effects.c - the table of effects that a model may lack.
 *
 * Equations come from law.h and model.h: a kind is a term of a law; its parameter is neutral until
 * it is stated. Kinds and places are names that other programs rely on. Laws: viscous, Coulomb and
 * Stribeck friction (Armstrong-Helouvry 1994), Hunt & Crossley (1975) contacts, instruments with
 * gain, offset, lag and a quadratic error.
 *
 * A table instead of code per effect: the code that lists, tests, fits, writes and explains a
 * candidate is then written once. A new effect is one entry here, its limit in limits.c and a term
 * of a law (docs/architecture.md). Effects that add a coordinate or a part are marked (`needs`):
 * the present equations have no parameter for them. Theirs is a number of the mechanism to which
 * lab_candidate_open adds that part.
 */
#include <string.h>

#include "open.h"
#include "stein/diagnose.h"

#define MISSING "missing_effect"
#define WRONG   "wrong_parameter"

static const lab_effect effects[] = {
    {"viscous_friction", MISSING, "dissipation", LAB_AT_JOINT, "b", "damping", NULL, NULL,
     "torque -b qd", "decay in proportion to speed; ring-down by a constant ratio",
     "quadratic_drag coulomb_friction", NULL, 0, 0},
    {"coulomb_friction", MISSING, "dissipation", LAB_AT_JOINT, "T", "coulomb.T", "coulomb.w", NULL,
     "torque -T tanh(qd/w)",
     "constant loss in either direction; small and slow motions lose the largest share",
     "viscous_friction preload stiction_peak", NULL, 0, 0},
    {"stiction_peak", MISSING, "dissipation", LAB_AT_JOINT, "B1", "friction.B1", "friction.B2",
     "friction.A", "joint friction A (tanh u + B1 u/(1 + B2 u^4)), u = qd/vt",
     "late, sudden starts; only at low speed", "coulomb_friction", NULL, 0, 0},
    {"quadratic_drag", MISSING, "dissipation", LAB_AT_JOINT, "k", "drag", NULL, NULL,
     "torque -k |qd| qd", "loss that grows with the square of speed; large and quick motions only",
     "viscous_friction", NULL, 0, 0},
    {"viscous_asymmetry", MISSING, "dissipation", LAB_AT_JOINT, "s", "asymmetry", NULL, "damping",
     "viscous friction times 1 + s tanh(qd/w): more one way than the other",
     "a loss in proportion to speed that differs by direction", "quadratic_drag preload", NULL, 1,
     0},
    {"coulomb_asymmetry", MISSING, "dissipation", LAB_AT_JOINT, "s", "coulomb.asymmetry", NULL,
     "coulomb.T", "Coulomb friction times 1 + s tanh(qd/w): more one way than the other",
     "a constant loss that differs by direction, nothing at rest", "preload", NULL, 1, 0},
    {"preload", MISSING, "stiffness", LAB_AT_JOINT, "T", "preload", NULL, NULL, "torque T",
     "constant pull in one direction, also at rest", "centre joint_stiffness coulomb_asymmetry",
     NULL, 1, 0},
    {"joint_stiffness", MISSING, "stiffness", LAB_AT_JOINT, "k", "spring.k", NULL, NULL,
     "torque -k q", "restoring, grows with the angle", "preload hardening_spring centre", NULL, 0,
     0},
    {"hardening_spring", MISSING, "stiffness", LAB_AT_JOINT, "k3", "spring.k3", NULL, NULL,
     "torque -k3 (q - theta0)^3", "stiffer at large angles", "joint_stiffness", NULL, 1, 0},
    {"backlash", MISSING, "stiffness", LAB_AT_JOINT, "k", "backlash.k", "backlash.gap", NULL,
     "torque -k (|q| - gap) sign(q) beyond +-gap", "nothing up to an angle, then a spring",
     "joint_stiffness hardening_spring", NULL, 0, 0},
    {"mass", WRONG, "inertia", LAB_AT_BODY, "mass", "mass", NULL, NULL, "mass of the body",
     "all levels alike; weight and inertia together", "inertia centre unknown_load", NULL, 1, 0},
    {"centre", WRONG, "inertia", LAB_AT_BODY, "shift", "centre.x", NULL, NULL,
     "centre of mass along the body", "all levels alike; slow phases most", "preload mass", NULL, 1,
     0},
    {"inertia", WRONG, "inertia", LAB_AT_BODY, "inertia", "inertia.yy", NULL, NULL,
     "moment of inertia about the centre", "all levels alike; fast phases most",
     "mass joint_stiffness", NULL, 1, 0},
    {"armature", MISSING, "inertia", LAB_AT_JOINT, "armature", NULL, NULL, NULL,
     "inertia of a rotor behind the gear: torque -armature qdd in the joint alone",
     "resists acceleration, weighs nothing; the parent's motion does not count", "inertia mass",
     "structure", 0, 0},
    {"elastic_hinge", MISSING, "part", LAB_AT_BODY, "compliance", NULL, "damping_ratio", NULL,
     "the link bends at one place: torque k dphi + d dphid, k = 1/compliance",
     "a quick oscillation after kick and impact", "compliant_partner", "structure", 0, 0},
    {"axis_translation", MISSING, "part", LAB_AT_BODY, "compliance", NULL, "damping_ratio", NULL,
     "the axis moves by u: force -k u - d ud, k = 1/compliance, upwards 1/compliance/(1 + lift)",
     "the body moves as a whole when it is loaded", "elastic_hinge", "structure", 0, 0},
    {"contact_stiffness", WRONG, "contact", LAB_AT_SURFACE, "log_scale", "normal.c", NULL, NULL,
     "normal force times exp(log_scale)", "depth and duration of the contact",
     "contact_exponent contact_gap", NULL, 1, 0},
    {"contact_exponent", MISSING, "contact", LAB_AT_SURFACE, "p", "normal.p", NULL, NULL,
     "normal force times (x/0.1 mm)^p", "duration of the contact depends on the level",
     "contact_stiffness", NULL, 1, 0},
    {"contact_damping", WRONG, "contact", LAB_AT_SURFACE, "log_scale", "normal.D", NULL, NULL,
     "D times exp(log_scale)", "height of the rebound", "contact_hysteresis contact_friction", NULL,
     1, 0},
    {"contact_hysteresis", MISSING, "contact", LAB_AT_SURFACE, "h", "normal.h", NULL, NULL,
     "normal force times 1 + h tanh(xdot/0.01 m/s)", "rebound, whatever the speed",
     "contact_damping", NULL, 0, 0},
    {"contact_friction", WRONG, "contact", LAB_AT_SURFACE, "log_scale", "friction.A", NULL, NULL,
     "mu times exp(log_scale)", "loss while surfaces slide under load", "contact_damping", NULL, 1,
     0},
    {"adhesion", MISSING, "contact", LAB_AT_CONTACT, "F", "adhesion.F", "adhesion.range", NULL,
     "pull 4 F u (1 - u), u = -x/range, 0 < u < 1", "late separation; nothing while pressed",
     "contact_hysteresis", NULL, 0, 0},
    {"contact_gap", WRONG, "contact", LAB_AT_SURFACE, "gap", "gap", NULL, NULL,
     "the surface lies deeper by gap",
     "the contact begins elsewhere; event times of all levels alike",
     "wrong_parameter contact_stiffness", NULL, 1, 0},
    {"compliant_partner", MISSING, "part", LAB_AT_CONTACT, "compliance", NULL, "mass", NULL,
     "the partner is a mass on a spring with damper, k = 1/compliance", "long or double contacts",
     "contact_stiffness", "structure", 0, 0},
    {"string_damper", MISSING, "part", LAB_AT_BODY, "F0", NULL, "x0", NULL,
     "from dip x0 on the front is pushed up by F0 + k (dip - x0)", "a step of force in mid-travel",
     "joint_stiffness backlash hardening_spring", "structure", 0, 0},
    {"wire", MISSING, "part", LAB_AT_BODY, "k", NULL, "stretch", NULL,
     "spring from a point to the frame, stretched by a share of its length at rest",
     "pull towards a point", "joint_stiffness preload", "structure", 0, 0},
    {"one_sided_link", MISSING, "contact", LAB_AT_LINK, "slack", "slack", NULL, NULL,
     "pull of the link times 1 - slack: at 1 it only pushes",
     "what is driven flies on where the driver slows down", "let_off", NULL, 0, 0},
    {"let_off", MISSING, "contact", LAB_AT_LINK, "lower", "let_off.z", "let_off.share", "let_off.z",
     "the link lets go of what it drives at a height of its first end, z_off - lower",
     "what is driven goes its own way near the end of the driver's travel", "one_sided_link", NULL,
     0, 0},
    {"unknown_load", "input", "drive", LAB_AT_LOAD, "error", "error", NULL, NULL,
     "mass of the load times 1 + error", "drive too strong or too weak, all phases under load",
     "mass", NULL, 1, 0},
    {"input_gain", "input", "drive", LAB_AT_INPUT, "error", "gain", NULL, NULL,
     "true input = (1 + error) recorded", "acts with the input and stops with it", "mass", NULL, 1,
     0},
    {"input_delay", "input", "drive", LAB_AT_INPUT, "delay", "delay", NULL, NULL,
     "the true input comes later than recorded", "shift in proportion to the input's rate",
     "sensor_delay", NULL, 1, 0},
    {"sensor_gain", "sensor", "sensor", LAB_AT_CHANNEL, "error", "sensor.gain", NULL, NULL,
     "reading y (1 + error)", "one channel, in proportion to its travel", "camera_tilt", NULL, 1,
     0},
    {"sensor_offset", "sensor", "sensor", LAB_AT_CHANNEL, "offset", "sensor.offset", NULL, NULL,
     "reading y + offset", "one channel, from the first sample on; a marker's offset says the same",
     "", NULL, 1, 0},
    // a sensor shows what was: where it is not known when a record began, one that seems to be
    // ahead is another one that is late
    {"sensor_delay", "sensor", "sensor", LAB_AT_CHANNEL, "delay", "sensor.delay", NULL, NULL,
     "reading y(t - delay)", "one channel, in proportion to its rate", "time_base", NULL, 0, 1},
    {"time_base", "sensor", "clock", LAB_AT_CLOCK, "error", "clock.error", NULL, NULL,
     "the frame at recorded time t was taken at (1 + error) t",
     "all channels, ever later or earlier", "sensor_delay", NULL, 1, 1},
    {"sensor_nonlinearity", "sensor", "sensor", LAB_AT_CHANNEL, "k2", "sensor.square", NULL, NULL,
     "reading y + k2 (y - y at rest)^2", "one channel, at the far end of its travel", "sensor_gain",
     NULL, 1, 0},
    {"camera_tilt", "sensor", "sensor", LAB_AT_MARKER, "tilt", "sensor.tilt", NULL, NULL,
     "reading y + tilt (x - x at rest), x the horizontal position of the marker",
     "one channel, follows the marker's sideways motion", "sensor_nonlinearity sensor_gain", NULL,
     1, 0},
    {"wrong_parameter", WRONG, "geometry", LAB_AT_PARAMETER, "change", "", NULL, NULL,
     "a number of the file is another one", "all levels alike", "contact_gap", NULL, 1, 0},
    {"wrong_setting", WRONG, "setting", LAB_AT_SETTING, "change", "", NULL, NULL,
     "a number that one record states is another one", "one record alone", "", NULL, 1, 0},
};

const lab_effect *lab_effects(int *n)
{
    *n = (int)(sizeof effects / sizeof *effects);
    return effects;
}

const lab_effect *lab_effect_find(const char *kind)
{
    for (size_t i = 0; i < sizeof effects / sizeof *effects; i++) {
        if (strcmp(effects[i].kind, kind) == 0) {
            return &effects[i];
        }
    }
    return NULL;
}

int lab_effect_is_compliance(const lab_effect *effect)
{
    return strcmp(effect->size, "compliance") == 0;
}

int lab_effect_is(const lab_effect *effect, const char *word)
{
    return strcmp(word, "all") == 0 || strcmp(word, effect->kind) == 0 ||
           strcmp(word, effect->cls) == 0 || strcmp(word, lab_site_text(effect->site)) == 0;
}

/* would it scale a number that is 0? */
static int scales_nothing(const lab_candidate *c)
{
    return strcmp(c->effect->size, "log_scale") == 0 && c->move == LAB_MOVE_ADD;
}

int lab_candidate_is_signed(const lab_candidate *c)
{
    return (c->effect->both_signs && !scales_nothing(c)) || c->number > 0.0;
}

int lab_candidate_is_mistakable(const lab_candidate *c)
{
    return c->number > 0.0 || c->effect->site == LAB_AT_CLOCK || c->effect->site == LAB_AT_CHANNEL;
}

const char *lab_candidate_size(const lab_candidate *c)
{
    return scales_nothing(c) ? "change" : c->effect->size;
}

const char *lab_candidate_equation(const lab_candidate *c)
{
    return scales_nothing(c) ? "0 of the file plus change" : c->effect->equation;
}

const char *lab_effect_share(const lab_effect *effect)
{
    return effect->share;
}

const char *lab_effect_family(const lab_effect *effect)
{
    return effect != NULL && effect->family != NULL ? effect->family : "unknown";
}

const char *lab_site_text(lab_site site)
{
    static const char *const text[] = {"joint",  "body",  "contact",   "contact or notch",
                                       "link",   "load",  "input",     "channel",
                                       "marker", "clock", "parameter", "setting"};
    return text[site];
}
