/* SPDX-License-Identifier: MIT
 * linalg.c - the one linear system of the core: M qdd = Q - c.
 *
 * M = L^T D L without pivoting, from the leaves of the tree to its root (Featherstone 2008, section
 * 6.5): M is symmetric positive definite for every mechanism with inertia on its free joints, and
 * row k of L has entries at the ancestors of joint k only, as M has, so nothing else is touched. A
 * pivot that loses all its digits is reported, not divided by.
 */
#include "core.h"

int stein__solve(const stein_model *model, double *M, double *b, double *inverse)
{
    int n = model->nq;
    const stein_body *body = model->bodies;
    for (int k = n - 1; k >= 0; k--) {
        double *row = M + k * n, d = row[k];
        if (!(d > 0.0)) {
            return k;
        }
        inverse[k] = 1.0 / d;
        for (int i = body[k].parent; i >= 0; i = body[i].parent) {
            double l = row[i] * inverse[k], *above = M + i * n, diagonal = above[i];
            for (int j = i; j >= 0; j = body[j].parent) {
                above[j] -= l * row[j];
            }
            if (!(above[i] > 1e-13 * diagonal)) {
                return i;
            }
            row[i] = l;
            b[i] -= l * b[k];
        }
    }
    for (int k = 0; k < n; k++) {
        double x = b[k] * inverse[k];
        for (int i = body[k].parent; i >= 0; i = body[i].parent) {
            x -= M[k * n + i] * b[i];
        }
        b[k] = x;
    }
    return -1;
}
