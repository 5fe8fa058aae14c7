/* SPDX-License-Identifier: MIT
 * split_body.c - a body cut in two: the rest of the whole, and the places on the part.
 *
 * A part of a body is described as drawn on the whole: its points, its centre and its joint are
 * in the whole's axes, from the whole's origin. Mass, centre and inertia stated for the whole
 * include both. So a number keeps its name and its meaning when a body is cut, and the rest stays
 * right when the whole is weighed or fitted again:
 *
 *      m' = m - m_p      c' = (m c - m_p p)/m'      u = p - c
 *      I' = I - I_p - m m_p/m' (u^2 1 - u u^T)
 *
 * with c, p the centres of whole and part. (The parallel axes of the two pieces about the common
 * centre have lengths u m/m' and u m_p/m'.) Elements of the tensor that neither body states stay
 * structural zeros.
 */
#include <stdio.h>
#include <string.h>

#include "reader.h"

enum { MAX_STEPS = 4 * MECH__MAX_STEPS };

/** A formula while it is put together. */
typedef struct builder {
    mech_step step[MAX_STEPS];
    int n, depth, deepest, full;
} builder;

static void put_step(builder *b, mech_step step)
{
    int operand = step.op == MECH_OP_CONST || step.op == MECH_OP_PARAM;

    if (b->n == MAX_STEPS) {
        b->full = 1;
        return;
    }
    b->step[b->n++] = step;
    b->depth += operand ? 1 : step.op <= MECH_OP_DIV ? -1 : 0;
    b->deepest = b->depth > b->deepest ? b->depth : b->deepest;
}

static void begin(builder *b)
{
    b->n = b->depth = b->deepest = b->full = 0;
}

static void put_op(builder *b, mech_op op)
{
    put_step(b, (mech_step){op, -1, 0.0});
}

static void put(builder *b, const mechanism *m, mech_scalar s)
{
    if (s.kind == MECH_FORMULA) {
        const mech_formula *f = &m->formulas[s.index];

        for (int i = 0; i < f->nsteps; i++) {
            put_step(b, f->steps[i]);
        }
    } else if (s.kind == MECH_PARAM) {
        put_step(b, (mech_step){MECH_OP_PARAM, s.index, 0.0});
    } else {
        put_step(b, (mech_step){MECH_OP_CONST, -1, 0.0});
    }
}

/** x y op */
static void put_two(builder *b, const mechanism *m, mech_scalar x, mech_scalar y, mech_op op)
{
    put(b, m, x);
    put(b, m, y);
    put_op(b, op);
}

static mech_scalar finish(mech__reader *rd, const builder *b, const mech__node *node,
                          const char *name, const char *text)
{
    if (b->full || b->deepest > MECH_STACK) {
        mech__problem_at(rd, node, "%s: the formula is too long", name);
        return (mech_scalar){MECH_ZERO, 0, 0.0};
    }
    return mech__formula(rd, name, text, b->step, b->n);
}

/* --- the rest --- */

typedef struct cut {
    mech__reader *rd;
    const mech_body *whole, *part; /* the whole before the split */
    const mech__node *node;
    builder *b;
    mech_op op, other; /* the part is taken away (SUB), or added; the opposite */
} cut;

static mech_scalar cut_mass(const cut *c, const char *name)
{
    begin(c->b);
    put_two(c->b, c->rd->m, c->whole->mass, c->part->mass, c->op);
    return finish(c->rd, c->b, c->node, name, c->op == MECH_OP_SUB ? "m - m_p" : "m + m_f");
}

static mech_scalar cut_centre(const cut *c, int k, const char *name)
{
    const mechanism *m = c->rd->m;

    if (c->whole->centre[k].kind == MECH_ZERO && c->part->centre[k].kind == MECH_ZERO) {
        return c->whole->centre[k];
    }
    begin(c->b);
    put_two(c->b, m, c->whole->mass, c->whole->centre[k], MECH_OP_MUL);
    put_two(c->b, m, c->part->mass, c->part->centre[k], MECH_OP_MUL);
    put_op(c->b, c->op);
    put_two(c->b, m, c->whole->mass, c->part->mass, c->op);
    put_op(c->b, MECH_OP_DIV);
    return finish(c->rd, c->b, c->node, name,
                  c->op == MECH_OP_SUB ? "(m c - m_p p)/(m - m_p)" : "(m c + m_f f)/(m + m_f)");
}

/** u_i u_j */
static void put_square(const cut *c, int i, int j)
{
    const mechanism *m = c->rd->m;

    put_two(c->b, m, c->part->centre[i], c->whole->centre[i], MECH_OP_SUB);
    put_two(c->b, m, c->part->centre[j], c->whole->centre[j], MECH_OP_SUB);
    put_op(c->b, MECH_OP_MUL);
}

static mech_scalar cut_inertia(const cut *c, int e, const char *name)
{
    static const int first[] = {1, 0, 0, 0, 0, 1}, second[] = {2, 2, 1, 1, 2, 2};
    const mechanism *m = c->rd->m;
    mech_scalar I = c->whole->inertia[e], part = c->part->inertia[e];
    int i = first[e], j = second[e];

    if (I.kind == MECH_ZERO && part.kind == MECH_ZERO) {
        return I;
    }
    begin(c->b);
    put_two(c->b, m, I, part, c->op);
    put_two(c->b, m, c->whole->mass, c->part->mass, MECH_OP_MUL);
    put_two(c->b, m, c->whole->mass, c->part->mass, c->op);
    put_op(c->b, MECH_OP_DIV);
    if (e < 3) {
        put_square(c, i, i);
        put_square(c, j, j);
        put_op(c->b, MECH_OP_ADD);
        put_op(c->b, MECH_OP_MUL);
        put_op(c->b, c->op);
    } else {
        put_square(c, i, j);
        put_op(c->b, MECH_OP_MUL);
        put_op(c->b, c->other);
    }
    return finish(c->rd, c->b, c->node, name,
                  c->op == MECH_OP_SUB ? "I - I_p - m m_p/(m - m_p) (u^2 - u u)"
                                       : "I + I_f + m m_f/(m + m_f) (u^2 - u u)");
}

void mech__combine(mech__reader *rd, mech_body *a, const mech_body *b, int apart,
                   const mech__node *node, const char *name)
{
    static const char *const element[] = {"xx", "yy", "zz", "xy", "xz", "yz"};
    const mech_body before = *a;
    builder *room = mech__alloc(rd, sizeof *room);
    const cut c = {.rd = rd,
                   .whole = &before,
                   .part = b,
                   .node = node,
                   .b = room,
                   .op = apart ? MECH_OP_SUB : MECH_OP_ADD,
                   .other = apart ? MECH_OP_ADD : MECH_OP_SUB};
    char path[MECH_PATH];

    if (!room) {
        return;
    }
    snprintf(path, sizeof path, "%s.mass", name);
    a->mass = cut_mass(&c, path);
    for (int k = 0; k < 3; k++) {
        snprintf(path, sizeof path, "%s.centre.%c", name, "xyz"[k]);
        a->centre[k] = cut_centre(&c, k, path);
    }
    for (int e = 0; e < 6; e++) {
        snprintf(path, sizeof path, "%s.inertia.%s", name, element[e]);
        a->inertia[e] = cut_inertia(&c, e, path);
    }
}

static void cut_body(mech__reader *rd, int index)
{
    const mech_body *part = &rd->m->bodies[index];
    mech_body *whole = &rd->m->bodies[part->parent];
    char name[MECH_PATH];

    if (!(whole->mass.value > part->mass.value)) {
        mech__problem_at(rd, rd->body_node[index],
                         "the mass of %s is not larger than the mass of its part %s", whole->name,
                         part->name);
        return;
    }
    snprintf(name, sizeof name, "%s.rest", whole->name);
    mech__combine(rd, whole, part, 1, rd->body_node[index], name);
}

/* --- places --- */

void mech__shift(mech__reader *rd, mech_scalar *to, mech_scalar by, int s, const mech__slot *slot,
                 const char *why)
{
    char name[MECH_PATH], text[MECH_PATH];
    builder *b = by.kind == MECH_ZERO ? NULL : mech__alloc(rd, sizeof *b);

    if (!b || slot->state != MECH__DONE) {
        return;
    }
    begin(b);
    put_two(b, rd->m, *to, by, s < 0 ? MECH_OP_SUB : MECH_OP_ADD);
    mech__name_copy(name, sizeof name, slot->path);
    snprintf(text, sizeof text, "%.60s %s", slot->path, why);
    *to = finish(rd, b, slot->node, name, text);
}

void mech__parts(mech__reader *rd)
{
    for (int i = 0; !rd->nomem && i < rd->m->nbody; i++) {
        const mech_body *body = &rd->m->bodies[i];

        if (body->part && !rd->m->bodies[body->parent].part && !mech__failed(rd, body->name) &&
            !mech__failed(rd, rd->m->bodies[body->parent].name)) {
            cut_body(rd, i);
        }
    }
    for (const mech__slot *s = rd->slots; !rd->nomem && s; s = s->next) {
        if (s->less) {
            mech__shift(rd, s->to, *s->less, -1, s, "from the part's joint");
        }
    }
}
