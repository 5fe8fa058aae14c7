/* SPDX-License-Identifier: GPL-3.0-or-later
 * parts.c - could a part stand in the leader's place, and how much of it?
 *
 * The leader's end describes the strokes. Without the leader they are off by what it does, and a
 * part that does the same brings them back - at some amount. That is far from linear in it (a link
 * that bends a little follows slowly, one that bends more rings), so no derivative is asked:
 *
 *      chi2(a) over a few strokes,  a = limit * 10^-3 ... limit,  everything else as at that end
 *
 * Parts that take away most of the misfit at their best amount are fitted in full from there.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "functions.h"
#include "searching.h"

enum { AMOUNTS = 10, STROKES = 3 };
static const double decades = 3.0; /* below the limit */
static const double takes = 0.5;   /* of the misfit, to be worth a fit */

typedef struct scan {
    const double *x; /* all unknowns at the leader's end */
    const diag__suspect *part;
    int stroke[STROKES], nstroke;
    double chi2[AMOUNTS * STROKES]; /* INFINITY where it cannot be simulated */
} scan;

static double amount_at(int k)
{
    return stein__power(10.0, -decades * (1.0 - (double)k / (AMOUNTS - 1)));
}

/* one amount on one stroke */
static stein_status ask(void *ctx, fit__bench *b, int job)
{
    const scan *c = ctx;
    return diag__begin_with(c->part->fit, b, c->part, c->x, amount_at(job / c->nstroke),
                            c->stroke[job % c->nstroke], b->y);
}

static void take(void *ctx, fit__bench *b, int job, int failed)
{
    scan *c = ctx;
    const fit__stroke *data = &c->part->fit->stroke[c->stroke[job % c->nstroke]];
    c->chi2[job] = INFINITY;
    if (!failed) {
        c->chi2[job] = 0.0;
        fit__weigh(data, b->y);
        for (int i = 0; i < data->nch * data->n; i++) {
            c->chi2[job] += b->y[i] * b->y[i];
        }
    }
}

static double sum_of(const scan *c, int k)
{
    double sum = 0.0;
    for (int i = 0; i < c->nstroke; i++) {
        sum += c->chi2[k * c->nstroke + i];
    }
    return sum;
}

/* swap and start of a part, from its scan; swap INFINITY: it does not bring the strokes back
 * @param share  of the misfit that may be left */
static stein_status judge(diag__suspect *s, const scan *c, double share, double samples,
                          stein_err *err)
{
    size_t nu = (size_t)s->fit->nu;
    int best = 0;
    for (int k = 1; k < AMOUNTS; k++) {
        best = sum_of(c, k) < sum_of(c, best) ? k : best;
    }
    double least = sum_of(c, best) - samples, none = sum_of(c, 0) - samples;
    s->swap = INFINITY;
    if (best == 0 || !(least < share * none)) {
        return STEIN_OK;
    }
    if (s->start == NULL) {
        s->start = malloc(sizeof *s->start * nu);
    }
    if (s->start == NULL) {
        return lab__no_memory(err);
    }
    memcpy(s->start, c->x, sizeof *s->start * nu);
    memset(s->start + s->fit->amount, 0, sizeof *s->start * FIT__NUMBERS);
    s->start[s->fit->amount] = amount_at(best);
    s->swap = least;
    return STEIN_OK;
}

stein_status diag__scan_parts(diag *d, const diag__suspect *leader, stein_err *err)
{
    const fit__problem *p = &d->p;
    scan c = {.x = leader->x, .nstroke = p->nstroke < STROKES ? p->nstroke : STROKES};
    double samples = 0.0;
    for (int i = 0; i < c.nstroke; i++) {
        c.stroke[i] = (2 * i + 1) * p->nstroke / (2 * c.nstroke);
        samples += p->stroke[c.stroke[i]].samples;
    }
    stein_status status = STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < d->n; i++) {
        diag__suspect *s = &d->suspect[i];
        s->swap = INFINITY;
        if (s->fit == NULL || s->never != NULL || s == leader) {
            continue;
        }
        c.part = s;
        s->fit->horizon = INFINITY;
        d->out->strokes_simulated += AMOUNTS * c.nstroke;
        status = fit__many(s->fit, AMOUNTS * c.nstroke, ask, take, &c, err);
        double share = diag__related(&s->s.candidate, &leader->s.candidate) ? 1.0 : takes;
        status = status == STEIN_OK ? judge(s, &c, share, samples, err) : status;
    }
    return status;
}
