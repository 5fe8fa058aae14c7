/* SPDX-License-Identifier: GPL-3.0-or-later
 * posterior.c - what the next experiment starts from: all numbers of a cause or rival with their
 * joint uncertainty, and what the strokes were like.
 *
 *      cov(x) = ([F g]' V^-1 [F g] + 1)^-1
 *
 * F the parameters, g the effect's own columns, V noise, nuisances and scatter (mixed.h): the
 * intervals of the diagnosis with what they leave out, their correlations. Numbers that one kind of
 * stroke cannot tell apart have wide intervals and a narrow sum; without it an experiment that
 * measures that sum once more would look worth its time.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "searching.h"
#include "stein/plan.h"

enum { RIVALS = 2 }; // for the next experiment; stein plan takes more

static stein_status make(lab_posterior *to, int n, stein_err *err)
{
    to->number = calloc((size_t)n + 1, sizeof *to->number);
    to->correlation = calloc((size_t)(n * n) + 1, sizeof *to->correlation);
    to->n = n;
    return to->number != NULL && to->correlation != NULL ? STEIN_OK : lab__no_memory(err);
}

static void note(lab_posterior *to, const double *x, const fit__problem *p, const diag__local *l,
                 double wide)
{
    const double *cov = l->cov;
    int n = to->n;
    for (int i = 0; i < n; i++) {
        int at = diag__unknown_of(l, i);
        const fit__unknown *u = &p->unknown[at];
        struct lab_uncertain *q = &to->number[i];
        snprintf(q->name, sizeof q->name, "%s",
                 u->kind == FIT__PARAM ? lab_equations(p->model)->params[u->index].name
                                       : fit__number_name[1 + u->index]);
        double sd = sqrt(fmax(0.0, wide * cov[i * n + i]));
        q->logarithmic = u->log;
        q->value = fit__value(u, x[at]);
        q->sd = u->sd * (u->prior ? fmin(1.0, sd) : sd);
        for (int k = 0; k < n; k++) {
            double size = sqrt(cov[i * n + i] * cov[k * n + k]);
            to->correlation[i * n + k] = i == k ? 1.0 : size > 0.0 ? cov[i * n + k] / size : 0.0;
        }
    }
}

static stein_status posterior(diag *d, diag__suspect *s, lab_posterior *to, stein_err *err)
{
    fit__problem *p = diag__problem(d, s);
    const diag__numbers told = diag__numbers_of(d, s);
    diag__local l;
    fit__problem_try(p, &s->s.candidate);
    stein_status status = diag__local_open(&l, p, told.x, told.J, s->r, err);
    status = status == STEIN_OK ? make(to, l.nfree + l.n, err) : status;
    if (status == STEIN_OK) {
        memcpy(l.m.D, told.D, sizeof l.m.D);
        lab__mixed_weigh(&l.m);
        if (isfinite(lab__mixed_solve(&l.m, l.with, l.n, l.beta, l.cov))) {
            note(to, told.x, p, &l, diag__excess(d, s));
        } else {
            to->n = 0;
        }
    }
    diag__local_close(&l);
    fit__problem_try(p, NULL);
    return status;
}

/* Derivatives that a width can be made of. A search has one-sided ones of coarse steps: where two
 * unknowns change nearly the same - the mass of the load, and what the drive of every stroke
 * differs by - the roughness of their columns looks like knowledge that tells them apart. */
static stein_status renew(diag *d, diag__suspect *s, stein_err *err)
{
    fit__problem *p = diag__problem(d, s);
    stein_err why = {STEIN_OK, ""};
    double *step = malloc(sizeof *step * (size_t)(p->nu + 1));
    if (step == NULL) {
        return lab__no_memory(err);
    }
    memcpy(step, p->step, sizeof *step * (size_t)p->nu);
    p->central = 1;
    fit__problem_try(p, &s->s.candidate);
    fit__choose_steps(p, s->J);
    stein_status status = fit__sensitivities(p, s->x, s->r, s->J, &why);
    fit__problem_try(p, NULL);
    memcpy(p->step, step, sizeof *step * (size_t)p->nu);
    p->central = 0;
    free(step);
    return fit__forgive(status, err);
}

stein_status diag__widths(diag *d, stein_err *err)
{
    stein_status status = STEIN_OK;
    int n = d->n > 0 ? 1 + diag__rivals(d) : 0;
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        diag__suspect *s = &d->suspect[i];
        double D[LAB_SCATTERS];
        if (s->J == NULL) {
            continue;
        }
        status = i <= LAB_PLAN_RIVALS ? renew(d, s, err) : STEIN_OK;
        fit__problem *p = diag__problem(d, s);
        fit__problem_try(p, &s->s.candidate);
        if (status == STEIN_OK) {
            status = diag__likelihood(p, s->x, s->J, s->r, D, s->sd, NULL, NULL, err);
        }
        fit__problem_try(p, NULL);
    }
    return status;
}

/* ---- what the strokes were like ---- */

/* the entry of that name, a new one if need be. @return NULL: out of memory */
static lab_used *entry(lab_used **list, int *n, const char *name, const char *unit)
{
    for (int i = 0; i < *n; i++) {
        if (strcmp((*list)[i].name, name) == 0) {
            return &(*list)[i];
        }
    }
    lab_used *more = realloc(*list, sizeof *more * (size_t)(*n + 1));
    if (more == NULL) {
        return NULL;
    }
    *list = more;
    more[*n] = (lab_used){.unit = unit, .lo = INFINITY, .hi = -INFINITY, .noise = NAN};
    snprintf(more[*n].name, sizeof more->name, "%s", name);
    return &more[(*n)++];
}

static void widen(lab_used *u, double value)
{
    u->lo = fmin(u->lo, value);
    u->hi = fmax(u->hi, value);
}

static int note_stroke(lab_conditions *c, const fit__stroke *t, const stein_model *m, double excess)
{
    const lab_data *data = t->data;
    int ok = 1;
    for (int i = 0; i < data->nset; i++) {
        const lab_setting *s = &data->set[i];
        lab_used *u = entry(&c->setting, &c->nsetting, s->name, m->params[s->param].unit);
        ok &= u != NULL;
        if (u != NULL) {
            widen(u, s->value);
        }
    }
    for (int i = 0; i < data->ncolumn; i++) {
        const lab_column *k = &data->column[i];
        lab_used *u = k->role == LAB_INPUT ? entry(&c->input, &c->ninput, k->name, k->unit) : NULL;
        ok &= u != NULL || k->role != LAB_INPUT;
        for (int a = 0; u != NULL && a < data->nrow; a++) {
            if (k->present[a]) {
                widen(u, k->value[a]);
            }
        }
    }
    for (int k = 0; k < t->nch; k++) {
        const stein_channel *channel = &m->channels[t->channel[k]];
        lab_used *u = entry(&c->channel, &c->nchannel, channel->name, channel->unit);
        ok &= u != NULL;
        if (u != NULL) {
            double noise = t->noise[k] * (t->given[k] ? 1.0 : sqrt(excess));
            u->noise = isfinite(u->noise) ? fmax(u->noise, noise) : noise;
            for (int i = 0; i < t->n; i++) {
                if (isfinite(t->y[k * t->n + i])) {
                    widen(u, t->y[k * t->n + i]);
                }
            }
        }
    }
    return ok;
}

static stein_status conditions(diag *d, double excess, stein_err *err)
{
    lab_conditions *c = &d->out->conditions;
    int ok = 1;
    *c = (lab_conditions){.from = INFINITY, .until = -INFINITY, .interval = INFINITY};
    for (int s = 0; s < d->p.nstroke; s++) {
        const lab_data *data = d->p.stroke[s].data;
        double span = data->time[data->nrow - 1] - data->time[0];
        c->from = fmin(c->from, data->time[0]);
        c->until = fmax(c->until, data->time[data->nrow - 1]);
        c->interval = fmin(c->interval, span / fmax(1.0, data->nrow - 1));
        c->unsynchronised |= data->trigger == LAB_TRIGGER_UNSYNCHRONISED;
        ok &= note_stroke(c, &d->p.stroke[s], lab_equations(d->model), excess);
    }
    return ok ? STEIN_OK : lab__no_memory(err);
}

stein_status diag__posteriors(diag *d, int alone, stein_err *err)
{
    lab_diagnosis *o = d->out;
    stein_status status = conditions(d, o->ncause > 0 ? diag__excess(d, &d->suspect[0]) : 1.0, err);
    for (int i = 0; alone && status == STEIN_OK && i < 1 + o->nrival; i++) {
        if (d->suspect[i].J != NULL) {
            status = posterior(d, &d->suspect[i], &o->suspect[i].posterior, err);
        }
    }
    return status;
}

stein_status diag__next(diag *d, stein_err *err)
{
    lab_diagnosis *o = d->out;
    lab_plan *plan = NULL;
    lab_plan_def def = lab_plan_def_default();
    stein_err why = {STEIN_OK, ""};
    def.rivals = RIVALS;
    def.quick = 1;
    def.threads = d->fit_def.threads;
    def.options = d->def->options;
    stein_status status = lab_plan_make(&plan, d->file, d->model, o, &def, &why);
    if (status == STEIN_OK && plan->n > 0 && plan->experiment[0].feasible) {
        o->strokes_simulated += plan->strokes;
        o->next = malloc(sizeof *o->next);
        if (o->next != NULL) {
            *o->next = plan->experiment[0];
        } else {
            status = STEIN_ENOMEM;
        }
    }
    lab_plan_destroy(plan);
    return fit__forgive(status, err);
}

void diag__posteriors_free(lab_diagnosis *o)
{
    for (int i = 0; o->suspect != NULL && i < o->nsuspect; i++) {
        free(o->suspect[i].posterior.number);
        free(o->suspect[i].posterior.correlation);
    }
    free(o->conditions.channel);
    free(o->conditions.input);
    free(o->conditions.setting);
    free(o->next);
}
