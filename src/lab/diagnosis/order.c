/* SPDX-License-Identifier: GPL-3.0-or-later
 * order.c - suspects in the order of what their fits have reached.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "searching.h"

static const double the_same = 2.0; /* of the objective: the same fit */

static int by_objective(const void *a, const void *b)
{
    const diag__suspect *x = a, *y = b;
    if (x->objective < y->objective || y->objective < x->objective) {
        return x->objective < y->objective ? -1 : 1;
    }
    double sx = isfinite(x->s.score) ? x->s.score : -1e300;
    double sy = isfinite(y->s.score) ? y->s.score : -1e300;
    return sx > sy ? -1 : sx < sy;
}

/* A fit that has found no step with derivatives of elsewhere has told nothing yet. */
static void judge_size(diag *d, diag__suspect *s)
{
    const fit__problem *p = diag__problem(d, s);
    double amount = s->x[p->amount];
    if (!s->ended && !(s->s.gain > 0.0)) {
        return;
    }
    s->s.possible = s->s.candidate.effect->both_signs || amount > 0.0;
    if (fabs(amount) > 2.0 || !s->s.possible) {
        s->s.possible = 0;
        s->s.why = "its amount is not physical";
        s->objective = INFINITY;
    }
}

int diag__is_same(const lab_candidate *a, const lab_candidate *b)
{
    return a->effect == b->effect && strcmp(a->place, b->place) == 0;
}

int diag__one_element(const char *a, const char *b)
{
    size_t n = strcspn(a, ".");
    return n == strcspn(b, ".") && strncmp(a, b, n) == 0;
}

int diag__related(const lab_candidate *a, const lab_candidate *b)
{
    return diag__one_element(a->place, b->place);
}

/* Where one number of a law is all of it that shows, it and the effect that is named after the law
 * are the same (the stiffness of a contact and its linear term), and noise decides which is first.
 * The name says more than the number. */
static void prefer_a_name(diag *d)
{
    const lab_candidate *best = &d->suspect[0].s.candidate;
    for (int i = 1; i < d->n && best->effect->site == LAB_AT_PARAMETER &&
                    d->suspect[i].objective < d->suspect[0].objective + the_same;
         i++) {
        diag__suspect named = d->suspect[i];
        if (named.s.candidate.effect->site != LAB_AT_PARAMETER &&
            diag__related(&named.s.candidate, best)) {
            memmove(&d->suspect[1], &d->suspect[0], sizeof named * (size_t)i);
            d->suspect[0] = named;
            return;
        }
    }
}

void diag__sort(diag *d)
{
    for (int i = 0; i < d->n; i++) {
        if (d->suspect[i].s.refitted && isfinite(d->suspect[i].objective)) {
            judge_size(d, &d->suspect[i]);
        }
    }
    qsort(d->suspect, (size_t)d->n, sizeof *d->suspect, by_objective);
    prefer_a_name(d);
}
