/* SPDX-License-Identifier: MIT
 * dyn.c - equations of motion by recursive Newton-Euler on recombined parameters.
 *
 * For body i with parent p, joint axis e, arm d from p's origin to i's, all in working frames:
 *   forward    om_i = om_p + e qd             omp_i = omp_p + om_p x e qd + e qdd
 *              BS_i = om~ om~ + omp~          A_i = A_p + BS_p d      (base: A = -g)
 *   backward   FF_i = BS_i b_i - frc + sum FF_k
 *              CF_i = K_i omp + om x K_i om + b_i x A_i - (trq + l x frc) + sum (CF_k + d_k x FF_k)
 *   outputs    c_i = e . CF_i  (revolute),   e . (m_i A_i + FF_i)  (prismatic)
 * FF leaves out m_i A_i: the mass is part of the parent's b and K (recombine.c). A prismatic child
 * that has slid by u adds m u to b and S(b, u) + m (u.u E - u u') to K, and its relative
 * acceleration a_r = 2 om x e qd + e qdd adds m a_r to FF and (b + m u) x a_r + u x FF to CF.
 *
 * M by composite bodies (Walker & Orin 1982, method 3; Featherstone): H_i = b_i + sum H_k and
 * I_i = K_i + sum (I_k + S(d_k, H_k)); column j is the force e x H_j and moment I_j e carried up.
 *
 * In a planar pair the terms of b x A and d x FF that come from BS are one pair of numbers, PD =
 * d.b and PC = (d x b).e, times omp and om^2. That saves operations near the root, not deep in a
 * chain. Rejected: expanding Lagrange's equations (Christoffel symbols), which grows with n^3.
 */
#include <stdlib.h>

#include "tree.h"

typedef struct link_state {
    vec om, omp; /* angular velocity and acceleration */
    ex bs[3][3]; /* BS */
    vec acc;     /* of the origin */
    vec axis;    /* joint axis times its sign */
    vec arm;     /* from the parent's origin, in frame arm_frame */
    int arm_frame;
    int pair;       /* handled as a pair with its parent */
    vec slide, rel; /* prismatic: displacement and relative acceleration */
    vec extra;      /* contribution of slid children to the first moment */
    sym extra_k;    /*   and to the inertia */
    vec first;      /* recombined first moment including `extra` */
    vec force, moment;
    vec local; /* forces that arrive in own axes: turned to the working frame together */
    vec comp;  /* composite first moment, with and without the own constant part */
    vec comp_x;
    sym comp_k, comp_kx; /* the same for the inertia */
    vec base_force;      /* force on the base for unit acceleration of this joint, fixed frame */
} link_state;

typedef struct dyn {
    walk *ps;
    ex_graph *g;
    const tree *t;
    link_state *s;
    link_state root;
    vec *carried; /* [n*n] force of column j past joint i, in the frame of i's parent */
    vec gravity;  /* fixed frame; zero where it acts as an acceleration */
} dyn;

static link_state *state_of(dyn *y, int i)
{
    return i < 0 ? &y->root : &y->s[i];
}

static int frame_of(const dyn *y, int i)
{
    return i < 0 ? -1 : y->ps->frame[i];
}

static int orient_of(const dyn *y, int i)
{
    return i < 0 ? -1 : y->t->body[i].orient;
}

static void at(dyn *y, int phase, int body)
{
    y->g->pass = phase;
    y->g->body = body;
}

/* ---- forward -------------------------------------------------------------------------------- */

static void set_bs(dyn *y, link_state *s, int body)
{
    ex_graph *g = y->g;
    ex w2[3] = {0, 0, 0};
    for (int i = 0; i < 3; i++) {
        w2[i] = ex_mul(g, s->om.x[i], s->om.x[i]);
    }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        ex product = ex_mul(g, s->om.x[i], s->om.x[j]);
        s->bs[i][i] = ex_neg(g, ex_add(g, w2[j], w2[k]));
        s->bs[i][j] = ex_sub(g, product, s->omp.x[k]);
        s->bs[j][i] = ex_add(g, product, s->omp.x[k]);
    }
    for (int i = 0; i < 9; i++) {
        ex_name(g, s->bs[i / 3][i % 3], "BS%d%d", i + 1, body + 1);
    }
}

static vec apply_bs(dyn *y, const link_state *s, vec v)
{
    vec r;
    for (int i = 0; i < 3; i++) {
        r.x[i] = vec_dot(y->g, (vec){{s->bs[i][0], s->bs[i][1], s->bs[i][2]}}, v);
    }
    return r;
}

static int only_along(vec v, int axis)
{
    return v.x[(axis + 1) % 3] == 0 && v.x[(axis + 2) % 3] == 0;
}

static void forward_turn(dyn *y, int i, ex qd, ex qdd)
{
    const rbody *b = &y->t->body[i];
    link_state *s = &y->s[i], *p = state_of(y, b->parent);
    int here = frame_of(y, i), there = frame_of(y, b->parent);
    vec spin = vec_scale(y->g, qd, s->axis), om_p = rotate(y->ps, p->om, there, here);
    int planar = same_group(y->t, here, there, b->axis) && only_along(p->om, b->axis);
    s->om = vec_add(y->g, om_p, spin);
    vec faster = vec_scale(y->g, qdd, s->axis), turned = vec_cross(y->g, om_p, spin);
    vec more = vec_add(y->g, turned, faster);
    s->omp = vec_add(y->g, rotate(y->ps, p->omp, there, here), more);
    vec_name(y->g, s->om, "OM", i, -1);
    vec_name(y->g, s->omp, "OMp", i, -1);
    set_bs(y, s, i);
    s->pair = planar && y->ps->ch->pair[i] && b->parent >= 0;
    s->arm_frame = planar && y->ps->ch->near[i] ? here : there;
    s->arm = rotate(y->ps, vec_const(y->g, b->hinge), orient_of(y, b->parent), s->arm_frame);
    vec_name(y->g, s->arm, "DP", i, -1);
    vec bend = apply_bs(y, p, s->arm);
    if (s->arm_frame == there) {
        s->acc = rotate(y->ps, vec_add(y->g, p->acc, bend), there, here);
    } else {
        s->acc = vec_add(y->g, rotate(y->ps, p->acc, there, here), bend);
    }
    vec_name(y->g, s->acc, "AF", i, -1);
}

static void forward_slide(dyn *y, int i, ex qd, ex qdd)
{
    ex_graph *g = y->g;
    const rbody *b = &y->t->body[i];
    link_state *s = &y->s[i], *p = state_of(y, b->parent);
    vec coriolis = vec_scale(g, qd, vec_cross(g, p->om, s->axis));
    s->om = p->om;
    s->omp = p->omp;
    for (int k = 0; k < 9; k++) {
        s->bs[k / 3][k % 3] = p->bs[k / 3][k % 3];
    }
    s->slide = vec_scale(g, ex_var(g, EX_Q, i), s->axis);
    vec faster = vec_scale(g, qdd, s->axis);
    s->rel = vec_add(g, vec_add(g, coriolis, coriolis), faster);
    s->acc = vec_add(g, vec_add(g, p->acc, apply_bs(y, p, s->slide)), s->rel);
    vec_name(g, s->acc, "AF", i, -1);
}

static void forward(dyn *y, int inverse)
{
    const tree *t = y->t;
    vec gravity = vec_const(y->g, t->gravity);
    if (y->ps->ch->gravity == 0) {
        y->root.acc = vec_sub(y->g, vec_zero(), gravity);
    } else {
        y->gravity = gravity;
    }
    for (int i = 0; i < t->n; i++) {
        const rbody *b = &t->body[i];
        at(y, PASS_FORWARD, i);
        ex qd = tree_rate(t, y->g, EX_QD, i);
        ex qdd = inverse ? tree_rate(t, y->g, EX_QDD, i) : 0;
        vec unit = vec_axis(b->axis, ex_num(y->g, b->sign));
        y->s[i].axis =
            b->turns ? unit : rotate(y->ps, unit, orient_of(y, b->parent), frame_of(y, i));
        if (b->turns) {
            forward_turn(y, i, qd, qdd);
        } else {
            forward_slide(y, i, qd, qdd);
        }
    }
}

/** First moments and inertias that vary because a child has slid. */
static void slid_children(dyn *y)
{
    ex_graph *g = y->g;
    for (int i = y->t->n - 1; i >= 0; i--) {
        const rbody *b = &y->t->body[i];
        link_state *s = &y->s[i];
        at(y, PASS_FORWARD, i);
        s->first = rotate(y->ps, vec_const(g, b->first), b->orient, frame_of(y, i));
        s->first = vec_add(g, s->first, s->extra);
        vec_name(g, s->first, "MB", i, -1);
        if (!b->turns && b->parent >= 0) {
            link_state *p = &y->s[b->parent];
            ex mass = ex_const(g, b->mass);
            p->extra = vec_add(g, p->extra, vec_add(g, s->extra, vec_scale(g, mass, s->slide)));
            sym shift = sym_add_cross(g, sym_point(g, mass, s->slide), s->first, s->slide);
            p->extra_k = sym_add(g, p->extra_k, sym_add(g, s->extra_k, shift));
        }
    }
}

/* ---- backward ------------------------------------------------------------------------------- */

/** Pair terms: PD = arm.b and PC = (arm x b).e, both bodies turning about the same axis. */
static void pair_terms(dyn *y, int i, ex *dot, ex *cross)
{
    const rbody *b = &y->t->body[i];
    link_state *s = &y->s[i];
    vec first = rotate(y->ps, s->first, frame_of(y, i), s->arm_frame), arm = s->arm;
    int e = b->axis, f = (e + 1) % 3, h = (e + 2) % 3;
    *dot = ex_dot2(y->g, arm.x[f], first.x[f], arm.x[h], first.x[h]);
    *cross = ex_det2(y->g, arm.x[f], first.x[h], arm.x[h], first.x[f]);
    ex_name(y->g, *dot, "PD%d", i + 1);
    ex_name(y->g, *cross, "PC%d", i + 1);
}

/** omp dot + sign om^2 cross, about the axis of body i. */
static vec pair_moment(dyn *y, int i, const link_state *rate, int sign)
{
    ex_graph *g = y->g;
    ex dot, cross;
    int e = y->t->body[i].axis;
    pair_terms(y, i, &dot, &cross);
    ex square = ex_mul(g, cross, ex_mul(g, rate->om.x[e], rate->om.x[e]));
    square = sign > 0 ? square : ex_neg(g, square);
    return vec_axis(e, ex_add(g, ex_mul(g, rate->omp.x[e], dot), square));
}

static void own_load(dyn *y, int i)
{
    ex_graph *g = y->g;
    const rbody *b = &y->t->body[i];
    link_state *s = &y->s[i];
    int here = frame_of(y, i);
    vec frc, trq;
    for (int k = 0; k < 3; k++) {
        frc.x[k] = y->ps->unloaded ? 0 : ex_var(g, EX_FRC, 3 * i + k);
        trq.x[k] = y->ps->unloaded ? 0 : ex_var(g, EX_TRQ, 3 * i + k);
    }
    vec turn = vec_add(g, trq, vec_cross(g, vec_const(g, b->centre), frc));
    s->force = vec_add(g, s->force, rotate(y->ps, vec_sub(g, s->local, frc), b->orient, here));
    s->moment = vec_sub(g, s->moment, rotate(y->ps, turn, b->orient, here));
}

static vec gravity_in(dyn *y, int i)
{
    return rotate(y->ps, y->gravity, -1, frame_of(y, i));
}

/** K omp + om x K om, the plain form. */
static vec euler_moment(ex_graph *g, const link_state *s, sym k)
{
    vec spin = vec_cross(g, s->om, sym_apply(g, k, s->om));
    return vec_add(g, sym_apply(g, k, s->omp), spin);
}

/** The same from BS. With second moments P_jj = K_kk (recombine.c: nothing along the joint axis),
 *      N_i = P_jj BS_kj - P_kk BS_jk - K_ij BS_ki + K_ik BS_ji + K_jk (BS_jj - BS_kk)
 *  cyclically: 13 products where the plain form has 22 (Balafoutis & Patel 1991, chapter 5). */
static vec inertia_moment(dyn *y, int i)
{
    ex_graph *g = y->g;
    const rbody *b = &y->t->body[i];
    link_state *s = &y->s[i];
    sym c = rotate_sym(y->ps, sym_const(g, b->inertia), i, frame_of(y, i));
    int e = b->axis;
    if (!b->flat) {
        return euler_moment(g, s, sym_add(g, c, s->extra_k));
    }
    vec n, second = vec_zero();
    second.x[(e + 1) % 3] = c.x[(e + 2) % 3];
    second.x[(e + 2) % 3] = c.x[(e + 1) % 3];
    for (int m = 0; m < 3; m++) {
        int j = (m + 1) % 3, k = (m + 2) % 3;
        vec col_j = sym_column(c, j), col_k = sym_column(c, k);
        n.x[m] = ex_det2(g, second.x[j], s->bs[k][j], second.x[k], s->bs[j][k]);
        n.x[m] = ex_sub(g, n.x[m], ex_mul(g, col_j.x[m], s->bs[k][m]));
        n.x[m] = ex_add(g, n.x[m], ex_mul(g, col_k.x[m], s->bs[j][m]));
        n.x[m] = ex_add(g, n.x[m], ex_mul(g, col_j.x[k], ex_sub(g, s->bs[j][j], s->bs[k][k])));
    }
    if (only_along(s->om, e) && only_along(s->omp, e)) {
        n.x[e] = ex_mul(g, c.x[e], s->omp.x[e]);
    }
    return vec_add(g, n, euler_moment(g, s, s->extra_k));
}

/** Moment of inertia forces and gravity on a turning body about its origin. */
static void own_inertia(dyn *y, int i)
{
    ex_graph *g = y->g;
    const rbody *b = &y->t->body[i];
    link_state *s = &y->s[i], *p = state_of(y, b->parent);
    int here = frame_of(y, i), there = frame_of(y, b->parent);
    s->moment = vec_add(g, s->moment, inertia_moment(y, i));
    if (s->pair) {
        s->moment = vec_add(g, s->moment, pair_moment(y, i, p, +1));
        s->moment =
            vec_add(g, s->moment, vec_cross(g, s->first, rotate(y->ps, p->acc, there, here)));
    } else {
        s->moment = vec_add(g, s->moment, vec_cross(g, s->first, s->acc));
    }
    if (y->ps->ch->gravity == 1) {
        vec pull = rotate(y->ps, y->gravity, -1, i);
        vec own = vec_cross(g, vec_const(g, b->first), pull);
        vec rest = vec_cross(g, s->extra, gravity_in(y, i));
        s->moment = vec_sub(g, s->moment, vec_add(g, rotate(y->ps, own, i, here), rest));
    }
}

/** Force and moment of a turning body on its parent. */
static void pass_up_turn(dyn *y, int i, vec own_force)
{
    ex_graph *g = y->g;
    link_state *s = &y->s[i], *p = state_of(y, y->t->body[i].parent);
    int here = frame_of(y, i), there = frame_of(y, y->t->body[i].parent);
    vec arm_force = s->pair ? s->force : vec_add(g, s->force, own_force);
    s->force = vec_add(g, s->force, own_force);
    vec_name(g, s->force, "FF", i, -1);
    vec lever = vec_cross(g, s->arm, rotate(y->ps, arm_force, here, s->arm_frame));
    if (s->pair) {
        lever = vec_add(g, lever, rotate(y->ps, pair_moment(y, i, s, -1), here, s->arm_frame));
    }
    if (y->t->body[i].base == orient_of(y, y->t->body[i].parent)) {
        p->local = vec_add(g, p->local, rotate(y->ps, s->force, here, y->t->body[i].base));
    } else {
        p->force = vec_add(g, p->force, rotate(y->ps, s->force, here, there));
    }
    p->moment = vec_add(g, p->moment, rotate(y->ps, lever, s->arm_frame, there));
    p->moment = vec_add(g, p->moment, rotate(y->ps, s->moment, here, there));
}

static void pass_up_slide(dyn *y, int i)
{
    ex_graph *g = y->g;
    const rbody *b = &y->t->body[i];
    link_state *s = &y->s[i], *p = state_of(y, b->parent);
    ex mass = ex_const(g, b->mass);
    vec moved = vec_add(g, s->first, vec_scale(g, mass, s->slide));
    vec own = vec_cross(g, moved, s->rel), carried = vec_cross(g, s->slide, s->force);
    vec turn = vec_add(g, carried, own);
    p->moment = vec_add(g, p->moment, vec_add(g, s->moment, turn));
    p->force = vec_add(g, p->force, vec_add(g, s->force, vec_scale(g, mass, s->rel)));
}

static ex joint_force(dyn *y, int i, vec own_force)
{
    ex_graph *g = y->g;
    const rbody *b = &y->t->body[i];
    link_state *s = &y->s[i];
    ex mass = ex_const(g, b->mass);
    vec inertial = vec_scale(g, mass, s->acc);
    vec total = vec_add(g, vec_add(g, s->force, own_force), inertial);
    if (y->ps->ch->gravity == 1 || y->ps->ch->gravity == 2) {
        vec axis = vec_axis(b->axis, ex_num(g, b->sign));
        ex pull = vec_dot(g, axis, rotate(y->ps, y->gravity, -1, orient_of(y, b->parent)));
        ex weight = ex_mul(g, mass, pull);
        return ex_sub(g, vec_dot(g, s->axis, total), weight);
    }
    return vec_dot(g, s->axis, total);
}

/** Fills c [n] (or Q). */
static void backward(dyn *y, ex *out)
{
    ex_graph *g = y->g;
    for (int i = y->t->n - 1; i >= 0; i--) {
        const rbody *b = &y->t->body[i];
        link_state *s = &y->s[i];
        at(y, PASS_BACKWARD, i);
        own_load(y, i);
        vec own_force = apply_bs(y, s, s->first);
        if (b->turns) {
            own_inertia(y, i);
            vec_name(g, s->moment, "CF", i, -1);
            out[i] = vec_dot(g, s->axis, s->moment);
            if (y->ps->ch->gravity == 2) {
                vec turn = vec_cross(g, s->comp, gravity_in(y, i));
                out[i] = ex_sub(g, out[i], vec_dot(g, s->axis, turn));
            }
            pass_up_turn(y, i, own_force);
        } else {
            out[i] = joint_force(y, i, own_force);
            pass_up_slide(y, i);
        }
        if (y->ps->ch->gravity == 3) { /* dV/dq = -g . d(sum m r)/dq */
            out[i] = ex_sub(g, out[i], vec_dot(g, y->gravity, s->base_force));
        }
    }
}

/* ---- composite bodies ----------------------------------------------------------------------- */

static void composites(dyn *y)
{
    ex_graph *g = y->g;
    for (int i = y->t->n - 1; i >= 0; i--) {
        const rbody *b = &y->t->body[i];
        link_state *s = &y->s[i], *p = state_of(y, b->parent);
        int here = frame_of(y, i), there = frame_of(y, b->parent);
        at(y, PASS_MASS, i);
        s->comp = vec_add(g, rotate(y->ps, vec_const(g, b->first), b->orient, here), s->comp_x);
        vec_name(g, s->comp, "HB", i, -1);
        if (b->turns) {
            vec h = rotate(y->ps, s->comp, here, s->arm_frame);
            s->comp_k =
                sym_add(g, rotate_sym(y->ps, sym_const(g, b->inertia), i, here), s->comp_kx);
            for (int k = 0; k < 6; k++) {
                ex_name(g, s->comp_k.x[k], "IB%d%d", k + 1, i + 1);
            }
            sym k = sym_add_cross(g, rotate_sym(y->ps, s->comp_k, here, s->arm_frame), s->arm, h);
            p->comp_x = vec_add(g, p->comp_x, rotate(y->ps, s->comp, here, there));
            p->comp_kx = sym_add(g, p->comp_kx, rotate_sym(y->ps, k, s->arm_frame, there));
        } else {
            ex mass = ex_const(g, b->mass);
            sym shift = sym_add_cross(g, sym_point(g, mass, s->slide), s->comp, s->slide);
            p->comp_x = vec_add(g, p->comp_x, vec_add(g, s->comp_x, vec_scale(g, mass, s->slide)));
            p->comp_kx = sym_add(g, p->comp_kx, sym_add(g, s->comp_kx, shift));
        }
    }
}

/** Force of column j at its own joint: for unit acceleration, in the working frame of j. */
static vec column_force(dyn *y, int j, vec first)
{
    const rbody *b = &y->t->body[j];
    const link_state *s = &y->s[j];
    return b->turns ? vec_cross(y->g, s->axis, first)
                    : vec_scale(y->g, ex_const(y->g, b->mass), s->axis);
}

/** 1 when column j is the sum of the own part and of the children's columns up to sign. */
static int splits(const dyn *y, int j)
{
    const rbody *b = &y->t->body[j];
    for (int k = j + 1; k < y->t->n; k++) {
        const rbody *c = &y->t->body[k];
        if (c->parent == j && !(c->turns && c->axis == b->axis)) {
            return 0;
        }
    }
    return y->ps->ch->split && b->turns;
}

/** Carry a force of column j past joint i, whole or as the sum of own part and children. */
static vec carry(dyn *y, int j, int i, vec whole, vec *own)
{
    const tree *t = y->t;
    int here = frame_of(y, i), there = frame_of(y, t->body[i].parent);
    *own = rotate(y->ps, *own, here, there);
    if (!splits(y, j)) {
        return rotate(y->ps, whole, here, there);
    }
    vec sum = *own;
    for (int k = j + 1; k < t->n; k++) {
        if (t->body[k].parent == j) {
            vec part = y->carried[k * t->n + i];
            sum = t->body[k].sign == t->body[j].sign ? vec_add(y->g, sum, part)
                                                     : vec_sub(y->g, sum, part);
        }
    }
    return sum;
}

/** Column j of M, carried from the joint to the root. */
static void mass_column(dyn *y, int j, ex *M)
{
    ex_graph *g = y->g;
    const tree *t = y->t;
    const link_state *s = &y->s[j];
    ex one = ex_num(g, t->body[j].sign);
    vec first = rotate(y->ps, vec_const(g, t->body[j].first), t->body[j].orient, frame_of(y, j));
    vec force = column_force(y, j, s->comp), own = column_force(y, j, first);
    vec moment = t->body[j].turns ? vec_scale(g, one, sym_column(s->comp_k, t->body[j].axis))
                                  : vec_cross(g, s->comp, s->axis);
    for (int i = j; i >= 0; i = t->body[i].parent) {
        const rbody *b = &t->body[i];
        const link_state *k = &y->s[i];
        int here = frame_of(y, i), there = frame_of(y, b->parent);
        at(y, PASS_MASS, i);
        M[i * t->n + j] = b->turns ? vec_dot(g, k->axis, moment) : vec_dot(g, k->axis, force);
        M[j * t->n + i] = M[i * t->n + j];
        if (b->turns) {
            vec lever = vec_cross(g, k->arm, rotate(y->ps, force, here, k->arm_frame));
            lever = rotate(y->ps, lever, k->arm_frame, there);
            moment = vec_add(g, rotate(y->ps, moment, here, there), lever);
        } else {
            moment = vec_add(g, moment, vec_cross(g, k->slide, force));
        }
        force = carry(y, j, i, force, &own);
        y->carried[j * t->n + i] = force;
        if (b->parent >= 0) {
            vec_name(g, force, "FM", b->parent, j);
            vec_name(g, moment, "CM", b->parent, j);
        }
        y->s[j].base_force = force; /* the last one is in the fixed frame */
    }
}

static void mass_matrix(dyn *y, ex *M)
{
    for (int j = y->t->n - 1; j >= 0; j--) {
        mass_column(y, j, M);
    }
}

/* ---- entry points --------------------------------------------------------------------------- */

static void dyn_end(dyn *y)
{
    free(y->s);
    free(y->carried);
}

static int dyn_begin(dyn *y, walk *ps)
{
    *y = (dyn){.ps = ps, .g = ps->g, .t = ps->t};
    size_t n = (size_t)ps->t->n;
    y->s = calloc(n, sizeof *y->s);
    y->carried = calloc(n * n, sizeof *y->carried);
    if (!y->s || !y->carried) {
        ps->g->failed = 1;
        dyn_end(y);
        return -1;
    }
    walk_frames(ps);
    return 0;
}

/** The rows of joints that keep their angle: qdd = 0. */
static void hold_still(const dyn *y, ex *M, ex *c)
{
    int n = y->t->n;
    for (int i = 0; i < n; i++) {
        if (y->t->body[i].still) {
            for (int j = 0; j < n; j++) {
                M[i * n + j] = M[j * n + i] = i == j ? ex_num(y->g, 1.0) : 0;
            }
            c[i] = 0;
        }
    }
}

void dyn_mass_bias(walk *ps, ex *out)
{
    dyn y;
    ex *c = out + (size_t)ps->t->n * (size_t)ps->t->n;
    if (dyn_begin(&y, ps)) {
        return;
    }
    forward(&y, 0);
    slid_children(&y);
    composites(&y);
    mass_matrix(&y, out);
    armature_masses(ps, out);
    backward(&y, c);
    hold_still(&y, out, c);
    dyn_end(&y);
}

void dyn_unloaded(walk *ps, ex *out)
{
    ps->unloaded = 1;
    dyn_mass_bias(ps, out);
}

static void inverse(walk *ps, int moves, ex *out)
{
    dyn y;
    int n = ps->t->n;
    if (dyn_begin(&y, ps)) {
        return;
    }
    forward(&y, moves);
    slid_children(&y);
    ex *M = calloc((size_t)n * (size_t)n, sizeof *M);
    if (M && ps->ch->gravity >= 2) {
        composites(&y);
        mass_matrix(&y, M); /* only the forces at the base are used, the rest is dead code */
    }
    ps->g->failed |= !M;
    free(M);
    backward(&y, out);
    for (int i = 0; i < n; i++) {
        if (ps->t->body[i].still) {
            out[i] = moves ? ex_var(ps->g, EX_QDD, i) : 0;
        }
    }
    dyn_end(&y);
}

void dyn_inverse(walk *ps, ex *out)
{
    inverse(ps, 1, out);
    armature_forces(ps, EX_QDD, out);
}

void dyn_bias(walk *ps, ex *out)
{
    inverse(ps, 0, out);
}
