/* SPDX-License-Identifier: GPL-3.0-or-later
 * peers.h - the steppers of other packages on our right-hand side.
 */
#ifndef BENCH_PEERS_H
#define BENCH_PEERS_H

#include "stein/sim.h"

/** A stroke from the state that the simulation is in, by one method with one setting.
 *  @param at   [n] times to be seen [s], increasing
 *  @param q    [n*nq] out
 *  @param calls  out: evaluations of the right-hand side
 *  @return 0, or -1 when the method gives up */
typedef int peer_run(const void *method, stein_sim *sim, double tolerance, const double *at, int n,
                     double *q, long *calls);

typedef struct peer {
    const char *name;
    peer_run *run;
    const void *method; /* which of a package's */
} peer;

/** The methods of GSL and, where it was there when this was compiled, CVODE. @return their number
 */
int peers_all(const peer **list);

#endif
