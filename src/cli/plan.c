/* SPDX-License-Identifier: GPL-3.0-or-later
 * plan.c - stein plan: the next experiment, when a diagnosis cannot separate causes.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "stein/plan.h"

enum { SHOWN = 12, NAME_LEAST = 24, NAME_MOST = 72 };

typedef struct job {
    const cli_args *args;
    lab_model *model;
    lab_diagnosis *diagnosis;
    lab_plan *plan;
    lab_plan_def def;
    cli_progress progress;
    char *names;
    const char *instrument[CLI_NAMES];
    const char *folder;
    char *path[LAB_PLAN_FILES]; /* written */
} job;

/* ---- the command line ---- */

static int read_options(job *j)
{
    const char *odds = cli_value(j->args, "odds");
    stein_err err = {STEIN_OK, ""};
    j->def = lab_plan_def_default();
    j->folder = cli_value(j->args, "output");
    if (odds != NULL) {
        double value = 0.0;
        if (mech_parse_quantity(odds, (mech_dim){.kg = 0}, &value, &err) != STEIN_OK ||
            !(value > 1.0 && value <= 1e6)) {
            return cli_misuse(j->args->command, "--odds %s: expected a number from 1 to 1e6", odds);
        }
        j->def.wanted = value;
    }
    const char *instruments = cli_value(j->args, "instruments");
    if (instruments != NULL) {
        int none = strcmp(instruments, "none") == 0;
        j->def.instrument = j->instrument;
        j->def.ninstrument = none ? 0 : cli_names(instruments, &j->names, j->instrument);
        if (j->def.ninstrument < 0) {
            return cli_misuse(j->args->command,
                              "--instruments %s: expected names of outputs separated by commas, or "
                              "none",
                              instruments);
        }
    }
    return cli_threads(j->args, &j->def.threads);
}

/* ---- output ---- */

static void print_name(const char *text, int width)
{
    printf("%s%*s", text, cli_width(text) < width ? width - cli_width(text) : 1, "");
}

/* the first column: as wide as the longest name */
static int name_width(const lab_plan *p, int shown)
{
    int width = NAME_LEAST;
    for (int i = 0; i < shown; i++) {
        int own = cli_width(p->experiment[i].name) + 2;
        width = own > width ? own : width;
    }
    return width < NAME_MOST ? width : NAME_MOST;
}

static void print_head(const lab_plan *p, int width)
{
    printf("The first row separates them best. Needed: records (or checks) for odds of %.4g to 1 "
           "in 9 of 10 cases. 2 ln odds: 9.2 is 100 to 1, 0 tells nothing.\n\n",
           p->wanted);
    print_name("", width);
    printf("%9s  %21s\n", "needed", "2 ln odds of one [1]");
    print_name("experiment", width);
    printf("%9s  %7s %13s  %s\n", "[records]", "mean", "9 of 10 above", "how");
}

static void print_experiment(const lab_experiment *e, const lab_plan *plan, int width)
{
    char repeats[CLI_TEXT];
    if (e->repeats > 0) {
        snprintf(repeats, sizeof repeats, "%d", e->repeats);
    } else {
        snprintf(repeats, sizeof repeats, "> %d", plan->most);
    }
    print_name(e->name, width);
    if (e->feasible) {
        printf("%9s  %7.3g %13.3g  %s\n", repeats, e->odds, e->odds_worst, e->why);
    } else {
        printf("%9s  %7s %13s  %s\n", "-", "-", "-", e->why);
    }
}

/* "coulomb_friction at rod and mass at bob": all causes of a hypothesis */
static void print_hypothesis(const lab_suspect *s)
{
    printf("%s at %s", s->candidate.effect->kind, s->candidate.place);
    for (int i = 0; i < s->posterior.nbeside; i++) {
        const lab_candidate *c = &s->posterior.beside[i];
        printf(" and %s at %s", c->effect->kind, c->place);
    }
}

static void print_nothing(const job *j)
{
    const lab_diagnosis *d = j->diagnosis;
    printf("%s: ", lab_equations(j->model)->name);
    if (d->ncause < 1) {
        printf("the diagnosis (%s) names no cause", lab_verdict_text(d->verdict));
    }
    for (int i = 0; i < d->ncause; i++) {
        const lab_candidate *c = &d->suspect[i].candidate;
        printf("%s%s at %s", i > 0 ? " and " : "", c->effect->kind, c->place);
    }
    printf("%s: there is nothing to separate\n", d->ncause > 0 ? ", and no rival" : "");
}

static void print_plan(const job *j)
{
    const lab_plan *p = j->plan;
    const lab_diagnosis *d = j->diagnosis;
    int shown = p->n < SHOWN ? p->n : SHOWN;
    if (p->nrival == 0) {
        print_nothing(j);
        return;
    }
    printf("%s: ", lab_equations(j->model)->name);
    print_hypothesis(&d->suspect[0]);
    printf(", or");
    for (int i = d->ncause, n = 0; n < p->nrival && i < d->nsuspect; i++) {
        if (d->suspect[i].posterior.n > 0) {
            printf(n++ > 0 ? ", or " : " ");
            print_hypothesis(&d->suspect[i]);
        }
    }
    printf("?\n");
    if (p->left_out > 0) {
        printf("%d rivals more are left out, they are less likely\n", p->left_out);
    }
    printf("\n");
    int width = name_width(p, shown);
    print_head(p, width);
    for (int i = 0; i < shown; i++) {
        print_experiment(&p->experiment[i], p, width);
    }
    if (p->n > shown) {
        printf("%d more separate less\n", p->n - shown);
    }
    printf("\n");
    printf("%d records simulated, %.3g s\n", p->strokes, p->seconds);
}

static int show(job *j)
{
    stein_err err = {STEIN_OK, ""};
    int json = cli_value(j->args, "json") != NULL;
    stein_status status = STEIN_OK;
    if (j->folder != NULL) {
        status = lab_plan_files(j->folder, j->plan, j->args->operand[0], j->model, j->diagnosis,
                                &j->def, j->path, &err);
    }
    if (status == STEIN_OK && json) {
        char **stroke = j->path[LAB_PLAN_STROKE] != NULL ? &j->path[LAB_PLAN_STROKE] : NULL;
        status = lab_plan_json("-", j->plan, j->diagnosis, stroke, &err);
    } else if (status == STEIN_OK) {
        print_plan(j);
        for (int i = 0; i < LAB_PLAN_FILES; i++) {
            if (j->path[i] != NULL) {
                printf("%s\n", j->path[i]);
            }
        }
    }
    return cli_failed(status, &err);
}

/* ---- running ---- */

static int compute(job *j)
{
    stein_err err = {STEIN_OK, ""};
    lab_options options = lab_options_default();
    const char *const *file = j->args->operand;
    options.set = j->args->set;
    options.nset = j->args->nset;
    j->def.options = &options;
    j->def.progress = cli_progress_step;
    j->def.ctx = &j->progress;
    stein_status status = lab_diagnosis_read(&j->diagnosis, file[1], j->model, &err);
    if (status == STEIN_OK) {
        cli_progress_begin(&j->progress, "experiments");
        status = lab_plan_make(&j->plan, file[0], j->model, j->diagnosis, &j->def, &err);
        cli_progress_end(&j->progress);
    }
    return status == STEIN_OK ? show(j) : cli_failed(status, &err);
}

static int run(const cli_args *args)
{
    job j = {.args = args};
    stein_err err = {STEIN_OK, ""};
    int before = cli_value(args, "before") != NULL;
    if (args->noperand != (before ? 1 : 2)) {
        return cli_misuse(args->command, "expected %s",
                          before ? "MODEL alone: there is no diagnosis before the records"
                                 : "MODEL DIAGNOSIS.json, or --before MODEL");
    }
    if (before) {
        return cli_plan_before(args);
    }
    int code = read_options(&j);
    if (code == CLI_OK) {
        stein_status status = cli_open(&j.model, args, &err);
        code = status == STEIN_OK ? compute(&j) : cli_failed(status, &err);
    }
    for (int i = 0; i < LAB_PLAN_FILES; i++) {
        free(j.path[i]);
    }
    free(j.names);
    lab_plan_destroy(j.plan);
    lab_diagnosis_destroy(j.diagnosis);
    lab_close(j.model);
    return code;
}

static const cli_option options[] = {
    {"output", 'o', "DIR", "Write plan.json and the best experiment's records into this folder."},
    {"instruments", 0, "NAMES",
     "Channels that can be measured, too, separated by commas, or none; default: every place, "
     "angle and force on the ground."},
    {"odds", 0, "N", "Odds wanted between the cause and its rivals; default 100."},
    {"before", 0, NULL,
     "Before anything is measured: the detectability of effects in records like --records"},
    {"channels", 0, "NAMES", "Outputs that will be measured, separated by commas (--before)."},
    {"records", 0, "TEXT",
     "Planned records (--before), \"[N x] TIME at RATE [with NAME=VALUE[unit], ...]\",\n"
     "several separated by semicolons."},
    {"noise", 0, "NAME=VALUE,...",
     "Noise of one sample (--before); default: 1 mrad of an angle, 0.1 mm of a place, 1 % of\n"
     "the largest reading of anything else."},
    {"jobs", 'j', "N", "Threads; default: one a processor. Results do not depend on it."},
    CLI_COMMON};

const cli_command cli_plan = {
    .name = "plan",
    .summary = "the next experiment, when a diagnosis cannot separate causes",
    .operands = "MODEL DIAGNOSIS.json",
    .noperands = 1,
    .more = 1,
    .options = options,
    .description =
        "A diagnosis may end with a cause and rivals that the records cannot separate\n"
        "(\"indistinguishable\" of its diagnosis.json). This command looks for an experiment\n"
        "that separates them. Every possible experiment is simulated with the cause and with\n"
        "each rival, with their fitted numbers: other settings, load or start, a prescribed\n"
        "motion (also half of it and back), a force, the string removed, a mass added,\n"
        "another channel, a faster camera, a supposed wire or damper taken off (# set\n"
        "key_wire.k: 0); where one change is not enough, up to three at once. Differences\n"
        "that uncertain numbers, trigger, offsets or scatter of the records can explain do\n"
        "not count. Checks without a record are listed as well: an instrument beside a plumb\n"
        "line, a scale, a light or a clock, a length with calipers, a body on a balance or a\n"
        "knife edge, a felt in a press. Their result is stated in the files of all records (#\n"
        "known NAME: VALUE) and is known from then on.\n"
        "\n"
        "The best experiment needs few records against the rival that is hardest to separate.\n"
        "It stays near the present records, where the model has been compared (\"beyond\": 1\n"
        "within them, 2 twice the force). It also separates the rivals from each other\n"
        "(\"all_pairs\").\n"
        "\n"
        "MODEL is the mechanism file that was diagnosed, with the same --set.\n"
        "\n"
        "stein plan --before MODEL --channels NAMES --records TEXT needs no diagnosis. The\n"
        "planned records are simulated with the numbers of the file. For each effect and\n"
        "place the table lists the least size that would be named with 95 % probability, and\n"
        "the other effects that would explain the records as well, up to a size. The same\n"
        "follows with each possible addition (channel, setting, start, load, motion) and its\n"
        "cost: one more record counts 1, another set-up 4.",
    .output =
        "A table: the experiment, the number of records for the odds wanted, 2 ln of the odds\n"
        "expected from one record, the value that 9 of 10 records exceed, and what to do. In\n"
        "DIR: plan.json {\"cause\", \"rivals\", \"odds_wanted\", \"experiments\": "
        "[{\"experiment\",\n"
        "\"why\", \"feasible\", \"odds\", \"odds_worst\", \"repeats\", \"all_pairs\", "
        "\"against\",\n"
        "\"check\": [{\"instrument\", \"beside\", \"numbers\", \"file\", \"noise\",\n"
        "\"reach\"}], \"set\",\n"
        "\"drive\", \"channel\", \"frames_for_one\", \"beyond\"}], \"stroke\", "
        "\"stroke_of_rival\"};\n"
        "next_stroke.csv, the best record as the cause predicts it, and next_rival.csv, as the\n"
        "rival does: data files with the settings (# set) and the driven input, for\n"
        "`stein simulate --drive` and for the diagnosis. With --json plan.json is printed.\n"
        "With --before plan.json is {\"records\", \"causes\": [{\"kind\", \"place\", \"unit\", "
        "\"limit\",\n"
        "\"nameable\", \"named\", \"why\", \"not_told_from\"}], \"help\": [{\"experiment\", "
        "\"why\", \"cost\",\n"
        "\"causes_named\", \"pairs_told\", \"finer\", \"most\", \"most_finer\"}], "
        "\"tried\"}.",
    .examples = "stein plan --before models/pendulum.yaml --channels angle \\\n"
                "  --records \"3 x 10 s at 100 Hz\"\n"
                "stein diagnose models/stein1788.yaml strokes/*.csv -o out\n"
                "stein plan models/stein1788.yaml out/diagnosis.json -o next\n"
                "stein plan models/stein1788.yaml out/diagnosis.json --odds 20 --json\n"
                "stein plan models/stein1788.yaml out/diagnosis.json --instruments hammer_angle",
    .run = run,
};
