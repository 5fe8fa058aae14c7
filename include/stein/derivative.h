/* SPDX-License-Identifier: MIT
 * derivative.h - exact derivatives of qdd(q, qd, p), with contacts, laws and the notch.
 *
 *      M qdd + c = Q      hence      M dqdd = dQ - (dM qdd + dc)
 *
 * d(M qdd + c) is generated with the equations (model.h). dQ comes from the same source code of
 * contacts, laws and notch as Q, compiled for dual numbers. No finite differences are used, so
 * derivatives are as exact as the values.
 *
 *      stein_derivative_at(s, sim, t, q, qd, qdd, &err);
 *      stein_derivative_by_state(s, by_q, by_qd);
 *      stein_derivative_by_parameter(s, stein_find_param(model, "hammer.mass"), by_mass);
 *
 * Modes of contacts, notch and load are memory, not geometry: the simulation's present modes are
 * kept. At a kink of a law the derivative is one-sided, on the side of the state. Joints that
 * follow a signal or are held do not move with q or qd. A signal gives its value alone, so the
 * derivative by the delay of an input is given as 0.
 *
 * A stein_derivative owns one block of memory; nothing allocates after it was created. One of them
 * belongs to one thread at a time. All quantities are SI.
 */
#ifndef STEIN_DERIVATIVE_H
#define STEIN_DERIVATIVE_H

#include "stein/sim.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct stein_derivative stein_derivative;

/** @param def  for its alloc and release; NULL for malloc and free
 *  @return OK; ESTALE (as stein_sim_create), EINVAL (the equations were written without
 *  derivatives), ENOMEM */
stein_status stein_derivative_create(stein_derivative **s, const stein_model *model,
                                     const stein_sim_def *def, stein_err *err);
/** Release everything. NULL is fine. */
void stein_derivative_destroy(stein_derivative *s);

/** Where the following derivatives are: at t [s], q, qd [nq], with the parameters, signals and
 *  memory of a simulation of the same model. They are read from its last evaluation: compute them
 *  before any other call with the simulation, and before it is destroyed. Its state does not
 *  change.
 *  @param qdd  [nq] out: the acceleration there, with the bits of stein_acceleration; or NULL
 *  @return OK; EINVAL (another model; a force hook, or a force at a point off the plane, of which
 *  there is no derivative), ESINGULAR */
stein_status stein_derivative_at(stein_derivative *s, stein_sim *sim, double t, const double *q,
                                 const double *qd, double *qdd, stein_err *err);

/* Without a place (none was set, or the last one was refused) the following are nan.
 */

/** qdd by every q and qd: by_q, by_qd [nq*nq], row i of qdd_i. */
void stein_derivative_by_state(stein_derivative *s, double *by_q, double *by_qd);
/** qdd by parameter p[param]: [nq]; all 0 for an index out of range. */
void stein_derivative_by_parameter(stein_derivative *s, int param, double *by_p);
/** qdd along dq, dqd [nq], dp [np], each of which may be NULL for 0: dqdd [nq]. */
void stein_derivative_along(stein_derivative *s, const double *dq, const double *dqd,
                            const double *dp, double *dqdd);

/** The generalised forces Q of contacts, laws, links and inputs, by every q and qd: by_q, by_qd
 *  [nq*nq], row i of Q_i [N m or N]. */
void stein_derivative_forces(stein_derivative *s, double *by_q, double *by_qd);

#ifdef __cplusplus
}
#endif
#endif
