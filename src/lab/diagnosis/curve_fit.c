/* SPDX-License-Identifier: GPL-3.0-or-later
 * curve_fit.c - fits of one curve, and their ends.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "curve_fitting.h"

enum { SETTLINGS = 2, ROUNDS_TO_SETTLE = 40 };
enum { NOISE_ROUNDS = 15 };       // where each of them learns the noise anew, too
static const double fine = 1e-12; /* tolerance of a step where a fit settles */
static const double little = 0.5; /* gain of a fit, of a round */

stein_status diag__curve_fit(diag__curves *w, diag__curve *c, stein_err *err)
{
    diag__fitting t;
    stein_err why = {STEIN_OK, ""};
    stein_status status = diag__fitting_begin_at(&t, w, c, w->null.x, err), end;
    if (status != STEIN_OK) {
        return status;
    }
    memcpy(c->r, w->null.r, sizeof *c->r * fit__offset(&w->p, w->p.nstroke));
    end =
        diag__rounds(&t, INFINITY, fit__noise_given(&w->p) ? CURVE_ROUNDS : NOISE_ROUNDS, 1, &why);
    diag__fitting_weigh(&t, end);
    diag__fitting_end(&t);
    return fit__forgive(end, err);
}

/* the strays of a fit called back, if there are any, then all together */
static stein_status recall(diag *d, diag__curves *w, diag__curve *c, double horizon, int anyway,
                           int *found, stein_err *err)
{
    diag__fitting t;
    diag in_tables = *d;
    in_tables.fit_def = w->def;
    diag__fitter f = {.d = &in_tables, .p = &w->p, .D = d->null_D, .fit = diag__fit_others};
    stein_status status = diag__fitting_begin(&t, w, c, err);
    if (status != STEIN_OK) {
        return status;
    }
    fit__end e = {.x = c->x, .r = c->r, .J = t.J};
    f.ctx = &t;
    t.horizon = w->p.horizon = horizon;
    status = diag__recall_by(&f, &e, 0, found, err);
    w->p.horizon = INFINITY;
    d->out->fits += e.fits;
    c->gain = -(double)INFINITY;
    if (status == STEIN_OK && (*found > 0 || anyway)) {
        status = diag__rounds(&t, horizon, CURVE_ROUNDS, 0, err);
        diag__fitting_weigh(&t, status);
    }
    diag__fitting_end(&t);
    return status;
}

stein_status diag__curve_recall(diag *d, diag__curves *w, diag__curve *c, double horizon,
                                int anyway, int *found, int *better, stein_err *err)
{
    const fit__problem *p = &w->p;
    size_t size = (size_t)p->nu + fit__offset(p, p->nstroke) + (size_t)p->np;
    diag__curve other = *c;
    stein_err why = {STEIN_OK, ""};
    stein_status status = diag__curve_room(p, &other, err);
    *found = *better = 0;
    if (status != STEIN_OK) {
        return status;
    }
    memcpy(other.x, c->x, sizeof *c->x * size);
    status = recall(d, w, &other, horizon, anyway, found, &why);
    *better = status == STEIN_OK && other.gain > c->gain + little;
    free(*better ? c->x : other.x);
    *c = *better ? other : *c;
    return fit__forgive(status, err);
}

/* with derivatives that are sized and taken with care */
static stein_status settle(diag__fitting *t, stein_err *err)
{
    fit__problem *p = &t->w->p;
    int failed = 0;
    stein_status status = fit__residuals(p, t->c->x, t->c->r, &failed, err);
    for (int k = 0; k < SETTLINGS && status == STEIN_OK; k++) {
        status = fit__sensitivities(p, t->c->x, t->c->r, t->J, err);
        if (status == STEIN_OK) {
            fit__choose_steps(p, t->J);
        }
    }
    return status == STEIN_OK ? diag__rounds(t, INFINITY, ROUNDS_TO_SETTLE, 0, err) : status;
}

/* What is missing was taken for scatter of friction and drive. With the law in its place they
 * scatter by what is left, and the law is known the better. */
static stein_status scatter_anew(diag__fitting *t, stein_err *err)
{
    fit__problem *p = &t->w->p;
    double D[LAB_SCATTERS], *sd = malloc(sizeof *sd * ((size_t)p->np + 1));
    stein_status status = sd != NULL ? STEIN_OK : lab__no_memory(err);
    if (status == STEIN_OK) { // J is that of the last round, which has hardly moved
        status = diag__likelihood(p, t->c->x, t->J, t->c->r, D, sd, NULL, NULL, err);
    }
    for (int i = 0; status == STEIN_OK && i < LAB_SCATTERS; i++) {
        D[i] = fmin(D[i], 1.0); // more would be the limit of the limit
        t->w->D[i] *= D[i];
    }
    for (int k = p->np; status == STEIN_OK && k < p->nu; k++) {
        fit__unknown *u = &p->unknown[k];
        double factor = u->kind == FIT__SCATTER ? sqrt(D[u->index - FIT__JOINTS]) : 1.0;
        u->sd *= factor;
        t->c->x[k] /= factor;
        p->step[k] /= factor;
    }
    free(sd);
    return status == STEIN_OK ? diag__rounds(t, INFINITY, ROUNDS_TO_SETTLE, 0, err) : status;
}

/* Gain of a round that leads on: of a law that leaves more than noise, what would bring it there in
 * all rounds. Its band is widened by what it leaves, and the last digits of it tell nothing. */
static double worth(const diag *d, const diag__curves *w, const diag__curve *c)
{
    double more = fit__noise_given(&w->p) ? diag__by_more(d, diag__curve_chi2_dof(d, w, c)) : 0.0;
    return fmax(little, more * w->p.samples / ROUNDS_TO_SETTLE);
}

stein_status diag__curve_settle(const diag *d, diag__curves *w, diag__curve *c, stein_err *err)
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
    t.worth = worth(d, w, c);
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
