/* SPDX-License-Identifier: GPL-3.0-or-later
 * diagnosing.h - what the files of the diagnosis share.
 *
 *   phase.c                the phase of the stroke at every frame
 *   departure.c            where the residual is more than noise
 *   missing_force.c        the force that the model lacks
 *   missing_force_phase.c  the same by phase
 *   force_response.c       what a force does to the channels
 *   evidence.c             how large it is
 *
 * Phases lie behind each other, stroke by stroke, one name a frame: sample i of stroke s at
 * phase[diag__frame(p, s) + i]. Names are constants, equal names are equal pointers.
 * Included by: this folder, src/lab/report, src/lab/search.
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
size_t diag__frame(const fit__problem *p, int stroke);
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
/** The phase in which two sets of residuals of the same strokes differ most (sum of squares); NULL:
 *  they do not. */
const char *diag__phase_shown(const fit__problem *p, const double *before, const double *after,
                              const char *const *phase);
/** Add a stroke's channels, as measured and as predicted.
 *  @param before, after  [nch*n] of the stroke; after NULL: as before
 *  @param phase          [n] of the stroke
 *  @return OK, ENOMEM */
stein_status diag__trace(lab_trace **list, int *n, const fit__problem *p, int stroke, int held_out,
                         const double *before, const double *after, const char *const *phase,
                         stein_err *err);

/* ---- force_response.c ---- */

/** A generalised force on a joint while a stroke is simulated: a hat over time, or constant in one
 *  phase. */
typedef struct diag__push {
    int stroke, joint;
    int phase;          /* of diag__phase; -1: a hat */
    double knot, width; /* of the hat: where it is 1, and how far from there it is 0 [s] */
    double amplitude;   /* in and out: of the differences; 0: to be found */
    double limit;       /* of the amplitude, > 0 */
    double *column;     /* [nch*n] out: derivative of the weighted residuals; 0: no influence */
} diag__push;
/** Fill in the columns of n pushes, on threads.
 *  @param time  simulation time of all frames (diag__phases)  @return OK, ENOMEM */
stein_status diag__force_columns(const fit__problem *p, const double *x, const double *r,
                                 const char *const *phase, const double *time, diag__push *push,
                                 int n, stein_err *err);

/* ---- evidence.c ---- */

/** Linear forces f that explain residuals, all nuisances eliminated: -2 ln L and f follow from
 *      M = G'PG  [n*n],   c = -G'Pr  [n]
 *  and a prior f = same * constant[group] + g, the constant with sd wide[group], g with sd scale *
 *  tau[group] and correlated by rho where tied. */
typedef struct diag__gauss {
    int n, ngroup;
    const int *group;         /* [n] */
    const unsigned char *tie; /* [n] 1: correlated with the one before */
    double rho;
    const double *scale, *same; /* [n] */
    const double *wide;         /* [ngroup] */
    double *M, *c;
    double *tau;        /* [ngroup] out: the largest that the likelihood allows */
    double *mean, *cov; /* [n], [n*n] out: of f */
    double explained;   /* out: fall of the sum of squares */
} diag__gauss;
/** Room for n unknowns in ngroup groups; g->M is freed by the caller. @return OK, ENOMEM */
stein_status diag__gauss_make(diag__gauss *g, int n, int ngroup, stein_err *err);
/** Choose tau by marginal likelihood and find f. @return OK, ENOMEM */
stein_status diag__gauss_solve(diag__gauss *g, stein_err *err);

/* ---- missing_force.c, missing_force_phase.c ---- */

/** What the search for missing forces needs. */
typedef struct diag__plan {
    const fit__problem *p;
    const stein_model *m;
    const double *x, *r, *J, *time;
    const char *const *phase;
    int njoint, *joint; /* all but the load's */
    double *limit;      /* [njoint] plausible largest force */
} diag__plan;
const char *diag__force_unit(const diag__plan *l, int joint);
/** Values of a stroke: channels by frames. */
size_t diag__size(const fit__problem *p, int stroke);
stein_status diag__force_by_phase(const diag__plan *l, lab_departure **list, int *n,
                                  stein_err *err);

/** The force that the model lacks: joint by phase over all strokes, added to the list of
 *  departures, and over time for a few strokes that differ.
 *  @param r, J  residuals at x and their derivatives (fit__sensitivities)
 *  @return OK, ENOMEM, failures of simulations */
stein_status diag__missing_force(const fit__problem *p, const double *x, const double *r,
                                 const double *J, const char *const *phase, const double *time,
                                 lab_departure **list, int *n, lab_latent **latent, int *nlatent,
                                 stein_err *err);

/* ---- diagnosis_detectability.c ---- */

/** Number of candidates with that presence. */
int diag__count(const lab_diagnosis *d, lab_presence presence);

/* ---- diagnosis.c ---- */

/** All of the above into departure and latent of a diagnosis, from the residuals r at x; J may be
 *  NULL: they are computed. @return OK, ENOMEM, failures of simulations */
stein_status diag__show(lab_diagnosis *d, const fit__problem *p, const double *x, const double *r,
                        const double *J, const char *const *phase, const double *time,
                        stein_err *err);
/** "wrong parameter", "missing effect" ...: the verdict in words. */
const char *diag__verdict_words(lab_verdict verdict);
/** The verdict with an effect as its only cause. */
lab_verdict diag__verdict_of(const lab_suspect *s);
/** Fall of -2 ln L that names any cause. */
double diag__enough(void);
/** What nfit and nheld count: "record", or "piece" of long ones. */
const char *diag__record_word(const lab_diagnosis *d);
enum { DIAG_COUNTS = 100 };
/** "3 records fitted, 1 held out", "3 pieces of 1 record fitted ...", "nothing was fitted". */
const char *diag__counts(char to[DIAG_COUNTS], const lab_diagnosis *d);

#endif
