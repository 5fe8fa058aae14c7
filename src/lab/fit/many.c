/* SPDX-License-Identifier: GPL-3.0-or-later
 * many.c - many strokes of one problem, on its threads and in the lanes of each.
 *
 * Derivatives, residuals and secants ask for hundreds of strokes that know nothing of each other. A
 * thread has a row of seats, one a lane, each with a simulation of its own:
 *
 *      job -> a free seat: ask (parameters, start) ... steps, side by side ... take (what came out)
 *
 * While a seat is free the thread takes the next job that nobody has; else all seats go on until
 * one of them is over. So a lane waits for nobody, and what a job is the same to the last bit
 * whoever sits beside it. A stroke with a recorded input is a run from each of its samples to the
 * next. Strokes with a force of the bench's, or down the ladder, have the thread for themselves.
 */
#include <stdlib.h>

#include "fitting.h"
#include "stein/batch.h"

/* ---- whole jobs ---- */

typedef struct gang {
    const fit__problem *p;
    fit__work *work;
    void *ctx;
} gang;

static stein_status no_memory(stein_err *err)
{
    return lab__fail(err, STEIN_ENOMEM, "out of memory");
}

static stein_status begin(void *ctx, void **bench, stein_err *err)
{
    const gang *g = ctx;
    fit__bench *b = calloc(1, sizeof *b);
    *bench = b;
    return b != NULL ? fit__bench_make(b, g->p, err) : no_memory(err);
}

static stein_status work(void *ctx, void *bench, int job, stein_err *err)
{
    const gang *g = ctx;
    const fit__bench *b = bench;
    g->work(g->ctx, bench, job);
    return b->no_memory ? no_memory(err) : STEIN_OK;
}

static void end(void *bench)
{
    if (bench != NULL) {
        fit__bench_free(bench);
        free(bench);
    }
}

stein_status fit__parallel(const fit__problem *p, int jobs, fit__work *one, void *ctx,
                           stein_err *err)
{
    gang g = {p, one, ctx};
    lab__crew crew = {
        .n = jobs, .threads = p->threads, .begin = begin, .work = work, .end = end, .ctx = &g};
    return lab__crew_run(&crew, err);
}

/* ---- side by side ---- */

typedef struct asking {
    const fit__problem *p;
    fit__ask *ask;
    fit__take *take;
    void *ctx;
} asking;

typedef struct seat {
    fit__bench bench; /* made for the first who sits here */
    int made, taken, job;
} seat;

/* the seats of a thread */
typedef struct row {
    seat *seat; /* [n] */
    int n, taken;
    stein_batch *batch;
} row;

static stein_status row_make(void *ctx, void **bench, stein_err *err)
{
    const asking *a = ctx;
    const stein_model *m = lab_equations(a->p->model);
    stein_sim_def def = lab_def(a->p->model);
    def.integrator = STEIN_DP5;
    row *r = calloc(1, sizeof *r);
    *bench = r;
    if (r == NULL) {
        return no_memory(err);
    }
    r->n = a->p->lanes > 0 ? a->p->lanes : stein_batch_width(m);
    r->seat = calloc((size_t)r->n, sizeof *r->seat);
    return r->seat == NULL ? no_memory(err)
                           : stein_batch_create(&r->batch, m, &def, r->n, a->p->lanes, err);
}

static void row_free(void *bench)
{
    row *r = bench;
    if (r == NULL) {
        return;
    }
    stein_batch_destroy(r->batch);
    for (int i = 0; r->seat != NULL && i < r->n; i++) {
        if (r->seat[i].made) {
            fit__bench_free(&r->seat[i].bench);
        }
    }
    free(r->seat);
    free(r);
}

/* the job in a seat is over */
static stein_status get_up(const asking *a, row *r, int i, int failed, stein_err *err)
{
    seat *s = &r->seat[i];
    (void)stein_batch_put(r->batch, i, NULL, NULL);
    r->taken -= s->taken;
    s->taken = 0;
    a->take(a->ctx, &s->bench, s->job, failed);
    return s->bench.no_memory ? no_memory(err) : STEIN_OK;
}

/* the next run of a job begins, or the job is over */
static stein_status next_run(const asking *a, row *r, int i, stein_status status, stein_err *err)
{
    seat *s = &r->seat[i];
    stein_pace *pace;
    double t_end;
    if (status == STEIN_OK && fit__next_run(&s->bench, &t_end, &pace)) {
        status = stein_batch_begin(r->batch, i, t_end, pace, NULL);
        if (status == STEIN_OK) {
            return STEIN_OK;
        }
    }
    return get_up(a, r, i, fit__finish(&s->bench, status) != STEIN_OK, err);
}

/* all seats go on until one run is over */
static stein_status go_on(const asking *a, row *r, stein_err *err)
{
    stein_status status;
    int i = stein_batch_go(r->batch, &status, NULL);
    return next_run(a, r, i, status, err);
}

static stein_status sit_down(const asking *a, row *r, int i, int job, stein_err *err)
{
    seat *s = &r->seat[i];
    if (!s->made) {
        s->made = 1;
        stein_status made = fit__bench_make(&s->bench, a->p, err);
        if (made != STEIN_OK) {
            return made;
        }
    }
    s->job = job;
    stein_status status = a->ask(a->ctx, &s->bench, job);
    if (status == STEIN_OK && fit__can_ride(&s->bench)) {
        s->taken = 1;
        r->taken++;
        status = stein_batch_put(r->batch, i, s->bench.sim, NULL);
        return next_run(a, r, i, status, err);
    }
    if (status == STEIN_OK) {
        status = fit__finish(&s->bench, fit__alone(&s->bench));
    }
    s->bench.no_memory |= status == STEIN_ENOMEM;
    return get_up(a, r, i, status != STEIN_OK, err);
}

static stein_status next_job(void *ctx, void *bench, int job, stein_err *err)
{
    row *r = bench;
    stein_status status = STEIN_OK;
    int i = 0;
    while (status == STEIN_OK && r->taken == r->n) {
        status = go_on(ctx, r, err);
    }
    if (status != STEIN_OK) {
        return status;
    }
    while (r->seat[i].taken) {
        i++;
    }
    return sit_down(ctx, r, i, job, err);
}

static stein_status last_jobs(void *ctx, void *bench, stein_err *err)
{
    row *r = bench;
    stein_status status = STEIN_OK;
    while (status == STEIN_OK && r->taken > 0) {
        status = go_on(ctx, r, err);
    }
    return status;
}

stein_status fit__many(const fit__problem *p, int jobs, fit__ask *ask, fit__take *take, void *ctx,
                       stein_err *err)
{
    asking a = {p, ask, take, ctx};
    lab__crew crew = {.n = jobs,
                      .threads = p->threads,
                      .begin = row_make,
                      .work = next_job,
                      .rest = last_jobs,
                      .end = row_free,
                      .ctx = &a};
    return lab__crew_run(&crew, err);
}
