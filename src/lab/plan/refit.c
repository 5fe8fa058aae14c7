/* SPDX-License-Identifier: GPL-3.0-or-later
 * refit.c - distance of one side from the prediction of another one, everything refitted.
 *
 * Two models that explain the same strokes have numbers of their own: the stiffness of a spring may
 * differ by four of its standard deviations. So much further along P their predictions curve away
 * from each other, and seen along straight lines that looks like evidence. Here one side is fitted
 * to the prediction of the other one,
 *
 *      min |y_of - y(w, u)|^2 + |w|^2 + |u|^2
 *
 * by steps along its derivatives at w = u = 0, each with a simulated stroke at its end.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <gsl/gsl_linalg.h>

#include "planning.h"

static const double enough = 0.1; /* of the residual: to gain less is not worth a stroke more */

typedef struct imitation {
    plan__prediction *v;
    const plan__prediction *of;
    const plan__reference *b;
    int n, until;
    const double *P;  /* [np][noutput*rows] its own beside `of`'s */
    const double *Z;  /* [nz][noutput*rows] of both, the mean */
    double *t, *step; /* [n] w and u; where to go from there */
    double *x, *r;    /* [nu], residuals */
    gsl_matrix *A;    /* factor of 1 + [P Z]'[P Z] */
    gsl_vector *g;
} imitation;

static const double *column_of(const imitation *m, int k)
{
    size_t n = (size_t)m->v->noutput * (size_t)m->v->rows;
    return k < m->v->np ? m->P + (size_t)k * n : m->Z + (size_t)(k - m->v->np) * n;
}

/* sum over measured and predictable samples */
static double product(const imitation *m, const double *a, const double *b)
{
    double sum = 0.0;
    for (int c = 0; c < m->v->noutput; c++) {
        size_t at = (size_t)c * (size_t)m->v->rows;
        for (int i = 0; m->b->output[c].measured && i < m->until; i++) {
            sum += a[at + (size_t)i] * b[at + (size_t)i];
        }
    }
    return sum;
}

static void imitation_free(imitation *m)
{
    free(m->t);
    free(m->x);
    free(m->r);
    gsl_matrix_free(m->A);
    gsl_vector_free(m->g);
}

/* @return 1; 0: no columns that make sense; -1: out of memory */
static int imitation_make(imitation *m, plan__prediction *v, const plan__reference *b,
                          const plan__prediction *of, const double *P, const double *Z)
{
    size_t rows = (size_t)v->noutput * (size_t)v->rows;
    *m = (imitation){.v = v, .of = of, .b = b, .n = v->np + v->nz, .P = P, .Z = Z};
    m->until = v->until < of->until ? v->until : of->until;
    m->t = calloc(2 * (size_t)m->n + 1, sizeof *m->t);
    m->x = malloc(sizeof *m->x * ((size_t)v->stage->p.nu + 1));
    m->r = malloc(sizeof *m->r * (rows + 1));
    m->A = gsl_matrix_calloc((size_t)m->n + 1, (size_t)m->n + 1);
    m->g = gsl_vector_calloc((size_t)m->n + 1);
    if (!m->t || !m->x || !m->r || !m->A || !m->g) {
        return -1;
    }
    m->step = m->t + m->n;
    for (int i = 0; i <= m->n; i++) { // one row more than there are: GSL has no matrices of size 0
        gsl_matrix_set(m->A, (size_t)i, (size_t)i, 1.0);
        for (int k = 0; k <= i && i < m->n; k++) {
            double *a = gsl_matrix_ptr(m->A, (size_t)i, (size_t)k);
            *a += product(m, column_of(m, i), column_of(m, k));
        }
    }
    return gsl_linalg_cholesky_decomp1(m->A) == 0;
}

/* goes the step, r = y_of - y there. @return the objective, INFINITY: it cannot be simulated */
static double attempt(imitation *m, plan__reference *b, stein_status *status, stein_err *err)
{
    plan__prediction *v = m->v;
    plan__stage *s = v->stage;
    int failed = 0;
    double sum = 0.0;
    memcpy(m->x, s->x, sizeof *m->x * (size_t)s->p.nu);
    for (int k = 0; k < m->n; k++) {
        m->t[k] += m->step[k];
        sum += m->t[k] * m->t[k];
        for (int i = 0; k < v->np && i < s->p.np; i++) {
            m->x[i] += s->way[k * s->p.np + i] * m->t[k];
        }
        if (k >= v->np) {
            m->x[s->p.np + k - v->np] += s->own[k - v->np] * m->t[k];
        }
    }
    b->strokes++;
    *status = fit__residuals(&s->p, m->x, m->r, &failed, err);
    if (*status != STEIN_OK || failed > 0) {
        return INFINITY;
    }
    for (int i = 0; i < v->rows * v->noutput; i++) {
        m->r[i] += m->of->y[i]; // the residual of nothing is -y
    }
    return sum + product(m, m->r, m->r);
}

/* next point after t, which has the residuals r, by the derivatives at 0 */
static void aim(imitation *m)
{
    for (int k = 0; k < m->n; k++) {
        gsl_vector_set(m->g, (size_t)k, product(m, column_of(m, k), m->r) - m->t[k]);
    }
    gsl_vector_set(m->g, (size_t)m->n, 0.0);
    gsl_linalg_cholesky_svx(m->A, m->g);
    for (int k = 0; k < m->n; k++) {
        m->step[k] = gsl_vector_get(m->g, (size_t)k);
    }
}

stein_status plan__refit(double *to, plan__prediction *v, plan__reference *b,
                         const plan__prediction *of, const double *P, const double *Z,
                         stein_err *err)
{
    enum { STEPS = 6 };
    size_t n = (size_t)v->noutput * (size_t)v->rows;
    imitation m;
    stein_status status = STEIN_OK;
    memcpy(to, v->y, sizeof *to * n);
    if (v->stage == NULL) {
        return STEIN_OK;
    }
    int ok = imitation_make(&m, v, b, of, P, Z);
    for (size_t i = 0; ok > 0 && i < n; i++) {
        m.r[i] = of->y[i] - v->y[i];
    }
    double best = ok > 0 ? product(&m, m.r, m.r) : INFINITY;
    for (int k = 0, on = ok > 0; status == STEIN_OK && on && k < STEPS; k++) {
        aim(&m);
        double now = attempt(&m, b, &status, err);
        on = now < best;
        for (size_t i = 0; on && i < n; i++) {
            to[i] = of->y[i] - m.r[i];
        }
        for (int c = 0; on && c < m.n; c++) {
            const double *column = column_of(&m, c);
            for (size_t i = 0; i < n; i++) {
                to[i] -= m.t[c] * column[i];
            }
        }
        on = on && best - now > enough * best;
        best = fmin(best, now);
    }
    imitation_free(&m);
    return ok < 0 ? lab__no_memory(err) : status;
}
