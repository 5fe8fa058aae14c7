/* SPDX-License-Identifier: GPL-3.0-or-later
 * calls_lab.c - calls of the laboratory: strokes, sweeps, measured data, and results of them.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "faults.h"
#include "stein/fit.h"
#include "stein/identity.h"
#include "stein/import.h"
#include "stein/plan.h"
#include "study.h"

static void hear(void *ctx, const char *message)
{
    uint64_t *hash = ctx;
    *hash = lab__hash(*hash, message, strlen(message));
}

/* ---- strokes ---- */

static stein_status call_strike(uint64_t *result, stein_err *err)
{
    lab_record *record = NULL;
    stein_sim *sim = NULL;
    lab_stroke stroke;
    lab_stroke_def def = lab_stroke_def_default(lab_equations(thing->action));
    def.until = 0.004;
    def.sample = lab_record_sample;
    stein_status status = lab_sim(thing->action, NULL, &sim, err);
    status = status == STEIN_OK ? lab_record_create(&record, lab_equations(thing->action), 0.0, err)
                                : status;
    def.ctx = record;
    status = status == STEIN_OK ? lab_strike(sim, &def, &stroke, err) : status;
    status = status == STEIN_OK ? lab_record_finish(record, sim) : status;
    status = status == STEIN_OK ? lab_write_csv(thing->out, record, NULL, err) : status;
    *result = status == STEIN_OK ? files_hash(thing->out) : 0;
    lab_record_destroy(record);
    stein_sim_destroy(sim);
    return status;
}

/* a motion of the key and a force of a finger, and the response of thing->action */
static stein_status call_drive(uint64_t *result, stein_err *err)
{
    lab_drive *drive = NULL;
    stein_sim *sim = NULL;
    stein_status status = lab_drive_open(&drive, thing->drive, lab_equations(thing->action), err);
    status = status == STEIN_OK ? lab_sim(thing->action, NULL, &sim, err) : status;
    status = status == STEIN_OK ? lab_drive_bind(drive, sim, err) : status;
    status = status == STEIN_OK ? stein_run(sim, 0.003, err) : status;
    *result = status == STEIN_OK ? stein_hash_numbers(STEIN_HASH, stein_q(sim), 4) : 0;
    stein_sim_destroy(sim);
    lab_drive_close(drive);
    return status;
}

/* a record in all its forms, and drawn */
static stein_status call_write(uint64_t *result, stein_err *err)
{
    static const char *const notes[] = {"made by: nobody", NULL};
    char picture[FILES_PATH + 8];
    stein_status status = STEIN_OK;
    uint64_t hash = STEIN_HASH;
    for (int form = LAB_CSV; status == STEIN_OK && form <= LAB_CSV_PLAIN; form++) {
        status = lab_write(thing->out, (lab_format)form, thing->record, notes, err);
    }
    snprintf(picture, sizeof picture, "%s.svg", thing->out);
    status = status == STEIN_OK ? lab_plot(picture, thing->record, lab_equations(thing->action),
                                           &thing->stroke, err)
                                : status;
    if (status == STEIN_OK) {
        hash = files_hash(thing->out) ^ files_hash(picture);
    }
    *result = hash;
    return status;
}

/* ---- sweeps ---- */

enum { POINTS = 3 };

/* strokes at three places of the stop, and the published facts on them */
static stein_status sweep(lab_point point[POINTS], lab_fact *fact, int *nfact, stein_err *err)
{
    for (int i = 0; i < POINTS; i++) {
        point[i] = (lab_point){.dx = -1e-3 + 0.5e-3 * i};
    }
    stein_status status = lab_sweep(thing->action, point, POINTS, 1, NULL, NULL, err);
    for (int i = 0; status == STEIN_OK && i < POINTS; i++) {
        if (point[i].status != STEIN_OK) { // memory that ended within is an error of the sweep
            status = lab__fail(err, point[i].status, "point %d", i);
        }
    }
    *nfact = status == STEIN_OK ? lab_facts(fact, point, POINTS) : 0;
    return status;
}

static stein_status call_sweep(uint64_t *result, stein_err *err)
{
    lab_point point[POINTS];
    lab_fact fact[LAB_FACTS_MAX];
    int nfact = 0;
    stein_status status = sweep(point, fact, &nfact, err);
    *result = lab__hash(STEIN_HASH, &nfact, sizeof nfact);
    for (int i = 0; status == STEIN_OK && i < POINTS; i++) {
        *result = stein_hash_numbers(*result, &point[i].stroke.impact_time, 1);
    }
    return status;
}

static const char *const vary[] = {"rod.mass=0.2:0.3:3kg", "rod.damping=1e-4,2e-4"};

static stein_status call_vary(uint64_t *result, stein_err *err)
{
    lab_grid *grid = NULL;
    lab_table *table = NULL;
    unlink(thing->journal);
    stein_status status = lab_grid_create(&grid, lab_equations(thing->pendulum), vary, 2, err);
    if (status == STEIN_OK) {
        lab_vary_def def = lab_vary_def_default(thing->pendulum);
        def.until = 0.005;
        def.journal = thing->journal;
        status = lab_vary(&table, thing->pendulum, grid, &def, NULL, err);
    }
    status = status == STEIN_OK ? lab_table_write(thing->out, table, err) : status;
    *result = status == STEIN_OK ? files_hash(thing->out) : 0;
    lab_table_destroy(table);
    lab_grid_destroy(grid);
    return status;
}

static stein_status call_merge(uint64_t *result, stein_err *err)
{
    const char *const journal[] = {thing->journal};
    lab_table *table = NULL;
    int damaged = 0;
    stein_status status = lab_merge(&table, journal, 1, &damaged, err);
    status = status == STEIN_OK ? lab_table_write(thing->out, table, err) : status;
    *result = status == STEIN_OK ? files_hash(thing->out) + (uint64_t)damaged : 0;
    lab_table_destroy(table);
    return status;
}

/* the numbers of a map, as the file would accept them, and the map */
static stein_status call_map(uint64_t *result, stein_err *err)
{
    lab_grid *grid = NULL;
    lab_table *table = NULL;
    char picture[FILES_PATH + 8];
    lab_vary_def def = lab_vary_def_default(thing->pendulum);
    lab_options options = files_options();
    def.until = 0.005;
    snprintf(picture, sizeof picture, "%s.svg", thing->out);
    stein_status status =
        lab_grid_open(&grid, thing->pendulum, vary, 2, thing->yaml, &options, err);
    status = status == STEIN_OK ? lab_vary(&table, thing->pendulum, grid, &def, NULL, err) : status;
    status = status == STEIN_OK ? lab_table_plot(picture, table, err) : status;
    *result = status == STEIN_OK ? files_hash(picture) : 0;
    lab_table_destroy(table);
    lab_grid_destroy(grid);
    return status;
}

static stein_status call_identify(uint64_t *result, stein_err *err)
{
    lab_identity identity = {0, 0, 0};
    stein_status status = lab_identify(&identity, 1, err);
    *result = identity.core ^ identity.sweep ^ identity.fit;
    return status;
}

/* ---- measured data ---- */

static stein_status call_data(uint64_t *result, stein_err *err)
{
    const char *const file[] = {"models/strokes/stroke_01.csv", "models/strokes/stroke_02.csv"};
    lab_data_options options = lab_data_options_default(lab_equations(thing->action));
    lab_dataset *set = NULL;
    lab_audit *audit = NULL;
    stein_status status = lab_dataset_open(&set, file, 2, &options, err);
    status = status == STEIN_OK ? lab_audit_create(&audit, set->stroke[1], err) : status;
    *result = STEIN_HASH;
    status = status == STEIN_OK ? lab_audit_text(audit, hear, result, err) : status;
    lab_audit_destroy(audit);
    lab_dataset_close(set);
    return status;
}

static stein_status call_fit(uint64_t *result, stein_err *err)
{
    static const char *const names[] = {"rod.damping", "rod.pendulum.frequency"};
    const char *const file[] = {thing->csv};
    lab_data_options options = lab_data_options_default(lab_equations(thing->pendulum));
    lab_dataset *set = NULL;
    lab_fit *fit = NULL;
    lab_fit_def def = lab_fit_def_default();
    def.free = names;
    def.nfree = 2;
    def.starts = 1;
    def.iterations = 2;
    def.threads = 1;
    stein_status status = lab_dataset_open(&set, file, 1, &options, err);
    status = status == STEIN_OK ? lab_fit_run(&fit, thing->pendulum, set, &def, err) : status;
    status = status == STEIN_OK ? lab_fit_write(thing->out, fit, thing->yaml, NULL, err) : status;
    *result = status == STEIN_OK ? stein_hash_numbers(STEIN_HASH, &fit->chi2, 1) : 0;
    lab_fit_destroy(fit);
    lab_dataset_close(set);
    return status;
}

/* checks of settings, suspicions and rests of strokes */
static stein_status call_settings(uint64_t *result, stein_err *err)
{
    const char *const file[] = {thing->swing[0], thing->swing[1], thing->swing[2]};
    const double tolerance[] = {1e-3};
    char **suspicion = NULL;
    int suspicions = 0;
    lab_data_options options = lab_data_options_default(lab_equations(thing->pendulum));
    lab_dataset *set = NULL;
    stein_status status = lab_dataset_open(&set, file, 3, &options, err);
    *result = STEIN_HASH;
    if (status == STEIN_OK) {
        status = lab_data_check_settings(set, thing->pendulum, hear, result, err);
    }
    if (status == STEIN_OK) {
        status = lab_suspicions(&suspicion, &suspicions, thing->pendulum, set, err);
    }
    for (int i = 0; i < suspicions; i++) {
        hear(result, suspicion[i]);
    }
    lab_suspicions_free(suspicion, suspicions);
    for (int i = 0; status == STEIN_OK && i < set->n; i++) {
        double rest[] = {NAN};
        lab_audit *audit = NULL;
        status = lab_audit_create(&audit, set->stroke[i], err);
        status =
            status == STEIN_OK ? lab_data_rest(set->stroke[i], thing->pendulum, rest, err) : status;
        status = status == STEIN_OK ? lab_data_check_rest(audit, rest, tolerance, hear, result, err)
                                    : status;
        *result = stein_hash_numbers(*result, rest, 1);
        lab_audit_destroy(audit);
    }
    lab_dataset_close(set);
    return status;
}

/* searches from three places with a profile, written to a journal; again, from its end */
static stein_status call_resume(uint64_t *result, stein_err *err)
{
    static const char *const names[] = {"rod.damping", "rod.pendulum.frequency"};
    const char *const file[] = {thing->csv};
    lab_data_options options = lab_data_options_default(lab_equations(thing->pendulum));
    lab_dataset *set = NULL;
    lab_fit_def def = lab_fit_def_default();
    def.free = names;
    def.nfree = 2;
    def.profile = names;
    def.nprofile = 1;
    def.iterations = 2;
    def.robust = 1;
    def.threads = 1;
    def.journal = thing->journal;
    unlink(thing->journal);
    stein_status status = lab_dataset_open(&set, file, 1, &options, err);
    *result = STEIN_HASH;
    for (int i = 0; status == STEIN_OK && i < 2; i++) {
        lab_fit *fit = NULL;
        status = lab_fit_run(&fit, thing->pendulum, set, &def, err);
        if (status == STEIN_OK) {
            *result = stein_hash_numbers(*result, &fit->chi2, 1);
            *result = lab__hash(*result, &fit->resumed, sizeof fit->resumed);
        }
        lab_fit_destroy(fit);
    }
    lab_dataset_close(set);
    return status;
}

/* a pendulum with air drag, and its diagnosis, written in all forms */
static stein_status call_diagnose(uint64_t *result, stein_err *err)
{
    const char *const file[] = {thing->swing[0], thing->swing[1], thing->swing[2]};
    static const unsigned char held_out[] = {0, 0, 1};
    lab_data_options data = lab_data_options_default(lab_equations(thing->pendulum));
    lab_options options = files_options();
    lab_diagnose_def def = lab_diagnose_def_default();
    lab_dataset *set = NULL;
    lab_diagnosis *found = NULL;
    def.options = &options;
    def.held_out = held_out;
    def.threads = 1;
    stein_status status = lab_dataset_open(&set, file, 3, &data, err);
    status = status == STEIN_OK ? lab_diagnose(&found, thing->yaml, thing->pendulum, set, &def, err)
                                : status;
    status = status == STEIN_OK ? lab_diagnosis_json(thing->out, found, err) : status;
    status = status == STEIN_OK ? lab_diagnosis_page(thing->out, found, err) : status;
    status = status == STEIN_OK ? lab_extend(thing->out, thing->yaml, found, err) : status;
    *result = status == STEIN_OK ? files_hash(thing->out) : 0;
    lab_diagnosis_destroy(found);
    lab_dataset_close(set);
    return status;
}

/* candidates, and a mechanism with one of them */
static stein_status call_candidates(uint64_t *result, stein_err *err)
{
    lab_candidate *list = NULL;
    lab_options options = files_options();
    int n = 0;
    stein_status status = lab_candidates(&list, &n, thing->rotor, err);
    *result = (uint64_t)n;
    for (int i = 0; status == STEIN_OK && i < n; i++) {
        lab_model *model = NULL;
        if (list[i].effect->needs != NULL) {
            status = lab_candidate_open(&list[i], &model, thing->rotor_yaml, &options, err);
        }
        *result += (uint64_t)list[i].nparam << 8;
        lab_close(model);
    }
    free(list);
    return status;
}

/* the next experiment of a diagnosis that is read back */
static stein_status call_plan(uint64_t *result, stein_err *err)
{
    lab_options options = files_options();
    lab_plan_def def = lab_plan_def_default();
    lab_diagnosis *found = NULL;
    lab_plan *plan = NULL;
    def.options = &options;
    def.quick = 1;
    def.threads = 1;
    stein_status status = lab_diagnosis_read(&found, thing->found, thing->rotor, err);
    status = status == STEIN_OK
                 ? lab_plan_make(&plan, thing->rotor_yaml, thing->rotor, found, &def, err)
                 : status;
    status = status == STEIN_OK
                 ? lab_plan_stroke(thing->out, &plan->experiment[0], plan->experiment[0].against,
                                   thing->rotor_yaml, thing->rotor, found, &def, err)
                 : status;
    uint64_t hash =
        status == STEIN_OK ? stein_hash_numbers(STEIN_HASH, &plan->experiment[0].odds, 1) : 0;
    status = status == STEIN_OK ? lab_plan_json(thing->out, plan, found, NULL, err) : status;
    *result = hash;
    lab_plan_destroy(plan);
    lab_diagnosis_destroy(found);
    return status;
}

/* ---- output for other programs ---- */

/* with a compiler that writes a line; other tests check the contents of an FMU */
static stein_status call_fmu(uint64_t *result, stein_err *err)
{
    lab_options options = files_options();
    lab_fmu_facts facts;
    options.cc = thing->cc;
    stein_status status = lab_fmu(thing->out, thing->pendulum, 3, &options, &facts, err);
    *result = status == STEIN_OK ? files_hash(thing->out) : 0;
    return status;
}

/* the equations as text for SymPy */
static stein_status call_expressions(uint64_t *result, stein_err *err)
{
    static const char *const what[] = {"M", "Q", "V", "hammer.head"};
    stein_status status = STEIN_OK;
    *result = STEIN_HASH;
    for (int i = 0; status == STEIN_OK && i < 4; i++) {
        char *text = NULL;
        status = lab_expressions(&text, thing->action, what[i], err);
        *result = status == STEIN_OK ? lab__hash(*result, text, strlen(text)) : 0;
        free(text);
    }
    return status;
}

/* every kind of file: joints of several kinds, loops, couplings, notes on omissions, warnings */
static stein_status call_import(uint64_t *result, stein_err *err)
{
    static const char *const file[] = {"tests/mbs/arm.mbs", "tests/mbs/rig.mbs",
                                       "tests/mbs/arm.urdf", "tests/mbs/arm.xml"};
    stein_status status = STEIN_OK;
    *result = 0;
    for (int i = 0; i < 4 && status == STEIN_OK; i++) {
        lab_imported done;
        uint64_t heard = STEIN_HASH;
        status = lab_import(file[i], thing->out, LAB_INERTIA_ACCEPT, hear, &heard, &done, err);
        *result = status == STEIN_OK ? 31 * *result + (files_hash(thing->out) ^ heard) : 0;
    }
    return status;
}

/* a page; that compiler compiles its module again */
static stein_status call_page(uint64_t *result, stein_err *err)
{
    char remove[2 * FILES_PATH];
    lab_options options = files_options();
    snprintf(remove, sizeof remove, "rm -rf %s/*/page-*", thing->folder);
    if (system(remove) != 0) {
        return lab__fail(err, STEIN_EIO, "%s: failed", remove);
    }
    stein_status status = lab_page(thing->out, thing->pendulum, &options, NULL, err);
    *result = status == STEIN_OK ? files_hash(thing->out) : 0;
    return status;
}

/* the study and its files: of three places of the stop the paper's figures, or all parts */
static stein_status do_study(int all, uint64_t *result, stein_err *err)
{
    lab_point point[POINTS];
    lab_fact fact[LAB_FACTS_MAX];
    char page[FILES_PATH + 16];
    study_report report = {.npart = 0};
    study s = {.model = thing->action,
               .threads = 1,
               .dt = 20e-6,
               .samples = 3,
               .point = point,
               .npoint = POINTS,
               .fact = fact};
    stein_status status = sweep(point, fact, &s.nfact, err);
    if (status == STEIN_OK && all) {
        status = study_run(&s, &report, err);
    } else if (status == STEIN_OK) {
        report.npart = 1;
        status = study_begin(&s, err);
        status = status == STEIN_OK ? study_paper(&s, &report.part[0], err) : status;
    }
    status = status == STEIN_OK ? study_write(&s, &report, thing->folder, err) : status;
    snprintf(page, sizeof page, "%s/study.html", thing->folder);
    *result = status == STEIN_OK ? files_hash(page) : 0;
    study_report_free(&report);
    return status;
}

static stein_status call_study(uint64_t *result, stein_err *err)
{
    return do_study(0, result, err);
}

static stein_status call_parts(uint64_t *result, stein_err *err)
{
    return do_study(1, result, err);
}

const call_entry calls_lab[] = {{"strike", call_strike, 0},
                                {"drive", call_drive, 0},
                                {"write", call_write, 0},
                                {"sweep", call_sweep, 0},
                                {"vary", call_vary, 0},
                                {"merge", call_merge, 0},
                                {"map", call_map, 0},
                                {"identify", call_identify, 120},
                                {"data", call_data, 0},
                                {"settings", call_settings, 1},
                                {"fit", call_fit, 3},
                                {"resume", call_resume, 10},
                                {"candidates", call_candidates, 5},
                                {"diagnose", call_diagnose, 60},
                                {"plan", call_plan, 30},
                                {"fmu", call_fmu, 2},
                                {"expressions", call_expressions, 0},
                                {"page", call_page, 10},
                                {"study", call_study, 10},
                                {"parts", call_parts, NOT_ALL},
                                {"import", call_import, 1},
                                {NULL, NULL, 0}};
