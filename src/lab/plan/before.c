/* SPDX-License-Identifier: GPL-3.0-or-later
 * before.c - which causes planned records can separate.
 *
 *      records that are meant -> files, simulated with the file's numbers and noise
 *                             -> a diagnosis problem and its row without a cause (search/)
 *                             -> linear model of the row: information of every candidate
 *                             -> statements (before_information.c)
 *
 * Scatter between records may imitate a cause, for example a friction. So variances of scatter are
 * as large as a fit allows, and settings are uncertain within their digits: a fit without the cause
 * would make them so.
 *
 * Then the same once more with each thing that could be measured or done besides, as the plan of
 * the next experiment lists them (experiments.c). Such a thing is another channel in all records;
 * another setting, start, load or motion in one record more. A third of the records reports and is
 * not fitted, so it does not help to separate causes. An amount counts in the limit that its
 * candidate has in the records without them.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "diagnosis.h"
#include "functions.h"
#include "planning.h"

enum { SENSORS = 32 };
static const unsigned long first_seed = 20260101;
static const double one_record = 1.0, setting_up = 4.0; /* cost, as in plan.c */
static const double finer = 1.02; /* a ratio of amounts that is a difference */

/* candidates with the information of their columns */
typedef struct view {
    int n;
    lab_candidate *candidate; /* [n] */
    char **why;               /* [n] freed with it: why there is no column; NULL: there is */
    int ncolumn, *cause;      /* [ncolumn] */
    double *I;                /* [ncolumn*ncolumn] limits of `candidate` */
    lab_conditions conditions;
    long strokes;
} view;

typedef struct before {
    const char *file;
    const lab_model *model;
    const lab_before_def *def;
    char *folder;
    plan__meant *meant;
    int nmeant, nsensor;
    plan__sensor sensor[SENSORS + 1];
    view base;
} before;

int lab_before_told(const lab_before *b, int i, int j)
{
    size_t n = (size_t)b->ncolumn;
    return b->apart[(size_t)i * n + (size_t)j] <= 1.0 && b->apart[(size_t)j * n + (size_t)i] <= 1.0;
}

int lab_before_mistaken(const lab_before *b, int i, int j)
{
    double from = b->apart[(size_t)i * (size_t)b->ncolumn + (size_t)j];
    return i != j && from * b->cause[i].candidate.limit > b->cause[i].nameable;
}

/* ---- options ---- */

static stein_status read_noise(before *b, stein_err *err)
{
    const stein_model *m = lab_equations(b->model);
    stein_status status = STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < b->def->nnoise; i++) {
        const char *text = b->def->noise[i];
        size_t n = strcspn(text, "=");
        int k = 0;
        while (k < b->nsensor && (strlen(m->channels[b->sensor[k].channel].name) != n ||
                                  strncmp(m->channels[b->sensor[k].channel].name, text, n) != 0)) {
            k++;
        }
        if (text[n] != '=' || k == b->nsensor) {
            return lab__fail(err, STEIN_EINVAL,
                             "noise: \"%s\": expected CHANNEL=VALUE of a channel that is measured",
                             text);
        }
        status = lab_quantity(&b->sensor[k].noise, text + n + 1,
                              m->channels[b->sensor[k].channel].unit, err);
        if (status == STEIN_OK && !(b->sensor[k].noise > 0.0)) {
            status = lab__fail(err, STEIN_EINVAL, "noise: \"%s\": expected a positive value", text);
        }
    }
    return status;
}

static stein_status read_sensors(before *b, stein_err *err)
{
    const stein_model *m = lab_equations(b->model);
    if (b->def->nchannel < 1 || b->def->nchannel > SENSORS) {
        return lab__fail(err, STEIN_EINVAL, "channels: expected 1 to %d of them", (int)SENSORS);
    }
    for (int i = 0; i < b->def->nchannel; i++) {
        int k = stein_find_channel(m, b->def->channel[i]);
        if (k < 0) {
            return lab__fail(err, STEIN_ENAME, "channels: no output \"%s\" in %s",
                             b->def->channel[i], m->name);
        }
        for (int j = 0; j < b->nsensor; j++) {
            if (b->sensor[j].channel == k) {
                return lab__fail(err, STEIN_EINVAL, "channels: \"%s\" is there twice",
                                 b->def->channel[i]);
            }
        }
        b->sensor[b->nsensor++] = (plan__sensor){k, NAN};
    }
    return read_noise(b, err);
}

/* ---- records ---- */

static void remove_records(char **file, int n)
{
    for (int i = 0; file != NULL && i < n; i++) {
        if (file[i] != NULL) {
            unlink(file[i]);
        }
        free(file[i]);
    }
    free(file);
}

/* @param file  out: [n], for remove_records in any case */
static stein_status make_records(const before *b, const plan__meant *meant, int n,
                                 const plan__sensor *sensor, int nsensor, char ***file,
                                 lab_dataset **data, stein_err *err)
{
    lab_data_options options = lab_data_options_default(lab_equations(b->model));
    char **path = calloc((size_t)n + 1, sizeof *path);
    stein_status status = path != NULL ? STEIN_OK : lab__no_memory(err);
    *file = path;
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        path[i] = lab__text("%s/record%02d.csv", b->folder, i + 1);
        status = path[i] == NULL ? lab__no_memory(err)
                                 : plan__meant_write(path[i], &meant[i], b->model, sensor, nsensor,
                                                     first_seed + (unsigned long)i, err);
    }
    return status == STEIN_OK ? lab_dataset_open(data, (const char *const *)path, n, &options, err)
                              : status;
}

/* ---- a view ---- */

static void free_view(view *v)
{
    for (int i = 0; v->why != NULL && i < v->n; i++) {
        free(v->why[i]);
    }
    free(v->candidate);
    free(v->why);
    free(v->cause);
    free(v->I);
    free(v->conditions.channel);
    free(v->conditions.input);
    free(v->conditions.setting);
    *v = (view){.n = 0};
}

/* candidates of the problem in all records, with their columns */
static stein_status take_columns(view *v, const diag__problem *q, const diag__linear *l,
                                 stein_err *err)
{
    size_t n = (size_t)q->n + 1, all = (size_t)l->n;
    v->candidate = malloc(sizeof *v->candidate * n);
    v->why = calloc(n, sizeof *v->why);
    v->cause = malloc(sizeof *v->cause * (all + 1));
    v->I = malloc(sizeof *v->I * (all * all + 1));
    int *from = calloc(all + 1, sizeof *from);
    int ok = v->candidate && v->why && v->cause && v->I && from;
    for (int k = 0; ok && k < q->n; k++) {
        const char *why = q->untestable[k] != NULL ? q->untestable[k] : l->unseen[k];
        v->candidate[k] = q->candidate[k];
        v->why[k] = why != NULL ? lab__text("%s", why) : NULL;
        ok = why == NULL || v->why[k] != NULL;
        v->n = k + 1;
    }
    for (int c = 0; ok && c < l->n; c++) {
        if (l->cause[c] < q->n) {
            from[v->ncolumn] = c;
            v->cause[v->ncolumn++] = l->cause[c];
        }
    }
    for (int i = 0; ok && i < v->ncolumn; i++) {
        for (int j = 0; j < v->ncolumn; j++) {
            v->I[(size_t)i * (size_t)v->ncolumn + (size_t)j] =
                l->I[(size_t)from[i] * all + (size_t)from[j]];
        }
    }
    free(from);
    return ok ? STEIN_OK : lab__no_memory(err);
}

static stein_status linearise(view *v, diag__problem *q, stein_err *err)
{
    const diag__proposal null = {.parent = -1, .by = &diag__step_settings, .rough = 1};
    diag__table t = {.n = 0};
    diag__linear l = {.n = 0};
    diag__row *row = NULL;
    stein_status status = diag__evaluate(q, &t, &null, &row, err);
    if (status == STEIN_OK && row->failed != NULL) {
        status = lab__fail(err, STEIN_ENONFINITE, "%s", row->failed);
    }
    q->most_scatter = 1; // result of a fit without the cause
    if (status == STEIN_OK) {
        status = diag__linearise(q, row, 0.0, row->p.nstroke, &l, err);
    }
    status = status == STEIN_OK ? take_columns(v, q, &l, err) : status;
    status = status == STEIN_OK ? diag__conditions(&q->null, NULL, &v->conditions, err) : status;
    diag__linear_free(&l);
    diag__table_free(&t);
    return status;
}

/* @return OK, ENOMEM, what is wrong with the records; free_view in any case */
static stein_status look(const before *b, const plan__meant *meant, int n,
                         const plan__sensor *sensor, int nsensor, view *v, stein_err *err)
{
    lab_diagnose_def def = lab_diagnose_def_default();
    lab_dataset *data = NULL;
    char **file = NULL;
    diag__problem q = {.n = 0};
    def.threads = b->def->threads > 0 ? b->def->threads : 1;
    def.options = b->def->options;
    def.stop = b->def->stop;
    def.ctx = b->def->ctx;
    stein_status status = make_records(b, meant, n, sensor, nsensor, &file, &data, err);
    if (status == STEIN_OK) {
        status = diag__problem_open(&q, b->file, b->model, data, &def, err);
        status = status == STEIN_OK ? linearise(v, &q, err) : status;
        v->strokes = q.strokes + n;
        diag__problem_close(&q);
    }
    lab_dataset_close(data);
    remove_records(file, n);
    return status;
}

/* ---- statements ---- */

/* statements of a view about the causes of a plan, in limits of those */
static stein_status tell(const lab_before *o, const view *v, double *nameable, double *apart,
                         stein_err *err)
{
    size_t n = (size_t)v->ncolumn, used = 0;
    int *which = malloc(sizeof *which * (n + 1)), *from = malloc(sizeof *from * (n + 1));
    double *I = malloc(sizeof *I * (n * n + 1));
    if (which == NULL || from == NULL || I == NULL) {
        free(which);
        free(from);
        free(I);
        return lab__no_memory(err);
    }
    for (size_t c = 0; c < n; c++) {
        for (int k = 0; k < o->ncolumn; k++) {
            if (diag__is_same(&o->cause[k].candidate, &v->candidate[v->cause[c]])) {
                from[used] = (int)c;
                which[used++] = k;
            }
        }
    }
    for (size_t i = 0; i < used; i++) {
        for (size_t j = 0; j < used; j++) {
            double a = o->cause[which[i]].candidate.limit / v->candidate[v->cause[from[i]]].limit;
            double b = o->cause[which[j]].candidate.limit / v->candidate[v->cause[from[j]]].limit;
            I[i * used + j] = a * b * v->I[(size_t)from[i] * n + (size_t)from[j]];
        }
    }
    plan__tell(I, (int)used, which, o->ncolumn, nameable, apart);
    free(which);
    free(from);
    free(I);
    return STEIN_OK;
}

/* candidates of the base, those with a column first */
static stein_status list_causes(lab_before *o, const view *v, stein_err *err)
{
    o->cause = calloc((size_t)v->n + 1, sizeof *o->cause);
    if (o->cause == NULL) {
        return lab__no_memory(err);
    }
    for (int with = 1; with >= 0; with--) {
        for (int k = 0; k < v->n; k++) {
            int has = 0;
            for (int c = 0; c < v->ncolumn; c++) {
                has |= v->cause[c] == k;
            }
            if (has == with) {
                lab_before_cause *to = &o->cause[o->n++];
                *to = (lab_before_cause){.candidate = v->candidate[k], .nameable = NAN};
                snprintf(to->why, sizeof to->why, "%s",
                         has                 ? ""
                         : v->why[k] != NULL ? v->why[k]
                                             : "no column");
            }
        }
        o->ncolumn = with ? o->n : o->ncolumn;
    }
    return STEIN_OK;
}

static stein_status state(lab_before *o, const view *v, stein_err *err)
{
    stein_status status = list_causes(o, v, err);
    size_t n = (size_t)o->ncolumn;
    double *nameable = malloc(sizeof *nameable * (n + 1));
    o->apart = malloc(sizeof *o->apart * (n * n + 1));
    if (status == STEIN_OK && (nameable == NULL || o->apart == NULL)) {
        status = lab__no_memory(err);
    }
    status = status == STEIN_OK ? tell(o, v, nameable, o->apart, err) : status;
    for (int k = 0; status == STEIN_OK && k < o->ncolumn; k++) {
        o->cause[k].nameable = nameable[k] * o->cause[k].candidate.limit;
        o->cause[k].named = nameable[k] <= 1.0;
    }
    free(nameable);
    return status;
}

/* ---- additions ---- */

/* additional information of a view */
static stein_status compare(const lab_before *o, const view *v, lab_before_help *h, stein_err *err)
{
    size_t n = (size_t)o->ncolumn;
    double *nameable = malloc(sizeof *nameable * (n + n * n + 1)), *apart = nameable + n;
    stein_status status = nameable != NULL ? tell(o, v, nameable, apart, err) : lab__no_memory(err);
    double sum = 0.0;
    int counted = 0;
    for (size_t k = 0; status == STEIN_OK && k < n; k++) {
        const lab_before_cause *c = &o->cause[k];
        double ratio = c->nameable / (nameable[k] * c->candidate.limit);
        h->named += nameable[k] <= 1.0 && !c->named;
        for (size_t j = 0; j < k; j++) {
            h->told += apart[k * n + j] <= 1.0 && apart[j * n + k] <= 1.0 &&
                       !lab_before_told(o, (int)k, (int)j);
        }
        if (isfinite(ratio) && ratio > 0.0) {
            sum += stein__log_of(ratio);
            counted++;
            if (ratio > h->most_finer) {
                h->most_finer = ratio;
                snprintf(h->most, sizeof h->most, "%s at %s", c->candidate.effect->kind,
                         c->candidate.place);
            }
        }
    }
    for (int k = 0; k < v->n; k++) { // candidates that were invisible
        int seen = v->why[k] == NULL;
        for (int i = 0; seen && i < o->ncolumn; i++) {
            seen = !diag__is_same(&o->cause[i].candidate, &v->candidate[k]);
        }
        for (int c = 0; seen && c < v->ncolumn; c++) {
            double info = v->I[(size_t)c * (size_t)v->ncolumn + (size_t)c];
            if (v->cause[c] == k && info > 0.0 && diag__detectable(info) <= 1.0) {
                h->named++;
                seen = 0;
            }
        }
    }
    h->finer = counted > 0 ? stein__exp_of(sum / counted) : 1.0;
    free(nameable);
    return status;
}

static double worth(const lab_before_help *h)
{
    return (h->named + h->told) / h->cost;
}

/* worth most for its cost first */
static int before_other(const void *a, const void *b)
{
    const lab_before_help *x = a, *y = b;
    double u = worth(x), v = worth(y);
    return u != v                 ? (u < v) - (u > v)
           : x->finer != y->finer ? (x->finer < y->finer) - (x->finer > y->finer)
                                  : strcmp(x->name, y->name);
}

/* the records with the addition of an experiment, and its cost. @return number of records, 0: it
 * adds nothing that could be measured */
static int with_experiment(const before *b, const lab_experiment *e, plan__meant *meant,
                           plan__sensor *sensor, int *nsensor, double *cost)
{
    memcpy(meant, b->meant, sizeof *meant * (size_t)b->nmeant);
    memcpy(sensor, b->sensor, sizeof b->sensor);
    *nsensor = b->nsensor;
    if (e->ncheck > 0 || e->faster > 1) {
        return 0;
    }
    if (e->channel[0] != '\0') {
        int k = stein_find_channel(lab_equations(b->model), e->channel);
        sensor[(*nsensor)++] = (plan__sensor){k, e->noise};
        *cost = setting_up;
        return b->nmeant;
    }
    int like = 0; // one of them has the same settings
    for (int i = 0; i < e->nset; i++) {
        const lab_planned_set *s = plan__set_of(&b->meant[0].e, e->set[i].name);
        like += s != NULL;
    }
    meant[b->nmeant] = b->meant[0];
    meant[b->nmeant].e = *e;
    // settings of the records are replaced; anything else has to be arranged
    *cost = one_record + (e->nset > like || e->input[0] != '\0' ? setting_up : 0.0);
    return b->nmeant + 1;
}

static stein_status try_all(before *b, lab_before *o, const lab_experiment *e, int n,
                            stein_err *err)
{
    plan__meant *meant = malloc(sizeof *meant * (size_t)(b->nmeant + 1));
    o->help = calloc((size_t)n + 1, sizeof *o->help);
    stein_status status = meant != NULL && o->help != NULL ? STEIN_OK : lab__no_memory(err);
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        plan__sensor sensor[SENSORS + 1];
        view v = {.n = 0};
        stein_err why = {STEIN_OK, ""};
        int nsensor;
        lab_before_help *h = &o->help[o->nhelp];
        *h = (lab_before_help){.finer = 1.0};
        int records = with_experiment(b, &e[i], meant, sensor, &nsensor, &h->cost);
        if (b->def->progress != NULL) {
            b->def->progress(b->def->ctx, (1.0 + i) / (1.0 + n), "what would help");
        }
        if (records == 0) {
            continue;
        }
        snprintf(h->name, sizeof h->name, "%s%s", records > b->nmeant ? "one record more: " : "",
                 e[i].name);
        snprintf(h->why, sizeof h->why, "%s", e[i].why);
        status = look(b, meant, records, sensor, nsensor, &v, &why);
        o->strokes += v.strokes;
        o->ntried++;
        if (status == STEIN_OK) {
            status = compare(o, &v, h, err);
            o->nhelp += h->named + h->told > 0 || h->finer > finer;
        } else {
            status = fit__forgive(status, err); // it cannot be simulated
        }
        free_view(&v);
    }
    free(meant);
    if (status == STEIN_OK && o->nhelp > 1) {
        qsort(o->help, (size_t)o->nhelp, sizeof *o->help, before_other);
    }
    return status;
}

/* input of the planner of experiments for this mechanism, with the planned records */
static stein_status help(before *b, lab_before *o, stein_err *err)
{
    const stein_model *m = lab_equations(b->model);
    lab_diagnosis d = {.conditions = b->base.conditions};
    const lab_suspect none = {.amount = 0.0};
    const plan__model file = {.s = &none, .model = b->model};
    const lab_plan_def def = lab_plan_def_default();
    plan__reference reference = {.d = NULL};
    lab_experiment *e = NULL;
    int n = 0;
    stein_status status = plan__reference_make(&reference, &file, &d, m, &def, err);
    status = status == STEIN_OK ? plan__experiments(&reference, NULL, 0, &e, &n, err) : status;
    status = status == STEIN_OK ? try_all(b, o, e, n, err) : status;
    free(e);
    plan__reference_free(&reference);
    return status;
}

/* ---- the whole ---- */

/* the fitted part of a diagnosis */
static void keep_fitted(before *b)
{
    int n = b->nmeant;
    b->nmeant = 0;
    for (int i = 0; i < n; i++) {
        if (!diag__reports(i, n)) {
            b->meant[b->nmeant++] = b->meant[i];
        }
    }
}

static stein_status make(before *b, lab_before *o, stein_err *err)
{
    const stein_model *m = lab_equations(b->model);
    stein_status status = read_sensors(b, err);
    if (status == STEIN_OK) {
        status = plan__meant_read(b->def->records, m, &b->meant, &b->nmeant, err);
    }
    if (status == STEIN_OK) {
        o->records = b->nmeant;
        keep_fitted(b);
        status = look(b, b->meant, b->nmeant, b->sensor, b->nsensor, &b->base, err);
    }
    o->strokes = b->base.strokes;
    status = status == STEIN_OK ? state(o, &b->base, err) : status;
    return status == STEIN_OK && !b->def->no_help ? help(b, o, err) : status;
}

stein_status lab_before_make(lab_before **out, const char *file, const lab_model *model,
                             const lab_before_def *def, stein_err *err)
{
    const char *place = getenv("TMPDIR");
    before b = {.file = file, .model = model, .def = def};
    lab_before *o = calloc(1, sizeof *o);
    double begin = diag__clock();
    b.folder = lab__text("%s/stein-before-XXXXXX", place != NULL ? place : "/tmp");
    if (o == NULL || b.folder == NULL) {
        free(o);
        free(b.folder);
        return lab__no_memory(err);
    }
    stein_status status = mkdtemp(b.folder) != NULL
                              ? make(&b, o, err)
                              : lab__fail(err, STEIN_EIO, "%s cannot be made", b.folder);
    rmdir(b.folder);
    free(b.folder);
    free(b.meant);
    free_view(&b.base);
    o->seconds = diag__clock() - begin;
    if (status != STEIN_OK) {
        lab_before_destroy(o);
        return lab__stop_end(status, &(lab__stop){def->stop, def->ctx}, err);
    }
    *out = o;
    return STEIN_OK;
}

void lab_before_destroy(lab_before *o)
{
    if (o != NULL) {
        free(o->cause);
        free(o->apart);
        free(o->help);
        free(o);
    }
}
