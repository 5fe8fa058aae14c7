/* SPDX-License-Identifier: GPL-3.0-or-later
 * anew.c - fits that begin anew.
 *
 * A fit ends where it began to go: with the events of its strokes as they were, and with the
 * numbers that others have bent. What explains the data may be behind an escapement that comes a
 * moment later. So a fit that ends far from the data is made again from another start, and kept
 * when it is better:
 *
 *   - from the file's own numbers along the strokes, with the effect in the model (pursue.c)
 *   - from the end of a race up to an early horizon, along the strokes (race.c)
 *   - without the strokes that it has lost (strays.c)
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "searching.h"

enum {
    RENEW_LAST = 4,
    TRIES = 3,
    ANEW = 5 /* fits from the file's own numbers, of one search: they cost most of it */
};
const double diag__worth_anew = 40.0, diag__worth_starts = 0.7;
static const double worth_a_try = 10.0; /* of the objective */
static const double farthest = 1.8;     /* quarters, of a number beside an amount */
static const double a_step = 0.05;      /* of the way to the best one: less leads nowhere */

/* where the effect begins; NAN: where it is */
typedef struct beginning {
    double amount, first; /* in limits; the first number beside the amount, in its quarters */
} beginning;

/* the best fit of a search so far, NULL: there is none */
static const diag__suspect *best_of(const diag *d)
{
    const diag__suspect *best = NULL;
    for (int i = 0; i < d->n; i++) {
        const diag__suspect *s = &d->suspect[i];
        int fitted = s->s.refitted && isfinite(s->objective);
        best = fitted && (best == NULL || s->left < best->left) ? s : best;
    }
    return best;
}

/* along the strokes from s->x, with the effect in the model; @param c  NULL: to their end */
static stein_status follow_from(diag *d, diag__suspect *s, diag__pursuit *c, int *found,
                                stein_err *err)
{
    fit__problem *p = diag__problem(d, s);
    fit__end e = {.x = s->x, .J = s->J, .r = s->r};
    fit__problem_try(p, &s->s.candidate);
    stein_status status = diag__follow(d, p, &e, c, err);
    d->out->fits += e.fits;
    fit__problem_try(p, NULL);
    s->unknown_J = 0;
    *found = c == NULL || !c->given_up;
    return status;
}

/* the same, held against the null fit and the best one
 * @param to_noise  1: given up where it clearly leaves more, first where the strokes begin */
static stein_status along(diag *d, diag__suspect *s, int to_noise, int *found, stein_err *err)
{
    fit__problem *p = diag__problem(d, s);
    const diag__suspect *best = best_of(d);
    double most[DIAG_HORIZONS];
    if (best != NULL) {
        diag__ahead(p, best->r, best->left, most);
    }
    diag__pursuit c = {.most = best != NULL ? most : NULL,
                       .null = &d->null_marks,
                       .to_noise = to_noise,
                       .first = to_noise && d->early.z > 0.0 ? d->early.horizon : 0.0};
    return follow_from(d, s, &c, found, err);
}

/* Along the strokes from the file's own numbers, with the effect in the model: a null fit without
 * it has bent parameters so far that no step leads back. */
static stein_status from_the_file(diag *d, diag__suspect *s, const void *ctx, int *found,
                                  stein_err *err)
{
    const beginning at = *(const beginning *)ctx;
    fit__problem *p = diag__problem(d, s);
    double number[FIT__NUMBERS];
    memcpy(number, s->x + p->amount, sizeof number);
    memset(s->x, 0, sizeof *s->x * (size_t)p->first_accepted);
    memset(s->x + p->np, 0, sizeof *s->x * (size_t)(p->nu - p->np));
    for (int k = 1; k < FIT__NUMBERS; k++) {
        s->x[p->amount + k] = fmin(fmax(number[k], -1.0), 1.0);
    }
    s->x[p->amount] = isfinite(at.amount) ? at.amount : s->x[p->amount];
    s->x[p->side] = isfinite(at.first) ? at.first : s->x[p->side];
    return along(d, s, 1, found, err);
}

/* from where it has ended in the race */
static stein_status from_the_race(diag *d, diag__suspect *s, const void *ctx, int *found,
                                  stein_err *err)
{
    (void)ctx;
    memcpy(s->x, s->start, sizeof *s->x * (size_t)diag__problem(d, s)->nu);
    return along(d, s, 0, found, err);
}

static stein_status without_strays(diag *d, diag__suspect *s, const void *ctx, int *found,
                                   stein_err *err)
{
    (void)ctx;
    fit__problem *p = diag__problem(d, s);
    fit__end e = {.x = s->x, .J = s->J, .r = s->r};
    fit__problem_try(p, &s->s.candidate);
    stein_status status = diag__recall_strays(d, p, &e, 1, found, err);
    d->out->fits += e.fits;
    fit__problem_try(p, NULL);
    s->unknown_J = 1;
    return status;
}

stein_status diag__again(diag *d, diag__suspect *s, diag__start *start, const void *ctx,
                         stein_err *err)
{
    const diag__suspect was = *s;
    size_t size = diag__room_of(diag__problem(d, s));
    double *room = malloc(sizeof *room * size);
    if (room == NULL) {
        return lab__no_memory(err);
    }
    memcpy(room, s->x, sizeof *room * size);
    stein_err why = {STEIN_OK, ""};
    int found = 0;
    stein_status status = start(d, s, ctx, &found, &why);
    if (status == STEIN_OK && found) {
        status = diag__fit_on(d, s, s->unknown_J ? RENEW_LAST : 1, &why);
    }
    double tried = found && status == STEIN_OK ? s->objective : (double)INFINITY;
    if (!(tried < was.objective)) {
        memcpy(s->x, room, sizeof *room * size);
        *s = was;
    }
    s->tried = tried;
    free(room);
    return fit__forgive(status, err);
}

/* along the strokes, then to the end */
static stein_status follow(diag *d, diag__suspect *s, diag__start *start, const void *ctx,
                           stein_err *err)
{
    stein_status status = diag__make_room(d, s, err);
    if (status == STEIN_OK && !s->s.refitted) {
        memcpy(s->x, d->x, sizeof *s->x * (size_t)diag__problem(d, s)->nu);
        s->objective = INFINITY;
    }
    status = status == STEIN_OK ? diag__again(d, s, start, ctx, err) : status;
    s->begun = 1;
    return status == STEIN_OK ? diag__to_the_end(d, s, err) : status;
}

/* from where it explains how they begin, to their end whatever that leaves */
static stein_status from_the_begin(diag *d, diag__suspect *s, const void *ctx, int *found,
                                   stein_err *err)
{
    (void)ctx;
    memcpy(s->x, s->begins, sizeof *s->x * (size_t)diag__problem(d, s)->nu);
    return follow_from(d, s, NULL, found, err);
}

stein_status diag__from_the_begin(diag *d, diag__suspect *s, stein_err *err)
{
    stein_status status = diag__make_room(d, s, err);
    s->objective = INFINITY;
    return status == STEIN_OK ? diag__again(d, s, from_the_begin, NULL, err) : status;
}

stein_status diag__from_the_file(diag *d, diag__suspect *s, double amount, stein_err *err)
{
    return follow(d, s, from_the_file, &(beginning){amount, NAN}, err);
}

/* What a fit has to gain to be worth another one. Far behind the best one that is a share of the
 * way: in a few steps it is there, or nowhere. */
static double least_step(const diag *d, const diag__suspect *s)
{
    const diag__suspect *best = best_of(d);
    return fmax(worth_a_try, best != NULL ? a_step * (s->left - best->left) : 0.0);
}

/* is it elsewhere than where something has brought nothing? */
static int has_moved(const diag__suspect *s, double in_vain)
{
    return !(fabs(in_vain - s->objective) <= worth_a_try);
}

/* A fit that has become worse, as likelihoods may while chi2 falls, has moved as well; that ends a
 * round, and the next one goes on from there. */
stein_status diag__to_the_end(diag *d, diag__suspect *s, stein_err *err)
{
    stein_status status = STEIN_OK;
    double was = INFINITY;
    for (int k = 0; status == STEIN_OK && k < TRIES && !s->ended && isfinite(s->objective) &&
                    was - s->objective > least_step(d, s) && has_moved(s, s->stuck);
         k++) {
        was = s->objective;
        status = diag__attempt(d, s, RENEW_LAST, err);
        s->stuck = fabs(was - s->objective) <= worth_a_try ? s->objective : s->stuck;
    }
    return status;
}

/* more than noise is left to a suspect that gains enough to be worth a search, or strokes of it
 * have numbers that nobody believes */
int diag__leaves_more(diag *d, const diag__suspect *s)
{
    return isfinite(s->objective) && s->s.gain > diag__worth_anew &&
           (diag__is_on(d, s->s.chi2_dof) || diag__has_bent(diag__problem(d, s), s->x));
}

stein_status diag__recall(diag *d, diag__suspect *s, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int k = 0;
         status == STEIN_OK && k < TRIES && diag__leaves_more(d, s) && has_moved(s, s->unheeded);
         k++) {
        double was = s->objective;
        status = diag__again(d, s, without_strays, NULL, err);
        s->unheeded = was - s->objective > least_step(d, s) ? s->unheeded : s->objective;
    }
    return status;
}

/* From the file's own numbers, until one of the starts leads to noise: where a gap begins or a
 * spring is tight decides which events a stroke has, and no small step leads across one. The first
 * amount is that of bent numbers; where much was gained by a start, another one with the amount
 * found there may lead on. Where a start has ended where the fit is already, so do the others. */
stein_status diag__begin_anew(diag *d, diag__suspect *s, stein_err *err)
{
    static const double first[] = {NAN, NAN, 1.0, -1.0}; // quarters of the range
    int several =
        s->s.candidate.side[0].param >= 0 && s->s.gain > diag__worth_starts * d->suspect[0].s.gain;
    stein_status status = STEIN_OK;
    double was = INFINITY;
    for (int k = 0; k < (several ? 4 : 2) && status == STEIN_OK && diag__leaves_more(d, s); k++) {
        int same = k > 0 && was - s->objective <= worth_a_try &&
                   fabs(s->tried - s->objective) <= worth_a_try;
        if ((k == 1 && !(was - s->objective > diag__worth_anew)) || same || d->anew >= ANEW) {
            continue;
        }
        d->anew++;
        was = s->objective;
        status = diag__again(d, s, from_the_file, &(beginning){NAN, first[k]}, err);
        if (status == STEIN_OK && s->objective < was) { // else it stays where it was
            status = diag__to_the_end(d, s, err);
            status = status == STEIN_OK ? diag__recall(d, s, err) : status;
        }
    }
    s->begun = 1;
    return status;
}

/* where it ended, but for the first number beside the amount */
static stein_status from_beside(diag *d, diag__suspect *s, const void *ctx, int *found,
                                stein_err *err)
{
    const beginning *at = ctx;
    (void)err;
    s->x[diag__problem(d, s)->side] = at->first;
    s->unknown_J = 1;
    *found = 1;
    return STEIN_OK;
}

stein_status diag__from_beside(diag *d, diag__suspect *s, stein_err *err)
{
    static const double way[] = {1.0, -1.0}; // quarters of the range
    double ended = s->x[diag__problem(d, s)->side], was = s->objective;
    stein_status status = STEIN_OK;
    for (int k = 0; status == STEIN_OK && k < 2 && !(was - s->objective > worth_a_try); k++) {
        beginning at = {NAN, fmin(fmax(ended + way[k], -farthest), farthest)};
        status = diag__again(d, s, from_beside, &at, err);
    }
    return status;
}

/* the early one that left least, and of equals the first. @return NULL: none is left */
static diag__suspect *next_early(diag *d)
{
    diag__suspect *next = NULL;
    for (int i = 0; i < d->n; i++) {
        diag__suspect *s = &d->suspect[i];
        next = isfinite(s->early) && (next == NULL || s->early_left < next->early_left) ? s : next;
    }
    return next;
}

stein_status diag__early_ones(diag *d, int relatives, stein_err *err)
{
    stein_status status = STEIN_OK;
    const diag__suspect *end = NULL; // leaves but noise
    diag__suspect *s;
    while (status == STEIN_OK && (s = next_early(d)) != NULL) {
        beginning at = {s->model != NULL ? fmax(s->early, diag__least_amount(s)) : s->early, NAN};
        s->early = NAN;
        if (end != NULL && !(relatives && diag__related(&s->s.candidate, &end->s.candidate))) {
            continue;
        }
        status = follow(d, s, relatives ? from_the_file : from_the_race, &at, err);
        int ends = isfinite(s->objective) && !diag__is_on(d, s->s.chi2_dof) &&
                   !diag__has_bent(diag__problem(d, s), s->x);
        end = end == NULL && ends ? s : end;
    }
    diag__sort(d);
    return status;
}
