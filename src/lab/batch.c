/* SPDX-License-Identifier: GPL-3.0-or-later
 * batch.c - many simulations of one model on several threads.
 *
 * A thread takes the next point that nobody has and gives it a simulation made from a descriptor
 * whose defaults are the point's parameters - as if the file had said so. Nothing of one point
 * reaches another one, so any number of threads gives the same bits, and a parameter set without
 * equilibrium fails alone. Creating a simulation costs one allocation, nothing beside a stroke.
 */
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "inner.h"

typedef struct work {
    const lab__batch *batch;
    int next, done, total;
    stein_status status; /* why the batch ends early */
    stein_err err;
    pthread_mutex_t lock;
} work;

/* what a thread has of its own */
typedef struct bench {
    stein_model model; /* params are the ones below */
    stein_param *params;
    double *p;
} bench;

/* the next point, -1 when there is none */
static int take(work *w)
{
    const lab__batch *b = w->batch;
    pthread_mutex_lock(&w->lock);
    while (w->next < b->n && b->skip != NULL && b->skip[w->next]) {
        w->next++;
    }
    int point = w->status == STEIN_OK && w->next < b->n ? w->next++ : -1;
    pthread_mutex_unlock(&w->lock);
    return point;
}

static void finish(work *w, stein_status status, const stein_err *err)
{
    const lab__batch *b = w->batch;
    pthread_mutex_lock(&w->lock);
    w->done++;
    if (status != STEIN_OK && w->status == STEIN_OK) {
        w->status = status;
        w->err = *err;
    }
    if (status == STEIN_OK && b->progress != NULL) {
        b->progress(b->progress_ctx, w->done, w->total);
    }
    pthread_mutex_unlock(&w->lock);
}

static stein_status set_up(bench *t, const lab_model *model, stein_err *err)
{
    t->model = *lab_equations(model);
    size_t np = (size_t)t->model.np;
    t->params = malloc(sizeof *t->params * (np + 1));
    t->p = malloc(sizeof *t->p * (np + 1));
    if (t->params == NULL || t->p == NULL) {
        return lab__fail(err, STEIN_ENOMEM, "out of memory");
    }
    memcpy(t->params, t->model.params, sizeof *t->params * np);
    t->model.params = t->params;
    return STEIN_OK;
}

static stein_status work_on(const lab__batch *b, bench *t, int point, stein_err *err)
{
    stein_sim *sim = NULL;
    memcpy(t->p, lab_parameters(b->model), sizeof *t->p * (size_t)t->model.np);
    b->set(b->ctx, point, t->p);
    for (int i = 0; i < t->model.np; i++) {
        t->params[i].value = t->p[i];
    }
    stein_status status = stein_sim_create(&sim, &t->model, NULL, err);
    if (status == STEIN_ENOMEM) {
        return status;
    }
    status = b->run(b->ctx, point, sim, status, err);
    stein_sim_destroy(sim);
    return status;
}

static void *thread_main(void *ctx)
{
    work *w = ctx;
    bench t = {.params = NULL};
    stein_err err = {STEIN_OK, ""};
    stein_status ready = set_up(&t, w->batch->model, &err);
    for (int point = take(w); point >= 0; point = take(w)) {
        stein_status status = ready == STEIN_OK ? work_on(w->batch, &t, point, &err) : ready;
        finish(w, status, &err);
    }
    free(t.params);
    free(t.p);
    return NULL;
}

stein_status lab__batch_run(const lab__batch *batch, stein_err *err)
{
    work w = {.batch = batch};
    for (int i = 0; i < batch->n; i++) {
        w.total += batch->skip == NULL || !batch->skip[i];
    }
    if (pthread_mutex_init(&w.lock, NULL) != 0) {
        return lab__fail(err, STEIN_ENOMEM, "out of memory for threads");
    }
    pthread_t thread[LAB_THREADS];
    int started = 0, threads = batch->threads < w.total ? batch->threads : w.total;
    threads = threads > LAB_THREADS ? LAB_THREADS : threads;
    while (started < threads - 1 && pthread_create(&thread[started], NULL, thread_main, &w) == 0) {
        started++;
    }
    thread_main(&w); // this thread works too
    for (int i = 0; i < started; i++) {
        pthread_join(thread[i], NULL);
    }
    pthread_mutex_destroy(&w.lock);
    return w.status == STEIN_OK ? STEIN_OK : lab__fail(err, w.status, "%s", w.err.msg);
}
