/* SPDX-License-Identifier: MIT
 * section_bodies.c - bodies, their joints and points, the fixed frame, and the free load's body.
 *
 * Names come first. Before any number is declared, bodies are ordered so that a parent precedes its
 * children (otherwise in the order of the file), and all points get their places. So a joint may
 * sit at a point of a body that stands further down in the file.
 */
#include <stdlib.h>
#include <string.h>

#include "reader.h"

/** The bodies while they are sorted: indices count entries of the file. */
typedef struct family {
    const mech__node *entry[MECH_BODIES];
    int parent[MECH_BODIES]; /* -1 frame */
    int place[MECH_BODIES];  /* in the sorted order, -1 not yet */
    char orphan[MECH_BODIES], part[MECH_BODIES];
    int n, fits; /* fits: there is room for all joints of balls */
} family;

static int find_entry(const family *f, const char *name)
{
    for (int i = 0; i < f->n; i++) {
        if (strcmp(f->entry[i]->key->text, name) == 0) {
            return i;
        }
    }
    return -1;
}

static void find_parent(mech__reader *rd, family *f, int i)
{
    const mech__node *parent = mech__get(f->entry[i], "parent");
    const mech__node *part = mech__get(f->entry[i], "part_of");
    const mech__node *node = part ? part : parent;
    const char *name = node ? mech__text(rd, node, part ? "part_of" : "parent") : NULL;

    if (part && parent) {
        mech__problem_at(rd, part->key, "parent and part_of exclude each other");
    }
    f->parent[i] = -1;
    f->part[i] = (char)(part != NULL);
    if (!name || strcmp(name, "frame") == 0) {
        if (part && name) {
            mech__problem_at(rd, part, "the frame has no parts, expected a body");
        }
        f->part[i] = 0;
        return;
    }
    f->parent[i] = find_entry(f, name);
    if (f->parent[i] < 0) {
        f->orphan[i] = 1;
        mech__nearest near = {name, NULL, 0};

        for (int k = 0; k < f->n; k++) {
            mech__offer(&near, f->entry[k]->key->text);
        }
        mech__offer(&near, "frame");
        mech__problem_at(rd, node, "there is no body \"%s\"%s", mech__shown(rd, name),
                         mech__hint(rd, &near, ", expected frame or a body of this file"));
    }
}

/** Every body that is left hangs on a loop: name each loop once and cut it. */
static void cut_loop(mech__reader *rd, family *f)
{
    int i = 0;

    while (f->place[i] >= 0) {
        i++;
    }
    for (int k = 0; k < f->n; k++) {
        i = f->parent[i];
    }
    const char *text = f->entry[i]->key->text;

    for (int k = f->parent[i]; k != i && text; k = f->parent[k]) {
        text = mech__print(rd, "%s -> %s", text, f->entry[k]->key->text);
    }
    const mech__node *node = mech__get(f->entry[i], f->part[i] ? "part_of" : "parent");
    mech__problem_at(rd, node,
                     "the parents form a loop: %s -> %s, "
                     "expected a tree that begins at the frame",
                     text ? text : "", f->entry[i]->key->text);
    f->parent[i] = -1;
    f->part[i] = 0;
    f->orphan[i] = 1;
}

/** Parents first, otherwise the order of the file. */
static void sort_bodies(mech__reader *rd, family *f)
{
    mechanism *m = rd->m;

    for (int sorted = 0; sorted < f->n;) {
        int i = 0;

        while (i < f->n &&
               (f->place[i] >= 0 || (f->parent[i] >= 0 && f->place[f->parent[i]] < 0))) {
            i++;
        }
        if (i == f->n) {
            cut_loop(rd, f);
            continue;
        }
        int parent = f->parent[i] >= 0 ? f->place[f->parent[i]] : -1;

        sorted++;
        if (f->fits) {
            parent = mech__lead_joints(rd, f->entry[i], parent, f->orphan[i]);
        }
        mech_body *b = &m->bodies[m->nbody];

        mech__name_copy(b->name, sizeof b->name, f->entry[i]->key->text);
        b->parent = parent;
        b->line = f->entry[i]->key->line;
        b->column = f->entry[i]->key->column;
        rd->body_node[m->nbody] = f->entry[i];
        rd->orphan[m->nbody] = f->orphan[i];
        b->part = f->part[i] && !f->orphan[i];
        if (b->part && m->bodies[b->parent].part) {
            mech__problem_at(rd, mech__get(f->entry[i], "part_of"),
                             "%s is a part itself, expected a whole body",
                             m->bodies[b->parent].name);
        }
        f->place[i] = m->nbody++;
    }
}

/** "R y", "T -z", "fixed". */
static int joint_text(const char *s, mech_body *b)
{
    if (strcmp(s, "fixed") == 0) {
        b->type = MECH__FIXED;
        b->axis = 'x';
        b->sign = 1;
        return 1;
    }
    b->type = s[0];
    s += s[0] != '\0';
    if ((b->type != 'R' && b->type != 'T') || *s != ' ') {
        return 0;
    }
    s += strspn(s, " ");
    b->sign = *s == '-' ? -1 : 1;
    s += *s == '-' || *s == '+';
    b->axis = s[0];
    return (s[0] == 'x' || s[0] == 'y' || s[0] == 'z') && s[1] == '\0';
}

static void read_joint(mech__reader *rd, int index)
{
    mech_body *b = &rd->m->bodies[index];
    if (b->type) {
        return; // of a ball
    }
    const mech__node *node = mech__need(rd, rd->body_node[index], "joint", "a body");
    const char *text = node ? mech__text(rd, node, "joint") : NULL;

    if (!text || !joint_text(text, b)) {
        if (text) {
            mech__problem_at(rd, node,
                             "\"%s\" is no joint, expected R or T, a blank and an axis, "
                             "as in \"R y\" or \"T -z\", or fixed, ball, free",
                             mech__shown(rd, text));
        }
        b->type = 'R';
        b->axis = 'y';
        b->sign = 0; // not read: units of its laws are unknown
    }
}

static void name_points(mech__reader *rd, const mech__node *section, int body)
{
    const char *owner = body < 0 ? "frame" : rd->m->bodies[body].name;
    int n = mech__section(rd, section, "a point", MECH__MAX_POINTS);
    const mech__node *entry = n ? section->first : NULL;

    for (; entry; entry = entry->next) {
        if (rd->m->npoint == MECH__MAX_POINTS) {
            mech__problem_at(rd, entry->key, "more than %d points", MECH__MAX_POINTS);
            return;
        }
        mech_point *p = &rd->m->points[rd->m->npoint++];
        char name[MECH_NAME];

        mech__name_copy(name, sizeof name, entry->key->text);
        p->body = body;
        mech__name_copy(p->name, sizeof p->name, owner);
        mech__name_copy(p->name + strlen(p->name), 1 + sizeof name, ".");
        mech__name_copy(p->name + strlen(p->name), sizeof name, name);
    }
}

static void place_points(mech__reader *rd, const mech__node *section, int body)
{
    const mech__node *entry = section && section->kind == MECH__MAP ? section->first : NULL;
    int i = 0;

    while (i < rd->m->npoint && rd->m->points[i].body != body) {
        i++;
    }
    for (; entry && i < rd->m->npoint && rd->m->points[i].body == body; i++) {
        mech__place(rd, body, rd->m->points[i].at, MECH__VANISHES, entry, rd->m->points[i].name);
        entry = entry->next;
    }
}

int mech__body_ref(mech__reader *rd, const mech__node *node, int frame_allowed, int *body)
{
    const char *name = mech__text(rd, node, "a body");

    if (!name) {
        return -1;
    }
    mech__nearest near = {name, NULL, 0};

    if (frame_allowed && strcmp(name, "frame") == 0) {
        *body = -1;
        return 0;
    }
    for (int i = 0; i < rd->m->nbody; i++) {
        if (strcmp(rd->m->bodies[i].name, name) == 0) {
            *body = i;
            return 0;
        }
        mech__offer(&near, rd->m->bodies[i].name);
    }
    if (frame_allowed) {
        mech__offer(&near, "frame");
    }
    mech__problem_at(rd, node, "there is no body \"%s\"%s", mech__shown(rd, name),
                     mech__hint(rd, &near, ""));
    return -1;
}

int mech__point_ref(mech__reader *rd, const mech__node *node, int *point)
{
    const char *name = mech__text(rd, node, "a point");

    if (!name) {
        return -1;
    }
    mech__nearest near = {name, NULL, 0};

    for (int i = 0; i < rd->m->npoint; i++) {
        if (strcmp(rd->m->points[i].name, name) == 0) {
            *point = i;
            return 0;
        }
        mech__offer(&near, rd->m->points[i].name);
    }
    mech__problem_at(rd, node, "there is no point \"%s\"%s", mech__shown(rd, name),
                     mech__hint(rd, &near, ", expected a name like body.point or frame.point"));
    return -1;
}

int mech__has_joint(mech__reader *rd, const mech__node *node, int body)
{
    const mech_body *b = &rd->m->bodies[body];

    if (b->type != MECH__FIXED && !b->ball) {
        return 0;
    }
    mech__problem_at(rd, node, "%s %s, expected a body with a joint%s", b->name,
                     b->ball ? "turns in all directions" : "is fixed",
                     b->ball ? " about or along one axis" : "");
    return -1;
}

int mech__joint_ref(mech__reader *rd, const mech__node *node, int *body)
{
    return mech__body_ref(rd, node, 0, body) || mech__has_joint(rd, node, *body) ? -1 : 0;
}

/** Joint origin: three numbers or a point of the parent. */
static void read_at(mech__reader *rd, mech_body *b, const char *name, const mech__node *node)
{
    int point;

    if (!node || node->kind != MECH__SCALAR) {
        char base[MECH_PATH];

        mech__name_copy(base, sizeof base, name);
        mech__name_copy(base + strlen(base), sizeof base - strlen(base), ".at");
        mech__place(rd, b->parent, b->at, MECH__VANISHES, node, base);
        return;
    }
    if (mech__point_ref(rd, node, &point) != 0) {
        return;
    }
    const mech_point *p = &rd->m->points[point];

    if (p->body != b->parent && !rd->orphan[b - rd->m->bodies]) {
        mech__problem_at(rd, node, "the point %s is not on the parent, expected a point of %s",
                         p->name, b->parent < 0 ? "frame" : rd->m->bodies[b->parent].name);
        return;
    }
    for (int i = 0; i < 3; i++) {
        mech__repeat(rd, &b->at[i], &p->at[i]);
    }
}

/** I_yy from the swing of the body on its joint, as makers measure it, by its frequency or period:
 *  I_o = m g d / (2 pi nu)^2 = m g d (T / 2 pi)^2 about the joint, I_yy = I_o - m d^2, d from the
 *  joint to the centre.
 */
static void read_pendulum(mech__reader *rd, mech_body *b, const mech__node *node)
{
    mech_scalar *unused = mech__alloc(rd, 2 * sizeof *unused);
    const mech__node *g = mech__get(node, "gravity"), *period = mech__get(node, "period");
    const char *n = b->name;

    if (!unused || !mech__keys(rd, node, "pendulum", "frequency period gravity")) {
        return;
    }
    if (period && mech__get(node, "frequency")) {
        mech__problem_at(rd, period->key, "frequency and period exclude each other");
        return;
    }
    if (b->type != 'R' || b->axis != 'y') {
        mech__problem_at(rd, node->key, "a pendulum test needs a joint about y, expected inertia");
        return;
    }
    if (period) {
        mech__number(rd, &unused[0], "s", MECH__POSITIVE, period, 1.0, "%s.pendulum.period", n);
    } else {
        mech__number(rd, &unused[0], "Hz", MECH__POSITIVE,
                     mech__need(rd, node, "frequency", "pendulum"), 1.0, "%s.pendulum.frequency",
                     n);
    }
    if (g) {
        mech__number(rd, &unused[1], "m/s^2", MECH__POSITIVE, g, 9.81, "%s.pendulum.gravity", n);
    }
    mech__slot *yy =
        mech__number(rd, &b->inertia[1], "kg m^2", MECH__VANISHES, NULL, 0.0, "%s.inertia.yy", n);
    const char *gravity = g ? mech__print(rd, "%s.pendulum.gravity", n) : "9.81 m/s^2";
    const char *d2 =
        mech__print(rd, "(%s.centre.x * %s.centre.x + %s.centre.z * %s.centre.z)", n, n, n, n);
    const char *of = mech__print(rd, period ? "%s.pendulum.period" : "%s.pendulum.frequency", n);

    if (yy && gravity && d2 && of) {
        yy->node = node;
        yy->label = period ? "m g d (T / 2 pi)^2 - m d^2" : "m g d / (2 pi nu)^2 - m d^2";
        yy->text =
            mech__print(rd,
                        period ? "%s.mass * (%s * sqrt%s * %s * %s / 39.478417604357434 - %s)"
                               : "%s.mass * (%s * sqrt%s / (39.478417604357434 * %s * %s) - "
                                 "%s)",
                        n, gravity, d2, of, of, d2);
    }
}

static void read_inertia(mech__reader *rd, mech_body *b, const mech__node *entry)
{
    static const char *const names[] = {"xx", "yy", "zz", "xy", "xz", "yz"};
    const mech__node *inertia = mech__get(entry, "inertia");
    const mech__node *pendulum = mech__get(entry, "pendulum");

    if (inertia && pendulum) {
        mech__problem_at(rd, pendulum->key, "inertia and pendulum exclude each other");
        pendulum = NULL;
    }
    mech__keys(rd, inertia, "inertia", "xx yy zz xy xz yz");
    for (int i = 0; i < 6; i++) {
        if (i != 1 || !pendulum) {
            mech__number(rd, &b->inertia[i], "kg m^2", MECH__VANISHES, mech__get(inertia, names[i]),
                         0.0, "%s.inertia.%s", b->name, names[i]);
        }
    }
    if (pendulum) {
        read_pendulum(rd, b, pendulum);
    }
}

/** Laws of its joint, and their start positions. */
static void read_joint_numbers(mech__reader *rd, mech_body *b, const mech__node *entry)
{
    const mech__node *initial = mech__get(entry, "initial");
    const mech__node *guess = mech__get(initial, "guess");
    int turns = b->type == 'R';

    mech__joint_law(rd, b, entry);
    mech__limits(rd, b, mech__get(entry, "limits"));
    mech__keys(rd, initial, "initial", "position guess speed");
    if (guess && mech__get(initial, "position")) {
        mech__problem_at(rd, guess->key, "position and guess exclude each other");
    }
    mech__number(rd, &b->armature, turns ? "kg m^2" : "kg", MECH__VANISHES | MECH__NOT_NEGATIVE,
                 mech__get(entry, "armature"), 0.0, "%s.armature", b->name);
    mech__number(rd, &b->q0, turns ? "rad" : "m", 0, guess ? guess : mech__get(initial, "position"),
                 0.0, guess ? "%s.initial.guess" : "%s.initial.position", b->name);
    mech__number(rd, &b->qd0, turns ? "rad/s" : "m/s", 0, mech__get(initial, "speed"), 0.0,
                 "%s.initial.speed", b->name);
}

static void read_body(mech__reader *rd, int index)
{
    mech_body *b = &rd->m->bodies[index];
    const mech__node *entry = rd->body_node[index];
    int fixed = b->type == MECH__FIXED;
    char *base = mech__print(rd, "%s.centre", b->name);

    mech__keys(rd, entry,
               fixed     ? "a fixed body"
               : b->free ? "a free body"
               : b->ball ? "a body on a ball"
                         : "a body",
               fixed ? "parent joint at mass centre inertia points"
               : b->ball
                   ? "parent joint at mass centre inertia initial points"
                   : "parent part_of joint at mass centre inertia pendulum spring damping "
                     "friction drag preload coulomb backlash asymmetry initial points mimic limits "
                     "armature motor");
    if (!base) {
        return;
    }
    mech__number(rd, &b->mass, "kg", MECH__VANISHES | MECH__NOT_NEGATIVE, mech__get(entry, "mass"),
                 0.0, "%s.mass", b->name);
    mech__place(rd, index, b->centre, MECH__VANISHES, mech__get(entry, "centre"), base);
    read_inertia(rd, b, entry);
    read_at(rd, mech__first_joint(b), b->name, mech__get(entry, "at"));
    if (b->ball) {
        mech__ball_initial(rd, b, mech__get(entry, "initial"));
    } else if (!fixed && b->sign != 0) {
        read_joint_numbers(rd, b, entry);
    }
    place_points(rd, mech__get(entry, "points"), index);
}

/** The free load is a separate body that slides along z; its contact comes with the contacts.
 *  Records state its mass, so that an error of what is stated is a number of its own. */
static void add_load(mech__reader *rd, const mech__node *load)
{
    mech_body *b = &rd->m->bodies[rd->m->nbody];

    mech__name_copy(b->name, sizeof b->name, "load");
    b->parent = -1;
    b->type = 'T';
    b->axis = 'z';
    b->sign = 1;
    b->line = load->key->line;
    b->column = load->key->column;
    rd->body_node[rd->m->nbody] = load;
    rd->m->load_body = rd->m->nbody++;
    mech_scalar *stated = mech__alloc(rd, 2 * sizeof *stated);
    mech__slot *mass = mech__number(rd, &b->mass, "kg", MECH__VANISHES | MECH__NOT_NEGATIVE, NULL,
                                    0.0, "load.true_mass");
    if (stated != NULL && mass != NULL) {
        mech__number(rd, &stated[0], "kg", MECH__VANISHES | MECH__NOT_NEGATIVE,
                     mech__need(rd, load, "mass", "the load"), 0.0, "load.mass");
        mech__number(rd, &stated[1], "1", 0, mech__get(load, "error"), 0.0, "load.error");
        mass->node = load;
        mass->label = "mass (1 + error)";
        mass->text = "load.mass * (1 + load.error)";
    }
    mech__number(rd, &b->q0, "m", 0, NULL, 0.0, "load.initial.position");
    mech__number(rd, &b->qd0, "m/s", 0, NULL, 0.0, "load.initial.speed");
}

static void read_gravity(mech__reader *rd)
{
    const mech__node *node = mech__get(rd->root, "gravity");

    if (node) {
        mech__vector(rd, rd->m->gravity, "m/s^2", MECH__VANISHES, node, "gravity");
        return;
    }
    for (int i = 0; i < 3; i++) {
        mech__number(rd, &rd->m->gravity[i], "m/s^2", MECH__VANISHES, NULL, i == 2 ? -9.81 : 0.0,
                     "gravity.%c", "xyz"[i]);
    }
}

/** Entries of the section, with parents found. */
static void list_bodies(mech__reader *rd, family *f, const mech__node *section, int max)
{
    int n = mech__section(rd, section, "a body", max);
    const mech__node *entry = n ? section->first : NULL;

    for (; entry; entry = entry->next) {
        const char *name = entry->key->text;

        if (strcmp(name, "frame") == 0 || (strcmp(name, "load") == 0 && max < MECH_BODIES)) {
            mech__problem_at(rd, entry->key, "no body can be called \"%s\": it is the name of %s",
                             name, name[0] == 'f' ? "the fixed frame" : "the free load");
            continue;
        }
        f->place[f->n] = -1;
        f->entry[f->n++] = entry;
    }
    for (int i = 0; i < f->n; i++) {
        find_parent(rd, f, i);
    }
}

static int have_room(mech__reader *rd, const family *f, int max)
{
    int n = 0;

    for (int i = 0; i < f->n; i++) {
        n += mech__joints_of(f->entry[i]);
    }
    if (n > max) {
        mech__problem_at(rd, f->entry[0], "more than %d joints of one axis: a free body has 7",
                         max);
    }
    return n <= max;
}

void mech__section_bodies(mech__reader *rd)
{
    mechanism *m = rd->m;
    family *f = mech__alloc(rd, sizeof *f);
    const mech__node *load = mech__get(rd->root, "load");
    const mech__node *section = mech__need(rd, rd->root, "bodies", "the mechanism");
    const mech__node *frame = mech__get(rd->root, "points");

    m->bodies = mech__array(rd, MECH_BODIES, sizeof *m->bodies);
    m->points = mech__array(rd, MECH__MAX_POINTS, sizeof *m->points);
    if (rd->nomem) {
        return;
    }
    list_bodies(rd, f, section, load ? MECH_BODIES - 1 : MECH_BODIES);
    f->fits = have_room(rd, f, load ? MECH_BODIES - 1 : MECH_BODIES);
    sort_bodies(rd, f);
    for (int i = 0; i < m->nbody; i++) {
        read_joint(rd, i);
        if (m->bodies[i].part && m->bodies[m->bodies[i].parent].type == MECH__FIXED) {
            mech__problem_at(rd, mech__get(rd->body_node[i], "part_of"),
                             "%s is fixed, it has no parts", m->bodies[m->bodies[i].parent].name);
            m->bodies[i].part = 0;
        }
        if (!m->bodies[i].lead) {
            name_points(rd, mech__get(rd->body_node[i], "points"), i);
        }
    }
    name_points(rd, frame, -1);
    read_gravity(rd);
    for (int i = 0; i < m->nbody && !rd->nomem; i++) {
        if (!m->bodies[i].lead) {
            read_body(rd, i);
        }
    }
    place_points(rd, frame, -1);
    if (load) {
        add_load(rd, load);
    }
}
