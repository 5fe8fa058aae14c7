/* SPDX-License-Identifier: GPL-3.0-or-later
 * plan_before.c - stein plan --before: which causes planned records could separate.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "stein/plan.h"

enum { RIVALS = 3, HELPS = 5, NAME = 46, SIZE = 22 };

typedef struct job {
    const cli_args *args;
    lab_model *model;
    lab_before *before;
    lab_before_def def;
    lab_options options;
    cli_progress progress;
    char *names, *noises, *path;
    const char *channel[CLI_NAMES], *noise[CLI_NAMES];
} job;

static int read_names(const job *j, const char *option, char **memory, const char **name, int *n)
{
    const char *text = cli_value(j->args, option);
    *n = text != NULL ? cli_names(text, memory, name) : 0;
    return *n >= 0 ? CLI_OK
                   : cli_misuse(j->args->command, "--%s %s: expected names separated by commas",
                                option, text);
}

static int read_options(job *j)
{
    j->def.records = cli_value(j->args, "records");
    if (cli_value(j->args, "channels") == NULL || j->def.records == NULL) {
        return cli_misuse(j->args->command, "--before needs --channels and --records");
    }
    int code = read_names(j, "channels", &j->names, j->channel, &j->def.nchannel);
    code = code == CLI_OK ? read_names(j, "noise", &j->noises, j->noise, &j->def.nnoise) : code;
    j->def.channel = j->channel;
    j->def.noise = j->noise;
    return code == CLI_OK ? cli_threads(j->args, &j->def.threads) : code;
}

/* ---- output ---- */

static void pad(const char *text, int width)
{
    printf("%s%*s", text, cli_width(text) < width ? width - cli_width(text) : 1, "");
}

/* to three digits */
static const char *rounded(char *text, double value, const char *unit)
{
    char digits[CLI_TEXT];
    snprintf(digits, sizeof digits, "%.3g", value);
    return cli_quantity(text, strtod(digits, NULL), unit);
}

static void print_cause(const lab_before *b, int i)
{
    const lab_candidate *c = &b->cause[i].candidate;
    char text[CLI_TEXT], name[2 * CLI_TEXT];
    snprintf(name, sizeof name, "%s at %s", c->effect->kind, c->place);
    pad(name, NAME);
    pad(isfinite(b->cause[i].nameable) ? rounded(text, b->cause[i].nameable, c->unit) : "-", SIZE);
    int n = 0;
    for (int k = 0; k < b->ncolumn; k++) {
        if (!b->cause[k].named || !lab_before_mistaken(b, i, k)) {
            continue;
        }
        if (n < RIVALS) {
            const lab_candidate *r = &b->cause[k].candidate;
            double below = b->apart[(size_t)i * (size_t)b->ncolumn + (size_t)k];
            printf("%s%s at %s", n > 0 ? ", " : "", r->effect->kind, r->place);
            if (below <= 1.0) {
                printf(" (below %s)", rounded(text, below * c->limit, c->unit));
            }
        }
        n++;
    }
    printf("%s", n == 0 ? "-" : "");
    if (n > RIVALS) {
        printf(" and %d more", n - RIVALS);
    }
    printf("\n");
}

/* candidates that cannot be named; a common reason is printed once */
static void print_others(const lab_before *b)
{
    char text[CLI_TEXT];
    printf("\nnot named within their limits:\n");
    for (int i = 0; i < b->ncolumn; i++) {
        const lab_candidate *c = &b->cause[i].candidate;
        if (!b->cause[i].named) {
            printf("  %s at %s, up to %s\n", c->effect->kind, c->place,
                   rounded(text, c->limit, c->unit));
        }
    }
    for (int i = b->ncolumn; i < b->n; i++) {
        int first = b->ncolumn, n = 0;
        while (strcmp(b->cause[first].why, b->cause[i].why) != 0) {
            first++;
        }
        for (int k = i; first == i && k < b->n; k++) {
            if (strcmp(b->cause[k].why, b->cause[i].why) == 0) {
                const lab_candidate *c = &b->cause[k].candidate;
                printf("%s%s at %s", n++ > 0 ? ", " : "  ", c->effect->kind, c->place);
            }
        }
        if (n > 0) {
            printf(": %s\n", b->cause[i].why);
        }
    }
}

static void print_helps(const lab_before *b)
{
    if (b->nhelp == 0) {
        printf("\nNone of %d things that could be measured or done besides would help.\n",
               b->ntried);
        return;
    }
    printf("\n");
    pad("would help, most for its cost first", NAME);
    printf("%5s %6s %6s %6s  %s\n", "cost", "named", "pairs", "finer", "most");
    for (int i = 0; i < b->nhelp && i < HELPS; i++) {
        const lab_before_help *h = &b->help[i];
        pad(h->name, NAME);
        printf("%5.0f %6d %6d %6.3g  %s (%.3g)\n", h->cost, h->named, h->told, h->finer, h->most,
               h->most_finer);
    }
    printf("\ncost: in records; named: causes that are named then and were not before; pairs: that "
           "are told\napart then; finer: ratio of the amounts that are named, before over then, "
           "mean and largest.\n");
}

static void print_text(const job *j)
{
    const lab_before *b = j->before;
    int named = 0;
    for (int i = 0; i < b->ncolumn; i++) {
        named += b->cause[i].named;
    }
    printf("%s, %d record%s: %d of %d causes can be named\n\n", lab_equations(j->model)->name,
           b->records, b->records == 1 ? "" : "s", named, b->n);
    pad("cause", NAME);
    pad("named from", SIZE);
    printf("cannot be told from\n");
    for (int i = 0; i < b->ncolumn; i++) {
        if (b->cause[i].named) {
            print_cause(b, i);
        }
    }
    print_others(b);
    print_helps(b);
    printf("%ld records simulated, %.3g s\n", b->strokes, b->seconds);
}

static int show(job *j)
{
    const char *folder = cli_value(j->args, "output");
    stein_err err = {STEIN_OK, ""};
    stein_status status = STEIN_OK;
    if (folder != NULL) {
        j->path = lab__text("%s/plan.json", folder);
        status = j->path != NULL ? lab__folder(folder, &err) : lab__no_memory(&err);
        status = status == STEIN_OK ? lab_before_json(j->path, j->before, &err) : status;
    }
    if (status == STEIN_OK && cli_value(j->args, "json") != NULL) {
        status = lab_before_json("-", j->before, &err);
    } else if (status == STEIN_OK) {
        print_text(j);
        if (j->path != NULL) {
            printf("%s\n", j->path);
        }
    }
    return cli_failed(status, &err);
}

/* ---- running ---- */

static int compute(job *j)
{
    stein_err err = {STEIN_OK, ""};
    j->options = lab_options_default();
    j->options.set = j->args->set;
    j->options.nset = j->args->nset;
    j->def.options = &j->options;
    j->def.progress = cli_progress_step;
    j->def.ctx = &j->progress;
    cli_progress_begin(&j->progress, "records");
    stein_status status = lab_before_make(&j->before, j->args->operand[0], j->model, &j->def, &err);
    cli_progress_end(&j->progress);
    return status == STEIN_OK ? show(j) : cli_failed(status, &err);
}

int cli_plan_before(const cli_args *args)
{
    job j = {.args = args};
    stein_err err = {STEIN_OK, ""};
    int code = read_options(&j);
    if (code == CLI_OK) {
        stein_status status = cli_open(&j.model, args, &err);
        code = status == STEIN_OK ? compute(&j) : cli_failed(status, &err);
    }
    free(j.names);
    free(j.noises);
    free(j.path);
    lab_before_destroy(j.before);
    lab_close(j.model);
    return code;
}
