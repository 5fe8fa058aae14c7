/* SPDX-License-Identifier: GPL-3.0-or-later
 * sweep.c - one stroke at each of many positions of the pawl's stop, on several threads.
 *
 * A thread takes the next point that nobody has, with a simulation of its own, and writes only into
 * that point. Each stroke starts from a reset, so a point's result depends neither on the thread
 * nor on what the thread did before: any number of threads gives the same bits.
 */
#include <math.h>
#include <pthread.h>
#include <stdlib.h>

#include "inner.h"

enum { MAX_THREADS = 64 };
static const char *const shift = "pawl.stop_shift";

typedef struct work {
    const lab_model *model;
    lab_point *point;
    int n, next, done;
    stein_status failed; /* of a thread that could not even begin */
    pthread_mutex_t lock;
    lab_progress_fn *progress;
    void *ctx;
} work;

static void strike_point(stein_sim *sim, lab_point *p)
{
    lab_stroke_def def = lab_stroke_def_default(stein_sim_model(sim));
    p->status = stein_set(sim, shift, p->dx, NULL);
    if (p->status == STEIN_OK) {
        p->status = stein_reset(sim, NULL);
    }
    if (p->status == STEIN_OK) {
        p->status = lab_strike(sim, &def, &p->stroke, NULL);
    }
}

static int take(work *w)
{
    pthread_mutex_lock(&w->lock);
    int i = w->next < w->n ? w->next++ : -1;
    pthread_mutex_unlock(&w->lock);
    return i;
}

static void finish(work *w)
{
    pthread_mutex_lock(&w->lock);
    w->done++;
    if (w->progress != NULL) {
        w->progress(w->ctx, w->done, w->n);
    }
    pthread_mutex_unlock(&w->lock);
}

static void *thread_main(void *ctx)
{
    work *w = ctx;
    stein_sim *sim = NULL;
    stein_status status = lab_sim(w->model, NULL, &sim, NULL);
    if (status != STEIN_OK) {
        pthread_mutex_lock(&w->lock);
        w->failed = status;
        pthread_mutex_unlock(&w->lock);
        return NULL;
    }
    for (int i = take(w); i >= 0; i = take(w)) {
        strike_point(sim, &w->point[i]);
        finish(w);
    }
    stein_sim_destroy(sim);
    return NULL;
}

/* what a stroke of this model lacks is found out once, with a message, before any thread starts */
static stein_status try_model(const lab_model *model, stein_err *err)
{
    stein_sim *sim = NULL;
    lab_stroke stroke;
    lab_stroke_def def = lab_stroke_def_default(lab_equations(model));
    if (stein_find_param(lab_equations(model), shift) < 0) {
        return lab__fail(err, STEIN_ENAME, "\"%s\" has no parameter %s, which the study varies",
                         lab_equations(model)->name, shift);
    }
    stein_status status = lab_sim(model, NULL, &sim, err);
    if (status == STEIN_OK) {
        def.until = lab_def(model).dt;
        status = lab_strike(sim, &def, &stroke, err);
        stein_sim_destroy(sim);
    }
    return status;
}

stein_status lab_sweep(const lab_model *model, lab_point *point, int n, int threads,
                       lab_progress_fn *progress, void *ctx, stein_err *err)
{
    stein_status status = try_model(model, err);
    if (status != STEIN_OK) {
        return status;
    }
    work w = {.model = model, .point = point, .n = n, .progress = progress, .ctx = ctx};
    if (pthread_mutex_init(&w.lock, NULL) != 0) {
        return lab__fail(err, STEIN_ENOMEM, "out of memory for threads");
    }
    pthread_t thread[MAX_THREADS];
    int started = 0;
    threads = threads < 1 ? 1 : threads > MAX_THREADS ? MAX_THREADS : threads;
    while (started < threads - 1 && pthread_create(&thread[started], NULL, thread_main, &w) == 0) {
        started++;
    }
    thread_main(&w); // this thread works too
    for (int i = 0; i < started; i++) {
        pthread_join(thread[i], NULL);
    }
    pthread_mutex_destroy(&w.lock);
    return w.next >= w.n ? STEIN_OK
                         : lab__fail(err, w.failed, "no simulation of \"%s\": %s",
                                     lab_equations(model)->name, stein_status_text(w.failed));
}
