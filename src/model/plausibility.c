/* SPDX-License-Identifier: MIT
 * plausibility.c - numbers that are possible but implausible: warnings with line and column.
 *
 * A number without a unit is SI. In a file that otherwise uses g and mm such a number probably
 * lacks its unit if it is far above all others of its kind: "mass: 82" among masses of some grams.
 * And a body of a mass and a size has an inertia of at most about m L^2, which is less than m c^2
 * of a joint at the distance c from its centre: an inertia about that joint is above.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "reader.h"
#include "stein/model.h"

static const double far_above = 100.0; /* against the largest of its kind that has a unit */
/* kg in a cube of the largest length [kg/m^3]; osmium: 2.3e4 */
static const double most_dense = 3e4;
static const double most_inertia = 1000.0;  /* in m L^2 */
static const double farther = 1.2;          /* points of a body, over its centre: no point mass */
static const double most_about_joint = 2.0; /* in m c^2; a rod on its end has 4/3 */

/** How a number is written. */
typedef struct written {
    double value; /* [SI] */
    int has_unit;
    int scaled; /* in a unit that is not SI: mm, g */
    const char *unit;
} written;

/* @return 0: absent, a formula, or replaced from outside */
static int read_written(const mech__slot *slot, written *w)
{
    const char *text = slot->text, *bad;
    char why[MECH__WHY];
    mech__quantity q;

    if (!text || slot->set || slot->label || slot->state != MECH__DONE) {
        return 0;
    }
    while (*text == ' ' || *text == '-' || *text == '+') {
        text++;
    }
    int n = mech__quantity_at(text, &q, why, &bad);

    if (n < 0 || q.percent || (text[n] != '\0' && strstr(text + n, "+-") == NULL)) {
        return 0;
    }
    char *unit;
    double number = strtod(text, &unit);

    while (*unit == ' ') {
        unit++;
    }
    *w = (written){q.value, q.has_unit, q.has_unit && fabs(q.value - number) > 1e-9 * fabs(number),
                   unit};
    return 1;
}

/* masses and lengths: stiffnesses and inertias of one mechanism differ by any factor */
static const mech_dim kilogram = {.kg = 1}, metre = {.m = 1};

/** Units in use in a file. */
typedef struct habits {
    int scaled;    /* any number in a unit that is not SI */
    double length; /* largest of all [m] */
} habits;

static habits find_habits(const mech__reader *rd)
{
    habits h = {0, 0.0};
    written w;

    for (const mech__slot *s = rd->slots; s; s = s->next) {
        if (read_written(s, &w) && s->unit) {
            h.scaled |= w.scaled;
            if (mech__dim_same(s->dim, metre) && w.has_unit) {
                h.length = fmax(h.length, w.value);
            }
        }
    }
    return h;
}

/* the largest number with a unit of the same kind; its unit as written, [MECH_UNIT] */
static double largest_like(const mech__reader *rd, const mech__slot *slot, char *unit)
{
    double largest = 0.0;
    written w;

    for (const mech__slot *s = rd->slots; s; s = s->next) {
        if (s->unit && mech__dim_same(s->dim, slot->dim) && read_written(s, &w) && w.has_unit &&
            w.value > largest) {
            size_t n = strcspn(w.unit, "+ ");

            largest = w.value;
            n = n < MECH_UNIT ? n : MECH_UNIT - 1;
            memcpy(unit, w.unit, n);
            unit[n] = '\0';
        }
    }
    return largest;
}

static void doubt_unit(mech__reader *rd, const mech__slot *slot, const habits *h)
{
    int is_mass = mech__dim_same(slot->dim, kilogram);
    char unit[MECH_UNIT] = "";
    written w;

    if (!slot->unit || (!is_mass && !mech__dim_same(slot->dim, metre)) || !read_written(slot, &w) ||
        w.has_unit) {
        return;
    }
    double like = largest_like(rd, slot, unit);
    double room = h->length * h->length * h->length;

    if (like > 0.0 && w.value > far_above * like) {
        mech__problem_at(rd, slot->node,
                         "warning: %s = \"%s\" has no unit, so it is in %s: %.3g times the largest "
                         "number of its kind in the file; is it in %s?",
                         slot->path, mech__shown(rd, slot->text), slot->unit, w.value / like, unit);
    } else if (like == 0.0 && is_mass && room > 0.0 && w.value > most_dense * room) {
        mech__problem_at(
            rd, slot->node,
            "warning: %s = \"%s\" has no unit, so it is in kg, while the largest length "
            "of the file is %.3g m; is it in g?",
            slot->path, mech__shown(rd, slot->text), h->length);
    }
}

/* the larger one of a distance and that of `at` from `from` */
static double reach(double size, const mech_scalar at[3], const double from[3])
{
    double square = 0.0;

    for (int i = 0; i < 3; i++) {
        square += (at[i].value - from[i]) * (at[i].value - from[i]);
    }
    return fmax(size, sqrt(square));
}

/* the largest distance of anything of a body from a place of it [m] */
static double size_about(const mechanism *m, int body, const double from[3])
{
    static const double joint[3] = {0.0};
    double size = reach(0.0, m->bodies[body].centre, from);

    for (int i = 0; i < m->nbody; i++) {
        size = m->bodies[i].parent == body ? reach(size, m->bodies[i].at, from) : size;
    }
    for (int i = 0; i < m->npoint; i++) {
        size = m->points[i].body == body ? reach(size, m->points[i].at, from) : size;
    }
    for (int i = 0; i < 4 * m->ncontact; i++) {
        const mech_contact *c = &m->contacts[i / 4];
        const mech_shape *s = &c->spot[i / 2 % 2].side[i % 2];

        if (i / 2 % 2 < c->nspot && s->body == body) {
            size = s->corner ? reach(size, s->size, joint) : size;
            size = fmax(reach(size, s->at, from), s->radius.value);
            size = s->has_extent ? fmax(size, fmax(fabs(s->extent[0].value), s->extent[1].value))
                                 : size;
        }
    }
    return size;
}

static double size_of(const mechanism *m, int body)
{
    static const double joint[3] = {0.0};

    return size_about(m, body, joint);
}

static void doubt_inertia(mech__reader *rd, int body)
{
    const mech_body *b = &rd->m->bodies[body];
    const mech__node *node = mech__get(rd->body_node[body], "inertia");
    double size = size_of(rd->m, body), most = 0.0;

    for (int i = 0; i < 3; i++) {
        most = fmax(most, b->inertia[i].value);
    }
    double expected = b->mass.value * size * size;

    if (node && expected > 0.0 && most > most_inertia * expected) {
        mech__problem_at(rd, node,
                         "warning: the inertia of %s, %.3g kg m^2, is %.2g times the largest of "
                         "%.3g kg within %.3g m; is it in g mm^2 or kg mm^2?",
                         b->name, most, most / expected, b->mass.value, size);
    }
}

/* Does it stand alone at the end of a tree: nothing on it, no loop, and nothing prescribes it? */
static int is_last(const mechanism *m, int body)
{
    const mech_body *b = &m->bodies[body];
    int alone = !b->lead && !b->ball && !b->part;

    for (int i = 0; i < m->nbody; i++) {
        alone = alone && m->bodies[i].parent != body;
    }
    for (int i = 0; i < 2 * m->nloop; i++) {
        const mech_loop *l = &m->loops[i / 2];
        int of = l->index[i % 2];

        alone = alone && (l->kind == MECH_COUPLING ? of : of < 0 ? of : m->points[of].body) != body;
    }
    for (int i = 0; i < m->ninput; i++) {
        alone = alone && !(m->inputs[i].kind == STEIN_INPUT_MOTION && m->inputs[i].index == body);
    }
    return alone;
}

/* a hinge that turns no inertia of its own, a body without weight */
static void doubt_nothing(mech__reader *rd, int body)
{
    const mech_body *b = &rd->m->bodies[body];
    const mech__node *node = mech__get(rd->body_node[body], "mass");
    double x = b->centre[0].value, y = b->centre[1].value, z = b->centre[2].value;
    double from = sqrt(x * x + y * y + z * z);

    if (!is_last(rd->m, body)) {
        return;
    }
    if (b->mass.value == 0.0 && from > 0.0) {
        mech__problem_at(rd, node ? node : rd->body_node[body],
                         "warning: the body %s has no mass, so it has no weight; expected `mass:`",
                         b->name);
    } else if (b->mass.value > 0.0 && b->type == 'R' && b->inertia[b->axis - 'x'].value == 0.0 &&
               b->armature.value == 0.0 && size_of(rd->m, body) > farther * from) {
        mech__problem_at(rd, rd->body_node[body],
                         "warning: the body %s has no inertia about %c, so all its mass is in its "
                         "centre; expected `inertia: {%c%c: ...}` about the centre of mass, or "
                         "`pendulum:`",
                         b->name, b->axis, b->axis, b->axis);
    }
}

/* Is the inertia about the joint instead of the centre of mass? It is then m c^2 and more, and its
 * radius of gyration is larger than the body. A body that is balanced near its joint has many
 * times m c^2. */
static void doubt_centre(mech__reader *rd, int body)
{
    const mech_body *b = &rd->m->bodies[body];
    const mech__node *node = mech__get(rd->body_node[body], "inertia");
    const double centre[3] = {b->centre[0].value, b->centre[1].value, b->centre[2].value};
    char key[] = {b->axis, b->axis, '\0'};
    double from = 0.0;

    if (!node || b->type != 'R' || !is_last(rd->m, body) || !(b->mass.value > 0.0)) {
        return;
    }
    for (int i = 0; i < 3; i++) {
        from += i == b->axis - 'x' ? 0.0 : centre[i] * centre[i];
    }
    int has_points = size_of(rd->m, body) > farther * sqrt(from);
    double inertia = b->inertia[b->axis - 'x'].value, moved = b->mass.value * from;
    double radius = sqrt(inertia / b->mass.value);
    const mech__node *entry = mech__get(node, key);
    double size = reach(size_about(rd->m, body, centre), (mech_scalar[3]){{0}}, centre);

    if (has_points && moved > 0.0 && inertia > moved && inertia < most_about_joint * moved &&
        radius > size) {
        mech__problem_at(rd, entry ? entry : node,
                         "warning: `inertia:` of %s is about its centre of mass, but %.4g kg m^2 "
                         "is all its mass %.3g m from there, outside of its points; if that is "
                         "about the joint, write %.4g kg m^2, which is less by m c^2",
                         b->name, inertia, radius, inertia - moved);
    }
}

void mech__doubts(mech__reader *rd)
{
    habits h = find_habits(rd);

    for (const mech__slot *s = rd->slots; h.scaled && s; s = s->next) {
        doubt_unit(rd, s, &h);
    }
    for (int i = 0; i < rd->m->nbody; i++) {
        doubt_inertia(rd, i);
        doubt_nothing(rd, i);
        doubt_centre(rd, i);
    }
}
