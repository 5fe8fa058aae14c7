/* SPDX-License-Identifier: GPL-3.0-or-later
 * mixed.c - is there an effect, when strokes scatter by themselves?
 *
 *      r_s = F_s beta + G_s alpha + Z_s u_s + e,   u_s ~ N(0, D),  e ~ N(0, 1)
 *      V_s = 1 + Z_s D Z_s'                        by Woodbury, on Gram matrices
 *      P   = V^-1 - V^-1 F (F' V^-1 F + 1)^-1 F' V^-1
 *      s_k = G_k' P r,   I_kl = G_k' P G_l,   z_k = s_k / sqrt(I_kk),   EPC_k = s_k / I_kk
 *
 * (Rao's score test; expected amount as in Saris & Satorra 1987.) Random effects of a stroke are
 * its nuisances, whose variance is their prior, and what real strokes never repeat: frictions, the
 * drive. Those variances D follow by the fixed point D = sum u^2 / sum (1 - W/D) of the restricted
 * likelihood (Harville 1977, MacKay 1992); EM would creep. A test that takes
 * strokes for exact repeats finds an effect in most clean sets: tests/lab/search/test_mixed.c has
 * both.
 *
 * The largest of many correlated scores is judged by draws of N(0, corr) divided by sqrt(chi2/nu):
 * the scatter is known from nu + 1 strokes only. Bonferroni would ignore that most candidates look
 * like others.
 *
 * Models with and without a candidate are compared by the marginal likelihood, its amount with a
 * normal prior of one limit: the price of a parameter needs no further choice.
 */
#include <gsl/gsl_blas.h>
#include <gsl/gsl_linalg.h>
#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "functions.h"
#include "mixed.h"

enum { DRAWS = 2000 };
static const double least_scatter = 1e-10;

/* ---- small dense algebra ---- */

/* in place lower Cholesky factor of a positive matrix [n*n] and ln det. @return 0 when it is not
 * positive */
static int factorise(double *a, int n, double *logdet)
{
    gsl_matrix_view m = gsl_matrix_view_array(a, (size_t)n, (size_t)n);
    if (gsl_linalg_cholesky_decomp1(&m.matrix) != 0) {
        return 0;
    }
    double sum = 0.0;
    for (int i = 0; i < n; i++) {
        sum += 2.0 * stein__log_of(a[i * n + i]);
    }
    *logdet = sum;
    return 1;
}

/* in place inverse of a positive matrix [n*n] and ln det. @return 0 when it is not positive */
static int invert(double *a, int n, double *logdet)
{
    gsl_matrix_view m = gsl_matrix_view_array(a, (size_t)n, (size_t)n);
    if (!factorise(a, n, logdet)) {
        return 0;
    }
    gsl_linalg_cholesky_invert(&m.matrix);
    return 1;
}

/* ---- filling ---- */

stein_status lab__mixed_make(lab__mixed *m, int nstroke, int nf, int ncand, int nrandom,
                             const int *zclass, const int *flat, const lab__scatter *scatter,
                             int nclass, stein_err *err)
{
    *m = (lab__mixed){.nf = nf,
                      .nc = ncand,
                      .nz = nrandom,
                      .ncol = nf + ncand + 1,
                      .nstroke = nstroke,
                      .nclass = nclass};
    size_t nc = (size_t)m->ncol, nz = (size_t)m->nz, ns = (size_t)m->nstroke;
    m->Q = calloc(ns * nc * nc + 1, sizeof *m->Q);
    m->QZ = calloc(ns * nz * nc + 1, sizeof *m->QZ);
    m->ZZ = calloc(ns * nz * nz + 1, sizeof *m->ZZ);
    m->W = calloc(ns * nz * nz + 1, sizeof *m->W);
    m->A = calloc(nc * nc, sizeof *m->A);
    m->work = calloc(nz * nc + nc * nc + 1, sizeof *m->work);
    m->solving = calloc(2 * nc * nc, sizeof *m->solving);
    m->effects = calloc(nz + 1, sizeof *m->effects);
    m->pick = calloc(nc, sizeof *m->pick);
    m->flat = calloc((size_t)nf + 1, sizeof *m->flat);
    m->at = calloc((size_t)nf + 1, sizeof *m->at);
    m->zclass = calloc(nz + 1, sizeof *m->zclass);
    if (!m->Q || !m->QZ || !m->ZZ || !m->W || !m->A || !m->work || !m->pick || !m->flat || !m->at ||
        !m->zclass || !m->solving || !m->effects) {
        return lab__no_memory(err);
    }
    for (int k = 0; k < nf; k++) {
        m->flat[k] = flat != NULL && flat[k];
    }
    for (int k = 0; k < nrandom; k++) {
        m->zclass[k] = zclass[k];
    }
    for (int c = 0; c < nclass; c++) {
        m->limit[c] = scatter[c];
        m->D[c] = scatter[c].first;
    }
    return STEIN_OK;
}

void lab__mixed_stroke(lab__mixed *m, int stroke, int samples, const double *C)
{
    size_t nc = (size_t)m->ncol, nz = (size_t)m->nz, s = (size_t)stroke, n = (size_t)samples;
    const double *Z = C + nc * n;
    double *Q = m->Q + s * nc * nc, *QZ = m->QZ + s * nz * nc, *ZZ = m->ZZ + s * nz * nz;
    for (size_t i = 0; i < nc; i++) {
        lab__dot_rows(C + i * n, C, n, (int)i + 1, Q + i * nc);
        for (size_t k = 0; k < i; k++) {
            Q[k * nc + i] = Q[i * nc + k];
        }
    }
    for (size_t i = 0; i < nz; i++) {
        lab__dot_rows(Z + i * n, C, n, m->ncol, QZ + i * nc);
        lab__dot_rows(Z + i * n, Z, n, m->nz, ZZ + i * nz);
    }
}

void lab__mixed_free(lab__mixed *m)
{
    free(m->zclass);
    free(m->Q);
    free(m->QZ);
    free(m->ZZ);
    free(m->W);
    free(m->A);
    free(m->work);
    free(m->solving);
    free(m->effects);
    free(m->pick);
    free(m->flat);
    free(m->at);
}

/* ---- weighing ---- */

/* Cholesky factor of W^-1 = D^-1 + Z'Z of a stroke, in the place of W, and its share of logdet.
 * @return 0 when it has none */
static int weigh_stroke(lab__mixed *m, size_t s)
{
    size_t nz = (size_t)m->nz;
    double *W = m->W + s * nz * nz, logdet = 0.0;
    memcpy(W, m->ZZ + s * nz * nz, sizeof *W * nz * nz);
    for (size_t k = 0; k < nz; k++) {
        double D = m->zclass[k] < 0 ? 1.0 : m->D[m->zclass[k]];
        W[k * nz + k] += 1.0 / D;
        m->logdet += stein__log_of(D);
    }
    int ok = nz > 0 && factorise(W, m->nz, &logdet);
    m->logdet += ok ? logdet : 0.0;
    return ok;
}

/* A of the n columns in pick, and W. With W^-1 = L L' and T = L^-1 Z'C it is C'C - T'T: where a
 * record's columns are a million noises long and nearly the same, W itself is too inexact. */
static void weigh(lab__mixed *m, size_t n)
{
    size_t nc = (size_t)m->ncol, nz = (size_t)m->nz;
    double *t = m->work, *A = t + nz * nc;
    memset(A, 0, sizeof *A * n * n);
    m->logdet = 0.0;
    for (size_t s = 0; s < (size_t)m->nstroke; s++) {
        const double *QZ = m->QZ + s * nz * nc, *Q = m->Q + s * nc * nc;
        for (size_t i = 0; i < nz * n; i++) {
            t[i] = QZ[i / n * nc + (size_t)m->pick[i % n]];
        }
        if (weigh_stroke(m, s)) {
            gsl_matrix_view w = gsl_matrix_view_array(m->W + s * nz * nz, nz, nz);
            gsl_matrix_view vt = gsl_matrix_view_array(t, nz, n);
            gsl_matrix_view va = gsl_matrix_view_array(A, n, n);
            gsl_blas_dtrsm(CblasLeft, CblasLower, CblasNoTrans, CblasNonUnit, 1.0, &w.matrix,
                           &vt.matrix);
            gsl_blas_dgemm(CblasTrans, CblasNoTrans, -1.0, &vt.matrix, &vt.matrix, 1.0, &va.matrix);
            gsl_linalg_cholesky_invert(&w.matrix);
        }
        for (size_t i = 0; i < n * n; i++) {
            A[i] += Q[(size_t)m->pick[i / n] * nc + (size_t)m->pick[i % n]];
        }
    }
    for (size_t i = 0; i < n * n; i++) {
        m->A[(size_t)m->pick[i / n] * nc + (size_t)m->pick[i % n]] = A[i];
    }
}

void lab__mixed_weigh(lab__mixed *m)
{
    for (int i = 0; i < m->ncol; i++) {
        m->pick[i] = i;
    }
    weigh(m, (size_t)m->ncol);
}

/* index of unknown i among columns: free, then the candidates asked for */
static int col(const lab__mixed *m, const int *with, int i)
{
    return i < m->nf ? i : m->nf + with[i - m->nf];
}

/* the same of what is fitted with these candidates: nobody asks for the others */
static void weigh_with(lab__mixed *m, const int *with, int nwith)
{
    int n = m->nf + nwith;
    for (int i = 0; i < n; i++) {
        m->pick[i] = col(m, with, i);
    }
    m->pick[n] = m->ncol - 1;
    weigh(m, (size_t)n + 1);
}

/* what unknown i wants to change by: F' V^-1 r, less the pull of its prior */
static double pull_of(const lab__mixed *m, const int *with, int i)
{
    double pull = i < m->nf && !m->flat[i] ? m->at[i] : 0.0;
    return m->A[col(m, with, i) * m->ncol + m->ncol - 1] - pull;
}

/* r'V^-1 r and the priors where r was taken */
static double square_of(const lab__mixed *m)
{
    double sum = m->A[m->ncol * m->ncol - 1];
    for (int i = 0; i < m->nf; i++) {
        sum += m->flat[i] ? 0.0 : m->at[i] * m->at[i];
    }
    return sum;
}

/* lab__mixed_solve, and the sum of squares at the minimum, priors included */
static double solve(const lab__mixed *m, const int *with, int nwith, double *beta, double *cov,
                    double *square)
{
    int n = m->nf + nwith, nc = m->ncol;
    double *S = m->solving, logdet = 0.0;
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < n; k++) {
            S[i * n + k] = m->A[col(m, with, i) * nc + col(m, with, k)];
        }
        S[i * n + i] += i < m->nf && m->flat[i] ? 1e-9 : 1.0;
    }
    double objective = square_of(m);
    int ok = n == 0 || invert(S, n, &logdet);
    for (int i = 0; ok && i < n; i++) {
        beta[i] = 0.0;
        for (int k = 0; k < n; k++) {
            beta[i] += S[i * n + k] * pull_of(m, with, k);
        }
        objective -= beta[i] * pull_of(m, with, i);
    }
    if (ok && cov != NULL) {
        memcpy(cov, S, sizeof *S * (size_t)(n * n));
    }
    *square = ok ? objective : (double)INFINITY;
    return ok ? objective + m->logdet + logdet : INFINITY;
}

double lab__mixed_solve(const lab__mixed *m, const int *with, int nwith, double *beta, double *cov)
{
    double square;
    return solve(m, with, nwith, beta, cov, &square);
}

double lab__mixed_least(lab__mixed *m, const int *with, int nwith, double *beta)
{
    double square = INFINITY;
    weigh_with(m, with, nwith);
    solve(m, with, nwith, beta, NULL, &square);
    return square;
}

void lab__mixed_effects(const lab__mixed *m, int stroke, const int *with, int nwith,
                        const double *beta, double *u)
{
    size_t nc = (size_t)m->ncol, nz = (size_t)m->nz;
    const double *W = m->W + (size_t)stroke * nz * nz, *QZ = m->QZ + (size_t)stroke * nz * nc;
    double *g = m->work; // Z' (r0 - F beta)
    for (size_t k = 0; k < nz; k++) {
        g[k] = QZ[k * nc + nc - 1];
        for (int i = 0; i < m->nf + nwith; i++) {
            g[k] -= QZ[k * nc + (size_t)col(m, with, i)] * beta[i];
        }
    }
    for (size_t k = 0; k < nz; k++) {
        u[k] = 0.0;
        for (size_t j = 0; j < nz; j++) {
            u[k] += W[k * nz + j] * g[j];
        }
    }
}

double lab__mixed_scatter(lab__mixed *m, const int *with, int nwith, int rounds, double *beta,
                          double *cov)
{
    size_t nz = (size_t)m->nz;
    double *u = m->effects;
    weigh_with(m, with, nwith);
    double objective = lab__mixed_solve(m, with, nwith, beta, cov);
    for (int round = 0; round < rounds; round++) {
        double sum[LAB_SCATTERS] = {0.0}, before = objective;
        double known[LAB_SCATTERS] = {0.0}; // how far the data tell, 0 .. 1 each
        for (int s = 0; s < m->nstroke; s++) {
            lab__mixed_effects(m, s, with, nwith, beta, u);
            for (size_t k = 0; k < nz; k++) {
                if (m->zclass[k] >= 0) {
                    double W = m->W[(size_t)s * nz * nz + k * nz + k];
                    sum[m->zclass[k]] += u[k] * u[k];
                    known[m->zclass[k]] += fmax(0.0, 1.0 - W / m->D[m->zclass[k]]);
                }
            }
        }
        for (int c = 0; c < m->nclass; c++) {
            double all = known[c] + m->worth;
            double D = all > 1e-9 ? (sum[c] + m->worth * m->limit[c].first) / all : m->D[c];
            m->D[c] = fmin(fmax(D, least_scatter), m->limit[c].most);
        }
        weigh_with(m, with, nwith);
        objective = lab__mixed_solve(m, with, nwith, beta, cov);
        if (fabs(before - objective) < 1e-3 && round > 3) {
            break;
        }
    }
    return objective;
}

/* ---- scores ---- */

int lab__mixed_project(const lab__mixed *m, double *I, double *s, double *square)
{
    int nf = m->nf, nc = m->nc, n = m->ncol;
    double *S = m->solving, logdet;
    double *T = S + nf * nf; // S^-1 F' V^-1 C
    for (int i = 0; i < nf; i++) {
        for (int k = 0; k < nf; k++) {
            S[i * nf + k] = m->A[i * n + k] + (i == k ? (m->flat[i] ? 1e-9 : 1.0) : 0.0);
        }
    }
    int ok = nf == 0 || invert(S, nf, &logdet);
    for (int i = 0; ok && i < nf; i++) {
        for (int c = 0; c < n; c++) {
            T[i * n + c] = 0.0;
            for (int k = 0; k < nf; k++) {
                double a = c == n - 1 ? pull_of(m, NULL, k) : m->A[k * n + c];
                T[i * n + c] += S[i * nf + k] * a;
            }
        }
    }
    for (int a = 0; ok && a <= nc; a++) { // the last one is r
        for (int b = 0; b <= nc; b++) {
            double v = a == nc && b == nc ? square_of(m) : m->A[(nf + a) * n + nf + b];
            for (int i = 0; i < nf; i++) {
                double of = a == nc ? pull_of(m, NULL, i) : m->A[(nf + a) * n + i];
                v -= of * T[i * n + nf + b];
            }
            double *to = a == nc && b == nc ? square
                         : b == nc          ? &s[a]
                         : a < nc           ? &I[a * nc + b]
                                            : NULL;
            if (to != NULL) {
                *to = v;
            }
        }
    }
    return ok;
}

void lab__mixed_score(const lab__mixed *m, double *score, double *epc, double *info, double *corr)
{
    int nc = m->nc;
    double square, *s = calloc((size_t)nc + 1, sizeof *s);
    if (s == NULL || !lab__mixed_project(m, corr, s, &square)) {
        memset(corr, 0, sizeof *corr * (size_t)(nc * nc));
    }
    for (int a = 0; a < nc; a++) {
        info[a] = fmax(corr[a * nc + a], 0.0);
        score[a] = s != NULL && info[a] > 1e-6 ? s[a] / sqrt(info[a]) : 0.0;
        epc[a] = s != NULL && info[a] > 1e-6 ? s[a] / info[a] : 0.0;
    }
    for (int a = 0; a < nc; a++) {
        for (int b = 0; b < nc; b++) {
            double size = sqrt(info[a] * info[b]);
            corr[a * nc + b] = a == b ? 1.0 : size > 0.0 ? corr[a * nc + b] / size : 0.0;
        }
    }
    free(s);
}

/* the factor of the correlations of those in use, behind each other in L. @return how many */
static int factor_family(gsl_matrix *L, const double *corr, const unsigned char *use, int nc)
{
    int n = 0;
    for (int a = 0; a < nc; a++) {
        for (int b = 0, k = 0; use[a] && b < nc; b++) {
            if (use[b]) {
                gsl_matrix_set(L, (size_t)n, (size_t)k++, corr[a * nc + b] + (a == b ? 1e-3 : 0.0));
            }
        }
        n += use[a] != 0;
    }
    if (n == 0) {
        return 0;
    }
    gsl_matrix_view v = gsl_matrix_submatrix(L, 0, 0, (size_t)n, (size_t)n);
    return gsl_linalg_cholesky_decomp1(&v.matrix) == 0 ? n : 0;
}

double *lab__family_draws(const double *corr, const unsigned char *use, int nc, int nu)
{
    gsl_matrix *L = gsl_matrix_calloc((size_t)nc + 1, (size_t)nc + 1);
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    double *g = malloc(sizeof *g * (size_t)(nc + 1)), *draw = NULL;
    int n = L != NULL && rng != NULL && g != NULL ? factor_family(L, corr, use, nc) : 0;
    if (n > 0) {
        draw = malloc(sizeof *draw * DRAWS);
        gsl_rng_set(rng, 1788);
    }
    for (int d = 0; draw != NULL && d < DRAWS; d++) {
        double most = 0.0, scale = sqrt(gsl_ran_chisq(rng, nu) / nu);
        for (int i = 0; i < n; i++) {
            g[i] = gsl_ran_ugaussian(rng);
            most =
                fmax(most, fabs(lab__dot(gsl_matrix_const_ptr(L, (size_t)i, 0), g, (size_t)i + 1)));
        }
        draw[d] = most / scale;
    }
    gsl_matrix_free(L);
    if (rng != NULL) {
        gsl_rng_free(rng);
    }
    free(g);
    return draw;
}

double lab__family_p(const double *draws, double score)
{
    int above = 0;
    for (int d = 0; draws != NULL && d < DRAWS; d++) {
        above += draws[d] >= fabs(score);
    }
    return draws != NULL ? (above + 1.0) / (DRAWS + 1.0) : 1.0;
}
