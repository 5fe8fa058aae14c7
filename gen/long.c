/* SPDX-License-Identifier: MIT
 * long.c - mechanisms with long branches: M, kinetic energy and Jacobians of points as loops, since
 * written out their text grows with the square of the number of joints.
 *
 * M, the kinetic energy and the Jacobians of points have a number for every joint and every one
 * below it. In long branches that is text which compilers take minutes for, and none of it is in a
 * step, as qdd comes from articulated bodies (articulated.c). So the emitted text grows with n, and
 * loops do the rest:
 *
 *      M a       by the recursion of dyn.c with om = 0 and without gravity; its columns are M
 *      c         Q = M qdd + c at qdd = 0
 *      T         1/2 qd' (M qd)
 *      J         e_k x (x - o_k), e_k and o_k axis and origin of joint k
 */
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include "gen_internal.h"

/* Joints, and joints on the way to the frame of each of them on average. Below them the text is
 * compiled in seconds; above them articulated bodies take fewer operations than M. */
enum { LONG_TREE = 40, LONG_BRANCH = 20 };

int tree_is_long(const tree *t)
{
    long pairs = 0;
    for (int i = 0; i < t->n; i++) {
        for (int j = i; j >= 0; j = t->body[j].parent) {
            pairs++;
        }
    }
    return t->n >= LONG_TREE && pairs >= (long)LONG_BRANCH * t->n && dyn_articulates(t);
}

/* ---- M a ------------------------------------------------------------------------------------ */

typedef struct moving {
    vec spin, acc,
        arm; /* angular acceleration, acceleration of the origin, place from the parent's origin */
    vec force, moment;
} moving;

static void speed_up(walk *w, moving *all, int i, ex a)
{
    ex_graph *g = w->g;
    const rbody *b = &w->t->body[i];
    const moving rest = {.spin = {{0}}}, *p = b->parent < 0 ? &rest : &all[b->parent];
    int up = b->parent < 0 ? -1 : w->t->body[b->parent].orient;
    int here = w->frame[i], there = b->parent < 0 ? -1 : w->frame[b->parent];
    moving *s = &all[i];
    g->pass = PASS_FORWARD;
    g->body = i;
    s->arm = rotate(w, vec_const(g, b->hinge), up, there);
    vec turned = vec_axis(b->axis, b->sign > 0 ? a : ex_neg(g, a));
    s->spin = vec_add(g, rotate(w, p->spin, there, here), turned);
    s->acc = rotate(w, vec_add(g, p->acc, vec_cross(g, p->spin, s->arm)), there, here);
    vec_name(g, s->spin, "W", i, -1);
    vec_name(g, s->acc, "A", i, -1);
}

static ex push_back(walk *w, moving *all, int i)
{
    ex_graph *g = w->g;
    const rbody *b = &w->t->body[i];
    moving *s = &all[i];
    int here = w->frame[i];
    g->pass = PASS_BACKWARD;
    g->body = i;
    vec first = rotate(w, vec_const(g, b->first), b->orient, here);
    sym inertia = rotate_sym(w, sym_const(g, b->inertia), i, here);
    vec own = vec_add(g, sym_apply(g, inertia, s->spin), vec_cross(g, first, s->acc));
    s->force = vec_add(g, s->force, vec_cross(g, s->spin, first));
    s->moment = vec_add(g, s->moment, own);
    vec_name(g, s->force, "FF", i, -1);
    vec_name(g, s->moment, "CF", i, -1);
    if (b->parent >= 0) {
        moving *p = &all[b->parent];
        int there = w->frame[b->parent];
        vec force = rotate(w, s->force, here, there), moment = rotate(w, s->moment, here, there);
        p->force = vec_add(g, p->force, force);
        p->moment = vec_add(g, p->moment, vec_add(g, moment, vec_cross(g, s->arm, force)));
    }
    ex along = s->moment.x[b->axis];
    return b->sign > 0 ? along : ex_neg(g, along);
}

void dyn_momenta(walk *w, ex_var_kind rate, ex *out)
{
    int n = w->t->n;
    moving *all = calloc((size_t)n, sizeof *all);
    if (!all) {
        w->g->failed = 1;
        return;
    }
    walk_frames(w);
    for (int i = 0; i < n; i++) {
        speed_up(w, all, i, ex_var(w->g, rate, i));
    }
    for (int i = n - 1; i >= 0; i--) {
        out[i] = push_back(w, all, i);
    }
    armature_forces(w, rate, out);
    free(all);
}

void long_momenta(walk *w, ex *out)
{
    dyn_momenta(w, EX_QDD, out);
}

/* ---- points --------------------------------------------------------------------------------- */

/* the axes of body i in the fixed frame, from its parent's axes */
static void place_axes(walk *w, int i)
{
    const rbody *b = &w->t->body[i];
    int up = b->parent < 0 ? -1 : w->t->body[b->parent].orient;
    for (int k = 0; k < 3; k++) {
        vec axis = rotate(w, vec_axis(k, ex_num(w->g, 1.0)), b->orient, up);
        vec fixed = kin_turn(w, axis, up, -1);
        vec_name(w->g, fixed, k == 0 ? "RX" : k == 1 ? "RY" : "RZ", i, -1);
        for (int c = 0; c < 3; c++) {
            w->world[i].x[c][k] = fixed.x[c];
        }
    }
}

/* x, v, jdqd of every point, e and o of every joint: three numbers each */
void long_points(walk *w, ex *out)
{
    ex_graph *g = w->g;
    const tree *t = w->t;
    int n = t->n, np = t->m->npoint;
    placed *all = calloc((size_t)n, sizeof *all);
    w->world = calloc((size_t)n, sizeof *w->world);
    g->failed |= !all || !w->world;
    for (int i = 0; i < n && all && w->world; i++) {
        kin_place(w, all, i, -1);
        place_axes(w, i);
        for (int c = 0; c < 3; c++) {
            out[9 * np + 3 * i + c] = all[i].axis.x[c];
            out[9 * np + 3 * n + 3 * i + c] = all[i].o.x[c];
        }
    }
    for (int k = 0; k < np && all && w->world; k++) {
        placed at = kin_point_of(w, all, k);
        for (int c = 0; c < 3; c++) {
            out[3 * k + c] = at.o.x[c];
            out[3 * np + 3 * k + c] = at.v.x[c];
            out[6 * np + 3 * k + c] = at.a.x[c];
        }
    }
    free(w->world);
    w->world = NULL;
    free(all);
}

/* ---- text ----------------------------------------------------------------------------------- */

static void target_momenta(const tree *t, int i, char out[64])
{
    (void)t;
    snprintf(out, 64, "Q[%d]", i);
}

static void target_points(const tree *t, int i, char out[64])
{
    static const char *const name[] = {"x", "v", "jdqd"};
    int np = 3 * t->m->npoint, n = 3 * t->n;
    if (i < 3 * np) {
        snprintf(out, 64, "%s[%d]", name[i / np], i % np);
    } else {
        snprintf(out, 64, i < 3 * np + n ? "e[%d]" : "o[%d]", (i - 3 * np) % n);
    }
}

/* M by its columns, c by inverse() */
static void add_mass(text *x, int n)
{
    text_quiet(x, "/* M(q) and c(q, qd, frc, trq): the columns of M are M a of unit a */\n");
    text_add(x,
             "static void mass_bias(const double *q, const double *qd, const double *sc,\n"
             "                      const double *d, const double *frc,\n"
             "                      const double *trq, double *M, double *c)\n"
             "{\n"
             "    double a[%d] = {0.0};\n"
             "    for (int j = 0; j < %d; j++) {\n"
             "        a[j] = 1.0;\n"
             "        momenta(q, a, sc, d, c);\n"
             "        a[j] = 0.0;\n"
             "        for (int i = 0; i <= j; i++) {\n"
             "            M[i * %d + j] = M[j * %d + i] = c[i];\n"
             "        }\n"
             "    }\n"
             "    inverse(q, qd, a, sc, d, frc, trq, c);\n"
             "}\n\n",
             n, n, n, n);
    text_quiet(x, "/* M(q) and c(q, qd) without external forces */\n");
    text_add(x,
             "static void unloaded(const double *q, const double *qd, const double *sc,\n"
             "                     const double *d, double *M, double *c)\n"
             "{\n"
             "    static const double none[%d] = {0.0};\n"
             "    mass_bias(q, qd, sc, d, none, none, M, c);\n"
             "}\n\n",
             3 * n);
}

static void add_table(text *x, const char *name, int n, const int *value)
{
    text_add(x, "    static const short %s[%d] = {", name, n);
    for (int i = 0; i < n; i++) {
        text_add(x, i == 0 ? "%d" : i % 24 ? ", %d" : ",\n        %d", value[i]);
    }
    text_add(x, "};\n");
}

static void add_points(text *x, const tree *t)
{
    int n = t->n, np = t->m->npoint, *on = malloc(sizeof *on * (size_t)(n + np));
    if (!on) {
        x->failed = 1;
        return;
    }
    for (int i = 0; i < n; i++) {
        on[i] = t->body[i].parent;
    }
    for (int k = 0; k < np; k++) {
        on[n + k] = t->m->points[k].body;
    }
    text_quiet(x, "/* named points in the fixed frame */\n");
    text_add(x,
             "static void point(const double *q, const double *qd, const double *sc, const double "
             "*d,\n                  double *x, double *v, double *J, double *jdqd)\n{\n");
    add_table(x, "parent", n, on);
    add_table(x, "body", np, on + n);
    text_add(
        x,
        "    double e[%d], o[%d];\n"
        "    places(q, qd, sc, d, x, v, jdqd, e, o);\n"
        "    for (int i = 0; i < %d; i++) {\n"
        "        J[i] = 0.0;\n"
        "    }\n"
        "    for (int k = 0; k < %d; k++) {\n"
        "        for (int j = body[k]; j >= 0; j = parent[j]) {\n"
        "            for (int i = 0; i < 3; i++) {\n"
        "                int l = (i + 1) %% 3, m = (i + 2) %% 3;\n"
        "                J[(3 * k + i) * %d + j] = e[3 * j + l] * (x[3 * k + m] - o[3 * j + m]) -\n"
        "                                          e[3 * j + m] * (x[3 * k + l] - o[3 * j + l]);\n"
        "            }\n"
        "        }\n"
        "    }\n"
        "}\n\n",
        3 * n, 3 * n, 3 * np * n, np, n);
    free(on);
}

void emit_long(text *x, const tree *t, const layout *l, const funcs *f)
{
    static const emission momenta = {
        .name = "momenta",
        .arguments = "const double *q, const double *qdd, const double *sc, const double *d,\n"
                     "                    double *Q",
        .note = "Q = M qdd alone",
        .type = "double",
        .unused = {[EX_Q] = "q", [EX_QDD] = "qdd", [EX_NVAR] = "d", [EX_NVAR + 1] = "sc"},
        .target = target_momenta};
    static const emission places = {
        .name = "places",
        .arguments = "const double *q, const double *qd, const double *sc, const double *d,\n"
                     "                   double *x, double *v, double *jdqd, double *e, double *o",
        .note = "named points, axes and origins of the joints in the fixed frame",
        .type = "double",
        .unused = {[EX_Q] = "q", [EX_QD] = "qd", [EX_NVAR] = "d", [EX_NVAR + 1] = "sc"},
        .seldom = GEN_HUGE,
        .target = target_points};
    emit_func(x, t, l, &f->momenta, &momenta);
    add_mass(x, t->n);
    if (t->m->npoint) {
        emit_func(x, t, l, &f->point, &places);
        add_points(x, t);
    }
}
