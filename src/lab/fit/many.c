/* SPDX-License-Identifier: GPL-3.0-or-later
 * many.c - many strokes of one problem, on its threads and in the lanes of each.
 *
 * Derivatives, residuals and secants ask for hundreds of strokes that know nothing of each other.
 * While a thread has a free seat in its row it takes the next job that no thread has; else all who
 * sit there go on until one of them is over.
 */
#include <stdlib.h>

#include "row.h"

/* ---- one after the other on each thread ---- */

typedef struct gang {
    const fit__problem *p;
    fit__work *work;
    void *ctx;
} gang;

static stein_status begin(void *ctx, void **bench, stein_err *err)
{
    const gang *g = ctx;
    fit__bench *b = calloc(1, sizeof *b);
    *bench = b;
    return b != NULL ? fit__bench_make(b, g->p, err) : lab__no_memory(err);
}

static stein_status work(void *ctx, void *bench, int job, stein_err *err)
{
    const gang *g = ctx;
    const fit__bench *b = bench;
    g->work(g->ctx, bench, job);
    return b->no_memory ? lab__no_memory(err) : STEIN_OK;
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
    lab__thread_pool pool = {.n = jobs,
                             .threads = p->threads,
                             .begin = begin,
                             .work = work,
                             .end = end,
                             .stop = p->stop,
                             .ctx = &g};
    return lab__thread_pool_run(&pool, err);
}

/* ---- side by side on each thread ---- */

typedef struct rows {
    const fit__problem *p;
    fit__jobs jobs;
} rows;

static stein_status make_row(void *ctx, void **bench, stein_err *err)
{
    const rows *all = ctx;
    fit__row *r = calloc(1, sizeof *r);
    *bench = r;
    return r != NULL ? fit__row_make(r, all->p, err) : lab__no_memory(err);
}

static void free_row(void *bench)
{
    if (bench != NULL) {
        fit__row_free(bench);
        free(bench);
    }
}

static stein_status next_job(void *ctx, void *bench, int job, stein_err *err)
{
    rows *all = ctx;
    fit__row *r = bench;
    stein_status status = STEIN_OK;
    while (status == STEIN_OK && r->taken == r->n) {
        status = fit__row_go(r, err);
    }
    return status == STEIN_OK ? fit__row_begin(r, &all->jobs, job, err) : status;
}

static stein_status last_jobs(void *ctx, void *bench, stein_err *err)
{
    fit__row *r = bench;
    stein_status status = STEIN_OK;
    (void)ctx;
    while (status == STEIN_OK && r->taken > 0) {
        status = fit__row_go(r, err);
    }
    return status;
}

stein_status fit__many(const fit__problem *p, int jobs, fit__ask *ask, fit__take *take, void *ctx,
                       stein_err *err)
{
    rows all = {p, {ask, take, ctx}};
    if (p->simulated != NULL) {
        __atomic_add_fetch(p->simulated, jobs, __ATOMIC_RELAXED);
    }
    if (p->pool != NULL) {
        return lab__stop_asked(&p->stop) ? lab__stop_work(err)
                                         : fit__pool_run(p->pool, &all.jobs, jobs, err);
    }
    lab__thread_pool pool = {.n = jobs,
                             .threads = p->threads,
                             .begin = make_row,
                             .work = next_job,
                             .rest = last_jobs,
                             .end = free_row,
                             .stop = p->stop,
                             .ctx = &all};
    return lab__thread_pool_run(&pool, err);
}
