/* SPDX-License-Identifier: GPL-3.0-or-later
 * stroke_reader.h - a stroke while it is being simulated, for simulate.c and event_times.c.
 * Included by: this folder.
 */
#ifndef FIT_STROKE_READER_H
#define FIT_STROKE_READER_H

#include "fitting.h"

/** A signal with the clock it is on. */
typedef struct fit__clocked {
    const fit__signal *signal;
    double shift;
    const double *error; /* [n] of the signal: what is added at its knots; NULL: nothing */
    int at;              /* where it was read last */
} fit__clocked;

/** Times of events of one channel, as they come. */
typedef struct fit__caught {
    int most, found; /* measured ones that count; simulated ones among them */
    int closed;      /* 1: the place touches */
    double since;    /* when it closed [s of the simulation] */
} fit__caught;

/** A stroke that is being read. An instrument that lags shows at T what was at T - delay, so the
 *  channels have their own times; `next` is the first sample of each that is not read. */
struct fit__reader {
    const fit__stroke *s;
    double horizon, gain;
    int stride;
    double shift, error;  /* a frame recorded at t has the time (1 + error) t + shift */
    double *delay;        /* [nch] s */
    int *next;            /* [nch] */
    double *due;          /* [nch] their times, INFINITY: none is left [s] */
    fit__caught *caught;  /* [nch] */
    fit__clocked *signal; /* [nsignal], and those of the probe */
    double *force;        /* [knots] of its signals: their errors */
    double *y;
    stein_pace pace;
    double t_end;
    double from, last, limit; /* events count from; the last measured one that counts; where a
                                 simulation that lacks some ends at the latest [s] */
    long long most;           /* trial steps of the simulation when it ends at the latest */
    int bend, over; /* frames that have been asked for a bend; 1: the run to t_end has begun */
    stein_status status;
    stein_err *err;
};

/** Before a stroke's steps: which events are to come. Needs clock and horizon of the reader. */
void fit__events_ready(fit__bench *b);
/** Where the next run ends on the way to events that are still to come. @return 0: none is, or none
 *  can come any more */
int fit__events_next(const fit__bench *b, double *t_end);
/** After a stroke's steps: the times of events that it lacks, and of those that do not count. */
void fit__events_finish(fit__bench *b);

#endif
