/* SPDX-License-Identifier: MIT
 * linear.h - a mechanism linearised about a state, for control, modal analysis and stability.
 *
 *      dx/dt = A x + B u,    y = C x + D u
 *
 * x, u, y are deviations from the state. With loops and couplings not all coordinates are
 * independent: dq = T dz, where z are n independent ones (J T = 0), x = {z, dz/dt}. From
 *
 *      T^T (M qdd + c - Q) = 0      M_zz z'' + C_z z' + K_z z = T_z^T dQ/du u - M_zp z_p''
 *
 * A = {0, 1; -M_zz^-1 K_z, -M_zz^-1 C_z}, M_zz = T_z^T M T_z. (Wehage & Haug 1982, J. Mech. Des.
 * 104:247, for the partition; Sohoni & Whitesell 1986, J. Mech. Trans. Autom. Des. 108:300, for the
 * linearisation of mechanisms with loops.)
 *
 * Joints with a prescribed motion are the last of the independent coordinates: their positions and
 * speeds are states as well, their accelerations are the inputs. This form needs no derivatives of
 * u: inertia forces act through B, springs and dampers of a moved support through A.
 *
 * A is built from exact derivatives (derivative.h) where the mechanism has them. A mechanism with
 * loops, couplings, bodies or contacts in space, friction that sticks or hooks has none. Its A
 * comes from central differences along T, extrapolated to a step of 0 (Ridders 1982, Adv. Eng.
 * Softw. 4:75). The method estimates its error: system->error. B and D are always exact.
 *
 * Contacts keep their modes: a closed contact acts with the slope of its law at the present depth,
 * an open one does not act. At its edge a contact or stop acts on one side only, and no linear
 * system describes both sides: such places are listed (system->edge). Smooth friction at rest is
 * viscous, with the coefficient A/vt. A place that sticks does not move.
 *
 *      stein_linear_create(&l, model, NULL, &err);
 *      stein_linear_at(l, sim, &system, &err);
 *      system->A[(2 * system->n) * i + j]
 *
 * A stein_linear owns one block of memory; nothing allocates after it was created. One of them
 * belongs to one thread at a time. All quantities are SI.
 */
#ifndef STEIN_LINEAR_H
#define STEIN_LINEAR_H

#include "stein/sim.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct stein_linear stein_linear;

/** Where a force begins or ends. */
typedef enum {
    STEIN_EDGE_CONTACT, /* index: contact */
    STEIN_EDGE_NOTCH,   /* index: notch */
    STEIN_EDGE_LIMIT,   /* index: joint, one end of its limits */
    STEIN_EDGE_BACKLASH /* index: joint */
} stein_edge_kind;

/** An edge at which the state is. */
typedef struct stein_edge {
    stein_edge_kind kind;
    int index;
    double apart; /* gap [m or rad]; < 0: pressed in */
} stein_edge;
/** A place is at its edge if it is open by at most OPEN, or pressed in by at most PRESSED [m or
 *  rad]. (A hard contact that carries a load is pressed in by more.) */
#define STEIN_EDGE_OPEN    1e-6
#define STEIN_EDGE_PRESSED 1e-9

/** Largest acceleration of a state that counts as an equilibrium [rad/s^2 or m/s^2]. The
 *  acceleration that a displacement of all coordinates by SHIFT [rad or m] would cause is added to
 *  this limit. */
#define STEIN_LINEAR_ACCELERATION 1e-6
#define STEIN_LINEAR_SHIFT        1e-9
/** Largest rate of an acceleration in a motion that counts as steady, in units of the largest speed
 *  times the sum of |dqdd/dq| plus 1. */
#define STEIN_LINEAR_STEADY 1e-6

/** The linear system. Matrices are row-major. States are the n coordinates z, then their speeds,
 * [rad or m] and [rad/s or m/s]. A force has the unit of its input, a prescribed motion the unit
 *  of the second time derivative of its input; outputs have the unit of the channel. */
typedef struct stein_linear_system {
    int n, nfree;        /* independent coordinates; the first nfree of them have no motion */
    int ninput, noutput; /* noutput: all channels of the model */
    const int *joint;    /* [n] which joint's coordinate it is */
    const int *input;    /* [ninput] input of the model. A motion counts where it is in force: bound
                          * to a signal, or idle: hold */
    const double *A;     /* [2n*2n] */
    const double *B;     /* [2n*ninput]; delays of inputs are not in it */
    const double *C;     /* [noutput*2n], with the gains of the instruments, without their delays */
    const double *D;     /* [noutput*ninput] */
    const double *T;     /* [nq*n] dq/dz */
    const double *mass;  /* [n*n] T^T M T */
    double residual;     /* largest acceleration at the state */
    int worst;           /* its joint */
    int exact;           /* 1: A is by exact derivatives */
    const char *why;     /* 0: why not, e.g. "it has loops or couplings" */
    double error;        /* of A by differences, the largest estimate in units of the largest
                          * element of its row; 0 where exact */
    const unsigned char *differences; /* [noutput] 1: this row of C is by differences */
    int nedge;
    const stein_edge *edge; /* [nedge] */
} stein_linear_system;

/** @param def  for its alloc and release; NULL for malloc and free
 *  @return OK; ESTALE (as stein_sim_create), EINVAL, ENOMEM */
stein_status stein_linear_create(stein_linear **l, const stein_model *model,
                                 const stein_sim_def *def, stein_err *err);
/** Release everything. NULL is fine. */
void stein_linear_destroy(stein_linear *l);

/** Linearise about the present state of a simulation of the same model, with its parameters,
 *  signals, hooks and modes of contacts. The simulation does not change.
 *  The state has to be an equilibrium, or a steady motion: no coordinate accelerates, and none will
 *  (A z' = 0, as of a wheel that turns evenly).
 *  @param system  out: valid until the next call or stein_linear_destroy; untouched on failure
 *  @return OK; ESETTLE: neither an equilibrium nor a steady motion; err names the joint and its
 *  acceleration. EINVAL: another model, a contact with friction that sticks, or no degree of
 *  freedom. ESINGULAR, ECLOSE */
stein_status stein_linear_at(stein_linear *l, stein_sim *sim, const stein_linear_system **system,
                             stein_err *err);

#ifdef __cplusplus
}
#endif
#endif
