/* SPDX-License-Identifier: GPL-3.0-or-later
 * equations.h - M and c of piano3 for many states in lanes; equations.c is compiled once a width.
 */
#ifndef BENCH_EQUATIONS_H
#define BENCH_EQUATIONS_H

typedef struct equations_in_lanes {
    int lanes;
    /** Derived constants [nd] into all lanes, kept for the next calls. */
    void (*prepare)(const double *d, int nd);
    /** `lanes` states: component k of lane l is at [k * lanes + l]. Every array begins at a
     * multiple of 64 bytes. */
    void (*mass_bias)(const double *q, const double *qd, double *M, double *c);
    /** The same of n states, a multiple of `lanes`, group behind group. @return the sum of what the
     *  simple tree has in M and c, which are kept no longer than a state's alone */
    double (*sum)(const double *q, const double *qd, int n);
} equations_in_lanes;

extern const equations_in_lanes equations2, equations4, equations8;
/** NULL where there are none. */
const equations_in_lanes *equations_of_width(int lanes);

#endif
