/* SPDX-License-Identifier: GPL-3.0-or-later
 * curve.h - shared by the files of the search for an unknown law.
 *
 *   curve.c          which law, of what, and where explains what is left
 *   curve_site.c     where a law could sit, and the states that the strokes visit there
 *   curve_text.c     a mechanism file with tables in it
 *   curve_baseline.c    the fit without a law from which curves begin
 *   curve_prior.c    a curve as a Gaussian process: how large, how smooth
 *   curve_fitting.h  a curve and all other unknowns, by penalised least squares
 *   curve_judge.c    is it accepted, and its sentence
 *   curve_show.c     the law in diagnosis.json and report.html
 * Included by: this folder, src/lab/diagnosis, src/lab/effects, src/lab/report.
 */
#ifndef CURVE_H
#define CURVE_H

#include <gsl/gsl_matrix.h>
#include <math.h>

#include "verdict.h"
#include "added_parts.h"

enum { CURVE_POINTS = 25, CURVE_CONTACT_POINTS = 25 };

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
    double price;  /* of the fit's freedom: part of -2 ln p from the curve's prior and logdet */
    double cov[CURVE_POINTS * CURVE_POINTS];
    double excess; /* factor on variances where the noise is not stated */
    int fitted;
} diag__curve;

/** The mechanism with a table of zeros at every site, and records in it. */
typedef struct diag__tables {
    diag__site *site; /* [nsite] */
    int nsite;
    lab_model *model;
    lab_fit_def def;
    const char **name; /* free: unknowns of the null hypothesis, then all values */
    char *names;
    double *name_sd; /* assumed tolerances, 0: none */
} diag__tables;

/** Records in it, and the fit without a law: where curves begin. */
typedef struct diag__curves {
    diag__problem *q;
    const diag__row *null;
    const diag__tables *in;
    lab_dataset *records;
    const diag__site *site; /* [nsite] as in the tables */
    int nsite;
    fit__problem p;
    double D[LAB_SCATTERS]; /* variances of scatter, in the priors' */
    double *x, *r, *J;      /* without a law; one block */
    double objective;       /* chi2 and priors there */
} diag__curves;

/** The laws of an unknown effect. */
typedef struct diag__laws {
    diag__tables in;
    diag__curves all; /* all records */
    diag__curve curve[4];
    int n; /* fitted, the best first */
} diag__laws;

/* ---- curve.c ---- */

/** Laws that explain the residual of the null hypothesis, fitted; the best one first.
 *  @return OK (n 0: none), ENOMEM; free in any case */
stein_status diag__laws_find(diag__problem *q, const diag__row *null, diag__laws *l,
                             stein_err *err);
void diag__laws_free(diag__laws *l);
/** Records in the tables' mechanism. @return OK, ENOMEM, a failure; close in any case */
stein_status diag__curves_open(diag__curves *w, const diag__tables *in, diag__problem *q,
                               const diag__row *null, const lab_dataset *records, stein_err *err);
void diag__curves_close(diag__curves *w);

/* ---- curve_site.c ---- */

/** Sites that the records visit, the simulation held near them.
 *  @return OK, ENOMEM */
stein_status diag__sites(const fit__problem *p, const double *x, diag__site **list, int *n,
                         stein_err *err);
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
stein_status lab__table_add(lab__yaml_edit *s, const char *table, const char *word,
                            const char *place, const char *of, const char *what, int n,
                            const double *at, const double *value, const double *sd,
                            stein_err *err);
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
/** cov of q as chosen, about f, of all priors, weighted by their marginal likelihood. The data may
 *  determine the smoothness poorly, and the best prior alone gives bands that are too narrow.
 */
void diag__curve_spread(const diag__site *s, diag__reduced *q);
/** f and cov from M and c of q with the prior of another one. */
void diag__curve_solve(const diag__reduced *prior, diag__reduced *q);
/** f'(tau^2 K)^-1 f of values f [n]. */
double diag__curve_penalty(const diag__reduced *q, const double *f);

/* ---- curve_baseline.c ---- */

/** No table moves, or all do; values at pins never do. */
void diag__curve_hold(diag__curves *w, int all_move);
/** x, r of a fit without a law while an observer with that gain holds; steps of all curves.
 *  @return OK, ENOMEM, or the failure of a stroke */
stein_status diag__stand(diag__curves *w, double gain, stein_err *err);
/** J there, by all curves. @return OK, ENOMEM, or the failure of a stroke */
stein_status diag__stand_derive(diag__curves *w, stein_err *err);
/** J at x with residuals r. A difference may be too large for one of the strokes: then differences
 *  by unknowns first .. end - 1 are shorter. @return as fit__sensitivities */
stein_status diag__curve_derive(fit__problem *p, int first, int end, const double *x,
                                const double *r, double *J, stein_err *err);

/* ---- curve_reduce.c ---- */

/** Gains of all curves (c[i] of site i) to first order at the fit without a law.
 *  @return OK, ENOMEM */
stein_status diag__curve_scores(diag__curves *w, diag__curve *c, stein_err *err);

/* ---- curve_fit.c ---- */

/** Fit one curve with everything else, held near the records first, then free. A stroke that cannot
 *  be simulated ends it where it is. @return OK, ENOMEM */
stein_status diag__curve_fit(diag__curves *w, diag__curve *c, stein_err *err);
/** The end of a fit that describes the data: central differences and fine integration separate
 *  numbers with nearly the same effect, as a curve's offset and a spring's preload. With coarse
 *  ones such a pair seems determined. @return OK (also where it stays), ENOMEM */
stein_status diag__curve_settle(diag__curves *w, diag__curve *c, stein_err *err);

/* ---- curve_rounds.c ---- */

/** Only the curve of this site moves. */
void diag__curve_free_only(diag__curves *w, const diag__site *s);

/* ---- curve_judge.c ---- */

/** The largest gain first. */
void diag__curve_sort(diag__curve *c, int n);
/** With the degrees of freedom of the null fit: the points of a curve are in its prior. */
double diag__curve_chi2_dof(const diag__curves *w, const diag__curve *c);
/** The laws into o; if the first one is accepted beside the judgement, it becomes the verdict.
 *  @param reporting  records that no fit has read; n 0: none
 *  @param before, after  of the report; after belongs to the law if it is accepted
 *  @return OK, ENOMEM */
stein_status diag__law_judge(diag__laws *l, const diag__judgement *j, const diag__row *best,
                             const lab_dataset *reporting, const diag__reported *before,
                             diag__reported *after, lab_diagnosis *o, stein_err *err);

/** Laws of a diagnosis are freed; it has none any more. */
void diag__laws_drop(lab_diagnosis *o);

/* ---- curve_show.c ---- */

void diag__law_json(lab__json *j, const lab_diagnosis *d);

#endif
