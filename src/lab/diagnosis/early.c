/* SPDX-License-Identifier: GPL-3.0-or-later
 * early.c - suspects by how the strokes begin, and by what believed numbers leave.
 *
 * A bounce more or less, and everything after it is different: where the null fit lacks what
 * decides that, its parameters are bent until the bounces look right, and linear scores at its end
 * rank what is missing among the last. But until the first of these events the model is near the
 * data, and what is missing shows there already, if only a little. So the strokes are fitted up to
 * the first horizon at which more than noise is left, and the suspects are ranked there. Those that
 * lead are fitted along the strokes from the file's own numbers (refine.c).
 *
 * Some effects are there from the first event to the last and still hide: a null fit that may move
 * numbers out of their tolerances takes them over, almost. Where it ends with such numbers, the
 * strokes are fitted once more with numbers that stay within them, and what that leaves is asked.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "searching.h"

enum { EARLY = 4, RENEWALS = 4, FOREMOST = 3, RELATIVES = 3 }; /* EARLY: of the horizons */
static const double enough = 0.3;                              /* of the objective */
static const double off = 3.0;    /* sd of chi2/dof: more than noise is left */
static const double worth = 16.0; /* score */
static const double within = 1.0; /* tolerances */
static const double near = 0.2;   /* of the best score: worth it at the same place */

/* samples up to the horizon */
static double samples(const fit__problem *p)
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

/* from the file's own numbers to the first horizon at which more than noise is left. @return is
 * there one? */
static int find(diag *d, stein_status *status, stein_err *err)
{
    fit__problem *p = &d->p;
    fit__end e = {.x = d->x, .J = d->J, .r = d->r};
    double T = diag__longest(p);
    memset(d->x, 0, sizeof *d->x * (size_t)p->nu);
    fit__problem_try(p, NULL);
    for (int h = 0; h < EARLY; h++) {
        p->horizon = diag__horizon[h] * T;
        *status = fit__descend(p, &e, 0, enough, RENEWALS, err);
        d->out->fits++;
        double dof = fmax(1.0, samples(p) - p->nu);
        if (*status != STEIN_OK || fit__chi2(p, d->r) > dof + off * sqrt(2.0 * dof)) {
            return *status == STEIN_OK;
        }
    }
    return 0;
}

/* the first ones count, and more of those at the place of the first one */
static void choose(diag *d, int relatives)
{
    const diag__suspect *best = NULL;
    for (int i = 0, n = 0, related = 0; i < d->n; i++) {
        diag__suspect *s = &d->suspect[i];
        int can = s->never == NULL && s->G != NULL && s->s.possible && s->s.score > worth;
        int first = n < FOREMOST;
        int here = best != NULL && related < relatives && s->s.score > near * best->s.score &&
                   diag__related(&s->s.candidate, &best->s.candidate);
        if (can && (first || here)) {
            best = best == NULL ? s : best;
            s->early = s->s.amount / s->s.candidate.limit;
            related += !first;
            n++;
        }
    }
}

static stein_status rank(diag *d, int relatives, stein_err *err)
{
    stein_status status = fit__sensitivities(&d->p, d->x, d->r, d->J, err);
    status = status == STEIN_OK ? diag__changes(d, err) : status;
    status = status == STEIN_OK ? diag__rank(d, err) : status;
    if (status == STEIN_OK) {
        choose(d, relatives);
    }
    return status;
}

/* a null fit whose numbers stay within their tolerances */
static int believe(diag *d, stein_status *status, stein_err *err)
{
    fit__problem *p = &d->p;
    fit__end e = {.x = d->x, .J = d->J, .r = d->r};
    double limit = p->limit;
    memset(d->x, 0, sizeof *d->x * (size_t)p->nu);
    fit__problem_try(p, NULL);
    p->limit = within;
    *status = diag__follow(d, p, &e, err);
    d->out->fits += e.fits;
    p->limit = limit;
    return *status == STEIN_OK;
}

/* where to look: a fit of the strokes to d->x. @return is anything to be seen there? */
typedef int look(diag *d, stein_status *status, stein_err *err);

static stein_status look_at(diag *d, look *make_fit, int relatives, stein_err *err)
{
    const fit__problem *p = &d->p;
    size_t nu = (size_t)p->nu, rows = fit__offset(p, p->nstroke);
    double *room = malloc(sizeof *room * (nu + rows + fit__columns(p) + 1));
    if (room == NULL) {
        return lab__no_memory(err);
    }
    const diag null = *d; // it waits
    d->x = room;
    d->r = room + nu;
    d->J = d->r + rows;
    stein_err why = {STEIN_OK, ""};
    stein_status status = STEIN_OK;
    if (make_fit(d, &status, &why)) {
        status = rank(d, relatives, &why);
    }
    d->x = null.x;
    d->r = null.r;
    d->J = null.J;
    d->null_objective = null.null_objective;
    d->p.horizon = INFINITY;
    free(room);
    return fit__forgive(status, err);
}

stein_status diag__look_early(diag *d, stein_err *err)
{
    return look_at(d, find, 0, err);
}

stein_status diag__look_believing(diag *d, stein_err *err)
{
    return look_at(d, believe, RELATIVES, err);
}
