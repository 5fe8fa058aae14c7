/* SPDX-License-Identifier: GPL-3.0-or-later
 * main.c - the smallest program that prints the core's hash: core and equations only.
 * tests/identity.sh builds it for many compilers, options and processors.
 */
#include <stdio.h>

#include "stein/identity.h"
#include "stein/models.h"

int main(void)
{
    unsigned long long hash = 0;
    stein_err err = {STEIN_OK, ""};
    if (stein_identity(stein_models, &hash, &err) != STEIN_OK) {
        fprintf(stderr, "%s\n", err.msg);
        return 1;
    }
    printf("%016llx\n", hash);
    return 0;
}
