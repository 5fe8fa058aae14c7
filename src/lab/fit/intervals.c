/* SPDX-License-Identifier: GPL-3.0-or-later
 * intervals.c - what the data tell about the parameters, and what they do not.
 *
 * At the minimum, with the nuisances eliminated (their priors kept), the Schur complement of J'J is
 * the information on the free parameters, in prior standard deviations:
 *
 *      I          of the data alone
 *      I/v + 1    with the priors:   covariance = (I/v + 1)^-1,  v = max(1, chi2/dof) f
 *
 * v widens the intervals where the residual is more than the stated noise (Birge 1932). The model
 * then lacks something, and the formal errors mean little, but smaller ones would be false. Where
 * the noise was taken from the residual, f = 1 + 2 sum of its correlations (up to the first below
 * 0.1): a slow residual has fewer independent samples than rows. Eigenvalues of I show the
 * combinations that the data cannot tell: 1/sqrt(lambda) is their sd, in prior sd. Correlations by
 * the data alone are those of I^-1; parameters that no data depend on are named apart and left out.
 */
#include <gsl/gsl_eigen.h>
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fitting.h"

static const double seen = 0.02; /* chi by a change of one prior sd: less is rounding */
static const double told_apart = 0.95;

/* I of the data in m; its factor is not needed */
static int information(fit__normal *n, const fit__problem *p, const double *x, const double *r,
                       const double *J, gsl_matrix *m)
{
    fit__normal_fill(n, p, x, r, J, 0);
    gsl_matrix_set_identity(m); // of what stays
    for (int i = 0; i < n->n; i++) {
        for (int k = 0; k < n->n; k++) {
            gsl_matrix_set(m, (size_t)n->moving[i], (size_t)n->moving[k],
                           gsl_matrix_get(n->A, (size_t)i, (size_t)k));
        }
    }
    if (fit__normal_factor(n, p, 0.0, NULL) !=
        0) { // S may well be singular, the strokes' blocks are not
        for (int s = 0; s < p->nstroke; s++) {
            if (n->B[s] != NULL && !(gsl_matrix_get(n->BL[s], 0, 0) > 0.0)) {
                return -1;
            }
        }
    }
    for (int s = 0; s < p->nstroke; s++) {
        for (int i = 0; n->B[s] != NULL && i < n->n; i++) {
            for (int k = 0; k < n->n; k++) {
                double sum = 0.0;
                for (size_t a = 0; a < n->C[s]->size1; a++) {
                    sum += gsl_matrix_get(n->C[s], a, (size_t)i) *
                           gsl_matrix_get(n->X[s], a, (size_t)k);
                }
                *gsl_matrix_ptr(m, (size_t)n->moving[i], (size_t)n->moving[k]) -= sum;
            }
        }
    }
    return 0;
}

static void note_unseen(const fit__problem *p, lab_fit *fit, const double *x, const gsl_matrix *m,
                        double v)
{
    for (int k = 0; k < p->np; k++) {
        double lambda = gsl_matrix_get(m, (size_t)k, (size_t)k);
        const fit__unknown *u = &p->unknown[k];
        fit->value[k].unseen = !(lambda > seen * seen);
        fit->value[k].data_sd =
            fit->value[k].unseen ? INFINITY : sqrt(v / lambda) * u->sd * fabs(fit__slope(u, x[k]));
    }
}

static stein_status add_pair(lab_fit *fit, int a, int b, double correlation, stein_err *err)
{
    lab_fit_pair *more = realloc(fit->pair, sizeof *more * (size_t)(fit->npair + 1));
    if (more == NULL) {
        return lab__no_memory(err);
    }
    fit->pair = more;
    fit->pair[fit->npair++] = (lab_fit_pair){a, b, correlation};
    return STEIN_OK;
}

/* pseudo-inverse of I over the seen parameters, by its eigenvectors; pairs, condition, weakest */
static stein_status correlations(const fit__problem *p, lab_fit *fit, const gsl_vector *lambda,
                                 const gsl_matrix *V, stein_err *err)
{
    size_t np = (size_t)p->np;
    double most = gsl_vector_max(lambda), least = INFINITY;
    size_t weakest = 0;
    gsl_matrix *inverse = gsl_matrix_calloc(np, np);
    if (inverse == NULL) {
        return lab__no_memory(err);
    }
    for (size_t e = 0; e < np; e++) {
        double l = fmax(gsl_vector_get(lambda, e), 1e-14 * most);
        int own = 0; // an eigenvector of a single unseen parameter
        for (size_t k = 0; k < np; k++) {
            own |= fit->value[k].unseen && fabs(gsl_matrix_get(V, k, e)) > 0.9;
        }
        if (own) {
            continue;
        }
        if (l < least) {
            least = l;
            weakest = e;
        }
        for (size_t i = 0; i < np; i++) {
            for (size_t k = 0; k < np; k++) {
                *gsl_matrix_ptr(inverse, i, k) +=
                    gsl_matrix_get(V, i, e) * gsl_matrix_get(V, k, e) / l;
            }
        }
    }
    fit->condition = isfinite(least) ? sqrt(most / least) : 1.0;
    fit->weakest_sd = isfinite(least) ? 1.0 / sqrt(least) : INFINITY;
    stein_status status = STEIN_OK;
    for (size_t i = 0; i < np; i++) {
        fit->weakest[i] = gsl_matrix_get(V, i, weakest);
        for (size_t k = 0; status == STEIN_OK && k < i; k++) {
            double c = gsl_matrix_get(inverse, i, k) /
                       sqrt(gsl_matrix_get(inverse, i, i) * gsl_matrix_get(inverse, k, k));
            if (!fit->value[i].unseen && !fit->value[k].unseen && fabs(c) > told_apart) {
                status = add_pair(fit, (int)k, (int)i, c, err);
            }
        }
    }
    gsl_matrix_free(inverse);
    return status;
}

static stein_status spectrum(const fit__problem *p, lab_fit *fit, gsl_matrix *m, stein_err *err)
{
    size_t np = (size_t)p->np;
    gsl_eigen_symmv_workspace *w = gsl_eigen_symmv_alloc(np);
    gsl_vector *lambda = gsl_vector_alloc(np);
    gsl_matrix *V = gsl_matrix_alloc(np, np);
    stein_status status = STEIN_OK;
    if (w == NULL || lambda == NULL || V == NULL) {
        status = lab__no_memory(err);
    } else {
        gsl_eigen_symmv(m, lambda, V, w);
        status = correlations(p, fit, lambda, V, err);
    }
    gsl_eigen_symmv_free(w);
    gsl_vector_free(lambda);
    gsl_matrix_free(V);
    return status;
}

static void take_interval(lab_fit_value *v, const fit__unknown *u, double x, double variance)
{
    double sd = sqrt(variance), z = 1.959963984540054; // of a normal one, two-sided 95 %
    v->value = fit__value(u, x);
    v->sd = sd * u->sd * fabs(fit__slope(u, x));
    v->lo = fit__value(u, x - z * sd); // of the logarithm, where that was fitted
    v->hi = fit__value(u, x + z * sd);
}

/* variances of the strokes' own: B^-1 + X S^-1 X' */
static void own_intervals(const fit__problem *p, lab_fit *fit, const double *x,
                          const fit__normal *n, const gsl_matrix *cov)
{
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        if (t->own == 0) {
            continue;
        }
        gsl_linalg_cholesky_invert(n->BL[s]);
        for (int a = 0; a < t->own; a++) {
            double sum = gsl_matrix_get(n->BL[s], (size_t)a, (size_t)a);
            for (size_t i = 0; i < cov->size1; i++) {
                for (size_t k = 0; k < cov->size1; k++) {
                    sum += gsl_matrix_get(n->X[s], (size_t)a, i) * gsl_matrix_get(cov, i, k) *
                           gsl_matrix_get(n->X[s], (size_t)a, k);
                }
            }
            take_interval(&fit->stroke[s].value[a], &p->unknown[t->first + a], x[t->first + a],
                          sum);
        }
    }
}

/* what one more step would gain */
static stein_status last_gain(const fit__problem *p, lab_fit *fit, fit__normal *n, stein_err *err)
{
    double *dx = malloc(sizeof *dx * (size_t)p->nu);
    if (dx == NULL) {
        return lab__no_memory(err);
    }
    fit__normal_step(n, p, dx);
    fit->gradient = 0.0;
    for (int u = 0; u < p->nu; u++) {
        fit->gradient -= dx[u] * n->g[u];
    }
    free(dx);
    return STEIN_OK;
}

static void covariances(const fit__problem *p, lab_fit *fit, const double *x, fit__normal *n)
{
    if (n->n > 0) {
        gsl_linalg_cholesky_invert(n->S);
    }
    for (int i = 0; i < p->np; i++) {
        for (int k = 0; k < p->np; k++) {
            int moves = n->row[i] >= 0 && n->row[k] >= 0; // what stays is as sure as before
            double v = moves ? gsl_matrix_get(n->S, (size_t)n->row[i], (size_t)n->row[k]) : i == k;
            fit->covariance[i * p->np + k] = v * p->unknown[i].sd * p->unknown[k].sd;
            if (i == k) {
                take_interval(&fit->value[i], &p->unknown[i], x[i], v);
            }
        }
    }
    own_intervals(p, fit, x, n, n->S);
}

/* the normal equations of data whose variances are v times as large */
static stein_status refill(fit__normal *n, const fit__problem *p, const double *x, const double *r,
                           const double *J, double v, stein_err *err)
{
    size_t rows = fit__offset(p, p->nstroke), columns = fit__columns(p);
    double *scaled = malloc(sizeof *scaled * (rows + columns + 1)), factor = 1.0 / sqrt(v);
    if (scaled == NULL) {
        return lab__no_memory(err);
    }
    for (size_t i = 0; i < rows + columns; i++) {
        scaled[i] = factor * (i < rows ? r[i] : J[i - rows]);
    }
    fit__normal_fill(n, p, x, scaled, scaled + rows, 1);
    free(scaled);
    return fit__normal_factor(n, p, 0.0, NULL) == 0
               ? STEIN_OK
               : lab__fail(err, STEIN_ENONFINITE, "the information matrix is not positive");
}

stein_status fit__intervals(fit__problem *p, lab_fit *fit, const double *x, const double *r,
                            const double *J, stein_err *err)
{
    fit__normal n;
    double v = fmax(1.0, fit->chi2_dof) * fit->inflation;
    stein_status status = fit__normal_make(&n, p, err);
    gsl_matrix *m = gsl_matrix_alloc((size_t)p->np, (size_t)p->np);
    if (status == STEIN_OK && m == NULL) {
        status = lab__no_memory(err);
    }
    if (status == STEIN_OK && information(&n, p, x, r, J, m) != 0) {
        status = lab__fail(err, STEIN_ENONFINITE, "a record's own unknowns cannot be told apart");
    }
    if (status == STEIN_OK) {
        note_unseen(p, fit, x, m, v);
        status = spectrum(p, fit, m, err);
    }
    if (status == STEIN_OK) {
        status = refill(&n, p, x, r, J, 1.0, err);
        status = status == STEIN_OK ? last_gain(p, fit, &n, err) : status;
        status = status == STEIN_OK ? refill(&n, p, x, r, J, v, err) : status;
    }
    if (status == STEIN_OK) {
        covariances(p, fit, x, &n);
    }
    gsl_matrix_free(m);
    fit__normal_free(&n);
    return status;
}
