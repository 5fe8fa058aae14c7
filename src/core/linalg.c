/* SPDX-License-Identifier: MIT
 * linalg.c - the one linear system of the core: M qdd = Q - c.
 *
 * LDL^T without pivoting: M is symmetric positive definite for every mechanism with inertia on its
 * free joints, and no square root is needed. A pivot that loses all its digits against the diagonal
 * it started from is reported, not divided by. Rows begin at their first entry that is not 0.
 */
#include "core.h"

/* the first column of row i that is not 0: those of bodies on other branches are */
static int begin_of(const double *row, int i)
{
    int k = 0;
    while (k < i && row[k] == 0.0) {
        k++;
    }
    return k;
}

int stein__solve_spd(int n, double *M, double *b)
{
    for (int i = 0; i < n; i++) {
        double *row = M + i * n;
        double diagonal = row[i];
        int from = begin_of(row, i);
        for (int j = from; j < i; j++) {
            const double *other = M + j * n;
            double s = row[j];
            for (int k = from; k < j; k++) {
                s -= row[k] * other[k] * M[k * n + k];
            }
            row[j] = s / other[j];
            diagonal -= row[j] * row[j] * other[j];
            b[i] -= row[j] * b[j];
        }
        if (!(diagonal > 1e-13 * row[i])) {
            return i;
        }
        row[i] = diagonal;
    }
    for (int i = n - 1; i >= 0; i--) {
        b[i] /= M[i * n + i];
        for (int k = i + 1; k < n; k++) {
            b[i] -= M[k * n + i] * b[k];
        }
    }
    return -1;
}
