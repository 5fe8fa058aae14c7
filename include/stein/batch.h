/* SPDX-License-Identifier: MIT
 * batch.h - many simulations of one model, stepped side by side in the lanes of the processor.
 *
 * A batch steps simulations that belong to its user. Each has parameters, time, step length, events
 * and a subscriber of its own; in a lane or alone, its motion is the same to
 * the last bit. Lanes need not be full, and a simulation that is done makes room for the next one:
 *
 *      put(batch, i, sim)  ->  step ... step  ->  sim(batch, i), read, put(batch, i, next)
 *
 * Lanes do whole trial steps. A step that meets an event is taken alone, as by stein_step. So is
 * every step of a simulation with a force hook, a sensitivity, or a force at a body that leaves
 * the plane, and of a model whose equations were not compiled for lanes. Signals are asked by the
 * thread that steps the batch, each for times that belong to its simulation.
 */
#ifndef STEIN_BATCH_H
#define STEIN_BATCH_H

#include "stein/sim.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct stein_batch stein_batch;

/** Simulations of a model that this processor steps side by side: 8, 4 or 2; 1 when the model has
 *  no lanes. A batch is best a multiple of it. */
int stein_batch_width(const stein_model *model);

/** A batch with n empty places.
 *  @param def    integrator of the simulations to come, and the allocator; NULL for the defaults
 *  @param width  lanes to use, one of 8, 4, 2 that this processor has, or 1; 0: the most there are
 *  @return OK; ESTALE; EINVAL (a field of def, n, width or integrator out of range), ENOMEM */
stein_status stein_batch_create(stein_batch **batch, const stein_model *model,
                                const stein_sim_def *def, int n, int width, stein_err *err);
/** Release the batch, not the simulations. NULL is fine. What was not asked back by stein_batch_sim
 *  is left where it was before its last steps. */
void stein_batch_destroy(stein_batch *batch);

/** Put a simulation into place i, or none (NULL). The one that was there is up to date afterwards;
 *  it leaves its place before it is destroyed.
 *  @return OK; EINVAL (no such place, other equations, or another integrator than the batch's) */
stein_status stein_batch_put(stein_batch *batch, int i, stein_sim *sim, stein_err *err);
/** The simulation in place i, up to date, or NULL. It may be read and changed in any way: its lane
 *  takes all of it again. */
stein_sim *stein_batch_sim(stein_batch *batch, int i);
/** The same, only to be read: its lane goes on as it is, which costs less. */
stein_sim *stein_batch_look(stein_batch *batch, int i);

/** One step of every simulation, as stein_step. Between steps its time, the load's presence
 *  (stein_load_present), notch phases (stein_notch_phase), what touches (stein_touches) and so the
 *  force of a contact that does not are up to date without stein_batch_look.
 *  @param status  [n] or NULL: out, of each place; OK where there is none
 *  @param err     of the first that fails
 *  @return OK, or the first failure in the order of the places; the others went on */
stein_status stein_batch_step(stein_batch *batch, stein_status *status, stein_err *err);
/** The same several times in one go, which costs less: up to `most` steps, at least one. It ends
 * with the first step that a simulation took alone - there are its events -, or that failed.
 *  @param taken  out: steps, the same number for every place */
stein_status stein_batch_steps(stein_batch *batch, long most, long *taken, stein_status *status,
                               stein_err *err);
/** Every simulation to its own end t_end [n], as stein_run. Arguments and result as above. */
stein_status stein_batch_run(stein_batch *batch, const double *t_end, stein_status *status,
                             stein_err *err);

/** Begin a run of place i to t_end with steps of controlled error, as stein_run_adaptive; they are
 * explicit, however stiff the motion, but with STEIN_IMPLICIT. Until it is over its place is not to
 * be stepped in another way, nor its simulation changed; stein_batch_put gives it up.
 *  @param pace  must outlive the run
 *  @return OK; EINVAL (no such place, none in it, or as stein_run_adaptive); ESINGULAR */
stein_status stein_batch_begin(stein_batch *batch, int i, double t_end, stein_pace *pace,
                               stein_err *err);
/** Continue all runs that have begun until one of them is over. Its place can then take the next
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
