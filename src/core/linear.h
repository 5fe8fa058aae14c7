/* SPDX-License-Identifier: MIT
 * linear.h - what the files that linearise share.
 *
 *   linear.c           memory, the state           linear_outputs.c      C, D, edges
 *   linear_matrices.c  coordinates, A and B        linear_differences.c  slopes by differences
 *
 * Included by: this folder.
 */
#ifndef STEIN__LINEAR_H
#define STEIN__LINEAR_H

#include "slopes.h"
#include "stein/linear.h"

/* an input that is moved: what drives it otherwise, and how far */
typedef struct stein__nudge {
    stein_signal_fn *signal;
    void *ctx;
    double rest[2]; /* its value and rate without a signal */
    int which;      /* derivative that is moved: 0 its value, 2 the second one, of a motion */
    double more;
} stein__nudge;

struct stein_linear {
    const stein_model *model;
    stein_sim_def def;
    stein_linear_system system;
    stein_derivative *slopes; /* NULL: the equations have no derivatives */
    stein_sim *sim;           /* during a call */
    double *kept;             /* [2*nq] what its q, qd were before */

    int *joint, *input;   /* as in system */
    int *motion;          /* [nq] input that gives a coordinate its motion, -1: it has none */
    unsigned char *still; /* [nq] joints that are no coordinates: held, stuck, charts */
    double *A, *B, *C, *D, *T, *mass;
    double *W;            /* [nq*n] dqd/dz: how the speeds of the joints change with z */
    double *M, *c;        /* [nq*nq], [nq] at the state */
    double *factor;       /* [nfree*nfree] of mass */
    int *pivot;           /* [nfree] */
    double *q, *qd;       /* [nq] at the state, prescribed ones in place */
    double *force;        /* [nq] of inputs, then by a unit of the state */
    double *product;      /* [nq*n] of a matrix and T */
    double *K;            /* [n*n] T^T of that */
    double *points;       /* [npoint*(9 + 3*nq)] x, v, Jdot qd, J */
    double *by_q, *by_qd; /* [nq*nq] */
    double *row;          /* [max of 2*nq, nrow] work */
    double *slope, *off;  /* [nq + nchannel] along a direction; estimates of their errors */
    double *table;        /* [levels*(nq + nchannel)] differences of growing fineness */
    unsigned char *differences;
    stein_edge *edge;
    stein_signal_fn **signal; /* [ninput] of the simulation, while joints move otherwise */
};

/* which joints have a motion, which are still: held, charts of balls, what sticks. @return OK,
 * EINVAL (a contact sticks) */
stein_status stein__linear_joints(stein_linear *l, stein_err *err);
/* the independent ones of the others, n and nfree */
void stein__linear_coordinates(stein_linear *l);
/* T, masses, A, B, and C by differences. @return OK, ESINGULAR */
stein_status stein__linear_matrices(stein_linear *l, stein_err *err);
/* qdd [nq], then all channels, along dq, dqd [nq] with modes of contacts as they are, or, where
 * these are NULL, by an input (nullable), a motion by its acceleration: to slope, the estimate of
 * its errors to off. @return OK, ESINGULAR */
stein_status stein__linear_differences(stein_linear *l, const double *dq, const double *dqd,
                                       stein__nudge *nudge, stein_err *err);
int stein__linear_levels(void);
/* the generalised forces [nq] of a unit of input i of the model; 0 of a motion */
void stein__linear_force(const stein_linear *l, int i, double *force);
/* C and D, when A, B and C by differences are there. @return OK, ESINGULAR */
stein_status stein__linear_outputs(stein_linear *l, stein_err *err);
/* the state as it was, after differences */
void stein__linear_restore(stein_linear *l);
/* at the last evaluation */
void stein__linear_edges(stein_linear *l);

#endif
