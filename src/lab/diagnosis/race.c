/* SPDX-License-Identifier: GPL-3.0-or-later
 * race.c - who explains how the strokes begin?
 *
 * Where what is missing changes events, linear scores mislead, and to fit every suspect along all
 * strokes takes minutes. But the null fit leaves more than noise at a horizon already that is a
 * share of the strokes (early.c), and a fit up to there costs a share of that. What is missing
 * leaves noise there, and what is not leaves about what the null fit left: a race of few steps
 * tells.
 *
 *      all that score there --> one step --> the best --> to their ends --> three --> along the
 *                                                                           strokes (anew.c)
 *                                                                       --> some: as the first of
 *                                                                           two (along.c)
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "searching.h"

enum { FINAL = 16, LAST = 6, FOREMOST = 3, FIRST_OF_TWO = 6, NEARER = 2, RENEWALS = 3 };
static const double enough = 0.3;  /* of the objective */
static const double nearer = 0.2;  /* of an amount */
static const double share = 0.1;   /* of what more than noise there is: worth it */
static const double as_much = 0.8; /* of what the best one explains */

typedef struct runner {
    diag__suspect *s;
    double *x;
    double left; /* chi2 + priors at x; INFINITY: it cannot be fitted */
} runner;

/* on from x, up to the early horizon. @param known  1: with the derivatives of the null fit up to
 * there, and the suspect's own */
static stein_status run(diag *d, runner *r, int known, int renewals, stein_err *err)
{
    fit__problem *p = diag__problem(d, r->s);
    double *room = malloc(sizeof *room * (fit__offset(p, p->nstroke) + fit__columns(p) + 1));
    if (room == NULL) {
        return lab__no_memory(err);
    }
    fit__end e = {.x = r->x, .r = room, .J = room + fit__offset(p, p->nstroke)};
    stein_err why = {STEIN_OK, ""};
    if (known) {
        diag__borrow(p, d->early.J, r->s->early_G, e.J);
    }
    p->horizon = d->early.horizon;
    fit__problem_try(p, &r->s->s.candidate);
    stein_status status = fit__descend(p, &e, known, enough, renewals, &why);
    fit__problem_try(p, NULL);
    p->horizon = INFINITY;
    r->left = status == STEIN_OK ? e.objective : (double)INFINITY;
    d->out->fits++;
    free(room);
    return fit__forgive(status, err);
}

/* back to where the null fit has ended, with some amount */
static void go_back(diag *d, runner *r, double amount)
{
    const fit__problem *p = diag__problem(d, r->s);
    memcpy(r->x, d->early.x, sizeof *r->x * (size_t)p->nu);
    r->x[p->amount] = amount;
}

static int by_what_is_left(const void *a, const void *b)
{
    const runner *x = a, *y = b;
    return (x->left > y->left) - (x->left < y->left);
}

/* The first step of a number, which costs no new derivatives. To where its amount would have to be
 * negative it makes none; what changes events is not linear, and it may yet run. */
static stein_status step_of_number(diag *d, runner *r, stein_err *err)
{
    stein_status status = run(d, r, 1, 0, err);
    if (!r->s->s.candidate.effect->both_signs && !(r->x[diag__problem(d, r->s)->amount] > 0.0)) {
        go_back(d, r, r->s->early);
        r->left = d->early.objective;
    }
    return status;
}

/* The first step of a part, which is far from linear. Who leaves more than the null fit after it
 * has begun too far away, which tells nothing: it begins again nearer. */
static stein_status step_of_part(diag *d, runner *r, stein_err *err)
{
    double amount = r->x[diag__problem(d, r->s)->amount];
    stein_status status = run(d, r, 0, 0, err);
    for (int k = 0; k < NEARER && status == STEIN_OK && r->left > d->early.objective; k++) {
        amount *= nearer;
        go_back(d, r, amount);
        status = run(d, r, 0, 0, err);
    }
    return status;
}

static stein_status first_step(diag *d, runner *r, stein_err *err)
{
    int linear = r->s->model == NULL && r->s->early_G != NULL;
    return linear ? step_of_number(d, r, err) : step_of_part(d, r, err);
}

static stein_status heat(diag *d, runner *all, int n, int renewals, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        if (isfinite(all[i].left)) {
            status = renewals > 0 ? run(d, &all[i], 0, renewals, err) : first_step(d, &all[i], err);
        }
    }
    qsort(all, (size_t)n, sizeof *all, by_what_is_left);
    return status;
}

/* those that lead, from where the null fit has ended */
static int line_up(diag *d, runner *all, double *x)
{
    int n = 0;
    for (int i = 0; i < d->n && n < DIAG_RACE; i++) {
        diag__suspect *s = &d->suspect[i];
        if (isfinite(s->early)) {
            const fit__problem *p = diag__problem(d, s);
            memcpy(x, d->early.x, sizeof *x * (size_t)p->nu);
            x[p->amount] = s->model != NULL ? fmax(s->early, s->step) : diag__least_amount(s);
            all[n++] = (runner){.s = s, .x = x};
            x += p->nu;
        }
    }
    return n;
}

/* Does the winner leave but noise, and everybody at another place more than that or clearly more
 * than the winner? Then it is there, whatever hides it later. */
static int begins(const diag *d, const runner *all, int n)
{
    double left = n > 0 ? all[0].left : (double)INFINITY, next = d->early.objective;
    for (int i = 1; i < n; i++) {
        int related = diag__related(&all[i].s->s.candidate, &all[0].s->s.candidate);
        next = related ? next : fmin(next, all[i].left);
    }
    int alone = diag__is_clear(next, d->early.samples) || next - left > diag__least_gain;
    return alone && diag__is_clear(d->early.objective, d->early.samples) &&
           !diag__is_clear(left, d->early.samples);
}

static stein_status keep(diag *d, const runner *r, double **to, stein_err *err)
{
    size_t size = sizeof *r->x * (size_t)diag__problem(d, r->s)->nu;
    free(*to);
    *to = malloc(size);
    if (*to == NULL) {
        return lab__no_memory(err);
    }
    memcpy(*to, r->x, size);
    return STEIN_OK;
}

/* those that may be the first of two causes */
static stein_status keep_leading(diag *d, const runner *all, int n, double least, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < n && i < FIRST_OF_TWO; i++) {
        if (d->early.objective - all[i].left > least) {
            status = keep(d, &all[i], &all[i].s->led, err);
        }
    }
    return status;
}

static stein_status place(diag *d, const runner *r, int on, stein_err *err)
{
    diag__suspect *s = r->s;
    const fit__problem *p = diag__problem(d, s);
    size_t size = sizeof *r->x * (size_t)p->nu;
    s->early = on ? r->x[p->amount] : (double)NAN;
    s->early_left = r->left;
    if (on && s->start == NULL) {
        s->start = malloc(size);
    }
    if (on && s->start == NULL) {
        return lab__no_memory(err);
    }
    if (on) {
        memcpy(s->start, r->x, size);
    }
    return STEIN_OK;
}

int diag__is_beyond_one(const diag *d)
{
    return diag__is_clear(d->early.left, d->early.samples);
}

stein_status diag__race(diag *d, stein_err *err)
{
    runner all[DIAG_RACE];
    double *x = malloc(sizeof *x * DIAG_RACE * (size_t)d->p.nu);
    if (x == NULL) {
        return lab__no_memory(err);
    }
    int n = line_up(d, all, x);
    stein_status status = heat(d, all, n, 0, err);
    status = status == STEIN_OK ? heat(d, all, n < FINAL ? n : FINAL, RENEWALS, err) : status;
    status = status == STEIN_OK ? heat(d, all, n < LAST ? n : LAST, RENEWALS, err) : status;
    d->early.left = n > 0 ? all[0].left : 0.0;
    double explained = d->early.objective - d->early.left;
    double least = fmax(share * (d->early.objective - d->early.samples), as_much * explained);
    if (status == STEIN_OK && begins(d, all, n)) {
        status = keep(d, &all[0], &all[0].s->begins, err);
    }
    status = status == STEIN_OK ? keep_leading(d, all, n, least, err) : status;
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        status = place(d, &all[i], i < FOREMOST && d->early.objective - all[i].left > least, err);
    }
    free(x);
    return status;
}
