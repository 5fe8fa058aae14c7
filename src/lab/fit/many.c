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
 *
 * A fit of one stroke asks for one at a time, and would leave all lanes but one empty. So several
 * such fits share the seats: each has a thread that sleeps while its strokes are under way, and one
 * of those that wait drives a row, for whoever sits there.
 */
#include <pthread.h>
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
    // among several fits: jobs, the next that nobody has, how many are not over, why one has failed
    int jobs, next, left;
    stein_status status;
    stein_err why;
    struct asking *after; /* in the queue */
} asking;

typedef struct seat {
    fit__bench bench; /* made for the first who sits here */
    asking *asking;   /* whose job it is */
    int made, taken, job;
} seat;

/* the seats of a thread */
typedef struct row {
    const fit__problem *p; /* what benches are made for */
    seat *seat;            /* [n] */
    int n, taken, driven;
    stein_batch *batch;
    asking *over; /* whose job was over last, NULL: none was */
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
    r->p = a->p;
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
static stein_status get_up(row *r, int i, int failed, stein_err *err)
{
    seat *s = &r->seat[i];
    (void)stein_batch_put(r->batch, i, NULL, NULL);
    r->taken -= s->taken;
    s->taken = 0;
    r->over = s->asking;
    s->asking->take(s->asking->ctx, &s->bench, s->job, failed);
    return s->bench.no_memory ? no_memory(err) : STEIN_OK;
}

/* the next run of a job begins, or the job is over */
static stein_status next_run(row *r, int i, stein_status status, stein_err *err)
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
    return get_up(r, i, fit__finish(&s->bench, status) != STEIN_OK, err);
}

/* all seats go on until one run is over */
static stein_status go_on(row *r, stein_err *err)
{
    stein_status status;
    int i = stein_batch_go(r->batch, &status, NULL);
    return next_run(r, i, status, err);
}

/* on a free seat, of which there is one */
static stein_status sit_down(asking *a, row *r, int job, stein_err *err)
{
    int i = 0;
    while (r->seat[i].taken) {
        i++;
    }
    seat *s = &r->seat[i];
    if (!s->made) {
        s->made = 1;
        stein_status made = fit__bench_make(&s->bench, r->p, err);
        if (made != STEIN_OK) {
            return made;
        }
    }
    s->asking = a;
    s->job = job;
    stein_status status = a->ask(a->ctx, &s->bench, job);
    if (status == STEIN_OK && fit__can_ride(&s->bench)) {
        s->taken = 1;
        r->taken++;
        status = stein_batch_put(r->batch, i, s->bench.sim, NULL);
        return next_run(r, i, status, err);
    }
    if (status == STEIN_OK) {
        status = fit__finish(&s->bench, fit__alone(&s->bench));
    }
    s->bench.no_memory |= status == STEIN_ENOMEM;
    return get_up(r, i, status != STEIN_OK, err);
}

static stein_status next_job(void *ctx, void *bench, int job, stein_err *err)
{
    row *r = bench;
    stein_status status = STEIN_OK;
    while (status == STEIN_OK && r->taken == r->n) {
        status = go_on(r, err);
    }
    return status == STEIN_OK ? sit_down(ctx, r, job, err) : status;
}

static stein_status last_jobs(void *ctx, void *bench, stein_err *err)
{
    row *r = bench;
    stein_status status = STEIN_OK;
    (void)ctx;
    while (status == STEIN_OK && r->taken > 0) {
        status = go_on(r, err);
    }
    return status;
}

/* ---- several fits at once ---- */

struct fit__pool {
    pthread_mutex_t lock; /* of all that is below, but for a row that somebody drives */
    pthread_cond_t changed;
    asking *first; /* of those with jobs that nobody has */
    row **row;     /* [nrow] one for each thread of the problem */
    int nrow;
    int busy; /* fits that are not waiting for strokes: they may soon ask for some */
    fit__piece *piece;
    void *ctx;
};

static void tell_all(fit__pool *pool)
{
    pthread_cond_broadcast(&pool->changed);
}

static void job_is_over(fit__pool *pool, asking *a, stein_status status, const stein_err *why)
{
    if (status != STEIN_OK && a->status == STEIN_OK) {
        a->status = status;
        a->why = *why;
    }
    if (--a->left == 0) {
        tell_all(pool);
    }
}

/* The next job sits down in r, or all that sit there go on until one is over. @return 0: there is
 * nothing to do, or too few have asked yet */
static int drive_on(fit__pool *pool, row *r)
{
    asking *a = r->taken < r->n ? pool->first : NULL;
    int job = a != NULL ? a->next++ : 0;
    stein_err why = {STEIN_OK, ""};
    stein_status status;
    if (a != NULL && a->next == a->jobs) {
        pool->first = a->after;
    }
    if (a == NULL && (r->taken == 0 || (r->taken < r->n && pool->busy > 0))) {
        return 0;
    }
    r->over = NULL;
    pthread_mutex_unlock(&pool->lock);
    status = a != NULL ? sit_down(a, r, job, &why) : go_on(r, &why);
    pthread_mutex_lock(&pool->lock);
    a = r->over != NULL || status == STEIN_OK ? r->over : a;
    if (a != NULL) {
        job_is_over(pool, a, status, &why);
    }
    return 1;
}

/* a row that nobody drives, and that has something to do. @return NULL: none */
static row *idle_row(const fit__pool *pool)
{
    for (int i = 0; i < pool->nrow; i++) {
        row *r = pool->row[i];
        if (!r->driven && (r->taken > 0 || pool->first != NULL)) {
            return r;
        }
    }
    return NULL;
}

static void queue_up(fit__pool *pool, asking *a)
{
    asking **last = &pool->first;
    while (*last != NULL) {
        last = &(*last)->after;
    }
    *last = a;
}

/* a's jobs, done in the rows of the pool by whoever waits there */
static stein_status wait_for(fit__pool *pool, asking *a, stein_err *err)
{
    pthread_mutex_lock(&pool->lock);
    queue_up(pool, a);
    pool->busy--;
    tell_all(pool);
    while (a->left > 0) {
        row *r = idle_row(pool);
        int moved = 0;
        if (r != NULL) {
            r->driven = 1;
            do {
                moved = drive_on(pool, r);
            } while (moved && a->left > 0);
            r->driven = 0;
            tell_all(pool);
        }
        if (a->left > 0 && !moved) {
            pthread_cond_wait(&pool->changed, &pool->lock);
        }
    }
    pool->busy++;
    pthread_mutex_unlock(&pool->lock);
    return a->status == STEIN_OK ? STEIN_OK : lab__fail(err, a->status, "%s", a->why.msg);
}

static void count_fit(fit__pool *pool, int more)
{
    pthread_mutex_lock(&pool->lock);
    pool->busy += more;
    tell_all(pool);
    pthread_mutex_unlock(&pool->lock);
}

static stein_status join(void *ctx, void **bench, stein_err *err)
{
    (void)err;
    count_fit(ctx, 1);
    *bench = ctx;
    return STEIN_OK;
}

static void leave(void *bench)
{
    count_fit(bench, -1);
}

static stein_status one_fit(void *ctx, void *bench, int i, stein_err *err)
{
    fit__pool *pool = ctx;
    (void)bench;
    return pool->piece(pool->ctx, i, pool, err);
}

stein_status fit__together(const fit__problem *p, int n, fit__piece *piece, void *ctx,
                           stein_err *err)
{
    asking of = {.p = p};
    fit__pool pool = {.nrow = p->threads, .piece = piece, .ctx = ctx};
    pool.row = calloc((size_t)pool.nrow + 1, sizeof *pool.row);
    stein_status status =
        pool.row != NULL && pthread_mutex_init(&pool.lock, NULL) == 0 ? STEIN_OK : no_memory(err);
    int locked = status == STEIN_OK, sound = locked && pthread_cond_init(&pool.changed, NULL) == 0;
    status = locked && !sound ? no_memory(err) : status;
    for (int i = 0; status == STEIN_OK && i < pool.nrow; i++) {
        void *made = NULL;
        status = row_make(&of, &made, err);
        pool.row[i] = made;
    }
    if (status == STEIN_OK) {
        lab__crew crew = {.n = n,
                          .threads = pool.nrow * pool.row[0]->n,
                          .begin = join,
                          .work = one_fit,
                          .end = leave,
                          .ctx = &pool};
        status = lab__crew_run(&crew, err);
    }
    for (int i = 0; pool.row != NULL && i < pool.nrow; i++) {
        row_free(pool.row[i]);
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

/* ---- both ---- */

stein_status fit__many(const fit__problem *p, int jobs, fit__ask *ask, fit__take *take, void *ctx,
                       stein_err *err)
{
    asking a = {.p = p, .ask = ask, .take = take, .ctx = ctx, .jobs = jobs, .left = jobs};
    if (p->pool != NULL) {
        return jobs > 0 ? wait_for(p->pool, &a, err) : STEIN_OK;
    }
    lab__crew crew = {.n = jobs,
                      .threads = p->threads,
                      .begin = row_make,
                      .work = next_job,
                      .rest = last_jobs,
                      .end = row_free,
                      .ctx = &a};
    return lab__crew_run(&crew, err);
}
