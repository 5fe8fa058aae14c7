/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_trial.c - does the model move as a record says, with the numbers of both files?
 *
 * Only gross errors of reading are looked for, so the comparison has to be quick and must not
 * depend on noise, on offsets or on parameters that are wrong by some per cent:
 *
 *   - at most ROWS samples up to the third turning point of every channel are compared: beyond it
 *     a small error of the initial state or of a friction may have grown to any size;
 *   - an unknown initial state q, qd solves h(q) = y(0), dh/dq qd = dy/dt(0) in the least-squares
 *     sense, with a weak prior at the file's values for what no channel shows. y(0) and its slope
 *     are those of a parabola through the first samples;
 *   - the measure has no scale and no offset (data_trial.h).
 *
 * A reading that makes no sense (an angle of 20 000 rad/s) may be stiff: it is broken off.
 */
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data_trial.h"
#include "fitting.h"

enum { ROWS = 300, TURNS = 3, FEWEST = 8, NEWTON = 6, SHIFTS = 25 };
static const double hysteresis = 0.1;  /* of the travel: less is no turning point */
static const double first_part = 0.08; /* of the window: where the initial slope is taken from */
static const double weak = 1e-3;       /* weight of the prior against a channel's travel */

data__reading data__as_it_is(void)
{
    return (data__reading){.column = -1, .other = -1, .factor = 1.0, .time = 1.0};
}

/* ---- the window ---- */

/* 2 % and 98 % of the samples that are finite. @return their distance; 0: too few */
static double travel_of(const double *v, int n)
{
    double *sorted = malloc(sizeof *sorted * ((size_t)n + 1)), travel = 0.0;
    int k = 0;
    for (int i = 0; sorted != NULL && i < n; i++) {
        if (isfinite(v[i])) {
            sorted[k++] = v[i];
        }
    }
    if (k >= FEWEST) {
        qsort(sorted, (size_t)k, sizeof *sorted, data__compare);
        travel = sorted[k - 1 - k / 50] - sorted[k / 50];
    }
    free(sorted);
    return travel;
}

/* row behind the third turning point of a channel */
static int third_turn(const lab_column *c, int n)
{
    double low = INFINITY, high = -INFINITY, range = travel_of(c->value, n < 20000 ? n : 20000);
    int turns = 0, way = 0;
    for (int i = 0; i < n; i++) {
        if (!c->present[i]) {
            continue;
        }
        low = fmin(low, c->value[i]);
        high = fmax(high, c->value[i]);
        int up = c->value[i] > low + hysteresis * range,
            down = c->value[i] < high - hysteresis * range;
        if ((up && way <= 0) || (down && way >= 0)) {
            turns += way != 0;
            way = up && way <= 0 ? 1 : -1;
            low = high = c->value[i];
        }
        if (turns == TURNS) {
            return i + 1;
        }
    }
    return n;
}

static int window_of(const lab_data *d)
{
    int rows = FEWEST;
    for (int k = 0; k < d->ncolumn; k++) {
        int turned = d->column[k].role == LAB_OUTPUT ? third_turn(&d->column[k], d->nrow) : 0;
        rows = turned > rows ? turned : rows;
    }
    return rows < d->nrow ? rows : d->nrow;
}

/* ---- the record as it is read ---- */

/* a copy of the window, thinned, read otherwise: all arrays in one block */
typedef struct copy {
    lab_data data;
    lab_column *column;
    double *number;         /* [(1 + ncolumn) * nrow] */
    unsigned char *present; /* [ncolumn * nrow] */
    lab_data *list[1];
    lab_dataset set;
} copy;

static void copy_free(copy *c)
{
    free(c->column);
    free(c->number);
    free(c->present);
}

static double factor_of(const data__reading *r, const lab_data *d, int k)
{
    int scaled =
        r->unit != NULL ? strcmp(d->column[k].unit, r->unit) == 0 : r->other < 0 && r->column == k;
    return scaled ? r->factor : 1.0;
}

/* the column whose samples column k gets */
static int source_of(const data__reading *r, int k)
{
    return r->other < 0 ? k : k == r->column ? r->other : k == r->other ? r->column : k;
}

static stein_status copy_make(copy *c, const lab_data *d, data__reading r, stein_err *err)
{
    int window = window_of(d), stride = 1 + (window - 1) / ROWS, rows = 1 + (window - 1) / stride;
    size_t n = (size_t)rows, columns = (size_t)d->ncolumn;
    *c = (copy){.data = *d};
    c->column = malloc(sizeof *c->column * (columns + 1));
    c->number = malloc(sizeof *c->number * (columns + 1) * n);
    c->present = malloc(columns * n + 1);
    if (c->column == NULL || c->number == NULL || c->present == NULL) {
        return lab__no_memory(err);
    }
    for (int i = 0; i < rows; i++) {
        c->number[i] = r.time * d->time[i * stride];
    }
    for (int k = 0; k < d->ncolumn; k++) {
        const lab_column *from = &d->column[source_of(&r, k)];
        double factor = factor_of(&r, d, k), *value = c->number + (size_t)(k + 1) * n;
        unsigned char *present = c->present + (size_t)k * n;
        int samples = 0;
        for (int i = 0; i < rows; i++) {
            present[i] = from->present[i * stride];
            value[i] = present[i] ? factor * from->value[i * stride] : NAN;
            samples += present[i];
        }
        c->column[k] = d->column[k];
        c->column[k].value = value;
        c->column[k].present = present;
        c->column[k].samples = samples;
        c->column[k].noise = fabs(factor) * from->noise;
    }
    c->data.nrow = rows;
    c->data.time = c->number;
    c->data.column = c->column;
    c->list[0] = &c->data;
    c->set = (lab_dataset){1, c->list};
    return STEIN_OK;
}

/* ---- initial state ---- */

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

static int shows_place(stein_read_kind read)
{
    return read == STEIN_READ_POSITION || read == STEIN_READ_GAP || read == STEIN_READ_X ||
           read == STEIN_READ_Y || read == STEIN_READ_Z;
}

static int shows_speed(stein_read_kind read)
{
    return read == STEIN_READ_SPEED || read == STEIN_READ_VX || read == STEIN_READ_VY ||
           read == STEIN_READ_VZ;
}

/* value and slope of the first samples of a channel: a parabola by least squares */
static void start_of(const fit__stroke *s, const double *y, double *value, double *rate)
{
    const double *t = s->data->time;
    int n = (int)(first_part * s->n) > 5 ? (int)(first_part * s->n) : 5, k = 0;
    double t0 = t[0], span = t[n < s->n ? n : s->n - 1] - t0, A[9] = {0}, g[3] = {0}, x[3];
    for (int i = 0; i < s->n && i < n; i++) {
        double u = (t[i] - t0) / span, basis[3] = {1.0, u, u * u};
        for (int r = 0; !isnan(y[i]) && r < 9; r++) {
            A[r] += basis[r / 3] * basis[r % 3];
            g[r / 3] += r % 3 == 0 ? basis[r / 3] * y[i] : 0.0;
        }
        k += !isnan(y[i]);
    }
    *value = *rate = NAN;
    gsl_matrix_view M = gsl_matrix_view_array(A, 3, 3);
    gsl_vector_view right = gsl_vector_view_array(g, 3), left = gsl_vector_view_array(x, 3);
    if (k >= 4 && span > 0.0 && gsl_linalg_cholesky_decomp1(&M.matrix) == 0) {
        gsl_linalg_cholesky_solve(&M.matrix, &right.vector, &left.vector);
        *value = x[0];
        *rate = x[1] / span;
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
    gsl_matrix_view M = gsl_matrix_view_array(A, n, n);
    gsl_vector_view x = gsl_vector_view_array(dx, n);
    return gsl_linalg_cholesky_decomp1(&M.matrix) == 0 &&
                   gsl_linalg_cholesky_svx(&M.matrix, &x.vector) == 0
               ? 0
               : -1;
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
            int usable = shows_place(channel->read) && !channel->from_rest;
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
        r[c] = shows_place(read) ? g->rate[c] : shows_speed(read) ? g->value[c] - g->read[c] : NAN;
        for (int k = 0; k < g->n; k++) {
            int joint = g->p->unknown[g->unknown[k]].index;
            r[c] -= shows_place(read) ? J[c * g->n + k] * g->qd[joint] : 0.0;
            J[c * g->n + k] = shows_speed(read) ? by_speed[c * g->n + k] : J[c * g->n + k];
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

/* state of the problem's simulation before it is moved, what the record shows at its start, and the
 * estimate, in the unknowns x. @return OK, ENOMEM, or what the simulation says */
static stein_status find_start(fit__problem *p, fit__bench *b, double *x, stein_err *err)
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
            double travel = travel_of(s->y + c * (size_t)s->n, s->n);
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

/* ---- the comparison ---- */

typedef struct watch {
    long used, most;
} watch;

/* a reading that makes no sense makes stiff runs: they are broken off as failed */
static void lose_patience(void *ctx, double t, const double *q, const double *qd, double *Q)
{
    watch *w = ctx;
    (void)t, (void)q, (void)qd;
    Q[0] += ++w->used > w->most ? (double)NAN : 0.0;
}

/* prediction h [n] at time `at`; t increasing, k where it was read last */
static double read_later(const double *t, const double *h, int n, double at, int *k)
{
    while (*k + 2 < n && t[*k + 1] < at) {
        ++*k;
    }
    double u = (at - t[*k]) / (t[*k + 1] - t[*k]);
    u = fmin(fmax(u, 0.0), 1.0);
    return h[*k] + u * (h[*k + 1] - h[*k]);
}

/* how far channel c is off when its prediction is read tau later; -1: too few samples */
static double off_by(const fit__stroke *s, int c, const double *predicted, double tau)
{
    const double *y = s->y + (size_t)c * (size_t)s->n, *h = predicted + (size_t)c * (size_t)s->n;
    double sum[3] = {0.0}, squares[3] = {0.0}, sd[3], y0 = NAN, p0 = NAN;
    int n = 0, k = 0;
    for (int i = 0; i < s->n; i++) {
        if (isnan(y[i])) {
            continue;
        }
        double p = read_later(s->data->time, h, s->n, s->data->time[i] + tau, &k);
        y0 = n == 0 ? y[i] : y0; // about the first sample: offsets may be large
        p0 = n == 0 ? p : p0;
        double v[3] = {y[i] - y0, p - p0, y[i] - y0 - (p - p0)};
        for (int j = 0; j < 3; j++) {
            sum[j] += v[j];
            squares[j] += v[j] * v[j];
        }
        n++;
    }
    for (int j = 0; j < 3; j++) {
        sd[j] = n > 0 ? sqrt(fmax(0.0, squares[j] / n - (sum[j] / n) * (sum[j] / n))) : 0.0;
    }
    double off = sd[0] + sd[1] > 0.0 ? sd[2] / (sd[0] + sd[1]) : 0.0;
    return n < FEWEST ? -1.0 : isfinite(off) ? off : 1.0;
}

/* the shift of an unknown trigger at which all channels together are nearest */
static double best_shift(const fit__problem *p, const double *predicted)
{
    const fit__stroke *s = &p->stroke[0];
    double best = INFINITY, at = 0.0, reach = s->tau >= 0 ? 3.0 * p->def->trigger : 0.0;
    for (int i = 0; reach > 0.0 && i < SHIFTS; i++) {
        double tau = reach * (2.0 * i / (SHIFTS - 1) - 1.0), sum = 0.0;
        for (int c = 0; c < s->nch; c++) {
            sum += fmax(0.0, off_by(s, c, predicted, tau));
        }
        at = sum < best ? tau : at;
        best = fmin(best, sum);
    }
    return at;
}

static int column_of(const lab_data *d, int channel)
{
    int k = 0;
    while (d->column[k].role != LAB_OUTPUT || d->column[k].index != channel) {
        k++;
    }
    return k;
}

static void take_matches(const fit__problem *p, const double *predicted, int failed,
                         data__match *match)
{
    const fit__stroke *s = &p->stroke[0];
    double tau = failed ? 0.0 : best_shift(p, predicted);
    for (int c = 0; c < s->nch; c++) {
        data__match *m = &match[column_of(s->data, s->channel[c])];
        stein_read_kind read = lab_equations(p->model)->channels[s->channel[c]].read;
        double off = off_by(s, c, failed ? s->y : predicted, tau);
        size_t first = (size_t)c * (size_t)s->n;
        m->place = shows_place(read) || shows_speed(read);
        m->travel = travel_of(s->y + first, s->n);
        m->compared = off >= 0.0 && m->travel > 0.0;
        m->off = failed ? 1.0 : off;
        m->predicted = failed ? NAN : travel_of(predicted + first, s->n);
    }
}

/* one record whose problem is made */
static stein_status run(fit__problem *p, data__match *match, long *patience, stein_err *err)
{
    fit__bench b;
    fit__stroke *s = &p->stroke[0];
    watch w = {0, *patience};
    double *x = calloc((size_t)p->nu + 1, sizeof *x);
    stein_status status = x != NULL ? fit__bench_make(&b, p, err) : lab__no_memory(err);
    if (x == NULL) {
        return status;
    }
    for (int k = 0; k < p->nu && s->nsignal == 0; k++) {
        // an unknown initial state is that of the first sample
        s->origin = p->unknown[k].kind == FIT__POSITION ? s->data->time[0] : s->origin;
    }
    if (status == STEIN_OK) {
        b.force = lose_patience;
        b.force_ctx = &w;
        stein_status moved = find_start(p, &b, x, err);
        moved = moved == STEIN_OK ? fit__simulate(p, &b, 0, x, b.y, NULL) : moved;
        status = fit__forgive(moved, err);
        take_matches(p, b.y, moved != STEIN_OK, match);
    }
    *patience = w.used;
    fit__bench_free(&b);
    free(x);
    return status;
}

stein_status data__try(const lab_model *model, const lab_data *data, data__reading reading,
                       data__match *match, long *patience, stein_err *err)
{
    copy c;
    fit__problem p;
    lab_fit_def def = lab_fit_def_default();
    def.scatter = 0;
    def.offset = 0.0;
    def.threads = def.lanes = 1;
    memset(match, 0, sizeof *match * (size_t)data->ncolumn);
    stein_status status = copy_make(&c, data, reading, err);
    if (status == STEIN_OK) {
        status = fit__problem_make_open(&p, model, &c.set, &def, err);
        if (status == STEIN_OK) {
            p.tolerance = 1e-8;
            status = run(&p, match, patience, err);
        }
        fit__problem_free(&p);
    }
    copy_free(&c);
    return status;
}
