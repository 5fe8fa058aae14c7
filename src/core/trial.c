/* SPDX-License-Identifier: MIT
 * trial.c - one trial step, for a simulation alone or in lanes.
 *
 * One engine runs every explicit tableau on q' = qd, qd' = qdd(t, q, qd):
 *
 *   RK4   Kutta 1901, order 4, 4 stages
 *   DP5   Dormand & Prince 1980, order 5 with embedded order 4, 6 stages
 */
#include <float.h>
#include <math.h>

#include "core.h"
#include "elementary.h"

enum { MAX_STAGES = 6 };

typedef struct tableau {
    int stages;
    double c[MAX_STAGES];
    double a[MAX_STAGES][MAX_STAGES];
    double b[MAX_STAGES];
    double e[MAX_STAGES + 1]; /* b - b_embedded, the last for the end derivative; all 0: none */
    int embedded;
} tableau;

static const tableau rk4 = {
    .stages = 4,
    .c = {0.0, 0.5, 0.5, 1.0},
    .a = {{0.0}, {0.5}, {0.0, 0.5}, {0.0, 0.0, 1.0}},
    .b = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0},
};

static const tableau dp5 = {
    .stages = 6,
    .c = {0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0},
    .a = {{0.0},
          {1.0 / 5.0},
          {3.0 / 40.0, 9.0 / 40.0},
          {44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0},
          {19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0},
          {9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0}},
    .b = {35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0},
    .e = {71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0,
          -1.0 / 40.0},
    .embedded = 1,
};

/* an explicit step is abrupt where its stages differ by that share of the speeds */
static const double share = 0.1;

/* the larger one; b where a is no number */
static inline real larger(real a, real b)
{
    return sel(more(a, b), a, b);
}

#if STEIN_LANES == 1
int stein__stages(stein_integrator integrator)
{
    return integrator == STEIN_RK4 ? rk4.stages : dp5.stages;
}

double stein__explicit_stiffness(const stein_sim *sim, double h)
{
    int n = sim->model->nq, apart = sim->stride, end = dp5.stages;
    const double *g6 = sim->k + (end - 1) * apart, *y7 = sim->k + end * apart;
    double by = 0.0, df = 0.0;
    for (int j = 0; j < 2 * n; j++) {
        double scale = j < n ? 1.0 : h, dy = dp5.b[end - 1] * g6[j];
        for (int i = 0; i < end - 1; i++) {
            dy += (dp5.b[i] - dp5.a[end - 1][i]) * sim->k[i * apart + j];
        }
        by = larger(scale * fabs(h * dy), by);
        df = larger(scale * fabs(h * (y7[j] - g6[j])), df);
    }
    return by > 0.0 ? df / by : 0.0;
}

const double *stein__weights(stein_integrator integrator, int i)
{
    const tableau *rk = integrator == STEIN_RK4 ? &rk4 : &dp5;
    return i < rk->stages ? rk->a[i] : rk->b;
}
#endif

/* y = y0 + h sum of w_i k_i over the first n stages, those that have a weight: four registers full
 * of such sums at a time */
static void combine(const stein_sim *sim, const double *w, int n, real h, const real *y0, real *y)
{
    int width = sim->width, stride = sim->stride;
    for (int at = 0; at < width; at += STEIN__SUMS) {
        const some *from = (const some *)(const void *)(y0 + at);
        some *to = (some *)(void *)(y + at);
        some s0 = from[0], s1 = from[1], s2 = from[2], s3 = from[3];
        const real *each = sim->k + at;
        for (int i = 0; i < n; i++, each += stride) {
            const some *k = (const some *)(const void *)each;
            if (w[i] != 0.0) {
                real weight = h * w[i];
                some hw = SOME(weight);
                s0 += hw * k[0];
                s1 += hw * k[1];
                s2 += hw * k[2];
                s3 += hw * k[3];
            }
        }
        to[0] = s0;
        to[1] = s1;
        to[2] = s2;
        to[3] = s3;
    }
}

/* The state of row i from n stages. It is evaluated where it is, unless joints follow signals: what
 * is given counts in forces, but not in sums of stages. */
static void stand(stein_sim *sim, int i, const double *w, int n, real h)
{
    real *row = sim->y0 + i * sim->stride;
    combine(sim, w, n, h, sim->y0, row);
    if (sim->motions) {
        copy(sim->x, row, 2 * sim->model->nq);
    } else {
        sim->xq = row;
        sim->xqd = row + sim->model->nq;
    }
}

/* qdd into row i */
ALWAYS stein_status derive(stein_sim *sim, int i, real t, stein_err *err)
{
    real *k = sim->k + i * sim->stride;
#if STEIN_LANES == 1
    if (sim->loop.near) {
        return stein__singular_derive(sim, t, i == MAX_STAGES, k, err);
    }
#endif
    return stein__evaluate(sim, t, sim->xq, sim->xqd, k + sim->model->nq, err);
}

/* the largest |h e_q| and |h e_qd| of the embedded estimate */
static void estimate(stein_sim *sim, const tableau *rk, real h)
{
    int nq = sim->model->nq;
    sim->eq = sim->eqd = same(rk->embedded ? 0.0 : -1.0);
    if (rk->embedded) {
        combine(sim, rk->e, rk->stages + 1, h, sim->zero, sim->e);
        for (int j = 0; j < nq; j++) {
            sim->eq = larger(magnitude(sim->e[j]), sim->eq);
            sim->eqd = larger(magnitude(sim->e[nq + j]), sim->eqd);
        }
    }
}

/* Gustafsson's controller, see adapt.c */
INNER stein__grade stein__graded(const stein_sim *sim, real h, real tolerance, real log_last)
{
    static const double least = STEIN__LEAST_GROWTH, no_less = 1e-12;
    real e = larger(sim->eq, h * sim->eqd) / tolerance;
    mask is_number = at_most(e, DBL_MAX);
    mask fails = both(more(e, 1.0), no(less(h, STEIN__SHORTEST)));
    real log_e = stein__log(sel(both(is_number, more(e, no_less)), e, same(no_less)));
    real factor = 0.9 * stein__exp(0.04 * sel(fails, same(0.0), log_last) - 0.17 * log_e);
    factor = smaller(factor, same(STEIN__MOST_GROWTH));
    factor = sel(more(factor, least), factor, same(least));
    return (stein__grade){sel(is_number, e, same((double)INFINITY)), log_e,
                          sel(is_number, factor, same(least)), same(0.0)};
}

/* What is uncertain about the speeds at the end of a step. RK4 has two stages in its middle. An end
 * that is far from the beginning is as bad as a difference of those by a `share`. In a step that
 * makes energy the last stage alone may be huge, and with it the end. DP5 has an estimate. */
static real doubt(const stein_sim *sim, real h)
{
    const real *k1 = sim->k, *k2 = k1 + sim->stride, *k3 = k2 + sim->stride;
    const real *k4 = k3 + sim->stride;
    int nq = sim->model->nq;
    real most = same(0.0);
    if (sim->def.integrator != STEIN_RK4) {
        return sim->eqd;
    }
    for (int j = nq; j < 2 * nq; j++) {
        most = larger(magnitude(h * (k3[j] - k2[j])), most);
        most = larger(magnitude(share * h * (k4[j] - k1[j])), most);
    }
    return most;
}

INNER mask stein__abrupt(const stein_sim *sim, real h)
{
    real speed = same(0.0);
    for (int j = 0; j < sim->model->nq; j++) {
        speed = larger(magnitude(sim->qd1[j]), speed);
    }
    return more(doubt(sim, h), share * speed);
}

/* The end is row 6 of every tableau. */
static stein_status make_rows(stein_sim *sim, const tableau *rk, real t, real h, stein_err *err)
{
    stein_status status = STEIN_OK;
    sim->inside = IN_STAGE;
    for (int i = 1; status == STEIN_OK && i < rk->stages; i++) {
        stand(sim, i, rk->a[i], i, h);
        status = derive(sim, i, t + rk->c[i] * h, err);
    }
    sim->inside = AT_END;
    if (status != STEIN_OK) {
        return status;
    }
    stand(sim, MAX_STAGES, rk->b, rk->stages, h);
#if STEIN_LANES == 1
    if (sim->model->nrow > 0) {
        status = stein__loops_project(sim, t + h, err);
    }
    if (status == STEIN_OK && sim->model->nstick > 0) {
        status = stein__stick_project(sim, t + h, err);
    }
    if (status != STEIN_OK) {
        return status;
    }
    if (sim->switches_at_end) {
        stein__drive_from(sim, t + h, sim->xq, sim->xqd);
        return STEIN_OK;
    }
#endif
    return derive(sim, MAX_STAGES, t + h, err);
}

INNER stein_status stein__trial(stein_sim *sim, real t, real h, stein_err *err)
{
    const tableau *rk = sim->def.integrator == STEIN_RK4 ? &rk4 : &dp5;
    int nq = sim->model->nq;
    copy(sim->q0, sim->q, nq);
    copy(sim->qd0, sim->qd, nq);
    copy(sim->qdd0, sim->qdd, nq);
#if STEIN_LANES == 1
    stein__find_active(sim);
#endif
    stein_status status = make_rows(sim, rk, t, h, err);
    if (sim->motions) {
        copy(sim->q1, sim->x, 2 * nq); // prescribed joints exactly on track
    } else {
        copy(sim->x, sim->xq, 2 * nq);
        sim->xq = sim->x;
        sim->xqd = sim->x + nq;
    }
    if (status == STEIN_OK && !sim->switches_at_end) {
        estimate(sim, rk, h);
    }
    return status;
}
