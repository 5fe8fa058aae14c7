/* SPDX-License-Identifier: GPL-3.0-or-later
 * early.c - suspects by how the strokes begin.
 *
 * A bounce more or less, and everything after it is different: where the null fit lacks what
 * decides that, its parameters are bent until the bounces look right, and linear scores at its end
 * rank what is missing among the last. But until the first of these events the model is near the
 * data, and what is missing shows there already, if only a little. So the strokes are fitted up to
 * the first horizon at which more than noise is left, and the suspects are ranked there. Those that
 * lead are fitted along the strokes from the file's own numbers (refine.c).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "searching.h"

enum { EARLY = 4, RENEWALS = 4, FOREMOST = 3 }; /* EARLY: of the horizons */
static const double enough = 0.3;               /* of the objective */
static const double off = 3.0;                  /* sd of chi2/dof: more than noise is left */
static const double worth = 16.0;               /* score */

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

static stein_status rank(diag *d, stein_err *err)
{
    stein_status status = fit__sensitivities(&d->p, d->x, d->r, d->J, err);
    status = status == STEIN_OK ? diag__changes(d, err) : status;
    status = status == STEIN_OK ? diag__rank(d, err) : status;
    for (int i = 0, n = 0; status == STEIN_OK && i < d->n && n < FOREMOST; i++) {
        diag__suspect *s = &d->suspect[i];
        if (s->never == NULL && s->G != NULL && s->s.possible && s->s.score > worth) {
            s->early = s->s.amount / s->s.candidate.limit;
            n++;
        }
    }
    return status;
}

stein_status diag__look_early(diag *d, stein_err *err)
{
    const fit__problem *p = &d->p;
    size_t nu = (size_t)p->nu, rows = fit__offset(p, p->nstroke);
    double *room = malloc(sizeof *room * (nu + rows + fit__columns(p) + 1));
    if (room == NULL) {
        return lab__fail(err, STEIN_ENOMEM, "out of memory");
    }
    double *x = d->x, *r = d->r, *J = d->J; // the null fit waits
    d->x = room;
    d->r = room + nu;
    d->J = d->r + rows;
    stein_err why = {STEIN_OK, ""};
    stein_status status = STEIN_OK;
    if (find(d, &status, &why)) {
        status = rank(d, &why);
    }
    d->x = x;
    d->r = r;
    d->J = J;
    d->p.horizon = INFINITY;
    free(room);
    return status == STEIN_ENOMEM ? lab__fail(err, status, "out of memory") : STEIN_OK;
}
