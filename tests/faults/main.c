/* SPDX-License-Identifier: GPL-3.0-or-later
 * main.c - every allocation of every call of the library is made to fail: once, and from there on.
 *
 *     faults [NAME|all]
 *
 * Of calls that make millions, the first one of every place that makes some: where four calls on
 * the stack were others before. Without a name a share of these.
 *
 * malloc and its kin are defined here, so the libraries below ours (libyaml, GSL, stdio) use them
 * too. A call that is told there is no memory has to end with an error and leave nothing behind -
 * no block, no result, no changed object - or to end with the result it has when there is memory.
 */
#define _DEFAULT_SOURCE
#include <errno.h>
#include <execinfo.h>
#include <gsl/gsl_errno.h>
#include <limits.h>
#include <math.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "inner.h"
#include "stein/diagnose.h"
#include "stein/fit.h"
#include "stein/identity.h"
#include "stein/import.h"
#include "stein/models.h"

/* ---- memory ---- */

extern void *__libc_malloc(size_t size);
extern void *__libc_calloc(size_t n, size_t size);
extern void *__libc_realloc(void *block, size_t size);
extern void __libc_free(void *block);

static atomic_long asked, live, fail_at, refused;
static atomic_int for_good, in_gsl;
static uintptr_t gsl_from, gsl_to; /* where the code of GSL is */

/* ---- places: the first allocation of each ---- */

static uint64_t hash_bytes(uint64_t hash, const char *at, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        hash = (hash ^ (unsigned char)at[i]) * 1099511628211u;
    }
    return hash;
}

enum { FRAMES = 7, BELOW = 3, PLACES = 1 << 14 }; /* of these frames three are here */
static uint64_t place[PLACES];                    /* hashed; 0: nobody there */
static long first_at[PLACES];
static int places;
static atomic_int noting;

static void note_place(long n)
{
    void *frame[FRAMES];
    atomic_store(&noting, 0); // what looks at the stack may ask for memory
    int depth = backtrace(frame, FRAMES);
    size_t known = depth > BELOW ? (size_t)(depth - BELOW) : 0;
    uint64_t hash = hash_bytes(STEIN_HASH, (const char *)(frame + BELOW), known * sizeof *frame);
    size_t at = hash % PLACES;
    while (place[at] != 0 && place[at] != hash) {
        at = (at + 1) % PLACES;
    }
    if (place[at] == 0 && places < PLACES / 2) {
        place[at] = hash;
        first_at[places++] = n;
    }
    atomic_store(&asked, n); // nor is it counted
    atomic_store(&noting, 1);
}

enum { DEEP = 16 };
static void *refused_frame[DEEP]; /* who asked for the first block that was refused */
static int refused_depth;

/* does this allocation fail? fail_at 0: none does */
static int fails(const void *caller)
{
    long n = atomic_fetch_add(&asked, 1) + 1, at = atomic_load(&fail_at);
    if (atomic_load(&noting)) {
        note_place(n);
    }
    int now = at > 0 && (atomic_load(&for_good) ? n >= at : n == at);
    if (now) {
        if (atomic_fetch_add(&refused, 1) == 0) {
            refused_depth = backtrace(refused_frame, DEEP);
        }
        if ((uintptr_t)caller >= gsl_from && (uintptr_t)caller < gsl_to) {
            atomic_store(&in_gsl, 1);
        }
        errno = ENOMEM;
    }
    return now;
}

void *malloc(size_t size)
{
    void *block = fails(__builtin_return_address(0)) ? NULL : __libc_malloc(size);
    atomic_fetch_add(&live, block != NULL);
    return block;
}

void *calloc(size_t n, size_t size)
{
    void *block = fails(__builtin_return_address(0)) ? NULL : __libc_calloc(n, size);
    atomic_fetch_add(&live, block != NULL);
    return block;
}

void *realloc(void *was, size_t size)
{
    void *block = fails(__builtin_return_address(0)) ? NULL : __libc_realloc(was, size);
    atomic_fetch_add(&live, block != NULL && was == NULL);
    return block;
}

void free(void *block)
{
    atomic_fetch_sub(&live, block != NULL);
    __libc_free(block);
}

/* ---- what is called ---- */

static char folder[] = "/tmp/stein-faults-XXXXXX";
static char path_csv[64], path_out[64], path_journal[64], path_yaml[64], path_cc[64],
    path_drive[64], path_swing[3][64];
static const lab_model *action, *pendulum; /* opened once, must not change */

/* of a file, without memory */
static uint64_t hash_file(const char *path)
{
    char part[4096];
    uint64_t hash = STEIN_HASH;
    atomic_store(&fail_at, 0); // the call is over
    atomic_store(&noting, 0);
    FILE *f = fopen(path, "rb");
    for (size_t n; f != NULL && (n = fread(part, 1, sizeof part, f)) > 0;) {
        hash = hash_bytes(hash, part, n);
    }
    if (f != NULL) {
        fclose(f);
    }
    return hash;
}

/* A call: OK and a hash of what came out, or an error. */
typedef stein_status call(uint64_t *result, stein_err *err);

static stein_status call_create(uint64_t *result, stein_err *err)
{
    stein_sim *sim = NULL;
    stein_status status = stein_sim_create(&sim, &stein_model_stein1788, NULL, err);
    if (status == STEIN_OK) {
        *result = stein_hash_numbers(STEIN_HASH, stein_q(sim), 4);
    }
    if (status != STEIN_OK && sim != NULL) {
        *result = 0; // a simulation in spite of an error: told as a wrong result
        status = STEIN_OK;
    }
    stein_sim_destroy(status == STEIN_OK ? sim : NULL);
    return status;
}

static stein_status call_read(uint64_t *result, stein_err *err)
{
    mechanism *m = NULL;
    mech_set set = {"load.mass", "90 g"};
    stein_status status = mech_read(&m, "models/stein1788.yaml", &set, 1, NULL, NULL, err);
    if (status == STEIN_OK) {
        *result = (uint64_t)m->nparam;
        mech_free(m);
    }
    return status;
}

/* every section that no file of models/ has beside others, formulas and a tolerance */
static stein_status call_sections(uint64_t *result, stein_err *err)
{
    static const char text[] =
        "mechanism: m\n"
        "parameters: {rod.shift: {value: 1.5 mm +- 0.1 mm, about: of the tip}}\n"
        "bodies:\n"
        "  rod:\n    joint: R -y\n    mass: 2 kg\n    centre: [0, 0, -100 mm - rod.shift]\n"
        "    pendulum: {frequency: 1.3 Hz, gravity: 9.8 m/s^2}\n    spring: {k: 1 N m/rad}\n"
        "    points: {tip: [0, 0, 2 * rod.shift - 0.3 m]}\n"
        "  bob:\n    part_of: rod\n    joint: R -y\n    mass: 90 g +- 1 %\n"
        "    centre: [1 mm, 0, -0.2 m]\n    inertia: {yy: 1e-5 kg m^2}\n"
        "  cart: {joint: T x, mass: 1 kg, friction: {A: 0.2 N, vt: 1 mm/s}}\n"
        "points: {wall: [1 m, 0, 0]}\n"
        "links: {tie: {from: frame.wall, to: rod.tip, k: 93 N/m, length: 0.1 m}}\n"
        "tables: {brake: {joint: cart, of: speed, at: [0, 1 mm/s], force: [0, -2 N]}}\n"
        "inputs: {push: {force: rod.tip, direction: [1, 0, 0]}}\n"
        "outputs: {x: {joint: cart, read: position}, e: {energy: kinetic}}\n"
        "regulation: {rod.shift: {from: 0 mm, to: 2 mm}}\n";
    mechanism *m = NULL;
    stein_status status = mech_read_text(&m, "m", text, sizeof text - 1, NULL, 0, NULL, NULL, err);
    if (status == STEIN_OK) {
        *result = (uint64_t)(m->nparam + 1000 * m->nformula);
        mech_free(m);
    }
    return status;
}

static void hear(void *ctx, const char *message)
{
    uint64_t *hash = ctx;
    *hash = hash_bytes(*hash, message, strlen(message));
}

/* problems of a bad file; no memory may hide some of them, so the outcome is the code alone */
static stein_status call_problems(uint64_t *result, stein_err *err)
{
    static const char text[] = "mechanism: m\nbodies: {a: {joint: Q q, mass: 3 m, x: {y: [1]}}}\n";
    mechanism *m = NULL;
    uint64_t heard = STEIN_HASH;
    stein_status status =
        mech_read_text(&m, "m", text, sizeof text - 1, NULL, 0, hear, &heard, err);
    *result = heard;
    return status == STEIN_EPARSE ? STEIN_OK : status;
}

static stein_status call_generate(uint64_t *result, stein_err *err)
{
    gen_result r;
    stein_status status = gen_equations(&r, lab__mechanism(pendulum), err);
    if (status == STEIN_OK) {
        *result = hash_bytes(STEIN_HASH, r.source, r.size);
        gen_free(&r);
    }
    return status;
}

static stein_status call_open(uint64_t *result, stein_err *err)
{
    lab_model *model = NULL;
    stein_status status = lab_open(&model, "models/pendulum.yaml", NULL, err);
    if (status == STEIN_OK) {
        const stein_model *m = lab_equations(model);
        *result = stein_hash_numbers(STEIN_HASH, lab_parameters(model), m->np);
        lab_close(model);
    }
    return status;
}

static stein_status call_strike(uint64_t *result, stein_err *err)
{
    lab_record *record = NULL;
    stein_sim *sim = NULL;
    lab_stroke stroke;
    lab_stroke_def def = lab_stroke_def_default(lab_equations(action));
    def.until = 0.004;
    def.sample = lab_record_sample;
    stein_status status = lab_sim(action, NULL, &sim, err);
    status =
        status == STEIN_OK ? lab_record_create(&record, lab_equations(action), 0.0, err) : status;
    def.ctx = record;
    status = status == STEIN_OK ? lab_strike(sim, &def, &stroke, err) : status;
    status = status == STEIN_OK ? lab_record_finish(record, sim) : status;
    status = status == STEIN_OK ? lab_write_csv(path_out, record, NULL, err) : status;
    *result = status == STEIN_OK ? hash_file(path_out) : 0;
    lab_record_destroy(record);
    stein_sim_destroy(sim);
    return status;
}

/* a motion of the key and a force of a finger, and what the action does with them */
static stein_status call_drive(uint64_t *result, stein_err *err)
{
    lab_drive *drive = NULL;
    stein_sim *sim = NULL;
    stein_status status = lab_drive_open(&drive, path_drive, lab_equations(action), err);
    status = status == STEIN_OK ? lab_sim(action, NULL, &sim, err) : status;
    status = status == STEIN_OK ? lab_drive_bind(drive, sim, err) : status;
    status = status == STEIN_OK ? stein_run(sim, 0.003, err) : status;
    *result = status == STEIN_OK ? stein_hash_numbers(STEIN_HASH, stein_q(sim), 4) : 0;
    stein_sim_destroy(sim);
    lab_drive_close(drive);
    return status;
}

static stein_status call_vary(uint64_t *result, stein_err *err)
{
    static const char *const vary[] = {"rod.mass=0.2:0.3:3kg", "rod.damping=1e-4,2e-4"};
    lab_grid *grid = NULL;
    lab_table *table = NULL;
    unlink(path_journal);
    stein_status status = lab_grid_create(&grid, lab_equations(pendulum), vary, 2, err);
    if (status == STEIN_OK) {
        lab_vary_def def = lab_vary_def_default(pendulum);
        def.until = 0.005;
        def.journal = path_journal;
        status = lab_vary(&table, pendulum, grid, &def, NULL, err);
    }
    status = status == STEIN_OK ? lab_table_write(path_out, table, err) : status;
    *result = status == STEIN_OK ? hash_file(path_out) : 0;
    lab_table_destroy(table);
    lab_grid_destroy(grid);
    return status;
}

static stein_status call_merge(uint64_t *result, stein_err *err)
{
    const char *const journal[] = {path_journal};
    lab_table *table = NULL;
    int damaged = 0;
    stein_status status = lab_merge(&table, journal, 1, &damaged, err);
    status = status == STEIN_OK ? lab_table_write(path_out, table, err) : status;
    *result = status == STEIN_OK ? hash_file(path_out) + (uint64_t)damaged : 0;
    lab_table_destroy(table);
    return status;
}

static stein_status call_data(uint64_t *result, stein_err *err)
{
    const char *const file[] = {"models/strokes/stroke_01.csv", "models/strokes/stroke_02.csv"};
    lab_data_options options = lab_data_options_default(lab_equations(action));
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
    const char *const file[] = {path_csv};
    lab_data_options options = lab_data_options_default(lab_equations(pendulum));
    lab_dataset *set = NULL;
    lab_fit *fit = NULL;
    lab_fit_def def = lab_fit_def_default();
    def.free = names;
    def.nfree = 2;
    def.starts = 1;
    def.iterations = 2;
    def.threads = 1;
    stein_status status = lab_dataset_open(&set, file, 1, &options, err);
    status = status == STEIN_OK ? lab_fit_run(&fit, pendulum, set, &def, err) : status;
    status = status == STEIN_OK ? lab_fit_write(path_out, fit, path_yaml, NULL, err) : status;
    *result = status == STEIN_OK ? stein_hash_numbers(STEIN_HASH, &fit->chi2, 1) : 0;
    lab_fit_destroy(fit);
    lab_dataset_close(set);
    return status;
}

/* a pendulum that air brakes, and what is found, written in all its forms */
static stein_status call_diagnose(uint64_t *result, stein_err *err)
{
    const char *const file[] = {path_swing[0], path_swing[1], path_swing[2]};
    static const unsigned char held_out[] = {0, 0, 1};
    lab_data_options data = lab_data_options_default(lab_equations(pendulum));
    lab_options options = lab_options_default();
    lab_diagnose_def def = lab_diagnose_def_default();
    lab_dataset *set = NULL;
    lab_diagnosis *found = NULL;
    options.cache = folder;
    def.options = &options;
    def.held_out = held_out;
    def.threads = 1;
    stein_status status = lab_dataset_open(&set, file, 3, &data, err);
    status =
        status == STEIN_OK ? lab_diagnose(&found, path_yaml, pendulum, set, &def, err) : status;
    status = status == STEIN_OK ? lab_diagnosis_json(path_out, found, err) : status;
    status = status == STEIN_OK ? lab_diagnosis_page(path_out, found, err) : status;
    status = status == STEIN_OK ? lab_extend(path_out, path_yaml, found, err) : status;
    *result = status == STEIN_OK ? hash_file(path_out) : 0;
    lab_diagnosis_destroy(found);
    lab_dataset_close(set);
    return status;
}

/* with a compiler that writes a line; what is in an FMU is tested elsewhere */
static stein_status call_fmu(uint64_t *result, stein_err *err)
{
    lab_options options = lab_options_default();
    lab_fmu_facts facts;
    options.cc = path_cc;
    options.cache = folder;
    stein_status status = lab_fmu(path_out, pendulum, 3, &options, &facts, err);
    *result = status == STEIN_OK ? hash_file(path_out) : 0;
    return status;
}

/* a project with joints of several kinds and notes on what is left out */
static stein_status call_import(uint64_t *result, stein_err *err)
{
    lab_imported done;
    uint64_t heard = STEIN_HASH;
    stein_status status = lab_import_mbs("tests/mbs/arm.mbs", path_out, hear, &heard, &done, err);
    *result = status == STEIN_OK ? hash_file(path_out) ^ heard : 0;
    return status;
}

/* ---- one after the other ---- */

static const struct {
    const char *name;
    call *call;
    int by_place; /* not every allocation fails, but the first one of every so many-th place; of
                     every place, if the call is asked for */
} calls[] = {
    {"create", call_create, 0},     {"read", call_read, 0},     {"problems", call_problems, 0},
    {"generate", call_generate, 0}, {"open", call_open, 0},     {"strike", call_strike, 0},
    {"drive", call_drive, 0},       {"vary", call_vary, 0},     {"merge", call_merge, 0},
    {"data", call_data, 0},         {"fit", call_fit, 3},       {"diagnose", call_diagnose, 20},
    {"fmu", call_fmu, 2},           {"import", call_import, 0}, {"sections", call_sections, 0}};
enum { CALLS = sizeof calls / sizeof *calls };

static int wrong;

static void complain(const char *name, long at, const char *what)
{
    printf("FAILED: %s, allocation %ld%s: %s\n", name, at,
           atomic_load(&for_good) ? " and all after it" : "", what);
    fflush(stdout);
    backtrace_symbols_fd(refused_frame, refused_depth, STDOUT_FILENO);
    wrong++;
}

/* @return 1 while there was an allocation to fail */
static int try_one(int i, long at, uint64_t expected)
{
    stein_err err = {STEIN_OK, ""};
    uint64_t result = 0;
    long before = atomic_load(&live);
    atomic_store(&asked, 0);
    atomic_store(&refused, 0);
    atomic_store(&in_gsl, 0);
    atomic_store(&fail_at, at);
    stein_status status = calls[i].call(&result, &err);
    atomic_store(&fail_at, 0);
    long after = atomic_load(&live);
    // GSL forgets the outer part of what it cannot make whole; that is not ours to mend
    if (after != before && !atomic_load(&in_gsl)) {
        char text[60];
        snprintf(text, sizeof text, "%ld blocks are left", after - before);
        complain(calls[i].name, at, text);
    }
    if (status == STEIN_OK && result != expected && atomic_load(&refused) > 0 &&
        strcmp(calls[i].name, "problems") != 0) {
        complain(calls[i].name, at, "another result without an error");
    }
    if (status != STEIN_OK && (err.code != status || err.msg[0] == '\0')) {
        complain(calls[i].name, at, "an error without a message");
    }
    return atomic_load(&refused) > 0;
}

/* allocations to fail: the first ones of every so many-th place. @return how many */
static int find_places(int i, int stride)
{
    stein_err err;
    uint64_t result;
    int n = 0;
    memset(place, 0, sizeof place);
    places = 0;
    atomic_store(&asked, 0);
    atomic_store(&noting, 1);
    calls[i].call(&result, &err);
    atomic_store(&noting, 0);
    for (int k = 0; k < places; k += stride) {
        first_at[n++] = first_at[k];
    }
    return n;
}

static void fail_all(int i, int stride)
{
    stein_err err = {STEIN_OK, ""};
    uint64_t expected = 0;
    calls[i].call(&expected, &err); // what is kept for ever (buffers, caches) is there now
    if (calls[i].call(&expected, &err) != STEIN_OK) {
        printf("FAILED: %s: %s\n", calls[i].name, err.msg);
        wrong++;
        return;
    }
    int by_place = calls[i].by_place > 0;
    long n = 0, some = by_place ? find_places(i, stride) : LONG_MAX;
    for (int good = 0; good < 2; good++) {
        atomic_store(&for_good, good);
        for (long k = 0; k < some; k++) {
            long at = by_place ? first_at[k] : k + 1;
            if (try_one(i, at, expected)) {
                n++;
            } else if (by_place) {
                complain(calls[i].name, at, "nobody asks for it any more");
            } else {
                break;
            }
        }
    }
    printf("faults: %-9s %5ld allocations failed\n", calls[i].name, n);
}

static void find_gsl(void)
{
    char line[400];
    FILE *f = fopen("/proc/self/maps", "r");
    while (f != NULL && fgets(line, sizeof line, f) != NULL) {
        unsigned long from, to;
        char rights[8];
        if (strstr(line, "/libgsl.") != NULL &&
            sscanf(line, "%lx-%lx %7s", &from, &to, rights) == 3 && rights[2] == 'x') {
            gsl_from = from;
            gsl_to = to;
        }
    }
    if (f != NULL) {
        fclose(f);
    }
}

/* air that brakes with the square of the speed */
static void air(void *ctx, double t, const double *q, const double *qd, double *Q)
{
    (void)ctx, (void)t, (void)q;
    Q[0] -= 2e-3 * fabs(qd[0]) * qd[0];
}

/* swings in it from three heights */
static void make_swings(stein_sim *sim)
{
    stein_err err;
    stein_on_force(sim, air, NULL);
    for (int k = 0; k < 3; k++) {
        double q = 0.5 + 0.2 * k, qd = 0.0;
        snprintf(path_swing[k], sizeof path_swing[k], "%s/swing%d.csv", folder, k);
        FILE *f = fopen(path_swing[k], "w");
        fprintf(f, "# noise angle: 1e-4\n# set rod.initial.position: %.17g\ntime [s],angle [rad]\n",
                q);
        stein_set_state(sim, 0.0, &q, &qd, &err);
        for (int i = 0; i < 120; i++) {
            stein_run(sim, 0.02 * i, &err);
            fprintf(f, "%.17g,%.17g\n", 0.02 * i,
                    stein_q(sim)[0] + 1e-4 * ((i * 7919) % 13 - 6) / 3.7);
        }
        fclose(f);
    }
}

static void prepare(void)
{
    stein_err err = {STEIN_OK, ""};
    lab_model *a = NULL, *p = NULL;
    stein_sim *sim = NULL;
    if (mkdtemp(folder) == NULL || lab_open(&a, "models/stein1788.yaml", NULL, &err) != STEIN_OK ||
        lab_open(&p, "models/pendulum.yaml", NULL, &err) != STEIN_OK ||
        lab_sim(p, NULL, &sim, &err) != STEIN_OK) {
        printf("FAILED: %s\n", err.msg);
        exit(EXIT_FAILURE);
    }
    action = a;
    pendulum = p;
    snprintf(path_csv, sizeof path_csv, "%s/swing.csv", folder);
    snprintf(path_out, sizeof path_out, "%s/out", folder);
    snprintf(path_journal, sizeof path_journal, "%s/journal", folder);
    snprintf(path_cc, sizeof path_cc, "%s/cc", folder);
    snprintf(path_yaml, sizeof path_yaml, "models/pendulum.yaml");
    snprintf(path_drive, sizeof path_drive, "%s/drive.csv", folder);
    FILE *f = fopen(path_drive, "w");
    fprintf(f, "time [s],key_motion [rad],finger [N]\n");
    for (int i = 0; i < 5; i++) {
        fprintf(f, "%.17g,%.17g,%.17g\n", 1e-3 * i, 2e-4 * i * i, 0.3 * i);
    }
    fclose(f);
    f = fopen(path_csv, "w");
    fprintf(f, "# noise angle: 1e-4\ntime [s],angle [rad]\n");
    for (int i = 0; i < 60; i++) {
        stein_run(sim, 0.02 * i, &err);
        fprintf(f, "%.17g,%.17g\n", 0.02 * i, stein_q(sim)[0] + 1e-4 * ((i * 7919) % 13 - 6) / 6.0);
    }
    fclose(f);
    make_swings(sim);
    stein_sim_destroy(sim);
    f = fopen(path_cc, "w");
    fprintf(f, "#!/bin/sh\n[ \"$1\" = -dumpmachine ] && echo x86_64-linux-gnu && exit\n"
               "while [ \"$1\" != -o ]; do shift; done\necho compiled >\"$2\"\n");
    fclose(f);
    chmod(path_cc, 0700);
}

int main(int argc, char **argv)
{
    gsl_set_error_handler_off();
    setvbuf(stdout, NULL, _IOLBF, 0);
    void *frame[FRAMES];
    (void)backtrace(frame, FRAMES); // loads what it needs
    find_gsl();
    prepare();
    int all = argc > 1 && strcmp(argv[1], "all") == 0, chosen = 0;
    for (int i = 0; i < CALLS; i++) {
        if (argc < 2 || all || strcmp(argv[1], calls[i].name) == 0) {
            fail_all(i, argc < 2 ? calls[i].by_place : 1);
            chosen++;
        }
    }
    if (chosen == 0) {
        printf("FAILED: no call \"%s\"\n", argv[1]);
        wrong++;
    }
    char clean[64];
    snprintf(clean, sizeof clean, "rm -rf %s", folder);
    wrong += system(clean) != 0;
    printf("faults: %d failed\n", wrong);
    return wrong == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
