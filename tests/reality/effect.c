/* SPDX-License-Identifier: GPL-3.0-or-later
 * effect.c - drawing an effect and putting it into the action, its parameters or its instruments.
 */
#include <gsl/gsl_randist.h>
#include <math.h>
#include <string.h>

#include "reality.h"

static const char *const joint_names[] = {"key", "hammer", "pawl"};
static const char *const contact_names[] = {"rest", "dip",  "loops", "string",
                                            "stop", "load", "notch"};
const char *const seen_name[SEEN] = {"string_distance", "key_dip", "hammer_angle"};
const char *const seen_unit[SEEN] = {"m", "m", "rad"};

/* range of motion of the joints, for a gap [rad] */
static const double travel[JOINTS] = {0.04, 0.5, 0.02};

const effect_kind *effect_find(const char *name)
{
    for (const effect_kind *k = effect_kinds; k->name != NULL; k++) {
        if (strcmp(k->name, name) == 0) {
            return k;
        }
    }
    for (const effect_kind *k = outside_kinds; k->name != NULL; k++) {
        if (strcmp(k->name, name) == 0) {
            return k;
        }
    }
    return NULL;
}

/* kinds that are alike in one way or another: losses, springs and weights, felts, instruments */
int effect_has_twins(const effect_kind *kind)
{
    static const char *const like[] = {"viscous_friction",
                                       "quadratic_drag",
                                       "coulomb_friction",
                                       "stiction_peak",
                                       "preload",
                                       "joint_stiffness",
                                       "hardening_spring",
                                       "backlash",
                                       "mass",
                                       "centre",
                                       "inertia",
                                       "contact_stiffness",
                                       "contact_exponent",
                                       "contact_damping",
                                       "contact_gap",
                                       "contact_hysteresis",
                                       "sensor_nonlinearity",
                                       "camera_tilt",
                                       "sensor_gain",
                                       "sensor_delay",
                                       "time_base",
                                       "wire",
                                       "string_damper",
                                       "unknown_load"};
    for (size_t i = 0; i < sizeof like / sizeof *like; i++) {
        if (strcmp(kind->name, like[i]) == 0) {
            return 1;
        }
    }
    return 0;
}

static int is(const effect *e, const char *name)
{
    return e->kind != NULL && strcmp(e->kind->name, name) == 0;
}

/* the n-th of words separated by blanks; 0 when there are fewer */
static int word(const char *words, int n, char out[MECH_PATH])
{
    for (int i = 0; *words != '\0'; i++) {
        size_t length = strcspn(words, " ");
        if (i == n) {
            snprintf(out, MECH_PATH, "%.*s", (int)length, words);
            return 1;
        }
        words += length + strspn(words + length, " ");
    }
    return 0;
}

int effect_nth_place(const effect_kind *kind, int n, char place[MECH_PATH])
{
    return word(kind->places, n, place);
}

int effect_has_place(const effect_kind *kind, const char *place)
{
    char name[MECH_PATH];
    for (int i = 0; word(kind->places, i, name); i++) {
        if (strcmp(name, place) == 0) {
            return 1;
        }
    }
    return 0;
}

static int find(const char *const *names, int n, const char *name)
{
    for (int i = 0; i < n; i++) {
        if (strcmp(names[i], name) == 0) {
            return i;
        }
    }
    return -1;
}

static void locate(effect *e, const mechanism *m)
{
    int at = is(e, "wrong_parameter") ? mech_find_param(m, e->place, NULL) : -1;
    at = at >= 0 ? at : find(joint_names, JOINTS, e->place);
    at = at >= 0 ? at : find(seen_name, SEEN, e->place);
    int contact = find(contact_names, CONTACTS, e->place);
    e->where = contact >= 0 ? contact : at;
}

int effect_draw(effect *e, const effect_kind *kind, const char *place, const mechanism *m,
                gsl_rng *rng)
{
    int n = 0;
    char name[MECH_PATH];
    memset(e, 0, sizeof *e);
    e->kind = kind;
    while (word(kind->places, n, name)) {
        n++;
    }
    word(kind->places, (int)gsl_rng_uniform_int(rng, (unsigned long)n), e->place);
    if (place != NULL) {
        if (!effect_has_place(kind, place)) {
            return -1;
        }
        snprintf(e->place, sizeof e->place, "%s", place);
    }
    locate(e, m);
    for (int i = 0; i < SIDES; i++) {
        const effect_parameter *side = &kind->side[i];
        double u = gsl_rng_uniform(rng);
        int log_range = side->lo > 0.0 && side->hi > 4.0 * side->lo;
        e->side[i] = log_range ? side->lo * pow(side->hi / side->lo, u)
                               : side->lo + u * (side->hi - side->lo);
    }
    if (is(e, "backlash")) {
        e->side[0] *= travel[e->where];
    }
    if (is(e, "axis_translation")) {
        e->side[1] = e->side[1] < 0.7 ? 1.0 : 10.0; // a pin in a round hole, or open above
    }
    if (effect_is_outside(e)) {
        outside_sides(e);
    }
    e->amount = kind->both_signs && gsl_rng_uniform(rng) < 0.5 ? -1.0 : 1.0;
    return 0;
}

/* limit of a plain parameter: 1 mm, 0.06 rad, half of anything else */
static double parameter_limit(const effect *e, const mechanism *m)
{
    const mech_param *p = &m->params[e->where];
    if (strcmp(p->unit, "m") == 0) {
        return 1e-3;
    }
    return strcmp(p->unit, "rad") == 0 ? 0.06 : 0.5 * fabs(p->value);
}

double effect_size(const effect *e)
{
    int body = find(joint_names, JOINTS, e->place);
    double own = body > 0 ? e->kind->limit[body] : 0.0;
    double unit = effect_is_outside(e) ? outside_unit(e) : 1.0;
    return e->amount * (own > 0.0 ? own : e->kind->limit[0]) * unit;
}

/* ---- parameters ---- */

int effect_own_parameter(const effect *e, const mechanism *m)
{
    char name[MECH_PATH + 24];
    const char *part = is(e, "mass")               ? "mass"
                       : is(e, "centre")           ? "centre.x"
                       : is(e, "inertia")          ? "inertia.yy"
                       : is(e, "contact_friction") ? "friction.A"
                                                   : NULL;
    if (is(e, "wrong_parameter")) {
        return e->where;
    }
    if (part == NULL) {
        return -1;
    }
    snprintf(name, sizeof name, "%s.%s", e->place, part);
    return mech_find_param(m, name, NULL);
}

void effect_on_parameters(const effect *e, const mechanism *m, double *p)
{
    int i = effect_own_parameter(e, m);
    double size = e->kind == NULL ? 0.0 : effect_size(e);
    if (i < 0) {
        return;
    }
    if (is(e, "wrong_parameter")) {
        p[i] += e->amount * parameter_limit(e, m);
    } else if (is(e, "centre")) {
        p[i] += size;
    } else if (is(e, "contact_friction")) {
        p[i] *= exp(size);
    } else {
        p[i] *= 1.0 + size;
    }
}

double effect_value(const effect *e, const world *w)
{
    int i = effect_own_parameter(e, w->m);
    if (i < 0) {
        return effect_size(e);
    }
    double old = w->p[i];
    effect_on_parameters(e, w->m, w->p);
    double value = w->p[i];
    w->p[i] = old;
    return value;
}

/* ---- joints and bodies ---- */

static void on_joint(const effect *e, hinge *h, double size)
{
    if (is(e, "viscous_friction")) {
        h->viscous = size;
    } else if (is(e, "coulomb_friction")) {
        h->coulomb = size;
        h->coulomb_w0 = e->side[0];
    } else if (is(e, "stiction_peak")) {
        h->friction.B1 += size;
        h->friction.B2 = e->side[0];
    } else if (is(e, "quadratic_drag")) {
        h->drag = size;
    } else if (is(e, "preload")) {
        h->preload = size;
    } else if (is(e, "joint_stiffness")) {
        h->stiffness = size;
    } else if (is(e, "hardening_spring")) {
        h->hardening = size;
    } else if (is(e, "backlash")) {
        h->slack_k = size;
        h->slack = e->side[0];
    } else if (is(e, "warming_friction")) {
        h->creep = size;
        h->creep_w0 = e->side[0];
        h->creep_turn = e->side[1];
        h->creep_time = e->side[2];
    }
}

/* Where a link bends and what lies beyond: shares of the whole that leave positive inertias. */
static void on_link(const effect *e, action *a, double size)
{
    int hammer = e->where == JOINT_HAMMER;
    const piece *whole = &a->body[e->where];
    split *s = hammer ? &a->hammer_split : &a->key_split;
    s->on = 1;
    s->at = hammer ? (vec){0.045, 0.0} : (vec){-0.04, 0.0};
    s->outer.m = (hammer ? 0.55 : 0.6) * whole->m;
    s->outer.c = hammer ? (vec){whole->c.x + 0.0266, whole->c.z + 0.001}
                        : (vec){whole->c.x - 0.0568, whole->c.z};
    s->outer.I = (hammer ? 0.08 : 0.11) * whole->I;
    double x = s->outer.c.x - s->at.x, z = s->outer.c.z - s->at.z;
    double I = s->outer.I + s->outer.m * (x * x + z * z);
    s->k = 1.0 / size;
    s->d = 2.0 * e->side[0] * sqrt(s->k * I);
}

static void on_parts(const effect *e, action *a, double size)
{
    if (is(e, "elastic_hinge")) {
        on_link(e, a, size);
    } else if (is(e, "axis_translation")) {
        a->pin_k = 1.0 / size;
        a->pin_d = 2.0 * e->side[0] * sqrt(a->pin_k * a->body[JOINT_KEY].m);
        a->pin_ratio = e->side[1];
    } else if (is(e, "string_damper")) {
        a->damper_force = size;
        a->damper_at = e->side[0];
        a->damper_k = e->side[1] * size;
    } else if (is(e, "wire")) {
        a->wire_k = size;
        a->wire_from = (vec){a->front.x, a->front.z + e->side[0]};
        a->wire_length = e->side[0] / (1.0 + e->side[1]);
    } else if (is(e, "compliant_partner")) {
        a->string_k = 1.0 / size;
        a->string_m = e->side[0];
        a->string_d = 2.0 * e->side[1] * sqrt(a->string_k * a->string_m);
    } else if (is(e, "magnetic_pull")) {
        a->magnet = size;
        a->magnet_at = (vec){e->side[0], e->side[1]};
    } else if (is(e, "unknown_load")) {
        a->load_mass *= 1.0 + size;
    } else if (is(e, "input_gain")) {
        a->drive_gain *= 1.0 + size;
    } else if (is(e, "input_delay")) {
        a->drive_delay += size;
    }
}

static void on_contact(const effect *e, felt *f, double size)
{
    if (is(e, "contact_stiffness")) {
        f->scale = exp(size);
    } else if (is(e, "contact_exponent")) {
        f->power = size;
    } else if (is(e, "contact_damping")) {
        f->D *= exp(size);
    } else if (is(e, "contact_hysteresis")) {
        f->hysteresis = size;
    } else if (is(e, "adhesion")) {
        f->pull = size;
        f->range = e->side[0];
    } else if (is(e, "contact_gap")) {
        f->gap = size;
    } else if (is(e, "two_stage_felt")) {
        f->layer = size;
        f->layer_time = e->side[0];
    }
}

void effect_on_action(const effect *e, action *a)
{
    if (e->kind == NULL || !(fabs(e->amount) > 0.0)) {
        return;
    }
    double size = effect_size(e);
    if (effect_is_outside(e)) {
        outside_on_action(e, a, size);
        return;
    }
    int joint = find(joint_names, JOINTS, e->place);
    int contact = find(contact_names, CONTACTS, e->place);
    if (joint >= 0) {
        on_joint(e, &a->joint[joint], size);
    }
    if (contact >= 0) {
        on_contact(e, &a->felt[contact], size);
    }
    on_parts(e, a, size);
}

/* ---- instruments ---- */

void effect_on_sensors(const effect *e, sensor s[SEEN], double *clock)
{
    memset(s, 0, sizeof(sensor[SEEN]));
    *clock = 0.0;
    if (e->kind == NULL) {
        return;
    }
    double size = effect_size(e);
    int i = find(seen_name, SEEN, e->place);
    *clock = is(e, "time_base") ? size : 0.0;
    if (i >= 0) {
        s[i].gain = is(e, "sensor_gain") ? size : 0.0;
        s[i].offset = is(e, "sensor_offset") ? size : 0.0;
        s[i].delay = is(e, "sensor_delay") ? size : 0.0;
        s[i].square = is(e, "sensor_nonlinearity") ? size : 0.0;
        s[i].tilt = is(e, "camera_tilt") ? size : 0.0;
    }
}

int effect_is_instrument(const effect *e)
{
    return e->kind != NULL && e->also == NULL && strcmp(e->kind->verdict, "sensor") == 0;
}

int effect_touch(const effect *e)
{
    int input = is(e, "input_gain") || is(e, "input_delay");
    return !input ? 0 : strcmp(e->place, "finger") == 0 ? 1 : 2;
}
