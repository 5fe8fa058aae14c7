/* SPDX-License-Identifier: GPL-3.0-or-later
 * scale.c - the amount of an effect that has a given size after refitting (refit.c).
 *
 * The amount grows from a twentieth of its limit by at most a factor of four, so that every refit
 * begins near the one before. Where a refit diverges, shorter steps are taken from the last good
 * one; a size far beyond the wanted one has no further information.
 */
#include <math.h>

#include "reality.h"

static const double close_enough = 0.1; /* what is reached is in the answer */
static const double most = 4.0;         /* factor between two amounts */
static const double least = 1.01;       /* the size jumps where not even this can be followed */
static const double steepest = 2.0;     /* size ~ amount^2 at most, where it has begun to show: */
static const double begun = 1e-4;       /* before it, gaps may be closed */
enum { MAX_TRIES = 16 };

typedef struct search {
    double low, m;  /* greatest amount that is too small, its size; 0: none yet */
    double high;    /* smallest amount that is too large; 0: none yet */
    double stretch; /* factor from low to the next amount at most */
} search;

/* The next amount after one of size m: secant in logarithms, inside what is known. */
static double next_amount(search *b, double a, double m, double target)
{
    double next = a * fmin(fmax(target / m, 1.0 / most), b->stretch);
    if (refit_is_lost(m, target) && b->low > 0.0) {
        b->stretch = fmin(sqrt(b->stretch), sqrt(a / b->low));
        next = b->low * b->stretch;
    } else if (m > target && b->low > 0.0) {
        next = b->low * pow(target / b->m, log(a / b->low) / log(m / b->m));
    }
    int outside = b->high > 0.0 && b->low > 0.0 && !(next > b->low && next < b->high);
    return outside ? sqrt(b->low * b->high) : next;
}

/* can an amount up to the limit have the size at all */
static int is_hopeless(double a, double m, double limit, double target)
{
    return a >= limit || (m > begun * target && m * pow(limit / a, steepest) < target);
}

const char *refit_scale(refit *r, effect *e, double target, double *reached)
{
    static const char beyond_limit[] = "limit reached first", jumps[] = "size jumps";
    double sign = e->amount < 0.0 ? -1.0 : 1.0, limit = 1.0, a = 0.05, m;
    search b = {.stretch = most};
    refit_forget(r);
    e->amount = sign * limit;
    if (refit_raw(r, e, &m) == 0 && m < target) {
        *reached = m;
        return beyond_limit;
    }
    for (int n = 0; n < MAX_TRIES && b.stretch > least; n++) {
        e->amount = sign * a;
        if (refit_size(r, e, target, &m) != 0) { // the action does not survive that much
            limit = 0.7 * a;
            a = 0.5 * limit;
            continue;
        }
        *reached = m;
        if (fabs(m / target - 1.0) < close_enough) {
            return NULL;
        }
        if (m < target && is_hopeless(a, m, limit, target)) {
            return beyond_limit;
        }
        if (m < target) {
            refit_keep(r, e);
            b.low = a;
            b.m = m;
        } else if (!refit_is_lost(m, target)) {
            b.high = a;
        }
        if (b.high > 0.0 && b.low > 0.0 && b.high < least * b.low) {
            return jumps;
        }
        a = fmin(next_amount(&b, a, fmax(m, 1e-3 * target), target), limit);
    }
    return b.stretch > least ? "not found" : jumps;
}
