/* SPDX-License-Identifier: GPL-3.0-or-later
 * curve.c - an effect that is in no table: which law, of what, and where.
 *
 * sites    every joint over its position and its speed, every contact over its depth and its rate,
 *          where the strokes go (curve_site.c)
 *
 * model    the mechanism with a table of zeros at each of them: one more compilation, none a site
 *
 * scores   marginal likelihood of every curve to first order at the null fit
 *
 * fits     the best ones in full, everything else refitted (curve_fit.c); once more with the points
 *          where the strokes go then, if that is elsewhere
 *
 * judge    the best of those by marginal likelihood, on the held-out strokes (curve_judge.c)
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "curve.h"

enum { FITTED = 4, BEGUN_ANEW = 2, RECALLS = 3, ROUNDS = 2, RENEWALS = 4, NAME = 2 * MECH_NAME };
static const double enough = 0.3;    /* of the objective */
static const double believed = 3.0;  /* of a stroke's own number, in sd */
static const double far = 1.3;       /* chi2/dof from which on a fit begins anew */
static const double elsewhere = 0.1; /* share of the range by which an end is misplaced */
static const double worth_it = 0.75; /* share of the best gain from which on a fit goes on */
static const double near = 0.25; /* share of the best linear gain from which on a curve is fitted */

/* ---- the mechanism with all tables ---- */

static stein_status make_text(const diag *d, const diag__curves *w, char **text, size_t *size,
                              stein_err *err)
{
    const stein_model *m = lab_equations(d->model);
    char *old = NULL;
    size_t nold = 0;
    lab__surgery *s = NULL;
    double zero[CURVE_POINTS] = {0.0};
    stein_status status = lab__read_file(d->file, &old, &nold, err);
    status = status == STEIN_OK ? lab__surgery_begin(&s, old, nold, err) : status;
    for (int i = 0; status == STEIN_OK && i < w->nsite; i++) {
        const diag__site *o = &w->site[i];
        status = lab__table_add(s, o->table, diag__site_word(o->kind, m, o->index), o->place,
                                diag__site_of(o->kind), diag__site_what(o), o->n, o->at, zero, NULL,
                                err);
    }
    status = status == STEIN_OK ? lab__surgery_text(s, text, size, err) : status;
    lab__surgery_end(s);
    free(old);
    return status;
}

/* free: the null fit's numbers, then all values of all tables in their order */
static stein_status make_names(const diag *d, diag__curves *w, stein_err *err)
{
    size_t most = (size_t)d->nname + (size_t)w->nsite * CURVE_POINTS;
    int n = 0;
    w->name = malloc(sizeof *w->name * (most + 1));
    w->names = malloc(NAME * (most + 1));
    if (w->name == NULL || w->names == NULL) {
        return lab__no_memory(err);
    }
    for (; n < d->nname; n++) {
        w->name[n] = d->name[n];
    }
    for (int i = 0; i < w->nsite; i++) {
        diag__site *s = &w->site[i];
        s->first = n;
        for (int k = 0; k < s->n; k++) {
            char *to = w->names + (size_t)n * NAME;
            snprintf(to, NAME, "%s.%s.%d", s->table, diag__site_what(s), k + 1);
            w->name[n++] = to;
        }
    }
    w->def = d->fit_def;
    w->def.free = w->name;
    w->def.nfree = n;
    return STEIN_OK;
}

/* where the null fit stands, in the new problem */
static stein_status take_null(const diag *d, diag__curves *w, stein_err *err)
{
    fit__problem *p = &w->p;
    size_t nu = (size_t)p->nu, rows = fit__offset(p, p->nstroke);
    w->x = calloc(nu + rows + 1, sizeof *w->x);
    w->J = malloc(sizeof *w->J * (fit__columns(p) + 1));
    if (w->x == NULL || w->J == NULL) {
        return lab__no_memory(err);
    }
    w->r = w->x + nu;
    memcpy(w->x, d->x, sizeof *w->x * (size_t)d->nname);
    for (int k = 0; k < d->nname; k++) {
        p->step[k] = d->p.step[k];
    }
    for (int k = 0; k < p->nu - p->np; k++) {
        fit__unknown *u = &p->unknown[p->np + k];
        double was = u->sd;
        u->sd *=
            u->kind == FIT__SCATTER ? sqrt(fmax(d->null_D[u->index - FIT__JOINTS], 1e-6)) : 1.0;
        double x = d->x[d->p.np + k] * was / u->sd;
        w->x[p->np + k] = u->kind == FIT__SCATTER ? fmin(fmax(x, -believed), believed) : x;
        p->step[p->np + k] = d->p.step[d->p.np + k] * was / u->sd;
    }
    for (int i = 0; i < w->nsite; i++) {
        for (int k = 0; k < w->site[i].n; k++) {
            fit__unknown *u = &p->unknown[w->site[i].first + k];
            u->prior = u->log = 0;
            u->start = 0.0;
            u->sd = 1.0;
        }
    }
    return STEIN_OK;
}

static stein_status open_model(const diag *d, diag__curves *w, stein_err *err)
{
    char *text = NULL;
    size_t size = 0;
    stein_status status = make_text(d, w, &text, &size, err);
    if (status == STEIN_OK) {
        status = lab__open_text(&w->model, d->file, text, size, d->def->options, err);
    }
    free(text);
    status =
        status == STEIN_OK ? diag__read_again(d->fit_data, w->model, &w->fit_data, err) : status;
    status =
        status == STEIN_OK ? diag__read_again(d->held_data, w->model, &w->held_data, err) : status;
    status = status == STEIN_OK ? make_names(d, w, err) : status;
    status = status == STEIN_OK ? fit__problem_make_open(&w->p, w->model, w->fit_data, &w->def, err)
                                : status;
    if (status == STEIN_OK && w->p.nu - w->p.np != d->p.nu - d->p.np) {
        status = lab__fail(err, STEIN_EINVAL, "tables make other strokes of the data");
    }
    w->p.tolerance = d->p.tolerance;
    return status == STEIN_OK ? take_null(d, w, err) : status;
}

/* ---- derivatives at the null fit ---- */

/* a value that changes the strokes by about a third of the noise, to begin with: by one stroke */
typedef struct sizing {
    diag__curves *w;
    int stroke;
} sizing;

static void one_size(void *ctx, fit__bench *b, int job)
{
    enum { TRIES = 8 };
    sizing *z = ctx;
    fit__problem *p = &z->w->p;
    const diag__site *site = &z->w->site[job];
    const fit__stroke *s = &p->stroke[z->stroke];
    size_t n = (size_t)(s->nch * s->n);
    double *x = malloc(sizeof *x * ((size_t)p->nu + n + 1)), value = 1e-4;
    for (int k = 0; x != NULL && k < TRIES; k++) {
        double *y = x + p->nu, sum = 0.0;
        memcpy(x, z->w->x, sizeof *x * (size_t)p->nu);
        for (int i = site->pinned; i < site->n; i++) {
            x[site->first + i] = value;
        }
        int bad = fit__simulate(p, b, z->stroke, x, y, NULL) != STEIN_OK;
        fit__weigh(s, y);
        for (size_t i = 0; !bad && i < n; i++) {
            double change = y[i] - z->w->r[fit__offset(p, z->stroke) + i];
            sum += change * change;
        }
        double moved = bad ? (double)INFINITY : sqrt(sum / fmax(1.0, s->samples));
        if (moved > 0.3 && moved < 3.0) {
            break;
        }
        double factor = isfinite(moved) ? 1.0 / fmax(moved, 1e-3) : 1e-2;
        value = fmin(value * fmax(factor, 1e-4), 1e6);
    }
    for (int i = 0; i < site->n; i++) {
        p->step[site->first + i] = value;
    }
    free(x);
}

/* all values of curves stay, or but those at the pins do */
static void hold_curves(diag__curves *w, int all)
{
    for (int i = 0; i < w->nsite; i++) {
        for (int k = 0; k < w->site[i].n; k++) {
            w->p.unknown[w->site[i].first + k].idle = all || k < w->site[i].pinned;
        }
    }
}

/* The null fit with the variances that it has found: a stroke's own number that is beyond them
 * would be a gain of any curve. */
static stein_status look(diag__curves *w, stein_err *err)
{
    fit__end e = {.x = w->x, .J = w->J, .r = w->r};
    hold_curves(w, 1);
    stein_status status = fit__descend(&w->p, &e, 0, enough, RENEWALS, err);
    hold_curves(w, 0);
    w->objective = e.objective;
    sizing z = {w, w->p.nstroke / 2};
    status = status == STEIN_OK ? fit__parallel(&w->p, w->nsite, one_size, &z, err) : status;
    return status == STEIN_OK ? fit__sensitivities(&w->p, w->x, w->r, w->J, err) : status;
}

/* does one of them describe the data? */
static int is_near(const diag__curves *w, const diag__curve *c, int n)
{
    double dof = fmax(1.0, w->p.samples - w->p.nu);
    for (int i = 0; i < n; i++) {
        if (c[i].fitted && fit__chi2(&w->p, c[i].r) < far * dof) {
            return 1;
        }
    }
    return 0;
}

/* the best curves by first order, in full
 * @param bound  chi2/dof that one of them has to stay below before the slow fits are made; out n: 0
 *               when none does */
static stein_status fit_best(diag *d, diag__curves *w, double bound, int *n, stein_err *err)
{
    diag__curve *c = w->curve;
    diag__curve_sort(c, w->nsite);
    stein_status status = STEIN_OK;
    double best = c[0].gain;
    *n = 0;
    while (status == STEIN_OK && *n < FITTED && *n < w->nsite &&
           (*n < 2 || c[*n].gain > near * best)) {
        status = diag__curve_fit(w, &c[*n], err);
        d->out->fits++;
        ++*n;
    }
    diag__curve_sort(c, *n);
    if (status == STEIN_OK && !(diag__curve_chi2_dof(d, w, &c[0]) < bound)) {
        *n = 0;
    }
    best = c[0].gain;
    for (int i = 0; status == STEIN_OK && i < *n && i < BEGUN_ANEW && !is_near(w, c, *n); i++) {
        status = diag__curve_anew(w, &c[i], err);
    }
    for (int i = 0; status == STEIN_OK && i < *n; i++) {
        int on = c[i].fitted && c[i].gain > worth_it * best;
        for (int k = 0; k < RECALLS && status == STEIN_OK && on; k++) {
            on = diag__is_off(d, diag__curve_chi2_dof(d, w, &c[i]));
            status = on ? diag__curve_recall(d, w, &c[i], &on, err) : status;
        }
    }
    diag__curve_sort(c, *n);
    return status;
}

/* all that the search for a law in these places owns */
static void close_curves(diag *d)
{
    diag__curves *w = d->curves;
    for (int i = 0; w != NULL && w->curve != NULL && i < w->nsite; i++) {
        free(w->curve[i].x);
    }
    if (w != NULL) {
        free(w->curve);
        fit__problem_free(&w->p);
        lab_dataset_close(w->fit_data);
        lab_dataset_close(w->held_data);
        lab_close(w->model);
        free(w->site);
        free(w->name);
        free(w->names);
        free(w->x);
        free(w->J);
        diag__held_free(&w->held);
        free(w);
    }
    d->curves = NULL;
}

/* the best curves with their points where the strokes go in a fit: p, x. @param n  fitted, out */
static stein_status search(diag *d, const fit__problem *p, const double *x, double bound, int *n,
                           stein_err *err)
{
    diag__curves *w = calloc(1, sizeof *w);
    *n = 0;
    if (w == NULL) {
        return lab__no_memory(err);
    }
    stein_status status = diag__sites(d, p, x, &w->site, &w->nsite, err);
    close_curves(d); // p and x may be those of an earlier search
    d->curves = w;
    if (status == STEIN_OK && w->nsite > 0) {
        w->curve = calloc((size_t)w->nsite + 1, sizeof *w->curve);
        status = w->curve != NULL ? open_model(d, w, err) : STEIN_ENOMEM;
        status = status == STEIN_OK ? look(w, err) : status;
        status = status == STEIN_OK ? diag__curve_scores(w, w->curve, err) : status;
        status = status == STEIN_OK ? fit_best(d, w, bound, n, err) : status;
    }
    return status;
}

/* Do the strokes go elsewhere with the best law than without it? Then its points stand where
 * nothing was seen. */
static int is_misplaced(const diag *d, int n, stein_status *status, stein_err *err)
{
    diag__curves *w = d->curves;
    diag__site *now = NULL;
    int nnow = 0, off = 0;
    if (n < 1 || !w->curve[0].fitted || !(w->curve[0].gain > diag__least_gain)) {
        return 0;
    }
    const diag__site *was = w->curve[0].site;
    *status = diag__sites(d, &w->p, w->curve[0].x, &now, &nnow, err);
    for (int i = 0; *status == STEIN_OK && i < nnow; i++) {
        if (now[i].kind == was->kind && now[i].index == was->index) {
            double range = now[i].at[now[i].n - 1] - now[i].at[0];
            off |= fabs(now[i].at[0] - was->at[0]) > elsewhere * range ||
                   fabs(now[i].at[now[i].n - 1] - was->at[was->n - 1]) > elsewhere * range;
        }
    }
    free(now);
    return off;
}

stein_status diag__try_laws(diag *d, const diag__held *before, double bound, stein_err *err)
{
    stein_err why = {STEIN_OK, ""};
    int n = 0;
    if (d->laws_tried) {
        return STEIN_OK;
    }
    d->laws_tried = 1;
    stein_status status = search(d, &d->p, d->x, bound, &n, &why);
    if (status == STEIN_OK && n == 0) {
        d->laws_tried = 0; // it may be asked for again, at any price
        close_curves(d);
    }
    for (int i = 0; i < ROUNDS && status == STEIN_OK && is_misplaced(d, n, &status, &why); i++) {
        status = search(d, &d->curves->p, d->curves->curve[0].x, INFINITY, &n, &why);
    }
    status = status == STEIN_OK && n > 0 ? diag__curve_judge(d, d->curves, n, before->rmse, &why)
                                         : status;
    if (status == STEIN_ENOMEM) {
        return lab__no_memory(err);
    }
    if (status != STEIN_OK && d->def->report != NULL) { // a verdict stands without a law
        d->def->report(d->def->ctx, why.msg);
    }
    return STEIN_OK;
}

stein_status diag__unknown_law(diag *d, const diag__held *before, diag__found *f, stein_err *err)
{
    stein_status status = diag__try_laws(d, before, INFINITY, err);
    return status == STEIN_OK && d->curves != NULL
               ? diag__curve_conclude(d, d->curves, before->rmse, f, err)
               : status;
}

const double *diag__law_residuals(const diag *d)
{
    return d->out->nlaw > 0 && d->out->law[0].pays ? d->curves->curve[0].r : NULL;
}

void diag__law_free(diag *d)
{
    close_curves(d);
}
