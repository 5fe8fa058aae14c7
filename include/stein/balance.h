/* SPDX-License-Identifier: MIT
 * balance.h - where the energy of a motion comes from and goes to, worked out while it goes on.
 *
 *      E(t) - E(0) = work of inputs + work of laws + error of the steps
 *
 * E is kinetic energy and potential energy of gravity (stein_energy). The power of every force is
 * integrated over each step by Gauss's rule with three nodes on the step's dense output (order 6, 4
 * in implicit ones), with the contacts of the step. A law's force has two parts. The elastic part
 * is its value if all speeds were 0; its work is stored as energy. The other part depends on speed;
 * its work is dissipated. The difference that remains is the error of the steps, 0 for an exact
 * solution.
 *
 *      stein_balance_create(&b, model, NULL, &err);
 *      stein_balance_attach(b, sim, &err);
 *      stein_run(sim, 0.25, &err);
 *      stein_balance_total(b, &total);
 *
 * The motion keeps its bits. Each step costs three evaluations more. A stein_balance owns one block
 * of memory; nothing allocates after it was created.
 */
#ifndef STEIN_BALANCE_H
#define STEIN_BALANCE_H

#include "stein/sim.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct stein_balance stein_balance;

/** @param def  for its alloc and release; NULL for malloc and free
 *  @return OK; ENOMEM, and those of stein_sim_create for def */
stein_status stein_balance_create(stein_balance **b, const stein_model *model,
                                  const stein_sim_def *def, stein_err *err);
/** Release everything; the simulation goes on alone. NULL is fine. */
void stein_balance_destroy(stein_balance *b);
/** Count from the present state of a simulation on, all sums 0. With sim = NULL the sums stay and
 *  counting ends. One balance or sensitivity follows a simulation at a time: an earlier one is
 *  detached. @return OK; EINVAL (another model) */
stein_status stein_balance_attach(stein_balance *b, stein_sim *sim, stein_err *err);

/** Energies and works since a balance was attached [J]. */
typedef struct stein_energy_total {
    double begin, now;  /* E when it was attached, and after the last step */
    double inputs;      /* work of forces and prescribed motions of all inputs */
    double dissipated;  /* by all laws, mostly > 0: less than 0 where a law adds energy */
    double stored;      /* in springs, links and contacts, against E when it was attached */
    double other;       /* work of force hooks, and of laws without a count of their own */
    double taken;       /* out of the mechanism between steps: a load lifted, a state set */
    double unexplained; /* now - begin - inputs + dissipated + stored - other + taken */
    double scale; /* reference energy: the largest of the peak kinetic energy, the sum of |work| of
                     the inputs and that of dissipation */
} stein_energy_total;
void stein_balance_total(const stein_balance *b, stein_energy_total *total);

/** Kind of an element that does work, with the number of elements: inputs [ninput]; damping and
 * friction of joints
 *  [nq]; contacts and notches, along the normal and by friction [ncontact + nnotch]; damping of
 * links [nlink]. */
typedef enum {
    STEIN_WORK_INPUT,
    STEIN_WORK_JOINT,
    STEIN_WORK_NORMAL,
    STEIN_WORK_FRICTION,
    STEIN_WORK_LINK
} stein_work_kind;
/** Work that one of them has done on the mechanism [J], < 0: it took energy away. NAN for an index
 *  out of range. */
double stein_balance_work(const stein_balance *b, stein_work_kind kind, int index);

#ifdef __cplusplus
}
#endif
#endif
