/* SPDX-License-Identifier: GPL-3.0-or-later
 * effects.c - stein effects: effects that a model may lack, and their places.
 */
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "stein/diagnose.h"

static void print_effect(const lab_effect *e)
{
    printf("%-20s %-15s at a %s\n    %s\n    looks like: %s\n", e->kind, e->cls,
           lab_site_text(e->site), e->equation, e->looks);
    if (*e->twins != '\0') {
        printf("    hard to tell from: %s\n", e->twins);
    }
    if (e->needs != NULL) {
        printf("    needs: %s - a part or a degree of freedom more, tried in a mechanism with it\n",
               e->needs);
    }
}

static void json_effect(lab__json *j, const lab_effect *e)
{
    lab__json_open(j, NULL, '{');
    lab__json_text(j, "kind", e->kind);
    lab__json_text(j, "class", e->cls);
    lab__json_text(j, "site", lab_site_text(e->site));
    lab__json_text(j, "size", e->size);
    lab__json_text(j, "parameter", e->parameter);
    lab__json_text(j, "side", e->side);
    lab__json_text(j, "equation", e->equation);
    lab__json_text(j, "looks_like", e->looks);
    lab__json_text(j, "hard_to_tell_from", e->twins);
    lab__json_text(j, "needs", e->needs);
    lab__json_bool(j, "both_signs", e->both_signs);
    lab__json_close(j);
}

static void print_table(int json)
{
    int n;
    const lab_effect *e = lab_effects(&n);
    lab__json j = {.stream = stdout};
    if (json) {
        lab__json_open(&j, NULL, '{');
        lab__json_open(&j, "effects", '[');
    }
    for (int i = 0; i < n; i++) {
        if (json) {
            json_effect(&j, &e[i]);
        } else {
            print_effect(&e[i]);
        }
    }
    if (json) {
        lab__json_close(&j);
        lab__json_close(&j);
    }
}

static void json_side(lab__json *j, const char *key, const lab_side *side)
{
    if (side->name == NULL) {
        lab__json_null(j, key);
        return;
    }
    lab__json_open(j, key, '{');
    lab__json_text(j, "name", side->name);
    lab__json_text(j, "unit", side->unit);
    lab__json_real(j, "lo", side->lo);
    lab__json_real(j, "value", side->value);
    lab__json_real(j, "hi", side->hi);
    lab__json_close(j);
}

static void json_candidate(lab__json *j, const stein_model *m, const lab_candidate *c)
{
    lab__json_open(j, NULL, '{');
    lab__json_text(j, "kind", c->effect->kind);
    lab__json_text(j, "class", c->effect->cls);
    lab__json_text(j, "place", c->place);
    lab__json_text(j, "size", c->effect->size);
    lab__json_text(j, "unit", c->unit);
    lab__json_real(j, "limit", c->limit);
    lab__json_open(j, "parameters", '[');
    for (int k = 0; k < c->nparam; k++) {
        lab__json_text(j, NULL, m->params[c->param[k]].name);
    }
    lab__json_close(j);
    json_side(j, "side", &c->side[0]);
    json_side(j, "other", &c->side[1]);
    lab__json_text(j, "also_called", c->alias);
    lab__json_close(j);
}

static void json_candidates(const stein_model *m, const lab_candidate *list, int n)
{
    lab__json j = {.stream = stdout};
    lab__json_open(&j, NULL, '{');
    lab__json_text(&j, "model", m->name);
    lab__json_open(&j, "candidates", '[');
    for (int i = 0; i < n; i++) {
        json_candidate(&j, m, &list[i]);
    }
    lab__json_close(&j);
    lab__json_close(&j);
}

/* "range 30 um .. 200 um" */
static void print_range(const lab_side *side)
{
    char low[CLI_TEXT], high[CLI_TEXT];
    const char *last = strrchr(side->name, '.');
    printf(", %s %s .. %s", last != NULL ? last + 1 : side->name,
           cli_quantity(low, side->lo, side->unit), cli_quantity(high, side->hi, side->unit));
}

static void print_candidate(const stein_model *m, const lab_candidate *c, const char *kind)
{
    char limit[CLI_TEXT], number[CLI_TEXT];
    int both = c->effect->both_signs && lab_candidate_is_signed(c);
    const char *name = c->nparam > 0 ? m->params[c->param[0]].name : "(a part more)";
    printf("%-20s %-18s %-28s up to %s%s",
           strcmp(kind, c->effect->kind) == 0 ? "" : c->effect->kind, c->place, name,
           both ? "+-" : "", cli_quantity(limit, c->limit, c->unit));
    if (!both && lab_candidate_is_signed(c)) {
        printf(", or less than the file's %s", cli_quantity(number, c->number, c->unit));
    }
    for (int k = 0; k < LAB_SIDES && c->side[k].name != NULL; k++) {
        print_range(&c->side[k]);
    }
    printf("%s%s\n", *c->alias != '\0' ? "; also called " : "", c->alias);
}

static void print_candidates(const stein_model *m, const lab_candidate *list, int n)
{
    const char *kind = "";
    int parts = 0;
    printf("%s: %d candidates\n", m->name, n);
    for (int i = 0; i < n; i++) {
        print_candidate(m, &list[i], kind);
        kind = list[i].effect->kind;
        parts += list[i].effect->needs != NULL;
    }
    printf("%s",
           parts > 0 ? "(a part more): simulated in the mechanism with that part in it\n" : "");
}

static int show_candidates(const cli_args *args)
{
    lab_model *model = NULL;
    lab_candidate *list = NULL;
    int n = 0;
    stein_err err = {STEIN_OK, ""};
    stein_status status = cli_open(&model, args, &err);
    status = status == STEIN_OK ? lab_candidates(&list, &n, model, &err) : status;
    if (status == STEIN_OK && cli_value(args, "json") != NULL) {
        json_candidates(lab_equations(model), list, n);
    } else if (status == STEIN_OK) {
        print_candidates(lab_equations(model), list, n);
    }
    free(list);
    lab_close(model);
    return status == STEIN_OK ? CLI_OK : cli_failed(status, &err);
}

static int run(const cli_args *args)
{
    if (args->noperand > 1) {
        return cli_misuse(args->command, "%s: one mechanism file at most", args->operand[1]);
    }
    if (args->noperand == 1) {
        return show_candidates(args);
    }
    print_table(cli_value(args, "json") != NULL);
    return CLI_OK;
}

static const cli_option options[] = {CLI_COMMON};

const cli_command cli_effects = {
    .name = "effects",
    .summary = "kinds of effects that a model may lack, and their possible places",
    .operands = "[MODEL]",
    .noperands = 0,
    .more = 1,
    .options = options,
    .description =
        "Without MODEL: the table of all kinds of effects, with class, equation, appearance,\n"
        "and kinds that are hard to separate from it. With MODEL: every possible place in\n"
        "that mechanism, the parameter that switches the effect on, and its largest plausible\n"
        "size, from the mechanism's own weights, springs and motion. A neutral parameter has\n"
        "no effect; --set changes it in every command. Kinds that need one more part or\n"
        "degree of freedom are marked: they are simulated in an extended mechanism. \"also\n"
        "called\" lists names with exactly the same effect.",
    .output = "Text, or with --json {\"effects\": [{\"kind\", \"class\", \"site\", \"size\", "
              "\"parameter\",\n"
              "\"side\", \"equation\", \"looks_like\", \"hard_to_tell_from\", \"needs\", "
              "\"both_signs\"}]},\n"
              "with MODEL {\"model\", \"candidates\": [{\"kind\", \"class\", \"place\", \"size\", "
              "\"unit\",\n"
              "\"limit\", \"parameters\", \"side\", \"other\" (name, unit, lo, value, hi), "
              "\"also_called\"}]}.",
    .examples = "stein effects\n"
                "stein effects models/stein1788.yaml\n"
                "stein strike models/stein1788.yaml --set hammer.drag=1e-6",
    .run = run,
};
