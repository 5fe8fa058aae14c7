/* SPDX-License-Identifier: MIT
 * sensitivity.h - derivatives of a motion by its initial state and parameters, integrated beside
 * the motion.
 *
 * Directions follow a simulation. Each is a change dq, dqd of the state and dp of the parameters.
 * With every step of the simulation it is integrated by the derivatives of the same step
 * (derivative.h), stage by stage. Where contacts or the notch switch, the instant moves too:
 *
 *      dt = - dg / gdot            g the guard that is 0 there
 *      dqd jumps by (qdd before - qdd after) dt
 *
 *      stein_sensitivity_create(&s, model, NULL, 1, &err);
 *      stein_sensitivity_attach(s, sim, &err);
 *      stein_sensitivity_set(s, 0, NULL, NULL, dp);     d/dp, with the present state kept
 *      stein_run(sim, 0.05, &err);
 *      stein_sensitivity_q(s, 0)                        dq/dp at 0.05 s
 *
 * They are the derivatives of the motion to the accuracy of the steps; of a step without a switch,
 * to rounding. A motion that grazes a contact has no derivative.
 *
 * A stein_sensitivity owns one block of memory; nothing allocates after it was created.
 */
#ifndef STEIN_SENSITIVITY_H
#define STEIN_SENSITIVITY_H

#include "stein/derivative.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct stein_sensitivity stein_sensitivity;

/** @param n  directions, at least 1
 *  @param def  for its alloc and release; NULL for malloc and free
 *  @return as stein_derivative_create; EINVAL also when n < 1 */
stein_status stein_sensitivity_create(stein_sensitivity **s, const stein_model *model,
                                      const stein_sim_def *def, int n, stein_err *err);
/** Release everything; the simulation that it follows goes on alone. NULL is fine. */
void stein_sensitivity_destroy(stein_sensitivity *s);

/** Follow a simulation from now on, all directions 0; sim = NULL: none. One sensitivity follows
 * a simulation at a time: an earlier one is detached, as when the simulation is destroyed, and
 * stein_sensitivity_check then fails. In a batch a simulation with one runs alone.
 *  @return OK; EINVAL (another model, an input with a signal, what stein_derivative_at refuses) */
stein_status stein_sensitivity_attach(stein_sensitivity *s, stein_sim *sim, stein_err *err);
/** Direction k from now on: dq, dqd [nq] of the present state, dp [np] of the parameters; each may
 * be NULL for 0. An index out of range does nothing. */
void stein_sensitivity_set(stein_sensitivity *s, int k, const double *dq, const double *dqd,
                           const double *dp);

/** The same along dp [np] for the state after stein_reset: the derivatives of the static
 * equilibrium, of the initial values and of the place of the load by the parameters.
 *  @return OK; EINVAL (dp is NULL, k out of range, no simulation), ESINGULAR (an equilibrium that
 * is indifferent), what stein_derivative_at returns */
stein_status stein_sensitivity_start(stein_sensitivity *s, int k, const double *dp, stein_err *err);

/** Direction k now, [nq]; NULL for an index out of range. */
const double *stein_sensitivity_q(const stein_sensitivity *s, int k);
const double *stein_sensitivity_qd(const stein_sensitivity *s, int k);
/** How the instant of the last switch changes along direction k [s a unit of it]; 0 before one. */
double stein_sensitivity_switch(const stein_sensitivity *s, int k);
/** Are the directions valid? @return OK; or what went wrong since the sensitivity was attached:
 * EINVAL (a signal or hook was bound, the simulation was destroyed or follows another sensitivity),
 * ENONFINITE (a guard was only touched), ESINGULAR */
stein_status stein_sensitivity_check(const stein_sensitivity *s, stein_err *err);

#ifdef __cplusplus
}
#endif
#endif
