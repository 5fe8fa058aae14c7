/* SPDX-License-Identifier: GPL-3.0-or-later
 * contest.c - what could stand in the place of who leads.
 *
 *   1. at the end of the leader - there the model describes the data, so linear predictions are as
 *      good as they can be - all suspects are scored again, each in the leader's place, and those
 *      that come near are fitted from there
 *   2. if one of them leads now, once more
 *   3. those that all of this has passed over - a fit that found no step, an amount beyond what is
 *      thinkable, another number of the same law - along the strokes from the file's own numbers,
 *      where a law's number leads or the leader leaves more than noise
 *
 * Before and after that the leading ones are led to their ends.
 */
#include <math.h>
#include <string.h>

#include "searching.h"

enum {
    IN_PLACE = 6,
    PARTS = 3,
    ROUNDS = 2,
    POLISHED = 4,
    MORE = 8,
    RIVALS = 4,
    HEARD = 2,
    MOST_HEARD = 6,
    RENEW_LEADERS = 2
};
static const double certain = 0.5;   /* gain per sample that no stuck null fit leaves */
static const double come_near = 0.5; /* of the leader's gain */
static const double almost = 4.0;    /* chi2/dof of a leader that begins anew once more */
static const double nearly = 0.75;   /* in the leader's place: what loses less than that share */

int diag__leaves_noise(const diag *d)
{
    const diag__suspect *s = &d->suspect[0];
    int leads = s->s.refitted && isfinite(s->objective);
    return !diag__is_on(d, leads ? s->s.chi2_dof : fit__chi2_dof(&d->p, d->r));
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
        diag__borrow(p, leader->J, s->G, s->J);
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

/* those that promise as much as the leader has */
static stein_status rivals_to_the_end(diag *d, stein_err *err)
{
    const diag__suspect *leader = &d->suspect[0];
    double bound = leader->objective + diag__convincing * diag__excess(d, leader);
    stein_status status = STEIN_OK;
    for (int i = 1, n = 0; status == STEIN_OK && i < d->n && n < RIVALS; i++) {
        if (diag__is_open(&d->suspect[i]) && d->suspect[i].promised < bound) {
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
    int alike = !diag__leaves_noise(d) && s->alike > fmax(diag__worth_anew, leader->s.gain);
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
    for (int n = 0; status == STEIN_OK && n < (diag__leaves_noise(d) ? HEARD : MOST_HEARD); n++) {
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
        int behind = s->s.gain < (i < POLISHED ? 0.3 : diag__worth_starts) * d->suspect[0].s.gain;
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
            s->s.gain > fmax(diag__least_gain, diag__worth_starts * d->suspect[0].s.gain)) {
            status = diag__from_beside(d, s, err);
            n++;
        }
    }
    diag__sort(d);
    return status;
}

stein_status diag__doubt(diag *d, stein_err *err)
{
    const diag__suspect *leader = d->n > 0 ? &d->suspect[0] : NULL;
    int doubtful = leader != NULL && leader->s.refitted && isfinite(leader->objective) &&
                   leader->s.gain > diag__least_gain && leader->s.gain < certain * d->p.samples;
    return doubtful ? diag__pursue_again(d, leader, err) : STEIN_OK;
}

stein_status diag__contest(diag *d, stein_err *err)
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
        (d->suspect[0].s.candidate.effect->site == LAB_AT_PARAMETER || !diag__leaves_noise(d))) {
        status = hear(d, err);
    }
    status = status == STEIN_OK ? polish(d, err) : status;
    if (status == STEIN_OK && d->n > 0 && diag__leaves_noise(d)) {
        status = beside(d, err);
    }
    return status == STEIN_OK ? diag__doubt(d, err) : status;
}
