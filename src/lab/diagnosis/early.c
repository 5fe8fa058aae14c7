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
enum { RENEWALS = 4, FOREMOST = 3, RELATIVES = 3, HALVINGS = 2, FOREMOST_OF_ALL = 4 };
static const double enough = 0.3;  /* of the objective */
static const double off = 3.0;     /* sd of chi2: more than noise */
static const double sudden = 30.0; /* sd of chi2, at once: strokes have gone elsewhere */
static const double worth = 16.0;  /* score */
static const double within = 1.0;  /* tolerances */
static const double near = 0.2;    /* of the best score: worth it at the same place */

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

/* at the early horizon, where its fit has ended */
static int stand_there(diag *d, const double *null_x, stein_status *status, stein_err *err)
{
    fit__problem *p = &d->p;
    int failed = 0;
    (void)null_x;
    fit__problem_try(p, NULL);
    p->horizon = d->early.horizon;
    memcpy(d->x, d->early.x, sizeof *d->x * (size_t)p->nu);
    *status = fit__residuals(p, d->x, d->r, &failed, err);
    return *status == STEIN_OK && failed == 0;
}

/* the fit up to a horizon. @param z  sd that chi2 is from noise, out  @return is it clearly more?
 */
static int goes_off(diag *d, double horizon, fit__end *e, double *z, stein_status *status,
                    stein_err *err)
{
    fit__problem *p = &d->p;
    *z = 0.0;
    p->horizon = horizon;
    *status = fit__descend(p, e, 0, enough, RENEWALS, err);
    if (*status != STEIN_OK) {
        return 0;
    }
    d->out->fits++;
    double dof = fmax(1.0, diag__samples(p) - p->nu), chi2 = fit__chi2(p, d->r);
    *z = (chi2 - dof) / sqrt(2.0 * dof);
    return diag__is_clear(chi2, dof);
}

/* Between a horizon with but noise and the next one the strokes have gone far: nearer to where they
 * begin to, what is missing is nearly linear yet.
 * @param x  unknowns up to the former, lost */
static void halve(diag *d, double last, double *x, stein_status *status, stein_err *err)
{
    size_t size = sizeof *x * (size_t)d->p.nu;
    fit__end e = {.x = d->x, .J = d->J, .r = d->r};
    for (int k = 0; k < HALVINGS && *status == STEIN_OK && d->early.z > sudden; k++) {
        double middle = 0.5 * (last + d->early.horizon), z;
        memcpy(d->x, x, size);
        if (goes_off(d, middle, &e, &z, status, err)) {
            d->early.z = 0.0;
            is_furthest(d, e.objective, z);
        } else {
            last = middle;
            memcpy(x, d->x, size);
        }
    }
}

/* From d->x along the strokes, beginning with a horizon, to the first one at which clearly more
 * than noise is left.
 * @param most     horizons
 * @param near_it  1: to somewhere before it, if the strokes have gone far there
 * @return is there one? */
static int go_off(diag *d, double from, int most, int near_it, stein_status *status, stein_err *err)
{
    size_t size = sizeof *d->x * (size_t)d->p.nu;
    double T = diag__longest(&d->p), last = 0.0, *x = malloc(size);
    fit__end e = {.x = d->x, .J = d->J, .r = d->r};
    int is_off = 0;
    *status = x != NULL ? STEIN_OK : lab__no_memory(err);
    fit__problem_try(&d->p, NULL);
    for (int h = 0; *status == STEIN_OK && h < most && !is_off; h++) {
        double horizon = diag__horizon[h] * T, z;
        if (horizon < from * (1.0 - 1e-9)) {
            continue;
        }
        memcpy(x, d->x, size);
        int clear = goes_off(d, horizon, &e, &z, status, err);
        is_off = *status == STEIN_OK && is_furthest(d, e.objective, z) && clear;
        if (is_off && near_it && last > 0.0) {
            halve(d, last, x, status, err);
        }
        last = horizon;
    }
    free(x);
    return *status == STEIN_OK && is_off;
}

/* From the file's own numbers to there, or else to the horizon that leaves most. @return is there
 * one? */
static int find(diag *d, const double *null_x, stein_status *status, stein_err *err)
{
    believe_file(d, null_x);
    (void)go_off(d, 0.0, EARLY, 1, status, err);
    return *status == STEIN_OK && d->early.z > 0.0 && stand_there(d, null_x, status, err);
}

/* The amount that was predicted, as far as it is thinkable: what changes an event is not linear,
 * and a race tells more than a prediction. */
static double begin_at(const diag__suspect *s)
{
    double amount = fmin(fmax(s->s.amount / s->s.candidate.limit, -1.0), 1.0);
    return amount > 0.0 || s->s.candidate.effect->both_signs ? amount : s->step;
}

/* the first ones count, and more of those at the place of the first one */
static void choose(diag *d, int foremost, int relatives)
{
    const diag__suspect *best = NULL;
    for (int i = 0, n = 0, related = 0; i < d->n; i++) {
        diag__suspect *s = &d->suspect[i];
        s->early = NAN;
        s->early_left = 0.0;
        int can = s->never == NULL && s->G != NULL && s->s.score > worth;
        int first = n < foremost;
        int here = best != NULL && related < relatives && s->s.score > near * best->s.score &&
                   diag__related(&s->s.candidate, &best->s.candidate);
        if (can && (first || here)) {
            best = best == NULL ? s : best;
            s->early = begin_at(s);
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

/* derivatives of a race's first steps: those of all, and those of who was chosen */
static stein_status keep_derivatives(diag *d, stein_err *err)
{
    size_t rows = fit__offset(&d->p, d->p.nstroke), columns = fit__columns(&d->p);
    free(d->early.J);
    d->early.J = malloc(sizeof *d->J * (columns + 1));
    if (d->early.J == NULL) {
        return lab__no_memory(err);
    }
    memcpy(d->early.J, d->J, sizeof *d->J * columns);
    for (int i = 0; i < d->n; i++) {
        diag__suspect *s = &d->suspect[i];
        free(s->early_G);
        s->early_G = NULL;
        if (isfinite(s->early)) {
            s->early_G = malloc(sizeof *s->G * (rows + 1));
            if (s->early_G == NULL) {
                return lab__no_memory(err);
            }
            memcpy(s->early_G, s->G, sizeof *s->G * rows);
        }
    }
    return STEIN_OK;
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
            status = relatives == 0 ? keep_derivatives(d, &why) : STEIN_OK; // there is a race
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

stein_status diag__go_on(diag *d, double horizon, stein_err *err)
{
    stein_status status = STEIN_OK;
    d->early.x = calloc((size_t)d->p.nu + 1, sizeof *d->early.x);
    if (d->early.x == NULL) {
        return lab__no_memory(err);
    }
    d->early.z = go_off(d, horizon, DIAG_HORIZONS, 0, &status, err) ? d->early.z : 0.0;
    d->p.horizon = INFINITY;
    return status;
}

stein_status diag__look_there(diag *d, stein_err *err)
{
    int whole = !(d->early.horizon < diag__longest(&d->p)); // a race would cost as much as fits
    return look_at(d, stand_there, whole ? FOREMOST_OF_ALL : DIAG_RACE, 0, err);
}

stein_status diag__look_believing(diag *d, stein_err *err)
{
    return look_at(d, believe, FOREMOST, RELATIVES, err);
}
