/* SPDX-License-Identifier: GPL-3.0-or-later
 * start_follow.c - the initial state from which a simulation follows the beginning of a record.
 *
 * Gauss-Newton with damping on the numbers of one stroke's initial state, over the samples up to a
 * horizon. What a channel may be off by is given: its noise alone, or more where the model may
 * be wrong. Derivatives are differences of short simulations, so that a step costs as many of them
 * as the state has numbers.
 */
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fitting.h"

enum { MOST_STATE = 16 };
static const double nudge = 1e-5;  /* half-width of differences [rad or m; 1/s] */
static const double enough = 0.95; /* of the objective: a step that gains less is the last one */

/* one stroke at work */
typedef struct work {
    const fit__problem *p; /* with the horizon */
    fit__bench *b;
    const fit__follow *how;
    int stroke, n, at[MOST_STATE]; /* unknowns of the initial state */
    double *x, *r, *J;             /* [nu], [rows], [n*rows] */
    size_t rows;
} work;

static double penalty(const work *w, int i)
{
    const fit__unknown *u = &w->p->unknown[w->at[i]];
    return u->prior || isfinite(w->how->most) ? 1.0 : 0.0;
}

/* residuals at x, 0 behind the horizon. @return sum of squares and penalties */
static double residuals(const work *w, double *r)
{
    const fit__stroke *s = &w->p->stroke[w->stroke];
    double sum = 0.0;
    stein_status status = fit__simulate(w->p, w->b, w->stroke, w->x, r, NULL);
    for (int i = 0; status == STEIN_OK && i < s->nch * s->n; i++) {
        int counts = isfinite(s->y[i]) && fit__time_of(s, i) - s->origin <= w->how->until;
        r[i] = counts ? (s->y[i] - r[i]) / w->how->sd[i / s->n] : 0.0;
        sum += r[i] * r[i];
    }
    for (int i = 0; i < w->n; i++) {
        sum += penalty(w, i) * w->x[w->at[i]] * w->x[w->at[i]];
    }
    return status == STEIN_OK && isfinite(sum) ? sum : (double)INFINITY;
}

/* normal equations at x, whose residuals are in w->r. @return 0, -1: a neighbour of x fails */
static int fill(work *w, double *A, double *g)
{
    int n = w->n;
    for (int i = 0; i < n; i++) {
        double *J = w->J + (size_t)i * w->rows, was = w->x[w->at[i]];
        double h = nudge / w->p->unknown[w->at[i]].sd;
        w->x[w->at[i]] = was + h;
        double there = residuals(w, J);
        w->x[w->at[i]] = was;
        if (!isfinite(there)) {
            return -1;
        }
        for (size_t k = 0; k < w->rows; k++) {
            J[k] = (J[k] - w->r[k]) / h;
        }
        g[i] = -lab__dot(J, w->r, w->rows) - penalty(w, i) * was;
        for (int j = 0; j <= i; j++) {
            A[i * n + j] = A[j * n + i] = lab__dot(J, w->J + (size_t)j * w->rows, w->rows);
        }
        A[i * n + i] += penalty(w, i);
    }
    return 0;
}

/* a step from x with this damping, within the bounds. @return 0, -1: not positive definite */
static int go(work *w, const double *A, const double *g, const double *was, double mu)
{
    int n = w->n;
    double B[MOST_STATE * MOST_STATE], v[MOST_STATE] = {0};
    memcpy(B, A, sizeof *B * (size_t)(n * n));
    memcpy(v, g, sizeof *v * (size_t)n);
    for (int i = 0; i < n; i++) {
        B[i * n + i] = (1.0 + mu) * B[i * n + i] + 1e-30;
    }
    gsl_matrix_view M = gsl_matrix_view_array(B, (size_t)n, (size_t)n);
    gsl_vector_view b = gsl_vector_view_array(v, (size_t)n);
    if (gsl_linalg_cholesky_decomp1(&M.matrix) != 0) {
        return -1;
    }
    gsl_linalg_cholesky_svx(&M.matrix, &b.vector);
    for (int i = 0; i < n; i++) {
        double most = w->p->unknown[w->at[i]].prior ? fmin(w->how->most, 1.0) : w->how->most;
        w->x[w->at[i]] = fmin(fmax(was[i] + v[i], -most), most);
    }
    return 0;
}

/* one step. @return objective there; INFINITY: nothing better was found, x is where it was */
static double step(work *w, double here)
{
    double A[MOST_STATE * MOST_STATE], g[MOST_STATE], was[MOST_STATE] = {0};
    for (int i = 0; i < w->n; i++) {
        was[i] = w->x[w->at[i]];
    }
    int failed = fill(w, A, g);
    for (double mu = 1e-6; !failed && mu < 1e6; mu *= 30.0) {
        double there = go(w, A, g, was, mu) == 0 ? residuals(w, w->r) : (double)INFINITY;
        if (there < here) {
            return there;
        }
    }
    for (int i = 0; i < w->n; i++) {
        w->x[w->at[i]] = was[i];
    }
    return INFINITY;
}

double fit__follow_start(const fit__problem *p, fit__bench *b, int stroke, const fit__follow *how,
                         double *x)
{
    fit__problem to = *p;
    const fit__stroke *s = &p->stroke[stroke];
    work w = {.p = &to, .b = b, .how = how, .stroke = stroke, .x = x};
    w.rows = (size_t)s->nch * (size_t)s->n;
    to.horizon = fmin(p->horizon, how->until);
    for (int k = s->first; k < s->first + s->own && w.n < MOST_STATE; k++) {
        fit__kind kind = p->unknown[k].kind;
        if (kind == FIT__POSITION || kind == FIT__SPEED) {
            w.at[w.n++] = k;
        }
    }
    w.r = malloc(sizeof *w.r * (w.rows * (size_t)(w.n + 1) + 1));
    if (w.r == NULL) {
        b->no_memory = 1;
        return INFINITY;
    }
    w.J = w.r + w.rows;
    double here = residuals(&w, w.r);
    for (int i = 0; w.n > 0 && i < how->steps && isfinite(here); i++) {
        double there = step(&w, here);
        int over = !(there < enough * here);
        here = fmin(here, there);
        if (over) {
            break;
        }
    }
    free(w.r);
    int n = 0;
    for (int i = 0; i < s->nch * s->n; i++) {
        n += isfinite(s->y[i]) && fit__time_of(s, i) - s->origin <= how->until;
    }
    return n > 0 ? here / n : (double)INFINITY;
}
