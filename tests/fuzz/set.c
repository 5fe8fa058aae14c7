/* SPDX-License-Identifier: GPL-3.0-or-later
 * set.c - any words on the command line, and --set and --vary of them for a mechanism.
 */
#include "cli.h"
#include "fuzz.h"
#include "stein/models.h"

enum { WORDS = 12, WORD = 300 };

static const char text[] =
    "mechanism: m\nparameters:\n  cut: 3 mm\n  turn: 0.1 rad\n"
    "bodies:\n  a: {joint: R -y, mass: 213 g +- 1 g, centre: [0, 0, -174 mm], inertia: {yy: "
    "2e-3},\n"
    "    damping: 1e-4, initial: {position: 30 deg}, points: {tip: [0, 0, -350 mm]}}\n"
    "  b: {joint: T x, parent: a, mass: 2 * parameters.cut / (1 m) * 1 kg}\n"
    "outputs: {angle: {joint: a, read: position}}\nsimulation: {dt: 1 ms, until: 10 ms}\n";

static void set_all(const cli_args *args)
{
    static char name[WORDS][WORD];
    mech_set set[WORDS];
    mechanism *m = NULL;
    stein_err err = {STEIN_OK, ""};
    int n = 0;
    for (; n < args->nset && n < WORDS; n++) {
        snprintf(name[n], WORD, "%s", args->set[n]);
        char *sign = strchr(name[n], '=');
        must(sign != NULL, "a setting has a sign of equality");
        *sign = '\0';
        set[n] = (mech_set){name[n], sign + 1};
    }
    if (mech_read_text(&m, "m.yaml", text, sizeof text - 1, set, n, NULL, NULL, &err) == STEIN_OK) {
        mech_free(m);
    } else {
        must(err.msg[0] != '\0', "a refusal says why");
    }
}

/* a million points are allowed, and their texts take a second: no use here */
static int is_large(const cli_args *args)
{
    for (int i = 0; i < args->nvary; i++) {
        const char *count = strrchr(args->vary[i], ':');
        if (count != NULL && strtol(count + 1, NULL, 10) > 200) {
            return 1;
        }
    }
    return 0;
}

static void vary_all(const cli_args *args)
{
    lab_grid *grid = NULL;
    stein_err err = {STEIN_OK, ""};
    if (args->nvary > 0 && !is_large(args) &&
        lab_grid_create(&grid, &stein_model_pendulum, args->vary, args->nvary, &err) == STEIN_OK) {
        must(lab_grid_points(grid) > 0 && lab_grid_points(grid) <= LAB_POINTS,
             "points are counted");
        lab_grid_destroy(grid);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const cli_command *const commands[] = {
        &cli_strike, &cli_sweep, &cli_fit, &cli_diagnose, &cli_check, &cli_plan, &cli_version};
    static char word[WORDS][WORD];
    static cli_args args;
    char *argv[WORDS];
    int argc = 0, number = 1;
    double seconds = 0.0;
    if (size == 0) {
        return 0;
    }
    const cli_command *command = commands[data[0] % (sizeof commands / sizeof *commands)];
    data++;
    size--;
    while (argc < WORDS && fuzz_line(&data, &size, word[argc], WORD)) {
        argv[argc] = word[argc];
        argc++;
    }
    if (cli_parse(&args, command, argc, argv) == CLI_OK) {
        (void)cli_time(&args, "until", &seconds);
        (void)cli_count(&args, "jobs", 64, &number);
        if (args.nset > 0) { // else it is the same file again and again
            set_all(&args);
        }
        vary_all(&args);
    }
    return 0;
}
