/* SPDX-License-Identifier: GPL-3.0-or-later
 * fit.c - stein fit: parameters of a mechanism from measured strokes.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "stein/fit.h"

typedef struct job {
    const cli_args *args;
    lab_model *model;
    lab_dataset *data;
    lab_fit_def def;
    lab_fit *fit;
    const char *free[CLI_NAMES], *profile[CLI_NAMES];
    char *text[2]; /* memory behind them */
    cli_progress progress;
} job;

static void on_progress(void *ctx, double fraction, const char *step)
{
    job *j = ctx;
    j->progress.what = step;
    cli_progress_show(&j->progress, fraction);
}

static void on_report(void *ctx, const char *message)
{
    (void)ctx;
    fprintf(stderr, "%s\n", message);
}

/* ---- the command line ---- */

static int read_quantity(const job *j, const char *option, mech_dim dim, double *value)
{
    const char *text = cli_value(j->args, option);
    stein_err err;
    if (text != NULL && mech_parse_quantity(text, dim, value, &err) != STEIN_OK) {
        return cli_misuse(j->args->command, "--%s %s: %s", option, text, err.msg);
    }
    return text == NULL || *value >= 0.0
               ? CLI_OK
               : cli_misuse(j->args->command, "--%s %s: expected no negative number", option, text);
}

static int read_names(job *j)
{
    const char *free = cli_value(j->args, "free"), *profile = cli_value(j->args, "profile");
    if (free == NULL) {
        return cli_misuse(j->args->command,
                          "which numbers are to be fitted? expected --free NAME,...");
    }
    j->def.nfree = cli_names(free, &j->text[0], j->free);
    j->def.free = j->free;
    if (j->def.nfree < 0) {
        return cli_misuse(j->args->command, "--free %s: expected names separated by commas", free);
    }
    j->def.profile_flagged = profile != NULL && strcmp(profile, "flagged") == 0;
    if (profile != NULL && !j->def.profile_flagged) {
        j->def.nprofile = cli_names(profile, &j->text[1], j->profile);
        j->def.profile = j->profile;
        if (j->def.nprofile < 0) {
            return cli_misuse(j->args->command,
                              "--profile %s: expected names separated by commas, or flagged",
                              profile);
        }
    }
    return CLI_OK;
}

static int read_options(job *j)
{
    const char *initial = cli_value(j->args, "initial");
    j->def = lab_fit_def_default();
    int code = read_names(j);
    code = code == CLI_OK ? cli_threads(j->args, &j->def.threads) : code;
    code = code == CLI_OK ? cli_count(j->args, "starts", LAB_FIT_STARTS, &j->def.starts) : code;
    code = code == CLI_OK ? read_quantity(j, "prior", (mech_dim){.kg = 0}, &j->def.prior) : code;
    code = code == CLI_OK ? read_quantity(j, "offset", (mech_dim){.m = 1}, &j->def.offset) : code;
    code = code == CLI_OK ? read_quantity(j, "trigger", (mech_dim){.s = 1}, &j->def.trigger) : code;
    if (code == CLI_OK && !(j->def.prior > 0.0)) {
        code = cli_misuse(j->args->command, "--prior 0: expected a fraction above 0");
    }
    if (code == CLI_OK && initial != NULL) {
        j->def.initial = strcmp(initial, "free") == 0 ? 1 : strcmp(initial, "fixed") == 0 ? 0 : -1;
        if (j->def.initial < 0 && strcmp(initial, "auto") != 0) {
            code =
                cli_misuse(j->args->command, "--initial %s: expected free, fixed or auto", initial);
        }
    }
    const char *scatter = cli_value(j->args, "scatter");
    if (code == CLI_OK && scatter != NULL) {
        j->def.scatter = strcmp(scatter, "yes") == 0 ? 1 : strcmp(scatter, "no") == 0 ? 0 : -1;
        if (j->def.scatter < 0 && strcmp(scatter, "auto") != 0) {
            code = cli_misuse(j->args->command, "--scatter %s: expected yes, no or auto", scatter);
        }
    }
    j->def.robust = cli_value(j->args, "robust") != NULL;
    j->def.journal = cli_value(j->args, "journal");
    return code;
}

/* ---- results ---- */

static void print_parameter(const lab_fit_value *v, int width)
{
    char value[CLI_TEXT], lo[CLI_TEXT], hi[CLI_TEXT], start[CLI_TEXT];
    printf("  %-*s  %-22s  95 %%: %s .. %s  (was %s)%s\n", width, v->name,
           cli_quantity(value, v->value, v->unit), cli_quantity(lo, v->lo, v->unit),
           cli_quantity(hi, v->hi, v->unit), cli_quantity(start, v->start, v->unit),
           v->unseen ? "  NO DATA DEPEND ON IT" : "");
    if (v->profiled) {
        int below = isfinite(v->profile_lo), above = isfinite(v->profile_hi);
        printf("  %-*s  profile: %s .. %s\n", width, "",
               below ? cli_quantity(lo, v->profile_lo, v->unit) : "(open)",
               above ? cli_quantity(hi, v->profile_hi, v->unit) : "(open)");
    }
}

static void print_residuals(const lab_fit *fit)
{
    printf("residuals (rms / noise):\n");
    for (int i = 0; i < fit->nresidual; i++) {
        const lab_fit_residual *r = &fit->residual[i];
        char rms[CLI_TEXT], noise[CLI_TEXT];
        printf("  %s  %s: %s / %s = %.3g%s, %.3g %% of the signal", fit->stroke[r->stroke].file,
               r->channel, cli_quantity(rms, r->rms, r->unit),
               cli_quantity(noise, r->noise, r->unit), r->rms / r->noise,
               r->noise_given ? "" : " (noise estimated)", 100.0 * r->relative);
        printf(r->downweighted > 0 ? ", %d down-weighted\n" : "\n", r->downweighted);
    }
    for (int s = 0; s < fit->nstroke; s++) {
        if (fit->stroke[s].lacking > 0) {
            printf("  %s: %d of the measured events do not happen with these numbers\n",
                   fit->stroke[s].file, fit->stroke[s].lacking);
        }
    }
}

static void print_weakest(const lab_fit *fit)
{
    if (fit->nvalue < 2 || !(fit->weakest_sd > 1.0)) {
        return;
    }
    printf("the data hardly determine this combination (%.3g prior sd):", fit->weakest_sd);
    for (int k = 0; k < fit->nvalue; k++) {
        if (fabs(fit->weakest[k]) > 0.2) {
            printf(" %+.2f %s", fit->weakest[k], fit->value[k].name);
        }
    }
    printf("\n");
}

static void print_text(const job *j)
{
    const lab_fit *fit = j->fit;
    int width = 0;
    for (int k = 0; k < fit->nvalue; k++) {
        int n = (int)strlen(fit->value[k].name);
        width = n > width ? n : width;
    }
    printf("%s: %s%s%s\n", lab_equations(j->model)->name, lab_fit_status_text(fit->status),
           fit->reason[0] != '\0' ? " - " : "", fit->reason);
    for (int k = 0; k < fit->nvalue; k++) {
        print_parameter(&fit->value[k], width);
    }
    printf("%d samples of %d record%s, chi2/dof %.4g (band %.3g .. %.3g)%s\n", fit->samples,
           fit->nstroke, fit->nstroke == 1 ? "" : "s", fit->chi2_dof, fit->band_lo, fit->band_hi,
           fit->noise_given ? "" : ", noise estimated");
    for (int i = 0; i < fit->npair; i++) {
        printf("the data hardly distinguish %s from %s (correlation %.4f)\n",
               fit->value[fit->pair[i].a].name, fit->value[fit->pair[i].b].name,
               fit->pair[i].correlation);
    }
    print_weakest(fit);
    print_residuals(fit);
}

/* ---- running ---- */

static int open_data(job *j)
{
    stein_err err = {STEIN_OK, ""};
    lab_data_options options = lab_data_options_default(lab_equations(j->model));
    options.report = on_report;
    options.progress = cli_progress_read;
    options.ctx = &j->progress;
    cli_progress_begin(&j->progress, "reading");
    stein_status status =
        lab_dataset_open(&j->data, j->args->operand + 1, j->args->noperand - 1, &options, &err);
    cli_progress_end(&j->progress);
    if (status == STEIN_EPARSE || status == STEIN_EIO) {
        err.msg[0] = '\0'; // told one by one
    }
    return status == STEIN_OK ? CLI_OK : cli_failed(status, &err);
}

static int compute(job *j)
{
    stein_err err = {STEIN_OK, ""};
    j->def.progress = on_progress;
    j->def.report = on_report;
    j->def.ctx = j;
    cli_progress_begin(&j->progress, "fit");
    stein_status status = lab_fit_run(&j->fit, j->model, j->data, &j->def, &err);
    cli_progress_end(&j->progress);
    if (status != STEIN_OK) {
        return cli_failed(status, &err);
    }
    if (j->fit->resumed) {
        fprintf(stderr, "stein: went on from %s\n", j->def.journal);
    }
    return CLI_OK;
}

static int show(job *j)
{
    stein_err err = {STEIN_OK, ""};
    const char *path = cli_value(j->args, "output");
    lab_options options = lab_options_default();
    options.set = j->args->set;
    options.nset = j->args->nset;
    if (path != NULL) {
        stein_status status = lab_fit_write(path, j->fit, j->args->operand[0], &options, &err);
        if (status != STEIN_OK) {
            return cli_failed(status, &err);
        }
    }
    if (cli_value(j->args, "json") != NULL) {
        stein_status status = lab_fit_json("-", lab_equations(j->model)->name, j->fit, &err);
        if (status != STEIN_OK) {
            return cli_failed(status, &err);
        }
    } else if (path == NULL || !lab__is_stdout(path)) {
        print_text(j);
    }
    if (j->fit->status != LAB_FIT_CONVERGED) {
        fprintf(stderr, "stein: %s: %s\n", lab_fit_status_text(j->fit->status), j->fit->reason);
    }
    return j->fit->status == LAB_FIT_NOT_CONVERGED ? CLI_NUMERICAL : CLI_OK;
}

static int run_job(job *j)
{
    int code = cli_free_known(j->args, j->model, j->free, j->def.nfree);
    code = code == CLI_OK ? open_data(j) : code;
    code = code == CLI_OK ? compute(j) : code;
    return code == CLI_OK ? show(j) : code;
}

static int run(const cli_args *args)
{
    job j = {.args = args};
    stein_err err = {STEIN_OK, ""};
    int code = read_options(&j);
    if (code == CLI_OK) {
        stein_status status = cli_open(&j.model, args, &err);
        code = status == STEIN_OK ? run_job(&j) : cli_failed(status, &err);
    }
    lab_fit_destroy(j.fit);
    lab_dataset_close(j.data);
    lab_close(j.model);
    free(j.text[0]);
    free(j.text[1]);
    return code;
}

static const cli_option options[] = {
    {"free", 0, "NAME,...",
     "The parameters to fit, as stein check names them. A tolerance in the file (+-) is the\n"
     "prior; without one it is --prior. Positive masses, stiffnesses, frictions are fitted as\n"
     "logarithms."},
    {"output", 'o', "FILE.yaml",
     "The mechanism file with the fitted numbers in their places and their standard\n"
     "deviations as tolerances; comments stay; the head states numbers and records of the fit."},
    {"jobs", 'j', "N", "Threads; default: one a processor. Results do not depend on it."},
    {"journal", 0, "FILE",
     "Keep the state of the search in FILE. After an interruption the same command\n"
     "continues from it, with the same result."},
    {"starts", 0, "N",
     "Searches from different places, default 3; more than half of them have to agree. The\n"
     "rest is left out when enough agree and the residual is noise."},
    {"robust", 0, NULL, "Bisquare weights: single bad frames get little weight."},
    {"profile", 0, "NAME,...",
     "Profile likelihood of these parameters: their intervals with all others refitted.\n"
     "`flagged`: the first three that the data hardly distinguish."},
    {"prior", 0, "FRACTION", "Relative sd of a number without tolerance; default 0.3."},
    {"offset", 0, "LENGTH",
     "Prior sd of the offset of every marker, default 0.2mm (an angle: over 100 mm); 0: none."},
    {"trigger", 0, "T", "Prior sd of an unsynchronised trigger, default 2ms; 0: trust it."},
    {"scatter", 0, "HOW",
     "Variation from record to record: joint friction 5 %, contact friction 8 %, drive 0.3 %.\n"
     "yes, no or auto (default): yes with four records or more."},
    {"initial", 0, "HOW",
     "Initial state of every record: free, fixed as in the file, or auto (default): free\n"
     "where the mechanism does not settle and the record does not set it."},
    CLI_COMMON};

const cli_command cli_fit = {
    .name = "fit",
    .summary = "parameters from measured records",
    .operands = "MODEL DATA...",
    .noperands = 2,
    .more = 1,
    .options = options,
    .description =
        "Weighted nonlinear least squares over all samples of all records. Each record is "
        "simulated\n"
        "with its `# set` values and its measured inputs and compared at its own times. The "
        "weights\n"
        "are `# noise`, or the noise that the audit estimates. Further unknowns of each\n"
        "record are fitted too: the time of an unsynchronised trigger, an offset of every\n"
        "marker, factors on its friction and drive, and the initial state (it starts from the\n"
        "first samples) unless the record states it.\n"
        "\n"
        "A false minimum looks like missing physics. So the fit starts from several points: the\n"
        "file's numbers and points spread over the priors; unless these agree, also with an\n"
        "observer that holds the model near the data at first. The status is `converged` when the\n"
        "starts agree and the residual is noise, `misfit` when they agree and the residual is\n"
        "larger, `not_converged` otherwise (exit status 3).",
    .output =
        "A table of values with 95 % intervals, parameters that the data do not separate, "
        "residuals.\n"
        "With --json: {\"model\", \"status\", \"reason\", \"parameters\": [{\"name\", \"value\",\n"
        "\"unit\", \"sd\", \"lo\", \"hi\", \"start\", \"prior_sd\", \"data_sd\", \"unseen\",\n"
        "\"logarithmic\", \"profile\"}], \"chi2\", \"prior\", \"samples\", \"dof\", \"chi2_dof\",\n"
        "\"band\", \"inflation\", \"noise_given\", \"gradient\", \"sensitivity_error\", "
        "\"starts\",\n"
        "\"collinear\": [{\"a\", \"b\", \"correlation\"}], \"condition\", \"weakest\",\n"
        "\"strokes\": [{\"file\", \"fnv1a64\", \"rows\", \"lacking_events\", \"chi2\", "
        "\"nuisances\",\n"
        "\"channels\"}]}.",
    .examples =
        "stein fit models/stein1788.yaml strokes/*.csv --free hammer.mass,notch.friction.A \\\n"
        "    -o fitted.yaml\n"
        "stein fit models/pendulum.yaml swing.csv --free rod.damping --profile rod.damping",
    .run = run,
};
