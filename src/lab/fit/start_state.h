/* SPDX-License-Identifier: GPL-3.0-or-later
 * start_state.h - what initial.c needs of one stroke's beginning. Not installed.
 */
#ifndef FIT_START_STATE_H
#define FIT_START_STATE_H

#include "fitting.h"

/** What is estimated for one stroke. */
typedef struct fit__estimate {
    double *q, *qd, *q_sd, *qd_sd; /* [nq] deviations from the stroke's reset state; sd */
    double *q_prior, *qd_prior;    /* [nq] sd */
    double *shown;                 /* [nch] value of every channel, NAN: unknown */
    int known;                     /* 0: the record says nothing, or no state can be read */
    double length;                 /* of the start window [s] */
    double rate;                   /* at which the channels move [rad/s] */
} fit__estimate;

static inline int fit__is_initial(const fit__unknown *u)
{
    return u->kind == FIT__POSITION || u->kind == FIT__SPEED;
}

/** Overwrites b->x and b->y. @return 1 when the record says something of the state */
int fit__estimate_state(const fit__problem *p, fit__bench *b, int stroke, fit__estimate *e);

#endif
