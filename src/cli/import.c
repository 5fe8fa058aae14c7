/* SPDX-License-Identifier: GPL-3.0-or-later
 * import.c - stein import: a mechanism of another program as a mechanism file.
 */
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "stein/import.h"

/* what was left out, for --json */
typedef struct notes {
    char **text;
    int n;
    int quiet;
} notes;

static void on_note(void *ctx, const char *message)
{
    notes *t = ctx;
    char **more = realloc(t->text, ((size_t)t->n + 1) * sizeof *more);
    if (more != NULL) {
        t->text = more;
        t->text[t->n] = lab__text("%s", message);
        t->n += t->text[t->n] != NULL;
    }
    if (!t->quiet) {
        fprintf(stderr, "left out or changed: %s\n", message);
    }
}

static void print_json(const lab_imported *done, const char *to, const notes *t)
{
    lab__json out = {.stream = stdout};
    lab__json_open(&out, NULL, '{');
    lab__json_text(&out, "model", done->name);
    lab__json_text(&out, "file", to);
    lab__json_int(&out, "bodies", done->bodies);
    lab__json_int(&out, "joints", done->joints);
    lab__json_int(&out, "points", done->points);
    lab__json_open(&out, "left_out", '[');
    for (int i = 0; i < t->n; i++) {
        lab__json_text(&out, NULL, t->text[i]);
    }
    lab__json_close(&out);
    lab__json_close(&out);
}

static int run(const cli_args *args)
{
    const char *to = cli_value(args, "output");
    int json = cli_value(args, "json") != NULL;
    notes t = {.quiet = json};
    lab_imported done;
    stein_err err = {STEIN_OK, ""};
    to = to != NULL ? to : "-";
    if (json && lab__is_stdout(to)) {
        return cli_misuse(args->command, "--json and -o %s both want standard output", to);
    }
    stein_status status = lab_import_mbs(args->operand[0], to, on_note, &t, &done, &err);
    if (status == STEIN_OK && json) {
        print_json(&done, to, &t);
    } else if (status == STEIN_OK) {
        fprintf(lab__is_stdout(to) ? stderr : stdout, "%s: %d bodies, %d joints, %d points%s%s\n",
                done.name, done.bodies, done.joints, done.points, lab__is_stdout(to) ? "" : " in ",
                lab__is_stdout(to) ? "" : to);
    }
    for (int i = 0; i < t.n; i++) {
        free(t.text[i]);
    }
    free(t.text);
    return status == STEIN_OK ? CLI_OK : cli_failed(status, &err);
}

static const cli_option options[] = {
    {"output", 'o', "FILE.yaml",
     "The mechanism file; - is standard output, which is the default. A file appears whole or\n"
     "not at all."},
    {"json", 0, NULL, "Print one JSON object on standard output and nothing else there."},
    {"help", 'h', NULL, "Print this page."},
    {NULL, 0, NULL, NULL}};

const cli_command cli_import = {
    .name = "import",
    .summary = "a ROBOTRAN project as a mechanism file",
    .operands = "PROJECT.mbs",
    .noperands = 1,
    .options = options,
    .description =
        "Reads the project file of ROBOTRAN (XML, written by MBsysPad) and writes the same tree\n"
        "as a mechanism file: gravity, bodies with mass, centre, inertia and points, joints T1 to\n"
        "R3 with their initial values. A body with several joints becomes a chain of massless\n"
        "bodies, called like the joints, and itself. Driven and locked joints become inputs that\n"
        "hold their joint while nothing drives them, and every joint an output. M and c are those\n"
        "of the project, coordinate by coordinate, with the joints in the order of the file,\n"
        "parents first.\n"
        "\n"
        "What a mechanism file cannot carry is reported on standard error and listed at the head "
        "of\n"
        "the file: cuts, so that loops stay open and dependent joints are free; links, external\n"
        "forces and user models, whose laws are C code of the project; sensors; names that had\n"
        "to be changed. Drawings are passed over. What is added to the file afterwards - springs,\n"
        "contacts, friction - is described in docs/mechanism-files.md.\n"
        "\n"
        "Projects may hold numbers that no body has, such as a moment of inertia above the sum of\n"
        "the other two. The file is then written, the line is reported, and the exit status is 1.",
    .output = "The mechanism file. A line with the number of bodies, joints and points, or with\n"
              "--json: {\"model\", \"file\", \"bodies\", \"joints\", \"points\", \"left_out\": "
              "[...]}.",
    .examples = "stein import dataR/Suspension.mbs -o suspension.yaml\n"
                "stein check suspension.yaml",
    .run = run,
};
