/* SPDX-License-Identifier: GPL-3.0-or-later
 * thread_pool.c - n pieces of work on several threads.
 *
 * Each thread has data of its own, the worker (a simulation, buffers), and takes the next piece
 * that no thread has taken. A piece writes only its own data, so the result does not depend on the
 * number of threads or on the assignment of pieces. Everything in the lab that runs on several
 * threads does so here.
 */
#include <pthread.h>

#include "run.h"

enum { MAX_THREADS = 64 };

typedef struct queue {
    const lab__thread_pool *pool;
    int next, done, total;
    stein_status status; /* why the work ends early */
    stein_err err;
    pthread_mutex_t lock;
} queue;

static void finish(queue *s, int counts, stein_status status, const stein_err *err)
{
    const lab__thread_pool *c = s->pool;
    pthread_mutex_lock(&s->lock);
    s->done += counts;
    if (status != STEIN_OK && s->status == STEIN_OK) {
        s->status = status;
        s->err = *err;
    }
    if (status == STEIN_OK && counts && c->progress != NULL) {
        c->progress(c->progress_ctx, s->done, s->total);
    }
    pthread_mutex_unlock(&s->lock);
}

/* the next piece, -1 when there is none */
static int take(queue *s)
{
    const lab__thread_pool *c = s->pool;
    stein_err err;
    if (lab__stop_asked(&c->stop)) {
        finish(s, 0, lab__stop_work(&err), &err);
    }
    pthread_mutex_lock(&s->lock);
    while (s->next < c->n && c->skip != NULL && c->skip[s->next]) {
        s->next++;
    }
    int i = s->status == STEIN_OK && s->next < c->n ? s->next++ : -1;
    pthread_mutex_unlock(&s->lock);
    return i;
}

static void *thread_main(void *ctx)
{
    queue *s = ctx;
    const lab__thread_pool *c = s->pool;
    void *worker = NULL;
    stein_err err = {STEIN_OK, ""};
    stein_status status = c->begin != NULL ? c->begin(c->ctx, &worker, &err) : STEIN_OK;
    if (status != STEIN_OK) {
        finish(s, 0, status, &err);
    }
    for (int i = take(s); i >= 0; i = take(s)) {
        status = c->work(c->ctx, worker, i, &err);
        finish(s, 1, status, &err);
    }
    if (c->rest != NULL && status == STEIN_OK) {
        status = c->rest(c->ctx, worker, &err);
        finish(s, 0, status, &err);
    }
    if (c->end != NULL) {
        c->end(worker);
    }
    return NULL;
}

stein_status lab__thread_pool_run(const lab__thread_pool *pool, stein_err *err)
{
    queue s = {.pool = pool};
    for (int i = 0; i < pool->n; i++) {
        s.total += pool->skip == NULL || !pool->skip[i];
    }
    if (pthread_mutex_init(&s.lock, NULL) != 0) {
        return lab__fail(err, STEIN_ENOMEM, "out of memory for threads");
    }
    pthread_t thread[MAX_THREADS];
    int started = 0, threads = pool->threads < s.total ? pool->threads : s.total;
    threads = threads > MAX_THREADS ? MAX_THREADS : threads;
    while (started < threads - 1 && pthread_create(&thread[started], NULL, thread_main, &s) == 0) {
        started++;
    }
    thread_main(&s); // this thread works too
    for (int i = 0; i < started; i++) {
        pthread_join(thread[i], NULL);
    }
    pthread_mutex_destroy(&s.lock);
    return s.status == STEIN_OK ? STEIN_OK : lab__fail(err, s.status, "%s", s.err.msg);
}
