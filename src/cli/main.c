/* SPDX-License-Identifier: GPL-3.0-or-later
 * main.c - the program `stein`: finds the command and lets it run.
 */
#include <gsl/gsl_errno.h>
#include <signal.h>
#include <string.h>

#include "cli.h"
#include "stein/stein.h"

const cli_command *const cli_commands[] = {
    &cli_new,    &cli_check, &cli_show,   &cli_generate, &cli_strike, &cli_simulate, &cli_linearise,
    &cli_sweep,  &cli_merge, &cli_study,  &cli_effects,  &cli_fit,    &cli_diagnose, &cli_plan,
    &cli_import, &cli_page,  &cli_export, &cli_version,  NULL};
enum { COMMANDS = sizeof cli_commands / sizeof *cli_commands - 1 };

static void overview(FILE *stream)
{
    fprintf(stream, "usage: stein COMMAND MODEL [options]\n\ncommands:\n");
    for (int i = 0; i < COMMANDS; i++) {
        fprintf(stream, "  %-10s %s\n", cli_commands[i]->name, cli_commands[i]->summary);
    }
    fprintf(stream, "\nstein help COMMAND explains one; stein --version prints the version.\n"
                    "MODEL is a mechanism file, e.g. models/stein1788.yaml.\n");
}

static const cli_command *find(const char *name)
{
    const char *names[COMMANDS];
    for (int i = 0; i < COMMANDS; i++) {
        names[i] = cli_commands[i]->name;
        if (strcmp(names[i], name) == 0) {
            return cli_commands[i];
        }
    }
    const char *nearest = cli_nearest(name, names, COMMANDS);
    char text[LAB_PRINTABLE];
    fprintf(stderr, "stein: no command \"%s\"", lab__printable(text, name));
    if (nearest != NULL) {
        fprintf(stderr, "; did you mean %s?", nearest);
    }
    fprintf(stderr, "\n");
    overview(stderr);
    return NULL;
}

/* help [COMMAND], help --manual [COMMAND], help --completion [SHELL], help --commands */
static int help(int argc, char **argv)
{
    int manual = argc > 0 && strcmp(argv[0], "--manual") == 0;
    if (argc > 0 && strcmp(argv[0], "--completion") == 0) {
        return cli_completion(argc > 1 ? argv[1] : "bash");
    }
    if (argc > 0 && strcmp(argv[0], "--commands") == 0) {
        for (int i = 0; i < COMMANDS; i++) {
            printf("%s\n", cli_commands[i]->name);
        }
        return CLI_OK;
    }
    const char *name = argc > manual ? argv[manual] : NULL;
    const cli_command *command = name != NULL ? find(name) : NULL;
    if (name != NULL && command == NULL) {
        return CLI_USAGE;
    }
    if (command == NULL && manual) {
        cli_manual_overview();
    } else if (command == NULL) {
        overview(stdout);
    } else if (manual) {
        cli_manual(command);
    } else {
        cli_help(command);
    }
    return CLI_OK;
}

/* program: how it was called, "stein" or "build/stein" */
static int run(const char *program, int argc, char **argv)
{
    if (argc == 0) {
        overview(stderr);
        return CLI_USAGE;
    }
    const char *name = argv[0];
    if (strcmp(name, "--version") == 0) {
        printf("stein %s\n", stein_version());
        return CLI_OK;
    }
    if (strcmp(name, "help") == 0 || strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0) {
        return help(argc - 1, argv + 1);
    }
    const cli_command *command = find(name);
    cli_args args;
    if (command == NULL) {
        return CLI_USAGE;
    }
    int code = cli_parse(&args, command, argc - 1, argv + 1);
    args.program = program;
    if (code == CLI_OK && cli_value(&args, "help") != NULL) {
        cli_help(command);
        return CLI_OK;
    }
    return code == CLI_OK ? command->run(&args) : code;
}

int main(int argc, char **argv)
{
    signal(SIGPIPE,
           SIG_IGN); // a write that fails is reported, and nothing is left half done
    signal(SIGXFSZ, SIG_IGN);
    gsl_set_error_handler_off(); // a library must not abort the program; results are checked
    return cli_finish(run(argc > 0 ? argv[0] : "stein", argc - 1, argv + 1));
}
