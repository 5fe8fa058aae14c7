/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_start.c - the initial state of a record that nobody states.
 *
 * q and qd solve h(q) = y(0), dh/dq qd = dy/dt(0) in the least-squares sense, with a weak prior at
 * the file's values for what no channel shows. y(0) and its slope are those of a parabola through
 * the first samples. The slope of a noisy record is poor, so a few Gauss-Newton steps on all
 * samples follow.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data_start.h"

enum { NEWTON = 6, REFINEMENTS = 4, SORTED = 512 };
static const double first_part = 0.08; /* of the samples: where the initial slope is taken from */
static const double weak = 1e-3;       /* weight of the prior against a channel's travel */

/* A x = b by Cholesky, A [n * n] symmetric, its lower triangle is replaced by the factor; x holds b
 * and then x. @return 0, -1 not positive definite */
static int solve_positive(double *A, double *x, int n)
{
    for (int i = 0; i < n; i++) {
        for (int k = 0; k <= i; k++) {
            double sum = A[i * n + k];
            for (int j = 0; j < k; j++) {
                sum -= A[i * n + j] * A[k * n + j];
            }
            if (i == k && !(sum > 0.0 && isfinite(sum))) {
                return -1;
            }
            A[i * n + k] = i == k ? sqrt(sum) : sum / A[k * n + k];
        }
        for (int j = 0; j < i; j++) {
            x[i] -= A[i * n + j] * x[j];
        }
        x[i] /= A[i * n + i];
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int j = i + 1; j < n; j++) {
            x[i] -= A[j * n + i] * x[j];
        }
        x[i] /= A[i * n + i];
    }
    return 0;
}

double data__travel(const double *v, int n)
{
    double sorted[SORTED];
    int stride = 1 + n / SORTED, k = 0;
    for (int i = 0; i < n; i += stride) {
        if (isfinite(v[i])) {
            sorted[k++] = v[i];
        }
    }
    if (k < DATA_FEWEST) {
        return 0.0;
    }
    qsort(sorted, (size_t)k, sizeof *sorted, data__compare);
    return sorted[k - 1 - k / 50] - sorted[k / 50];
}

/* what an initial state is estimated with */
typedef struct beginning {
    fit__problem *p;
    fit__bench *b;
    const stein_model *m;
    int n, *unknown;      /* joints whose state is unknown, their unknown of the problem */
    double *q, *qd;       /* [nq] */
    double *q0, *qd0;     /* [nq] of the file */
    double *value, *rate; /* [nch] of the record at its start; NAN: not known */
    double *scale;        /* [nch] weight of a channel: 1 over its travel */
    double *read;         /* [2 nch] */
} beginning;

int data__shows_place(stein_read_kind read)
{
    return read == STEIN_READ_POSITION || read == STEIN_READ_GAP || read == STEIN_READ_X ||
           read == STEIN_READ_Y || read == STEIN_READ_Z;
}

int data__shows_speed(stein_read_kind read)
{
    return read == STEIN_READ_SPEED || read == STEIN_READ_VX || read == STEIN_READ_VY ||
           read == STEIN_READ_VZ;
}

/* value and slope of the first samples of a channel: a parabola by least squares */
static void start_of(const fit__stroke *s, const double *y, double *value, double *rate)
{
    const double *t = s->data->time;
    int n = (int)(first_part * s->n) > 5 ? (int)(first_part * s->n) : 5, k = 0;
    double t0 = t[0], span = t[n < s->n ? n : s->n - 1] - t0, A[9] = {0}, g[3] = {0};
    for (int i = 0; i < s->n && i < n; i++) {
        double u = (t[i] - t0) / span, basis[3] = {1.0, u, u * u};
        for (int r = 0; !isnan(y[i]) && r < 9; r++) {
            A[r] += basis[r / 3] * basis[r % 3];
            g[r / 3] += r % 3 == 0 ? basis[r / 3] * y[i] : 0.0;
        }
        k += !isnan(y[i]);
    }
    *value = *rate = NAN;
    if (k >= 4 && span > 0.0 && solve_positive(A, g, 3) == 0) {
        *value = g[0];
        *rate = g[1] / span;
    }
}

/* readings at q, qd. @return OK or what stein_set_state returns */
static stein_status read_at(const beginning *g, const double *q, const double *qd, double *to)
{
    const fit__stroke *s = &g->p->stroke[0];
    stein_status status = stein_set_state(g->b->sim, 0.0, q, qd, NULL);
    for (int c = 0; status == STEIN_OK && c < s->nch; c++) {
        to[c] = stein_read(g->b->sim, s->channel[c]);
    }
    return status;
}

/* Derivatives of the readings by the unknown joints' q (or qd); J [nch x n]. */
static stein_status slopes(const beginning *g, double *at, double *J)
{
    int nch = g->p->stroke[0].nch;
    for (int k = 0; k < g->n; k++) {
        int joint = g->p->unknown[g->unknown[k]].index;
        double kept = at[joint], h = 1e-6 * fmax(1.0, fabs(kept));
        for (int side = 0; side < 2; side++) {
            at[joint] = kept + (side ? -h : h);
            stein_status status = read_at(g, g->q, g->qd, g->read + side * nch);
            at[joint] = kept;
            if (status != STEIN_OK) {
                return status;
            }
        }
        for (int c = 0; c < nch; c++) {
            J[c * g->n + k] = (g->read[c] - g->read[nch + c]) / (2.0 * h);
        }
    }
    return STEIN_OK;
}

/* Least squares of J dx = r with weights and the weak prior dx = 0; rows whose r is NAN say
 * nothing.
 * @param A  [n * n] room, dx [n] out. @return 0, -1 singular */
static int solve(const beginning *g, const double *J, const double *r, double *A, double *dx)
{
    size_t n = (size_t)g->n;
    memset(A, 0, sizeof *A * n * n);
    memset(dx, 0, sizeof *dx * n);
    for (size_t i = 0; i < n; i++) {
        A[i * n + i] = weak * weak;
    }
    for (int c = 0; c < g->p->stroke[0].nch; c++) {
        double w = g->scale[c] * g->scale[c];
        const double *row = J + (size_t)c * n;
        for (size_t i = 0; !isnan(r[c]) && i < n; i++) {
            dx[i] += w * row[i] * r[c];
            for (size_t k = 0; k < n; k++) {
                A[i * n + k] += w * row[i] * row[k];
            }
        }
    }
    return solve_positive(A, dx, g->n);
}

/* positions by Gauss-Newton, speeds by one linear problem; J [nch x n], room [nch + n * n + n] */
static stein_status estimate(beginning *g, double *J, double *room)
{
    const fit__stroke *s = &g->p->stroke[0];
    double *r = room, *A = room + s->nch, *dx = A + g->n * g->n;
    stein_status status = STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < NEWTON; i++) {
        status = slopes(g, g->q, J);
        status = status == STEIN_OK ? read_at(g, g->q, g->qd, g->read) : status;
        for (int c = 0; c < s->nch; c++) {
            const stein_channel *channel = &g->m->channels[s->channel[c]];
            int usable = data__shows_place(channel->read) && !channel->from_rest;
            r[c] = usable ? g->value[c] - g->read[c] : NAN;
        }
        if (status != STEIN_OK || solve(g, J, r, A, dx) != 0) {
            return STEIN_ESINGULAR;
        }
        for (int k = 0; k < g->n; k++) {
            g->q[g->p->unknown[g->unknown[k]].index] += dx[k];
        }
    }
    // a place moves with dh/dq qd, of all joints; a speed reads dh/dqd qd
    double *by_speed = J + s->nch * g->n;
    status = status == STEIN_OK ? slopes(g, g->q, J) : status;
    status = status == STEIN_OK ? slopes(g, g->qd, by_speed) : status;
    status = status == STEIN_OK ? read_at(g, g->q, g->qd, g->read) : status;
    for (int c = 0; status == STEIN_OK && c < s->nch; c++) {
        stein_read_kind read = g->m->channels[s->channel[c]].read;
        r[c] = data__shows_place(read)   ? g->rate[c]
               : data__shows_speed(read) ? g->value[c] - g->read[c]
                                         : NAN;
        for (int k = 0; k < g->n; k++) {
            int joint = g->p->unknown[g->unknown[k]].index;
            r[c] -= data__shows_place(read) ? J[c * g->n + k] * g->qd[joint] : 0.0;
            J[c * g->n + k] = data__shows_speed(read) ? by_speed[c * g->n + k] : J[c * g->n + k];
        }
    }
    if (status != STEIN_OK || solve(g, J, r, A, dx) != 0) {
        return STEIN_ESINGULAR;
    }
    for (int k = 0; k < g->n; k++) {
        g->qd[g->p->unknown[g->unknown[k]].index] += dx[k];
    }
    return STEIN_OK;
}

stein_status data__find_start(fit__problem *p, fit__bench *b, double *x, stein_err *err)
{
    const stein_model *m = lab_equations(p->model);
    fit__stroke *s = &p->stroke[0];
    size_t nq = (size_t)m->nq, nch = (size_t)s->nch;
    beginning g = {.p = p, .b = b, .m = m};
    int *unknown = calloc(nq + 1, sizeof *unknown);
    double *room = calloc(4 * nq + 6 * nch + 2 * nch * nq + nq * nq + nq + 1, sizeof *room);
    if (unknown == NULL || room == NULL) {
        free(unknown);
        free(room);
        return lab__no_memory(err);
    }
    g.unknown = unknown;
    g.q = room;
    g.qd = g.q + nq;
    g.q0 = g.qd + nq;
    g.qd0 = g.q0 + nq;
    g.value = g.qd0 + nq;
    g.rate = g.value + nch;
    g.scale = g.rate + nch;
    g.read = g.scale + nch;
    for (int k = s->first; k < s->first + s->own; k++) {
        if (p->unknown[k].kind == FIT__POSITION) {
            unknown[g.n++] = k;
        }
    }
    stein_status status = g.n > 0 ? fit__begin(p, b, 0, x, b->y, NULL) : STEIN_OK;
    if (status == STEIN_OK && g.n > 0) {
        memcpy(g.q, stein_q(b->sim), sizeof *g.q * nq);
        memcpy(g.qd, stein_qd(b->sim), sizeof *g.qd * nq);
        memcpy(g.q0, g.q, 2 * sizeof *g.q * nq);
        for (size_t c = 0; c < nch; c++) {
            double travel = data__travel(s->y + c * (size_t)s->n, s->n);
            start_of(s, s->y + c * (size_t)s->n, &g.value[c], &g.rate[c]);
            g.scale[c] = travel > 0.0 ? 1.0 / travel : 1.0;
        }
        status = estimate(&g, g.read + 2 * nch, g.read + 2 * nch + 2 * nch * (size_t)g.n);
    }
    for (int k = 0; status == STEIN_OK && k < g.n; k++) {
        int u = unknown[k], joint = p->unknown[u].index; // its speed comes next
        x[u] = (g.q[joint] - g.q0[joint]) / p->unknown[u].sd;
        x[u + 1] = (g.qd[joint] - g.qd0[joint]) / p->unknown[u + 1].sd;
    }
    free(unknown);
    free(room);
    return status;
}

/* ---- on all samples ---- */

/* what the steps share */
typedef struct refinement {
    fit__problem *p;
    fit__bench *b;
    int n, *unknown;       /* positions and speeds at the start */
    double *J, *A, *g;     /* [n * rows], [n * n], [n] derivatives, normal equations */
    double *r, *scale;     /* [rows], [nch] what is left over, in travels of the channels */
    double *x, *y, *trial; /* [nu], [rows] present unknowns and prediction; [nu] */
    double sum;            /* of squares of r */
} refinement;

/* sum of squares of what a prediction leaves over, r [rows] out */
static double left_over(const refinement *f, const double *y, double *r)
{
    const fit__stroke *s = &f->p->stroke[0];
    double sum = 0.0;
    for (int c = 0; c < s->nch; c++) {
        for (int i = c * s->n; i < (c + 1) * s->n; i++) {
            r[i] = isnan(s->y[i]) ? 0.0 : f->scale[c] * (s->y[i] - y[i]);
            sum += r[i] * r[i];
        }
    }
    return sum;
}

static double product(const double *a, const double *b, size_t n)
{
    double sum = 0.0;
    for (size_t i = 0; i < n; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

/* normal equations by differences */
static stein_status derivatives(refinement *f)
{
    const fit__stroke *s = &f->p->stroke[0];
    size_t rows = (size_t)s->nch * (size_t)s->n;
    for (int k = 0; k < f->n; k++) {
        int u = f->unknown[k];
        double kept = f->x[u], h = 1e-4 / f->p->unknown[u].sd, *column = f->J + (size_t)k * rows;
        f->x[u] += h;
        stein_status status = fit__simulate(f->p, f->b, 0, f->x, f->b->y, NULL);
        f->x[u] = kept;
        if (status != STEIN_OK) {
            return status;
        }
        left_over(f, f->b->y, column);
        for (size_t i = 0; i < rows; i++) {
            column[i] = (f->r[i] - column[i]) / h;
        }
    }
    for (int k = 0; k < f->n; k++) {
        const double *column = f->J + (size_t)k * rows;
        f->g[k] = product(column, f->r, rows);
        for (int l = 0; l <= k; l++) {
            f->A[k * f->n + l] = product(column, f->J + (size_t)l * rows, rows);
        }
        f->A[k * f->n + k] = f->A[k * f->n + k] * (1.0 + 1e-6) + 1e-12; // what nothing depends on
    }
    return STEIN_OK;
}

/* The step in g, halved while it makes things worse. @return 1 when it has helped by much */
static int step(refinement *f)
{
    const fit__stroke *s = &f->p->stroke[0];
    size_t rows = (size_t)s->nch * (size_t)s->n, nu = (size_t)f->p->nu;
    double part = 1.0;
    for (int halved = 0; halved < 4; halved++, part *= 0.5) {
        memcpy(f->trial, f->x, sizeof *f->trial * nu);
        for (int k = 0; k < f->n; k++) {
            f->trial[f->unknown[k]] += part * f->g[k];
        }
        if (fit__simulate(f->p, f->b, 0, f->trial, f->b->y, NULL) != STEIN_OK) {
            continue;
        }
        double now = left_over(f, f->b->y, f->r), before = f->sum;
        if (now < before) {
            memcpy(f->x, f->trial, sizeof *f->x * nu);
            memcpy(f->y, f->b->y, sizeof *f->y * rows);
            f->sum = now;
            return now < 0.9 * before;
        }
    }
    return 0;
}

stein_status data__refine_start(fit__problem *p, fit__bench *b, double *x, double *y,
                                stein_err *err)
{
    const fit__stroke *s = &p->stroke[0];
    size_t rows = (size_t)s->nch * (size_t)s->n, nu = (size_t)p->nu, n = 0;
    refinement f = {.p = p, .b = b, .x = x, .y = y};
    f.unknown = calloc(nu + 1, sizeof *f.unknown);
    for (int k = s->first; f.unknown != NULL && k < s->first + s->own; k++) {
        fit__kind kind = p->unknown[k].kind;
        if (kind == FIT__POSITION || kind == FIT__SPEED) {
            f.unknown[n++] = k;
        }
    }
    f.J = calloc(rows * (n + 1) + n * n + n + nu + (size_t)s->nch + 1, sizeof *f.J);
    if (f.unknown == NULL || f.J == NULL) {
        free(f.unknown);
        free(f.J);
        return lab__no_memory(err);
    }
    f.n = (int)n;
    f.r = f.J + rows * n;
    f.A = f.r + rows;
    f.g = f.A + n * n;
    f.trial = f.g + n;
    f.scale = f.trial + nu;
    for (int c = 0; c < s->nch; c++) {
        double travel = data__travel(s->y + c * s->n, s->n);
        f.scale[c] = travel > 0.0 ? 1.0 / travel : 0.0;
    }
    f.sum = left_over(&f, y, f.r);
    int goes_on = n > 0;
    for (int i = 0; goes_on && i < REFINEMENTS; i++) {
        goes_on = derivatives(&f) == STEIN_OK && solve_positive(f.A, f.g, f.n) == 0 && step(&f);
    }
    free(f.unknown);
    free(f.J);
    return b->no_memory ? lab__no_memory(err) : STEIN_OK;
}
