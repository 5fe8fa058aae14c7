/* SPDX-License-Identifier: GPL-3.0-or-later
 * evidence.c - linear forces and how large they may be, by marginal likelihood.
 *
 * Residuals r = e - J v - G f with noise e ~ N(0, 1), nuisances v (eliminated) and forces
 *
 *      f = E k + g,    k ~ N(0, wide^2) one constant a joint,    g ~ N(0, Q^-1(tau))
 *
 * with g a chain: neighbours in time are correlated by rho. With T = (1, E) and h = (g, k)
 *
 *      h | r ~ N((T'MT + Q)^-1 T'c, (T'MT + Q)^-1),
 *      -2 ln p(r | tau) = const - c'T (T'MT + Q)^-1 T'c + ln |T'MT + Q| - ln |Q|
 *
 * The constant stands for what parameters imitate: a preload that a shifted centre of mass replaces
 * leaves no residual, but its size is uncertain and belongs to the band.
 *
 * tau, one for each joint, begins at its lowest value: first for the joint whose forces explain
 * most, then for the others, which explain what is left. The tau of a force that is not needed
 * stays at the lowest value, and its band would vanish as if the data excluded the force. Therefore
 * each tau is raised as long as -2 ln p rises by at most one: the band then covers what the data
 * allow.
 */
#include <gsl/gsl_blas.h>
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "functions.h"
#include "diagnosing.h"

enum { LEVELS = 17, SWEEPS = 3 };
static const double lowest = 1e-2, stride = 2.371373705661655; /* 16 steps are 6 decades */
static const double allowed = 1.0;

typedef struct room {
    gsl_matrix *M, *S; /* T'MT; with the prior, then its factor */
    gsl_vector *c, *f;
    int *level; /* [ngroup] */
} room;

static double tau_of(int level)
{
    return lowest * stein__power(stride, level);
}

/* precision of the prior added to S. @return ln |Q| */
static double add_prior(const diag__gauss *g, const int *level, gsl_matrix *S)
{
    double logdet = 0.0, spread = 1.0 - g->rho * g->rho;
    for (int k = 0; k < g->n; k++) {
        double sd = g->scale[k] * tau_of(level[g->group[k]]);
        int before = g->tie[k], after = k + 1 < g->n && g->tie[k + 1];
        // of an autoregression: x_k given x_k-1 has variance (1 - rho^2) sd^2
        double own = (before ? 1.0 / spread : 1.0) + (after ? g->rho * g->rho / spread : 0.0);
        *gsl_matrix_ptr(S, (size_t)k, (size_t)k) += own / (sd * sd);
        logdet -= 2.0 * stein__log_of(sd) + (before ? stein__log_of(spread) : 0.0);
        if (before) {
            double sd_before = g->scale[k - 1] * tau_of(level[g->group[k - 1]]);
            double beside = -g->rho / spread / (sd * sd_before);
            *gsl_matrix_ptr(S, (size_t)k, (size_t)k - 1) += beside;
            *gsl_matrix_ptr(S, (size_t)k - 1, (size_t)k) += beside;
        }
    }
    for (int k = 0; k < g->ngroup; k++) { // counted in `wide`
        *gsl_matrix_ptr(S, (size_t)g->n + (size_t)k, (size_t)g->n + (size_t)k) += 1.0;
    }
    return logdet;
}

/* -2 ln p up to a constant; f and the factor of S stay */
static double objective(diag__gauss *g, room *r)
{
    double gained = 0.0;
    gsl_matrix_memcpy(r->S, r->M);
    double value = -add_prior(g, r->level, r->S);
    if (gsl_linalg_cholesky_decomp1(r->S) != 0) {
        return INFINITY;
    }
    for (size_t k = 0; k < r->S->size1; k++) {
        value += 2.0 * stein__log_of(gsl_matrix_get(r->S, k, k));
    }
    gsl_linalg_cholesky_solve(r->S, r->c, r->f);
    gsl_blas_ddot(r->c, r->f, &gained);
    g->explained = gained;
    return value - gained;
}

/* the best level of one group, the others as they are. @return its -2 ln p */
static double scan(diag__gauss *g, room *r, int group, double best)
{
    int at = r->level[group], start = at;
    for (int side = -1; side <= 1; side += 2) {
        double last = best;
        for (int level = start + side, worse = 0; level >= 0 && level < LEVELS && worse < 3;
             level += side) {
            r->level[group] = level;
            double there = objective(g, r);
            worse = there < last ? 0 : worse + 1; // it may first get worse a little
            last = there;
            if (there < best - 1e-9) {
                best = there;
                at = level;
            }
        }
    }
    r->level[group] = at;
    return best;
}

static void choose(diag__gauss *g, room *r)
{
    double best = objective(g, r);
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        double before = best;
        int first = -1;
        for (int k = 0; sweep == 0 && k < g->ngroup; k++) { // the one that explains most begins
            int level = r->level[k];
            double there = scan(g, r, k, best);
            if (there < before) {
                before = there;
                first = k;
            }
            r->level[k] = level;
        }
        if (first >= 0) {
            best = scan(g, r, first, best);
        }
        for (int k = 0; k < g->ngroup; k++) {
            best = scan(g, r, k, best);
        }
        if (sweep > 0 && before - best < 0.1) {
            break;
        }
    }
    for (int k = 0; k < g->ngroup; k++) { // what could hide
        int level = r->level[k];
        while (r->level[k] + 1 < LEVELS) {
            r->level[k]++;
            if (objective(g, r) > best + allowed) {
                r->level[k]--;
                break;
            }
        }
        g->tau[k] = r->level[k];
        r->level[k] = level;
    }
    for (int k = 0; k < g->ngroup; k++) {
        r->level[k] = (int)g->tau[k];
        g->tau[k] = tau_of(r->level[k]);
    }
}

stein_status diag__gauss_make(diag__gauss *g, int n, int ngroup, stein_err *err)
{
    size_t k = (size_t)n;
    *g = (diag__gauss){.n = n, .ngroup = ngroup};
    g->M = calloc(2 * k * k + 3 * k + (size_t)ngroup + 1, sizeof *g->M);
    if (g->M == NULL) {
        return lab__no_memory(err);
    }
    g->cov = g->M + k * k;
    g->c = g->cov + k * k;
    g->mean = g->c + k;
    g->tau = g->mean + k;
    return STEIN_OK;
}

static double constant(const diag__gauss *g, int k)
{
    return g->same[k] * g->wide[g->group[k]];
}

/* T'MT and T'c */
static void extend(const diag__gauss *g, room *r)
{
    for (int k = 0; k < g->n; k++) {
        size_t i = (size_t)k, top = (size_t)g->n + (size_t)g->group[k];
        double own = constant(g, k);
        *gsl_vector_ptr(r->c, i) += g->c[k];
        *gsl_vector_ptr(r->c, top) += own * g->c[k];
        for (int o = 0; o < g->n; o++) {
            size_t side = (size_t)g->n + (size_t)g->group[o];
            double M = g->M[k * g->n + o], other = constant(g, o);
            *gsl_matrix_ptr(r->M, i, (size_t)o) += M;
            *gsl_matrix_ptr(r->M, top, (size_t)o) += own * M;
            *gsl_matrix_ptr(r->M, i, side) += other * M;
            *gsl_matrix_ptr(r->M, top, side) += own * other * M;
        }
    }
}

/* f = T h */
static void take(diag__gauss *g, const room *r)
{
    for (int k = 0; k < g->n; k++) {
        size_t i = (size_t)k, top = (size_t)g->n + (size_t)g->group[k];
        double own = constant(g, k);
        g->mean[k] = gsl_vector_get(r->f, i) + own * gsl_vector_get(r->f, top);
        for (int o = 0; o < g->n; o++) {
            size_t j = (size_t)o, side = (size_t)g->n + (size_t)g->group[o];
            double other = constant(g, o);
            g->cov[k * g->n + o] = gsl_matrix_get(r->S, i, j) + own * gsl_matrix_get(r->S, top, j) +
                                   other * gsl_matrix_get(r->S, i, side) +
                                   own * other * gsl_matrix_get(r->S, top, side);
        }
    }
}

stein_status diag__gauss_solve(diag__gauss *g, stein_err *err)
{
    size_t n = (size_t)g->n + (size_t)g->ngroup;
    room r = {.M = gsl_matrix_calloc(n, n),
              .S = gsl_matrix_alloc(n, n),
              .c = gsl_vector_calloc(n),
              .f = gsl_vector_alloc(n),
              .level = calloc((size_t)g->ngroup + 1, sizeof *r.level)};
    stein_status status = STEIN_OK;
    if (!r.M || !r.S || !r.c || !r.f || !r.level) {
        status = lab__no_memory(err);
    } else {
        extend(g, &r);
        choose(g, &r);
        if (isfinite(objective(g, &r))) {
            gsl_linalg_cholesky_invert(r.S);
            take(g, &r);
        }
    }
    gsl_matrix_free(r.M);
    gsl_matrix_free(r.S);
    gsl_vector_free(r.c);
    gsl_vector_free(r.f);
    free(r.level);
    return status;
}
