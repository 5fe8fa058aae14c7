/* SPDX-License-Identifier: MIT
 * batch.h - many simulations of one model, stepped side by side in the lanes of the processor.
 *
 * A batch steps simulations that belong to its user. Each has its own parameters, time, step
 * length, events and subscriber. Its motion has the same bits in a lane and alone. Lanes need not
 * be full; a finished simulation can be replaced by the next one:
 *
 *      put(batch, i, sim)  ->  step ... step  ->  sim(batch, i), read, put(batch, i, next)
 *
 * Lanes compute whole trial steps. A step with an event is computed alone, as by stein_step. Every
 * step is computed alone for a simulation with a force hook, a sensitivity or a force at a body
 * that leaves the plane, and for a model without equations compiled for lanes. Signals are called
 * by the thread that steps the batch, each at times of its own simulation.
 */
#ifndef STEIN_BATCH_H
#define STEIN_BATCH_H

#include "stein/sim.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct stein_batch stein_batch;

/** Simulations of a model that this processor steps side by side: 8, 4 or 2; 1 when the model has
 *  no lanes. The number of places is best a multiple of it. */
int stein_batch_width(const stein_model *model);

/** A batch with n empty places.
 *  @param def    integrator of the simulations to come, and the allocator; NULL for the defaults
 *  @param width  lanes to use, one of 8, 4, 2 that this processor has, or 1; 0: the most there are
 *  @return OK; ESTALE; EINVAL (a field of def, n, width or integrator out of range), ENOMEM */
stein_status stein_batch_create(stein_batch **batch, const stein_model *model,
                                const stein_sim_def *def, int n, int width, stein_err *err);
/** Release the batch, not the simulations. NULL is fine. A simulation that stein_batch_sim has not
 *  brought up to date keeps an earlier state. */
void stein_batch_destroy(stein_batch *batch);

/** Put a simulation into place i, or none (NULL). The simulation that was there is brought up to
 *  date. Take a simulation out of its place before it is destroyed.
 *  @return OK; EINVAL (no such place, other equations, or another integrator than the batch's) */
stein_status stein_batch_put(stein_batch *batch, int i, stein_sim *sim, stein_err *err);
/** The simulation in place i, up to date, or NULL. It may be read and changed in any way: its lane
 *  reads the whole state again. */
stein_sim *stein_batch_sim(stein_batch *batch, int i);
/** The same, only to be read: its lane keeps its state, which costs less. */
stein_sim *stein_batch_look(stein_batch *batch, int i);

/** One step of every simulation, as stein_step. Up to date between steps, without stein_batch_look,
 * are its time, the load's presence (stein_load_present), notch phases (stein_notch_phase), which
 *  contacts touch (stein_touches), and the force of a contact that does not touch.
 *  @param status  [n] or NULL: out, of each place; OK where there is none
 *  @param err     of the first that fails
 *  @return OK, or the first failure in the order of the places; the others went on */
stein_status stein_batch_step(stein_batch *batch, stein_status *status, stein_err *err);
/** The same several times in one go, which costs less: up to `most` steps, at least one. It ends
 * with the first step that a simulation took alone (its events are there) or that failed.
 *  @param taken  out: steps, the same number for every place */
stein_status stein_batch_steps(stein_batch *batch, long most, long *taken, stein_status *status,
                               stein_err *err);
/** Every simulation to its own end t_end [n], as stein_run. Arguments and result as above. */
stein_status stein_batch_run(stein_batch *batch, const double *t_end, stein_status *status,
                             stein_err *err);

/** Begin a run of place i to t_end with steps of controlled error, as stein_run_adaptive. The steps
 * are explicit, however stiff the motion; with STEIN_IMPLICIT they are implicit. Until the run is
 * over, do not step the place in another way and do not change its simulation. stein_batch_put
 * abandons the run.
 *  @param pace  must outlive the run
 *  @return OK; EINVAL (no such place, none in it, or as stein_run_adaptive); ESINGULAR */
stein_status stein_batch_begin(stein_batch *batch, int i, double t_end, stein_pace *pace,
                               stein_err *err);
/** Continue all runs that have begun until one of them is over. Its place can then begin the next
 * run while the others wait, so lanes stay full.
 *
 *      put, begin   for every place
 *      while ((i = stein_batch_go(batch, &status, &err)) >= 0)
 *          read sim i; put, begin the next one there
 *
 *  Looks and events come in the order of the trials, mixed between simulations, all from this
 * thread.
 *  @param status  out: of that run, as stein_run_adaptive; OK when there is none
 *  @param err     why it failed, or NULL
 *  @return its place; -1: none is under way */
int stein_batch_go(stein_batch *batch, stein_status *status, stein_err *err);
/** Every simulation to its own end in this way, each with its pace [n] (of places without
 * simulation: not read). */
stein_status stein_batch_run_adaptive(stein_batch *batch, const double *t_end, stein_pace *pace,
                                      stein_status *status, stein_err *err);

#ifdef __cplusplus
}
#endif
#endif
