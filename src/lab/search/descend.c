/* SPDX-License-Identifier: GPL-3.0-or-later
 * descend.c - ways of minimising: free, with an observer, over growing horizons.
 *
 *      free      Gauss-Newton on the free simulation
 *      held      while an observer holds the simulation near the records, its gain reduced from
 * rung to rung growing   over a horizon that grows from the beginning of the records to their end
 *      lost      records that are far off while most are near: what is shared from the others, then
 *                each lost record is followed from its start
 *
 * Continuation in an observer's gain: Vyasarayani et al. 2012 (fit/observer.c). Measured on strokes
 * of the piano action with a hidden effect of two noises: at a gain of 0.05 the effect ranks first
 * or among its geometric equivalents, at the free fit of the model without it 65th. Growing
 * horizons are used where an oscillation would lose its phase or motion is chaotic. A crank that
 * swings seventy times, with a sensor gain of -5 %, ended at chi2/dof 2.4e7 with the observer, and
 * ends at 5.1 with them.
 */
#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>
#include <gsl/gsl_sort.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "search.h"

enum {
    RENEWALS_HELD = 1,
    RENEWALS = 5,
    RENEWALS_FAR = 2,
    RENEWALS_EVENTS = 20,
    LONGER = 4, /* times as many as long as they lead on */
    RECOVERIES = 2,
    FAR_MOST = 2,
    CORRECTIONS = 75,
    FOLLOWING = 8
};
static const double falling = 0.8;        /* of the objective: it leads on */
static const double no_weight = 1e-3;     /* of a record that a fit has lost */
static const double horizon = 1.5;        /* from one to the next */
static const double least_horizon = 0.01; /* share of the longest record */

/* ---- fits ---- */

int diag__stride_of(const fit__problem *p)
{
    int least = p->stroke[0].n;
    for (int s = 0; s < p->nstroke; s++) {
        least = p->stroke[s].n < least ? p->stroke[s].n : least;
    }
    return least / CORRECTIONS > 1 ? least / CORRECTIONS : 1;
}

/* Sum of squares of a channel about its mean [noise^2], of the samples up to a time `until` of the
 * simulation. @param n  out: as many as they count as */
static double motion_of(const fit__stroke *t, int c, double until, double *n)
{
    double sum = 0.0, square = 0.0;
    *n = 0.0;
    for (int i = c * t->n; i < (c + 1) * t->n; i++) {
        int counts = isfinite(t->y[i]) && fit__time_of(t, i % t->n) - t->origin <= until;
        double y = counts ? t->y[i] / t->noise[c] : 0.0,
               w = counts ? t->share[i] * t->share[i] : 0.0;
        sum += w * y;
        square += w * y * y;
        *n += w;
    }
    return *n > 0.0 ? square - sum * sum / *n : 0.0;
}

double diag__relative(const fit__problem *p, const double *r)
{
    double motion = 0.0, n;
    for (int s = 0; s < p->nstroke; s++) {
        for (int c = 0; c < p->stroke[s].nch; c++) {
            motion += motion_of(&p->stroke[s], c, p->horizon, &n);
        }
    }
    return sqrt(fit__chi2(p, r) / fmax(motion, 1e-300));
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
        if (p->unknown[k].kind == FIT__SCATTER || p->unknown[k].kind == FIT__FORCE) {
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
    for (int i = 0; i < DIAG_RUNGS && least > diag__three_noises(); i++) {
        stein_err why;
        p->gain = diag__rung[i];
        stein_status status = fit__descend(p, e, 0, diag__fit_ends, RENEWALS_HELD, &why);
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

/* do the records hold times of events alone? */
static int are_events(const fit__problem *p)
{
    int sampled = 0;
    for (int s = 0; s < p->nstroke; s++) {
        sampled += p->stroke[s].nsampled;
    }
    return sampled == 0;
}

/* The first steps without an observer. Of few samples the priors weigh much while they are far off
 * (minimise.c), and steps are short: times of events take more of them, and no other way helps. */
static stein_status descend_free(fit__problem *p, fit__end *e, int known, stein_err *err)
{
    return fit__descend(p, e, known, diag__fit_ends, are_events(p) ? RENEWALS_EVENTS : RENEWALS_FAR,
                        err);
}

/* the sum of squares over a horizon from which on a fit has lost the records */
static double lost_from(const fit__problem *p, double until)
{
    double sum = 0.0, n;
    for (int s = 0; s < p->nstroke; s++) {
        for (int c = 0; c < p->stroke[s].nch; c++) {
            double motion = motion_of(&p->stroke[s], c, until, &n);
            sum += fmax(diag__five_noises() * n, diag__no_model * diag__no_model * motion);
        }
    }
    return fmax(1.0, sum);
}

/* All numbers, over a horizon that grows from the start windows to the whole records. A swing whose
 * frequency is 1 % off has lost its phase after fifty periods.
 * @param reach  NULL: to the end; else out: the last horizon over which the fit did not end far
 * off, where it stops, 0: none; INFINITY: it did so over none */
static stein_status descend_growing(fit__problem *p, fit__end *e, double *reach, stein_err *err)
{
    double whole = 0.0, until = 0.0, last = 0.0, most = p->horizon;
    stein_status status = STEIN_OK;
    int near = 1;
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        whole = fmax(whole, t->data->time[t->n - 1] - t->origin);
        until = fmax(until, 2.0 * t->window);
    }
    diag__hold_scatter(p, 1);
    whole = fmin(whole, most);
    for (until = fmax(until, least_horizon * whole); until < whole && status == STEIN_OK && near;
         until *= horizon) {
        stein_err why;
        p->horizon = until;
        status = fit__descend(p, e, 0, diag__fit_ends, RENEWALS_HELD, &why);
        if (reach != NULL) {
            near = status == STEIN_OK && e->objective < lost_from(p, until);
            *reach = near ? (double)INFINITY : last;
        }
        last = until;
        status = fit__forgive(status, err);
    }
    diag__hold_scatter(p, 0);
    p->horizon = most;
    return status;
}

stein_status diag__follows(fit__problem *p, fit__end *e, double *until, stein_err *err)
{
    *until = INFINITY;
    return descend_growing(p, e, until, err);
}

static stein_status descend_to_end(fit__problem *p, fit__end *e, stein_err *err)
{
    return descend_growing(p, e, NULL, err);
}

/* does a fit end where its simulation does not follow the records? */
static int is_lost(const fit__problem *p, double objective, const double *r)
{
    return !(objective < diag__five_noises() * p->samples) &&
           !(diag__relative(p, r) < diag__followed);
}

/* First without an observer, which costs a quarter. Where that has lost the records, from the same
 * start with one, and then over growing horizons; what comes nearest stays. A mechanism that lacks
 * something follows them, by more than noise off. */
static stein_status descend_if_far(fit__problem *p, fit__end *e, stein_err *err)
{
    stein_status (*const way[])(fit__problem *, fit__end *, stein_err *) = {NULL, descend_held,
                                                                            descend_to_end};
    size_t size = sizeof *e->x * (size_t)p->nu, n = sizeof way / sizeof *way, last = n;
    double *x = malloc(2 * size + 1), *end = x + (x != NULL ? p->nu : 0), reached = INFINITY;
    stein_status status = x != NULL ? STEIN_OK : STEIN_ENOMEM;
    stein_err why;
    if (x != NULL) {
        memcpy(x, e->x, size);
    }
    int off = 1;
    for (size_t i = 0; i < n && status != STEIN_ENOMEM && off; i++) {
        memcpy(e->x, x, size);
        status = way[i] != NULL ? way[i](p, e, &why) : STEIN_OK;
        status = status == STEIN_OK ? descend_free(p, e, 0, &why) : status;
        if (status == STEIN_OK && e->objective < reached) {
            reached = e->objective;
            memcpy(end, e->x, size);
            last = i;
            off = is_lost(p, reached, e->r);
        }
    }
    if (status != STEIN_ENOMEM && isfinite(reached) && last + 1 < n && off) {
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
    for (int k = 0; k < LONGER && status == STEIN_OK; k++) {
        double before = e->objective;
        if (e->ended || before > diag__five_noises() * p->samples) {
            break;
        }
        status = fit__descend(p, e, 1, diag__fit_ends, RENEWALS - RENEWALS_FAR, err);
        if (!(e->objective < falling * before)) {
            break;
        }
    }
    return status;
}

/* ---- records one by one ---- */

typedef struct alone {
    fit__problem *p;
    const double *D;
    double *x, *r;
    const unsigned char *which; /* NULL: all */
    int restarts; /* 1: a record that is not near noise begins from other starts, too */
} alone;

/* The initial state from which the simulation follows the record, over a horizon that grows from
 * the start window to the whole record. After a few impacts, or in chaotic motion, a fit over all
 * of it at once does not converge. What it ends at stays where it is nearer. */
static stein_status follow(const fit__problem *own, double *x, stein_err *err)
{
    const fit__stroke *t = &own->stroke[0];
    double length = fmin(t->data->time[t->n - 1] - t->origin, own->horizon), before;
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

/* A record by itself, where its fit has not come near, from other starts: draws of its own unknowns
 * from their priors. A hammer that bounces once more, or is caught, has another minimum. What comes
 * nearest stays. */
static stein_status restart(fit__problem *own, fit__end *e, stein_err *err)
{
    size_t nu = (size_t)own->nu, rows = fit__offset(own, own->nstroke);
    double near = diag__near_noise * own->samples;
    double *room = malloc(sizeof *room * (nu + rows + fit__columns(own) + 1));
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    stein_status status = room != NULL && rng != NULL ? STEIN_OK : lab__no_memory(err);
    for (int d = 0; d < DIAG_FEW_FITS && status == STEIN_OK && !(e->objective < near); d++) {
        fit__end other = {.x = room, .r = room + nu, .J = room + nu + rows};
        stein_err why;
        memcpy(other.x, e->x, sizeof *other.x * nu);
        for (size_t k = (size_t)own->np; k < nu; k++) {
            const fit__unknown *u = &own->unknown[k];
            other.x[k] = u->prior && !u->idle ? gsl_ran_gaussian(rng, 1.0) : other.x[k];
        }
        status = diag__descend(own, &other, DIAG_FREE, &why);
        if (status == STEIN_OK && other.objective < e->objective) {
            memcpy(e->x, other.x, sizeof *e->x * nu);
            memcpy(e->r, other.r, sizeof *e->r * rows);
            e->objective = other.objective;
            e->ended = other.ended;
        }
        status = fit__forgive(status, err);
    }
    if (rng != NULL) {
        gsl_rng_free(rng);
    }
    free(room);
    return status;
}

/* Readings of a record alone weigh as in the problem: their noise may be estimated with the fit,
 * and the step of an encoder may show in other records only. */
static void weigh_alike(fit__problem *own, const fit__stroke *t)
{
    fit__stroke *o = &own->stroke[0];
    memcpy(o->noise, t->noise, sizeof *o->noise * (size_t)t->nch);
    memcpy(o->share, t->share, sizeof *o->share * (size_t)t->nch * (size_t)t->n);
    own->samples += t->samples - o->samples;
    o->samples = t->samples;
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
    own.horizon = p->horizon;
    own.pool = pool;
    own.simulated = p->simulated;
    if (status == STEIN_OK) {
        weigh_alike(&own, t);
    }
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
        status = status == STEIN_OK && a->restarts ? restart(&own, &e, err) : status;
        for (int k = 0; k < t->own; k++) { // as the problem counts: one record may begin elsewhere
            const fit__unknown *u = &own.unknown[own.np + k], *v = &p->unknown[t->first + k];
            a->x[t->first + k] = (u->start + u->sd * x[own.np + k] - v->start) / v->sd;
        }
    }
    free(x);
    fit__problem_free(&own);
    return status;
}

static stein_status fit_alone(alone *a, stein_err *err)
{
    fit__problem held = *a->p; // whose benches have an observer
    held.gain = diag__rung[0];
    return fit__together(&held, a->p->nstroke, fit_record, a, err);
}

stein_status diag__fit_own(fit__problem *p, const double *D, int restarts, double *x, double *r,
                           stein_err *err)
{
    alone a = {p, D, x, r, NULL, restarts};
    return fit_alone(&a, err);
}

/* ---- records that a fit has lost ---- */

double diag__by_record(const fit__problem *p, const double *r, double *chi2)
{
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        size_t size = (size_t)t->nch * (size_t)t->n;
        const double *v = r + fit__offset(p, s);
        chi2[s] = lab__dot(v, v, size) / fmax(1.0, t->samples);
        chi2[p->nstroke + s] = chi2[s];
    }
    gsl_sort(chi2 + p->nstroke, 1, (size_t)p->nstroke);
    return chi2[p->nstroke + p->nstroke / 2];
}

/* chi2 per sample of a record from which on it is off by more than chance */
static double most_alone(const fit__stroke *t)
{
    return fmax(diag__near_noise, 1.0 + diag__beyond_chance * sqrt(2.0 / fmax(1.0, t->samples)));
}

/* marks records that are far off beside the one in the middle. @param chi2  [2*nstroke] room
 * @param scale  of the noise in p beside that of file or audit
 * @param near  out: that one leaves noise  @return how many; 0 where they are half of all */
static int outliers(const fit__problem *p, const double *r, double scale, double *chi2,
                    unsigned char *which, int *near)
{
    double middle = diag__by_record(p, r, chi2);
    int n = 0;
    *near = middle * scale * scale < diag__near_noise;
    for (int s = 0; s < p->nstroke; s++) {
        double unit = *near ? scale * scale : 1.0;
        double most = *near ? most_alone(&p->stroke[s]) : diag__three_noises();
        which[s] = chi2[s] * unit > most * fmax(1.0, middle * unit);
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
                                 int restarts, double *x, double *r, stein_err *err)
{
    fit__end near = {.x = x, .J = e->J, .r = r};
    memcpy(x, e->x, sizeof *x * (size_t)p->nu);
    weigh(p, which, no_weight);
    stein_status status = fit__descend(p, &near, 0, diag__fit_ends, RENEWALS, err);
    weigh(p, which, 1.0 / no_weight);
    alone a = {p, NULL, x, r, which, restarts};
    int failed = 0;
    status = status == STEIN_OK ? fit__residuals(p, x, r, &failed, err) : status;
    return status == STEIN_OK ? fit_alone(&a, err) : status;
}

stein_status diag__recover(fit__problem *p, fit__end *e, double scale, stein_err *err)
{
    size_t nu = (size_t)p->nu, rows = fit__offset(p, p->nstroke), ns = (size_t)p->nstroke;
    double *room = malloc(sizeof *room * (nu + rows + 2 * ns + 1));
    unsigned char *which = calloc(ns + 1, 1);
    stein_status status = room != NULL && which != NULL ? STEIN_OK : lab__no_memory(err);
    for (int k = 0, near; k < RECOVERIES && status == STEIN_OK; k++) {
        if (outliers(p, e->r, scale, room, which, &near) == 0) {
            break;
        }
        double *x = room + 2 * ns, *r = x + nu, before = e->objective;
        stein_err why;
        e->current = 0;
        status = fit__forgive(without_lost(p, e, which, near, x, r, &why), err);
        if (status != STEIN_OK || !(fit__chi2(p, r) + fit__priors(p, x) < before)) {
            break;
        }
        memcpy(e->x, x, sizeof *x * nu);
        status = fit__forgive(fit__descend(p, e, 0, diag__fit_ends, RENEWALS, &why), err);
    }
    free(which);
    free(room);
    return status;
}
