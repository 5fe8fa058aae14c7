/* SPDX-License-Identifier: GPL-3.0-or-later
 * curve_outline.c - few points of a law, where the strokes begin.
 *
 * Where a law is missing that decides about events the null fit ends far from the data, and a curve
 * of many points that is fitted from there goes astray: its linear prediction promises the whole
 * misfit, for zigzags that no step of it keeps. So it is asked where the strokes first show that
 * something is missing. Up to there a curve of few points, evenly apart, is fitted at every place
 * that scores. Where it explains most the curve of many points begins from its outline:
 *
 *      all that score there --> outlines --> heats --> two along the strokes (curve_follow.c)
 *
 * Several may explain that beginning alike: a law over a depth, over its rate, of a joint that
 * moves with it. They part a little later, and to see that costs a fraction of a way to the end.
 * So the horizon goes on in strides, and who falls behind is out.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "curve.h"
#include "stein/law.h"

enum { RUNNERS = 5, RENEWALS = 5, RENEWALS_DAMPED = 8, HEATS = 4 };
static const double enough = 0.3; /* of the objective */
static const double near = 0.15;  /* share of the best score from which on a curve runs */
static const double worth =
    0.90; /* share of what the best one explains from which on one goes on */
static const double stride = 0.05;              /* of the longest stroke */
static const double stuck = 0.99, damped = 1e4; /* of what was left; damping */

typedef struct runner {
    diag__curve curve;
    double *x;         /* [nu] */
    double left;       /* chi2 and priors; INFINITY: it cannot be fitted */
    double left_early; /* up to the early horizon */
} runner;

static const diag__site *outline_of(const diag__curves *w, const diag__site *s)
{
    return s + w->nsite;
}

static int by_what_is_left(const void *a, const void *b)
{
    const runner *x = a, *y = b;
    return (x->left > y->left) - (x->left < y->left);
}

/* From where it is up to a horizon. An outline's prior is loose: a step that is damped by that
 * alone may lead a hundred noises astray, and down is where it is damped by what it changes. */
static stein_status run(diag__curves *w, runner *r, fit__end *e, double horizon, stein_err *err)
{
    fit__problem *p = &w->p;
    stein_err why = {STEIN_OK, ""};
    e->x = r->x;
    diag__curve_free_only(w, outline_of(w, r->curve.site));
    p->horizon = horizon;
    stein_status status = fit__descend(p, e, 0, enough, RENEWALS, &why);
    e->fits++;
    if (status == STEIN_OK && !e->ended && e->objective > stuck * r->left) {
        e->mu = damped;
        status = fit__descend(p, e, 0, enough, RENEWALS_DAMPED, &why);
        e->mu = 0.0;
        e->fits++;
    }
    p->horizon = INFINITY;
    r->left = status == STEIN_OK ? e->objective : (double)INFINITY;
    return fit__forgive(status, err);
}

/* those in front. @return how many they are, now sorted */
static int in_front(const diag__curves *w, runner *all, int n)
{
    if (n < 1) {
        return 0;
    }
    qsort(all, (size_t)n, sizeof *all, by_what_is_left);
    double behind = (1.0 - worth) * (w->early.objective - all[0].left_early);
    int on = 1;
    while (on < n && all[on].left < all[0].left + behind) {
        on++;
    }
    return on;
}

/* who is in front a little later, too? @return how many */
static stein_status heats(diag__curves *w, runner *all, int *n, fit__end *e, stein_err *err)
{
    stein_status status = STEIN_OK;
    double T = diag__longest(&w->p);
    for (int k = 1; k <= HEATS && status == STEIN_OK && *n > 1; k++) {
        for (int i = 0; status == STEIN_OK && i < *n; i++) {
            all[i].left = INFINITY; // of another horizon
            status = run(w, &all[i], e, w->early.horizon + k * stride * T, err);
        }
        *n = in_front(w, all, *n);
    }
    return status;
}

/* the curve where its outline is, which becomes 0 */
static void take_outline(const diag__curves *w, const diag__site *s, double *x)
{
    const diag__site *o = outline_of(w, s);
    double value[CURVE_POINTS], slope[CURVE_POINTS];
    for (int k = 0; k < o->n; k++) {
        value[k] = fit__value(&w->p.unknown[o->first + k], x[o->first + k]);
        x[o->first + k] = 0.0;
    }
    stein_table_slopes(o->n, o->at, value, slope);
    for (int k = s->pinned; k < s->n; k++) {
        x[s->first + k] = stein_table_value(o->n, o->at, value, slope, s->at[k]);
    }
}

stein_status diag__curve_outlines(diag *d, diag__curves *w, const diag__curve *c, int n,
                                  diag__curve *to, int *found, stein_err *err)
{
    const fit__problem *p = &w->p;
    size_t nu = (size_t)p->nu, rows = fit__offset(p, p->nstroke);
    runner all[RUNNERS];
    double *room = malloc(sizeof *room * (RUNNERS * nu + rows + fit__columns(p) + 1));
    stein_status status = room != NULL ? STEIN_OK : lab__no_memory(err);
    fit__end e = {.x = room, .r = room, .J = room};
    int running = 0;
    *found = 0;
    if (status == STEIN_OK) {
        e.r += RUNNERS * nu;
        e.J = e.r + rows;
    }
    for (; status == STEIN_OK && running < RUNNERS && running < n &&
           c[running].gain > near * c[0].gain;
         running++) {
        all[running] = (runner){.curve = {.site = c[running].site, .held = NAN},
                                .x = room + (size_t)running * nu};
        memcpy(all[running].x, w->early.x, sizeof *room * nu);
        all[running].left = w->early.objective;
        status = run(w, &all[running], &e, w->early.horizon, err);
        all[running].left_early = all[running].left;
    }
    running = in_front(w, all, running);
    status = status == STEIN_OK ? heats(w, all, &running, &e, err) : status;
    d->out->fits += e.fits;
    int done = 0;
    for (int i = 0; status == STEIN_OK && i < running && i < OUTLINES && !done; i++) {
        take_outline(w, all[i].curve.site, all[i].x);
        to[*found] = all[i].curve;
        status = diag__curve_follow(d, w, all[i].x, &to[*found], err);
        done = status == STEIN_OK && diag__curve_describes(d, w, &to[*found]);
        if (to[*found].fitted) {
            ++*found;
        } else {
            free(to[*found].x);
        }
    }
    free(room);
    return status;
}
