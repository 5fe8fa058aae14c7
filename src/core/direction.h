/* SPDX-License-Identifier: MIT
 * direction.h - the interface between a simulation and the derivatives of its forces: plain numbers
 * only, so that files whose reals are numbers with a derivative (tangent.h) can meet the others
 * here.
 * Included by: this folder.
 */
#ifndef STEIN_DIRECTION_H
#define STEIN_DIRECTION_H

#include <stddef.h>

#include "stein/sim.h"

enum { STEIN__POSE = 7 }; /* numbers of a stein_pose, in its order */

/** What forces are evaluated at, and their direction; those marked + may be NULL for 0. */
typedef struct stein__at {
    const double *d, *q, *qd;
    const double *pose;         /* [7*nframe] */
    const double *u;            /* [3*ninput] signals with their gains */
    const double *px, *pv, *pJ; /* + [3*npoint], [3*npoint], [3*npoint*nq] points off the plane */
    stein_signal_fn *const *signal;
    const unsigned char *mode;
    int load_present, signals;
} stein__at;
typedef struct stein__direction {
    const double *dq, *dqd, *dpose, *du; /* + */
    const double *dpx, *dpv, *dpJ;       /* as px, pv, pJ; dpx + for all of them */
    const double *dd;
    const int *moved; /* [nmoved] where dd is not 0 */
    int nmoved;
} stein__direction;

/** Slopes of laws, each as the law is written (laws.h). A normal force by depth and its rate; mu by
 * u at u, whose tanh is known; a joint's force by q and qd, with the slope of its friction by qd.
 */
void stein__normal_slopes(const double *law, double x, double xdot, double *by_x, double *by_xdot);
double stein__mu_slope(const double *law, double u, double tanh_u);
void stein__joint_slopes(const double *law, double q, double qd, double friction, double *by_q,
                         double *by_qd);

/** Bytes of a block for stein__tangent_make(). */
size_t stein__tangent_size(const stein_model *model);
void *stein__tangent_make(void *block, const stein_model *model);
/** Where the following directions begin; with_d: its parameters are others than last time. */
void stein__tangent_place(void *tangent, const stein__at *at, int with_d);
/** Generalised forces of everything but hooks along a direction, [nq]. */
void stein__tangent_forces(void *tangent, const stein__direction *way, double *dQ);
/** All guards along a direction of positions and parameters, [nspot + 4 nnotch]. */
void stein__tangent_guards(void *tangent, const stein__direction *way, double *dguard);

#endif
