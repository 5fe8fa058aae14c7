/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_unwrap.c - angles that a sensor or a tracker keeps within one turn.
 *
 * A coordinate of the model has no end: behind +180 deg comes +181, not -179. So an angle with all
 * values within one turn is made continuous where it jumps from one end to the other. A jump is
 * more than three quarters of a turn from one sample to the next. A motion slower than a quarter of
 * a turn a sample wraps by more, and a faster one can hardly be followed.
 */
#include <math.h>
#include <string.h>

#include "data_internal.h"

static const double turn = 6.283185307179586476925, jump = 0.75;

/* can a column of this kind wrap? */
static int is_angle(const stein_model *m, const lab_column *c)
{
    if (strcmp(c->unit, "rad") != 0) {
        return 0;
    }
    return c->role == LAB_INPUT ? m->inputs[c->index].kind == STEIN_INPUT_MOTION
                                : stein_reads_place((int)m->channels[c->index].read);
}

static int stays_within_a_turn(const lab_column *c, int n)
{
    double low = INFINITY, high = -INFINITY;
    for (int i = 0; i < n; i++) {
        low = c->present[i] ? fmin(low, c->value[i]) : low;
        high = c->present[i] ? fmax(high, c->value[i]) : high;
    }
    return high - low <= turn * (1.0 + 1e-3);
}

/* 1: from a to b it passes the lower end, -1 the upper one; 0: neither, or a is NAN */
static int wrap(double a, double b)
{
    return fabs(b - a) > jump * turn ? (b > a ? 1 : -1) : 0;
}

int data__unwrap(const stein_model *m, lab_column *c, double *value, int n)
{
    int wraps = 0, turns = 0;
    if (!is_angle(m, c) || !stays_within_a_turn(c, n)) {
        return 0;
    }
    double before = NAN;
    for (int i = 0; i < n; i++) {
        if (!c->present[i]) {
            continue;
        }
        int w = wrap(before, value[i]);
        wraps += w != 0;
        turns += w;
        before = value[i];
        value[i] -= turn * turns;
    }
    return wraps;
}
