/* SPDX-License-Identifier: GPL-3.0-or-later
 * batch.c - many runs of one model, on the threads of a pool and in the lanes of each.
 *
 * Each point gets a simulation from a descriptor with the point's parameters as defaults, as if the
 * file stated them. Nothing of one point reaches another one, so any number of threads and lanes
 * gives the same bits, and a parameter set without equilibrium fails alone. Creating a simulation
 * costs one allocation, nothing beside a stroke.
 *
 * A thread takes points in chunks. Each of its lanes has a run (strike.c), which returns the next
 * operation of its simulation. Fixed steps are taken in all lanes at once; steps of controlled
 * error have a length of their own in each lane. After the end of a run its lane takes the next
 * point of the chunk.
 */
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "run.h"
#include "stein/batch.h"

enum { CHUNKS = 4 }; /* for each thread, so that all of them end at about the same time */

typedef struct job {
    const lab__batch *batch;
    const stein_model *equations;
    int *point; /* [npoint] points to compute */
    int npoint, chunk, lanes, done;
    pthread_mutex_t lock; /* of done */
} job;

/* a lane and the point that it computes */
typedef struct lane {
    stein_model model; /* params are the ones below */
    stein_param *params;
    double *p;
    int point; /* -1: none */
    stein_sim *sim;
    lab__runner *runner;
} lane;

/* data of a thread */
typedef struct worker {
    lane *lane; /* [lanes] */
    int lanes;
    stein_batch *together;
    stein_status *status; /* [lanes] of the last step */
} worker;

static void worker_free(void *worker_)
{
    worker *t = worker_;
    if (t == NULL) {
        return;
    }
    for (int i = 0; t->lane != NULL && i < t->lanes; i++) {
        lab__runner_drop(t->lane[i].runner);
        stein_sim_destroy(t->lane[i].sim);
        free(t->lane[i].params);
        free(t->lane[i].p);
    }
    stein_batch_destroy(t->together);
    free(t->lane);
    free(t->status);
    free(t);
}

static stein_status lane_create(lane *s, const stein_model *equations, stein_err *err)
{
    size_t np = (size_t)equations->np;
    s->model = *equations;
    s->params = malloc(sizeof *s->params * (np + 1));
    s->p = malloc(sizeof *s->p * (np + 1));
    s->point = -1;
    if (s->params == NULL || s->p == NULL) {
        return lab__no_memory(err);
    }
    memcpy(s->params, equations->params, sizeof *s->params * np);
    s->model.params = s->params;
    return STEIN_OK;
}

static stein_status worker_create(void *ctx, void **worker_, stein_err *err)
{
    const job *j = ctx;
    worker *t = calloc(1, sizeof *t);
    *worker_ = t;
    if (t != NULL) {
        t->lanes = j->lanes;
        t->lane = calloc((size_t)j->lanes, sizeof *t->lane);
        t->status = calloc((size_t)j->lanes, sizeof *t->status);
    }
    if (t == NULL || t->lane == NULL || t->status == NULL) {
        return lab__no_memory(err);
    }
    stein_status status = STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < t->lanes; i++) {
        status = lane_create(&t->lane[i], j->equations, err);
    }
    return status == STEIN_OK
               ? stein_batch_create(&t->together, j->equations, j->batch->sim, t->lanes, 0, err)
               : status;
}

/* ---- a point ---- */

/* hand over the result of the lane's point, and empty the lane */
static stein_status finish_point(job *j, worker *t, int i, stein_status status, stein_err *err)
{
    const lab__batch *b = j->batch;
    lane *s = &t->lane[i];
    lab_stroke stroke;
    int is_stroke = status == STEIN_OK && j->equations->stroke.string >= 0;
    if (is_stroke) {
        lab__runner_stroke(s->runner, &stroke);
    }
    (void)stein_batch_put(t->together, i, NULL, NULL);
    status = b->run(b->ctx, s->point, s->sim, is_stroke ? &stroke : NULL, status, err);
    lab__runner_drop(s->runner);
    stein_sim_destroy(s->sim);
    s->runner = NULL;
    s->sim = NULL;
    s->point = -1;
    pthread_mutex_lock(&j->lock);
    j->done++;
    if (status == STEIN_OK && b->progress != NULL) {
        b->progress(b->progress_ctx, j->done, j->npoint);
    }
    pthread_mutex_unlock(&j->lock);
    return status;
}

/* begin a point in a lane; a failure of the point is its result */
static stein_status begin_point(const job *j, worker *t, int i, int point, stein_status *failed,
                                stein_err *err)
{
    const lab__batch *b = j->batch;
    lane *s = &t->lane[i];
    s->point = point;
    memcpy(s->p, lab_parameters(b->model), sizeof *s->p * (size_t)s->model.np);
    b->set(b->ctx, point, s->p);
    for (int k = 0; k < s->model.np; k++) {
        s->params[k].value = s->p[k];
    }
    *failed = stein_sim_create(&s->sim, &s->model, b->sim, err);
    if (*failed == STEIN_OK) {
        *failed =
            lab__runner_new(&s->runner, s->sim, b->def, b->steps, s->model.stroke.string >= 0, err);
    }
    if (*failed == STEIN_OK) {
        *failed = stein_batch_put(t->together, i, s->sim, err);
    }
    return *failed == STEIN_ENOMEM ? STEIN_ENOMEM : STEIN_OK;
}

/* operations of the run in a lane between steps; *over: it does no more.
 * @return its status */
static stein_status advance_lane(worker *t, int i, stein_status status, int *over, stein_err *err)
{
    lane *s = &t->lane[i];
    lab__need need = status != STEIN_OK ? LAB_TO_CHANGE : lab__runner_needs(s->runner);
    double stop;
    if (need == LAB_TO_CHANGE) {
        (void)stein_batch_sim(t->together, i);
    } else if (need == LAB_TO_LOOK) {
        (void)stein_batch_look(t->together, i);
    }
    status = lab__runner_next(s->runner, status, &stop, err);
    while (isfinite(stop)) { // only where the whole of it was asked for
        status = stein_run(s->sim, stop, err);
        status = lab__runner_next(s->runner, status, &stop, err);
    }
    *over = isnan(stop);
    return status;
}

/* fill empty lanes from the chunk, advance all; after the end of a run its lane is filled at once.
 * @param steps  out: so many are next in all lanes; 0: none is left */
static stein_status advance_lanes(job *j, worker *t, int *next, int end, long *steps,
                                  stein_err *err)
{
    *steps = 0;
    for (int i = 0; i < t->lanes;) {
        lane *s = &t->lane[i];
        stein_status status = t->status[i];
        if (s->point < 0) {
            if (*next >= end) {
                i++;
                continue;
            }
            if (begin_point(j, t, i, j->point[(*next)++], &status, err) != STEIN_OK) {
                return STEIN_ENOMEM;
            }
        }
        int over = 1;
        if (s->runner != NULL) {
            status = advance_lane(t, i, status, &over, err);
        }
        t->status[i] = STEIN_OK;
        if (over) {
            status = finish_point(j, t, i, status, err);
            if (status != STEIN_OK) {
                return status;
            }
        } else {
            long wanted = lab__runner_steps(s->runner);
            *steps = *steps == 0 || wanted < *steps ? wanted : *steps;
            i++;
        }
    }
    return STEIN_OK;
}

/* ---- steps of controlled error ---- */

/* begin the next run of a lane, or finish its point */
static stein_status begin_run(job *j, worker *t, int i, stein_status status, stein_err *err)
{
    lane *s = &t->lane[i];
    double stop = NAN;
    if (s->runner != NULL) {
        do {
            (void)stein_batch_sim(t->together, i); // the next operation may change it
            status = lab__runner_next(s->runner, status, &stop, err);
            if (!isnan(stop)) {
                status = stein_batch_begin(t->together, i, stop, lab__runner_pace(s->runner), err);
            }
        } while (!isnan(stop) && status != STEIN_OK);
    }
    return isnan(stop) ? finish_point(j, t, i, status, err) : STEIN_OK;
}

/* one chunk of points, with steps of controlled error */
static stein_status work_controlled(job *j, worker *t, int next, int end, stein_err *err)
{
    stein_status status = STEIN_OK;
    int over = 0;
    while (status == STEIN_OK && over >= 0) {
        for (int i = 0; status == STEIN_OK && i < t->lanes; i++) {
            while (status == STEIN_OK && t->lane[i].point < 0 && next < end) {
                stein_status failed;
                status = begin_point(j, t, i, j->point[next++], &failed, err);
                status = status == STEIN_OK ? begin_run(j, t, i, failed, err) : status;
            }
        }
        if (status == STEIN_OK && lab__stop_asked(&j->batch->stop)) {
            status = lab__stop_work(err);
        }
        if (status == STEIN_OK) {
            stein_status ended;
            over = stein_batch_go(t->together, &ended, err);
            status = over >= 0 ? begin_run(j, t, over, ended, err) : STEIN_OK;
        }
    }
    return status;
}

/* ---- all of them ---- */

/* one chunk of points */
static stein_status work(void *ctx, void *worker_, int chunk, stein_err *err)
{
    job *j = ctx;
    worker *t = worker_;
    int next = chunk * j->chunk, end = next + j->chunk;
    long steps = 0;
    end = end > j->npoint ? j->npoint : end;
    stein_status status;
    if (j->batch->steps != NULL) {
        return work_controlled(j, t, next, end, err);
    }
    do {
        status = lab__stop_asked(&j->batch->stop) ? lab__stop_work(err)
                                                  : advance_lanes(j, t, &next, end, &steps, err);
        if (status == STEIN_OK && steps > 0) {
            (void)stein_batch_steps(t->together, steps, &steps, t->status, NULL);
        }
    } while (status == STEIN_OK && steps > 0);
    return status;
}

static int list_points(job *j)
{
    const lab__batch *b = j->batch;
    j->point = malloc(sizeof *j->point * ((size_t)b->n + 1));
    for (int i = 0; j->point != NULL && i < b->n; i++) {
        if (b->skip == NULL || !b->skip[i]) {
            j->point[j->npoint++] = i;
        }
    }
    return j->point != NULL;
}

/* as asked, but by the integrator that has an error estimate */
static stein_sim_def controlled_def(const lab__batch *batch)
{
    stein_sim_def def = batch->sim != NULL ? *batch->sim : lab_def(batch->model);
    def.integrator = STEIN_DP5;
    return def;
}

stein_status lab__batch_run(const lab__batch *batch, stein_err *err)
{
    const stein_sim_def def = controlled_def(batch);
    lab__batch with_estimate = *batch;
    with_estimate.sim = &def;
    job j = {.batch = batch->steps != NULL ? &with_estimate : batch,
             .equations = lab_equations(batch->model)};
    j.lanes = stein_batch_width(j.equations);
    if (!list_points(&j)) {
        return lab__no_memory(err);
    }
    int rounds = j.npoint / (j.lanes * CHUNKS * (batch->threads > 0 ? batch->threads : 1));
    j.chunk = j.lanes * (rounds > 1 ? rounds : 1);
    if (pthread_mutex_init(&j.lock, NULL) != 0) {
        free(j.point);
        return lab__fail(err, STEIN_ENOMEM, "out of memory for threads");
    }
    const lab__thread_pool pool = {.n = (j.npoint + j.chunk - 1) / j.chunk,
                                   .threads = batch->threads,
                                   .begin = worker_create,
                                   .work = work,
                                   .end = worker_free,
                                   .ctx = &j};
    stein_status status = lab__thread_pool_run(&pool, err);
    pthread_mutex_destroy(&j.lock);
    free(j.point);
    return status;
}
