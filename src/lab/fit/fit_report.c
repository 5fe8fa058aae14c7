/* SPDX-License-Identifier: GPL-3.0-or-later
 * fit_report.c - the parts of a fit's result that are lists: names, starts, residuals, strokes.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fitting.h"

const char *lab_fit_status_text(lab_fit_status status)
{
    static const char *const text[] = {"converged", "misfit", "not_converged"};
    return text[status];
}

static void describe_value(const fit__problem *p, lab_fit_value *v, int k)
{
    const fit__unknown *u = &p->unknown[k];
    const stein_param *q = &lab_equations(p->model)->params[u->index];
    *v = (lab_fit_value){.name = q->name,
                         .unit = q->unit,
                         .param = u->index,
                         .logarithmic = u->log,
                         .start = q->value,
                         .sd = NAN,
                         .lo = NAN,
                         .hi = NAN,
                         .data_sd = NAN};
    v->prior_sd = u->prior ? u->sd * (u->log ? q->value : 1.0) : NAN;
}

/* name of a stroke's own unknown; the caller frees it */
static char *own_name(const fit__problem *p, const fit__unknown *u, const char **unit)
{
    const stein_model *m = lab_equations(p->model);
    const fit__stroke *s = &p->stroke[u->stroke];
    static const char *const group[FIT__GROUPS] = {
        "", "scatter of joint friction", "scatter of contact friction", "scatter of drive"};
    int turns =
        (u->kind == FIT__POSITION || u->kind == FIT__SPEED) && m->bodies[u->index].type == 'R';
    switch (u->kind) {
    case FIT__TAU: *unit = "s"; return lab__text("trigger");
    case FIT__OFFSET:
        *unit = m->channels[s->channel[u->index]].unit;
        return lab__text("offset %s", m->channels[s->channel[u->index]].name);
    case FIT__SCATTER: *unit = "1"; return lab__text("%s", group[fit__class(u->index)]);
    case FIT__FORCE: *unit = "1"; return lab__text("error of forces, shape %d", u->index + 1);
    case FIT__SETTING:
        *unit = m->params[u->index].unit;
        return lab__text("setting %s", m->params[u->index].name);
    case FIT__POSITION:
        *unit = turns ? "rad" : "m";
        return lab__text("initial position %s", m->bodies[u->index].name);
    default:
        *unit = turns ? "rad/s" : "m/s";
        return lab__text("initial speed %s", m->bodies[u->index].name);
    }
}

static stein_status describe_stroke(const fit__problem *p, lab_fit *fit, int s, const double *r,
                                    stein_err *err)
{
    const fit__stroke *t = &p->stroke[s];
    lab_fit_stroke *to = &fit->stroke[s];
    *to = (lab_fit_stroke){.hash = t->data->hash, .rows = t->n};
    to->file = lab__text("%s", t->data->file);
    to->value = calloc((size_t)t->own + 1, sizeof *to->value);
    if (to->file == NULL || to->value == NULL) {
        return lab__no_memory(err);
    }
    for (int i = 0; i < t->nch * t->n; i++) {
        double ri = r[fit__offset(p, s) + (size_t)i];
        to->chi2 += ri * ri;
    }
    for (int k = 0; k < t->own; k++) {
        const fit__unknown *u = &p->unknown[t->first + k];
        lab_fit_value *v = &to->value[to->nvalue++];
        *v = (lab_fit_value){.param = -1,
                             .logarithmic = u->log,
                             .start = fit__value(u, 0.0),
                             .prior_sd = u->prior ? u->sd : NAN,
                             .sd = NAN,
                             .lo = NAN,
                             .hi = NAN,
                             .data_sd = NAN};
        v->name = own_name(p, u, &v->unit);
        if (v->name == NULL) {
            return lab__no_memory(err);
        }
    }
    return STEIN_OK;
}

static void describe_residual(const fit__problem *p, lab_fit *fit, int s, int c, const double *r)
{
    const stein_model *m = lab_equations(p->model);
    const fit__stroke *t = &p->stroke[s];
    lab_fit_residual *to = &fit->residual[fit->nresidual++];
    *to = (lab_fit_residual){.stroke = s,
                             .channel = t->event[c].is ? t->event[c].name
                                                       : m->channels[t->channel[c]].name,
                             .unit = m->channels[t->channel[c]].unit,
                             .noise = t->noise[c],
                             .noise_given = t->given[c],
                             .audited = t->audited[c]};
    double sum = 0.0, size = 0.0;
    r += fit__offset(p, s);
    for (int i = c * t->n; i < (c + 1) * t->n; i++) {
        if (!isfinite(t->y[i])) {
            continue;
        }
        double w = t->weight != NULL ? t->weight[i] : 1.0, all = fit__weight(t, i);
        double plain = all > 0.0 ? r[i] / all : 0.0; // without weight it is not counted
        to->downweighted += w * w < 0.5;
        to->samples += all > 0.0;
        sum += plain * plain;
        size += all > 0.0 ? t->y[i] * t->y[i] : 0.0;
    }
    to->rms = to->noise * sqrt(sum / fmax(1.0, to->samples));
    to->relative = size > 0.0 ? to->noise * sqrt(sum / size) : 0.0;
    fit->noise_given &= to->noise_given;
}

static stein_status make_lists(const fit__problem *p, lab_fit *fit, stein_err *err)
{
    size_t np = (size_t)p->np, residuals = 0;
    for (int s = 0; s < p->nstroke; s++) {
        residuals += (size_t)p->stroke[s].nch;
    }
    fit->value = calloc(np + 1, sizeof *fit->value);
    fit->weakest = calloc(np + 1, sizeof *fit->weakest);
    fit->covariance = calloc(np * np + 1, sizeof *fit->covariance);
    fit->stroke = calloc((size_t)p->nstroke + 1, sizeof *fit->stroke);
    fit->residual = calloc(residuals + 1, sizeof *fit->residual);
    return fit->value && fit->weakest && fit->covariance && fit->stroke && fit->residual
               ? STEIN_OK
               : lab__no_memory(err);
}

static stein_status count_lacking(const fit__problem *p, lab_fit *fit, const double *x,
                                  stein_err *err)
{
    int *lacking = calloc((size_t)p->nstroke + 1, sizeof *lacking);
    stein_status status = lacking != NULL ? fit__lacking(p, x, lacking, err) : lab__no_memory(err);
    for (int s = 0; status == STEIN_OK && s < p->nstroke; s++) {
        fit->stroke[s].lacking = lacking[s];
    }
    free(lacking);
    return status;
}

stein_status fit__describe(const fit__problem *p, lab_fit *fit, const double *x, const double *r,
                           stein_err *err)
{
    stein_status status = make_lists(p, fit, err);
    if (status != STEIN_OK) {
        return status;
    }
    fit->noise_given = 1;
    for (int k = 0; k < p->np; k++) {
        describe_value(p, &fit->value[fit->nvalue++], k);
    }
    for (int s = 0; status == STEIN_OK && s < p->nstroke; s++) {
        fit->nstroke++;
        status = describe_stroke(p, fit, s, r, err);
        for (int c = 0; c < p->stroke[s].nch; c++) {
            describe_residual(p, fit, s, c, r);
        }
    }
    status = status == STEIN_OK ? count_lacking(p, fit, x, err) : status;
    fit->chi2 = fit__chi2(p, r);
    fit->prior = fit__priors(p, x);
    fit->samples = p->samples;
    return status;
}

void lab_fit_destroy(lab_fit *fit)
{
    if (fit == NULL) {
        return;
    }
    for (int s = 0; s < fit->nstroke; s++) {
        for (int k = 0; k < fit->stroke[s].nvalue; k++) {
            free((char *)fit->stroke[s].value[k].name);
        }
        free(fit->stroke[s].value);
        free((char *)fit->stroke[s].file);
    }
    free(fit->value);
    free(fit->weakest);
    free(fit->covariance);
    free(fit->stroke);
    free(fit->residual);
    free(fit->pair);
    free(fit);
}

void lab_fit_apply(const lab_fit *fit, double *p)
{
    for (int k = 0; k < fit->nvalue; k++) {
        p[fit->value[k].param] = fit->value[k].value;
    }
}
