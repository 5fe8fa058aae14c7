/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_set.c - several records: all files are read, or none.
 *
 * Records with the same bytes are accepted and reported, one message for all copies of a file.
 */
#include <stdlib.h>

#include "data_internal.h"

void lab_dataset_close(lab_dataset *set)
{
    for (int i = 0; set != NULL && set->stroke != NULL && i < set->n; i++) {
        lab_data_close(set->stroke[i]);
    }
    if (set != NULL) {
        free(set->stroke);
        free(set);
    }
}

static const char *text_of(const lab_data_options *options, int i)
{
    return options->text != NULL ? options->text[i] : NULL;
}

static int is_twin(const lab_data *a, const lab_data *b)
{
    return a != NULL && b != NULL && a->hash == b->hash && a->nrow == b->nrow;
}

/* "B: the same data as A, counted twice", "B ... C, 4 files: the same data as A, counted 5 times"
 */
static void report_twins(const lab_dataset *set, int i, const lab_data_options *o)
{
    const lab_data *one = set->stroke[i], *first = NULL, *last = NULL;
    int n = 0;
    for (int k = 0; k < set->n; k++) {
        if (k != i && is_twin(set->stroke[k], one)) {
            if (k < i) { // reported with that one
                return;
            }
            last = set->stroke[k];
            first = first == NULL ? last : first;
            n++;
        }
    }
    if (first == NULL) {
        return;
    }
    char *text = n == 1
                     ? lab__text("%s: the same data as %s, counted twice", first->file, one->file)
                     : lab__text("%s ... %s, %d files: the same data as %s, counted %d times",
                                 first->file, last->file, n, one->file, n + 1);
    if (text != NULL) {
        o->report(o->ctx, text);
    }
    free(text);
}

/* every file, to the end, so that all problems are reported. @return the first failure */
static stein_status open_all(lab_dataset *set, const char *const *file,
                             const lab_data_options *options, stein_err *err)
{
    stein_status status = STEIN_OK;
    double before = 0.0, total = 0.0;
    for (int i = 0; options->progress != NULL && i < set->n; i++) {
        total += data__bytes(file[i], text_of(options, i));
    }
    for (int i = 0; i < set->n; i++) {
        stein_err why = {STEIN_OK, ""};
        const char *text = text_of(options, i);
        stein_status one = data__open(&set->stroke[i], file[i], text, options, before, total, &why);
        before += total > 0.0 ? data__bytes(file[i], text) : 0.0;
        if (one == STEIN_EIO && options->report != NULL) {
            options->report(options->ctx, why.msg);
        }
        if (status == STEIN_OK && one != STEIN_OK) {
            status = lab__fail(err, one, "%s", why.msg);
        }
    }
    return status;
}

stein_status lab_dataset_open(lab_dataset **out, const char *const *file, int n,
                              const lab_data_options *options, stein_err *err)
{
    if (n < 1) {
        return lab__fail(err, STEIN_EINVAL, "no data files");
    }
    lab_dataset *set = calloc(1, sizeof *set);
    if (set == NULL || (set->stroke = calloc((size_t)n, sizeof(lab_data *))) == NULL) {
        lab_dataset_close(set);
        return lab__no_memory(err);
    }
    set->n = n;
    stein_status status = open_all(set, file, options, err);
    if (status != STEIN_OK) {
        lab_dataset_close(set);
        return status;
    }
    for (int i = 0; i < n && set->stroke[i] != NULL; i++) {
        set->stroke[i]->number = i + 1;
    }
    for (int i = 0; options->report != NULL && i < n; i++) {
        report_twins(set, i, options);
    }
    *out = set;
    return STEIN_OK;
}
