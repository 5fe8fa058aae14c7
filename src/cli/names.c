/* SPDX-License-Identifier: GPL-3.0-or-later
 * names.c - lists of parameters on the command line.
 */
#include <stdlib.h>
#include <string.h>

#include "cli.h"

int cli_names(const char *option, char **memory, const char **name)
{
    int n = 0;
    *memory = lab__text("%s", option);
    for (char *at = *memory; at != NULL;) {
        char *comma = strchr(at, ',');
        if (comma != NULL) {
            *comma = '\0';
        }
        if (*at == '\0' || n == CLI_NAMES) {
            return -1;
        }
        name[n++] = at;
        at = comma != NULL ? comma + 1 : NULL;
    }
    return n;
}

int cli_free_known(const cli_args *args, const lab_model *model, const char *const *name, int n)
{
    const stein_model *m = lab_equations(model);
    const char **names = calloc((size_t)m->np + 1, sizeof *names);
    int code = CLI_OK;
    for (int i = 0; names != NULL && i < m->np; i++) {
        names[i] = m->params[i].name;
    }
    for (int k = 0; names != NULL && code == CLI_OK && k < n; k++) {
        if (stein_find_param(m, name[k]) >= 0) {
            continue;
        }
        const char *nearest = cli_nearest(name[k], names, m->np);
        code = nearest != NULL
                   ? cli_misuse(args->command,
                                "--free %s: no such parameter in \"%s\"; did you mean %s?", name[k],
                                m->name, nearest)
                   : cli_misuse(args->command,
                                "--free %s: no such parameter in \"%s\" (a number that is 0 in the "
                                "file is not in its equations: --set %s=... adds it)",
                                name[k], m->name, name[k]);
    }
    free(names);
    return code;
}
