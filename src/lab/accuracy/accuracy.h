/* SPDX-License-Identifier: GPL-3.0-or-later
 * accuracy.h - how far the result of a run may be trusted: the error of its positions and its
 * energy.
 *
 * Two reference simulations accompany the judged one, both with steps of controlled error and a
 * tolerance far below its tolerance (lab__accuracy_create):
 *
 *      whole   from the same initial state, on its own: how far the run is from the solution
 *      part    put onto the run's state at every checkpoint: errors of the steps between two of
 *      them
 *
 * The errors that the steps make, summed over the run, judge the method. Where the deviation is
 * much larger than that sum, the motion amplifies small differences (impacts, chaos): no method
 * then finds positions, while energies and averages may well be right.
 * Included by: this folder, src/cli.
 */
#ifndef LAB_TRUST_H
#define LAB_TRUST_H

#include "run.h"
#include "stein/balance.h"

typedef struct lab__accuracy lab__accuracy;

/** Are steps of dt divided by their error estimate? */
static inline int lab__is_controlled(stein_integrator integrator)
{
    return integrator == STEIN_CONTROLLED || integrator == STEIN_IMPLICIT;
}

/** Errors by kind of joint; of a mechanism without such joints 0. */
enum { LAB_SLIDES, LAB_TURNS, LAB_KINDS }; /* [m], [rad] */
typedef struct lab__errors {
    double made[LAB_KINDS];      /* by the steps, summed over the run; largest of all joints */
    double deviation[LAB_KINDS]; /* largest, from the run of small tolerance */
    double range[LAB_KINDS];     /* largest motion of a joint */
    double made_share, deviation_share; /* largest ratios of them to the range */
    double lost;                /* from when on the deviation was above LAB_DOUBTFUL [s]; NAN */
    double gimbal, gimbal_time; /* least of stein_gimbal at the checkpoints, when [s] */
    int hinge[2];               /* of which joints */
    int known;                  /* 0: the run of small tolerance failed */
    stein_energy_total energy;
    double energy_share; /* |unexplained| / scale */
} lab__errors;

/* Shares above which a result is doubtful, and above which it is not to be trusted.
 * Measured positions of mechanisms are good to 1e-3 of their range (the paper: 0.014 mm of
 * 40 mm); an error of 3 % of the range or of the energy is one that a figure shows. */
#define LAB_DOUBTFUL 1e-3
#define LAB_WRONG    3e-2

/** @param def    of the simulation that is judged  @param drive  its signals, or NULL
 *  @param until  [s]  @return OK, ENOMEM, what stein_sim_create returns */
stein_status lab__accuracy_create(lab__accuracy **t, const lab_model *model,
                                  const stein_sim_def *def, double tolerance, double until,
                                  lab_drive *drive, stein_err *err);
void lab__accuracy_destroy(lab__accuracy *t);
/** Begin with the simulation in its initial state. @return OK, ENOMEM */
stein_status lab__accuracy_begin(lab__accuracy *t, stein_sim *sim, stein_err *err);
/** The run has failed: only what led to it is asked for. */
void lab__accuracy_fail(lab__accuracy *t, const stein_sim *sim);
/** After every step. */
void lab__accuracy_step(lab__accuracy *t, stein_sim *sim);
/** The run is at its end: nothing is counted any more. */
void lab__accuracy_end(lab__accuracy *t, stein_sim *sim);
const lab__errors *lab__accuracy_errors(const lab__accuracy *t);
/** Work of one law or input, as stein_balance_work [J]. */
double lab__accuracy_work(const lab__accuracy *t, stein_work_kind kind, int index);

#endif
