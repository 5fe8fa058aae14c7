/* SPDX-License-Identifier: MIT
 * lane.h - the interface between a simulation and its lane: plain numbers only, so that
 * files compiled for any number of lanes can meet here.
 * Included by: this folder.
 */
#ifndef STEIN_LANE_H
#define STEIN_LANE_H

#include <stddef.h>

#include "stein/sim.h"

/** What a lane needs of a simulation. */
typedef struct stein__rider {
    const double *d, *q, *qd, *qdd;
    const unsigned char *mode;      /* [nguard] */
    int load_present;               /* 0: its body is held, its contact gone */
    stein_signal_fn *const *signal; /* [ninput] NULL: none there; and what they are called with */
    void *const *signal_ctx;
} stein__rider;

/** Steps of a lane: the one with the number i = 1, 2, .. ends at t0 + (taken + i) dt; with dt = 0 a
 *  single one at t0. */
typedef struct stein__grid {
    double t0, taken, dt;
} stein__grid;

/** Code for one number of lanes. `wide` is what make() returned. */
typedef struct stein__width {
    int lanes;
    /** Bytes of a block for make(). */
    size_t (*size)(const stein_model *model);
    void *(*make)(void *block, const stein_model *model, stein_integrator integrator);
    /** A simulation into a lane; with_d: its parameters and signals too, and ready() before the
     *  next trial. */
    void (*put)(void *wide, int lane, const stein__rider *from, int with_d);
    void (*ready)(void *wide);
    /** Steps of their grids [lanes] in all lanes, from t [lanes], up to `most`, or to the first one
     * that not all of the wanted (one bit each) take. A lane that meets an event or trouble does
     *  not. Signals of lanes that are not wanted are not asked.
     *  @param t      in and out: of the states
     *  @param tried  out: steps that those took that are returned; the others wanted took one less
     *  @return lanes that took the last one */
    unsigned (*steps)(void *wide, const stein__grid *grid, double *t, unsigned wanted, long most,
                      long *tried);
    /** State of a lane: q, qd, qdd [nq], and the error estimates of its last step. */
    void (*take)(const void *wide, int lane, double *q, double *qd, double *qdd, double error[2]);
    /** The trial step without taking it. @return those wanted that ended with numbers */
    unsigned (*trial)(void *wide, const double *t, const double *h, unsigned wanted);
    /** What it came to in a lane: q, qd, qdd at its end [nq], guards, error estimates. */
    void (*outcome)(const void *wide, int lane, double *q1, double *qd1, double *qdd1,
                    double *guard, double error[2]);
    /** And what it is worth with these tolerances and logarithms of the errors before, in all
     *  lanes [lanes]: see stein__graded. */
    void (*grade)(const void *wide, const double *h, const double *tolerance,
                  const double *log_last, double *e, double *log_e, double *factor);
    /** Lanes with a guard on the other side of its mode in the middle of the trial step of h. The
     *  guards of its end are gone then. */
    unsigned (*grazes)(void *wide, const double *h);
} stein__width;

/** processor.c: 8, 4 or 2. */
int stein__processor_lanes(void);

extern const stein__width stein__width2, stein__width4, stein__width8;

#endif
