/* SPDX-License-Identifier: GPL-3.0-or-later
 * run.c - motion in time: Bogacki and Shampine's pair would do, Dormand and Prince's (1980) of
 * orders 5 and 4 takes fewer steps. The step follows the difference of both orders; where a contact
 * begins or ends it shrinks by itself.
 */
#include <math.h>
#include <string.h>

#include "world.h"

enum { STAGES = 7 };
static const double least_step = 1e-10, largest_step = 0.02;

static const double node[STAGES] = {0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0};
static const double stage[STAGES][STAGES - 1] = {
    {0.0},
    {1.0 / 5.0},
    {3.0 / 40.0, 9.0 / 40.0},
    {44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0},
    {19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0},
    {9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0},
    {35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0}};
/* order 5 less order 4 */
static const double off[STAGES] = {
    71.0 / 57600.0,      0.0,          -71.0 / 16695.0, 71.0 / 1920.0,
    -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0};

/* One trial. @return its error over the tolerance, NAN: no rates */
static double trial(play *s, const state *x, double h, double tolerance, state *to)
{
    int n = s->m->nbody;
    double v[STAGES][BODIES], a[STAGES][BODIES], worst = 0.0;
    for (int k = 0; k < STAGES; k++) {
        *to = *x;
        for (int i = 0; i < n; i++) {
            for (int j = 0; j < k; j++) {
                to->q[i] += h * stage[k][j] * v[j][i];
                to->qd[i] += h * stage[k][j] * a[j][i];
            }
        }
        if (motion_rates(s, x->t + node[k] * h, to->q, to->qd, a[k]) != 0) {
            return NAN;
        }
        memcpy(v[k], to->qd, sizeof v[k]);
    }
    for (int i = 0; i < n; i++) {
        double dq = 0.0, dv = 0.0;
        for (int k = 0; k < STAGES; k++) {
            dq += h * off[k] * v[k][i];
            dv += h * off[k] * a[k][i];
        }
        worst = fmax(worst, fabs(dq) / (tolerance * (0.1 + fabs(x->q[i]))));
        worst = fmax(worst, fabs(dv) / (tolerance * (0.5 + fabs(x->qd[i]))));
    }
    to->t = x->t + h;
    return worst;
}

int run_to(play *s, state *x, double until, double tolerance)
{
    double wanted = x->h > 0.0 ? x->h : 1e-4;
    while (x->t < until) {
        state to;
        double rest = until - x->t, h = wanted < rest ? wanted : rest;
        double error = trial(s, x, h, tolerance, &to);
        if (!isfinite(error)) {
            error = 1e9;
        }
        if (error <= 1.0) {
            *x = to;
            x->t = h < rest ? to.t : until;
        } else if (h < least_step) {
            return -1;
        }
        double factor = 0.9 * pow(fmax(error, 1e-6), -0.2);
        double next = h * fmin(4.0, fmax(0.1, factor));
        // a step that was cut by the end gives no length for the next one
        wanted = error > 1.0 || h >= wanted ? next : fmax(next, wanted);
        wanted = fmin(wanted, largest_step);
    }
    x->h = wanted;
    return 0;
}

int run_settle(play *s, state *x)
{
    enum { ROUNDS = 100 };
    static const double round_time = 0.1, at_rest = 1e-8; /* [s], [rad/s, m/s] */
    int n = s->m->nbody, status = 0;
    s->calm = 40.0;
    for (int k = 0; k < ROUNDS && status == 0; k++) {
        double fastest = 0.0;
        x->t = 0.0;
        status = run_to(s, x, round_time, 1e-10);
        for (int i = 0; i < n; i++) {
            fastest = fmax(fastest, fabs(x->qd[i]));
        }
        if (fastest < at_rest) {
            break;
        }
    }
    s->calm = 0.0;
    x->t = 0.0;
    memset(x->qd, 0, sizeof x->qd);
    return status;
}
