/* SPDX-License-Identifier: GPL-3.0-or-later
 * force_response.c - what a small force on a joint does to the channels of a stroke.
 *
 *      dr/df = (r(f) - r(0)) / f,      f so small that r changes by a third of the noise
 *
 * Where even the largest plausible force does less, that force is the difference. In a phase the
 * force is constant; it comes and goes linearly within one frame, as steps of controlled error do
 * not end where a force jumps.
 *
 * Each push is a whole stroke with the force added to the equations, so that it acts through all
 * contacts and moves their events as a real force would.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "diagnosing.h"

enum { TRIES = 6 };
static const double wanted = 0.3, least = 0.03, most = 1.5; /* RMS change of a stroke [noise] */
static const double first_guess = 1e-6;                     /* [N m or N] */
static const double longest_stride = 1e4;                   /* of the guesses */

typedef struct job {
    const fit__problem *p;
    const double *x, *r, *time;
    const char *const *phase;
    diag__push *push;
} job;

/* the force of one push while its stroke runs */
typedef struct acting {
    const diag__push *push;
    const double *time;       /* [n] of the stroke */
    const char *const *phase; /* [n] */
    int n, at;                /* at: the frame found last */
    double amplitude;
} acting;

static double shape(acting *a, double t)
{
    const diag__push *push = a->push;
    if (push->phase < 0) {
        return fmax(0.0, 1.0 - fabs(t - push->knot) / push->width);
    }
    while (a->at + 1 < a->n && a->time[a->at + 1] <= t) {
        a->at++;
    }
    while (a->at > 0 && a->time[a->at] > t) {
        a->at--;
    }
    int here = a->phase[a->at] == diag__phase[push->phase], next = here;
    double from = a->time[a->at], to = from;
    if (a->at + 1 < a->n && isfinite(a->time[a->at + 1])) {
        to = a->time[a->at + 1];
        next = a->phase[a->at + 1] == diag__phase[push->phase];
    }
    double share = to > from ? fmin(1.0, fmax(0.0, (t - from) / (to - from))) : 0.0;
    return here + share * (next - here);
}

static void act(void *ctx, double t, const double *q, const double *qd, double *Q)
{
    acting *a = ctx;
    (void)q;
    (void)qd;
    Q[a->push->joint] += a->amplitude * shape(a, t);
}

/* residuals with the force less those without, into the column. @return RMS change, NAN: failed */
static double change(const job *j, fit__bench *b, const diag__push *push, acting *a)
{
    const fit__stroke *s = &j->p->stroke[push->stroke];
    const double *r = j->r + fit__offset(j->p, push->stroke);
    double sum = 0.0;
    b->force = act;
    b->force_ctx = a;
    int bad = fit__simulate(j->p, b, push->stroke, j->x, push->column, NULL) != STEIN_OK;
    b->force = NULL;
    if (bad) {
        return NAN;
    }
    fit__weigh(s, push->column);
    for (int i = 0; i < s->nch * s->n; i++) {
        push->column[i] -= r[i];
        sum += push->column[i] * push->column[i];
    }
    return sqrt(sum / fmax(1.0, s->samples));
}

static void one_push(void *ctx, fit__bench *b, int index)
{
    job *j = ctx;
    diag__push *push = &j->push[index];
    const fit__stroke *s = &j->p->stroke[push->stroke];
    size_t row = diag__frame(j->p, push->stroke);
    acting a = {push, j->time + row, j->phase + row, s->n, 0, push->amplitude};
    int known = push->amplitude > 0.0;
    a.amplitude = known ? a.amplitude : fmin(first_guess, push->limit);
    double moved = NAN;
    for (int i = 0; i < TRIES; i++) {
        moved = change(j, b, push, &a);
        // a guess from elsewhere may be weak here: then the force matters little here
        int enough = moved >= least || known || a.amplitude >= push->limit;
        if ((enough && moved <= most) || i == TRIES - 1) {
            break;
        }
        double stride = isnan(moved) ? 1e-2 : wanted / fmax(moved, wanted / longest_stride);
        a.amplitude = fmin(a.amplitude * stride, push->limit);
    }
    push->amplitude = a.amplitude;
    for (int i = 0; i < s->nch * s->n; i++) {
        push->column[i] = moved > 0.0 ? push->column[i] / a.amplitude : 0.0;
    }
}

stein_status diag__force_columns(const fit__problem *p, const double *x, const double *r,
                                 const char *const *phase, const double *time, diag__push *push,
                                 int n, stein_err *err)
{
    job j = {.p = p, .x = x, .r = r, .time = time, .phase = phase, .push = push};
    return fit__parallel(p, n, one_push, &j, err);
}
