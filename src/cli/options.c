/* SPDX-License-Identifier: GPL-3.0-or-later
 * options.c - the command line: --name VALUE, --name=VALUE, -n VALUE, -nVALUE, and -- to end
 * options.
 *
 * Own code instead of getopt_long: that is not POSIX, accepts abbreviations silently (--se), and
 * cannot suggest an option.
 */
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli.h"

enum { LONGEST = 32 };

/* letters to insert, delete, replace or swap with the next (Damerau-Levenshtein, restricted) */
static int distance(const char *a, const char *b)
{
    int row[3][LONGEST + 1], m = (int)strlen(a), n = (int)strlen(b);
    if (m > LONGEST || n > LONGEST) {
        return LONGEST;
    }
    for (int j = 0; j <= n; j++) {
        row[0][j] = j;
    }
    for (int i = 1; i <= m; i++) {
        int *now = row[i % 3], *before = row[(i - 1) % 3], *older = row[(i + 1) % 3];
        now[0] = i;
        for (int j = 1; j <= n; j++) {
            int best = before[j - 1] + (a[i - 1] != b[j - 1]);
            best = before[j] + 1 < best ? before[j] + 1 : best;
            best = now[j - 1] + 1 < best ? now[j - 1] + 1 : best;
            int swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
            now[j] = swapped && older[j - 2] + 1 < best ? older[j - 2] + 1 : best;
        }
    }
    return row[m % 3][n];
}

const char *cli_nearest(const char *name, const char *const *names, int n)
{
    int limit = 1 + (int)strlen(name) / 3, best = limit + 1;
    const char *nearest = NULL;
    for (int i = 0; i < n; i++) {
        int d = distance(name, names[i]);
        if (d < best) {
            best = d;
            nearest = names[i];
        }
    }
    return nearest;
}

int cli_misuse(const cli_command *command, const char *format, ...)
{
    va_list list;
    char text[1000];
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    fprintf(stderr, "stein %s: %s", command->name, lab__one_line(text));
    fprintf(stderr, "\nusage: stein %s %s [options]   (stein %s --help)\n", command->name,
            command->operands, command->name);
    return CLI_USAGE;
}

static int find_long(const cli_command *command, const char *name, size_t length)
{
    for (int i = 0; command->options[i].name != NULL; i++) {
        if (strlen(command->options[i].name) == length &&
            strncmp(command->options[i].name, name, length) == 0) {
            return i;
        }
    }
    return -1;
}

static int find_letter(const cli_command *command, char letter)
{
    for (int i = 0; command->options[i].name != NULL; i++) {
        if (command->options[i].letter == letter) {
            return i;
        }
    }
    return -1;
}

static int unknown(const cli_command *command, const char *word)
{
    const char *names[CLI_OPTIONS];
    char name[LONGEST + 1];
    int n = 0;
    while (command->options[n].name != NULL) {
        names[n] = command->options[n].name;
        n++;
    }
    const char *start = word + strspn(word, "-");
    size_t length = strcspn(start, "=");
    length = length > LONGEST ? LONGEST : length;
    memcpy(name, start, length);
    name[length] = '\0';
    const char *nearest = cli_nearest(name, names, n);
    return nearest != NULL ? cli_misuse(command, "no option %s; did you mean --%s?", word, nearest)
                           : cli_misuse(command, "no option %s", word);
}

static int store_vary(cli_args *args, const char *value)
{
    const char *sign = strchr(value, '=');
    if (sign == NULL || sign == value || sign[1] == '\0') {
        return cli_misuse(args->command,
                          "--vary %s: expected NAME=FROM:TO:COUNT or "
                          "NAME=VALUE,VALUE..., e.g. pawl.stop_shift=-1.2:0:13mm",
                          value);
    }
    if (args->nvary == CLI_VARIES) {
        return cli_misuse(args->command, "more than %d --vary", (int)CLI_VARIES);
    }
    args->vary[args->nvary++] = value;
    return CLI_OK;
}

static int store_held(cli_args *args, const char *value)
{
    if (args->nheld == CLI_OPERANDS) {
        return cli_misuse(args->command, "more than %d files held out", (int)CLI_OPERANDS);
    }
    args->held[args->nheld++] = value;
    return CLI_OK;
}

/* an override like others, so that it goes wherever they go */
static int store_inertia(cli_args *args, const char *value)
{
    static const char *const sets[] = {"inertia=accept", "inertia=balance", "inertia=refuse"};
    for (int i = 0; i < 3; i++) {
        if (strcmp(sets[i] + strlen("inertia="), value) == 0 && args->nset < CLI_SETS) {
            args->set[args->nset++] = sets[i];
            return CLI_OK;
        }
    }
    return cli_misuse(args->command, "--inertia %s: expected accept, balance or refuse", value);
}

static int store(cli_args *args, int option, const char *value)
{
    const char *name = args->command->options[option].name;
    args->value[option] = value;
    if (strcmp(name, "vary") == 0) {
        return store_vary(args, value);
    }
    if (strcmp(name, "inertia") == 0) {
        return store_inertia(args, value);
    }
    if (strcmp(name, "held-out") == 0 || strcmp(name, "holdout") == 0) {
        return store_held(args, value);
    }
    if (strcmp(name, "set") != 0) {
        return CLI_OK;
    }
    const char *sign = strchr(value, '=');
    if (sign == NULL || sign == value || sign[1] == '\0') {
        return cli_misuse(args->command,
                          "--set %s: expected NAME=VALUE, e.g. "
                          "pawl.stop_shift=-0.3mm",
                          value);
    }
    if (args->nset == CLI_SETS) {
        return cli_misuse(args->command, "more than %d --set", (int)CLI_SETS);
    }
    args->set[args->nset++] = value;
    return CLI_OK;
}

/* one option word; *at moves past its value, or past all values */
static int take_option(cli_args *args, const char *word, int argc, char **argv, int *at)
{
    const cli_command *command = args->command;
    const char *inline_value = NULL;
    int option;
    if (word[1] == '-') {
        size_t length = strcspn(word + 2, "=");
        option = find_long(command, word + 2, length);
        inline_value = word[2 + length] == '=' ? word + 3 + length : NULL;
    } else {
        option = find_letter(command, word[1]);
        inline_value = word[2] != '\0' ? word + 2 : NULL;
    }
    if (option < 0) {
        return unknown(command, word);
    }
    if (command->options[option].value == NULL) {
        return inline_value == NULL
                   ? store(args, option, "")
                   : cli_misuse(command, "--%s takes no value", command->options[option].name);
    }
    if (inline_value == NULL) {
        if (*at + 1 >= argc) {
            return cli_misuse(command, "%s needs a value: %s", word,
                              command->options[option].value);
        }
        inline_value = argv[++*at];
    }
    int code = store(args, option, inline_value);
    int goes_on = strcmp(command->options[option].name, "holdout") == 0;
    while (goes_on && code == CLI_OK && *at + 1 < argc && argv[*at + 1][0] != '-') {
        code = store(args, option, argv[++*at]);
    }
    return code;
}

int cli_parse(cli_args *args, const cli_command *command, int argc, char **argv)
{
    *args = (cli_args){.command = command};
    int ended = 0;
    for (int i = 0; i < argc; i++) {
        const char *word = argv[i];
        if (!ended && strcmp(word, "--") == 0) {
            ended = 1;
        } else if (!ended && word[0] == '-' && word[1] != '\0') {
            int code = take_option(args, word, argc, argv, &i);
            if (code != CLI_OK) {
                return code;
            }
        } else if (args->noperand == CLI_OPERANDS) {
            return cli_misuse(command, "more than %d operands", (int)CLI_OPERANDS);
        } else {
            args->operand[args->noperand++] = word;
        }
    }
    int enough = args->noperand >= command->noperands;
    if (cli_value(args, "help") != NULL ||
        (enough && (command->more || args->noperand == command->noperands))) {
        return CLI_OK;
    }
    return !enough
               ? cli_misuse(command, "expected %s", command->operands)
               : cli_misuse(command, "one operand too many: %s", args->operand[command->noperands]);
}

const char *cli_value(const cli_args *args, const char *option)
{
    int i = find_long(args->command, option, strlen(option));
    return i < 0 ? NULL : args->value[i];
}

int cli_time(const cli_args *args, const char *option, double *seconds)
{
    const char *text = cli_value(args, option);
    stein_err err;
    if (text == NULL) {
        return CLI_OK;
    }
    if (mech_parse_quantity(text, (mech_dim){.s = 1}, seconds, &err) != STEIN_OK) {
        return cli_misuse(args->command, "--%s %s: %s", option, text, err.msg);
    }
    return CLI_OK;
}

int cli_count(const cli_args *args, const char *option, int most, int *value)
{
    const char *text = cli_value(args, option);
    if (text == NULL) {
        return CLI_OK;
    }
    size_t digits = strspn(text, "0123456789");
    long n = digits > 0 && digits < 7 && text[digits] == '\0' ? strtol(text, NULL, 10) : -1;
    if (n < 1 || n > most) {
        return cli_misuse(args->command, "--%s %s: expected a number from 1 to %d", option, text,
                          most);
    }
    *value = (int)n;
    return CLI_OK;
}

int cli_threads(const cli_args *args, int *threads)
{
    long n = sysconf(_SC_NPROCESSORS_ONLN);
    *threads = n < 1 ? 1 : n > LAB_THREADS ? LAB_THREADS : (int)n;
    return cli_count(args, "jobs", LAB_THREADS, threads);
}
