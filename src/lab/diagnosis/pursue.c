/* SPDX-License-Identifier: GPL-3.0-or-later
 * pursue.c - the null fit, which follows the strokes from their beginning.
 *
 * A model that lacks an effect, or starts from wrong numbers, runs away from the data: after an
 * escapement that comes a little late everything is different, and a fit to the whole stroke ends
 * in a false minimum a thousand noises from the data, from where no suspect looks right. So the
 * horizon grows: only samples up to it count. As long as the model fits, the next samples are near.
 *
 * The same idea as multiple shooting's or an observer's (Vyasarayani et al. 2012), but the model
 * runs free: what is not in it cannot be made up for by forces that pull it to the data. And early
 * horizons are cheap.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "searching.h"

enum { RENEWALS = 4, RENEWALS_LAST = 5, RECALLS = 3 };
const double diag__horizon[DIAG_HORIZONS] = {0.16, 0.25, 0.32, 0.4, 0.5, 0.65, 1.0};
static const double enough = 0.3;
static const double near = 12.0;           /* RMS [noise] */
static const double worth_a_recall = 10.0; /* of the objective */
static const double a_share = 0.1;         /* of what strays may have lost */
static const double near_enough = 40.0;    /* of the objective: who is behind by less may win */
static const double off = 3.0;             /* sd of chi2: more than noise is left */
static const double clearly = 1.2;         /* per sample */
static const double worth_it = 0.1;        /* share of that */

double diag__longest(const fit__problem *p)
{
    double T = 0.0;
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        T = fmax(T, t->data->time[t->n - 1] - t->origin);
    }
    return T;
}

/* squares of the residuals of each share of the strokes, from one horizon to the next, and how many
 * samples it has */
static void by_horizon(const fit__problem *p, const double *r, double T, double *square, double *n)
{
    memset(square, 0, sizeof *square * DIAG_HORIZONS);
    memset(n, 0, sizeof *n * DIAG_HORIZONS);
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        const double *v = r + fit__offset(p, s);
        for (int i = 0; i < t->nch * t->n; i++) {
            double share = (t->data->time[i % t->n] - t->origin) / T;
            int h = 0;
            while (h + 1 < DIAG_HORIZONS && share > diag__horizon[h]) {
                h++;
            }
            square[h] += v[i] * v[i];
            n[h] += isfinite(t->y[i]);
        }
    }
}

/* the horizon up to which the model is near enough to the data for a fit: where the RMS of the
 * samples of one more share is too large, it ends; at least one share beyond the last one */
static int next_horizon(fit__problem *p, fit__end *e, int last, double T, stein_err *err)
{
    double square[DIAG_HORIZONS], n[DIAG_HORIZONS];
    int failed = 0, to = last + 1;
    p->horizon = INFINITY;
    if (fit__residuals(p, e->x, e->r, &failed, err) != STEIN_OK || failed > 0) {
        return to;
    }
    by_horizon(p, e->r, T, square, n);
    while (to + 1 < DIAG_HORIZONS && square[to + 1] < near * near * n[to + 1]) {
        to++;
    }
    return to;
}

/* the first horizon that reaches so far [s] */
static int horizon_of(double far, double T)
{
    int h = 0;
    while (h + 1 < DIAG_HORIZONS && diag__horizon[h] * T < far - 1e-9) {
        h++;
    }
    return h;
}

/* a second end beside e, at its x and r. @return its room, NULL: out of memory */
static double *beside(const fit__problem *p, const fit__end *e, fit__end *t, stein_err *err)
{
    size_t nu = (size_t)p->nu, rows = fit__offset(p, p->nstroke);
    double *room = malloc(sizeof *room * (nu + rows + fit__columns(p) + 1));
    if (room == NULL) {
        (void)lab__no_memory(err);
        return NULL;
    }
    *t = (fit__end){.x = room, .r = room + nu, .J = room + nu + rows};
    memcpy(t->x, e->x, sizeof *room * nu);
    memcpy(t->r, e->r, sizeof *room * rows);
    return room;
}

static void take_over(const fit__problem *p, fit__end *e, const fit__end *t)
{
    memcpy(e->x, t->x, sizeof *e->x * (size_t)p->nu);
    memcpy(e->r, t->r, sizeof *e->r * fit__offset(p, p->nstroke));
    memcpy(e->J, t->J, sizeof *e->J * fit__columns(p));
    e->objective = t->objective;
    e->ended = t->ended;
}

/* the fit from where its strays lead it. @param found  how many there are, out
 * @param each  [nstroke] room
 * @return 1 when that was worth it: it gained a share of what strays may have lost */
static int recall(diag *d, fit__problem *p, fit__end *e, double *each, int *found,
                  stein_status *status, stein_err *err)
{
    fit__end t;
    double *room = beside(p, e, &t, err), was = e->objective;
    double more = fit__chi2(p, e->r) - diag__come_back(p, e->r, each);
    if (room == NULL) {
        *status = STEIN_ENOMEM;
        return 0;
    }
    stein_err why = {STEIN_OK, ""};
    *found = 0;
    stein_status tried = diag__recall_strays(d, p, &t, 0, found, &why);
    if (tried == STEIN_OK && *found > 0) {
        tried = fit__descend(p, &t, 0, enough, RENEWALS, &why);
        t.fits++;
    }
    e->fits += t.fits;
    if (tried == STEIN_OK && *found > 0 && t.objective < e->objective) {
        take_over(p, e, &t);
    }
    free(room);
    *status = fit__forgive(tried, err);
    return e->objective < was - fmax(worth_a_recall, a_share * more);
}

int diag__is_clear(double chi2, double dof)
{
    return chi2 > clearly * dof && chi2 - dof > off * sqrt(2.0 * dof);
}

double diag__chi2_to(const fit__problem *p, const double *r, double horizon)
{
    double sum = 0.0;
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        const double *v = r + fit__offset(p, s);
        for (int i = 0; i < t->nch * t->n; i++) {
            int counts = t->data->time[i % t->n] - t->origin <= horizon;
            sum += counts ? v[i] * v[i] : 0.0;
        }
    }
    return sum;
}

double diag__samples(const fit__problem *p)
{
    double n = 0.0;
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        for (int i = 0; i < t->nch * t->n; i++) {
            n += isfinite(t->y[i]) && t->data->time[i % t->n] - t->origin <= p->horizon;
        }
    }
    return n;
}

void diag__ahead(const fit__problem *p, const double *r, double left, double *most)
{
    double square[DIAG_HORIZONS], n[DIAG_HORIZONS], rest = 0.0, samples = 0.0;
    by_horizon(p, r, diag__longest(p), square, n);
    for (int h = DIAG_HORIZONS - 1; h >= 0; h--) {
        most[h] = left - rest + fmax(0.0, rest - samples + off * sqrt(2.0 * samples)) + near_enough;
        rest += square[h];
        samples += n[h];
    }
}

/* Is a fit lost where it stands? Either it is further from the data already than it may be at its
 * end. Or the null fit clearly left more than noise at this horizon, and what is on trial has
 * explained nothing of it: something that is missing shows before, and this is not it. (Where the
 * null fit left a little, that may be a stroke which one of the two has lost.)
 * Nor is what was to leave but noise on its way there where it clearly leaves more. And who is too
 * far behind another one cannot win, even if all strays came back.
 * @param where  0: before strays are called back, where only one that stands as the null fit did is
 *               lost; 1: after
 * @param room   [nstroke] */
static int is_lost(const diag__pursuit *c, const fit__problem *p, const fit__end *e, int h,
                   int where, double *room)
{
    if (c == NULL) {
        return 0;
    }
    double null = c->null != NULL ? c->null->at[h][where] : 0.0, n = diag__samples(p);
    double excess = null - n, gain = null - e->objective, least = worth_it * excess;
    int nothing = gain < least && (where > 0 || gain > -least);
    double sure = where > 0 ? e->objective : diag__come_back(p, e->r, room);
    return (c->most != NULL && sure > c->most[h]) || (diag__is_clear(null, n) && nothing) ||
           (c->to_noise && where > 0 && diag__is_clear(e->objective, n));
}

/* notes where it stands, or that it is lost */
static int goes_on(diag__pursuit *c, const fit__problem *p, const fit__end *e, int h, int where,
                   double *room)
{
    if (c != NULL && c->reached != NULL) {
        c->reached->at[h][where] = e->objective;
    }
    if (is_lost(c, p, e, h, where, room)) {
        c->given_up = 1;
        return 0;
    }
    return 1;
}

/* All strays called back, again while that is worth it. @return 1 when it was in vain though much
 * is left: what those strokes have lost is in no number of their own, and it costs most of a fit to
 * ask again. */
static int recall_all(diag *d, fit__problem *p, fit__end *e, double *each, stein_status *status,
                      stein_err *err)
{
    int found = 1, worth = 1, once = 0;
    for (int k = 0; k < RECALLS && worth && *status == STEIN_OK; k++) {
        worth = recall(d, p, e, each, &found, status, err);
        once |= worth;
    }
    return found > 0 && !once && diag__is_clear(e->objective, diag__samples(p));
}

stein_status diag__follow(diag *d, fit__problem *p, fit__end *e, diag__pursuit *c, stein_err *err)
{
    double T = diag__longest(p), most = p->horizon;
    double *room = malloc(sizeof *room * ((size_t)p->nstroke + 1));
    stein_status status = room != NULL ? STEIN_OK : lab__no_memory(err);
    for (int h = -1, last = 0, on = 1, vain = p->nstroke < 2; status == STEIN_OK && !last && on;) {
        h = h < 0 && c != NULL && c->first > 0.0 ? horizon_of(c->first, T)
                                                 : next_horizon(p, e, h, T, err);
        last = h + 1 == DIAG_HORIZONS || diag__horizon[h] * T >= most;
        p->horizon = h + 1 == DIAG_HORIZONS ? most : fmin(diag__horizon[h] * T, most);
        status = fit__descend(p, e, 0, enough, last ? RENEWALS_LAST : RENEWALS, err);
        e->fits++;
        // at the end only who is behind another one needs no strays called back
        on = status == STEIN_OK &&
             ((last && (c == NULL || c->most == NULL)) || goes_on(c, p, e, h, 0, room));
        if (on && !vain) {
            vain = recall_all(d, p, e, room, &status, err);
        }
        on = on && status == STEIN_OK && (last || goes_on(c, p, e, h, 1, room));
    }
    p->horizon = INFINITY;
    free(room);
    return status;
}

stein_status diag__pursue(diag *d, stein_err *err)
{
    fit__end e = {.x = d->x, .J = d->J, .r = d->r};
    fit__problem_try(&d->p, NULL);
    diag__pursuit c = {.reached = &d->null_marks};
    stein_status status = diag__follow(d, &d->p, &e, &c, err);
    d->out->fits += e.fits;
    d->ended = e.ended;
    // from the last derivatives to where they led is a short way
    return status == STEIN_OK ? fit__sensitivities(&d->p, d->x, d->r, d->J, err) : status;
}

stein_status diag__pursue_on(diag *d, stein_err *err)
{
    fit__end e = {.x = d->x, .J = d->J, .r = d->r};
    stein_status status = fit__descend(&d->p, &e, 1, enough, RENEWALS, err);
    d->out->fits++;
    d->ended = e.ended;
    return status == STEIN_OK ? fit__sensitivities(&d->p, d->x, d->r, d->J, err) : status;
}

stein_status diag__pursue_again(diag *d, const diag__suspect *leader, stein_err *err)
{
    fit__problem *p = &d->p;
    fit__end e = {.x = d->x, .J = d->J, .r = d->r}, t;
    double *room = beside(p, &e, &t, err);
    if (room == NULL) {
        return STEIN_ENOMEM;
    }
    e.objective = fit__chi2(p, d->r) + fit__priors(p, d->x);
    memcpy(t.x, leader->x, sizeof *t.x * (size_t)p->nu);
    memset(t.x + p->amount, 0, sizeof *t.x * FIT__NUMBERS);
    fit__problem_try(p, NULL);
    stein_err why = {STEIN_OK, ""};
    stein_status status = fit__descend(p, &t, 0, enough, RENEWALS_LAST, &why);
    d->out->fits++;
    if (status == STEIN_OK && t.objective < e.objective) {
        take_over(p, &e, &t);
        d->ended = e.ended;
        status = fit__sensitivities(p, d->x, d->r, d->J, &why);
        if (status != STEIN_ENOMEM) {
            status = diag__likelihood(p, d->x, d->J, d->r, d->null_D, d->sd, &d->null_objective,
                                      NULL, &why);
        }
        for (int i = 0; i < d->n; i++) {
            diag__suspect *s = &d->suspect[i];
            s->s.gain = s->s.refitted ? d->null_objective - s->objective : s->s.gain;
        }
    }
    free(room);
    return fit__forgive(status, err);
}
