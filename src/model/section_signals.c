/* SPDX-License-Identifier: MIT
 * section_signals.c - inputs, outputs, the elements of a stroke, and the simulation's defaults.
 */
#include <math.h>
#include <string.h>

#include "reader.h"
#include "stein/model.h"

/** Elements by the keys of an output; `what` is for messages. */
static const struct element {
    const char *key, *what;
} elements[] = {
    [MECH_A_JOINT] = {"joint", "reading of a joint"},
    [MECH_A_POINT] = {"point", "reading of a point"},
    [MECH_A_CONTACT] = {"contact", "reading of a contact"},
    [MECH_A_NOTCH] = {"notch", "reading of a notch"},
    [MECH_AN_INPUT] = {"input", "reading of an input"},
    [MECH_A_BODY] = {"body", "reading of a body"},
    [MECH_A_LOOP] = {"loop", "reading of a loop or coupling"},
    [MECH_AN_ENERGY] = {"energy", "energy"},
};
_Static_assert(sizeof elements / sizeof *elements == MECH_NO_THING, "every element has a key");

/** Names of all things of one kind, for finding one by name. */
static const char *name_of(const mechanism *m, mech_thing kind, int i)
{
    switch (kind) {
    case MECH_A_JOINT:
    case MECH_A_BODY: return i < m->nbody ? m->bodies[i].name : NULL;
    case MECH_A_POINT: return i < m->npoint ? m->points[i].name : NULL;
    case MECH_A_CONTACT: return i < m->ncontact ? m->contacts[i].name : NULL;
    case MECH_A_NOTCH: return i < m->nnotch ? m->notches[i].name : NULL;
    case MECH_AN_INPUT: return i < m->ninput ? m->inputs[i].name : NULL;
    case MECH_A_LOOP: return i < m->nloop ? m->loops[i].name : NULL;
    case MECH_AN_ENERGY:
    case MECH_NO_THING: break;
    }
    return NULL;
}

const char *mech_target(const mechanism *m, const mech_channel *c)
{
    mech_thing of = c->loop ? MECH_A_LOOP : mech_output_kind_of(c->read)->of;

    return of == MECH_AN_ENERGY ? "" : name_of(m, of, c->index);
}

/** Index of the thing a scalar names, -1 after noting a problem. */
static int find_thing(mech__reader *rd, const mech__node *node, mech_thing kind)
{
    const char *key = elements[kind].key;
    const char *name = mech__text(rd, node, key), *other;

    if (!name) {
        return -1;
    }
    mech__nearest near = {name, NULL, 0};

    for (int i = 0; (other = name_of(rd->m, kind, i)); i++) {
        if (strcmp(other, name) == 0) {
            return kind == MECH_A_JOINT && mech__has_joint(rd, node, i) != 0 ? -1 : i;
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
    in->index = find_thing(rd, mech__get(entry, keys[kind]),
                           kind == STEIN_INPUT_POINT ? MECH_A_POINT : MECH_A_JOINT);
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

static const char *reaction_unit(const mechanism *m, const mech_channel *c)
{
    int couples = c->loop && m->loops[c->index].kind == MECH_COUPLING;
    int turns = couples && m->bodies[m->loops[c->index].index[0]].type == 'R';
    int moment = c->component == STEIN_MOMENT_SIZE ||
                 (c->component >= STEIN_MOMENT_X && c->component <= STEIN_MOMENT_Z);

    return turns || moment ? "N m" : "N";
}

/** A unit of the table, or that of the element itself. */
static const char *channel_unit(const mechanism *m, const mech_channel *c)
{
    const mech_output_kind *kind = mech_output_kind_of(c->read);
    int joint = kind->of == MECH_A_JOINT    ? c->index
                : kind->of == MECH_AN_INPUT ? m->inputs[c->index].index
                                            : -1;

    if (*kind->turning == '\0') {
        return kind->of == MECH_AN_INPUT ? m->inputs[c->index].unit : reaction_unit(m, c);
    }
    return joint >= 0 && m->bodies[joint].type != 'R' ? kind->sliding : kind->turning;
}

/** The kind of output of an element that a word names; -1 after noting a problem. */
static int read_kind(mech__reader *rd, const mech__node *node, mech_thing of)
{
    int kinds[STEIN_READ_KINDS] = {0}, n = 0;
    const char *words = "";

    for (int read = 0; read < STEIN_READ_KINDS && words; read++) {
        const mech_output_kind *kind = mech_output_kind_of(read);

        if (kind->of == of || kind->also == of) {
            words = mech__print(rd, "%s%s%s", words, n > 0 ? " " : "", kind->word);
            kinds[n++] = read;
        }
    }
    int choice = words ? mech__choice(rd, node, elements[of].what, words) : -1;

    return choice < 0 ? -1 : kinds[choice];
}

static int read_energy(mech__reader *rd, mech_channel *c, const mech__node *entry)
{
    int read = read_kind(rd, mech__get(entry, "energy"), MECH_AN_ENERGY);

    mech__keys(rd, entry, "an output of energy", "energy sign zero sensor");
    c->read = read < 0 ? STEIN_READ_KINETIC : read;
    return read < 0 ? -1 : 0;
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
        return find_thing(rd, node, MECH_A_JOINT);
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
    const char *keys[MECH_NO_THING];

    for (int i = 0; i < MECH_NO_THING; i++) {
        keys[i] = elements[i].key;
    }
    int of = only_one(rd, entry, keys, MECH_NO_THING,
                      "an output needs exactly one of joint, "
                      "point, contact, notch, input, body, loop, energy");

    if (of == MECH_AN_ENERGY) {
        return read_energy(rd, c, entry);
    }
    mech__keys(rd, entry, "an output",
               of == MECH_A_JOINT || of == MECH_A_LOOP
                   ? "joint loop read component axes sign zero sensor"
                   : "joint point contact notch input body loop energy read sign zero sensor");
    if (of < 0) {
        return -1;
    }
    const mech__node *read = mech__need(rd, entry, "read", "an output");
    int kind = read ? read_kind(rd, read, (mech_thing)of) : -1;
    int reaction = kind == STEIN_READ_REACTION || of == MECH_A_LOOP;
    const mech__node *element = mech__get(entry, elements[of].key);

    c->index = of == MECH_A_JOINT ? find_joint(rd, element, reaction)
                                  : find_thing(rd, element, (mech_thing)of);
    c->read = reaction ? STEIN_READ_REACTION : kind < 0 ? STEIN_READ_TIME : kind;
    c->loop = of == MECH_A_LOOP;
    if (kind < 0 || c->index < 0) {
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
        return check_plane(rd, element, c->index);
    }
    return of == MECH_AN_INPUT && rd->m->inputs[c->index].index < 0 ? -1 : 0;
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

    rd->m->stroke_string = string ? find_thing(rd, string, MECH_A_CONTACT) : -1;
    rd->m->stroke_notch = notch ? find_thing(rd, notch, MECH_A_NOTCH) : -1;
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
