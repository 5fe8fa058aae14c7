/* SPDX-License-Identifier: GPL-3.0-or-later
 * effects.c - stein effects: what a model may get wrong, and where.
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
        printf("    needs: %s - listed only, a diagnosis does not score it\n", e->needs);
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
    lab__json_bool(j, "scored", e->needs == NULL);
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

static void json_candidates(const stein_model *m, const lab_candidate *list, int n)
{
    lab__json j = {.stream = stdout};
    lab__json_open(&j, NULL, '{');
    lab__json_text(&j, "model", m->name);
    lab__json_open(&j, "candidates", '[');
    for (int i = 0; i < n; i++) {
        const lab_candidate *c = &list[i];
        lab__json_open(&j, NULL, '{');
        lab__json_text(&j, "kind", c->effect->kind);
        lab__json_text(&j, "class", c->effect->cls);
        lab__json_text(&j, "place", c->place);
        lab__json_text(&j, "size", c->effect->size);
        lab__json_text(&j, "unit", c->unit);
        lab__json_real(&j, "limit", c->limit);
        lab__json_open(&j, "parameters", '[');
        for (int k = 0; k < c->nparam; k++) {
            lab__json_text(&j, NULL, m->params[c->param[k]].name);
        }
        lab__json_close(&j);
        lab__json_text(&j, "side", c->side >= 0 ? m->params[c->side].name : NULL);
        lab__json_close(&j);
    }
    lab__json_close(&j);
    lab__json_close(&j);
}

static void print_candidates(const stein_model *m, const lab_candidate *list, int n)
{
    const char *kind = "";
    printf("%s: %d candidates\n", m->name, n);
    for (int i = 0; i < n; i++) {
        const lab_candidate *c = &list[i];
        char limit[CLI_TEXT];
        const char *name = m->params[c->param[0]].name;
        printf("%-20s %-18s %-28s up to %s%s\n",
               strcmp(kind, c->effect->kind) == 0 ? "" : c->effect->kind, c->place, name,
               c->effect->both_signs ? "+-" : "", cli_quantity(limit, c->limit, c->unit));
        kind = c->effect->kind;
    }
    int kinds;
    const lab_effect *e = lab_effects(&kinds);
    printf("not scored, each needs a part or a degree of freedom more:");
    for (int i = 0; i < kinds; i++) {
        printf("%s%s", e[i].needs != NULL ? " " : "", e[i].needs != NULL ? e[i].kind : "");
    }
    printf("\n");
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
    .summary = "kinds of effects a model may lack, and where they could sit",
    .operands = "[MODEL]",
    .noperands = 0,
    .more = 1,
    .options = options,
    .description =
        "Without MODEL: the table of all kinds of effects - class, equation, what it looks like,\n"
        "what is hard to tell from it. With MODEL: every place of that mechanism where one could\n"
        "sit, the parameter that switches it on, and how large it may plausibly be, by the\n"
        "mechanism's own weights, springs and motion. A neutral parameter does nothing; any of "
        "them\n"
        "can be tried with --set in every command. Kinds that need one more part or degree of\n"
        "freedom are listed and say so.",
    .output = "Text, or with --json {\"effects\": [{\"kind\", \"class\", \"site\", \"size\", "
              "\"parameter\",\n"
              "\"side\", \"equation\", \"looks_like\", \"hard_to_tell_from\", \"needs\", "
              "\"both_signs\",\n"
              "\"scored\"}]}, with MODEL {\"model\", \"candidates\": [{\"kind\", \"class\", "
              "\"place\", \"size\",\n"
              "\"unit\", \"limit\", \"parameters\", \"side\"}]}.",
    .examples = "stein effects\n"
                "stein effects models/stein1788.yaml\n"
                "stein strike models/stein1788.yaml --set hammer.drag=1e-6",
    .run = run,
};
