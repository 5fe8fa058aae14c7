/* SPDX-License-Identifier: GPL-3.0-or-later
 * help.c - the manual page of a command, from its table entry.
 */
#include <string.h>

#include "cli.h"

/* a text with every line indented */
static void indented(const char *text, int indent)
{
    while (*text != '\0') {
        size_t length = strcspn(text, "\n");
        if (length > 0) {
            printf("%*s%.*s", indent, "", (int)length, text);
        }
        putchar('\n');
        text += length + (text[length] == '\n');
    }
}

static void section(const char *title, const char *text)
{
    printf("\n%s\n", title);
    indented(text, 4);
}

const char *const cli_exit_status =
    "0  done\n"
    "1  the mechanism file or another file is not in order, or cannot be read or written\n"
    "2  the command line is not in order\n"
    "3  numerical failure: no equilibrium, a singular mass matrix, a state that is not\n"
    "   finite, chattering contacts";

void cli_help(const cli_command *command)
{
    printf("NAME\n    stein %s - %s\n\nSYNOPSIS\n    stein %s %s [options]\n", command->name,
           command->summary, command->name, command->operands);
    section("DESCRIPTION", command->description);
    printf("\nOPTIONS\n");
    for (const cli_option *o = command->options; o->name != NULL; o++) {
        char letter[] = {'-', o->letter, ',', ' ', '\0'};
        printf("    %s--%s%s%s\n", o->letter != 0 ? letter : "", o->name,
               o->value != NULL ? " " : "", o->value != NULL ? o->value : "");
        indented(o->help, 8);
    }
    section("OUTPUT", command->output);
    section("EXIT STATUS", cli_exit_status);
    section("EXAMPLES", command->examples);
}
