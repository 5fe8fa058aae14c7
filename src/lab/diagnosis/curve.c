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
 * judge    the best of those by marginal likelihood; it is believed when strokes that were held out
 *          are predicted better, and otherwise nothing of what was tried explains them
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "curve.h"

enum { FITTED = 4, JUDGED = 3, BEGUN_ANEW = 2, ROUNDS = 2, RENEWALS = 4, NAME = 2 * MECH_NAME };
static const double enough = 0.3;    /* of the objective */
static const double believed = 3.0;  /* of a stroke's own number, in sd */
static const double explained = 2.0; /* chi2/dof of a fit that can be trusted, as in verdict.c */
static const double far = 1.3;       /* chi2/dof from which on a fit begins anew */
static const double elsewhere = 0.1; /* share of the range by which an end is misplaced */
static const double as_well = 1.25;  /* held-out errors that are no different */
static const double less = 0.5;      /* of what is left */
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

/* ---- judging ---- */

static int by_gain(const void *a, const void *b)
{
    const diag__curve *x = a, *y = b;
    return x->gain > y->gain ? -1 : x->gain < y->gain;
}

static stein_status hold(const diag *d, const diag__curves *w, diag__curve *c, diag__held *to,
                         stein_err *err)
{
    diag other = *d;
    stein_err why = {STEIN_OK, ""};
    other.model = w->model;
    other.held_data = w->held_data;
    other.fit_def = w->def;
    other.x = c->x;
    stein_status status = diag__held_out(&other, NULL, to, &why);
    to->p.def = &w->def;
    c->held = status == STEIN_OK ? to->rmse : (double)NAN;
    return fit__forgive(status, err);
}

/* ---- results ---- */

static stein_status note(const diag *d, const diag__curves *w, const diag__curve *c, lab_law *to,
                         stein_err *err)
{
    const diag__site *s = c->site;
    size_t n = (size_t)s->n;
    *to = (lab_law){.site = diag__site_word(s->kind, lab_equations(d->model), s->index),
                    .of = diag__site_of(s->kind),
                    .what = diag__site_what(s),
                    .at_unit = diag__site_at_unit(s),
                    .unit = diag__site_unit(s),
                    .n = s->n,
                    .gain = c->gain,
                    .held_out = c->held,
                    .share = NAN,
                    .chi2_dof = fit__chi2(&w->p, c->r) / fmax(1.0, w->p.samples - d->p.nu),
                    .at = malloc(sizeof(double) * 5 * n),
                    .seen = malloc(sizeof(int) * n)};
    if (to->at == NULL || to->seen == NULL) {
        return lab__no_memory(err);
    }
    to->value = to->at + n;
    to->lo = to->value + n;
    to->hi = to->lo + n;
    to->sd = to->hi + n;
    snprintf(to->place, sizeof to->place, "%s", s->place);
    snprintf(to->table, sizeof to->table, "%s", s->table);
    for (int k = 0; k < s->n; k++) {
        to->at[k] = s->at[k];
        to->sd[k] = sqrt(fmax(0.0, c->cov[k * s->n + k]));
        double digits = to->sd[k] > 0.0 ? pow(10.0, 2.0 - floor(log10(to->sd[k]))) : 0.0;
        to->value[k] = c->x[s->first + k];
        to->value[k] = digits > 0.0 ? round(to->value[k] * digits) / digits : to->value[k];
        to->lo[k] = to->value[k] - 1.959964 * to->sd[k];
        to->hi[k] = to->value[k] + 1.959964 * to->sd[k];
        to->seen[k] = s->seen[k];
    }
    return STEIN_OK;
}

/* the refitted numbers of the file, with the law in the model */
static stein_status note_values(diag *d, const diag__curves *w, const diag__curve *c,
                                stein_err *err)
{
    lab_diagnosis *o = d->out;
    o->value = calloc((size_t)d->nname + 1, sizeof *o->value);
    if (o->value == NULL) {
        return lab__no_memory(err);
    }
    o->chi2_dof_after = o->law[0].chi2_dof;
    for (int k = 0; k < d->nname; k++) {
        diag__note_value(d, &w->p, k, c->x[k], c->sd[k], 1.0);
    }
    diag__note_scatter(d, d->null_D);
    return STEIN_OK;
}

/* predicts the held-out strokes as well as the first law, in the same place: NULL, or over what */
static const char *twin_of(const lab_diagnosis *o)
{
    const lab_law *l = &o->law[0];
    for (int i = 1; i < o->nlaw; i++) {
        if (strcmp(o->law[i].place, l->place) == 0 && o->law[i].held_out <= as_well * l->held_out) {
            return o->law[i].of;
        }
    }
    return NULL;
}

static void say_twin(lab_diagnosis *o)
{
    const char *of = twin_of(o);
    size_t n = strlen(o->reason);
    if (of != NULL) {
        snprintf(o->reason + n, sizeof o->reason - n,
                 " A curve over its %s does it as well: these strokes do not tell the two apart.",
                 of);
    }
}

static void say(lab_diagnosis *o, double before)
{
    const lab_law *l = &o->law[0];
    size_t n = strlen(o->reason);
    if (l->pays && l->share >= diag__must_explain) {
        snprintf(o->reason + n, sizeof o->reason - n,
                 " A %s at %s over its %s does, as a curve: held-out strokes %.3g -> %.3g noise.",
                 l->what, l->place, l->of, before, l->held_out);
        say_twin(o);
    } else if (l->pays) {
        snprintf(o->reason + n, sizeof o->reason - n,
                 " Of all curves over one state, a %s at %s over its %s explains most, %.0f %% of "
                 "the misfit: no state function of those tried explains the rest.",
                 l->what, l->place, l->of, 100.0 * l->share);
    } else if (o->verdict == LAB_VERDICT_UNKNOWN_EFFECT) {
        snprintf(o->reason + n, sizeof o->reason - n,
                 " No state function of those tried explains it either: curves over position or "
                 "speed of a joint, depth or rate of a contact.");
    }
}

/* Nothing was found, and what is left counts as noise because nobody stated that. A law that
 * predicts the held-out strokes says that it is none. */
static int is_doubtful(const diag *d)
{
    const lab_diagnosis *o = d->out;
    return o->verdict == LAB_VERDICT_EXPLAINED && !fit__noise_given(&d->p) &&
           o->chi2_dof_before > explained;
}

int diag__asks_for_law(const diag *d, const diag__found *f)
{
    const lab_diagnosis *o = d->out;
    double left = f->n > 0 ? f->chi2_dof : o->chi2_dof_before;
    int known = fit__noise_given(&d->p);
    return o->verdict >= LAB_VERDICT_UNKNOWN_EFFECT || (known && diag__is_off(d, left)) ||
           is_doubtful(d);
}

/* Does a law take away most of what the causes leave beyond noise? One that bends as they do fits
 * as well as they and a little better: it has more numbers. */
static int leaves_less(const diag__found *f, const lab_law *l)
{
    return l->chi2_dof - 1.0 < less * (f->chi2_dof - 1.0);
}

/* Is the law believed? It has to predict held-out strokes better than nothing does, and than the
 * causes do whose place it would take: those are things people know. */
static int is_believed(const diag *d, const diag__found *f, const lab_law *l, double before)
{
    const lab_diagnosis *o = d->out;
    int held = isfinite(before);
    if (!(l->gain > diag__least_gain) || (held && !(l->held_out < before))) {
        return 0;
    }
    if (o->verdict == LAB_VERDICT_UNKNOWN_EFFECT) {
        return 1;
    }
    if (o->verdict == LAB_VERDICT_NOT_CONVERGED) {
        return l->chi2_dof < explained;
    }
    if (is_doubtful(d)) {
        return held && l->share >= diag__must_explain;
    }
    double other = f->n > 0 ? d->null_objective - diag__objective(f) : 0.0;
    return l->share >= diag__must_explain && l->chi2_dof <= diag__most_noise(d) &&
           l->gain > other + diag__least_gain &&
           (f->n == 0 || (leaves_less(f, l) && (!held || l->held_out < f->held.rmse)));
}

static void take_over(diag *d, diag__found *f, diag__held *held)
{
    lab_diagnosis *o = d->out;
    if (o->verdict != LAB_VERDICT_UNKNOWN_EFFECT && d->n > 0 && d->suspect[0].s.refitted) {
        snprintf(o->reason, sizeof o->reason,
                 "The best candidate (%s at %.60s) leaves more than noise.",
                 d->suspect[0].s.candidate.effect->kind, d->suspect[0].s.candidate.place);
    } else if (o->verdict != LAB_VERDICT_UNKNOWN_EFFECT) {
        snprintf(o->reason, sizeof o->reason, "No candidate explains these strokes.");
    }
    o->verdict = LAB_VERDICT_UNKNOWN_EFFECT;
    f->n = 0;
    diag__held_free(&f->held);
    f->held = *held;
    *held = (diag__held){.x = NULL, .rmse = NAN};
}

/* The best ones on the held-out strokes. Likelihoods say which curve is right where the noise is
 * known; where it is not, one over speed comes before one over position that predicts no better:
 * of a fall from one height both are the same, and what is missing is a loss more often than a
 * spring. @param held  of the first one, out */
static stein_status judge(const diag *d, const diag__curves *w, int n, diag__held *held,
                          stein_err *err)
{
    diag__curve *c = w->curve;
    diag__held of[JUDGED] = {{.x = NULL}};
    stein_status status = STEIN_OK;
    int first = 0, judged = 0;
    for (; status == STEIN_OK && judged < n && judged < JUDGED && c[judged].fitted; judged++) {
        of[judged].rmse = NAN;
        status = hold(d, w, &c[judged], &of[judged], err);
    }
    for (int i = 1; i < judged && c[0].site->kind == STEIN_TABLE_POSITION; i++) {
        int twin = !fit__noise_given(&d->p) && c[i].site->kind == STEIN_TABLE_SPEED &&
                   c[i].site->index == c[0].site->index && c[i].gain > diag__least_gain &&
                   c[i].held <= as_well * c[0].held;
        first = first == 0 && twin ? i : first;
    }
    diag__curve best = c[first];
    memmove(&c[1], &c[0], sizeof *c * (size_t)first);
    c[0] = best;
    *held = of[first];
    of[first] = (diag__held){.x = NULL, .rmse = NAN};
    for (int i = 0; i < judged; i++) {
        diag__held_free(&of[i]);
    }
    return status;
}

static stein_status conclude(diag *d, diag__curves *w, int n, double before, diag__found *f,
                             stein_err *err)
{
    lab_diagnosis *o = d->out;
    diag__curve *c = w->curve;
    diag__held held = {.x = NULL, .rmse = NAN};
    qsort(c, (size_t)n, sizeof *c, by_gain);
    stein_status status = judge(d, w, n, &held, err);
    o->law = calloc((size_t)n + 1, sizeof *o->law);
    if (status == STEIN_OK && o->law == NULL) {
        status = lab__no_memory(err);
    }
    for (int i = 0; status == STEIN_OK && i < n && c[i].fitted; i++) {
        status = note(d, w, &c[i], &o->law[o->nlaw++], err);
    }
    if (status == STEIN_OK && o->nlaw > 0) {
        lab_law *l = &o->law[0];
        double was = isfinite(before) ? before * before : o->chi2_dof_before;
        double is = isfinite(before) ? l->held_out * l->held_out : l->chi2_dof;
        l->share = fmin(1.0, (was - is) / fmax(was - 1.0, 1e-9));
        l->pays = is_believed(d, f, l, before);
        if (l->pays) {
            take_over(d, f, &held);
            status = note_values(d, w, &c[0], err);
        }
        say(o, before);
    }
    if (o->verdict >= LAB_VERDICT_UNKNOWN_EFFECT && (o->nlaw == 0 || !o->law[0].pays)) {
        diag__held_free(&f->held); // of a candidate that is no cause
        f->held = (diag__held){.x = NULL, .rmse = NAN};
    }
    diag__held_free(&held);
    return status;
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

/* the best curves by first order, in full */
static stein_status fit_best(diag *d, diag__curves *w, int *n, stein_err *err)
{
    diag__curve *c = w->curve;
    qsort(c, (size_t)w->nsite, sizeof *c, by_gain);
    stein_status status = STEIN_OK;
    double best = c[0].gain;
    *n = 0;
    while (status == STEIN_OK && *n < FITTED && *n < w->nsite &&
           (*n < 2 || c[*n].gain > near * best)) {
        status = diag__curve_fit(w, &c[*n], err);
        d->out->fits++;
        ++*n;
    }
    qsort(c, (size_t)*n, sizeof *c, by_gain);
    for (int i = 0; status == STEIN_OK && i < *n && i < BEGUN_ANEW && !is_near(w, c, *n); i++) {
        status = diag__curve_anew(w, &c[i], err);
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
        free(w->x);
        free(w->J);
        free(w);
    }
    d->curves = NULL;
}

/* the best curves with their points where the strokes go in a fit: p, x. @param n  fitted, out */
static stein_status search(diag *d, const fit__problem *p, const double *x, int *n, stein_err *err)
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
        status = status == STEIN_OK ? fit_best(d, w, n, err) : status;
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

stein_status diag__unknown_law(diag *d, const diag__held *before, diag__found *f, stein_err *err)
{
    stein_err why = {STEIN_OK, ""};
    int n = 0;
    stein_status status = search(d, &d->p, d->x, &n, &why);
    for (int i = 0; i < ROUNDS && status == STEIN_OK && is_misplaced(d, n, &status, &why); i++) {
        status = search(d, &d->curves->p, d->curves->curve[0].x, &n, &why);
    }
    status =
        status == STEIN_OK && n > 0 ? conclude(d, d->curves, n, before->rmse, f, &why) : status;
    if (status == STEIN_ENOMEM) {
        return lab__no_memory(err);
    }
    if (status != STEIN_OK && d->def->report != NULL) { // a verdict stands without a law
        d->def->report(d->def->ctx, why.msg);
    }
    return STEIN_OK;
}

const double *diag__law_residuals(const diag *d)
{
    return d->out->nlaw > 0 && d->out->law[0].pays ? d->curves->curve[0].r : NULL;
}

void diag__law_free(diag *d)
{
    close_curves(d);
}
