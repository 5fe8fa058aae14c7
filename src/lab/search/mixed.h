/* SPDX-License-Identifier: GPL-3.0-or-later
 * mixed.h - the mixed model of strokes that scatter by themselves.
 * Included by: this folder, src/lab/verdict.
 */
#ifndef LAB_MIXED_H
#define LAB_MIXED_H

#include "run.h"

enum { LAB_SCATTERS = 9 };

/** What kind of scatter: variances are estimated between bounds. */
typedef struct lab__scatter {
    double first, most; /* variance: where the search begins, how large it may become */
} lab__scatter;

/** r = F beta + G alpha + Z u + e over strokes, as Gram matrices: F what is fitted anyhow, G the
 *  candidates, Z what differs from stroke to stroke, e white with variance 1. */
typedef struct lab__mixed {
    int nf, nc, nz, ncol; /* columns of F, G, Z; nf + nc + 1 */
    int nstroke, nclass;
    int *zclass; /* [nz] kind of scatter of a column of Z; -1: variance 1 */
    int *flat;   /* [nf] 1: no prior; 0: N(0, 1) */
    /* [nf] r is what is left at this beta: sums of squares stay those of the misfit, however long
     * the columns of F are. The prior is that of beta itself; what is solved for is its change */
    double *at;
    lab__scatter limit[LAB_SCATTERS];
    double D[LAB_SCATTERS]; /* present variances */
    double worth;        /* of what is known of them before, in columns of Z: lab__mixed_scatter */
    double *Q, *QZ, *ZZ; /* per stroke: C'C, Z'C, Z'Z with C = [F G r] */
    double *A;           /* [ncol*ncol] sum C' V^-1 C, of the columns weighed last */
    double *W;           /* per stroke (D^-1 + Z'Z)^-1 */
    double logdet;       /* sum log |V| */
    double *work, *solving, *effects; /* rooms: of weighing, [2*ncol*ncol] of solving, [nz] */
    int *pick;                        /* [ncol] the columns weighed last */
} lab__mixed;

/** @param zclass [nz], flat [nf] (NULL: all have priors)  copied  @return OK, ENOMEM */
stein_status lab__mixed_make(lab__mixed *m, int nstroke, int nf, int nc, int nz, const int *zclass,
                             const int *flat, const lab__scatter *scatter, int nclass,
                             stein_err *err);
void lab__mixed_free(lab__mixed *m);
/** Fill in a stroke of n samples. @param C  [(ncol + nz)*n] by column: F, G, r, Z */
void lab__mixed_stroke(lab__mixed *m, int stroke, int n, const double *C);
/** A of all columns and W at the present variances. */
void lab__mixed_weigh(lab__mixed *m);
/** Fit F and the candidates `with` [nwith], whose amounts have the prior N(0, 1).
 *  @param beta  [nf + nwith] out, of F its change from `at`; cov [square] out, may be NULL
 *  @return -2 log marginal likelihood up to a constant, INFINITY without a solution */
double lab__mixed_solve(const lab__mixed *m, const int *with, int nwith, double *beta, double *cov);
/** Sum of squares where F and the candidates `with` fit best, priors included, at the present
 *  variances. @param beta  as above */
double lab__mixed_least(lab__mixed *m, const int *with, int nwith, double *beta);
/** lab__mixed_solve with the variances estimated in at most `rounds` rounds, and A and W there; A
 * of these columns and r alone. With a worth w they are those of the prior (limit.first) to the
 * share that w columns more would have: a few strokes may look as if nothing differed. */
double lab__mixed_scatter(lab__mixed *m, const int *with, int nwith, int rounds, double *beta,
                          double *cov);
/** Expected random effects of a stroke at beta, u [nz] out. */
void lab__mixed_effects(const lab__mixed *m, int stroke, const int *with, int nwith,
                        const double *beta, double *u);
/** What F leaves of the candidates at the present variances: I = G'PG [nc*nc], s = G'Pr [nc] and
 *  r'Pr. @return 0: F has no solution, or no memory */
int lab__mixed_project(const lab__mixed *m, double *I, double *s, double *square);
/** Candidates in a part of the strokes alone, with F and the causes that act already eliminated. */
typedef struct lab__shares {
    int n, nstroke;               /* numbers that are eliminated */
    int none;                     /* 1: there is no solution */
    double *S, *b, *c;            /* their Cholesky factor, solution, workspace */
    double *info, *score, *cross; /* [nc*nstroke], the last one times n */
} lab__shares;
/** @param m  weighed by lab__mixed_weigh  @return OK, ENOMEM; free it in any case */
stein_status lab__shares_make(lab__shares *h, const lab__mixed *m, const int *with, int nwith,
                              stein_err *err);
void lab__shares_free(lab__shares *h);
/** Fall of -2 ln L by a candidate in strokes first .. last, its amount with the prior N(0, 1).
 *  @param amount  out  @return -INFINITY without a solution */
double lab__shares_gain(lab__shares *h, int candidate, int first, int last, double *amount);

/** Score, expected amount and information of every candidate [nc], and the correlations [nc*nc] of
 * what F leaves of them. */
void lab__mixed_score(const lab__mixed *m, double *score, double *epc, double *info, double *corr);
/** The largest of the candidates' scores (those with use [nc] != 0) in draws where there is
 * nothing.
 *  @param nu  degrees of freedom behind the scatter: strokes - 1
 *  @return freed by the caller; NULL: no candidate, correlations that are none, or no memory */
double *lab__family_draws(const double *corr, const unsigned char *use, int nc, int nu);
/** Probability that it reaches `score`; 1 without draws. */
double lab__family_p(const double *draws, double score);

#endif
