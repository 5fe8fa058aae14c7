/* SPDX-License-Identifier: MIT
 * kin.c - poses, points and energies.
 *
 * Everything is written in the fixed frame: with arm r (joint to joint, or joint to point) turned
 * there once by the sums of joint angles,
 *      x = o + r      v = v_o + om x r      Jdot qd = a_o + BS r,  BS = om~ om~ + omp~ (qdd = 0)
 *      J column of joint k: e_k x (x - o_k), or e_k where it slides
 *      kinetic energy 1/2 qd' M qd      potential energy -g . (sum of first moments)
 * v is not formed as J qd: the recursion needs one product per arm instead of one per joint.
 */
#include <stddef.h>
#include <stdlib.h>

#include "tree.h"

vec kin_bend(ex_graph *g, vec om, vec omp, vec r)
{
    vec out;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        ex diagonal = ex_dot2(g, om.x[j], om.x[j], om.x[k], om.x[k]);
        ex ij = ex_sub(g, ex_mul(g, om.x[i], om.x[j]), omp.x[k]);
        ex ik = ex_add(g, ex_mul(g, om.x[i], om.x[k]), omp.x[j]);
        ex sum = ex_dot2(g, ij, r.x[j], ik, r.x[k]);
        out.x[i] = ex_sub(g, sum, ex_mul(g, diagonal, r.x[i]));
    }
    return out;
}

vec kin_turn(walk *w, vec v, int up, int to)
{
    if (w->world == NULL || up < 0 || to >= 0) {
        return rotate(w, v, up, to);
    }
    vec out;
    for (int i = 0; i < 3; i++) {
        const ex *row = w->world[up].x[i];
        out.x[i] = vec_dot(w->g, (vec){{row[0], row[1], row[2]}}, v);
    }
    return out;
}

void kin_place(walk *w, placed *all, int i, int top)
{
    ex_graph *g = w->g;
    const rbody *b = &w->t->body[i];
    const placed fixed = {.o = {{0}}}, *p = b->parent == top ? &fixed : &all[b->parent];
    placed *s = &all[i];
    int up = b->parent < 0 ? -1 : w->t->body[b->parent].orient;
    int to = top < 0 ? -1 : w->t->body[top].orient;
    ex qd = tree_rate(w->t, g, EX_QD, i);
    g->pass = PASS_FORWARD;
    g->body = i;
    s->axis = kin_turn(w, vec_axis(b->axis, ex_num(g, b->sign)), up, to);
    vec_name(g, s->axis, "E", i, -1);
    s->om = p->om;
    s->omp = p->omp;
    vec at = vec_const(g, b->at), relative = vec_zero(), coriolis = vec_zero();
    if (b->turns) {
        vec spin = vec_scale(g, qd, s->axis);
        s->om = vec_add(g, p->om, spin);
        s->omp = vec_add(g, p->omp, vec_cross(g, p->om, spin));
        vec_name(g, s->om, "OM", i, -1);
        vec_name(g, s->omp, "OMp", i, -1);
    } else {
        ex q = ex_var(g, EX_Q, i);
        at.x[b->axis] = ex_add(g, at.x[b->axis], ex_mul(g, ex_num(g, b->sign), q));
        relative = vec_scale(g, qd, s->axis);
        coriolis = vec_cross(g, p->om, relative);
    }
    s->arm = kin_turn(w, at, up, to);
    vec_name(g, s->arm, "RL", i, -1);
    s->o = vec_add(g, p->o, s->arm);
    vec_name(g, s->o, "PO", i, -1);
    s->v = vec_add(g, p->v, vec_add(g, vec_cross(g, p->om, s->arm), relative));
    vec_name(g, s->v, "VI", i, -1);
    vec twice = vec_add(g, coriolis, coriolis);
    s->a = vec_add(g, p->a, vec_add(g, kin_bend(g, p->om, p->omp, s->arm), twice));
    vec_name(g, s->a, "AC", i, -1);
}

static placed *place_all(walk *w)
{
    placed *all = calloc((size_t)w->t->n + 1, sizeof *all);
    if (!all) {
        w->g->failed = 1;
        return NULL;
    }
    for (int i = 0; i < w->t->n; i++) {
        kin_place(w, all, i, -1);
    }
    return all;
}

/* ---- poses ---------------------------------------------------------------------------------- */

void kin_pose(walk *w, ex *out)
{
    ex_graph *g = w->g;
    placed *all = place_all(w);
    for (int k = 0; all && k < w->t->ncarrier; k++) {
        int i = w->t->carrier[k], o = w->t->body[i].orient;
        ex s = 0, c = ex_num(g, 1.0);
        if (o >= 0) {
            angle_trig(w, o, -1, &s, &c);
        }
        const ex pose[7] = {all[i].o.x[0],
                            all[i].o.x[2],
                            c,
                            ex_neg(g, s),
                            all[i].v.x[0],
                            all[i].v.x[2],
                            ex_neg(g, all[i].om.x[1])};
        for (int j = 0; j < 7; j++) {
            out[7 * k + j] = pose[j];
        }
    }
    free(all);
}

void kin_pose3(walk *w, ex *out)
{
    ex_graph *g = w->g;
    placed *all = place_all(w);
    for (int k = 0; all && k < w->t->nsolid; k++) {
        int i = w->t->solid[k];
        ex *pose = out + (ptrdiff_t)POSE3 * k;
        g->pass = PASS_FORWARD;
        g->body = i;
        for (int j = 0; j < 3; j++) {
            vec column = rotate(w, vec_axis(j, ex_num(g, 1.0)), w->t->body[i].orient, -1);
            for (int row = 0; row < 3; row++) {
                pose[3 + 3 * row + j] = column.x[row];
            }
            pose[j] = all[i].o.x[j];
            pose[12 + j] = all[i].v.x[j];
            pose[15 + j] = all[i].om.x[j];
        }
    }
    free(all);
}

/* ---- points --------------------------------------------------------------------------------- */

placed kin_point_of(walk *w, const placed *all, int k)
{
    ex_graph *g = w->g;
    const tree *t = w->t;
    int i = t->m->points[k].body;
    vec at = vec_const(g, tree_vector(t, t->m->points[k].at));
    placed p = {.arm = at, .o = at};
    g->pass = PASS_POINT;
    g->body = k;
    if (i >= 0) {
        p.arm = kin_turn(w, at, t->body[i].orient, -1);
        vec_name(g, p.arm, "RP", k, -1);
        p.o = vec_add(g, all[i].o, p.arm);
        p.v = vec_add(g, all[i].v, vec_cross(g, all[i].om, p.arm));
        p.a = vec_add(g, all[i].a, kin_bend(g, all[i].om, all[i].omp, p.arm));
    }
    return p;
}

static void one_point(walk *w, const placed *all, int k, ex *out)
{
    ex_graph *g = w->g;
    const tree *t = w->t;
    int n = t->n, np = t->m->npoint, i = t->m->points[k].body;
    placed p = kin_point_of(w, all, k);
    vec r = p.arm;
    for (int c = 0; c < 3; c++) {
        out[3 * k + c] = p.o.x[c];
        out[3 * np + 3 * k + c] = p.v.x[c];
        out[6 * np + 3 * np * n + 3 * k + c] = p.a.x[c];
    }
    for (int j = i; j >= 0; j = t->body[j].parent) {
        vec column = t->body[j].turns ? vec_cross(g, all[j].axis, r) : all[j].axis;
        for (int c = 0; c < 3; c++) {
            out[6 * np + (3 * k + c) * n + j] = t->body[j].still ? 0 : column.x[c];
        }
        r = vec_add(g, r, all[j].arm);
    }
}

void kin_point(walk *w, ex *out)
{
    placed *all = place_all(w);
    for (int k = 0; all && k < w->t->m->npoint; k++) {
        one_point(w, all, k, out);
    }
    free(all);
}

/* ---- energies ------------------------------------------------------------------------------- */

static ex kinetic_of_long(walk *w)
{
    ex_graph *g = w->g;
    int n = w->t->n;
    ex *p = calloc((size_t)n, sizeof *p), sum = 0;
    if (!p) {
        g->failed = 1;
        return 0;
    }
    dyn_momenta(w, EX_QD, p);
    g->pass = PASS_OUTPUT;
    g->body = -1;
    for (int i = 0; i < n; i++) {
        sum = ex_add(g, sum, ex_mul(g, ex_var(g, EX_QD, i), p[i]));
    }
    free(p);
    return ex_mul(g, ex_num(g, 0.5), sum);
}

static ex kinetic(walk *w)
{
    ex_graph *g = w->g;
    int n = w->t->n;
    ex *M = calloc((size_t)n * (size_t)n + (size_t)n, sizeof *M), diagonal = 0, rest = 0;
    if (!M) {
        g->failed = 1;
        return 0;
    }
    dyn_mass_bias(w, M);
    g->pass = PASS_OUTPUT;
    g->body = -1;
    for (int i = 0; i < n; i++) {
        ex qd = tree_rate(w->t, g, EX_QD, i), coupled = 0;
        for (int j = i + 1; j < n; j++) {
            coupled = ex_add(g, coupled, ex_mul(g, M[i * n + j], tree_rate(w->t, g, EX_QD, j)));
        }
        diagonal = ex_add(g, diagonal, ex_mul(g, M[i * n + i], ex_mul(g, qd, qd)));
        rest = ex_add(g, rest, ex_mul(g, qd, coupled));
    }
    free(M);
    return ex_add(g, ex_mul(g, ex_num(g, 0.5), diagonal), rest);
}

static ex potential(walk *w)
{
    ex_graph *g = w->g;
    const tree *t = w->t;
    vec gravity = vec_const(g, t->gravity);
    ex sum = vec_dot(g, vec_const(g, t->first), gravity);
    for (int i = 0; i < t->n; i++) {
        const rbody *b = &t->body[i];
        g->pass = PASS_FORWARD;
        g->body = i;
        vec there = rotate(w, gravity, -1,
                           b->turns || b->parent < 0 ? b->orient : t->body[b->parent].orient);
        vec first = vec_const(g, b->first);
        if (!b->turns) {
            ex q = ex_var(g, EX_Q, i), slid = ex_mul(g, ex_num(g, b->sign), q);
            first = vec_axis(b->axis, ex_mul(g, ex_const(g, b->mass), slid));
        }
        sum = ex_add(g, sum, vec_dot(g, first, there));
    }
    return ex_neg(g, sum);
}

void kin_energy(walk *w, ex *out)
{
    out[0] = tree_is_long(w->t) ? kinetic_of_long(w) : kinetic(w);
    out[1] = potential(w);
}
