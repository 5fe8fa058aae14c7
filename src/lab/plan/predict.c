/* SPDX-License-Identifier: GPL-3.0-or-later
 * predict.c - prediction of an experiment by the cause or a rival.
 *
 * The experiment becomes a stroke like any other: its settings, its clock, the driven input and
 * channels without values; their residual is the prediction. So its uncertain quantities (trigger,
 * offsets, initial state, scatter) are the unknowns of a fit, with the same priors and derivatives.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <gsl/gsl_linalg.h>

#include "data_internal.h"
#include "functions.h"
#include "planning.h"
#include "added_parts.h"
#include "verdict.h"

enum { MOST_ROWS = 4000 };
static const double offset_prior = 1e-3;   /* [m] as in a diagnosis */
static const double tolerance = 1e-10;     /* of integration steps */
static const double unknown_start = 100.0; /* of an initial speed without prior, in its scale */
static const double least_step = 1e-6, most_step = 0.05; /* of differences, in prior sd */

enum { WAYS = 6 };
static const double small = 0.1;       /* part of the uncertainty */
static const double unpredicted = 0.1; /* of a stroke's chi2, as where the numbers come from */

double lab_shape_at(lab_shape shape, double time, double t)
{
    static const double pi = 3.14159265358979323846;
    double s = time > 0.0 ? fmax(t / time, 0.0) : 1.0;
    if (shape == LAB_SHAPE_SWING) {
        return s < 2.0 ? stein__sin(pi * s) : 0.0;
    }
    s = shape == LAB_SHAPE_BACK && s > 1.0 ? fmax(2.0 - s, 0.0) : fmin(s, 1.0);
    return shape == LAB_SHAPE_NONE ? 0.0 : s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
}

/* ---- the sides ---- */

stein_status plan__model_open(plan__model *side, const lab_suspect *s, const char *file,
                              const lab_model *model, const lab_options *options, stein_err *err)
{
    const lab_posterior *q = &s->posterior;
    *side = (plan__model){.s = s, .candidate = {s->candidate}, .n = 1, .model = model};
    int parts = s->candidate.effect->needs != NULL;
    for (int i = 0; i < q->nbeside && side->n < FIT__ACCEPTED; i++) {
        parts |= q->beside[i].effect->needs != NULL;
        side->candidate[side->n++] = q->beside[i];
    }
    stein_status status =
        parts ? lab__open_with(&side->own, file, side->candidate, side->n, options, err) : STEIN_OK;
    side->model = parts ? side->own : model;
    for (int i = 0; status == STEIN_OK && i < side->n; i++) {
        status = lab_candidate_bind(&side->candidate[i], side->model, err);
    }
    for (int i = 0; i < q->n; i++) {
        int place, k;
        if (diag__find_number(q->number[i].name, &place, &k) && k > 0 && place < side->n) {
            side->candidate[place].side[k - 1].value = q->number[i].value;
        }
    }
    return status;
}

void plan__model_apply(const plan__model *side, int which, double by, double *p)
{
    const lab_posterior *q = &side->s->posterior;
    for (int i = 0; i < q->n; i++) {
        const struct lab_uncertain *u = &q->number[i];
        int place, k;
        if (!diag__find_number(u->name, &place, &k) || k > 0 || place >= side->n) {
            continue;
        }
        double off = place == which ? by * u->sd : 0.0;
        lab_candidate_apply(&side->candidate[place],
                            u->logarithmic ? u->value * stein__exp_of(off) : u->value + off, p);
    }
}

void plan__model_close(plan__model *side)
{
    lab_close(side->own);
    side->own = NULL;
}

/* ---- the stroke ---- */

static void blank_free(plan__blank *b)
{
    free(b->column);
    free(b->setting);
    free(b->time);
    free(b->present);
}

static stein_status blank_make(plan__blank *b, const plan__reference *reference,
                               const stein_model *m, const lab_experiment *e, stein_err *err)
{
    const lab_conditions *c = &reference->d->conditions;
    double interval = c->interval / e->faster;
    int rows = (int)fmin(MOST_ROWS * e->faster, floor((c->until - c->from) / interval + 1.5));
    size_t n = (size_t)rows, ncolumn = (size_t)reference->noutput + 1;
    b->column = calloc(ncolumn, sizeof *b->column);
    b->setting = calloc((size_t)e->nset + 1, sizeof *b->setting);
    b->time = calloc(3 * n, sizeof *b->time);
    b->present = malloc(n);
    if (!b->column || !b->setting || !b->time || !b->present) {
        return lab__no_memory(err);
    }
    b->value = b->time + n;
    b->zero = b->value + n;
    memset(b->present, 1, n);
    for (int i = 0; i < rows; i++) {
        b->time[i] = c->from + interval * i;
        b->value[i] = e->zero + e->size * lab_shape_at(e->shape, e->time, b->time[i]);
    }
    b->data.file = "an experiment";
    b->data.planned = 1;
    b->data.model = m;
    b->data.nrow = rows;
    b->data.time = b->time;
    b->data.column = b->column;
    b->data.set = b->setting;
    b->data.trigger = c->unsynchronised ? LAB_TRIGGER_UNSYNCHRONISED : LAB_TRIGGER_UNSTATED;
    for (int i = 0; i < e->nset; i++) {
        int param = stein_find_param(m, e->set[i].name);
        if (param < 0 && lab__comes_off(m, e->set[i].name) != NULL) {
            continue; // this side has none
        }
        if (param < 0) {
            return lab__fail(err, STEIN_ENAME, "no parameter \"%s\"", e->set[i].name);
        }
        const char *name = m->params[param].name;
        b->setting[b->data.nset++] =
            (lab_setting){name, param, e->set[i].value, 1, 1, data__has_last_word(m, name), 0.0};
    }
    if (e->input[0] != '\0') {
        int input = stein_find_input(m, e->input);
        if (input < 0) {
            return lab__fail(err, STEIN_ENAME, "no input \"%s\"", e->input);
        }
        b->column[b->data.ncolumn++] = (lab_column){.name = m->inputs[input].name,
                                                    .unit = m->inputs[input].unit,
                                                    .role = LAB_INPUT,
                                                    .index = input,
                                                    .value = b->value,
                                                    .present = b->present,
                                                    .samples = rows,
                                                    .noise = 1e-12,
                                                    .line = 1,
                                                    .column = 1};
    }
    for (int i = 0; i < reference->noutput; i++) {
        int k = stein_find_channel(m, reference->output[i].name);
        if (k < 0) {
            return lab__fail(err, STEIN_ENAME, "no output \"%s\"", reference->output[i].name);
        }
        b->column[b->data.ncolumn++] = (lab_column){.name = m->channels[k].name,
                                                    .unit = m->channels[k].unit,
                                                    .role = LAB_OUTPUT,
                                                    .index = k,
                                                    .value = b->zero,
                                                    .present = b->present,
                                                    .samples = rows,
                                                    .noise = reference->output[i].noise,
                                                    .line = 1,
                                                    .column = 1};
    }
    b->list[0] = &b->data;
    b->set = (lab_dataset){1, b->list};
    return STEIN_OK;
}

/* ---- uncertainty ---- */

/* numbers of the posterior in the order of the problem's unknowns; of[k] -1: known by now */
static int unknowns(const fit__problem *p, const lab_posterior *q, int *of)
{
    const stein_model *m = lab_equations(p->model);
    int found = 0;
    for (int k = 0; k < p->np; k++) {
        const fit__unknown *u = &p->unknown[k];
        char name[LAB_PLACE];
        if (u->kind == FIT__PARAM) {
            snprintf(name, sizeof name, "%s", m->params[u->index].name);
        } else {
            diag__number_name(name, (k - p->first_accepted) / FIT__NUMBERS, 1 + u->index);
        }
        of[k] = -1;
        for (int i = 0; !u->idle && i < q->n; i++) {
            of[k] = strcmp(q->number[i].name, name) == 0 ? i : of[k];
        }
        found += of[k] >= 0;
    }
    return found;
}

/* x and steps of the unknowns in the posterior */
static void place(fit__problem *p, const lab_posterior *q, const int *of, double *x)
{
    memset(x, 0, sizeof *x * (size_t)p->nu);
    for (int k = 0; k < p->np; k++) {
        if (of[k] >= 0) {
            const fit__unknown *u = &p->unknown[k];
            const struct lab_uncertain *n = &q->number[of[k]];
            double z = u->log ? stein__log_of(n->value) : n->value;
            x[k] = (z - u->start) / u->sd;
            p->step[k] = fmin(fmax(0.5 * n->sd / u->sd, least_step), most_step);
        }
    }
}

/* D: columns of J; L: the Cholesky factor of the posterior's covariance; P of both; way
 * [np][p->np]: the number of each column of P */
static stein_status spread(plan__prediction *v, const fit__problem *p, const lab_posterior *q,
                           const int *of, const double *J, double *way, stein_err *err)
{
    size_t n = (size_t)v->noutput * (size_t)v->rows, np = (size_t)v->np;
    int *at = calloc((size_t)p->np + 1, sizeof *at), k = 0;
    gsl_matrix *C = gsl_matrix_alloc(np + 1, np + 1);
    if (at == NULL || C == NULL) {
        free(at);
        gsl_matrix_free(C);
        return lab__no_memory(err);
    }
    for (int i = 0; i < p->np; i++) {
        if (of[i] >= 0) {
            at[k++] = i;
        }
    }
    gsl_matrix_view c = gsl_matrix_submatrix(C, 0, 0, np > 0 ? np : 1, np > 0 ? np : 1);
    for (size_t a = 0; a < np; a++) {
        for (size_t b = 0; b < np; b++) {
            double r = q->correlation[of[at[a]] * q->n + of[at[b]]];
            gsl_matrix_set(C, a, b, a == b ? 1.0 + 1e-10 : r);
        }
    }
    int ok = np == 0 || gsl_linalg_cholesky_decomp1(&c.matrix) == 0;
    for (size_t a = 0; ok && a < np; a++) {
        double sd = q->number[of[at[a]]].sd / p->unknown[at[a]].sd;
        const double *j = J + fit__column(p, 0, at[a]);
        v->name[a] = q->number[of[at[a]]].name;
        for (size_t i = 0; i < n; i++) {
            v->D[a * n + i] = -j[i];
        }
        for (size_t b = 0; b <= a; b++) { // lower
            v->L[b * np + a] = way[b * (size_t)p->np + (size_t)at[a]] =
                sd * gsl_matrix_get(C, a, b);
        }
    }
    if (ok) {
        plan__spread(v->P, v, v);
    }
    free(at);
    gsl_matrix_free(C);
    return ok ? STEIN_OK : lab__fail(err, STEIN_EINVAL, "the correlations of its numbers are none");
}

/* Z: the stroke's own */
static void own_columns(plan__prediction *v, const fit__problem *p, const double *scatter,
                        const double *J, double *own)
{
    size_t n = (size_t)v->noutput * (size_t)v->rows;
    for (int k = 0; k < v->nz; k++) {
        const fit__unknown *u = &p->unknown[p->stroke[0].first + k];
        double by = u->kind == FIT__SCATTER ? scatter[fit__class(u->index) - FIT__JOINTS] / u->sd
                    : u->prior              ? 1.0
                                            : unknown_start;
        own[k] = by;
        const double *j = J + fit__column(p, 0, p->np + k);
        for (size_t i = 0; i < n; i++) {
            v->Z[(size_t)k * n + i] = -by * j[i];
        }
    }
}

/* ---- predictable part ---- */

/* +1 or -1, of a Walsh function */
static double sign_of(int way, int column)
{
    int bits = way & column, odd = 0;
    for (; bits != 0; bits >>= 1) {
        odd ^= bits & 1;
    }
    return odd ? -1.0 : 1.0;
}

/* the first row by which r has left y and P, a small way along all columns, for good */
static int leaves(const plan__prediction *v, const plan__reference *b, int way, const double *r)
{
    size_t n = (size_t)v->noutput * (size_t)v->rows;
    double sum = 0.0;
    for (int i = 0; i < v->rows; i++) {
        for (int c = 0; c < v->noutput; c++) {
            size_t at = (size_t)c * (size_t)v->rows + (size_t)i;
            double e = b->output[c].measured ? r[at] - v->y[at] : 0.0;
            for (int k = 0; b->output[c].measured && k < v->np; k++) {
                e += small * sign_of(way, k) * v->P[(size_t)k * n + at];
            }
            sum += e * e;
        }
        if (!(sum < unpredicted)) {
            return i;
        }
    }
    return v->rows;
}

/* After an event that may as well not happen (one more bounce, a pawl that just catches) a stroke
 * is more sensitive to its numbers than their uncertainty, and its prediction is no evidence about
 * the model. The stroke ends where a small part of the uncertainty gives a motion that differs from
 * the linear prediction. The numbers have been found from strokes that end so (equilibrium.c).
 */
static stein_status foresee(plan__prediction *v, plan__reference *b, const fit__problem *p,
                            const double *x, const double *way, stein_err *err)
{
    size_t n = (size_t)v->rows * (size_t)v->noutput;
    double *to = malloc(sizeof *to * ((size_t)p->nu + 1)), *r = malloc(sizeof *r * (n + 1));
    stein_status status = to != NULL && r != NULL ? STEIN_OK : lab__no_memory(err);
    for (int w = 0; status == STEIN_OK && w < WAYS; w++) {
        int failed = 0;
        memcpy(to, x, sizeof *to * (size_t)p->nu);
        for (int k = 0; k < v->np; k++) {
            for (int i = 0; i < p->np; i++) {
                to[i] += small * sign_of(w, k) * way[k * p->np + i];
            }
        }
        b->strokes++;
        status = fit__residuals(p, to, r, &failed, err);
        int until = status != STEIN_OK || failed > 0 ? 0 : leaves(v, b, w, r);
        v->until = until < v->until ? until : v->until;
    }
    free(to);
    free(r);
    return status;
}

/* ---- predicting ---- */

static void stage_free(plan__stage *s)
{
    if (s != NULL) {
        fit__problem_free(&s->p);
        blank_free(&s->stroke);
        free(s->x);
        free(s->way);
        free(s->own);
        free(s);
    }
}

static stein_status view_make(plan__prediction *v, const plan__reference *b, const fit__problem *p,
                              int np, stein_err *err)
{
    const fit__stroke *t = &p->stroke[0];
    v->rows = v->until = t->n;
    v->noutput = b->noutput;
    v->np = np;
    v->nz = t->own;
    size_t n = (size_t)v->rows * (size_t)v->noutput;
    v->y = calloc(n + 1, sizeof *v->y);
    v->P = calloc(n * (size_t)np + 1, sizeof *v->P);
    v->D = calloc(n * (size_t)np + 1, sizeof *v->D);
    v->L = calloc((size_t)(np * np) + 1, sizeof *v->L);
    v->name = calloc((size_t)np + 1, sizeof *v->name);
    v->Z = calloc(n * (size_t)v->nz + 1, sizeof *v->Z);
    v->time = calloc((size_t)v->rows + 1, sizeof *v->time);
    if (!v->y || !v->P || !v->D || !v->L || !v->name || !v->Z || !v->time) {
        return lab__no_memory(err);
    }
    memcpy(v->time, t->data->time, sizeof *v->time * (size_t)v->rows);
    return STEIN_OK;
}

void plan__prediction_free(plan__prediction *v)
{
    free(v->y);
    free(v->P);
    free(v->D);
    free(v->L);
    free(v->name);
    free(v->Z);
    free(v->time);
    stage_free(v->stage);
    *v = (plan__prediction){.y = NULL};
}

static stein_status run(plan__prediction *v, plan__reference *b, const plan__model *side,
                        int only_y, stein_err *err)
{
    const lab_posterior *q = &side->s->posterior;
    plan__stage *s = v->stage;
    fit__problem *p = &s->p;
    int *of = calloc((size_t)p->np + 1, sizeof *of), failed = 0;
    double *J = NULL;
    p->tolerance = tolerance;
    p->central = !b->def->quick;
    s->x = malloc(sizeof *s->x * ((size_t)p->nu + 1));
    if (of == NULL || s->x == NULL) {
        free(of);
        return lab__no_memory(err);
    }
    int np = unknowns(p, q, of);
    stein_status status = view_make(v, b, p, np, err);
    if (status == STEIN_OK) {
        place(p, q, of, s->x);
        b->strokes++;
        status = fit__residuals(p, s->x, v->y, &failed, err);
    }
    if (status == STEIN_OK && failed > 0) {
        status = lab__fail(err, STEIN_ENONFINITE, "it cannot be simulated");
    }
    if (status == STEIN_OK && !only_y) {
        J = malloc(sizeof *J * (fit__columns(p) + 1));
        b->strokes += 2 * (np + v->nz);
        s->way = calloc((size_t)(np * p->np) + 1, sizeof *s->way);
        s->own = calloc((size_t)v->nz + 1, sizeof *s->own);
        status = J != NULL && s->way != NULL && s->own != NULL
                     ? fit__sensitivities(p, s->x, v->y, J, err)
                     : lab__no_memory(err);
    }
    if (status == STEIN_OK && J != NULL) {
        status = spread(v, p, q, of, J, s->way, err);
        own_columns(v, p, b->d->scatter, J, s->own);
        status = status == STEIN_OK ? foresee(v, b, p, s->x, s->way, err) : status;
    }
    for (int i = 0; status == STEIN_OK && i < v->rows * v->noutput; i++) {
        v->y[i] = -v->y[i]; // the residual of nothing
    }
    free(of);
    free(J);
    return status;
}

stein_status plan__predict(plan__prediction *v, plan__reference *b, const plan__model *side,
                           const lab_experiment *e, int only_y, stein_err *err)
{
    const stein_model *m = lab_equations(side->model);
    const lab_posterior *q = &side->s->posterior;
    const char **name = malloc(sizeof *name * ((size_t)q->n + 1));
    *v = (plan__prediction){.stage = calloc(1, sizeof *v->stage)};
    stein_status status = name != NULL && v->stage != NULL
                              ? blank_make(&v->stage->stroke, b, m, e, err)
                              : lab__no_memory(err);
    lab_fit_def def = lab_fit_def_default();
    for (int i = 0; name != NULL && i < q->n; i++) {
        const char *n = q->number[i].name;
        int place, k;
        if (!diag__find_number(n, &place, &k) && plan__set_of(e, n) == NULL) {
            name[def.nfree++] = n;
        }
    }
    def.free = name;
    def.offset = offset_prior;
    def.scatter = 1;
    def.threads = b->def->threads;
    def.stop = b->def->stop;
    def.ctx = b->def->ctx;
    if (status == STEIN_OK) {
        fit__problem *p = &v->stage->p;
        status = fit__problem_make_with(p, side->model, &v->stage->stroke.set, &def,
                                        side->candidate, side->n, err);
        status = status == STEIN_OK ? run(v, b, side, only_y, err) : status;
    }
    free(name);
    return status;
}
