/* SPDX-License-Identifier: GPL-3.0-or-later
 * derivative_support.h - differences with an error estimate, and the 1788 action with all of its
 * contacts closed.
 */
#ifndef DERIVATIVE_SUPPORT_H
#define DERIVATIVE_SUPPORT_H

#include <string.h>

#include "support.h"

enum { ROWS = 6, MOST = 16 };

/** y [n] at x. */
typedef void function_of(void *ctx, double x, double *y);

/** Derivatives of y [n <= MOST] at x by central differences with steps from h down, extrapolated
 * (Ridders 1982), each from the entry of its table that differs least from its neighbours. */
static inline void differences(function_of *f, void *ctx, double x, double h, int n, double *slope)
{
    double row[ROWS][MOST], last[ROWS][MOST], high[MOST], low[MOST], least[MOST];
    for (int i = 0; i < ROWS; i++, h *= 0.5) {
        f(ctx, x + h, high);
        f(ctx, x - h, low);
        for (int j = 0; j < n; j++) {
            row[0][j] = (high[j] - low[j]) / ((x + h) - (x - h));
            if (i == 0) {
                slope[j] = row[0][j];
                least[j] = INFINITY;
            }
            double factor = 4.0;
            for (int k = 1; k <= i; k++, factor *= 4.0) {
                row[k][j] = row[k - 1][j] + (row[k - 1][j] - last[k - 1][j]) / (factor - 1.0);
                double error =
                    fmax(fabs(row[k][j] - row[k - 1][j]), fabs(row[k][j] - last[k - 1][j]));
                if (error < least[j]) {
                    least[j] = error;
                    slope[j] = row[k][j];
                }
            }
        }
        memcpy(last, row, sizeof last);
    }
}

/** The action with every contact closed, the notch at tip and corner, and all of it sliding: its
 * regulation is changed until all touch where the parts are at rest. */
static inline stein_sim *all_closed(void)
{
    const stein_model *model = &stein_model_stein1788;
    stein_sim *sim = make_sim(model, STEIN_RK4, 0.0);
    double x[3 * 16], q[4], qd[4] = {0.013, -0.21, 0.17, -0.004}, corner;
    ck_assert_int_le(model->npoint, 16);
    memcpy(q, stein_q(sim), sizeof q);
    stein_points(sim, q, qd, x, NULL, NULL, NULL);
    double below = 0.0, head = 0.0;
    for (int i = 0; i < model->npoint; i++) {
        below = strcmp(model->points[i].name, "key.below") == 0 ? x[3 * i + 2] : below;
        head = strcmp(model->points[i].name, "hammer.head") == 0 ? x[3 * i + 2] : head;
    }
    ck_assert_stein(stein_get(sim, "pawl.corner.z", &corner, err));
    q[3] -= 0.03e-3; // the load
    ck_assert_stein(stein_set(sim, "pawl.corner.z", corner - 0.30e-3, err));
    ck_assert_stein(stein_set(sim, "dip.line.z", below + 0.05e-3, err));
    ck_assert_stein(stein_set(sim, "string.height", head - 0.04e-3, err));
    ck_assert_stein(stein_set_state(sim, 0.0, q, qd, err));
    return sim;
}

#endif
