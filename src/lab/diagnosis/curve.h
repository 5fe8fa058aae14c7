/* SPDX-License-Identifier: GPL-3.0-or-later
 * curve.h - what the files of the search for an unknown law share. Not installed.
 *
 *   curve.c          places and states, one after the other: which law explains what is left
 *   curve_site.c     where a law could sit, and the states that the strokes visit there
 *   curve_text.c     a mechanism file with tables in it
 *   curve_stand.c    where curves begin: fits without a law
 *   curve_prior.c    a curve as a Gaussian process: how large, how smooth
 *   curve_outline.c  few points of it, where the strokes begin
 *   curve_fitting.h  a curve and all other unknowns, by penalised least squares
 *   curve_judge.c    is it believed, and what is said of it
 *   curve_show.c     the law in diagnosis.json and report.html
 */
#ifndef CURVE_H
#define CURVE_H

#include <gsl/gsl_matrix.h>
#include <math.h>

#include "searching.h"
#include "structure.h"

enum { CURVE_POINTS = 25, CURVE_CONTACT_POINTS = 25 };
/* and those of its outline */
enum { OUTLINE_POINTS = 13, OUTLINE_CONTACT_POINTS = 9 };

/** A place and a state of it: the points of the curve that may act there. */
typedef struct diag__site {
    char place[MECH_NAME], table[MECH_NAME];
    stein_table_kind kind;
    int index;  /* as in stein_table */
    int slides; /* of a joint */
    int n;
    double at[CURVE_POINTS];
    int seen[CURVE_POINTS];
    int pinned; /* 1: the first value stays 0 */
    int first;  /* unknown of the first value */
} diag__site;

/** A curve at one site, fitted. */
typedef struct diag__curve {
    const diag__site *site;
    double *x, *r; /* [nu], [rows]; one block */
    double *sd;    /* [np] of the parameters, in x */
    double gain;   /* linear; then of the fit: fall of -2 ln marginal likelihood */
    double price;  /* of the fit's freedom: what of -2 ln p is the curve's prior and logdet */
    double cov[CURVE_POINTS * CURVE_POINTS];
    double excess; /* factor on variances where nobody stated the noise */
    double held;   /* RMSE on held-out strokes */
    int fitted;
} diag__curve;

/** A fit without a law, in the mechanism with tables: where curves begin. */
typedef struct diag__stand {
    double *x, *r, *J; /* one block; J by all curves, too, early by their outlines */
    double objective;  /* chi2 and priors */
    double horizon;    /* [s] up to which it has been fitted */
} diag__stand;

/** The mechanism with a table of zeros at every site, and the strokes in it. */
typedef struct diag__curves {
    diag__site *site; /* [2*nsite] the curves, then their outlines */
    int nsite;
    lab_model *model;
    lab_dataset *fit_data, *held_data;
    lab_fit_def def;
    const char **name; /* free: those of the null fit, then all values */
    char *names;
    fit__problem p;
    double D[LAB_SCATTERS]; /* variances of what differs from stroke to stroke, in the priors' */
    diag__stand null;       /* of all samples */
    diag__stand early;  /* to where more than noise is left first; x NULL: there is no such place */
    diag__curve *curve; /* [nsite], the best first */
    diag__held held;    /* held-out strokes with the first one, when it is judged */
    double bound; /* chi2/dof that a law has to leave less than; INFINITY: at any price, else one
                   * that does not follow the strokes to their end is given up */
} diag__curves;
static inline int diag__in_haste(const diag__curves *w)
{
    return isfinite(w->bound);
}

/* ---- curve_site.c ---- */

/** Sites that the strokes visit.
 *  @param p, x  where: the null fit, or one in the mechanism with tables
 *  @return OK, ENOMEM */
stein_status diag__sites(const diag *d, const fit__problem *p, const double *x, diag__site **list,
                         int *n, stein_err *err);
/** "joint", "position", "torque", "rad", "N m". */
const char *diag__site_word(stein_table_kind kind, const stein_model *m, int index);
const char *diag__site_of(stein_table_kind kind);
const char *diag__site_what(const diag__site *s);
const char *diag__site_at_unit(const diag__site *s);
const char *diag__site_unit(const diag__site *s);

/* ---- curve_text.c ---- */

/** Add a table to a file's text.
 *  @param word, of, what  as in lab_law
 *  @param sd  [n] tolerances, NULL: none */
stein_status lab__table_add(lab__surgery *s, const char *table, const char *word, const char *place,
                            const char *of, const char *what, int n, const double *at,
                            const double *value, const double *sd, stein_err *err);
/** The text with the law in it, freed by the caller. */
stein_status lab__law_text(const lab_law *law, const char *text, size_t size, char **out,
                           size_t *nout, stein_err *err);

/* ---- curve_prior.c ---- */

/** One curve with all else eliminated, and the prior that the data choose. */
typedef struct diag__reduced {
    int n, index[CURVE_POINTS]; /* unknowns of the curve that are free */
    double M[CURVE_POINTS * CURVE_POINTS], c[CURVE_POINTS];
    double tau, length; /* chosen */
    int kind;
    double L[CURVE_POINTS * CURVE_POINTS], f[CURVE_POINTS], cov[CURVE_POINTS * CURVE_POINTS],
        logdet;
    double gained; /* fall of -2 ln p */
} diag__reduced;
/** Prior of the largest marginal likelihood, then f, cov, logdet, gained from M and c. */
void diag__curve_choose(const diag__site *s, diag__reduced *q);
/** cov of q as chosen, about f, of all priors, each as its marginal likelihood weighs it: the data
 *  may hardly know how smooth a law is, and the best prior alone gives bands that are too narrow.
 */
void diag__curve_spread(const diag__site *s, diag__reduced *q);
/** f and cov from M and c of q with the prior of another one. */
void diag__curve_solve(const diag__reduced *prior, diag__reduced *q);
/** f'(tau^2 K)^-1 f of values f [n]. */
double diag__curve_penalty(const diag__reduced *q, const double *f);

/* ---- curve_stand.c ---- */

typedef enum { DIAG_NONE, DIAG_CURVES, DIAG_OUTLINES } diag__moving;
/** Values of which tables move; those at pins never do. */
void diag__curve_hold(diag__curves *w, diag__moving which);

/** w->null: from the null fit, with the variances that it has found; no derivatives yet.
 *  @return OK, ENOMEM, or the failure of a stroke */
stein_status diag__stand_null(const diag *d, diag__curves *w, stein_err *err);
/** Those. @return OK, ENOMEM, or the failure of a stroke */
stein_status diag__stand_derived(diag__curves *w, stein_err *err);
/** w->early: from the file's own numbers along the strokes, to where a fit without a law first
 *  clearly leaves more than noise; its x NULL: it does so nowhere. @return OK, ENOMEM */
stein_status diag__stand_early(const diag *d, diag__curves *w, stein_err *err);

/** J at x with residuals r. What one stroke bears may be too much for another one: then differences
 *  by unknowns first .. end - 1 are shorter. @return as fit__sensitivities */
stein_status diag__curve_derive(fit__problem *p, int first, int end, const double *x,
                                const double *r, double *J, stein_err *err);

/* ---- curve_reduce.c ---- */

/** Gains of all curves (c[i] of site i) to first order where a fit without a law stands; early
 * those of their outlines, which cost half.
 *  @return OK, ENOMEM */
stein_status diag__curve_scores(diag__curves *w, const diag__stand *at, diag__curve *c,
                                stein_err *err);

/* ---- curve_fit.c ---- */

enum { CURVE_ROUNDS = 5 };
/** Fit one curve with everything else in a few rounds from the null fit. A stroke that cannot be
 *  simulated ends it where it is. @return OK, ENOMEM */
stein_status diag__curve_fit(diag__curves *w, diag__curve *c, stein_err *err);
/** A fit goes on up to a horizon; single strokes that it has lost are called back before
 *  (strays.c). Kept when it is better: c->gain has been weighed up to the same horizon.
 *  @param anyway  1: also when none was lost
 *  @param found   strays, out
 *  @param better  out  @return OK, ENOMEM */
stein_status diag__curve_recall(diag *d, diag__curves *w, diag__curve *c, double horizon,
                                int anyway, int *found, int *better, stein_err *err);
/** The end of a fit that describes the data: differences to both sides and fine integration tell
 *  numbers apart that do nearly the same, a curve's offset and a spring's preload, say; with coarse
 *  ones such a pair seems known. @return OK (also where it stays), ENOMEM */
stein_status diag__curve_settle(const diag *d, diag__curves *w, diag__curve *c, stein_err *err);

/* ---- curve_follow.c ---- */

/** From unknowns x [nu] that are good up to w->early.horizon, along the strokes. A stroke that
 *  cannot be simulated ends it. @return OK, ENOMEM */
stein_status diag__curve_follow(diag *d, diag__curves *w, const double *x, diag__curve *c,
                                stein_err *err);

/* ---- curve_rounds.c ---- */

/** Only the curve of this site moves, or its outline. */
void diag__curve_free_only(diag__curves *w, const diag__site *s);

/* ---- curve_outline.c ---- */

enum { OUTLINES = 2 };
/** Of the curves c [n], sorted by how they score at w->early, those whose outlines explain most of
 *  how the strokes begin, fitted along the strokes.
 *  @param to  [OUTLINES]; found of them, out, to be freed  @return OK, ENOMEM */
stein_status diag__curve_outlines(diag *d, diag__curves *w, const diag__curve *c, int n,
                                  diag__curve *to, int *found, stein_err *err);

/* ---- curve_judge.c ---- */

/** The largest gain first. */
void diag__curve_sort(diag__curve *c, int n);
/** As of the null fit: how many degrees of freedom a curve takes is its prior's business. */
double diag__curve_chi2_dof(const diag *d, const diag__curves *w, const diag__curve *c);
/** Does it leave no more than noise, so that no other one is asked? */
int diag__curve_describes(const diag *d, const diag__curves *w, const diag__curve *c);
/** Does it leave so little more that none from the null fit is asked? */
int diag__curve_nearly(const diag *d, const diag__curves *w, const diag__curve *c);
/** The laws of the first n curves, which were tried, into d->out, by the held-out strokes.
 *  @param before  RMSE of the held-out strokes without a law, NAN: there are none
 *  @return OK, ENOMEM */
stein_status diag__curve_judge(diag *d, diag__curves *w, int n, double before, stein_err *err);
/** What is said of the first law, and the law in the place of the causes where it is believed.
 *  @return OK, ENOMEM */
stein_status diag__curve_conclude(diag *d, diag__curves *w, double before, diag__found *f,
                                  stein_err *err);

/* ---- curve_show.c ---- */

void diag__law_json(lab__json *j, const lab_diagnosis *d);

#endif
