/* SPDX-License-Identifier: GPL-3.0-or-later
 * starts.c - multi-start search for one minimum, with a ladder of observer gains.
 *
 *      start 0   from the file, free-running
 *      start 1.. from points of a Sobol sequence within the priors, free-running
 *      ladders   unless these agree, start 1 from the file and 2.. from points of the sequence once
 *                more, down the ladder K = 0.1, 0.04, 0.015, 0.005, 0
 *      polish    the best end, with differences to both sides; noise that is not stated is now
 *                taken from the residual (that of a record says little where the motion is fast)
 *      robust    weights from the residual, and again, four times
 *
 * (K = 0.3 above them costs ten times as much and ends nowhere else: its forces shake the
 * contacts.) Every rung (see observer.c) starts where the one above it ended. A direct search from
 * parameters that are 10 % wrong usually ends in a false minimum, which looks exactly like missing
 * physics. Only the agreement of different searches shows that the lowest minimum was found. False
 * minima are many, so free-running searches that end in them do not agree. A rung costs as much as
 * a hundred strokes that run free and in lanes: it is not begun where all starts have ended in one
 * minimum. The search also stops early when enough of them agree and the residual is noise - a
 * false minimum is never that good.
 */
#include <gsl/gsl_qrng.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fitting.h"

enum { ROBUST_PASSES = 4, SOBOL_DIMENSIONS = 40 };
static const double rung[] = {0.1, 0.04, 0.015, 0.005, 0.0};
enum { RUNGS = sizeof rung / sizeof *rung, RUNG_ITERATIONS = 5 };
static const double rung_enough = 1e-3;  /* of the objective: go down */
static const double start_enough = 1e-2; /* of an sd^2: a start has ended */
static const double done = 1e-4;         /* of an sd^2: the fit has */
static const double start_spread = 0.15; /* starts within so much of a value, or 1.5 sd */

typedef struct stage {
    int start; /* -1: polish, -2: robust pass */
    int point; /* of the Sobol sequence, where it begins; 0: the file */
    double gain;
    int first, last; /* rung of its start */
} stage;

typedef struct run {
    fit__problem *p;
    fit__search *s;
    unsigned long long key;
} run;

/* ---- memory ---- */

stein_status fit__search_make(fit__search *s, const fit__problem *p, stein_err *err)
{
    size_t nu = (size_t)p->nu + 1;
    *s = (fit__search){.stage = 0};
    double *room = calloc(nu * (4 + LAB_FIT_STARTS), sizeof *room);
    if (room == NULL) {
        return lab__no_memory(err);
    }
    s->state.x = room;
    s->state.step = room + nu;
    s->state.scale = room + 2 * nu;
    s->entry = room + 3 * nu;
    for (int i = 0; i < LAB_FIT_STARTS; i++) {
        s->best[i] = room + (4 + (size_t)i) * nu;
    }
    return STEIN_OK;
}

void fit__search_free(fit__search *s)
{
    free(s->state.x);
}

/* ---- the plan ---- */

int fit__can_hold(const fit__problem *p)
{
    const stein_model *m = lab_equations(p->model);
    for (int s = 0; s < p->nstroke; s++) {
        for (int c = 0; c < p->stroke[s].nch; c++) {
            if (fit__shows_place(&m->channels[p->stroke[s].channel[c]])) {
                return 1;
            }
        }
    }
    return 0;
}

/* searches down the ladder */
static int ladders(const fit__problem *p)
{
    return p->def->ladder && fit__can_hold(p) ? p->def->starts - 1 : 0;
}

static int first_stage_after_starts(const fit__problem *p)
{
    return p->def->starts + ladders(p) * (int)RUNGS;
}

static int stage_at(const fit__problem *p, int index, stage *st)
{
    int down = index - p->def->starts, after = index - first_stage_after_starts(p);
    if (down < 0) {
        *st = (stage){index, index, 0.0, 1, 1};
        return 1;
    }
    if (after < 0) {
        int start = 1 + down / (int)RUNGS, i = down % (int)RUNGS;
        *st = (stage){start, start - 1, rung[i], i == 0, i == (int)RUNGS - 1};
        return 1;
    }
    *st = (stage){after == 0 ? -1 : -2, 0, 0.0, 1, 1};
    return after <= (p->def->robust ? ROBUST_PASSES : 0);
}

/* ---- places to start from ---- */

static double spread_of(const fit__problem *p, int k)
{
    const fit__unknown *u = &p->unknown[k];
    double relative = u->log ? u->sd : u->start != 0.0 ? u->sd / fabs(u->start) : 0.0;
    return relative > 0.0 ? fmin(1.5, start_spread / relative) : 1.0;
}

static stein_status place(const fit__problem *p, int point, double *x, stein_err *err)
{
    memset(x, 0, sizeof *x * (size_t)p->nu);
    if (point == 0) {
        return STEIN_OK;
    }
    unsigned dim = (unsigned)(p->np < SOBOL_DIMENSIONS ? p->np : SOBOL_DIMENSIONS);
    double u[SOBOL_DIMENSIONS] = {0.0};
    gsl_qrng *q = gsl_qrng_alloc(gsl_qrng_sobol, dim);
    if (q == NULL) {
        return lab__no_memory(err);
    }
    for (int i = 0; i <= point; i++) { // the first one is the middle
        gsl_qrng_get(q, u);
    }
    for (int k = 0; k < p->np; k++) {
        double v = u[k % SOBOL_DIMENSIONS];
        v = (k / SOBOL_DIMENSIONS) % 2 == 0 ? v : 1.0 - v;
        x[k] = spread_of(p, k) * (2.0 * v - 1.0);
    }
    gsl_qrng_free(q);
    return STEIN_OK;
}

/* ---- agreement ---- */

static int best_of(const fit__search *s)
{
    int best = 0;
    for (int i = 1; i < s->nstart; i++) {
        best = s->start[i].objective < s->start[best].objective ? i : best;
    }
    return best;
}

static int agreeing(const fit__problem *p, fit__search *s)
{
    int n = 0, best = best_of(s), dof = p->samples - p->nu;
    double lowest = s->start[best].objective;
    double slack = 0.5 * fmax(1.0, lowest / dof);
    for (int i = 0; i < s->nstart; i++) {
        s->start[i].agrees = s->start[i].ended && s->start[i].objective - lowest <= slack;
        n += s->start[i].agrees;
    }
    return n;
}

static int is_enough(const fit__problem *p, fit__search *s)
{
    int dof = p->samples - p->nu, agree = agreeing(p, s);
    double ratio = s->start[best_of(s)].objective / dof;
    int needed = p->def->starts / 2 + 1;
    return agree == p->def->starts || (agree >= needed && ratio < 1.1 + 3.0 * sqrt(2.0 / dof));
}

/* ---- running ---- */

static stein_status checkpoint(void *ctx, const fit__state *state, stein_err *err)
{
    run *r = ctx;
    const lab_fit_def *def = r->p->def;
    if (def->progress != NULL) {
        char text[80];
        stage st;
        stage_at(r->p, r->s->stage, &st);
        double all = first_stage_after_starts(r->p) + 1;
        snprintf(text, sizeof text, "%s %d, iteration %d, objective %.6g",
                 st.start >= 0    ? "start"
                 : st.start == -1 ? "polish"
                                  : "robust",
                 st.start >= 0 ? st.start + 1 : 1, state->iteration, state->objective);
        def->progress(def->ctx, fmin(1.0, (r->s->stage + 0.1 * fmin(state->iteration, 10)) / all),
                      text);
    }
    return def->journal != NULL ? fit__search_save(r->s, r->p->nu, def->journal, r->key, err)
                                : STEIN_OK;
}

static void reset_state(fit__problem *p, fit__state *s)
{
    s->mu = 1e-3;
    s->nu = 2.0;
    s->iteration = 0;
    s->ended = 0;
    memset(s->scale, 0, sizeof *s->scale * (size_t)p->nu);
    for (int k = 0; k < p->nu; k++) {
        s->step[k] = s->step[k] > 0.0 ? s->step[k] : 1e-2;
    }
}

/* residuals without weights */
static stein_status plain_residuals(fit__problem *p, const double *x, double **r, stein_err *err)
{
    int failed = 0;
    *r = malloc(sizeof **r * (fit__offset(p, p->nstroke) + 1));
    if (*r == NULL) {
        return lab__no_memory(err);
    }
    for (int s = 0; s < p->nstroke; s++) {
        free(p->stroke[s].weight);
        p->stroke[s].weight = NULL;
    }
    stein_status status = fit__residuals(p, x, *r, &failed, err);
    return status == STEIN_OK && failed > 0
               ? lab__fail(err, STEIN_ENONFINITE, "a record cannot be simulated any more")
               : status;
}

/* noise that is not stated, from the residual at the best end of the starts */
static stein_status new_noise(fit__problem *p, const double *x, stein_err *err)
{
    double *r = NULL;
    for (int s = 0; s < p->nstroke; s++) {
        memcpy(p->stroke[s].noise, p->stroke[s].audited,
               sizeof *p->stroke[s].noise * (size_t)p->stroke[s].nch);
    }
    stein_status status = plain_residuals(p, x, &r, err);
    for (int s = 0; status == STEIN_OK && s < p->nstroke; s++) {
        fit__estimate_noise(p, s, r);
    }
    for (int s = 0; status == STEIN_OK && s < p->nstroke; s++) {
        for (int c = 0; c < p->stroke[s].nch; c++) {
            p->stroke[s].noise[c] = p->stroke[s].residual[c];
        }
    }
    free(r);
    return status;
}

/* weights from the residual at the beginning of the stage */
static stein_status new_weights(fit__problem *p, const double *x, stein_err *err)
{
    double *r = NULL;
    stein_status status = plain_residuals(p, x, &r, err);
    status = status == STEIN_OK ? fit__robust_weights(p, r, err) : status;
    free(r);
    return status;
}

/* enter the stage: where it starts. After an interruption that is in the journal. */
static stein_status enter(fit__problem *p, fit__search *s, const stage *st, stein_err *err)
{
    stein_status status = STEIN_OK;
    if (st->start >= 0 && st->first) {
        memset(s->state.step, 0, sizeof *s->state.step * (size_t)p->nu);
        status = place(p, st->point, s->state.x, err);
    } else if (st->start == -1) {
        memcpy(s->state.x, s->best[best_of(s)], sizeof *s->state.x * (size_t)p->nu);
    }
    reset_state(p, &s->state);
    memcpy(s->entry, s->state.x, sizeof *s->entry * (size_t)p->nu);
    return status;
}

/* of two searches the better one is kept */
static void note_start(fit__problem *p, fit__search *s, const stage *st, int failed)
{
    lab_fit_start *to = &s->start[st->start];
    if (st->start < s->nstart && (failed || !(s->state.objective < to->objective))) {
        return;
    }
    *to = (lab_fit_start){failed ? INFINITY : s->state.objective, s->state.iteration,
                          !failed && s->state.ended, 0};
    memcpy(s->best[st->start], s->state.x, sizeof *s->state.x * (size_t)p->nu);
    s->nstart = st->start < s->nstart ? s->nstart : st->start + 1;
}

static stein_status one_stage(run *r, const stage *st, stein_err *err)
{
    fit__problem *p = r->p;
    fit__search *s = r->s;
    int rung_only = st->gain > 0.0;
    p->gain = st->gain;
    p->central = st->start < 0;
    p->tolerance = rung_only ? 1e-8 : p->central ? 1e-11 : 1e-9;
    stein_status status = st->start < 0 ? new_noise(p, s->best[best_of(s)], err) : STEIN_OK;
    if (status == STEIN_OK && st->start == -2) {
        status = new_weights(p, s->entry, err);
    }
    int iterations = rung_only ? RUNG_ITERATIONS : p->def->iterations;
    status = status == STEIN_OK
                 ? fit__minimise(p, &s->state,
                                 rung_only       ? rung_enough
                                 : st->start < 0 ? done
                                                 : start_enough,
                                 rung_only ? 1.0 : 0.0, iterations, checkpoint, r, err)
                 : status;
    p->gain = 0.0;
    return status;
}

static int is_numerical(stein_status status)
{
    return status == STEIN_ENONFINITE || status == STEIN_ESINGULAR || status == STEIN_ECHATTER ||
           status == STEIN_ESETTLE;
}

/* a start that cannot go on is over; only when all are, that is a failure */
static stein_status after_stage(run *r, stage *st, stein_status status, stein_err *why)
{
    fit__search *s = r->s;
    if (st->start < 0) {
        return status;
    }
    int failed = is_numerical(status);
    if (status != STEIN_OK && !failed) {
        return status;
    }
    while (failed && !st->last) { // no further rungs
        s->stage++;
        stage_at(r->p, s->stage, st);
    }
    if (st->last) {
        note_start(r->p, s, st, failed);
    }
    if (st->last && is_enough(r->p, s)) {
        s->stage = first_stage_after_starts(r->p) - 1;
        stage_at(r->p, s->stage, st);
    }
    int over = s->stage == first_stage_after_starts(r->p) - 1;
    return over && !isfinite(s->start[best_of(s)].objective) ? (why->code = STEIN_ENONFINITE)
                                                             : STEIN_OK;
}

stein_status fit__search_run(fit__problem *p, fit__search *s, unsigned long long key, int *resumed,
                             stein_err *err)
{
    run r = {p, s, key};
    stage st;
    stein_err why = {STEIN_OK, ""};
    stein_status status = STEIN_OK;
    *resumed = 0;
    if (p->def->journal != NULL) {
        status = fit__search_load(s, p->nu, p->def->journal, key, resumed, err);
    }
    int inside = *resumed;
    while (status == STEIN_OK && stage_at(p, s->stage, &st)) {
        status = inside ? STEIN_OK : enter(p, s, &st, err);
        inside = 0;
        if (status == STEIN_OK) {
            status = after_stage(&r, &st, one_stage(&r, &st, &why), &why);
            s->stage++;
        }
    }
    s->stage--; // the last one, as the journal has it
    agreeing(p, s);
    return status == STEIN_OK || why.code == STEIN_OK
               ? status
               : lab__fail(err, status, "%s",
                           why.msg[0] != '\0' ? why.msg : "no record can be simulated");
}
