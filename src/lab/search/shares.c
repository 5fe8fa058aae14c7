/* SPDX-License-Identifier: GPL-3.0-or-later
 * shares.c - what a candidate would explain in a part of the strokes alone.
 *
 *      V_s = C_s' V^-1 C_s,   C = [F G r]          of each stroke s, at the present variances
 *      I = sum V_kk - c'S^-1 c,   s = sum V_kr - c'b,   c = sum V_kB,   S = sum V_BB + 1,  S b =
 * V_Br
 *
 * with sums over the strokes of the part, S and b over all of them; B: F and the causes that act
 * already. So every candidate in every part of the strokes is scored from one set of columns.
 */
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mixed.h"

/* column of B among those of the model */
static size_t column(const lab__mixed *m, const int *with, int i)
{
    return (size_t)(i < m->nf ? i : m->nf + with[i - m->nf]);
}

/* S^-1 and b. @return 0: there is none */
static int solve(lab__shares *h, const lab__mixed *m, const int *with)
{
    size_t n = (size_t)h->n, nc = (size_t)m->ncol;
    for (size_t i = 0; i < n; i++) {
        const double *A = m->A + column(m, with, (int)i) * nc;
        for (size_t k = 0; k < n; k++) {
            h->S[i * n + k] = A[column(m, with, (int)k)];
        }
        h->S[i * n + i] += i < (size_t)m->nf && m->flat[i] ? 1e-9 : 1.0;
        h->b[i] = A[nc - 1] - (i < (size_t)m->nf && !m->flat[i] ? m->at[i] : 0.0);
    }
    if (n == 0) {
        return 1;
    }
    gsl_matrix_view S = gsl_matrix_view_array(h->S, n, n);
    gsl_vector_view b = gsl_vector_view_array(h->b, n);
    if (gsl_linalg_cholesky_decomp1(&S.matrix) != 0) {
        return 0;
    }
    gsl_linalg_cholesky_svx(&S.matrix, &b.vector);
    return 1;
}

/* V_s of candidate k with column y; T = W Z'C */
static double weighed(const lab__mixed *m, size_t s, const double *T, size_t k, size_t y)
{
    size_t nc = (size_t)m->ncol, nz = (size_t)m->nz;
    const double *QZ = m->QZ + s * nz * nc;
    double v = m->Q[s * nc * nc + k * nc + y];
    for (size_t z = 0; z < nz; z++) {
        v -= QZ[z * nc + k] * T[z * nc + y];
    }
    return v;
}

static void fill(lab__shares *h, const lab__mixed *m, const int *with, size_t s, double *T)
{
    size_t nc = (size_t)m->ncol, nz = (size_t)m->nz;
    memset(T, 0, sizeof *T * nz * nc);
    for (size_t z = 0; z < nz; z++) {
        for (size_t u = 0; u < nz; u++) {
            double w = m->W[s * nz * nz + z * nz + u];
            for (size_t y = 0; y < nc; y++) {
                T[z * nc + y] += w * m->QZ[s * nz * nc + u * nc + y];
            }
        }
    }
    for (int c = 0; c < m->nc; c++) {
        size_t k = (size_t)m->nf + (size_t)c, at = (size_t)c * (size_t)m->nstroke + s;
        h->info[at] = weighed(m, s, T, k, k);
        h->score[at] = weighed(m, s, T, k, nc - 1);
        for (int i = 0; i < h->n; i++) {
            h->cross[at * (size_t)h->n + (size_t)i] = weighed(m, s, T, k, column(m, with, i));
        }
    }
}

stein_status lab__shares_make(lab__shares *h, const lab__mixed *m, const int *with, int nwith,
                              stein_err *err)
{
    size_t n = (size_t)m->nf + (size_t)nwith, all = (size_t)m->nc * (size_t)m->nstroke;
    size_t nz = (size_t)m->nz, nc = (size_t)m->ncol;
    *h = (lab__shares){.n = (int)n, .nstroke = m->nstroke};
    h->S = calloc(n * n + 2 * n + all * (n + 2) + 1, sizeof *h->S);
    double *T = malloc(sizeof *T * (nz * nc + 1));
    if (h->S == NULL || T == NULL) {
        free(T);
        return lab__no_memory(err);
    }
    h->b = h->S + n * n;
    h->c = h->b + n;
    h->info = h->c + n;
    h->score = h->info + all;
    h->cross = h->score + all;
    h->none = !solve(h, m, with);
    for (int s = 0; s < m->nstroke; s++) {
        fill(h, m, with, (size_t)s, T);
    }
    free(T);
    return STEIN_OK;
}

void lab__shares_free(lab__shares *h)
{
    free(h->S);
    *h = (lab__shares){.n = 0};
}

double lab__shares_gain(lab__shares *h, int candidate, int first, int last, double *amount)
{
    size_t n = (size_t)h->n;
    double I = 0.0, s = 0.0;
    memset(h->c, 0, sizeof *h->c * n);
    for (int k = first; k <= last; k++) {
        size_t at = (size_t)candidate * (size_t)h->nstroke + (size_t)k;
        I += h->info[at];
        s += h->score[at];
        for (size_t i = 0; i < n; i++) {
            h->c[i] += h->cross[at * n + i];
        }
    }
    for (size_t i = 0; i < n; i++) {
        s -= h->c[i] * h->b[i];
    }
    for (size_t i = 0; i < n; i++) { // L^-1 c
        double v = h->c[i];
        for (size_t k = 0; k < i; k++) {
            v -= h->S[i * n + k] * h->c[k];
        }
        h->c[i] = v / h->S[i * n + i];
        I -= h->c[i] * h->c[i];
    }
    I = fmax(I, 0.0);
    *amount = s / (I + 1.0);
    return h->none ? -(double)INFINITY : s * *amount - log1p(I);
}
