/* SPDX-License-Identifier: GPL-3.0-or-later
 * new.c - stein new: a commented mechanism file to begin with, src/cli/starter.yaml under its name.
 */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli.h"
#include "embedded.h"

static const char placeholder[] = "NAME", ending[] = ".yaml";

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

static void put_line(FILE *to, const char *line, const char *name)
{
    for (const char *at; (at = strstr(line, placeholder)) != NULL;) {
        fwrite(line, 1, (size_t)(at - line), to);
        fputs(name, to);
        line = at + strlen(placeholder);
    }
    fputs(line, to);
}

static stein_status write_starter(const char *path, const char *name, stein_err *err)
{
    lab__file file;
    stein_status status = lab__file_open(&file, path, err);
    if (status != STEIN_OK) {
        return status;
    }
    for (const char *const *line = lab__starter_files[0].lines; *line != NULL; line++) {
        put_line(file.stream, *line, name);
    }
    return lab__file_close(&file, 1, err);
}

static void tell(const cli_args *args, const char *name, const char *path)
{
    if (cli_value(args, "json") == NULL) {
        printf("%s\n", path);
        fprintf(stderr, "next: stein check %s, stein show %s -o %s.svg, stein simulate %s\n", path,
                path, name, path);
        return;
    }
    lab__json j = {.stream = stdout};
    lab__json_open(&j, NULL, '{');
    lab__json_text(&j, "model", name);
    lab__json_text(&j, "file", path);
    lab__json_close(&j);
}

static int make(const cli_args *args, const char *name, const char *path)
{
    stein_err err = {STEIN_OK, ""};
    if (!is_name(name)) {
        return cli_misuse(args->command,
                          "%s: expected a letter and then at most %d letters, digits or _", name,
                          MECH_NAME - 2);
    }
    if (access(path, F_OK) == 0) {
        return cli_failed(
            lab__fail(&err, STEIN_EIO, "%s is there already and stays as it is", path), &err);
    }
    stein_status status = write_starter(path, name, &err);
    if (status != STEIN_OK) {
        return cli_failed(status, &err);
    }
    tell(args, name, path);
    return CLI_OK;
}

static int run(const cli_args *args)
{
    stein_err err = {STEIN_OK, ""};
    const char *operand = args->operand[0], *slash = strrchr(operand, '/');
    char *name = name_of(operand);
    char *path = name != NULL
                     ? lab__text("%.*s%s%s", slash != NULL ? (int)(slash + 1 - operand) : 0,
                                 operand, name, ending)
                     : NULL;
    int code = path != NULL ? make(args, name, path) : cli_failed(lab__no_memory(&err), &err);
    free(name);
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
        "commented out. It can be checked, drawn, simulated and diagnosed as it is.\n"
        "NAME may have a folder before it. A file that is there already is an error.",
    .output = "NAME.yaml; its path is printed. With --json: {\"model\", \"file\"}.",
    .examples = "stein new swing\n"
                "stein simulate swing.yaml --plot swing.svg",
    .run = run,
};
