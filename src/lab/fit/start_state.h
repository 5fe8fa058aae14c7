/* SPDX-License-Identifier: GPL-3.0-or-later
 * start_state.h - what initial.c needs of one stroke's beginning.
 * Included by: this folder.
 */
#ifndef FIT_START_STATE_H
#define FIT_START_STATE_H

#include "fitting.h"

/** What is estimated for one stroke. */
typedef struct fit__estimate {
    double *q, *qd, *q_sd, *qd_sd; /* [nq] deviations from the stroke's reset state; sd */
    double *q_prior, *qd_prior;    /* [nq] sd */
    double *shown;                 /* [nch] value of every channel, NAN: unknown */
    int known;                     /* 0: no channel can be used, or no state can be read */
    double length;                 /* of the start window [s] */
    double rate;                   /* at which the channels move [rad/s] */
} fit__estimate;

static inline int fit__is_initial(const fit__unknown *u)
{
    return u->kind == FIT__POSITION || u->kind == FIT__SPEED;
}

/** Room for one stroke at work. */
typedef struct fit__beginning {
    const fit__problem *p;
    fit__bench *b;
    const fit__stroke *s;
    int nq, nfree, *joint;      /* [nfree] joints that are estimated */
    double *q0, *qd0;           /* [nq] reset state */
    double *q, *qd, *to, *grad; /* [nq] */
    double *H, *A, *base;       /* [nch*nq], [nq*nq], [nch] */
    fit__start *start;          /* [nch]; samples 0: the channel is not used */
    double *offset;             /* [nch] sd of its marker */
    fit__estimate *e;
} fit__beginning;

static inline const stein_channel *fit__channel_of(const fit__beginning *w, int c)
{
    return &lab_equations(w->p->model)->channels[w->s->channel[c]];
}

/* ---- start_kinematics.c ---- */

/** Does the value of a channel depend on the position at the start? One that counts from the
 * initial state does not. */
int fit__measures_place(const fit__beginning *w, int c);
/** Levenberg-Marquardt on the positions from w->q, which is the minimum then. @return objective
 *  there; INFINITY when no state near can be read */
double fit__find_positions(fit__beginning *w);
/** Standard deviations of the positions at w->q. @param sd  [nq] out  @return 0, -1 */
int fit__position_sd(fit__beginning *w, double *sd);
/** Speeds at w->q to w->qd, from slopes and channels that read a speed. @param sd  [nq] out, may be
 *  NULL  @return 0, -1 */
int fit__find_speeds(fit__beginning *w, double *sd);

/* ---- start_state.c ---- */

/** Overwrites b->x and b->y. @return 1 when there is an estimate */
int fit__estimate_state(const fit__problem *p, fit__bench *b, int stroke, fit__estimate *e);

#endif
