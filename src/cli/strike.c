/* SPDX-License-Identifier: GPL-3.0-or-later
 * strike.c - stein strike, also called stein simulate: one run of a mechanism.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "creep.h"
#include "errors.h"

static const int samples_by_default = 3000;
static const int most_plot_samples = 100000;

/* everything of one run */
typedef struct job {
    const cli_args *args;
    lab_model *model;
    const stein_model *equations;
    stein_sim *sim;
    stein_sim_def sim_def;
    lab_stroke_def def;
    double every;
    lab_format format; /* of -o */
    lab_drive *drive;
    lab_record *table, *picture; /* NULL: not asked for */
    lab_stroke stroke;
    int is_stroke;
    double tolerance; /* of controlled steps [rad or m] */
    lab__accuracy *trust;
    cli_errors errors;
    int *begins; /* [ncontact] of contacts */
    cli_creep *creep;
    cli_progress progress;
} job;

/* ---- the command line ---- */

static int read_numbers(job *j)
{
    const cli_args *args = j->args;
    const char *integrator = cli_value(args, "integrator");
    int code = cli_time(args, "until", &j->def.until);
    code = code == CLI_OK ? cli_time(args, "release", &j->def.release) : code;
    code = code == CLI_OK ? cli_time(args, "dt", &j->sim_def.dt) : code;
    j->every = j->def.until / samples_by_default;
    code = code == CLI_OK ? cli_time(args, "every", &j->every) : code;
    if (code != CLI_OK) {
        return code;
    }
    if (integrator != NULL) {
        int i = STEIN_RK4;
        while (i <= STEIN_IMPLICIT && strcmp(integrator, mech_integrator(i)) != 0) {
            i++;
        }
        if (i > STEIN_IMPLICIT) {
            return cli_misuse(args->command,
                              "--integrator %s: expected rk4, dp5, controlled or implicit",
                              integrator);
        }
        j->sim_def.integrator = (stein_integrator)i;
    }
    if (cli_value(args, "tolerance") != NULL &&
        (lab_quantity(&j->tolerance, cli_value(args, "tolerance"), "1", NULL) != STEIN_OK ||
         !(j->tolerance > 0.0))) {
        return cli_misuse(args->command, "--tolerance %s: expected a positive number",
                          cli_value(args, "tolerance"));
    }
    if (!(j->def.until > 0.0)) {
        return cli_misuse(args->command, "--until %g s: expected a positive time", j->def.until);
    }
    if (!(j->sim_def.dt > 0.0)) {
        return cli_misuse(args->command, "--dt %g s: expected a positive time", j->sim_def.dt);
    }
    if (!(j->every >= 0.0)) {
        return cli_misuse(args->command, "--every %g s: expected an interval", j->every);
    }
    if (!isnan(j->def.release) && !(j->def.release >= 0.0 && j->def.release <= j->def.until)) {
        return cli_misuse(args->command, "--release %g s: expected a time from 0 to the end, %g s",
                          j->def.release, j->def.until);
    }
    return CLI_OK;
}

/* --format, else by the ending of -o */
static int read_format(job *j)
{
    static const char *const name[] = {"csv", "npy", "mat", "csv-plain"};
    const char *table = cli_value(j->args, "output"), *format = cli_value(j->args, "format");
    j->format = table != NULL ? lab_format_of(table) : LAB_CSV;
    if (format == NULL) {
        return CLI_OK;
    }
    if (table == NULL) {
        return cli_misuse(j->args->command, "--format %s needs a file: -o", format);
    }
    for (int i = LAB_CSV; i <= LAB_CSV_PLAIN; i++) {
        if (strcmp(format, name[i]) == 0) {
            j->format = (lab_format)i;
            return CLI_OK;
        }
    }
    return cli_misuse(j->args->command, "--format %s: expected csv, csv-plain, npy or mat", format);
}

/* ---- running ---- */

static stein_status on_sample(void *ctx, stein_sim *sim)
{
    job *j = ctx;
    cli_progress_show(&j->progress, stein_time(sim) / j->def.until);
    stein_status status = j->table != NULL ? lab_record_sample(j->table, sim) : STEIN_OK;
    if (status == STEIN_OK && j->picture != NULL) {
        status = lab_record_sample(j->picture, sim);
    }
    int contact = -1;
    double rate = stein_stiffest(sim, &contact);
    if (rate > j->errors.stiffest) {
        j->errors.stiffest = rate;
        j->errors.stiff_contact = contact;
        j->errors.stiff_time = stein_time(sim);
    }
    cli_creep_look(j->creep, sim);
    lab__accuracy_step(j->trust, sim);
    if (stein_time(sim) >= j->def.until) {
        lab__accuracy_end(j->trust, sim);
    }
    return status;
}

static void on_event(void *ctx, stein_sim *sim, const stein_event *event)
{
    job *j = ctx;
    (void)sim;
    if (event->kind == STEIN_EVENT_CONTACT_BEGIN && ++j->begins[event->index] > j->errors.begins) {
        j->errors.begins = j->begins[event->index];
        j->errors.busiest = event->index;
    }
}

/* observers of the run */
static stein_status prepare_errors(job *j, stein_err *err)
{
    stein_status status = stein_set_tolerance(j->sim, j->tolerance, err);
    j->begins = calloc((size_t)j->equations->ncontact + 1, sizeof *j->begins);
    j->creep = cli_creep_begin(j->equations, j->def.until);
    if (status == STEIN_OK && (j->begins == NULL || j->creep == NULL)) {
        status = lab__no_memory(err);
    }
    if (status == STEIN_OK) {
        status = lab__accuracy_create(&j->trust, j->model, &j->sim_def, j->tolerance, j->def.until,
                                      j->drive, err);
    }
    if (status == STEIN_OK) {
        status = lab__accuracy_begin(j->trust, j->sim, err);
    }
    j->errors = (cli_errors){.model = j->equations,
                             .trust = j->trust,
                             .drive = j->drive,
                             .integrator = j->sim_def.integrator,
                             .dt = j->sim_def.dt,
                             .tolerance = j->tolerance,
                             .until = j->def.until};
    return status;
}

static stein_status prepare(job *j, stein_err *err)
{
    stein_status status = STEIN_OK;
    if (cli_value(j->args, "output") != NULL) {
        status = lab_record_create(&j->table, j->equations, j->every, err);
    }
    if (status == STEIN_OK && cli_value(j->args, "plot") != NULL) {
        double finest = j->def.until / most_plot_samples;
        finest = finest > j->sim_def.dt ? finest : 0.0;
        status = lab_record_create(&j->picture, j->equations, finest, err);
    }
    if (status == STEIN_OK) {
        status = lab_sim(j->model, &j->sim_def, &j->sim, err);
    }
    if (status == STEIN_OK && cli_value(j->args, "drive") != NULL) {
        status = lab_drive_open(&j->drive, cli_value(j->args, "drive"), j->equations, err);
        status = status == STEIN_OK ? lab_drive_bind(j->drive, j->sim, err) : status;
        status = status == STEIN_OK ? stein_reset(j->sim, err) : status;
    }
    return status == STEIN_OK ? prepare_errors(j, err) : status;
}

static stein_status simulate(job *j, stein_err *err)
{
    j->def.sample = on_sample;
    j->def.event = on_event;
    j->def.ctx = j;
    cli_progress_begin(&j->progress, j->equations->name);
    stein_status status = j->is_stroke ? lab_strike(j->sim, &j->def, &j->stroke, err)
                                       : lab_simulate(j->sim, &j->def, err);
    cli_progress_end(&j->progress);
    if (status == STEIN_ENONFINITE || status == STEIN_ESINGULAR || status == STEIN_ECHATTER) {
        lab__accuracy_fail(j->trust, j->sim);
        cli_errors_gimbal(&j->errors);
    }
    stein_steps_taken(j->sim, &j->errors.steps);
    j->errors.passes = stein_singular_passes(j->sim, &j->errors.passed);
    if (status == STEIN_OK && j->table != NULL) {
        status = lab_record_finish(j->table, j->sim);
    }
    return status;
}

/* ---- files ---- */

/* "# name: value" lines of the CSV; owned texts, closed by NULL */
static char **make_notes(const job *j)
{
    const cli_args *args = j->args;
    char **note = calloc((size_t)args->nset + 8, sizeof *note), number[LAB_NUMBER];
    int n = 0;
    if (note == NULL) {
        return NULL;
    }
    note[n++] = lab__text("model: %s", j->equations->name);
    note[n++] = lab__text("equations: %s", j->equations->equations);
    note[n++] = lab__text("integrator: %s", mech_integrator((int)j->sim_def.integrator));
    note[n++] = lab__text("dt: %s s", lab__number(number, j->sim_def.dt));
    for (int i = 0; i < args->nset; i++) {
        int length = (int)strcspn(args->set[i], "=");
        note[n++] = lab__text("set %.*s: %s", length, args->set[i], args->set[i] + length + 1);
    }
    if (!isnan(j->def.release)) {
        note[n++] = lab__text("release: %s s", lab__number(number, j->def.release));
    }
    if (cli_value(args, "drive") != NULL) {
        note[n++] = lab__text("drive: %s", cli_value(args, "drive"));
    }
    if (j->is_stroke) {
        note[n++] = lab__text("outcome: %s", lab_outcome_text(j->stroke.outcome));
    }
    return note;
}

static stein_status write_table(const job *j, const char *path, stein_err *err)
{
    char **note = make_notes(j);
    if (note == NULL) {
        return lab__no_memory(err);
    }
    stein_status status = lab_write(path, j->format, j->table, (const char *const *)note, err);
    for (int i = 0; note[i] != NULL; i++) {
        free(note[i]);
    }
    free(note);
    return status;
}

static stein_status write_files(const job *j, stein_err *err)
{
    const char *table = cli_value(j->args, "output"), *picture = cli_value(j->args, "plot");
    stein_status status = table != NULL ? write_table(j, table, err) : STEIN_OK;
    if (status == STEIN_OK && picture != NULL) {
        status = lab_plot(picture, j->picture, j->equations, j->is_stroke ? &j->stroke : NULL, err);
    }
    return status;
}

/* ---- results ---- */

static void print_stroke_json(lab__json *out, const lab_stroke *s)
{
    lab__json_text(out, "outcome", lab_outcome_text(s->outcome));
    if (s->escaped) {
        lab__json_open(out, "escapement", '{');
        lab__json_real(out, "time", s->escape_time);
        lab__json_real(out, "height", s->escape_height);
        lab__json_close(out);
    } else {
        lab__json_null(out, "escapement");
    }
    if (s->impacts > 0) {
        lab__json_open(out, "impact", '{');
        lab__json_real(out, "time", s->impact_time);
        lab__json_real(out, "speed", s->impact_speed);
        lab__json_close(out);
    } else {
        lab__json_null(out, "impact");
    }
    lab__json_int(out, "impacts", s->impacts);
    lab__json_real(out, "free_flight", s->free_flight);
    lab__json_bool(out, "forced_escapement", s->forced_escapement);
    lab__json_real(out, "peak_string_force", s->peak_string_force);
    lab__json_bool(out, "rearmed", s->rearmed);
}

static void print_json(const job *j)
{
    lab__json out = {.stream = stdout};
    lab__json_open(&out, NULL, '{');
    lab__json_text(&out, "model", j->equations->name);
    if (j->is_stroke) {
        print_stroke_json(&out, &j->stroke);
    }
    lab__json_open(&out, "final", '{');
    for (int i = 0; i < j->equations->nchannel; i++) {
        lab__json_real(&out, j->equations->channels[i].name, stein_read(j->sim, i));
    }
    lab__json_close(&out);
    cli_put_reactions(&out, j->sim);
    cli_errors_json(&out, &j->errors);
    lab__json_close(&out);
}

static void print_stroke(FILE *f, const lab_stroke *s)
{
    static const char *const verdict[] = {"the string is struck", "the notch misses the beak",
                                          "the hammer does not escape",
                                          "the hammer escapes but does not reach the string"};
    fprintf(f, "  %-14s %s\n", "outcome", verdict[s->outcome]);
    if (s->escaped) {
        fprintf(f, "  %-14s %8.3f ms   head %.3f mm below the string%s\n", "escapement",
                1e3 * s->escape_time, 1e3 * s->escape_height,
                s->forced_escapement ? ", forced: after the impact" : "");
    }
    if (s->impacts > 0) {
        fprintf(f, "  %-14s %8.3f ms   %.3f m/s, blow %.2f mm, %d impact%s\n", "impact",
                1e3 * s->impact_time, s->impact_speed, 1e3 * s->blow, s->impacts,
                s->impacts == 1 ? "" : "s");
        fprintf(f, "  %-14s %8.3f ms\n", "free flight", 1e3 * s->free_flight);
        fprintf(f, "  %-14s %8.3f N\n", "peak force", s->peak_string_force);
    }
    fprintf(f, "  %-14s %s\n", "re-armed", s->rearmed ? "yes" : "no");
}

static void print_final(FILE *f, const job *j)
{
    fprintf(f, "  at the end\n");
    for (int i = 0; i < j->equations->nchannel; i++) {
        char text[CLI_TEXT];
        const stein_channel *c = &j->equations->channels[i];
        fprintf(f, "    %-24s %s\n", c->name, cli_quantity(text, stein_read(j->sim, i), c->unit));
    }
}

static void print_text(const job *j)
{
    const char *table = cli_value(j->args, "output"), *picture = cli_value(j->args, "plot");
    FILE *f = table != NULL && lab__is_stdout(table) ? stderr : stdout;
    char dt[CLI_TEXT], until[CLI_TEXT];
    fprintf(f, "%s, %s with dt = %s, %s\n", j->equations->name,
            mech_integrator((int)j->sim_def.integrator), cli_quantity(dt, j->sim_def.dt, "s"),
            cli_quantity(until, j->def.until, "s"));
    if (j->is_stroke) {
        print_stroke(f, &j->stroke);
    } else {
        print_final(f, j);
    }
    cli_errors_line(f, &j->errors);
    if (table != NULL && !lab__is_stdout(table)) {
        fprintf(f, "%s\n", table);
    }
    if (picture != NULL) {
        fprintf(f, "%s\n", picture);
    }
}

static void free_job(job *j)
{
    lab_record_destroy(j->table);
    lab_record_destroy(j->picture);
    lab__accuracy_destroy(j->trust);
    free(j->begins);
    free(j->creep);
    stein_sim_destroy(j->sim);
    lab_drive_close(j->drive);
    lab_close(j->model);
}

static int run_job(job *j)
{
    stein_err err = {STEIN_OK, ""};
    int code = read_format(j);
    code = code == CLI_OK ? read_numbers(j) : code;
    if (code != CLI_OK) {
        return code;
    }
    stein_status status = prepare(j, &err);
    if (status == STEIN_OK) {
        status = simulate(j, &err);
    }
    if (status == STEIN_OK) {
        status = write_files(j, &err);
    }
    if (status != STEIN_OK) {
        return cli_failed(status, &err);
    }
    if (cli_value(j->args, "json") != NULL) {
        print_json(j);
    } else {
        print_text(j);
    }
    cli_warn_reactions(j->sim);
    int wrong = cli_errors_warn(&j->errors);
    cli_creep_warn(j->creep, lab__accuracy_errors(j->trust)->range[LAB_SLIDES]);
    return wrong && cli_value(j->args, "allow-error") == NULL ? CLI_NUMERICAL : CLI_OK;
}

static int run(const cli_args *args)
{
    job j = {.args = args, .tolerance = STEIN_TOLERANCE};
    stein_err err = {STEIN_OK, ""};
    const char *table = cli_value(args, "output"), *picture = cli_value(args, "plot");
    if (table != NULL && lab__is_stdout(table) && cli_value(args, "json") != NULL) {
        return cli_misuse(args->command, "--json and -o %s both want standard output", table);
    }
    if (picture != NULL && lab__picture_name(picture, &err) != STEIN_OK) {
        return cli_misuse(args->command, "--plot %s", err.msg);
    }
    stein_status status = cli_open(&j.model, args, &err);
    if (status != STEIN_OK) {
        return cli_failed(status, &err);
    }
    j.equations = lab_equations(j.model);
    j.is_stroke = j.equations->stroke.string >= 0;
    j.sim_def = lab_def(j.model);
    j.def = lab_stroke_def_default(j.equations);
    int code = run_job(&j);
    free_job(&j);
    return code;
}

static const cli_option options[] = {
    {"until", 0, "T", "Simulate so long, e.g. 0.3s or 300ms; default: that of the file."},
    {"release", 0, "T",
     "Lift the load at this time. The following motion shows the return of the action and\n"
     "decides whether it re-arms; it is not part of the stroke."},
    {"integrator", 0, "rk4|dp5|controlled|implicit",
     "rk4, dp5: Runge-Kutta 4 or Dormand-Prince 5 with fixed steps. controlled:\n"
     "Dormand-Prince 5(4) divides a step by its error estimate, and implicit steps follow\n"
     "where the motion is too stiff for it. implicit: implicit steps only. Default: the\n"
     "file's, else controlled."},
    {"dt", 0, "S", "Length of a step, e.g. 10us; default: the file's."},
    {"tolerance", 0, "E",
     "Error estimate of a controlled step at most [rad or m]; default: 1e-12."},
    {"allow-error", 0, NULL,
     "Exit with 0 although the result is not to be trusted; the warning stays."},
    {"every", 0, "T",
     "Interval of the rows of -o, rounded up to whole steps; 0: every step. Default: 1/3000\n"
     "of the duration. Results do not depend on it."},
    {"drive", 0, "FILE.csv",
     "Signals for inputs: each column named like an input of the mechanism drives it.\n"
     "Motions become natural cubic splines, forces run straight between the samples."},
    {"output", 'o', "FILE.csv",
     "Write all output channels; - is standard output (the summary then goes to standard\n"
     "error)."},
    {"format", 0, "csv|csv-plain|npy|mat",
     "Form of -o; default: by its ending, else csv. csv-plain has no # lines and names without\n"
     "units: numpy.genfromtxt(file, names=True, delimiter=',') and pandas.read_csv(file)\n"
     "read it. npy is a structured array of NumPy with a field for each channel. mat is\n"
     "MATLAB's level 5 with a column for each channel, a struct of units and the notes of\n"
     "the CSV as a text."},
    {"plot", 0, "FILE.svg", "Draw the run with gnuplot, .svg or .png."},
    CLI_COMMON};

#define DESCRIPTION                                                                               \
    "Runs the mechanism of the file MODEL from its initial state. If the file names a stroke\n"   \
    "(a string, and a notch where the hammer escapes), the load rests on the key and is let go\n" \
    "at t = 0, and the stroke is judged:\n"                                                       \
    "\n"                                                                                          \
    "  struck         the hammer escaped and met the string\n"                                    \
    "  missed_notch   the beak did not touch the notch's roof or corner\n"                        \
    "  no_escapement  it did, but did not leave the notch\n"                                      \
    "  no_impact      it left the notch, but the string was not touched\n"                        \
    "\n"                                                                                          \
    "Escapement is the instant at which the beak's end passes the corner of the notch; its\n"     \
    "height is the distance of head and string then. The impact's speed is their closing\n"       \
    "speed at first contact. The action is re-armed when, the load lifted, the beak is back\n"    \
    "under the roof and the hammer at rest at the end. Without --release it is decided in\n"      \
    "0.5 s of simulation after the end, in which the load is lifted.\n"                           \
    "\n"                                                                                          \
    "Any other mechanism is simulated. `stein strike` and `stein simulate` are the same\n"        \
    "command. Equations that are not built in are generated, compiled with the system's cc\n"     \
    "into $XDG_CACHE_HOME/stein (or ~/.cache/stein) and loaded; a changed number never\n"         \
    "needs the compiler, a changed structure starts it automatically."
#define OUTPUT                                                                                \
    "A summary in ms, mm, N. With --json, in SI units:\n"                                     \
    "{\"model\", \"outcome\", \"escapement\": {\"time\", \"height\"} or null, \"impact\":\n"  \
    "{\"time\", \"speed\"} or null, \"impacts\", \"free_flight\", \"forced_escapement\",\n"   \
    "\"peak_string_force\", \"rearmed\", \"final\": {channel: value}, \"undetermined\",\n"    \
    "\"integration\",\n"                                                                      \
    "\"errors\", \"energy\", \"trusted\"}; for a mechanism without a stroke {\"model\",\n"    \
    "\"final\", \"undetermined\", \"integration\", \"errors\", \"energy\", \"trusted\"}.\n"   \
    "`undetermined` names outputs that have one of many possible values: reactions of\n"      \
    "redundant conditions, friction that contacts share. `integration` is about\n"            \
    "controlled steps: their number (`steps`), the number of `implicit` ones, the time\n"     \
    "from which on stability limited explicit ones (`stiff_from`, null: never), the\n"        \
    "decay `rate` [1/s] of the limiting motion, and the reason if they stayed explicit\n"     \
    "all the same (`refused`).\n"                                                             \
    "\n"                                                                                      \
    "The last line states the errors of the run, from two reference simulations with a\n"     \
    "small tolerance. `deviation` is the largest difference to the reference that starts\n"   \
    "with the run. `steps` sums the errors of the steps between 1000 checkpoints.\n"          \
    "`_share` are the same divided by the range of the motion. `energy` lists the work of\n"  \
    "inputs, the energy dissipated by laws and stored in springs, and each law's `work`;\n"   \
    "`unexplained` is the rest, the error of the steps, `scale` the reference energy.\n"      \
    "Above 0.1 % a warning names the cause and a remedy; above 3 % the result is not to\n"    \
    "be trusted: `trusted` is false and the exit code 3 (--allow-error: 0). `lost` is the\n"  \
    "time after which positions are undetermined, because the motion amplifies small\n"       \
    "differences.\n"                                                                          \
    "\n"                                                                                      \
    "The CSV starts with `# name: value` lines (`# set pawl.stop_shift: -0.3mm` for every\n"  \
    "override), then a header of `channel [unit]` with `time [s]` first, then the rows, in\n" \
    "the shortest decimals that read back exactly. It is itself a data file."
#define EXAMPLES                                                                                   \
    "stein strike models/stein1788.yaml\n"                                                         \
    "stein strike models/stein1788.yaml --set pawl.stop_shift=-0.3mm --json\n"                     \
    "stein strike models/stein1788.yaml --release 0.25s --until 0.5s -o stroke.csv --plot s.svg\n" \
    "stein simulate models/double_pendulum.yaml --until 10s --integrator dp5 -o - | head"

const cli_command cli_strike = {
    .name = "strike",
    .summary = "run one stroke of an action",
    .operands = "MODEL",
    .noperands = 1,
    .options = options,
    .description = DESCRIPTION,
    .output = OUTPUT,
    .examples = EXAMPLES,
    .run = run,
};

const cli_command cli_simulate = {
    .name = "simulate",
    .summary = "run any mechanism (the same command)",
    .operands = "MODEL",
    .noperands = 1,
    .options = options,
    .description = DESCRIPTION,
    .output = OUTPUT,
    .examples = EXAMPLES,
    .run = run,
};
