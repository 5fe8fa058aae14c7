/* SPDX-License-Identifier: GPL-3.0-or-later
 * main.c - the program `stein` as part of a host that has set the locale of its user: what a
 * library in a graphical program has to live with. The program itself never sets one.
 *
 *     comma LOCALE COMMAND ...
 */
#include <locale.h>
#include <stdlib.h>

int stein_main(int argc, char **argv);
#define main stein_main
#include "../../src/cli/main.c"
#undef main

int main(int argc, char **argv)
{
    if (argc < 2 || setlocale(LC_ALL, argv[1]) == NULL) {
        fprintf(stderr, "no locale %s\n", argc > 1 ? argv[1] : "");
        return 77;
    }
    return stein_main(argc - 1, argv + 1);
}
