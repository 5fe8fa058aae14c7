/* SPDX-License-Identifier: MIT
 * structure.c - hash of all data that the equations of a mechanism depend on.
 *
 * Equal structure, equal equations: with the equations of one mechanism, equal equations of another
 * one are recognised without generating them. Everything counts but
 *
 *   values and tolerances of parameters      setup() works with those it is given
 *   step, integrator, duration, settling     the program takes them from the file
 *   dials, texts, lines, the file's name     are in no equation
 *
 * A number that vanishes is no parameter but a zero, and counts as one. Texts count with their
 * closing zero, so that two cannot be read as one.
 */
#include <stdio.h>
#include <string.h>

#include "gen_internal.h"

typedef uint64_t hash;

static void bytes(hash *h, const void *at, size_t n)
{
    *h = hash_bytes(*h, at, n);
}

static void number(hash *h, int i)
{
    bytes(h, &i, sizeof i);
}

static void words(hash *h, const char *word)
{
    bytes(h, word, strlen(word) + 1);
}

static void scalars(hash *h, const mech_scalar *s, int n)
{
    for (int i = 0; i < n; i++) {
        number(h, (int)s[i].kind);
        number(h, s[i].kind == MECH_ZERO ? 0 : s[i].index);
    }
}

static void params(hash *h, const mechanism *m)
{
    number(h, m->nparam);
    for (int i = 0; i < m->nparam; i++) {
        words(h, m->params[i].name);
        words(h, m->params[i].unit);
        number(h, m->params[i].declared);
        number(h, (int)m->params[i].range);
    }
}

static void formulas(hash *h, const mechanism *m)
{
    number(h, m->nformula);
    for (int i = 0; i < m->nformula; i++) {
        const mech_formula *f = &m->formulas[i];
        words(h, f->name);
        words(h, f->text);
        number(h, f->nsteps);
        for (int k = 0; k < f->nsteps; k++) {
            number(h, (int)f->steps[k].op);
            number(h, f->steps[k].param);
            bytes(h, &f->steps[k].value, sizeof f->steps[k].value);
        }
    }
}

static void bodies(hash *h, const mechanism *m)
{
    number(h, m->nbody);
    for (int i = 0; i < m->nbody; i++) {
        const mech_body *b = &m->bodies[i];
        const int is[] = {b->parent, b->part, b->type, b->axis, b->sign};
        words(h, b->name);
        bytes(h, is, sizeof is);
        scalars(h, b->at, 3);
        scalars(h, &b->mass, 1);
        scalars(h, b->centre, 3);
        scalars(h, b->inertia, 6);
        scalars(h, b->joint, STEIN_JOINT_SIZE);
        scalars(h, &b->q0, 1);
        scalars(h, &b->qd0, 1);
    }
    number(h, m->npoint);
    for (int i = 0; i < m->npoint; i++) {
        words(h, m->points[i].name);
        number(h, m->points[i].body);
        scalars(h, m->points[i].at, 3);
    }
}

static void shape(hash *h, const mech_shape *s)
{
    const int is[] = {s->body, s->is_line, s->has_extent, s->end};
    bytes(h, is, sizeof is);
    scalars(h, s->at, 3);
    scalars(h, &s->radius, 1);
    scalars(h, &s->facing, 1);
    scalars(h, s->extent, 2);
    if (s->solid != MECH_FLAT) {
        const int in_space[] = {s->solid, s->corner, s->across};
        bytes(h, in_space, sizeof in_space);
        scalars(h, s->normal, 3);
        scalars(h, s->size, 3);
    }
}

static void contacts(hash *h, const mechanism *m)
{
    number(h, m->ncontact);
    for (int i = 0; i < m->ncontact; i++) {
        const mech_contact *c = &m->contacts[i];
        words(h, c->name);
        number(h, c->nspot);
        for (int k = 0; k < c->nspot; k++) {
            shape(h, &c->spot[k].side[0]);
            shape(h, &c->spot[k].side[1]);
        }
        scalars(h, c->normal.v, STEIN_NORMAL_SIZE);
        scalars(h, c->friction.v, STEIN_FRICTION_SIZE);
    }
}

static void notches(hash *h, const mechanism *m)
{
    number(h, m->nnotch);
    for (int i = 0; i < m->nnotch; i++) {
        const mech_notch *n = &m->notches[i];
        words(h, n->name);
        number(h, n->catcher);
        number(h, n->beak);
        scalars(h, n->corner, 3);
        scalars(h, &n->lean, 1);
        scalars(h, &n->angle, 1);
        scalars(h, n->end, 3);
        scalars(h, &n->tilt, 1);
        scalars(h, n->normal.v, STEIN_NORMAL_SIZE);
        scalars(h, n->friction.v, STEIN_FRICTION_SIZE);
    }
}

static void laws(hash *h, const mechanism *m)
{
    number(h, m->nlink);
    for (int i = 0; i < m->nlink; i++) {
        words(h, m->links[i].name);
        bytes(h, m->links[i].point, sizeof m->links[i].point);
        scalars(h, m->links[i].law, STEIN_LINK_SIZE);
    }
    number(h, m->ntable);
    for (int i = 0; i < m->ntable; i++) {
        const mech_table *t = &m->tables[i];
        words(h, t->name);
        number(h, t->kind);
        number(h, t->index);
        number(h, t->n);
        scalars(h, t->v, 2 * t->n);
    }
}

/* none leave no trace: mechanisms without limits, armatures, sticking, balls and loops keep their
 * older hash */
static void limits_and_loops(hash *h, const mechanism *m)
{
    for (int i = 0; i < m->nbody; i++) {
        if (m->bodies[i].limited) {
            number(h, i);
            scalars(h, m->bodies[i].limit, STEIN_LIMIT_SIZE);
        }
        if (m->bodies[i].armature.kind != MECH_ZERO) {
            words(h, "armature");
            number(h, i);
            scalars(h, &m->bodies[i].armature, 1);
        }
        if (m->bodies[i].sticks) {
            words(h, "stick");
            number(h, i);
        }
    }
    for (int i = 0; i < m->ncontact; i++) {
        if (m->contacts[i].sticks) {
            words(h, "stick");
            number(h, m->nbody + i);
        }
    }
    for (int i = 0; i < m->nbody; i++) {
        if (m->bodies[i].ball) {
            const int is[] = {i, m->bodies[i].ball};
            bytes(h, is, sizeof is);
        }
    }
    for (int i = 0; i < m->nloop; i++) {
        const mech_loop *l = &m->loops[i];
        const int is[] = {l->kind, l->index[0], l->index[1], l->axis};
        words(h, l->name);
        bytes(h, is, sizeof is);
        scalars(h, &l->length, 1);
        scalars(h, &l->ratio, 1);
        scalars(h, &l->offset, 1);
    }
}

static void signals(hash *h, const mechanism *m)
{
    number(h, m->ninput);
    for (int i = 0; i < m->ninput; i++) {
        const mech_input *s = &m->inputs[i];
        words(h, s->name);
        words(h, s->unit);
        number(h, s->kind);
        number(h, s->index);
        number(h, s->hold);
        scalars(h, s->direction, 3);
        scalars(h, s->signal, STEIN_SIGNAL_SIZE);
    }
    number(h, m->nchannel);
    for (int i = 0; i < m->nchannel; i++) {
        const mech_channel *c = &m->channels[i];
        const int is[] = {c->read, c->index, c->sign, c->from_rest};
        words(h, c->name);
        words(h, c->unit);
        bytes(h, is, sizeof is);
        if (c->read == STEIN_READ_REACTION) {
            const int of[] = {c->loop, c->component, c->axes};
            bytes(h, of, sizeof of);
        }
        scalars(h, c->sensor, STEIN_SENSOR_SIZE);
    }
}

void gen_structure(const mechanism *m, char out[17])
{
    const int roles[] = {m->load_body, m->load_contact, m->stroke_string, m->stroke_notch};
    hash h = GEN_HASH;
    words(&h, m->name);
    scalars(&h, m->gravity, 3);
    params(&h, m);
    formulas(&h, m);
    bodies(&h, m);
    contacts(&h, m);
    notches(&h, m);
    laws(&h, m);
    limits_and_loops(&h, m);
    signals(&h, m);
    bytes(&h, roles, sizeof roles);
    scalars(&h, &m->clock_error, 1);
    snprintf(out, 17, "%016llx", (unsigned long long)h);
}
