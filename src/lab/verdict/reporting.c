/* SPDX-License-Identifier: GPL-3.0-or-later
 * reporting.c - error on records that no fit has read before the table was closed.
 *
 * What all records share stays as it was fitted. A record's own unknowns are fitted to it, with and
 * without the causes alike, since no model predicts them: initial state, trigger, offsets, and what
 * scatters, with the variances of the fit. The error is the RMS of the residual; the gain is the
 * ratio of two such errors, its interval a bootstrap over records: samples of one record are not
 * independent.
 */
#include <gsl/gsl_rng.h>
#include <gsl/gsl_sort.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "verdict.h"

enum { DRAWS = 2000, BLOCKS = 8 };

stein_status diag__report(const diag__row *row, const lab_dataset *data, diag__reported *to,
                          stein_err *err)
{
    *to = (diag__reported){.rmse = NAN};
    const lab_dataset *in = data;
    stein_status status = STEIN_OK;
    if (row->in->own != NULL) {
        status = diag__read_again(data, row->in->model, &to->own, err);
        in = to->own;
    }
    memcpy(to->cause, row->cause, sizeof to->cause);
    status = status == STEIN_OK ? fit__problem_make_with(&to->p, row->in->model, in, row->p.def,
                                                         to->cause, row->h.n, err)
                                : status;
    if (status != STEIN_OK) {
        return status;
    }
    fit__problem *p = &to->p;
    p->tolerance = row->p.tolerance;
    p->simulated = row->p.simulated;
    to->x = calloc((size_t)p->nu + fit__offset(p, p->nstroke) + 1, sizeof *to->x);
    if (to->x == NULL) {
        return lab__no_memory(err);
    }
    to->r = to->x + p->nu;
    memcpy(to->x, row->x, sizeof *to->x * (size_t)p->np);
    status = diag__fit_own(p, row->D, row->chi2_dof < diag__near_noise, to->x, to->r, err);
    if (status == STEIN_OK) {
        to->rmse = sqrt(fit__chi2(p, to->r) / fmax(1.0, p->samples));
    }
    return status;
}

void diag__reported_free(diag__reported *h)
{
    fit__problem_free(&h->p);
    lab_dataset_close(h->own);
    free(h->x);
    *h = (diag__reported){.rmse = NAN};
}

/* ---- gain ---- */

/* what a bootstrap draws: records, or blocks of the only one */
static int draws_of(const fit__problem *p)
{
    return p->nstroke > 1 ? p->nstroke : BLOCKS;
}

/* squares and samples of a channel (-1: all) and phase (NULL: all) of one of draws_of */
static void sums(const fit__problem *p, const double *r, const char *const *phase, int draw,
                 int channel, const char *want, double *square, double *n)
{
    int s = p->nstroke > 1 ? draw : 0;
    const fit__stroke *t = &p->stroke[s];
    *square = *n = 0.0;
    for (int i = 0; i < t->nch * t->n; i++) {
        int c = i / t->n, row = fit__row_of(t, i), at = (int)diag__frame(p, s) + row;
        if (p->nstroke == 1 && (int)((long long)row * BLOCKS / t->n) != draw) {
            continue;
        }
        double unit = channel < 0 ? 1.0 : t->noise[c];
        if (isfinite(t->y[i]) && (channel < 0 || t->channel[c] == channel) &&
            (want == NULL || phase[at] == want)) {
            double v = unit * r[fit__offset(p, s) + (size_t)i];
            *square += v * v;
            *n += t->share[i] * t->share[i];
        }
    }
}

static stein_status interval(const double *before, const double *after, int n, lab_gain *g)
{
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    double *ratio = malloc(sizeof *ratio * DRAWS);
    if (rng != NULL && ratio != NULL) {
        gsl_rng_set(rng, 1788);
        for (int d = 0; d < DRAWS; d++) {
            double b = 0.0, a = 0.0;
            for (int i = 0; i < n; i++) {
                unsigned long k = gsl_rng_uniform_int(rng, (unsigned long)n);
                b += before[k];
                a += after[k];
            }
            ratio[d] = b > 0.0 ? sqrt(a / b) : 1.0;
        }
        gsl_sort(ratio, 1, DRAWS);
        g->lo = ratio[(int)(0.025 * DRAWS)];
        g->hi = ratio[(int)(0.975 * DRAWS)];
    }
    stein_status status = rng != NULL && ratio != NULL ? STEIN_OK : STEIN_ENOMEM;
    if (rng != NULL) {
        gsl_rng_free(rng);
    }
    free(ratio);
    return status;
}

/* @return samples */
static int measure(const diag__reported *before, const diag__reported *after,
                   const char *const *phase, int channel, const char *want, lab_gain *g,
                   stein_err *err, stein_status *status)
{
    const fit__problem *p = &before->p;
    int draws = draws_of(p);
    double *b = malloc(sizeof *b * (size_t)(2 * draws + 1));
    double *a = b + (b != NULL ? draws : 0), sb = 0.0, sa = 0.0, all = 0.0;
    if (b == NULL) {
        *status = lab__no_memory(err);
        return 0;
    }
    for (int s = 0; s < draws; s++) {
        double n = 0.0;
        sums(p, before->r, phase, s, channel, want, &b[s], &n);
        sums(&after->p, after->r, phase, s, channel, want, &a[s], &n);
        sb += b[s];
        sa += a[s];
        all += n;
    }
    g->samples = (int)all;
    g->rmse_before = all > 0.0 ? sqrt(sb / all) : NAN;
    g->rmse_after = all > 0.0 ? sqrt(sa / all) : NAN;
    g->ratio = sb > 0.0 ? sqrt(sa / sb) : NAN;
    g->lo = g->hi = NAN;
    if (all > 0.0 && interval(b, a, draws, g) != STEIN_OK) {
        *status = lab__no_memory(err);
    }
    free(b);
    return g->samples;
}

stein_status diag__compare(const diag__reported *before, const diag__reported *after, lab_gain *g,
                           stein_err *err)
{
    stein_status status = STEIN_OK;
    measure(before, after, NULL, -1, NULL, g, err, &status);
    return status;
}

/* the unit of a channel in the records */
static void note_written(lab_gain *g, const lab_data *data)
{
    const lab_column *c = lab_data_column(data, g->channel);
    if (c != NULL && c->written[0] != '\0') {
        snprintf(g->written, sizeof g->written, "%s", c->written);
        g->per_unit = 1.0 / c->factor;
    }
}

stein_status diag__gain(lab_diagnosis *out, const diag__reported *before,
                        const diag__reported *after, const char *const *phase, stein_err *err)
{
    const fit__problem *p = &before->p;
    const stein_model *m = lab_equations(p->model);
    stein_status status = STEIN_OK;
    out->gain.noise = 1.0;
    measure(before, after, phase, -1, NULL, &out->gain, err, &status);
    out->gains = calloc((size_t)m->nchannel * (DIAG_PHASES + 1) + 1, sizeof *out->gains);
    if (out->gains == NULL) {
        return lab__no_memory(err);
    }
    for (int c = 0; status == STEIN_OK && c < m->nchannel; c++) {
        double noise = NAN;
        for (int k = 0; k < p->stroke[0].nch; k++) {
            noise = p->stroke[0].channel[k] == c ? p->stroke[0].noise[k] : noise;
        }
        for (int f = -1; isfinite(noise) && f < DIAG_PHASES; f++) {
            lab_gain *g = &out->gains[out->ngain];
            *g = (lab_gain){.channel = fit__name_of(p, c),
                            .unit = m->channels[c].unit,
                            .phase = f < 0 ? NULL : diag__phase[f],
                            .noise = noise};
            note_written(g, p->stroke[0].data);
            out->ngain += measure(before, after, phase, c, g->phase, g, err, &status) > 0;
        }
    }
    return status;
}
