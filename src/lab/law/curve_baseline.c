/* SPDX-License-Identifier: GPL-3.0-or-later
 * curve_baseline.c - the fit without a law from which curves begin, and the derivatives of curves
 * there.
 *
 * A fit without the law is biased: strokes that escape at a wrong moment are compensated by their
 * own numbers and by the parameters. So the observer holds the simulation near the records, and the
 * residual there is the effect of the law.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "curve.h"

enum { RENEWALS = 2, SHORTER = 3, SIZES = 8 };
static const double shorter = 0.1; /* differences where a stroke cannot be simulated */

static void take_start(diag__curves *w)
{
    const diag__row *null = w->null;
    fit__problem *p = &w->p;
    size_t own = (size_t)(p->nu - p->np);
    memcpy(w->x, null->x, sizeof *w->x * (size_t)w->q->nname);
    memcpy(p->step, null->p.step, sizeof *w->x * (size_t)w->q->nname);
    if (p->nstroke == null->p.nstroke) {
        memcpy(w->x + p->np, null->x + null->p.np, sizeof *w->x * own);
        memcpy(p->step + p->np, null->p.step + null->p.np, sizeof *w->x * own);
    }
    for (int i = 0; i < LAB_SCATTERS; i++) {
        w->D[i] = 1.0;
    }
    for (int i = 0; i < w->nsite; i++) {
        for (int k = 0; k < w->site[i].n; k++) {
            fit__unknown *u = &p->unknown[w->site[i].first + k];
            u->prior = u->log = 0;
            u->start = 0.0;
            u->sd = 1.0;
        }
    }
}

/* ---- how large a value is ---- */

typedef struct sizing {
    diag__curves *w;
    int stroke;
} sizing;

/* RMS change of a stroke with all values of a curve at one, in noise; INFINITY: it cannot be
 * simulated. @param x  room, [nu + rows] */
static double moved(const sizing *z, fit__bench *b, const diag__site *site, double value, double *x)
{
    const fit__problem *p = &z->w->p;
    const fit__stroke *s = &p->stroke[z->stroke];
    const double *r = z->w->r + fit__offset(p, z->stroke);
    double *y = x + p->nu, sum = 0.0;
    memcpy(x, z->w->x, sizeof *x * (size_t)p->nu);
    for (int i = site->pinned; i < site->n; i++) {
        x[site->first + i] = value;
    }
    if (fit__simulate(p, b, z->stroke, x, y, NULL) != STEIN_OK) {
        return INFINITY;
    }
    fit__weigh(s, y);
    for (int i = 0; i < s->nch * s->n; i++) {
        sum += (y[i] - r[i]) * (y[i] - r[i]);
    }
    return sqrt(sum / fmax(1.0, s->samples));
}

/* first a value that changes one stroke by about the noise */
static void one_size(void *ctx, fit__bench *b, int job)
{
    sizing *z = ctx;
    fit__problem *p = &z->w->p;
    const diag__site *site = &z->w->site[job];
    double value = 1e-4, most = 1e6;
    double *room = malloc(sizeof *room * ((size_t)p->nu + (size_t)p->rows + 1));
    for (int k = 0; room != NULL && k < SIZES; k++) {
        double change = moved(z, b, site, value, room);
        if (change > 0.3 && change < 3.0) {
            break;
        }
        double factor = isfinite(change) ? 1.0 / fmax(change, 1e-3) : 1e-2;
        value = fmin(value * fmax(factor, 1e-4), most);
    }
    for (int i = 0; i < site->n; i++) {
        p->step[site->first + i] = value;
    }
    free(room);
}

/* ---- a fit without a law ---- */

void diag__curve_hold(diag__curves *w, int all_move)
{
    for (int i = 0; i < w->nsite; i++) {
        for (int k = 0; k < w->site[i].n; k++) {
            w->p.unknown[w->site[i].first + k].idle = !all_move || k < w->site[i].pinned;
        }
    }
}

stein_status diag__curve_derive(fit__problem *p, int first, int end, const double *x,
                                const double *r, double *J, stein_err *err)
{
    stein_status status = fit__sensitivities(p, x, r, J, err);
    for (int n = 0; status != STEIN_OK && status != STEIN_ENOMEM && n < SHORTER; n++) {
        for (int k = first; k < end; k++) {
            p->step[k] *= shorter;
        }
        status = fit__sensitivities(p, x, r, J, err);
    }
    return status;
}

stein_status diag__stand(diag__curves *w, double gain, stein_err *err)
{
    fit__end e = {.x = w->x, .J = w->J, .r = w->r};
    sizing z = {w, w->p.nstroke / 2};
    take_start(w);
    diag__curve_hold(w, 0);
    w->p.gain = gain;
    stein_status status = fit__descend(&w->p, &e, 0, diag__fit_ends, RENEWALS, err);
    w->objective = e.objective;
    return status == STEIN_OK ? fit__parallel(&w->p, w->nsite, one_size, &z, err) : status;
}

stein_status diag__stand_derive(diag__curves *w, stein_err *err)
{
    diag__curve_hold(w, 1);
    return diag__curve_derive(&w->p, w->site[0].first, w->p.amount, w->x, w->r, w->J, err);
}
