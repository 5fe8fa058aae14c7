/* SPDX-License-Identifier: MIT
 * table.c - laws given by points: the curve, and where it acts.
 *
 *      y(x) = (1 + 2u)(1 - u)^2 y_0 + u^2 (3 - 2u) y_1 + h u (1 - u) [(1 - u) s_0 - u s_1]
 *
 * with u = (x - x_0)/h in 0..1 between two points (Hermite), slopes s as law.h has them. A monotone
 * choice of slopes (Fritsch & Carlson 1980) would never overshoot, but is not linear in the
 * values. A fitted curve would then change its shape with its size, and have no derivative at 0. A
 * straight line from point to point has kinks, each of which a controlled step would have to find.
 *
 * Beyond the ends the curve is level: a force that went on growing there with the speed, as a fit
 * may well try, would drive a mechanism to infinity.
 *
 * Slopes are worked out once per parameter set. A table that is 0 everywhere is not looked at.
 */
#include "core.h"

static inline real secant(const real *at, const real *value, int i)
{
    real h = at[i + 1] - at[i];
    return sel(more(h, 0.0), over(value[i + 1] - value[i], h), same(0.0));
}

static inline void slopes_of(int n, const real *at, const real *value, real *slope)
{
    slope[0] = secant(at, value, 0);
    slope[n - 1] = secant(at, value, n - 2);
    for (int i = 1; i < n - 1; i++) {
        real before = at[i] - at[i - 1], after = at[i + 1] - at[i];
        real s =
            over(after * secant(at, value, i - 1) + before * secant(at, value, i), before + after);
        slope[i] = sel(both(more(before, 0.0), more(after, 0.0)), s, same(0.0));
    }
}

/* two points of a table beside each other */
typedef struct span {
    real x0, x1, y0, y1, s0, s1;
} span;

/* The points around x, or the two at the end behind which it is: along the points to the first one
 * that x is before, in lanes without a branch that differs from lane to lane. */
static inline span span_of(int n, const real *at, const real *value, const real *slope, real x)
{
#if STEIN_LANES > 1
    span s = {at[0], at[1], value[0], value[1], slope[0], slope[1]};
    mask beyond = no((mask){0});
    for (int k = 1; k < n - 1; k++) {
        beyond = both(beyond, no(less(x, at[k])));
        if (!any(beyond)) {
            break;
        }
        s = (span){sel(beyond, at[k], s.x0),    sel(beyond, at[k + 1], s.x1),
                   sel(beyond, value[k], s.y0), sel(beyond, value[k + 1], s.y1),
                   sel(beyond, slope[k], s.s0), sel(beyond, slope[k + 1], s.s1)};
    }
    return s;
#else
    int k = 0;
    while (k + 2 < n && !less(x, at[k + 1])) {
        k++;
    }
    return (span){at[k], at[k + 1], value[k], value[k + 1], slope[k], slope[k + 1]};
#endif
}

static inline real curve_at(int n, const real *at, const real *value, const real *slope, real x)
{
    span s = span_of(n, at, value, slope, x);
    real h = s.x1 - s.x0, u = over(x - s.x0, h), v = 1.0 - u;
    real y = (1.0 + 2.0 * u) * v * v * s.y0 + u * u * (1.0 + 2.0 * v) * s.y1 +
             h * u * v * (v * s.s0 - u * s.s1);
    y = sel(more(h, 0.0), y, s.y0);
    y = sel(less(x, at[n - 1]), y, value[n - 1]);
    return sel(more(x, at[0]), y, value[0]);
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
        mask on = {0};
        for (int k = 0; k < t->n; k++) {
            on = either(on, differ(value[k], 0.0));
        }
        sim->table_on[i] = (flag)on;
        sim->ntable_on += any(on);
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
        mask on = mask_of(sim->table_on[i]);
        if (any(on) && t->kind <= STEIN_TABLE_SPEED) {
            real x = t->kind == STEIN_TABLE_POSITION ? sim->xq[t->index] : sim->xqd[t->index];
            real *Q = &sim->Q[t->index];
            *Q = sel(on, *Q + read_table(sim, t, slope, x), *Q);
        }
        slope += t->n;
    }
}

INNER real stein__tables_normal(const stein_sim *sim, int index, real force, real x, real xdot)
{
    const real *slope = sim->slope;
    real factor = same(1.0), sum = force;
    mask inside = more(x, 0.0), found = {0};
    if (!any(inside)) {
        return force;
    }
    for (int i = 0; i < sim->model->ntable; i++) {
        const stein_table *t = &sim->model->tables[i];
        mask on = mask_of(sim->table_on[i]);
        if (any(on) && t->kind == STEIN_TABLE_DEPTH && t->index == index) {
            found = either(found, on);
            sum = sel(on, sum + read_table(sim, t, slope, x), sum);
        } else if (any(on) && t->kind > STEIN_TABLE_DEPTH && t->index == index) {
            found = either(found, on);
            factor = sel(on, factor + read_table(sim, t, slope, xdot), factor);
        }
        slope += t->n;
    }
    sum *= factor;
    sum = sel(both(more(sum, 0.0), more(factor, 0.0)), sum, same(0.0));
    return sel(both(inside, found), sum, force);
}
