/* SPDX-License-Identifier: GPL-3.0-or-later
 * diagnose.c - from a mechanism file and strokes to a verdict.
 *
 *   audit       what the records say about themselves, before anything is fitted
 *   hold out    strokes that judge the end and that nothing is fitted to
 *   null fit    the model as it is: every number with a tolerance, every stroke's own (pursue.c)
 *   suspects    what every candidate would change (suspects.c)
 *   rank        whom the residual looks like (rank.c)
 *   refit       the best ones in full, then what could stand in their place (refine.c,
 *               contest.c)
 *   held out    is anything gained where nothing was fitted (heldout.c), and is there more
 *               to be found (several.c); where much is left, a law is asked for first (curve.c)
 *   verdict     (verdict.c), numbers (note.c)
 *   law         of an unknown effect, as a curve (curve.c)
 *   show        where the model departs, and the force it lacks (departure.c, latent.c)
 *   check       the same verdict from a prescribed motion and its force (motion_check.c)
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "motion.h"
#include "searching.h"

enum { FEWEST = 2, HOLD_EVERY = 3, SCATTER_FROM = 4, TRACES = 4, TRACES_HELD = 2 };
static const double offset_prior = 1e-3; /* [m] a marker is glued on by hand */
/* Of integration steps. Ten times coarser ones are quicker and leave little of chi2 beside what is
 * missing where that is gross, nearly the same whatever is on trial; with them a null fit may lose
 * its strokes, and near ties change places. */
const double diag__tolerance = 1e-9;
static const double coarse = 1e-8;
static const double much = 4.0;   /* chi2/dof of the null fit */
static const double a_part = 0.2; /* of the misfit: explained by one of two causes */
static const char candidates[] = "fits with more candidates";

lab_diagnose_def lab_diagnose_def_default(void)
{
    return (lab_diagnose_def){.threads = 1};
}

static void progress(const diag *d, double fraction, const char *step)
{
    if (d->def->progress != NULL) {
        d->def->progress(d->def->ctx, fraction, step);
    }
}

/* ---- strokes ---- */

static int is_held(const diag *d, int stroke, int n)
{
    if (d->def->held_out != NULL) {
        return d->def->held_out[stroke];
    }
    return n >= HOLD_EVERY && stroke % HOLD_EVERY == HOLD_EVERY - 1;
}

static stein_status split(diag *d, const lab_dataset *data, lab_dataset *fit, lab_dataset *held,
                          stein_err *err)
{
    size_t n = (size_t)data->n;
    fit->stroke = calloc(n + 1, sizeof(lab_data *));
    held->stroke = calloc(n + 1, sizeof(lab_data *));
    if (fit->stroke == NULL || held->stroke == NULL) {
        return lab__no_memory(err);
    }
    for (int s = 0; s < data->n; s++) {
        lab_dataset *to = is_held(d, s, data->n) ? held : fit;
        to->stroke[to->n++] = data->stroke[s];
    }
    d->fit_data = fit;
    d->held_data = held;
    d->out->nfit = fit->n;
    d->out->nheld = held->n;
    if (data->n < FEWEST || fit->n < 1) {
        return lab__fail(
            err, STEIN_EINVAL,
            "%d stroke%s to fit to and %d held out: at least %d in all, and one to fit "
            "to",
            fit->n, fit->n == 1 ? "" : "s", held->n, FEWEST);
    }
    return STEIN_OK;
}

stein_status diag__add_finding(diag *d, char *line, stein_err *err)
{
    lab_diagnosis *o = d->out;
    char **more = realloc(o->finding, sizeof *more * (size_t)(o->nfinding + 1));
    o->finding = more != NULL ? more : o->finding;
    if (line == NULL || more == NULL) {
        free(line);
        return lab__no_memory(err);
    }
    o->finding[o->nfinding++] = line;
    return STEIN_OK;
}

stein_status diag__tell(diag *d, char *line, stein_err *err)
{
    if (line != NULL && d->def->report != NULL) {
        d->def->report(d->def->ctx, line);
    }
    stein_status status = diag__add_finding(d, line, err);
    lab_diagnosis *o = d->out;
    if (status == STEIN_OK) {
        memmove(o->finding + 1, o->finding, sizeof *o->finding * (size_t)(o->nfinding - 1));
        o->finding[0] = line;
    }
    return status;
}

static stein_status audit(diag *d, const lab_dataset *data, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int s = 0; status == STEIN_OK && s < data->n; s++) {
        lab_audit *a = NULL;
        status = lab_audit_create(&a, data->stroke[s], err);
        for (int i = 0; status == STEIN_OK && i < a->nfinding; i++) {
            status = diag__add_finding(d, lab__text("%s: %s", data->stroke[s]->file, a->finding[i]),
                                       err);
        }
        lab_audit_destroy(a);
    }
    return status;
}

/* ---- the null fit's problem ---- */

/* every number whose tolerance the file states and that not every stroke sets, and what the caller
 * wants free; of a name that is none the fit will tell */
static stein_status choose_names(diag *d, stein_err *err)
{
    const stein_model *m = lab_equations(d->model);
    d->name = malloc(sizeof *d->name * (size_t)(m->np + d->def->nfree + 1));
    if (d->name == NULL) {
        return lab__no_memory(err);
    }
    for (int i = 0; i < m->np; i++) {
        if (m->params[i].tolerance > 0.0 && !fit__always_set(d->fit_data, i)) {
            d->name[d->nname++] = m->params[i].name;
        }
    }
    for (int k = 0; k < d->def->nfree; k++) {
        int i = stein_find_param(m, d->def->free[k]);
        if (i < 0 || !(m->params[i].tolerance > 0.0)) {
            d->name[d->nname++] = d->def->free[k];
        }
    }
    return STEIN_OK;
}

static stein_status make_problem(diag *d, stein_err *err)
{
    stein_status status = choose_names(d, err);
    if (status != STEIN_OK) {
        return status;
    }
    d->fit_def = lab_fit_def_default();
    d->fit_def.free = d->name;
    d->fit_def.nfree = d->nname;
    d->fit_def.offset = offset_prior;
    d->fit_def.threads = d->def->threads > 0 ? d->def->threads : 1;
    d->fit_def.scatter = d->fit_data->n >= SCATTER_FROM;
    status = diag__open_problem(d, err);
    d->p.tolerance = diag__tolerance;
    d->out->samples = d->p.samples;
    return status;
}

stein_status diag__open_problem(diag *d, stein_err *err)
{
    stein_status status = fit__problem_make_with(&d->p, d->model, d->fit_data, &d->fit_def,
                                                 d->accepted, d->naccepted, err);
    status = status == STEIN_OK ? fit__check_samples(&d->p, err) : status;
    if (status != STEIN_OK) {
        return status;
    }
    size_t rows = fit__offset(&d->p, d->p.nstroke);
    d->x = calloc((size_t)d->p.nu + 1, sizeof *d->x);
    d->sd = calloc((size_t)d->p.np + 1, sizeof *d->sd);
    d->J = malloc(sizeof *d->J * (fit__columns(&d->p) + 1));
    d->r = malloc(sizeof *d->r * (rows + 1));
    return d->x != NULL && d->sd != NULL && d->J != NULL && d->r != NULL ? STEIN_OK
                                                                         : lab__no_memory(err);
}

void diag__close(diag *d)
{
    diag__suspects_free(d);
    fit__problem_free(&d->p);
    free(d->x);
    free(d->J);
    free(d->r);
    free(d->sd);
    free(d->early.x);
    free(d->early.J);
    lab_dataset_close(d->own_fit);
    lab_dataset_close(d->own_held);
    lab_close(d->own_model);
}

/* ---- the search ---- */

stein_status diag__search(diag *d, stein_err *err)
{
    progress(d, d->naccepted > 0 ? 0.85 : 0.35, "what every candidate would change");
    int early = diag__is_off(d, fit__chi2_dof(&d->p, d->r)), found = 0;
    stein_status status = diag__refit_known(d, &found, err);
    if (status != STEIN_OK || found) {
        return status;
    }
    status = early ? diag__look_early(d, err) : STEIN_OK;
    status = status == STEIN_OK ? diag__changes(d, err) : status;
    status = status == STEIN_OK ? diag__rank(d, err) : status;
    progress(d, d->naccepted > 0 ? 0.86 : 0.55, "fits with the best candidates");
    return status == STEIN_OK ? diag__refit(d, err) : status;
}

/* of the problems that parts have of their own, too: what is compared has the same steps */
static void step_coarsely(diag *d)
{
    d->p.tolerance = coarse;
    for (int i = 0; i < d->n; i++) {
        if (d->suspect[i].fit != NULL) {
            d->suspect[i].fit->tolerance = coarse;
        }
    }
}

static stein_status search(diag *d, stein_err *err)
{
    progress(d, 0.02, "parts that may be missing");
    stein_status status = diag__suspects(d, err);
    progress(d, 0.05, "fit of the model as it is");
    status = status == STEIN_OK ? diag__pursue(d, err) : status;
    if (status == STEIN_OK && fit__chi2_dof(&d->p, d->r) > much) {
        step_coarsely(d);
        status = diag__pursue_on(d, err);
    }
    return status == STEIN_OK ? diag__search(d, err) : status;
}

/* ---- results ---- */

/* predictions of a stroke from its weighted residuals */
static void predict(const fit__problem *p, int s, const double *r, double *y)
{
    const fit__stroke *t = &p->stroke[s];
    r += fit__offset(p, s);
    for (int i = 0; i < t->nch * t->n; i++) {
        y[i] = t->y[i] - r[i] * t->noise[i / t->n];
    }
}

static stein_status traces(diag *d, const fit__problem *p, const double *before,
                           const double *after, const char *const *phase, int held, int most,
                           stein_err *err)
{
    size_t size = (size_t)p->rows;
    double *y = malloc(sizeof *y * (2 * size + 1));
    stein_status status = y != NULL ? STEIN_OK : lab__no_memory(err);
    for (int k = 0; status == STEIN_OK && k < most && k < p->nstroke; k++) {
        int s = k * p->nstroke / (most < p->nstroke ? most : p->nstroke);
        predict(p, s, before, y);
        if (after != NULL) {
            predict(p, s, after, y + size);
        }
        status = diag__trace(&d->out->trace, &d->out->ntrace, p, s, held, y,
                             after != NULL ? y + size : NULL, phase + diag__row(p, s), err);
    }
    free(y);
    return status;
}

/* the strokes as the file predicts them and as the end does */
static stein_status show(diag *d, const diag__held *before, const diag__found *f, stein_err *err)
{
    const fit__problem *p = &d->p;
    const double *r = f->n < 1            ? diag__law_residuals(d)
                      : f->leader != NULL ? f->leader->r
                                          : f->end->r;
    size_t frames = diag__row(p, p->nstroke),
           more = before->x != NULL ? diag__row(&before->p, before->p.nstroke) : 0;
    const char **phase = malloc(sizeof *phase * (frames + more + 1));
    double *time = malloc(sizeof *time * (frames + 1));
    stein_status status = phase != NULL && time != NULL ? diag__phases(p, d->x, phase, time, err)
                                                        : lab__no_memory(err);
    if (status == STEIN_OK && more > 0) {
        status = diag__phases(&before->p, before->x, phase + frames, NULL, err);
    }
    if (status == STEIN_OK && r != NULL) {
        d->out->phase = diag__phase_shown(p, d->r, r, phase);
    }
    status = status == STEIN_OK ? traces(d, p, d->r, r, phase, 0, TRACES, err) : status;
    if (status == STEIN_OK && more > 0) {
        const diag__held *end = r != NULL && f->held.x != NULL ? &f->held : before;
        status = traces(d, &before->p, before->r, end != before ? end->r : NULL, phase + frames, 1,
                        TRACES_HELD, err);
        status = status == STEIN_OK ? diag__gain(d->out, before, end, phase + frames, err) : status;
    }
    status =
        status == STEIN_OK ? diag__show(d->out, p, d->x, d->r, d->J, phase, time, err) : status;
    progress(d, 0.94, "the force that the measured motion needs");
    status = status == STEIN_OK ? diag__motion(d, before, f, phase, phase + frames, err) : status;
    free(phase);
    free(time);
    return status;
}

/* a model of a search goes to the diagnosis, if it is the search's own */
static void keep_of(lab_diagnosis *o, diag *search, const lab_model *model)
{
    lab_model **owner = search->own_model == model ? &search->own_model : NULL;
    for (int i = 0; owner == NULL && i < search->n; i++) {
        owner = search->suspect[i].model == model ? &search->suspect[i].model : NULL;
    }
    if (owner != NULL) {
        o->kept[o->nkept++] = *owner;
        *owner = NULL;
    }
}

/* mechanisms with parts stay: causes and rivals have their units from them */
static stein_status keep_parts(diag *d, const diag__found *f, stein_err *err)
{
    lab_diagnosis *o = d->out;
    o->kept = calloc((size_t)f->nstage + 2, sizeof(lab_model *));
    if (o->kept == NULL) {
        return lab__no_memory(err);
    }
    for (int k = 0; k <= f->nstage; k++) {
        const lab_model *model = k < f->nstage       ? f->stage[k]->model
                                 : f->leader != NULL ? f->leader->model
                                                     : NULL;
        for (int i = -1; model != NULL && i < f->nstage; i++) {
            keep_of(o, i < 0 ? d : f->stage[i], model);
        }
    }
    return STEIN_OK;
}

/* chi2/dof of the best candidate, or of the null fit */
static double left(const diag *d)
{
    const diag__suspect *s = d->n > 0 ? &d->suspect[0] : NULL;
    int led = s != NULL && s->s.refitted && isfinite(s->objective);
    return led ? s->s.chi2_dof : fit__chi2_dof(&d->p, d->r);
}

/* A law explains all: may two causes in its place be what it is? Then they are searched for there.
 */
static int may_be_pieces(diag *d)
{
    d->only = d->out->law[0].place;
    // NOLINTNEXTLINE(clang-analyzer-core.NonNullParamChecker): every candidate has a place
    return d->n > 0 && strcmp(d->suspect[0].s.candidate.place, d->only) == 0 &&
           diag__share(d, left(d)) > a_part;
}

static diag__found none(diag *d)
{
    return (diag__found){.end = d, .excess = 1.0, .held = {.rmse = NAN}};
}

/* A law explains all, and the first search has put off what costs most. Where the strokes begin one
 * candidate explains them, too: does one of them to the end? @return then it is known */
static int is_known_after_all(diag *d, stein_status *status, stein_err *err)
{
    if (!d->put_off || diag__is_beyond_one(d)) {
        return 0;
    }
    progress(d, 0.83, candidates);
    *status = diag__refit_on(d, err);
    return *status == STEIN_OK && diag__leaves_noise(d);
}

/* two causes along the strokes; or else one after the other, with what was put off */
static stein_status known_causes(diag *d, const diag__held *before, diag__found *f, stein_err *err)
{
    stein_status status = STEIN_OK;
    if (d->put_off) {
        progress(d, 0.83, "two causes along the strokes");
        status = diag__two_along(d, before, f, err);
    }
    if (status == STEIN_OK && f->n == 0 && d->put_off) {
        progress(d, 0.84, candidates);
        status = diag__refit_on(d, err);
    }
    if (status == STEIN_OK && f->n == 0) {
        diag__found_free(f);
        status = diag__several(d, before, f, err);
    }
    return status;
}

/* Causes or a law. Where the best candidate leaves more than the noise that the data state, a law
 * is asked for in haste before it is searched for more causes: where one law explains all, causes
 * in other places do not, and a search for them costs several times as much. At any price it is
 * asked for where two causes leave more than noise (several.c), or where nobody is a cause. */
static stein_status explain(diag *d, const diag__held *before, diag__found *f, stein_err *err)
{
    static const char law[] = "the law of what is in no table";
    stein_status status = STEIN_OK;
    d->out->chi2_dof_before = fit__chi2_dof(&d->p, d->r);
    *f = none(d);
    if (left(d) > diag__most_noise(d)) {
        progress(d, 0.82, law);
        status = diag__try_laws(d, before, left(d), err);
    }
    int all = status == STEIN_OK && diag__law_is_all(d),
        one = all && is_known_after_all(d, &status, err), known = !all || one || may_be_pieces(d);
    if (status == STEIN_OK && known) {
        status = known_causes(d, before, f, err);
    }
    if (status == STEIN_OK && !all && diag__law_is_all(d)) { // it was found on the way
        all = 1;
        known = may_be_pieces(d);
        diag__found_free(f);
        *f = none(d);
        status = known ? diag__several(d, before, f, err) : STEIN_OK;
    }
    if (status == STEIN_OK && known) {
        d->out->gain.ratio = f->held.rmse / before->rmse;
        diag__verdict(d, f);
    }
    if (status == STEIN_OK && ((all && !one) || diag__asks_for_law(d, f))) {
        progress(d, 0.88, law);
        status = diag__unknown_law(d, before, f, err);
    }
    return status;
}

static stein_status conclude(diag *d, stein_err *err)
{
    diag__held before = {.x = NULL, .rmse = NAN};
    diag__found found;
    lab_diagnosis *o = d->out;
    stein_status status =
        diag__likelihood(&d->p, d->x, d->J, d->r, d->null_D, d->sd, NULL, NULL, err);
    if (status != STEIN_OK) {
        return status;
    }
    progress(d, 0.8, "strokes that were held out");
    o->gain.ratio = o->gain.rmse_before = o->gain.rmse_after = o->gain.lo = o->gain.hi = NAN;
    o->noise_floor = 1.0;
    stein_err why = {STEIN_OK, ""};
    if (d->held_data->n > 0 && diag__held_out(d, NULL, &before, &why) == STEIN_ENOMEM) {
        diag__held_free(&before);
        return lab__no_memory(err);
    }
    int alone = 0; // the first search has found the only cause
    status = explain(d, &before, &found, err);
    if (status == STEIN_OK) {
        alone = found.n == 1 && found.leader == d->suspect;
        status = found.n > 0 && found.leader != NULL ? diag__widths(found.end, err) : STEIN_OK;
    }
    if (status == STEIN_OK && found.n > 0 && found.leader != NULL) {
        progress(d, 0.9, "what of the strokes can be predicted");
        status = diag__settle(found.end, found.leader, err);
    }
    diag *last = found.n > 0 ? found.from[found.n - 1] : d;
    status = status == STEIN_OK ? diag__power(last, found.n > 0, err) : status;
    status = status == STEIN_OK ? diag__note(d, &found, err) : status;
    status = status == STEIN_OK ? diag__posteriors(d, alone, err) : status;
    progress(d, 0.92, "where the model departs");
    status = status == STEIN_OK ? show(d, &before, &found, err) : status;
    stein_status kept = keep_parts(d, &found, err);
    status = status == STEIN_OK ? kept : status;
    if (status == STEIN_OK && alone && o->nrival > 0) {
        progress(d, 0.95, "the next experiment");
        status = diag__next(d, err);
    }
    diag__found_free(&found);
    diag__held_free(&before);
    return status;
}

stein_status lab_diagnose(lab_diagnosis **out, const char *file, const lab_model *model,
                          const lab_dataset *data, const lab_diagnose_def *def, stein_err *err)
{
    lab_diagnose_def none = lab_diagnose_def_default();
    lab_dataset fit = {0, NULL}, held = {0, NULL};
    diag d = {.file = file, .model = model, .def = def != NULL ? def : &none};
    struct timespec begin, end;
    clock_gettime(CLOCK_MONOTONIC, &begin);
    d.out = calloc(1, sizeof *d.out);
    if (d.out == NULL) {
        return lab__no_memory(err);
    }
    progress(&d, 0.0, "audit");
    stein_status status = diag__check_without(&d, err);
    status = status == STEIN_OK ? split(&d, data, &fit, &held, err) : status;
    status = status == STEIN_OK ? audit(&d, data, err) : status;
    status = status == STEIN_OK ? make_problem(&d, err) : status;
    status = status == STEIN_OK ? diag__check_step(&d, err) : status;
    status = status == STEIN_OK ? search(&d, err) : status;
    status = status == STEIN_OK ? conclude(&d, err) : status;
    clock_gettime(CLOCK_MONOTONIC, &end);
    d.out->seconds =
        (double)(end.tv_sec - begin.tv_sec) + 1e-9 * (double)(end.tv_nsec - begin.tv_nsec);
    diag__law_free(&d);
    diag__close(&d);
    free(d.name);
    free(fit.stroke);
    free(held.stroke);
    if (status == STEIN_OK) {
        progress(&d, 1.0, "done");
        *out = d.out;
    } else {
        lab_diagnosis_destroy(d.out);
    }
    return status;
}
