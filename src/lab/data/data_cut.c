/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_cut.c - a record cut into windows, each a record of its own.
 *
 * A window keeps the time of its record, and the name of its file with the time it covers.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data_cut.h"
#include "data_internal.h"

int data__is_window(const lab_data *data)
{
    return data->nrow < data->file_rows;
}

static void *copy(const void *from, size_t size)
{
    void *to = malloc(size + 1);
    return to != NULL ? memcpy(to, from, size) : NULL;
}

static int cut_columns(data__file *out, const lab_data *whole, size_t from, size_t n)
{
    int ok = 1;
    for (int i = 0; i < whole->ncolumn; i++) {
        const lab_column *c = &whole->column[i];
        lab_column *to = &out->column[i];
        *to = *c;
        to->value = copy(c->value + from, sizeof *c->value * n);
        to->present = copy(c->present + from, n);
        to->samples = 0;
        ok &= to->value != NULL && to->present != NULL;
        for (size_t k = 0; to->present != NULL && k < n; k++) {
            to->samples += to->present[k] != 0;
        }
    }
    return ok;
}

/* the settings of the record, but for its initial state where the window begins later */
static void cut_settings(data__file *out, const lab_data *whole, size_t from)
{
    for (int i = 0; i < whole->nset; i++) {
        if (from == 0 || strstr(whole->set[i].name, ".initial.") == NULL) {
            out->set[out->data.nset++] = whole->set[i];
        }
    }
}

static int cut_notes(data__file *out, const lab_data *whole)
{
    int ok = 1;
    for (int i = 0; i < whole->nnote; i++) {
        out->note[i] = (lab_note){.name = lab__text("%s", whole->note[i].name),
                                  .value = lab__text("%s", whole->note[i].value),
                                  .line = whole->note[i].line};
        ok &= out->note[i].name != NULL && out->note[i].value != NULL;
    }
    return ok;
}

stein_status data__cut(lab_data **window, const lab_data *whole, int from, int to, stein_err *err)
{
    size_t first = (size_t)from, n = (size_t)(to - from);
    data__file *out = calloc(1, sizeof *out);
    if (out == NULL) {
        return lab__no_memory(err);
    }
    out->data = *whole;
    out->data.nset = 0;
    out->data.nrow = (int)n;
    out->data.first_row = whole->first_row + from;
    out->file = lab__text("%s, %.4g s to %.4g s", whole->source, whole->time[from],
                          whole->time[to - 1]);
    out->source = lab__text("%s", whole->source);
    out->text = whole->text != NULL ? lab__text("%s", whole->text) : NULL;
    out->time = copy(whole->time + first, sizeof *whole->time * n);
    out->column = calloc((size_t)whole->ncolumn + 1, sizeof *out->column);
    out->set = calloc((size_t)whole->nset + 1, sizeof *out->set);
    out->note = calloc((size_t)whole->nnote + 1, sizeof *out->note);
    int ok = out->file != NULL && out->source != NULL && out->time != NULL && out->set != NULL &&
             (whole->text == NULL || out->text != NULL) && out->column != NULL &&
             out->note != NULL && cut_columns(out, whole, first, n) && cut_notes(out, whole);
    out->data.note = out->note;
    out->data.nnote = out->note != NULL ? whole->nnote : 0;
    if (!ok) {
        lab_data_close(&out->data);
        return lab__no_memory(err);
    }
    cut_settings(out, whole, first);
    data__hand_over(out);
    *window = &out->data;
    return STEIN_OK;
}

/* how many windows a record makes */
static int windows_of(const lab_data *d, double length, int least)
{
    double lasts = d->time[d->nrow - 1] - d->time[0];
    double n = fmin(ceil(lasts / length - 1e-9), d->nrow / least);
    return n > 1.0 ? (int)n : 1;
}

stein_status data__cut_all(lab_dataset **out, const lab_dataset *whole, const double *length,
                           int least, int **of, stein_err *err)
{
    size_t n = 0;
    for (int s = 0; s < whole->n; s++) {
        n += (size_t)windows_of(whole->stroke[s], length[s], least);
    }
    lab_dataset *set = calloc(1, sizeof *set);
    *of = malloc(sizeof **of * (n + 1));
    if (set == NULL || *of == NULL || (set->stroke = calloc(n, sizeof(lab_data *))) == NULL) {
        lab_dataset_close(set);
        return lab__no_memory(err);
    }
    stein_status status = STEIN_OK;
    for (int s = 0; s < whole->n; s++) {
        const lab_data *d = whole->stroke[s];
        int parts = windows_of(d, length[s], least);
        for (int k = 0; status == STEIN_OK && k < parts; k++) {
            int from = (int)((long long)d->nrow * k / parts);
            int to = (int)((long long)d->nrow * (k + 1) / parts);
            status = data__cut(&set->stroke[set->n], d, from, to, err);
            if (status == STEIN_OK) {
                (*of)[set->n++] = s;
                set->stroke[set->n - 1]->number = set->n;
            }
        }
    }
    if (status != STEIN_OK) {
        lab_dataset_close(set);
        return status;
    }
    *out = set;
    return STEIN_OK;
}
