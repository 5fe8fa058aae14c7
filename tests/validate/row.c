/* SPDX-License-Identifier: GPL-3.0-or-later
 * row.c - rows of `make validate` (validate.h).
 */
#include "validate.h"

#include <math.h>
#include <stdio.h>

static int failed;

void validate_row(const char *problem, const char *source, const char *reference, const char *ours,
                  double error, double bar)
{
    int is_fact = isnan(bar), passed = is_fact ? error == 0.0 : error <= bar;
    failed += !passed;
    printf("%s\t%s\t%s\t%s\t", problem, source, reference, ours);
    if (is_fact) {
        printf("\t\t%s\n", passed ? "yes" : "NO");
    } else {
        printf("%.1e\t%.0e\t%s\n", error, bar, passed ? "yes" : "NO");
    }
}

int validate_failed(void)
{
    return failed;
}
