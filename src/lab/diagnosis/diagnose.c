/* SPDX-License-Identifier: GPL-3.0-or-later
 * diagnose.c - from a mechanism file and strokes to a verdict.
 *
 *   audit       what the records say about themselves, before anything is fitted
 *   hold out    strokes that judge the end and that nothing is fitted to
 *   null fit    the model as it is: every number with a tolerance, every stroke's own (pursue.c)
 *   suspects    what every candidate would change (suspects.c)
 *   rank        whom the residual looks like (rank.c)
 *   refit       the best ones in full, then what could stand in their place (refine.c)
 *   held out    is anything gained where nothing was fitted (heldout.c)
 *   verdict     (verdict.c)
 *   show        where the model departs, and the force it lacks (departure.c, latent.c)
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "searching.h"

enum { FEWEST = 2, HOLD_EVERY = 3, SCATTER_FROM = 4, TRACES = 4, TRACES_HELD = 2 };
static const double offset_prior = 1e-3; /* [m] a marker is glued on by hand */
static const double tolerance = 1e-10;   /* of integration steps */

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
        return lab__fail(err, STEIN_ENOMEM, "out of memory");
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

static stein_status audit(diag *d, const lab_dataset *data, stein_err *err)
{
    stein_status status = STEIN_OK;
    lab_diagnosis *o = d->out;
    for (int s = 0; status == STEIN_OK && s < data->n; s++) {
        lab_audit *a = NULL;
        status = lab_audit_create(&a, data->stroke[s], err);
        for (int i = 0; status == STEIN_OK && i < a->nfinding; i++) {
            char **more = realloc(o->finding, sizeof *more * (size_t)(o->nfinding + 1));
            char *line = lab__text("%s: %s", data->stroke[s]->file, a->finding[i]);
            o->finding = more != NULL ? more : o->finding;
            if (more == NULL || line == NULL) {
                free(line);
                status = lab__fail(err, STEIN_ENOMEM, "out of memory");
            } else {
                o->finding[o->nfinding++] = line;
            }
        }
        lab_audit_destroy(a);
    }
    return status;
}

/* ---- the null fit's problem ---- */

/* every number whose tolerance the file states and that not every stroke sets */
static stein_status choose_names(diag *d, stein_err *err)
{
    const stein_model *m = lab_equations(d->model);
    d->name = malloc(sizeof *d->name * (size_t)(m->np + 1));
    if (d->name == NULL) {
        return lab__fail(err, STEIN_ENOMEM, "out of memory");
    }
    for (int i = 0; i < m->np; i++) {
        int known = 1;
        for (int s = 0; s < d->fit_data->n; s++) {
            known &= fit__is_set(d->fit_data->stroke[s], i);
        }
        if (m->params[i].tolerance > 0.0 && !known) {
            d->name[d->nname++] = m->params[i].name;
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
    status = fit__problem_make_open(&d->p, d->model, d->fit_data, &d->fit_def, err);
    if (status != STEIN_OK) {
        return status;
    }
    size_t rows = fit__offset(&d->p, d->p.nstroke);
    d->p.tolerance = tolerance;
    d->out->samples = d->p.samples;
    d->x = calloc((size_t)d->p.nu + 1, sizeof *d->x);
    d->J = malloc(sizeof *d->J * (fit__columns(&d->p) + 1));
    d->r = malloc(sizeof *d->r * (rows + 1));
    return d->x != NULL && d->J != NULL && d->r != NULL
               ? STEIN_OK
               : lab__fail(err, STEIN_ENOMEM, "out of memory");
}

/* ---- the search ---- */

static stein_status search(diag *d, stein_err *err)
{
    progress(d, 0.02, "parts that may be missing");
    stein_status status = diag__suspects(d, err);
    progress(d, 0.05, "fit of the model as it is");
    status = status == STEIN_OK ? diag__pursue(d, err) : status;
    progress(d, 0.35, "what every candidate would change");
    status = status == STEIN_OK ? diag__changes(d, err) : status;
    status = status == STEIN_OK ? diag__rank(d, err) : status;
    progress(d, 0.55, "fits with the best candidates");
    return status == STEIN_OK ? diag__refit(d, err) : status;
}

/* ---- results ---- */

static void note_number(const char *name, const char *unit, double value, double sd,
                        lab_suspect *to)
{
    lab_cause_number *n = &to->number[to->nnumber++];
    snprintf(n->name, sizeof n->name, "%s", name);
    n->unit = unit;
    n->value = value;
    n->lo = value - 1.96 * sd;
    n->hi = value + 1.96 * sd;
}

/* amount and second number of a refitted suspect */
static void note_numbers(diag *d, diag__suspect *s)
{
    fit__problem *p = diag__problem(d, s);
    const lab_candidate *c = &s->s.candidate;
    double wide = sqrt(diag__excess(d, s));
    fit__problem_try(p, c);
    note_number(c->effect->size, c->unit, s->x[p->amount] * c->limit,
                wide * s->sd[p->amount] * c->limit, &s->s);
    if (c->side >= 0) {
        const fit__unknown *u = &p->unknown[p->side];
        double value = fit__value(u, s->x[p->side]);
        const char *unit =
            c->side_unit != NULL ? c->side_unit : lab_equations(p->model)->params[c->side].unit;
        note_number(c->effect->side, unit, value,
                    fmin(1.0, wide * s->sd[p->side]) * u->sd * fabs(fit__slope(u, s->x[p->side])),
                    &s->s);
        s->s.candidate.side_value = value;
    }
    fit__problem_try(p, NULL);
}

static stein_status note_suspects(diag *d, stein_err *err)
{
    lab_diagnosis *o = d->out;
    double most = d->n > 0 ? d->suspect[0].s.gain : NAN;
    o->suspect = calloc((size_t)d->n + 1, sizeof *o->suspect);
    if (o->suspect == NULL) {
        return lab__fail(err, STEIN_ENOMEM, "out of memory");
    }
    for (int i = 0; i < d->n; i++) {
        diag__suspect *s = &d->suspect[i];
        if (s->s.refitted && isfinite(s->objective)) {
            note_numbers(d, s);
        }
        double gain = s->s.refitted ? s->s.gain : s->s.score;
        s->s.likeness = most > 0.0 && gain > 0.0 ? fmin(1.0, sqrt(gain / most)) : 0.0;
        o->suspect[i] = s->s;
    }
    o->nsuspect = d->n;
    o->p = d->p_value;
    return STEIN_OK;
}

/* the refitted numbers of the file, with the cause in the model if there is one */
static stein_status note_values(diag *d, const diag__suspect *cause, stein_err *err)
{
    lab_diagnosis *o = d->out;
    const fit__problem *p = cause != NULL ? diag__problem(d, (diag__suspect *)cause) : &d->p;
    const double *x = cause != NULL ? cause->x : d->x;
    const double *sd = cause != NULL ? cause->sd : d->sd;
    double wide = cause != NULL ? sqrt(diag__excess(d, cause)) : 1.0;
    const stein_model *m = lab_equations(d->model);
    o->value = calloc((size_t)p->np + 1, sizeof *o->value);
    if (o->value == NULL) {
        return lab__fail(err, STEIN_ENOMEM, "out of memory");
    }
    for (int k = 0; k < p->np; k++) {
        const fit__unknown *u = &p->unknown[k];
        if (u->kind != FIT__PARAM) {
            continue;
        }
        int param = stein_find_param(m, lab_equations(p->model)->params[u->index].name);
        if (param < 0) {
            continue; // the part's own
        }
        const stein_param *q = &m->params[param];
        lab_fit_value *v = &o->value[o->nvalue++];
        double value = fit__value(u, x[k]),
               in_sd = u->prior ? fmin(1.0, wide * sd[k]) : wide * sd[k];
        double s = in_sd * u->sd * fabs(fit__slope(u, x[k]));
        *v = (lab_fit_value){.name = q->name,
                             .unit = q->unit,
                             .param = param,
                             .logarithmic = u->log,
                             .start = q->value,
                             .value = value,
                             .sd = s,
                             .lo = value - 1.96 * s,
                             .hi = value + 1.96 * s,
                             .prior_sd = u->sd * fabs(fit__slope(u, 0.0)),
                             .data_sd = NAN};
    }
    for (int i = 0; i < DIAG_CLASSES; i++) {
        const double prior[] = {d->fit_def.joint_scatter, d->fit_def.contact_scatter,
                                d->fit_def.drive_scatter};
        const double *D = cause != NULL ? cause->D : d->null_D;
        o->scatter[i] = prior[i] * sqrt(D[i]);
    }
    return STEIN_OK;
}

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
    stein_status status = y != NULL ? STEIN_OK : lab__fail(err, STEIN_ENOMEM, "out of memory");
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

/* held-out strokes of the model with and without the best candidate, then the verdict */
static stein_status conclude_held(diag *d, diag__held *before, diag__held *after, stein_err *err)
{
    diag__suspect *best = d->n > 0 && d->suspect[0].s.refitted ? &d->suspect[0] : NULL;
    d->out->gain.ratio = d->out->gain.rmse_before = d->out->gain.rmse_after = NAN;
    d->out->gain.lo = d->out->gain.hi = NAN;
    if (d->held_data->n < 1) {
        diag__verdict(d, NAN, NAN);
        return STEIN_OK;
    }
    stein_err why = {STEIN_OK, ""};
    stein_status status = diag__held_out(d, NULL, before, &why);
    if (status == STEIN_OK && best != NULL && isfinite(best->objective)) {
        status = diag__held_out(d, best, after, &why);
        best->s.held_out = after->rmse;
    }
    if (status == STEIN_ENOMEM) {
        return lab__fail(err, status, "out of memory");
    }
    d->out->gain.ratio = after->rmse / before->rmse;
    diag__verdict(d, before->rmse, isfinite(after->rmse) ? after->rmse : before->rmse);
    return STEIN_OK;
}

static stein_status show(diag *d, diag__held *before, diag__held *after, stein_err *err)
{
    const fit__problem *p = &d->p;
    const diag__suspect *cause = d->out->ncause > 0 ? &d->suspect[0] : NULL;
    size_t frames = diag__row(p, p->nstroke),
           more = before->x != NULL ? diag__row(&before->p, before->p.nstroke) : 0;
    const char **phase = malloc(sizeof *phase * (frames + more + 1));
    double *time = malloc(sizeof *time * (frames + 1));
    stein_status status = phase != NULL && time != NULL
                              ? diag__phases(p, d->x, phase, time, err)
                              : lab__fail(err, STEIN_ENOMEM, "out of memory");
    if (status == STEIN_OK && more > 0) {
        status = diag__phases(&before->p, before->x, phase + frames, NULL, err);
    }
    if (status == STEIN_OK && cause != NULL) {
        d->out->phase = diag__phase_shown(p, d->r, cause->r, phase);
    }
    status = status == STEIN_OK
                 ? traces(d, p, d->r, cause != NULL ? cause->r : NULL, phase, 0, TRACES, err)
                 : status;
    if (status == STEIN_OK && more > 0) {
        const diag__held *end = cause != NULL && after->x != NULL ? after : before;
        status = traces(d, &before->p, before->r, end != before ? end->r : NULL, phase + frames, 1,
                        TRACES_HELD, err);
        status = status == STEIN_OK ? diag__gain(d->out, before, end, phase + frames, err) : status;
    }
    status =
        status == STEIN_OK ? diag__show(d->out, p, d->x, d->r, d->J, phase, time, err) : status;
    free(phase);
    free(time);
    return status;
}

static stein_status conclude(diag *d, stein_err *err)
{
    diag__held before = {.x = NULL, .rmse = NAN}, after = {.x = NULL, .rmse = NAN};
    d->sd = calloc((size_t)d->p.np + 1, sizeof *d->sd);
    if (d->sd == NULL) {
        return lab__fail(err, STEIN_ENOMEM, "out of memory");
    }
    double D[LAB_SCATTERS];
    diag__likelihood(&d->p, d->x, d->J, d->r, D, d->sd);
    progress(d, 0.85, "strokes that were held out");
    stein_status status = conclude_held(d, &before, &after, err);
    diag__suspect *cause = d->out->ncause > 0 ? &d->suspect[0] : NULL;
    status = status == STEIN_OK ? note_suspects(d, err) : status;
    status = status == STEIN_OK ? note_values(d, cause, err) : status;
    progress(d, 0.92, "where the model departs");
    status = status == STEIN_OK ? show(d, &before, &after, err) : status;
    if (status == STEIN_OK && cause != NULL && cause->model != NULL) {
        d->out->extended_model = cause->model;
        cause->model = NULL;
    }
    d->out->noise_floor = 1.0;
    diag__held_free(&before);
    diag__held_free(&after);
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
        return lab__fail(err, STEIN_ENOMEM, "out of memory");
    }
    progress(&d, 0.0, "audit");
    stein_status status = split(&d, data, &fit, &held, err);
    status = status == STEIN_OK ? audit(&d, data, err) : status;
    status = status == STEIN_OK ? make_problem(&d, err) : status;
    status = status == STEIN_OK ? search(&d, err) : status;
    status = status == STEIN_OK ? conclude(&d, err) : status;
    clock_gettime(CLOCK_MONOTONIC, &end);
    d.out->seconds =
        (double)(end.tv_sec - begin.tv_sec) + 1e-9 * (double)(end.tv_nsec - begin.tv_nsec);
    diag__suspects_free(&d);
    fit__problem_free(&d.p);
    free(d.x);
    free(d.J);
    free(d.r);
    free(d.sd);
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
