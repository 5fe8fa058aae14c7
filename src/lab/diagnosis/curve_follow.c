/* SPDX-License-Identifier: GPL-3.0-or-later
 * curve_follow.c - a curve along the strokes.
 *
 * A stroke's end depends on how it escaped and where it bounced; a curve that is nearly right has
 * whole strokes wrong from one of these on, and no step of it leads back. So it is fitted up to a
 * horizon, single strokes that it has lost there are called back, and the horizon goes on - as far
 * as the curve predicts the strokes well enough to be corrected by small steps.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "curve_fitting.h"

enum { CALLS = 2, ON_THE_WAY = 8, IN_HASTE = 4, TO_THE_END = 40, FALTERS = 8 };
static const double stride = 0.05, shortest = 0.006, whole = 0.999; /* of the longest stroke */
static const double longest = 0.2, wider = 2.0; /* the next one where a whole one was predicted */
static const double well = 1.7;   /* chi2 per sample of a prediction that can be corrected */
static const double lost = 1.2;   /* and of a fit that is not on its way any more */
static const double chance = 3.0; /* in haste, sd above noise: what explains all leaves nothing */

/* chi2 per sample up to a horizon of c->r. @param n  samples up to there, out */
static double left(const diag__fitting *t, double horizon, double *n)
{
    fit__problem *p = &t->w->p;
    p->horizon = horizon;
    *n = fmax(1.0, diag__samples(p));
    double chi2 = fit__chi2(p, t->c->r) / *n;
    p->horizon = INFINITY;
    return chi2;
}

/* is the fit up to a horizon not on its way any more? */
static int is_lost(const diag__fitting *t, double horizon)
{
    double n, chi2 = left(t, horizon, &n);
    return !(chi2 < lost) || (diag__in_haste(t->w) && chi2 > 1.0 + chance * sqrt(2.0 / n));
}

/* what is predicted up to a horizon, in c->r. @return chi2 per sample, INFINITY: a stroke fails */
static double predict(diag__fitting *t, double horizon, stein_status *status, stein_err *err)
{
    fit__problem *p = &t->w->p;
    int failed = 0;
    double n;
    p->horizon = horizon;
    *status = fit__residuals(p, t->c->x, t->c->r, &failed, err);
    p->horizon = INFINITY;
    return failed > 0 ? (double)INFINITY : left(t, horizon, &n);
}

/* @param done  share of the strokes that has been fitted; step: to the next one, at most
 * @return the share to fit next */
static double next_share(diag__fitting *t, double done, double step, stein_status *status,
                         stein_err *err)
{
    double T = diag__longest(&t->w->p);
    while (*status == STEIN_OK && predict(t, (done + step) * T, status, err) > well &&
           step > shortest) {
        step *= 0.5;
    }
    return done + step;
}

/* In haste no stroke is called back on the way: one law that explains all loses few, and those
 * that another one has lost are most of its cost. So they are of one that has called in vain: what
 * its strokes have lost is in no number of their own. At the end it asks once more. */
static stein_status call_back(diag *d, diag__fitting *t, double horizon, stein_err *err)
{
    stein_status status = STEIN_OK;
    int better = !isfinite(horizon) || !(diag__in_haste(t->w) || t->vain), found = 0;
    diag__fitting_weigh(t, STEIN_OK);
    for (int k = 0; k < CALLS && status == STEIN_OK && better; k++) {
        status = diag__curve_recall(d, t->w, t->c, horizon, 0, &found, &better, err);
        t->vain = k == 0 && found > 0 && !better;
    }
    return status;
}

/* strays up to a horizon, rounds, strays */
static stein_status go_to(diag *d, diag__fitting *t, double horizon, int rounds, stein_err *err)
{
    stein_status status = call_back(d, t, horizon, err);
    status = status == STEIN_OK ? diag__rounds(t, horizon, rounds, 0, err) : status;
    return status == STEIN_OK ? call_back(d, t, horizon, err) : status;
}

/* From c->x, which is good up to where the fit without a law leaves more than noise. Where a stride
 * has lost the strokes, half of it is tried from where they were. */
static stein_status follow(diag *d, diag__fitting *t, stein_err *err)
{
    fit__problem *p = &t->w->p;
    size_t size = sizeof *t->good_x * (size_t)p->nu;
    double T = diag__longest(p), share = t->w->early.horizon / T, horizon = share * T;
    int haste = diag__in_haste(t->w), on_the_way = haste ? IN_HASTE : ON_THE_WAY;
    p->horizon = horizon;
    stein_status status = diag__look_around(t, err);
    p->horizon = INFINITY;
    status = status == STEIN_OK ? diag__rounds(t, horizon, on_the_way, 0, err) : status;
    double step = stride;
    for (int falters = 0;
         status == STEIN_OK && share < whole && !is_lost(t, horizon) && falters <= FALTERS;) {
        double done = share;
        memcpy(t->good_x, t->c->x, size);
        share = next_share(t, share, step, &status, err);
        falters += share - done < 0.9 * stride;
        step = share - done < 0.9 * step ? stride : fmin(longest, wider * step);
        horizon = share * T;
        status =
            status == STEIN_OK && share < whole ? go_to(d, t, horizon, on_the_way, err) : status;
        int astray = status == STEIN_OK ? is_lost(t, horizon) : status != STEIN_ENOMEM;
        if (astray && share < whole && share - done > shortest) {
            falters++;
            step = 0.5 * (share - done);
            share = done;
            horizon = share * T;
            memcpy(t->c->x, t->good_x, size);
            predict(t, horizon, &status, err);
        }
    }
    if (status == STEIN_OK && share < whole && haste) {
        return lab__fail(err, STEIN_ENONFINITE, "the law has lost the strokes at %.3g s", horizon);
    }
    if (status == STEIN_OK) {
        predict(t, INFINITY, &status, err);
    }
    int rounds = share < whole ? CURVE_ROUNDS : TO_THE_END;
    return status == STEIN_OK ? go_to(d, t, INFINITY, rounds, err) : status;
}

stein_status diag__curve_follow(diag *d, diag__curves *w, const double *x, diag__curve *c,
                                stein_err *err)
{
    diag__fitting t;
    stein_err why = {STEIN_OK, ""};
    stein_status status = diag__fitting_begin_at(&t, w, c, x, err), end;
    if (status != STEIN_OK) {
        return status;
    }
    end = follow(d, &t, &why);
    if (end != STEIN_OK) {
        diag__fitting_weigh(&t, end);
    }
    diag__fitting_end(&t);
    return fit__forgive(end, err);
}
