/* SPDX-License-Identifier: GPL-3.0-or-later
 * curve_fitting.h - shared by the fits of a curve.
 *
 *   curve_reduce.c  a curve with all other unknowns eliminated
 *   curve_collinear.c    numbers that move a stroke exactly as a curve does
 *   curve_rounds.c  damped steps, and the derivatives they need
 *   curve_fit.c     from where the null fit stands; the end of a fit
 * Included by: this folder.
 */
#ifndef CURVE_FITTING_H
#define CURVE_FITTING_H

#include "curve.h"

/* ---- curve_reduce.c ---- */

/** Normal equations without the strokes' own unknowns: of the parameters that move. */
typedef struct diag__globals {
    gsl_matrix *S;
    gsl_vector *g;
    const int *row; /* as in fit__normal, which has to outlive this */
} diag__globals;
/** From the columns of all unknowns. It computes the factors of the strokes n->BL and n->X.
 *  @return OK, ENOMEM; diag__globals_free in any case */
stein_status diag__globals_of(fit__normal *n, const fit__problem *p, diag__globals *o,
                              stein_err *err);
void diag__globals_free(diag__globals *o);

/** The step of the parameters for a change of the curve, and their precision. */
typedef struct diag__others {
    int n, *index;
    gsl_matrix *F; /* Cholesky factor of S_pp */
    gsl_matrix *X; /* S_pp^-1 S_pf */
    gsl_vector *g; /* S_pp^-1 g_p */
} diag__others;
/** M and c of a curve at x.
 *  @return OK, ENOMEM, ESINGULAR; diag__others_free in any case */
stein_status diag__reduce(const diag__curves *w, const diag__site *s, const diag__globals *o,
                          const double *x, diag__others *t, diag__reduced *q, stein_err *err);
void diag__others_free(diag__others *o);
/** Prior of the largest marginal likelihood, as diag__curve_choose, of a curve at x with residuals
 * r. @return factor on variances that belongs to it: 1 where the noise is stated */
double diag__curve_choose_noise(const diag__curves *w, const diag__site *s, const double *x,
                                const double *r, diag__reduced *q);
void diag__temper(diag__reduced *q, double excess);

/* ---- curve_collinear.c ---- */

/** Derivatives J at x with a parameter that has the effect of the curve of a joint: those of the
 * curve.
 *  @return OK, ENOMEM */
stein_status diag__same_as_curve(const diag__curves *w, const diag__site *s, const double *x,
                                 double *J, stein_err *err);

/* ---- curve_rounds.c ---- */

/** A fit under way. */
typedef struct diag__fitting {
    diag__curves *w;
    diag__curve *c; /* its x, r, sd, cov and excess follow */
    fit__normal n;
    diag__reduced q; /* at c->x, with the prior that the data chose there */
    double *J;
    double *try_x, *try_r, *was_x, *was_r, *dx; /* [nu], [rows] */
    double objective;                           /* of the round: chi2, priors and penalty */
    double damping;
    double worth; /* gain of a round over whole strokes from which on another round follows */
} diag__fitting;
/** Room, and nothing but this curve moves. @return OK, ENOMEM: there is nothing to end */
stein_status diag__fitting_begin(diag__fitting *t, diag__curves *w, diag__curve *c, stein_err *err);
/** The same of a new fit from unknowns x [nu], in c->x. @return OK, ENOMEM: there is nothing to end
 */
stein_status diag__fitting_begin_at(diag__fitting *t, diag__curves *w, diag__curve *c,
                                    const double *x, stein_err *err);
/** Value of the fit: c->fitted, gain and price. */
void diag__fitting_weigh(diag__fitting *t, stein_status end);
void diag__fitting_end(diag__fitting *t);
/** Rounds until one gains little, under an observer with that gain (0: free).
 *  @param known  1: c->r and the derivatives come from the fit without a law
 *  @return OK, ENOMEM, or the failure of a stroke: c stays where it is */
stein_status diag__rounds(diag__fitting *t, double gain_of_observer, int rounds, int known,
                          stein_err *err);
/** x of zeros, r, sd. @return OK, ENOMEM */
stein_status diag__curve_room(const fit__problem *p, diag__curve *c, stein_err *err);
#endif
