/* SPDX-License-Identifier: GPL-3.0-or-later
 * input_noise.c - how far the noise of measured forces moves the simulation.
 *
 * A recorded force u = u_true + e drives the simulation, so that its prediction is off by what e
 * does, whatever the model. With draws e_k of the noise that file or audit give the input,
 *
 *      share = mean over draws and samples of ((h(u + e_k) - h(u)) / noise)^2
 *
 * is what this adds to chi2/dof. A prescribed motion is smoothed as far as its noise allows
 * (fit/signal.c) and is left alone here.
 */
#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "search.h"

enum { DRAWS = 4, RECORDS = 5 };
static const unsigned long seed = 1788;

/* sd of one sample of a record's signals; 0: prescribed motions, and what has no noise */
static stein_status find_noise(const fit__stroke *t, const stein_model *m, double *noise,
                               stein_err *err)
{
    lab_audit *audit = NULL;
    stein_status status = lab_audit_create(&audit, t->data, err);
    int k = 0;
    for (int c = 0; status == STEIN_OK && c < t->data->ncolumn; c++) {
        const lab_column *column = &t->data->column[c];
        if (column->role == LAB_INPUT) {
            double sd = audit->channel[c].noise;
            int force = m->inputs[column->index].kind != STEIN_INPUT_MOTION;
            noise[k++] = force && isfinite(sd) ? sd : 0.0;
        }
    }
    lab_audit_destroy(audit);
    return status;
}

static void stir(fit__stroke *t, const double *const *clean, const double *noise, gsl_rng *rng)
{
    for (int k = 0; k < t->nsignal; k++) {
        fit__signal *s = &t->signal[k];
        for (int i = 0; !s->motion && i < s->n; i++) {
            s->g[i] = clean[k][i] + (rng != NULL ? gsl_ran_gaussian(rng, noise[k]) : 0.0);
        }
        if (!s->motion) {
            fit__signal_pieces(s, NULL);
        }
    }
}

/* mean square of what draws of the noise move a record's prediction by [noise]; NAN: it fails */
static double moved(const fit__problem *p, fit__bench *b, int s, const double *x,
                    const double *noise, double *clean, gsl_rng *rng)
{
    fit__stroke *t = &p->stroke[s];
    const double *from[64];
    size_t size = (size_t)t->nch * (size_t)t->n;
    double *there = clean, *here = there + size, *at = here + size, sum = 0.0;
    int ok = t->nsignal <= 64 && fit__simulate(p, b, s, x, here, NULL) == STEIN_OK;
    for (int k = 0; ok && k < t->nsignal; k++) {
        from[k] = memcpy(at, t->signal[k].g, sizeof *at * (size_t)t->signal[k].n);
        at += t->signal[k].n;
    }
    for (int d = 0; ok && d < DRAWS; d++) {
        stir(t, from, noise, rng);
        ok = fit__simulate(p, b, s, x, there, NULL) == STEIN_OK;
        for (size_t i = 0; ok && i < size; i++) {
            double off = t->share[i] * (there[i] - here[i]) / t->noise[i / (size_t)t->n];
            sum += off * off;
        }
    }
    stir(t, from, noise, NULL);
    return ok ? sum / (DRAWS * fmax(1.0, t->samples)) : (double)NAN;
}

stein_status diag__input_noise(const fit__problem *p, double *share, stein_err *err)
{
    const stein_model *m = lab_equations(p->model);
    fit__bench b;
    double sum = 0.0, n = 0.0, *x = calloc((size_t)p->nu + 1, sizeof *x);
    gsl_rng *rng = gsl_rng_alloc(gsl_rng_mt19937);
    stein_status status = fit__bench_make(&b, p, err);
    if (status == STEIN_OK && (x == NULL || rng == NULL)) {
        status = lab__no_memory(err);
    }
    int most = p->nstroke < RECORDS ? p->nstroke : RECORDS;
    for (int k = 0; status == STEIN_OK && k < most; k++) {
        int s = k * p->nstroke / most;
        const fit__stroke *t = &p->stroke[s];
        size_t room = (size_t)t->n * (2 * (size_t)t->nch + (size_t)t->nsignal);
        double *work = malloc(sizeof *work * (room + (size_t)t->nsignal + 1)), *noise = work + room;
        status = work != NULL ? find_noise(t, m, noise, err) : lab__no_memory(err);
        gsl_rng_set(rng, seed + (unsigned long)s);
        double one = status == STEIN_OK ? moved(p, &b, s, x, noise, work, rng) : (double)NAN;
        sum += isfinite(one) ? one : 0.0;
        n += isfinite(one);
        free(work);
    }
    *share = n > 0.0 ? sum / n : 0.0;
    gsl_rng_free(rng);
    free(x);
    fit__bench_free(&b);
    return status;
}
