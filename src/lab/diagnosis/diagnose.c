/* SPDX-License-Identifier: GPL-3.0-or-later
 * diagnose.c - from a mechanism file and records to a verdict.
 *
 *   audit      noise, rests and slips of the records, before anything is fitted
 *   split      records that are fitted, and those that report, read after the table is closed
 *   search     the table of hypotheses (search/)
 *   judge      the closed table -> finding, causes, rivals (verdict/judge.c)
 *   law        where the best hypothesis leaves more than noise, a curve (law/)
 *   report     reporting records, predicted with and without the causes
 *   verify     extended.yaml, read again and simulated
 *   show       where the model departs, the force it lacks, the motion check
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "curve.h"
#include "motion.h"
#include "verdict.h"

enum { HOLD_EVERY = 3, TRACES = 4, TRACES_HELD = 2, FREE_RECORDS = 16 };

static const double nearly_all = 0.9, far_off = 50.0; /* share of the misfit; chi2/dof */
static const double no_gain = 0.98, worse = 1.01;     /* ratio of errors on reporting records */

typedef struct diagnosis {
    diag__problem q;
    diag__table t;
    diag__judgement j;
    diag__setting setting;
    lab_dataset fitted, reporting;
    const lab_diagnose_def *def;
    diag__laws laws;
    diag__reported before, after;
    char suspicion[300]; /* what would let the records begin as the model moves; "": nothing */
    lab_diagnosis *out;
} diagnosis;

lab_diagnose_def lab_diagnose_def_default(void)
{
    return (lab_diagnose_def){.threads = 1};
}

static void progress(const diagnosis *d, double fraction, const char *step)
{
    if (d->def->progress != NULL) {
        d->def->progress(d->def->ctx, fraction, step);
    }
}

/* ---- records ---- */

static int is_held(const lab_diagnose_def *def, int record, int n)
{
    if (def->held_out != NULL) {
        return def->held_out[record];
    }
    return n >= HOLD_EVERY && record % HOLD_EVERY == HOLD_EVERY - 1;
}

static stein_status split(diagnosis *d, const lab_dataset *data, stein_err *err)
{
    size_t n = (size_t)data->n;
    lab_dataset *fit = &d->fitted, *report = &d->reporting;
    fit->stroke = calloc(n + 1, sizeof(lab_data *));
    report->stroke = calloc(n + 1, sizeof(lab_data *));
    if (fit->stroke == NULL || report->stroke == NULL) {
        return lab__no_memory(err);
    }
    for (int s = 0; s < data->n; s++) {
        lab_dataset *to = is_held(d->def, s, data->n) ? report : fit;
        to->stroke[to->n++] = data->stroke[s];
    }
    d->out->nfit = fit->n;
    d->out->nheld = report->n;
    return fit->n > 0 ? STEIN_OK
                      : lab__fail(err, STEIN_EINVAL,
                                  "%d strokes are held out and none is to fit to", report->n);
}

/* a line for the findings, which takes it over */
static stein_status add_finding(lab_diagnosis *o, char *line, int first, stein_err *err)
{
    char **more = realloc(o->finding, sizeof *more * (size_t)(o->nfinding + 1));
    o->finding = more != NULL ? more : o->finding;
    if (line == NULL || more == NULL) {
        free(line);
        return lab__no_memory(err);
    }
    if (first) {
        memmove(o->finding + 1, o->finding, sizeof *o->finding * (size_t)o->nfinding);
    }
    o->finding[first ? 0 : o->nfinding] = line;
    o->nfinding++;
    return STEIN_OK;
}

static stein_status audit(diagnosis *d, const lab_dataset *data, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int s = 0; status == STEIN_OK && s < data->n; s++) {
        lab_audit *a = NULL;
        status = lab_audit_create(&a, data->stroke[s], err);
        for (int i = 0; status == STEIN_OK && i < a->nfinding; i++) {
            status = add_finding(d->out, lab__text("%s: %s", data->stroke[s]->file, a->finding[i]),
                                 0, err);
        }
        lab_audit_destroy(a);
    }
    return status;
}

/* Slips that the records show before anything is fitted: units, signs, columns, the clock. With a
 * grave one no verdict on the mechanism could be trusted, so none is given. */
static stein_status check_slips(diagnosis *d, const lab_model *model, const lab_dataset *data,
                                stein_err *err)
{
    lab_doubts *doubts = NULL;
    stein_status status = lab_doubts_find(&doubts, model, data, err);
    for (int i = status == STEIN_OK ? doubts->n - 1 : -1; status == STEIN_OK && i >= 0; i--) {
        status = add_finding(d->out, lab__text("%s", doubts->item[i].text), 1, err);
    }
    if (status == STEIN_OK && doubts->grave) {
        d->out->verdict = LAB_VERDICT_UNUSABLE_MODEL;
        status = diag__name_slip(model, data, doubts, d->out, err);
        snprintf(d->out->reason, sizeof d->out->reason,
                 "The records do not mean what they say: %s%s", doubts->item[0].text,
                 d->out->ncause > 0 ? ". extended.yaml has the gain -1 that fits" : "");
    }
    lab_doubts_free(doubts);
    return status;
}

static stein_status check_step(diagnosis *d, stein_err *err)
{
    char *line = NULL;
    stein_status status = diag__check_step(&d->q.null, &line, err);
    if (status != STEIN_OK || line == NULL) {
        return status;
    }
    if (d->def->report != NULL) {
        d->def->report(d->def->ctx, line);
    }
    return add_finding(d->out, line, 1, err);
}

/* up to which frequency measured motions are taken as motion, where that is not as their noise has
 * it */
static stein_status tell_bands(diagnosis *d, stein_err *err)
{
    const stein_model *m = lab_equations(d->q.model);
    stein_status status = STEIN_OK;
    for (int i = 0; i < m->ninput && status == STEIN_OK; i++) {
        double hz = d->q.fit_def.smooth != NULL ? d->q.smooth[i] : (double)NAN;
        if (m->inputs[i].kind != STEIN_INPUT_MOTION || !isfinite(hz)) {
            continue;
        }
        char *line = lab__text(d->def->smooth > 0.0
                                   ? "%s: smoothed to half at %.3g Hz"
                                   : "%s: smoothed to half at %.3g Hz; what is faster does not "
                                     "show in the measured forces",
                               m->inputs[i].name, hz);
        if (line != NULL && d->def->report != NULL) {
            d->def->report(d->def->ctx, line);
        }
        status = add_finding(d->out, line, 1, err);
    }
    return status;
}

/* signs, zeros, units and planes with which the records' beginnings would follow */
static stein_status check_setup(diagnosis *d, stein_err *err)
{
    fit__finding *list = NULL;
    int n = 0;
    stein_err why;
    stein_status status = fit__setup(&d->q.null, &list, &n, &why);
    for (int i = n - 1; status == STEIN_OK && i >= 0; i--) {
        if (d->def->report != NULL) {
            d->def->report(d->def->ctx, list[i].text);
        }
        status = add_finding(d->out, lab__text("%s", list[i].text), 1, err);
    }
    if (status == STEIN_OK && n > 0) {
        snprintf(d->suspicion, sizeof d->suspicion, "%s", list[0].text);
    }
    fit__setup_free(list, n);
    return fit__forgive(status, err);
}

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

static diag__evidence evidence_of(const diag__problem *q, const diag__row *row)
{
    diag__evidence e = {.n = row->h.n,
                        .objective = row->objective + (row->rough ? of_settings() : 0.0),
                        .chi2_dof = row->chi2_dof,
                        .relative = row->relative,
                        .memory = row->memory,
                        .rough = row->rough,
                        .converged = row->converged,
                        .scatters_most = row->failed == NULL && diag__scatters_most(row->D),
                        .possible = diag__is_possible(q, row)};
    for (int i = 0; i < row->h.n; i++) {
        const lab_candidate c = diag__candidate(q, row->h.cause[i]);
        e.cause[i] = row->h.cause[i];
        if (row->failed == NULL) {
            e.amount[i] = diag__amount(row, i, &e.sd[i]);
        }
        e.tolerated[i] = diag__is_tolerated(q, e.cause[i]);
        e.scatters[i] = diag__scatters(q, e.cause[i]);
        e.single[i] = c.from > 0 && c.from == c.until;
        e.named[i] = c.effect->site != LAB_AT_PARAMETER;
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

/* rows whose numbers are reported, to the end of their fits */
static stein_status refine(diagnosis *d, stein_err *err)
{
    stein_status status = diag__refine_row(d->t.row[d->j.best], err);
    if (status == STEIN_OK &&
        d->j.null != d->j.best) { // what a cause gains is a difference of both
        status = diag__refine_row(d->t.row[d->j.null], err);
    }
    for (int i = 0; status == STEIN_OK && i < d->j.nrival; i++) {
        status = diag__refine_row(d->t.row[d->j.rival[i]], err);
    }
    diag__weigh(&d->q, &d->t); // noise that is estimated is weighed anew
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
        status = diag__linearise(&d->q, best, diag__observer_gain(best), FREE_RECORDS, l, &why);
    }
    status = status == STEIN_OK ? diag__results(&d->q, &d->t, &d->j, l, &d->setting, d->out, &why)
                                : status;
    diag__linear_free(&own);
    if (status != STEIN_OK && err != NULL) {
        *err = why;
    }
    return status;
}

static stein_status posteriors(diagnosis *d, stein_err *err)
{
    lab_diagnosis *o = d->out;
    const diag__row *best = d->t.row[d->j.best];
    stein_status status = diag__conditions(&d->q.null, &o->conditions, err);
    for (int i = -1; status == STEIN_OK && o->ncause == 1 && i < d->j.nrival; i++) {
        const diag__row *row = i < 0 ? best : d->t.row[d->j.rival[i]];
        for (int k = 0; k < 1 + o->nrival; k++) {
            if (row->J != NULL && o->suspect[k].posterior.n == 0 &&
                diag__is_same(&o->suspect[k].candidate, &row->cause[0])) {
                status = diag__posterior(row, &o->suspect[k].posterior, err);
            }
        }
    }
    return status;
}

/* the row with all causes of one but this; NULL: there is none */
static const diag__row *row_without(const diag__table *t, const diag__row *row,
                                    const lab_candidate *cause)
{
    int i = 0;
    while (i < row->h.n && !diag__is_same(&row->cause[i], cause)) {
        i++;
    }
    if (i == row->h.n) {
        return NULL;
    }
    const diag__hypothesis less = diag__without(row->h, row->h.cause[i]);
    return diag__find(t, &less);
}

/* what the reporting records lose without one of several causes, where that was fitted, too */
static stein_status own_gain(diagnosis *d, lab_suspect *cause, stein_err *err)
{
    const diag__row *row = row_without(&d->t, d->t.row[d->j.best], &cause->candidate);
    diag__reported without = {.rmse = NAN};
    if (row == NULL || row->failed != NULL || !isfinite(d->after.rmse)) {
        return STEIN_OK;
    }
    stein_status status = diag__report(row, &d->reporting, &without, err);
    if (status == STEIN_OK) {
        lab_gain g = {.ratio = NAN};
        status = diag__compare(&without, &d->after, &g, err);
        cause->own_ratio = g.ratio;
        cause->own_lo = g.lo;
        cause->own_hi = g.hi;
    }
    diag__reported_free(&without);
    return status;
}

/* sum of squares of the reporting records between two numbers, where the change i of the best row
 * begins at `from`; INFINITY: they cannot be simulated. The prediction stays in `to`. */
static stein_status report_from(diagnosis *d, int i, int from, int lo, int hi, diag__reported *to,
                                double *square, stein_err *err)
{
    diag__row *best = d->t.row[d->j.best];
    best->cause[i].from = from;
    stein_status status = diag__report(best, &d->reporting, to, err);
    *square = isfinite(to->rmse) ? 0.0 : (double)INFINITY;
    for (int s = 0; status == STEIN_OK && s < to->p.nstroke; s++) {
        const fit__stroke *t = &to->p.stroke[s];
        const double *r = to->r + fit__offset(&to->p, s);
        int between = t->data->number >= lo && t->data->number < hi;
        *square += between ? lab__dot(r, r, (size_t)t->nch * (size_t)t->n) : 0.0;
    }
    return status;
}

/* A change lies between two fitted records; the reporting ones between them tell where. They choose
 * nothing else. */
static stein_status place_change(diagnosis *d, int i, lab_suspect *s, stein_err *err)
{
    diag__row *best = d->t.row[d->j.best];
    int first = s->after + 1, last = best->cause[i].from, at = last;
    double least = INFINITY;
    stein_status status = STEIN_OK;
    for (int pass = 0; pass < 2; pass++) { // the least, then what comes near it
        int lo = last, hi = first;
        for (int from = first; status == STEIN_OK && from <= last && first < last; from++) {
            diag__reported there = {.rmse = NAN};
            double square;
            status = report_from(d, i, from, first, last, &there, &square, err);
            at = square < least ? from : at;
            least = fmin(least, square);
            lo = square < least + diag__convincing && from < lo ? from : lo;
            hi = square < least + diag__convincing && from > hi ? from : hi;
            diag__reported_free(&there);
        }
        s->after = pass > 0 && first < last ? lo - 1 : s->after;
        s->after_most = pass > 0 && first < last ? hi - 1 : s->after_most;
    }
    best->cause[i].from = s->candidate.from = at;
    return status;
}

static stein_status place_changes(diagnosis *d, stein_err *err)
{
    diag__row *best = d->t.row[d->j.best];
    stein_status status = STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < best->h.n; i++) {
        lab_suspect *s = d->out->suspect;
        while (!diag__is_same(&s->candidate, &best->cause[i])) {
            s++;
        }
        if (s->after > 0) {
            status = place_change(d, i, s, err);
        }
    }
    return status;
}

/* the reporting records, predicted for the first time; numerical failures leave rmse NAN */
static stein_status report(diagnosis *d, stein_err *err)
{
    stein_err why;
    stein_status status = STEIN_OK;
    d->before.rmse = d->after.rmse = NAN;
    if (d->reporting.n < 1) {
        return STEIN_OK;
    }
    status = diag__report(d->t.row[d->j.null], &d->reporting, &d->before, &why);
    if (status != STEIN_ENOMEM && d->j.finding == DIAG_NAMED) {
        status = place_changes(d, &why);
    }
    if (status != STEIN_ENOMEM && d->j.finding == DIAG_NAMED) {
        status = diag__report(d->t.row[d->j.best], &d->reporting, &d->after, &why);
    }
    for (int i = 0; i < d->out->ncause && status != STEIN_ENOMEM; i++) {
        d->out->suspect[i].held_out = d->after.rmse;
        status = d->out->ncause > 1 ? own_gain(d, &d->out->suspect[i], &why) : status;
    }
    return fit__forgive(status, err);
}

/* a reporting record whose own setting does not fit it, beside an explanation or a cause */
static stein_status odd_setting(diagnosis *d, stein_err *err)
{
    lab_diagnosis *o = d->out;
    int after = isfinite(d->after.rmse);
    const diag__row *row = d->t.row[after ? d->j.best : d->j.null];
    diag__odd_setting odd;
    stein_err why;
    if (d->j.finding != DIAG_EXPLAINED && d->j.finding != DIAG_NAMED) {
        return STEIN_OK;
    }
    stein_status status =
        diag__find_odd_setting(&d->q, row, after ? &d->after : &d->before, &odd, &why);
    if (status != STEIN_OK ||
        !diag__is_odd(&odd, row, d->fitted.n, d->reporting.n * d->q.nsetting)) {
        return fit__forgive(status, err);
    }
    if (d->j.finding == DIAG_EXPLAINED) {
        o->verdict = LAB_VERDICT_WRONG_PARAMETER;
        o->reason[0] = '\0';
    } else {
        strncat(o->reason, " ", sizeof o->reason - strlen(o->reason) - 1);
    }
    status = diag__take_odd_setting(&d->q, &odd, o, err);
    if (status == STEIN_OK) {
        diag__say_setting(o, &o->suspect[o->ncause - 1]);
    }
    return status;
}

/* One of several causes that reporting records do not show, and that has a row without it, is none:
 * they are predicted as well without it, or nearly so where more than noise is left.
 * @return 1: that row stands for the verdict now */
static int drop_unshown(diagnosis *d)
{
    const diag__row *best = d->t.row[d->j.best];
    int more = best->chi2_dof > d->setting.most_noise;
    for (int i = 0; d->out->ncause > 1 && i < d->out->ncause; i++) {
        const lab_suspect *s = &d->out->suspect[i];
        if (!(s->own_ratio >= no_gain && (more || s->own_hi >= 1.0))) {
            continue;
        }
        const diag__row *row = row_without(&d->t, best, &s->candidate);
        if (row != NULL && diag__is_possible(&d->q, row)) {
            d->j.best = diag__index(&d->t, row);
            d->j.nrival = 0;
            return 1;
        }
    }
    return 0;
}

/* Do the reporting records allow what is named? By no row without a cause they may be predicted
 * better, and where it leaves more than noise they must be predicted better by it. What leaves noise
 * may be too small to show beside the records' own unknowns. @param yes  out */
static stein_status is_shown(const diagnosis *d, int *yes, stein_err *err)
{
    const diag__row *best = d->t.row[d->j.best], *least = d->t.row[d->j.least];
    double most = best->chi2_dof > d->setting.most_noise ? no_gain : worse;
    diag__reported without = {.rmse = NAN};
    lab_gain g = {.ratio = NAN};
    stein_err why;
    *yes = 1;
    if (d->j.finding != DIAG_NAMED || !isfinite(d->after.rmse)) {
        return STEIN_OK;
    }
    stein_status status = diag__report(least, &d->reporting, &without, &why);
    status = status == STEIN_OK ? diag__compare(&without, &d->after, &g, &why) : status;
    diag__reported_free(&without);
    *yes = !isfinite(g.ratio) || g.ratio < most || g.hi < 1.0;
    return fit__forgive(status, err);
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
    return status == STEIN_OK ? report(d, err) : status;
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
 * what is left is still far from noise, the model errs in more than one law. */
static stein_status laws(diagnosis *d, stein_err *err)
{
    const diag__row *best = d->t.row[d->j.best];
    int hopeless =
        d->j.finding == DIAG_NAMED && d->j.share > nearly_all && best->chi2_dof > far_off;
    int noise = best->chi2_dof <= d->setting.most_noise && !diag__scatters_most(best->D);
    if (noise || hopeless || diag__is_spent(&d->q)) {
        return STEIN_OK;
    }
    const diag__judgement as_said = d->j;
    int stated = state_settings(d);
    stein_status status = stated ? shorten(d, err) : STEIN_OK;
    diag__reported after = {.rmse = NAN};
    status = status == STEIN_OK
                 ? diag__laws_find(&d->q, d->t.row[d->j.null], &d->laws, err)
                 : status;
    if (status == STEIN_OK && d->laws.n > 0) {
        status = diag__law_judge(&d->laws, &d->j, d->t.row[d->j.best], &d->reporting, &d->before,
                                 &after, d->out, err);
    }
    int pays = d->out->nlaw > 0 && d->out->law[0].pays;
    if (pays) {
        diag__reported_free(&d->after);
        d->after = after;
        d->out->ncause = d->out->nrival = 0;
    }
    if (status == STEIN_OK && stated && !pays) {
        d->j = as_said;
        status = shorten(d, err);
    }
    return status;
}

/* ---- what is shown ---- */

/* predictions of a record from its weighted residuals */
static void predict(const fit__problem *p, int s, const double *r, double *y)
{
    const fit__stroke *t = &p->stroke[s];
    r += fit__offset(p, s);
    for (int i = 0; i < t->nch * t->n; i++) {
        y[i] = t->y[i] - fit__off(t, r, i);
    }
}

static stein_status traces(diagnosis *d, const fit__problem *p, const double *before,
                           const double *after, const char *const *phase, int reporting, int most,
                           stein_err *err)
{
    size_t size = (size_t)p->rows;
    double *y = malloc(sizeof *y * (2 * size + 1));
    stein_status status = y != NULL ? STEIN_OK : lab__no_memory(err);
    for (int k = 0; status == STEIN_OK && k < most && k < p->nstroke; k++) {
        int s = k * p->nstroke / (most < p->nstroke ? most : p->nstroke);
        predict(p, s, before, y);
        if (after != NULL) {
            predict(p, s, after, y + size);
        }
        status = diag__trace(&d->out->trace, &d->out->ntrace, p, s, reporting, y,
                             after != NULL ? y + size : NULL, phase + diag__frame(p, s), err);
    }
    free(y);
    return status;
}

/* where the extension acts: the best row, or the law. @return 0: there is none */
static int extended(const diagnosis *d, diag__side *to)
{
    const diag__row *best = d->t.row[d->j.best];
    if (d->out->ncause > 0) {
        *to = (diag__side){&best->p, best->x, best->r};
    } else if (d->out->nlaw > 0 && d->out->law[0].pays) {
        *to = (diag__side){&d->laws.all.p, d->laws.curve[0].x, d->laws.curve[0].r};
    }
    return to->p != NULL;
}

static stein_status motion(diagnosis *d, const char *const *phase, const char *const *held_phase,
                           stein_err *err)
{
    const diag__row *null = d->t.row[d->j.null];
    diag__side from = {&null->p, null->x, null->r}, to = {NULL, NULL, NULL};
    int more = extended(d, &to), read = isfinite(d->before.rmse);
    if (read) {
        from = (diag__side){&d->before.p, d->before.x, d->before.r};
        more = more && isfinite(d->after.rmse);
        to = (diag__side){&d->after.p, d->after.x, d->after.r};
    }
    stein_status status =
        diag__motion_check(&from, more ? &to : NULL, read ? held_phase : phase, d->out->verdict,
                           read ? d->fitted.n : 0, &d->out->motion, err);
    d->out->motion.held_out = read;
    return status;
}

/* Is what is written what was found? A difference is an error of ours, and said so. */
static stein_status verify(diagnosis *d, stein_err *err)
{
    diag__side side[2] = {{NULL, NULL, NULL}, {&d->after.p, d->after.x, d->after.r}};
    lab_diagnosis *o = d->out;
    stein_err why = {STEIN_OK, ""};
    int changed = d->def->options != NULL && d->def->options->nset > 0; // by no file
    if (!lab_diagnosis_extends(o) || !extended(d, &side[0]) || changed) {
        return STEIN_OK;
    }
    stein_status status = diag__verify(&d->q, side, 1 + isfinite(d->after.rmse), o, &why);
    if (status == STEIN_OK && o->verified.same) {
        return STEIN_OK;
    }
    size_t n = strlen(o->reason);
    if (status == STEIN_OK) {
        snprintf(o->reason + n, sizeof o->reason - n,
                 " An error of this program: extended.yaml leaves %.4g noises where its fit left "
                 "%.4g.",
                 o->verified.file, o->verified.table);
    } else {
        o->verified = (lab_verified){.done = 1, .table = NAN, .file = NAN};
        snprintf(o->reason + n, sizeof o->reason - n,
                 " An error of this program: extended.yaml cannot be simulated: %s.", why.msg);
    }
    return fit__forgive(status, err);
}

static stein_status show(diagnosis *d, stein_err *err)
{
    const diag__row *null = d->t.row[d->j.null];
    const fit__problem *p = &null->p;
    diag__side end = {NULL, NULL, NULL};
    const double *r = extended(d, &end) ? end.r : NULL;
    int read = isfinite(d->before.rmse);
    size_t frames = diag__frame(p, p->nstroke),
           more = read ? diag__frame(&d->before.p, d->before.p.nstroke) : 0;
    const char **phase = malloc(sizeof *phase * (frames + more + 1));
    double *time = malloc(sizeof *time * (frames + 1));
    stein_status status = phase != NULL && time != NULL ? diag__phases(p, null->x, phase, time, err)
                                                        : lab__no_memory(err);
    if (status == STEIN_OK && more > 0) {
        status = diag__phases(&d->before.p, d->before.x, phase + frames, NULL, err);
    }
    if (status == STEIN_OK && r != NULL) {
        d->out->phase = diag__phase_shown(p, null->r, r, phase);
    }
    status = status == STEIN_OK ? traces(d, p, null->r, r, phase, 0, TRACES, err) : status;
    if (status == STEIN_OK && more > 0) {
        int better = isfinite(d->after.rmse);
        status = traces(d, &d->before.p, d->before.r, better ? d->after.r : NULL, phase + frames, 1,
                        TRACES_HELD, err);
    }
    progress(d, 0.94, "the force that the measured motion needs");
    status = status == STEIN_OK ? diag__show(d->out, p, null->x, null->r, null->J, phase, time, err)
                                : status;
    status = status == STEIN_OK ? motion(d, phase, phase + frames, err) : status;
    free(phase);
    free(time);
    return status;
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

static stein_status conclude(diagnosis *d, stein_err *err)
{
    lab_diagnosis *o = d->out;
    progress(d, 0.8, "numbers of the causes");
    stein_status status = judge(d, err);
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
    progress(d, 0.85, "strokes that were held out");
    status = report(d, err);
    for (int k = 0; k < DIAG_CAUSES && status == STEIN_OK && drop_unshown(d); k++) {
        status = shorten(d, err);
    }
    status = status == STEIN_OK ? gains(d, err) : status;
    int shown = 1;
    status = status == STEIN_OK ? is_shown(d, &shown, err) : status;
    if (status == STEIN_OK && !shown) {
        const diag__evidence null = evidence_of(&d->q, d->t.row[d->j.least]);
        d->j.finding = diag__not_shown(&null, &d->setting);
        d->j.best = d->j.null = d->j.least;
        d->j.nrival = 0;
        status = shorten(d, err);
        status = status == STEIN_OK ? gains(d, err) : status;
    }
    if (status == STEIN_OK) {
        diag__say(o, &d->j, &d->setting, d->suspicion);
        status = odd_setting(d, err);
        if (diag__is_spent(&d->q)) {
            size_t n = strlen(o->reason);
            snprintf(o->reason + n, sizeof o->reason - n,
                     " The search ended with its budget: %ld simulated strokes.", d->q.strokes);
        }
        progress(d, 0.88, "the law of what is in no table");
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
    progress(d, 0.91, "the extended file, read again");
    status = status == STEIN_OK ? verify(d, err) : status;
    progress(d, 0.92, "where the model departs");
    status = status == STEIN_OK ? show(d, err) : status;
    if (status == STEIN_OK && o->ncause == 1 && o->nrival > 0 && act_in_all(o)) {
        progress(d, 0.95, "the next experiment");
        status = diag__next(&d->q, o, err);
    }
    stein_status kept = keep_parts(d, err);
    return status == STEIN_OK ? kept : status;
}

static stein_status search(diagnosis *d, const char *file, const lab_model *model, stein_err *err)
{
    stein_status status = diag__problem_open(&d->q, file, model, &d->fitted, d->def, err);
    if (status == STEIN_OK && d->def->trace != NULL) {
        d->q.trace = fopen(d->def->trace, "w");
        if (d->q.trace == NULL) {
            return lab__fail(err, STEIN_EIO, "%s: cannot be written", d->def->trace);
        }
    }
    d->out->samples = d->q.null.samples;
    status = status == STEIN_OK ? tell_bands(d, err) : status;
    status = status == STEIN_OK ? check_step(d, err) : status;
    status = status == STEIN_OK ? check_setup(d, err) : status;
    progress(d, 0.05, "search for causes");
    status = status == STEIN_OK ? diag__search(&d->q, &d->t, err) : status;
    if (d->q.trace != NULL && fclose(d->q.trace) != 0 && status == STEIN_OK) {
        status = lab__fail(err, STEIN_EIO, "%s: cannot be written", d->def->trace);
    }
    return status;
}

stein_status lab_diagnose(lab_diagnosis **out, const char *file, const lab_model *model,
                          const lab_dataset *data, const lab_diagnose_def *def, stein_err *err)
{
    lab_diagnose_def none = lab_diagnose_def_default();
    diagnosis d = {.def = def != NULL ? def : &none, .before.rmse = NAN, .after.rmse = NAN};
    double begin = diag__clock();
    d.out = calloc(1, sizeof *d.out);
    if (d.out == NULL) {
        return lab__no_memory(err);
    }
    d.out->remainder = d.out->share = d.out->p = NAN;
    d.out->chi2_dof_before = d.out->chi2_dof_after = NAN;
    d.out->gain.ratio = d.out->gain.rmse_before = d.out->gain.rmse_after = NAN;
    d.out->gain.lo = d.out->gain.hi = NAN;
    d.out->noise_floor = 1.0;
    progress(&d, 0.0, "audit");
    stein_status status = split(&d, data, err);
    status = status == STEIN_OK ? audit(&d, data, err) : status;
    status = status == STEIN_OK ? check_slips(&d, model, data, err) : status;
    if (status == STEIN_OK && d.out->verdict != LAB_VERDICT_UNUSABLE_MODEL) {
        status = search(&d, file, model, err);
        status = status == STEIN_OK ? conclude(&d, err) : status;
    }
    d.out->seconds = diag__clock() - begin;
    d.out->fits = d.t.n;
    d.out->strokes_simulated = (int)d.q.strokes;
    diag__laws_free(&d.laws);
    diag__reported_free(&d.before);
    diag__reported_free(&d.after);
    diag__table_free(&d.t);
    diag__problem_close(&d.q);
    free(d.fitted.stroke);
    free(d.reporting.stroke);
    if (status == STEIN_OK) {
        progress(&d, 1.0, "done");
        *out = d.out;
    } else {
        lab_diagnosis_destroy(d.out);
    }
    return lab__stop_end(status, &(lab__stop){d.def->stop, d.def->ctx}, err);
}
