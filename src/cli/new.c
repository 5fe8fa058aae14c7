/* SPDX-License-Identifier: GPL-3.0-or-later
 * new.c - stein new: a commented mechanism file to begin with, src/cli/starter.yaml under its name.
 */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli.h"
#include "embedded.h"

static const char ending[] = ".yaml";

/* placeholders in the starter */
enum { WORDS = 3 };
typedef struct words {
    const char *name, *file, *program;
} words;

/* "folder/swing.yaml" or "folder/swing" -> "swing"; NULL without memory */
static char *name_of(const char *operand)
{
    const char *slash = strrchr(operand, '/');
    char *name = lab__text("%s", slash != NULL ? slash + 1 : operand);
    size_t n = name != NULL ? strlen(name) : 0, most = sizeof ending - 1;
    if (n > most && strcmp(name + n - most, ending) == 0) {
        name[n - most] = '\0';
    }
    return name;
}

/* names of mechanisms are words of C */
static int is_name(const char *name)
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";
    static const char all[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_";
    return strspn(name, letters) > 0 && name[strspn(name, all)] == '\0' && strlen(name) < MECH_NAME;
}

/* can a shell take a word without quotes, and a comment of YAML? */
static int is_plain(const char *word)
{
    static const char plain[] =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./+-";
    return *word != '-' && word[strspn(word, plain)] == '\0';
}

static void put_line(FILE *to, const char *line, const words *w)
{
    const char *const placeholder[WORDS] = {"NAME", "FILE", "PROGRAM"};
    const char *const word[WORDS] = {w->name, w->file, w->program};
    while (*line != '\0') {
        int k = 0;
        while (k < WORDS && strncmp(line, placeholder[k], strlen(placeholder[k])) != 0) {
            k++;
        }
        if (k < WORDS) {
            fputs(word[k], to);
            line += strlen(placeholder[k]);
        } else {
            fputc(*line++, to);
        }
    }
}

static stein_status write_starter(const char *path, const words *w, stein_err *err)
{
    lab__file file;
    stein_status status = lab__file_open(&file, path, err);
    if (status != STEIN_OK) {
        return status;
    }
    for (const char *const *line = lab__starter_files[0].lines; *line != NULL; line++) {
        put_line(file.stream, *line, w);
    }
    return lab__file_close(&file, 1, err);
}

static void tell(const cli_args *args, const words *w, const char *path)
{
    if (cli_value(args, "json") == NULL) {
        const char *p = w->program, *f = w->file;
        printf("%s\n", path);
        fprintf(stderr, "next:\n  %s check %s.yaml\n  %s show %s.yaml -o %s.svg\n", p, f, p, f, f);
        fprintf(stderr, "  %s simulate %s.yaml --plot %s_motion.svg\n", p, f, f);
        return;
    }
    lab__json j = {.stream = stdout};
    lab__json_open(&j, NULL, '{');
    lab__json_text(&j, "model", w->name);
    lab__json_text(&j, "file", path);
    lab__json_close(&j);
}

/* stem: the path without its ending */
static int make(const cli_args *args, const char *name, const char *stem, const char *path)
{
    stein_err err = {STEIN_OK, ""};
    const words w = {name, is_plain(stem) ? stem : name,
                     is_plain(args->program) ? args->program : "stein"};
    if (!is_name(name)) {
        return cli_misuse(args->command,
                          "%s: expected a letter and then at most %d letters, digits or _", name,
                          MECH_NAME - 2);
    }
    if (access(path, F_OK) == 0) {
        return cli_failed(lab__fail(&err, STEIN_EIO, "%s exists already and is not changed", path),
                          &err);
    }
    stein_status status = write_starter(path, &w, &err);
    if (status != STEIN_OK) {
        return cli_failed(status, &err);
    }
    tell(args, &w, path);
    return CLI_OK;
}

static int run(const cli_args *args)
{
    stein_err err = {STEIN_OK, ""};
    const char *operand = args->operand[0], *slash = strrchr(operand, '/');
    char *name = name_of(operand);
    char *stem = name != NULL ? lab__text("%.*s%s", slash != NULL ? (int)(slash + 1 - operand) : 0,
                                          operand, name)
                              : NULL;
    char *path = stem != NULL ? lab__text("%s%s", stem, ending) : NULL;
    int code = path != NULL ? make(args, name, stem, path) : cli_failed(lab__no_memory(&err), &err);
    free(name);
    free(stem);
    free(path);
    return code;
}

static const cli_option options[] = {
    {"json", 0, NULL, "Print one JSON object on standard output and nothing else there."},
    {"help", 'h', NULL, "Print this page."},
    {NULL, 0, NULL, NULL}};

const cli_command cli_new = {
    .name = "new",
    .summary = "write a commented mechanism file to begin with",
    .operands = "NAME",
    .noperands = 1,
    .options = options,
    .description =
        "Writes NAME.yaml: a rod on a pin, with a comment at each line and further lines\n"
        "commented out. It can be checked, drawn, simulated and diagnosed without changes.\n"
        "NAME may include a folder. An existing file is an error.",
    .output = "NAME.yaml; its path is printed. With --json: {\"model\", \"file\"}.",
    .examples = "stein new swing\n"
                "stein simulate swing.yaml --plot swing.svg",
    .run = run,
};
