/* SPDX-License-Identifier: MIT
 * loops.c - conditions of closed loops and couplings on the coordinates: h(q) = 0 with J = dh/dq
 * and Jdot qd.
 *
 * Everything of a loop is written in the axes of the body that carries both of its branches. The
 * joints below that body do not move the two points against each other, so their columns of J are
 * exactly 0, not expressions with the value 0. With d from the first point A to the second one B,
 * e_k the axes of A's body and f_k the axes of B's:
 *
 *      meet    d = 0                          rod     (d.d - L^2) / 2 L = 0
 *      slot k  e_i.d = 0 for i other than k   weld    d = 0 and e_i.f_j = 0 (three pairs)
 *                                             hinge k d = 0 and e_k.f_i = 0 for i other than k
 *      coupling  q_b - ratio q_a - offset = 0
 *
 * Each condition is a sum of scalar products u.v; kin.c gives the derivatives of both vectors:
 *      (u.v)'' = u''.v + 2 u'.v' + u.v''
 * A row that is 0 for every q is left out: of a planar mechanism that is one of d and two of the
 * angles.
 */
#include <stdlib.h>

#include "tree.h"

/** A vector, its rate, its acceleration while qdd = 0, and its derivative by every q. */
typedef struct moving {
    vec at, rate, bias, *by_q;
} moving;

/** A row of h: itself, Jdot qd, then J. */
enum { ROW_H, ROW_BIAS, ROW_J };

typedef struct closer {
    walk *w;
    ex_graph *g;
    const mech_loop *l;
    int n, top;     /* joints; the body both branches hang on, -1 the fixed frame */
    int body[2];    /* of the two points */
    placed *all;    /* [n] in the axes of `top` */
    vec *store;     /* [3*n] */
    moving d, e, f; /* from A to B; an axis of A's body, of B's */
    ex *row;        /* [LOOP_ROWS][2 + n] */
} closer;

static int parent_of(const closer *c, int body)
{
    return c->w->t->body[body].parent;
}

static int common_body(const tree *t, int a, int b)
{
    while (a != b) {
        if (a > b) {
            a = t->body[a].parent;
        } else {
            b = t->body[b].parent;
        }
    }
    return a;
}

static ex *row_of(const closer *c, int i)
{
    return c->row + i * (ROW_J + c->n);
}

/* ---- vectors -------------------------------------------------------------------------------- */

/** Add a point of a body, times sign, to a vector. */
static void add_point(closer *c, moving *d, int point, int sign)
{
    ex_graph *g = c->g;
    const tree *t = c->w->t;
    int i = t->m->points[point].body, to = c->top < 0 ? -1 : t->body[c->top].orient;
    vec r = vec_const(g, tree_vector(t, t->m->points[point].at)), x = r, v = vec_zero(), b = v;
    if (i != c->top) {
        r = rotate(c->w, r, t->body[i].orient, to);
        x = vec_add(g, c->all[i].o, r);
        v = vec_add(g, c->all[i].v, vec_cross(g, c->all[i].om, r));
        b = vec_add(g, c->all[i].a, kin_bend(g, c->all[i].om, c->all[i].omp, r));
    }
    d->at = sign > 0 ? vec_add(g, d->at, x) : vec_sub(g, d->at, x);
    d->rate = sign > 0 ? vec_add(g, d->rate, v) : vec_sub(g, d->rate, v);
    d->bias = sign > 0 ? vec_add(g, d->bias, b) : vec_sub(g, d->bias, b);
    for (int j = i; j != c->top; j = parent_of(c, j)) {
        vec column = t->body[j].turns ? vec_cross(g, c->all[j].axis, r) : c->all[j].axis;
        d->by_q[j] = sign > 0 ? vec_add(g, d->by_q[j], column) : vec_sub(g, d->by_q[j], column);
        r = vec_add(g, r, c->all[j].arm);
    }
}

/** An axis of the body of side 0 or 1. */
static void set_axis(closer *c, moving *e, int side, int axis)
{
    ex_graph *g = c->g;
    const tree *t = c->w->t;
    int i = c->body[side], to = c->top < 0 ? -1 : t->body[c->top].orient;
    vec *by_q = e->by_q;
    *e = (moving){.at = vec_axis(axis, ex_num(g, 1.0)), .by_q = by_q};
    for (int j = 0; j < c->n; j++) {
        by_q[j] = vec_zero();
    }
    if (i == c->top) {
        return;
    }
    e->at = rotate(c->w, e->at, t->body[i].orient, to);
    e->rate = vec_cross(g, c->all[i].om, e->at);
    e->bias = kin_bend(g, c->all[i].om, c->all[i].omp, e->at);
    for (int j = i; j != c->top; j = parent_of(c, j)) {
        if (t->body[j].turns) {
            by_q[j] = vec_cross(g, c->all[j].axis, e->at);
        }
    }
}

/** u.v as row i. */
static void put_product(closer *c, int i, const moving *u, const moving *v)
{
    ex_graph *g = c->g;
    ex *row = row_of(c, i), half = vec_dot(g, u->rate, v->rate);
    ex first = vec_dot(g, u->bias, v->at), second = vec_dot(g, u->at, v->bias);
    row[ROW_H] = vec_dot(g, u->at, v->at);
    row[ROW_BIAS] = ex_add(g, ex_add(g, first, second), ex_add(g, half, half));
    for (int j = 0; j < c->n; j++) {
        ex left = vec_dot(g, u->by_q[j], v->at), right = vec_dot(g, u->at, v->by_q[j]);
        row[ROW_J + j] = ex_add(g, left, right);
    }
}

/* ---- kinds ---------------------------------------------------------------------------------- */

static void close_meet(closer *c)
{
    for (int i = 0; i < 3; i++) {
        ex *row = row_of(c, i);
        row[ROW_H] = c->d.at.x[i];
        row[ROW_BIAS] = c->d.bias.x[i];
        for (int j = 0; j < c->n; j++) {
            row[ROW_J + j] = c->d.by_q[j].x[i];
        }
    }
}

/** (d.d - L^2) / 2 L: half of the product of d with itself, over L */
static void close_rod(closer *c)
{
    ex_graph *g = c->g, *setup = c->w->t->setup;
    ex length = tree_scalar(c->w->t, c->l->length);
    ex share = ex_const(g, ex_div(setup, ex_num(setup, 0.5), length));
    ex half = ex_const(g, ex_mul(setup, ex_num(setup, 0.5), length));
    ex *row = row_of(c, 0);
    put_product(c, 0, &c->d, &c->d);
    for (int j = 0; j < ROW_J + c->n; j++) {
        row[j] = ex_mul(g, share, row[j]);
    }
    row[ROW_H] = ex_sub(g, row[ROW_H], half);
}

static void close_slot(closer *c)
{
    for (int i = 0, axis = 0; axis < 3; axis++) {
        if (axis != c->l->axis) {
            set_axis(c, &c->e, 0, axis);
            put_product(c, i++, &c->e, &c->d);
        }
    }
}

static void close_weld(closer *c)
{
    int free_axis = c->l->axis;
    close_meet(c);
    for (int i = 0; i < (free_axis < 0 ? 3 : 2); i++) {
        int first = free_axis < 0 ? (i + 1) % 3 : free_axis;
        int second = free_axis < 0 ? (i + 2) % 3 : (free_axis + 1 + i) % 3;
        set_axis(c, &c->e, 0, first);
        set_axis(c, &c->f, 1, second);
        put_product(c, 3 + i, &c->e, &c->f);
    }
}

static void close_coupling(closer *c)
{
    ex_graph *g = c->g;
    const tree *t = c->w->t;
    int b = c->l->index[0], a = c->l->index[1];
    ex ratio = ex_const(g, tree_scalar(t, c->l->ratio));
    ex offset = ex_const(g, tree_scalar(t, c->l->offset)), *row = row_of(c, 0);
    ex follows = ex_add(g, ex_mul(g, ratio, ex_var(g, EX_Q, a)), offset);
    row[ROW_H] = ex_sub(g, ex_var(g, EX_Q, b), follows);
    row[ROW_J + b] = ex_num(g, 1.0);
    row[ROW_J + a] = ex_neg(g, ratio);
}

static void close_loop(closer *c)
{
    const tree *t = c->w->t;
    for (int side = 0; side < 2; side++) {
        c->body[side] = t->m->points[c->l->index[side]].body;
    }
    c->top = common_body(t, c->body[0], c->body[1]);
    for (int i = c->top + 1; i < c->n; i++) {
        int on = common_body(t, i, c->body[0]) == i || common_body(t, i, c->body[1]) == i;
        if (on) {
            kin_place(c->w, c->all, i, c->top);
        }
    }
    vec *by_q = c->store;
    c->d = (moving){.by_q = by_q};
    c->e = (moving){.by_q = by_q + c->n};
    c->f = (moving){.by_q = by_q + 2 * (ptrdiff_t)c->n};
    for (int j = 0; j < c->n; j++) {
        by_q[j] = vec_zero();
    }
    c->g->pass = PASS_LOOP;
    c->g->body = (int)(c->l - t->m->loops);
    add_point(c, &c->d, c->l->index[1], 1);
    add_point(c, &c->d, c->l->index[0], -1);
    switch (c->l->kind) {
    case MECH_ROD: close_rod(c); break;
    case MECH_SLOT: close_slot(c); break;
    case MECH_WELD: close_weld(c); break;
    default: close_meet(c);
    }
}

/** All rows of all loops, [nloop][LOOP_ROWS][2 + n], to be freed; NULL without memory. */
static ex *all_rows(walk *w)
{
    const mechanism *m = w->t->m;
    size_t n = (size_t)w->t->n, size = LOOP_ROWS * (ROW_J + n);
    ex *rows = calloc((size_t)m->nloop * size + 1, sizeof *rows);
    closer c = {.w = w, .g = w->g, .n = w->t->n};
    c.all = calloc(n, sizeof *c.all);
    c.store = calloc(3 * n, sizeof *c.store);
    int complete = rows && c.all && c.store;
    w->g->failed |= !complete;
    for (int i = 0; complete && i < m->nloop; i++) {
        c.l = &m->loops[i];
        c.row = rows + (size_t)i * size;
        w->g->pass = PASS_LOOP;
        w->g->body = i;
        if (c.l->kind == MECH_COUPLING) {
            close_coupling(&c);
        } else {
            close_loop(&c);
        }
    }
    free(c.all);
    free(c.store);
    return rows;
}

/* ---- rows ----------------------------------------------------------------------------------- */

int loop_rows(tree *t)
{
    ex_graph g;
    int n = LOOP_ROWS * t->m->nloop, size = ROW_J + t->n;
    if (n == 0) {
        return 0;
    }
    t->row = calloc((size_t)n, sizeof *t->row);
    if (!t->row || ex_graph_init(&g, t->setup)) {
        return -1;
    }
    walk w = {.t = t, .g = &g};
    ex *rows = all_rows(&w);
    for (int i = 0; rows && i < n; i++) {
        int says = 0;
        for (int k = 0; k < size; k++) {
            says |= rows[(ptrdiff_t)i * size + k] != 0;
        }
        if (says) {
            t->row[t->nrow++] = i;
        }
    }
    int failed = !rows || g.failed;
    free(rows);
    ex_graph_free(&g);
    return failed ? -1 : 0;
}

void loop_units(const tree *t, int i, int *lengths, int *angles)
{
    const mech_loop *l = &t->m->loops[i];
    int turns = l->kind == MECH_COUPLING && t->m->bodies[l->index[0]].type == 'R';
    *lengths = *angles = 0;
    for (int k = 0; k < t->nrow; k++) {
        int row = t->row[k] % LOOP_ROWS;
        if (t->row[k] / LOOP_ROWS == i) {
            int angle = turns || (l->kind == MECH_WELD && row >= 3);
            *lengths += !angle;
            *angles += angle;
        }
    }
}

void loop_closure(walk *w, ex *out)
{
    const tree *t = w->t;
    int n = t->n, size = ROW_J + n;
    ex *rows = all_rows(w);
    for (int k = 0; rows && k < t->nrow; k++) {
        const ex *row = rows + (ptrdiff_t)t->row[k] * size;
        out[k] = row[ROW_H];
        out[t->nrow + t->nrow * n + k] = row[ROW_BIAS];
        for (int j = 0; j < n; j++) {
            out[t->nrow + k * n + j] = t->body[j].still ? 0 : row[ROW_J + j];
        }
    }
    free(rows);
}
