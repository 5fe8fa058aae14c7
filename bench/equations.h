/* SPDX-License-Identifier: GPL-3.0-or-later
 * equations.h - M and c of piano3 for many states in lanes; equations.c is compiled once a width.
 */
#ifndef BENCH_EQUATIONS_H
#define BENCH_EQUATIONS_H

typedef struct equations_in_lanes {
    int lanes;
    /** Derived constants [nd] into all lanes, kept for the next calls. */
    void (*prepare)(const double *d, int nd);
    /** n states, a multiple of `lanes`: component k of lane l in group g is at [(g * size + k) *
     * lanes + l]. */
    void (*mass_bias)(const double *q, const double *qd, int n, double *M, double *c);
} equations_in_lanes;

extern const equations_in_lanes equations2, equations4, equations8;
/** NULL where there are none. */
const equations_in_lanes *equations_of_width(int lanes);

#endif
