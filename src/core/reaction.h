/* SPDX-License-Identifier: MIT
 * reaction.h - what reaction.c, reaction_loops.c and determined.c share.
 * Included by: this folder.
 */
#ifndef STEIN_REACTION_H
#define STEIN_REACTION_H

#include "core.h"
#include "wrench.h"

typedef struct body {
    double R[9], o[3];        /* axes and origin in the fixed frame */
    double w[3], dw[3], a[3]; /* angular velocity and acceleration, that of the origin less g */
    double axis[3];           /* of its joint, times the sign */
    /* of it alone, then of all that it carries: what its motion needs; what contacts, links and
     * inputs give, and what sticks; what joints transmit */
    wrench6 needs, given, stuck, held;
} body;

/* everything, in the memory of the simulation */
typedef struct work {
    const stein_sim *sim;
    body *body;
    wrench6 *unit;  /* [forces of all loops] on the second body */
    double *column; /* [forces][nq] s_j . w_k, then orthogonal */
    double *R;      /* [forces][forces] */
    double *mu;     /* [forces] */
    double *null;   /* [forces] that no joint feels */
    double *lack;   /* [nq] */
    int *first;     /* [nloop + 1] of the forces of a loop */
    int *order;     /* [forces] */
    double slack;   /* of forces that are free */
} work;

enum { MOST_FORCES = 6 }; /* of a loop */

/* axes of a body in the fixed frame; -1: those of the frame */
static inline void axes_of(const work *k, int of, double R[9])
{
    static const double unit[9] = {[0] = 1.0, [4] = 1.0, [8] = 1.0};
    memcpy(R, of >= 0 ? k->body[of].R : unit, sizeof unit);
}

/* reaction_loops.c: forces of loops into mu, and taken off what joints transmit */
void stein__loop_forces(work *k);

/* reaction.c: a reaction in the present state, with the slack for forces that are free. The state
 * has been evaluated (stein__refresh). */
double stein__reaction_of(stein_sim *sim, const stein_reaction *r, double slack);

#endif
