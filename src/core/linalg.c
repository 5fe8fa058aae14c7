/* SPDX-License-Identifier: MIT
 * linalg.c - the linear system of every step, M qdd = Q - c, for trees too large for a generated
 * solution (gen/solve.c), and the one of an equilibrium.
 *
 * M = L^T D L without pivoting, from the leaves of the tree to its root (Featherstone 2008, section
 * 6.5): M is symmetric positive definite for every mechanism with inertia on its free joints. Row k
 * of L has entries at the ancestors of joint k only, as M has, so nothing else is computed. A
 * pivot that loses all its digits is reported, not divided by.
 */
#include <math.h>

#include "core.h"

int stein__factor(int n, const int *parent, double *M, double *inverse)
{
    for (int k = n - 1; k >= 0; k--) {
        double *row = M + k * n, d = row[k];
        if (!(d > 0.0)) {
            return k;
        }
        inverse[k] = 1.0 / d;
        for (int i = parent[k]; i >= 0; i = parent[i]) {
            double l = row[i] * inverse[k], *above = M + i * n, diagonal = above[i];
            for (int j = i; j >= 0; j = parent[j]) {
                above[j] -= l * row[j];
            }
            if (!(above[i] > 1e-13 * diagonal)) {
                return i;
            }
            row[i] = l;
        }
    }
    return -1;
}

/* row a of B less f times row b, m numbers */
static inline void less_row(double *B, int m, int a, double f, int b)
{
    double *to = B + a * m;
    const double *from = B + b * m;
    for (int i = 0; i < m; i++) {
        to[i] -= f * from[i];
    }
}

void stein__substitute(int n, const int *parent, const double *M, const double *inverse, double *B,
                       int m)
{
    for (int k = n - 1; k >= 0; k--) {
        for (int i = parent[k]; i >= 0; i = parent[i]) {
            less_row(B, m, i, M[k * n + i], k);
        }
    }
    for (int k = 0; k < n; k++) {
        for (int i = 0; i < m; i++) {
            B[k * m + i] *= inverse[k];
        }
        for (int i = parent[k]; i >= 0; i = parent[i]) {
            less_row(B, m, k, M[k * n + i], i);
        }
    }
}

int stein__solve(int n, const int *parent, double *M, double *b, double *inverse)
{
    int bad = stein__factor(n, parent, M, inverse);
    if (bad < 0) {
        stein__substitute(n, parent, M, inverse, b, 1);
    }
    return bad;
}

static void swap(double *a, double *b)
{
    double kept = *a;
    *a = *b;
    *b = kept;
}

int stein__factor_general(int n, double *A, int *pivot)
{
    for (int k = 0; k < n; k++) {
        pivot[k] = k;
        for (int i = k + 1; i < n; i++) {
            pivot[k] = fabs(A[i * n + k]) > fabs(A[pivot[k] * n + k]) ? i : pivot[k];
        }
        if (!(fabs(A[pivot[k] * n + k]) > 0.0)) {
            return -1;
        }
        for (int j = 0; j < n; j++) {
            swap(&A[k * n + j], &A[pivot[k] * n + j]);
        }
        for (int i = k + 1; i < n; i++) {
            double f = A[i * n + k] / A[k * n + k];
            A[i * n + k] = f;
            for (int j = k + 1; j < n; j++) {
                A[i * n + j] -= f * A[k * n + j];
            }
        }
    }
    return 0;
}

void stein__substitute_general(int n, const double *A, const int *pivot, double *b)
{
    for (int k = 0; k < n; k++) {
        swap(&b[k], &b[pivot[k]]);
    }
    for (int k = 0; k < n; k++) {
        for (int i = k + 1; i < n; i++) {
            b[i] -= A[i * n + k] * b[k];
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int j = i + 1; j < n; j++) {
            b[i] -= A[i * n + j] * b[j];
        }
        b[i] /= A[i * n + i];
    }
}

int stein__solve_general(int n, double *A, int *pivot, double *b)
{
    int bad = stein__factor_general(n, A, pivot);
    if (bad == 0) {
        stein__substitute_general(n, A, pivot, b);
    }
    return bad;
}
