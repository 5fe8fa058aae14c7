/* SPDX-License-Identifier: GPL-3.0-or-later
 * swing_bench.h - a diagnosis of swings, taken apart: up to its null fit.
 */
#ifndef SWING_BENCH_H
#define SWING_BENCH_H

#include "searching.h"
#include "swings.h"

typedef struct bench {
    fitted f;
    lab_options options;
    lab_diagnosis *out;
    lab_diagnose_def def;
    diag d;
    diag__found found;
} bench;

/* suspects and the null fit of the swings that b->f has open
 * @param name  [n] free numbers of the file */
static inline void begin_bench(bench *b, const char *file, const char **name, int n, int threads)
{
    b->options = cache_here(NULL);
    b->def = lab_diagnose_def_default();
    b->def.options = &b->options;
    b->out = calloc(1, sizeof *b->out);
    b->out->nfit = SWINGS;
    b->d = (diag){.file = file,
                  .model = b->f.model,
                  .def = &b->def,
                  .fit_data = b->f.data,
                  .held_data = b->f.data,
                  .name = name,
                  .nname = n,
                  .out = b->out};
    b->d.fit_def = lab_fit_def_default();
    b->d.fit_def.free = name;
    b->d.fit_def.nfree = n;
    b->d.fit_def.offset = 1e-3;
    b->d.fit_def.scatter = 1;
    b->d.fit_def.threads = threads;
    ck_assert_stein(diag__open_problem(&b->d, err));
    b->d.p.tolerance = 1e-9;
    ck_assert_stein(diag__suspects(&b->d, err));
    ck_assert_stein(diag__pursue(&b->d, err));
}

static inline void close_bench(bench *b)
{
    diag__held_free(&b->found.held);
    diag__law_free(&b->d);
    diag__close(&b->d);
    lab_diagnosis_destroy(b->out);
    drop(&b->f);
}

#endif
