/* SPDX-License-Identifier: MIT
 * batch_inner.h - a batch, as its two files see it.
 * Included by: this folder.
 */
#ifndef STEIN_BATCH_INNER_H
#define STEIN_BATCH_INNER_H

#include "core.h"
#include "lane.h"
#include "stein/batch.h"

enum { MAX_LANES = 8 };

/* where the state of a place is */
typedef enum seat {
    ALONE,   /* in the simulation, which cannot be in a lane */
    CHANGED, /* in the simulation; all of it has to go to its lane */
    MOVED,   /* in the simulation; the lane has its parameters */
    SEEN,    /* in both */
    AWAY     /* in the lane */
} seat;

typedef struct berth {
    stein_sim *sim;
    seat seat;
} berth;

struct stein_batch {
    const stein_model *model;
    stein_sim_def def;
    const stein__width *width; /* NULL: one after the other */
    int n, lanes, ngroup;
    berth *place;        /* [n] */
    void **wide;         /* [ngroup] */
    stein_status *state; /* [n] of the present step or run */
    stein_pace **pace;   /* [n] of a run with steps of controlled error; NULL: none under way */
    stein__pacer *pacer; /* [n] and where it is */
    stein_err *why;      /* [n] why it failed */
};

/* state of place i from its lane into the simulation */
void stein__batch_fetch(stein_batch *b, int i);
/* the simulations of group g into their lanes; @return those in lanes, one bit each */
unsigned stein__batch_board(stein_batch *b, int g);

#endif
