/* SPDX-License-Identifier: MIT
 * partition.c - the linear system of a mechanism with loops (loops.c): joints are parted into
 * dependent and independent ones, by elimination of J with complete pivoting.
 */
#include <math.h>
#include <string.h>

#include "loops.h"

double stein__largest(const double *x, int n)
{
    double most = 0.0;
    for (int i = 0; i < n; i++) {
        most = isfinite(x[i]) ? fmax(most, fabs(x[i])) : INFINITY;
    }
    return most;
}

/* ---- elimination ---- */

/* the largest element of a row that may be a pivot, in shares of the largest one of J there */
static void look_at_row(stein_sim *sim, int i)
{
    stein__loops *l = &sim->loop;
    const double *row = l->A + i * sim->model->nq;
    double most = 0.0;
    for (int j = 0; j < sim->model->nq; j++) {
        if (l->role[j] == FREE && fabs(row[j]) > most) {
            most = fabs(row[j]);
            l->best_column[i] = j;
        }
    }
    l->best[i] = l->scale[i] > 0.0 ? most / l->scale[i] : 0.0;
}

/* the row with the largest pivot of all that have none. @return it, -1: there is none of `least` */
static int find_pivot(const stein_sim *sim, double least)
{
    const stein__loops *l = &sim->loop;
    int row = -1;
    for (int i = 0; i < sim->model->nrow; i++) {
        if (!l->used[i] && l->best[i] >= least && (row < 0 || l->best[i] > l->best[row])) {
            row = i;
        }
    }
    return row;
}

/* row i becomes that of the dependent joint j */
static void eliminate(stein_sim *sim, int i, int j)
{
    stein__loops *l = &sim->loop;
    int n = sim->model->nq, m = sim->model->nrow;
    double *row = l->A + i * n, inverse = 1.0 / row[j];
    l->role[j] = DEPENDENT;
    l->used[i] = 1;
    l->row[l->rank_found] = i;
    l->column[l->rank_found++] = j;
    for (int k = 0; k < n; k++) {
        row[k] = l->role[k] == FREE ? row[k] * inverse : 0.0;
    }
    l->rhs[i] *= inverse;
    for (int a = 0; a < m; a++) {
        double *other = l->A + a * n, f = other[j];
        if (a == i || f == 0.0) {
            continue;
        }
        for (int k = 0; k < n; k++) {
            other[k] -= f * row[k];
        }
        other[j] = 0.0;
        l->rhs[a] -= f * l->rhs[i];
        if (!l->used[a]) {
            look_at_row(sim, a);
        }
    }
}

double stein__partition(stein_sim *sim, const double *x, int rank, double least)
{
    stein__loops *l = &sim->loop;
    int n = sim->model->nq, m = sim->model->nrow;
    double left = 0.0;
    memcpy(l->A, l->J, sizeof *l->A * (size_t)(m * n));
    for (int i = 0; i < m; i++) {
        l->used[i] = 0;
        l->scale[i] = stein__largest(l->J + i * n, n);
        for (int j = 0; j < n; j++) {
            if (l->role[j] == GIVEN) {
                l->rhs[i] -= l->A[i * n + j] * x[j];
                l->A[i * n + j] = 0.0;
            }
        }
        look_at_row(sim, i);
    }
    l->rank_found = 0;
    for (int row; l->rank_found < rank && (row = find_pivot(sim, least)) >= 0;) {
        eliminate(sim, row, l->best_column[row]);
    }
    for (int i = 0; i < m; i++) {
        if (!l->used[i]) {
            left = fmax(left, fabs(l->rhs[i]) / (l->scale[i] > 0.0 ? l->scale[i] : 1.0));
        }
    }
    return left;
}

/* ---- the system of the independent joints ---- */

static double mass(const double *M, int n, int i, int j)
{
    return M != NULL ? M[i * n + j] : i == j ? 1.0 : 0.0;
}

/* b less M times what is known of x: joints that are given, and s of the dependent ones */
static void move_known(const stein_sim *sim, const double *M, const double *x, double *b)
{
    const stein__loops *l = &sim->loop;
    int n = sim->model->nq;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            if (l->role[j] == GIVEN) {
                b[i] -= mass(M, n, i, j) * x[j];
            }
        }
        for (int k = 0; k < l->rank_found; k++) {
            b[i] -= mass(M, n, i, l->column[k]) * l->rhs[l->row[k]];
        }
    }
}

/* S = T^T M T over the independent joints, and T^T b in y */
static void reduce(stein_sim *sim, const double *M, const double *b)
{
    stein__loops *l = &sim->loop;
    int n = sim->model->nq, r = l->rank_found, nu = l->nfree;
    for (int k = 0; k < r; k++) {
        for (int c = 0; c < nu; c++) {
            double sum = mass(M, n, l->column[k], l->free[c]);
            for (int i = 0; i < r; i++) {
                sum -= mass(M, n, l->column[k], l->column[i]) * l->A[l->row[i] * n + l->free[c]];
            }
            l->W[k * nu + c] = sum;
        }
    }
    for (int a = 0; a < nu; a++) {
        l->y[a] = b[l->free[a]];
        for (int k = 0; k < r; k++) {
            l->y[a] -= l->A[l->row[k] * n + l->free[a]] * b[l->column[k]];
        }
        for (int c = 0; c <= a; c++) {
            double sum = mass(M, n, l->free[a], l->free[c]);
            for (int k = 0; k < r; k++) {
                sum -= mass(M, n, l->free[a], l->column[k]) * l->A[l->row[k] * n + l->free[c]];
                sum -= l->A[l->row[k] * n + l->free[a]] * l->W[k * nu + c];
            }
            l->S[a * nu + c] = sum;
        }
    }
}

/* S y = y by L D L^T. @return -1, or the joint whose pivot vanishes */
static int solve_reduced(stein__loops *l)
{
    int n = l->nfree;
    for (int i = 0; i < n; i++) {
        double *row = l->S + i * n, diagonal = row[i];
        for (int j = 0; j < i; j++) {
            const double *above = l->S + j * n;
            for (int k = 0; k < j; k++) {
                row[j] -= row[k] * above[k];
            }
        }
        for (int j = 0; j < i; j++) { // row[j] is L_ij D_j so far
            double f = row[j] / l->S[j * n + j];
            row[i] -= f * row[j];
            l->y[i] -= f * l->y[j];
            row[j] = f;
        }
        if (!(row[i] > 1e-13 * diagonal)) {
            return l->free[i];
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        l->y[i] /= l->S[i * n + i];
        for (int k = i + 1; k < n; k++) {
            l->y[i] -= l->S[k * n + i] * l->y[k];
        }
    }
    return -1;
}

int stein__partitioned(stein_sim *sim, const double *M, double *b, double *x)
{
    stein__loops *l = &sim->loop;
    int n = sim->model->nq;
    l->nfree = 0;
    for (int j = 0; j < n; j++) {
        if (l->role[j] == FREE) {
            l->free[l->nfree++] = j;
        }
    }
    move_known(sim, M, x, b);
    reduce(sim, M, b);
    int bad = solve_reduced(l);
    for (int a = 0; a < l->nfree; a++) {
        x[l->free[a]] = l->y[a];
    }
    for (int k = 0; k < l->rank_found; k++) {
        double sum = l->rhs[l->row[k]];
        for (int a = 0; a < l->nfree; a++) {
            sum -= l->A[l->row[k] * n + l->free[a]] * l->y[a];
        }
        x[l->column[k]] = sum;
    }
    return bad;
}
