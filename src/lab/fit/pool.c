/* SPDX-License-Identifier: GPL-3.0-or-later
 * pool.c - several fits at once, whose strokes share threads and lanes.
 *
 * A fit of one stroke asks for one at a time, and would leave all lanes but one empty. So each of
 * several such fits has a thread that sleeps while its strokes are under way:
 *
 *      fit -> queue of strokes -> a free seat of a row ... side by side ... -> the fit goes on
 *
 * There is a row for each thread of the problem. One of the waiting fits steps it, for all jobs
 * in it. It does not step while seats are free and a busy fit may soon need one.
 */
#include <pthread.h>
#include <stdlib.h>

#include "row.h"

/* what a fit has asked for */
typedef struct request {
    fit__jobs jobs;      /* first: rows tell whose job is over by it */
    int n, next, left;   /* jobs, the next that no thread has, how many are not over */
    stein_status status; /* why one has failed */
    stein_err why;
    struct request *after; /* in the queue */
} request;

typedef struct driven {
    fit__row row;
    int by; /* somebody */
} driven;

struct fit__pool {
    pthread_mutex_t lock; /* of all that is below, but for a row that somebody drives */
    pthread_cond_t changed;
    request *queue; /* of those with jobs that no thread has */
    driven *row;    /* [nrow] one for each thread of the problem */
    int nrow;
    int busy; /* fits that do not wait for strokes: they may soon ask for some */
    fit__piece *piece;
    void *ctx;
};

static void queue_up(fit__pool *pool, request *a)
{
    request **last = &pool->queue;
    while (*last != NULL) {
        last = &(*last)->after;
    }
    *last = a;
}

/* the next job of the queue. @return whose it is, NULL: there is none */
static request *next_job(fit__pool *pool, int *job)
{
    request *a = pool->queue;
    if (a != NULL) {
        *job = a->next++;
        pool->queue = a->next == a->n ? a->after : a;
    }
    return a;
}

static void job_is_over(fit__pool *pool, request *a, stein_status status, const stein_err *why)
{
    if (status != STEIN_OK && a->status == STEIN_OK) {
        a->status = status;
        a->why = *why;
    }
    if (--a->left == 0) {
        pthread_cond_broadcast(&pool->changed);
    }
}

static int has_work(const fit__pool *pool, const fit__row *r)
{
    int room = r->taken < r->n;
    return room && pool->queue != NULL ? 1 : r->taken > 0 && (!room || pool->busy == 0);
}

/* the next job begins in r, or all who sit there go on until one is over */
static void drive_on(fit__pool *pool, fit__row *r)
{
    int job = 0;
    request *a = r->taken < r->n ? next_job(pool, &job) : NULL;
    stein_err why = {STEIN_OK, ""};
    pthread_mutex_unlock(&pool->lock);
    stein_status status = a != NULL ? fit__row_begin(r, &a->jobs, job, &why) : fit__row_go(r, &why);
    pthread_mutex_lock(&pool->lock);
    if (r->over != NULL) {
        job_is_over(pool, (request *)r->over, status, &why);
    } else if (a != NULL && status != STEIN_OK) { // it has not begun
        job_is_over(pool, a, status, &why);
    }
}

/* a row that nobody drives, and that has something to do. @return NULL: none */
static driven *idle_row(fit__pool *pool)
{
    for (int i = 0; i < pool->nrow; i++) {
        driven *d = &pool->row[i];
        if (!d->by && has_work(pool, &d->row)) {
            return d;
        }
    }
    return NULL;
}

stein_status fit__pool_run(fit__pool *pool, const fit__jobs *jobs, int n, stein_err *err)
{
    request a = {.jobs = *jobs, .n = n, .left = n};
    if (n == 0) {
        return STEIN_OK;
    }
    pthread_mutex_lock(&pool->lock);
    queue_up(pool, &a);
    pool->busy--;
    pthread_cond_broadcast(&pool->changed);
    while (a.left > 0) {
        driven *d = idle_row(pool);
        if (d == NULL) {
            pthread_cond_wait(&pool->changed, &pool->lock);
            continue;
        }
        d->by = 1;
        while (a.left > 0 && has_work(pool, &d->row)) {
            drive_on(pool, &d->row);
        }
        d->by = 0;
        pthread_cond_broadcast(&pool->changed); // whoever else waits may drive it
    }
    pool->busy++;
    pthread_mutex_unlock(&pool->lock);
    return a.status == STEIN_OK ? STEIN_OK : lab__fail(err, a.status, "%s", a.why.msg);
}

/* ---- the fits ---- */

static void count_busy(fit__pool *pool, int more)
{
    pthread_mutex_lock(&pool->lock);
    pool->busy += more;
    pthread_cond_broadcast(&pool->changed);
    pthread_mutex_unlock(&pool->lock);
}

static stein_status join(void *ctx, void **bench, stein_err *err)
{
    (void)err;
    count_busy(ctx, 1);
    *bench = ctx;
    return STEIN_OK;
}

static void leave(void *bench)
{
    count_busy(bench, -1);
}

static stein_status one_fit(void *ctx, void *bench, int i, stein_err *err)
{
    fit__pool *pool = ctx;
    (void)bench;
    return pool->piece(pool->ctx, i, pool, err);
}

static stein_status run_fits(fit__pool *pool, int n, stein_err *err)
{
    lab__thread_pool threads = {.n = n,
                                .threads = pool->nrow * pool->row[0].row.n,
                                .begin = join,
                                .work = one_fit,
                                .end = leave,
                                .ctx = pool};
    return lab__thread_pool_run(&threads, err);
}

stein_status fit__together(const fit__problem *p, int n, fit__piece *piece, void *ctx,
                           stein_err *err)
{
    fit__pool pool = {.nrow = p->threads, .piece = piece, .ctx = ctx};
    stein_status status = STEIN_OK;
    pool.row = calloc((size_t)pool.nrow, sizeof *pool.row);
    int locked = pool.row != NULL && pthread_mutex_init(&pool.lock, NULL) == 0;
    int sound = locked && pthread_cond_init(&pool.changed, NULL) == 0;
    if (!sound) {
        status = lab__no_memory(err);
    }
    for (int i = 0; status == STEIN_OK && i < pool.nrow; i++) {
        status = fit__row_make(&pool.row[i].row, p, err);
    }
    status = status == STEIN_OK ? run_fits(&pool, n, err) : status;
    for (int i = 0; pool.row != NULL && i < pool.nrow; i++) {
        fit__row_free(&pool.row[i].row);
    }
    free(pool.row);
    if (sound) {
        pthread_cond_destroy(&pool.changed);
    }
    if (locked) {
        pthread_mutex_destroy(&pool.lock);
    }
    return status;
}
