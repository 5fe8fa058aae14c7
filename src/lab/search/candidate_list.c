/* SPDX-License-Identifier: GPL-3.0-or-later
 * candidate_list.c - what may explain the records of a diagnosis.
 *
 * Candidates are those of the mechanism (effects/candidates.c) and, behind them, the settings that
 * records state, of which one record may be wrong. They are numbered once; a hypothesis names them
 * by number.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "search.h"
#include "added_parts.h"

static const double nothing = 1e-300; /* of a friction */
static const double of_stated = 0.1;  /* its size: plausible error where all records state one */

stein_status diag__check_without(const lab_diagnose_def *def, stein_err *err)
{
    int n;
    const lab_effect *e = lab_effects(&n);
    for (int i = 0; i < def->nwithout; i++) {
        int any = 0;
        for (int k = 0; k < n; k++) {
            any |= lab_effect_is(&e[k], def->without[i]);
        }
        if (!any) {
            return lab__fail(err, STEIN_ENAME,
                             "no effect is called \"%s\" by kind, site or class: nothing to go "
                             "without",
                             def->without[i]);
        }
    }
    return STEIN_OK;
}

static int is_left_out(const diag__problem *q, const lab_candidate *c)
{
    int out = 0;
    for (int i = 0; i < q->def->nwithout; i++) {
        out |= lab_effect_is(c->effect, q->def->without[i]);
    }
    return out;
}

/* Does a record say how the motion goes on, where the file's own run does not? It prescribes a
 * motion, or begins in a state of its own or in one that was set. */
static int go_elsewhere(const fit__problem *p)
{
    const stein_model *m = lab_equations(p->model);
    const fit__stroke *s = &p->stroke[0];
    int yes = 0;
    for (int k = 0; k < s->nsignal; k++) {
        yes |= m->inputs[s->signal[k].input].kind == STEIN_INPUT_MOTION;
    }
    for (int k = s->first; k < s->first + s->own; k++) {
        yes |= p->unknown[k].kind == FIT__POSITION;
    }
    for (int k = 0; k < s->data->nset; k++) {
        yes |= strstr(m->params[s->data->set[k].param].name, ".initial.") != NULL;
    }
    return yes;
}

typedef struct viewer {
    stein_status (*look)(void *watch, stein_sim *sim);
    void *watch;
} viewer;

static void show(void *ctx, stein_sim *sim, int i)
{
    viewer *v = ctx;
    (void)i;
    v->look(v->watch, sim);
}

/* all records, held near the data */
static stein_status run_records(void *ctx, stein_status (*look)(void *watch, stein_sim *sim),
                                void *watch, stein_err *err)
{
    const diag__problem *q = ctx;
    fit__problem p = q->null;
    fit__bench bench;
    viewer v = {look, watch};
    p.gain = diag__rung[0];
    double *y = malloc(sizeof *y * ((size_t)p.rows + 1)), *x = calloc((size_t)p.nu + 1, sizeof *x);
    stein_status status = fit__bench_make(&bench, &p, err);
    if (status == STEIN_OK && (y == NULL || x == NULL)) {
        status = lab__no_memory(err);
    }
    bench.watch = show;
    bench.watch_ctx = &v;
    for (int s = 0; status == STEIN_OK && s < p.nstroke; s++) {
        status = fit__simulate(&p, &bench, s, x, y, err);
    }
    bench.watch = NULL;
    fit__bench_free(&bench);
    free(x);
    free(y);
    return status;
}

static int measures(const fit__problem *p, int channel)
{
    for (int s = 0; s < p->nstroke; s++) {
        for (int c = 0; c < p->stroke[s].nch; c++) {
            if (p->stroke[s].channel[c] == channel) {
                return 1;
            }
        }
    }
    return 0;
}

static int has_input(const fit__problem *p, const char *name)
{
    const stein_model *m = lab_equations(p->model);
    for (int s = 0; s < p->nstroke; s++) {
        for (int k = 0; k < p->stroke[s].nsignal; k++) {
            if (strcmp(m->inputs[p->stroke[s].signal[k].input].name, name) == 0) {
                return 1;
            }
        }
    }
    return 0;
}

/* were all its numbers measured by themselves, for every record? */
static int is_known(const diag__problem *q, const lab_candidate *c)
{
    int known = c->effect->needs == NULL && c->nparam > 0;
    for (int k = 0; known && k < c->nparam; k++) {
        known = fit__always_known(q->fitted, c->param[k]);
    }
    return known;
}

/* was every record made without the part that it supposes? */
static int was_off(const diag__problem *q, const lab_candidate *c)
{
    char name[LAB_NUMBERS][LAB_PLACE];
    int n = 0;
    lab__structure_names(c, name);
    while (n < q->fitted->n && lab_data_without(q->fitted->stroke[n], name[0])) {
        n++;
    }
    return n > 0 && n == q->fitted->n;
}

static const char *untestable(const diag__problem *q, const lab_candidate *c)
{
    if (c->channel >= 0 && !measures(&q->null, c->channel)) {
        return "the channel was not measured";
    }
    if (c->effect->site == LAB_AT_INPUT && !has_input(&q->null, c->place)) {
        return "the input was not used";
    }
    if (is_known(q, c)) {
        return "every record states it";
    }
    if (was_off(q, c)) {
        return "every record was made without it";
    }
    if (strcmp(c->effect->kind, "sensor_offset") == 0 &&
        lab_equations(q->model)->channels[c->channel].read == STEIN_READ_INPUT_FORCE) {
        return "a preload says the same";
    }
    for (int i = 0; i < q->def->nfree; i++) {
        if (c->effect->site == LAB_AT_PARAMETER && strcmp(q->def->free[i], c->place) == 0) {
            return "it is refitted anyhow";
        }
    }
    return NULL;
}

/* The file's numbers, and a very small value of each number that an effect may be a share of. So a
 * share of a friction that the search finds is a candidate beside it. @return freed by the caller;
 * NULL: no memory
 */
static double *with_shares(const diag__problem *q)
{
    static const char *const of[] = {".damping", ".coulomb.T"};
    const stein_model *m = lab_equations(q->model);
    double *p = malloc(sizeof *p * ((size_t)m->np + 1));
    for (int i = 0; p != NULL && i < m->np; i++) {
        size_t n = strlen(m->params[i].name);
        p[i] = lab_parameters(q->model)[i];
        for (size_t k = 0; k < sizeof of / sizeof *of; k++) {
            size_t end = strlen(of[k]);
            int is = n > end && strcmp(m->params[i].name + n - end, of[k]) == 0;
            p[i] = is ? fmax(p[i], nothing) : p[i];
        }
    }
    return p;
}

/* smallest and largest value of a setting over the records. @return how many state it, the
 * instruments that were put right left out: nothing acts on top of those */
static int range_of_setting(const lab_dataset *data, int param, double *lo, double *hi)
{
    int n = 0;
    *lo = INFINITY;
    *hi = -INFINITY;
    for (int s = 0; s < data->n; s++) {
        for (int k = 0; k < data->stroke[s]->nset; k++) {
            const lab_setting *set = &data->stroke[s]->set[k];
            if (set->param == param && !set->last_word) {
                *lo = fmin(*lo, set->value);
                *hi = fmax(*hi, set->value);
                n++;
            }
        }
    }
    return n;
}

/* A setting is off by as much as settings differ: somebody took one record's for another's. */
static lab_candidate setting(const stein_model *m, const lab_effect *effect, int param, double lo,
                             double hi)
{
    double size = fmax(fabs(lo), fabs(hi));
    lab_candidate c = {.effect = effect,
                       .move = LAB_MOVE_ADD,
                       .nparam = 1,
                       .param = {param},
                       .unit = m->params[param].unit,
                       .limit = fmax(hi - lo, of_stated * size),
                       .start = 0.01,
                       .joint = -1,
                       .channel = -1};
    for (int k = 0; k < LAB_SIDES; k++) {
        c.side[k].param = -1;
    }
    snprintf(c.place, sizeof c.place, "%s", m->params[param].name);
    return c;
}

/* behind the candidates: what the records state, of which one record may be wrong */
static stein_status list_settings(diag__problem *q, stein_err *err)
{
    const stein_model *m = lab_equations(q->model);
    const lab_effect *effect = lab_effect_find("wrong_setting");
    double lo, hi;
    for (int s = 0; s < q->fitted->n; s++) {
        int number = q->fitted->stroke[s]->number;
        q->records = number > q->records ? number : q->records;
    }
    for (int i = 0; i < m->np; i++) {
        if (range_of_setting(q->fitted, i, &lo, &hi) == 0 || !(fmax(fabs(lo), fabs(hi)) > 0.0)) {
            continue;
        }
        lab_candidate *more =
            realloc(q->candidate, sizeof *more * ((size_t)q->n + (size_t)q->nsetting + 1));
        if (more == NULL) {
            return lab__no_memory(err);
        }
        q->candidate = more;
        more[q->n + q->nsetting] = setting(m, effect, i, lo, hi);
        q->nsetting += !is_left_out(q, &more[q->n + q->nsetting]);
    }
    return STEIN_OK;
}

stein_status diag__list_candidates(diag__problem *q, stein_err *err)
{
    lab__strokes records = {run_records, q};
    int elsewhere = go_elsewhere(&q->null), left = 0;
    double *p = with_shares(q);
    stein_status status = p != NULL ? lab__candidates_at(&q->candidate, &q->n, q->model, p,
                                                         elsewhere ? &records : NULL, err)
                                    : lab__no_memory(err);
    free(p);
    for (int i = 0; status == STEIN_OK && i < q->n; i++) {
        if (!is_left_out(q, &q->candidate[i])) {
            q->candidate[left++] = q->candidate[i];
        }
    }
    q->n = status == STEIN_OK ? left : 0;
    status = status == STEIN_OK ? list_settings(q, err) : status;
    size_t all = (size_t)q->n + (size_t)q->nsetting + 1;
    q->untestable = calloc(all, sizeof *q->untestable);
    q->step = calloc(all, sizeof *q->step);
    if (status == STEIN_OK && (q->untestable == NULL || q->step == NULL)) {
        return lab__no_memory(err);
    }
    for (int i = 0; i < q->n; i++) {
        q->untestable[i] = untestable(q, &q->candidate[i]);
    }
    return status;
}
