/* SPDX-License-Identifier: GPL-3.0-or-later
 * strays.c - single strokes that a fit has lost.
 *
 * A stroke has numbers of its own: when it began, how much friction it had that day. With wrong
 * ones it may escape a moment too late and bounce in another way ever after; its misfit then pulls
 * at what all strokes share, and no small step leads it back, while the others are fitted to their
 * noise. One stroke of twelve left at three noises is no physics. So it is left out for a while:
 *
 *      others fitted without it --> its own numbers anew, along its course --> all together
 */
#include <gsl/gsl_sort.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "searching.h"

enum { STROKES_MOST = 3, RENEWALS = 2 }; /* strays are a third of the strokes at most */
static const double settled = 1.3;       /* chi2 per sample of the stroke in the middle */
static const double lost = 1.25;         /* of a stray, in that one's */
static const double far_lost = 3.0;      /* the same where that one is not settled */
static const double worth = 100.0;       /* of chi2 */
static const double enough = 0.3;        /* of the objective */

static double misfit(const fit__problem *p, const double *r, int s)
{
    const fit__stroke *t = &p->stroke[s];
    double sum = 0.0;
    for (int i = 0; i < t->nch * t->n; i++) {
        double v = r[fit__offset(p, s) + (size_t)i];
        sum += v * v;
    }
    return sum / fmax(1.0, t->samples);
}

/* marks strays. @param room  [2*nstroke]  @return their number; 0 where too many are */
static int find(const fit__problem *p, const double *r, double *room, unsigned char *stray)
{
    int n = p->nstroke, found = 0;
    double *own = room, *sorted = room + n;
    for (int s = 0; s < n; s++) {
        own[s] = sorted[s] = misfit(p, r, s);
    }
    gsl_sort(sorted, 1, (size_t)n);
    double middle = sorted[(n - 1) / 2], most = middle * (middle < settled ? lost : far_lost);
    for (int s = 0; s < n; s++) {
        stray[s] = own[s] > most && (own[s] - middle) * p->stroke[s].samples > worth;
        found += stray[s];
    }
    return found <= n / STROKES_MOST ? found : 0;
}

/* every stray changes its weights for those at hand, which takes its own */
static void exchange(fit__problem *p, const unsigned char *stray, double **weight)
{
    for (int s = 0; s < p->nstroke; s++) {
        if (stray[s]) {
            double *own = p->stroke[s].weight;
            p->stroke[s].weight = weight[s];
            weight[s] = own;
        }
    }
}

/* a fit of the others, and of each stray's own numbers to that; derivatives are not those of the
 * end */
static stein_status recall(diag *d, fit__problem *p, fit__end *e, const unsigned char *stray,
                           double **none, stein_err *err)
{
    exchange(p, stray, none);
    stein_status status = fit__descend(p, e, 0, enough, RENEWALS, err);
    exchange(p, stray, none);
    for (int i = 0; status == STEIN_OK && i < p->nstroke; i++) {
        status = stray[i] ? diag__fit_stroke(d, p, i, e, err) : STEIN_OK;
    }
    return status;
}

stein_status diag__recall_strays(diag *d, fit__problem *p, fit__end *e, int *found, stein_err *err)
{
    size_t n = (size_t)p->nstroke;
    unsigned char *stray = calloc(n + 1, 1);
    double *room = calloc(2 * n + (size_t)p->rows + 1, sizeof *room);
    double **none = malloc(sizeof *none * (n + 1));
    stein_status status = stray != NULL && room != NULL && none != NULL
                              ? STEIN_OK
                              : lab__fail(err, STEIN_ENOMEM, "out of memory");
    *found = status == STEIN_OK ? find(p, e->r, room, stray) : 0;
    for (size_t i = 0; *found > 0 && i < n; i++) {
        none[i] = room + 2 * n; // weights 0, of any stroke
    }
    status = *found > 0 ? recall(d, p, e, stray, none, err) : status;
    free(stray);
    free(room);
    free(none);
    return status;
}
