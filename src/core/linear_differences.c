/* SPDX-License-Identifier: MIT
 * linear_differences.c - slopes of accelerations and outputs along a direction of q and qd, by
 * differences.
 *
 * Central differences at h, h/2, h/4 .. and Neville's extrapolation to h = 0, of which that one is
 * taken whose neighbours it differs from least (Ridders 1982). Long steps are good where the
 * motion is smooth, short ones where a contact is pressed in by little: each number finds its own.
 */
#include <math.h>
#include <string.h>

#include "linear.h"

enum { LEVELS = 26, MIDDLE = 10, ORDERS = 4 }; /* steps; extrapolations of each, to h^10 */
static const double longest = 0x1p-6;          /* [rad or m], [rad/s or m/s] along the direction */

int stein__linear_levels(void)
{
    return LEVELS;
}

/* what a derivative is along */
typedef struct way {
    const double *dq, *dqd; /* NULL: 0 */
    stein__nudge *nudge;
} way;

/* accelerations and channels at `share` of the direction from the state, added `times` to sum */
static stein_status look(stein_linear *l, const way *w, double share, double times, double *sum,
                         stein_err *err)
{
    stein_sim *sim = l->sim;
    int n = l->model->nq;
    for (int j = 0; j < n; j++) {
        sim->q[j] = l->q[j] + (w->dq != NULL ? share * w->dq[j] : 0.0);
        sim->qd[j] = l->qd[j] + (w->dqd != NULL ? share * w->dqd[j] : 0.0);
    }
    if (w->nudge != NULL) {
        w->nudge->more = share;
    }
    sim->fresh = STALE;
    stein_status status = stein__evaluate(sim, sim->head->t, sim->q, sim->qd, sim->qdd, err);
    if (status != STEIN_OK) {
        return status;
    }
    sim->fresh = FRESH;
    for (int j = 0; j < n; j++) {
        sum[j] += times * sim->qdd[j];
    }
    for (int i = 0; i < l->model->nchannel; i++) {
        sum[n + i] += times * stein_read(sim, i);
    }
    return STEIN_OK;
}

static double power_of_half(int k)
{
    return 1.0 / (double)(1u << k);
}

/* The best extrapolation of differences [LEVELS], `stride` apart. Neighbours may agree by chance or
 * because they are rounded alike. What counts is the worse one of two levels, and the effect of
 * rounding of numbers of this size on a difference. */
static double extrapolate(const double *differences, int stride, double size, double *off)
{
    double row[ORDERS + 1] = {0.0}, before[ORDERS + 1] = {0.0};
    double e[ORDERS + 1] = {0.0}, e_before[ORDERS + 1] = {0.0}, best = NAN;
    *off = INFINITY;
    for (int k = 0; k < LEVELS; k++) {
        double power = 1.0;
        row[0] = differences[k * stride];
        for (int j = 1; j <= k && j <= ORDERS; j++) {
            power *= 4.0;
            row[j] = (power * row[j - 1] - before[j - 1]) / (power - 1.0);
            e[j] = fmax(fabs(row[j] - row[j - 1]), fabs(row[j] - before[j - 1])) +
                   0x1p-52 * size / (longest * power_of_half(k));
            double worse = j < k ? fmax(e[j], e_before[j]) : INFINITY;
            if (worse < *off) {
                *off = worse;
                best = row[j];
            }
        }
        memcpy(before, row, sizeof row);
        memcpy(e_before, e, sizeof e);
    }
    return best;
}

stein_status stein__linear_differences(stein_linear *l, const double *dq, const double *dqd,
                                       stein__nudge *nudge, stein_err *err)
{
    const way w = {dq, dqd, nudge};
    int size = l->model->nq + l->model->nchannel;
    double h = longest;
    stein_status status = STEIN_OK;
    memset(l->table, 0, sizeof *l->table * (size_t)(LEVELS * size));
    for (int k = 0; k < LEVELS && status == STEIN_OK; k++, h *= 0.5) {
        double *at = l->table + k * size;
        status = look(l, &w, h, 0.5 / h, at, err);
        status = status == STEIN_OK ? look(l, &w, -h, -0.5 / h, at, err) : status;
    }
    const double *middle = l->table + MIDDLE * size;
    double largest = 0.0; // accelerations are made of the same forces
    for (int j = 0; j < l->model->nq; j++) {
        largest = fmax(largest, fabs(middle[j]));
    }
    for (int i = 0; i < size && status == STEIN_OK; i++) {
        double own = i < l->model->nq ? largest : fabs(middle[i]);
        l->slope[i] = extrapolate(l->table + i, size, own, &l->off[i]);
    }
    return status;
}
