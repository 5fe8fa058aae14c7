/* SPDX-License-Identifier: GPL-3.0-or-later
 * curve_judge.c - is a recovered law accepted, and its sentence in the report.
 *
 * Effects of the table come before a law: laws are fitted only where the best hypothesis leaves
 * more than noise. A law is accepted if its marginal likelihood gains as much as a cause has to
 * gain, and, where causes were named, if it leaves noise and they do not. A law that leaves more
 * than noise is reported with the share of the misfit that it explains. No function of one state of
 * those tried explains the rest, as with hysteresis, where the force differs between loading and
 * unloading.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "curve.h"
#include "functions.h"

enum { SHAPE = 5 }; // numbers of a smooth curve

double diag__curve_chi2_dof(const diag__curves *w, const diag__curve *c)
{
    return fit__chi2(&w->p, c->r) / fmax(1.0, w->p.samples - w->null->p.nu);
}

static int by_gain(const void *a, const void *b)
{
    const diag__curve *x = a, *y = b;
    return x->gain > y->gain ? -1 : x->gain < y->gain;
}

void diag__curve_sort(diag__curve *c, int n)
{
    qsort(c, (size_t)n, sizeof *c, by_gain);
}

/* Factor on sd of a law that leaves more than noise. */
static double beyond_noise(const diag__curves *w, const diag__curve *c)
{
    double v = diag__curve_chi2_dof(w, c);
    int in_excess = !fit__noise_given(&w->p); // of noise that is not stated it is in the fit
    return !in_excess && v > diag__most_noise(w->q, &w->p)
               ? sqrt(v * fmax(1.0, fit__memory(&w->p, c->r)))
               : 1.0;
}

/* ---- records that nothing has read ---- */

static stein_status report(diag__laws *l, const diag__curve *c, const lab_dataset *records,
                           diag__reported *to, stein_err *err)
{
    diag__curves w;
    *to = (diag__reported){.rmse = NAN};
    stein_status status = diag__curves_open(&w, &l->in, l->all.q, l->all.null, records, err);
    if (status == STEIN_OK) {
        fit__problem *p = &w.p;
        memcpy(w.x, c->x, sizeof *w.x * (size_t)p->np);
        status = diag__fit_own(p, l->all.D, 0, w.x, w.r, err);
        to->x = status == STEIN_OK
                    ? malloc(sizeof *to->x * ((size_t)p->nu + fit__offset(p, p->nstroke) + 1))
                    : NULL;
    }
    if (status == STEIN_OK && to->x == NULL) {
        status = lab__no_memory(err);
    }
    if (status != STEIN_OK) {
        diag__curves_close(&w);
        return status;
    }
    size_t rows = fit__offset(&w.p, w.p.nstroke);
    to->r = to->x + w.p.nu;
    memcpy(to->x, w.x, sizeof *w.x * (size_t)w.p.nu);
    memcpy(to->r, w.r, sizeof *w.r * rows);
    to->rmse = sqrt(fit__chi2(&w.p, w.r) / fmax(1.0, w.p.samples));
    to->p = w.p;
    to->own = w.records;
    free(w.x);
    return STEIN_OK;
}

/* ---- results ---- */

static stein_status note(const diag__curves *w, const diag__curve *c, lab_law *to, stein_err *err)
{
    const diag__site *s = c->site;
    size_t n = (size_t)s->n;
    *to = (lab_law){.site = diag__site_word(s->kind, lab_equations(w->q->model), s->index),
                    .of = diag__site_of(s->kind),
                    .what = diag__site_what(s),
                    .at_unit = diag__site_at_unit(s),
                    .unit = diag__site_unit(s),
                    .n = s->n,
                    .gain = c->gain,
                    .held_out = NAN,
                    .share = NAN,
                    .chi2_dof = diag__curve_chi2_dof(w, c),
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
    double wide = beyond_noise(w, c);
    for (int k = 0; k < s->n; k++) {
        to->at[k] = s->at[k];
        to->sd[k] = wide * sqrt(fmax(0.0, c->cov[k * s->n + k]));
        double digits = to->sd[k] > 0.0 ? pow(10.0, 2.0 - floor(log10(to->sd[k]))) : 0.0;
        to->value[k] = c->x[s->first + k];
        to->value[k] = digits > 0.0 ? round(to->value[k] * digits) / digits : to->value[k];
        to->lo[k] = to->value[k] - diag__interval * to->sd[k];
        to->hi[k] = to->value[k] + diag__interval * to->sd[k];
        to->seen[k] = s->seen[k];
    }
    return STEIN_OK;
}

/* the refitted numbers of the file, with the law in the model */
static stein_status note_values(const diag__curves *w, const diag__curve *c, lab_diagnosis *o,
                                stein_err *err)
{
    const stein_model *m = lab_equations(w->q->model);
    double wide = beyond_noise(w, c);
    free(o->value);
    o->nvalue = 0;
    o->value = calloc((size_t)w->q->nname + 1, sizeof *o->value);
    if (o->value == NULL) {
        return lab__no_memory(err);
    }
    const lab_fit_def *def = &w->q->fit_def; // apparent scatter is the law
    const double prior[DIAG_CLASSES] = {def->joint_scatter, def->contact_scatter,
                                        def->drive_scatter};
    for (int i = 0; i < DIAG_CLASSES; i++) {
        o->scatter[i] = prior[i] * sqrt(w->D[i]);
    }
    for (int k = 0; k < w->q->nname; k++) {
        const fit__unknown *u = &w->p.unknown[k];
        int param = stein_find_param(m, w->q->name[k]);
        if (param < 0) {
            continue;
        }
        double value = fit__value(u, c->x[k]),
               in_sd = u->prior ? fmin(1.0, wide * c->sd[k]) : wide * c->sd[k],
               s = in_sd * u->sd * fabs(fit__slope(u, c->x[k]));
        o->value[o->nvalue++] = (lab_fit_value){.name = m->params[param].name,
                                                .unit = m->params[param].unit,
                                                .param = param,
                                                .logarithmic = u->log,
                                                .start = m->params[param].value,
                                                .value = value,
                                                .sd = s,
                                                .lo = value - diag__interval * s,
                                                .hi = value + diag__interval * s,
                                                .prior_sd = u->sd * fabs(fit__slope(u, 0.0)),
                                                .data_sd = NAN};
    }
    return STEIN_OK;
}

/* Does the first curve fit as well as the second? Where the noise is not stated it is estimated
 * from each residual, and n ln(chi2) replaces -2 ln p. */
static int fits_as_well(const diag__curves *w, const diag__curve *c, const diag__curve *than)
{
    if (fit__noise_given(&w->p)) {
        return c->gain > than->gain - diag__convincing;
    }
    double ratio = diag__curve_chi2_dof(w, c) / fmax(diag__curve_chi2_dof(w, than), 1e-9);
    double dof = w->p.samples / fmax(1.0, w->null->memory);
    return dof * stein__log_of(fmax(ratio, 1e-9)) < diag__least_gain;
}

/* Where the noise is not stated, a curve over speed comes before one over position that fits as
 * well. In a fall from one height both are equivalent, and a missing loss is more frequent
 * than a missing spring. */
static void prefer_speed(diag__laws *l)
{
    diag__curve *c = l->curve;
    for (int i = 1;
         i < l->n && !fit__noise_given(&l->all.p) && c[0].site->kind == STEIN_TABLE_POSITION; i++) {
        if (c[i].fitted && c[i].site->kind == STEIN_TABLE_SPEED &&
            c[i].site->index == c[0].site->index && fits_as_well(&l->all, &c[i], &c[0])) {
            diag__curve best = c[i];
            c[i] = c[0];
            c[0] = best;
        }
    }
}

/* Gain of a law where the noise is an unknown, too (search/evaluate.c): from the ratio of its
 * residual and the null hypothesis' residual, less the penalty of the numbers of a smooth curve
 * (Schwarz 1978). */
static double scale_free_gain(const diag__laws *l, const lab_law *law)
{
    const diag__row *null = l->all.null;
    double dof = l->all.p.samples / fmax(1.0, null->memory);
    return dof * stein__log_of(fmax(null->chi2_dof / fmax(law->chi2_dof, 1e-9), 1e-9)) -
           SHAPE * stein__log_of(fmax(1.0, dof));
}

/* Are the causes frictions of the law's joint, is the law over its speed, and do they explain
 * nearly all? Then the law is their shape: no friction has exactly the shape of the table. */
static int is_shape_of(const lab_law *law, const diag__judgement *j, const diag__row *best)
{
    // NOLINTNEXTLINE(clang-analyzer-core.NonNullParamChecker): a law that was noted has a state
    int yes = strcmp(law->of, "speed") == 0 && j->share > diag__nearly_all();
    for (int i = 0; i < best->h.n; i++) {
        const lab_candidate *c = &best->cause[i];
        yes = yes && strcmp(c->place, law->place) == 0 &&
              strcmp(lab_effect_family(c->effect), "dissipation") == 0;
    }
    return yes;
}

static int is_believed(const diag__laws *l, const lab_law *law, const diag__judgement *j,
                       const diag__row *best)
{
    double most = diag__most_noise(l->all.q, &l->all.p), wide = beyond_noise(&l->all, &l->curve[0]);
    int stated = fit__noise_given(&l->all.p);
    double gain = stated ? law->gain / (wide * wide) : scale_free_gain(l, law);
    if (!(gain > diag__least_gain) || law->chi2_dof > diag__seven_noises) {
        return 0;
    }
    if (j->finding == DIAG_NAMED && (!stated || is_shape_of(law, j, best))) {
        return 0; // known effects come first, and their residual may be noise
    }
    if (j->finding == DIAG_EXPLAINED && !stated) {
        return 1; // the assumed noise is none
    }
    if (j->finding == DIAG_NAMED || j->finding == DIAG_EXPLAINED) {
        return best->chi2_dof > most && law->chi2_dof <= most &&
               law->gain > j->gain + diag__least_gain;
    }
    double less = (best->chi2_dof - law->chi2_dof) * l->all.p.samples;
    int noise = stated && j->finding == DIAG_NO_CAUSE && best->chi2_dof <= most;
    return !noise || less > diag__least_gain;
}

/* A curve over another state of the same place that fits as well; NULL: there is none. */
static const lab_law *twin_of(const diag__laws *l, const lab_diagnosis *o)
{
    for (int i = 1; i < o->nlaw; i++) {
        if (strcmp(o->law[i].place, o->law[0].place) == 0 &&
            fits_as_well(&l->all, &l->curve[i], &l->curve[0])) {
            return &o->law[i];
        }
    }
    return NULL;
}

static void say_twin(const diag__laws *l, lab_diagnosis *o)
{
    const lab_law *twin = twin_of(l, o);
    size_t n = strlen(o->reason);
    if (twin != NULL) {
        snprintf(o->reason + n, sizeof o->reason - n,
                 " A curve over its %s fits as well: these records do not separate the two.",
                 twin->of);
    }
}

/* Is nothing but noise left to the law, where it was fitted and in the records that report? A
 * residual that a function of a state nearly explains may be no function of that state. */
static int explains_all(const diag__laws *l, const lab_law *law, const diag__reported *after)
{
    double sd = sqrt(2.0 / fmax(1.0, after->p.samples));
    int reported = !isfinite(after->rmse) || !fit__noise_given(&l->all.p) ||
                   after->rmse * after->rmse < 1.0 + diag__certain * sd;
    int noise =
        !fit__noise_given(&l->all.p) || law->chi2_dof <= diag__most_noise(l->all.q, &l->all.p);
    return law->share >= diag__most_of && noise && reported;
}

static void say(const diag__laws *laws, lab_diagnosis *o, double before, int all)
{
    const lab_law *l = &o->law[0];
    size_t n = strlen(o->reason), room = sizeof o->reason - n;
    if (l->pays && all) {
        snprintf(o->reason + n, room, " A %s at %s over its %s does, as a curve", l->what, l->place,
                 l->of);
        n = strlen(o->reason);
        if (isfinite(l->held_out) && isfinite(before)) {
            snprintf(o->reason + n, sizeof o->reason - n, ": held-out records %.3g -> %.3g noise.",
                     before, l->held_out);
        } else {
            snprintf(o->reason + n, sizeof o->reason - n, ".");
        }
        say_twin(laws, o);
    } else if (l->pays) {
        snprintf(o->reason + n, room,
                 " Of all curves over one state, a %s at %s over its %s explains most, %.0f %% of "
                 "the misfit: no state function of those tried explains the rest.",
                 l->what, l->place, l->of, 100.0 * l->share);
    } else if (o->verdict == LAB_VERDICT_UNKNOWN_EFFECT) {
        snprintf(o->reason + n, room,
                 " No state function of those tried explains it either: curves over position or "
                 "speed of a joint, depth or rate of a contact.");
    }
}

stein_status diag__law_judge(diag__laws *l, const diag__judgement *j, const diag__row *best,
                             const lab_dataset *reporting, const diag__reported *before,
                             diag__reported *after, lab_diagnosis *o, stein_err *err)
{
    diag__curve *c = l->curve;
    stein_status status = STEIN_OK;
    prefer_speed(l);
    if (l->n > 0 && c[0].fitted && diag__curve_chi2_dof(&l->all, &c[0]) < diag__near_noise) {
        status = diag__curve_settle(&l->all, &c[0], err);
    }
    o->law = calloc((size_t)l->n + 1, sizeof *o->law);
    if (status == STEIN_OK && o->law == NULL) {
        return lab__no_memory(err);
    }
    for (int i = 0; status == STEIN_OK && i < l->n && c[i].fitted; i++) {
        status = note(&l->all, &c[i], &o->law[o->nlaw++], err);
    }
    if (status != STEIN_OK || o->nlaw == 0) {
        return status;
    }
    lab_law *law = &o->law[0];
    law->share =
        fmin(1.0, (o->chi2_dof_before - law->chi2_dof) / fmax(o->chi2_dof_before - 1.0, 1e-9));
    law->pays = is_believed(l, law, j, best);
    if (law->pays && reporting->n > 0) {
        stein_err why;
        status = fit__forgive(report(l, &c[0], reporting, after, &why), err);
        law->held_out = after->rmse;
        law->pays = !(law->held_out > diag__no_gain * before->rmse);
    }
    if (law->pays && status == STEIN_OK) {
        o->verdict = LAB_VERDICT_UNKNOWN_EFFECT;
        snprintf(o->reason, sizeof o->reason, "No candidate explains the residual.");
        o->chi2_dof_after = law->chi2_dof;
        status = note_values(&l->all, &c[0], o, err);
    }
    say(l, o, before->rmse, explains_all(l, law, after));
    return status;
}

void diag__laws_drop(lab_diagnosis *o)
{
    for (int i = 0; o->law != NULL && i < o->nlaw; i++) {
        free(o->law[i].at);
        free(o->law[i].seen);
    }
    free(o->law);
    o->law = NULL;
    o->nlaw = 0;
}
