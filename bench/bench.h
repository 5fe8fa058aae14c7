/* SPDX-License-Identifier: GPL-3.0-or-later
 * bench.h - shared by the files of the benchmark.
 *
 *   bench.c       options, order, CSV
 *   timing.c      cases, rounds, ratios
 *   operations.c  equations counted, against those of other generators
 *   closed.c      equations by hand against generated ones
 *   mujoco.c      the same by MuJoCo
 *   equations.c   the same in lanes
 *   runtime.c     qdd, steps, strokes, batches
 *   derivative.c  qdd by q, qd and parameters
 *   instrument.c  61 actions at audio rate
 *   precision.c   error of a stroke against time
 *   stiff.c       the stiff governor against CVODE
 *   peers.c       the steppers of others (GSL, CVODE)
 *
 * Cases are timed in turn within each round, so a machine that changes its speed changes all of
 * them alike: a ratio is taken within a round, its median and quartiles over the rounds. Every case
 * is checked against a reference before it is timed (bench_check).
 */
#ifndef BENCH_H
#define BENCH_H

#include <stdio.h>

#include "stein/batch.h"
#include "stein/lab.h"
#include "stein/stein.h"

enum { BENCH_ROUNDS = 21, BENCH_STATES = 256, BENCH_NQ = 16 };

typedef struct bench_case bench_case;
/** n operations; whatever they compute has to reach the number that is returned. */
typedef double bench_run(void *ctx, long n);

struct bench_case {
    const char *group, *subject, *what;
    bench_run *run;
    void *ctx;
    const stein_ops *ops; /* NULL: not counted */
    long least;           /* operations that go together, 0 or 1: none */
    long count;           /* operations in a block */
    double ns[BENCH_ROUNDS];
};

/** CPU time of the process [ns]. */
double bench_clock(void);
/** A number in [-1, 1), the same ones in every run. */
double bench_noise(void);
/** Memory, or the end of the program. */
void *bench_alloc(size_t size);
/** The end of the program when a call fails. */
void bench_need(stein_status status, const stein_err *err, const char *what);

/** Timed code has to be correct: |error| <= bound, or the program ends with 1 after everything. */
void bench_check(const char *what, double error, double bound);
int bench_failures(void);

/** A case; it is timed when its group, subject or name holds the filter. @return NULL otherwise */
bench_case *bench_add(const char *group, const char *subject, const char *what, bench_run *run,
                      void *ctx);
void bench_filter(const char *part);
void bench_measure(void);
/** Quantile of n <= BENCH_ROUNDS numbers, which are not changed. */
double bench_quantile(const double *x, int n, double share);
double bench_median(const bench_case *c);
void bench_print_cases(FILE *csv);

/** A row of the table of ratios: time of a over time of b, times `scale`. Nothing without both.
 *  @param bar  what it should be at most (with at_least: at least); 0: none is set */
void bench_ratio(const char *what, const bench_case *a, const bench_case *b, double scale,
                 double bar, int at_least);
/** A row with figures [n] from another source. */
void bench_row(const char *what, const double *figure, int n, double bar, int at_least);
void bench_print_ratios(FILE *csv);

/** States of a model for its evaluations: near the one of rest, in a ring. */
typedef struct bench_states {
    double q[BENCH_STATES][BENCH_NQ], qd[BENCH_STATES][BENCH_NQ];
} bench_states;
void bench_fill_states(bench_states *s, const stein_sim *sim);

/* the parts: cases first, ratios when they have been measured */
void operations_rows(void);
void closed_add(void);
void closed_rows(void);
void runtime_add(void);
void runtime_rows(void);
void derivative_add(void);
void derivative_rows(void);
void instrument_rows(void);
void stiff_rows(void);
void worst_rows(void);
/** @param picture  where the work-precision plot goes, CSV beside it; NULL: none */
void precision_rows(const char *picture, FILE *csv);

#endif
