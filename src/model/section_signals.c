/* SPDX-License-Identifier: MIT
 * section_signals.c - inputs, outputs, the elements of a stroke, and the simulation's defaults.
 */
#include <math.h>
#include <string.h>

#include "reader.h"
#include "stein/model.h"

/** Readings of one kind of element; the words of `choices` are the keys of `what`. */
typedef struct readable {
    const char *key, *what, *choices;
    int first; /* stein_read_kind of the first choice, the others follow */
} readable;

static const readable readables[] = {
    {"joint", "reading of a joint", "position speed acceleration reaction", STEIN_READ_POSITION},
    {"point", "reading of a point", "x y z vx vy vz", STEIN_READ_X},
    {"contact", "reading of a contact", "gap force friction", STEIN_READ_GAP},
    {"notch", "reading of a notch", "force phase overlap", STEIN_READ_NOTCH_FORCE},
    {"input", "reading of an input", "value force", STEIN_READ_INPUT},
    {"body", "reading of a body", "roll pitch yaw xx xy xz yx yy yz zx zy zz wx wy wz angle",
     STEIN_READ_ROLL},
    {"loop", "reading of a loop or coupling", "reaction", STEIN_READ_REACTION},
};
enum { JOINT, POINT, CONTACT, NOTCH, INPUT, BODY, LOOP, NREADABLE };
enum { REACTION_OF_JOINT = 3 }; /* choice of a joint */

/** Names of all things of one kind, for finding one by name. */
static const char *name_of(const mechanism *m, int kind, int i)
{
    switch (kind) {
    case JOINT:
    case BODY: return i < m->nbody ? m->bodies[i].name : NULL;
    case POINT: return i < m->npoint ? m->points[i].name : NULL;
    case CONTACT: return i < m->ncontact ? m->contacts[i].name : NULL;
    case NOTCH: return i < m->nnotch ? m->notches[i].name : NULL;
    case LOOP: return i < m->nloop ? m->loops[i].name : NULL;
    default: return i < m->ninput ? m->inputs[i].name : NULL;
    }
}

const char *mech_target(const mechanism *m, const mech_channel *c)
{
    int kind = NREADABLE - 1;

    if (c->read == STEIN_READ_REACTION) {
        return name_of(m, c->loop ? LOOP : BODY, c->index);
    }
    if (c->read == STEIN_READ_KINETIC || c->read == STEIN_READ_POTENTIAL) {
        return "";
    }
    while (c->read < readables[kind].first) {
        kind--;
    }
    return name_of(m, kind, c->index);
}

/** Index of the thing a scalar names, -1 after noting a problem. */
static int find_thing(mech__reader *rd, const mech__node *node, int kind)
{
    const char *key = readables[kind].key;
    const char *name = mech__text(rd, node, key), *other;

    if (!name) {
        return -1;
    }
    mech__nearest near = {name, NULL, 0};

    for (int i = 0; (other = name_of(rd->m, kind, i)); i++) {
        if (strcmp(other, name) == 0) {
            return kind == JOINT && mech__has_joint(rd, node, i) != 0 ? -1 : i;
        }
        mech__offer(&near, other);
    }
    mech__problem_at(rd, node, "there is no %s \"%s\"%s", key, mech__shown(rd, name),
                     mech__hint(rd, &near, ""));
    return -1;
}

/** The only key of `keys` that stands in a mapping; -1 after noting a problem. */
static int only_one(mech__reader *rd, const mech__node *map, const char *const *keys, int n,
                    const char *what)
{
    int found = -1, count = 0;

    for (int i = 0; i < n; i++) {
        if (mech__get(map, keys[i])) {
            found = i;
            count++;
        }
    }
    if (count != 1 && map->kind == MECH__MAP) {
        mech__problem_at(rd, map->key, "%s", what);
    }
    return count == 1 ? found : -1;
}

static void set_unit(char unit[MECH_UNIT], const char *text)
{
    mech__name_copy(unit, MECH_UNIT, text);
}

static void read_direction(mech__reader *rd, mech_input *in, const mech__node *entry)
{
    const mech__node *node = mech__need(rd, entry, "direction", "a force input");
    char *base = mech__print(rd, "%s.direction", in->name);

    if (base && node) {
        mech__vector(rd, in->direction, "1", MECH__VANISHES, node, base);
    }
}

static void read_motion(mech__reader *rd, mech_input *in, const mech__node *entry)
{
    const mech__node *idle = mech__get(entry, "idle");
    int choice = idle ? mech__choice(rd, idle, "idle state", "free hold") : 0;

    in->hold = choice == 1;
    for (const mech_input *other = rd->m->inputs; other < in; other++) {
        if (other->kind == STEIN_INPUT_MOTION && other->index == in->index && in->index >= 0) {
            mech__problem_at(rd, entry->key, "the joint %s has two motion inputs, expected one",
                             rd->m->bodies[in->index].name);
        }
    }
}

static void read_voltage(mech__reader *rd, mech_input *in, const mech__node *node)
{
    const mech_body *b = in->index >= 0 ? &rd->m->bodies[in->index] : NULL;

    if (b && !b->has_motor) {
        mech__problem_at(rd, node,
                         "the joint %s has no motor, expected motor: {torque_constant: .., "
                         "resistance: .., gear: ..} in that body, or torque instead of voltage",
                         b->name);
    } else if (b) {
        mech__repeat(rd, &in->direction[0], &b->per_volt);
    }
}

static void read_input(mech__reader *rd, mech_input *in, const mech__node *entry)
{
    static const char *const keys[] = {"torque", "force", "motion",
                                       "voltage"}; /* stein_input_kind */
    int kind = only_one(rd, entry, keys, 4,
                        "an input needs exactly one of force, torque, motion, voltage");

    mech__name_copy(in->name, sizeof in->name, entry->key->text);
    mech__keys(rd, entry, "an input",
               kind == 0   ? "torque gain delay"
               : kind == 1 ? "force direction gain delay"
               : kind == 2 ? "motion idle gain delay"
               : kind == 3 ? "voltage gain delay"
                           : "force direction torque motion voltage idle gain delay");
    mech__input_law(rd, in, entry);
    in->index = -1;
    if (kind < 0) {
        return;
    }
    in->kind = kind;
    in->index =
        find_thing(rd, mech__get(entry, keys[kind]), kind == STEIN_INPUT_POINT ? POINT : JOINT);
    int turns = kind != STEIN_INPUT_POINT && in->index >= 0 && rd->m->bodies[in->index].type == 'R';

    if (kind == STEIN_INPUT_POINT) {
        set_unit(in->unit, "N");
        read_direction(rd, in, entry);
    } else if (kind == STEIN_INPUT_JOINT) {
        set_unit(in->unit, turns ? "N m" : "N");
    } else if (kind == STEIN_INPUT_VOLTAGE) {
        set_unit(in->unit, "V");
        read_voltage(rd, in, mech__get(entry, keys[kind]));
    } else {
        set_unit(in->unit, turns ? "rad" : "m");
        read_motion(rd, in, entry);
    }
}

static const char *joint_unit(const mechanism *m, int index, const char *const turning[3],
                              const char *const sliding[3], int which)
{
    return m->bodies[index].type == 'R' ? turning[which] : sliding[which];
}

static const char *reaction_unit(const mechanism *m, const mech_channel *c)
{
    int couples = c->loop && m->loops[c->index].kind == MECH_COUPLING;
    int turns = couples && m->bodies[m->loops[c->index].index[0]].type == 'R';
    int moment = c->component == STEIN_MOMENT_SIZE ||
                 (c->component >= STEIN_MOMENT_X && c->component <= STEIN_MOMENT_Z);

    return turns || moment ? "N m" : "N";
}

static const char *channel_unit(const mechanism *m, const mech_channel *c)
{
    static const char *const turning[] = {"rad", "rad/s", "rad/s^2"};
    static const char *const sliding[] = {"m", "m/s", "m/s^2"};

    switch (c->read) {
    case STEIN_READ_REACTION: return reaction_unit(m, c);
    case STEIN_READ_POSITION:
    case STEIN_READ_SPEED:
    case STEIN_READ_ACCELERATION:
        return joint_unit(m, c->index, turning, sliding, c->read - STEIN_READ_POSITION);
    case STEIN_READ_VX:
    case STEIN_READ_VY:
    case STEIN_READ_VZ: return "m/s";
    case STEIN_READ_FORCE:
    case STEIN_READ_TANGENT:
    case STEIN_READ_NOTCH_FORCE: return "N";
    case STEIN_READ_NOTCH_PHASE: return "1";
    case STEIN_READ_INPUT: return m->inputs[c->index].unit;
    case STEIN_READ_INPUT_FORCE:
        return m->bodies[m->inputs[c->index].index].type == 'R' ? "N m" : "N";
    case STEIN_READ_KINETIC:
    case STEIN_READ_POTENTIAL: return "J";
    case STEIN_READ_ROLL:
    case STEIN_READ_PITCH:
    case STEIN_READ_YAW:
    case STEIN_READ_ANGLE: return "rad";
    default: return c->read >= STEIN_READ_WX ? "rad/s" : c->read >= STEIN_READ_XX ? "1" : "m";
    }
}

static int read_energy(mech__reader *rd, mech_channel *c, const mech__node *entry)
{
    int choice = mech__choice(rd, mech__get(entry, "energy"), "energy", "kinetic potential");

    mech__keys(rd, entry, "an output of energy", "energy sign zero sensor");
    c->read = STEIN_READ_KINETIC + choice;
    return choice < 0 ? -1 : 0;
}

/** Component of the reaction of a joint or a loop; default: the size of the force.
 *  @return 0 when it is known */
static int read_reaction(mech__reader *rd, mech_channel *c, const mech__node *entry)
{
    const mech__node *part = mech__get(entry, "component"), *axes = mech__get(entry, "axes");
    int couples = c->loop && rd->m->loops[c->index].kind == MECH_COUPLING;

    c->component = STEIN_FORCE_SIZE;
    c->axes = -1;
    if (!c->loop && rd->m->bodies[c->index].type == MECH__FIXED) {
        mech__problem_at(rd, mech__get(entry, "joint"), "%s is fixed, expected a body with a joint",
                         rd->m->bodies[c->index].name);
        return -1;
    }
    if (couples) {
        c->component = STEIN_FORCE_X;
        if (part || axes) {
            mech__problem_at(rd, part ? part : axes,
                             "the coupling %s has one force, that on the joint that follows, "
                             "expected neither component nor axes",
                             rd->m->loops[c->index].name);
        }
        return part || axes ? -1 : 0;
    }
    if (part) {
        c->component = mech__choice(rd, part, "component", "fx fy fz mx my mz force moment");
    }
    if (axes && c->component >= STEIN_FORCE_SIZE) {
        mech__problem_at(rd, axes, "a size has no axes, expected component: fx fy fz mx my mz");
        return -1;
    }
    return c->component < 0 || (axes && mech__body_ref(rd, axes, 1, &c->axes)) ? -1 : 0;
}

/** Of what a joint's reading is: a ball, too, transmits a force. */
static int find_joint(mech__reader *rd, const mech__node *node, int reaction)
{
    int body;

    if (!reaction) {
        return find_thing(rd, node, JOINT);
    }
    return mech__body_ref(rd, node, 0, &body) ? -1 : body;
}

/** A body has a plane angle when all joints that turn it do so about one axis. */
static int check_plane(mech__reader *rd, const mech__node *node, int body)
{
    const mech_body *all = rd->m->bodies, *first = NULL;

    for (int i = body; i >= 0; i = all[i].parent) {
        if (all[i].type == 'R' && first && all[i].axis != first->axis) {
            mech__problem_at(rd, node,
                             "%s turns in space, about %c and %c, and has no angle in a plane, "
                             "expected roll, pitch, yaw or an element of its attitude (xx .. zz)",
                             all[body].name, all[i].axis, first->axis);
            return -1;
        }
        first = all[i].type == 'R' && !first ? &all[i] : first;
    }
    if (!first) {
        mech__problem_at(rd, node,
                         "%s does not turn, expected a body with a joint R on its way to the frame",
                         all[body].name);
    }
    return first ? 0 : -1;
}

/** Reading and element of a channel. @return 0 when both are known */
static int read_source(mech__reader *rd, mech_channel *c, const mech__node *entry)
{
    static const char *const keys[] = {"joint", "point", "contact", "notch",
                                       "input", "body",  "loop",    "energy"};
    int kind = only_one(rd, entry, keys, NREADABLE + 1,
                        "an output needs exactly one of joint, "
                        "point, contact, notch, input, body, loop, energy");

    if (kind == NREADABLE) {
        return read_energy(rd, c, entry);
    }
    mech__keys(rd, entry, "an output",
               kind == JOINT || kind == LOOP
                   ? "joint loop read component axes sign zero sensor"
                   : "joint point contact notch input body loop energy read sign zero sensor");
    if (kind < 0) {
        return -1;
    }
    const readable *r = &readables[kind];
    const mech__node *read = mech__need(rd, entry, "read", "an output");
    int choice = read ? mech__choice(rd, read, r->what, r->choices) : -1;

    int reaction = kind == LOOP || (kind == JOINT && choice == REACTION_OF_JOINT);
    const mech__node *of = mech__get(entry, r->key);
    c->index = kind == JOINT ? find_joint(rd, of, reaction) : find_thing(rd, of, kind);
    c->read = reaction ? STEIN_READ_REACTION : r->first + choice;
    c->loop = kind == LOOP;
    if (choice < 0 || c->index < 0) {
        return -1;
    }
    if (reaction) {
        return read_reaction(rd, c, entry);
    }
    if (mech__get(entry, "component") || mech__get(entry, "axes")) {
        mech__problem_at(rd, mech__get(entry, mech__get(entry, "axes") ? "axes" : "component"),
                         "belongs to read: reaction");
        return -1;
    }
    if (c->read == STEIN_READ_INPUT_FORCE && rd->m->inputs[c->index].kind != STEIN_INPUT_MOTION) {
        mech__problem_at(rd, read, "only a motion input has a force, expected value");
        return -1;
    }
    if (c->read == STEIN_READ_ANGLE) {
        return check_plane(rd, mech__get(entry, r->key), c->index);
    }
    return kind == INPUT && rd->m->inputs[c->index].index < 0 ? -1 : 0;
}

static void read_channel(mech__reader *rd, mech_channel *c, const mech__node *entry)
{
    const mech__node *sign = mech__get(entry, "sign");
    const mech__node *zero = mech__get(entry, "zero");

    mech__name_copy(c->name, sizeof c->name, entry->key->text);
    if (strcmp(c->name, "time") == 0) {
        mech__problem_at(rd, entry->key,
                         "every model has the output \"time\", expected another "
                         "name");
    }
    int side = sign ? mech__choice(rd, sign, "sign", "1 -1 +1") : 0;

    c->sign = side == 1 ? -1 : 1;
    c->from_rest = zero ? mech__choice(rd, zero, "zero", "origin rest") == 1 : 0;
    if (read_source(rd, c, entry) == 0) {
        set_unit(c->unit, channel_unit(rd->m, c));
        mech__sensor_law(rd, c, entry);
    }
}

static void read_stroke(mech__reader *rd)
{
    const mech__node *stroke = mech__get(rd->root, "stroke");

    if (!mech__keys(rd, stroke, "stroke", "string notch")) {
        return;
    }
    const mech__node *string = mech__need(rd, stroke, "string", "stroke");
    const mech__node *notch = mech__get(stroke, "notch");

    rd->m->stroke_string = string ? find_thing(rd, string, CONTACT) : -1;
    rd->m->stroke_notch = notch ? find_thing(rd, notch, NOTCH) : -1;
}

/** A time of the section `simulation`: a plain number, since it is no property of the mechanism. */
static void read_time(mech__reader *rd, const mech__node *map, const char *key, double *value)
{
    const mech__node *node = mech__get(map, key);
    const char *text = node ? mech__text(rd, node, key) : NULL;
    const mech_dim seconds = {.s = 1};
    stein_err err = {STEIN_OK, ""};
    double t = 0.0;

    if (!text) {
        return;
    }
    if (mech_parse_quantity(text, seconds, &t, &err) != STEIN_OK) {
        mech__problem_at(rd, node, "%s = %s", key, err.msg);
    } else if (!(t > 0.0)) {
        mech__problem_at(rd, node, "%s = \"%s\": must be greater than zero", key,
                         mech__shown(rd, text));
    } else {
        *value = t;
    }
}

/** {CHANNEL: VALUE}: the error that steps of controlled error may leave in an output */
static void read_tolerance(mech__reader *rd, const mech__node *map)
{
    static const char *const what = "tolerance";
    mechanism *m = rd->m;
    m->tolerated = -1;
    if (mech__section(rd, map, what, 1) == 0) {
        return;
    }
    const mech__node *entry = map->first;
    for (int i = 0; i < m->nchannel; i++) {
        m->tolerated = strcmp(m->channels[i].name, entry->key->text) == 0 ? i : m->tolerated;
    }
    const char *text = mech__text(rd, entry, what);
    const mech_channel *c = m->tolerated >= 0 ? &m->channels[m->tolerated] : NULL;
    mech_dim dim;
    stein_err err = {STEIN_OK, ""};
    if (c == NULL) {
        mech__problem_at(rd, entry->key, "no output \"%s\", expected one of this file",
                         mech__shown(rd, entry->key->text));
    } else if (!stein_reads_place(c->read)) {
        mech__problem_at(rd, entry->key,
                         "a tolerance in \"%s\", expected an output that reads a position, angle, "
                         "x, y, z or gap",
                         c->name);
    } else if (text == NULL || mech_parse_unit(c->unit, &dim, NULL) != 0) {
        return; // already reported
    } else if (mech_parse_quantity(text, dim, &m->tolerance, &err) != STEIN_OK) {
        mech__problem_at(rd, entry, "tolerance = %s", err.msg);
    } else if (!(m->tolerance > 0.0)) {
        mech__problem_at(rd, entry, "tolerance = \"%s\": must be greater than zero",
                         mech__shown(rd, text));
    }
}

const char *mech_integrator(int integrator)
{
    static const char *const name[] = {"rk4", "dp5", "controlled", "implicit"};
    return name[integrator];
}

static void read_simulation(mech__reader *rd)
{
    mechanism *m = rd->m;
    const mech__node *map = mech__get(rd->root, "simulation");
    const mech__node *integrator = mech__get(map, "integrator");
    const mech__node *settle = mech__get(map, "settle");

    m->dt = 1e-5;
    m->until = 1.0;
    mech__keys(rd, map, "simulation", "dt until integrator settle tolerance");
    read_time(rd, map, "dt", &m->dt);
    read_time(rd, map, "until", &m->until);
    m->integrator = STEIN_CONTROLLED;
    if (integrator) {
        m->integrator = mech__choice(rd, integrator, "integrator", "rk4 dp5 controlled implicit");
    }
    if (settle) {
        m->settle = mech__choice(rd, settle, "answer", "no yes false true") % 2 == 1;
        for (int i = 0; m->settle && i < m->nbody; i++) {
            if (m->bodies[i].ball == 1) {
                mech__problem_at(rd, settle,
                                 "no equilibrium is looked for in a mechanism with a body that "
                                 "turns in all directions, expected settle: no");
                break;
            }
        }
    }
    read_tolerance(rd, mech__get(map, "tolerance"));
}

void mech__section_signals(mech__reader *rd)
{
    mechanism *m = rd->m;
    const mech__node *inputs = mech__get(rd->root, "inputs");
    const mech__node *outputs = mech__get(rd->root, "outputs");
    int n = mech__section(rd, inputs, "an input", MECH__MAX_THINGS);
    int k = mech__section(rd, outputs, "an output", MECH__MAX_THINGS);

    m->inputs = mech__array(rd, n, sizeof *m->inputs);
    m->channels = mech__array(rd, k, sizeof *m->channels);
    for (const mech__node *e = n ? inputs->first : NULL; e && !rd->nomem; e = e->next) {
        read_input(rd, &m->inputs[m->ninput], e);
        m->ninput++;
    }
    for (const mech__node *e = k ? outputs->first : NULL; e && !rd->nomem; e = e->next) {
        read_channel(rd, &m->channels[m->nchannel++], e);
    }
    read_stroke(rd);
    read_simulation(rd);

    const mech__node *clock = mech__get(rd->root, "clock");

    mech__keys(rd, clock, "clock", "error");
    mech__number(rd, &m->clock_error, "1", 0, mech__get(clock, "error"), 0.0, "clock.error");
}
