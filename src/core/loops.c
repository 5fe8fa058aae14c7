/* SPDX-License-Identifier: MIT
 * loops.c - closed loops and couplings: h(q) = 0 beside the equations of the tree.
 *
 *      M qdd + c = Q + J^T lambda,    J qdd = -Jdot qd
 *
 * Coordinate partitioning (Wehage & Haug 1982) with pivots chosen again in every evaluation:
 * Gauss-Jordan elimination of J with complete pivoting gives the dependent accelerations by the
 * independent ones, v = s - A u, and what is left is a small positive definite system,
 *
 *      T = [1; -A]      T^T M T u = T^T (Q - c - M [0; s])
 *
 * Rejected: the matrix of all qdd and lambda at once (KKT), or J M^-1 J^T. Both are larger: for a
 * four-bar 5 unknowns, or the factors of M and a 2 x 2 matrix; here 1. The second one needs an M
 * that is regular without the loops, which bodies without mass in a loop do not give. All
 * coordinates are integrated, so there is no memory of which ones are independent. The choice
 * depends on the state alone and changes qdd by rounding only; no step is cut at a change.
 *
 * Nothing drifts, because every step ends on h = 0 and J qd = 0: a Newton step or two in the metric
 * of M, min dq^T M dq, the same system with another right-hand side. For speeds that is an impulse
 * that does no work along the loop. Steps keep their order (Hairer, Lubich & Wanner 2006, IV.4).
 *
 * Redundant rows, as of a Bricard mechanism or of two hinges in a plane loop in space, are found by
 * the rank of J where the loops are closed. Within steps they are not quite closed; then no more
 * pivots than that are taken, and the rest are the smallest. Where a pivot vanishes in between, at
 * a singular position, the motion carries on (singular.c).
 */
#include <math.h>
#include <string.h>

#include "loops.h"

enum { MOST_CORRECTIONS = 8 };

void stein__loops_at(stein_sim *sim, const double *q, const double *qd)
{
    stein_turn(sim->model, q, sim->sc);
    sim->model->closure(q, qd, sim->sc, sim->d, sim->loop.h, sim->loop.J, sim->loop.jdqd);
}

void stein__give(stein_sim *sim, const unsigned char *kept, double *x)
{
    for (int j = 0; j < sim->model->nq; j++) {
        int given = stein__is_driven(sim, j) || (kept != NULL && kept[j]);
        sim->loop.role[j] = given ? GIVEN : FREE;
        x[j] = 0.0;
    }
}

int stein__most_pivots(const stein_sim *sim)
{
    return sim->loop.rank >= 0 ? sim->loop.rank : sim->model->nrow;
}

/* ---- accelerations ---- */

int stein__loops_solve(stein_sim *sim, double *b, int moves)
{
    stein__loops *l = &sim->loop;
    int n = sim->model->nq, m = sim->model->nrow;
    double *x = l->x;
    stein__give(sim, NULL, x);
    for (int j = 0; moves && j < n; j++) {
        int i = l->role[j] == GIVEN ? stein__driver_of(sim, j) : STEIN__FREE;
        x[j] = i >= 0 ? sim->ustate[3 * i + 2] : 0.0;
    }
    for (int i = 0; i < m; i++) {
        l->rhs[i] = moves ? -l->jdqd[i] : 0.0;
    }
    (void)stein__partition(sim, x, stein__most_pivots(sim), STEIN__PASSING_PIVOT);
    int bad = stein__partitioned(sim, sim->M, b, x);
    memcpy(b, x, sizeof *x * (size_t)n);
    return bad;
}

int stein__loops_accelerate(stein_sim *sim, double *qdd)
{
    const stein_model *model = sim->model;
    model->unloaded(sim->xq, sim->xqd, sim->sc, sim->d, sim->M, sim->c);
    model->closure(sim->xq, sim->xqd, sim->sc, sim->d, sim->loop.h, sim->loop.J, sim->loop.jdqd);
    for (int j = 0; j < model->nq; j++) {
        qdd[j] = sim->Q[j] - sim->c[j];
    }
    return stein__loops_solve(sim, qdd, 1);
}

/* The dependent joints have no force but those of the loops: J_v^T lambda = what is missing there.
 */
void stein__loops_take(stein_sim *sim, double *missing)
{
    stein__loops *l = &sim->loop;
    int n = sim->model->nq, r;
    stein__loops_at(sim, sim->xq, sim->xqd);
    stein__give(sim, NULL, l->x);
    memset(l->rhs, 0, sizeof *l->rhs * (size_t)sim->model->nrow);
    (void)stein__partition(sim, l->x, stein__most_pivots(sim), STEIN__PASSING_PIVOT);
    r = l->rank_found;
    for (int k = 0; k < r; k++) {
        l->y[k] = missing[l->column[k]];
        for (int i = 0; i < r; i++) {
            l->S[k * r + i] = l->J[l->row[i] * n + l->column[k]];
        }
    }
    if (stein__solve_general(r, l->S, sim->pivot, l->y) != 0) {
        return;
    }
    for (int j = 0; j < n; j++) {
        for (int k = 0; k < r; k++) {
            missing[j] -= l->J[l->row[k] * n + j] * l->y[k];
        }
    }
}

/* ---- on h = 0 ---- */

static int worst_row(const stein_sim *sim)
{
    int worst = 0;
    for (int i = 1; i < sim->model->nrow; i++) {
        worst = fabs(sim->loop.h[i]) > fabs(sim->loop.h[worst]) ? i : worst;
    }
    return worst;
}

const char *stein__worst_loop(const stein_sim *sim, double *gap, int *is_length)
{
    const stein_model *model = sim->model;
    int i = 0, row = worst_row(sim);
    *gap = fabs(sim->loop.h[row]);
    while (row >= model->loops[i].lengths + model->loops[i].angles) {
        row -= model->loops[i].lengths + model->loops[i].angles;
        i++;
    }
    *is_length = row < model->loops[i].lengths;
    return model->loops[i].name;
}

static stein_status fail_open(const stein_sim *sim, double t, stein_err *err)
{
    int is_length;
    double gap;
    const char *name = stein__worst_loop(sim, &gap, &is_length);
    return stein__fail(err, STEIN_ECLOSE,
                       "\"%s\" does not stay closed at t = %g s: off by %g %s (a prescribed motion "
                       "beyond its reach, or a step that is too long)",
                       name, t, gap, is_length ? "m" : "rad");
}

void stein__loops_correct(stein_sim *sim, const double *M, const unsigned char *kept, int rank,
                          double least)
{
    stein__loops *l = &sim->loop;
    stein__give(sim, kept, l->x);
    for (int i = 0; i < sim->model->nrow; i++) {
        l->rhs[i] = -l->h[i];
    }
    (void)stein__partition(sim, l->x, rank, least);
    memset(l->b, 0, sizeof *l->b * (size_t)sim->model->nq);
    if (stein__partitioned(sim, M, l->b, l->x) >= 0) { // no mass there: each joint counts alike
        memset(l->b, 0, sizeof *l->b * (size_t)sim->model->nq);
        (void)stein__partitioned(sim, NULL, l->b, l->x);
    }
}

double stein__loops_speeds(stein_sim *sim, const double *M, const unsigned char *kept, double *qd)
{
    stein__loops *l = &sim->loop;
    int n = sim->model->nq;
    stein__give(sim, kept, l->x);
    for (int i = 0; i < sim->model->nrow; i++) {
        l->rhs[i] = 0.0;
        for (int j = 0; j < n; j++) {
            l->rhs[i] -= l->J[i * n + j] * qd[j];
        }
    }
    double left = stein__partition(sim, l->x, stein__most_pivots(sim), STEIN__PASSING_PIVOT);
    memset(l->b, 0, sizeof *l->b * (size_t)n);
    if (stein__partitioned(sim, M, l->b, l->x) < 0) {
        for (int j = 0; j < n; j++) {
            qd[j] += l->x[j];
        }
    }
    return left;
}

stein_status stein__loops_project(stein_sim *sim, double t, stein_err *err)
{
    const stein__loops *l = &sim->loop;
    int n = sim->model->nq, m = sim->model->nrow;
    stein_status status = STEIN_OK;
    double gap = INFINITY; // before a correction; near a singular position down to rounding
    if (l->near && stein__singular_is_close(sim, t)) {
        return STEIN_OK; // what follows does it
    }
    stein__drive(sim, t);
    stein__loops_at(sim, sim->xq, sim->xqd);
    for (int k = 0; k < MOST_CORRECTIONS && (stein__largest(l->h, m) > 0.01 * STEIN__CLOSED ||
                                             (l->near && stein__largest(l->h, m) < 0.5 * gap));
         k++) {
        gap = stein__largest(l->h, m);
        stein__loops_correct(sim, sim->M, NULL, stein__most_pivots(sim), STEIN__PASSING_PIVOT);
        for (int j = 0; j < n; j++) {
            sim->xq[j] += l->x[j];
        }
        stein__loops_at(sim, sim->xq, sim->xqd);
    }
    if (stein__largest(l->h, m) <= STEIN__CLOSED) {
        (void)stein__loops_speeds(sim, sim->M, NULL, sim->xqd);
    } else if (isfinite(stein__largest(sim->xq, n))) {
        status = fail_open(sim, t, err);
    }
    return status;
}
