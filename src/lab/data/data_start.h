/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_start.h - the initial state of a record that nobody states.
 */
#ifndef DATA_START_H
#define DATA_START_H

#include "data_inner.h"
#include "fitting.h"

enum { DATA_FEWEST = 8 }; /* samples of a channel; fewer say nothing */

/** Distance of the 2 % and the 98 % quantile of the samples that are finite, at most 512 of them;
 *  0: too few. */
double data__travel(const double *v, int n);
int data__shows_place(stein_read_kind read);
int data__shows_speed(stein_read_kind read);

/** Unknown initial state of the first stroke of a problem from its first samples, in the unknowns.
 *  @param x  [nu] in, out: 0 where nothing is found
 *  @return OK, ENOMEM, or what the simulation says */
stein_status data__find_start(fit__problem *p, fit__bench *b, double *x, stein_err *err);
/** The same improved by Gauss-Newton steps on all samples.
 *  @param y  [rows] in, out: prediction at x
 *  @return OK, ENOMEM */
stein_status data__refine_start(fit__problem *p, fit__bench *b, double *x, double *y,
                                stein_err *err);

#endif
