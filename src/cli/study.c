/* SPDX-License-Identifier: GPL-3.0-or-later
 * study.c - stein study: the published facts of the regulation, simulated, and further studies.
 */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli.h"
#include "study.h"

/* the sweep and its facts; the report beyond it */
typedef struct inquiry {
    const cli_args *args;
    lab_model *model;
    lab_point *point;
    int npoint;
    lab_fact fact[LAB_FACTS_MAX];
    int nfact;
    cli_progress progress;
    char part[40]; /* what the progress is about */
    study study;
    study_report report;
} inquiry;

static void on_progress(void *ctx, int done, int total)
{
    inquiry *s = ctx;
    cli_progress_show(&s->progress, (double)done / total);
}

/* the same for the parts of the report: each has its own bar */
static void on_part(void *ctx, const char *what, int done, int total)
{
    inquiry *s = ctx;
    if (strcmp(s->part, what) != 0) {
        cli_progress_end(&s->progress);
        snprintf(s->part, sizeof s->part, "%s", what);
        cli_progress_begin(&s->progress, s->part);
    }
    cli_progress_show(&s->progress, (double)done / total);
}

/* the report beyond the facts; `threads` as in the sweep */
static stein_status look_further(inquiry *s, int threads, stein_err *err)
{
    s->study = (study){.model = s->model,
                       .threads = threads,
                       .dt = 20e-6,
                       .seed = 1788,
                       .samples = 300,
                       .progress = on_part,
                       .ctx = s,
                       .point = s->point,
                       .npoint = s->npoint,
                       .fact = s->fact,
                       .nfact = s->nfact};
    cli_progress_begin(&s->progress, s->part);
    stein_status status = study_run(&s->study, &s->report, err);
    cli_progress_end(&s->progress);
    return status;
}

static stein_status simulate(inquiry *s, int threads, stein_err *err)
{
    s->npoint = lab_study_grid(NULL, 0);
    s->point = calloc((size_t)s->npoint, sizeof *s->point);
    if (s->point == NULL) {
        return lab__no_memory(err);
    }
    lab_study_grid(s->point, s->npoint);
    cli_progress_begin(&s->progress, "strokes over dx");
    stein_status status = lab_sweep(s->model, s->point, s->npoint, threads, on_progress, s, err);
    cli_progress_end(&s->progress);
    if (status == STEIN_OK) {
        s->nfact = lab_facts(s->fact, s->point, s->npoint);
    }
    return status;
}

/* ---- files of the folder ---- */

static void put(FILE *f, double value, char end)
{
    char text[LAB_NUMBER];
    fprintf(f, "%s%c", value == value ? lab__number(text, value) : "", end); // NAN: empty cell
}

static void write_sweep(FILE *f, const inquiry *s)
{
    fprintf(f, "# model: %s\n", lab_equations(s->model)->name);
    for (int i = 0; i < s->args->nset; i++) {
        int length = (int)strcspn(s->args->set[i], "=");
        fprintf(f, "# set %.*s: ", length, s->args->set[i]);
        lab__put_line(f, s->args->set[i] + length + 1);
    }
    fprintf(f, "pawl.stop_shift [m],outcome,escapement_time [s],escapement_height [m],"
               "impact_time [s],impact_speed [m/s],impacts [1],free_flight [s],"
               "forced_escapement [1],peak_string_force [N],rearmed [1]\n");
    for (int i = 0; i < s->npoint; i++) {
        const lab_stroke *k = &s->point[i].stroke;
        put(f, s->point[i].dx, ',');
        if (s->point[i].status != STEIN_OK) {
            fprintf(f, "failed,,,,,,,,,\n");
            continue;
        }
        fprintf(f, "%s,", lab_outcome_text(k->outcome));
        put(f, k->escape_time, ',');
        put(f, k->escape_height, ',');
        put(f, k->impact_time, ',');
        put(f, k->impact_speed, ',');
        fprintf(f, "%d,", k->impacts);
        put(f, k->free_flight, ',');
        fprintf(f, "%d,", k->forced_escapement);
        put(f, k->peak_string_force, ',');
        fprintf(f, "%d\n", k->rearmed);
    }
}

static void write_facts(FILE *f, const inquiry *s)
{
    lab__json j = {.stream = f};
    lab__json_open(&j, NULL, '[');
    for (int i = 0; i < s->nfact; i++) {
        lab__json_open(&j, NULL, '{');
        lab__json_text(&j, "fact", s->fact[i].fact);
        lab__json_text(&j, "paper", s->fact[i].paper);
        lab__json_text(&j, "simulated", s->fact[i].simulated);
        lab__json_text(&j, "within", s->fact[i].within);
        lab__json_bool(&j, "calibrated", s->fact[i].calibrated);
        lab__json_bool(&j, "ok", s->fact[i].ok);
        lab__json_close(&j);
    }
    lab__json_close(&j);
}

/* a file of the study: name and writer; figures join this list */
static const struct {
    const char *name;
    void (*write)(FILE *f, const inquiry *s);
} files[] = {{"sweep.csv", write_sweep}, {"facts.json", write_facts}};
enum { FILES = sizeof files / sizeof *files };

/* errors of output fail before a minute of work */
static stein_status check_place(const char *folder, int pictures, stein_err *err)
{
    char *gnuplot[] = {"gnuplot", "--version", NULL};
    lab__file file;
    int code = 0;
    stein_status status = lab__folder(folder, err);
    char *path = lab__text("%s/%s", folder, files[FILES - 1].name);
    if (status == STEIN_OK) {
        status = path == NULL ? lab__no_memory(err) : lab__file_open(&file, path, err);
    }
    if (status == STEIN_OK) {
        status = lab__file_close(&file, 0, err);
    }
    free(path);
    if (status == STEIN_OK && pictures) {
        status = lab__spawn(gnuplot, "/dev/null", &code, err);
    }
    return status == STEIN_OK && code == 127
               ? lab__fail(err, STEIN_EIO,
                           "no gnuplot to draw with: run apt-get install gnuplot-nox "
                           "(--facts needs none)")
               : status;
}

static stein_status write_files(const inquiry *s, const char *folder, stein_err *err)
{
    stein_status status = lab__folder(folder, err);
    for (int i = 0; status == STEIN_OK && i < FILES; i++) {
        lab__file file;
        char *path = lab__text("%s/%s", folder, files[i].name);
        status = path != NULL ? lab__file_open(&file, path, err) : lab__no_memory(err);
        if (status == STEIN_OK) {
            files[i].write(file.stream, s);
            status = lab__file_close(&file, 1, err);
        }
        free(path);
    }
    return status;
}

/* ---- standard output ---- */

static void cell(const char *text, int width)
{
    printf("%s%*s", text, width - cli_width(text) + 2, "");
}

static int count_ok(const inquiry *s)
{
    int ok = 0;
    for (int i = 0; i < s->nfact; i++) {
        ok += s->fact[i].ok != 0;
    }
    return ok;
}

static void print_table(const inquiry *s, const char *folder)
{
    int width[3] = {4, 5, 9};
    for (int i = 0; i < s->nfact; i++) {
        const char *text[] = {s->fact[i].fact, s->fact[i].paper, s->fact[i].simulated};
        for (int k = 0; k < 3; k++) {
            width[k] = cli_width(text[k]) > width[k] ? cli_width(text[k]) : width[k];
        }
    }
    cell("fact", width[0]);
    cell("paper", width[1]);
    cell("simulated", width[2]);
    printf("verdict\n");
    for (int i = 0; i < s->nfact; i++) {
        cell(s->fact[i].fact, width[0]);
        cell(s->fact[i].paper, width[1]);
        cell(s->fact[i].simulated, width[2]);
        printf("%s%s\n", s->fact[i].ok ? "ok" : "OFF", s->fact[i].calibrated ? ", calibrated" : "");
    }
    int calibrated = 0;
    for (int i = 0; i < s->nfact; i++) {
        calibrated += s->fact[i].calibrated;
    }
    printf("%d of %d facts reproduced; the numbers of the model were calibrated for %d of them\n",
           count_ok(s), s->nfact, calibrated);
    if (s->report.npart > 0) {
        printf("%s/study.html\n", folder);
    }
    for (int i = 0; i < FILES; i++) {
        printf("%s/%s\n", folder, files[i].name);
    }
}

static void print_json(const inquiry *s)
{
    lab__json j = {.stream = stdout};
    lab__json_open(&j, NULL, '{');
    lab__json_text(&j, "model", lab_equations(s->model)->name);
    lab__json_int(&j, "facts", s->nfact);
    lab__json_int(&j, "ok", count_ok(s));
    lab__json_open(&j, "off", '[');
    for (int i = 0; i < s->nfact; i++) {
        if (!s->fact[i].ok) {
            lab__json_text(&j, NULL, s->fact[i].fact);
        }
    }
    lab__json_close(&j);
    lab__json_close(&j);
}

static int run(const cli_args *args)
{
    const char *folder = cli_value(args, "output");
    inquiry s = {.args = args};
    stein_err err = {STEIN_OK, ""};
    int threads = 1, code = cli_threads(args, &threads);
    if (folder == NULL) {
        return cli_misuse(args->command, "where to? expected -o DIR");
    }
    if (code != CLI_OK) {
        return code;
    }
    int further = cli_value(args, "facts") == NULL;
    stein_status status = cli_open(&s.model, args, &err);
    if (status == STEIN_OK) {
        status = check_place(folder, further, &err);
    }
    if (status == STEIN_OK) {
        status = simulate(&s, threads, &err);
    }
    if (status == STEIN_OK) {
        status = write_files(&s, folder, &err);
    }
    if (status == STEIN_OK && further) {
        status = look_further(&s, threads, &err);
    }
    if (status == STEIN_OK && further) {
        status = study_write(&s.study, &s.report, folder, &err);
    }
    if (status == STEIN_OK && cli_value(args, "json") != NULL) {
        print_json(&s);
    } else if (status == STEIN_OK) {
        print_table(&s, folder);
    }
    study_report_free(&s.report);
    free(s.point);
    lab_close(s.model);
    return status == STEIN_OK ? CLI_OK : cli_failed(status, &err);
}

static const cli_option options[] = {
    {"output", 'o', "DIR", "Folder of the results, made if need be. Required."},
    {"facts", 'f', NULL, "Only the table of facts: no pictures, nothing beyond the paper."},
    {"jobs", 'j', "N", "Threads; default: one a processor. Results do not depend on it."},
    CLI_COMMON};

const cli_command cli_study = {
    .name = "study",
    .summary = "the published facts of the regulation, simulated",
    .operands = "MODEL",
    .noperands = 1,
    .options = options,
    .description =
        "Simulates a stroke at every position of the pawl's stop from dx = -1.5 mm to +0.3 mm\n"
        "in steps of 0.05 mm (parameter pawl.stop_shift, positive to the right). Compares the\n"
        "results with the facts of the published study of the Stein action. Straight lines\n"
        "are fitted by least squares over -1.2 .. 0 mm in steps of 0.1 mm. A fact that\n"
        "differs is no failure of the command: it is marked in the table.\n"
        "\n"
        "Further parts answer questions beyond the publication: the static escapement height,\n"
        "the pawl's spring as a second regulation, the notch's angle, touch and repetition,\n"
        "the sensitivity to every parameter, and making tolerances. Parts without their\n"
        "inputs or parameters in the model are left out; the report lists them.",
    .output =
        "The table fact | paper | simulated | verdict, then the path of every file in DIR:\n"
        "\n"
        "  study.html  the report: one page with every picture, no network needed\n"
        "  sweep.csv   one row a stroke, SI units, empty cells where there was no such event\n"
        "  facts.json  [{\"fact\", \"paper\", \"simulated\", \"ok\"}]\n"
        "\n"
        "and the pictures of the report as NAME.svg with their data as NAME.csv: figure09, "
        "figure11,\n"
        "figure12, figure13 (numbered as in the publication), regulation, notch_angle, touch,\n"
        "repetition, sensitivity, tolerance.\n"
        "\n"
        "With --json: {\"model\", \"facts\", \"ok\", \"off\": [fact]}.",
    .examples = "stein study models/stein1788.yaml -o results\n"
                "stein study models/stein1788.yaml --set notch.friction.A=0.30 -o results/smooth",
    .run = run,
};
