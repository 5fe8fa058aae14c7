/* SPDX-License-Identifier: GPL-3.0-or-later
 * early.c - suspects by how the strokes begin, and by what believed numbers leave.
 *
 * A bounce more or less, and everything after it is different: where the null fit lacks what
 * decides that, its parameters are bent until the bounces look right, and linear scores at its end
 * rank what is missing among the last. But until the first of these events the model is near the
 * data, and what is missing shows there already, if only a little. So the strokes are fitted up to
 * the first horizon at which clearly more than noise is left, and the suspects are ranked there.
 * Those that lead run a race (race.c).
 *
 * Some effects are there from the first event to the last and still hide: a null fit that may move
 * numbers out of their tolerances takes them over, almost. Where it ends with such numbers, the
 * strokes are fitted once more with numbers that stay within them, and what that leaves is asked.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "searching.h"

enum { EARLY = 6 }; /* horizons */
enum { RENEWALS = 4, FOREMOST = 3, RELATIVES = 3 };
static const double enough = 0.3; /* of the objective */
static const double off = 3.0;    /* sd of chi2: more than noise */
static const double worth = 16.0; /* score */
static const double within = 1.0; /* tolerances */
static const double near = 0.2;   /* of the best score: worth it at the same place */

/* the horizon counts where the null fit is furthest from noise so far */
static int is_furthest(diag *d, double objective, double z)
{
    if (z < off || z < d->early.z) {
        return 0;
    }
    d->early.z = z;
    d->early.horizon = d->p.horizon;
    d->early.objective = objective;
    d->early.samples = diag__samples(&d->p);
    memcpy(d->early.x, d->x, sizeof *d->x * (size_t)d->p.nu);
    return 1;
}

/* the file's own numbers, and the amounts of the causes that act already */
static void believe_file(diag *d, const double *null_x)
{
    const fit__problem *p = &d->p;
    size_t first = (size_t)p->first_accepted, n = (size_t)p->naccepted * FIT__NUMBERS;
    memset(d->x, 0, sizeof *d->x * (size_t)p->nu);
    memcpy(d->x + first, null_x + first, sizeof *d->x * n);
}

/* From the file's own numbers to the first horizon at which clearly more than noise is left, or to
 * the one that leaves most. @return is there one? */
static int find(diag *d, const double *null_x, stein_status *status, stein_err *err)
{
    fit__problem *p = &d->p;
    fit__end e = {.x = d->x, .J = d->J, .r = d->r};
    double T = diag__longest(p);
    int failed = 0;
    believe_file(d, null_x);
    fit__problem_try(p, NULL);
    for (int h = 0; h < EARLY; h++) {
        p->horizon = diag__horizon[h] * T;
        *status = fit__descend(p, &e, 0, enough, RENEWALS, err);
        if (*status != STEIN_OK) {
            return 0;
        }
        d->out->fits++;
        double dof = fmax(1.0, diag__samples(p) - p->nu), chi2 = fit__chi2(p, d->r);
        int counts = is_furthest(d, e.objective, (chi2 - dof) / sqrt(2.0 * dof));
        if (counts && diag__is_clear(chi2, dof)) {
            return 1;
        }
    }
    if (!(d->early.z > 0.0)) {
        return 0;
    }
    p->horizon = d->early.horizon;
    memcpy(d->x, d->early.x, sizeof *d->x * (size_t)p->nu);
    *status = fit__residuals(p, d->x, d->r, &failed, err);
    return *status == STEIN_OK && failed == 0;
}

/* the first ones count, and more of those at the place of the first one */
static void choose(diag *d, int foremost, int relatives)
{
    const diag__suspect *best = NULL;
    for (int i = 0, n = 0, related = 0; i < d->n; i++) {
        diag__suspect *s = &d->suspect[i];
        s->early = NAN;
        s->early_left = 0.0;
        int can = s->never == NULL && s->G != NULL && s->s.possible && s->s.score > worth;
        int first = n < foremost;
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

static stein_status rank(diag *d, stein_err *err)
{
    stein_status status = fit__sensitivities(&d->p, d->x, d->r, d->J, err);
    status = status == STEIN_OK ? diag__changes(d, err) : status;
    return status == STEIN_OK ? diag__rank(d, err) : status;
}

/* a null fit whose numbers stay within their tolerances */
static int believe(diag *d, const double *null_x, stein_status *status, stein_err *err)
{
    fit__problem *p = &d->p;
    fit__end e = {.x = d->x, .J = d->J, .r = d->r};
    double limit = p->limit;
    believe_file(d, null_x);
    fit__problem_try(p, NULL);
    p->limit = within;
    *status = diag__follow(d, p, &e, NULL, err);
    d->out->fits += e.fits;
    p->limit = limit;
    return *status == STEIN_OK;
}

/* where to look: a fit of the strokes to d->x, beside the null fit's. @return is anything to be
 * seen there? */
typedef int look(diag *d, const double *null_x, stein_status *status, stein_err *err);

static stein_status look_at(diag *d, look *make_fit, int foremost, int relatives, stein_err *err)
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
    if (make_fit(d, null.x, &status, &why)) {
        status = rank(d, &why);
        if (status == STEIN_OK) {
            choose(d, foremost, relatives);
        }
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
    d->early.x = calloc((size_t)d->p.nu + 1, sizeof *d->early.x);
    return d->early.x != NULL ? look_at(d, find, DIAG_RACE, 0, err) : lab__no_memory(err);
}

stein_status diag__look_believing(diag *d, stein_err *err)
{
    return look_at(d, believe, FOREMOST, RELATIVES, err);
}
