/* SPDX-License-Identifier: MIT
 * slopes.h - what the files that derive qdd share.
 * Included by: this folder.
 */
#ifndef STEIN_SLOPES_H
#define STEIN_SLOPES_H

#include "core.h"
#include "direction.h"
#include "stein/derivative.h"

/** A block that is cut in parts, or only measured. */
typedef struct stein__arena {
    unsigned char *base; /* NULL: measured */
    size_t used;
} stein__arena;

static inline void *stein__carve(stein__arena *a, size_t size)
{
    void *at = a->base == NULL ? NULL : a->base + a->used;
    a->used += (size + 15u) / 16u * 16u;
    return at;
}

static inline double *stein__carve_doubles(stein__arena *a, int n)
{
    return stein__carve(a, sizeof(double) * (size_t)n);
}

/* from, or 0 where there is none, [n] */
static inline void stein__vector_to(double *to, const double *from, int n)
{
    for (int i = 0; i < n; i++) {
        to[i] = from != NULL ? from[i] : 0.0;
    }
}

/** Derived constants along a direction of parameters. */
typedef struct stein__constants {
    double *dd; /* [nd] */
    int *moved; /* [n] where it is not 0 */
    int n;
} stein__constants;

/** Of a joint, or the motion of a body: (u, v) where it would carry the origin of the fixed frame.
 */
typedef struct stein__twist {
    double w, u, v; /* [rad/s], [m/s] a unit of the coordinate, or in all */
} stein__twist;

/** The same at the place of a contact, along its normal and tangent. */
typedef struct stein__local {
    double w, a, b;
} stein__local;

/** A joint between the two bodies of a contact, and on whose side. */
typedef struct stein__step {
    int joint, first;
    stein__local at;
} stein__step;

/** Points of bodies that leave the plane, where a force acts on one; rows = 3*npoint, else 0. */
typedef struct stein__points {
    double *x, *v, *J;        /* [rows], [rows], [rows*nq] at the place */
    double *H;                /* [nq*nq*rows] d2x by each two coordinates */
    double *dx, *dv, *dJ;     /* along a direction */
    double *a, *waste, *unit; /* [rows], [rows*nq], [nq] work */
} stein__points;

struct stein_derivative {
    const stein_model *model;
    stein_sim_def def;
    stein_sim *sim;         /* whose last evaluation is derived; NULL: none */
    int placed;             /* 1: the tangent is at that place */
    const stein_sim *known; /* whose parameters the tangent has, and as of when */
    unsigned taken;
    int *parent, *driver;
    int driven;                        /* 1: there is a joint that is not free */
    double *qdd;                       /* [nq] */
    double *factor, *inverse;          /* M of the free joints: [nq*nq], [nq] */
    double *dp;                        /* [np] a direction of parameters */
    stein__constants none, own;        /* of no direction, of that one */
    double *dq, *dqd, *dQ, *dR, *dqdd; /* [nq] */
    double *du;                        /* [3*ninput] */
    stein_pose *dpose;                 /* [nframe] */
    double *M;                         /* [nq*nq] */
    double *c;                         /* [nq] */
    double *Qq, *Qqd, *Rq, *Rqd;       /* [nq*nq] */
    stein__twist *S, *V;               /* [nq] of the joints, of the bodies */
    stein__step *way;                  /* [nq] */
    stein__points points;
    void *tangent;
};

/* derivative.c: bytes of a block for stein__derivative_make(), 0 of a model without derivatives;
 * the block is the caller's */
size_t stein__derivative_size(const stein_model *model);
stein_derivative *stein__derivative_make(void *block, const stein_model *model);
/* derivative.c: as stein_derivative_at, of a simulation that no hook of forces acts on. Forces at
 * points off the plane have derivatives by q and qd, none by parameters. */
stein_status stein__derivative_at(stein_derivative *s, stein_sim *sim, double t, const double *q,
                                  const double *qd, double *qdd, stein_err *err);

/* derivative.c: M qdd + c - Q at the place by every q and qd, [nq*nq], also of joints that follow a
 * signal */
void stein__derivative_residual(stein_derivative *s, double *by_q, double *by_qd);

/* points.c: can a force act at a point off the plane? Its H at the place; the points along {dq,
 * dqd}
 */
int stein__points_matter(const stein_model *model);
void stein__points_carve(stein__points *p, stein__arena *a, const stein_model *m);
void stein__points_place(stein_derivative *s);
void stein__points_along(stein_derivative *s);

/* derivative.c: derived constants along dp at the parameters of the place; room for them */
void stein__constants_along(stein_derivative *s, const double *dp, stein__constants *to);
stein__constants stein__carve_constants(stein__arena *a, const stein_model *model);
/* derivative.c: as stein_derivative_along; all guards along a direction of positions and parameters
 */
void stein__along(stein_derivative *s, const double *dq, const double *dqd,
                  const stein__constants *dd, double *dqdd);
void stein__guards_along(stein_derivative *s, const double *dq, const stein__constants *dd,
                         double *dguard);

/* slopes.c: by every q and qd, when the forces are all of contacts, notches and joints; else 0 */
int stein__touch_slopes(stein_derivative *s, double *Qq, double *Qqd);

#endif
