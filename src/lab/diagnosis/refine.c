/* SPDX-License-Identifier: GPL-3.0-or-later
 * refine.c - full fits of the best suspects, and of what could stand in their place.
 *
 *   1. every suspect that the linear scores do not rule out is fitted with all other unknowns,
 *      first with the derivatives of the null fit, the leading ones with new ones until they end;
 *      where the leader does not end near the data, those that explain how the strokes begin are
 *      followed along them (race.c), and the leading ones begin anew from the file's own numbers
 *   2. at the end of the leader - there the model describes the data, so linear predictions are as
 *      good as they can be - all suspects are scored again, each in the leader's place, and those
 *      that come near are fitted from there
 *   3. if one of them leads now, once more
 *   4. those that all of this has passed over - a fit that found no step, an amount beyond what is
 *      thinkable, another number of the same law - along the strokes from the file's own numbers,
 *      where a law's number leads or the leader leaves more than noise
 *
 * Scores at the null fit alone name the wrong one more often: what is missing has bent all
 * parameters by then.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "searching.h"

enum {
    FIRST = 16,
    LEADERS = 3,
    TURNS = 3,
    LEADS = 4,
    IN_PLACE = 6,
    PARTS = 3,
    ROUNDS = 2,
    RENEW_FIRST = 0,
    RENEW_LEADERS = 2,
    POLISHED = 4,
    MORE = 8,
    RIVALS = 4,
    HEARD = 2,
    MOST_HEARD = 6,
    RENEW_LAST = 4
};
static const double enough = 0.3;       /* of the objective */
static const double worth_anew = 40.0;  /* gain */
static const double worth_starts = 0.7; /* of the best gain: worth more than one start */
static const double worth = 0.08;       /* linear gains below that share of the best are left out */
static const double certain = 0.5;      /* gain per sample that no stuck null fit leaves */
static const double come_near = 0.5;    /* of the leader's gain */
static const double almost = 4.0;       /* chi2/dof of a null fit that takes an effect over */
static const double nearly = 0.75;      /* in the leader's place: what loses less than that share */

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
static void borrow(const fit__problem *p, const double *J, const double *G, double *to)
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

/* is it still open how far the fit of a suspect leads? */
static int is_open(const diag__suspect *s)
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
        for (int k = 0; status == STEIN_OK && k < TURNS && is_open(next); k++) {
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
        borrow(p, d->J, s->G, s->J);
        status = diag__attempt(d, s, RENEW_FIRST, err);
        if (status != STEIN_OK) {
            return status;
        }
        tried++;
    }
    diag__sort(d);
    return lead_on(d, err);
}

/* ---- in the leader's place ---- */

/* G of the promising suspects and of the leader's neighbours at its end, scored in its place */
static stein_status swap(diag *d, diag__suspect *leader, stein_err *err)
{
    fit__problem *p = &d->p;
    double amount = leader->x[p->amount];
    for (int i = 0; i < d->n; i++) {
        d->suspect[i].promising |= diag__related(&d->suspect[i].s.candidate, &leader->s.candidate);
    }
    lab_candidate given = leader->s.candidate;
    fit__problem_try(p, &given); // its derivatives may be those of the null fit yet
    stein_status status = fit__sensitivities(p, leader->x, leader->r, leader->J, err);
    for (int k = 0; k < LAB_SIDES && given.side[k].param >= 0; k++) {
        given.side[k].value = fit__value(&p->unknown[p->side + k], leader->x[p->side + k]);
    }
    fit__problem_try(p, NULL);
    if (status != STEIN_OK) {
        return status;
    }
    p->given = &given;
    p->given_amount = amount * given.limit;
    double *x = d->x, *r = d->r, *J = d->J; // changes are taken around the leader
    d->x = leader->x;
    d->r = leader->r;
    d->J = leader->J;
    status = diag__changes(d, err);
    d->x = x;
    d->r = r;
    d->J = J;
    status = status == STEIN_OK ? diag__in_place(d, leader, err) : status;
    p->given = NULL;
    return status;
}

/* the suspect with the least swap, NULL: none is finite */
static diag__suspect *next_part(diag *d)
{
    diag__suspect *next = NULL;
    for (int i = 0; i < d->n; i++) {
        diag__suspect *s = &d->suspect[i];
        if (isfinite(s->swap) && (next == NULL || s->swap < next->swap)) {
            next = s;
        }
    }
    return next;
}

/* where it was scored in the leader's place: a part without derivatives, a number with those of the
 * leader */
static stein_status from_place(diag *d, diag__suspect *s, const void *ctx, int *found,
                               stein_err *err)
{
    const diag__suspect *leader = ctx;
    const fit__problem *p = diag__problem(d, s);
    (void)err;
    memcpy(s->x, s->start, sizeof *s->x * (size_t)p->nu);
    s->unknown_J = s->model != NULL;
    if (!s->unknown_J) {
        borrow(p, leader->J, s->G, s->J);
    }
    *found = 1;
    return STEIN_OK;
}

/* the parts that do what the leader does, each from the amount that does it best */
static stein_status parts_in_place(diag *d, stein_err *err)
{
    stein_status status = diag__scan_parts(d, &d->suspect[0], err);
    diag__suspect *s = NULL;
    for (int n = 0; status == STEIN_OK && n < PARTS && (s = next_part(d)) != NULL; n++) {
        int was_fitted = s->s.refitted && isfinite(s->objective) && s->ended;
        s->swap = INFINITY;
        status = was_fitted ? STEIN_OK : diag__make_room(d, s, err);
        if (status == STEIN_OK && !was_fitted) {
            status = diag__again(d, s, from_place, NULL, err);
        }
    }
    return status;
}

/* those whose effect is a number of the file, or one it could have: as predicted at that end */
static stein_status numbers_in_place(diag *d, stein_err *err)
{
    double L = d->suspect[0].objective, lost = nearly * fmax(d->null_objective - L, 30.0);
    stein_status status = swap(d, &d->suspect[0], err);
    for (int n = 0; status == STEIN_OK && n < IN_PLACE;) {
        diag__suspect *next = NULL;
        for (int i = 1; i < d->n; i++) {
            diag__suspect *s = &d->suspect[i];
            if (s->swap < L + lost && s->swap < s->objective - 3.0 && s->start != NULL &&
                (next == NULL || s->swap < next->swap)) {
                next = s;
            }
        }
        if (next == NULL) {
            break;
        }
        status = diag__make_room(d, next, err);
        status =
            status == STEIN_OK ? diag__again(d, next, from_place, &d->suspect[0], err) : status;
        next->swap = INFINITY;
        n++;
    }
    return status;
}

static stein_status in_place(diag *d, int *changed, stein_err *err)
{
    if (!d->suspect[0].s.refitted || !isfinite(d->suspect[0].objective)) {
        *changed = 0; // nobody leads
        return STEIN_OK;
    }
    // candidates are bound to the mechanism of the file, and cannot stand beside a part
    stein_status status = d->suspect[0].model == NULL ? numbers_in_place(d, err) : STEIN_OK;
    if (status == STEIN_OK && d->suspect[0].s.gain > diag__least_gain) {
        status = parts_in_place(d, err);
    }
    const lab_effect *kind = d->suspect[0].s.candidate.effect;
    char place[LAB_PLACE];
    memcpy(place, d->suspect[0].s.candidate.place, sizeof place);
    diag__sort(d);
    *changed = d->suspect[0].s.candidate.effect != kind ||
               strcmp(d->suspect[0].s.candidate.place, place) != 0;
    return status;
}

/* is but noise left to the leader, or to the null fit? */
static int leaves_noise(const diag *d)
{
    const diag__suspect *s = &d->suspect[0];
    int leads = s->s.refitted && isfinite(s->objective);
    return !diag__is_on(d, leads ? s->s.chi2_dof : fit__chi2_dof(&d->p, d->r));
}

/* The leader alone to its end, without its strays: where that leaves but noise, nobody needs a fit
 * along the strokes, which costs ten of these. */
static stein_status lead_to_the_end(diag *d, stein_err *err)
{
    diag__suspect *leader = &d->suspect[0];
    if (!leader->s.refitted || !isfinite(leader->objective) || leader->s.gain < worth_anew) {
        return STEIN_OK;
    }
    stein_status status = STEIN_OK;
    double was = INFINITY;
    for (int k = 0; k < LEADS && status == STEIN_OK && was - leader->objective > worth_anew; k++) {
        was = leader->objective;
        status = diag__to_the_end(d, leader, err);
    }
    status = status == STEIN_OK ? diag__recall(d, leader, err) : status;
    diag__sort(d);
    return status;
}

/* those that promise as much as the leader has */
static stein_status rivals_to_the_end(diag *d, stein_err *err)
{
    const diag__suspect *leader = &d->suspect[0];
    double bound = leader->objective + diag__convincing * diag__excess(d, leader);
    stein_status status = STEIN_OK;
    for (int i = 1, n = 0; status == STEIN_OK && i < d->n && n < RIVALS; i++) {
        if (is_open(&d->suspect[i]) && d->suspect[i].promised < bound) {
            status = diag__to_the_end(d, &d->suspect[i], err);
            n++;
        }
    }
    return status;
}

/* Was it never followed to where it leads, though it is named after the law of the leader's place,
 * or the null fit's residual looks more like it than the leader has gained? */
static int is_unheard(const diag *d, const diag__suspect *s)
{
    const diag__suspect *leader = &d->suspect[0];
    const lab_effect *e = s->s.candidate.effect;
    int named = (e->site == LAB_AT_CONTACT || e->site == LAB_AT_SURFACE) &&
                diag__related(&s->s.candidate, &leader->s.candidate);
    int alike = !leaves_noise(d) && s->alike > fmax(worth_anew, leader->s.gain);
    int fitted = s->s.refitted && isfinite(s->objective) && s->s.gain > come_near * leader->s.gain;
    return (named || alike) && !fitted && s->model == NULL && s->never == NULL && s->G != NULL &&
           !s->begun;
}

/* of two: nearer in the leader's place, or more like what the null fit leaves */
static int is_nearer(const diag__suspect *a, const diag__suspect *b)
{
    return a->near < b->near || (a->near == b->near && a->alike > b->alike);
}

/* Is a number of a law in the lead, or leaves the leader more than noise, those that nobody has
 * heard have a fit along the strokes, the nearest first, and more of them until one leaves but
 * noise: what changes a law changes events, and predictions end there, those of the null fit and
 * those in the leader's place. */
static stein_status hear(diag *d, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int n = 0; status == STEIN_OK && n < (leaves_noise(d) ? HEARD : MOST_HEARD); n++) {
        diag__suspect *next = NULL;
        for (int i = 1; i < d->n; i++) {
            diag__suspect *s = &d->suspect[i];
            next = is_unheard(d, s) && (next == NULL || is_nearer(s, next)) ? s : next;
        }
        if (next == NULL) {
            break;
        }
        status = diag__from_the_file(d, next, diag__least_amount(next), err);
        diag__sort(d);
    }
    return status;
}

stein_status diag__hear_place(diag *d, int k, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int i = 0, n = 0; status == STEIN_OK && i < d->n && n < HEARD; i++) {
        diag__suspect *s = &d->suspect[i];
        int open = s->model == NULL && s->never == NULL && s->G != NULL && !s->begun;
        if (i != k && open && s->alike > 0.0 &&
            strcmp(s->s.candidate.place, d->suspect[k].s.candidate.place) == 0) {
            status = diag__from_the_file(d, s, diag__least_amount(s), err);
            n++;
        }
    }
    return status;
}

/* The leading ones to their end, also where that is far while none leaves only noise, and then more
 * of them. From the file's own numbers each begins anew once, and the leader again where it is
 * almost there: with the amounts it has now that may be the rest of the way. */
static stein_status polish(diag *d, stein_err *err)
{
    stein_status status = STEIN_OK;
    int explained = 0;
    for (int i = 0; status == STEIN_OK && i < d->n && i < (explained ? POLISHED : MORE); i++) {
        diag__suspect *s = &d->suspect[i];
        int behind = s->s.gain < (i < POLISHED ? 0.3 : worth_starts) * d->suspect[0].s.gain;
        if (!s->s.refitted || !isfinite(s->objective) || behind) {
            continue;
        }
        status = diag__to_the_end(d, s, err);
        if (status == STEIN_OK && !explained && diag__leaves_more(d, s) && d->only == NULL) {
            int again = !s->begun || (i == 0 && s->s.chi2_dof < almost);
            status = diag__recall(d, s, err);
            status = status == STEIN_OK && again ? diag__begin_anew(d, s, err) : status;
        }
        explained |= !diag__leaves_more(d, s);
    }
    diag__sort(d);
    if (status == STEIN_OK && d->n > 0 && d->suspect[0].s.refitted) {
        status = diag__to_the_end(d, &d->suspect[0], err);
        status = status == STEIN_OK ? rivals_to_the_end(d, err) : status;
        diag__sort(d);
    }
    return status;
}

/* Those that come near the leader, the leader too, as far as a number beside their amount may have
 * kept them where they began. Where more than noise is left there are other ways
 * (diag__begin_anew).
 */
static stein_status beside(diag *d, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int i = 0, n = 0; status == STEIN_OK && i < d->n && n < RIVALS; i++) {
        diag__suspect *s = &d->suspect[i];
        int fitted = s->s.refitted && isfinite(s->objective);
        if (fitted && s->s.candidate.side[0].param >= 0 &&
            s->s.gain > fmax(diag__least_gain, worth_starts * d->suspect[0].s.gain)) {
            status = diag__from_beside(d, s, err);
            n++;
        }
    }
    diag__sort(d);
    return status;
}

/* a gain that may be that of a null fit which is stuck is asked again from the leader's end */
static stein_status doubt(diag *d, stein_err *err)
{
    const diag__suspect *leader = d->n > 0 ? &d->suspect[0] : NULL;
    int doubtful = leader != NULL && leader->s.refitted && isfinite(leader->objective) &&
                   leader->s.gain > diag__least_gain && leader->s.gain < certain * d->p.samples;
    return doubtful ? diag__pursue_again(d, leader, err) : STEIN_OK;
}

/* what could stand in the leader's place, until nobody else leads */
static stein_status contest(diag *d, stein_err *err)
{
    stein_status status = polish(d, err);
    for (int round = 0, changed = 1; status == STEIN_OK && changed && round < ROUNDS; round++) {
        status = in_place(d, &changed, err);
        if (status == STEIN_OK && changed && !d->suspect[0].ended) {
            status = diag__attempt(d, &d->suspect[0], RENEW_LEADERS, err);
        }
    }
    if (status == STEIN_OK && d->n > 0 && d->only == NULL && d->suspect[0].s.refitted &&
        isfinite(d->suspect[0].objective) &&
        (d->suspect[0].s.candidate.effect->site == LAB_AT_PARAMETER || !leaves_noise(d))) {
        status = hear(d, err);
    }
    status = status == STEIN_OK ? polish(d, err) : status;
    if (status == STEIN_OK && d->n > 0 && leaves_noise(d)) {
        status = beside(d, err);
    }
    return status == STEIN_OK ? doubt(d, err) : status;
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
    return status == STEIN_OK && d->suspect[0].objective < objective ? contest(d, err) : status;
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
    return status == STEIN_OK ? contest(d, err) : status;
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
            diag__sort(d);
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
    int open = !d->raced && d->n > 0 && !leaves_noise(d), needed = open && !begins_well(d);
    for (int i = 0; open && !needed && i < d->n; i++) {
        d->suspect[i].early = NAN; // nobody runs
    }
    d->raced = 1;
    return needed ? diag__race(d, err) : STEIN_OK;
}

stein_status diag__refit(diag *d, stein_err *err)
{
    note_alike(d);
    stein_status status = from_null(d, err);
    status = status == STEIN_OK ? lead_as_known(d, err) : status;
    status = status == STEIN_OK ? doubt(d, err) : status;
    if (status == STEIN_OK && d->n > 0 && !leaves_noise(d)) {
        status = lead_to_the_end(d, err);
    }
    d->put_off = status == STEIN_OK && d->hasty && d->n > 0 && d->suspect[0].s.refitted &&
                 diag__is_more(d, d->suspect[0].s.chi2_dof);
    if (status == STEIN_OK && !d->put_off) {
        status = race(d, err);
        d->put_off = status == STEIN_OK && d->naccepted == 0 && fit__noise_given(&d->p) &&
                     diag__is_beyond_one(d);
    }
    return status == STEIN_OK && !d->put_off ? diag__refit_on(d, err) : status;
}

stein_status diag__refit_on(diag *d, stein_err *err)
{
    stein_status status = race(d, err);
    d->put_off = 0;
    if (status == STEIN_OK && d->n > 0 && !leaves_noise(d)) {
        status = diag__early_ones(d, 0, err);
    }
    status = status == STEIN_OK ? contest(d, err) : status;
    if (status == STEIN_OK && d->naccepted == 0 && d->n > 0 && !leaves_noise(d) &&
        fit__chi2_dof(&d->p, d->r) < almost && diag__is_strained(d)) {
        status = believe(d, err);
    }
    return status;
}
