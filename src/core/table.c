/* SPDX-License-Identifier: MIT
 * table.c - laws given by points: the curve, and where it acts.
 *
 *      y(x) = (1 + 2u)(1 - u)^2 y_0 + u^2 (3 - 2u) y_1 + h u (1 - u) [(1 - u) s_0 - u s_1]
 *
 * with u = (x - x_0)/h in 0..1 between two points (Hermite), slopes s as law.h has them. A monotone
 * choice of slopes (Fritsch & Carlson 1980) would never overshoot, but is not linear in the values:
 * a curve that is fitted changes its shape with its size then, and has no derivative at 0. A
 * straight line from point to point has kinks, each of which a controlled step would have to find.
 *
 * Beyond the ends the curve is level: a force that went on growing there with the speed, as a fit
 * may well try, would drive a mechanism to infinity.
 *
 * Written in the words of real.h for derivatives (tangent.c); there are no tables in lanes.
 *
 * Slopes are worked out once per parameter set. A table that is 0 everywhere is not looked at.
 */
#include "core.h"

static inline real secant(const real *at, const real *value, int i)
{
    real h = at[i + 1] - at[i];
    return more(h, 0.0) ? (value[i + 1] - value[i]) / h : same(0.0);
}

static inline void slopes_of(int n, const real *at, const real *value, real *slope)
{
    slope[0] = secant(at, value, 0);
    slope[n - 1] = secant(at, value, n - 2);
    for (int i = 1; i < n - 1; i++) {
        real before = at[i] - at[i - 1], after = at[i + 1] - at[i];
        slope[i] = more(before, 0.0) && more(after, 0.0)
                       ? (after * secant(at, value, i - 1) + before * secant(at, value, i)) /
                             (before + after)
                       : same(0.0);
    }
}

static inline real curve_at(int n, const real *at, const real *value, const real *slope, real x)
{
    int lo = 0, hi = n - 1;
    if (!more(x, at[0])) {
        return value[0];
    }
    if (!less(x, at[hi])) {
        return value[hi];
    }
    while (hi - lo > 1) {
        int middle = (lo + hi) / 2;
        if (less(x, at[middle])) {
            hi = middle;
        } else {
            lo = middle;
        }
    }
    real h = at[hi] - at[lo];
    if (!more(h, 0.0)) {
        return value[lo];
    }
    real u = (x - at[lo]) / h, v = 1.0 - u;
    return (1.0 + 2.0 * u) * v * v * value[lo] + u * u * (1.0 + 2.0 * v) * value[hi] +
           h * u * v * (v * slope[lo] - u * slope[hi]);
}

#if STEIN_LANES == 1
void stein_table_slopes(int n, const double *at, const double *value, double *slope)
{
    slopes_of(n, at, value, slope);
}

double stein_table_value(int n, const double *at, const double *value, const double *slope,
                         double x)
{
    return curve_at(n, at, value, slope, x);
}

int stein__table_points(const stein_model *model)
{
    int n = 0;
    for (int i = 0; i < model->ntable; i++) {
        n += model->tables[i].n;
    }
    return n;
}
#endif

INNER void stein__tables_prepare(stein_sim *sim)
{
    real *slope = sim->slope;
    sim->ntable_on = 0;
    for (int i = 0; i < sim->model->ntable; i++) {
        const stein_table *t = &sim->model->tables[i];
        const real *at = sim->d + t->d, *value = at + t->n;
        sim->table_on[i] = 0;
        for (int k = 0; k < t->n; k++) {
            sim->table_on[i] |= differ(value[k], 0.0);
        }
        sim->ntable_on += sim->table_on[i];
        slopes_of(t->n, at, value, slope);
        slope += t->n;
    }
}

/* the value of table t, whose slopes are at `slope` */
static inline real read_table(const stein_sim *sim, const stein_table *t, const real *slope, real x)
{
    const real *at = sim->d + t->d;
    return curve_at(t->n, at, at + t->n, slope, x);
}

INNER void stein__tables_joints(stein_sim *sim)
{
    const real *slope = sim->slope;
    for (int i = 0; i < sim->model->ntable; i++) {
        const stein_table *t = &sim->model->tables[i];
        if (sim->table_on[i] && t->kind <= STEIN_TABLE_SPEED) {
            real x = t->kind == STEIN_TABLE_POSITION ? sim->xq[t->index] : sim->xqd[t->index];
            sim->Q[t->index] += read_table(sim, t, slope, x);
        }
        slope += t->n;
    }
}

INNER real stein__tables_normal(const stein_sim *sim, int index, real force, real x, real xdot)
{
    const real *slope = sim->slope;
    real factor = same(1.0), sum = force;
    int found = 0;
    if (!more(x, 0.0)) {
        return force;
    }
    for (int i = 0; i < sim->model->ntable; i++) {
        const stein_table *t = &sim->model->tables[i];
        if (sim->table_on[i] && t->kind >= STEIN_TABLE_DEPTH && t->index == index) {
            found = 1;
            if (t->kind == STEIN_TABLE_DEPTH) {
                sum += read_table(sim, t, slope, x);
            } else {
                factor += read_table(sim, t, slope, xdot);
            }
        }
        slope += t->n;
    }
    sum *= factor;
    return !found ? force : more(sum, 0.0) && more(factor, 0.0) ? sum : same(0.0);
}
