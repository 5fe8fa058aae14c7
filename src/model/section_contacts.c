/* SPDX-License-Identifier: MIT
 * section_contacts.c - links, contacts, notches and the free load's contact.
 *
 * The mechanism has only spots: a circle (or an end of a line) against a circle or a line. So a
 * line that comes first is exchanged with its point. A line against a line becomes two contacts at
 * its ends. The load is a contact between its flat underside and the point under it.
 */
#include <string.h>

#include "reader.h"

typedef enum { POINT, CIRCLE, LINE, SPHERE, PLANE, BOX, NONE } shape_kind;

static const char *const kind_names[] = {"point", "circle", "line", "sphere", "plane", "box"};

/** Does every joint on the way to the frame turn about an axis or slide across it? */
static int moves_across(const mechanism *m, int body, char axis)
{
    while (body >= 0 && (m->bodies[body].type == 'R') == (m->bodies[body].axis == axis)) {
        body = m->bodies[body].parent;
    }
    return body < 0;
}

/** Notches and loads are planar: every joint on the way to the frame turns about y or slides along
 *  x or z. */
static int check_planar(mech__reader *rd, const mech__node *node, int body)
{
    for (int i = body; i >= 0; i = rd->m->bodies[i].parent) {
        const mech_body *b = &rd->m->bodies[i];

        if ((b->type == 'R') != (b->axis == 'y')) {
            mech__problem_at(
                rd, node,
                "notches and loads are planar: the joint %s must turn about y or slide "
                "along x or z, found %c %c",
                b->name, b->type, b->axis);
            return -1;
        }
    }
    return 0;
}

/** Place of a shape: "at: body.point", or "on: body" with three numbers.
 *  @param flags  of those: of a planar contact y does nothing, so that a zero there is no parameter
 */
static int read_place(mech__reader *rd, const mech__node *map, const char *what, const char *base,
                      int *body, mech_scalar at[3], unsigned flags)
{
    const mech__node *node = mech__need(rd, map, "at", what);
    const mech__node *on = mech__get(map, "on");
    int point, other;

    if (!node) {
        return -1;
    }
    if (node->kind != MECH__SCALAR) {
        if (!mech__need(rd, map, "on", what) || mech__body_ref(rd, on, 1, body) != 0) {
            return -1;
        }
        mech__place(rd, *body, at, flags, node, base);
        return 0;
    }
    if (mech__point_ref(rd, node, &point) != 0) {
        return -1;
    }
    *body = rd->m->points[point].body;
    if (on && mech__body_ref(rd, on, 1, &other) == 0 && other != *body) {
        mech__problem_at(rd, on, "the point %s is not on this body, expected the point's own body",
                         rd->m->points[point].name);
        return -1;
    }
    for (int i = 0; i < 3; i++) {
        mech__repeat(rd, &at[i], &rd->m->points[point].at[i]);
    }
    return 0;
}

static shape_kind find_kind(mech__reader *rd, const mech__node *side)
{
    shape_kind found = NONE;
    int n = 0;

    if (!mech__keys(rd, side, "a side of a contact", "point circle line sphere plane box")) {
        return NONE;
    }
    for (int k = POINT; k < NONE; k++) {
        if (mech__get(side, kind_names[k])) {
            found = (shape_kind)k;
            n++;
        }
    }
    if (n != 1) {
        mech__problem_at(rd, side,
                         "a side of a contact needs exactly one of point, circle, line, sphere, "
                         "plane, box");
        return NONE;
    }
    return found;
}

static void read_line(mech__reader *rd, mech_shape *s, const mech__node *map, const char *base)
{
    const mech__node *extent = mech__get(map, "extent");

    s->is_line = 1;
    mech__keys(rd, map, "a line", "on at facing extent");
    mech__number(rd, &s->facing, "rad", 0, mech__need(rd, map, "facing", "a line"), 0.0,
                 "%s.facing", base);
    if (!extent) {
        return;
    }
    if (extent->kind != MECH__LIST || extent->count != 2) {
        mech__problem_at(rd, extent, "extent must be a list of two lengths [from, to]");
        return;
    }
    s->has_extent = 1;
    mech__number(rd, &s->extent[0], "m", 0, extent->first, 0.0, "%s.extent.lo", base);
    mech__number(rd, &s->extent[1], "m", 0, extent->last, 0.0, "%s.extent.hi", base);
}

/** A sphere, a plane or a box. */
static int read_solid(mech__reader *rd, mech_shape *s, const mech__node *map, shape_kind kind,
                      const char *base)
{
    static const char *const what[] = {"a sphere", "a plane", "a box"};
    static const char *const keys[] = {"on at radius", "on at normal", "on at size"};
    const char *title = what[kind - SPHERE];

    s->solid = kind == PLANE ? MECH_PLANE : MECH_SPHERE;
    int placed = read_place(rd, map, title, base, &s->body, s->at, 0);

    mech__keys(rd, map, title, keys[kind - SPHERE]);
    if (kind == SPHERE) {
        mech__number(rd, &s->radius, "m", MECH__NOT_NEGATIVE, mech__need(rd, map, "radius", title),
                     0.0, "%s.radius", base);
        return placed;
    }
    char *path = mech__print(rd, kind == PLANE ? "%s.normal" : "%s.size", base);
    const mech__node *node = mech__need(rd, map, kind == PLANE ? "normal" : "size", title);

    if (path && node) {
        mech__vector(rd, kind == PLANE ? s->normal : s->size, kind == PLANE ? "1" : "m", 0, node,
                     path);
    }
    s->corner = kind == BOX;
    return placed;
}

/** @return 0 when the body of the shape is known */
static int read_shape(mech__reader *rd, mech_shape *s, const mech__node *side, shape_kind kind,
                      const char *base)
{
    const mech__node *map = mech__get(side, kind_names[kind]);
    int point, placed;

    if (kind >= SPHERE) {
        return read_solid(rd, s, map, kind, base);
    }
    if (kind == POINT) {
        if (mech__point_ref(rd, map, &point) != 0) {
            return -1;
        }
        s->body = rd->m->points[point].body;
        for (int i = 0; i < 3; i++) {
            mech__repeat(rd, &s->at[i], &rd->m->points[point].at[i]);
        }
        return 0;
    }
    placed = read_place(rd, map, kind == LINE ? "a line" : "a circle", base, &s->body, s->at,
                        MECH__PLANAR);
    if (kind == LINE) {
        read_line(rd, s, map, base);
    } else {
        mech__keys(rd, map, "a circle", "on at radius");
        mech__number(rd, &s->radius, "m", MECH__NOT_NEGATIVE,
                     mech__need(rd, map, "radius", "a circle"), 0.0, "%s.radius", base);
    }
    return placed;
}

/** Can these two touch? A side of LINE or PLANE stands second. */
static int can_touch(mech__reader *rd, const mech__node *between, const shape_kind kind[2])
{
    int solid = kind[0] >= SPHERE || kind[1] >= SPHERE;
    int flat = kind[0] == CIRCLE || kind[0] == LINE || kind[1] == CIRCLE || kind[1] == LINE;
    int box = kind[0] == BOX || kind[1] == BOX, plane = kind[0] == PLANE || kind[1] == PLANE;

    if (kind[0] == POINT && kind[1] == POINT) {
        mech__problem_at(rd, between,
                         "a point cannot touch a point, expected a circle, a line or a sphere");
    } else if (solid && flat) {
        mech__problem_at(rd, between,
                         "circles and lines touch in a plane, spheres, planes and boxes in space: "
                         "expected two sides of one kind");
    } else if (kind[0] == PLANE && kind[1] == PLANE) {
        mech__problem_at(rd, between, "a plane cannot touch a plane, expected a sphere or a box");
    } else if (box && !plane) {
        mech__problem_at(rd, between, "a box touches a plane only, with its corners");
    } else {
        return 1;
    }
    return 0;
}

/** Circles and lines of a mechanism that moves in another plane than x-z, or in space: as spheres
 *  and planes; the planes are normal to the plane of motion. */
static void lift_sides(mech__reader *rd, mech_contact *c, const mech__node *between)
{
    const mechanism *m = rd->m;
    mech_shape *side = c->spot[0].side;
    int a = side[0].body, b = side[1].body;

    if (side[0].solid || side[1].solid) {
        side[0].solid = MECH_SPHERE; // or a point
        side[1].solid = side[1].solid ? side[1].solid : MECH_SPHERE;
        return;
    }
    if (moves_across(m, a, 'y') && moves_across(m, b, 'y')) {
        return;
    }
    int across = moves_across(m, a, 'z') && moves_across(m, b, 'z')   ? 2
                 : moves_across(m, a, 'x') && moves_across(m, b, 'x') ? 0
                                                                      : 1;
    if (c->nspot > 1 || side[0].has_extent || side[1].has_extent) {
        mech__problem_at(rd, between,
                         "lines with ends touch in the x-z plane only, where all joints turn about "
                         "y or slide along x or z: expected a line without extent, or a box and a "
                         "plane");
    }
    for (int k = 0; k < 2; k++) {
        side[k].solid = side[k].is_line ? MECH_PLANE : MECH_SPHERE;
        side[k].across = across;
    }
}

/** Both sides of a contact, in the order of a spot. */
static void read_sides(mech__reader *rd, mech_contact *c, const mech__node *between)
{
    const mech__node *side[2] = {between->first, between->last};
    shape_kind kind[2] = {find_kind(rd, side[0]), find_kind(rd, side[1])};
    mech_spot *spot = &c->spot[0];
    int good = 1;

    if (kind[0] == NONE || kind[1] == NONE || !can_touch(rd, between, kind)) {
        return;
    }
    for (int i = 0; i < 2; i++) {
        int second = i == 1 && kind[0] == kind[1];
        int last = kind[0] == PLANE || (kind[0] == LINE && kind[1] != LINE);
        int place = last ? 1 - i : i;
        char *base = mech__print(rd, "%s.%s%s", c->name, kind_names[kind[i]], second ? "2" : "");

        good = base && read_shape(rd, &spot->side[place], side[i], kind[i], base) == 0 && good;
    }
    if (good && spot->side[0].body == spot->side[1].body) {
        mech__problem_at(rd, between,
                         "both sides are on one body, expected two that can move "
                         "against each other");
    }
    c->nspot = kind[0] == BOX || kind[1] == BOX ? MECH_SPOTS : 1;
    if (kind[0] == LINE && kind[1] == LINE) {
        c->nspot = 2;
        if (!mech__get(mech__get(side[0], "line"), "extent")) {
            mech__problem_at(rd, side[0],
                             "of two lines the first needs an extent: it touches with "
                             "its ends");
        }
    }
    if (good) {
        lift_sides(rd, c, between);
    }
}

static void read_contact(mech__reader *rd, mech_contact *c, const mech__node *entry)
{
    const mech__node *between = mech__need(rd, entry, "between", "a contact");

    mech__name_copy(c->name, sizeof c->name, entry->key->text);
    mech__keys(rd, entry, "a contact", "between normal friction adhesion gap");
    if (between && (between->kind != MECH__LIST || between->count != 2)) {
        mech__problem_at(rd, between, "between must be a list of two sides");
    } else if (between) {
        read_sides(rd, c, between);
    }
    mech__contact_law(rd, &c->normal, &c->friction, entry, "a contact", c->name);
    c->sticks = mech__contact_sticks(
        rd, entry, c->spot[0].side[0].solid != MECH_FLAT ? "a contact in space" : NULL);
}

/** The underside of the load, a line without ends that faces down, on a point. */
static void load_contact(mech__reader *rd, const mech__node *load)
{
    mechanism *m = rd->m;
    mech_contact *c = &m->contacts[m->ncontact];
    const mech__node *on = mech__need(rd, load, "on", "the load");
    int point;

    mech__keys(rd, load, "the load", "mass error on normal friction adhesion gap");
    mech__name_copy(c->name, sizeof c->name, "load");
    m->load_contact = m->ncontact++;
    c->nspot = 1;
    c->spot[0].side[1].body = m->load_body;
    c->spot[0].side[1].is_line = 1;
    if (on && mech__point_ref(rd, on, &point) == 0) {
        c->spot[0].side[0].body = m->points[point].body;
        check_planar(rd, on, m->points[point].body);
        for (int i = 0; i < 3; i++) {
            mech__repeat(rd, &c->spot[0].side[0].at[i], &m->points[point].at[i]);
        }
    }
    mech__contact_law(rd, &c->normal, &c->friction, load, "the load", "load");
    mech__contact_sticks(rd, load, "the load");
}

/** A catcher's notched corner and the beak of another body. */
static void read_notch(mech__reader *rd, mech_notch *n, const mech__node *entry)
{
    const mech__node *corner = mech__need(rd, entry, "corner", "a notch");
    const mech__node *beak = mech__need(rd, entry, "beak", "a notch");

    mech__name_copy(n->name, sizeof n->name, entry->key->text);
    mech__keys(rd, entry, "a notch", "corner beak normal friction adhesion gap");
    mech__keys(rd, corner, "corner", "on at angle lean");
    mech__keys(rd, beak, "beak", "on at tilt");
    char *base[2] = {mech__print(rd, "%s.corner", n->name), mech__print(rd, "%s.beak", n->name)};

    if (!base[0] || !base[1]) {
        return;
    }
    if (read_place(rd, corner, "corner", base[0], &n->catcher, n->corner, MECH__PLANAR) == 0 &&
        check_planar(rd, corner, n->catcher) == 0 &&
        read_place(rd, beak, "beak", base[1], &n->beak, n->end, MECH__PLANAR) == 0 &&
        check_planar(rd, beak, n->beak) == 0 && n->catcher == n->beak) {
        mech__problem_at(rd, entry->key, "corner and beak are on one body, expected two bodies");
    }
    mech__number(rd, &n->angle, "rad", MECH__WEDGE, mech__need(rd, corner, "angle", "corner"), 1.0,
                 "%s.angle", base[0]);
    mech__number(rd, &n->lean, "rad", 0, mech__get(corner, "lean"), 0.0, "%s.lean", base[0]);
    mech__number(rd, &n->tilt, "rad", 0, mech__get(beak, "tilt"), 0.0, "%s.tilt", base[1]);
    mech__contact_law(rd, &n->normal, &n->friction, entry, "a notch", n->name);
    mech__contact_sticks(rd, entry, "a notch");
}

void mech__section_contacts(mech__reader *rd)
{
    mechanism *m = rd->m;
    const mech__node *section = mech__get(rd->root, "contacts");
    const mech__node *notches = mech__get(rd->root, "notches");
    const mech__node *load = mech__get(rd->root, "load");
    int n = mech__section(rd, section, "a contact", MECH__MAX_THINGS);
    int k = mech__section(rd, notches, "a notch", MECH__MAX_THINGS);

    m->contacts = mech__array(rd, n + 1, sizeof *m->contacts);
    m->notches = mech__array(rd, k, sizeof *m->notches);
    for (const mech__node *e = n ? section->first : NULL; e && !rd->nomem; e = e->next) {
        if (load && strcmp(e->key->text, "load") == 0) {
            mech__problem_at(rd, e->key,
                             "no contact can be called \"load\": it is the name of the "
                             "free load");
            continue;
        }
        read_contact(rd, &m->contacts[m->ncontact++], e);
    }
    if (load && !rd->nomem) {
        load_contact(rd, load);
    }
    for (const mech__node *e = k ? notches->first : NULL; e && !rd->nomem; e = e->next) {
        read_notch(rd, &m->notches[m->nnotch++], e);
    }
}

void mech__contacts_finish(mech__reader *rd)
{
    mechanism *m = rd->m;

    for (int i = 0; i < m->ncontact; i++) {
        mech_contact *c = &m->contacts[i];

        if (c->nspot == 2) {
            c->spot[1] = c->spot[0];
            c->spot[0].side[0].end = -1;
            c->spot[1].side[0].end = 1;
        }
        for (int k = 1; k < c->nspot && c->nspot == MECH_SPOTS; k++) {
            c->spot[k] = c->spot[0];
            c->spot[k].side[0].corner = k + 1;
        }
        if (i == m->load_contact) {
            mech__constant(rd, &c->spot[0].side[1].facing, -1.5707963267948966, "load.line.facing",
                           "-90 deg");
        }
    }
}

/** A link's end or another reference that must be there. */
static void read_end(mech__reader *rd, const mech__node *entry, const char *key, int *point)
{
    const mech__node *node = mech__need(rd, entry, key, "a link");

    if (!node || mech__point_ref(rd, node, point) != 0) {
        *point = -1;
    }
}

void mech__section_links(mech__reader *rd)
{
    mechanism *m = rd->m;
    const mech__node *section = mech__get(rd->root, "links");
    int n = mech__section(rd, section, "a link", MECH__MAX_THINGS);

    m->links = mech__array(rd, n, sizeof *m->links);
    for (const mech__node *e = n ? section->first : NULL; e && !rd->nomem; e = e->next) {
        mech_link *l = &m->links[m->nlink++];

        mech__name_copy(l->name, sizeof l->name, e->key->text);
        mech__keys(rd, e, "a link", "from to k length damping slack let_off");
        read_end(rd, e, "from", &l->point[0]);
        read_end(rd, e, "to", &l->point[1]);
        if (l->point[0] >= 0 && l->point[1] >= 0 &&
            m->points[l->point[0]].body == m->points[l->point[1]].body) {
            mech__problem_at(rd, e->key,
                             "both ends of the link are on one body, expected two bodies");
        }
        mech__link_law(rd, l, e);
    }
}
