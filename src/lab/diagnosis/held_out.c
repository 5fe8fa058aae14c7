/* SPDX-License-Identifier: GPL-3.0-or-later
 * held_out.c - records that report: what the verdict predicts of them, and what they contradict.
 *
 * No fit has read them. They withdraw what they contradict and tell where between two fitted
 * records a change lies; they choose nothing else.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "diagnosis.h"

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

stein_status diag__predict(diagnosis *d, stein_err *err)
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

stein_status diag__name_odd_setting(diagnosis *d, stein_err *err)
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

/* Can reporting records show a cause, or does it act in none of them? */
static int can_be_shown(const diagnosis *d, const lab_candidate *c)
{
    int yes = 0;
    for (int i = 0; i < d->reporting.n; i++) {
        yes |= lab_candidate_acts(c, d->reporting.stroke[i]->number);
    }
    return yes;
}

int diag__drop_unshown(diagnosis *d)
{
    const diag__row *best = d->t.row[d->j.best];
    int more = best->chi2_dof > d->setting.most_noise;
    for (int i = 0; d->out->ncause > 1 && i < d->out->ncause; i++) {
        const lab_suspect *s = &d->out->suspect[i];
        int unshown = s->own_ratio >= diag__no_gain && (more || s->own_hi >= 1.0);
        if (!unshown || !can_be_shown(d, &s->candidate)) {
            continue;
        }
        const diag__row *row = row_without(&d->t, best, &s->candidate);
        // reporting records may be too few to show what the fitted ones need
        int required = row != NULL && !more && row->chi2_dof > d->setting.most_noise;
        int contradicted = s->own_lo > 1.0;
        if (row != NULL && diag__is_possible(&d->q, row) && (contradicted || !required)) {
            d->j.best = diag__index(&d->t, row);
            d->j.nrival = 0;
            return 1;
        }
    }
    return 0;
}

/* Do reporting records contradict what leaves noise where it was fitted? Of two predictions whose
 * difference is D noises, the true one is nearer by
 *
 *      chi2_without - chi2_with = D^2 +- 2 D,     -D^2 +- 2 D if the other one is true
 *
 * so the difference of chi2 is the evidence for a cause; it contradicts one that it makes
 * improbable, not one beside which it happens to be a little below 0.
 */
static int contradict(const diag__row *best, const diag__reported *without,
                      const diag__reported *with)
{
    size_t n = fit__offset(&with->p, with->p.nstroke);
    double nearer = 0.0, noise = fmax(with->rmse * with->rmse, 1e-300) * fmax(best->memory, 1.0);
    if (fit__offset(&without->p, without->p.nstroke) != n || !isfinite(without->rmse)) {
        return 0;
    }
    for (size_t i = 0; i < n; i++) {
        double a = without->r[i], b = with->r[i];
        nearer += (a - b) * (a + b) / noise;
    }
    return nearer < -diag__convincing;
}

stein_status diag__is_shown(const diagnosis *d, int *yes, stein_err *err)
{
    const diag__row *best = d->t.row[d->j.best], *least = d->t.row[d->j.least];
    int acts = 0;
    diag__reported without = {.rmse = NAN};
    lab_gain g = {.ratio = NAN};
    stein_err why;
    *yes = 1;
    for (int i = 0; i < best->h.n; i++) {
        acts |= can_be_shown(d, &best->cause[i]);
    }
    if (!acts || d->j.finding != DIAG_NAMED || !isfinite(d->after.rmse)) {
        return STEIN_OK;
    }
    stein_status status = diag__report(least, &d->reporting, &without, &why);
    if (status == STEIN_OK && best->chi2_dof <= d->setting.most_noise) {
        *yes = !contradict(best, &without, &d->after);
    } else if (status == STEIN_OK) { // an improvement may be due to what is left besides noise
        status = diag__compare(&without, &d->after, &g, &why);
        int clear = best->chi2_dof <= diag__seven_noises || g.hi < 1.0;
        *yes = !isfinite(g.ratio) || (clear && g.ratio < diag__no_gain);
    }
    diag__reported_free(&without);
    return fit__forgive(status, err);
}

stein_status diag__differ(const diagnosis *d, int *yes, stein_err *err)
{
    const diag__reported *r = &d->before;
    *yes = 0;
    if (!fit__noise_given(&d->q.null) || !isfinite(r->rmse)) {
        return STEIN_OK;
    }
    double *chi2 = malloc(sizeof *chi2 * (2 * (size_t)r->p.nstroke + 1));
    if (chi2 == NULL) {
        return lab__no_memory(err);
    }
    // the record in the middle: single ones may be lost by their fits
    *yes = diag__by_record(&r->p, r->r, chi2) > diag__three_noises();
    free(chi2);
    return STEIN_OK;
}
