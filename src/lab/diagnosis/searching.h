/* SPDX-License-Identifier: GPL-3.0-or-later
 * searching.h - what the search for a cause shares. Not installed.
 *
 *   diagnose.c    the whole: null fit, suspects, refits, held-out strokes, verdict
 *   suspects.c    candidates of the mechanism and what each would change
 *   pursue.c      the null fit, along the strokes
 *   rank.c        which of them the residual looks like, with the strokes' scatter taken out
 *   refine.c      the best suspects fitted in full
 *   heldout.c     error on strokes that nothing was fitted to
 *   verdict.c     from numbers to one of seven words
 */
#ifndef SEARCHING_H
#define SEARCHING_H

#include "diagnosing.h"
#include "mixed.h"

/** A candidate with what is needed to try it. */
typedef struct diag__suspect {
    lab_suspect s;
    lab_model *model;                  /* extended mechanism; NULL: the one diagnosed */
    lab_dataset *fit_data, *held_data; /* the strokes in it */
    fit__problem *fit;                 /* of the extended mechanism; NULL: the base's */
    const char *never;                 /* the data cannot show it, because ... */
    double step;                       /* amount that G was made with, in limits */
    double *G;              /* change of all weighted residuals per limit; NULL: nothing to see */
    double *x, *J, *r;      /* of a refit, one block; NULL before */
    double objective;       /* -2 log likelihood of the refit, scatter taken out */
    double D[LAB_SCATTERS]; /* variances of scatter in prior variances */
    double *sd;             /* [np] of the free unknowns, in x */
    int promising;          /* its linear gain is a share of the best one */
    int ended;              /* the refit has */
    double swap;            /* predicted objective in the leader's place */
    double *start;          /* and unknowns */
} diag__suspect;

enum { DIAG_CLASSES = 3 }; /* kinds of scatter: joints, contacts, drive */

typedef struct diag {
    const char *file;
    const lab_model *model;
    const lab_diagnose_def *def;
    lab_fit_def fit_def;
    const char **name; /* free parameters */
    int nname;
    const lab_dataset *fit_data, *held_data;
    fit__problem p;
    double *x, *J, *r; /* null fit: nothing hidden */
    int ended;         /* it found its minimum */
    double *sd;        /* [np] of the free unknowns, in x */
    double null_objective, null_D[LAB_SCATTERS];
    diag__suspect *suspect;
    int n;
    double p_value;
    lab_diagnosis *out;
} diag;

/* ---- suspects.c ---- */

/** All candidates; `why` of those that the data cannot show. */
stein_status diag__suspects(diag *d, stein_err *err);
/** G of all others at the present point (x, r) and horizon. */
stein_status diag__changes(diag *d, stein_err *err);
void diag__suspects_free(diag *d);
/** The problem in which a suspect is simulated. */
fit__problem *diag__problem(diag *d, diag__suspect *s);

/* ---- pursue.c ---- */

/** A fit from e->x over growing horizons, with whatever effect the problem has on trial. */
stein_status diag__follow(diag *d, fit__problem *p, fit__end *e, stein_err *err);
/** The null fit over growing horizons: x, J, r, ended. */
stein_status diag__pursue(diag *d, stein_err *err);

/* ---- rank.c ---- */

/** Scores of all suspects at the null fit: s.score, s.amount, s.possible; sorted. */
stein_status diag__rank(diag *d, stein_err *err);
/** -2 log likelihood at unknowns x with derivatives J and residuals r, scatter estimated.
 *  @param D   variances of scatter, out
 *  @param sd  [np] standard deviations of the free unknowns in x, out */
double diag__likelihood(const fit__problem *p, const double *x, const double *J, const double *r,
                        double *D, double *sd);
/** Scores of all suspects in the place of the leader, at its end: swap and start.
 *  diag__changes was called there. */
stein_status diag__in_place(diag *d, diag__suspect *leader, stein_err *err);

/* ---- refine.c ---- */

/** Full fits of the best suspects; the best first. */
stein_status diag__refit(diag *d, stein_err *err);

/* ---- heldout.c ---- */

/** Held-out strokes as a model predicts them, each with its own unknowns fitted. */
typedef struct diag__held {
    fit__problem p;
    double *x, *r; /* unknowns, weighted residuals */
    double rmse;   /* in units of noise */
} diag__held;
/** @param s  NULL: nothing found  @return OK, ENOMEM, a numerical failure; free in any case */
stein_status diag__held_out(diag *d, const diag__suspect *s, diag__held *to, stein_err *err);
void diag__held_free(diag__held *h);
/** gain and gains of a diagnosis. @param phase  of all held-out frames */
stein_status diag__gain(lab_diagnosis *out, const diag__held *before, const diag__held *after,
                        const char *const *phase, stein_err *err);

/* ---- verdict.c ---- */

/** Verdict, reason, causes and rivals from what the search has found; suspects are sorted. */
void diag__verdict(diag *d, double held_before, double held_after);
/** How much more than its noise a residual varies whose noise nobody stated: chi2/dof with this
 *  suspect, times the length of the residual's memory; 1 where it was stated. */
double diag__excess(const diag *d, const diag__suspect *s);

#endif
