/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_compare.h - one record simulated with the file's own numbers, as read or in another reading.
 * Included by: this folder.
 */
#ifndef DATA_COMPARE_H
#define DATA_COMPARE_H

#include "data_internal.h"

/** Another reading of a record. Start from data__as_it_is(). */
typedef struct data__reading {
    int column, other; /* that are scaled, or exchanged when other >= 0; -1: none */
    const char *unit;  /* all columns of this unit are scaled instead; NULL: not so */
    double factor;     /* of the columns */
    double time;       /* factor of the time */
} data__reading;
data__reading data__as_it_is(void);

/** How a channel of the record compares with its prediction. */
typedef struct data__match {
    int compared; /* 0: an input, or too few samples */
    int adapted;  /* 1: the initial state was taken from the record, which helps any reading */
    int place;    /* shows where something is, or how fast it is */
    /** sd(y - h) / (sd(y) + sd(h)): 0 the same motion, about 0.7 two that have nothing in common, 1
     *  the opposite motion or sizes that cannot be compared */
    double off;
    double
        line; /* the same of the best straight line: a reading that is not better is no evidence */
    double travel, predicted; /* 2 % to 98 % of the samples, and of the prediction [unit] */
} data__match;

/** Evaluations of the equations that a simulation may take. */
typedef struct data__patience {
    long used, most;
} data__patience;
/** A stein_force_fn. Absurd readings and settings make stiff runs that would take hours: with more
 *  evaluations than ctx, a data__patience, allows, the run fails. */
void data__lose_patience(void *ctx, double t, const double *q, const double *qd, double *Q);

/** Compare the beginning of a record, up to the third turning point of its channels, with the model
 *  at the file's numbers and the record's settings. Where the initial state is unknown it is taken
 *  from the first samples, as this reading shows them.
 *  @param match  [ncolumn] out
 *  @param patience  evaluations of the equations, in: at most; out: used
 *  @return OK (a simulation that fails is off by 1 everywhere), ENOMEM, EINVAL (nothing to compare)
 */
stein_status data__try(const lab_model *model, const lab_data *data, data__reading reading,
                       data__match *match, long *patience, stein_err *err);

#endif
