/* SPDX-License-Identifier: GPL-3.0-or-later
 * curve.c - a law that is in no table: its place, its variable, its curve.
 *
 * sites    every joint over its position and its speed, every contact over its depth and its rate,
 *          where the records go (curve_site.c)
 * model    the mechanism with a table of zeros at each of them: one more compilation, none a site
 * scores   marginal likelihood of every curve to first order where an observer holds the model
 *          without a law near the records (curve_baseline.c): there the residual is linear in what
 * is missing even where that is gross fits     the best ones in full, everything else refitted,
 * held first, then free (curve_fit.c) judge    by marginal likelihood and by the residual
 * (curve_judge.c)
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "curve.h"

enum { FITTED = sizeof((diag__laws *)0)->curve / sizeof(diag__curve), NAME = 2 * MECH_NAME };

/* ---- the mechanism with all tables ---- */

static stein_status make_text(const diag__problem *q, const diag__tables *t, char **text,
                              size_t *size, stein_err *err)
{
    const stein_model *m = lab_equations(q->model);
    char *old = NULL;
    size_t nold = 0;
    lab__yaml_edit *s = NULL;
    double zero[CURVE_POINTS] = {0.0};
    stein_status status = lab__read_file(q->file, &old, &nold, err);
    status = status == STEIN_OK ? lab__yaml_edit_begin(&s, old, nold, err) : status;
    for (int i = 0; status == STEIN_OK && i < t->nsite; i++) {
        const diag__site *o = &t->site[i];
        status = lab__table_add(s, o->table, diag__site_word(o->kind, m, o->index), o->place,
                                diag__site_of(o->kind), diag__site_what(o), o->n, o->at, zero, NULL,
                                err);
    }
    status = status == STEIN_OK ? lab__yaml_edit_text(s, text, size, err) : status;
    lab__yaml_edit_end(s);
    free(old);
    return status;
}

/* free: the null hypothesis's numbers, then all values of all tables in their order */
static stein_status make_names(const diag__problem *q, diag__tables *t, stein_err *err)
{
    size_t most = (size_t)q->nname + (size_t)t->nsite * CURVE_POINTS;
    int n = 0;
    t->name = malloc(sizeof *t->name * (most + 1));
    t->names = malloc(NAME * (most + 1));
    t->name_sd = calloc(most + 1, sizeof *t->name_sd);
    if (t->name == NULL || t->names == NULL || t->name_sd == NULL) {
        return lab__no_memory(err);
    }
    for (; n < q->nname; n++) {
        t->name[n] = q->name[n];
        t->name_sd[n] = q->name_sd[n];
    }
    for (int i = 0; i < t->nsite; i++) {
        diag__site *s = &t->site[i];
        s->first = n;
        for (int k = 0; k < s->n; k++) {
            char *to = t->names + (size_t)n * NAME;
            snprintf(to, NAME, "%s.%s.%d", s->table, diag__site_what(s), k + 1);
            t->name[n++] = to;
        }
    }
    t->def = q->fit_def;
    t->def.free = t->name;
    t->def.nfree = n;
    t->def.tolerance = t->name_sd;
    return STEIN_OK;
}

static stein_status make_tables(diag__problem *q, const diag__row *null, diag__tables *t,
                                stein_err *err)
{
    char *text = NULL;
    size_t size = 0;
    stein_status status = diag__sites(&null->p, null->x, &t->site, &t->nsite, err);
    if (status != STEIN_OK || t->nsite == 0) {
        return status;
    }
    status = make_text(q, t, &text, &size, err);
    if (status == STEIN_OK) {
        status = lab__open_text(&t->model, q->file, text, size, q->def->options, err);
    }
    free(text);
    return status == STEIN_OK ? make_names(q, t, err) : status;
}

stein_status diag__curves_open(diag__curves *w, const diag__tables *in, diag__problem *q,
                               const diag__row *null, const lab_dataset *records, stein_err *err)
{
    *w = (diag__curves){.q = q, .null = null, .in = in, .site = in->site, .nsite = in->nsite};
    stein_status status = diag__read_again(records, in->model, &w->records, err);
    status = status == STEIN_OK
                 ? fit__problem_make_open(&w->p, in->model, w->records, &in->def, err)
                 : status;
    if (status != STEIN_OK) {
        return status;
    }
    w->p.tolerance = q->null.tolerance;
    w->p.stride = q->null.stride;
    w->p.simulated = &q->strokes;
    size_t rows = fit__offset(&w->p, w->p.nstroke);
    w->x = calloc((size_t)w->p.nu + rows + fit__columns(&w->p) + 1, sizeof *w->x);
    w->r = w->x != NULL ? w->x + w->p.nu : NULL;
    w->J = w->x != NULL ? w->r + rows : NULL;
    return w->x != NULL ? STEIN_OK : lab__no_memory(err);
}

void diag__curves_close(diag__curves *w)
{
    fit__problem_free(&w->p);
    lab_dataset_close(w->records);
    free(w->x);
}

/* ---- the best curves ---- */

/* scores of all curves, from a few records. @param c  [nsite] out, the best first */
static stein_status score(diag__laws *l, diag__problem *q, const diag__row *null, diag__curve *c,
                          stein_err *err)
{
    lab_dataset some = {0, malloc(sizeof(lab_data *) * DIAG_FEW_RECORDS)};
    diag__curves w = {.p = {.nstroke = 0}};
    const lab_dataset *all = null->in->fitted;
    if (some.stroke == NULL) {
        return lab__no_memory(err);
    }
    some.n = all->n < DIAG_FEW_RECORDS ? all->n : DIAG_FEW_RECORDS;
    for (int k = 0; k < some.n; k++) {
        some.stroke[k] = all->stroke[(2 * k + 1) * all->n / (2 * some.n)];
    }
    stein_status status = diag__curves_open(&w, &l->in, q, null, &some, err);
    status = status == STEIN_OK ? diag__stand(&w, diag__rung[0], err) : status;
    status = status == STEIN_OK ? diag__stand_derive(&w, err) : status;
    status = status == STEIN_OK ? diag__curve_scores(&w, c, err) : status;
    diag__curve_sort(c, status == STEIN_OK ? w.nsite : 0);
    diag__curves_close(&w);
    free(some.stroke);
    return status;
}

static stein_status fit_best(diag__laws *l, diag__curve *c, stein_err *err)
{
    double best = c[0].gain;
    stein_status status = diag__stand(&l->all, diag__rung[0], err);
    for (int i = 0; status == STEIN_OK && i < l->in.nsite && l->n < FITTED; i++) {
        if (i > 0 && !(c[i].gain > diag__some_of * best)) {
            break;
        }
        l->curve[l->n] = c[i];
        status = diag__curve_fit(&l->all, &l->curve[l->n], err);
        l->n++;
        if (status == STEIN_OK && l->curve[l->n - 1].fitted && fit__noise_given(&l->all.p) &&
            diag__curve_chi2_dof(&l->all, &l->curve[l->n - 1]) < diag__near_noise) {
            break;
        }
    }
    diag__curve_sort(l->curve, l->n);
    return status;
}

stein_status diag__laws_find(diag__problem *q, const diag__row *null, diag__laws *l, stein_err *err)
{
    stein_err why = {STEIN_OK, ""};
    diag__curve *c = NULL;
    *l = (diag__laws){.n = 0};
    stein_status status = make_tables(q, null, &l->in, &why);
    if (status == STEIN_OK && l->in.nsite > 0) {
        c = calloc((size_t)l->in.nsite + 1, sizeof *c);
        status = c != NULL ? score(l, q, null, c, &why) : STEIN_ENOMEM;
        status = status == STEIN_OK
                     ? diag__curves_open(&l->all, &l->in, q, null, null->in->fitted, &why)
                     : status;
        status = status == STEIN_OK ? fit_best(l, c, &why) : status;
    }
    free(c);
    if (status != STEIN_OK && status != STEIN_ENOMEM && q->def->report != NULL) {
        q->def->report(q->def->ctx, why.msg); // a verdict stands without a law
    }
    return fit__forgive(status, err);
}

void diag__laws_free(diag__laws *l)
{
    for (int i = 0; i < l->n; i++) {
        free(l->curve[i].x);
    }
    diag__curves_close(&l->all);
    lab_close(l->in.model);
    free(l->in.site);
    free(l->in.name);
    free(l->in.names);
    free(l->in.name_sd);
}
