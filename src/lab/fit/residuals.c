/* SPDX-License-Identifier: GPL-3.0-or-later
 * residuals.c - weighted residuals of all strokes.
 *
 *      r = w (y - h) / noise,    chi2 = sum r^2,    w^2 share of the sample, times the robust
 * weight
 *
 * Robust weights are Tukey's bisquare of the residuals over their robust scale (Huber 1981)
 *
 *      w^2 = (1 - (r/4.685 s)^2)^2 for |r| < 4.685 s, else 0,    s = max(1, 1.4826 median |r|)
 *
 * and only where at most three samples in a row would lose more than half of their weight: a bad
 * frame is short. A whole impact that does not fit is the model's fault and keeps its weight,
 * otherwise the fit would look away from what it is there to show.
 */
#include <gsl/gsl_sort.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fitting.h"
#include "functions.h"

enum { LONGEST_BAD = 3 };
static const double least_correlation = 0.1;

/* ---- residuals ---- */

size_t fit__offset(const fit__problem *p, int stroke)
{
    size_t at = 0;
    for (int s = 0; s < stroke; s++) {
        at += (size_t)(p->stroke[s].nch * p->stroke[s].n);
    }
    return at;
}

void fit__weigh(const fit__stroke *s, double *y)
{
    for (int i = 0; i < s->nch * s->n; i++) {
        y[i] = isfinite(s->y[i]) ? fit__weight(s, i) * (s->y[i] - y[i]) / s->noise[i / s->n] : 0.0;
    }
}

typedef struct job {
    const fit__problem *p;
    const double *x;
    double *r;
    int *failed; /* [nstroke] */
} job;

static stein_status ask(void *ctx, fit__bench *b, int s)
{
    job *j = ctx;
    return fit__begin(j->p, b, s, j->x, j->r + fit__offset(j->p, s), NULL);
}

static void take(void *ctx, fit__bench *b, int s, int failed)
{
    job *j = ctx;
    (void)b;
    j->failed[s] = failed;
    if (!failed) {
        fit__weigh(&j->p->stroke[s], j->r + fit__offset(j->p, s));
    }
}

stein_status fit__residuals(const fit__problem *p, const double *x, double *r, int *failed,
                            stein_err *err)
{
    job j = {p, x, r, calloc((size_t)p->nstroke, sizeof *j.failed)};
    if (j.failed == NULL) {
        return lab__no_memory(err);
    }
    stein_status status = fit__many(p, p->nstroke, ask, take, &j, err);
    *failed = 0;
    for (int s = 0; s < p->nstroke; s++) {
        *failed += j.failed[s];
    }
    free(j.failed);
    return status;
}

double fit__chi2(const fit__problem *p, const double *r)
{
    double sum = 0.0;
    size_t n = fit__offset(p, p->nstroke);
    for (size_t i = 0; i < n; i++) {
        sum += r[i] * r[i];
    }
    return sum;
}

/* Unknowns with priors use up less than a sample each. Where there are few samples, times of events
 * say, those of the records alone would be more than that: half of the samples count in any case.
 */
double fit__chi2_dof(const fit__problem *p, const double *r)
{
    return fit__chi2(p, r) / fmax(fmax(1.0, 0.5 * p->samples), p->samples - p->nu);
}

int fit__noise_given(const fit__problem *p)
{
    for (int s = 0; s < p->nstroke; s++) {
        for (int c = 0; c < p->stroke[s].nch; c++) {
            if (!p->stroke[s].given[c]) {
                return 0;
            }
        }
    }
    return 1;
}

/* limits; an amount beyond that is a mistake (diag__largest in search/thresholds.h is the same) */
static const double normal_to = 3.0;

double fit__long_tail(double x)
{
    double square = x * x, edge = normal_to * normal_to;
    return square > edge ? edge * (1.0 + stein__log_of(square / edge)) : square;
}

double fit__prior_weight(const fit__unknown *u, double x, double tempered)
{
    double edge = normal_to * normal_to;
    return !u->mistake ? tempered : x * x > edge ? edge / (x * x) : 1.0;
}

double fit__priors(const fit__problem *p, const double *x)
{
    double sum = 0.0;
    for (int k = 0; k < p->nu; k++) {
        const fit__unknown *u = &p->unknown[k];
        double own = u->mistake ? fit__long_tail(x[k]) : x[k] * x[k];
        sum += u->prior && k != p->flat ? own : 0.0;
    }
    return sum;
}

/* ---- noise ---- */

/* squares and number of samples of one model channel with unstated noise, over all strokes [unit^2]
 */
static void pooled(const fit__problem *p, int channel, const double *r, double *squares, double *n)
{
    *squares = *n = 0.0;
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        const double *rs = r + fit__offset(p, s);
        for (int i = 0; i < t->nch * t->n; i++) {
            int c = i / t->n;
            if (t->channel[c] == channel && !t->given[c] && isfinite(t->y[i])) {
                *squares += rs[i] * rs[i] * t->noise[c] * t->noise[c];
                *n += t->share[i] * t->share[i];
            }
        }
    }
}

void fit__estimate_noise(fit__problem *p, int stroke, const double *r)
{
    fit__stroke *t = &p->stroke[stroke];
    for (int c = 0; c < t->nch; c++) {
        double squares = 0.0, n = 0.0;
        if (!t->given[c]) {
            pooled(p, t->channel[c], r, &squares, &n);
        }
        double sd = n > 1.0 ? sqrt(squares / n) : 0.0;
        t->residual[c] = sd > 0.0 ? sd : t->noise[c];
    }
}

/* 1 + 2 sum of the correlations of a channel's residual, in samples as they count */
static double inflation_of(const fit__stroke *s, const double *r, int c)
{
    const double *share = s->share + (size_t)c * (size_t)s->n;
    double f = 1.0, none = 0.0, counts = 0.0, present = 0.0;
    r += c * s->n;
    for (int i = 0; i < s->n; i++) {
        none += r[i] * r[i];
        counts += share[i] * share[i];
        present += share[i] > 0.0;
    }
    for (int lag = 1; lag < s->n / 4; lag++) {
        double sum = 0.0;
        for (int i = lag; i < s->n; i++) {
            sum += r[i] * r[i - lag];
        }
        if (!(sum > least_correlation * none)) {
            break;
        }
        f += 2.0 * sum / none;
    }
    return fmax(1.0, f * counts / fmax(1.0, present));
}

/* mean over channels, those whose noise the data state counting 1 or not */
static double mean_inflation(const fit__problem *p, const double *r, int all)
{
    double sum = 0.0, n = 0.0;
    for (int s = 0; s < p->nstroke; s++) {
        const fit__stroke *t = &p->stroke[s];
        for (int c = 0; c < t->nch; c++) {
            sum += t->given[c] && !all ? 1.0 : inflation_of(t, r + fit__offset(p, s), c);
            n += 1.0;
        }
    }
    return sum / n;
}

double fit__inflation(const fit__problem *p, const double *r)
{
    return mean_inflation(p, r, 0);
}

double fit__memory(const fit__problem *p, const double *r)
{
    return mean_inflation(p, r, 1);
}

/* ---- robust weights ---- */

static double median_abs(const double *r, const double *y, int n, double *room)
{
    int m = 0;
    for (int i = 0; i < n; i++) {
        if (isfinite(y[i])) {
            room[m++] = fabs(r[i]);
        }
    }
    if (m == 0) {
        return 0.0;
    }
    gsl_sort(room, 1, (size_t)m);
    return room[m / 2];
}

/* weights of one channel of one stroke */
static void weigh_channel(double *w, const double *r, const double *y, int n, double *room)
{
    double scale = 4.685 * fmax(1.0, 1.4826 * median_abs(r, y, n, room));
    for (int i = 0; i < n; i++) {
        double u = r[i] / scale;
        w[i] = fabs(u) < 1.0 ? 1.0 - u * u : 0.0;
    }
    for (int i = 0, end; i < n; i = end) {
        for (end = i; end < n && w[end] * w[end] < 0.5; end++) {
        }
        for (int k = i; end - i > LONGEST_BAD && k < end; k++) {
            w[k] = 1.0;
        }
        end += end == i;
    }
}

stein_status fit__robust_weights(fit__problem *p, const double *r, stein_err *err)
{
    double *room = malloc(sizeof *room * (size_t)(2 * p->rows + 1));
    if (room == NULL) {
        return lab__no_memory(err);
    }
    for (int k = 0; k < p->nstroke; k++) {
        fit__stroke *s = &p->stroke[k];
        size_t size = (size_t)s->nch * (size_t)s->n;
        double *plain = room + p->rows; // residuals without the present weights
        double *w = malloc(sizeof *w * (size + 1));
        if (w == NULL) {
            free(room);
            return lab__no_memory(err);
        }
        memcpy(plain, r + fit__offset(p, k), sizeof *plain * size);
        for (int c = 0; c < s->nch; c++) {
            weigh_channel(w + c * s->n, plain + c * s->n, s->y + c * s->n, s->n, room);
        }
        free(s->weight);
        s->weight = w;
    }
    free(room);
    return STEIN_OK;
}
