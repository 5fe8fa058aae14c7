/* SPDX-License-Identifier: GPL-3.0-or-later
 * sweep.c - stein sweep: one stroke at every point of a grid of parameters.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"

typedef struct job {
    const cli_args *args;
    lab_model *model;
    lab_grid *grid;
    lab_vary_def def;
    lab_table *table;
    cli_progress progress;
} job;

static void on_progress(void *ctx, int done, int total)
{
    job *j = ctx;
    cli_progress_show(&j->progress, (double)done / total);
}

/* a whole number at *text; *text moves behind it */
static int read_int(const char **text, long *n)
{
    size_t digits = strspn(*text, "0123456789");
    if (digits == 0 || digits > 9) {
        return -1;
    }
    *n = strtol(*text, NULL, 10);
    *text += digits;
    return 0;
}

/* ---- the command line ---- */

static int read_shard(job *j)
{
    const char *text = cli_value(j->args, "shard"), *at = text;
    long i, n;
    if (text == NULL) {
        return CLI_OK;
    }
    if (read_int(&at, &i) != 0 || *at++ != '/' || read_int(&at, &n) != 0 || *at != '\0' || i < 1 ||
        n < 1 || i > n) {
        return cli_misuse(j->args->command, "--shard %s: expected I/N with I from 1 to N", text);
    }
    j->def.shard = (int)(i - 1);
    j->def.shards = (int)n;
    if (n == 1) {
        return CLI_OK;
    }
    if (j->def.journal == NULL) {
        return cli_misuse(j->args->command,
                          "--shard %s computes a part, which is kept for stein "
                          "merge: expected --journal FILE",
                          text);
    }
    if (cli_value(j->args, "output") != NULL || cli_value(j->args, "plot") != NULL) {
        return cli_misuse(j->args->command,
                          "--shard %s computes a part: table and picture come "
                          "from stein merge",
                          text);
    }
    return CLI_OK;
}

static int read_times(job *j)
{
    int code = cli_time(j->args, "until", &j->def.until);
    code = code == CLI_OK ? cli_time(j->args, "release", &j->def.release) : code;
    if (code != CLI_OK) {
        return code;
    }
    if (!(j->def.until > 0.0)) {
        return cli_misuse(j->args->command, "--until %g s: expected a positive time", j->def.until);
    }
    if (!isnan(j->def.release) && !(j->def.release >= 0.0 && j->def.release <= j->def.until)) {
        return cli_misuse(j->args->command,
                          "--release %g s: expected a time from 0 to the end at "
                          "%g s",
                          j->def.release, j->def.until);
    }
    return CLI_OK;
}

/* checks that do not need the mechanism file */
static int read_options(job *j)
{
    j->def = (lab_vary_def){.until = INFINITY, .release = NAN, .shards = 1};
    if (j->args->nvary == 0) {
        return cli_misuse(j->args->command, "what varies? expected --vary NAME=FROM:TO:COUNT");
    }
    j->def.journal = cli_value(j->args, "journal");
    j->def.tolerance = cli_value(j->args, "tolerance");
    j->def.fixed = cli_value(j->args, "fixed") != NULL;
    if (j->def.fixed && j->def.tolerance != NULL) {
        return cli_misuse(j->args->command, "--fixed steps have no --tolerance");
    }
    j->def.set = j->args->set;
    j->def.nset = j->args->nset;
    int code = read_shard(j);
    code = code == CLI_OK ? cli_threads(j->args, &j->def.threads) : code;
    return code == CLI_OK ? cli_results_check(j->args) : code;
}

/* ---- running ---- */

/* the axes are part of the command line: errors in them are misuse */
static int make_grid(job *j)
{
    lab_options options = lab_options_default();
    options.set = j->args->set;
    options.nset = j->args->nset;
    stein_err err = {STEIN_OK, ""};
    stein_status status = lab_grid_open(&j->grid, j->model, j->args->vary, j->args->nvary,
                                        j->args->operand[0], &options, &err);
    if (status == STEIN_EINVAL || status == STEIN_ENAME) {
        fprintf(stderr, "stein: --%s\n", err.msg);
        return CLI_USAGE;
    }
    return status == STEIN_OK ? CLI_OK : cli_failed(status, &err);
}

static int check_plot(const job *j)
{
    int varied = 0;
    for (int i = 0; i < j->grid->naxis; i++) {
        varied += j->grid->axis[i].n > 1;
    }
    if (cli_value(j->args, "plot") != NULL && varied > 2) {
        return cli_misuse(j->args->command, "--plot shows one or two varied parameters, not %d",
                          varied);
    }
    return CLI_OK;
}

static int compute(job *j)
{
    stein_err err = {STEIN_OK, ""};
    lab_vary_report report = {0, 0, 0};
    cli_progress_begin(&j->progress, "strokes");
    stein_status status = lab_vary(&j->table, j->model, j->grid, &j->def, &report, &err);
    cli_progress_end(&j->progress);
    if (status != STEIN_OK) {
        return cli_failed(status, &err);
    }
    cli_damaged(report.damaged);
    if (report.found > 0) {
        fprintf(stderr, "stein: %d points were in %s, %d are new\n", report.found, j->def.journal,
                report.computed);
    }
    return CLI_OK;
}

static int run_job(job *j)
{
    j->def.until = lab_until(j->model);
    j->def.progress = on_progress;
    j->def.ctx = j;
    int code = read_times(j);
    code = code == CLI_OK ? make_grid(j) : code;
    code = code == CLI_OK ? check_plot(j) : code;
    code = code == CLI_OK ? compute(j) : code;
    return code == CLI_OK ? cli_results(j->args, j->table, j->def.shards > 1) : code;
}

static int run(const cli_args *args)
{
    job j = {.args = args};
    stein_err err = {STEIN_OK, ""};
    int code = read_options(&j);
    if (code != CLI_OK) {
        return code;
    }
    stein_status status = cli_open(&j.model, args, &err);
    code = status == STEIN_OK ? run_job(&j) : cli_failed(status, &err);
    lab_table_destroy(j.table);
    lab_grid_destroy(j.grid);
    lab_close(j.model);
    return code;
}

static const cli_option options[] = {
    {"vary", 0, "NAME=VALUES",
     "A parameter to vary, FROM:TO:COUNT or VALUE,VALUE,... Repeatable: every combination\n"
     "is a point, the last parameter runs fastest. A unit that is given once holds for all\n"
     "numbers (-1.2:0:13mm); without any they are SI. Values are rounded to 15 digits in\n"
     "that unit, so that a grid hits 0.1 mm exactly."},
    {"jobs", 'j', "N", "Threads; default: one a processor. Results do not depend on it."},
    {"journal", 0, "FILE",
     "Keep every finished point in FILE at once, and do not compute it again.\n"
     "Run the same command again after an interruption. A journal of another sweep is\n"
     "refused."},
    {"shard", 0, "I/N",
     "Compute only the points with index % N = I - 1, I from 1 to N; needs --journal.\n"
     "stein merge puts the journals together."},
    {"until", 0, "T", "Simulate so long, e.g. 0.3s or 300ms; default: that of the file."},
    {"release", 0, "T", "Lift the load at this time, as in stein strike."},
    {"tolerance", 0, "CHANNEL=VALUE",
     "Steps of controlled error, with about this error in this output (a position, x, y, z\n"
     "or gap), e.g. string_distance=0.1um; default: the file's tolerance, or fixed steps\n"
     "where it has none."},
    {"fixed", 0, NULL, "The file's fixed steps, also where it states a tolerance."},
    {"output", 'o', "FILE.csv",
     "The table; - is standard output, which is the default. A file appears whole or not\n"
     "at all."},
    {"plot", 0, "FILE.svg",
     "Draw with gnuplot, .svg or .png: curves over one varied parameter, a map of the\n"
     "escapement height over two."},
    CLI_COMMON};

const cli_command cli_sweep = {
    .name = "sweep",
    .summary = "strokes over a grid of parameters",
    .operands = "MODEL",
    .noperands = 1,
    .options = options,
    .description =
        "Runs one stroke at every combination of the varied parameters - or, for a mechanism\n"
        "without stroke, simulates and takes the final outputs. Every point is a separate\n"
        "simulation that starts from its own equilibrium. A point that fails numerically is a\n"
        "row with its status (ESETTLE: no equilibrium, ENONFINITE, ESINGULAR, ECHATTER) and\n"
        "empty cells. The table is the same, byte for byte, for any number of threads, any\n"
        "sharding and any interruption.\n"
        "\n"
        "A number that is a literal 0 in the file is not in the equations; --set NAME=VALUE\n"
        "adds it, then --vary can vary it.",
    .output =
        "CSV: `# name: value` lines with the sweep's definition, then a row a point in SI units:\n"
        "point, the varied parameters, status, then outcome, escapement_time,\n"
        "escapement_height, impact_time, impact_speed, impacts, free_flight,\n"
        "forced_escapement, peak_string_force, blow, rearmed - or the output channels.\n"
        "Numbers are the shortest decimals that read back exactly; a cell is empty if the\n"
        "event did not happen.\n"
        "\n"
        "With --json: {\"model\", \"points\", \"present\", \"failed\", \"vary\": [{\"name\",\n"
        "\"unit\", \"values\"}], \"results\": [{column: value}]}. Exit status 3 only when every\n"
        "point failed.",
    .examples =
        "stein sweep models/stein1788.yaml --vary pawl.stop_shift=-1.2:0:13mm -o dx.csv --plot "
        "dx.svg\n"
        "stein sweep models/stein1788.yaml --vary pawl.stop_shift=-1:0:21mm \\\n"
        "    --vary pawl.notch_angle=75:90:16deg --journal map.journal -o map.csv\n"
        "seq 4 | parallel stein sweep models/stein1788.yaml --vary pawl.stop_shift=-1.2:0:241mm "
        "\\\n"
        "    -j 1 --shard {}/4 --journal part{}.journal && stein merge part*.journal -o dx.csv\n"
        "stein sweep MODEL --vary ... --journal part$SLURM_ARRAY_TASK_ID.journal \\\n"
        "    --shard $SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT    (sbatch --array=1-16)",
    .run = run,
};
