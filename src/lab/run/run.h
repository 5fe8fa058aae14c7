/* SPDX-License-Identifier: GPL-3.0-or-later
 * run.h - simulations: one run, many runs on threads, their steps.
 *
 *   strike.c          one stroke, by its events; one run of any mechanism
 *   batch.c           many simulations
 *   thread_pool.c     work on threads
 *   stop.c            work that its caller stops
 *   step_tolerance.c  fixed steps, or steps of controlled error
 *   dot_product.c     sums of products
 *
 * Included by: src/lab, src/cli.
 */
#ifndef LAB_RUN_H
#define LAB_RUN_H

#include "open.h"

/* ---- step_tolerance.c ---- */

/** How runs are stepped: with controlled error, or (tolerance 0) with the file's fixed steps. */
typedef struct lab__steps {
    int channel;      /* whose error is stated, -1: none */
    double stated;    /* [its unit] */
    double tolerance; /* of a step [rad or m] */
    double longest;   /* step [s] */
} lab__steps;
/** @param stated  "CHANNEL=VALUE[unit]"; NULL: what the file states, else fixed steps
 *  @param fixed   1: the file's fixed steps, whatever it states
 *  @return OK, ENAME (no such channel), EINVAL, or what making a simulation returns */
stein_status lab__steps_of(lab__steps *steps, const lab_model *model, const char *stated, int fixed,
                           stein_err *err);

/* ---- strike.c ---- */

/** A run that returns step by step the next operation of its simulation. */
typedef struct lab__runner lab__runner;
/** State that the next call of lab__runner_next needs of a simulation that may be in a lane. It is
 * the values that are always up to date, the state for reading, or all of it for changing. */
typedef enum { LAB_NOTHING, LAB_TO_LOOK, LAB_TO_CHANGE } lab__need;
/** Begin a run of a simulation, which stays its owner's, as a stroke or as a motion
 *  without a verdict.
 *  @param steps  of controlled error, without samples (def->sample); NULL: fixed ones
 *  @return OK, EINVAL, ENOMEM */
stein_status lab__runner_new(lab__runner **play, stein_sim *sim, const lab_stroke_def *def,
                             const lab__steps *steps, int as_stroke, stein_err *err);
void lab__runner_drop(lab__runner *play);
lab__need lab__runner_needs(const lab__runner *play);
/** Steps that may be taken in one go before lab__runner_next is called, as long as there is no
 * event on the way; 1 at least. */
long lab__runner_steps(const lab__runner *play);
/** The pace of its runs, where their error is controlled. */
stein_pace *lab__runner_pace(lab__runner *play);
/** Between steps. @param status of the last operation, OK at the beginning
 *  @param stop  out: INFINITY: one step is next; a time: a run to it; NAN: it is over. Where the
 *               error is controlled always a run
 *  @return OK, or why it is over */
stein_status lab__runner_next(lab__runner *play, stein_status status, double *stop, stein_err *err);
/** Result of a finished stroke. */
void lab__runner_stroke(lab__runner *play, lab_stroke *stroke);
/** Output channel that reads `read` of thing `index`, counted absolutely; -1 when there is none. */
int lab__channel_of(const stein_model *model, stein_read_kind read, int index);

/* ---- stop.c ---- */

/** Function that stops long work. Zeros: none. */
typedef struct lab__stop {
    lab_stop_fn *fn;
    void *ctx;
} lab__stop;
int lab__stop_asked(const lab__stop *stop);
/** The failure with which work that shall stop goes up: out of memory: every caller passes it on,
 * and none takes it for a property of the model. @return ENOMEM */
stein_status lab__stop_work(stein_err *err);
/** At the public call that was given the question. @return ESTOPPED in place of ENOMEM, if that is
 *  why; else status */
stein_status lab__stop_end(stein_status status, const lab__stop *stop, stein_err *err);

/* ---- thread_pool.c ---- */

/** Work that several threads share. */
typedef struct lab__thread_pool {
    int n, threads;
    const unsigned char *skip; /* [n] 1: leave out this piece; may be NULL */
    /** Data of a thread; may be NULL. A failure ends the work. */
    stein_status (*begin)(void *ctx, void **worker, stein_err *err);
    /** One piece, in any order, from any thread. Anything but OK ends the work. */
    stein_status (*work)(void *ctx, void *worker, int i, stein_err *err);
    /** Ends the unfinished work of a thread when there is no piece left; may be NULL. As work. */
    stein_status (*rest)(void *ctx, void *worker, stein_err *err);
    void (*end)(void *worker); /* also after a failed begin; may be NULL */
    lab__stop stop;            /* asked before every piece */
    lab_progress_fn *progress; /* may be NULL; counts what is not skipped */
    void *progress_ctx, *ctx;
} lab__thread_pool;
/** @return OK, ENOMEM, or the first failure */
stein_status lab__thread_pool_run(const lab__thread_pool *pool, stein_err *err);

/* ---- dot_product.c ---- */

/** Sum of a[i] b[i] over n samples, in their order. */
double lab__dot(const double *a, const double *b, size_t n);
/** The same with each row of b [rows*n], to the last bit; sum [rows] out. */
void lab__dot_rows(const double *a, const double *b, size_t n, int rows, double *sum);

/* ---- batch.c ---- */

enum { LAB_THREADS = 64 };
/** Result at one point. Called from any thread, once a point, in any order; it stores only data of
 *  the point.
 *  @param sim     at the end of its run, from a reset with the point's parameters; NULL when there
 *                 was none
 *  @param stroke its result, if it was one and status is OK
 *  @param status  OK, or why there is no simulation or no stroke
 *  @return OK; anything else ends the batch */
typedef stein_status lab__point_fn(void *ctx, int point, stein_sim *sim, const lab_stroke *stroke,
                                   stein_status status, stein_err *err);
/** Many runs of one model, each with its parameters: strokes, where the model names one. */
typedef struct lab__batch {
    const lab_stroke_def *def; /* of every run, without samples */
    const lab_model *model;
    const stein_sim_def *sim; /* how they are computed; NULL: as the file states */
    const lab__steps *steps;  /* NULL: fixed steps */
    int n, threads;
    const unsigned char *skip;                    /* [n] 1: leave out this point; may be NULL */
    void (*set)(void *ctx, int point, double *p); /* p [np]: the file's values, to be changed */
    lab__point_fn *run;
    lab__stop stop;            /* asked between steps */
    lab_progress_fn *progress; /* may be NULL; counts what is not skipped */
    void *progress_ctx, *ctx;
} lab__batch;
/** @return OK, ENOMEM, or what `run` returned. Failures of a point are handed to `run`. */
stein_status lab__batch_run(const lab__batch *batch, stein_err *err);

#endif
