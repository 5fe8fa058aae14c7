/* SPDX-License-Identifier: GPL-3.0-or-later
 * curve_stand.c - where curves begin: fits without a law, and what curves would change there.
 *
 * null    of all samples. What is missing has bent it: strokes that escape at a wrong moment cannot
 *         be explained, so their own numbers and the parameters make up for it.
 *
 * early   up to where the strokes first show that something is missing. Before that nothing can be
 *         told, and little behind it is bent yet: what the residual looks like there is the law.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "curve.h"

enum { RENEWALS = 4, DESCENTS = 4, SHORTER = 3, SIZES = 8 };
static const double enough = 0.3;   /* of the objective */
static const double believed = 3.0; /* of a stroke's own number, in sd */
static const double shorter = 0.1;  /* differences where a stroke cannot be simulated */
static const double loose = 100.0;  /* prior sd of an outline, in values that are about noise */
static const double larger = 30.0;  /* most of such a value early, in that of whole strokes */
static const double little = 1.0;   /* gain of a descent */
static const double first_look = 0.15, next_look = 0.05; /* of the longest stroke */
static const double shortest_look = 0.02, nearer = 0.7;

static stein_status make_stand(const fit__problem *p, diag__stand *s, stein_err *err)
{
    size_t nu = (size_t)p->nu, rows = fit__offset(p, p->nstroke);
    s->horizon = INFINITY;
    s->x = calloc(nu + rows + fit__columns(p) + 1, sizeof *s->x);
    s->r = s->x != NULL ? s->x + nu : NULL;
    s->J = s->x != NULL ? s->r + rows : NULL;
    return s->x != NULL ? STEIN_OK : lab__no_memory(err);
}

/* Strokes' own numbers count in the variances that the null fit has found: one that is beyond them
 * would be a gain of any curve. Curves have no prior here, outlines have a loose one. */
static void take_priors(const diag *d, diag__curves *w)
{
    fit__problem *p = &w->p;
    double *to = w->null.x;
    memcpy(to, d->x, sizeof *to * (size_t)d->nname);
    for (int i = 0; i < LAB_SCATTERS; i++) {
        w->D[i] = fmax(d->null_D[i], 1e-6);
    }
    for (int k = 0; k < d->nname; k++) {
        p->step[k] = d->p.step[k];
    }
    for (int k = 0; k < p->nu - p->np; k++) {
        fit__unknown *u = &p->unknown[p->np + k];
        double was = u->sd;
        u->sd *= u->kind == FIT__SCATTER ? sqrt(w->D[u->index - FIT__JOINTS]) : 1.0;
        double x = d->x[d->p.np + k] * was / u->sd;
        to[p->np + k] = u->kind == FIT__SCATTER ? fmin(fmax(x, -believed), believed) : x;
        p->step[p->np + k] = d->p.step[d->p.np + k] * was / u->sd;
    }
    for (int i = 0; i < 2 * w->nsite; i++) {
        for (int k = 0; k < w->site[i].n; k++) {
            fit__unknown *u = &p->unknown[w->site[i].first + k];
            u->prior = i >= w->nsite;
            u->log = 0;
            u->start = 0.0;
            u->sd = 1.0;
        }
    }
}

/* ---- how large a value is ---- */

typedef struct sizing {
    diag__curves *w;
    const diag__stand *at;
    int stroke;
} sizing;

/* RMS change of a stroke with all values of a curve at one, in noise; INFINITY: it cannot be
 * simulated. @param x  room, [nu + rows] */
static double moved(const sizing *z, fit__bench *b, const diag__site *site, double value, double *x)
{
    const fit__problem *p = &z->w->p;
    const fit__stroke *s = &p->stroke[z->stroke];
    const double *r = z->at->r + fit__offset(p, z->stroke);
    double *y = x + p->nu, sum = 0.0;
    memcpy(x, z->at->x, sizeof *x * (size_t)p->nu);
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

/* a value that changes the strokes by about the noise, to begin with: by one stroke */
static void one_size(void *ctx, fit__bench *b, int job)
{
    sizing *z = ctx;
    fit__problem *p = &z->w->p;
    const diag__site *site = &z->w->site[job], *outline = site + z->w->nsite;
    int early = z->at == &z->w->early;
    double value = early ? p->step[site->first] : 1e-4, most = early ? larger * value : 1e6;
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
    for (int i = 0; i < outline->n; i++) {
        fit__unknown *u = &p->unknown[outline->first + i];
        u->sd = early ? u->sd : loose * value;
        p->step[outline->first + i] = value / u->sd;
    }
    free(room);
}

/* ---- a fit without a law ---- */

void diag__curve_hold(diag__curves *w, diag__moving which)
{
    for (int i = 0; i < 2 * w->nsite; i++) {
        diag__moving are = i < w->nsite ? DIAG_CURVES : DIAG_OUTLINES;
        for (int k = 0; k < w->site[i].n; k++) {
            w->p.unknown[w->site[i].first + k].idle = are != which || k < w->site[i].pinned;
        }
    }
}

static stein_status descend(diag__curves *w, diag__stand *s, stein_err *err)
{
    fit__end e = {.x = s->x, .J = s->J, .r = s->r};
    diag__curve_hold(w, DIAG_NONE);
    w->p.horizon = s->horizon;
    stein_status status = fit__descend(&w->p, &e, 0, enough, RENEWALS, err);
    w->p.horizon = INFINITY;
    diag__curve_hold(w, DIAG_CURVES);
    s->objective = e.objective;
    return status;
}

static stein_status size(diag__curves *w, const diag__stand *s, stein_err *err)
{
    sizing z = {w, s, w->p.nstroke / 2};
    w->p.horizon = s->horizon;
    stein_status status = fit__parallel(&w->p, w->nsite, one_size, &z, err);
    w->p.horizon = INFINITY;
    return status;
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

/* J by all curves, too, or by their outlines */
static stein_status derive(diag__curves *w, diag__stand *s, diag__moving which, stein_err *err)
{
    fit__problem *p = &w->p;
    diag__curve_hold(w, which);
    p->horizon = s->horizon;
    stein_status status = diag__curve_derive(p, w->site[0].first, p->amount, s->x, s->r, s->J, err);
    p->horizon = INFINITY;
    return status;
}

stein_status diag__stand_null(const diag *d, diag__curves *w, stein_err *err)
{
    stein_status status = make_stand(&w->p, &w->null, err);
    if (status == STEIN_OK) {
        take_priors(d, w);
        status = descend(w, &w->null, err);
    }
    return status == STEIN_OK ? size(w, &w->null, err) : status;
}

stein_status diag__stand_derived(diag__curves *w, stein_err *err)
{
    stein_status status = size(w, &w->null, err);
    return status == STEIN_OK ? derive(w, &w->null, DIAG_CURVES, err) : status;
}

/* does the fit clearly leave more than noise up to its horizon? */
static int is_seen(const diag *d, diag__curves *w, const diag__stand *s)
{
    w->p.horizon = s->horizon;
    double dof = fmax(1.0, diag__samples(&w->p) - d->p.nu), chi2 = fit__chi2(&w->p, s->r);
    w->p.horizon = INFINITY;
    return diag__is_clear(chi2, dof);
}

/* Up to its horizon; where that leaves more than noise, until it goes no lower. @return does it? */
static int look(const diag *d, diag__curves *w, diag__stand *s, stein_status *status,
                stein_err *err)
{
    double was = INFINITY;
    int seen = 1;
    s->objective = INFINITY;
    for (int k = 0; k < DESCENTS && *status == STEIN_OK && seen && !(s->objective > was - little);
         k++) {
        was = s->objective;
        *status = descend(w, s, err);
        seen = *status == STEIN_OK && is_seen(d, w, s);
    }
    return seen;
}

/* share of the strokes that is known to leave no more than noise (early.c), and a first one */
static double first_share(const diag *d)
{
    double T = diag__longest(&d->p), share = first_look;
    for (int h = 0; d->early.x != NULL && d->early.z > 0.0 && h < DIAG_HORIZONS; h++) {
        share = diag__horizon[h] * T < d->early.horizon - 1e-9 ? diag__horizon[h] : share;
    }
    return share;
}

/* Where more than noise is left first: forth in strides from where there is none, and back where
 * the first look shows it. */
static int find(const diag *d, diag__curves *w, diag__stand *s, stein_status *status,
                stein_err *err)
{
    double T = diag__longest(&w->p), share = first_share(d), kept = 0.0;
    for (int seen = 0; *status == STEIN_OK && !seen && share < 1.0; share += next_look) {
        s->horizon = share * T;
        seen = look(d, w, s, status, err);
        kept = seen ? share : 0.0;
    }
    int before = kept > 0.0 && kept <= first_share(d); // was there any, then?
    for (share = kept * nearer; *status == STEIN_OK && before && share > shortest_look;
         share *= nearer) {
        s->horizon = share * T;
        before = look(d, w, s, status, err);
        kept = before ? share : kept;
    }
    s->horizon = kept * T;
    return kept > 0.0 && look(d, w, s, status, err);
}

stein_status diag__stand_early(const diag *d, diag__curves *w, stein_err *err)
{
    diag__stand *s = &w->early;
    stein_err why = {STEIN_OK, ""};
    stein_status status = make_stand(&w->p, s, err);
    int seen = status == STEIN_OK && find(d, w, s, &status, &why);
    status = seen ? size(w, s, &why) : status;
    status = seen && status == STEIN_OK ? derive(w, s, DIAG_OUTLINES, &why) : status;
    if (status != STEIN_OK || !seen) {
        free(s->x);
        s->x = NULL;
    }
    return fit__forgive(status, err);
}
