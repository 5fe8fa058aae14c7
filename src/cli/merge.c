/* SPDX-License-Identifier: GPL-3.0-or-later
 * merge.c - stein merge: the journals of a sweep become its table.
 */
#include <string.h>

#include "cli.h"

/* the points that are not there, "3 5-9 12 ..." */
static void print_missing(const lab_table *t)
{
    enum { RANGES = 12 };
    int ranges = 0;
    for (int i = 0; i < t->n; i++) {
        int first = i;
        if (lab_table_has(t, i)) {
            continue;
        }
        while (i + 1 < t->n && !lab_table_has(t, i + 1)) {
            i++;
        }
        if (ranges++ == RANGES) {
            fprintf(stderr, " ...");
            break;
        }
        fprintf(stderr, i > first ? " %d-%d" : " %d", first, i);
    }
}

static int run(const cli_args *args)
{
    stein_err err = {STEIN_OK, ""};
    lab_table *table = NULL;
    int damaged = 0, code = cli_results_check(args);
    if (code != CLI_OK) {
        return code;
    }
    stein_status status = lab_merge(&table, args->operand, args->noperand, &damaged, &err);
    if (status != STEIN_OK) {
        return cli_failed(status, &err);
    }
    cli_damaged(damaged);
    int missing = lab_table_points(table) - cli_results_count(table).present;
    if (missing > 0) {
        fprintf(stderr, "stein: %d of %d points are missing:", missing, lab_table_points(table));
        print_missing(table);
        fprintf(stderr, "%s\n",
                cli_value(args, "partial") != NULL
                    ? ""
                    : "; compute them, or use --partial for the present ones");
    }
    if (missing == 0 || cli_value(args, "partial") != NULL) {
        code = cli_results(args, table, 0);
    } else {
        code = CLI_FAILED;
    }
    lab_table_destroy(table);
    return code;
}

static const cli_option options[] = {
    {"output", 'o', "FILE.csv",
     "The table; - is standard output, which is the default. A file appears whole or not\n"
     "at all."},
    {"plot", 0, "FILE.svg", "Draw it, as in stein sweep."},
    {"partial", 0, NULL, "Accept missing points."},
    {"json", 0, NULL, "Print one JSON object on standard output and nothing else there."},
    {"help", 'h', NULL, "Print this page."},
    {NULL, 0, NULL, NULL}};

const cli_command cli_merge = {
    .name = "merge",
    .summary = "put the journals of a sweep together",
    .operands = "JOURNAL...",
    .noperands = 1,
    .more = 1,
    .options = options,
    .description =
        "Reads journals that stein sweep --journal wrote, of all shards of one sweep, in any\n"
        "order, and writes the table that one undivided stein sweep would have written, byte for\n"
        "byte. Journals of different sweeps are refused, and so are two different results for\n"
        "one point. Lines that were torn or damaged count as not there.",
    .output =
        "The table, or with --json the object, of stein sweep. When points are missing they are\n"
        "listed on standard error, nothing is written, and the exit status is 1.",
    .examples = "stein merge part*.journal -o dx.csv --plot dx.svg",
    .run = run,
};
