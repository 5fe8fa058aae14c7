/* SPDX-License-Identifier: GPL-3.0-or-later
 * departure.c - in which channel, and in which phase of the stroke, is the residual no noise?
 *
 * In phase F of stroke s a channel has n weighted residuals r_i. They are projected on slow
 * functions of the time within the phase, u_i = (i + 1/2)/n,
 *
 *      a_sk = sum_i phi_k(u_i) r_i,    phi_0 = 1/sqrt(n),  phi_k = sqrt(2/n) cos(pi k u)
 *
 * (orthonormal on that grid). Noise, white or not, leaves the a_sk of neighbouring k with equal
 * variance; a departure that comes again in every stroke has a mean over the strokes. So
 *
 *      F = (1/K) sum_k S mean_s(a_sk)^2 / V_k,    k < K = 3
 *
 * where V_k is the scatter of a_sk from stroke to stroke, but at least V, the larger of two
 * estimates over all k: that scatter, and the mean square of the next cosines k = K .. K + 5
 * (equally weighted cosines, the variance that holds under autocorrelation: Lazarus, Lewis, Stock &
 * Watson 2018). Neither uses the stated noise. F is taken for the F distribution with
 * K and the degrees of freedom of V, a little on the safe side; the normal deviate with the same
 * two-sided probability is the significance. The stroke is the unit: 1000 frames of one stroke that
 * was struck differently are one contradiction, not 1000.
 */
#include <gsl/gsl_cdf.h>
#include <gsl/gsl_math.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "functions.h"
#include "diagnosing.h"

enum { SLOW = 3, NEXT = 6, FEWEST = 4 }; /* functions; samples of a phase */
static const double largest_z = 37.0;

/* sums over strokes for one channel and phase */
typedef struct tally {
    double squares, noise2, product, lagged; /* of residuals [unit^2]; r_i r_i-1 and r_i-1^2 */
    int samples, strokes, next;
    double sum[SLOW], sum2[SLOW]; /* of a_sk */
    double high;                  /* squares of the next cosines */
    int slow;                     /* functions that all strokes have */
} tally;

static double cosine(int k, int i, int n)
{
    double u = (i + 0.5) / n;
    return k == 0 ? 1.0 / sqrt(n) : sqrt(2.0 / n) * stein__cos(M_PI * k * u);
}

/* residuals of one stroke in the phase, r [n] */
static void take_run(tally *t, const double *r, int n)
{
    int slow = n < FEWEST ? 1 : n < 3 * SLOW ? 2 : SLOW;
    t->slow = t->strokes == 0 || slow < t->slow ? slow : t->slow;
    for (int k = 0; k < SLOW + NEXT && k < n; k++) {
        double a = 0.0;
        for (int i = 0; i < n; i++) {
            a += cosine(k, i, n) * r[i];
        }
        if (k < SLOW) {
            t->sum[k] += a;
            t->sum2[k] += a * a;
        } else {
            t->high += a * a;
            t->next++;
        }
    }
    for (int i = 1; i < n; i++) {
        t->product += r[i] * r[i - 1];
        t->lagged += 0.5 * (r[i] * r[i] + r[i - 1] * r[i - 1]);
    }
    t->strokes++;
}

/* normal deviate of F with K and nu degrees of freedom */
static double deviate(double F, int K, int nu)
{
    double p = gsl_cdf_fdist_Q(F, K, nu);
    return p > 0.0 ? fmin(largest_z, gsl_cdf_ugaussian_Qinv(0.5 * p)) : largest_z;
}

static double significance(const tally *t)
{
    int S = t->strokes, K = t->slow, nu = (S - 1) * K;
    double own[SLOW], between = 0.0, F = 0.0;
    for (int k = 0; k < K; k++) {
        double mean = t->sum[k] / S;
        own[k] = fmax(0.0, t->sum2[k] - S * mean * mean);
        between += own[k];
    }
    double V = nu > 0 ? between / nu : 0.0;
    if (t->next > 0 && t->high / t->next > V) {
        V = t->high / t->next;
        nu = t->next;
    }
    for (int k = 0; k < K; k++) {
        double mean = t->sum[k] / S, scatter = S > 1 ? own[k] / (S - 1) : 0.0;
        F += S * mean * mean / (K * fmax(V, scatter));
    }
    return V > 0.0 && nu > 1 ? deviate(F, K, nu) : (double)NAN;
}

/* one stroke's residuals of a model channel in one phase. @return their number */
static int collect(const fit__problem *p, int stroke, int c, const double *r,
                   const char *const *phase, int wanted, double *out)
{
    const fit__stroke *s = &p->stroke[stroke];
    int n = 0;
    r += fit__offset(p, stroke);
    phase += diag__frame(p, stroke);
    for (int i = 0; i < s->n; i++) {
        int k = c * s->n + i;
        if (isfinite(s->y[k]) && phase[fit__row_of(s, k)] == diag__phase[wanted]) {
            out[n++] = fit__off(s, r, c * s->n + i) / s->noise[c];
        }
    }
    return n;
}

static void tally_channel(tally *t, const fit__problem *p, int channel, const double *r,
                          const char *const *phase, int wanted, double *room)
{
    for (int k = 0; k < p->nstroke; k++) {
        const fit__stroke *s = &p->stroke[k];
        for (int c = 0; c < s->nch; c++) {
            int n = s->channel[c] == channel ? collect(p, k, c, r, phase, wanted, room) : 0;
            double noise2 = s->noise[c] * s->noise[c];
            for (int i = 0; i < n; i++) {
                t->squares += room[i] * room[i] * noise2;
                t->noise2 += noise2;
            }
            t->samples += n;
            if (n > 0) {
                take_run(t, room, n);
            }
        }
    }
}

static stein_status add(lab_departure **list, int *n, const lab_departure *row, stein_err *err)
{
    lab_departure *more = realloc(*list, sizeof *more * (size_t)(*n + 1));
    if (more == NULL) {
        return lab__no_memory(err);
    }
    *list = more;
    more[(*n)++] = *row;
    return STEIN_OK;
}

stein_status diag__departures(const fit__problem *p, const double *r, const char *const *phase,
                              lab_departure **list, int *n, stein_err *err)
{
    const stein_model *m = lab_equations(p->model);
    stein_status status = STEIN_OK;
    double *room = malloc(sizeof *room * (size_t)(p->rows + 1));
    if (room == NULL) {
        return lab__no_memory(err);
    }
    for (int c = 0; status == STEIN_OK && c < m->nchannel; c++) {
        for (int f = 0; status == STEIN_OK && f < DIAG_PHASES; f++) {
            tally t = {.samples = 0};
            tally_channel(&t, p, c, r, phase, f, room);
            if (t.samples == 0) {
                continue;
            }
            lab_departure row = {.place = fit__name_of(p, c),
                                 .unit = m->channels[c].unit,
                                 .phase = diag__phase[f],
                                 .samples = t.samples,
                                 .size = sqrt(t.squares / t.samples),
                                 .sd = sqrt(t.noise2 / t.samples),
                                 .z = significance(&t),
                                 .lag1 = t.lagged > 0.0 ? t.product / t.lagged : (double)NAN};
            status = add(list, n, &row, err);
        }
    }
    free(room);
    return status;
}

const char *diag__phase_shown(const fit__problem *p, const double *before, const double *after,
                              const char *const *phase)
{
    double sum[DIAG_PHASES] = {0.0};
    int best = -1;
    for (int k = 0; k < p->nstroke; k++) {
        const fit__stroke *s = &p->stroke[k];
        size_t at = fit__offset(p, k), row = diag__frame(p, k);
        for (int i = 0; i < s->nch * s->n; i++) {
            double change = before[at + (size_t)i] - after[at + (size_t)i];
            int f = diag__phase_index(phase[row + (size_t)fit__row_of(s, i)]);
            sum[f < 0 ? 0 : f] += change * change;
        }
    }
    for (int f = 0; f < DIAG_PHASES; f++) {
        best = sum[f] > 0.0 && (best < 0 || sum[f] > sum[best]) ? f : best;
    }
    return best >= 0 ? diag__phase[best] : NULL;
}

/* ---- traces ---- */

static stein_status fill_trace(lab_trace *t, const fit__stroke *s, int c, const double *before,
                               const double *after, const char *const *phase, stein_err *err)
{
    size_t n = (size_t)t->n, at = (size_t)c * (size_t)s->n;
    t->t = malloc(sizeof *t->t * (n + 1));
    t->y = malloc(sizeof *t->y * (n + 1));
    t->before = malloc(sizeof *t->before * (n + 1));
    t->after = malloc(sizeof *t->after * (n + 1));
    t->phase = malloc(sizeof *t->phase * (n + 1));
    if (!t->t || !t->y || !t->before || !t->after || !t->phase) {
        return lab__no_memory(err);
    }
    memcpy(t->y, s->y + at, sizeof *t->y * n);
    memcpy(t->before, before + at, sizeof *t->before * n);
    memcpy(t->after, (after != NULL ? after : before) + at, sizeof *t->after * n);
    for (int i = 0; i < t->n; i++) {
        t->t[i] = fit__time_of(s, (int)at + i);
        t->phase[i] = phase[fit__row_of(s, (int)at + i)];
    }
    return STEIN_OK;
}

stein_status diag__trace(lab_trace **list, int *n, const fit__problem *p, int stroke, int held_out,
                         const double *before, const double *after, const char *const *phase,
                         stein_err *err)
{
    const stein_model *m = lab_equations(p->model);
    const fit__stroke *s = &p->stroke[stroke];
    lab_trace *more = realloc(*list, sizeof *more * (size_t)(*n + s->nch + 1));
    stein_status status = STEIN_OK;
    if (more == NULL) {
        return lab__no_memory(err);
    }
    *list = more;
    for (int c = 0; status == STEIN_OK && c < s->nch; c++) {
        const stein_channel *channel = &m->channels[s->channel[c]];
        more[*n] = (lab_trace){.stroke = stroke,
                               .held_out = held_out,
                               .file = s->data->file,
                               .channel = s->event[c].is ? s->event[c].name : channel->name,
                               .unit = channel->unit,
                               .n = s->event[c].is ? s->event[c].n : s->n,
                               .noise = s->noise[c]};
        const lab_column *column = lab_data_column(s->data, more[*n].channel);
        if (column != NULL && column->written[0] != '\0') {
            snprintf(more[*n].written, sizeof more[*n].written, "%s", column->written);
            more[*n].per_unit = 1.0 / column->factor;
        }
        status = fill_trace(&more[(*n)++], s, c, before, after, phase, err);
    }
    return status;
}
