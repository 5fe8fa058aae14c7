/* SPDX-License-Identifier: GPL-3.0-or-later
 * diagnose.c - stein diagnose: effects that a simulation lacks, from measured records.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli.h"
#include "stein/diagnose.h"

enum { FINDINGS = 6, KINDS = 100 };

typedef struct job {
    const cli_args *args;
    lab_model *model;
    lab_dataset *data;
    const char **file; /* [nfile] of all strokes, each once */
    unsigned char *held_out;
    int nfile;
    char **text; /* [nheld] memory behind names between commas */
    const char *free[CLI_NAMES];
    char *names; /* memory behind them */
    const char *without[CLI_NAMES];
    char *kinds; /* memory behind them */
    lab_diagnose_def def;
    lab_diagnosis *diagnosis;
    cli_progress progress;
    const char *folder;
} job;

static void on_report(void *ctx, const char *message)
{
    (void)ctx;
    fprintf(stderr, "%s\n", message);
}

/* ---- the command line ---- */

static int find_file(const job *j, const char *name)
{
    for (int i = 0; i < j->nfile; i++) {
        if (strcmp(j->file[i], name) == 0) {
            return i;
        }
    }
    return -1;
}

/* one more stroke, or one that is there already. @return CLI_OK, or CLI_USAGE after a message */
static int add_file(job *j, const char *name, int held_out)
{
    int i = find_file(j, name);
    if (i < 0 && j->nfile == CLI_OPERANDS) {
        return cli_misuse(j->args->command, "more than %d files", (int)CLI_OPERANDS);
    }
    i = i < 0 ? j->nfile++ : i;
    j->file[i] = name;
    j->held_out[i] |= (unsigned char)held_out;
    return CLI_OK;
}

/* a word of --held-out: a file, or several between commas */
static int add_held(job *j, int k)
{
    const char *word = j->args->held[k];
    int code = CLI_OK;
    if (access(word, F_OK) == 0 || strchr(word, ',') == NULL) {
        return add_file(j, word, 1);
    }
    j->text[k] = lab__text("%s", word);
    for (char *at = j->text[k]; code == CLI_OK && at != NULL;) {
        char *comma = strchr(at, ',');
        if (comma != NULL) {
            *comma = '\0';
        }
        code = *at != '\0' ? add_file(j, at, 1)
                           : cli_misuse(j->args->command,
                                        "--held-out %s: expected files separated by commas", word);
        at = comma != NULL ? comma + 1 : NULL;
    }
    return code;
}

static int read_files(job *j)
{
    int code = CLI_OK, fitted = 0;
    for (int i = 1; code == CLI_OK && i < j->args->noperand; i++) {
        code = add_file(j, j->args->operand[i], 0);
    }
    for (int i = 0; code == CLI_OK && i < j->args->nheld; i++) {
        code = add_held(j, i);
    }
    for (int i = 0; i < j->nfile; i++) {
        fitted += !j->held_out[i];
    }
    if (code == CLI_OK && fitted == 0) {
        code = cli_misuse(j->args->command, "all records are held out, none is left to fit to");
    }
    return code;
}

static int check_without(const job *j, const char *word)
{
    const char *kind[KINDS];
    int n;
    const lab_effect *table = lab_effects(&n);
    for (int i = 0; i < n; i++) {
        if (lab_effect_is(&table[i], word)) {
            return CLI_OK;
        }
    }
    n = n < KINDS ? n : KINDS;
    for (int i = 0; i < n; i++) {
        kind[i] = table[i].kind;
    }
    const char *near = cli_nearest(word, kind, n);
    return cli_misuse(j->args->command,
                      "--without %s: no kind, site or class of effects%s%s (see stein effects)",
                      word, near != NULL ? "; did you mean " : "", near != NULL ? near : "");
}

/* effects of the table that are hidden from the search */
static int read_without(job *j)
{
    const char *without = cli_value(j->args, "without");
    if (without == NULL) {
        return CLI_OK;
    }
    j->def.without = j->without;
    j->def.nwithout = cli_names(without, &j->kinds, j->without);
    if (j->def.nwithout < 0) {
        return cli_misuse(j->args->command, "--without %s: expected words separated by commas",
                          without);
    }
    for (int i = 0; i < j->def.nwithout; i++) {
        int code = check_without(j, j->without[i]);
        if (code != CLI_OK) {
            return code;
        }
    }
    return CLI_OK;
}

/* "20000" strokes or "30s" */
static int read_budget(job *j)
{
    const char *budget = cli_value(j->args, "budget");
    char *end = NULL;
    if (budget == NULL) {
        return CLI_OK;
    }
    double n = strtod(budget, &end);
    if (end == budget || !(n >= 1.0) || !(n < 1e12) || (*end != '\0' && strcmp(end, "s") != 0)) {
        return cli_misuse(j->args->command,
                          "--budget %s: expected a number of simulations, 20000, or seconds, 30s",
                          budget);
    }
    if (*end == 's') {
        j->def.most_seconds = n;
    } else {
        j->def.most_strokes = (long)n;
    }
    return CLI_OK;
}

/* "12Hz" */
static int read_smooth(job *j)
{
    const char *text = cli_value(j->args, "smooth");
    stein_err err = {STEIN_OK, "expected a frequency above 0, 12Hz"};
    if (text == NULL) {
        return CLI_OK;
    }
    stein_status status = mech_parse_quantity(text, (mech_dim){.s = -1}, &j->def.smooth, &err);
    return status == STEIN_OK && j->def.smooth > 0.0
               ? CLI_OK
               : cli_misuse(j->args->command, "--smooth %s: %s", text, err.msg);
}

static int read_options(job *j)
{
    const char *free = cli_value(j->args, "free");
    j->def = lab_diagnose_def_default();
    j->folder = cli_value(j->args, "output");
    if (j->folder == NULL) {
        return cli_misuse(j->args->command, "where to? expected -o DIR");
    }
    if (free != NULL) {
        j->def.free = j->free;
        j->def.nfree = cli_names(free, &j->names, j->free);
        if (j->def.nfree < 0) {
            return cli_misuse(j->args->command, "--free %s: expected names separated by commas",
                              free);
        }
    }
    j->def.trace = cli_value(j->args, "trace");
    j->def.explain = cli_value(j->args, "explain");
    int code = read_budget(j);
    code = code == CLI_OK ? read_smooth(j) : code;
    code = code == CLI_OK ? read_without(j) : code;
    if (code != CLI_OK) {
        return code;
    }
    j->def.held_out = j->args->nheld > 0 ? j->held_out : NULL;
    code = cli_threads(j->args, &j->def.threads);
    return code == CLI_OK ? read_files(j) : code;
}

/* ---- the data ---- */

static int open_data(job *j)
{
    stein_err err = {STEIN_OK, ""};
    lab_data_options options = lab_data_options_default(lab_equations(j->model));
    options.report = on_report;
    options.progress = cli_progress_read;
    options.ctx = &j->progress;
    cli_progress_begin(&j->progress, "reading");
    stein_status status = lab_dataset_open(&j->data, j->file, j->nfile, &options, &err);
    cli_progress_end(&j->progress);
    if (status == STEIN_EPARSE || status == STEIN_EIO) {
        err.msg[0] = '\0'; // told one by one
    }
    return status == STEIN_OK ? CLI_OK : cli_failed(status, &err);
}

/* findings of the audits; the same sentence about several records is one */
typedef struct findings {
    int n, more; /* kept and shown; others, each counted */
    struct {
        char *text;
        const char *file; /* first record */
        int records;
    } item[FINDINGS];
} findings;

static stein_status keep_finding(findings *f, const char *file, const char *text, stein_err *err)
{
    for (int i = 0; i < f->n; i++) {
        if (strcmp(f->item[i].text, text) == 0) {
            f->item[i].records++;
            return STEIN_OK;
        }
    }
    if (f->n == FINDINGS) {
        f->more++;
        return STEIN_OK;
    }
    char *copy = lab__text("%s", text);
    if (copy == NULL) {
        return lab__no_memory(err);
    }
    f->item[f->n].text = copy;
    f->item[f->n].file = file;
    f->item[f->n].records = 1;
    f->n++;
    return STEIN_OK;
}

static stein_status audit_one(const lab_data *data, findings *f, stein_err *err)
{
    lab_audit *audit = NULL;
    stein_status status = lab_audit_create(&audit, data, err);
    for (int i = 0; status == STEIN_OK && i < audit->nfinding; i++) {
        status = keep_finding(f, data->file, audit->finding[i], err);
    }
    lab_audit_destroy(audit);
    return status;
}

static void print_findings(findings *f)
{
    for (int i = 0; i < f->n; i++) {
        if (f->item[i].records > 1) {
            fprintf(stderr, "%s and %d more: %s\n", f->item[i].file, f->item[i].records - 1,
                    f->item[i].text);
        } else {
            fprintf(stderr, "%s: %s\n", f->item[i].file, f->item[i].text);
        }
        free(f->item[i].text);
    }
    if (f->more > 0) {
        fprintf(stderr, "%d findings more, all of them are in diagnosis.json\n", f->more);
    }
}

static int audit_data(const job *j)
{
    stein_err err = {STEIN_OK, ""};
    findings found = {.n = 0};
    stein_status status = cli_value(j->args, "trust-settings") == NULL
                              ? lab_data_check_settings(j->data, j->model, on_report, NULL, &err)
                              : STEIN_OK;
    if (status == STEIN_EPARSE) {
        err.msg[0] = '\0'; // reported one by one
    }
    for (int s = 0; status == STEIN_OK && s < j->data->n; s++) {
        status = audit_one(j->data->stroke[s], &found, &err);
    }
    print_findings(&found);
    return status == STEIN_OK ? CLI_OK : cli_failed(status, &err);
}

/* ---- files ---- */

static stein_status copy_to_stdout(const char *path, stein_err *err)
{
    char block[4096];
    size_t n;
    FILE *f = fopen(path, "rb");
    if (f == NULL) {
        return lab__fail(err, STEIN_EIO, "%s cannot be read: %s", path, strerror(errno));
    }
    while ((n = fread(block, 1, sizeof block, f)) > 0) {
        fwrite(block, 1, n, stdout);
    }
    fclose(f);
    return STEIN_OK;
}

/* Is there something to extend by? The file of an earlier run must not lie beside another verdict.
 */
static stein_status write_extended(const job *j, const char *path, stein_err *err)
{
    if (lab_diagnosis_extends(j->diagnosis)) {
        return lab_extend(path, j->args->operand[0], j->diagnosis, err);
    }
    return unlink(path) == 0 || errno == ENOENT
               ? STEIN_OK
               : lab__fail(err, STEIN_EIO, "%s cannot be removed: %s", path, strerror(errno));
}

enum { JSON, EXTENDED, PAGE, FILES };

static int write_files(const job *j, char *const path[FILES])
{
    stein_err err = {STEIN_OK, ""};
    const lab_diagnosis *d = j->diagnosis;
    stein_status status = lab_diagnosis_json(path[JSON], d, &err);
    status = status == STEIN_OK ? lab_diagnosis_page(path[PAGE], d, &err) : status;
    status = status == STEIN_OK ? write_extended(j, path[EXTENDED], &err) : status;
    if (status != STEIN_OK) {
        return cli_failed(status, &err);
    }
    if (cli_value(j->args, "json") != NULL) {
        return cli_failed(copy_to_stdout(path[JSON], &err), &err);
    }
    for (int i = 0; i < FILES; i++) {
        if (i != EXTENDED || lab_diagnosis_extends(d)) {
            printf("%s\n", path[i]);
        }
    }
    return CLI_OK;
}

static int write_results(const job *j)
{
    static const char *const name[FILES] = {"diagnosis.json", "extended.yaml", "report.html"};
    stein_err err = {STEIN_OK, ""};
    char *path[FILES];
    int named = 0;
    for (int i = 0; i < FILES; i++) {
        path[i] = lab__text("%s/%s", j->folder, name[i]);
        named += path[i] != NULL;
    }
    int code = named == FILES ? write_files(j, path) : cli_failed(lab__no_memory(&err), &err);
    for (int i = 0; i < FILES; i++) {
        free(path[i]);
    }
    return code;
}

/* ---- running ---- */

static int compute(job *j)
{
    stein_err err = {STEIN_OK, ""};
    lab_options options = lab_options_default();
    options.set = j->args->set;
    options.nset = j->args->nset;
    j->def.options = &options;
    j->def.progress = cli_progress_step;
    j->def.report = on_report;
    j->def.ctx = &j->progress;
    cli_progress_begin(&j->progress, "diagnosis");
    stein_status status =
        lab_diagnose(&j->diagnosis, j->args->operand[0], j->model, j->data, &j->def, &err);
    cli_progress_end(&j->progress);
    return status == STEIN_OK ? CLI_OK : cli_failed(status, &err);
}

/* Is the result no diagnosis? The reason is told once: the summary has it, and with --json there is
 * none. */
static int tell_failure(const job *j)
{
    const lab_diagnosis *d = j->diagnosis;
    int distrusted = d->verified.done && !d->verified.same;
    int unusable = d->verdict == LAB_VERDICT_UNUSABLE_MODEL;
    if (!distrusted && !unusable && d->verdict != LAB_VERDICT_NOT_CONVERGED) {
        return CLI_OK;
    }
    int json = cli_value(j->args, "json") != NULL;
    fprintf(stderr, "stein: %s%s%s\n", lab_verdict_text(d->verdict), json ? ": " : "",
            json ? d->reason : "");
    return unusable && !distrusted ? CLI_FAILED : CLI_NUMERICAL;
}

static int show(const job *j)
{
    if (cli_value(j->args, "json") == NULL) {
        cli_summary(lab_equations(j->model)->name, j->diagnosis);
        if (j->def.explain != NULL) {
            const char *text = j->diagnosis->explanation;
            printf("explain: %s\n", text != NULL ? text : "nothing was fitted");
        }
    }
    int code = write_results(j);
    return code == CLI_OK ? tell_failure(j) : code;
}

static int run_job(job *j)
{
    stein_err err = {STEIN_OK, ""};
    int code = cli_free_known(j->args, j->model, j->free, j->def.nfree);
    code = code == CLI_OK ? open_data(j) : code;
    code = code == CLI_OK ? audit_data(j) : code;
    code = code == CLI_OK ? cli_failed(lab__folder(j->folder, &err), &err) : code;
    code = code == CLI_OK ? compute(j) : code;
    return code == CLI_OK ? show(j) : code;
}

static int run(const cli_args *args)
{
    job j = {.args = args,
             .file = calloc(CLI_OPERANDS, sizeof *j.file),
             .held_out = calloc(CLI_OPERANDS, 1),
             .text = calloc((size_t)args->nheld + 1, sizeof *j.text)};
    stein_err err = {STEIN_OK, ""};
    int code = j.file != NULL && j.held_out != NULL && j.text != NULL
                   ? read_options(&j)
                   : cli_failed(lab__no_memory(&err), &err);
    if (code == CLI_OK) {
        stein_status status = cli_open(&j.model, args, &err);
        code = status == STEIN_OK ? run_job(&j) : cli_failed(status, &err);
    }
    lab_diagnosis_destroy(j.diagnosis);
    lab_dataset_close(j.data);
    lab_close(j.model);
    for (int i = 0; j.text != NULL && i < args->nheld; i++) {
        free(j.text[i]);
    }
    free(j.text);
    free(j.names);
    free(j.kinds);
    free(j.file);
    free(j.held_out);
    return code;
}

static const cli_option options[] = {
    {"output", 'o', "DIR", "The folder of the results; it is made when it is missing."},
    {"held-out", 0, "FILE,...",
     "Reporting records: no fit reads them. Repeatable. Without it some of the records (or\n"
     "blocks of one long record) are held out."},
    {"holdout", 0, "DATA...", "The same; all words up to the next option are files."},
    {"free", 0, "NAME,...",
     "Numbers of the file to refit besides those whose tolerance it states."},
    {"without", 0, "WORD,...",
     "Effects that are hidden from the search, as if the table lacked them: kinds, sites\n"
     "(joint, contact, channel ...), classes (sensor, input ...) or all. Their\n"
     "contribution is then a law to be recovered."},
    {"smooth", 0, "FREQUENCY",
     "Cut-off frequency of measured motions, at which half is kept, e.g. 12Hz. Without it\n"
     "the noise of the motion decides, or the measured force of the motion, if there is\n"
     "one."},
    {"budget", 0, "N|Ss", "The search ends after N simulations of records, or S seconds."},
    {"trace", 0, "FILE",
     "Every fit of the search, one JSON object a line: hypothesis, evidence, cost."},
    {"explain", 0, "KIND@PLACE", "Why this candidate is in the verdict or not, with its numbers."},
    {"trust-settings", 0, NULL,
     "Accept records whose motion contradicts their own \"# set\" lines."},
    {"jobs", 'j', "N", "Threads; default: one a processor. Results do not depend on it."},
    CLI_COMMON};

const cli_command cli_diagnose = {
    .name = "diagnose",
    .summary = "the physical effect that a simulation lacks, from measured records",
    .operands = "MODEL DATA...",
    .noperands = 2,
    .more = 1,
    .options = options,
    .description =
        "Compares a model with measured records and reports the place and time of\n"
        "differences, the physical effect that explains them, rival effects that explain them\n"
        "as well, and the errors of model and extended model on records that were not fitted.\n"
        "\n"
        "Candidates are the effects of `stein effects MODEL` at every place of the mechanism. "
        "Each\n"
        "is tested with all other unknowns refitted, and with friction and drive that vary from\n"
        "record to record. The best hypotheses are fitted in full; the evidence of the fitted\n"
        "records decides. Records held out are read last and only measure the gain.\n"
        "\n"
        "Agreement in position proves little about forces. If a channel measures the motion\n"
        "of the driven joint and an input can prescribe it, there is a second check. The\n"
        "measured motion is prescribed, and the required force is compared with the force\n"
        "that acted, with and without the causes. The check supports the verdict, contradicts\n"
        "it or cannot decide; it does not change the verdict.\n"
        "\n"
        "The data are audited first: an error in a file is reported with its line, and no verdict\n"
        "is given. The verdict is one of\n"
        "  explained        noise and variation from record to record are enough\n"
        "  wrong_parameter  a number of the file, or a setting of a record, is wrong\n"
        "  sensor           an instrument is wrong\n"
        "  input            the drive of the mechanism differs from what the record states\n"
        "  missing_effect   physics that the file lacks\n"
        "  unknown_effect   records and model differ, and no candidate explains it\n"
        "  not_converged    no fit converged: no statement about physics (exit status 3)\n"
        "  unusable_model   far from the records with every candidate (exit status 1)",
    .output =
        "At most 12 lines: verdict, reason, causes with their size, their rivals, the error on\n"
        "records held out, the check by forces, and the files.\n"
        "In DIR: diagnosis.json {\"verdict\", \"causes\": [{\"kind\", \"place\",\n"
        "\"phase\", \"parameters\", \"change\": old and new number of the file in words,\n"
        "\"changes\": [{\"name\", \"written_in\", \"from\", \"to\", \"lo\", \"hi\"}], "
        "\"evidence\"}],\n"
        "\"indistinguishable\", \"next_experiment\",\n"
        "\"law\": {\"place\", \"of\", \"at\", \"value\", \"lo\", \"hi\"} of an unknown effect,\n"
        "\"gain\": {\"rmse_before\", \"rmse_after\", \"ratio\", \"lo\", \"hi\", \"held_out\"},\n"
        "\"motion_check\": {\"says\": supports, contradicts, cannot_tell or not_done, \"why\",\n"
        "\"of_force\", \"of_channels\", \"all\", \"errors\": [...], \"stroke\"},\n"
        "\"changed_after\": the last record before a change, \"wrong_setting\" of one record,\n"
        "\"settings_off\", \"verified\": extended.yaml, read again, has the residual of its fit,\n"
        "\"noise_floor\", \"audit\", \"suspects\": [{\"kind\", \"place\", \"presence\",\n"
        "\"detectable\", \"upper_limit\"}]}, presence one of present, absent, weak, not_testable;\n"
        "report.html, one self-contained page; extended.yaml, the mechanism file with the cause "
        "in\n"
        "it (of an unknown effect its law as a table), when there is one that explains enough.\n"
        "With --json diagnosis.json is printed too.",
    .examples = "stein diagnose models/stein1788.yaml strokes/*.csv -o out\n"
                "stein diagnose models/stein1788.yaml fit_*.csv --holdout held_*.csv -o out\n"
                "stein strike out/extended.yaml --plot stroke.svg",
    .run = run,
};
