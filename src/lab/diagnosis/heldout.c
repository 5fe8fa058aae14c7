/* SPDX-License-Identifier: GPL-3.0-or-later
 * heldout.c - error on strokes that nothing was fitted to.
 *
 * What all strokes share stays as it was fitted; a stroke's own - trigger, offsets, and what
 * differs by itself, with the variances the fit has found - is fitted to it, as no model could know
 * it. Both models get the same help. The error is the RMS of what is left, in units of noise.
 *
 * That help can hide a cause that acts like what differs by itself: a gain of the drive is a drive
 * that differs to one side in every stroke. Whether a cause pays is therefore asked of the
 * likelihood, in which differences have their price.
 *
 * A stroke that is lost although the others are at their noise - it escapes a moment too late, and
 * none of its own numbers leads back - says nothing about who is right: the comparison leaves it
 * out. What is told of the error has it.
 *
 * The gain is the ratio of two such errors. Its interval is a bootstrap over strokes: frames of
 * one stroke are no independent witnesses.
 */
#include <gsl/gsl_cblas.h>
#include <gsl/gsl_math.h>
#include <gsl/gsl_rng.h>
#include <gsl/gsl_sort.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "searching.h"

enum { DRAWS = 2000, LOST_MOST = 3 }; /* a third of the strokes at most */

/* which strokes are lost while the others are at their noise; none where too many are */
static void find_lost(diag__held *h)
{
    const fit__problem *p = &h->p;
    double middle = diag__middle(p, h->r, h->lost);
    int n = 0;
    for (int s = 0; s < p->nstroke; s++) {
        h->lost[s] = !diag__is_far(middle) && diag__is_stray(p, h->r, s, middle);
        n += h->lost[s] > 0.0;
    }
    for (int s = 0; n > p->nstroke / LOST_MOST && s < p->nstroke; s++) {
        h->lost[s] = 0.0;
    }
}

stein_status diag__held_out(diag *d, const diag__suspect *s, diag__held *to, stein_err *err)
{
    const double *D = s != NULL ? s->D : d->null_D;
    const fit__problem *like = s != NULL ? diag__problem(d, s) : &d->p;
    const lab_candidate *effect = s != NULL ? &s->s.candidate : NULL;
    *to = (diag__held){.rmse = NAN};
    const lab_dataset *data = like != &d->p ? s->held_data : d->held_data;
    stein_status status = diag__own_problem(d, like, data, effect, D, &to->p, err);
    if (status != STEIN_OK) {
        return status;
    }
    fit__problem *p = &to->p;
    size_t rows = fit__offset(p, p->nstroke);
    to->x = calloc((size_t)p->nu + rows + 2 * (size_t)p->nstroke + 1, sizeof *to->x);
    if (to->x == NULL) {
        return lab__no_memory(err);
    }
    to->r = to->x + p->nu;
    to->deviance = to->r + rows;
    to->lost = to->deviance + p->nstroke;
    memcpy(to->x, s != NULL ? s->x : d->x, sizeof *to->x * (size_t)p->np);
    diag__singles each = {.d = d, .p = p, .D = D, .x = to->x, .r = to->r, .middle = NAN};
    status = diag__fit_singles(&each, NULL, err);
    status = status == STEIN_OK ? diag__deviance(&each, to->deviance, err) : status;
    d->out->fits += each.fits;
    if (status == STEIN_OK) {
        to->rmse = sqrt(fit__chi2(p, to->r) / fmax(1.0, p->samples));
        find_lost(to);
    }
    return status;
}

void diag__compare(const diag__held *without, const diag__held *with, int likely, double *before,
                   double *after)
{
    const fit__problem *p = &with->p;
    int known = isfinite(without->rmse) && isfinite(with->rmse);
    *before = *after = known ? 0.0 : (double)NAN;
    for (int s = 0; known && s < p->nstroke; s++) {
        size_t at = fit__offset(p, s), n = fit__offset(p, s + 1) - at;
        if (!(with->lost[s] > 0.0)) {
            *before +=
                likely ? without->deviance[s] : gsl_pow_2(cblas_dnrm2((int)n, without->r + at, 1));
            *after += likely ? with->deviance[s] : gsl_pow_2(cblas_dnrm2((int)n, with->r + at, 1));
        }
    }
}

void diag__held_free(diag__held *h)
{
    fit__problem_free(&h->p);
    free(h->x);
}

/* ---- gain ---- */

/* squares and samples of a channel (-1: all) and phase (NULL: all) of a stroke */
static void sums(const fit__problem *p, const double *r, const char *const *phase, int s,
                 int channel, const char *want, double *square, double *n)
{
    const fit__stroke *t = &p->stroke[s];
    *square = *n = 0.0;
    for (int i = 0; i < t->nch * t->n; i++) {
        int c = i / t->n, at = (int)diag__row(p, s) + i % t->n;
        double unit = channel < 0 ? 1.0 : t->noise[c];
        if (isfinite(t->y[i]) && (channel < 0 || t->channel[c] == channel) &&
            (want == NULL || phase[at] == want)) {
            double v = unit * r[fit__offset(p, s) + (size_t)i];
            *square += v * v;
            *n += 1.0;
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
static int measure(const diag__held *before, const diag__held *after, const char *const *phase,
                   int channel, const char *want, lab_gain *g, stein_err *err, stein_status *status)
{
    const fit__problem *p = &before->p;
    double *b = malloc(sizeof *b * (size_t)(2 * p->nstroke + 1));
    double *a = b + (b != NULL ? p->nstroke : 0), sb = 0.0, sa = 0.0, all = 0.0;
    if (b == NULL) {
        *status = lab__no_memory(err);
        return 0;
    }
    for (int s = 0; s < p->nstroke; s++) {
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
    if (all > 0.0 && interval(b, a, p->nstroke, g) != STEIN_OK) {
        *status = lab__no_memory(err);
    }
    free(b);
    return g->samples;
}

stein_status diag__ratio(const diag__held *without, const diag__held *with, lab_suspect *cause,
                         stein_err *err)
{
    lab_gain g = {.ratio = NAN, .lo = NAN, .hi = NAN};
    stein_status status = STEIN_OK;
    if (isfinite(without->rmse) && isfinite(with->rmse)) {
        measure(without, with, NULL, -1, NULL, &g, err, &status);
    }
    cause->own_ratio = g.ratio;
    cause->own_lo = g.lo;
    cause->own_hi = g.hi;
    return status;
}

stein_status diag__gain(lab_diagnosis *out, const diag__held *before, const diag__held *after,
                        const char *const *phase, stein_err *err)
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
            *g = (lab_gain){.channel = m->channels[c].name,
                            .unit = m->channels[c].unit,
                            .phase = f < 0 ? NULL : diag__phase[f],
                            .noise = noise};
            out->ngain += measure(before, after, phase, c, g->phase, g, err, &status) > 0;
        }
    }
    return status;
}
