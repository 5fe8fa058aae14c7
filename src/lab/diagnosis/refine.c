/* SPDX-License-Identifier: GPL-3.0-or-later
 * refine.c - full fits of the best suspects.
 *
 *   1. every suspect that the linear scores do not rule out is fitted with all other unknowns,
 *      first with the derivatives of the null fit, the leading ones with new ones until they end;
 *      where the leader does not end near the data, those that explain how the strokes begin are
 *      followed along them (race.c), and the leading ones begin anew from the file's own numbers
 *      (A hasty search asks whether its leader leaves but noise, and puts off what follows. A first
 *      one puts off what follows the race: laws, and two causes in the order in which the strokes
 *      show them, are asked before.)
 *   2. what could stand in the leader's place (contest.c)
 *
 * Scores at the null fit alone name the wrong one more often: what is missing has bent all
 * parameters by then.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "searching.h"

enum { FIRST = 16, LEADERS = 3, TURNS = 3, LEADS = 4 };
enum { RENEW_FIRST = 0, RENEW_LEADERS = 2 };
static const double enough = 0.3; /* of the objective */
static const double worth = 0.08; /* linear gains below that share of the best are left out */
static const double almost = 4.0; /* chi2/dof of a null fit that takes an effect over */

/* an amount at which it can be simulated: parts have no 0, and what was scanned does nothing there
 */
double diag__least_amount(const diag__suspect *s)
{
    return s->model != NULL || s->scanned ? s->step : 0.0;
}

/* numbers in the block of x, r, J and sd of a refit */
size_t diag__room_of(const fit__problem *p)
{
    return (size_t)p->nu + fit__offset(p, p->nstroke) + fit__columns(p) + (size_t)p->np + 1;
}

stein_status diag__make_room(diag *d, diag__suspect *s, stein_err *err)
{
    const fit__problem *p = diag__problem(d, s);
    size_t nu = (size_t)p->nu, rows = fit__offset(p, p->nstroke);
    if (s->x == NULL) {
        s->x = malloc(sizeof *s->x * diag__room_of(p));
        s->r = s->x != NULL ? s->x + nu : NULL;
        s->J = s->x != NULL ? s->r + rows : NULL;
        s->sd = s->x != NULL ? s->J + fit__columns(p) : NULL;
    }
    return s->x != NULL ? STEIN_OK : lab__no_memory(err);
}

/* derivatives at hand: those of the base, and the suspect's own column */
void diag__borrow(const fit__problem *p, const double *J, const double *G, double *to)
{
    memcpy(to, J, sizeof *to * fit__columns(p));
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        size_t n = (size_t)t->nch * (size_t)t->n;
        memcpy(to + fit__column(p, s, p->amount), G + fit__offset(p, s), sizeof *to * n);
        for (int k = 0; k < LAB_SIDES; k++) {
            memset(to + fit__column(p, s, p->side + k), 0, sizeof *to * n);
        }
    }
}

/* the fit of a suspect, from s->x with s->J */
stein_status diag__fit_on(diag *d, diag__suspect *s, int renewals, stein_err *err)
{
    fit__problem *p = diag__problem(d, s);
    fit__end e = {.x = s->x, .J = s->J, .r = s->r};
    p->horizon = INFINITY;
    fit__problem_try(p, &s->s.candidate);
    stein_status status = fit__descend(p, &e, !s->unknown_J, enough, renewals, err);
    s->unknown_J = 0;
    if (status == STEIN_OK) {
        status =
            diag__likelihood(p, s->x, s->J, s->r, s->D, s->sd, &s->objective, &s->promised, err);
    }
    if (status == STEIN_OK) {
        s->ended = e.ended && renewals > 0; // derivatives of elsewhere do not tell the end
        s->s.refitted = 1;
        s->left = e.objective;
        s->s.gain = d->null_objective - s->objective;
        s->s.amount = s->x[p->amount] * s->s.candidate.limit;
        s->s.chi2_dof = fit__chi2_dof(p, s->r);
        d->out->fits++;
    }
    fit__problem_try(p, NULL);
    return status;
}

/* numerical failures are the suspect's misfortune */
stein_status diag__attempt(diag *d, diag__suspect *s, int renewals, stein_err *err)
{
    stein_err why = {STEIN_OK, ""};
    stein_status status = diag__fit_on(d, s, renewals, &why);
    if (status == STEIN_ENOMEM) {
        return lab__no_memory(err);
    }
    if (status != STEIN_OK) {
        s->s.why = "it could not be fitted";
        s->objective = INFINITY;
    }
    return STEIN_OK;
}

/* ---- from the null fit ---- */

int diag__is_open(const diag__suspect *s)
{
    return s->s.refitted && isfinite(s->objective) && !s->ended;
}

/* New derivatives for those that promise most; what has ended promises what it has. One that takes
 * several turns to its end does not take those of the others. */
static stein_status lead_on(diag *d, stein_err *err)
{
    stein_status status = STEIN_OK;
    const diag__suspect *had[LEADERS] = {NULL};
    for (int n = 0; status == STEIN_OK && n < LEADERS; n++) {
        diag__suspect *next = NULL;
        for (int i = 0; i < d->n; i++) {
            diag__suspect *s = &d->suspect[i];
            int fitted = s->s.refitted && isfinite(s->objective);
            for (int k = 0; k < n; k++) {
                fitted = fitted && had[k] != s;
            }
            next = fitted && (next == NULL || s->promised < next->promised) ? s : next;
        }
        if (next == NULL) {
            break;
        }
        had[n] = next;
        for (int k = 0; status == STEIN_OK && k < TURNS && diag__is_open(next); k++) {
            status = diag__attempt(d, next, RENEW_LEADERS, err);
        }
    }
    diag__sort(d);
    return status;
}

static stein_status from_null(diag *d, stein_err *err)
{
    int tried = 0;
    double best = d->n > 0 ? d->suspect[0].s.score : 0.0;
    for (int i = 0; i < d->n && tried < FIRST; i++) {
        diag__suspect *s = &d->suspect[i];
        const fit__problem *p = diag__problem(d, s);
        if (s->never != NULL || s->G == NULL || !(s->s.score > worth * best) || !s->s.possible) {
            continue;
        }
        stein_status status = diag__make_room(d, s, err);
        if (status != STEIN_OK) {
            return status;
        }
        memcpy(s->x, d->x, sizeof *s->x * (size_t)p->nu);
        s->x[p->amount] = diag__least_amount(s);
        diag__borrow(p, d->J, s->G, s->J);
        status = diag__attempt(d, s, RENEW_FIRST, err);
        if (status != STEIN_OK) {
            return status;
        }
        tried++;
    }
    diag__sort(d);
    return lead_on(d, err);
}

/* The leader alone to its end, without its strays: where that leaves but noise, nobody needs a fit
 * along the strokes, which costs ten of these. */
static stein_status lead_to_the_end(diag *d, stein_err *err)
{
    diag__suspect *leader = &d->suspect[0];
    if (!leader->s.refitted || !isfinite(leader->objective) || leader->s.gain < diag__worth_anew) {
        return STEIN_OK;
    }
    stein_status status = STEIN_OK;
    double was = INFINITY;
    for (int k = 0; k < LEADS && status == STEIN_OK && was - leader->objective > diag__worth_anew;
         k++) {
        was = leader->objective;
        status = diag__to_the_end(d, leader, err);
    }
    status = status == STEIN_OK ? diag__recall(d, leader, err) : status;
    diag__sort(d);
    return status;
}

/* The last resort, where more than noise is left and the null fit does not believe the file's
 * numbers, with which it takes over what is missing, almost: who leads where they are believed?
 * What is found so has to be better than all that was. */
static stein_status believe(diag *d, stein_err *err)
{
    double objective = d->suspect[0].objective;
    stein_status status = diag__look_believing(d, err);
    status = status == STEIN_OK ? diag__early_ones(d, 1, err) : status;
    status = status == STEIN_OK ? diag__changes(d, err) : status; // of the null fit again
    status = status == STEIN_OK ? diag__rank(d, err) : status;
    for (int i = 0; i < d->n; i++) {
        diag__suspect *s = &d->suspect[i];
        if (s->s.refitted && isfinite(s->objective)) {
            s->s.amount = s->x[diag__problem(d, s)->amount] * s->s.candidate.limit;
        }
    }
    diag__sort(d);
    return status == STEIN_OK && d->suspect[0].objective < objective ? diag__contest(d, err)
                                                                     : status;
}

/* how much the null fit's residual looks like each of them */
static void note_alike(diag *d)
{
    for (int i = 0; i < d->n; i++) {
        const lab_suspect *s = &d->suspect[i].s;
        int has_sign = s->candidate.effect->both_signs || s->amount > 0.0;
        d->suspect[i].alike = has_sign && isfinite(s->score) ? s->score : 0.0;
    }
}

stein_status diag__refit_from(diag *d, diag__suspect *s, stein_err *err)
{
    note_alike(d);
    s->unknown_J = 1;
    stein_status status = diag__attempt(d, s, RENEW_LEADERS, err);
    diag__sort(d);
    return status == STEIN_OK ? diag__contest(d, err) : status;
}

/* where an earlier search has ended */
static stein_status from_known(diag *d, diag__suspect *s, const void *ctx, int *found,
                               stein_err *err)
{
    (void)ctx, (void)err;
    memcpy(s->x, d->known_x, sizeof *s->x * (size_t)diag__problem(d, s)->nu);
    s->unknown_J = 1;
    *found = 1;
    return STEIN_OK;
}

/* who led in an earlier search, from where that has ended: nobody leads who leaves more */
static stein_status lead_as_known(diag *d, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int i = 0; d->known != NULL && i < d->n; i++) {
        diag__suspect *s = &d->suspect[i];
        if (diag__is_same(&s->s.candidate, d->known) && s->never == NULL) {
            status = diag__make_room(d, s, err);
            s->objective = s->s.refitted ? s->objective : (double)INFINITY;
            status = status == STEIN_OK ? diag__again(d, s, from_known, NULL, err) : status;
            diag__sort(d); // s is another one now
            break;
        }
    }
    return status;
}

/* Does the leader of a further search leave but noise of how the strokes begin? So does who wins a
 * race up to there. */
static int begins_well(diag *d)
{
    const diag__suspect *s = &d->suspect[0];
    if (d->naccepted == 0 || !(d->early.z > 0.0) || !s->s.refitted || !isfinite(s->objective)) {
        return 0;
    }
    double left = diag__chi2_to(diag__problem(d, s), s->r, d->early.horizon);
    return !diag__is_clear(left, d->early.samples);
}

/* once, where the leader leaves more than noise */
static stein_status race(diag *d, stein_err *err)
{
    int open = !d->raced && d->n > 0 && !diag__leaves_noise(d), needed = open && !begins_well(d);
    for (int i = 0; open && !needed && i < d->n; i++) {
        d->suspect[i].early = NAN; // nobody runs
    }
    d->raced = 1;
    return needed ? diag__race(d, err) : STEIN_OK;
}

/* who leads where the strokes begin, along them; once */
static stein_status early_ones(diag *d, stein_err *err)
{
    return d->n > 0 && !diag__leaves_noise(d) ? diag__early_ones(d, 0, err) : STEIN_OK;
}

/* Does the leader leave more than the noise that is stated? */
static int leaves_more(const diag *d)
{
    return d->n > 0 && d->suspect[0].s.refitted && diag__is_more(d, d->suspect[0].s.chi2_dof);
}

stein_status diag__refit(diag *d, stein_err *err)
{
    note_alike(d);
    stein_status status = from_null(d, err);
    status = status == STEIN_OK ? lead_as_known(d, err) : status;
    status = status == STEIN_OK ? diag__doubt(d, err) : status;
    if (status == STEIN_OK && d->n > 0 && !diag__leaves_noise(d)) {
        status = lead_to_the_end(d, err);
    }
    d->put_off = status == STEIN_OK && d->hasty && leaves_more(d);
    if (status == STEIN_OK && !d->put_off) {
        status = race(d, err);
        int two = d->naccepted == 0 && fit__noise_given(&d->p); // may be what it is
        if (status == STEIN_OK && !(two && diag__is_beyond_one(d))) {
            status = early_ones(d, err);
        }
        d->put_off = status == STEIN_OK && two && leaves_more(d);
    }
    return status == STEIN_OK && !d->put_off ? diag__refit_on(d, err) : status;
}

stein_status diag__refit_on(diag *d, stein_err *err)
{
    stein_status status = race(d, err);
    d->put_off = 0;
    status = status == STEIN_OK ? early_ones(d, err) : status;
    status = status == STEIN_OK ? diag__contest(d, err) : status;
    if (status == STEIN_OK && d->naccepted == 0 && d->n > 0 && !diag__leaves_noise(d) &&
        fit__chi2_dof(&d->p, d->r) < almost && diag__is_strained(d)) {
        status = believe(d, err);
    }
    return status;
}

stein_status diag__refit_known(diag *d, int *found, stein_err *err)
{
    *found = 0;
    if (d->known == NULL || !d->hasty) {
        return STEIN_OK;
    }
    stein_status status = diag__changes(d, err);
    status = status == STEIN_OK ? diag__rank(d, err) : status;
    if (status == STEIN_OK) {
        note_alike(d);
        status = lead_as_known(d, err);
    }
    *found = status == STEIN_OK && d->n > 0 && d->suspect[0].s.refitted && diag__leaves_noise(d);
    return *found ? diag__contest(d, err) : status;
}
