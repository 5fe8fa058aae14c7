/* SPDX-License-Identifier: GPL-3.0-or-later
 * results.c - the numbers of a diagnosis: causes, rivals, other candidates, the file's own.
 *
 * All of them are those of rows of the table. Where noise is estimated with the fit, its rows have
 * it in their noise, correlation of the residual included.
 */
#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "added_parts.h"
#include "verdict.h"

/* Half a 95 % interval [sd]. Where records scatter by themselves, how much they do is estimated
 * from them, and beside few from the prior, too: Student's t. */
static double half_interval(const fit__problem *p)
{
    const fit__stroke *t = &p->stroke[0];
    int scatter = 0;
    for (int k = 0; k < t->own; k++) {
        scatter |= p->unknown[t->first + k].kind == FIT__SCATTER;
    }
    double freedom = p->nstroke - 1 + diag__scatter_worth(p->nstroke);
    return scatter && freedom > 0.0 ? gsl_cdf_tdist_Pinv(0.975, freedom) : diag__interval;
}

static lab_cause_number *next_number(lab_suspect *to, const char *name, const char *unit)
{
    lab_cause_number *n = &to->number[to->nnumber++];
    snprintf(n->name, sizeof n->name, "%s", name);
    n->unit = unit;
    return n;
}

/* amount and the numbers beside it of cause i of a row */
static void note_numbers(const diag__row *row, int i, double gain, lab_suspect *s)
{
    const lab_candidate *c = &row->cause[i];
    const fit__problem *p = &row->p;
    int at = diag__unknown_at(row, i);
    const fit__unknown *u = &p->unknown[at];
    double half = half_interval(p), sd;
    s->nnumber = 0;
    s->amount = diag__amount(row, i, &sd) * c->limit;
    double down = sd, up = sd, *to_zero = row->x[at] > 0.0 ? &down : &up;
    if (gain > diag__least_gain && fabs(row->x[at]) < diag__interval * sd) {
        *to_zero = fabs(row->x[at]) / sqrt(gain); // 0 is as far as the ratio of likelihoods has it
    }
    lab_cause_number *n = next_number(s, lab_candidate_size(c), c->unit);
    n->value = s->amount;
    n->sd = sd * c->limit;
    n->lo = n->value - half * down * c->limit;
    n->hi = n->value + half * up * c->limit;
    for (int k = 0; k < LAB_SIDES && c->side[k].param >= 0; k++) {
        double own = fmin(1.0, row->sd[at + 1 + k]), x = row->x[at + 1 + k];
        n = next_number(s, c->side[k].name, c->side[k].unit);
        n->value = fit__value(&u[1 + k], x);
        n->sd = 0.5 * fabs(fit__value(&u[1 + k], x + own) - fit__value(&u[1 + k], x - own));
        n->lo = fit__value(&u[1 + k], x - half * own);
        n->hi = fit__value(&u[1 + k], x + half * own);
        s->candidate.side[k].value = n->value;
    }
}

lab_suspect diag__suspect(const lab_candidate *c)
{
    return (lab_suspect){.candidate = *c,
                         .score = NAN,
                         .gain = NAN,
                         .held_out = NAN,
                         .chi2_dof = NAN,
                         .own_ratio = NAN,
                         .own_lo = NAN,
                         .own_hi = NAN,
                         .stated = NAN};
}

/* the record of a wrong setting; the record behind which a change begins */
static void note_scope(const diag__row *row, lab_suspect *s)
{
    const lab_candidate *c = &s->candidate;
    const lab_dataset *fitted = row->in->fitted;
    for (int k = 0; c->from > 0 && k < fitted->n; k++) {
        const lab_data *data = fitted->stroke[k];
        if (c->until == 0 && data->number < c->from) {
            s->after = data->number;
        }
        for (int i = 0; data->number == c->until && i < data->nset; i++) {
            s->file = data->file;
            s->stated = data->set[i].param == c->param[0] ? data->set[i].value : s->stated;
        }
    }
    s->after_most = c->from > 0 && c->until == 0 ? c->from - 1 : 0;
}

/* "centre at rod and mass at bob": the other causes of the row */
static void note_beside(const diag__row *row, int own, lab_suspect *s)
{
    for (int i = 0; i < row->h.n; i++) {
        size_t n = strlen(s->fitted_beside);
        if (i != own) {
            snprintf(s->fitted_beside + n, sizeof s->fitted_beside - n, "%s%s at %s",
                     n > 0 ? " and " : "", row->cause[i].effect->kind, row->cause[i].place);
        }
    }
}

/* cause i of a row: what it gains over the same row without it, or over no cause */
static lab_suspect of_row(const diag__table *t, const diag__row *null, const diag__row *row, int i)
{
    lab_suspect s = diag__suspect(&row->cause[i]);
    diag__hypothesis less = diag__without(row->h, row->h.cause[i]);
    const diag__row *without = diag__find(t, &less);
    int fitted = without != NULL && isfinite(without->objective);
    without = fitted ? without : null;
    s.refitted = 1;
    double sd, z = diag__amount(row, i, &sd) / fmax(sd, 1e-300);
    s.gain = fitted || row->h.n == 1 ? without->objective - row->objective : z * z; // Wald's test
    s.chi2_dof = row->chi2_dof;
    s.possible = 1;
    note_numbers(row, i, s.gain, &s);
    note_scope(row, &s);
    note_beside(row, i, &s);
    return s;
}

/* the best row that has a candidate */
static const diag__row *row_with(const diag__problem *q, const diag__table *t, int k)
{
    const diag__row *best = NULL;
    for (int i = 0; i < t->n; i++) {
        const diag__row *row = t->row[i];
        if (diag__has(&row->h, k) && diag__is_possible(q, row) &&
            (best == NULL || row->objective < best->objective)) {
            best = row;
        }
    }
    return best;
}

static int place_in(const diag__row *row, int k)
{
    int i = 0;
    while (row->h.cause[i] != k) {
        i++;
    }
    return i;
}

/* The interval of a cause contains what its amount would be beside another candidate c, too:
 *
 *      a' = a + da,   sd'^2 = sd^2 + (da/a_c)^2 sd_c^2,   da as the linear model has it
 *
 * @param with, without  [l->own] amounts beside c and alone [limits] */
static void allow_for(const diag__problem *q, const diag__linear *l, const double *with,
                      const double *without, const lab_power *other, lab_diagnosis *o)
{
    for (int i = 0; i < l->own; i++) {
        const lab_candidate own = diag__candidate(q, l->cause[i]);
        int k = 0;
        while (k < o->ncause && !diag__is_same(&o->suspect[k].candidate, &own)) {
            k++;
        }
        if (k == o->ncause) {
            continue;
        }
        lab_cause_number *n = &o->suspect[k].number[0];
        double shift = (with[i] - without[i]) * own.limit, half = fmax(n->hi - n->value, 0.0),
               more = diag__interval * shift / other->amount * other->sd;
        double lo = fmin(n->lo, n->value + shift - hypot(half, more)),
               hi = fmax(n->hi, n->value + shift + hypot(half, more));
        if (lo * hi > 0.0) { // else one could stand in the other's place: those are rivals
            n->lo = lo, n->hi = hi;
        }
    }
}

/* a candidate that is neither a cause nor a rival */
static lab_suspect other(diag__problem *q, const diag__table *t, const diag__row *null,
                         const diag__linear *l, int k, lab_diagnosis *o)
{
    const diag__row *row = row_with(q, t, k);
    lab_suspect s =
        row != NULL ? of_row(t, null, row, place_in(row, k)) : diag__suspect(&q->candidate[k]);
    double amount[DIAG_CAUSES + 1], without[DIAG_CAUSES + 1], most = -INFINITY;
    int column = -1;
    s.power = (lab_power){.presence = LAB_NOT_TESTABLE,
                          .amount = NAN,
                          .sd = NAN,
                          .detectable = NAN,
                          .upper = NAN,
                          .because = l->unseen[k] != NULL ? l->unseen[k] : "it was not simulated"};
    s.why = q->untestable[k] != NULL ? q->untestable[k] : l->unseen[k];
    for (int c = l->own; c < l->n; c++) {
        int set[DIAG_CAUSES + 1] = {0, 1, 2}, n = l->own;
        set[n++] = c;
        if (l->cause[c] == k) {
            double gain = diag__linear_gain(l, set, n, amount) -
                          (n > 1 ? diag__linear_gain(l, set, n - 1, without) : 0.0);
            column = gain > most ? c : column;
            most = fmax(most, gain);
        }
    }
    if (column >= 0) {
        int set[DIAG_CAUSES + 1] = {0, 1, 2}, n = l->own;
        set[n++] = column;
        diag__linear_gain(l, set, n, amount);
        double a = amount[n - 1];
        s.score = most;
        s.amount = s.refitted ? s.amount : a * s.candidate.limit;
        s.possible = s.refitted || diag__thinkable(&q->candidate[k], a);
        s.why = s.possible ? NULL
                : a > 0.0 || lab_candidate_is_signed(&s.candidate)
                    ? "it would have to be larger than is thinkable"
                    : "it would have to be negative";
        s.power = diag__power(q, l, column);
        if (s.power.beside) {
            allow_for(q, l, amount, without, &s.power, o);
        }
    }
    return s;
}

/* as of detectability.c, from the row itself */
static void present(lab_suspect *s)
{
    double sd = s->number[0].sd;
    s->power = (lab_power){.presence = LAB_PRESENT,
                           .amount = s->amount,
                           .sd = sd,
                           .detectable = (sqrt(diag__least_gain) + diag__one_sided) * sd,
                           .upper = fabs(s->amount) + diag__one_sided * sd,
                           .because = "it is a cause"};
}

static int is_listed(const lab_diagnosis *o, const lab_candidate *c)
{
    for (int i = 0; i < o->nsuspect; i++) {
        if (diag__is_same(&o->suspect[i].candidate, c)) {
            return 1;
        }
    }
    return 0;
}

static int by_own_gain(const void *a, const void *b)
{
    const lab_suspect *x = a, *y = b;
    return x->gain > y->gain ? -1 : x->gain < y->gain;
}

static void list_causes(const diag__table *t, const diag__judgement *j, lab_diagnosis *o)
{
    const diag__row *null = t->row[j->null], *best = t->row[j->best];
    for (int i = 0; j->finding == DIAG_NAMED && i < best->h.n; i++) {
        lab_suspect s = of_row(t, null, best, i);
        s.likeness = 1.0;
        present(&s);
        o->suspect[o->nsuspect++] = s;
        o->ncause++;
    }
    qsort(o->suspect, (size_t)o->ncause, sizeof *o->suspect, by_own_gain); // the largest first
    for (int r = 0; j->finding == DIAG_NAMED && r < j->nrival; r++) {
        const diag__row *row = t->row[j->rival[r]];
        for (int i = 0; i < row->h.n; i++) {
            if (!is_listed(o, &row->cause[i])) {
                lab_suspect s = of_row(t, null, row, i);
                s.likeness = sqrt(fmax(0.0, fmin(1.0, (null->objective - row->objective) /
                                                          (null->objective - best->objective))));
                s.power = (lab_power){.presence = LAB_WEAK,
                                      .amount = s.amount,
                                      .sd = s.number[0].sd,
                                      .detectable = (sqrt(diag__least_gain) + diag__one_sided) *
                                                    s.number[0].sd,
                                      .upper = fabs(s.amount) + diag__one_sided * s.number[0].sd,
                                      .because = "it could stand in the cause's place"};
                o->suspect[o->nsuspect++] = s;
                o->nrival++;
            }
        }
    }
}

static int by_gain(const void *a, const void *b)
{
    const lab_suspect *x = a, *y = b;
    double gx = x->refitted ? x->gain : x->score, gy = y->refitted ? y->gain : y->score;
    gx = isfinite(gx) ? gx : -1e300;
    gy = isfinite(gy) ? gy : -1e300;
    return gx > gy ? -1 : gx < gy;
}

/* ---- the file's own numbers ---- */

static void note_value(const diag__problem *q, const diag__row *row, int k, lab_diagnosis *o)
{
    const stein_model *m = lab_equations(q->model);
    const fit__problem *p = &row->p;
    const fit__unknown *u = &p->unknown[k];
    int param = u->kind == FIT__PARAM
                    ? stein_find_param(m, lab_equations(p->model)->params[u->index].name)
                    : -1;
    if (param < 0) {
        return; // an amount
    }
    const stein_param *f = &m->params[param];
    double x = row->x[k], value = fit__value(u, x),
           in_sd = u->prior ? fmin(1.0, row->sd[k]) : row->sd[k],
           s = in_sd * u->sd * fabs(fit__slope(u, x));
    o->value[o->nvalue++] = (lab_fit_value){.name = f->name,
                                            .unit = f->unit,
                                            .param = param,
                                            .logarithmic = u->log,
                                            .start = f->value,
                                            .value = value,
                                            .sd = s,
                                            .lo = value - diag__interval * s,
                                            .hi = value + diag__interval * s,
                                            .prior_sd = u->sd * fabs(fit__slope(u, 0.0)),
                                            .data_sd = NAN};
}

/* settings that are off in a row, each by its RMS over the records */
static void note_settings(const diag__problem *q, const diag__row *row, lab_diagnosis *o)
{
    const stein_model *m = lab_equations(q->model);
    const fit__problem *p = &row->p;
    double square[LAB_SETTINGS_OFF] = {0.0};
    int n[LAB_SETTINGS_OFF] = {0};
    for (int k = p->np; k < p->nu; k++) {
        const fit__unknown *u = &p->unknown[k];
        int i = 0;
        if (u->kind != FIT__SETTING) {
            continue;
        }
        const char *name = lab_equations(p->model)->params[u->index].name;
        while (i < o->nsetting_off && strcmp(o->setting_off[i].name, name) != 0) {
            i++;
        }
        if (i == LAB_SETTINGS_OFF) {
            continue;
        }
        const stein_param *of = &m->params[stein_find_param(m, name)];
        o->nsetting_off += i == o->nsetting_off;
        o->setting_off[i].name = of->name;
        o->setting_off[i].unit = of->unit;
        square[i] += fit__value(u, row->x[k]) * fit__value(u, row->x[k]);
        n[i]++;
    }
    for (int i = 0; i < o->nsetting_off; i++) {
        o->setting_off[i].rms = sqrt(square[i] / n[i]);
    }
}

static stein_status note_values(const diag__problem *q, const diag__row *row, lab_diagnosis *o,
                                stein_err *err)
{
    const double prior[DIAG_CLASSES] = {q->fit_def.joint_scatter, q->fit_def.contact_scatter,
                                        q->fit_def.drive_scatter};
    o->value = calloc((size_t)row->p.np + 1, sizeof *o->value);
    if (o->value == NULL) {
        return lab__no_memory(err);
    }
    for (int k = 0; k < row->p.np; k++) {
        note_value(q, row, k, o);
    }
    note_settings(q, row, o);
    for (int i = 0; i < DIAG_CLASSES; i++) {
        o->scatter[i] = prior[i] * sqrt(row->D[i]);
    }
    return STEIN_OK;
}

/* of causes with the refitted numbers, of rivals, which have others, with the file's */
static void note_changes(const diag__problem *q, lab_diagnosis *o)
{
    for (int i = 0; i < o->ncause + o->nrival; i++) {
        lab_suspect *s = &o->suspect[i];
        for (int k = 0; k < q->n; k++) {
            const lab_candidate *c = &q->candidate[k];
            if (c->effect == s->candidate.effect && strcmp(c->place, s->candidate.place) == 0) {
                lab__note_changes(s, c, q->model, o->value, i < o->ncause ? o->nvalue : 0);
                break;
            }
        }
    }
}

stein_status diag__results(diag__problem *q, const diag__table *t, const diag__judgement *j,
                           const diag__linear *l, const diag__setting *s, lab_diagnosis *o,
                           stein_err *err)
{
    const diag__row *null = t->row[j->null], *best = t->row[j->best],
                    *end = j->finding == DIAG_NAMED ? best : null;
    (void)s;
    o->suspect = calloc((size_t)q->n + DIAG_CAUSES * (DIAG_RIVALS + 1) + 1, sizeof *o->suspect);
    if (o->suspect == NULL) {
        return lab__no_memory(err);
    }
    o->chi2_dof_before = null->chi2_dof;
    o->chi2_dof_after = best->chi2_dof;
    list_causes(t, j, o);
    int first = o->nsuspect;
    for (int k = 0; k < q->n; k++) {
        if (!is_listed(o, &q->candidate[k])) {
            o->suspect[o->nsuspect++] = other(q, t, null, l, k, o);
        }
    }
    qsort(o->suspect + first, (size_t)(o->nsuspect - first), sizeof *o->suspect, by_gain);
    stein_status status = note_values(q, end, o, err);
    if (status == STEIN_OK) {
        note_changes(q, o);
    }
    return status;
}
