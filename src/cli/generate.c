/* SPDX-License-Identifier: GPL-3.0-or-later
 * generate.c - stein generate: the equations of a mechanism as C.
 */
#include <stdlib.h>

#include "cli.h"

static stein_status write_source(const char *path, const gen_result *g, stein_err *err)
{
    lab__file file;
    stein_status status = lab__file_open(&file, path, err);
    if (status != STEIN_OK) {
        return status;
    }
    fwrite(g->source, 1, g->size, file.stream);
    return lab__file_close(&file, 1, err);
}

static stein_status generate(const cli_args *args, mechanism *m, const char *folder, stein_err *err)
{
    gen_result g;
    stein_status status = gen_equations(&g, m, err);
    if (status != STEIN_OK) {
        return status;
    }
    char *path = lab__text("%s/%s.c", folder, m->name);
    status = path == NULL ? lab__no_memory(err) : lab__folder(folder, err);
    if (status == STEIN_OK) {
        status = write_source(path, &g, err);
    }
    if (status == STEIN_OK && cli_value(args, "json") != NULL) {
        lab__json j = {.stream = stdout};
        lab__json_open(&j, NULL, '{');
        lab__json_text(&j, "model", m->name);
        lab__json_text(&j, "equations", g.equations);
        lab__json_text(&j, "file", path);
        lab__json_close(&j);
    } else if (status == STEIN_OK) {
        printf("%s\n", path);
    }
    free(path);
    gen_free(&g);
    return status;
}

static int run(const cli_args *args)
{
    const char *folder = cli_value(args, "output");
    mechanism *m = NULL;
    stein_err err = {STEIN_OK, ""};
    stein_status status = cli_mechanism(&m, args, &err);
    if (status == STEIN_OK) {
        status = generate(args, m, folder != NULL ? folder : ".", &err);
        mech_free(m);
    }
    return status == STEIN_OK ? CLI_OK : cli_failed(status, &err);
}

static const cli_option options[] = {
    {"output", 'o', "DIR", "Folder of the C file, made if need be; default: the current one."},
    CLI_COMMON};

const cli_command cli_generate = {
    .name = "generate",
    .summary = "write the equations of a mechanism as C",
    .operands = "MODEL",
    .noperands = 1,
    .options = options,
    .description =
        "Derives the equations of motion of the mechanism file MODEL by the recursive\n"
        "Newton-Euler scheme and writes them as one flat C file, as steingen does: M and c,\n"
        "inverse dynamics, poses, points with Jacobians, energies. The same file gives the same\n"
        "bytes on every run. Parameters stay symbolic; numbers that are zero in the file vanish.",
    .output =
        "DIR/NAME.c, where NAME is the mechanism's name. It includes stein/model.h and exports\n"
        "one symbol, stein_model_NAME. Its path is printed; with --json:\n"
        "{\"model\", \"equations\" (hash), \"file\"}.",
    .examples = "stein generate models/stein1788.yaml -o /tmp/equations\n"
                "cc -O2 -ffp-contract=off -fno-tree-slp-vectorize -fPIC -shared \\\n"
                "    /tmp/equations/stein1788.c -o stein1788.so",
    .run = run,
};
