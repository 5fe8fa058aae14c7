/* SPDX-License-Identifier: GPL-3.0-or-later
 * curve_judge.c - is a recovered law believed, and what is said of it?
 *
 * The best curve by marginal likelihood is believed when strokes that were held out are predicted
 * better. It is one of the states that were asked. What leaves more than the noise that the data
 * state, in the strokes it was fitted to or in those held out, is told as what it is: most of the
 * misfit looks like this, and no state function of those tried explains the rest - a memory has
 * another force on the way out than on the way in.
 *
 * Where known effects have been found they keep their place, unless the law leaves less by more
 * than its freedom would by chance. Several of them in one place may be its pieces.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "curve.h"
#include "functions.h"

enum { JUDGED = 3 };
static const double explained = 2.0;  /* chi2/dof of a fit that can be trusted, as in verdict.c */
static const double as_noise = 1.1;   /* the same of one that leaves nothing */
static const double near_noise = 1.2; /* the same of one that none from the null fit will better */
static const double as_well = 1.25;   /* held-out errors that are no different */
static const double less = 0.5;       /* of what is left */
static const double next_to_nothing = 0.01; /* of what was left before */
static const double certain = 4.0;          /* sd of a chi2/dof that is no chance */

double diag__curve_chi2_dof(const diag *d, const diag__curves *w, const diag__curve *c)
{
    return fit__chi2(&w->p, c->r) / fmax(1.0, w->p.samples - d->p.nu);
}

int diag__curve_nearly(const diag *d, const diag__curves *w, const diag__curve *c)
{
    return c->fitted && diag__curve_chi2_dof(d, w, c) < near_noise;
}

int diag__curve_describes(const diag *d, const diag__curves *w, const diag__curve *c)
{
    return c->fitted && diag__curve_chi2_dof(d, w, c) < as_noise;
}

/* Factor on sd of a law that leaves more than the noise which the data state: variances are larger
 * than they show by v i, as in curve_reduce.c. */
static double beyond_noise(const diag *d, const diag__curves *w, const diag__curve *c)
{
    double v = diag__curve_chi2_dof(d, w, c);
    return fit__noise_given(&w->p) && v > diag__most_noise(d)
               ? sqrt(v * fmax(1.0, fit__memory(&w->p, c->r)))
               : 1.0;
}

/* ---- judging ---- */

static int by_gain(const void *a, const void *b)
{
    const diag__curve *x = a, *y = b;
    return x->gain > y->gain ? -1 : x->gain < y->gain;
}

void diag__curve_sort(diag__curve *c, int n)
{
    qsort(c, (size_t)n, sizeof *c, by_gain);
}

static stein_status hold(const diag *d, const diag__curves *w, diag__curve *c, diag__held *to,
                         stein_err *err)
{
    diag other = *d;
    stein_err why = {STEIN_OK, ""};
    other.model = w->model;
    other.p = w->p;
    other.held_data = w->held_data;
    other.fit_def = w->def;
    other.x = c->x;
    memcpy(other.null_D, w->D, sizeof other.null_D);
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
                    .chi2_dof = diag__curve_chi2_dof(d, w, c),
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
    double wide = beyond_noise(d, w, c);
    for (int k = 0; k < s->n; k++) {
        to->at[k] = s->at[k];
        to->sd[k] = wide * sqrt(fmax(0.0, c->cov[k * s->n + k]));
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
    double wide = beyond_noise(d, w, c);
    for (int k = 0; k < d->nname; k++) {
        diag__note_value(d, &w->p, k, c->x[k], c->sd[k], wide);
    }
    diag__note_scatter(d, w->D);
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

/* Is nothing but the stated noise left to a law, where it was fitted and where it was not? What a
 * state function nearly explains may be no function of that state. */
static int explains_all(const diag *d, const lab_law *l, const diag__held *held)
{
    double sd = sqrt(2.0 / fmax(1.0, held->p.samples));
    int held_out = !isfinite(held->rmse) || held->rmse * held->rmse < 1.0 + certain * sd;
    return l->share >= diag__must_explain &&
           (!fit__noise_given(&d->p) || (l->chi2_dof <= diag__most_noise(d) && held_out));
}

/* What no state function explains might be one more degree of freedom: of the parts that the search
 * has fitted, the best one, and what it leaves. */
static void say_part(const diag *d)
{
    lab_diagnosis *o = d->out;
    const diag__suspect *best = NULL;
    char text[sizeof o->reason];
    for (int i = 0; i < d->n; i++) {
        const diag__suspect *s = &d->suspect[i];
        int fitted = s->model != NULL && s->s.refitted && isfinite(s->objective);
        best = fitted && (best == NULL || s->s.chi2_dof < best->s.chi2_dof) ? s : best;
    }
    size_t n = strlen(o->reason), room = sizeof o->reason - n;
    if (best != NULL && (size_t)snprintf(text, sizeof text,
                                         " Nor does a degree of freedom more: %s at %s leaves "
                                         "chi2/dof %.3g.",
                                         best->s.candidate.effect->kind, best->s.candidate.place,
                                         best->s.chi2_dof) < room) {
        memcpy(o->reason + n, text, strlen(text) + 1);
    }
}

static void say(const diag *d, double before, int all)
{
    lab_diagnosis *o = d->out;
    const lab_law *l = &o->law[0];
    size_t n = strlen(o->reason);
    if (l->pays && all) {
        snprintf(o->reason + n, sizeof o->reason - n,
                 " A %s at %s over its %s does, as a curve: held-out strokes %.3g -> %.3g noise.",
                 l->what, l->place, l->of, before, l->held_out);
        say_twin(o);
    } else if (l->pays) {
        snprintf(o->reason + n, sizeof o->reason - n,
                 " Of all curves over one state, a %s at %s over its %s explains most, %.0f %% of "
                 "the misfit: no state function of those tried explains the rest.",
                 l->what, l->place, l->of, 100.0 * l->share);
        say_part(d);
    } else if (o->verdict == LAB_VERDICT_UNKNOWN_EFFECT) {
        snprintf(o->reason + n, sizeof o->reason - n,
                 " No state function of those tried explains it either: curves over position or "
                 "speed of a joint, depth or rate of a contact.");
        say_part(d);
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

/* the place of several causes that are all in one, NULL: they are not */
static const char *only_place(const diag__found *f)
{
    const char *place = f->n > 1 ? f->cause[0].candidate.place : NULL;
    for (int i = 1; i < f->n && place != NULL; i++) {
        place = strcmp(f->cause[i].candidate.place, place) == 0 ? place : NULL;
    }
    return place;
}

/* two causes in one place may be pieces of a law there */
static int share_place(const diag__found *f)
{
    for (int i = 0; i < f->n; i++) {
        for (int k = 0; k < i; k++) {
            if (strcmp(f->cause[i].candidate.place, f->cause[k].candidate.place) == 0) {
                return 1;
            }
        }
    }
    return 0;
}

/* Several causes at as many places that leave next to nothing: a law at one of the places would
 * have to explain more, and its search costs most of a diagnosis. */
static int are_all(const diag *d, const diag__found *f)
{
    return f->n > 1 && !share_place(f) &&
           f->chi2_dof - 1.0 < next_to_nothing * (d->out->chi2_dof_before - 1.0);
}

int diag__asks_for_law(const diag *d, const diag__found *f)
{
    const lab_diagnosis *o = d->out;
    double left = f->n > 0 ? f->chi2_dof : o->chi2_dof_before;
    int off = diag__is_off(d, left) && !are_all(d, f);
    int known = fit__noise_given(&d->p) && (off || only_place(f) != NULL);
    return o->verdict >= LAB_VERDICT_UNKNOWN_EFFECT || known || is_doubtful(d);
}

/* Are the causes pieces of the law: several, all of them in its place, and it costs less for what
 * it fits? Their numbers cost ln n each (Schwarz 1978). @param price  of the law, diag__curve */
static int are_pieces(const diag *d, const diag__found *f, const lab_law *l, double price)
{
    const char *place = only_place(f);
    double fell = (f->chi2_dof - l->chi2_dof) * d->p.samples;
    int numbers = f->n;
    for (int i = 0; i < f->n; i++) {
        for (int k = 0; k < LAB_SIDES; k++) {
            numbers += f->cause[i].candidate.side[k].hi > f->cause[i].candidate.side[k].lo;
        }
    }
    double theirs = numbers * stein__log_of(fmax(1.0, d->p.samples));
    return place != NULL && strcmp(place, l->place) == 0 &&
           fell + theirs > price + diag__least_gain;
}

/* Does a law take away most of what the causes leave beyond noise? One that bends as they do fits
 * as well as they and a little better: it has more numbers. */
static int leaves_less(const diag__found *f, const lab_law *l)
{
    return l->chi2_dof - 1.0 < less * (f->chi2_dof - 1.0);
}

/* Is the law believed? It has to predict held-out strokes better than nothing does, and than the
 * causes do whose place it would take: those are things people know. */
static int is_believed(const diag *d, const diag__found *f, const lab_law *l, double price,
                       double before)
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
    if (l->share < diag__must_explain || l->chi2_dof > diag__most_noise(d)) {
        return 0;
    }
    if (f->n > 0 && held && !(l->held_out < f->held.rmse)) {
        return 0;
    }
    if (f->n > 0 && diag__law_is_all(d) && diag__is_more(d, f->chi2_dof)) {
        return 1; // what the causes leave, it explains
    }
    double other = f->n > 0 ? d->null_objective - diag__objective(f) : 0.0;
    int gains = l->gain > other + diag__least_gain;
    return are_pieces(d, f, l, price) || (gains && (f->n == 0 || leaves_less(f, l)));
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

/* Of curves that all leave more than noise none is right, and their likelihoods say little of which
 * is nearest: one stroke that a fit has lost outweighs all others. The one that predicts strokes
 * best which it has not seen comes first. */
static int best_predictor(const diag__curve *c, int n)
{
    int first = 0;
    for (int i = 1; i < n; i++) {
        first = c[i].gain > diag__least_gain && c[i].held < c[first].held ? i : first;
    }
    return first;
}

/* The best ones on the held-out strokes. Likelihoods say which curve is right where the noise is
 * known and one leaves no more; where it is not known, one over speed comes before one over
 * position that predicts no better: of a fall from one height both are the same, and what is
 * missing is a loss more often than a spring. @param held  of the first one, out */
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
    if (fit__noise_given(&d->p) && judged > 0 && !diag__curve_describes(d, w, &c[0])) {
        first = best_predictor(c, judged);
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

stein_status diag__curve_judge(diag *d, diag__curves *w, int n, double before, stein_err *err)
{
    lab_diagnosis *o = d->out;
    diag__curve *c = w->curve;
    w->held = (diag__held){.x = NULL, .rmse = NAN};
    diag__curve_sort(c, n);
    double most =
        fmin(near_noise, diag__most_noise(d)); // nobody counts the digits of what is beyond
    int settles = n > 0 && c[0].fitted && diag__curve_chi2_dof(d, w, &c[0]) < most;
    stein_status status = settles ? diag__curve_settle(d, w, &c[0], err) : STEIN_OK;
    status = status == STEIN_OK ? judge(d, w, n, &w->held, err) : status;
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
    }
    return status;
}

int diag__law_is_all(const diag *d)
{
    const lab_law *l = d->out->nlaw > 0 ? &d->out->law[0] : NULL;
    return l != NULL && l->gain > diag__least_gain && explains_all(d, l, &d->curves->held) &&
           !diag__scatters_most(d->curves->D); // that would be part of what is missing
}

int diag__law_has_all(const diag *d, const diag__found *f)
{
    int all = diag__law_is_ahead(d, f);
    for (int i = 0; all && i < f->n; i++) {
        all = diag__one_element(f->cause[i].candidate.place, d->out->law[0].place);
    }
    return all;
}

int diag__law_is_ahead(const diag *d, const diag__found *f)
{
    const lab_law *l = d->out->nlaw > 0 ? &d->out->law[0] : NULL;
    return f->n > 1 && l != NULL && l->gain > diag__least_gain && leaves_less(f, l);
}

stein_status diag__curve_conclude(diag *d, diag__curves *w, double before, diag__found *f,
                                  stein_err *err)
{
    lab_diagnosis *o = d->out;
    stein_status status = STEIN_OK;
    if (o->nlaw > 0) {
        lab_law *l = &o->law[0];
        int all = explains_all(d, l, &w->held);
        l->pays = is_believed(d, f, l, w->curve[0].price, before);
        if (l->pays) {
            take_over(d, f, &w->held);
            status = note_values(d, w, &w->curve[0], err);
        }
        say(d, before, all);
    }
    if (o->verdict >= LAB_VERDICT_UNKNOWN_EFFECT && (o->nlaw == 0 || !o->law[0].pays)) {
        diag__held_free(&f->held); // of a candidate that is no cause
        f->held = (diag__held){.x = NULL, .rmse = NAN};
    }
    return status;
}
