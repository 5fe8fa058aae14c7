/* SPDX-License-Identifier: GPL-3.0-or-later
 * note.c - the numbers of a diagnosis: causes, rivals, all other suspects, and the file's own.
 *
 * Causes have their numbers from where all of them act, rivals and others from the search in which
 * they were fitted. Where nobody stated the noise all intervals are wider by
 * sqrt(chi2/dof * memory) (diag__excess).
 */
#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "searching.h"

static const double normal95 = 1.96;

/* Half a 95 % interval [sd]. Where strokes differ by themselves, how much they do is estimated from
 * them: Student's t. */
static double half_interval(const fit__problem *p)
{
    const fit__stroke *t = &p->stroke[0];
    int differ = 0;
    for (int k = 0; k < t->own; k++) {
        differ |= p->unknown[t->first + k].kind == FIT__SCATTER;
    }
    return differ && p->nstroke > 1 ? gsl_cdf_tdist_Pinv(0.975, p->nstroke - 1) : normal95;
}

static lab_cause_number *next_number(lab_suspect *to, const char *name, const char *unit)
{
    lab_cause_number *n = &to->number[to->nnumber++];
    snprintf(n->name, sizeof n->name, "%s", name);
    n->unit = unit;
    return n;
}

/* amount and the numbers beside it at x, with deviations sd; u: their unknowns */
static void note_numbers(const fit__problem *p, lab_suspect *s, const fit__unknown *u,
                         const double *x, const double *sd, double wide)
{
    const lab_candidate *c = &s->candidate;
    double half = half_interval(p);
    s->nnumber = 0;
    s->amount = x[0] * c->limit;
    lab_cause_number *n = next_number(s, c->effect->size, c->unit);
    n->value = s->amount;
    n->sd = wide * sd[0] * c->limit;
    n->lo = n->value - half * n->sd;
    n->hi = n->value + half * n->sd;
    for (int k = 0; k < LAB_SIDES && c->side[k].param >= 0; k++) {
        double own = fmin(1.0, wide * sd[1 + k]), at = x[1 + k];
        n = next_number(s, c->side[k].name, c->side[k].unit);
        n->value = fit__value(&u[1 + k], at);
        n->sd = 0.5 * fabs(fit__value(&u[1 + k], at + own) - fit__value(&u[1 + k], at - own));
        n->lo = fit__value(&u[1 + k], at - half * own);
        n->hi = fit__value(&u[1 + k], at + half * own);
    }
}

/* a suspect of the search that has fitted it */
static void note_suspect(diag *d, diag__suspect *s)
{
    fit__problem *p = diag__problem(d, s);
    double gain = s->s.refitted ? s->s.gain : s->s.score, most = d->suspect[0].s.gain;
    s->s.likeness = most > 0.0 && gain > 0.0 ? fmin(1.0, sqrt(gain / most)) : 0.0;
    if (!s->s.refitted || !isfinite(s->objective)) {
        return;
    }
    diag__numbers told = diag__numbers_of(d, s);
    fit__problem_try(p, &s->s.candidate);
    note_numbers(p, &s->s, &p->unknown[p->amount], told.x + p->amount, told.sd + p->amount,
                 sqrt(diag__excess(d, s)));
    fit__problem_try(p, NULL);
}

static void note_cause(const diag *d, diag__found *f, int i)
{
    lab_suspect *s = &f->cause[i];
    double x[FIT__NUMBERS], sd[FIT__NUMBERS];
    const fit__unknown *u = diag__amount(f, i, x, sd);
    note_numbers(&d->p, s, u, x, sd, sqrt(f->excess));
    diag__present(d, s, sqrt(f->excess) * sd[0] * s->candidate.limit, f->excess);
    s->likeness = 1.0;
    s->chi2_dof = f->chi2_dof;
    s->held_out = f->held.rmse;
}

/* ---- the list ---- */

static int is_listed(const lab_diagnosis *o, const lab_suspect *s)
{
    for (int i = 0; i < o->nsuspect; i++) {
        const lab_candidate *c = &o->suspect[i].candidate;
        if (diag__is_same(c, &s->candidate)) {
            return 1;
        }
    }
    return 0;
}

/* Its numbers where they were found. In the search they stay where they begin: x counts from there.
 */
static void list(lab_diagnosis *o, const lab_suspect *s)
{
    lab_suspect *to = &o->suspect[o->nsuspect++];
    *to = *s;
    for (int k = 1; k < to->nnumber; k++) {
        to->candidate.side[k - 1].value = to->number[k].value;
    }
}

/* those of the search that has found a cause which the data cannot tell from it */
static void list_rivals(lab_diagnosis *o, const diag *d)
{
    int n = diag__rivals(d);
    for (int i = 1; i <= n; i++) {
        if (!is_listed(o, &d->suspect[i].s)) {
            list(o, &d->suspect[i].s);
            o->nrival++;
        }
    }
}

static stein_status note_suspects(diag *d, diag__found *f, stein_err *err)
{
    lab_diagnosis *o = d->out;
    o->suspect = calloc((size_t)(d->n * (f->n + 1)) + FIT__ACCEPTED, sizeof *o->suspect);
    if (o->suspect == NULL) {
        return lab__no_memory(err);
    }
    o->ncause = f->n;
    for (int i = 0; i < f->n; i++) {
        note_cause(d, f, i);
        list(o, &f->cause[i]);
    }
    for (int k = -1; k < f->nstage; k++) {
        diag *stage = k < 0 ? d : f->stage[k];
        for (int i = 0; i < stage->n; i++) {
            note_suspect(stage, &stage->suspect[i]);
        }
    }
    for (int i = 0; i < f->n; i++) {
        list_rivals(o, f->from[i]);
    }
    const diag *last = f->n > 0 ? f->from[f->n - 1] : d;
    for (int i = 0; i < last->n; i++) {
        if (!is_listed(o, &last->suspect[i].s)) {
            list(o, &last->suspect[i].s);
        }
    }
    o->p = d->p_value;
    return STEIN_OK;
}

/* ---- the file's own numbers ---- */

void diag__note_value(diag *d, const fit__problem *p, int k, double x, double sd, double wide)
{
    lab_diagnosis *o = d->out;
    const stein_model *m = lab_equations(d->model);
    const fit__unknown *u = &p->unknown[k];
    int param = u->kind == FIT__PARAM
                    ? stein_find_param(m, lab_equations(p->model)->params[u->index].name)
                    : -1;
    if (param < 0) {
        return; // an amount, or the part's own
    }
    const stein_param *q = &m->params[param];
    double value = fit__value(u, x), in_sd = u->prior ? fmin(1.0, wide * sd) : wide * sd;
    double s = in_sd * u->sd * fabs(fit__slope(u, x));
    o->value[o->nvalue++] = (lab_fit_value){.name = q->name,
                                            .unit = q->unit,
                                            .param = param,
                                            .logarithmic = u->log,
                                            .start = q->value,
                                            .value = value,
                                            .sd = s,
                                            .lo = value - normal95 * s,
                                            .hi = value + normal95 * s,
                                            .prior_sd = u->sd * fabs(fit__slope(u, 0.0)),
                                            .data_sd = NAN};
}

void diag__note_scatter(diag *d, const double *D)
{
    const double prior[DIAG_CLASSES] = {d->fit_def.joint_scatter, d->fit_def.contact_scatter,
                                        d->fit_def.drive_scatter};
    for (int i = 0; i < DIAG_CLASSES; i++) {
        d->out->scatter[i] = prior[i] * sqrt(D[i]);
    }
}

/* as they are where the causes act, or without any */
static stein_status note_values(diag *d, const diag__found *f, stein_err *err)
{
    lab_diagnosis *o = d->out;
    diag__suspect *s = f->n > 0 ? f->leader : NULL;
    diag *end = f->n > 0 ? f->end : d;
    const fit__problem *p = s != NULL ? diag__problem(end, s) : &end->p;
    diag__numbers told = {end->x, end->sd, end->J, end->null_D};
    if (s != NULL) {
        told = diag__numbers_of(end, s);
    }
    o->value = calloc((size_t)p->np + 1, sizeof *o->value);
    if (o->value == NULL) {
        return lab__no_memory(err);
    }
    for (int k = 0; k < p->np; k++) {
        diag__note_value(d, p, k, told.x[k], told.sd[k], f->n > 0 ? sqrt(f->excess) : 1.0);
    }
    diag__note_scatter(d, told.D);
    return STEIN_OK;
}

stein_status diag__note(diag *d, diag__found *f, stein_err *err)
{
    stein_status status = note_suspects(d, f, err);
    // a law that was recovered has its own (curve.c)
    return status == STEIN_OK && d->out->value == NULL ? note_values(d, f, err) : status;
}
