/* SPDX-License-Identifier: GPL-3.0-or-later
 * observer.c - a simulation that is held near the data while its parameters are still wrong.
 *
 * The sum of squares of a free simulation has many minima. A pendulum that is half a period late
 * fits as badly as one that is a whole period late, and a hammer that misses the notch gives no
 * information about the string. A simulation that is pulled towards the measurement stays in its
 * phase and its contacts. The sum of squares of the corrections has few minima (observer homotopy:
 * Vyasarayani, Uchida, Carvalho & McPhee 2012). The pull is then taken away step by step.
 *
 * At a sample with the innovation e_c = y_c - h_c the place of every measured point should jump by
 * K e_c and its speed by K^2/2 e_c/h, h being the interval to the next sample. Positions that are
 * moved by hand would end up inside of contacts and forget on which side of the notch the beak is.
 * So the jump is made by forces that go through contacts like any other,
 *
 *      Q = sum over c   H_c' m_c e_c/h^2 (K^2/2 + 4 K) in the first half of the interval,
 *                                        (K^2/2 - 4 K) in the second,
 *
 * with H = dh/dq and m_c = 1/(H_c M^-1 H_c') the mass that a force at its point moves: a free point
 * is at the end of the interval exactly where the jump would have brought it. Two other forms were
 * tried and rejected. A spring and a damper towards the data need the slope of the data, which at
 * an impact is wrong for the whole length of its window. Decoupling the channels by the mass matrix
 * fails where a load or a contact moves masses that the matrix does not contain.
 */
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fitting.h"

enum { MAX_CHANNELS = 16 };
static const double nudge = 1e-7; /* [rad or m] for H */

struct fit__observer {
    int nq;
    double *Q;           /* [nq] for K^2/2 + 4 K = 1 */
    double factor;       /* present one */
    double *H, *W;       /* [MAX_CHANNELS*nq] H and H M^-1 */
    double *M, *c, *col; /* [nq*nq], [nq], [nq] */
    double *q;           /* [nq] */
};

fit__observer *fit__observer_make(const stein_model *model)
{
    fit__observer *o = calloc(1, sizeof *o);
    size_t n = (size_t)model->nq;
    if (o != NULL) {
        o->nq = model->nq;
        o->Q = calloc(n * (4 + n + 2 * MAX_CHANNELS) + 1, sizeof *o->Q);
        if (o->Q == NULL) {
            free(o);
            return NULL;
        }
        o->c = o->Q + n;
        o->col = o->c + n;
        o->q = o->col + n;
        o->M = o->q + n;
        o->H = o->M + n * n;
        o->W = o->H + MAX_CHANNELS * n;
    }
    return o;
}

void fit__observer_free(fit__observer *o)
{
    if (o != NULL) {
        free(o->Q);
        free(o);
    }
}

void fit__observer_rest(fit__observer *o)
{
    memset(o->Q, 0, sizeof *o->Q * (size_t)o->nq);
}

void fit__observer_half(fit__observer *o, double gain, int second)
{
    o->factor = 0.5 * gain * gain + (second ? -4.0 : 4.0) * gain;
}

void fit__observer_force(void *ctx, double t, const double *q, const double *qd, double *Q)
{
    const fit__observer *o = ctx;
    (void)t;
    (void)q;
    (void)qd;
    for (int j = 0; j < o->nq; j++) {
        Q[j] += o->factor * o->Q[j];
    }
}

static int is_driven(const stein_model *m, const fit__stroke *s, int joint)
{
    for (int i = 0; i < m->nball; i++) {
        if (m->balls[i].joint == joint) {
            return 1; // a chart: no force moves it
        }
    }
    for (int i = 0; i < m->ninput; i++) {
        int bound = m->inputs[i].hold;
        for (int k = 0; k < s->nsignal; k++) {
            bound |= s->signal[k].input == i;
        }
        if (m->inputs[i].kind == STEIN_INPUT_MOTION && m->inputs[i].index == joint && bound) {
            return 1;
        }
    }
    return 0;
}

/* ---- the pull ---- */

/* rows of H for n channels, by differences on a simulation that only serves for that */
static stein_status find_H(fit__bench *b, const fit__stroke *s, const int *slot, int n,
                           stein_err *err)
{
    fit__observer *o = b->observer;
    const stein_model *m = stein_sim_model(b->sim);
    const double *qd = stein_qd(b->sim);
    double t = stein_time(b->sim), base[MAX_CHANNELS];
    memcpy(o->q, stein_q(b->sim), sizeof *o->q * (size_t)o->nq);
    stein_status status = stein_set_state(b->probe, t, o->q, qd, err);
    for (int a = 0; status == STEIN_OK && a < n; a++) {
        base[a] = stein_read(b->probe, s->channel[slot[a]]);
    }
    for (int j = 0; status == STEIN_OK && j < o->nq; j++) {
        double q = o->q[j];
        o->q[j] = q + nudge;
        int driven = is_driven(m, s, j);
        status = driven ? STEIN_OK : stein_set_state(b->probe, t, o->q, qd, err);
        o->q[j] = q;
        for (int a = 0; status == STEIN_OK && a < n; a++) {
            double there = driven ? base[a] : stein_read(b->probe, s->channel[slot[a]]);
            o->H[a * o->nq + j] = (there - base[a]) / nudge;
        }
    }
    return status;
}

/* W = H M^-1, joints that are driven left out */
static int find_W(fit__bench *b, const fit__stroke *s, int n)
{
    fit__observer *o = b->observer;
    const stein_model *m = stein_sim_model(b->sim);
    stein_mass_bias(b->sim, stein_q(b->sim), stein_qd(b->sim), NULL, NULL, o->M, o->c);
    for (int j = 0; j < o->nq; j++) {
        for (int k = 0; is_driven(m, s, j) && k < o->nq; k++) {
            o->M[j * o->nq + k] = o->M[k * o->nq + j] = j == k ? 1.0 : 0.0;
        }
    }
    gsl_matrix_view M = gsl_matrix_view_array(o->M, (size_t)o->nq, (size_t)o->nq);
    if (gsl_linalg_cholesky_decomp1(&M.matrix) != 0) {
        return -1;
    }
    for (int a = 0; a < n; a++) {
        gsl_vector_const_view h = gsl_vector_const_view_array(o->H + a * o->nq, (size_t)o->nq);
        gsl_vector_view w = gsl_vector_view_array(o->W + a * o->nq, (size_t)o->nq);
        gsl_linalg_cholesky_solve(&M.matrix, &h.vector, &w.vector);
    }
    return 0;
}

/* 1/(H M^-1 H') of channel a: the mass that a force at its point moves */
static double mass_of(const fit__observer *o, int a)
{
    double sum = 0.0;
    for (int j = 0; j < o->nq; j++) {
        sum += o->W[a * o->nq + j] * o->H[a * o->nq + j];
    }
    return sum > 0.0 ? 1.0 / sum : 0.0; // 0: nothing free moves this channel
}

stein_status fit__observe(fit__bench *b, const fit__stroke *s, int i, int next, const double *y,
                          stein_err *err)
{
    fit__observer *o = b->observer;
    const stein_model *m = stein_sim_model(b->sim);
    double h = s->data->time[next] - s->data->time[i];
    int slot[MAX_CHANNELS], n = 0;
    fit__observer_rest(o);
    for (int c = 0; c < s->nch && n < MAX_CHANNELS; c++) {
        if (stein_reads_place((int)m->channels[s->channel[c]].read) &&
            isfinite(s->y[c * s->n + i])) {
            slot[n++] = c;
        }
    }
    if (n == 0) {
        return STEIN_OK;
    }
    stein_status status = find_H(b, s, slot, n, err);
    if (status != STEIN_OK || find_W(b, s, n) != 0) {
        return status;
    }
    for (int a = 0; a < n; a++) {
        int at = slot[a] * s->n;
        double f = mass_of(o, a) * (s->y[at + i] - y[at]) / (h * h);
        for (int j = 0; j < o->nq; j++) {
            o->Q[j] += o->H[a * o->nq + j] * f;
        }
    }
    return STEIN_OK;
}
