/* SPDX-License-Identifier: GPL-3.0-or-later
 * posterior.c - what the next experiment starts from: all numbers of a cause or rival with their
 * joint uncertainty, and what the strokes were like.
 *
 *      cov(x) = ([F g]' V^-1 [F g] + 1)^-1
 *
 * F the parameters, g the effect's own columns, V noise, nuisances and scatter (mixed.h): the
 * intervals of the diagnosis and their correlations. Numbers that one kind of stroke does not
 * separate have wide intervals and a well known sum; without the correlations an experiment that
 * measures only that sum would seem useful.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "verdict.h"
#include "stein/plan.h"

enum { RIVALS = 2 }; // for the next experiment; stein plan takes more

static stein_status make(lab_posterior *to, int n, stein_err *err)
{
    to->number = calloc((size_t)n + 1, sizeof *to->number);
    to->correlation = calloc((size_t)(n * n) + 1, sizeof *to->correlation);
    to->n = n;
    return to->number != NULL && to->correlation != NULL ? STEIN_OK : lab__no_memory(err);
}

static void note(lab_posterior *to, const diag__row *row, const diag__local *l)
{
    const double *cov = l->cov;
    const fit__problem *p = &row->p;
    int n = to->n;
    for (int i = 0; i < n; i++) {
        const fit__unknown *u = &p->unknown[l->free[i]];
        struct lab_uncertain *q = &to->number[i];
        snprintf(q->name, sizeof q->name, "%s",
                 u->kind == FIT__PARAM ? lab_equations(p->model)->params[u->index].name
                                       : fit__number_name[1 + u->index]);
        double sd = sqrt(fmax(0.0, cov[i * n + i]));
        q->logarithmic = u->log;
        q->value = fit__value(u, row->x[l->free[i]]);
        q->sd = u->sd * (u->prior ? fmin(1.0, sd) : sd);
        for (int k = 0; k < n; k++) {
            double size = sqrt(cov[i * n + i] * cov[k * n + k]);
            to->correlation[i * n + k] = i == k ? 1.0 : size > 0.0 ? cov[i * n + k] / size : 0.0;
        }
    }
}

stein_status diag__posterior(const diag__row *row, lab_posterior *to, stein_err *err)
{
    diag__local l;
    stein_status status = diag__local_open(&l, &row->p, row->x, row->J, row->r, err);
    status = status == STEIN_OK ? make(to, l.nfree, err) : status;
    if (status == STEIN_OK) {
        memcpy(l.m.D, row->D, sizeof l.m.D);
        lab__mixed_weigh(&l.m);
        if (isfinite(lab__mixed_solve(&l.m, NULL, 0, l.beta, l.cov))) {
            note(to, row, &l);
        } else {
            to->n = 0;
        }
    }
    diag__local_close(&l);
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

static int note_stroke(lab_conditions *c, const fit__stroke *t, const stein_model *m)
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
    for (int k = 0; k < t->nsampled; k++) {
        const stein_channel *channel = &m->channels[t->channel[k]];
        lab_used *u = entry(&c->channel, &c->nchannel, channel->name, channel->unit);
        ok &= u != NULL;
        if (u != NULL) {
            double noise = t->noise[k];
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

stein_status diag__conditions(const fit__problem *p, lab_conditions *c, stein_err *err)
{
    int ok = 1;
    *c = (lab_conditions){.from = INFINITY, .until = -INFINITY, .interval = INFINITY};
    for (int s = 0; s < p->nstroke; s++) {
        const lab_data *data = p->stroke[s].data;
        double span = data->time[data->nrow - 1] - data->time[0];
        c->from = fmin(c->from, data->time[0]);
        c->until = fmax(c->until, data->time[data->nrow - 1]);
        c->interval = fmin(c->interval, span / fmax(1.0, data->nrow - 1));
        c->unsynchronised |= data->trigger == LAB_TRIGGER_UNSYNCHRONISED;
        ok &= note_stroke(c, &p->stroke[s], lab_equations(p->model));
    }
    return ok ? STEIN_OK : lab__no_memory(err);
}

stein_status diag__next(const diag__problem *q, lab_diagnosis *o, stein_err *err)
{
    lab_plan *plan = NULL;
    lab_plan_def def = lab_plan_def_default();
    stein_err why = {STEIN_OK, ""};
    def.rivals = RIVALS;
    def.quick = 1;
    def.threads = q->fit_def.threads;
    def.options = q->def->options;
    def.stop = q->def->stop;
    def.ctx = q->def->ctx;
    stein_status status = lab_plan_make(&plan, q->file, q->model, o, &def, &why);
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
