/* SPDX-License-Identifier: GPL-3.0-or-later
 * files.c - files for the calls: measured swings, a motion, a compiler that compiles nothing.
 */
#define _DEFAULT_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "../rotor.h"
#include "faults.h"
#include "stein/diagnose.h"
#include "stein/identity.h"

static things all = {.folder = "/tmp/stein-faults-XXXXXX", .yaml = "models/pendulum.yaml"};
const things *const thing = &all;

uint64_t files_hash(const char *path)
{
    char part[4096];
    uint64_t hash = STEIN_HASH;
    memory_calm();
    FILE *f = fopen(path, "rb");
    for (size_t n; f != NULL && (n = fread(part, 1, sizeof part, f)) > 0;) {
        hash = lab__hash(hash, part, n);
    }
    if (f != NULL) {
        fclose(f);
    }
    return hash;
}

lab_options files_options(void)
{
    lab_options options = lab_options_default();
    options.cache = all.folder;
    return options;
}

static void need(stein_status status, const stein_err *err)
{
    if (status != STEIN_OK) {
        printf("FAILED: %s\n", err->msg);
        exit(EXIT_FAILURE);
    }
}

static FILE *begin(char path[FILES_PATH], const char *name)
{
    snprintf(path, FILES_PATH, "%s/%s", all.folder, name);
    FILE *f = fopen(path, "w");
    if (f == NULL) {
        printf("FAILED: %s cannot be written\n", path);
        exit(EXIT_FAILURE);
    }
    return f;
}

static void write_script(char path[FILES_PATH], const char *name, const char *lines)
{
    FILE *f = begin(path, name);
    fprintf(f, "#!/bin/sh\n%s", lines);
    fclose(f);
    chmod(path, 0700);
}

/* ---- measured ---- */

/* air that brakes with the square of the speed */
static void air(void *drag, double t, const double *q, const double *qd, double *Q)
{
    (void)t, (void)q;
    Q[0] -= *(double *)drag * fabs(qd[0]) * qd[0];
}

static double noise(int i)
{
    return ((i * 7919) % 13 - 6) / 3.7;
}

/* angles of a simulation that is let go at q, with noise sd; told: start state in the file */
static void film(char path[FILES_PATH], const char *name, stein_sim *sim, double q, double every,
                 double sd, const char *told)
{
    stein_err err;
    double still = 0.0;
    FILE *f = begin(path, name);
    fprintf(f, "# noise angle: %g\n", sd);
    if (told != NULL) {
        fprintf(f, "# set %s: %.17g\n", told, q);
    }
    fprintf(f, "time [s],angle [rad]\n");
    stein_set_state(sim, 0.0, &q, &still, &err);
    for (int i = 0; i < 120; i++) {
        stein_run(sim, every * i, &err);
        fprintf(f, "%.17g,%.17g\n", every * i, stein_q(sim)[0] + sd * noise(i));
    }
    fclose(f);
}

/* swings from three heights and one to fit, in air */
static void film_pendulum(void)
{
    static const char told[] = "rod.initial.position";
    stein_err err = {STEIN_OK, ""};
    stein_sim *sim = NULL;
    double drag = 2e-3;
    need(lab_sim(all.pendulum, NULL, &sim, &err), &err);
    film(all.csv, "swing.csv", sim, stein_q(sim)[0], 0.01, 1e-4, NULL);
    stein_on_force(sim, air, &drag);
    for (int k = 0; k < 3; k++) {
        char name[] = {'s', 'w', 'i', 'n', 'g', (char)('0' + k), '\0'};
        film(all.swing[k], name, sim, 0.5 + 0.2 * k, 0.02, 1e-4, told);
    }
    stein_sim_destroy(sim);
}

/* A wheel released at one angle, for which several drags are alike, and its diagnosis. */
static void diagnose_rotor(void)
{
    stein_err err = {STEIN_OK, ""};
    stein_sim *sim = NULL;
    lab_model *rotor = NULL;
    lab_dataset *set = NULL;
    lab_diagnosis *found = NULL;
    lab_options options = files_options();
    lab_diagnose_def def = lab_diagnose_def_default();
    double drag = 1e-4;
    const char *file[3];
    FILE *f = begin(all.rotor_yaml, "rotor.yaml");
    fputs(rotor_text, f);
    fclose(f);
    need(lab_open(&rotor, all.rotor_yaml, &options, &err), &err);
    all.rotor = rotor;
    need(lab_sim(rotor, NULL, &sim, &err), &err);
    stein_on_force(sim, air, &drag);
    for (int k = 0; k < 3; k++) {
        char path[FILES_PATH], name[] = {'t', 'u', 'r', 'n', (char)('0' + k), '\0'};
        film(path, name, sim, 0.2, 0.7 / 119, 1e-3, NULL);
        file[k] = strdup(path);
    }
    lab_data_options data = lab_data_options_default(lab_equations(rotor));
    def.options = &options;
    def.threads = 1;
    need(lab_dataset_open(&set, file, 3, &data, &err), &err);
    need(lab_diagnose(&found, all.rotor_yaml, rotor, set, &def, &err), &err);
    snprintf(all.found, sizeof all.found, "%s/diagnosis.json", all.folder);
    need(lab_diagnosis_json(all.found, found, &err), &err);
    if (found->ncause != 1 || found->nrival < 1) {
        printf("FAILED: the drags of the wheel do not look alike\n");
        exit(EXIT_FAILURE);
    }
    lab_diagnosis_destroy(found);
    lab_dataset_close(set);
    stein_sim_destroy(sim);
    for (int k = 0; k < 3; k++) {
        free((void *)file[k]);
    }
}

/* ---- all of it ---- */

static void record_stroke(void)
{
    stein_err err = {STEIN_OK, ""};
    stein_sim *sim = NULL;
    lab_record *record = NULL;
    lab_stroke_def def = lab_stroke_def_default(lab_equations(all.action));
    need(lab_sim(all.action, NULL, &sim, &err), &err);
    need(lab_record_create(&record, lab_equations(all.action), 1e-3, &err), &err);
    def.sample = lab_record_sample;
    def.ctx = record;
    need(lab_strike(sim, &def, &all.stroke, &err), &err);
    all.record = record;
    stein_sim_destroy(sim);
}

/* programs that others are: other tests check their contents */
static void write_programs(void)
{
    char path[FILES_PATH];
    write_script(all.cc, "cc",
                 "[ \"$1\" = -dumpmachine ] && echo x86_64-linux-gnu && exit\n"
                 "while [ \"$1\" != -o ]; do shift; done\n"
                 "echo compiled >\"$2\"\n");
    write_script(path, "gnuplot",
                 "while read -r set output place; do\n"
                 "    [ \"$set $output\" = 'set output' ] && [ -n \"$place\" ] || continue\n"
                 "    place=${place#?}\n"
                 "    echo drawn >\"${place%?}\"\n"
                 "done <\"$1\"\n");
    const char *was = getenv("PATH");
    char *with = lab__text("%s:%s", all.folder, was != NULL ? was : "/usr/bin:/bin");
    setenv("PATH", with, 1);
    setenv("WASM_CC", all.cc, 1);
    free(with);
}

void files_make(void)
{
    stein_err err = {STEIN_OK, ""};
    lab_model *action = NULL, *pendulum = NULL;
    if (mkdtemp(all.folder) == NULL) {
        printf("FAILED: no folder in /tmp\n");
        exit(EXIT_FAILURE);
    }
    need(lab_open(&action, "models/stein1788.yaml", NULL, &err), &err);
    need(lab_open(&pendulum, all.yaml, NULL, &err), &err);
    all.action = action;
    all.pendulum = pendulum;
    snprintf(all.out, sizeof all.out, "%s/out", all.folder);
    snprintf(all.journal, sizeof all.journal, "%s/journal", all.folder);
    FILE *f = begin(all.drive, "drive.csv");
    fprintf(f, "time [s],key_motion [rad],finger [N]\n");
    for (int i = 0; i < 5; i++) {
        fprintf(f, "%.17g,%.17g,%.17g\n", 1e-3 * i, 2e-4 * i * i, 0.3 * i);
    }
    fclose(f);
    record_stroke();
    film_pendulum();
    diagnose_rotor(); // with a compiler that is one
    write_programs();
}

int files_remove(void)
{
    char remove[80];
    snprintf(remove, sizeof remove, "rm -rf %s", all.folder);
    return system(remove) != 0;
}
