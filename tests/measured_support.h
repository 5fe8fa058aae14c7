/* SPDX-License-Identifier: GPL-3.0-or-later
 * measured_support.h - measurements made by others, for the tests that use them. They are not part
 * of this project: where they are absent the tests are skipped.
 */
#ifndef MEASURED_SUPPORT_H
#define MEASURED_SUPPORT_H

#include "fit_support.h"
#include "sanitized.h"
#include "stein/diagnose.h"

static int has_measured;

/* once for all tests of a suite: a folder, and in it the converted files if they are here */
static inline void make_measured(void)
{
    make_folder();
    has_measured = access("../shared/data", R_OK) == 0;
    if (has_measured) {
        char *command = lab__text("sh tests/convert_data.sh ../shared/data %s", folder);
        int code = system(command);
        free(command);
        ck_assert_int_eq(code, 0);
    }
}

static inline int converted(void)
{
    if (!has_measured) {
        printf("skipped: no measurements in ../shared/data\n");
    }
    return has_measured;
}

/* a diagnosis takes minutes under the sanitizers; the fits below it are tested there */
static inline int is_too_slow(void)
{
    if (SANITIZED) {
        printf("measured: no diagnoses under the sanitizers\n");
    }
    return SANITIZED;
}

/* diagnose files in the folder of the test, the last `held` of them held out
 * @param without  words for effects hidden from the search, NULL at the end; NULL: none */
static inline lab_diagnosis *diagnosed(fitted *f, const char *model, const char *const *name, int n,
                                       int held, const char *const *without)
{
    char path[8][200];
    const char *data[9] = {NULL};
    unsigned char is_held[8] = {0};
    for (int i = 0; i < n; i++) {
        snprintf(path[i], sizeof path[i], "%s", in_folder(name[i]));
        data[i] = path[i];
        is_held[i] = i >= n - held;
    }
    open_fit(f, model, NULL, data);
    lab_options options = cache_here(NULL);
    lab_diagnose_def def = lab_diagnose_def_default();
    def.threads = 2;
    def.options = &options;
    def.held_out = is_held;
    def.without = without;
    while (without != NULL && without[def.nwithout] != NULL) {
        def.nwithout++;
    }
    lab_diagnosis *d = NULL;
    ck_assert_stein(lab_diagnose(&d, model, f->model, f->data, &def, err));
    return d;
}

/* the cause of that kind, or the test fails */
static inline const lab_suspect *cause_of(const lab_diagnosis *d, const char *kind)
{
    for (int i = 0; i < d->ncause; i++) {
        if (strcmp(d->suspect[i].candidate.effect->kind, kind) == 0) {
            return &d->suspect[i];
        }
    }
    ck_abort_msg("%s is not among the causes: %s", kind, d->reason);
    return NULL;
}

#endif
