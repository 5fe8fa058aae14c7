/* SPDX-License-Identifier: GPL-3.0-or-later
 * search_again.c - the search under other assumptions: starts or settings that are off by what
 * their digits allow, noise that is estimated, numbers of bodies that are free. Rows made so far
 * either compete with the new ones or no longer count. An assumption that gains nothing is undone.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "proposals.h"

enum { CARRIED = 10 /* rows that are fitted again */ };
/* Half swings of the first horizon. A length that is 4 % off is out of step by 0.4 rad then,
 * which a linear model still follows. */
static const double first_swings = 3.0;
static const double growth = 3.0;   /* from one horizon to the next */
static const double shortest = 1.5; /* records over the first horizon */
static const double tiny = 1e-6;    /* variance of noise, in the stated one */

const diag__proposer diag__step_settings = {
    .letter = 'S', .name = "settings that are off by what their digits allow"};
const diag__proposer diag__step_noise = {.letter = 'N', .name = "again, with estimated noise"};
const diag__proposer diag__step_longer = {.letter = 'H', .name = "again, over a longer horizon"};
const diag__proposer diag__step_bodies = {.letter = 'B',
                                          .name = "again, with the numbers of bodies free"};

/* the hypothesis without what cannot be told any more */
static diag__hypothesis testable(const diag__problem *q, diag__hypothesis h)
{
    for (int i = h.n - 1; i >= 0; i--) {
        int told = q->untestable[diag__base(q, h.cause[i]) - q->candidate] == NULL;
        h = told ? h : diag__without(h, h.cause[i]);
    }
    return h;
}

/* The best row with no cause, with one, two, three. If `rivals`, also rows whose objective is
 * nearly that of the best one. @param rows  [CARRIED] out  @return how many */
static int standing(const diag__problem *q, const diag__table *t, int rivals, int *rows)
{
    const diag__row *best = diag__incumbent(q, t);
    int n = 0;
    for (int k = 0; k <= DIAG_CAUSES; k++) {
        rows[n] = diag__index(t, diag__best(q, t, k));
        n += rows[n] >= 0;
    }
    for (int i = 0; rivals && i < t->n && n < CARRIED; i++) {
        const diag__row *row = t->row[i];
        int takes = !row->superseded && row == diag__find(t, &row->h) &&
                    diag__is_possible(q, row) &&
                    row->objective < best->objective + diag__least_gain;
        for (int k = 0; k < n; k++) {
            takes &= rows[k] != i;
        }
        rows[n] = takes ? i : rows[n];
        n += takes;
    }
    return n;
}

stein_status diag__fit_again(diag__problem *q, diag__table *t, const diag__proposer *by,
                             stein_err *err)
{
    stein_status status = STEIN_OK;
    int rows[CARRIED], longer = by == &diag__step_longer, n = standing(q, t, longer, rows);
    for (int k = 0; k < t->n; k++) { // rows so far have other objectives
        t->row[k]->superseded = 1;
        if (longer) { // and no derivatives behind their horizon
            free(t->row[k]->J);
            t->row[k]->J = NULL;
        }
    }
    for (int k = 0; status == STEIN_OK && k < n; k++) {
        diag__row *one = NULL;
        int anew = by == &diag__step_bodies; // numbers of the file are free that were none
        diag__proposal again =
            diag__as_parent(testable(q, t->row[rows[k]]->h), anew && k == 0 ? -1 : rows[k], by);
        again.held = anew;
        if (diag__find(t, &again.h) == NULL) {
            status = diag__try(q, t, &again, &one, err);
        }
    }
    return status;
}

/* A row's hypothesis once more. Instead of wrong settings it has settings that are off by what
 * their digits allow: a variance of all records, which costs as much as it explains. Causes that
 * leave nearly noise beside settings as they are stated do not need it. */
static stein_status loosen(diag__problem *q, diag__table *t, const diag__row *row, stein_err *err)
{
    diag__row *one = NULL;
    diag__proposal rough = diag__as_parent(row->h, diag__index(t, row), &diag__step_settings);
    rough.rough = 1;
    for (int i = row->h.n - 1; i >= 0; i--) {
        if (diag__base(q, row->h.cause[i])->effect->site == LAB_AT_SETTING) {
            rough.h = diag__without(rough.h, row->h.cause[i]);
        }
    }
    int had = rough.h.n == row->h.n && row->h.n > 0 && row->chi2_dof < diag__near_noise;
    for (int i = 0; i < t->n; i++) {
        had |= t->row[i]->rough && !t->row[i]->superseded && diag__equals(&t->row[i]->h, &rough.h);
    }
    return had || diag__is_spent(q) ? STEIN_OK : diag__try(q, t, &rough, &one, err);
}

/* are there settings that are initial states, or others? */
static int has_setting(const diag__problem *q, int initial)
{
    int yes = 0;
    for (int i = q->n; i < q->n + q->nsetting; i++) {
        yes |= (strstr(q->candidate[i].place, ".initial.") != NULL) == initial;
    }
    return yes;
}

static int has_part(const diag__problem *q, const diag__hypothesis *h)
{
    int yes = 0;
    for (int i = 0; i < h->n; i++) {
        yes |= diag__base(q, h->cause[i])->effect->needs != NULL;
    }
    return yes;
}

/* A start that is set by hand is less exact than an encoder's reading. If uncertain initial states
 * explain most of a gross misfit, but not all of it, they are uncertain in all rows; else the
 * search would look for causes of what the starts do. If they explain all of it, one cause may do
 * so as well, and evidence decides in the end (diag__with_settings). */
stein_status diag__doubt_starts(diag__problem *q, diag__table *t, diag__row *exact, stein_err *err)
{
    diag__proposal null = {.h = {.n = 0}, .parent = -1, .by = &diag__step_settings};
    diag__row *loose = NULL;
    if (!has_setting(q, 1) || exact->chi2_dof < diag__seven_noises || diag__is_spent(q)) {
        return STEIN_OK;
    }
    q->fit_def.settings = LAB_SETTINGS_STARTS;
    stein_status status = diag__problem_null(q, err);
    status = status == STEIN_OK ? diag__try(q, t, &null, &loose, err) : status;
    int taken = status == STEIN_OK && loose != NULL && loose->failed == NULL &&
                loose->chi2_dof - 1.0 < diag__part_of * (exact->chi2_dof - 1.0) &&
                !diag__leaves_noise(q, loose);
    if (taken) {
        exact->superseded = 1;
        return STEIN_OK;
    }
    if (loose != NULL) {
        loose->superseded = 1;
    }
    q->fit_def.settings = 0;
    stein_status again = status != STEIN_ENOMEM ? diag__problem_null(q, err) : status;
    return status == STEIN_OK ? again : status;
}

/* Settings that are off by what their digits allow, where there is something to explain: without a
 * cause and with those of the best hypothesis. If that leaves noise, or nearly so with a part, a
 * cause of it may stand for them: then also with fewer. */
stein_status diag__with_settings(diag__problem *q, diag__table *t, stein_err *err)
{
    const diag__row *best = diag__incumbent(q, t), *null = diag__best(q, t, 0);
    int unsure = best->h.n > 0 || best->chi2_dof > diag__most_noise(q, &q->null);
    int exact = q->fit_def.settings == LAB_SETTINGS_STARTS ? has_setting(q, 0) : q->nsetting > 0;
    if (!exact || !unsure) {
        return STEIN_OK;
    }
    // settings that are off in every record by another amount are not explained by few causes, but
    // by a part that begins each record at another place
    int told = best->h.n > 0 && DIAG_FEW_RECORDS * best->h.n <= best->p.nstroke &&
               diag__leaves_noise(q, best) && !has_part(q, &best->h) && null != NULL &&
               null->chi2_dof > diag__near_noise;
    stein_status status = STEIN_OK;
    int most = best->h.n, near = has_part(q, &best->h) && best->chi2_dof < diag__near_noise;
    int answers = near || diag__leaves_noise(q, best);
    for (int n = told ? most : 0; n <= most && status == STEIN_OK; n++) {
        const diag__row *row = n < most ? diag__best(q, t, n) : best;
        int asked = n == 0 || n == most || answers;
        status = row != NULL && asked ? loosen(q, t, row, err) : STEIN_OK;
    }
    return status == STEIN_OK && diag__incumbent(q, t)->rough ? diag__expand_all(q, t, err)
                                                              : status;
}

/* What the best hypothesis leaves is more than the noise that was stated, or less: the search goes
 * on with noise that is estimated. What had to be named with more noise than there is has to be
 * named: then the table stays as it was. */
stein_status diag__with_noise(diag__problem *q, diag__table *t, stein_err *err)
{
    const diag__row *best = diag__incumbent(q, t);
    double most = diag__most_noise(q, &q->null);
    int less = best->chi2_dof < 2.0 - most;
    diag__standing kept = {.rows = 0};
    if (diag__is_spent(q) || !(less || best->chi2_dof > most)) {
        return STEIN_OK;
    }
    q->least_noise = less ? tiny : 1.0;
    stein_status status = diag__note_standing(t, &kept, err);
    q->scale_free = 1;
    status = status == STEIN_OK ? diag__fit_again(q, t, &diag__step_noise, err) : status;
    if (status == STEIN_OK && diag__best(q, t, -1) == NULL) { // none could be fitted again
        q->scale_free = 0;
        diag__take_back(q, t, &kept);
        free(kept.superseded);
        return STEIN_OK;
    }
    status = status == STEIN_OK ? diag__expand_all(q, t, err) : status;
    if (status == STEIN_OK && less && best->h.n > 0) {
        const diag__row *now = diag__incumbent(q, t), *null = diag__best(q, t, 0);
        double gain = null != NULL ? null->objective - now->objective : (double)INFINITY;
        if (now->h.n < best->h.n || gain < diag__least_gain * now->h.n) {
            q->scale_free = 0;
            diag__take_back(q, t, &kept);
        }
    }
    free(kept.superseded);
    return status;
}

/* No hypothesis leaves noise: once more with the numbers of the bodies free. What these explain by
 * themselves is no effect, and the table stays as it was. */
stein_status diag__with_bodies(diag__problem *q, diag__table *t, stein_err *err)
{
    diag__bodies b;
    if (diag__is_spent(q) || diag__incumbent(q, t)->chi2_dof <= diag__most_noise(q, &q->null)) {
        return STEIN_OK;
    }
    stein_status status = diag__bodies_begin(q, t, &b, err);
    if (b.free && status == STEIN_OK) {
        status = diag__expand_all(q, t, err);
        int none = status == STEIN_OK && diag__incumbent(q, t)->h.n == 0;
        stein_status end = diag__bodies_end(q, t, &b, none, err);
        return status == STEIN_OK ? end : status;
    }
    free(b.kept.superseded);
    return status;
}

/* the longest half swing of a record, 0: none swings; the longest record [s] */
static double half_swing(const fit__problem *p, double *whole)
{
    double half = 0.0;
    *whole = 0.0;
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        half = fmax(half, t->half);
        *whole = fmax(*whole, t->data->time[t->n - 1] - t->data->time[0]);
    }
    return half;
}

stein_status diag__over_growing_horizons(diag__problem *q, diag__table *t, stein_err *err)
{
    double whole, until = first_swings * half_swing(&q->null, &whole);
    diag__row *lost = diag__best(q, t, 0), *row = NULL;
    diag__proposal null = {.h = {.n = 0}, .parent = -1, .by = &diag__step_longer};
    if (lost == NULL || !diag__is_far_off(lost) || !(until > 0.0) || until * shortest > whole) {
        return diag__try_factors(q, t, until > 0.0 ? 1 : 2, err); // what swings has a rate
    }
    int estimated = q->scale_free;
    q->scale_free = 0; // a model that is far off is no measure of the noise
    lost->superseded = 1;
    fit__limit(&q->null, until);
    stein_status status = diag__try(q, t, &null, &row, err);
    status = status == STEIN_OK ? diag__try_factors(q, t, 1, err) : status;
    status = status == STEIN_OK ? diag__expand_all(q, t, err) : status;
    while (status == STEIN_OK && isfinite(until) && !diag__is_spent(q)) {
        until = until * growth * growth < whole ? until * growth : (double)INFINITY;
        fit__limit(&q->null, until);
        q->scale_free = estimated && !isfinite(until);
        status = diag__fit_again(q, t, &diag__step_longer, err);
        status = status == STEIN_OK && isfinite(until) ? diag__expand_all(q, t, err) : status;
    }
    q->scale_free = estimated;
    if (isfinite(until)) { // the budget is spent, or it failed
        fit__limit(&q->null, INFINITY);
        for (int k = 0; k < t->n; k++) {
            t->row[k]->superseded = 1;
        }
    }
    lost->superseded = 0;
    return status;
}
