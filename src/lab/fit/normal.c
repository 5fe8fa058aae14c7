/* SPDX-License-Identifier: GPL-3.0-or-later
 * normal.c - normal equations whose nuisances are eliminated.
 *
 * With x = (p, n_1 ... n_S), free parameters and each stroke's own, J'J is an arrow:
 *
 *      | A   C_1' ... C_S' | dp  |       |g_p|     S = A - sum C_s' B_s^-1 C_s       (Schur)
 *      | C_1 B_1           | dn_1|  = -  |g_1|     S dp = -g_p + sum C_s' B_s^-1 g_s
 *      | C_S          B_S  | dn_S|       |g_S|     dn_s = -B_s^-1 (g_s + C_s dp)
 *
 * with the priors' 1 on the diagonal (x counts prior standard deviations).
 */
#include <gsl/gsl_blas.h>
#include <gsl/gsl_linalg.h>
#include <stdlib.h>
#include <string.h>

#include "fitting.h"

stein_status fit__normal_make(fit__normal *n, const fit__problem *p, stein_err *err)
{
    size_t np = (size_t)p->np, ns = (size_t)p->nstroke;
    *n = (fit__normal){.np = p->np, .nu = p->nu, .nstroke = p->nstroke};
    n->A = gsl_matrix_alloc(np, np);
    n->S = gsl_matrix_alloc(np, np);
    n->g = calloc((size_t)p->nu + 1, sizeof *n->g);
    n->product = calloc((size_t)p->nu + 1, sizeof *n->product);
    n->moving = calloc(2 * np + 1, sizeof *n->moving);
    n->row = n->moving + (n->moving != NULL ? np : 0);
    n->B = calloc(4 * ns + 1, sizeof *n->B);
    int memory = n->A && n->S && n->g && n->product && n->moving && n->B;
    n->C = n->B + (memory ? ns : 0);
    n->BL = n->C + (memory ? ns : 0);
    n->X = n->BL + (memory ? ns : 0);
    for (size_t s = 0; memory && s < ns; s++) {
        size_t own = (size_t)p->stroke[s].own;
        if (own > 0) {
            n->B[s] = gsl_matrix_alloc(own, own);
            n->BL[s] = gsl_matrix_alloc(own, own);
            n->C[s] = gsl_matrix_alloc(own, np);
            n->X[s] = gsl_matrix_alloc(own, np);
            memory = n->B[s] && n->BL[s] && n->C[s] && n->X[s];
        }
    }
    return memory ? STEIN_OK : lab__no_memory(err);
}

void fit__normal_free(fit__normal *n)
{
    gsl_matrix_free(n->A);
    gsl_matrix_free(n->S);
    for (int i = 0; n->B != NULL && i < 4 * n->nstroke; i++) {
        gsl_matrix_free(n->B[i]);
    }
    free(n->B);
    free(n->g);
    free(n->product);
    free(n->moving);
}

/* a matrix whose block has room for more */
static void shape(gsl_matrix *m, size_t rows, size_t columns)
{
    m->size1 = rows;
    m->size2 = m->tda = columns;
}

/* what moves, and matrices of that size, of zeros */
static void begin_fill(fit__normal *n, const fit__problem *p)
{
    n->n = 0;
    for (int u = 0; u < p->np; u++) {
        int moves = u != p->fixed && !p->unknown[u].idle;
        n->row[u] = moves ? n->n : -1;
        n->moving[n->n] = moves ? u : n->moving[n->n];
        n->n += moves;
    }
    size_t m = (size_t)n->n;
    shape(n->A, m, m);
    shape(n->S, m, m);
    gsl_matrix_set_zero(n->A);
    for (int s = 0; s < p->nstroke; s++) {
        if (n->B[s] != NULL) {
            shape(n->C[s], (size_t)p->stroke[s].own, m);
            shape(n->X[s], (size_t)p->stroke[s].own, m);
            gsl_matrix_set_zero(n->B[s]);
            gsl_matrix_set_zero(n->C[s]);
        }
    }
    memset(n->g, 0, sizeof *n->g * (size_t)p->nu);
}

/* column a of a stroke's derivatives with those before it, and itself, into its place: globals come
 * first, then its own */
static void fill_row(fit__normal *n, int s, int a, const double *product)
{
    size_t i = (size_t)(a < n->n ? a : a - n->n);
    for (int b = 0; b <= a; b++) {
        size_t k = (size_t)(b < n->n ? b : b - n->n);
        gsl_matrix *m = a < n->n ? n->A : b < n->n ? n->C[s] : n->B[s];
        gsl_matrix_set(m, i, k, gsl_matrix_get(m, i, k) + product[b]);
        if (m != n->C[s] && i != k) {
            gsl_matrix_set(m, k, i, gsl_matrix_get(m, i, k));
        }
    }
}

/* where column a is in the derivatives of a stroke */
static int column_of(const fit__normal *n, int a)
{
    return a < n->n ? n->moving[a] : n->np + a - n->n;
}

static void fill_stroke(fit__normal *n, const fit__problem *p, int s, const double *r,
                        const double *J)
{
    const fit__stroke *t = &p->stroke[s];
    const double *first = J + fit__column(p, s, 0);
    size_t size = (size_t)t->nch * (size_t)t->n;
    r += fit__offset(p, s);
    for (int a = 0; a < n->n + t->own; a++) {
        const double *column = first + size * (size_t)column_of(n, a);
        n->g[a < n->n ? n->moving[a] : t->first + a - n->n] += lab__dot(column, r, size);
        for (int b = 0, run; b <= a; b += run) { // columns beside each other at once
            run = 1;
            while (b + run <= a && column_of(n, b + run) == column_of(n, b) + run) {
                run++;
            }
            lab__dot_rows(column, first + size * (size_t)column_of(n, b), size, run,
                          n->product + b);
        }
        fill_row(n, s, a, n->product);
    }
}

double *fit__normal_diagonal(const fit__normal *n, const fit__problem *p, int u)
{
    if (u < p->np) {
        size_t row = (size_t)n->row[u];
        return n->row[u] >= 0 ? gsl_matrix_ptr(n->A, row, row) : NULL;
    }
    int s = p->unknown[u].stroke;
    size_t i = (size_t)(u - p->stroke[s].first);
    return gsl_matrix_ptr(n->B[s], i, i);
}

void fit__normal_fill(fit__normal *n, const fit__problem *p, const double *x, const double *r,
                      const double *J, int prior)
{
    begin_fill(n, p);
    for (int s = 0; s < p->nstroke; s++) {
        fill_stroke(n, p, s, r, J);
    }
    for (int u = 0; u < p->nu; u++) {
        // own priors always count: without them the data would be asked what a marker's offset is
        double *d = fit__normal_diagonal(n, p, u);
        if (d != NULL && p->unknown[u].prior && u != p->flat && (prior || u >= p->np)) {
            double w = fit__prior_weight(&p->unknown[u], x[u], 1.0);
            *d += w;
            n->g[u] += w * x[u];
        }
    }
}

/* what is added to the diagonal for an unknown; the 1e-12 is for one that no residual depends on */
static double damping(double mu, const double *scale, int u)
{
    return (scale != NULL ? mu * scale[u] : 0.0) + 1e-12;
}

int fit__normal_factor(fit__normal *n, const fit__problem *p, double mu, const double *scale)
{
    gsl_matrix_memcpy(n->S, n->A);
    for (int i = 0; i < n->n; i++) {
        *gsl_matrix_ptr(n->S, (size_t)i, (size_t)i) += damping(mu, scale, n->moving[i]);
    }
    for (int s = 0; s < n->nstroke; s++) {
        if (n->B[s] == NULL) {
            continue;
        }
        gsl_matrix_memcpy(n->BL[s], n->B[s]);
        for (int i = 0; i < p->stroke[s].own; i++) {
            *gsl_matrix_ptr(n->BL[s], (size_t)i, (size_t)i) +=
                damping(mu, scale, p->stroke[s].first + i);
        }
        if (gsl_linalg_cholesky_decomp1(n->BL[s]) != 0) {
            return -1;
        }
        if (n->n == 0) {
            continue;
        }
        gsl_matrix_memcpy(n->X[s], n->C[s]);
        for (size_t k = 0; k < (size_t)n->n; k++) {
            gsl_vector_view column = gsl_matrix_column(n->X[s], k);
            gsl_linalg_cholesky_svx(n->BL[s], &column.vector);
        }
        gsl_blas_dgemm(CblasTrans, CblasNoTrans, -1.0, n->C[s], n->X[s], 1.0, n->S);
    }
    return n->n == 0 || gsl_linalg_cholesky_decomp1(n->S) == 0 ? 0 : -1;
}

/* of the globals, in n->product */
static gsl_vector_view step_of_globals(const fit__normal *n, const fit__problem *p)
{
    gsl_vector_view dp = gsl_vector_view_array(n->product, (size_t)n->n);
    for (int i = 0; i < n->n; i++) {
        n->product[i] = -n->g[n->moving[i]];
    }
    for (int s = 0; s < n->nstroke; s++) {
        if (n->B[s] != NULL) {
            gsl_vector_const_view g =
                gsl_vector_const_view_array(n->g + p->stroke[s].first, (size_t)p->stroke[s].own);
            gsl_blas_dgemv(CblasTrans, 1.0, n->X[s], &g.vector, 1.0, &dp.vector);
        }
    }
    gsl_linalg_cholesky_svx(n->S, &dp.vector);
    return dp;
}

void fit__normal_step(const fit__normal *n, const fit__problem *p, double *dx)
{
    gsl_vector_view dp;
    for (int u = 0; u < p->nu; u++) {
        dx[u] = u < p->np ? 0.0 : -n->g[u];
    }
    if (n->n > 0) {
        dp = step_of_globals(n, p);
    }
    for (int i = 0; i < n->n; i++) {
        dx[n->moving[i]] = gsl_vector_get(&dp.vector, (size_t)i);
    }
    for (int s = 0; s < n->nstroke; s++) {
        if (n->B[s] != NULL) {
            gsl_vector_view dn =
                gsl_vector_view_array(dx + p->stroke[s].first, (size_t)p->stroke[s].own);
            gsl_linalg_cholesky_svx(n->BL[s], &dn.vector); // -B^-1 g
            if (n->n > 0) {
                gsl_blas_dgemv(CblasNoTrans, -1.0, n->X[s], &dp.vector, 1.0, &dn.vector);
            }
        }
    }
}

void fit__normal_gradient(fit__normal *n, const fit__problem *p, const double *x, const double *r,
                          const double *J, double prior)
{
    memset(n->g, 0, sizeof *n->g * (size_t)p->nu);
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        for (int a = 0; a < n->n + t->own; a++) {
            n->g[a < n->n ? n->moving[a] : t->first + a - n->n] +=
                lab__dot(J + fit__column(p, s, column_of(n, a)), r + fit__offset(p, s),
                         (size_t)t->nch * (size_t)t->n);
        }
    }
    for (int u = 0; u < p->nu; u++) {
        int moves = u >= p->np || n->row[u] >= 0;
        double w = fit__prior_weight(&p->unknown[u], x[u], prior);
        n->g[u] += moves && p->unknown[u].prior && u != p->flat ? w * x[u] : 0.0;
    }
}

void fit__normal_curvature(const fit__normal *n, const fit__problem *p, const double *r,
                           const double *J, const double *dx, double h, double *there)
{
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        size_t size = (size_t)t->nch * (size_t)t->n, from = fit__offset(p, s);
        for (size_t i = from; i < from + size; i++) {
            there[i] = (there[i] - r[i]) / h;
        }
        for (int a = 0; a < n->n + t->own; a++) {
            const double *column = J + fit__column(p, s, column_of(n, a));
            double along = dx[a < n->n ? n->moving[a] : t->first + a - n->n];
            for (size_t i = 0; i < size; i++) {
                there[from + i] -= column[i] * along;
            }
        }
        for (size_t i = from; i < from + size; i++) {
            there[i] *= 2.0 / h;
        }
    }
}
