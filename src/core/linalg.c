/* SPDX-License-Identifier: MIT
 * linalg.c - the one linear system of the core: M qdd = Q - c.
 *
 * LDL^T without pivoting: M is symmetric positive definite for every mechanism with inertia on its
 * free joints, and no square root is needed. A pivot that loses all its digits against the diagonal
 * it started from is reported, not divided by.
 */
#include "core.h"

int stein__solve_spd(int n, double *M, double *b)
{
    for (int j = 0; j < n; j++) {
        double *row = M + j * n;
        double diagonal = row[j];
        for (int k = 0; k < j; k++) {
            diagonal -= row[k] * row[k] * M[k * n + k];
        }
        if (!(diagonal > 1e-13 * row[j])) {
            return j;
        }
        row[j] = diagonal;
        for (int i = j + 1; i < n; i++) {
            double *low = M + i * n;
            double s = low[j];
            for (int k = 0; k < j; k++) {
                s -= low[k] * row[k] * M[k * n + k];
            }
            low[j] = s / diagonal;
        }
    }
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < i; k++) {
            b[i] -= M[i * n + k] * b[k];
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        b[i] /= M[i * n + i];
        for (int k = i + 1; k < n; k++) {
            b[i] -= M[k * n + i] * b[k];
        }
    }
    return -1;
}
