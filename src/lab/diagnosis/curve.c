/* SPDX-License-Identifier: GPL-3.0-or-later
 * curve.c - an effect that is in no table: which law, of what, and where.
 *
 * sites    every joint over its position and its speed, every contact over its depth and its rate,
 *          where the strokes go (curve_site.c)
 *
 * model    the mechanism with a table of zeros at each of them: one more compilation, none a site
 *
 * scores   marginal likelihood of every curve to first order where the strokes first show that
 *          something is missing, and at the null fit (curve_stand.c)
 *
 * fits     the best ones in full, everything else refitted: along the strokes (curve_outline.c,
 *          curve_follow.c), and where that leaves clearly more than noise from the null fit
 *          (curve_fit.c);
 *          once more with the points where the strokes go then, if that is elsewhere
 *
 * judge    the best of those by marginal likelihood, on the held-out strokes (curve_judge.c)
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "curve.h"

enum { FITTED = 4, RECALLS = 3, NAME = 2 * MECH_NAME };
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
    for (int i = 0; status == STEIN_OK && i < 2 * w->nsite; i++) {
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
    size_t most = (size_t)d->nname + 2 * (size_t)w->nsite * CURVE_POINTS;
    int n = 0;
    w->name = malloc(sizeof *w->name * (most + 1));
    w->names = malloc(NAME * (most + 1));
    if (w->name == NULL || w->names == NULL) {
        return lab__no_memory(err);
    }
    for (; n < d->nname; n++) {
        w->name[n] = d->name[n];
    }
    for (int i = 0; i < 2 * w->nsite; i++) {
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
    w->p.tolerance = diag__tolerance; // its valley is narrow
    return status;
}

/* single strokes that the best fits have lost are called back */
static stein_status recall(diag *d, diag__curves *w, diag__curve *c, int n, stein_err *err)
{
    stein_status status = STEIN_OK;
    int found;
    double best = n > 0 ? c[0].gain : 0.0;
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        int on = c[i].fitted && c[i].gain > worth_it * best;
        for (int k = 0; k < RECALLS && status == STEIN_OK && on; k++) {
            on = diag__is_off(d, diag__curve_chi2_dof(d, w, &c[i]));
            status = on ? diag__curve_recall(d, w, &c[i], INFINITY, 1, &found, &on, err) : status;
        }
    }
    diag__curve_sort(c, n);
    return status;
}

/* those whose outlines explain how the strokes begin, where there is such a place
 * @param c  [OUTLINES]; n out */
static stein_status fit_early(diag *d, diag__curves *w, diag__curve *c, int *n, stein_err *err)
{
    *n = 0;
    if (w->early.x == NULL) {
        return STEIN_OK;
    }
    stein_status status = diag__curve_scores(w, &w->early, w->curve, err);
    if (status == STEIN_OK) {
        diag__curve_sort(w->curve, w->nsite);
        status = diag__curve_outlines(d, w, w->curve, w->nsite, c, n, err);
    }
    if (status == STEIN_OK) {
        diag__curve_sort(c, *n);
        status = recall(d, w, c, *n, err);
    }
    return status;
}

/* the best curves by first order at the null fit, in full. @param n  out */
static stein_status fit_late(diag *d, diag__curves *w, int *n, stein_err *err)
{
    diag__curve *c = w->curve;
    stein_status status = diag__stand_derived(w, err);
    status = status == STEIN_OK ? diag__curve_scores(w, &w->null, c, err) : status;
    diag__curve_sort(c, w->nsite);
    double best = c[0].gain;
    *n = 0;
    while (status == STEIN_OK && *n < FITTED && *n < w->nsite &&
           (*n < 2 || c[*n].gain > near * best)) {
        status = diag__curve_fit(w, &c[*n], err);
        d->out->fits++;
        ++*n;
    }
    diag__curve_sort(c, *n);
    if (status == STEIN_OK && !(diag__curve_chi2_dof(d, w, &c[0]) < w->bound)) {
        *n = 0;
    }
    return status == STEIN_OK ? recall(d, w, c, *n, err) : status;
}

/* a fit among those of w->curve, in the place of a worse one of the same curve */
static void put(diag__curves *w, diag__curve *fit, int *n)
{
    diag__curve *c = w->curve;
    int i = 0;
    while (c[i].site != fit->site) {
        i++;
    }
    if (i < *n && c[i].fitted && !(c[i].gain < fit->gain)) {
        free(fit->x);
        return;
    }
    free(c[i].x);
    if (i >= *n) {
        c[i] = c[*n];
        i = (*n)++;
    }
    c[i] = *fit;
}

/* The best curves: along the strokes, and where that leaves more than noise from the null fit, too,
 * unless it is in haste. @param n  out: 0 when none stays below the bound */
static stein_status fit_best(diag *d, diag__curves *w, int *n, stein_err *err)
{
    diag__curve early[OUTLINES];
    int nearly = 0;
    for (int i = 0; i < w->nsite; i++) {
        free(w->curve[i].x);
        w->curve[i] = (diag__curve){.site = &w->site[i], .gain = -(double)INFINITY, .held = NAN};
    }
    *n = 0;
    stein_status status = fit_early(d, w, early, &nearly, err);
    int is_near = nearly > 0 && diag__curve_nearly(d, w, &early[0]);
    if (status == STEIN_OK && !is_near && !(diag__in_haste(w) && w->early.x != NULL)) {
        stein_status late = fit_late(d, w, n, err);
        status = nearly > 0 ? fit__forgive(late, err) : late;
    }
    for (int i = 0; i < nearly; i++) {
        put(w, &early[i], n);
    }
    diag__curve_sort(w->curve, *n);
    if (*n > 0 && !(diag__curve_chi2_dof(d, w, &w->curve[0]) < w->bound)) {
        *n = 0;
    }
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
        free(w->null.x);
        free(w->early.x);
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
    w->bound = bound;
    if (status == STEIN_OK && w->nsite > 0) {
        w->curve = calloc((size_t)w->nsite + 1, sizeof *w->curve);
        status = w->curve != NULL ? open_model(d, w, err) : STEIN_ENOMEM;
        status = status == STEIN_OK ? diag__stand_null(d, w, err) : status;
        status = status == STEIN_OK ? diag__stand_early(d, w, err) : status;
        status = status == STEIN_OK ? fit_best(d, w, n, err) : status;
    }
    return status;
}

/* the same search once more, at another price */
static stein_status search_on(diag *d, double bound, int *n, stein_err *err)
{
    d->curves->bound = bound;
    *n = 0;
    return d->curves->nsite > 0 ? fit_best(d, d->curves, n, err) : STEIN_OK;
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
    stein_status status =
        d->curves == NULL ? search(d, &d->p, d->x, bound, &n, &why) : search_on(d, bound, &n, &why);
    if (status == STEIN_OK && n == 0 && isfinite(bound)) {
        d->laws_tried = 0; // it may be asked for again, at any price
    }
    if (status == STEIN_OK && is_misplaced(d, n, &status, &why)) {
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
