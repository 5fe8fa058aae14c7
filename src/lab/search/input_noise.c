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

/* is there a measured force with noise? */
static int has_noise(const fit__stroke *t)
{
    int yes = 0;
    for (int k = 0; k < t->nsignal; k++) {
        yes |= !t->signal[k].motion && t->signal[k].noise > 0.0;
    }
    return yes;
}

/* the forces with a draw of their noise, as they are without rng */
static void stir(fit__stroke *t, const double *clean, gsl_rng *rng)
{
    for (int k = 0; k < t->nsignal; k++) {
        fit__signal *s = &t->signal[k];
        for (int i = 0; !s->motion && i < s->n; i++) {
            s->g[i] = clean[i] + (rng != NULL ? gsl_ran_gaussian(rng, s->noise) : 0.0);
        }
        clean += s->n;
        if (!s->motion) {
            fit__signal_pieces(s, NULL);
        }
    }
}

/* mean square of what draws of the noise move a record's prediction by [noise]; NAN: it fails
 * @param room  two predictions, and the values of all signals */
static double moved(const fit__problem *p, fit__bench *b, int s, const double *x, double *room,
                    gsl_rng *rng)
{
    fit__stroke *t = &p->stroke[s];
    size_t size = (size_t)t->nch * (size_t)t->n;
    double *there = room, *here = there + size, *clean = here + size, *at = clean, sum = 0.0;
    for (int k = 0; k < t->nsignal; k++) {
        memcpy(at, t->signal[k].g, sizeof *at * (size_t)t->signal[k].n);
        at += t->signal[k].n;
    }
    int ok = fit__simulate(p, b, s, x, here, NULL) == STEIN_OK;
    for (int d = 0; ok && d < DRAWS; d++) {
        stir(t, clean, rng);
        ok = fit__simulate(p, b, s, x, there, NULL) == STEIN_OK;
        for (size_t i = 0; ok && i < size; i++) {
            double off = t->share[i] * (there[i] - here[i]) / t->noise[i / (size_t)t->n];
            sum += off * off;
        }
    }
    stir(t, clean, NULL);
    return ok ? sum / (DRAWS * fmax(1.0, t->samples)) : (double)NAN;
}

static stein_status room_of(const fit__stroke *t, double **room, stein_err *err)
{
    size_t n = 2 * (size_t)t->nch * (size_t)t->n;
    for (int k = 0; k < t->nsignal; k++) {
        n += (size_t)t->signal[k].n;
    }
    *room = malloc(sizeof **room * (n + 1));
    return *room != NULL ? STEIN_OK : lab__no_memory(err);
}

stein_status diag__input_noise(const fit__problem *p, double *share, stein_err *err)
{
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
        double *room = NULL, one;
        if (!has_noise(&p->stroke[s])) {
            continue; // nothing would move
        }
        status = room_of(&p->stroke[s], &room, err);
        gsl_rng_set(rng, seed + (unsigned long)s);
        one = status == STEIN_OK ? moved(p, &b, s, x, room, rng) : (double)NAN;
        sum += isfinite(one) ? one : 0.0;
        n += isfinite(one);
        free(room);
    }
    *share = n > 0.0 ? sum / n : 0.0;
    gsl_rng_free(rng);
    free(x);
    fit__bench_free(&b);
    return status;
}
