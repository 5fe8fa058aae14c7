/* SPDX-License-Identifier: GPL-3.0-or-later
 * bench.c - costs of an evaluation, a step and a stroke, here and in other programs.
 *
 *     build/bench [FILTER] [--csv FILE] [--plot FILE.svg]
 *
 * FILTER: only cases with this text in model or name are run; `instrument`, `stiff`, `worst`
 * and `precision` select those groups of cases. Run from the root of the sources (it opens
 * models/stein1788.yaml). Compare ratios within one run, not nanoseconds between two. Ends with 1
 * when anything that was timed is not right.
 */
#include <stdlib.h>
#include <string.h>

#include "bench.h"

#ifndef BENCH_FLAGS
#define BENCH_FLAGS "unknown flags"
#endif

typedef struct options {
    const char *filter, *csv, *plot;
} options;

static int read_options(options *o, int argc, char **argv)
{
    *o = (options){NULL, NULL, NULL};
    for (int i = 1; i < argc; i++) {
        const char **value = strcmp(argv[i], "--csv") == 0    ? &o->csv
                             : strcmp(argv[i], "--plot") == 0 ? &o->plot
                                                              : NULL;
        if (value != NULL && i + 1 < argc) {
            *value = argv[++i];
        } else if (value == NULL && argv[i][0] != '-' && o->filter == NULL) {
            o->filter = argv[i];
        } else {
            fprintf(stderr, "usage: bench [FILTER] [--csv FILE] [--plot FILE.svg]\n");
            return 0;
        }
    }
    return 1;
}

static int has_part(const options *o, const char *part)
{
    return o->filter == NULL || strcmp(o->filter, part) == 0;
}

int main(int argc, char **argv)
{
    options o;
    if (!read_options(&o, argc, argv)) {
        return 2;
    }
    FILE *csv = fopen(o.csv != NULL ? o.csv : "/dev/null", "w");
    if (csv == NULL) {
        perror(o.csv);
        return EXIT_FAILURE;
    }
    fprintf(csv,
            "kind,group,model,what,min_ns,median,quartile_1,quartile_3,operations_bar_error\n");
    printf("%s\n", BENCH_FLAGS);
#ifdef __VERSION__
    printf("compiler %s\n", __VERSION__);
#endif
    printf("default step of stein1788: %g s; lanes of this processor: %d\n\n",
           stein_model_stein1788.dt, stein_batch_width(&stein_model_stein1788));
    bench_filter(o.filter);
    closed_add();
    runtime_add();
    derivative_add();
    bench_measure();
    bench_print_cases(csv);
    if (has_part(&o, "operations")) {
        operations_rows();
    }
    closed_rows();
    runtime_rows();
    derivative_rows();
    if (has_part(&o, "instrument")) {
        instrument_rows();
    }
    if (has_part(&o, "stiff")) {
        stiff_rows();
    }
    if (has_part(&o, "worst")) {
        worst_rows();
    }
    if (has_part(&o, "precision")) {
        precision_rows(o.plot, csv);
    }
    bench_print_ratios(csv);
    if (fclose(csv) != 0) {
        perror(o.csv);
        return EXIT_FAILURE;
    }
    return bench_failures() > 0 ? EXIT_FAILURE : EXIT_SUCCESS;
}
