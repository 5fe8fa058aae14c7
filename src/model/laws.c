/* SPDX-License-Identifier: MIT
 * laws.c - the numbers of laws: laws of joints, contacts, sensors and inputs.
 *
 * One table a law, in the order of the blocks of stein/model.h. Every entry becomes a parameter;
 * one that the file leaves out gets its neutral value, with which it does nothing. So a new term of
 * a law needs no new equations; docs/architecture.md lists the places that it needs.
 */
#include <string.h>

#include "reader.h"

/** One number of a law: `section` NULL stands beside the law's owner itself. Where two spellings
 * are given, the second is for a sliding joint. */
typedef struct law_entry {
    const char *section, *key[2], *unit[2];
    unsigned flags;
    double neutral;
    int needed; /* once its section is there, if it is used */
} law_entry;

/** Flags of numbers of friction, beside those of a slot. A place that sticks (`stick: yes`) has the
 * law of stein_stick_limit. A number without a flag is refused there. */
enum {
    STUCK = 1024, /* that law uses it, too */
    IDLE = 2048   /* it does not, but a file may state it, so that `stick` alone changes the law */
};

#define SAME(text) \
    {              \
        text, text \
    }

static const law_entry joint_law[STEIN_JOINT_SIZE] = {
    [STEIN_JOINT_K] = {"spring", SAME("k"), {"N m/rad", "N/m"}, 0, 0.0, 1},
    [STEIN_JOINT_Q0] = {"spring", {"theta0", "x0"}, {"rad", "m"}, 0, 0.0, 0},
    [STEIN_JOINT_K3] = {"spring", SAME("k3"), {"N m/rad^3", "N/m^3"}, 0, 0.0, 0},
    [STEIN_JOINT_B] = {NULL, SAME("damping"), {"N m s/rad", "N s/m"}, MECH__NOT_NEGATIVE, 0.0, 0},
    [STEIN_JOINT_ASYMMETRY] = {NULL, SAME("asymmetry"), SAME("1"), 0, 0.0, 0},
    [STEIN_JOINT_DRAG] =
        {NULL, SAME("drag"), {"N m s^2/rad^2", "N s^2/m^2"}, MECH__NOT_NEGATIVE, 0.0, 0},
    [STEIN_JOINT_PRELOAD] = {NULL, SAME("preload"), {"N m", "N"}, 0, 0.0, 0},
    [STEIN_JOINT_DRY] = {"coulomb", SAME("T"), {"N m", "N"}, MECH__NOT_NEGATIVE, 0.0, 1},
    [STEIN_JOINT_DRY_SPEED] = {"coulomb", SAME("w"), {"rad/s", "m/s"}, MECH__POSITIVE, 0.05, 1},
    [STEIN_JOINT_DRY_ASYMMETRY] = {"coulomb", SAME("asymmetry"), SAME("1"), 0, 0.0, 0},
    [STEIN_JOINT_STOP_K] = {"backlash", SAME("k"), {"N m/rad", "N/m"}, MECH__NOT_NEGATIVE, 0.0, 1},
    [STEIN_JOINT_STOP_GAP] = {"backlash", SAME("gap"), {"rad", "m"}, MECH__NOT_NEGATIVE, 0.0, 1},
    [STEIN_JOINT_FRICTION + STEIN_FRICTION_A] =
        {"friction", SAME("A"), {"N m", "N"}, MECH__NOT_NEGATIVE | STUCK, 0.0, 1},
    [STEIN_JOINT_FRICTION + STEIN_FRICTION_VT] =
        {"friction", SAME("vt"), {"rad/s", "m/s"}, MECH__POSITIVE | IDLE, 0.05, 1},
    [STEIN_JOINT_FRICTION + STEIN_FRICTION_B1] = {"friction", SAME("B1"), SAME("1"),
                                                  MECH__NOT_NEGATIVE | STUCK, 0.0, 0},
    [STEIN_JOINT_FRICTION + STEIN_FRICTION_B2] = {"friction", SAME("B2"), SAME("1"),
                                                  MECH__NOT_NEGATIVE | STUCK, 1.0, 0},
};

static const law_entry link_law[STEIN_LINK_SIZE] = {
    [STEIN_LINK_K] = {NULL, SAME("k"), SAME("N/m"), 0, 0.0, 0},
    [STEIN_LINK_LENGTH] = {NULL, SAME("length"), SAME("m"), MECH__NOT_NEGATIVE, 0.0, 0},
    [STEIN_LINK_B] = {NULL, SAME("damping"), SAME("N s/m"), MECH__NOT_NEGATIVE, 0.0, 0},
    [STEIN_LINK_SLACK] = {NULL, SAME("slack"), SAME("1"), MECH__NOT_NEGATIVE, 0.0, 0},
    [STEIN_LINK_OFF] = {"let_off", SAME("share"), SAME("1"), MECH__NOT_NEGATIVE, 0.0, 1},
    [STEIN_LINK_OFF_Z] = {"let_off", SAME("z"), SAME("m"), 0, 0.0, 1},
    [STEIN_LINK_OFF_RANGE] = {"let_off", SAME("range"), SAME("m"), MECH__POSITIVE, 1e-4, 0},
};

static const law_entry normal_law[STEIN_NORMAL_SIZE] = {
    [STEIN_NORMAL_A] = {"normal", SAME("a"), SAME("N/m^3"), 0, 0.0, 0},
    [STEIN_NORMAL_B] = {"normal", SAME("b"), SAME("N/m^2"), 0, 0.0, 0},
    [STEIN_NORMAL_C] = {"normal", SAME("c"), SAME("N/m"), 0, 0.0, 0},
    [STEIN_NORMAL_D] = {"normal", SAME("D"), SAME("s/m"), 0, 0.0, 0},
    [STEIN_NORMAL_EXPONENT] = {"normal", SAME("p"), SAME("1"), 0, 0.0, 0},
    [STEIN_NORMAL_HYSTERESIS] = {"normal", SAME("h"), SAME("1"), 0, 0.0, 0},
    [STEIN_NORMAL_PRELOAD] = {"normal", SAME("F0"), SAME("N"), MECH__NOT_NEGATIVE, 0.0, 0},
    [STEIN_NORMAL_GAP] = {NULL, SAME("gap"), SAME("m"), 0, 0.0, 0},
    [STEIN_NORMAL_ADHESION] = {"adhesion", SAME("F"), SAME("N"), MECH__NOT_NEGATIVE, 0.0, 1},
    [STEIN_NORMAL_RANGE] = {"adhesion", SAME("range"), SAME("m"), MECH__NOT_NEGATIVE, 0.0, 1},
};

static const law_entry friction_law[STEIN_FRICTION_SIZE] = {
    [STEIN_FRICTION_A] = {"friction", SAME("A"), SAME("1"), MECH__NOT_NEGATIVE | STUCK, 0.0, 1},
    [STEIN_FRICTION_VT] = {"friction", SAME("vt"), SAME("m/s"), MECH__POSITIVE | IDLE, 0.01, 1},
    [STEIN_FRICTION_B1] = {"friction", SAME("B1"), SAME("1"), MECH__NOT_NEGATIVE | STUCK, 0.0, 0},
    [STEIN_FRICTION_B2] = {"friction", SAME("B2"), SAME("1"), MECH__NOT_NEGATIVE | STUCK, 1.0, 0},
};

static const law_entry signal_law[STEIN_SIGNAL_SIZE] = {
    [STEIN_SIGNAL_GAIN] = {NULL, SAME("gain"), SAME("1"), 0, 1.0, 0},
    [STEIN_SIGNAL_DELAY] = {NULL, SAME("delay"), SAME("s"), 0, 0.0, 0},
};

/* units of offset and square follow the channel: mech__sensor fills them in */
static const law_entry sensor_law[STEIN_SENSOR_SIZE] = {
    [STEIN_SENSOR_GAIN] = {"sensor", SAME("gain"), SAME("1"), 0, 1.0, 0}, // -1: mirrored
    [STEIN_SENSOR_OFFSET] = {"sensor", SAME("offset"), SAME(NULL), 0, 0.0, 0},
    [STEIN_SENSOR_SQUARE] = {"sensor", SAME("square"), SAME(NULL), 0, 0.0, 0},
    [STEIN_SENSOR_TILT] = {"sensor", SAME("tilt"), SAME("rad"), 0, 0.0, 0},
    [STEIN_SENSOR_DELAY] = {"sensor", SAME("delay"), SAME("s"), 0, 0.0, 0},
};

/** A law's owner in words: "the spring of a turning joint". `of` NULL: the section alone. */
static const char *title(mech__reader *rd, const char *section, const char *of)
{
    const char *words = of ? mech__print(rd, "the %s of %s", section, of) : NULL;

    return words ? words : section;
}

static const mech__node *stick_of(const mech__node *owner)
{
    return mech__get(mech__get(owner, "friction"), "stick");
}

static int is_of_friction(const law_entry *e)
{
    return e->section && strcmp(e->section, "friction") == 0;
}

static int is_yes(const mech__node *node)
{
    return node && node->kind == MECH__SCALAR &&
           (strcmp(node->text, "yes") == 0 || strcmp(node->text, "true") == 0);
}

/** @return does the friction of a joint or a contact stick? */
static int read_stick(mech__reader *rd, const mech__node *owner)
{
    const mech__node *stick = stick_of(owner);

    if (stick) {
        mech__choice(rd, stick, "answer", "no yes false true");
    }
    return is_yes(stick);
}

/** Check the keys of the sections of a law, each once: "spring" may hold k theta0 k3. */
static void check_sections(mech__reader *rd, const law_entry *law, int n, int slides,
                           const mech__node *owner, const char *of)
{
    for (int i = 0; i < n; i++) {
        const char *section = law[i].section;
        int first = 1;
        char words[MECH_PATH] = "";

        for (int k = 0; section && k < n; k++) {
            if (law[k].section && strcmp(law[k].section, section) == 0) {
                first = first && k >= i;
                strcat(strcat(words, *words ? " " : ""), law[k].key[slides]);
            }
        }
        if (is_of_friction(&law[i])) {
            strcat(words, " stick");
        }
        if (section && first && mech__get(owner, section)) {
            const char *kept = mech__print(rd, "%s", words);
            mech__keys(rd, mech__get(owner, section), title(rd, section, of), kept ? kept : words);
        }
    }
}

/** @param slides  1: the second spelling of keys and units
 *  @param of      owner of the law, for messages; NULL: the section's name is enough */
static void read_law(mech__reader *rd, mech_scalar *to, const law_entry *law, int n, int slides,
                     const char *of, const mech__node *owner, const char *name)
{
    int sticks = is_yes(stick_of(owner));

    check_sections(rd, law, n, slides, owner, of);
    for (int i = 0; i < n; i++) {
        const law_entry *e = &law[i];
        const char *key = e->key[slides], *unit = e->unit[slides];
        const mech__node *map = e->section ? mech__get(owner, e->section) : owner;
        int unused = sticks && is_of_friction(e) && !(e->flags & STUCK);
        int needed = e->needed && !unused;
        unsigned flags =
            (e->flags & ~(unsigned)(STUCK | IDLE)) | (unused ? (unsigned)MECH__UNUSED : 0U);
        const mech__node *node = map && e->section && needed && map->kind == MECH__MAP
                                     ? mech__need(rd, map, key, title(rd, e->section, of))
                                     : mech__get(map, key);
        if (node && unused && !(e->flags & IDLE)) {
            mech__problem_at(rd, node->key,
                             "%s.%s.%s does not act where friction sticks, expected no %s, or no "
                             "stick: yes",
                             name, e->section, key, key);
        }
        if (e->section) {
            mech__number(rd, &to[i], unit, flags, node, e->neutral, "%s.%s.%s", name, e->section,
                         key);
        } else {
            mech__number(rd, &to[i], unit, flags, node, e->neutral, "%s.%s", name, key);
        }
    }
}

void mech__joint_law(mech__reader *rd, mech_body *b, const mech__node *entry)
{
    int slides = b->type == 'T';
    const mech__node *motor = mech__get(entry, "motor");
    mech_scalar *law = motor ? mech__alloc(rd, STEIN_JOINT_SIZE * sizeof *law) : b->joint;

    if (!law) {
        return;
    }
    read_law(rd, law, joint_law, STEIN_JOINT_SIZE, slides,
             slides ? "a sliding joint" : "a turning joint", entry, b->name);
    b->sticks = read_stick(rd, entry);
    if (motor) {
        mech__motor(rd, b, motor, law);
    }
}

/** A stop for whose stiffness the file has no number: the body alone, with its armature, swings on
 * it with 100 Hz. */
static const char *usual_stiffness(mech__reader *rd, const mech_body *b)
{
    int geared = mech__get(rd->body_node[b - rd->m->bodies], "armature") != NULL;
    const char *rotor = geared ? mech__print(rd, " + %s.armature", b->name) : "";
    static const char *const across[3][2] = {{"y", "z"}, {"x", "z"}, {"x", "y"}};
    const char *n = b->name, *const *c = across[b->axis - 'x'];
    const char axis[3] = {b->axis, b->axis, '\0'};

    return b->type == 'T'
               ? mech__print(rd,
                             geared ? "394784.17604357434 Hz^2 * (%s.mass%s)"
                                    : "394784.17604357434 Hz^2 * %s.mass%s",
                             n, rotor ? rotor : "")
               : mech__print(rd,
                             "394784.17604357434 Hz^2 * (%s.inertia.%s + %s.mass * (%s.centre.%s * "
                             "%s.centre.%s + %s.centre.%s * %s.centre.%s)%s)",
                             n, axis, n, n, c[0], n, c[0], n, c[1], n, c[1], rotor ? rotor : "");
}

void mech__limits(mech__reader *rd, mech_body *b, const mech__node *node)
{
    int slides = b->type == 'T', map = node && node->kind == MECH__MAP;
    const mech__node *range = map ? mech__need(rd, node, "range", "limits") : node;
    const char *position = slides ? "m" : "rad";

    if (!node || !range || (map && !mech__keys(rd, node, "limits", "range k D"))) {
        return;
    }
    if (range->kind != MECH__LIST || range->count != 2) {
        mech__problem_at(rd, range, "limits must be two positions, as in limits: [-1 %s, 1 %s]",
                         position, position);
        return;
    }
    b->limited = 1;
    mech__number(rd, &b->limit[STEIN_LIMIT_FROM], position, 0, range->first, 0.0, "%s.limits.from",
                 b->name);
    mech__number(rd, &b->limit[STEIN_LIMIT_TO], position, 0, range->first->next, 0.0,
                 "%s.limits.to", b->name);
    mech__slot *k =
        mech__number(rd, &b->limit[STEIN_LIMIT_K], slides ? "N/m" : "N m/rad", MECH__POSITIVE,
                     map ? mech__get(node, "k") : NULL, 0.0, "%s.limits.k", b->name);
    mech__number(rd, &b->limit[STEIN_LIMIT_D], slides ? "s/m" : "s/rad", MECH__NOT_NEGATIVE,
                 map ? mech__get(node, "D") : NULL, 0.0, "%s.limits.D", b->name);
    if (k && !k->text) {
        k->node = node;
        k->label = "100 Hz with the body alone";
        k->text = usual_stiffness(rd, b);
    }
}

void mech__link_law(mech__reader *rd, mech_link *l, const mech__node *entry)
{
    mech__need(rd, entry, "k", "a link");
    mech__need(rd, entry, "length", "a link");
    read_law(rd, l->law, link_law, STEIN_LINK_SIZE, 0, "a link", entry, l->name);
}

void mech__contact_law(mech__reader *rd, mech_normal *normal, mech_friction *friction,
                       const mech__node *entry, const char *what, const char *name)
{
    const mech__node *node = mech__need(rd, entry, "normal", what);

    if (node && node->kind == MECH__MAP && !mech__get(node, "a") && !mech__get(node, "b") &&
        !mech__get(node, "c") && !mech__get(node, "F0")) {
        mech__problem_at(rd, node->key, "normal needs at least one of a, b and c");
    }
    read_law(rd, normal->v, normal_law, STEIN_NORMAL_SIZE, 0, NULL, entry, name);
    read_law(rd, friction->v, friction_law, STEIN_FRICTION_SIZE, 0, NULL, entry, name);
}

int mech__contact_sticks(mech__reader *rd, const mech__node *entry, const char *what)
{
    if (what && stick_of(entry)) {
        mech__problem_at(rd, stick_of(entry),
                         "the friction of %s cannot stick, expected friction of a joint or of a "
                         "contact in contacts",
                         what);
        return 0;
    }
    return read_stick(rd, entry);
}

void mech__input_law(mech__reader *rd, mech_input *in, const mech__node *entry)
{
    read_law(rd, in->signal, signal_law, STEIN_SIGNAL_SIZE, 0, NULL, entry, in->name);
}

void mech__sensor_law(mech__reader *rd, mech_channel *c, const mech__node *entry)
{
    law_entry law[STEIN_SENSOR_SIZE];
    char inverse[MECH_UNIT];
    mech_dim dim = {.kg = 0};

    mech_parse_unit(c->unit, &dim, NULL);
    dim = (mech_dim){(signed char)-dim.kg, (signed char)-dim.m, (signed char)-dim.s,
                     (signed char)-dim.rad, (signed char)-dim.A};
    mech__unit_text(dim, inverse);
    memcpy(law, sensor_law, sizeof law);
    const char *square = mech__print(rd, "%s", inverse);
    for (int k = 0; k < 2; k++) {
        law[STEIN_SENSOR_OFFSET].unit[k] = c->unit;
        law[STEIN_SENSOR_SQUARE].unit[k] = square ? square : "1";
    }
    read_law(rd, c->sensor, law, STEIN_SENSOR_SIZE, 0, NULL, entry, c->name);
}
