/* SPDX-License-Identifier: GPL-3.0-or-later
 * curve_fit.c - the fit of one curve of an unknown law, with all other unknowns, to the records.
 *
 *      diag__curve_fit     coarse, for every site: while an observer holds, then free
 *      diag__curve_settle  to convergence, for the best sites: central differences, fine steps, the
 *                          scatter of friction and drive estimated again
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "curve_fitting.h"

enum { STEP_CHOICES = 2, ROUNDS = 5, ROUNDS_TO_SETTLE = 40 };
enum { NOISE_ROUNDS = 15 };           // where each round estimates the noise as well
static const double fine = 1e-12;     /* tolerance of a step where a fit settles */
static const double least_gain = 0.5; /* of a round, to make another one */

/* chi2 of the free simulation at x, INFINITY: it fails */
static double misfit(diag__curves *w, const double *x, double *r)
{
    int failed = 0;
    stein_err why;
    w->p.gain = 0.0;
    return fit__residuals(&w->p, x, r, &failed, &why) == STEIN_OK && failed == 0
               ? fit__chi2(&w->p, r)
               : (double)INFINITY;
}

/* from the fit without a law, held first or free at once */
static stein_status fit_from_null(diag__curves *w, diag__curve *c, int held, stein_err *err)
{
    diag__fitting t;
    stein_err why = {STEIN_OK, ""};
    stein_status status = diag__fitting_begin_at(&t, w, c, w->x, err), end = STEIN_OK;
    if (status != STEIN_OK) {
        return status;
    }
    int rounds = fit__noise_given(&w->p) ? ROUNDS : NOISE_ROUNDS;
    for (int i = 0; held && i < DIAG_RUNGS && end == STEIN_OK; i++) {
        if (i > 0 && misfit(w, c->x, t.try_r) < diag__three_noises() * w->p.samples) {
            break;
        }
        end = diag__rounds(&t, diag__rung[i], rounds, 0, &why);
    }
    end = end == STEIN_OK ? diag__rounds(&t, 0.0, rounds, 0, &why) : end;
    diag__fitting_weigh(&t, end);
    diag__fitting_end(&t);
    return fit__forgive(end, err);
}

/* A curve that was fitted under the observer may be distorted where the records have little
 * information, and a free fit does not always correct it. Where it leaves more than noise, the free
 * fit of the same start is made as well, and the better one stays. */
stein_status diag__curve_fit(diag__curves *w, diag__curve *c, stein_err *err)
{
    diag__curve other = *c;
    stein_status status = fit_from_null(w, c, 1, err);
    if (status != STEIN_OK || (c->fitted && diag__curve_chi2_dof(w, c) < diag__near_noise)) {
        return status;
    }
    status = fit_from_null(w, &other, 0, err);
    int better = status == STEIN_OK && other.fitted && (!c->fitted || other.gain > c->gain);
    free(better ? c->x : other.x);
    *c = better ? other : *c;
    return status;
}

/* with derivatives that are sized and taken with care */
static stein_status settle(diag__fitting *t, stein_err *err)
{
    fit__problem *p = &t->w->p;
    int failed = 0;
    stein_status status = fit__residuals(p, t->c->x, t->c->r, &failed, err);
    for (int k = 0; k < STEP_CHOICES && status == STEIN_OK; k++) {
        status = fit__sensitivities(p, t->c->x, t->c->r, t->J, err);
        if (status == STEIN_OK) {
            fit__choose_steps(p, t->J);
        }
    }
    return status == STEIN_OK ? diag__rounds(t, 0.0, ROUNDS_TO_SETTLE, 0, err) : status;
}

/* The fit without the law explains part of it by scatter of friction and drive. With the law,
 * scatter is estimated again from the residual, and the band of the law is narrower. */
static stein_status scatter_anew(diag__fitting *t, stein_err *err)
{
    fit__problem *p = &t->w->p;
    double D[LAB_SCATTERS], objective, *sd = malloc(sizeof *sd * ((size_t)p->np + 1));
    stein_status status = sd != NULL ? STEIN_OK : lab__no_memory(err);
    if (status == STEIN_OK) { // J is from the last round, which has hardly moved
        status = diag__likelihood(p, t->c->x, t->J, t->c->r, D, sd, &objective, err);
    }
    for (int i = 0; status == STEIN_OK && i < LAB_SCATTERS; i++) {
        D[i] = fmin(D[i], 1.0); // more would be the limit of the limit
        t->w->D[i] *= D[i];
    }
    for (int k = p->np; status == STEIN_OK && k < p->nu; k++) {
        fit__unknown *u = &p->unknown[k];
        int scatters = u->kind == FIT__SCATTER || u->kind == FIT__FORCE;
        double factor = scatters ? sqrt(D[diag__class_of(p, u)]) : 1.0;
        u->sd *= factor;
        t->c->x[k] /= factor;
        p->step[k] /= factor;
    }
    free(sd);
    return status == STEIN_OK ? diag__rounds(t, 0.0, ROUNDS_TO_SETTLE, 0, err) : status;
}

/* Gain of a round that is worth another one. Of a law that leaves more than noise it is the share
 * of the excess that each round would have to remove. The band of such a law is widened by the
 * excess, so that its last digits do not matter. */
static double worth(const diag__curves *w, const diag__curve *c)
{
    double sd = sqrt(2.0 / fmax(1.0, w->p.samples)),
           more = fit__noise_given(&w->p)
                      ? diag__curve_chi2_dof(w, c) - 1.0 - diag__beyond_chance * sd
                      : 0.0;
    return fmax(least_gain, more * w->p.samples / ROUNDS_TO_SETTLE);
}

stein_status diag__curve_settle(diag__curves *w, diag__curve *c, stein_err *err)
{
    fit__problem *p = &w->p;
    size_t size = sizeof *p->step * (size_t)p->nu;
    double coarse = p->tolerance, *step = malloc(size + 1);
    diag__fitting t;
    stein_err why = {STEIN_OK, ""};
    stein_status status = step != NULL ? STEIN_OK : lab__no_memory(err), end;
    status = status == STEIN_OK ? diag__fitting_begin(&t, w, c, err) : status;
    if (status != STEIN_OK) {
        free(step);
        return status;
    }
    memcpy(step, p->step, size);
    t.worth = worth(w, c);
    p->central = 1;
    p->tolerance = fine;
    end = settle(&t, &why);
    if (end == STEIN_OK) {
        diag__fitting_weigh(&t, end); // in the variances in which all curves are weighed
        end = scatter_anew(&t, &why);
    }
    p->central = 0;
    p->tolerance = coarse;
    memcpy(p->step, step, size);
    diag__fitting_end(&t);
    free(step);
    return fit__forgive(end, err);
}
