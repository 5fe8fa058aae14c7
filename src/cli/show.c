/* SPDX-License-Identifier: GPL-3.0-or-later
 * show.c - stein show: a mechanism as a drawing with names.
 */
#include <string.h>

#include "cli.h"
#include "draw.h"

static int run(const cli_args *args)
{
    const char *path = cli_value(args, "output");
    lab_model *model = NULL;
    stein_err err = {STEIN_OK, ""};
    path = path != NULL ? path : "-";
    if (lab__is_stdout(path) && cli_value(args, "json") != NULL) {
        return cli_misuse(args->command, "--json and the drawing both need the standard output: "
                                         "expected -o FILE.svg");
    }
    const char *slash = strrchr(path, '/'), *dot = strrchr(slash != NULL ? slash : path, '.');
    if (dot != NULL && strcmp(dot, ".svg") != 0) {
        return cli_misuse(args->command, "-o %s: the drawing is an SVG, expected FILE.svg", path);
    }
    stein_status status = cli_open(&model, args, &err);
    status = status == STEIN_OK ? lab__draw(path, model, &err) : status;
    if (status == STEIN_OK && cli_value(args, "json") != NULL) {
        lab__json j = {.stream = stdout};
        lab__json_open(&j, NULL, '{');
        lab__json_text(&j, "model", lab_equations(model)->name);
        lab__json_text(&j, "file", path);
        lab__json_close(&j);
    } else if (status == STEIN_OK && !lab__is_stdout(path)) {
        printf("%s\n", path);
    }
    lab_close(model);
    return status == STEIN_OK ? CLI_OK : cli_failed(status, &err);
}

static const cli_option options[] = {
    {"output", 'o', "FILE.svg", "The drawing; without it, or with -, on standard output."},
    CLI_COMMON};

const cli_command cli_show = {
    .name = "show",
    .summary = "draw a mechanism as SVG, with the names of its parts",
    .operands = "MODEL",
    .noperands = 1,
    .options = options,
    .description =
        "Draws MODEL to scale in its initial state, in its plane of motion (x-z if there are\n"
        "contacts), with the names of the parts. Bodies are lines from their joint to their\n"
        "points and children, revolute joints rings, sliding joints boxes, centres of mass\n"
        "dots, links springs, loops rods or rings, inputs arrows. Surfaces of contacts and\n"
        "notches are drawn too.",
    .output = "An SVG that any browser shows, light or dark. With -o its path is printed; with\n"
              "--json: {\"model\", \"file\"}.",
    .examples = "stein show models/stein1788.yaml -o action.svg\n"
                "stein show my.yaml --set rod.initial.position=90deg -o quarter.svg",
    .run = run,
};
