/* SPDX-License-Identifier: GPL-3.0-or-later
 * along.c - two causes, in the order in which the strokes show them.
 *
 * Fits of whole strokes lead one of two causes nowhere: what the other one does looks like its
 * failure. But they do not begin to act together, or not as much. Up to the horizon of a first race
 * (race.c) one of them explains what is to be explained, and others may do so as well: a surface
 * that lies higher and a pawl that sits lower come to the same for a while. So each of the leading
 * ones is asked how far it goes, and who goes farthest is asked for a second one first:
 *
 *      up to its race --> on along the strokes, until more than noise is left --> a race beside it
 *                         for a second one, up to there --> both along the strokes, to the end
 *
 * Where that leaves little, a pair is found. One of them may be another one yet of the same place:
 * both are searched for again beside each other (several.c).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "searching.h"

enum { BEGINNERS = DIAG_RACE, ASKED = 3 };
static const double most = 0.95; /* of the misfit: explained by a pair worth another search */

/* one that leads in the first race, and its search for a second one */
typedef struct beginner {
    int k;         /* suspect of the first search */
    diag__found f; /* owns the search */
    diag *next;    /* NULL: it failed */
} beginner;

/* where the race has ended, and on */
static stein_status begin(diag *first, beginner *b, stein_err *err)
{
    diag__suspect leader = first->suspect[b->k];
    diag *next = NULL;
    leader.x = leader.led;
    b->f = (diag__found){.held = {.rmse = NAN}, .hasty = 1};
    stein_err why = {STEIN_OK, ""};
    stein_status status = diag__stage_at(&b->f, first, first, &leader, NULL, &next, &why);
    status = status == STEIN_OK ? diag__go_on(next, first->early.horizon, &why) : status;
    b->next = status == STEIN_OK ? next : NULL;
    return fit__forgive(status, err);
}

/* who goes farthest first, and of those who is nearest to the data there */
static int by_reach(const void *a, const void *b)
{
    const diag *x = ((const beginner *)a)->next, *y = ((const beginner *)b)->next;
    if (x == NULL || y == NULL) {
        return (x == NULL) - (y == NULL);
    }
    if (x->early.horizon < y->early.horizon || y->early.horizon < x->early.horizon) {
        return x->early.horizon < y->early.horizon ? 1 : -1;
    }
    return (x->early.z > y->early.z) - (x->early.z < y->early.z);
}

/* who explains the rest, up to where the first one leaves some, and then to the end */
static stein_status second_of(diag *next, stein_err *err)
{
    stein_status status = diag__suspects(next, err);
    status = status == STEIN_OK ? diag__look_there(next, err) : status;
    status = status == STEIN_OK ? diag__race(next, err) : status;
    next->null_objective = INFINITY; // nobody has asked what the first one leaves at the end
    return status == STEIN_OK ? diag__early_ones(next, 0, err) : status;
}

/* the best second one beside a first one. @param least  chi2/dof that a pair has to come below */
static stein_status ask(const beginner *b, diag__pair *pair, double least, stein_err *err)
{
    stein_err why = {STEIN_OK, ""};
    stein_status status = second_of(b->next, &why);
    const diag__suspect *s = b->next->n > 0 ? &b->next->suspect[0] : NULL;
    if (status == STEIN_OK && s != NULL && s->s.refitted && isfinite(s->objective) &&
        s->s.possible && s->s.chi2_dof < least) {
        size_t size = sizeof *s->x * (size_t)diag__problem(b->next, s)->nu;
        *pair = (diag__pair){.first = b->k, .second = s->s.candidate, .x = malloc(size)};
        if (pair->x == NULL) {
            return lab__no_memory(err);
        }
        memcpy(pair->x, s->x, size);
    }
    return fit__forgive(status, err);
}

stein_status diag__along(diag *first, diag__pair *pair, stein_err *err)
{
    beginner all[BEGINNERS];
    stein_status status = STEIN_OK;
    double before = fit__chi2_dof(&first->p, first->r), least = before - most * (before - 1.0);
    int n = 0;
    *pair = (diag__pair){.first = -1};
    int alone = 0; // one of them leaves nothing to a second one
    for (int k = 0; status == STEIN_OK && k < first->n && n < BEGINNERS && !alone; k++) {
        if (first->suspect[k].led != NULL) {
            all[n] = (beginner){.k = k};
            status = begin(first, &all[n], err);
            alone = all[n].next != NULL && !(all[n].next->early.z > 0.0);
            n++;
        }
    }
    qsort(all, (size_t)n, sizeof *all, by_reach);
    for (int i = 0; status == STEIN_OK && !alone && i < n && i < ASKED && all[i].next != NULL &&
                    pair->first < 0;
         i++) {
        status = ask(&all[i], pair, least, err);
    }
    for (int i = 0; i < n; i++) {
        diag__found_free(&all[i].f);
    }
    return status;
}
