/* SPDX-License-Identifier: GPL-3.0-or-later
 * export.c - stein export: a mechanism as an FMU, for the programs of others.
 */
#include <stdlib.h>
#include <string.h>

#include "cli.h"

static const double kilobyte = 1000.0;

static void tell(const cli_args *args, const lab_model *model, const char *path, int version,
                 const lab_fmu_facts *facts)
{
    if (cli_value(args, "json") == NULL) {
        printf("%s\n", path);
        fprintf(stderr, "FMI %d.0, %d variables, %.0f KB, of which binary %.0f KB (%s)\n", version,
                facts->variables, (double)facts->bytes / kilobyte, (double)facts->binary / kilobyte,
                facts->platform);
        return;
    }
    lab__json j = {.stream = stdout};
    lab__json_open(&j, NULL, '{');
    lab__json_text(&j, "model", lab_equations(model)->name);
    lab__json_text(&j, "file", path);
    lab__json_int(&j, "fmi", version);
    lab__json_int(&j, "bytes", (int)facts->bytes);
    lab__json_int(&j, "binary_bytes", (int)facts->binary);
    lab__json_text(&j, "platform", facts->platform);
    lab__json_int(&j, "variables", facts->variables);
    lab__json_text(&j, "token", facts->token);
    lab__json_close(&j);
}

/* @return 0 after a message */
static int version_of(const cli_args *args)
{
    const char *text = cli_value(args, "fmi");
    if (text == NULL) {
        return 3;
    }
    int two = strcmp(text, "2") == 0 || strcmp(text, "2.0") == 0;
    int three = strcmp(text, "3") == 0 || strcmp(text, "3.0") == 0;
    if (!two && !three) {
        cli_misuse(args->command, "--fmi %s: expected 3 or 2", text);
    }
    return two ? 2 : three ? 3 : 0;
}

static int run(const cli_args *args)
{
    const char *path = cli_value(args, "output");
    lab_model *model = NULL;
    lab_fmu_facts facts;
    stein_err err = {STEIN_OK, ""};
    int version = version_of(args);
    if (version == 0) {
        return CLI_USAGE;
    }
    if (path == NULL) {
        return cli_misuse(args->command, "expected -o FILE.fmu, where the FMU is written");
    }
    if (lab__is_stdout(path) && cli_value(args, "json") != NULL) {
        return cli_misuse(args->command, "--json and -o - both need the standard output");
    }
    char *memory = NULL;
    const char *cc[CLI_NAMES];
    int ncc = cli_value(args, "cc") != NULL ? cli_names(cli_value(args, "cc"), &memory, cc) : 0;
    if (ncc < 0) {
        free(memory);
        return cli_misuse(args->command, "--cc %s: expected compilers with commas between them",
                          cli_value(args, "cc"));
    }
    stein_status status = cli_open(&model, args, &err);
    if (status == STEIN_OK) {
        status = ncc > 0 ? lab_fmu_for(path, model, version, cc, ncc, NULL, &facts, &err)
                         : lab_fmu(path, model, version, NULL, &facts, &err);
    }
    if (status == STEIN_OK && !lab__is_stdout(path)) {
        tell(args, model, path, version, &facts);
    }
    lab_close(model);
    free(memory);
    return status == STEIN_OK ? CLI_OK : cli_failed(status, &err);
}

static const cli_option options[] = {
    {"fmi", 0, "3|2", "Version of the standard, FMI 3.0 or 2.0; default: 3."},
    {"output", 'o', "FILE.fmu", "The FMU; - is standard output."},
    {"cc", 0, "CC,CC...",
     "Compilers, one for each machine that gets a binary, e.g. cc,x86_64-w64-mingw32-gcc for "
     "Linux\n"
     "and Windows; default: $CC, or cc."},
    CLI_COMMON};

const cli_command cli_export = {
    .name = "export",
    .summary = "write a mechanism as an FMU, for other simulators",
    .operands = "MODEL",
    .noperands = 1,
    .options = options,
    .description =
        "Writes a Functional Mock-up Unit for co-simulation and model exchange: the library's "
        "core\n"
        "and the equations of MODEL as a shared object for the machine that cc compiles for, and "
        "as\n"
        "C sources with their build description. A co-simulation has the same bits as `stein\n"
        "simulate`. In model exchange the importer integrates, and contacts are events.\n"
        "\n"
        "  outputs      the output channels of the file\n"
        "  inputs       its forces; of a prescribed motion NAME.position, NAME.speed and\n"
        "               NAME.acceleration, which the joint follows when NAME.follow is true;\n"
        "               load.present, which lifts the free load and puts it back\n"
        "  parameters   the numbers of the file. Those of its section `regulation` may be changed\n"
        "               while it runs; without one, those of `parameters`; without that, all that\n"
        "               the file states. Also simulation.dt, the step of the integrator\n"
        "  locals       BODY.q, BODY.qd, BODY.qdd, coordinate, speed, acceleration of each joint;\n"
        "               NAME.guard1 and so on, positive where a contact touches\n"
        "\n"
        "All are in SI units, with a description. The state can be saved, restored and\n"
        "serialised; partial derivatives are provided. A step that fails numerically is\n"
        "discarded, and the FMU keeps its earlier state. Communication steps may have any\n"
        "length. The integrator keeps its own step; if that divides the communication step,\n"
        "the bits do not depend on the latter. Needs a C compiler.",
    .output =
        "FILE.fmu, written whole or not at all: the same bytes for the same mechanism and\n"
        "compiler. Its path is printed; with --json: {\"model\", \"file\", \"fmi\", \"bytes\",\n"
        "\"binary_bytes\", \"platform\", \"variables\", \"token\"}.",
    .examples =
        "stein export models/stein1788.yaml -o stein1788.fmu\n"
        "stein export models/stein1788.yaml --fmi 2 --set pawl.stop_shift=-0.5mm -o left.fmu",
    .run = run,
};
