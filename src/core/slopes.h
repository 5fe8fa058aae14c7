/* SPDX-License-Identifier: MIT
 * slopes.h - what the files that derive qdd share. Not installed.
 */
#ifndef STEIN_SLOPES_H
#define STEIN_SLOPES_H

#include "core.h"
#include "direction.h"
#include "stein/derivative.h"

/** Of a joint, or the motion of a body: (u, v) where it would carry the origin of the fixed frame. */
typedef struct stein__twist {
    double w, u, v; /* [rad/s], [m/s] a unit of the coordinate, or in all */
} stein__twist;

struct stein_derivative {
    const stein_model *model;
    stein_sim_def def;
    stein_sim *sim; /* whose last evaluation is derived; NULL: none */
    int placed;     /* 1: the tangent is at that place */
    int *parent, *driver;
    int driven;                         /* 1: there is a joint that is not free */
    double *qdd;                        /* [nq] */
    double *factor, *inverse;           /* M of the free joints: [nq*nq], [nq] */
    double *dp, *dd;                    /* [np], [nd] a direction of parameters and of d */
    double *dq, *dqd, *dQ, *dR, *dqdd;  /* [nq] */
    double *du;                         /* [3*ninput] */
    stein_pose *dpose;                  /* [nframe] */
    double *M;                          /* [nq*nq] */
    double *c;                          /* [nq] */
    double *Qq, *Qqd, *Rq, *Rqd; /* [nq*nq] */
    stein__twist *S, *V;       /* [nq] */
    int *way;                  /* [nq] joints between the bodies of a pair */
    double *side;              /* [nq] */
    double *along_n, *along_t; /* [nq] s_j S_j . N and . T */
    void *tangent;
};

/* slopes.c: by every q and qd, when the forces are all of contacts, notches and joints; else 0 */
int stein__touch_slopes(stein_derivative *s, double *Qq, double *Qqd);

#endif
