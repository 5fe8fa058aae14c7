/* SPDX-License-Identifier: GPL-3.0-or-later
 * row.h - seats in which strokes are simulated side by side, for many.c and pool.c.
 * Included by: this folder.
 */
#ifndef FIT_ROW_H
#define FIT_ROW_H

#include "fitting.h"
#include "stein/batch.h"

/* simulations that somebody wants, as fit__many has them */
typedef struct fit__jobs {
    fit__ask *ask;
    fit__take *take;
    void *ctx;
} fit__jobs;

typedef struct fit__seat {
    fit__bench bench; /* made for the first who sits here */
    fit__jobs *jobs;  /* whose job it is */
    int made, taken, job;
} fit__seat;

/* seats that one thread drives at a time, one a lane */
typedef struct fit__row {
    const fit__problem *p; /* what benches are made for */
    fit__seat *seat;       /* [n] */
    int n, taken;
    stein_batch *batch;
    fit__jobs *over; /* whose job the last call has ended, NULL: it has ended none */
} fit__row;

/** Free in any case. @return OK, ENOMEM, the failure of making a batch */
stein_status fit__row_make(fit__row *r, const fit__problem *p, stein_err *err);
void fit__row_free(fit__row *r);
/** A job of `jobs`, which stay where they are, begins in a free seat; one that cannot ride is over
 *  at once. @return OK, ENOMEM, the failure of making a simulation; how a stroke fails is told to
 *  `take` */
stein_status fit__row_begin(fit__row *r, fit__jobs *jobs, int job, stein_err *err);
/** All who sit there go on until one run is over. @return OK, ENOMEM */
stein_status fit__row_go(fit__row *r, stein_err *err);

/** pool.c: fit__many in the rows of a pool. @return OK, ENOMEM, the failure of making a simulation
 */
stein_status fit__pool_run(fit__pool *pool, const fit__jobs *jobs, int n, stein_err *err);

#endif
