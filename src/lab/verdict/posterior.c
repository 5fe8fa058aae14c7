/* SPDX-License-Identifier: GPL-3.0-or-later
 * posterior.c - what the next experiment starts from: all numbers of a cause or rival with their
 * joint uncertainty, and what the strokes were like.
 *
 *      cov(x) = ([F g]' V^-1 [F g] + 1)^-1
 *
 * F the parameters, g the effect's own columns, V noise, nuisances and scatter (mixed.h): the
 * intervals of the diagnosis and their correlations. Numbers that one kind of stroke does not
 * separate have wide intervals and a well known sum; without the correlations an experiment that
 * measures only that sum would seem useful. The candidates of a hypothesis are fitted together, so
 * each posterior has the numbers of all of them, its own candidate's first.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "verdict.h"
#include "stein/plan.h"

enum { RIVALS = 2 }; // for the next experiment; stein plan takes more

void diag__number_name(char to[LAB_PLACE], int place, int index)
{
    if (place == 0) {
        snprintf(to, LAB_PLACE, "%s", fit__number_name[index]);
    } else {
        snprintf(to, LAB_PLACE, "%s_%d", fit__number_name[index], 1 + place);
    }
}

int diag__find_number(const char *name, int *place, int *index)
{
    char text[LAB_PLACE];
    for (int i = 0; i < DIAG_CAUSES * FIT__NUMBERS; i++) {
        *place = i / FIT__NUMBERS;
        *index = i % FIT__NUMBERS;
        diag__number_name(text, *place, *index);
        if (strcmp(text, name) == 0) {
            return 1;
        }
    }
    return 0;
}

static stein_status make(lab_posterior *to, int n, int beside, stein_err *err)
{
    to->number = calloc((size_t)n + 1, sizeof *to->number);
    to->correlation = calloc((size_t)(n * n) + 1, sizeof *to->correlation);
    to->beside = calloc((size_t)beside + 1, sizeof *to->beside);
    to->n = n;
    return to->number != NULL && to->correlation != NULL && to->beside != NULL
               ? STEIN_OK
               : lab__no_memory(err);
}

/* the other candidates of the row, as the file's own model has them */
static void note_beside(lab_posterior *to, const diag__row *row, int own)
{
    for (int i = 0; i < row->h.n; i++) {
        if (i != own) {
            to->beside[to->nbeside++] = row->cause[i];
        }
    }
}

static void note(lab_posterior *to, const diag__row *row, int own, const diag__local *l)
{
    const double *cov = l->cov;
    const fit__problem *p = &row->p;
    int n = to->n;
    for (int i = 0; i < n; i++) {
        const fit__unknown *u = &p->unknown[l->free[i]];
        struct lab_uncertain *q = &to->number[i];
        if (u->kind == FIT__PARAM) {
            snprintf(q->name, sizeof q->name, "%s", lab_equations(p->model)->params[u->index].name);
        } else {
            int of = (l->free[i] - p->first_accepted) / FIT__NUMBERS;
            diag__number_name(q->name, of == own ? 0 : of < own ? of + 1 : of, 1 + u->index);
        }
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

stein_status diag__posterior(const diag__row *row, int i, lab_posterior *to, stein_err *err)
{
    diag__local l;
    stein_status status = diag__local_open(&l, &row->p, row->x, row->J, row->r, err);
    status = status == STEIN_OK ? make(to, l.nfree, row->h.n - 1, err) : status;
    if (status == STEIN_OK) {
        note_beside(to, row, i);
        memcpy(l.m.D, row->D, sizeof l.m.D);
        lab__mixed_weigh(&l.m);
        if (isfinite(lab__mixed_solve(&l.m, NULL, 0, l.beta, l.cov))) {
            note(to, row, i, &l);
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

static int is_stated(const lab_data *data, const char *name)
{
    int yes = 0;
    for (int i = 0; i < data->nset; i++) {
        yes |= strcmp(data->set[i].name, name) == 0;
    }
    return yes;
}

/* Where and how fast the joints were let go, as the fit has estimated it from records that do not
 * state it: without it an experiment would begin at rest, where a pendulum stays. */
static int note_starts(lab_conditions *c, const diag__row *row, const lab_model *model)
{
    const stein_model *m = lab_equations(model);
    const fit__problem *p = &row->p;
    int ok = 1;
    for (int k = p->np; ok && k < p->nu && !m->settle && m->nloop == 0; k++) {
        const fit__unknown *u = &p->unknown[k];
        char name[2 * LAB_PLACE];
        if (u->stroke < 0 || (u->kind != FIT__POSITION && u->kind != FIT__SPEED)) {
            continue;
        }
        snprintf(name, sizeof name, "%.100s.initial.%s",
                 lab_equations(p->model)->bodies[u->index].name,
                 u->kind == FIT__POSITION ? "position" : "speed");
        int param = stein_find_param(m, name);
        if (param < 0 || strlen(name) >= LAB_PLACE || is_stated(p->stroke[u->stroke].data, name)) {
            continue;
        }
        lab_used *to = entry(&c->setting, &c->nsetting, name, m->params[param].unit);
        ok = to != NULL;
        if (ok) {
            widen(to, lab_parameters(model)[param] + fit__value(u, row->x[k]));
        }
    }
    return ok;
}

stein_status diag__conditions(const fit__problem *p, const diag__row *row, lab_conditions *c,
                              stein_err *err)
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
    ok = ok && (row == NULL || row->failed != NULL || note_starts(c, row, p->model));
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
        free(o->suspect[i].posterior.beside);
    }
    free(o->conditions.channel);
    free(o->conditions.input);
    free(o->conditions.setting);
    free(o->next);
}
