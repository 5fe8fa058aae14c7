/* SPDX-License-Identifier: GPL-3.0-or-later
 * results.c - the results of stein sweep and stein merge: table, picture, JSON, summary.
 *
 * The table goes to -o, or to standard output if that is not used otherwise; the summary
 * goes to standard error when the table is on standard output.
 */
#include <math.h>
#include <string.h>

#include "cli.h"

int cli_results_check(const cli_args *args)
{
    const char *table = cli_value(args, "output"), *picture = cli_value(args, "plot");
    stein_err err = {STEIN_OK, ""};
    if (table != NULL && lab__is_stdout(table) && cli_value(args, "json") != NULL) {
        return cli_misuse(args->command, "--json and -o %s both want standard output", table);
    }
    if (picture != NULL && lab__picture_name(picture, &err) != STEIN_OK) {
        return cli_misuse(args->command, "--plot %s", err.msg);
    }
    const char *const path[] = {table, picture};
    for (int i = 0; i < 2; i++) {
        lab__file probe; // reported before the work, not after it
        if (path[i] == NULL || lab__is_stdout(path[i])) {
            continue;
        }
        stein_status status = lab__file_open(&probe, path[i], &err);
        if (status != STEIN_OK) {
            return cli_failed(status, &err);
        }
        lab__file_close(&probe, 0, NULL);
    }
    return CLI_OK;
}

/* ---- JSON ---- */

/* name of a column without its unit, and whether its cells are numbers */
static int column_name(const lab_table *t, int column, char *name, size_t room)
{
    const char *line = t->head;
    while (*line == '#') {
        line += strcspn(line, "\n") + 1;
    }
    for (; column > 0; column--) {
        line += strcspn(line, ",") + 1;
    }
    size_t length = strcspn(line, ",\n");
    snprintf(name, room, "%.*s", (int)length, line);
    char *unit = strstr(name, " [");
    if (unit != NULL) {
        *unit = '\0';
    }
    return unit != NULL || strcmp(name, "point") == 0;
}

static void print_cell(lab__json *j, const lab_table *t, int point, int column)
{
    char name[2 * MECH_PATH], text[MECH_PATH];
    const char *cell;
    int number = column_name(t, column, name, sizeof name);
    size_t length = lab__table_cell(t, point, column, &cell);
    if (length == 0) {
        lab__json_null(j, name);
    } else if (number) {
        lab__json_real(j, name, lab__table_number(t, point, column));
    } else {
        snprintf(text, sizeof text, "%.*s", (int)length, cell);
        lab__json_text(j, name, text);
    }
}

static void print_axes(lab__json *j, const lab_table *t)
{
    lab__json_open(j, "vary", '[');
    for (int i = 0; i < t->grid->naxis; i++) {
        const lab__axis *a = &t->grid->axis[i];
        lab__json_open(j, NULL, '{');
        lab__json_text(j, "name", a->name);
        lab__json_text(j, "unit", a->unit);
        lab__json_open(j, "values", '[');
        for (int k = 0; k < a->n; k++) {
            lab__json_real(j, NULL, a->value[k]);
        }
        lab__json_close(j);
        lab__json_close(j);
    }
    lab__json_close(j);
}

static void print_json(const lab_table *t, const cli_counts *n)
{
    lab__json j = {.stream = stdout};
    const char *model = strstr(t->head, "# model: ");
    char name[MECH_PATH] = "";
    if (model != NULL) {
        snprintf(name, sizeof name, "%.*s", (int)strcspn(model + 9, "\n"), model + 9);
    }
    lab__json_open(&j, NULL, '{');
    lab__json_text(&j, "model", name);
    lab__json_int(&j, "points", t->n);
    lab__json_int(&j, "present", n->present);
    lab__json_int(&j, "failed", n->failed);
    print_axes(&j, t);
    lab__json_open(&j, "results", '[');
    for (int i = 0; i < t->n; i++) {
        if (lab_table_has(t, i)) {
            lab__json_open(&j, NULL, '{');
            for (int k = 0; k < t->ncolumn; k++) {
                print_cell(&j, t, i, k);
            }
            lab__json_close(&j);
        }
    }
    lab__json_close(&j);
    lab__json_close(&j);
}

/* ---- all of it ---- */

cli_counts cli_results_count(const lab_table *t)
{
    cli_counts n = {0, 0};
    for (int i = 0; i < t->n; i++) {
        n.present += lab_table_has(t, i);
        n.failed += lab_table_has(t, i) && !lab__table_ok(t, i);
    }
    return n;
}

static void print_summary(FILE *f, const cli_args *args, const lab_table *t, const cli_counts *n)
{
    const char *const path[] = {cli_value(args, "output"), cli_value(args, "plot")};
    fprintf(f, "%d of %d points", n->present, t->n);
    if (n->failed > 0) {
        fprintf(f, ", %d of them failed (column status)", n->failed);
    }
    fprintf(f, "\n");
    for (int i = 0; i < 2; i++) {
        if (path[i] != NULL && !lab__is_stdout(path[i])) {
            fprintf(f, "%s\n", path[i]);
        }
    }
}

int cli_results(const cli_args *args, const lab_table *t, int only_part)
{
    const char *table = cli_value(args, "output"), *picture = cli_value(args, "plot");
    int json = cli_value(args, "json") != NULL;
    stein_err err = {STEIN_OK, ""};
    stein_status status = STEIN_OK;
    cli_counts n = cli_results_count(t);
    table = table == NULL && !json && !only_part ? "-" : table;
    if (table != NULL) {
        status = lab_table_write(table, t, &err);
    }
    if (status == STEIN_OK && picture != NULL) {
        status = lab_table_plot(picture, t, &err);
    }
    if (status != STEIN_OK) {
        return cli_failed(status, &err);
    }
    if (json) {
        print_json(t, &n);
    } else {
        print_summary(table != NULL && lab__is_stdout(table) ? stderr : stdout, args, t, &n);
    }
    return n.present > 0 && n.failed == n.present ? CLI_NUMERICAL : CLI_OK;
}

void cli_damaged(int lines)
{
    if (lines > 0) {
        fprintf(stderr, "stein: %d damaged line%s of the journal count%s as not there\n", lines,
                lines == 1 ? "" : "s", lines == 1 ? "s" : "");
    }
}
