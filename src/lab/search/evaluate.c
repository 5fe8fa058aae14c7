/* SPDX-License-Identifier: GPL-3.0-or-later
 * evaluate.c - one hypothesis, fitted from one start; the only writer of rows.
 *
 *      start     the parent row's end, new causes at the proposed amounts
 *      held      Gauss-Newton while an observer holds the simulation near the records, its gain
 *                reduced from rung to rung; left out where the free simulation is near already
 *      free      Gauss-Newton on the free simulation
 *      recover   records that are far off while the others are near: their own unknowns once more,
 *                each record by itself
 *      evidence  -2 ln p(records | hypothesis) by Laplace, scatter estimated (likelihood.c)
 *
 * Noise. Where nobody stated it, or the best hypothesis leaves more or less than was stated, it is
 * an unknown of every fit: with v = chi2/dof in the noise of file or audit and residuals that are
 * alike over m samples
 *
 *      L = ((N - k)/m + k) ln v + rest,     data weigh 1/(v m) of what they did, priors what they
 * always do
 *
 * so what is left counts as noise of a model that is never exactly right, and hypotheses compare by
 * the ratio of what they leave.
 *
 * Continuation in an observer's gain: Vyasarayani et al. 2012 (fit/observer.c). It replaces fits
 * over growing horizons. Measured on strokes of the piano action with an effect of two noises
 * hidden in them: the hidden effect ranks first or among its geometric equivalents at a gain of
 * 0.05, and 65th at the free fit of the model without it.
 */
#include <gsl/gsl_sort.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "functions.h"
#include "search.h"

enum {
    RENEWALS_HELD = 1,
    RENEWALS = 5,
    RENEWALS_FAR = 2,
    RECOVERIES = 2,
    FAR_MOST = 2,
    CORRECTIONS = 75,
    REFINEMENTS = 8,
    NOISES = 6,
    COUNTED = 10,
    FOLLOWING = 8
};
static const double rung[] = {0.05, 0.012};
enum { RUNGS = sizeof rung / sizeof *rung };
static const double enough = 0.3;    /* of the objective: a fit has ended */
static const double far = 9.0;       /* chi2 per sample: three noises */
static const double hopeless = 25.0; /* the same of a fit that is not led to its end */
static const double outlying = 9.0;  /* the same of a record, in that of the record in the middle */
static const double no_weight = 1e-3;     /* of a record that a fit has lost */
static const double horizon = 1.5;        /* from one to the next */
static const double least_horizon = 0.01; /* share of the longest record */
static const double same_noise = 0.1;     /* relative change of noise that is none */
static const double finer = 0.1;   /* steps where numbers are reported, in those of a search */
static const double refined = 0.1; /* of the objective: such a fit has ended */
static const double least_scatter = 0.01; /* sd of a refined fit [of the prior] */

/* ---- fits ---- */

int diag__stride_of(const fit__problem *p)
{
    int least = p->stroke[0].n;
    for (int s = 0; s < p->nstroke; s++) {
        least = p->stroke[s].n < least ? p->stroke[s].n : least;
    }
    return least / CORRECTIONS > 1 ? least / CORRECTIONS : 1;
}

/* sum of squares of the free simulation per sample, INFINITY: it fails */
static double misfit(fit__problem *p, const double *x, double *r)
{
    int failed = 0;
    p->gain = 0.0;
    stein_err why;
    if (fit__residuals(p, x, r, &failed, &why) != STEIN_OK || failed > 0) {
        return INFINITY;
    }
    return (fit__chi2(p, r) + fit__priors(p, x)) / fmax(1.0, p->samples);
}

void diag__hold_scatter(fit__problem *p, int hold)
{
    for (int k = p->np; k < p->nu; k++) {
        if (p->unknown[k].kind == FIT__SCATTER) {
            p->unknown[k].idle = hold;
        }
    }
}

/* down the rungs from e->x; e->x is where the free simulation is nearest to the records */
static stein_status descend_held(fit__problem *p, fit__end *e, stein_err *err)
{
    size_t size = sizeof *e->x * (size_t)p->nu;
    double least = misfit(p, e->x, e->r), *x = malloc(size + 1);
    if (x == NULL) {
        return lab__no_memory(err);
    }
    memcpy(x, e->x, size);
    diag__hold_scatter(p, 1);
    for (int i = 0; i < RUNGS && least > far; i++) {
        stein_err why;
        p->gain = rung[i];
        stein_status status = fit__descend(p, e, 0, enough, RENEWALS_HELD, &why);
        if (status == STEIN_ENOMEM) {
            free(x);
            diag__hold_scatter(p, 0);
            return lab__no_memory(err);
        }
        double here = status == STEIN_OK ? misfit(p, e->x, e->r) : (double)INFINITY;
        if (here < least) {
            least = here;
            memcpy(x, e->x, size);
        }
    }
    memcpy(e->x, x, size);
    free(x);
    diag__hold_scatter(p, 0);
    p->gain = 0.0;
    return STEIN_OK;
}

/* the first steps without an observer */
static stein_status descend_free(fit__problem *p, fit__end *e, int known, stein_err *err)
{
    return fit__descend(p, e, known, enough, RENEWALS_FAR, err);
}

/* All numbers over a horizon that grows from the start windows to the whole records: a swing whose
 * frequency is off by one in a hundred has lost its phase after fifty. */
static stein_status descend_growing(fit__problem *p, fit__end *e, stein_err *err)
{
    double whole = 0.0, until = 0.0;
    stein_status status = STEIN_OK;
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        whole = fmax(whole, t->data->time[t->n - 1] - t->origin);
        until = fmax(until, 2.0 * t->window);
    }
    diag__hold_scatter(p, 1);
    for (until = fmax(until, least_horizon * whole); until < whole && status == STEIN_OK;
         until *= horizon) {
        stein_err why;
        p->horizon = until;
        status = fit__forgive(fit__descend(p, e, 0, enough, RENEWALS_HELD, &why), err);
    }
    diag__hold_scatter(p, 0);
    p->horizon = INFINITY;
    return status;
}

/* First without an observer, which costs a quarter. Where that ends far off, from the same start
 * with one, and then over growing horizons; what comes nearest stays. */
static stein_status descend_if_far(fit__problem *p, fit__end *e, stein_err *err)
{
    stein_status (*const way[])(fit__problem *, fit__end *, stein_err *) = {NULL, descend_held,
                                                                            descend_growing};
    size_t size = sizeof *e->x * (size_t)p->nu, n = sizeof way / sizeof *way, last = n;
    double *x = malloc(2 * size + 1), *end = x + (x != NULL ? p->nu : 0), reached = INFINITY;
    stein_status status = x != NULL ? STEIN_OK : STEIN_ENOMEM;
    stein_err why;
    if (x != NULL) {
        memcpy(x, e->x, size);
    }
    for (size_t i = 0; i < n && status != STEIN_ENOMEM && !(reached < hopeless * p->samples); i++) {
        memcpy(e->x, x, size);
        status = way[i] != NULL ? way[i](p, e, &why) : STEIN_OK;
        status = status == STEIN_OK ? descend_free(p, e, 0, &why) : status;
        if (status == STEIN_OK && e->objective < reached) {
            reached = e->objective;
            memcpy(end, e->x, size);
            last = i;
        }
    }
    if (status != STEIN_ENOMEM && isfinite(reached) && last + 1 < n &&
        !(reached < hopeless * p->samples)) {
        memcpy(e->x, end, size);
        status = descend_free(p, e, 0, &why);
    }
    free(x);
    if (status != STEIN_OK && err != NULL) {
        *err = why;
    }
    return status == STEIN_ENOMEM ? lab__no_memory(err) : status;
}

stein_status diag__descend(fit__problem *p, fit__end *e, diag__start from, stein_err *err)
{
    int can = fit__can_hold(p);
    stein_status status = STEIN_OK;
    if (from == DIAG_IF_FAR && can) {
        status = descend_if_far(p, e, err);
    } else {
        status = from == DIAG_HELD && can ? descend_held(p, e, err) : STEIN_OK;
        status = status == STEIN_OK ? descend_free(p, e, from == DIAG_KNOWN, err) : status;
    }
    if (status != STEIN_OK || e->ended || e->objective > hopeless * p->samples) {
        return status;
    }
    return fit__descend(p, e, 1, enough, RENEWALS - RENEWALS_FAR, err);
}

/* ---- records one by one ---- */

typedef struct alone {
    fit__problem *p;
    const double *D;
    double *x, *r;
    const unsigned char *which; /* NULL: all */
} alone;

/* The initial state from which the simulation follows the record, over a horizon that grows from
 * the start window to the whole record: behind a few impacts or in chaotic motion no fit over all
 * of it finds the way. What it ends at stays where it is nearer. */
static stein_status follow(const fit__problem *own, double *x, stein_err *err)
{
    const fit__stroke *t = &own->stroke[0];
    double length = t->data->time[t->n - 1] - t->origin, before;
    double *y = malloc(sizeof *y * ((size_t)own->nu + 1));
    fit__bench b;
    stein_status status = fit__bench_make(&b, own, err);
    if (status == STEIN_OK && y == NULL) {
        status = lab__no_memory(err);
    }
    if (status == STEIN_OK && t->window > 0.0) {
        fit__follow how = {.sd = t->noise, .most = INFINITY, .steps = FOLLOWING};
        before = fit__misfit(own, &b, 0, x, length);
        memcpy(y, x, sizeof *y * (size_t)own->nu);
        for (double until = t->window; how.until < length; until *= horizon) {
            how.until = fmin(until, length);
            (void)fit__follow_start(own, &b, 0, &how, y);
        }
        if (fit__misfit(own, &b, 0, y, length) < before) {
            memcpy(x, y, sizeof *y * (size_t)own->nu);
        }
    }
    fit__bench_free(&b);
    free(y);
    return status;
}

static stein_status fit_record(void *ctx, int s, fit__pool *pool, stein_err *err)
{
    const alone *a = ctx;
    const fit__problem *p = a->p;
    const fit__stroke *t = &p->stroke[s];
    lab_dataset one = {1, &p->data->stroke[s]};
    fit__problem own;
    if (a->which != NULL && !a->which[s]) {
        return STEIN_OK;
    }
    stein_status status = fit__problem_make_with(
        &own, p->model, &one, p->def, p->naccepted > 0 ? p->accepted[0] : NULL, p->naccepted, err);
    own.tolerance = p->tolerance;
    own.stride = p->stride;
    own.pool = pool;
    own.simulated = p->simulated;
    for (int k = 0; status == STEIN_OK && k < own.nu; k++) {
        fit__unknown *u = &own.unknown[k];
        u->idle |= k < own.np;
        int class = k < own.np ? -1 : diag__class_of(p, u);
        u->sd *= class >= 0 && a->D != NULL ? sqrt(fmax(a->D[class], 1e-6)) : 1.0;
    }
    double *x =
        status == STEIN_OK ? calloc((size_t)own.nu + fit__columns(&own) + 1, sizeof *x) : NULL;
    if (status == STEIN_OK && x == NULL) {
        status = lab__no_memory(err);
    }
    if (status == STEIN_OK) {
        fit__end e = {.x = x, .J = x + own.nu, .r = a->r + fit__offset(p, s)};
        memcpy(x, a->x, sizeof *x * (size_t)own.np);
        status = follow(&own, x, err);
        status = status != STEIN_OK ? status : diag__descend(&own, &e, DIAG_IF_FAR, err);
        for (int k = 0; k < t->own; k++) { // in the unit of the problem
            double unit = own.unknown[own.np + k].sd / p->unknown[t->first + k].sd;
            a->x[t->first + k] = x[own.np + k] * unit;
        }
    }
    free(x);
    fit__problem_free(&own);
    return status;
}

static stein_status fit_alone(alone *a, stein_err *err)
{
    fit__problem held = *a->p; // whose benches have an observer
    held.gain = rung[0];
    return fit__together(&held, a->p->nstroke, fit_record, a, err);
}

stein_status diag__fit_own(fit__problem *p, const double *D, double *x, double *r, stein_err *err)
{
    alone a = {p, D, x, r, NULL};
    return fit_alone(&a, err);
}

/* ---- records that a fit has lost ---- */

/* marks records that are far off beside the one in the middle. @param chi2  [2*nstroke] room
 * @return how many; 0 where they are half of all */
static int outliers(const fit__problem *p, const double *r, double *chi2, unsigned char *which)
{
    int n = 0;
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        size_t size = (size_t)t->nch * (size_t)t->n;
        const double *v = r + fit__offset(p, s);
        chi2[s] = lab__dot(v, v, size) / fmax(1.0, t->samples);
        chi2[p->nstroke + s] = chi2[s];
    }
    gsl_sort(chi2 + p->nstroke, 1, (size_t)p->nstroke);
    double middle = chi2[p->nstroke + p->nstroke / 2];
    for (int s = 0; s < p->nstroke; s++) {
        which[s] = chi2[s] > outlying * fmax(1.0, middle);
        n += which[s];
    }
    return FAR_MOST * n < p->nstroke ? n : 0;
}

/* records that are marked weigh by a factor what they did */
static void weigh(fit__problem *p, const unsigned char *which, double factor)
{
    for (int s = 0; s < p->nstroke; s++) {
        for (int c = 0; which[s] && c < p->stroke[s].nch; c++) {
            p->stroke[s].noise[c] /= factor;
        }
    }
}

/* The numbers of all records from those that are near, then the own unknowns of the others at
 * these. @param x, r  out */
static stein_status without_lost(fit__problem *p, const fit__end *e, const unsigned char *which,
                                 double *x, double *r, stein_err *err)
{
    fit__end near = {.x = x, .J = e->J, .r = r};
    memcpy(x, e->x, sizeof *x * (size_t)p->nu);
    weigh(p, which, no_weight);
    stein_status status = fit__descend(p, &near, 0, enough, RENEWALS, err);
    weigh(p, which, 1.0 / no_weight);
    alone a = {p, NULL, x, r, which};
    int failed = 0;
    status = status == STEIN_OK ? fit__residuals(p, x, r, &failed, err) : status;
    return status == STEIN_OK ? fit_alone(&a, err) : status;
}

static stein_status recover(fit__problem *p, fit__end *e, stein_err *err)
{
    size_t nu = (size_t)p->nu, rows = fit__offset(p, p->nstroke), ns = (size_t)p->nstroke;
    double *room = malloc(sizeof *room * (nu + rows + 2 * ns + 1));
    unsigned char *which = calloc(ns + 1, 1);
    stein_status status = room != NULL && which != NULL ? STEIN_OK : lab__no_memory(err);
    for (int k = 0; k < RECOVERIES && status == STEIN_OK && outliers(p, e->r, room, which); k++) {
        double *x = room + 2 * ns, *r = x + nu, before = e->objective;
        stein_err why;
        e->current = 0;
        status = fit__forgive(without_lost(p, e, which, x, r, &why), err);
        if (status != STEIN_OK || !(fit__chi2(p, r) + fit__priors(p, x) < before)) {
            break;
        }
        memcpy(e->x, x, sizeof *x * nu);
        status = fit__forgive(fit__descend(p, e, 0, enough, RENEWALS, &why), err);
    }
    free(which);
    free(room);
    return status;
}

/* ---- rows ---- */

static stein_status open_row(diag__problem *q, diag__row *row, stein_err *err)
{
    for (int i = 0; i < row->h.n; i++) {
        row->cause[i] = diag__bound(q, row->in, row->h.cause[i]);
        row->price += diag__price(q, row->h.cause[i]);
    }
    stein_status status =
        fit__problem_make_with(&row->p, row->in->model, row->in->fitted,
                               row->rough ? &q->rough_def : &q->fit_def, row->cause, row->h.n, err);
    if (status != STEIN_OK) {
        return status;
    }
    fit__problem *p = &row->p;
    p->tolerance = q->null.tolerance;
    p->stride = q->null.stride;
    p->simulated = &q->strokes;
    row->x = calloc((size_t)p->nu + (size_t)p->np + fit__offset(p, p->nstroke) + 1, sizeof *row->x);
    row->J = malloc(sizeof *row->J * (fit__columns(p) + 1));
    if (row->x == NULL || row->J == NULL) {
        return lab__no_memory(err);
    }
    row->sd = row->x + p->nu;
    row->r = row->sd + p->np;
    return STEIN_OK;
}

void diag__scale_noise(fit__problem *p, double factor)
{
    for (int s = 0; s < p->nstroke; s++) {
        for (int c = 0; c < p->stroke[s].nch; c++) {
            p->stroke[s].noise[c] *= factor;
        }
    }
}

/* RMS residual over RMS of the motion, both in noise */
static double relative_of(const fit__problem *p, const double *r)
{
    double motion = 0.0;
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        for (int c = 0; c < t->nch; c++) {
            double sum = 0.0, square = 0.0, n = 0.0;
            for (int i = c * t->n; i < (c + 1) * t->n; i++) {
                double y = isfinite(t->y[i]) ? t->y[i] / t->noise[c] : 0.0,
                       w = t->share[i] * t->share[i];
                sum += w * y;
                square += w * y * y;
                n += w;
            }
            motion += n > 0.0 ? square - sum * sum / n : 0.0;
        }
    }
    return sqrt(fit__chi2(p, r) / fmax(motion, 1e-300));
}

/* Samples that the residual is alike over. However smooth it is, a record counts as several
 * samples: one law may take all of a misfit away, and that is more than one coincidence. */
static double memory_of(const fit__problem *p, const double *r)
{
    double most = p->samples / (COUNTED * fmax(1.0, p->nstroke));
    return fmax(1.0, fmin(fit__memory(p, r), most));
}

/* the noise becomes what the fit leaves. @return the factor that it has changed by */
static double take_noise(const diag__problem *q, diag__row *row, const double *r)
{
    fit__problem *p = &row->p;
    double v = fit__chi2_dof(p, r) * row->scale * row->scale,
           to = sqrt(fmax(q->least_noise, v) * memory_of(p, r)), factor = to / row->scale;
    row->scale = to;
    diag__scale_noise(p, factor);
    return factor;
}

/* the fit once more with what it leaves as its noise, until that stays */
static stein_status settle_noise(const diag__problem *q, diag__row *row, fit__end *e,
                                 stein_err *err)
{
    stein_status status = STEIN_OK;
    double factor = 0.0;
    for (int k = 0; k < NOISES && status == STEIN_OK && fabs(factor - 1.0) > same_noise; k++) {
        factor = take_noise(q, row, e->r);
        status = fit__descend(&row->p, e, 0, enough, RENEWALS, err);
    }
    return status;
}

/* derivatives to begin with, those of the parent and those of new causes. @return are they there?
 */
static int begin_known(diag__row *row, const diag__row *parent, stein_status *status,
                       stein_err *err)
{
    fit__problem *p = &row->p;
    unsigned char *known = calloc((size_t)p->nu + 1, 1);
    int failed = 0;
    if (known == NULL) {
        *status = lab__no_memory(err);
        return 0;
    }
    diag__inherit(row, parent, known);
    *status = fit__residuals(p, row->x, row->r, &failed, err);
    if (*status == STEIN_OK && failed == 0) {
        *status = fit__more_sensitivities(p, row->x, row->r, known, row->J, err);
    }
    free(known);
    return *status == STEIN_OK && failed == 0;
}

static stein_status fit_row(const diag__problem *q, diag__row *row, const diag__row *parent,
                            diag__start from, stein_err *err)
{
    fit__problem *p = &row->p;
    fit__end e = {.x = row->x, .J = row->J, .r = row->r};
    stein_status status = STEIN_OK;
    if (from == DIAG_FREE && parent != NULL && parent->J != NULL &&
        begin_known(row, parent, &status, err)) {
        from = DIAG_KNOWN;
    }
    status = status == STEIN_ENOMEM ? status : diag__descend(p, &e, from, err);
    status = status == STEIN_OK ? recover(p, &e, err) : status;
    status = status == STEIN_OK && q->scale_free ? settle_noise(q, row, &e, err) : status;
    row->converged = e.ended;
    return status == STEIN_OK && !e.current ? fit__sensitivities(p, row->x, row->r, row->J, err)
                                            : status;
}

/* what a row tells, from its derivatives */
static stein_status note(diag__row *row, stein_err *err)
{
    fit__problem *p = &row->p;
    double square = row->scale * row->scale;
    stein_status status =
        diag__likelihood(p, row->x, row->J, row->r, row->D, row->sd, &row->objective, err);
    row->objective += row->price;
    row->rest = row->objective - fit__chi2(p, row->r);
    row->chi2_dof = fit__chi2_dof(p, row->r) * square;
    row->memory = memory_of(p, row->r);
    row->relative = relative_of(p, row->r);
    return status;
}

/* Derivatives stay with the row that stands for the verdict and with the one that proposals come
 * from: of all rows together they would be most of the memory. */
static void forget_derivatives(const diag__problem *q, const diag__table *t, int parent)
{
    const diag__row *best = diag__incumbent(q, t);
    for (int i = 0; i < t->n; i++) {
        if (i != parent && t->row[i] != best) {
            free(t->row[i]->J);
            t->row[i]->J = NULL;
        }
    }
}

stein_status diag__evaluate(diag__problem *q, diag__table *t, const diag__proposal *from,
                            diag__row **out, stein_err *err)
{
    diag__row *row = calloc(1, sizeof *row);
    long before = q->strokes;
    double begin = diag__clock();
    *out = NULL;
    if (row == NULL) {
        return lab__no_memory(err);
    }
    row->h = from->h;
    row->source = from->source;
    row->parent = from->parent;
    row->rough = from->rough || (from->parent >= 0 && t->row[from->parent]->rough);
    row->objective = row->chi2_dof = row->relative = INFINITY;
    row->scale = row->memory = 1.0;
    row->in = diag__mechanism_of(q, &row->h, err);
    if (row->in == NULL) {
        free(row);
        return STEIN_ENOMEM;
    }
    stein_err why = {STEIN_OK, ""};
    stein_status status = STEIN_OK;
    if (row->in->why == NULL) {
        status = open_row(q, row, &why);
        if (status == STEIN_OK) {
            const diag__row *parent = from->parent >= 0 ? t->row[from->parent] : NULL;
            diag__start_row(row, parent, from);
            row->scale = q->scale_free && parent != NULL ? parent->scale : 1.0;
            diag__scale_noise(&row->p, row->scale);
            diag__start how = from->parent < 0 ? DIAG_IF_FAR : from->held ? DIAG_HELD : DIAG_FREE;
            status = fit_row(q, row, parent, how, &why);
            status = status == STEIN_OK ? note(row, &why) : status;
        }
    }
    if (status == STEIN_ENOMEM) {
        diag__row_free(row);
        return lab__no_memory(err);
    }
    if (row->in->why != NULL || status != STEIN_OK || !isfinite(row->objective)) {
        row->failed = lab__text("%s", row->in->why != NULL ? row->in->why : why.msg);
        row->objective = row->chi2_dof = INFINITY;
        free(row->J);
        row->J = NULL;
    }
    row->strokes = q->strokes - before;
    row->seconds = diag__clock() - begin;
    *out = row;
    status = diag__table_add(t, row, err);
    diag__weigh(q, t);
    forget_derivatives(q, t, from->parent);
    return status;
}

/* Scatter in units of another standard deviation, by factors f of each class. */
static void scale_scatter(diag__row *row, const double *f)
{
    fit__problem *p = &row->p;
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        for (int k = t->first; k < t->first + t->own; k++) {
            fit__unknown *u = &p->unknown[k];
            int class = diag__class_of(p, u);
            double by = class >= 0 ? f[class] : 1.0;
            double *J = row->J + fit__column(p, s, p->np + k - t->first);
            u->sd *= by;
            row->x[k] /= by;
            p->step[k] /= by;
            for (int i = 0; i < t->nch * t->n; i++) {
                J[i] *= by;
            }
        }
    }
}

/* One-sided differences and coarse steps serve a search. Where two unknowns change nearly the same
 * - friction and the speed at which it begins - the roughness of their columns looks like knowledge
 * that tells them apart, and the fit ends where that leads: on strokes of the action an amount was
 * 1.5 % off with a standard deviation of 0.3 %, and is 1.2 % off with one of 1.1 % from central
 * differences and steps ten times finer. So what is reported is fitted to its end with those. And
 * with the scatter that was found instead of that of the prior: where records do not differ, their
 * own friction would take part of an effect, and the interval would not know. */
static stein_status refine(diag__row *row, stein_err *err)
{
    fit__problem *p = &row->p;
    double coarse = p->tolerance, to[LAB_SCATTERS], back[LAB_SCATTERS];
    for (int i = 0; i < LAB_SCATTERS; i++) {
        to[i] = fmax(sqrt(row->D[i]), least_scatter);
        back[i] = 1.0 / to[i];
    }
    fit__end e = {.x = row->x, .J = row->J, .r = row->r};
    scale_scatter(row, to);
    p->central = 1;
    p->tolerance = finer * coarse;
    stein_status status = fit__descend(p, &e, 0, refined, REFINEMENTS, err);
    row->converged |= e.ended;
    if (status == STEIN_OK && !e.current) {
        status = fit__sensitivities(p, row->x, row->r, row->J, err);
    }
    p->central = 0;
    p->tolerance = coarse;
    status = status == STEIN_OK ? note(row, err) : status;
    scale_scatter(row, back);
    for (int i = 0; status == STEIN_OK && i < LAB_SCATTERS; i++) {
        row->D[i] *= to[i] * to[i];
    }
    return status;
}

stein_status diag__refine_row(diag__row *row, stein_err *err)
{
    const fit__problem *p = &row->p;
    size_t n = (size_t)p->nu + (size_t)p->np + fit__offset(p, p->nstroke), nJ = fit__columns(p);
    diag__row was = *row;
    stein_err why = {STEIN_OK, ""};
    if (row->J == NULL) {
        row->J = calloc(nJ + 1, sizeof *row->J);
    }
    double *room = malloc(sizeof *room * (n + nJ + 1));
    if (row->J == NULL || room == NULL) {
        free(room);
        return lab__no_memory(err);
    }
    memcpy(room, row->x, sizeof *room * n);
    memcpy(room + n, row->J, sizeof *room * nJ);
    stein_status status = refine(row, &why);
    if (status != STEIN_OK || !isfinite(row->objective)) { // no finite derivatives: as it was
        memcpy(row->x, room, sizeof *room * n);
        memcpy(row->J, room + n, sizeof *room * nJ);
        was.J = row->J;
        was.p = row->p;
        *row = was;
    }
    free(room);
    return fit__forgive(status, err);
}

void diag__row_free(diag__row *row)
{
    if (row != NULL) {
        fit__problem_free(&row->p);
        free(row->x);
        free(row->J);
        free(row->failed);
        free(row);
    }
}
