/* SPDX-License-Identifier: GPL-3.0-or-later
 * conclude.c - from the closed table to all that is reported.
 *
 *      judge       finding, causes, rivals (verdict/judge.c): once for the rows that may be the
 *                  best ones, which are fitted to their end, then with their numbers
 *      report      reporting records, with and without the causes; what they contradict is
 *                  withdrawn
 *      law         where the best hypothesis leaves more than noise, a curve (law/)
 *      verify      extended.yaml, read again and simulated
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "functions.h"
#include "diagnosis.h"

/* ---- the judge's view of the table ---- */

static int element(const diag__problem *q, int k)
{
    int i = 0;
    while (!diag__related(diag__base(q, i), diag__base(q, k))) {
        i++;
    }
    return i;
}

/* price of "settings are off": a cause that is convincingly better than that is named */
static double of_settings(void)
{
    return diag__least_gain - diag__convincing;
}

/* Do records differ by more than by what scatters? Noise of measured forces does that, too. */
static int scatters_most(const diag__problem *q, const diag__row *row)
{
    return row->failed == NULL && q->input_noise < 1.0 && diag__scatters_most(row->D);
}

static diag__evidence evidence_of(const diag__problem *q, const diag__row *row)
{
    diag__evidence e = {.n = row->h.n,
                        .objective = row->objective + (row->rough ? of_settings() : 0.0),
                        .chi2_dof = row->chi2_dof,
                        .relative = row->relative,
                        .memory = row->memory,
                        .rough = row->rough,
                        .converged = row->converged,
                        .scatters_most = scatters_most(q, row),
                        .possible = diag__is_possible(q, row)};
    e.likelihood = e.objective;
    for (int i = 0; i < row->h.n; i++) {
        const lab_candidate c = diag__candidate(q, row->h.cause[i]);
        e.cause[i] = row->h.cause[i];
        if (row->failed == NULL) {
            double x = e.amount[i] = diag__amount(row, i, &e.sd[i]);
            e.likelihood -= x * x + diag__mistake(&c, x) - 2.0 * stein__log_of(e.sd[i]);
        }
        e.tolerated[i] = diag__is_tolerated(q, e.cause[i]);
        e.scatters[i] = diag__scatters(q, e.cause[i]);
        e.single[i] = c.from > 0 && c.from == c.until;
        e.named[i] = c.effect->site != LAB_AT_PARAMETER;
        e.clock[i] = c.effect->site == LAB_AT_CLOCK;
        e.gain[i] = strcmp(c.effect->kind, "sensor_gain") == 0;
        e.place[i] = element(q, row->h.cause[i]);
    }
    return e;
}

static stein_status judge(diagnosis *d, stein_err *err)
{
    const stein_model *m = lab_equations(d->q.model);
    diag__evidence *e = malloc(sizeof *e * (size_t)(d->t.n + 1));
    if (e == NULL) {
        return lab__no_memory(err);
    }
    for (int i = 0; i < d->t.n; i++) {
        e[i] = evidence_of(&d->q, d->t.row[i]);
    }
    d->setting = (diag__setting){.most_noise = diag__most_noise(&d->q, &d->q.null),
                                 .input = sqrt(d->q.input_share),
                                 .stated = fit__noise_given(&d->q.null),
                                 .assumed = d->q.assumed,
                                 .records = d->fitted.n,
                                 .freedom = d->fitted.n - 1 + diag__scatter_worth(d->fitted.n),
                                 .names = d->q.nname,
                                 .body = d->q.nbody > 0 ? d->q.body_sd : NULL};
    for (int k = 0; k < d->q.nname; k++) {
        int i = stein_find_param(m, d->q.name[k]);
        d->setting.tolerances += i >= 0 && diag__has_tolerance(&d->q, i);
    }
    d->j = diag__judge(e, d->t.n, &d->setting);
    free(e);
    return STEIN_OK;
}

/* The row, not yet at the end of its fit, that might become the best one there: as many causes, and
 * least objective; of several fits of a hypothesis the one that stands for it. NULL: there is none.
 */
static diag__row *contender(const diagnosis *d)
{
    const diag__row *best = d->t.row[d->j.best];
    diag__row *found = NULL;
    double least = evidence_of(&d->q, best).objective + diag__unended();
    for (int i = 0; i < d->t.n; i++) {
        diag__row *row = d->t.row[i];
        const diag__evidence e = evidence_of(&d->q, row);
        int stands = e.possible && e.n == best->h.n;
        for (int k = 0; k < d->t.n && stands; k++) {
            const diag__row *other = d->t.row[k];
            stands = !diag__equals(&other->h, &row->h) || !diag__is_possible(&d->q, other) ||
                     !(other->objective < row->objective);
        }
        if (stands && row->within > 0.0 && e.objective < least) {
            least = e.objective;
            found = row;
        }
    }
    return found;
}

/* Fits of a search end before their minimum, by more than the differences between hypotheses. So
 * rows near the best one are fitted to their end before one is chosen. */
static stein_status refine_contenders(diagnosis *d, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int k = 0; k < DIAG_FEW_FITS && status == STEIN_OK && !diag__is_spent(&d->q); k++) {
        diag__row *row = contender(d);
        if (row == NULL) {
            break;
        }
        status = diag__refine_row(row, 0.0, err);
        diag__weigh(&d->q, &d->t);
        status = status == STEIN_OK ? judge(d, err) : status;
    }
    return status;
}

/* rows whose numbers are reported, to the end of their fits */
static stein_status refine(diagnosis *d, stein_err *err)
{
    diag__row *best = d->t.row[d->j.best], *null = d->t.row[d->j.null];
    stein_status status = diag__refine_row(best, 0.0, err);
    if (status == STEIN_OK && null != best) { // what a cause gains is a difference of both
        double gain = null->objective - best->objective;
        status = diag__refine_row(null, diag__part_of * gain, err);
    }
    for (int i = 0; status == STEIN_OK && i < d->j.nrival; i++) {
        status = diag__refine_row(d->t.row[d->j.rival[i]], 0.0, err);
    }
    diag__weigh(&d->q, &d->t); // with the noise that the refined rows leave
    return status;
}

/* ---- results ---- */

static stein_status results(diagnosis *d, stein_err *err)
{
    const diag__row *best = d->t.row[d->j.best];
    diag__linear own = {.n = 0}, *l = &d->t.last;
    stein_err why = {STEIN_OK, ""};
    stein_status status = STEIN_OK;
    if (l->row != best) {
        l = &own;
        status = fit__forgive(
            diag__linearise(&d->q, best, diag__observer_gain(best), DIAG_MANY_RECORDS, l, &why),
            err);
    }
    status = status == STEIN_OK ? diag__results(&d->q, &d->t, &d->j, l, &d->setting, d->out, &why)
                                : status;
    diag__linear_free(&own);
    if (status != STEIN_OK && err != NULL) {
        *err = why;
    }
    return status;
}

/* The posterior of a row for the first one of its candidates among `first` .. `end` - 1 that has
 * none: of the best row it is the first cause, of another one the rival that it brings. */
static stein_status posterior(const diag__row *row, lab_diagnosis *o, int first, int end,
                              stein_err *err)
{
    for (int k = first; row->J != NULL && k < end; k++) {
        lab_suspect *s = &o->suspect[k];
        for (int i = 0; i < row->h.n; i++) {
            if (s->posterior.n == 0 && diag__is_same(&s->candidate, &row->cause[i])) {
                return diag__posterior(row, i, &s->posterior, err);
            }
        }
    }
    return STEIN_OK;
}

static stein_status posteriors(diagnosis *d, stein_err *err)
{
    lab_diagnosis *o = d->out;
    stein_status status = diag__conditions(&d->q.null, d->t.row[d->j.best], &o->conditions, err);
    if (status == STEIN_OK && o->ncause > 0) {
        status = posterior(d->t.row[d->j.best], o, 0, 1, err);
    }
    for (int i = 0; status == STEIN_OK && o->ncause > 0 && i < d->j.nrival; i++) {
        const diag__row *row = d->t.row[d->j.rival[i]];
        status = posterior(row, o, o->ncause, o->ncause + o->nrival, err);
    }
    return status;
}

/* numbers and predictions of the verdict's row, once more */
static stein_status shorten(diagnosis *d, stein_err *err)
{
    lab_diagnosis *o = d->out;
    const diag__row *null = d->t.row[d->j.null], *best = d->t.row[d->j.best];
    free(o->suspect);
    free(o->value);
    o->suspect = NULL;
    o->value = NULL;
    o->nsuspect = o->ncause = o->nrival = o->nvalue = 0;
    diag__reported_free(&d->before);
    diag__reported_free(&d->after);
    d->j.share = (null->chi2_dof - best->chi2_dof) / fmax(null->chi2_dof - 1.0, 1e-9);
    d->j.gain = null->objective - best->objective;
    stein_status status = refine(d, err);
    status = status == STEIN_OK ? results(d, err) : status;
    o->remainder = sqrt(o->chi2_dof_after);
    o->share = d->j.share;
    return status == STEIN_OK ? diag__predict(d, err) : status;
}

/* A law is fitted to settings as they are stated, and told against the row that takes them so.
 * @return 1: that row stands for the null hypothesis now */
static int state_settings(diagnosis *d)
{
    int plain = -1;
    for (int i = 0; i < d->t.n && d->t.row[d->j.null]->rough; i++) {
        const diag__row *row = d->t.row[i];
        int eligible = row->h.n == 0 && !row->rough && diag__is_possible(&d->q, row);
        plain = eligible && (plain < 0 || row->objective < d->t.row[plain]->objective) ? i : plain;
    }
    if (plain >= 0) {
        d->j.best = d->j.best == d->j.null ? plain : d->j.best;
        d->j.null = plain;
    }
    return plain >= 0;
}

/* After named causes a law has to leave noise (law/). Where they have explained nearly all, and
 * what is left is still far from noise, the model errs in more than one law. Where noise is left
 * but records differ by as much as is allowed for, and neither cause nor law is behind it, they do.
 */
static stein_status laws(diagnosis *d, stein_err *err)
{
    const diag__row *best = d->t.row[d->j.best];
    int hopeless = d->j.finding == DIAG_NAMED && d->j.share > diag__nearly_all() &&
                   best->chi2_dof > diag__seven_noises;
    int noise = best->chi2_dof <= d->setting.most_noise && !scatters_most(&d->q, best);
    if (noise || hopeless || diag__is_spent(&d->q)) {
        return STEIN_OK;
    }
    const diag__judgement as_said = d->j;
    int stated = state_settings(d);
    stein_status status = stated ? shorten(d, err) : STEIN_OK;
    diag__reported after = {.rmse = NAN};
    status =
        status == STEIN_OK ? diag__laws_find(&d->q, d->t.row[d->j.null], &d->laws, err) : status;
    if (status == STEIN_OK && d->laws.n > 0) {
        status = diag__law_judge(&d->laws, &d->j, d->t.row[d->j.best], &d->reporting, &d->before,
                                 &after, d->out, err);
    }
    int pays = d->out->nlaw > 0 && d->out->law[0].pays;
    if (pays) {
        diag__reported_free(&d->after);
        d->after = after;
        d->out->ncause = d->out->nrival = 0;
    } else {
        diag__reported_free(&after);
    }
    if (status == STEIN_OK && stated && !pays) {
        d->j = as_said;
        status = shorten(d, err);
    }
    best = d->t.row[d->j.best];
    if (status == STEIN_OK && !pays && d->j.finding == DIAG_NO_CAUSE &&
        best->chi2_dof <= d->setting.most_noise) {
        diag__laws_drop(d->out);
        d->j.finding = DIAG_EXPLAINED;
        diag__say(d->out, &d->j, &d->setting, "", d->suspicion);
    }
    return status;
}

/* "coulomb_friction at wheel": what explains most of the misfit where no cause is named */
static const char *nearest(const diagnosis *d, char *to, size_t room)
{
    const diag__row *row = d->j.nearest >= 0 ? d->t.row[d->j.nearest] : NULL;
    const lab_candidate *c = row != NULL ? diag__base(&d->q, row->h.cause[0]) : NULL;
    snprintf(to, room, "%s%s%s", c != NULL ? c->effect->kind : "", c != NULL ? " at " : "",
             c != NULL ? c->place : "");
    return to;
}

static stein_status gains(diagnosis *d, stein_err *err)
{
    lab_diagnosis *o = d->out;
    free(o->gains); // of another verdict
    o->gains = NULL;
    o->ngain = 0;
    o->gain.ratio = o->gain.rmse_before = o->gain.rmse_after = o->gain.lo = o->gain.hi = NAN;
    o->noise_floor = 1.0;
    if (!isfinite(d->before.rmse)) {
        return STEIN_OK;
    }
    size_t frames = diag__frame(&d->before.p, d->before.p.nstroke);
    const char **phase = malloc(sizeof *phase * (frames + 1));
    stein_status status = phase != NULL ? diag__phases(&d->before.p, d->before.x, phase, NULL, err)
                                        : lab__no_memory(err);
    if (status == STEIN_OK) {
        status =
            diag__gain(o, &d->before, isfinite(d->after.rmse) ? &d->after : &d->before, phase, err);
    }
    free(phase);
    return status;
}

/* mechanisms with parts stay: causes and rivals have their units from them */
static stein_status keep_parts(diagnosis *d, stein_err *err)
{
    d->out->kept = calloc((size_t)d->q.nmechanism + 1, sizeof(lab_model *));
    if (d->out->kept == NULL) {
        return lab__no_memory(err);
    }
    for (int i = 0; i < d->q.nmechanism; i++) {
        if (d->q.mechanism[i]->own != NULL) {
            d->out->kept[d->out->nkept++] = d->q.mechanism[i]->own;
            d->q.mechanism[i]->own = NULL;
        }
    }
    return STEIN_OK;
}

/* do causes and rivals act in all records? An experiment has no place in their order. */
static int act_in_all(const lab_diagnosis *o)
{
    int yes = 1;
    for (int i = 0; i < o->ncause + o->nrival; i++) {
        yes &= o->suspect[i].candidate.from == 0;
    }
    return yes;
}

/* what the noise of measured forces does to the records that report */
static stein_status learn_forces(diagnosis *d, stein_err *err)
{
    stein_err why;
    return d->reporting.n < 1 ? STEIN_OK
                              : fit__forgive(diag__know_forces(&d->q, &d->reporting, &why), err);
}

stein_status diag__conclude(diagnosis *d, stein_err *err)
{
    lab_diagnosis *o = d->out;
    diag__progress(d, 0.8, "numbers of the causes");
    stein_status status = judge(d, err);
    status = status == STEIN_OK ? refine_contenders(d, err) : status;
    status = status == STEIN_OK ? refine(d, err) : status;
    status = status == STEIN_OK ? judge(d, err) : status; // with the refined numbers
    status = status == STEIN_OK ? results(d, err) : status;
    if (status != STEIN_OK) {
        return status;
    }
    if (d->def->explain != NULL) {
        status = diag__explain(&d->q, &d->t, &d->j, d->def->explain, &o->explanation, err);
        if (status != STEIN_OK) {
            return status;
        }
    }
    o->remainder = sqrt(o->chi2_dof_after);
    o->share = d->j.share;
    diag__progress(d, 0.85, "records that were held out");
    status = learn_forces(d, err);
    status = status == STEIN_OK ? diag__predict(d, err) : status;
    for (int k = 0; k < DIAG_CAUSES && status == STEIN_OK && diag__drop_unshown(d); k++) {
        status = shorten(d, err);
    }
    status = status == STEIN_OK ? gains(d, err) : status;
    int shown = 1;
    status = status == STEIN_OK ? diag__is_shown(d, &shown, err) : status;
    if (status == STEIN_OK && !shown) {
        const diag__evidence null = evidence_of(&d->q, d->t.row[d->j.least]);
        d->j.finding = diag__not_shown(&null, &d->setting);
        d->j.best = d->j.null = d->j.least;
        d->j.nrival = 0;
        status = shorten(d, err);
        status = status == STEIN_OK ? gains(d, err) : status;
    }
    if (status == STEIN_OK) {
        char text[300];
        diag__say(o, &d->j, &d->setting, nearest(d, text, sizeof text), d->suspicion);
        status = diag__name_odd_setting(d, err);
        int differ = 0;
        if (status == STEIN_OK && o->verdict == LAB_VERDICT_EXPLAINED) {
            status = diag__differ(d, &differ, err);
        }
        if (differ) {
            d->j.finding = DIAG_NOT_HELD;
            diag__say(o, &d->j, &d->setting, "", d->suspicion);
        }
        if (diag__is_spent(&d->q)) {
            size_t n = strlen(o->reason);
            snprintf(o->reason + n, sizeof o->reason - n,
                     " The search ended with its budget: %ld simulations of records.",
                     d->q.strokes);
        }
        diag__progress(d, 0.88, "the law of what is in no table");
        status = status == STEIN_OK ? laws(d, err) : status;
    }
    if (status == STEIN_OK && o->nlaw > 0 && o->law[0].pays) {
        status = gains(d, err);
    }
    if (status == STEIN_OK) {
        status = diag__list_records(d->t.row[d->j.null],
                                    d->j.finding == DIAG_NAMED ? d->t.row[d->j.best] : NULL,
                                    &d->before, &d->after, o, err);
    }
    status = status == STEIN_OK ? posteriors(d, err) : status;
    diag__progress(d, 0.91, "the extended file, read again");
    status = status == STEIN_OK ? diag__verify_written(d, err) : status;
    diag__progress(d, 0.92, "where the model departs");
    status = status == STEIN_OK ? diag__show_all(d, err) : status;
    if (status == STEIN_OK && o->ncause > 0 && o->nrival > 0 && act_in_all(o)) {
        diag__progress(d, 0.95, "the next experiment");
        status = diag__next(&d->q, o, err);
    }
    stein_status kept = keep_parts(d, err);
    return status == STEIN_OK ? kept : status;
}
