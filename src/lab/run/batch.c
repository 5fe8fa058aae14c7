/* SPDX-License-Identifier: GPL-3.0-or-later
 * batch.c - many runs of one model, on the threads of a crew and in the lanes of each.
 *
 * Each point gets a simulation made from a descriptor whose defaults are the point's parameters -
 * as if the file had said so. Nothing of one point reaches another one, so any number of threads
 * and lanes gives the same bits, and a parameter set without equilibrium fails alone. Creating a
 * simulation costs one allocation, nothing beside a stroke.
 *
 * A thread takes points in heaps. Each of its seats, one a lane, has a run that says what its
 * simulation is to do next; where that is a fixed step or more, all of them do it at once, and
 * steps of controlled error go side by side, each at its own pace. A seat whose run is over takes
 * the next point of the heap.
 */
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "run.h"
#include "stein/batch.h"

enum { HEAPS = 4 }; /* for each thread, so that none waits long for the last one */

typedef struct job {
    const lab__batch *batch;
    const stein_model *equations;
    int *point; /* [npoint] what is to be done */
    int npoint, heap, lanes, done;
    pthread_mutex_t lock; /* of done */
} job;

/* a lane and who is in it */
typedef struct seat {
    stein_model model; /* params are the ones below */
    stein_param *params;
    double *p;
    int point; /* -1: nobody */
    stein_sim *sim;
    lab__play *play;
} seat;

/* what a thread has of its own */
typedef struct bench {
    seat *seat; /* [lanes] */
    int lanes;
    stein_batch *side_by_side;
    stein_status *status; /* [lanes] of the last step */
} bench;

static void put_away(void *bench_)
{
    bench *t = bench_;
    if (t == NULL) {
        return;
    }
    for (int i = 0; t->seat != NULL && i < t->lanes; i++) {
        lab__play_drop(t->seat[i].play);
        stein_sim_destroy(t->seat[i].sim);
        free(t->seat[i].params);
        free(t->seat[i].p);
    }
    stein_batch_destroy(t->side_by_side);
    free(t->seat);
    free(t->status);
    free(t);
}

static stein_status furnish(seat *s, const stein_model *equations, stein_err *err)
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

static stein_status set_up(void *ctx, void **bench_, stein_err *err)
{
    const job *j = ctx;
    bench *t = calloc(1, sizeof *t);
    *bench_ = t;
    if (t != NULL) {
        t->lanes = j->lanes;
        t->seat = calloc((size_t)j->lanes, sizeof *t->seat);
        t->status = calloc((size_t)j->lanes, sizeof *t->status);
    }
    if (t == NULL || t->seat == NULL || t->status == NULL) {
        return lab__no_memory(err);
    }
    stein_status status = STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < t->lanes; i++) {
        status = furnish(&t->seat[i], j->equations, err);
    }
    return status == STEIN_OK
               ? stein_batch_create(&t->side_by_side, j->equations, j->batch->sim, t->lanes, 0, err)
               : status;
}

/* ---- a point ---- */

/* hand over what came out at the seat's point, and clear the seat */
static stein_status hand_over(job *j, bench *t, int i, stein_status status, stein_err *err)
{
    const lab__batch *b = j->batch;
    seat *s = &t->seat[i];
    lab_stroke stroke;
    int is_stroke = status == STEIN_OK && j->equations->stroke.string >= 0;
    if (is_stroke) {
        lab__play_stroke(s->play, &stroke);
    }
    (void)stein_batch_put(t->side_by_side, i, NULL, NULL);
    status = b->run(b->ctx, s->point, s->sim, is_stroke ? &stroke : NULL, status, err);
    lab__play_drop(s->play);
    stein_sim_destroy(s->sim);
    s->play = NULL;
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

/* a point takes the seat; its failures are its own */
static stein_status sit_down(const job *j, bench *t, int i, int point, stein_status *failed,
                             stein_err *err)
{
    const lab__batch *b = j->batch;
    seat *s = &t->seat[i];
    s->point = point;
    memcpy(s->p, lab_parameters(b->model), sizeof *s->p * (size_t)s->model.np);
    b->set(b->ctx, point, s->p);
    for (int k = 0; k < s->model.np; k++) {
        s->params[k].value = s->p[k];
    }
    *failed = stein_sim_create(&s->sim, &s->model, b->sim, err);
    if (*failed == STEIN_OK) {
        *failed =
            lab__play_new(&s->play, s->sim, b->def, b->steps, s->model.stroke.string >= 0, err);
    }
    if (*failed == STEIN_OK) {
        *failed = stein_batch_put(t->side_by_side, i, s->sim, err);
    }
    return *failed == STEIN_ENOMEM ? STEIN_ENOMEM : STEIN_OK;
}

/* what the run in a seat does between steps, up to where a step is next; *over: it does no more.
 * @return its status */
static stein_status go_on(bench *t, int i, stein_status status, int *over, stein_err *err)
{
    seat *s = &t->seat[i];
    lab__need need = status != STEIN_OK ? LAB_TO_CHANGE : lab__play_needs(s->play);
    double stop;
    if (need == LAB_TO_CHANGE) {
        (void)stein_batch_sim(t->side_by_side, i);
    } else if (need == LAB_TO_LOOK) {
        (void)stein_batch_look(t->side_by_side, i);
    }
    status = lab__play_next(s->play, status, &stop, err);
    while (isfinite(stop)) { // only where the whole of it was asked for
        status = stein_run(s->sim, stop, err);
        status = lab__play_next(s->play, status, &stop, err);
    }
    *over = isnan(stop);
    return status;
}

/* fill empty seats from the heap, let everyone go on; those that are over make room at once.
 * @param steps  out: so many are next for all; 0: nobody is left */
static stein_status go_round(job *j, bench *t, int *next, int end, long *steps, stein_err *err)
{
    *steps = 0;
    for (int i = 0; i < t->lanes;) {
        seat *s = &t->seat[i];
        stein_status status = t->status[i];
        if (s->point < 0) {
            if (*next >= end) {
                i++;
                continue;
            }
            if (sit_down(j, t, i, j->point[(*next)++], &status, err) != STEIN_OK) {
                return STEIN_ENOMEM;
            }
        }
        int over = 1;
        if (s->play != NULL) {
            status = go_on(t, i, status, &over, err);
        }
        t->status[i] = STEIN_OK;
        if (over) {
            status = hand_over(j, t, i, status, err);
            if (status != STEIN_OK) {
                return status;
            }
        } else {
            long wanted = lab__play_steps(s->play);
            *steps = *steps == 0 || wanted < *steps ? wanted : *steps;
            i++;
        }
    }
    return STEIN_OK;
}

/* ---- steps of controlled error ---- */

/* the next run of the play in a seat begins, or its point is over and the seat empty */
static stein_status begin_run(job *j, bench *t, int i, stein_status status, stein_err *err)
{
    seat *s = &t->seat[i];
    double stop = NAN;
    if (s->play != NULL) {
        do {
            (void)stein_batch_sim(t->side_by_side, i); // what is next may change it
            status = lab__play_next(s->play, status, &stop, err);
            if (!isnan(stop)) {
                status = stein_batch_begin(t->side_by_side, i, stop, lab__play_pace(s->play), err);
            }
        } while (!isnan(stop) && status != STEIN_OK);
    }
    return isnan(stop) ? hand_over(j, t, i, status, err) : STEIN_OK;
}

/* one heap of points, each at its own pace */
static stein_status go_paced(job *j, bench *t, int next, int end, stein_err *err)
{
    stein_status status = STEIN_OK;
    int over = 0;
    while (status == STEIN_OK && over >= 0) {
        for (int i = 0; status == STEIN_OK && i < t->lanes; i++) {
            while (status == STEIN_OK && t->seat[i].point < 0 && next < end) {
                stein_status failed;
                status = sit_down(j, t, i, j->point[next++], &failed, err);
                status = status == STEIN_OK ? begin_run(j, t, i, failed, err) : status;
            }
        }
        if (status == STEIN_OK && lab__stop_asked(&j->batch->stop)) {
            status = lab__stop_work(err);
        }
        if (status == STEIN_OK) {
            stein_status ended;
            over = stein_batch_go(t->side_by_side, &ended, err);
            status = over >= 0 ? begin_run(j, t, over, ended, err) : STEIN_OK;
        }
    }
    return status;
}

/* ---- all of them ---- */

/* one heap of points */
static stein_status work_on(void *ctx, void *bench_, int heap, stein_err *err)
{
    job *j = ctx;
    bench *t = bench_;
    int next = heap * j->heap, end = next + j->heap;
    long steps = 0;
    end = end > j->npoint ? j->npoint : end;
    stein_status status;
    if (j->batch->steps != NULL) {
        return go_paced(j, t, next, end, err);
    }
    do {
        status = lab__stop_asked(&j->batch->stop) ? lab__stop_work(err)
                                                  : go_round(j, t, &next, end, &steps, err);
        if (status == STEIN_OK && steps > 0) {
            (void)stein_batch_steps(t->side_by_side, steps, &steps, t->status, NULL);
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
static stein_sim_def paced(const lab__batch *batch)
{
    stein_sim_def def = batch->sim != NULL ? *batch->sim : lab_def(batch->model);
    def.integrator = STEIN_DP5;
    return def;
}

stein_status lab__batch_run(const lab__batch *batch, stein_err *err)
{
    const stein_sim_def def = paced(batch);
    lab__batch with_estimate = *batch;
    with_estimate.sim = &def;
    job j = {.batch = batch->steps != NULL ? &with_estimate : batch,
             .equations = lab_equations(batch->model)};
    j.lanes = stein_batch_width(j.equations);
    if (!list_points(&j)) {
        return lab__no_memory(err);
    }
    int rounds = j.npoint / (j.lanes * HEAPS * (batch->threads > 0 ? batch->threads : 1));
    j.heap = j.lanes * (rounds > 1 ? rounds : 1);
    if (pthread_mutex_init(&j.lock, NULL) != 0) {
        free(j.point);
        return lab__fail(err, STEIN_ENOMEM, "out of memory for threads");
    }
    const lab__crew crew = {.n = (j.npoint + j.heap - 1) / j.heap,
                            .threads = batch->threads,
                            .begin = set_up,
                            .work = work_on,
                            .end = put_away,
                            .ctx = &j};
    stein_status status = lab__crew_run(&crew, err);
    pthread_mutex_destroy(&j.lock);
    free(j.point);
    return status;
}
