/* SPDX-License-Identifier: GPL-3.0-or-later
 * sweep.c - a sweep: one stroke at every point of a grid.
 *
 *   grid --head--> table <--rows-- journal
 *                    ^ |
 *                    | +--points without row--> batch (threads, lanes) --row--> journal
 *                    +-----------------------------------------+
 *
 * A point is known by the head, not by the run that computed it. The head names the version, the
 * equations, a hash of all parameter values that are not varied, the integrator and the times.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sweep.h"

typedef struct sweep {
    const lab_model *model;
    const stein_model *equations;
    const lab_grid *grid;
    const lab_vary_def *def;
    lab_table *table;
    lab__journal journal;
    int has_journal;
    int *param; /* [naxis] index of the varied parameter */
    lab__steps steps;
} sweep;

lab_vary_def lab_vary_def_default(const lab_model *model)
{
    return (lab_vary_def){
        .until = lab_until(model), .release = NAN, .threads = 1, .shard = 0, .shards = 1};
}

static int is_stroke(const stein_model *m)
{
    return m->stroke.string >= 0;
}

/* ---- the head ---- */

/* over the bits of every value that no point replaces, and over where a run starts from */
static unsigned long long hash_values(const sweep *s)
{
    unsigned long long hash = STEIN_HASH;
    const double *p = lab_parameters(s->model);
    for (int i = 0; i <= s->equations->np; i++) {
        double value = i < s->equations->np ? p[i] : s->equations->settle;
        for (int k = 0; i < s->equations->np && k < s->grid->naxis; k++) {
            value = s->param[k] == i ? 0.0 : value;
        }
        value = value == 0.0 ? 0.0 : value; // no minus zero
        hash = stein_hash_numbers(hash, &value, 1);
    }
    return hash;
}

static void write_sets(FILE *f, const sweep *s)
{
    for (int i = 0; i < s->def->nset; i++) {
        const char *set = s->def->set[i];
        int length = (int)strcspn(set, "=");
        fprintf(f, "# set %.*s: ", length, set);
        lab__put_line(f, set[length] == '=' ? set + length + 1 : "");
    }
}

static void write_columns(FILE *f, const sweep *s)
{
    const stein_model *m = s->equations;
    fprintf(f, "point,");
    for (int i = 0; i < s->grid->naxis; i++) {
        fprintf(f, "%s [%s],", s->grid->axis[i].name, s->grid->axis[i].unit);
    }
    if (is_stroke(m)) {
        fprintf(f, "status,outcome,escapement_time [s],escapement_height [m],impact_time [s],"
                   "impact_speed [m/s],impacts [1],free_flight [s],forced_escapement [1],"
                   "peak_string_force [N],blow [m],rearmed [1]\n");
        return;
    }
    fprintf(f, "status");
    for (int i = 0; i < m->nchannel; i++) {
        fprintf(f, ",%s [%s]", m->channels[i].name, m->channels[i].unit);
    }
    putc('\n', f);
}

static void write_steps(FILE *f, const sweep *s)
{
    char number[LAB_NUMBER];
    const stein_model *m = s->equations;
    const lab__steps *steps = &s->steps;
    if (!(steps->tolerance > 0.0)) {
        fprintf(f, "# integrator: %s\n", mech_integrator(m->integrator));
        fprintf(f, "# dt: %s s\n", lab__number(number, m->dt));
        return;
    }
    fprintf(f, "# integrator: dp5, steps of controlled error\n# tolerance %s: %s %s\n",
            m->channels[steps->channel].name, lab__number(number, steps->stated),
            m->channels[steps->channel].unit);
    fprintf(f, "# tolerance of a step: %s\n", lab__number(number, steps->tolerance));
    fprintf(f, "# longest step: %s s\n", lab__number(number, steps->longest));
}

static void write_head(FILE *f, const sweep *s)
{
    char number[LAB_NUMBER];
    const stein_model *m = s->equations;
    fprintf(f, "# stein: %s\n# model: %s\n# equations: %s\n# values: %016llx\n", STEIN_VERSION,
            m->name, m->equations, hash_values(s));
    write_steps(f, s);
    fprintf(f, "# until: %s s\n", lab__number(number, s->def->until));
    if (!isnan(s->def->release)) {
        fprintf(f, "# release: %s s\n", lab__number(number, s->def->release));
    }
    write_sets(f, s);
    for (int i = 0; i < s->grid->naxis; i++) {
        const lab__axis *a = &s->grid->axis[i];
        fprintf(f, "# vary %s [%s]: %s\n", a->name, a->unit, a->text);
    }
    fprintf(f, "# points: %d\n", s->grid->n);
    write_columns(f, s);
}

static stein_status make_table(sweep *s, stein_err *err)
{
    char *head = NULL;
    FILE *f = lab__text_open(&head);
    if (f == NULL) {
        return lab__no_memory(err);
    }
    write_head(f, s);
    stein_status status = lab__text_close(f, &head, err);
    status = status == STEIN_OK ? lab__table_new(&s->table, head, err) : status;
    free(head);
    return status;
}

/* ---- a row ---- */

static const char *status_name(stein_status status)
{
#define NAME(code, text) #code,
    static const char *const name[] = {STEIN_STATUS_LIST(NAME)};
#undef NAME
    return status == STEIN_OK ? "ok" : name[status];
}

/* ",NUMBER", or an empty cell without the event */
static void put(FILE *f, double value)
{
    char text[LAB_NUMBER];
    fprintf(f, ",%s", isnan(value) ? "" : lab__number(text, value));
}

static void write_stroke(FILE *f, const lab_stroke *k)
{
    fprintf(f, ",%s", lab_outcome_text(k->outcome));
    put(f, k->escape_time);
    put(f, k->escape_height);
    put(f, k->impact_time);
    put(f, k->impact_speed);
    fprintf(f, ",%d", k->impacts);
    put(f, k->free_flight);
    fprintf(f, ",%d", k->forced_escapement);
    put(f, k->peak_string_force);
    put(f, k->blow);
    fprintf(f, ",%d", k->rearmed);
}

static void write_row(FILE *f, const sweep *s, int point, stein_status status,
                      const lab_stroke *stroke, stein_sim *sim)
{
    fprintf(f, "%d", point);
    for (int i = 0; i < s->grid->naxis; i++) {
        put(f, lab_grid_value(s->grid, point, i));
    }
    fprintf(f, ",%s", status_name(status));
    if (status != STEIN_OK) {
        for (int i = s->grid->naxis + 2; i < s->table->ncolumn; i++) {
            putc(',', f);
        }
    } else if (is_stroke(s->equations)) {
        write_stroke(f, stroke);
    } else {
        for (int i = 0; i < s->equations->nchannel; i++) {
            put(f, stein_read(sim, i));
        }
    }
}

/* ---- a point ---- */

static void set_point(void *ctx, int point, double *p)
{
    const sweep *s = ctx;
    for (int i = 0; i < s->grid->naxis; i++) {
        p[s->param[i]] = lab_grid_value(s->grid, point, i);
    }
}

static stein_status keep_point(void *ctx, int point, stein_sim *sim, const lab_stroke *stroke,
                               stein_status status, stein_err *err)
{
    sweep *s = ctx;
    if (status == STEIN_ENOMEM) {
        return status; // no property of the point
    }
    char *row = NULL;
    FILE *f = lab__text_open(&row);
    if (f == NULL) {
        return lab__no_memory(err);
    }
    write_row(f, s, point, status, stroke, sim);
    status = lab__text_close(f, &row, err);
    if (status == STEIN_OK && s->has_journal) {
        status = lab__journal_add(&s->journal, row, err);
    }
    if (status == STEIN_OK) { // no other point writes here
        status = lab__table_take(s->table, row, strlen(row), err);
    }
    free(row);
    return status;
}

stein_status lab__check_points(const lab_model *model, double until, double release, stein_err *err)
{
    const stein_model *m = lab_equations(model);
    stein_sim *sim = NULL;
    lab_stroke stroke;
    lab_stroke_def def = lab_stroke_def_default(m);
    if (!(until > 0.0) || !isfinite(until)) {
        return lab__fail(err, STEIN_EINVAL, "a run of %g s: expected a positive duration", until);
    }
    if (!isnan(release) && !(release >= 0.0 && release <= until)) {
        return lab__fail(err, STEIN_EINVAL,
                         "release at %g s: expected a time from 0 to the end at %g s", release,
                         until);
    }
    def.until = m->dt;
    def.release = !isnan(release) || m->load.body >= 0 ? 0.0 : NAN;
    stein_status status = lab_sim(model, NULL, &sim, err);
    if (status == STEIN_OK) {
        status = is_stroke(m) ? lab_strike(sim, &def, &stroke, err) : lab_simulate(sim, &def, err);
        stein_sim_destroy(sim);
    }
    int numerical = status == STEIN_ENONFINITE || status == STEIN_ESINGULAR ||
                    status == STEIN_ECHATTER || status == STEIN_ESETTLE;
    return numerical ? STEIN_OK : status; // other points may fare better
}

/* ---- the sweep ---- */

static stein_status compute(sweep *s, lab_vary_report *report, stein_err *err)
{
    unsigned char *skip = calloc((size_t)s->grid->n, 1);
    if (skip == NULL) {
        return lab__no_memory(err);
    }
    for (int i = 0; i < s->grid->n; i++) {
        int mine = i % s->def->shards == s->def->shard, done = lab_table_has(s->table, i);
        skip[i] = !mine || done;
        report->found += mine && done;
        report->computed += mine && !done;
    }
    lab_stroke_def run = lab_stroke_def_default(s->equations);
    run.until = s->def->until;
    run.release = s->def->release;
    const lab__batch batch = {.model = s->model,
                              .def = &run,
                              .steps = s->steps.tolerance > 0.0 ? &s->steps : NULL,
                              .n = s->grid->n,
                              .threads = s->def->threads,
                              .skip = skip,
                              .set = set_point,
                              .run = keep_point,
                              .ctx = s,
                              .stop = {s->def->stop, s->def->ctx},
                              .progress = s->def->progress,
                              .progress_ctx = s->def->ctx};
    stein_status status = lab__batch_run(&batch, err);
    free(skip);
    return status;
}

static stein_status find_params(sweep *s, stein_err *err)
{
    s->param = calloc((size_t)s->grid->naxis + 1, sizeof *s->param);
    if (s->param == NULL) {
        return lab__no_memory(err);
    }
    for (int i = 0; i < s->grid->naxis; i++) {
        s->param[i] = stein_find_param(s->equations, s->grid->axis[i].name);
        if (s->param[i] < 0) {
            return lab__fail(err, STEIN_ENAME, "\"%s\" has no parameter %s", s->equations->name,
                             s->grid->axis[i].name);
        }
    }
    return STEIN_OK;
}

stein_status lab_vary(lab_table **table, const lab_model *model, const lab_grid *grid,
                      const lab_vary_def *def, lab_vary_report *report, stein_err *err)
{
    sweep s = {.model = model, .equations = lab_equations(model), .grid = grid, .def = def};
    lab_vary_report done = {0, 0, 0};
    if (def->shards < 1 || def->shard < 0 || def->shard >= def->shards) {
        return lab__fail(err, STEIN_EINVAL, "shard %d of %d", def->shard, def->shards);
    }
    stein_status status = find_params(&s, err);
    if (status == STEIN_OK) {
        status = lab__check_points(model, def->until, def->release, err);
    }
    if (status == STEIN_OK) {
        status = lab__steps_of(&s.steps, model, def->tolerance, def->fixed, err);
    }
    if (status == STEIN_OK) {
        status = make_table(&s, err);
    }
    if (status == STEIN_OK && def->journal != NULL) {
        status = lab__journal_open(&s.journal, def->journal, s.table, &done.damaged, err);
        s.has_journal = status == STEIN_OK;
    }
    if (status == STEIN_OK) {
        status = compute(&s, &done, err);
    }
    if (s.has_journal) {
        lab__journal_close(&s.journal);
    }
    free(s.param);
    if (status != STEIN_OK) {
        lab_table_destroy(s.table);
        return lab__stop_end(status, &(lab__stop){def->stop, def->ctx}, err);
    }
    *table = s.table;
    if (report != NULL) {
        *report = done;
    }
    return STEIN_OK;
}
