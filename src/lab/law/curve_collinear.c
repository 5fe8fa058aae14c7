/* SPDX-License-Identifier: GPL-3.0-or-later
 * curve_collinear.c - numbers that move a stroke exactly as a curve does.
 *
 * A joint's spring is a straight line over its position: more stiffness and a curve that subtracts
 * it change nothing, and the data determine their sum only. Numerical differences of the two do not
 * cancel exactly; since the events of a stroke depend on a torque to 1 part in 10^5, their
 * remainder is a direction that seems determined. So the column of such a number is computed from
 * the columns of the curve,
 *
 *      dr/dp = sum_k dT/dp(x_k) dr/df_k      T: torque or force in the joint at the points x_k
 *
 * where p is in nothing but the law of that joint, dT/dp depends on no other state, and the curve
 * through its values at the points is dT/dp.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "curve_fitting.h"
#include "stein/law.h"

static const double eps = 1e-3;      /* of a difference, in x */
static const double exact = 1e-7;    /* relative */
static const double like = 0.1;      /* relative difference from the column that was simulated */
static const double elsewhere = 0.3; /* other state at which T is evaluated */

/* parameters at x, and constants of the equations with unknown u moved by dx */
static void constants(const diag__curves *w, const double *x, int u, double dx, double *p,
                      double *d)
{
    const stein_model *m = lab_equations(w->in->model);
    memcpy(p, lab_parameters(w->in->model), sizeof *p * (size_t)m->np);
    for (int k = 0; k < w->site[0].first; k++) {
        const fit__unknown *o = &w->p.unknown[k];
        if (o->kind == FIT__PARAM) {
            p[o->index] = fit__value(o, x[k] + (k == u ? dx : 0.0));
        }
    }
    stein_setup(m, p, d);
}

/* is the law of a joint all that differs? */
static int only_joint(const stein_model *m, int joint, const double *d1, const double *d2)
{
    int first = m->bodies[joint].joint, changes = 0;
    for (int i = 0; i < m->nd; i++) {
        int differs = d1[i] != d2[i] && (isfinite(d1[i]) || isfinite(d2[i]));
        if (differs && (i < first || i >= first + STEIN_JOINT_SIZE)) {
            return 0;
        }
        changes |= differs;
    }
    return changes;
}

/* dT/dx of two laws over the state of the curve; the other state is `other` */
static double slope_at(const diag__site *s, const double *law1, const double *law2, double at,
                       double other)
{
    int of_position = s->kind == STEIN_TABLE_POSITION;
    double q = of_position ? at : other, qd = of_position ? other : at;
    return (stein_joint_force(law2, q, qd) - stein_joint_force(law1, q, qd)) / (2.0 * eps);
}

/* dT/dx at the points. @return is the curve through them all of it? */
static int weights(const diag__site *s, const double *law1, const double *law2, double *weight)
{
    double slope[CURVE_POINTS], most = 0.0;
    for (int k = 0; k < s->n; k++) {
        weight[k] = slope_at(s, law1, law2, s->at[k], 0.0);
        most = fmax(most, fabs(weight[k]));
    }
    stein_table_slopes(s->n, s->at, weight, slope);
    int same = most > 0.0 && !(s->pinned && fabs(weight[0]) > exact * most);
    for (int k = 0; k + 1 < s->n && same; k++) {
        double x = 0.5 * (s->at[k] + s->at[k + 1]);
        double is = slope_at(s, law1, law2, x, k % 2 ? elsewhere : -elsewhere);
        same = fabs(stein_table_value(s->n, s->at, weight, slope, x) - is) <= exact * most;
    }
    return same;
}

/* in every stroke that this number moves as the curve does */
static void combine(const fit__problem *p, const diag__site *s, int u, const double *weight,
                    double *room, double *J)
{
    for (int i = 0; i < p->nstroke; i++) {
        size_t size = (size_t)p->stroke[i].nch * (size_t)p->stroke[i].n;
        double *column = J + fit__column(p, i, u), off = 0.0, all = 0.0;
        memset(room, 0, sizeof *room * size);
        for (int k = s->pinned; k < s->n; k++) {
            const double *by = J + fit__column(p, i, s->first + k);
            for (size_t j = 0; j < size; j++) {
                room[j] += weight[k] * by[j];
            }
        }
        for (size_t j = 0; j < size; j++) {
            off += (room[j] - column[j]) * (room[j] - column[j]);
            all += column[j] * column[j];
        }
        if (off <= like * like * all) {
            memcpy(column, room, sizeof *room * size);
        }
    }
}

stein_status diag__same_as_curve(const diag__curves *w, const diag__site *s, const double *x,
                                 double *J, stein_err *err)
{
    const fit__problem *p = &w->p;
    const stein_model *m = lab_equations(w->in->model);
    size_t np = (size_t)m->np, nd = (size_t)m->nd;
    if (s->kind != STEIN_TABLE_POSITION && s->kind != STEIN_TABLE_SPEED) {
        return STEIN_OK;
    }
    double *room = malloc(sizeof *room * (np + 2 * nd + (size_t)p->rows + 1));
    if (room == NULL) {
        return lab__no_memory(err);
    }
    double *d1 = room + np, *d2 = d1 + nd, weight[CURVE_POINTS] = {0.0};
    int law = m->bodies[s->index].joint;
    for (int u = 0; u < w->site[0].first; u++) {
        if (p->unknown[u].kind != FIT__PARAM || p->unknown[u].idle) {
            continue;
        }
        constants(w, x, u, -eps, room, d1);
        constants(w, x, u, eps, room, d2);
        if (only_joint(m, s->index, d1, d2) && weights(s, d1 + law, d2 + law, weight)) {
            combine(p, s, u, weight, d2 + nd, J);
        }
    }
    free(room);
    return STEIN_OK;
}
