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
 * system call and touch neither errno nor the locale. The number of their operations is bounded.
 *   A fixed step of RK4 needs 4 evaluations, with two or more events at most 33. With friction that
 *   sticks at most 200 events a step are located. Hooks and signals of the user have to keep the
 *   same rules.
 *
 *   Three slots of values are exchanged by one atomic operation on each side, so neither side waits
 * for the other. A take always gets one whole published set; older sets that were not taken are
 * dropped. One thread publishes, one takes; they may be the same.
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

/** A parameter's wanted value [SI], in this side's own copy. Parameters that were never set keep
 *  their values in the simulation. @return OK, ENAME, EINVAL (out of its range) */
stein_status stein_handover_set(stein_handover *handover, const char *name, double value,
                                stein_err *err);
/** How fast a parameter moves to it: at most `rate` a second of simulated time [SI/s]. A loaded
 *  surface that jumps adds or removes energy; a surface that moves slowly does work instead.
 *  INFINITY, the default: at once.
 *  @return OK, ENAME, EINVAL (not positive) */
stein_status stein_handover_pace(stein_handover *handover, const char *name, double rate,
                                 stein_err *err);
/** Hand over all present values and paces. */
void stein_handover_publish(stein_handover *handover);

/* ---- the side that steps ---- */

/** Between two steps: take the newest set, and move parameters by as much as their pace allows for
 *  the time since the last call.
 *  @return 1 when parameters of the simulation have changed, else 0 */
int stein_handover_take(stein_handover *handover, stein_sim *sim);

#ifdef __cplusplus
}
#endif
#endif
