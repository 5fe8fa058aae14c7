/* SPDX-License-Identifier: MIT
 * handover.h - parameters from another thread while a simulation runs, without locks.
 *
 *      a window, a knob                          the thread that steps
 *      stein_handover_set, .._pace  (own copy)
 *      stein_handover_publish  ---- newest ----> stein_handover_take, stein_step, ...
 *
 * REAL TIME
 *   stein_step, stein_run, stein_run_adaptive, stein_set, stein_set_all, stein_read, stein_save,
 *   stein_restore, stein_reset and stein_handover_take allocate nothing, take no lock, make no
 *   system call and touch neither errno nor the locale; the number of their operations is bounded.
 *   A fixed step of RK4 evaluates 4 times, with two events or more at most 33 times;
 *   friction that sticks has 200 events a step located at most. What remains is whatever
 *   hooks and signals of one's own do.
 *
 *   Three slots of values are exchanged by one atomic operation on each side, so neither side
 * waits for the other. What is taken is always one whole set as published; older sets that were
 * not taken are dropped. One thread publishes, one takes; they may be the same.
 */
#ifndef STEIN_HANDOVER_H
#define STEIN_HANDOVER_H

#include "stein/sim.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct stein_handover stein_handover;

/** Create one for simulations of this model. Nothing allocates after it.
 *  @param def  whose allocator to use; NULL: malloc
 *  @return OK, EINVAL (an allocator without its release), ENOMEM */
stein_status stein_handover_create(stein_handover **handover, const stein_model *model,
                                   const stein_sim_def *def, stein_err *err);
/** When neither side uses it any more. NULL is fine. */
void stein_handover_destroy(stein_handover *handover);

/* ---- the side that publishes ---- */

/** A parameter's wanted value [SI], in the own copy of this side. Parameters that were never set
 *  stay as they are in the simulation. @return OK, ENAME, EINVAL (out of its range) */
stein_status stein_handover_set(stein_handover *handover, const char *name, double value,
                                stein_err *err);
/** How fast a parameter moves there: at most `rate` a second of simulated time [SI/s]. A surface
 *  that is moved at once while something presses on it gives or takes energy; moved slowly it is
 *  pushed like any other. INFINITY, the default: at once.
 *  @return OK, ENAME, EINVAL (not positive) */
stein_status stein_handover_pace(stein_handover *handover, const char *name, double rate,
                                 stein_err *err);
/** Hand over all values and paces as they are now. */
void stein_handover_publish(stein_handover *handover);

/* ---- the side that steps ---- */

/** Between two steps: take what is new, and move parameters on their way by what their pace allows
 *  for the time since the last call.
 *  @return 1 when parameters of the simulation have changed, else 0 */
int stein_handover_take(stein_handover *handover, stein_sim *sim);

#ifdef __cplusplus
}
#endif
#endif
