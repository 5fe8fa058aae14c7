/* SPDX-License-Identifier: MIT
 * fixed_bodies.c - bodies without a joint: they become part of the bodies that carry them.
 *
 * A fixed body is written like any other one: its mass, its points and its child bodies, in its own
 * axes, which are parallel to its parent's. All of its numbers are parameters. The equations have
 * no trace of it. Places on it are moved into the axes of the moving body that carries it, and its
 * mass, centre and inertia are added to that body (split_body.c).
 */
#include <stdio.h>
#include <string.h>

#include "reader.h"

/** Places on body i into the axes of its parent. A place at a named point follows that. */
static void move_places(mech__reader *rd, int i)
{
    const mech_scalar *at = rd->m->bodies[i].at;

    for (const mech__slot *s = rd->slots; !rd->nomem && s; s = s->next) {
        if (s->more >= at && s->more < at + 3) {
            mech__shift(rd, s->to, *s->more, 1, s, "from the origin of what carries it");
        }
    }
    mech__repeat_all(rd);
}

static void join(mech__reader *rd, int i)
{
    const mech_body *b = &rd->m->bodies[i];
    mech_body *carrier = &rd->m->bodies[b->parent];
    int empty = b->mass.kind == MECH_ZERO;
    char name[MECH_PATH];

    for (int e = 0; e < 6; e++) {
        empty &= b->inertia[e].kind == MECH_ZERO;
    }
    if (empty || mech__failed(rd, b->name) || mech__failed(rd, carrier->name)) {
        return;
    }
    if (!(b->mass.value + carrier->mass.value > 0.0)) {
        mech__problem_at(rd, rd->body_node[i], "%s and %s have no mass together, expected one",
                         carrier->name, b->name);
        return;
    }
    snprintf(name, sizeof name, "%s.with.%s", carrier->name, b->name);
    mech__combine(rd, carrier, b, 0, rd->body_node[i], name);
}

/** Where the bodies are once those that are fixed are gone: their carrier's place, -1 the frame. */
typedef struct moved {
    int to[MECH_BODIES];
} moved;

static void move_body(const moved *w, int *body)
{
    *body = *body >= 0 ? w->to[*body] : *body;
}

static void move_references(mechanism *m, const moved *w)
{
    for (int i = 0; i < m->npoint; i++) {
        move_body(w, &m->points[i].body);
    }
    for (int i = 0; i < m->ncontact; i++) {
        for (int k = 0; k < 4; k++) {
            move_body(w, &m->contacts[i].spot[k / 2].side[k % 2].body);
        }
    }
    for (int i = 0; i < m->nnotch; i++) {
        move_body(w, &m->notches[i].catcher);
        move_body(w, &m->notches[i].beak);
    }
    for (int i = 0; i < m->ntable; i++) {
        if (m->tables[i].kind <= STEIN_TABLE_SPEED) {
            move_body(w, &m->tables[i].index);
        }
    }
    for (int i = 0; i < m->nloop; i++) {
        if (m->loops[i].kind == MECH_COUPLING) {
            move_body(w, &m->loops[i].index[0]);
            move_body(w, &m->loops[i].index[1]);
        }
    }
    for (int i = 0; i < m->ninput; i++) {
        if (m->inputs[i].kind != STEIN_INPUT_POINT) {
            move_body(w, &m->inputs[i].index);
        }
    }
    for (int i = 0; i < m->nchannel; i++) {
        mech_channel *c = &m->channels[i];
        mech_thing of = mech_output_kind_of(c->read)->of;
        if (!c->loop && (of == MECH_A_JOINT || of == MECH_A_BODY)) {
            move_body(w, &c->index);
        }
        move_body(w, &c->axes);
    }
    move_body(w, &m->load_body);
}

void mech__fixed(mech__reader *rd)
{
    mechanism *m = rd->m;
    moved w = {{0}};
    int n = 0;

    for (int i = 0; i < m->nbody && !rd->nomem; i++) {
        mech_body *b = &m->bodies[i];

        while (b->parent >= 0 && m->bodies[b->parent].type == MECH__FIXED) {
            b->parent = m->bodies[b->parent].parent;
        }
        if (b->type == MECH__FIXED) {
            move_places(rd, i);
            if (b->parent >= 0) {
                join(rd, i);
            }
            mech__check_inertia(rd, i);
        }
    }
    for (int i = 0; i < m->nbody; i++) {
        mech_body *b = &m->bodies[i];
        int parent = b->parent >= 0 ? w.to[b->parent] : -1;

        w.to[i] = b->type == MECH__FIXED ? parent : n;
        if (b->type != MECH__FIXED) {
            b->parent = parent;
            rd->body_node[n] = rd->body_node[i];
            rd->orphan[n] = rd->orphan[i];
            m->bodies[n++] = *b;
        }
    }
    if (n < m->nbody) {
        m->nbody = n;
        move_references(m, &w);
    }
}
