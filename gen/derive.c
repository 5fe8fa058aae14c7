/* SPDX-License-Identifier: MIT
 * derive.c - derivatives of a function, in its own graph: forward mode, node by node.
 *
 *      (a + b)' = a' + b'          (a b)' = a' b + a b'        (a / b)' = (a' - (a / b) b') / b
 *      (sin a)' = cos a a'         (cos a)' = - sin a a'       (sqrt a)' = a' / (2 sqrt a)
 *
 * One sweep per known: a' is 1 for the argument itself and 0 for every other leaf, so independent
 * terms are 0 and leave no node. Everything is shared with the function and with the other sweeps.
 * Even the derivative of the sine of a sum of angles is found to be the cosine of that sum, made of
 * the same four products.
 *
 * Along a direction (dq, dqd, dd, or dp for the setup) there is a single sweep, with the numbers of
 * the direction as leaves.
 *
 * Rejected: reverse mode. It needs one sweep per result instead of one per argument, of which there
 * are twice as many. But it reverses the order of the recursion, and with it all names.
 */
#include <stdlib.h>
#include <string.h>

#include "gen_internal.h"

/** The variable of a sweep: one q or qd, or all numbers of a direction. */
typedef struct known {
    ex_var_kind kind; /* EX_Q, EX_QD; EX_DP along a direction of parameters, EX_DQ of all else */
    int index;
} known;

static ex of_variable(ex_graph *g, const ex_node *nd, const known *by)
{
    static const ex_var_kind direction[EX_NVAR] = {
        [EX_P] = EX_DP, [EX_Q] = EX_DQ, [EX_QD] = EX_DQD};
    ex_var_kind kind = (ex_var_kind)nd->a;
    if (by->kind == EX_Q || by->kind == EX_QD) {
        return kind == by->kind && nd->b == by->index ? ex_num(g, 1.0) : 0;
    }
    return direction[kind] != EX_P ? ex_var(g, direction[kind], nd->b) : 0;
}

static ex of_constant(ex_graph *g, ex setup_node, const known *by)
{
    int moves = by->kind == EX_DQ && g->setup->node[setup_node].op != EX_NUM;
    return moves ? ex_var(g, EX_DD, setup_node) : 0;
}

static ex of_quotient(ex_graph *g, ex e, ex b, ex da, ex db)
{
    return ex_div(g, ex_sub(g, da, ex_mul(g, e, db)), b);
}

/** e' from the derivatives of its operands. */
static ex of_node(ex_graph *g, ex e, const ex *slope, const known *by)
{
    const ex_node nd = g->node[e];
    int leaf = nd.op <= EX_CONST;
    ex a = leaf ? 0 : nd.a, b = nd.b, da = leaf ? 0 : slope[a];
    ex db = nd.op >= EX_ADD && nd.op <= EX_DIV ? slope[b] : 0;
    if (!leaf && da == 0 && db == 0) {
        return 0;
    }
    switch (nd.op) {
    case EX_NUM: return 0;
    case EX_VAR: return of_variable(g, &nd, by);
    case EX_CONST: return of_constant(g, nd.a, by);
    case EX_ADD: return ex_add(g, da, db);
    case EX_SUB: return ex_sub(g, da, db);
    case EX_MUL: return ex_dot2(g, da, b, a, db);
    case EX_DIV: return of_quotient(g, e, b, da, db);
    case EX_NEG: return ex_neg(g, da);
    case EX_SIN: return ex_mul(g, ex_fun(g, EX_COS, a), da);
    case EX_COS: return ex_neg(g, ex_mul(g, ex_fun(g, EX_SIN, a), da));
    case EX_TAN: return ex_add(g, da, ex_mul(g, ex_mul(g, e, e), da));
    case EX_SQRT: return ex_div(g, da, ex_add(g, e, e));
    }
    return 0;
}

/** A named quantity gives its derivative a name: CF21_q1, CF21_qd1; along a direction dCF21. */
static void name_slope(ex_graph *g, ex e, ex slope, const known *by)
{
    char name[EX_NAME];
    memcpy(name, g->node[e].name, sizeof name);
    if (!name[0] || g->failed) {
        return;
    }
    if (by->kind == EX_Q || by->kind == EX_QD) {
        ex_name(g, slope, "%.16s_%s%d", name, by->kind == EX_Q ? "q" : "qd", by->index + 1);
    } else {
        ex_name(g, slope, "d%.20s", name);
    }
}

/** One sweep over the first n nodes, those that are used. */
static void sweep(ex_graph *g, int n, const int *uses, ex *slope, const known *by)
{
    for (int e = 0; e < n && !g->failed; e++) {
        slope[e] = uses[e] ? of_node(g, e, slope, by) : 0;
        if (slope[e] != 0 && g->node[e].op > EX_CONST) {
            name_slope(g, e, slope[e], by);
        }
    }
}

typedef struct sweeper {
    int n, *uses;
    ex *slope;
} sweeper;

static int sweeper_init(sweeper *s, ex_graph *g, const ex *out, int nout)
{
    s->n = g->n;
    s->uses = malloc((size_t)g->n * sizeof *s->uses);
    s->slope = calloc((size_t)g->n, sizeof *s->slope);
    g->failed |= !s->uses || !s->slope;
    if (!g->failed) {
        ex_reach(g, out, nout, s->uses);
    }
    return !g->failed;
}

static void sweeper_free(sweeper *s)
{
    free(s->uses);
    free(s->slope);
}

void derive_by_state(ex_graph *g, const ex *out, int nout, int nq, ex *slopes)
{
    sweeper s;
    if (sweeper_init(&s, g, out, nout)) {
        for (int k = 0; k < 2 * nq; k++) {
            known by = {k < nq ? EX_Q : EX_QD, k % nq};
            g->pass = k < nq ? PASS_BY_Q : PASS_BY_QD;
            g->body = by.index;
            sweep(g, s.n, s.uses, s.slope, &by);
            for (int i = 0; i < nout; i++) {
                slopes[(k / nq * nout + i) * nq + by.index] = s.slope[out[i]];
            }
        }
    }
    sweeper_free(&s);
}

void derive_along(ex_graph *g, const ex *out, int nout, ex *slopes)
{
    sweeper s;
    known by = {g->setup ? EX_DQ : EX_DP, 0};
    if (sweeper_init(&s, g, out, nout)) {
        g->pass = PASS_ALONG;
        g->body = -1;
        sweep(g, s.n, s.uses, s.slope, &by);
        for (int i = 0; i < nout; i++) {
            slopes[i] = s.slope[out[i]];
        }
    }
    sweeper_free(&s);
}

/* ---- builders ------------------------------------------------------------------------------- */

/** n values of a builder, without external forces, to be derived; NULL without memory. */
static ex *values(walk *w, builder *build, int n)
{
    ex *out = calloc((size_t)n + 1, sizeof *out);
    w->g->failed |= !out;
    w->unloaded = 1;
    if (out) {
        build(w, out);
    }
    return out;
}

void slope_inverse(walk *w, ex *out)
{
    ex *Q = values(w, dyn_inverse, w->t->n);
    if (Q) {
        derive_by_state(w->g, Q, w->t->n, w->t->n, out);
    }
    free(Q);
}

void along_inverse(walk *w, ex *out)
{
    ex *Q = values(w, dyn_inverse, w->t->n);
    if (Q) {
        derive_along(w->g, Q, w->t->n, out);
    }
    free(Q);
}

void along_pose(walk *w, ex *out)
{
    int n = 7 * w->t->ncarrier;
    ex *pose = values(w, kin_pose, n);
    if (pose) {
        derive_along(w->g, pose, n, out);
    }
    free(pose);
}
