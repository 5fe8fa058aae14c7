/* SPDX-License-Identifier: MIT
 * loops.h - what loops.c, partition.c and assemble.c share.
 * Included by: this folder.
 */
#ifndef STEIN_LOOPS_H
#define STEIN_LOOPS_H

#include "core.h"

#define STEIN__CLOSED        1e-12 /* gap of a loop that is closed [m or rad] */
#define STEIN__RANK_PIVOT    1e-8  /* of a row of J with largest element 1: not 0 */
#define STEIN__PASSING_PIVOT 1e-9  /* less: a singular position is passed */

/* a joint is independent, follows the others by a row of J, or is given */
enum { FREE, GIVEN, DEPENDENT };

/* ---- partition.c ---- */

/* of n numbers; INFINITY where one is none */
double stein__largest(const double *x, int n);
/* J x = rhs by elimination, with at most `rank` pivots of at least `least`. Joints that are given
 * have the role and, in x, the value already.
 * @return the largest |rhs| of a row without a pivot, in shares of its largest element */
double stein__partition(stein_sim *sim, const double *x, int rank, double least);
/* min 1/2 x^T M x - b^T x over J x = rhs, after that; M NULL: 1. x has the values of what is given;
 * b is worked with. @return -1, or the joint whose pivot vanishes */
int stein__partitioned(stein_sim *sim, const double *M, double *b, double *x);

/* ---- loops.c ---- */

/* h, J and Jdot qd at q */
void stein__loops_at(stein_sim *sim, const double *q, const double *qd);
/* joints that follow a signal or are held, and those marked in `kept` (nullable): given, as 0 */
void stein__give(stein_sim *sim, const unsigned char *kept, double *x);
/* how many pivots there are */
int stein__most_pivots(const stein_sim *sim);
/* dq with J dq = -h in the metric M into loop.x; `kept` joints stay */
void stein__loops_correct(stein_sim *sim, const double *M, const unsigned char *kept, int rank,
                          double least);
/* qd at q, whose J is there, onto J qd = 0. @return what is left, in m/s or rad/s by size 1 */
double stein__loops_speeds(stein_sim *sim, const double *M, const unsigned char *kept, double *qd);
/* the loop that is open widest, as it was looked at last */
const char *stein__worst_loop(const stein_sim *sim, double *gap, int *is_length);

/* ---- assemble.c ---- */

/* Newton from q, steps of least length, shortened until the gaps shrink; `kept` (nullable) joints
 * stay. @return is it closed? */
int stein__loops_close(stein_sim *sim, const unsigned char *kept, double *q);

#endif
