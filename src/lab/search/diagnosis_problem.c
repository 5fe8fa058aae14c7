/* SPDX-License-Identifier: GPL-3.0-or-later
 * diagnosis_problem.c - the records, the null hypothesis, and the mechanisms that hold causes.
 *
 * The file's numbers with a tolerance are unknowns of every hypothesis. A candidate
 * (candidate_list.c) that needs a part acts in a mechanism of its own, which is written, generated
 * and compiled when the first hypothesis asks for it, and kept.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "data_cut.h"
#include "search.h"
#include "added_parts.h"

static const double offset_prior = 1e-3; /* [m] a marker is glued on by hand */
/* A step's error in shares of the noise: differences of records see a tenth of the noise (fit/
 * sensitivity.c) and have to be right to a percent. */
static const double step_error = 1e-3, finest = 1e-11, coarsest = 1e-9;

double diag__clock(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

int diag__is_spent(const diag__problem *q)
{
    return (q->most_strokes > 0 && q->strokes >= q->most_strokes) ||
           (q->most_seconds > 0.0 && diag__clock() - q->begin >= q->most_seconds);
}

double diag__tolerance_of(const fit__problem *p)
{
    double least = INFINITY;
    for (int s = 0; s < p->nstroke; s++) {
        for (int c = 0; c < p->stroke[s].nch; c++) {
            int force = lab_equations(p->model)->channels[p->stroke[s].channel[c]].read ==
                        STEIN_READ_INPUT_FORCE;
            least = force ? least : fmin(least, p->stroke[s].noise[c]);
        }
    }
    return fmin(fmax(step_error * least, finest), coarsest);
}

int diag__is_same(const lab_candidate *a, const lab_candidate *b)
{
    return a->effect == b->effect && strcmp(a->place, b->place) == 0 && a->from == b->from &&
           a->until == b->until;
}

int diag__related(const lab_candidate *a, const lab_candidate *b)
{
    size_t n = strcspn(a->place, ".");
    return n == strcspn(b->place, ".") && strncmp(a->place, b->place, n) == 0;
}

/* ---- numbers that are fitted anyhow ---- */

static int is_of(const char *name, const char *owner)
{
    size_t n = strlen(owner);
    return strncmp(name, owner, n) == 0 && name[n] == '.';
}

/* Is it of a contact, a notch or a law of friction, whose numbers are estimates? */
static int is_law(const stein_model *m, const stein_param *q)
{
    int of = strstr(q->name, ".damping") != NULL || strstr(q->name, ".coulomb.") != NULL ||
             strstr(q->name, ".friction.") != NULL;
    for (int i = 0; i < m->ncontact; i++) {
        of |= is_of(q->name, m->contacts[i].name);
    }
    for (int i = 0; i < m->nnotch; i++) {
        of |= is_of(q->name, m->notches[i].name);
    }
    return of && strcmp(q->unit, "m") != 0;
}

/* Standard deviation of a number that was measured with a ruler or on a kitchen scale, computed
 * from both, or estimated, as those of laws are. @return 0: it is of another kind */
static double by_ruler(const stein_model *m, const stein_param *q)
{
    static const struct {
        const char *unit;
        double share, least;
    } by[] = {
        {"m", 0.003, 2e-4},     {"kg", 0.005, 0.0}, {"kg m^2", 0.02, 0.0}, {"N/m", 0.02, 0.0},
        {"N m/rad", 0.02, 0.0}, {"Hz", 0.01, 0.0}}; // of a pendulum test: its swings are counted
    static const char *const other[] = {".initial.", ".sensor.",   "load.",      "gravity.",
                                        "clock.",    ".vt",        ".coulomb.w", ".facing",
                                        ".extent",   ".direction."};
    int is = q->stated && q->value != 0.0 && !lab__is_in_table(m, q->name);
    for (size_t k = 0; k < sizeof other / sizeof *other; k++) {
        is = is && strstr(q->name, other[k]) == NULL;
    }
    if (is && is_law(m, q)) {
        return 0.05 * fabs(q->value);
    }
    for (size_t k = 0; is && k < sizeof by / sizeof *by; k++) {
        if (strcmp(q->unit, by[k].unit) == 0) {
            return hypot(by[k].share * q->value, by[k].least);
        }
    }
    return 0.0;
}

static int states_any(const stein_model *m)
{
    int any = 0;
    for (int i = 0; i < m->np; i++) {
        any |= m->params[i].tolerance > 0.0 && by_ruler(m, &m->params[i]) > 0.0;
    }
    return any;
}

int diag__name_of(const diag__problem *q, const char *name)
{
    int k = 0;
    // NOLINTNEXTLINE(clang-analyzer-core.NonNullParamChecker): nname names are there
    while (k < q->nname && strcmp(q->name[k], name) != 0) {
        k++;
    }
    return k < q->nname ? k : -1;
}

int diag__has_tolerance(const diag__problem *q, int param)
{
    const stein_param *of = &lab_equations(q->model)->params[param];
    int k = diag__name_of(q, of->name);
    return of->tolerance > 0.0 || (k >= 0 && q->name_sd[k] > 0.0);
}

/* Every number with a tolerance that not every record sets, and what the caller wants free;
 * fit__problem_make names one that is unknown. A file that states no tolerance at all is not exact
 * to the last digit: what is measured with a ruler or a scale gets that tolerance. */
static stein_status choose_names(diag__problem *q, stein_err *err)
{
    const stein_model *m = lab_equations(q->model);
    size_t most = 2 * (size_t)m->np + (size_t)q->def->nfree + 1;
    int rough = !states_any(m);
    q->name = calloc(most, sizeof *q->name);
    q->name_sd = calloc(most, sizeof *q->name_sd);
    q->body_sd = malloc(sizeof *q->body_sd * most);
    if (q->name == NULL || q->name_sd == NULL || q->body_sd == NULL) {
        return lab__no_memory(err);
    }
    for (int i = 0; i < m->np; i++) {
        double sd = rough ? by_ruler(m, &m->params[i]) : 0.0;
        int stated = m->params[i].tolerance > 0.0;
        if ((stated || sd > 0.0) && !fit__always_set(q->fitted, i)) {
            q->assumed += !stated;
            q->name_sd[q->nname] = stated ? 0.0 : sd;
            q->name[q->nname++] = m->params[i].name;
        }
    }
    for (int k = 0; k < q->def->nfree; k++) {
        int i = stein_find_param(m, q->def->free[k]);
        if (i < 0 || !diag__has_tolerance(q, i)) {
            q->name[q->nname++] = q->def->free[k];
        }
    }
    return STEIN_OK;
}

/* bands of measured motions: as they are stated, or as the measured forces have it */
static stein_status choose_bands(diag__problem *q, stein_err *err)
{
    int n = lab_equations(q->model)->ninput;
    if (q->def->smooth > 0.0) {
        return STEIN_OK;
    }
    stein_status status = fit__choose_bands(&q->null, q->smooth, err);
    q->fit_def.smooth = status == STEIN_OK && n > 0 ? q->smooth : NULL;
    return status == STEIN_OK && n > 0 ? diag__problem_null(q, err) : status;
}

/* what is stated of the bands before they are chosen */
static stein_status state_bands(diag__problem *q, stein_err *err)
{
    int n = lab_equations(q->model)->ninput;
    q->smooth = malloc(sizeof *q->smooth * ((size_t)n + 1));
    if (q->smooth == NULL) {
        return lab__no_memory(err);
    }
    for (int i = 0; i < n && q->def->smooth > 0.0; i++) {
        q->smooth[i] = q->def->smooth;
        q->fit_def.smooth = q->smooth;
        q->fit_def.smooth_all = 1;
    }
    return STEIN_OK;
}

stein_status diag__problem_null(diag__problem *q, stein_err *err)
{
    fit__problem_free(&q->null);
    diag__kept_free(q->kept); // of other numbers
    q->kept = NULL;
    q->fit_def.free = q->name;
    q->fit_def.nfree = q->nname;
    q->fit_def.tolerance = q->name_sd;
    q->rough_def = q->fit_def;
    q->rough_def.settings = 1;
    stein_status status =
        fit__problem_make_with(&q->null, q->model, q->fitted, &q->fit_def, NULL, 0, err);
    status = status == STEIN_OK ? fit__check_samples(&q->null, err) : status;
    q->null.simulated = &q->strokes;
    if (status == STEIN_OK) {
        q->null.tolerance = diag__tolerance_of(&q->null);
        q->null.stride = diag__stride_of(&q->null);
    }
    return status;
}

stein_status diag__know_forces(diag__problem *q, const lab_dataset *records, stein_err *err)
{
    fit__problem p = {.nstroke = 0};
    stein_status status = fit__problem_make_with(&p, q->model, records, &q->fit_def, NULL, 0, err);
    p.tolerance = q->null.tolerance;
    p.simulated = &q->strokes;
    status = status == STEIN_OK ? fit__force_errors_add(&q->forces, &p, err) : status;
    fit__problem_free(&p);
    return status;
}

/* the noise of measured forces as unknowns of the records, where it matters */
static stein_status take_forces(diag__problem *q, stein_err *err)
{
    stein_status status = diag__know_forces(q, q->fitted, err);
    fit__force_errors_share(&q->forces, &q->input_share, &q->input_noise);
    if (status == STEIN_OK && q->forces.n > 0) {
        q->fit_def.force_errors = &q->forces;
        status = diag__problem_null(q, err);
    }
    return status;
}

static stein_status open_null(diag__problem *q, stein_err *err)
{
    q->fit_def = lab_fit_def_default();
    q->fit_def.offset = offset_prior;
    q->fit_def.threads = q->def->threads > 0 ? q->def->threads : 1;
    q->fit_def.stop = q->def->stop;
    q->fit_def.ctx = q->def->ctx;
    q->fit_def.scatter = LAB_SCATTER_PLACES;
    stein_status status = state_bands(q, err);
    status = status == STEIN_OK ? diag__problem_null(q, err) : status;
    status = status == STEIN_OK ? choose_bands(q, err) : status;
    return status == STEIN_OK ? take_forces(q, err) : status;
}

/* ---- mechanisms ---- */

/* Is record i a window of the same file as the one before? */
static int is_next_window(const lab_dataset *set, int i)
{
    const lab_data *d = set->stroke[i], *before = i > 0 ? set->stroke[i - 1] : NULL;
    return before != NULL && data__is_window(d) && data__is_window(before) &&
           d->first_row > before->first_row && strcmp(d->source, before->source) == 0;
}

/* the files of a set, each once, in the order of its records */
static stein_status read_files(const lab_dataset *set, const lab_model *model, lab_dataset **to,
                               stein_err *err)
{
    lab_data_options options = lab_data_options_default(lab_equations(model));
    const char **file = malloc(sizeof *file * 2 * (size_t)(set->n + 1)), **text = file + set->n;
    int n = 0;
    if (file == NULL) {
        return lab__no_memory(err);
    }
    for (int i = 0; i < set->n; i++) {
        const lab_data *d = set->stroke[i];
        if (!is_next_window(set, i)) {
            file[n] = d->source;
            text[n++] = d->text;
        }
    }
    options.text = text;
    stein_status status = lab_dataset_open(to, file, n, &options, err);
    free(file);
    return status;
}

stein_status diag__read_again(const lab_dataset *set, const lab_model *model, lab_dataset **to,
                              stein_err *err)
{
    lab_dataset *whole = NULL, *own = calloc(1, sizeof *own);
    if (own == NULL || (own->stroke = calloc((size_t)set->n + 1, sizeof(lab_data *))) == NULL) {
        free(own);
        return lab__no_memory(err);
    }
    stein_status status = set->n > 0 ? read_files(set, model, &whole, err) : STEIN_OK;
    for (int i = 0, k = -1; status == STEIN_OK && i < set->n; i++) {
        const lab_data *d = set->stroke[i];
        k += !is_next_window(set, i);
        if (data__is_window(d)) {
            status = data__cut(&own->stroke[i], whole->stroke[k], data__window_of(d), err);
        } else {
            own->stroke[i] = whole->stroke[k];
            whole->stroke[k] = NULL;
        }
        own->n += status == STEIN_OK;
        if (own->stroke[i] != NULL) {
            own->stroke[i]->number = d->number;
        }
    }
    lab_dataset_close(whole);
    if (status == STEIN_OK) {
        *to = own;
    } else {
        lab_dataset_close(own);
    }
    return status;
}

static stein_status make_mechanism(diag__problem *q, diag__mechanism *m, stein_err *err)
{
    lab_candidate part[DIAG_CAUSES];
    stein_status status = STEIN_OK;
    m->model = q->model;
    m->fitted = q->fitted;
    for (int i = 0; i < m->npart; i++) {
        part[i] = q->candidate[m->part[i]]; // a part acts in all records
    }
    if (m->npart > 0) {
        status = lab__open_with(&m->own, q->file, part, m->npart, q->def->options, err);
        m->model = m->own;
        status =
            status == STEIN_OK ? diag__read_again(q->fitted, m->own, &m->own_fitted, err) : status;
        m->fitted = m->own_fitted;
    }
    for (int i = 0; status == STEIN_OK && i < q->n + q->nsetting; i++) {
        int in = q->candidate[i].effect->needs == NULL;
        for (int k = 0; k < m->npart; k++) {
            in |= m->part[k] == i;
        }
        status = in ? lab_candidate_bind(&m->candidate[i], m->model, err) : STEIN_OK;
    }
    return status;
}

static void free_mechanism(diag__mechanism *m)
{
    lab_dataset_close(m->own_fitted);
    lab_close(m->own);
    free(m->candidate);
    free(m->why);
    free(m);
}

const diag__mechanism *diag__mechanism_of(diag__problem *q, const diag__hypothesis *h,
                                          stein_err *err)
{
    diag__mechanism like = {.npart = 0};
    stein_err why = {STEIN_OK, ""};
    for (int i = 0; i < h->n; i++) {
        if (diag__base(q, h->cause[i])->effect->needs != NULL) {
            like.part[like.npart++] = h->cause[i];
        }
    }
    for (int k = 0; k < q->nmechanism; k++) {
        const diag__mechanism *m = q->mechanism[k];
        if (m->npart == like.npart &&
            memcmp(m->part, like.part, sizeof *m->part * (size_t)m->npart) == 0) {
            return m;
        }
    }
    diag__mechanism **more = realloc(q->mechanism, sizeof *more * (size_t)(q->nmechanism + 1)),
                    *m = malloc(sizeof *m);
    q->mechanism = more != NULL ? more : q->mechanism;
    size_t all = (size_t)q->n + (size_t)q->nsetting;
    like.candidate = malloc(sizeof *like.candidate * (all + 1));
    if (more == NULL || m == NULL || like.candidate == NULL) {
        free(m);
        free(like.candidate);
        (void)lab__no_memory(err);
        return NULL;
    }
    memcpy(like.candidate, q->candidate, sizeof *like.candidate * all);
    *m = like;
    q->mechanism[q->nmechanism++] = m;
    stein_status status = make_mechanism(q, m, &why);
    m->why = status != STEIN_OK && status != STEIN_ENOMEM ? lab__text("%s", why.msg) : NULL;
    if (status != STEIN_OK && m->why == NULL) {
        (void)lab__no_memory(err);
        q->nmechanism--;
        free_mechanism(m);
        return NULL;
    }
    return m;
}

/* ---- the whole ---- */

stein_status diag__problem_open(diag__problem *q, const char *file, const lab_model *model,
                                const lab_dataset *fitted, const lab_diagnose_def *def,
                                stein_err *err)
{
    *q = (diag__problem){.file = file,
                         .model = model,
                         .def = def,
                         .fitted = fitted,
                         .most_strokes = def->most_strokes,
                         .most_seconds = def->most_seconds,
                         .begin = diag__clock()};
    stein_status status = diag__check_without(def, err);
    status = status == STEIN_OK ? choose_names(q, err) : status;
    status = status == STEIN_OK ? open_null(q, err) : status;
    return status == STEIN_OK ? diag__list_candidates(q, err) : status;
}

void diag__problem_close(diag__problem *q)
{
    for (int i = 0; i < q->nmechanism; i++) {
        free_mechanism(q->mechanism[i]);
    }
    free(q->mechanism);
    diag__kept_free(q->kept);
    fit__problem_free(&q->null);
    free(q->candidate);
    free(q->untestable);
    free(q->step);
    fit__force_errors_free(&q->forces);
    free(q->smooth);
    free(q->name);
    free(q->name_sd);
    free(q->body_sd);
}
