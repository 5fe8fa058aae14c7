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
 * Slopes are worked out once per parameter set. A table that is 0 everywhere is not looked at.
 */
#include "core.h"

/* the number of lane k */
#if STEIN_LANES > 1
#define LANE(k, x)       ((x)[k])
#define IS_LESS(k, x, y) ((x)[k] < (y)[k])
#else
#define LANE(k, x)       (x)
#define IS_LESS(k, x, y) less(x, y)
#endif

static inline real secant(const real *at, const real *value, int i)
{
    real h = at[i + 1] - at[i];
    return sel(more(h, 0.0), (value[i + 1] - value[i]) / h, same(0.0));
}

static inline void slopes_of(int n, const real *at, const real *value, real *slope)
{
    slope[0] = secant(at, value, 0);
    slope[n - 1] = secant(at, value, n - 2);
    for (int i = 1; i < n - 1; i++) {
        real before = at[i] - at[i - 1], after = at[i + 1] - at[i];
        real s =
            (after * secant(at, value, i - 1) + before * secant(at, value, i)) / (before + after);
        slope[i] = sel(both(more(before, 0.0), more(after, 0.0)), s, same(0.0));
    }
}

/* two points of a table beside each other */
typedef struct span {
    real x0, x1, y0, y1, s0, s1;
} span;

/* the points around x, or the two at the end behind which it is */
static inline span span_of(int n, const real *at, const real *value, const real *slope, real x)
{
    span s = {.x0 = at[0]};
    for (int k = 0; k < (STEIN_LANES > 1 ? STEIN_LANES : 1); k++) {
        int lo = 0, hi = n - 1;
        while (hi - lo > 1) {
            int middle = (lo + hi) / 2;
            int *end = IS_LESS(k, x, at[middle]) ? &hi : &lo;
            *end = middle;
        }
        LANE(k, s.x0) = LANE(k, at[lo]);
        LANE(k, s.x1) = LANE(k, at[hi]);
        LANE(k, s.y0) = LANE(k, value[lo]);
        LANE(k, s.y1) = LANE(k, value[hi]);
        LANE(k, s.s0) = LANE(k, slope[lo]);
        LANE(k, s.s1) = LANE(k, slope[hi]);
    }
    return s;
}

static inline real curve_at(int n, const real *at, const real *value, const real *slope, real x)
{
    span s = span_of(n, at, value, slope, x);
    real h = s.x1 - s.x0, u = (x - s.x0) / h, v = 1.0 - u;
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
