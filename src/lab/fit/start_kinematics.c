/* SPDX-License-Identifier: GPL-3.0-or-later
 * start_kinematics.c - positions and speeds from what channels show at the start of a record.
 *
 * Value y_c and slope of every channel at the first sample (start_window.c) are measurements of the
 * state through the channel's own kinematics h_c,
 *
 *      positions   y_c = h_c(q)                 Gauss-Newton, damped
 *      speeds      dy_c/dt = (dh_c/dq) qd       linear, at the q found
 *                  y_c = h_c(q, qd)             channels that read a speed
 *
 * each with its standard deviation, and with priors about the state that the stroke would begin in
 * otherwise. Forces and accelerations are not read: they depend on the laws that are to be found.
 */
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <string.h>

#include "start_state.h"

enum { ITERATIONS = 60 };
static const double nudge = 1e-6; /* half-width of differences by q [rad or m] */

static stein_status stand(fit__beginning *w, const double *q, const double *qd, stein_err *err)
{
    return stein_set_state(w->b->sim, 0.0, q, qd, err);
}

static double shown(fit__beginning *w, int c)
{
    return stein_read(w->b->sim, w->s->channel[c]) + w->b->shown[c];
}

int fit__measures_place(const fit__beginning *w, int c)
{
    return w->start[c].samples > 0 && fit__shows_place(fit__channel_of(w, c)) &&
           !fit__channel_of(w, c)->from_rest;
}

static double value_sd(const fit__beginning *w, int c)
{
    return fmax(hypot(w->start[c].value_sd, w->offset[c]), 1e-12);
}

/* H = dh/dq of the channels that show a place, at q */
static stein_status find_H(fit__beginning *w, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int k = 0; k < w->nq && status == STEIN_OK; k++) {
        double q = w->q[k];
        for (int side = -1; side <= 1 && status == STEIN_OK; side += 2) {
            w->q[k] = q + side * nudge;
            status = stand(w, w->q, w->qd0, err);
            for (int c = 0; c < w->s->nch && status == STEIN_OK; c++) {
                double h = fit__shows_place(fit__channel_of(w, c)) ? shown(w, c) : 0.0;
                double *to = &w->H[c * w->nq + k];
                *to = side < 0 ? h : (h - *to) / (2.0 * nudge);
            }
        }
        w->q[k] = q;
    }
    return status;
}

/* sum of squares of the values and of the priors at q; INFINITY where it cannot be read */
static double objective(fit__beginning *w, const double *q)
{
    double sum = 0.0;
    if (stand(w, q, w->qd0, NULL) != STEIN_OK) {
        return INFINITY;
    }
    for (int c = 0; c < w->s->nch; c++) {
        if (fit__measures_place(w, c)) {
            w->base[c] = w->start[c].value - shown(w, c);
            double r = w->base[c] / value_sd(w, c);
            sum += r * r;
        }
    }
    for (int k = 0; k < w->nfree; k++) {
        int j = w->joint[k];
        double r = (q[j] - w->q0[j]) / w->e->q_prior[j];
        sum += r * r;
    }
    return isfinite(sum) ? sum : (double)INFINITY;
}

/* normal equations of the positions: A, grad from the residuals in base */
static void fill_positions(fit__beginning *w)
{
    int n = w->nfree;
    memset(w->A, 0, sizeof *w->A * (size_t)(n * n));
    memset(w->grad, 0, sizeof *w->grad * (size_t)n);
    for (int c = 0; c < w->s->nch; c++) {
        double sd = fit__measures_place(w, c) ? value_sd(w, c) : (double)INFINITY;
        for (int a = 0; a < n && isfinite(sd); a++) {
            double h = w->H[c * w->nq + w->joint[a]] / sd;
            w->grad[a] += h * w->base[c] / sd;
            for (int b = 0; b < n; b++) {
                w->A[a * n + b] += h * w->H[c * w->nq + w->joint[b]] / sd;
            }
        }
    }
    for (int a = 0; a < n; a++) {
        int j = w->joint[a];
        double weight = 1.0 / (w->e->q_prior[j] * w->e->q_prior[j]);
        w->A[a * n + a] += weight;
        w->grad[a] -= weight * (w->q[j] - w->q0[j]);
    }
}

/* solve A x = b in place, A becomes its Cholesky factor. @return 0, -1 */
static int solve(double *A, double *b, int n)
{
    gsl_matrix_view M = gsl_matrix_view_array(A, (size_t)n, (size_t)n);
    gsl_vector_view v = gsl_vector_view_array(b, (size_t)n);
    return gsl_linalg_cholesky_decomp1(&M.matrix) == 0 &&
                   gsl_linalg_cholesky_svx(&M.matrix, &v.vector) == 0
               ? 0
               : -1;
}

/* standard deviations of the estimated joints from the factor in A */
static void spread(fit__beginning *w, double *sd)
{
    int n = w->nfree;
    for (int a = 0; a < n; a++) {
        memset(w->grad, 0, sizeof *w->grad * (size_t)n);
        w->grad[a] = 1.0;
        gsl_matrix_view M = gsl_matrix_view_array(w->A, (size_t)n, (size_t)n);
        gsl_vector_view v = gsl_vector_view_array(w->grad, (size_t)n);
        gsl_linalg_cholesky_svx(&M.matrix, &v.vector);
        sd[w->joint[a]] = sqrt(fmax(w->grad[a], 0.0));
    }
}

/* a damped step to w->to. @return objective there; INFINITY: none is better than `here` */
static double step_from(fit__beginning *w, double here, double *mu, double *size)
{
    int n = w->nfree;
    for (; *mu < 1e12; *mu *= 8.0) {
        (void)objective(w, w->q); // the residuals
        fill_positions(w);
        for (int a = 0; a < n; a++) {
            w->A[a * n + a] *= 1.0 + *mu;
        }
        if (solve(w->A, w->grad, n) != 0) {
            continue;
        }
        memcpy(w->to, w->q, sizeof *w->to * (size_t)w->nq);
        *size = 0.0;
        for (int a = 0; a < n; a++) {
            double d = fmin(fmax(w->grad[a], -1.0), 1.0);
            w->to[w->joint[a]] += d;
            *size = fmax(*size, fabs(d));
        }
        double there = objective(w, w->to);
        if (there <= here) {
            return there;
        }
    }
    return INFINITY;
}

double fit__find_positions(fit__beginning *w)
{
    double here = objective(w, w->q), mu = 1e-3;
    for (int i = 0; i < ITERATIONS && isfinite(here); i++) {
        double size = 0.0;
        if (find_H(w, NULL) != STEIN_OK) {
            return INFINITY;
        }
        double there = step_from(w, here, &mu, &size), gain = here - there;
        if (!(there <= here)) {
            break;
        }
        memcpy(w->q, w->to, sizeof *w->q * (size_t)w->nq);
        here = there;
        mu = fmax(0.1 * mu, 1e-15);
        if (gain < 1e-9 * (1.0 + here) && size < 1e-9) {
            break;
        }
    }
    return here;
}

int fit__position_sd(fit__beginning *w, double *sd)
{
    if (find_H(w, NULL) != STEIN_OK) {
        return -1;
    }
    (void)objective(w, w->q);
    fill_positions(w);
    if (solve(w->A, w->grad, w->nfree) != 0) {
        return -1;
    }
    spread(w, sd);
    return 0;
}

/* H of the speeds: of the places' slopes, which is that of the places, and of what reads a speed;
 * base: what is measured, less what is shown at the speeds qd0. @return 0, -1 */
static int find_speed_H(fit__beginning *w)
{
    int nq = w->nq;
    if (find_H(w, NULL) != STEIN_OK || stand(w, w->q, w->qd0, NULL) != STEIN_OK) {
        return -1;
    }
    for (int c = 0; c < w->s->nch; c++) {
        const stein_channel *ch = fit__channel_of(w, c);
        w->base[c] = fit__shows_speed(ch) ? shown(w, c) : w->start[c].slope;
        for (int j = 0; fit__shows_place(ch) && j < nq; j++) {
            w->base[c] -= w->H[c * nq + j] * w->qd0[j];
        }
    }
    memcpy(w->qd, w->qd0, sizeof *w->qd * (size_t)nq);
    for (int j = 0; j < nq; j++) {
        w->qd[j] = w->qd0[j] + 1.0;
        if (stand(w, w->q, w->qd, NULL) != STEIN_OK) {
            return -1;
        }
        for (int c = 0; c < w->s->nch; c++) {
            if (fit__shows_speed(fit__channel_of(w, c))) {
                w->H[c * nq + j] = shown(w, c) - w->base[c];
            }
        }
        w->qd[j] = w->qd0[j];
    }
    for (int c = 0; c < w->s->nch; c++) {
        if (fit__shows_speed(fit__channel_of(w, c))) {
            w->base[c] = w->start[c].value - w->base[c];
        }
    }
    return 0;
}

int fit__find_speeds(fit__beginning *w, double *sd)
{
    int n = w->nfree;
    if (find_speed_H(w) != 0) {
        return -1;
    }
    memset(w->A, 0, sizeof *w->A * (size_t)(n * n));
    memset(w->grad, 0, sizeof *w->grad * (size_t)n);
    for (int c = 0; c < w->s->nch; c++) {
        int speed = fit__shows_speed(fit__channel_of(w, c));
        double of = fmax(speed ? w->start[c].value_sd : w->start[c].slope_sd, 1e-12);
        for (int a = 0; a < n && w->start[c].samples > 0; a++) {
            double h = w->H[c * w->nq + w->joint[a]] / of;
            w->grad[a] += h * w->base[c] / of;
            for (int b = 0; b < n; b++) {
                w->A[a * n + b] += h * w->H[c * w->nq + w->joint[b]] / of;
            }
        }
    }
    for (int a = 0; a < n; a++) {
        w->A[a * n + a] += 1.0 / (w->e->qd_prior[w->joint[a]] * w->e->qd_prior[w->joint[a]]);
    }
    if (solve(w->A, w->grad, n) != 0) {
        return -1;
    }
    for (int a = 0; a < n; a++) {
        w->qd[w->joint[a]] += w->grad[a];
    }
    if (sd != NULL) {
        spread(w, sd);
    }
    return 0;
}
