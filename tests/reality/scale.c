/* SPDX-License-Identifier: GPL-3.0-or-later
 * scale.c - the amount of an effect that has a given size after refitting (refit.c).
 */
#include <math.h>

#include "reality.h"

static const double close_enough = 0.02;
enum { MAX_TRIES = 14 };

typedef struct bracket {
    double low, high; /* amounts known to be too small, too large; high 0: none yet */
    double a0, m0;    /* last try */
} bracket;

/* the next amount: secant in logarithms, kept inside what is known (halved there if it leaves) */
static double next_amount(const bracket *b, double a, double m, double target)
{
    double slope = 1.0;
    if (b->m0 > 0.0 && fabs(log(a / b->a0)) > 1e-6) {
        slope = log(m / b->m0) / log(a / b->a0);
        slope = slope > 0.3 && slope < 4.0 ? slope : 1.0;
    }
    double next = m > 0.0 ? a * fmin(fmax(pow(target / m, 1.0 / slope), 0.02), 20.0) : 20.0 * a;
    if (b->high > 0.0 && b->low > 0.0 && !(next > b->low && next < b->high)) {
        next = sqrt(b->low * b->high);
    }
    return next;
}

int refit_scale(refit *r, effect *e, double target, double *reached)
{
    double sign = e->amount < 0.0 ? -1.0 : 1.0, limit = 1.0, a = 0.05;
    bracket b = {0.0, 0.0, 0.0, 0.0};
    for (int n = 0; n < MAX_TRIES; n++) {
        double m;
        e->amount = sign * a;
        if (refit_size(r, e, &m) != 0) { // the action does not survive that much
            limit = 0.7 * a;
            a = 0.5 * limit;
            continue;
        }
        *reached = m;
        if (fabs(m / target - 1.0) < close_enough) {
            return 0;
        }
        if (m < target && a >= limit) {
            return 1;
        }
        b.low = m < target ? a : b.low;
        b.high = m > target ? a : b.high;
        double next = next_amount(&b, a, m, target);
        b.a0 = a;
        b.m0 = m;
        a = fmin(next, limit);
    }
    return 1;
}
