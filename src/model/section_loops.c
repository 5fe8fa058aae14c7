/* SPDX-License-Identifier: MIT
 * section_loops.c - closed loops, and joints that follow another one.
 *
 * A tree of bodies is closed where two of its points are held together. They meet, keep the length
 * of a rod, slide in a slot, or their bodies keep their axes parallel as well. A coupling holds
 * between two joints by itself. `mimic` in a body is a coupling that has the body's name.
 */
#include <string.h>

#include "reader.h"

/** Two points of different bodies: "between: [a.p, b.q]", or "from" and "to" as in a link. */
static int read_points(mech__reader *rd, mech_loop *l, const mech__node *entry)
{
    const mech__node *between = mech__get(entry, "between"), *node[2];
    int bad = 0;

    if (between && (between->kind != MECH__LIST || between->count != 2)) {
        mech__problem_at(rd, between, "expected two points, as in between: [rod.end, frame.pin]");
        return -1;
    }
    node[0] = between ? between->first : mech__get(entry, "from");
    node[1] = between ? between->first->next : mech__get(entry, "to");
    if (!node[0] || !node[1] || (between && (mech__get(entry, "from") || mech__get(entry, "to")))) {
        mech__problem_at(rd, entry->key,
                         "a loop needs two points, as in between: [rod.end, frame.pin]");
        return -1;
    }
    for (int k = 0; k < 2; k++) {
        bad |= mech__point_ref(rd, node[k], &l->index[k]);
    }
    if (!bad && rd->m->points[l->index[0]].body == rd->m->points[l->index[1]].body) {
        mech__problem_at(rd, entry->key,
                         "both points of the loop are on one body, expected two bodies");
        return -1;
    }
    return bad;
}

/** Constraint of the two points. */
static void read_kind(mech__reader *rd, mech_loop *l, const mech__node *entry)
{
    const mech__node *rod = mech__get(entry, "rod"), *slot = mech__get(entry, "slot");
    const mech__node *weld = mech__get(entry, "weld"), *hinge = mech__get(entry, "hinge");
    const mech__node *axis = slot ? slot : hinge;

    if ((rod != NULL) + (slot != NULL) + (weld != NULL) + (hinge != NULL) > 1) {
        mech__problem_at(rd, entry->key, "rod, slot, weld and hinge exclude each other");
        return;
    }
    l->axis = axis ? mech__choice(rd, axis, "axis", "x y z") : -1;
    if (weld) {
        mech__choice(rd, weld, "word for a weld", "yes");
    }
    l->kind = rod ? MECH_ROD : slot ? MECH_SLOT : weld || hinge ? MECH_WELD : MECH_MEET;
    if (rod) {
        mech__number(rd, &l->length, "m", MECH__POSITIVE, rod, 1.0, "%s.rod", l->name);
    }
}

/** @param path  of its numbers */
static void read_coupling(mech__reader *rd, mech_loop *l, const mech__node *entry, const char *path)
{
    static const char *const unit[2][2] = {{"1", "rad/m"}, {"m/rad", "1"}}; /* [follower][leader] */
    const mech_body *b = rd->m->bodies;
    int slides = b[l->index[0]].type == 'T', led = b[l->index[1]].type == 'T';
    const mech__node *ratio = mech__get(entry, "ratio");

    l->kind = MECH_COUPLING;
    l->axis = -1;
    if (l->index[0] == l->index[1]) {
        mech__problem_at(rd, entry->key, "a joint cannot follow itself, expected another one");
        return;
    }
    if (slides != led) {
        mech__need(rd, entry, "ratio", "a coupling of a turning and a sliding joint");
    }
    mech__number(rd, &l->ratio, unit[slides][led], 0, ratio, 1.0, "%s.ratio", path);
    mech__number(rd, &l->offset, slides ? "m" : "rad", 0, mech__get(entry, "offset"), 0.0,
                 "%s.offset", path);
}

/** A reference to a joint that must be there. */
static int joint_ref(mech__reader *rd, const mech__node *entry, const char *key, const char *what,
                     int *joint)
{
    const mech__node *node = mech__need(rd, entry, key, what);

    return node ? mech__joint_ref(rd, node, joint) : -1;
}

static mech_loop *add(mechanism *m, const char *name)
{
    mech_loop *l = &m->loops[m->nloop++];

    mech__name_copy(l->name, sizeof l->name, name);
    return l;
}

/** `mimic` in bodies, then the section. */
static void read_couplings(mech__reader *rd, const mech__node *section)
{
    mechanism *m = rd->m;

    for (int i = 0; i < m->nbody; i++) {
        const mech__node *mimic = mech__get(rd->body_node[i], "mimic");

        if (i != m->load_body && mimic && mech__keys(rd, mimic, "mimic", "joint ratio offset")) {
            mech_loop *l = add(m, m->bodies[i].name);

            l->index[0] = i;
            if (joint_ref(rd, mimic, "joint", "mimic", &l->index[1]) == 0) {
                read_coupling(rd, l, mimic, mech__print(rd, "%s.mimic", l->name));
            }
        }
    }
    for (const mech__node *e = section ? section->first : NULL; e && !rd->nomem; e = e->next) {
        mech_loop *l = add(m, e->key->text);

        if (mech__keys(rd, e, "a coupling", "joint follows ratio offset") &&
            joint_ref(rd, e, "joint", "a coupling", &l->index[0]) == 0 &&
            joint_ref(rd, e, "follows", "a coupling", &l->index[1]) == 0) {
            read_coupling(rd, l, e, l->name);
        }
    }
}

void mech__section_loops(mech__reader *rd)
{
    mechanism *m = rd->m;
    const mech__node *loops = mech__get(rd->root, "loops");
    const mech__node *couplings = mech__get(rd->root, "couplings");
    int n = mech__section(rd, loops, "a loop", MECH__MAX_THINGS);
    int k = mech__section(rd, couplings, "a coupling", MECH__MAX_THINGS);

    m->loops = mech__array(rd, n + k + m->nbody, sizeof *m->loops);
    for (const mech__node *e = n ? loops->first : NULL; e && !rd->nomem; e = e->next) {
        mech_loop *l = add(m, e->key->text);

        if (mech__keys(rd, e, "a loop", "between from to rod slot weld hinge") &&
            read_points(rd, l, e) == 0) {
            read_kind(rd, l, e);
        }
    }
    if (!rd->nomem) {
        read_couplings(rd, k ? couplings : NULL);
    }
}
