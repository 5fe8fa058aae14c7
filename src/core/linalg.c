/* SPDX-License-Identifier: MIT
 * linalg.c - the one linear system of the core: M qdd = Q - c.
 *
 * M = L^T D L without pivoting, from the leaves of the tree to its root (Featherstone 2008, section
 * 6.5): M is symmetric positive definite for every mechanism with inertia on its free joints, and
 * row k of L has entries at the ancestors of joint k only, as M has, so nothing else is touched. A
 * pivot that loses all its digits against the diagonal it started from is reported, not divided by.
 */
#include "core.h"

int stein__solve(const stein_model *model, double *M, double *b, double *pivot)
{
    int n = model->nq;
    const stein_body *body = model->bodies;
    for (int k = 0; k < n; k++) {
        pivot[k] = M[k * n + k];
    }
    for (int k = n - 1; k >= 0; k--) {
        double *row = M + k * n;
        if (!(row[k] > 1e-13 * pivot[k])) {
            return k;
        }
        pivot[k] = 1.0 / row[k];
        for (int i = body[k].parent; i >= 0; i = body[i].parent) {
            double l = row[i] * pivot[k];
            for (int j = i; j >= 0; j = body[j].parent) {
                M[i * n + j] -= l * row[j];
            }
            row[i] = l;
            b[i] -= l * b[k];
        }
    }
    for (int k = 0; k < n; k++) {
        b[k] *= pivot[k];
        for (int i = body[k].parent; i >= 0; i = body[i].parent) {
            b[k] -= M[k * n + i] * b[i];
        }
    }
    return -1;
}
