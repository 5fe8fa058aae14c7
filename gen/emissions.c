/* SPDX-License-Identifier: MIT
 * emissions.c - the list of the functions that a generated file holds: of each its prototype, the
 * comment above it, its results and the variables that they are assigned to.
 */
#include <stdio.h>

#include "gen_internal.h"

static void target_mass_bias(const tree *t, int i, char out[64])
{
    int n = t->n;
    snprintf(out, 64, i < n * n ? "M[%d]" : "c[%d]", i < n * n ? i : i - n * n);
}

/* all but the diagonal of M, where a joint with a prescribed motion has its 1 */
static int beside_diagonal(const tree *t, int i)
{
    int n = t->n;
    return i >= n * n || i / n != i % n;
}

static void target_inverse(const tree *t, int i, char out[64])
{
    (void)t;
    snprintf(out, 64, "Q[%d]", i);
}

static void target_articulated(const tree *t, int i, char out[64])
{
    snprintf(out, 64, i < t->n ? "qdd[%d]" : "pivot[%d]", i % t->n);
}

static void target_pose(const tree *t, int i, char out[64])
{
    static const char *const field[7] = {"x", "z", "c", "s", "vx", "vz", "w"};
    (void)t;
    snprintf(out, 64, "pose[%d].%s", i / 7, field[i % 7]);
}

static int always(const tree *t, int i)
{
    (void)t, (void)i;
    return 1;
}

static void target_point(const tree *t, int i, char out[64])
{
    int n = 3 * t->m->npoint, nj = n * t->n;
    if (i < 2 * n) {
        snprintf(out, 64, i < n ? "x[%d]" : "v[%d]", i % n);
    } else {
        snprintf(out, 64, i < 2 * n + nj ? "J[%d]" : "jdqd[%d]",
                 i < 2 * n + nj ? i - 2 * n : i - 2 * n - nj);
    }
}

static void target_slopes(const tree *t, int i, char out[64])
{
    int n = t->n * t->n;
    snprintf(out, 64, i < n ? "by_q[%d]" : "by_qd[%d]", i % n);
}

static void target_along(const tree *t, int i, char out[64])
{
    (void)t;
    snprintf(out, 64, "dQ[%d]", i);
}

static void target_pose_along(const tree *t, int i, char out[64])
{
    char pose[64];
    target_pose(t, i, pose);
    snprintf(out, 64, "d%.60s", pose);
}

static void target_closure(const tree *t, int i, char out[64])
{
    int n = t->nrow, nj = n * t->n;
    if (i < n) {
        snprintf(out, 64, "h[%d]", i);
    } else {
        snprintf(out, 64, i < n + nj ? "J[%d]" : "jdqd[%d]", i < n + nj ? i - n : i - n - nj);
    }
}

static void target_pose3(const tree *t, int i, char out[64])
{
    static const struct {
        const char *field;
        int first;
    } part[] = {{"o", 0}, {"R", 3}, {"v", 12}, {"w", 15}};
    int k = 3, at = i % POSE3;
    (void)t;
    while (at < part[k].first) {
        k--;
    }
    snprintf(out, 64, "pose[%d].%s[%d]", i / POSE3, part[k].field, at - part[k].first);
}

static void target_energy(const tree *t, int i, char out[64])
{
    (void)t;
    snprintf(out, 64, "e[%d]", i);
}

/** Functions that derivatives need. They exist in lanes, too. */
static void emit_rates(text *x, const tree *t, const layout *l, const funcs *f)
{
    static const emission unloaded = {
        .name = "unloaded",
        .arguments = "const stein_real *q, const stein_real *qd, const stein_real *sc,\n"
                     "                     const stein_real *d, stein_real *M, stein_real *c",
        .note = "M(q) and c(q, qd) without external forces: what a simulation evaluates",
        .type = "stein_real",
        .unused = {[EX_Q] = "q", [EX_QD] = "qd", [EX_NVAR] = "d", [EX_NVAR + 1] = "sc"},
        .target = target_mass_bias,
        .stays = beside_diagonal};
    static const emission articulated = {
        .name = "articulated",
        .arguments = "const stein_real *q, const stein_real *qd, const stein_real *sc,\n"
                     "                        const stein_real *d, const stein_real *Q,\n"
                     "                        stein_real *qdd, stein_real *pivot",
        .note = "qdd of M qdd + c = Q, and the pivots of M less what counts as 0",
        .type = "stein_real",
        .unused =
            {[EX_Q] = "q", [EX_QD] = "qd", [EX_TAU] = "Q", [EX_NVAR] = "d", [EX_NVAR + 1] = "sc"},
        .target = target_articulated};
    static const emission pose = {
        .name = "pose",
        .arguments = "const stein_real *q, const stein_real *qd, const stein_real *sc,\n"
                     "                 const stein_real *d, stein_pose *pose",
        .note = "planar poses of the bodies that have a frame",
        .type = "stein_real",
        .unused = {[EX_Q] = "q", [EX_QD] = "qd", [EX_NVAR] = "d", [EX_NVAR + 1] = "sc"},
        .target = target_pose,
        .stays = always};
    if (f->momenta.nout) {
        emit_func(x, t, l, &f->articulated, &articulated);
    } else if (f->articulated.nout) { // then lanes have no use for M
        emission asked = unloaded;
        asked.seldom = GEN_HUGE;
        text_add(x, "#if STEIN_LANES == 1\n");
        emit_func(x, t, l, &f->unloaded, &asked);
        text_add(x, "#endif\n\n");
        emit_func(x, t, l, &f->articulated, &articulated);
    } else {
        emit_func(x, t, l, &f->unloaded, &unloaded);
    }
    emit_solve(x, t);
    if (t->ncarrier) {
        emit_func(x, t, l, &f->pose, &pose);
    }
    text_add(x,
             "#if STEIN_LANES > 1\nextern const stein_lanes STEIN_LANES_NAME(STEIN_LANES, %s);\n",
             t->m->name);
    text_add(x,
             "const stein_lanes STEIN_LANES_NAME(STEIN_LANES, %s) = {%s, %s, %s, %s};\n"
             "#else\n\n",
             t->m->name, f->articulated.nout ? "NULL" : "unloaded",
             emit_solves(t) ? "solve" : "NULL", f->articulated.nout ? "articulated" : "NULL",
             t->ncarrier ? "pose" : "NULL");
}

void emit_slopes(text *x, const tree *t, const layout *l, const funcs *f)
{
    static const emission slopes = {
        .name = "inverse_slopes",
        .arguments = "const double *q, const double *qd, const double *qdd,\n"
                     "                           const double *sc, const double *d, double *by_q,\n"
                     "                           double *by_qd",
        .note = "derivatives of Q = M qdd + c by q and by qd",
        .type = "double",
        .unused =
            {[EX_Q] = "q", [EX_QD] = "qd", [EX_QDD] = "qdd", [EX_NVAR] = "d", [EX_NVAR + 1] = "sc"},
        .target = target_slopes};
    static const emission along = {
        .name = "inverse_along",
        .arguments =
            "const double *q, const double *qd, const double *qdd,\n"
            "                          const double *sc, const double *d, const double *dq,\n"
            "                          const double *dqd, const double *dd, double *dQ",
        .note = "Q = M qdd + c along a direction",
        .type = "double",
        .unused = {[EX_Q] = "q",
                   [EX_QD] = "qd",
                   [EX_QDD] = "qdd",
                   [EX_DQ] = "dq",
                   [EX_DQD] = "dqd",
                   [EX_DD] = "dd",
                   [EX_NVAR] = "d",
                   [EX_NVAR + 1] = "sc"},
        .seldom = GEN_LONG,
        .target = target_along};
    static const emission pose = {
        .name = "pose_along",
        .arguments =
            "const double *q, const double *qd, const double *sc, const double *d,\n"
            "                       const double *dq, const double *dqd, const double *dd,\n"
            "                       stein_pose *dpose",
        .note = "the poses along a direction",
        .type = "double",
        .unused = {[EX_Q] = "q",
                   [EX_QD] = "qd",
                   [EX_DQ] = "dq",
                   [EX_DQD] = "dqd",
                   [EX_DD] = "dd",
                   [EX_NVAR] = "d",
                   [EX_NVAR + 1] = "sc"},
        .seldom = GEN_LONG,
        .target = target_pose_along};
    if (f->slopes.nout) {
        emit_func(x, t, l, &f->slopes, &slopes);
    }
    if (f->along.nout) {
        emit_func(x, t, l, &f->along, &along);
    }
    if (f->pose_along.nout) {
        emit_func(x, t, l, &f->pose_along, &pose);
    }
}

void emit_functions(text *x, const tree *t, const layout *l, const funcs *f)
{
    static const emission mass_bias = {
        .name = "mass_bias",
        .arguments = "const double *q, const double *qd, const double *sc,\n"
                     "                      const double *d, const double *frc,\n"
                     "                      const double *trq, double *M, double *c",
        .note = "M(q) and c(q, qd, frc, trq)",
        .type = "double",
        .unused = {[EX_Q] = "q",
                   [EX_QD] = "qd",
                   [EX_FRC] = "frc",
                   [EX_TRQ] = "trq",
                   [EX_NVAR] = "d",
                   [EX_NVAR + 1] = "sc"},
        .seldom = GEN_HUGE,
        .target = target_mass_bias};
    static const emission inverse = {
        .name = "inverse",
        .arguments =
            "const double *q, const double *qd, const double *qdd, const double *sc,\n"
            "                    const double *d, const double *frc, const double *trq, double *Q",
        .note = "Q = M qdd + c",
        .type = "double",
        .unused = {[EX_Q] = "q",
                   [EX_QD] = "qd",
                   [EX_QDD] = "qdd",
                   [EX_FRC] = "frc",
                   [EX_TRQ] = "trq",
                   [EX_NVAR] = "d",
                   [EX_NVAR + 1] = "sc"},
        .target = target_inverse};
    static const emission point = {
        .name = "point",
        .arguments = "const double *q, const double *qd, const double *sc, const double *d,\n"
                     "                  double *x, double *v, double *J, double *jdqd",
        .note = "named points in the fixed frame",
        .type = "double",
        .unused = {[EX_Q] = "q", [EX_QD] = "qd", [EX_NVAR] = "d", [EX_NVAR + 1] = "sc"},
        .seldom = GEN_HUGE,
        .target = target_point};
    static const emission energy = {
        .name = "energy",
        .arguments = "const double *q, const double *qd, const double *sc, const double *d,\n"
                     "                   double *e",
        .note = "kinetic energy, potential energy of gravity",
        .type = "double",
        .unused = {[EX_Q] = "q", [EX_QD] = "qd", [EX_NVAR] = "d", [EX_NVAR + 1] = "sc"},
        .seldom = GEN_HUGE,
        .target = target_energy};
    static const emission pose3 = {
        .name = "pose3",
        .arguments = "const double *q, const double *qd, const double *sc, const double *d,\n"
                     "                  stein_pose3 *pose",
        .note = "poses in space of the bodies that have one",
        .type = "double",
        .unused = {[EX_Q] = "q", [EX_QD] = "qd", [EX_NVAR] = "d", [EX_NVAR + 1] = "sc"},
        .target = target_pose3};
    static const emission closure = {
        .name = "closure",
        .arguments = "const double *q, const double *qd, const double *sc, const double *d,\n"
                     "                    double *h, double *J, double *jdqd",
        .note = "loops and couplings: h(q), J = dh/dq and Jdot qd",
        .type = "double",
        .unused = {[EX_Q] = "q", [EX_QD] = "qd", [EX_NVAR] = "d", [EX_NVAR + 1] = "sc"},
        .target = target_closure};
    emit_rates(x, t, l, f);
    if (!f->momenta.nout) {
        emit_func(x, t, l, &f->mass_bias, &mass_bias);
    }
    emit_func(x, t, l, &f->inverse, &inverse);
    if (f->momenta.nout) {
        emit_long(x, t, l, f);
    } else if (t->m->npoint) {
        emit_func(x, t, l, &f->point, &point);
    }
    emit_func(x, t, l, &f->energy, &energy);
    if (t->nsolid) {
        emit_func(x, t, l, &f->pose3, &pose3);
    }
    if (t->nrow) {
        emit_func(x, t, l, &f->closure, &closure);
    }
}
