/* SPDX-License-Identifier: MIT
 * dense_output.c - dense output of a trial step, and guards at given coordinates, for a simulation
 * alone or in lanes.
 */
#include "core.h"

#if STEIN_LANES == 1

/* Of an implicit step, order 4: in a quintic, the derivatives at its ends would bring in motions
 * that have decayed.
 *      y = v y0 + u (y1 + v (d1 + u (d2 + u d3))) */
static void interpolate_implicit(const stein_sim *sim, double u, double *q, double *qd)
{
    int n = sim->model->nq;
    double v = 1.0 - u;
    for (int j = 0; j < (qd != NULL ? 2 * n : n); j++) {
        const double *d = sim->implicit->dense + j;
        double y0 = j < n ? sim->q0[j] : sim->qd0[j - n], y1 = j < n ? sim->q1[j] : sim->qd1[j - n];
        double y = v * y0 + u * (y1 + v * (d[0] + u * (d[2 * n] + u * d[4 * n])));
        *(j < n ? &q[j] : &qd[j - n]) = y;
    }
}

#endif

INNER void stein__interpolate(const stein_sim *sim, real h, double theta, real *q, real *qd)
{
#if STEIN_LANES == 1
    if (sim->implicit != NULL && sim->implicit->inside) {
        interpolate_implicit(sim, theta, q, qd);
        return;
    }
#endif
    double u = theta, v = 1.0 - theta;
    double u3 = u * u * u, v3 = v * v * v;
    double p0 = v3 * (1.0 + 3.0 * u + 6.0 * u * u), p1 = u3 * (1.0 + 3.0 * v + 6.0 * v * v);
    double s0 = v3 * u * (1.0 + 3.0 * u), s1 = -u3 * v * (1.0 + 3.0 * v);
    double a0 = 0.5 * v3 * u * u, a1 = 0.5 * u3 * v * v;
    for (int j = 0; j < sim->model->nq; j++) {
        q[j] = p0 * sim->q0[j] + p1 * sim->q1[j] + h * (s0 * sim->qd0[j] + s1 * sim->qd1[j]) +
               h * h * (a0 * sim->qdd0[j] + a1 * sim->qdd1[j]);
    }

    // its derivative
    double dp = 30.0 * u * u * v * v;
    double ds0 = v * v * (1.0 + 2.0 * u - 15.0 * u * u);
    double ds1 = u * u * (1.0 + 2.0 * v - 15.0 * v * v);
    double da0 = 0.5 * v * v * u * (2.0 - 5.0 * u), da1 = 0.5 * u * u * v * (5.0 * v - 2.0);
    for (int j = 0; qd != NULL && j < sim->model->nq; j++) {
        qd[j] = dp * (sim->q1[j] - sim->q0[j]) / h + ds0 * sim->qd0[j] + ds1 * sim->qd1[j] +
                h * (da0 * sim->qdd0[j] + da1 * sim->qdd1[j]);
    }
}

INNER void stein__pose_at(stein_sim *sim, const real *q)
{
    const stein_model *model = sim->model;
    if (model->nframe > 0) {
        turn_joints(sim, q, sim->sc);
        EQUATIONS(sim)->pose(q, sim->zero, sim->sc, sim->d, sim->pose);
    }
#if STEIN_LANES == 1
    if (model->npose3 > 0) {
        turn_joints(sim, q, sim->sc);
        stein__place3(sim, q, sim->zero);
    }
#endif
}

INNER void stein__guards(stein_sim *sim, const real *q, real *guard)
{
    const stein_model *model = sim->model;
    stein__pose_at(sim, q);
    for (int i = 0; i < model->nspot; i++) {
        guard[i] = stein__spot_guard(sim, i);
    }
    for (int i = 0; i < model->nnotch; i++) {
        real overlap;
        stein__notch_guards(sim, i, guard + model->nspot + NOTCH_GUARDS * i, &overlap);
    }
}

#if STEIN_LANES == 1

double stein__guard(const stein_sim *sim, int i)
{
    int nspot = sim->model->nspot;
    if (i < nspot) {
        return stein__spot_guard(sim, i);
    }
    double guard[NOTCH_GUARDS], overlap;
    stein__notch_guards(sim, (i - nspot) / NOTCH_GUARDS, guard, &overlap);
    return guard[(i - nspot) % NOTCH_GUARDS];
}

#endif
