/* SPDX-License-Identifier: GPL-3.0-or-later
 * version.c - `stein version`: which library this is, and whether it computes the same bits.
 */
#include <stdio.h>

#include "cli.h"
#include "stein/stein.h"

static void print_json(const lab_identity *identity)
{
    lab__json j = {.stream = stdout};
    char hash[LAB_NUMBER];
    lab__json_open(&j, NULL, '{');
    lab__json_text(&j, "version", stein_version());
    if (identity != NULL) {
        const struct {
            const char *name;
            unsigned long long hash;
        } part[] = {{"core", identity->core}, {"sweep", identity->sweep}, {"fit", identity->fit}};
        lab__json_open(&j, "hash", '{');
        for (int i = 0; i < 3; i++) {
            snprintf(hash, sizeof hash, "%016llx", part[i].hash);
            lab__json_text(&j, part[i].name, hash);
        }
        lab__json_close(&j);
    }
    lab__json_close(&j);
}

static int run(const cli_args *args)
{
    lab_identity identity;
    int hashed = cli_value(args, "hash") != NULL, json = cli_value(args, "json") != NULL;
    int threads, code = cli_threads(args, &threads);
    if (code != CLI_OK) {
        return code;
    }
    if (hashed) {
        stein_err err = {STEIN_OK, ""};
        stein_status status = lab_identify(&identity, threads, &err);
        if (status != STEIN_OK) {
            return cli_failed(status, &err);
        }
    }
    if (json) {
        print_json(hashed ? &identity : NULL);
        return CLI_OK;
    }
    printf("stein %s\n", stein_version());
    if (hashed) {
        printf("core  %016llx\nsweep %016llx\nfit   %016llx\n", identity.core, identity.sweep,
               identity.fit);
    }
    return CLI_OK;
}

static const cli_option options[] = {
    {"hash", 0, NULL,
     "Hashes of standard work: runs of every mechanism of the library, a sweep, a fit."},
    {"jobs", 'j', "N", "Threads; without it one a processor. The hashes do not depend on it."},
    {"json", 0, NULL, "Print one JSON object on standard output and nothing else there."},
    {"help", 'h', NULL, "Print this page."},
    {NULL, 0, NULL, NULL}};

const cli_command cli_version = {
    .name = "version",
    .summary = "which library this is, and whether it computes the same bits",
    .operands = "",
    .noperands = 0,
    .options = options,
    .description =
        "With --hash: one number each for the core, for a sweep and for a fit. Programs of one\n"
        "version that print the same numbers compute the same bits, whatever compiled them and\n"
        "wherever they run. stein_identity() returns the hash of the core. The fit goes\n"
        "through GSL, which is not ours: where it was compiled with fused multiplication, that\n"
        "number differs. Equations that are compiled later are compiled without.",
    .output = "The version, and the hashes in lines of their own; with --json {\"version\", "
              "\"hash\": {\"core\",\n\"sweep\", \"fit\"}}.",
    .examples = "stein version --hash",
    .run = run,
};
