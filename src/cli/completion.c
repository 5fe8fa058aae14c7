/* SPDX-License-Identifier: GPL-3.0-or-later
 * completion.c - the completion of bash, written from the table of commands.
 *
 * What an option's value is follows from its placeholder: FILE.csv and DIR are paths, a|b are
 * words, NAME... names a parameter of the mechanism file on the line. The script needs bash alone.
 */
#include <string.h>

#include "cli.h"

static const char head[] =
    "# bash completion of stein. Written by `stein help --completion`.\n"
    "# names of the numbers that the mechanism file on the line states\n"
    "_stein_parameters() {\n"
    "    local word\n"
    "    for word in \"${COMP_WORDS[@]:2}\"; do\n"
    "        if [[ $word == *.yaml && -r $word ]]; then\n"
    "            \"${COMP_WORDS[0]}\" check \"$word\" 2>/dev/null |\n"
    "                sed -n '/^parameters/,/^$/s/^  \\([A-Za-z][^ ]*\\) .*/\\1/p'\n"
    "        fi\n"
    "    done\n"
    "}\n"
    "_stein() {\n"
    "    local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD - 1]} options values\n"
    "    COMPREPLY=()\n"
    "    # --name=value comes as three words\n"
    "    [[ $cur == = ]] && cur= || { [[ $prev == = ]] && prev=${COMP_WORDS[COMP_CWORD - 2]}; }\n";

static const char tail[] =
    "    case $values in\n"
    "    FILES) COMPREPLY=($(compgen -f -- \"$cur\")); compopt -o filenames 2>/dev/null; return "
    ";;\n"
    "    DIRS) COMPREPLY=($(compgen -d -- \"$cur\")); compopt -o filenames 2>/dev/null; return ;;\n"
    "    NAMES) COMPREPLY=($(compgen -W \"$(_stein_parameters)\" -- \"$cur\")); compopt -o "
    "nospace; "
    "return ;;\n"
    "    ANY) return ;;\n"
    "    ?*) COMPREPLY=($(compgen -W \"$values\" -- \"$cur\")); return ;;\n"
    "    esac\n"
    "    if [[ $cur == -* ]]; then\n"
    "        COMPREPLY=($(compgen -W \"$options\" -- \"$cur\"))\n"
    "    else\n"
    "        COMPREPLY=($(compgen -f -- \"$cur\"))\n"
    "        compopt -o filenames 2>/dev/null\n"
    "    fi\n"
    "}\n"
    "complete -F _stein stein\n";

/* what follows the option */
static void value_of(const cli_option *o)
{
    if (strncmp(o->value, "NAME", 4) == 0) {
        printf("NAMES");
    } else if (strstr(o->value, "FILE") != NULL || strstr(o->value, "DATA") != NULL) {
        printf("FILES");
    } else if (strstr(o->value, "DIR") != NULL) {
        printf("DIRS");
    } else if (strchr(o->value, '|') != NULL) {
        printf("'");
        for (const char *c = o->value; *c != '\0'; c++) {
            putchar(*c == '|' ? ' ' : *c);
        }
        printf("'");
    } else {
        printf("ANY");
    }
}

static void one(const cli_command *c)
{
    printf("    %s)\n        options='", c->name);
    for (const cli_option *o = c->options; o->name != NULL; o++) {
        printf("%s--%s", o == c->options ? "" : " ", o->name);
    }
    printf("'\n        case $prev in\n");
    for (const cli_option *o = c->options; o->name != NULL; o++) {
        if (o->value != NULL) {
            printf("        --%s", o->name);
            if (o->letter != 0) {
                printf(" | -%c", o->letter);
            }
            printf(") values=");
            value_of(o);
            printf(" ;;\n");
        }
    }
    printf("        esac\n        ;;\n");
}

void cli_completion(void)
{
    fputs(head, stdout);
    printf("    if ((COMP_CWORD == 1)) || [[ ${COMP_WORDS[1]} == help ]]; then\n"
           "        COMPREPLY=($(compgen -W \"");
    for (const cli_command *const *c = cli_commands; *c != NULL; c++) {
        printf("%s ", (*c)->name);
    }
    printf("help --help --version\" -- \"$cur\"))\n        return\n    fi\n"
           "    case ${COMP_WORDS[1]} in\n");
    for (const cli_command *const *c = cli_commands; *c != NULL; c++) {
        one(*c);
    }
    printf("    esac\n");
    fputs(tail, stdout);
}
