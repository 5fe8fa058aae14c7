/* SPDX-License-Identifier: GPL-3.0-or-later
 * diagnosing.h - what the files of the diagnosis share. Not installed.
 *
 *   phase.c       the phase of the stroke at every frame    diagnosis.c       words, release
 *   departure.c   where the residual is more than noise     diagnosis_json.c  diagnosis.json
 *   latent.c      the force that the model lacks            diagnosis_page.c  report.html
 *
 * Phases lie behind each other, stroke by stroke, one name a frame: sample i of stroke s at
 * phase[diag__row(p, s) + i]. Names are constants, equal names are equal pointers.
 */
#ifndef DIAGNOSING_H
#define DIAGNOSING_H

#include "fitting.h"
#include "stein/diagnose.h"

/* ---- phase.c ---- */

enum { DIAG_PHASES = 9 };
/** In the order of a stroke: "rest", "drive i", "drive ii", "drive iii", "free flight", "string",
 *  "fall", "re-arm"; "motion" for a mechanism without stroke. */
extern const char *const diag__phase[DIAG_PHASES];
/** Its place in that order, -1: no phase. */
int diag__phase_index(const char *name);
/** Where the frames of a stroke begin; stroke = nstroke: how many there are in all. */
size_t diag__row(const fit__problem *p, int stroke);
/** Phases of all strokes simulated at x, on threads. A stroke that cannot be simulated is in
 *  "motion".
 *  @param phase  [frames in all] out
 *  @param time   [frames in all] out, simulation time of the frames [s]; may be NULL
 *  @return OK, ENOMEM */
stein_status diag__phases(const fit__problem *p, const double *x, const char **phase, double *time,
                          stein_err *err);

/* ---- departure.c ---- */

/** Channel by phase where the residuals r at x depart from noise: rows are added to a list.
 *  @param list, n  in and out; NULL and 0 to begin
 *  @return OK, ENOMEM */
stein_status diag__departures(const fit__problem *p, const double *r, const char *const *phase,
                              lab_departure **list, int *n, stein_err *err);
/** Add a stroke's channels, as measured and as predicted.
 *  @param before, after  [nch*n] of the stroke; after NULL: as before
 *  @param phase          [n] of the stroke
 *  @return OK, ENOMEM */
stein_status diag__trace(lab_trace **list, int *n, const fit__problem *p, int stroke, int held_out,
                         const double *before, const double *after, const char *const *phase,
                         stein_err *err);

/* ---- latent.c ---- */

/** The force that the model lacks: joint by phase over all strokes, added to the list of
 *  departures, and over time for a few strokes that differ.
 *  @param r, J  residuals at x and their derivatives (fit__sensitivities)
 *  @return OK, ENOMEM, failures of simulations */
stein_status diag__missing_force(const fit__problem *p, const double *x, const double *r,
                                 const double *J, const char *const *phase, const double *time,
                                 lab_departure **list, int *n, lab_latent **latent, int *nlatent,
                                 stein_err *err);

/* ---- diagnosis.c ---- */

/** All of the above into departure and latent of a diagnosis, from the residuals r at x; J may be
 *  NULL: found anew. @return OK, ENOMEM, failures of simulations */
stein_status diag__show(lab_diagnosis *d, const fit__problem *p, const double *x, const double *r,
                        const double *J, const char *const *phase, const double *time,
                        stein_err *err);
/** "wrong parameter", "missing effect" ...: the verdict in words. */
const char *diag__verdict_words(lab_verdict verdict);

#endif
