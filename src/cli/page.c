/* SPDX-License-Identifier: GPL-3.0-or-later
 * page.c - stein page: a mechanism as one HTML file to play with.
 */
#include "cli.h"

static const double kilobyte = 1000.0;

static void tell(const cli_args *args, const lab_model *model, const char *path,
                 const lab_page_facts *facts)
{
    if (cli_value(args, "json") == NULL) {
        printf("%s\n", path);
        fprintf(stderr, "%.0f KB, of which module %.0f KB; state after the file's own run: %s\n",
                (double)facts->page / kilobyte, (double)facts->module / kilobyte, facts->hash);
        return;
    }
    lab__json j = {.stream = stdout};
    lab__json_open(&j, NULL, '{');
    lab__json_text(&j, "model", lab_equations(model)->name);
    lab__json_text(&j, "file", path);
    lab__json_int(&j, "bytes", (int)facts->page);
    lab__json_int(&j, "module_bytes", (int)facts->module);
    lab__json_text(&j, "hash", facts->hash);
    lab__json_close(&j);
}

static int run(const cli_args *args)
{
    const char *path = cli_value(args, "output");
    lab_model *model = NULL;
    lab_page_facts facts;
    stein_err err = {STEIN_OK, ""};
    if (path == NULL) {
        return cli_misuse(args->command, "expected -o FILE.html, where the page is written");
    }
    if (lab__is_stdout(path) && cli_value(args, "json") != NULL) {
        return cli_misuse(args->command, "--json and -o - both need the standard output");
    }
    stein_status status = cli_open(&model, args, &err);
    if (status == STEIN_OK) {
        lab_options options = lab_options_default();
        options.report = cli_problem;
        options.ctx = (char *)args->operand[0];
        status = lab_page(path, model, &options, &facts, &err);
    }
    if (status == STEIN_OK && !lab__is_stdout(path)) {
        tell(args, model, path, &facts);
    }
    lab_close(model);
    return status == STEIN_OK ? CLI_OK : cli_failed(status, &err);
}

static const cli_option options[] = {
    {"output", 'o', "FILE.html", "The page; - is standard output."}, CLI_COMMON};

const cli_command cli_page = {
    .name = "page",
    .summary = "write a mechanism as a web page that simulates it",
    .operands = "MODEL",
    .noperands = 1,
    .options = options,
    .description =
        "Writes one self-contained HTML file that needs no network and no server: open it in\n"
        "a browser. It holds the library's core and the equations of MODEL, compiled to\n"
        "WebAssembly. It shows the mechanism drawn to scale, moving in slow motion or real\n"
        "time. Press the key with mouse, finger or space bar, or release the load; change the\n"
        "regulation while it runs. Beside the drawing are traces, a table of strokes and, for\n"
        "a piano action, a chart of escapement against the stop's place.\n"
        "\n"
        "The sliders are the numbers of the file's section `regulation`; without one, its own\n"
        "parameters and, if these are few, others. A slider moves its number gradually, so\n"
        "that no closed contact jumps.\n"
        "\n"
        "Needs a compiler for WebAssembly: apt-get install clang lld wasi-libc. It runs once\n"
        "for a mechanism and the cache keeps the module; changed numbers need no compiler.\n"
        "The variable WASM_CC names another clang, WASI_SYSROOT another place of wasi-libc\n"
        "than /usr.",
    .output =
        "FILE.html, written whole or not at all. Its path is printed; with --json:\n"
        "{\"model\", \"file\", \"bytes\", \"module_bytes\", \"hash\"}. hash is of the state\n"
        "at the end of the file's own run (FNV-1a): the page computes it again in the browser\n"
        "and shows both.",
    .examples = "stein page models/stein1788.yaml -o page.html\n"
                "stein page models/stein1788.yaml --set pawl.stop_shift=-0.5mm -o left.html",
    .run = run,
};
