/* SPDX-License-Identifier: GPL-3.0-or-later
 * completion.c - the completion of bash, zsh and fish, written from the table of commands.
 *
 * What an option's value is follows from its placeholder: FILE.csv and DIR are paths, a|b are
 * words, NAME... names a parameter of the mechanism file on the line. Each script needs its shell
 * alone, and sed.
 */
#include <ctype.h>
#include <string.h>

#include "cli.h"

/* the lines of `stein check` that name parameters */
#define NAMED "sed -n '/^parameters/,/^$/s/^  \\([A-Za-z][^ ]*\\) .*/\\1/p'"

typedef enum { ANY, FILES, DIRS, NAMES, WORDS } kind;

static int has_capital(const char *text)
{
    while (*text != '\0' && !isupper((unsigned char)*text)) {
        text++;
    }
    return *text != '\0';
}

static kind kind_of(const cli_option *o)
{
    const char *v = o->value;
    return strncmp(v, "NAME", 4) == 0                               ? NAMES
           : strstr(v, "FILE") != NULL || strstr(v, "DATA") != NULL ? FILES
           : strstr(v, "DIR") != NULL                               ? DIRS
           : strchr(v, '|') != NULL && !has_capital(v)              ? WORDS
                                                                    : ANY;
}

/* a|b as words with blanks between them */
static void put_words(const char *value)
{
    for (const char *c = value; *c != '\0'; c++) {
        putchar(*c == '|' ? ' ' : *c);
    }
}

/* the first sentence of a text, or its first line, for a shell: characters of `special` with a
 * backslash, and no single quotes */
static void put_brief(const char *text, const char *special)
{
    for (const char *c = text; *c != '\0' && *c != '\n' && *c != ';'; c++) {
        int ends = *c == '.' && (c[1] == ' ' || c[1] == '\n' || c[1] == '\0');
        if (ends || strncmp(c, ", e.g.", 6) == 0) {
            break;
        }
        printf("%s%c", strchr(special, *c) != NULL ? "\\" : "", *c == '\'' ? '`' : *c);
    }
}

/* ---- bash ---- */

static const char bash_head[] =
    "# bash completion of stein. Written by `stein help --completion bash`.\n"
    "# names of the numbers that the mechanism file on the line states\n"
    "_stein_parameters() {\n"
    "    local word\n"
    "    for word in \"${COMP_WORDS[@]:2}\"; do\n"
    "        if [[ $word == *.yaml && -r $word ]]; then\n"
    "            \"${COMP_WORDS[0]}\" check \"$word\" 2>/dev/null |\n"
    "                " NAMED "\n"
    "        fi\n"
    "    done\n"
    "}\n"
    "_stein() {\n"
    "    local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD - 1]} options values\n"
    "    COMPREPLY=()\n"
    "    # --name=value comes as three words\n"
    "    [[ $cur == = ]] && cur= || { [[ $prev == = ]] && prev=${COMP_WORDS[COMP_CWORD - 2]}; }\n";

static const char bash_tail[] =
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
static void bash_value(const cli_option *o)
{
    static const char *const known[] = {
        [ANY] = "ANY", [FILES] = "FILES", [DIRS] = "DIRS", [NAMES] = "NAMES", [WORDS] = ""};
    if (kind_of(o) == WORDS) {
        printf("'");
        put_words(o->value);
        printf("'");
    } else {
        printf("%s", known[kind_of(o)]);
    }
}

static void bash_command(const cli_command *c)
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
            bash_value(o);
            printf(" ;;\n");
        }
    }
    printf("        esac\n        ;;\n");
}

static void bash(void)
{
    fputs(bash_head, stdout);
    printf("    if ((COMP_CWORD == 1)) || [[ ${COMP_WORDS[1]} == help ]]; then\n"
           "        COMPREPLY=($(compgen -W \"");
    for (const cli_command *const *c = cli_commands; *c != NULL; c++) {
        printf("%s ", (*c)->name);
    }
    printf("help --help --version\" -- \"$cur\"))\n        return\n    fi\n"
           "    case ${COMP_WORDS[1]} in\n");
    for (const cli_command *const *c = cli_commands; *c != NULL; c++) {
        bash_command(*c);
    }
    printf("    esac\n");
    fputs(bash_tail, stdout);
}

/* ---- zsh ---- */

static const char zsh_head[] =
    "#compdef stein\n"
    "# zsh completion of stein. Written by `stein help --completion zsh`.\n"
    "# names of the numbers that the mechanism file on the line states\n"
    "_stein_parameters() {\n"
    "    local word\n"
    "    local -a names\n"
    "    for word in $words; do\n"
    "        if [[ $word == *.yaml && -r $word ]]; then\n"
    "            names+=(${(f)\"$($_stein_program check $word 2>/dev/null |\n"
    "                " NAMED ")\"})\n"
    "        fi\n"
    "    done\n"
    "    compadd -S '' -a names\n"
    "}\n"
    "_stein() {\n"
    "    local _stein_program=$words[1]\n"
    "    local -a commands=(\n";

static void zsh_option(const cli_option *o)
{
    static const char *const action[] = {[ANY] = " ",
                                         [FILES] = "_files",
                                         [DIRS] = "_files -/",
                                         [NAMES] = "_stein_parameters",
                                         [WORDS] = ""};
    for (int letter = o->letter != 0; letter >= 0; letter--) {
        printf(" \\\n            '*");
        if (letter) {
            printf("-%c", o->letter);
        } else {
            printf("--%s%s", o->name, o->value != NULL ? "=" : "");
        }
        printf("[");
        put_brief(o->help, "[]");
        printf("]");
        if (o->value != NULL) {
            printf(":value:");
            if (kind_of(o) == WORDS) {
                printf("(");
                put_words(o->value);
                printf(")");
            } else {
                printf("%s", action[kind_of(o)]);
            }
        }
        printf("'");
    }
}

static void zsh(void)
{
    fputs(zsh_head, stdout);
    for (const cli_command *const *c = cli_commands; *c != NULL; c++) {
        printf("        '%s:", (*c)->name);
        put_brief((*c)->summary, "");
        printf("'\n");
    }
    printf("        'help:the list of commands, or the page of one')\n"
           "    if ((CURRENT == 2)) || [[ $words[2] == help ]]; then\n"
           "        _describe command commands\n"
           "        return\n"
           "    fi\n"
           "    shift words\n"
           "    ((CURRENT--))\n"
           "    case $words[1] in\n");
    for (const cli_command *const *c = cli_commands; *c != NULL; c++) {
        printf("    %s)\n        _arguments", (*c)->name);
        for (const cli_option *o = (*c)->options; o->name != NULL; o++) {
            zsh_option(o);
        }
        printf(" \\\n            '*:file:_files'\n        ;;\n");
    }
    printf("    esac\n}\n_stein \"$@\"\n");
}

/* ---- fish ---- */

static const char fish_head[] =
    "# fish completion of stein. Written by `stein help --completion fish`.\n"
    "# names of the numbers that the mechanism file on the line states\n"
    "function __stein_parameters\n"
    "    set -l words (commandline -opc)\n"
    "    for word in $words\n"
    "        if string match -q '*.yaml' -- $word; and test -r $word\n"
    "            $words[1] check $word 2>/dev/null |\n"
    "                " NAMED "\n"
    "        end\n"
    "    end\n"
    "end\n"
    "complete -c stein -n __fish_use_subcommand -f\n"
    "complete -c stein -n __fish_use_subcommand -a help -d 'the list of commands, or the page of "
    "one'\n";

static void fish_option(const char *command, const cli_option *o)
{
    static const char *const action[] = {[ANY] = "-x",
                                         [FILES] = "-r -F",
                                         [DIRS] = "-x -a '(__fish_complete_directories)'",
                                         [NAMES] = "-x -a '(__stein_parameters)'",
                                         [WORDS] = ""};
    printf("complete -c stein -n '__fish_seen_subcommand_from %s' -l %s", command, o->name);
    if (o->letter != 0) {
        printf(" -s %c", o->letter);
    }
    if (o->value != NULL && kind_of(o) == WORDS) {
        printf(" -x -a '");
        put_words(o->value);
        printf("'");
    } else if (o->value != NULL) {
        printf(" %s", action[kind_of(o)]);
    }
    printf(" -d '");
    put_brief(o->help, "");
    printf("'\n");
}

static void fish(void)
{
    fputs(fish_head, stdout);
    printf("complete -c stein -n '__fish_seen_subcommand_from help' -f -a '");
    for (const cli_command *const *c = cli_commands; *c != NULL; c++) {
        printf("%s%s", c == cli_commands ? "" : " ", (*c)->name);
    }
    printf("'\n");
    for (const cli_command *const *c = cli_commands; *c != NULL; c++) {
        printf("complete -c stein -n __fish_use_subcommand -a %s -d '", (*c)->name);
        put_brief((*c)->summary, "");
        printf("'\n");
        for (const cli_option *o = (*c)->options; o->name != NULL; o++) {
            fish_option((*c)->name, o);
        }
    }
}

int cli_completion(const char *shell)
{
    static const struct {
        const char *name;
        void (*write)(void);
    } known[] = {{"bash", bash}, {"zsh", zsh}, {"fish", fish}};
    for (int i = 0; i < 3; i++) {
        if (strcmp(shell, known[i].name) == 0) {
            known[i].write();
            return CLI_OK;
        }
    }
    fprintf(stderr, "stein: help --completion: expected bash, zsh or fish\n");
    return CLI_USAGE;
}
