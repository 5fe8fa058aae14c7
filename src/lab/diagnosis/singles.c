/* SPDX-License-Identifier: GPL-3.0-or-later
 * singles.c - strokes that are fitted one by one.
 *
 * What all strokes share stays; a stroke's own numbers are fitted to it along its course. In one
 * fit the strokes would wait for the slowest, and one that has far to go stops all.
 *
 *      every stroke from 0 ... strays among them: again, from a start to either side of everything
 *                              that differs from stroke to stroke ... the best start is kept
 *
 * Which events a stroke has depends on what differs, and no step leads across one: hence the
 * starts. None knows of another, so all of them are under way at once, side by side. One that is
 * further from the data before its end than the first one was at its own is given up.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "functions.h"
#include "searching.h"

static const double aside = 1.5; /* of another start, in sd of the scatter */

/* a fit of one stroke */
typedef struct single {
    int stroke, k;       /* k of its own unknowns is at `first` where it begins, -1: none */
    double first, bound; /* bound: of the objective of a start, beyond which it is given up */
    double *x, *r;       /* where it ends: own unknowns, residuals */
    double objective;    /* INFINITY: it cannot be simulated there */
    int fits;
} single;

stein_status diag__own_problem(diag *d, const fit__problem *like, const lab_dataset *data,
                               const lab_candidate *effect, const double *D, fit__problem *p,
                               stein_err *err)
{
    const lab_candidate *accepted = like->naccepted > 0 ? like->accepted[0] : NULL;
    stein_status status =
        fit__problem_make_with(p, like->model, data, &d->fit_def, accepted, like->naccepted, err);
    if (status != STEIN_OK) {
        return status;
    }
    p->tolerance = d->p.tolerance;
    for (int k = p->np; k < p->nu; k++) {
        fit__unknown *u = &p->unknown[k];
        u->sd *= u->kind == FIT__SCATTER ? sqrt(fmax(D[u->index - FIT__JOINTS], 1e-6)) : 1.0;
    }
    fit__problem_try(p, effect);
    for (int k = 0; k < p->np; k++) {
        p->unknown[k].idle = 1;
    }
    return STEIN_OK;
}

/* ---- one of them ---- */

/* one stroke of the problem of all, on the lanes that it shares with others
 * @param x  [nu + columns] out: what is shared as it is, its own at 0; room for derivatives
 * @return OK; free the problem in any case */
static stein_status open_one(const diag__singles *s, int stroke, fit__pool *pool, fit__problem *own,
                             double **x, stein_err *err)
{
    lab_dataset one = {1, &s->p->data->stroke[stroke]};
    *x = NULL;
    stein_status status = diag__own_problem(s->d, s->p, &one, s->p->effect, s->D, own, err);
    if (status != STEIN_OK) {
        return status;
    }
    own->horizon = s->p->horizon;
    own->pool = pool;
    *x = calloc((size_t)own->nu + fit__columns(own) + 1, sizeof **x);
    if (*x == NULL) {
        return lab__no_memory(err);
    }
    memcpy(*x, s->x, sizeof **x * (size_t)own->np);
    return STEIN_OK;
}

typedef struct crowd {
    const diag__singles *s;
    single *one;
} crowd;

static stein_status fit_one(void *ctx, int i, fit__pool *pool, stein_err *err)
{
    const crowd *c = ctx;
    single *one = &c->one[i];
    fit__problem own;
    double *x;
    stein_status status = open_one(c->s, one->stroke, pool, &own, &x, err);
    if (status == STEIN_OK) {
        fit__end e = {.x = x, .J = x + own.nu, .r = one->r};
        double most[DIAG_HORIZONS];
        for (int h = 0; h < DIAG_HORIZONS; h++) {
            most[h] = one->bound;
        }
        diag__pursuit course = {.most = one->k >= 0 ? most : NULL};
        if (one->k >= 0) {
            x[own.np + one->k] = one->first;
        }
        status = diag__follow(c->s->d, &own, &e, &course, err);
        memcpy(one->x, x + own.np, sizeof *x * (size_t)(own.nu - own.np));
        one->objective =
            status == STEIN_OK ? fit__chi2(&own, e.r) + fit__priors(&own, x) : (double)INFINITY;
        one->fits = e.fits;
    }
    free(x);
    fit__problem_free(&own);
    // a start is a try; that the stroke cannot be followed at all is a failure
    return one->k >= 0 && status != STEIN_ENOMEM ? fit__forgive(status, err) : status;
}

/* ---- all of them ---- */

/* every marked stroke from 0 */
static stein_status first_starts(diag__singles *s, const unsigned char *marked, double *objective,
                                 stein_err *err)
{
    const fit__problem *p = s->p;
    single *one = calloc((size_t)p->nstroke + 1, sizeof *one);
    int n = 0;
    if (one == NULL) {
        return lab__no_memory(err);
    }
    for (int a = 0; a < p->nstroke; a++) {
        if (marked == NULL || marked[a]) {
            one[n++] = (single){.stroke = a,
                                .k = -1,
                                .x = s->x + p->stroke[a].first,
                                .r = s->r + fit__offset(p, a)};
        }
    }
    crowd c = {s, one};
    stein_status status = n > 0 ? fit__together(p, n, fit_one, &c, err) : STEIN_OK;
    for (int i = 0; i < n; i++) {
        objective[one[i].stroke] = one[i].objective;
        s->fits += one[i].fits;
    }
    free(one);
    return status;
}

/* a start to each side of everything that differs, of a stroke. @return how many */
static int sides(const fit__problem *p, int stroke, double bound, single *one)
{
    const fit__stroke *t = &p->stroke[stroke];
    int n = 0;
    for (int k = 0; k < t->own; k++) {
        for (int up = 0; p->unknown[t->first + k].kind == FIT__SCATTER && up < 2; up++, n++) {
            one[n] =
                (single){.stroke = stroke, .k = k, .first = up ? aside : -aside, .bound = bound};
        }
    }
    return n;
}

/* room for x and r of n fits. @return NULL: out of memory */
static double *give_room(const fit__problem *p, single *one, int n)
{
    size_t size = 0;
    for (int i = 0; i < n; i++) {
        const fit__stroke *t = &p->stroke[one[i].stroke];
        size += (size_t)(t->own + t->nch * t->n);
    }
    double *room = malloc(sizeof *room * (size + 1)), *next = room;
    for (int i = 0; room != NULL && i < n; i++) {
        const fit__stroke *t = &p->stroke[one[i].stroke];
        one[i].x = next;
        one[i].r = next + t->own;
        next += t->own + t->nch * t->n;
    }
    return room;
}

/* the better one of a stroke's starts */
static void keep(const diag__singles *s, const single *one, double *objective)
{
    const fit__stroke *t = &s->p->stroke[one->stroke];
    if (one->objective < objective[one->stroke]) {
        objective[one->stroke] = one->objective;
        memcpy(s->x + t->first, one->x, sizeof *one->x * (size_t)t->own);
        memcpy(s->r + fit__offset(s->p, one->stroke), one->r,
               sizeof *one->r * (size_t)(t->nch * t->n));
    }
}

/* strays among the marked ones from the other starts */
static stein_status other_starts(diag__singles *s, const unsigned char *marked, double *objective,
                                 stein_err *err)
{
    const fit__problem *p = s->p;
    single *one = calloc(2 * (size_t)(p->nu - p->np) + 1, sizeof *one);
    int n = 0;
    if (one == NULL) {
        return lab__no_memory(err);
    }
    for (int a = 0; a < p->nstroke; a++) {
        if ((marked == NULL || marked[a]) && diag__is_stray(p, s->r, a, s->middle)) {
            n += sides(p, a, objective[a], one + n);
        }
    }
    double *room = give_room(p, one, n);
    crowd c = {s, one};
    stein_status status = room == NULL ? lab__no_memory(err)
                          : n > 0      ? fit__together(p, n, fit_one, &c, err)
                                       : STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        keep(s, &one[i], objective);
        s->fits += one[i].fits;
    }
    free(room);
    free(one);
    return status;
}

stein_status diag__fit_singles(diag__singles *s, const unsigned char *marked, stein_err *err)
{
    size_t n = (size_t)s->p->nstroke;
    double *room = malloc(sizeof *room * (2 * n + 1));
    if (room == NULL) {
        return lab__no_memory(err);
    }
    stein_status status = first_starts(s, marked, room, err);
    if (status == STEIN_OK) {
        s->middle = isfinite(s->middle) ? s->middle : diag__middle(s->p, s->r, room + n);
        status = other_starts(s, marked, room, err);
    }
    free(room);
    return status;
}

/* ---- likelihood ---- */

typedef struct judged {
    const diag__singles *s;
    double *deviance; /* [nstroke] */
} judged;

/* -2 log likelihood of a stroke at the end of its fit, its own unknowns marginalised (Laplace);
 * what differs by itself is Student's, as its variance is known from n strokes only; INFINITY where
 * it cannot be simulated next to that */
static stein_status deviance(const fit__problem *p, double *x, const double *r, int n,
                             double *value, stein_err *err)
{
    double nu = fmax(1.0, n - 1.0), *J = x + p->nu;
    stein_err why = {STEIN_OK, ""};
    stein_status status = fit__sensitivities(p, x, r, J, &why);
    *value = INFINITY;
    if (status == STEIN_OK) {
        lab__mixed m = {.nf = 0};
        status = diag__mixed_at(&m, p, x, J, r, NULL, 0, &why);
        if (status == STEIN_OK) {
            lab__mixed_weigh(&m);
            *value = fit__chi2(p, r) + fit__priors(p, x) + m.logdet;
            for (int k = p->np; k < p->nu; k++) {
                double square = x[k] * x[k];
                *value += p->unknown[k].kind == FIT__SCATTER
                              ? (nu + 1.0) * stein__log_of(1.0 + square / nu) - square
                              : 0.0;
            }
        }
        lab__mixed_free(&m);
    }
    return fit__forgive(status, err);
}

static stein_status judge_one(void *ctx, int i, fit__pool *pool, stein_err *err)
{
    const judged *j = ctx;
    const diag__singles *s = j->s;
    const fit__stroke *t = &s->p->stroke[i];
    fit__problem own;
    double *x;
    stein_status status = open_one(s, i, pool, &own, &x, err);
    if (status == STEIN_OK) {
        memcpy(x + own.np, s->x + t->first, sizeof *x * (size_t)t->own);
        status =
            deviance(&own, x, s->r + fit__offset(s->p, i), s->d->p.nstroke, &j->deviance[i], err);
    }
    free(x);
    fit__problem_free(&own);
    return status;
}

stein_status diag__deviance(const diag__singles *s, double *each, stein_err *err)
{
    judged j = {s, each};
    return fit__together(s->p, s->p->nstroke, judge_one, &j, err);
}
