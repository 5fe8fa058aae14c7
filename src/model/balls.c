/* SPDX-License-Identifier: MIT
 * balls.c - joints that turn in all directions, `ball` and `free`, as joints of one axis.
 *
 *      free:  T x, T y, T z, then a ball          ball:  chart (R z), R x, R y, R z
 *
 * The last one carries the body, the others are bodies without mass. The chart never moves by
 * itself: the core sets its angle again, and the three others with it, before two axes become
 * parallel (src/core/chart.c). Names of the joints before the last one contain a dot, so they
 * cannot be names of a file.
 */
#include <string.h>

#include "reader.h"

enum { BALL = 4, FREE = 7, SUFFIX = sizeof ".chart" - 1 };

int mech__joints_of(const mech__node *entry)
{
    const mech__node *joint = mech__get(entry, "joint");
    const char *text = joint && joint->kind == MECH__SCALAR ? joint->text : "";

    return strcmp(text, "ball") == 0 ? BALL : strcmp(text, "free") == 0 ? FREE : 1;
}

static const struct {
    const char *name;
    char type, axis;
    int ball;
} joints[FREE] = {{".x", 'T', 'x', 0},     {".y", 'T', 'y', 0},     {".z", 'T', 'z', 0},
                  {".chart", 'R', 'z', 1}, {".turn1", 'R', 'x', 2}, {".turn2", 'R', 'y', 3},
                  {"", 'R', 'z', 4}};

int mech__lead_joints(mech__reader *rd, const mech__node *entry, int parent, int orphan)
{
    mechanism *m = rd->m;
    int n = mech__joints_of(entry);

    if (n > 1 && strlen(entry->key->text) + SUFFIX >= MECH_NAME) {
        mech__problem_at(rd, entry->key,
                         "the name of a body that turns in all directions has at "
                         "most %d signs",
                         MECH_NAME - 1 - SUFFIX);
    }
    for (int k = FREE - n; n > 1 && k < FREE; k++) {
        mech_body *b = &m->bodies[m->nbody];

        b->type = joints[k].type;
        b->axis = joints[k].axis;
        b->ball = joints[k].ball;
        b->sign = 1;
        b->free = n == FREE;
        if (k == FREE - 1) {
            break; // the body itself
        }
        mech__name_copy(b->name, sizeof b->name, entry->key->text);
        mech__name_copy(b->name + strlen(b->name), sizeof b->name - strlen(b->name),
                        joints[k].name);
        b->lead = 1;
        b->parent = parent;
        b->line = entry->key->line;
        b->column = entry->key->column;
        rd->body_node[m->nbody] = entry;
        rd->orphan[m->nbody] = (char)orphan;
        parent = m->nbody++;
    }
    return parent;
}

mech_body *mech__first_joint(mech_body *b)
{
    return b->free ? b - (FREE - 1) : b->ball ? b - (BALL - 1) : b;
}

/** Three numbers "NAME.initial.KEY.x" of three joints, their positions or speeds. */
static void read_three(mech__reader *rd, const char *name, const mech__node *initial,
                       const char *key, const char *unit, mech_scalar *const to[3])
{
    const mech__node *node = mech__get(initial, key), *entry = NULL;

    if (node && (node->kind != MECH__LIST || node->count != 3)) {
        mech__problem_at(rd, node, "%s.initial.%s must be a list of three numbers [x, y, z]", name,
                         key);
    } else if (node) {
        entry = node->first;
    }
    for (int i = 0; i < 3; i++) {
        mech__number(rd, to[i], unit, 0, entry, 0.0, "%s.initial.%s.%c", name, key, "xyz"[i]);
        entry = entry ? entry->next : NULL;
    }
}

void mech__ball_initial(mech__reader *rd, mech_body *b, const mech__node *node)
{
    mech_body *slide = b - (FREE - 1), *turn = b - 2;

    mech__keys(rd, node, "initial", b->free ? "position velocity attitude spin" : "attitude spin");
    if (b->free) {
        mech_scalar *const q[3] = {&slide[0].q0, &slide[1].q0, &slide[2].q0};
        mech_scalar *const qd[3] = {&slide[0].qd0, &slide[1].qd0, &slide[2].qd0};

        read_three(rd, b->name, node, "position", "m", q);
        read_three(rd, b->name, node, "velocity", "m/s", qd);
    }
    mech_scalar *const q[3] = {&turn[0].q0, &turn[1].q0, &turn[2].q0};
    mech_scalar *const qd[3] = {&turn[0].qd0, &turn[1].qd0, &turn[2].qd0};

    read_three(rd, b->name, node, "attitude", "rad", q);
    read_three(rd, b->name, node, "spin", "rad/s", qd);
}
