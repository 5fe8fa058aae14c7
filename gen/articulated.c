/* SPDX-License-Identifier: MIT
 * articulated.c - forward dynamics without M: articulated bodies (Featherstone 2008, chapter 7).
 *
 * qdd is how a tree at rest begins to move under r = Q - c, with c from the recursion of dyn.c.
 * Seen from joint i, the body and all that hangs on it resist the angular acceleration w and the
 * linear one a of its origin with
 *
 *      moment = J w + H a + n        force = H' w + B a + f
 *
 * Its own parts are K in J and the cross product of b in H. Its mass is part of the parent's K and
 * b (recombine.c), which does not change M and its solution. From the leaves to the root, with axis
 * e, arm d and u_n = J e, u_f = H' e, D = e.J e, t = r_i - e.n:
 *
 *      the joint gives way     J -= u_n u_n' / D    H -= u_n u_f' / D    B -= u_f u_f' / D
 *                              n += u_n t / D       f += u_f t / D
 *      the parent's origin     H+ = H + d~ B    J += (d~ H')' + d~ H+'    n += d x f
 *
 * and back from the root: a += w x d, qdd = t / D - (u_n.w + u_f.a) / D, w += e qdd.
 *
 * An armature a, which resists qdd alone, is added to D. The joint then gives way by a part of J e:
 * J, H and n keep the share a / D of their part along e.
 *
 * The work grows with n, where M and its factors grow with n^2 and n^3: from a dozen joints in a
 * chain on it is less (gen.c, make_route). Trees with a slide would need the masses that were moved
 * to parents, so they use M. So do trees with a joint that may have a prescribed motion: it is
 * taken out of M.
 *
 * D is the pivot of the factors of M: where one is not well above 0, M is singular. The returned
 * pivot is D less 1e-13 of the inertias beyond the joint.
 */
#include <stdlib.h>

#include "tree.h"

static const double tiny = 1e-13; /* of a pivot, as in solve.c */

/* a body with all that hangs on it, in its working frame */
typedef struct part {
    sym turning;       /* J */
    mat mixed;         /* H */
    sym moving;        /* B */
    vec moment, force; /* n, f */
    ex scale;          /* sum of the inertias */
    vec un, uf;        /* u_n / D, u_f / D */
    ex share;          /* t / D */
    vec arm;           /* d in the parent's working frame */
    vec spin, acc;     /* w, a */
} part;

static vec row(mat a, int i)
{
    return (vec){{a.x[i][0], a.x[i][1], a.x[i][2]}};
}

/* inertia of a single body: K and b~ */
static void own_inertia(walk *ps, int i, part *s)
{
    ex_graph *g = ps->g;
    const rbody *b = &ps->t->body[i];
    int here = ps->frame[i];
    vec first = rotate(ps, vec_const(g, b->first), b->orient, here);
    s->turning = sym_add(g, s->turning, rotate_sym(ps, sym_const(g, b->inertia), i, here));
    for (int k = 0; k < 3; k++) {
        int l = (k + 1) % 3, m = (k + 2) % 3;
        s->mixed.x[m][l] = ex_add(g, s->mixed.x[m][l], first.x[k]);
        s->mixed.x[l][m] = ex_sub(g, s->mixed.x[l][m], first.x[k]);
        s->scale = ex_add(ps->t->setup, s->scale, b->inertia.x[k]);
    }
    s->scale = ex_add(ps->t->setup, s->scale, b->armature);
}

/* The joint gives way to b_i, its drive. Without an armature J and H have no part along its axis
 * then, and the moment along it is the drive. */
static void give_way(walk *ps, int i, part *s, ex drive, ex *pivot)
{
    ex_graph *g = ps->g;
    const rbody *b = &ps->t->body[i];
    int e = b->axis, gone = b->armature == 0 ? e : -1;
    vec un = sym_column(s->turning, e), uf = row(s->mixed, e);
    ex along = b->sign > 0 ? drive : ex_neg(g, drive);
    ex D = ex_add(g, un.x[e], ex_const(g, b->armature)), t = ex_sub(g, along, s->moment.x[e]);
    ex_name(g, D, "D%d", i + 1);
    ex least = ex_mul(ps->t->setup, ex_num(ps->t->setup, tiny), s->scale);
    *pivot = ex_sub(g, D, ex_const(g, least));
    ex inverse = ex_div(g, ex_num(g, 1.0), D);
    ex_name(g, inverse, "iD%d", i + 1);
    s->share = ex_mul(g, t, inverse);
    for (int k = 0; k < 3; k++) {
        s->un.x[k] = k == gone ? 0 : ex_mul(g, un.x[k], inverse);
        s->uf.x[k] = ex_mul(g, uf.x[k], inverse);
    }
    for (int k = 0; k < 3; k++) {
        for (int l = 0; l < 3; l++) {
            ex *J = sym_entry(&s->turning, k, l), *B = sym_entry(&s->moving, k, l);
            if (k <= l) {
                *J = k == gone || l == gone ? 0 : ex_sub(g, *J, ex_mul(g, un.x[k], s->un.x[l]));
                *B = ex_sub(g, *B, ex_mul(g, uf.x[k], s->uf.x[l]));
            }
            s->mixed.x[k][l] =
                k == gone ? 0 : ex_sub(g, s->mixed.x[k][l], ex_mul(g, s->un.x[k], uf.x[l]));
        }
        s->moment.x[k] = k == gone ? along : ex_add(g, s->moment.x[k], ex_mul(g, s->un.x[k], t));
        s->force.x[k] = ex_add(g, s->force.x[k], ex_mul(g, s->uf.x[k], t));
    }
}

/* J about an origin that is -d away. J is symmetric: of the two ways to an entry beside the
 * diagonal the one along the joint's axis e, where rows of the old H are 0, costs less. */
static sym moved_inertia(ex_graph *g, sym J, vec d, mat before, mat after, int e)
{
    mat x, y;
    for (int j = 0; j < 3; j++) {
        vec old = vec_cross(g, d, row(before, j)), new = vec_cross(g, d, row(after, j));
        for (int i = 0; i < 3; i++) {
            x.x[i][j] = old.x[i];
            y.x[i][j] = new.x[i];
        }
    }
    for (int k = 0; k < 3; k++) {
        int i = (e + k) % 3, j = (i + 1) % 3;
        int from = j == e ? j : i, to = j == e ? i : j; // the axis comes first
        *sym_entry(&J, k, k) = ex_add(g, ex_add(g, *sym_entry(&J, k, k), x.x[k][k]), y.x[k][k]);
        ex sum = ex_add(g, *sym_entry(&J, from, to), x.x[to][from]);
        *sym_entry(&J, from, to) = ex_add(g, sum, y.x[from][to]);
    }
    return J;
}

/* inertia of an articulated body at its parent */
static void pass_up(walk *ps, int i, const part *s, part *p)
{
    ex_graph *g = ps->g;
    int here = ps->frame[i], there = ps->frame[ps->t->body[i].parent];
    sym J = rotate_sym(ps, s->turning, here, there), B = rotate_sym(ps, s->moving, here, there);
    mat H = rotate_mat(ps, s->mixed, here, there), moved = H;
    for (int j = 0; j < 3; j++) {
        vec lever = vec_cross(g, s->arm, sym_column(B, j));
        for (int k = 0; k < 3; k++) {
            moved.x[k][j] = ex_add(g, H.x[k][j], lever.x[k]);
            p->mixed.x[k][j] = ex_add(g, p->mixed.x[k][j], moved.x[k][j]);
        }
    }
    J = moved_inertia(g, J, s->arm, H, moved, ps->t->body[i].axis);
    p->turning = sym_add(g, p->turning, J);
    p->moving = sym_add(g, p->moving, B);
    vec f = rotate(ps, s->force, here, there), n = rotate(ps, s->moment, here, there);
    p->force = vec_add(g, p->force, f);
    p->moment = vec_add(g, p->moment, vec_add(g, n, vec_cross(g, s->arm, f)));
    p->scale = ex_add(ps->t->setup, p->scale, s->scale);
}

static void accelerate(walk *ps, int i, part *all, ex *qdd)
{
    ex_graph *g = ps->g;
    const rbody *b = &ps->t->body[i];
    part *s = &all[i];
    if (b->parent >= 0) {
        const part *p = &all[b->parent];
        int here = ps->frame[i], there = ps->frame[b->parent];
        vec a = vec_add(g, p->acc, vec_cross(g, p->spin, s->arm));
        s->spin = rotate(ps, p->spin, there, here);
        s->acc = rotate(ps, a, there, here);
    }
    ex turned = vec_dot(g, s->un, s->spin), lost = ex_add(g, turned, vec_dot(g, s->uf, s->acc));
    ex faster = ex_sub(g, s->share, lost); // of the body along e; with an armature of the joint
    ex of_joint = faster;
    if (b->armature == 0) {
        of_joint = ex_sub(g, faster, s->spin.x[b->axis]);
    } else {
        faster = ex_add(g, of_joint, s->spin.x[b->axis]);
    }
    s->spin.x[b->axis] = faster;
    *qdd = b->sign > 0 ? of_joint : ex_neg(g, of_joint);
    vec_name(g, s->spin, "W", i, -1);
    vec_name(g, s->acc, "A", i, -1);
}

int dyn_articulates(const tree *t)
{
    int can = t->m->load_body < 0 && t->nrow == 0 && !tree_in_space(t);
    for (int i = 0; i < t->n; i++) {
        can &= t->body[i].turns && !t->m->bodies[i].sticks; // friction that sticks needs M
    }
    for (int i = 0; i < t->m->ninput; i++) {
        can &= t->m->inputs[i].kind != STEIN_INPUT_MOTION;
    }
    for (int i = 0; i < t->m->ncontact; i++) {
        can &= !t->m->contacts[i].sticks;
    }
    return can;
}

void dyn_articulated(walk *ps, ex *out)
{
    ex_graph *g = ps->g;
    const tree *t = ps->t;
    int n = t->n;
    part *s = calloc((size_t)n, sizeof *s);
    ex *c = calloc((size_t)n, sizeof *c);
    g->failed |= !s || !c;
    if (s && c) {
        ps->unloaded = 1;
        dyn_bias(ps, c);
        for (int i = n - 1; i >= 0; i--) {
            int up = t->body[i].parent;
            g->pass = PASS_ARTICULATED;
            g->body = i;
            ex drive = ex_sub(g, ex_var(g, EX_TAU, i), c[i]);
            own_inertia(ps, i, &s[i]);
            give_way(ps, i, &s[i], drive, &out[n + i]);
            if (up >= 0) {
                s[i].arm =
                    rotate(ps, vec_const(g, t->body[i].hinge), t->body[up].orient, ps->frame[up]);
                pass_up(ps, i, &s[i], &s[up]);
            }
        }
        for (int i = 0; i < n; i++) {
            g->pass = PASS_RATES;
            g->body = i;
            accelerate(ps, i, s, &out[i]);
        }
    }
    free(s);
    free(c);
}
