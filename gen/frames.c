/* SPDX-License-Identifier: MIT
 * frames.c - symbolic vectors and the turning of them from frame to frame.
 *
 * Consecutive revolute joints about parallel axes form a group. Its bodies differ by one turn
 * about one axis. So a vector is turned from any of them to any other, or to the body that
 * carries the group, by the sine and cosine of one sum of joint angles.
 * A prismatic joint does not turn anything.
 *
 * Turning up by the angle t about axis a, with b, c the axes that follow a cyclically:
 *      v'_a = v_a     v'_b = cos t v_b - sin t v_c     v'_c = sin t v_b + cos t v_c
 */
#include <stdio.h>
#include <string.h>

#include "tree.h"

/* ---- vectors -------------------------------------------------------------------------------- */

vec vec_zero(void)
{
    return (vec){{0, 0, 0}};
}

vec vec_const(ex_graph *g, vec k)
{
    return (vec){{ex_const(g, k.x[0]), ex_const(g, k.x[1]), ex_const(g, k.x[2])}};
}

vec vec_add(ex_graph *g, vec a, vec b)
{
    return (vec){{ex_add(g, a.x[0], b.x[0]), ex_add(g, a.x[1], b.x[1]), ex_add(g, a.x[2], b.x[2])}};
}

vec vec_sub(ex_graph *g, vec a, vec b)
{
    return (vec){{ex_sub(g, a.x[0], b.x[0]), ex_sub(g, a.x[1], b.x[1]), ex_sub(g, a.x[2], b.x[2])}};
}

vec vec_scale(ex_graph *g, ex k, vec a)
{
    return (vec){{ex_mul(g, k, a.x[0]), ex_mul(g, k, a.x[1]), ex_mul(g, k, a.x[2])}};
}

vec vec_cross(ex_graph *g, vec a, vec b)
{
    vec r;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        r.x[i] = ex_det2(g, a.x[j], b.x[k], a.x[k], b.x[j]);
    }
    return r;
}

ex vec_dot(ex_graph *g, vec a, vec b)
{
    ex r = ex_mul(g, a.x[0], b.x[0]);
    r = ex_add(g, r, ex_mul(g, a.x[1], b.x[1]));
    return ex_add(g, r, ex_mul(g, a.x[2], b.x[2]));
}

vec vec_axis(int axis, ex k)
{
    vec r = vec_zero();
    r.x[axis] = k;
    return r;
}

int vec_is_zero(vec a)
{
    return a.x[0] == 0 && a.x[1] == 0 && a.x[2] == 0;
}

void vec_name(ex_graph *g, vec a, const char *symbol, int body, int column)
{
    for (int i = 0; i < 3; i++) {
        if (column >= 0) {
            ex_name(g, a.x[i], "%s%d%d_%d", symbol, i + 1, body + 1, column + 1);
        } else {
            ex_name(g, a.x[i], "%s%d%d", symbol, i + 1, body + 1);
        }
    }
}

/* ---- symmetric matrices --------------------------------------------------------------------- */

static const int place[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};

ex *sym_entry(sym *a, int i, int j)
{
    return &a->x[place[i][j]];
}

sym sym_const(ex_graph *g, sym k)
{
    sym r;
    for (int i = 0; i < 6; i++) {
        r.x[i] = ex_const(g, k.x[i]);
    }
    return r;
}

void sym_cross(ex_graph *g, vec u, vec v, sym half[2])
{
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        half[0].x[i] = ex_dot2(g, u.x[j], v.x[j], u.x[k], v.x[k]);
        half[1].x[i] = half[0].x[i];
        half[0].x[place[j][k]] = ex_neg(g, ex_mul(g, u.x[j], v.x[k]));
        half[1].x[place[j][k]] = ex_neg(g, ex_mul(g, u.x[k], v.x[j]));
    }
}

sym sym_add_cross(ex_graph *g, sym a, vec u, vec v)
{
    sym half[2];
    sym_cross(g, u, v, half);
    return sym_add(g, sym_add(g, a, half[0]), half[1]);
}

sym sym_point(ex_graph *g, ex mass, vec v)
{
    vec mv = vec_scale(g, mass, v);
    sym r;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        r.x[i] = ex_dot2(g, mv.x[j], v.x[j], mv.x[k], v.x[k]);
        r.x[place[j][k]] = ex_neg(g, ex_mul(g, mv.x[j], v.x[k]));
    }
    return r;
}

sym sym_add(ex_graph *g, sym a, sym b)
{
    sym r;
    for (int i = 0; i < 6; i++) {
        r.x[i] = ex_add(g, a.x[i], b.x[i]);
    }
    return r;
}

vec sym_column(sym a, int axis)
{
    return (vec){{a.x[place[0][axis]], a.x[place[1][axis]], a.x[place[2][axis]]}};
}

vec sym_apply(ex_graph *g, sym a, vec v)
{
    vec r;
    for (int i = 0; i < 3; i++) {
        r.x[i] = vec_dot(g, sym_column(a, i), v);
    }
    return r;
}

/* ---- frames --------------------------------------------------------------------------------- */

static int parent_orient(const tree *t, int o)
{
    int p = t->body[o].parent;
    return p < 0 ? -1 : t->body[p].orient;
}

void walk_frames(walk *ps)
{
    const tree *t = ps->t;
    for (int i = 0; i < t->n; i++) {
        if (!t->body[i].turns) {
            int o = t->body[i].orient;
            ps->frame[i] = o < 0 ? -1 : ps->frame[o];
        } else {
            int how = ps->ch->frame[i];
            ps->frame[i] = how == 0 ? i : how == 1 ? t->body[i].base : parent_orient(t, i);
        }
    }
}

/** 1 when `o` lies on the way up from `from` with turns about one axis only in between. */
static int within_group(const tree *t, int from, int o)
{
    int base = t->body[from].base;
    for (int k = from; k != base; k = parent_orient(t, k)) {
        if (k == o) {
            return 1;
        }
    }
    return o == base;
}

int same_group(const tree *t, int a, int b, int axis)
{
    int deep = a > b ? a : b, high = a > b ? b : a;
    return a == b || (t->body[deep].axis == axis && within_group(t, deep, high));
}

/** "1p2m3": joints from the top down, with signs against the first one. */
static void angle_symbol(const tree *t, const int *joint, int n, char *text, size_t size)
{
    size_t used = (size_t)snprintf(text, size, "%d", joint[0] + 1);
    for (int i = 1; i < n && used < size; i++) {
        int same = t->body[joint[i]].sign == t->body[joint[0]].sign;
        used += (size_t)snprintf(text + used, size - used, "%c%d", same ? 'p' : 'm', joint[i] + 1);
    }
}

static void chain_trig(walk *ps, const int *joint, int n, ex *s, ex *c)
{
    ex_graph *g = ps->g;
    char text[EX_NAME];
    angle_symbol(ps->t, joint, n, text, sizeof text - 2);
    if (n > 1) {
        ex s1, c1, s2, c2;
        chain_trig(ps, joint, n - 1, &s1, &c1);
        chain_trig(ps, joint + n - 1, 1, &s2, &c2);
        *s = ex_dot2(g, s1, c2, c1, s2);
        *c = ex_det2(g, c1, c2, s1, s2);
    } else {
        ex q = ex_var(g, EX_Q, joint[0]);
        ex angle = ps->t->body[joint[0]].sign > 0 ? q : ex_neg(g, q);
        *s = ex_fun(g, EX_SIN, angle);
        *c = ex_fun(g, EX_COS, angle);
    }
    ex_name(g, *s, "S%.20s", text);
    ex_name(g, *c, "C%.20s", text);
}

void angle_trig(walk *ps, int o, int top, ex *s, ex *c)
{
    int joint[256] = {0}, n = 0, phase = ps->g->pass, body = ps->g->body;
    for (int k = o; k != top && n < 256; k = parent_orient(ps->t, k)) {
        joint[n++] = k;
    }
    for (int i = 0; i < n / 2; i++) {
        int swap = joint[i];
        joint[i] = joint[n - 1 - i];
        joint[n - 1 - i] = swap;
    }
    ps->g->pass = PASS_TRIG;
    ps->g->body = -1;
    chain_trig(ps, joint, n, s, c);
    ps->g->pass = phase;
    ps->g->body = body;
}

/* the axis of the one turn between two orientations; -1: on the way is *base, where another begins
 */
static int turn_between(const tree *t, int from, int to, int *base)
{
    int deep = from > to ? from : to, high = from > to ? to : from;
    *base = t->body[deep].base;
    return within_group(t, deep, high) ? t->body[deep].axis : -1;
}

/* its sine and cosine */
static void turn_trig(walk *ps, int from, int to, ex *sine, ex *cosine)
{
    int down = to > from;
    angle_trig(ps, down ? to : from, down ? from : to, sine, cosine);
    *sine = down ? ex_neg(ps->g, *sine) : *sine;
}

vec rotate(walk *ps, vec v, int from, int to)
{
    if (from == to || vec_is_zero(v)) {
        return v;
    }
    int base, a = turn_between(ps->t, from, to, &base);
    if (a < 0) {
        return rotate(ps, rotate(ps, v, from, base), base, to);
    }
    ex_graph *g = ps->g;
    int b = (a + 1) % 3, c = (a + 2) % 3;
    if (v.x[b] == 0 && v.x[c] == 0) {
        return v;
    }
    ex sine, cosine;
    turn_trig(ps, from, to, &sine, &cosine);
    vec r;
    r.x[a] = v.x[a];
    r.x[b] = ex_det2(g, cosine, v.x[b], sine, v.x[c]);
    r.x[c] = ex_dot2(g, sine, v.x[b], cosine, v.x[c]);
    return r;
}

/* with w = S (bb - cc) + 2 C bc:  bb' = bb - S w, cc' = cc + S w, bc' = C w - bc */
sym rotate_sym(walk *ps, sym k, int from, int to)
{
    if (from == to) {
        return k;
    }
    int base, a = turn_between(ps->t, from, to, &base);
    if (a < 0) {
        return rotate_sym(ps, rotate_sym(ps, k, from, base), base, to);
    }
    ex_graph *g = ps->g;
    int b = (a + 1) % 3, c = (a + 2) % 3;
    ex sine, cosine;
    turn_trig(ps, from, to, &sine, &cosine);
    ex bb = k.x[b], cc = k.x[c], bc = k.x[place[b][c]];
    ex ab = k.x[place[a][b]], ac = k.x[place[a][c]];
    ex twice = ex_mul(g, cosine, ex_add(g, bc, bc));
    ex w = ex_add(g, ex_mul(g, sine, ex_sub(g, bb, cc)), twice);
    ex sw = ex_mul(g, sine, w);
    sym r = k;
    r.x[b] = ex_sub(g, bb, sw);
    r.x[c] = ex_add(g, cc, sw);
    r.x[place[b][c]] = ex_sub(g, ex_mul(g, cosine, w), bc);
    r.x[place[a][b]] = ex_det2(g, cosine, ab, sine, ac);
    r.x[place[a][c]] = ex_dot2(g, sine, ab, cosine, ac);
    return r;
}

/* The symmetric half turns as rotate_sym does, with the sum of both sides for twice one of them;
 * the difference of the two stays. */
mat rotate_mat(walk *ps, mat m, int from, int to)
{
    if (from == to) {
        return m;
    }
    int base, a = turn_between(ps->t, from, to, &base);
    if (a < 0) {
        return rotate_mat(ps, rotate_mat(ps, m, from, base), base, to);
    }
    ex_graph *g = ps->g;
    int b = (a + 1) % 3, c = (a + 2) % 3;
    ex sine, cosine;
    turn_trig(ps, from, to, &sine, &cosine);
    ex bb = m.x[b][b], cc = m.x[c][c], bc = m.x[b][c], cb = m.x[c][b];
    ex both = ex_mul(g, cosine, ex_add(g, bc, cb));
    ex w = ex_add(g, ex_mul(g, sine, ex_sub(g, bb, cc)), both);
    ex sw = ex_mul(g, sine, w), cw = ex_mul(g, cosine, w);
    mat r = m;
    r.x[b][b] = ex_sub(g, bb, sw);
    r.x[c][c] = ex_add(g, cc, sw);
    r.x[b][c] = ex_sub(g, cw, cb);
    r.x[c][b] = ex_sub(g, cw, bc);
    r.x[a][b] = ex_det2(g, cosine, m.x[a][b], sine, m.x[a][c]);
    r.x[a][c] = ex_dot2(g, sine, m.x[a][b], cosine, m.x[a][c]);
    r.x[b][a] = ex_det2(g, cosine, m.x[b][a], sine, m.x[c][a]);
    r.x[c][a] = ex_dot2(g, sine, m.x[b][a], cosine, m.x[c][a]);
    return r;
}
