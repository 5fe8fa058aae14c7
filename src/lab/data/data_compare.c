/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_compare.c - does the model move as a record shows, with the numbers of both files?
 *
 * Only gross errors of reading are searched. The comparison has to be quick, and must not depend on
 * noise, offsets or parameters that are wrong by some per cent:
 *
 *   - at most ROWS samples up to the third turning point of every channel are compared: beyond it
 *     a small error of the initial state or of a friction may have grown to any size;
 *   - an unknown initial state is that from which the model follows the record (start_follow.c);
 *   - the measure has no scale and no offset (data_compare.h);
 *   - times of events are no samples, and left out.
 *
 * A reading that makes no sense (an angle of 20 000 rad/s) may be stiff: it is broken off.
 */
#include <gsl/gsl_sort.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data_compare.h"
#include "fitting.h"

enum { ROWS = 300, TURNS = 3, SHIFTS = 25, STEPS = 4, SORTED = 512 };
enum { FEWEST = 8 };                  /* samples of a channel; fewer carry no information */
static const double nearly = 0.02;    /* of the travel: tolerance of a channel */
static const double hysteresis = 0.1; /* of the travel: less is no turning point */

data__reading data__as_it_is(void)
{
    return (data__reading){.column = -1, .other = -1, .factor = 1.0, .time = 1.0};
}

/* ---- the window ---- */

/* Distance of the 2 % and the 98 % quantile of the samples that are finite, at most SORTED of them;
 * 0: too few. */
static double travel_of(const double *v, int n)
{
    double sorted[SORTED];
    int stride = 1 + n / SORTED, k = 0;
    for (int i = 0; i < n; i += stride) {
        if (isfinite(v[i])) {
            sorted[k++] = v[i];
        }
    }
    if (k < FEWEST) {
        return 0.0;
    }
    gsl_sort(sorted, 1, (size_t)k);
    return sorted[k - 1 - k / 50] - sorted[k / 50];
}

/* row behind the third turning point of a channel */
static int third_turn(const lab_column *c, int n)
{
    double low = INFINITY, high = -INFINITY, range = travel_of(c->value, n);
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

/* ---- the record as read ---- */

/* a copy of the window, thinned, read otherwise: all arrays in one block */
typedef struct copy {
    lab_data data;
    lab_column *column;
    double *number;         /* [(1 + ncolumn) * nrow] */
    unsigned char *present; /* [ncolumn * nrow] */
    int *row;               /* [nrow] of the record, and room */
    lab_data *list[1];
    lab_dataset set;
} copy;

static void copy_free(copy *c)
{
    free(c->column);
    free(c->number);
    free(c->present);
    free(c->row);
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

/* One of every `stride` rows, with the most samples. Samples of a column of which few have been
 * taken weigh more, so that channels of different rates all keep some.
 * @param taken  [ncolumn] room, 0; row [rows] out */
static void choose_rows(const lab_data *d, int window, int stride, int rows, int *taken, int *row)
{
    for (int i = 0; i < rows; i++) {
        double most = -1.0;
        for (int at = i * stride; at < (i + 1) * stride && at < window; at++) {
            double weight = 0.0;
            for (int k = 0; k < d->ncolumn; k++) {
                weight += d->column[k].role != LAB_EVENT_TIMES && d->column[k].present[at]
                              ? 1.0 / (1.0 + taken[k])
                              : 0.0;
            }
            if (weight > most) {
                most = weight;
                row[i] = at;
            }
        }
        for (int k = 0; k < d->ncolumn; k++) {
            taken[k] += d->column[k].present[row[i]];
        }
    }
}

static stein_status copy_make(copy *c, const lab_data *d, data__reading r, stein_err *err)
{
    int window = window_of(d), stride = 1 + (window - 1) / ROWS, rows = 1 + (window - 1) / stride;
    size_t n = (size_t)rows, columns = (size_t)d->ncolumn;
    *c = (copy){.data = *d};
    c->column = malloc(sizeof *c->column * (columns + 1));
    c->number = malloc(sizeof *c->number * (columns + 1) * n);
    c->present = malloc(columns * n + 1);
    c->row = calloc(columns + n + 1, sizeof *c->row);
    if (c->column == NULL || c->number == NULL || c->present == NULL || c->row == NULL) {
        return lab__no_memory(err);
    }
    choose_rows(d, window, stride, rows, c->row + n, c->row);
    for (int i = 0; i < rows; i++) {
        c->number[i] = r.time * d->time[c->row[i]];
    }
    for (int k = 0; k < d->ncolumn; k++) {
        const lab_column *from = &d->column[source_of(&r, k)];
        double factor = factor_of(&r, d, k), *value = c->number + (size_t)(k + 1) * n;
        unsigned char *present = c->present + (size_t)k * n;
        int samples = 0;
        for (int i = 0; i < rows; i++) {
            present[i] = from->role != LAB_EVENT_TIMES && from->present[c->row[i]];
            value[i] = present[i] ? factor * from->value[c->row[i]] : NAN;
            samples += present[i];
        }
        c->column[k] = d->column[k];
        c->column[k].value = value;
        c->column[k].present = present;
        c->column[k].samples = samples;
        c->column[k].noise = fabs(factor) * from->noise;
        if (factor != 1.0) { // degrees under rad wrap as degrees
            data__unwrap(d->model, &c->column[k], value, rows);
        }
    }
    c->data.nrow = rows;
    c->data.time = c->number;
    c->data.column = c->column;
    c->list[0] = &c->data;
    c->set = (lab_dataset){1, c->list};
    return STEIN_OK;
}

/* ---- the comparison ---- */

void data__lose_patience(void *ctx, double t, const double *q, const double *qd, double *Q)
{
    data__patience *w = ctx;
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

/* misfit of a straight line through channel c */
static double off_line(const fit__stroke *s, int c)
{
    const double *y = s->y + (size_t)c * (size_t)s->n, *t = s->data->time;
    double n = 0.0, mean[2] = {0.0}, tt = 0.0, ty = 0.0, yy = 0.0;
    for (int i = 0; i < s->n; i++) {
        n += !isnan(y[i]);
        mean[0] += isnan(y[i]) ? 0.0 : t[i];
        mean[1] += isnan(y[i]) ? 0.0 : y[i];
    }
    for (int i = 0; i < s->n; i++) {
        double a = t[i] - mean[0] / n, b = y[i] - mean[1] / n;
        tt += isnan(y[i]) ? 0.0 : a * a;
        ty += isnan(y[i]) ? 0.0 : a * b;
        yy += isnan(y[i]) ? 0.0 : b * b;
    }
    double along = tt > 0.0 ? ty * ty / tt : 0.0;
    return yy > 0.0 ? sqrt(fmax(0.0, yy - along)) / (sqrt(yy) + sqrt(along)) : 0.0;
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

/* is the initial state unknown? */
static int is_open(const fit__problem *p)
{
    return p->nu > p->np && p->unknown[p->stroke[0].first].kind == FIT__POSITION;
}

static void take_matches(const fit__problem *p, const double *predicted, int failed,
                         data__match *match)
{
    const fit__stroke *s = &p->stroke[0];
    double tau = failed ? 0.0 : best_shift(p, predicted);
    for (int c = 0; c < s->nch; c++) {
        data__match *m = &match[column_of(s->data, s->channel[c])];
        const stein_channel *channel = &lab_equations(p->model)->channels[s->channel[c]];
        double off = off_by(s, c, failed ? s->y : predicted, tau);
        size_t first = (size_t)c * (size_t)s->n;
        m->place = fit__shows_place(channel) || fit__shows_speed(channel);
        m->travel = travel_of(s->y + first, s->n);
        m->compared = off >= 0.0 && m->travel > 0.0;
        m->off = failed ? 1.0 : off;
        m->line = off_line(s, c);
        m->adapted = is_open(p);
        m->predicted = failed ? NAN : travel_of(predicted + first, s->n);
    }
}

/* one record, with its problem set up */
static stein_status run(fit__problem *p, data__match *match, long *patience, stein_err *err)
{
    fit__bench b;
    const fit__stroke *s = &p->stroke[0];
    data__patience w = {0, *patience};
    double *x = calloc((size_t)(p->nu + p->rows + s->nch) + 1, sizeof *x);
    if (x == NULL) {
        return lab__no_memory(err);
    }
    double *y = x + p->nu, *sd = y + p->rows;
    for (int c = 0; c < s->nch; c++) {
        double travel = travel_of(s->y + (size_t)c * (size_t)s->n, s->n);
        sd[c] = travel > 0.0 ? nearly * travel : (double)INFINITY;
    }
    stein_status status = fit__bench_make(&b, p, err);
    if (status == STEIN_OK) {
        fit__follow how = {.sd = sd, .until = INFINITY, .most = INFINITY, .steps = STEPS};
        b.force = data__lose_patience;
        b.force_ctx = &w;
        if (is_open(p)) {
            fit__follow_start(p, &b, 0, &how, x);
        }
        stein_status moved = b.no_memory ? STEIN_ENOMEM : fit__simulate(p, &b, 0, x, y, NULL);
        status = fit__forgive(moved, err);
        take_matches(p, y, moved != STEIN_OK, match);
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
