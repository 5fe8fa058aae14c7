/* SPDX-License-Identifier: GPL-3.0-or-later
 * restart.c - other first causes, where what begins with the best one leaves more than noise.
 *
 * Of two effects at once the first search sees a mixture. Its best suspect may be one that imitates
 * a little of both; beside it nothing explains the rest, so it keeps its place. The one that is
 * right alone may look worse, or its fit may have found no step: from the null fit, which has bent
 * all numbers, Coulomb friction of the key got 9 % of its amount, where viscous friction went all
 * the way. So one more search is made beside each of the others that gain as much as the best one
 * nearly, and beside the best one of the next best place, where those that were not followed along
 * the strokes are first (hear_place in contest.c). A pair that leaves but noise holds.
 *
 * Or nobody explains anything: two effects that hide each other. Where one of them alone explains
 * how the strokes begin (race.c), fits of whole strokes lead it nowhere, since what the other one
 * does later looks like its failure. So it is a first cause for trial, whatever it gains, and what
 * shows next is searched for beside it.
 *
 * A pair that was found along the strokes (along.c) goes the same way, before all that: its first
 * one in front, and who is second is known.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "searching.h"

enum { OTHERS = 3 };
static const double as_good = 0.9; /* of the best one's gain: another first cause at any place */
static const double worth_hearing = 0.3; /* at a place where none was tried */
static const double worth_a_search = 0.5;

static double left_by(const diag *first, const diag__found *f)
{
    return f->n > 0 ? f->chi2_dof : fit__chi2_dof(&first->p, first->r);
}

static int gains(const diag__suspect *s, double least)
{
    return s->s.refitted && s->s.possible && isfinite(s->objective) && s->s.gain > least;
}

/* the best suspect that was not tried, -1: none that is worth it. @param new  1: nor was its place
 */
static int next_first(const diag *d, const lab_candidate *tried, int n, int *new)
{
    for (int k = 1; k < d->n; k++) {
        const lab_candidate *c = &d->suspect[k].s.candidate;
        int again = 0;
        *new = 1;
        for (int i = 0; i < n; i++) {
            int here = strcmp(tried[i].place, c->place) == 0;
            *new &= !here;
            again |= here && tried[i].effect == c->effect;
        }
        if (!again &&
            gains(&d->suspect[k], (*new ? worth_hearing : as_good) * d->suspect[0].s.gain)) {
            return k;
        }
    }
    return -1;
}

/* the suspect of a place whose fit ended lowest; k is one of them */
static int best_there(const diag *d, int k)
{
    int best = k;
    for (int i = 0; i < d->n; i++) {
        const diag__suspect *s = &d->suspect[i];
        if (strcmp(s->s.candidate.place, d->suspect[k].s.candidate.place) == 0 &&
            gains(s, d->suspect[best].s.gain)) {
            best = i;
        }
    }
    return best;
}

/* suspect k moves to the front, or from there back to k */
static void to_front(diag *d, int k)
{
    diag__suspect s = d->suspect[k];
    memmove(&d->suspect[1], &d->suspect[0], sizeof s * (size_t)k);
    d->suspect[0] = s;
}

static void from_front(diag *d, int k)
{
    diag__suspect s = d->suspect[0];
    memmove(&d->suspect[0], &d->suspect[1], sizeof s * (size_t)k);
    d->suspect[k] = s;
}

/* those that end lower than the first cause alone, and with others do not, are no rivals of it */
static void rule_out(diag *d)
{
    for (int i = 1; i < d->n; i++) {
        lab_suspect *s = &d->suspect[i].s;
        if (s->refitted && d->suspect[i].objective < d->suspect[0].objective) {
            s->possible = 0;
            s->why = "nothing explains what is left beside it";
        }
    }
}

/* A suspect as the first cause; with a second one that explains the rest it stays in front, and
 * they are what was found.
 * @param found  1 then */
static stein_status begin_with(diag *first, const diag__pair *pair, const diag__held *before,
                               diag__found *f, int *found, stein_err *err)
{
    diag__found other;
    int k = pair->first;
    to_front(first, k);
    stein_status status = diag__causes(first, before, pair, &other, err);
    *found = status == STEIN_OK && other.n > 0 && !diag__is_more(first, other.chi2_dof);
    if (*found) {
        diag__found_free(f);
        *f = other;
        rule_out(first);
    } else {
        diag__found_free(&other);
        from_front(first, k);
    }
    return status;
}

int diag__beginner(const diag *d)
{
    for (int k = 0; k < d->n; k++) {
        if (d->suspect[k].begins != NULL && d->suspect[k].never == NULL) {
            return k;
        }
    }
    return -1;
}

/* One that explains how the strokes begin as the first of two. Fits of whole strokes may have led
 * it nowhere, or away: what the other one does later was missing. Alone it has the fit that it had.
 */
static stein_status begin_as_they_do(diag *first, const diag__pair *pair, const diag__held *before,
                                     diag__found *f, int *found, stein_err *err)
{
    diag__suspect *s = &first->suspect[pair->first];
    stein_status status = diag__make_room(first, s, err);
    size_t size = diag__room_of(diag__problem(first, s));
    double *room = status == STEIN_OK ? malloc(sizeof *room * size) : NULL;
    *found = 0;
    if (room == NULL) {
        return lab__no_memory(err);
    }
    const diag__suspect was = *s;
    memcpy(room, s->x, sizeof *room * size);
    status = diag__from_the_begin(first, s, err);
    if (status == STEIN_OK && isfinite(s->objective)) {
        status = begin_with(first, pair, before, f, found, err);
    }
    if (!*found) {
        memcpy(s->x, room, sizeof *room * size);
        *s = was;
    }
    free(room);
    return status;
}

stein_status diag__two_along(diag *first, const diag__held *before, diag__found *f, stein_err *err)
{
    diag__pair pair;
    *f = (diag__found){.end = first, .excess = 1.0, .held = {.rmse = NAN}};
    if (first->only != NULL || !fit__noise_given(&first->p)) {
        return STEIN_OK;
    }
    stein_status status = diag__along(first, &pair, err);
    if (status == STEIN_OK && pair.first >= 0) {
        diag__suspect *s = &first->suspect[pair.first];
        double *begins = s->begins;
        int found;
        s->begins = s->led;
        status = begin_as_they_do(first, &pair, before, f, &found, err);
        s = found ? &first->suspect[0] : s; // it stays in front
        s->begins = begins;
    }
    free(pair.x);
    return status;
}

stein_status diag__several(diag *first, const diag__held *before, diag__found *f, stein_err *err)
{
    lab_candidate tried[1 + OTHERS];
    stein_status status = diag__causes(first, before, NULL, f, err);
    if (first->only != NULL || !fit__noise_given(&first->p) || first->n == 0 ||
        diag__law_is_all(first) || diag__law_is_ahead(first, f)) {
        return status;
    }
    diag__pair pair = {.first = diag__beginner(first)};
    if (status == STEIN_OK && diag__is_more(first, left_by(first, f)) &&
        (pair.first > 0 || (pair.first == 0 && f->n == 0))) {
        int found;
        status = begin_as_they_do(first, &pair, before, f, &found, err);
    }
    tried[0] = first->suspect[0].s.candidate;
    for (int n = 1; status == STEIN_OK && n <= OTHERS && diag__is_more(first, left_by(first, f));
         n++) {
        int new, found, k = next_first(first, tried, n, &new);
        if (k < 0) {
            break;
        }
        if (new) {
            status = diag__hear_place(first, k, err);
            k = best_there(first, k);
        }
        tried[n] = first->suspect[k].s.candidate;
        if (status == STEIN_OK &&
            gains(&first->suspect[k], worth_a_search * first->suspect[0].s.gain)) {
            pair.first = k;
            status = begin_with(first, &pair, before, f, &found, err);
        }
    }
    return status;
}
