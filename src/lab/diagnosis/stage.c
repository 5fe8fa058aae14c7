/* SPDX-License-Identifier: GPL-3.0-or-later
 * stage.c - a further search: the mechanism with the causes of another search in it, at the end of
 * that, as unknowns like all others.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "searching.h"
#include "structure.h"

enum { RENEWALS = 6 };
static const double enough = 0.3; /* of the objective */

/* effects that act in it; @param without  one that does not, NULL: all do */
static int take_causes(diag *next, const diag *from, const diag__suspect *leader,
                       const lab_candidate *without)
{
    int n = 0;
    for (int i = 0; i <= from->naccepted; i++) {
        const lab_candidate *c = i < from->naccepted ? &from->accepted[i]
                                 : leader != NULL    ? &leader->s.candidate
                                                     : NULL;
        if (c != NULL && (without == NULL || !diag__is_same(c, without)) && n < FIT__ACCEPTED) {
            next->accepted[n++] = *c;
        }
    }
    return next->naccepted = n;
}

static int parts_of(const lab_candidate *list, int n)
{
    int parts = 0;
    for (int i = 0; i < n; i++) {
        parts += list[i].effect->needs != NULL;
    }
    return parts;
}

static void take_strokes(diag *next, const lab_model *model, const lab_dataset *fit_data,
                         const lab_dataset *held_data)
{
    next->model = model;
    next->fit_data = fit_data;
    next->held_data = held_data;
}

/* a mechanism that no search has had: a part less than the last one's */
static stein_status open_model(diag *next, const diag *first, stein_err *err)
{
    stein_status status = lab__open_with(&next->own_model, first->file, next->accepted,
                                         next->naccepted, first->def->options, err);
    status = status == STEIN_OK
                 ? diag__read_again(first->fit_data, next->own_model, &next->own_fit, err)
                 : status;
    status = status == STEIN_OK
                 ? diag__read_again(first->held_data, next->own_model, &next->own_held, err)
                 : status;
    take_strokes(next, next->own_model, next->own_fit, next->own_held);
    return status;
}

/* the mechanism with the parts that the causes need, and the strokes in it */
static stein_status take_model(diag *next, const diag *first, const diag *from,
                               const diag__suspect *leader, const lab_candidate *without,
                               stein_err *err)
{
    int parts = parts_of(next->accepted, next->naccepted),
        had = parts_of(from->accepted, from->naccepted),
        more = leader != NULL && leader->model != NULL &&
               (without == NULL || !diag__is_same(&leader->s.candidate, without));
    if (parts == 0) {
        take_strokes(next, first->model, first->fit_data, first->held_data);
    } else if (parts < had + more) {
        return open_model(next, first, err);
    } else if (more) {
        take_strokes(next, leader->model, leader->fit_data, leader->held_data);
    } else {
        take_strokes(next, from->model, from->fit_data, from->held_data);
    }
    return STEIN_OK;
}

int diag__amount_of(const diag *from, const diag__suspect *leader, const lab_candidate *c)
{
    for (int i = 0; i < from->naccepted; i++) {
        if (diag__is_same(&from->accepted[i], c)) {
            return from->p.first_accepted + FIT__NUMBERS * i;
        }
    }
    return leader != NULL && diag__is_same(&leader->s.candidate, c) ? from->p.amount : -1;
}

void diag__carry_over(const diag *next, const diag *from, const diag__suspect *leader,
                      const lab_candidate *c, double *to)
{
    const double *x = leader != NULL ? leader->x : from->x;
    const fit__problem *q = &next->p, *p = &from->p;
    memset(to, 0, sizeof *to * (size_t)q->nu);
    memcpy(to, x, sizeof *x * (size_t)q->first_accepted);
    for (int i = 0; i <= next->naccepted; i++) {
        const lab_candidate *one = i < next->naccepted ? &next->accepted[i] : c;
        int at = one != NULL ? diag__amount_of(from, leader, one) : -1,
            k = i < next->naccepted ? q->first_accepted + FIT__NUMBERS * i : q->amount;
        for (int j = 0; at >= 0 && j < FIT__NUMBERS; j++) {
            to[k + j] = x[at + j];
        }
    }
    memcpy(to + q->np, x + p->np, sizeof *x * (size_t)(p->nu - p->np));
}

static stein_status keep(diag__found *f, diag *stage, stein_err *err)
{
    diag **more = realloc(f->stage, sizeof *more * (size_t)(f->nstage + 1));
    if (more == NULL) {
        free(stage);
        return lab__no_memory(err);
    }
    f->stage = more;
    f->stage[f->nstage++] = stage;
    return STEIN_OK;
}

stein_status diag__stage_at(diag__found *f, const diag *first, const diag *from,
                            const diag__suspect *leader, const lab_candidate *without, diag **out,
                            stein_err *err)
{
    diag *next = calloc(1, sizeof *next);
    stein_status status = next != NULL ? keep(f, next, err) : lab__no_memory(err);
    if (status != STEIN_OK) {
        return status;
    }
    next->file = first->file;
    next->def = first->def;
    next->fit_def = first->fit_def;
    next->out = first->out;
    next->only = first->only;
    next->hasty = f->hasty;
    take_causes(next, from, leader, without);
    status = take_model(next, first, from, leader, without, err);
    for (int i = 0; status == STEIN_OK && i < next->naccepted; i++) {
        status = lab_candidate_bind(&next->accepted[i], next->model, err);
    }
    status = status == STEIN_OK ? diag__open_problem(next, err) : status;
    if (status != STEIN_OK) {
        return status;
    }
    next->held_data = next->held_data != NULL ? next->held_data : first->held_data; // none
    next->p.tolerance = first->p.tolerance;
    diag__carry_over(next, from, leader, NULL, next->x);
    *out = next;
    return STEIN_OK;
}

stein_status diag__stage_open(diag__found *f, const diag *first, const diag *from,
                              const diag__suspect *leader, const lab_candidate *without, diag **out,
                              stein_err *err)
{
    diag *next;
    stein_status status = diag__stage_at(f, first, from, leader, without, &next, err);
    if (status != STEIN_OK) {
        return status;
    }
    fit__end e = {.x = next->x, .J = next->J, .r = next->r};
    status = fit__descend(&next->p, &e, 0, enough, RENEWALS, err);
    status =
        status == STEIN_OK ? fit__sensitivities(&next->p, next->x, next->r, next->J, err) : status;
    if (status == STEIN_OK) {
        status = diag__likelihood(&next->p, next->x, next->J, next->r, next->null_D, next->sd,
                                  &next->null_objective, NULL, err);
        next->ended = e.ended;
        first->out->fits++;
    }
    *out = next;
    return status;
}
