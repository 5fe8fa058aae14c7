/* SPDX-License-Identifier: MIT
 * expr.c - hash-consed expression graphs (see expr.h).
 *
 * Why folding at construction: a recursion that is written once for the general 3-D case meets
 * structural zeros, ones and signs at every step. Removing them as nodes are made keeps the graph
 * as small as the mechanism allows. Rejected: a computer algebra system's expand-and-collect, whose
 * cost explodes with the number of joints (SymPy needs minutes at six joints).
 */
#include "expr.h"

#include "functions.h"

#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- storage -------------------------------------------------------------------------------- */

static uint64_t bits_of(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static unsigned hash_key(ex_op op, int a, int b, double value)
{
    uint64_t h = ((uint64_t)op << 32 | (unsigned)a) * 0x9e3779b97f4a7c15u +
                 ((unsigned)b ^ bits_of(value)) * 0xc2b2ae3d27d4eb4fu;
    return (unsigned)((h ^ h >> 29) >> 7);
}

static int grow_nodes(ex_graph *g)
{
    int cap = g->cap * 2;
    ex_node *node = realloc(g->node, (size_t)cap * sizeof *node);
    if (!node) {
        return -1;
    }
    g->node = node;
    g->cap = cap;
    int *bucket = realloc(g->bucket, (size_t)(2 * cap) * sizeof *bucket);
    if (!bucket) {
        return -1;
    }
    g->bucket = bucket;
    g->nbucket = 2 * cap;
    memset(bucket, -1, (size_t)g->nbucket * sizeof *bucket);
    for (int i = 0; i < g->n; i++) {
        const ex_node *nd = &g->node[i];
        unsigned slot = hash_key(nd->op, nd->a, nd->b, nd->value) & (unsigned)(g->nbucket - 1);
        g->node[i].next = bucket[slot];
        bucket[slot] = i;
    }
    return 0;
}

/** The one node with this content, made when absent. */
static ex intern(ex_graph *g, ex_op op, int a, int b, double value)
{
    if (g->failed || (g->n == g->cap && grow_nodes(g))) {
        g->failed = 1;
        return 0;
    }
    unsigned slot = hash_key(op, a, b, value) & (unsigned)(g->nbucket - 1);
    for (int i = g->bucket[slot]; i >= 0; i = g->node[i].next) {
        const ex_node *nd = &g->node[i];
        if (nd->op == op && nd->a == a && nd->b == b && bits_of(nd->value) == bits_of(value)) {
            return i;
        }
    }
    ex_node *nd = &g->node[g->n];
    *nd = (ex_node){.op = op,
                    .a = a,
                    .b = b,
                    .value = value,
                    .pass = g->pass,
                    .body = g->body,
                    .next = g->bucket[slot]};
    g->bucket[slot] = g->n;
    return g->n++;
}

int ex_graph_init(ex_graph *g, ex_graph *setup)
{
    *g = (ex_graph){.setup = setup, .cap = 1024, .nbucket = 2048}; /* an action's functions fit */
    g->node = malloc((size_t)g->cap * sizeof *g->node);
    g->bucket = malloc((size_t)g->nbucket * sizeof *g->bucket);
    if (!g->node || !g->bucket) {
        ex_graph_free(g);
        return -1;
    }
    memset(g->bucket, -1, (size_t)g->nbucket * sizeof *g->bucket);
    (void)ex_num(g, 0.0);
    return 0;
}

void ex_graph_free(ex_graph *g)
{
    free(g->node);
    free(g->bucket);
    *g = (ex_graph){.failed = 1};
}

/* ---- leaves --------------------------------------------------------------------------------- */

ex ex_num(ex_graph *g, double value)
{
    if (g->setup) {
        return ex_const(g, ex_num(g->setup, value));
    }
    if (value < 0.0) {
        return ex_neg(g, ex_num(g, -value));
    }
    return intern(g, EX_NUM, 0, 0, value == 0.0 ? 0.0 : value);
}

ex ex_var(ex_graph *g, ex_var_kind kind, int index)
{
    return intern(g, EX_VAR, (int)kind, index, 0.0);
}

ex ex_const(ex_graph *g, ex k)
{
    if (g->setup->failed || g->failed) {
        g->failed = 1;
        return 0;
    }
    if (g->setup->node[k].op == EX_NEG) {
        return ex_neg(g, intern(g, EX_CONST, g->setup->node[k].a, 0, 0.0));
    }
    return intern(g, EX_CONST, k, 0, 0.0);
}

int ex_is_num(const ex_graph *g, ex a, double *value)
{
    double sign = 1.0;
    if (g->node[a].op == EX_NEG) {
        sign = -1.0;
        a = g->node[a].a;
    }
    if (g->node[a].op == EX_CONST && g->setup != NULL) {
        a = g->node[a].a;
        g = g->setup;
    }
    if (g->node[a].op != EX_NUM) {
        return 0;
    }
    *value = sign * g->node[a].value;
    return 1;
}

static int is_value(const ex_graph *g, ex a, double wanted)
{
    double v;
    return ex_is_num(g, a, &v) && v == wanted;
}

/** Parameter-only value of a function graph, possibly negated: its setup node goes to *k. */
static int is_const(ex_graph *g, ex a, ex *k)
{
    int negative = g->node[a].op == EX_NEG;
    if (negative) {
        a = g->node[a].a;
    }
    if (!g->setup || g->node[a].op != EX_CONST) {
        return 0;
    }
    *k = negative ? ex_neg(g->setup, g->node[a].a) : g->node[a].a;
    return 1;
}

/* ---- operations ----------------------------------------------------------------------------- */

static int is_neg(const ex_graph *g, ex a)
{
    return g->node[a].op == EX_NEG;
}

ex ex_neg(ex_graph *g, ex a)
{
    if (a == 0) {
        return 0;
    }
    return is_neg(g, a) ? g->node[a].a : intern(g, EX_NEG, a, 0, 0.0);
}

/** a = coefficient * rest with a parameter-only coefficient; 1 * a when it has none. */
static ex coefficient(ex_graph *g, ex a, ex *rest)
{
    const ex_node *nd = &g->node[a];
    ex_op leaf = g->setup ? EX_CONST : EX_NUM;
    if (nd->op == EX_MUL && g->node[nd->a].op == leaf) {
        *rest = nd->b;
        return nd->a;
    }
    *rest = a;
    return ex_num(g, 1.0);
}

/** k1 x + k2 x = (k1 + k2) x for parameter-only (setup graph: numeric) k; -1 when not of that form.
 *  x + x stays: an addition is as good as a product. */
static ex like_terms(ex_graph *g, ex a, ex b, int minus)
{
    ex ra, rb;
    ex ka = coefficient(g, a, &ra), kb = coefficient(g, b, &rb);
    if (ra != rb || a == b) {
        return -1;
    }
    return ex_mul(g, minus ? ex_sub(g, ka, kb) : ex_add(g, ka, kb), ra);
}

/** a and b both numbers of the setup graph, or both constants of a function graph. */
static int fold(ex_graph *g, ex_op op, ex a, ex b, ex *result)
{
    if (!g->setup) {
        double va, vb;
        if (!ex_is_num(g, a, &va) || !ex_is_num(g, b, &vb)) {
            return 0;
        }
        double v = op == EX_ADD   ? va + vb
                   : op == EX_SUB ? va - vb
                   : op == EX_MUL ? va * vb
                                  : va / vb;
        if (!isfinite(v)) {
            return 0;
        }
        *result = ex_num(g, v);
        return 1;
    }
    ex ka, kb;
    if (!is_const(g, a, &ka) || !is_const(g, b, &kb)) {
        return 0;
    }
    ex k = op == EX_ADD   ? ex_add(g->setup, ka, kb)
           : op == EX_SUB ? ex_sub(g->setup, ka, kb)
           : op == EX_MUL ? ex_mul(g->setup, ka, kb)
                          : ex_div(g->setup, ka, kb);
    *result = ex_const(g, k);
    return 1;
}

ex ex_add(ex_graph *g, ex a, ex b)
{
    ex r;
    if (a == 0 || b == 0) {
        return a == 0 ? b : a;
    }
    if (fold(g, EX_ADD, a, b, &r)) {
        return r;
    }
    if (is_neg(g, a) && is_neg(g, b)) {
        return ex_neg(g, ex_add(g, g->node[a].a, g->node[b].a));
    }
    if (is_neg(g, b)) {
        return ex_sub(g, a, g->node[b].a);
    }
    if (is_neg(g, a)) {
        return ex_sub(g, b, g->node[a].a);
    }
    r = like_terms(g, a, b, 0);
    if (r >= 0) {
        return r;
    }
    return a < b ? intern(g, EX_ADD, a, b, 0.0) : intern(g, EX_ADD, b, a, 0.0);
}

ex ex_sub(ex_graph *g, ex a, ex b)
{
    ex r;
    if (a == b) {
        return 0;
    }
    if (a == 0 || b == 0) {
        return a == 0 ? ex_neg(g, b) : a;
    }
    if (fold(g, EX_SUB, a, b, &r)) {
        return r;
    }
    if (is_neg(g, b)) {
        return ex_add(g, a, g->node[b].a);
    }
    if (is_neg(g, a)) {
        return ex_neg(g, ex_add(g, g->node[a].a, b));
    }
    r = like_terms(g, a, b, 1);
    if (r >= 0) {
        return r;
    }
    if (g->setup && a > b) { /* one order only: b - a and a - b are the same work */
        return ex_neg(g, intern(g, EX_SUB, b, a, 0.0));
    }
    return intern(g, EX_SUB, a, b, 0.0);
}

ex ex_mul(ex_graph *g, ex a, ex b)
{
    ex r, k, rest;
    if (a == 0 || b == 0) {
        return 0;
    }
    if (is_value(g, a, 1.0) || is_value(g, b, 1.0)) {
        return is_value(g, a, 1.0) ? b : a;
    }
    if (is_neg(g, a) || is_neg(g, b)) {
        int minus = is_neg(g, a) != is_neg(g, b);
        r = ex_mul(g, is_neg(g, a) ? g->node[a].a : a, is_neg(g, b) ? g->node[b].a : b);
        return minus ? ex_neg(g, r) : r;
    }
    if (fold(g, EX_MUL, a, b, &r)) {
        return r;
    }
    ex_op leaf = g->setup ? EX_CONST : EX_NUM;
    if (g->node[b].op == leaf || (g->node[a].op != leaf && a > b)) {
        ex t = a;
        a = b;
        b = t;
    }
    if (g->node[a].op == leaf) { /* k1 (k2 x) = (k1 k2) x */
        k = coefficient(g, b, &rest);
        if (rest != b) {
            return ex_mul(g, ex_mul(g, a, k), rest);
        }
    }
    return intern(g, EX_MUL, a, b, 0.0);
}

ex ex_dot2(ex_graph *g, ex a, ex b, ex c, ex d)
{
    ex second = ex_mul(g, c, d), first = ex_mul(g, a, b);
    return ex_add(g, first, second);
}

ex ex_det2(ex_graph *g, ex a, ex b, ex c, ex d)
{
    ex second = ex_mul(g, c, d), first = ex_mul(g, a, b);
    return ex_sub(g, first, second);
}

ex ex_div(ex_graph *g, ex a, ex b)
{
    ex r;
    if (a == 0 || is_value(g, b, 1.0)) {
        return a;
    }
    if (is_neg(g, a) || is_neg(g, b)) {
        int minus = is_neg(g, a) != is_neg(g, b);
        r = ex_div(g, is_neg(g, a) ? g->node[a].a : a, is_neg(g, b) ? g->node[b].a : b);
        return minus ? ex_neg(g, r) : r;
    }
    if (fold(g, EX_DIV, a, b, &r)) {
        return r;
    }
    return intern(g, EX_DIV, a, b, 0.0);
}

ex ex_fun(ex_graph *g, ex_op op, ex a)
{
    ex k;
    if (g->setup && is_const(g, a, &k)) {
        return ex_const(g, ex_fun(g->setup, op, k));
    }
    if (a == 0) {
        return op == EX_COS ? ex_num(g, 1.0) : 0;
    }
    if (is_neg(g, a) && op != EX_SQRT) {
        ex r = ex_fun(g, op, g->node[a].a);
        return op == EX_COS ? r : ex_neg(g, r);
    }
    return intern(g, op, a, 0, 0.0);
}

void ex_name(ex_graph *g, ex a, const char *format, ...)
{
    if (g->nameless) {
        return;
    }
    if (is_neg(g, a)) {
        a = g->node[a].a;
    }
    ex_node *nd = &g->node[a];
    if (nd->op <= EX_CONST || nd->name[0]) {
        return;
    }
    va_list ap;
    va_start(ap, format);
    vsnprintf(nd->name, sizeof nd->name, format, ap);
    va_end(ap);
}

/* ---- analysis ------------------------------------------------------------------------------- */

static int operands(const ex_node *nd)
{
    return nd->op <= EX_CONST ? 0 : nd->op <= EX_DIV ? 2 : 1;
}

void ex_reach(const ex_graph *g, const ex *outputs, int noutput, int *uses)
{
    memset(uses, 0, (size_t)g->n * sizeof *uses);
    for (int i = 0; i < noutput; i++) {
        uses[outputs[i]]++;
    }
    for (int i = g->n - 1; i > 0; i--) { /* operands precede their results */
        if (uses[i] && operands(&g->node[i]) > 0) {
            uses[g->node[i].a]++;
        }
        if (uses[i] && operands(&g->node[i]) > 1) {
            uses[g->node[i].b]++;
        }
    }
}

static int times_output(ex a, const ex *outputs, int noutput)
{
    int times = 0;
    for (int i = 0; i < noutput; i++) {
        times += outputs[i] == a;
    }
    return times;
}

int ex_count(const ex_graph *g, const ex *outputs, int noutput, stein_ops *count)
{
    stein_ops ops = {0, 0, 0, 0, 0};
    int *uses = malloc((size_t)g->n * sizeof *uses);
    if (!uses) {
        return -1;
    }
    ex_reach(g, outputs, noutput, uses);
    for (int i = 0; i < g->n; i++) {
        if (!uses[i]) {
            continue;
        }
        ex_op op = g->node[i].op;
        ops.add += op == EX_ADD || op == EX_SUB;
        ops.mul += op == EX_MUL;
        ops.div += op == EX_DIV || op == EX_SQRT;
        ops.trig += op == EX_SIN || op == EX_COS || op == EX_TAN;
        ops.neg += op == EX_NEG && uses[i] > times_output(i, outputs, noutput);
    }
    free(uses);
    *count = ops;
    return 0;
}

void ex_eval(const ex_graph *g, const double *const var[EX_NVAR], const double *constants,
             double *values)
{
    for (int i = 0; i < g->n; i++) {
        const ex_node *nd = &g->node[i];
        const double a = operands(nd) > 0 ? values[nd->a] : 0.0;
        const double b = operands(nd) > 1 ? values[nd->b] : 0.0;
        switch (nd->op) {
        case EX_NUM: values[i] = nd->value; break;
        case EX_VAR: values[i] = var[nd->a] ? var[nd->a][nd->b] : 0.0; break;
        case EX_CONST: values[i] = constants[nd->a]; break;
        case EX_ADD: values[i] = a + b; break;
        case EX_SUB: values[i] = a - b; break;
        case EX_MUL: values[i] = a * b; break;
        case EX_DIV: values[i] = a / b; break;
        case EX_NEG: values[i] = -a; break;
        case EX_SIN: values[i] = stein__sin(a); break;
        case EX_COS: values[i] = stein__cos(a); break;
        case EX_TAN: values[i] = stein__tan(a); break;
        case EX_SQRT: values[i] = sqrt(a); break;
        }
    }
}
