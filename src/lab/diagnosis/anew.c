/* SPDX-License-Identifier: GPL-3.0-or-later
 * anew.c - fits that begin anew.
 *
 * A fit ends where it began to go: with the events of its strokes as they were, and with the
 * numbers that others have bent. What explains the data may be behind an escapement that comes a
 * moment later. So a fit that ends far from the data is made again from another start, and kept
 * when it is better:
 *
 *   - from the file's own numbers along the strokes, with the effect in the model (pursue.c)
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
static const double worth_a_try = 10.0; /* of the objective */
static const double worth_anew = 40.0;  /* gain */
static const double worth_starts = 0.7; /* of the best gain: worth more than one start */

/* where the effect begins; NAN: where it is */
typedef struct beginning {
    double amount, first; /* in limits; the first number beside the amount, in its quarters */
} beginning;
static const beginning as_it_is = {NAN, NAN};

/* Another start: s->x, from which all is fitted with new derivatives. `found` 0: there is none. */
typedef stein_status another_start(diag *d, diag__suspect *s, beginning at, int *found,
                                   stein_err *err);

/* Along the strokes from the file's own numbers, with the effect in the model: a null fit without
 * it has bent parameters so far that no step leads back. */
static stein_status from_the_file(diag *d, diag__suspect *s, beginning at, int *found,
                                  stein_err *err)
{
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
    fit__problem_try(p, &s->s.candidate);
    fit__end e = {.x = s->x, .J = s->J, .r = s->r};
    stein_status status = diag__follow(d, p, &e, err);
    d->out->fits += e.fits;
    fit__problem_try(p, NULL);
    *found = 1;
    return status;
}

static stein_status without_strays(diag *d, diag__suspect *s, beginning at, int *found,
                                   stein_err *err)
{
    (void)at;
    fit__problem *p = diag__problem(d, s);
    fit__end e = {.x = s->x, .J = s->J, .r = s->r};
    fit__problem_try(p, &s->s.candidate);
    stein_status status = diag__recall_strays(d, p, &e, 1, found, err);
    d->out->fits += e.fits;
    fit__problem_try(p, NULL);
    return status;
}

/* a fit from another start, kept when it is better */
static stein_status again(diag *d, diag__suspect *s, another_start *start, beginning at,
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
    stein_status status = start(d, s, at, &found, &why);
    if (status == STEIN_OK && found) {
        s->unknown_J = start != from_the_file;
        status = diag__fit_on(d, s, s->unknown_J ? RENEW_LAST : 1, &why);
    }
    if (found && (status != STEIN_OK || !(s->objective < was.objective))) {
        memcpy(s->x, room, sizeof *room * size);
        *s = was;
    }
    free(room);
    return fit__forgive(status, err);
}

stein_status diag__from_the_file(diag *d, diag__suspect *s, double amount, stein_err *err)
{
    stein_status status = diag__make_room(d, s, err);
    if (status == STEIN_OK && !s->s.refitted) {
        memcpy(s->x, d->x, sizeof *s->x * (size_t)diag__problem(d, s)->nu);
        s->objective = INFINITY;
    }
    status = status == STEIN_OK
                 ? again(d, s, from_the_file, (beginning){.amount = amount, .first = NAN}, err)
                 : status;
    return status == STEIN_OK ? diag__to_the_end(d, s, err) : status;
}

/* until the fit has ended or new derivatives bring nothing any more */
stein_status diag__to_the_end(diag *d, diag__suspect *s, stein_err *err)
{
    stein_status status = STEIN_OK;
    double was = INFINITY;
    for (int k = 0; status == STEIN_OK && k < TRIES && !s->ended && isfinite(s->objective) &&
                    was - s->objective > worth_a_try;
         k++) {
        was = s->objective;
        status = diag__attempt(d, s, RENEW_LAST, err);
    }
    return status;
}

/* more than noise is left to a suspect that gains enough to be worth a search, or strokes of it
 * have numbers that nobody believes */
int diag__leaves_more(diag *d, const diag__suspect *s)
{
    return isfinite(s->objective) && s->s.gain > worth_anew &&
           (diag__is_off(d, s->s.chi2_dof) || diag__has_bent(diag__problem(d, s), s->x));
}

/* without the strays of where it is, and once more when that has brought something */
stein_status diag__recall(diag *d, diag__suspect *s, stein_err *err)
{
    stein_status status = STEIN_OK;
    double was = INFINITY;
    for (int k = 0; status == STEIN_OK && k < TRIES && diag__leaves_more(d, s) &&
                    was - s->objective > worth_a_try;
         k++) {
        was = s->objective;
        status = again(d, s, without_strays, as_it_is, err);
    }
    return status;
}

/* From the file's own numbers, until one of the starts leads to noise: where a gap begins or a
 * spring is tight decides which events a stroke has, and no small step leads across one. The first
 * amount is that of bent numbers; where much was gained by a start, another one with the amount
 * found there may lead on. */
stein_status diag__begin_anew(diag *d, diag__suspect *s, stein_err *err)
{
    static const double first[] = {NAN, NAN, 1.0, -1.0}; // quarters of the range
    int several =
        s->s.candidate.side[0].param >= 0 && s->s.gain > worth_starts * d->suspect[0].s.gain;
    stein_status status = STEIN_OK;
    double was = INFINITY;
    for (int k = 0; k < (several ? 4 : 2) && status == STEIN_OK && diag__leaves_more(d, s); k++) {
        if ((k == 1 && !(was - s->objective > worth_anew)) || d->anew >= ANEW) {
            continue;
        }
        d->anew++;
        was = s->objective;
        status = again(d, s, from_the_file, (beginning){NAN, first[k]}, err);
        status = status == STEIN_OK ? diag__to_the_end(d, s, err) : status;
        status = status == STEIN_OK ? diag__recall(d, s, err) : status;
    }
    s->begun = 1;
    return status;
}

stein_status diag__early_ones(diag *d, int relatives, stein_err *err)
{
    stein_status status = STEIN_OK;
    const diag__suspect *end = NULL; // leaves but noise
    for (int i = 0; status == STEIN_OK && i < d->n; i++) {
        diag__suspect *s = &d->suspect[i];
        int asked = end == NULL || (relatives && diag__related(&s->s.candidate, &end->s.candidate));
        if (!isfinite(s->early) || !asked) {
            continue;
        }
        double amount = s->model != NULL ? fmax(s->early, diag__least_amount(s)) : s->early;
        status = diag__from_the_file(d, s, amount, err);
        s->begun = 1;
        s->early = NAN;
        int ends = isfinite(s->objective) && !diag__is_off(d, s->s.chi2_dof) &&
                   !diag__has_bent(diag__problem(d, s), s->x);
        end = end == NULL && ends ? s : end;
    }
    diag__sort(d);
    return status;
}
