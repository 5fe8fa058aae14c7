/* SPDX-License-Identifier: GPL-3.0-or-later
 * curve_prior.c - how large and how smooth a law is, by marginal likelihood. The equations stand in
 * curve_fit.c.
 */
#include <gsl/gsl_blas.h>
#include <gsl/gsl_eigen.h>
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <string.h>

#include "functions.h"
#include "curve.h"

enum { N = CURVE_POINTS, LEVELS = 26, LENGTHS = 8, KINDS = 3 };
static const double first_tau = 0.1, stride = 2.0; /* in values that change the data by one noise */
static const double length[LENGTHS] = {0.06, 0.1, 0.16, 0.25,
                                       0.4,  0.8, 1.6,  4.0}; /* of the range */
static const double jitter = 1e-8;                            /* of K */
static const double unlikely = 14.0; /* -2 ln p of a prior above the best one's */

static double kernel(int kind, double d)
{
    double u = (kind == 1 ? sqrt(5.0) : sqrt(3.0)) * d;
    return kind == 0   ? stein__exp_of(-0.5 * d * d)
           : kind == 1 ? (1.0 + u + u * u / 3.0) * stein__exp_of(-u)
                       : (1.0 + u) * stein__exp_of(-u);
}

/* lower Cholesky factor of tau^2 K in L. @return 0, -1 */
static int prior_factor(const diag__site *s, const diag__reduced *q, int kind, double tau,
                        double scale, double *L)
{
    double range = s->at[s->n - 1] - s->at[0];
    for (int i = 0; i < q->n; i++) {
        for (int j = 0; j < q->n; j++) {
            double a = s->at[q->index[i] - s->first], b = s->at[q->index[j] - s->first];
            L[i * q->n + j] =
                tau * tau * (kernel(kind, fabs(a - b) / (scale * range)) + (i == j) * jitter);
        }
    }
    gsl_matrix_view m = gsl_matrix_view_array(L, (size_t)q->n, (size_t)q->n);
    if (gsl_linalg_cholesky_decomp1(&m.matrix) != 0) {
        return -1;
    }
    for (int i = 0; i < q->n; i++) {
        for (int j = i + 1; j < q->n; j++) {
            L[i * q->n + j] = 0.0;
        }
    }
    return 0;
}

/* f, cov, logdet of a prior. @return fall of -2 ln p, -INFINITY without a solution */
static double solve(diag__reduced *q, const double *L)
{
    size_t n = (size_t)q->n;
    double S[N * N], T[N * N], b[N], h[N], gained = 0.0;
    gsl_matrix_view l = gsl_matrix_view_array((double *)L, n, n);
    gsl_matrix_view m = gsl_matrix_view_array(q->M, n, n), s = gsl_matrix_view_array(S, n, n);
    gsl_matrix_view t = gsl_matrix_view_array(T, n, n), cov = gsl_matrix_view_array(q->cov, n, n);
    gsl_vector_view c = gsl_vector_view_array(q->c, n), bv = gsl_vector_view_array(b, n);
    gsl_vector_view hv = gsl_vector_view_array(h, n), fv = gsl_vector_view_array(q->f, n);
    gsl_blas_dgemm(CblasNoTrans, CblasNoTrans, 1.0, &m.matrix, &l.matrix, 0.0, &t.matrix);
    gsl_blas_dgemm(CblasTrans, CblasNoTrans, 1.0, &l.matrix, &t.matrix, 0.0, &s.matrix);
    for (int i = 0; i < q->n; i++) {
        S[i * q->n + i] += 1.0;
    }
    gsl_blas_dgemv(CblasTrans, 1.0, &l.matrix, &c.vector, 0.0, &bv.vector);
    if (gsl_linalg_cholesky_decomp1(&s.matrix) != 0) {
        return -INFINITY;
    }
    q->logdet = 0.0;
    for (int i = 0; i < q->n; i++) {
        q->logdet += 2.0 * stein__log_of(S[i * q->n + i]);
    }
    gsl_linalg_cholesky_solve(&s.matrix, &bv.vector, &hv.vector);
    gsl_blas_ddot(&bv.vector, &hv.vector, &gained);
    gsl_blas_dgemv(CblasNoTrans, 1.0, &l.matrix, &hv.vector, 0.0, &fv.vector);
    gsl_linalg_cholesky_invert(&s.matrix);
    gsl_blas_dgemm(CblasNoTrans, CblasNoTrans, 1.0, &l.matrix, &s.matrix, 0.0, &t.matrix);
    gsl_blas_dgemm(CblasNoTrans, CblasTrans, 1.0, &t.matrix, &l.matrix, 0.0, &cov.matrix);
    return gained - q->logdet;
}

/* L'ML = U diag(e) U', b = U'L'c for a prior of tau = 1. @return 0, -1 */
static int decompose(diag__reduced *q, const double *L, gsl_eigen_symmv_workspace *room, double *e,
                     double *b)
{
    size_t n = (size_t)q->n;
    double S[N * N], T[N * N], U[N * N], h[N];
    gsl_matrix_const_view l = gsl_matrix_const_view_array(L, n, n);
    gsl_matrix_view m = gsl_matrix_view_array(q->M, n, n), s = gsl_matrix_view_array(S, n, n);
    gsl_matrix_view t = gsl_matrix_view_array(T, n, n), u = gsl_matrix_view_array(U, n, n);
    gsl_vector_view c = gsl_vector_view_array(q->c, n), hv = gsl_vector_view_array(h, n);
    gsl_vector_view ev = gsl_vector_view_array(e, n), bv = gsl_vector_view_array(b, n);
    gsl_blas_dgemm(CblasNoTrans, CblasNoTrans, 1.0, &m.matrix, &l.matrix, 0.0, &t.matrix);
    gsl_blas_dgemm(CblasTrans, CblasNoTrans, 1.0, &l.matrix, &t.matrix, 0.0, &s.matrix);
    gsl_blas_dgemv(CblasTrans, 1.0, &l.matrix, &c.vector, 0.0, &hv.vector);
    for (int i = 0; i < q->n * q->n; i++) {
        if (!isfinite(S[i])) {
            return -1;
        }
    }
    gsl_eigen_symmv(&s.matrix, &ev.vector, &u.matrix, room);
    gsl_blas_dgemv(CblasTrans, 1.0, &u.matrix, &hv.vector, 0.0, &bv.vector);
    return 0;
}

/* a value that changes the data by one noise */
static double unit_of(const diag__reduced *q)
{
    double mean = 0.0;
    for (int i = 0; i < q->n; i++) {
        mean += fmax(0.0, q->M[i * q->n + i]) / q->n;
    }
    return mean > 0.0 ? 1.0 / sqrt(mean) : 1.0;
}

/* fall of -2 ln p with the prior larger by tau */
static double fall(const diag__reduced *q, const double *e, const double *b, double tau)
{
    double sum = 0.0, t2 = tau * tau;
    for (int i = 0; i < q->n; i++) {
        double d = 1.0 + t2 * fmax(0.0, e[i]);
        sum += t2 * b[i] * b[i] / d - stein__log_of(d);
    }
    return sum;
}

/* the factor of prior k with tau = 1, in q->L, and the decomposition by it. @return 1, 0: none */
static int takes_apart(const diag__site *s, diag__reduced *q, int k,
                       gsl_eigen_symmv_workspace *room, double *e, double *b)
{
    return prior_factor(s, q, k / LENGTHS, 1.0, length[k % LENGTHS], q->L) == 0 &&
           decompose(q, q->L, room, e, b) == 0;
}

/* tau, length and kind of the largest marginal likelihood, then f and cov */
void diag__curve_choose(const diag__site *s, diag__reduced *q)
{
    double e[N], b[N], best = -INFINITY, first = first_tau * unit_of(q);
    gsl_eigen_symmv_workspace *room = gsl_eigen_symmv_alloc((size_t)q->n);
    q->tau = 0.0;
    for (int k = 0; room != NULL && k < LENGTHS * KINDS; k++) {
        double tau = first;
        if (!takes_apart(s, q, k, room, e, b)) {
            continue;
        }
        for (int i = 0; i < LEVELS; i++, tau *= stride) {
            double gain = fall(q, e, b, tau);
            if (gain > best) {
                best = gain;
                q->tau = tau;
                q->length = length[k % LENGTHS];
                q->kind = k / LENGTHS;
            }
        }
    }
    gsl_eigen_symmv_free(room);
    q->gained = best;
    if (q->tau > 0.0 && prior_factor(s, q, q->kind, q->tau, q->length, q->L) == 0) {
        q->gained = solve(q, q->L);
    }
}

/* adds the covariance of a prior with weight w to cov, about f */
static void add_spread(const diag__reduced *one, const double *f, double w, double *cov)
{
    int n = one->n;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            cov[i * n + j] += w * (one->cov[i * n + j] + (one->f[i] - f[i]) * (one->f[j] - f[j]));
        }
    }
}

void diag__curve_spread(const diag__site *s, diag__reduced *q)
{
    double e[N], b[N], cov[N * N] = {0.0}, sum = 0.0, first = first_tau * unit_of(q);
    diag__reduced one = *q;
    gsl_eigen_symmv_workspace *room = q->tau > 0.0 ? gsl_eigen_symmv_alloc((size_t)q->n) : NULL;
    for (int k = 0; room != NULL && k < LENGTHS * KINDS; k++) {
        double tau = first;
        if (!takes_apart(s, &one, k, room, e, b)) {
            continue;
        }
        for (int i = 0; i < LEVELS; i++, tau *= stride) {
            double worse = q->gained - fall(&one, e, b, tau);
            if (worse < unlikely &&
                prior_factor(s, &one, k / LENGTHS, tau, length[k % LENGTHS], one.L) == 0 &&
                isfinite(solve(&one, one.L))) {
                double w = stein__exp_of(-0.5 * worse);
                add_spread(&one, q->f, w, cov);
                sum += w;
            }
        }
    }
    gsl_eigen_symmv_free(room);
    for (int i = 0; sum > 0.0 && i < q->n * q->n; i++) {
        q->cov[i] = cov[i] / sum;
    }
}

void diag__curve_solve(const diag__reduced *prior, diag__reduced *q)
{
    q->tau = prior->tau;
    q->length = prior->length;
    q->kind = prior->kind;
    memcpy(q->L, prior->L, sizeof q->L);
    q->gained = solve(q, q->L);
}

/* f'(tau^2 K)^-1 f */
double diag__curve_penalty(const diag__reduced *q, const double *f)
{
    double h[N], sum = 0.0;
    for (int i = 0; i < q->n; i++) {
        h[i] = f[i];
        for (int j = 0; j < i; j++) {
            h[i] -= q->L[i * q->n + j] * h[j];
        }
        h[i] /= q->L[i * q->n + i];
        sum += h[i] * h[i];
    }
    return sum;
}
