/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_cut.c - a record cut into windows, each a separate record.
 *
 * A window keeps the time of its record, and the name of its file with the time it covers.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data_cut.h"
#include "data_internal.h"

int data__can_cut(const lab_data *data)
{
    int events = 0;
    for (int i = 0; i < data->ncolumn; i++) {
        events |= data->column[i].role == LAB_EVENT_TIMES;
    }
    return !events;
}

int data__is_window(const lab_data *data)
{
    return data->nrow < data->file_rows;
}

static void *copy(const void *from, size_t size)
{
    void *to = malloc(size + 1);
    return to != NULL ? memcpy(to, from, size) : NULL;
}

data__window data__window_of(const lab_data *data)
{
    return (data__window){data->first_row, data->first_row + data->nrow, data->gap_from,
                          data->gap_to};
}

/* the rows of a column; outputs lack the gap */
static int cut_column(lab_column *to, const lab_column *from, data__window w)
{
    size_t first = (size_t)w.from, n = (size_t)(w.to - w.from);
    double *value = copy(from->value + first, sizeof *value * n);
    unsigned char *present = copy(from->present + first, n);
    *to = *from;
    to->value = value;
    to->present = present;
    to->samples = 0;
    for (int k = w.from; value != NULL && present != NULL && k < w.to; k++) {
        int at = k - w.from;
        if (from->role == LAB_OUTPUT && k >= w.gap_from && k < w.gap_to) {
            value[at] = NAN;
            present[at] = 0;
        }
        to->samples += present[at] != 0;
    }
    return value != NULL && present != NULL;
}

static int cut_columns(data__file *out, const lab_data *whole, data__window w)
{
    int ok = 1;
    for (int i = 0; i < whole->ncolumn; i++) {
        ok &= cut_column(&out->column[i], &whole->column[i], w);
    }
    return ok;
}

static char *label_of(const lab_data *whole, data__window w)
{
    const double *t = whole->time;
    return w.gap_to > w.gap_from
               ? lab__text("%s, %.4g s to %.4g s without %.4g s to %.4g s", whole->source,
                           t[w.from], t[w.to - 1], t[w.gap_from], t[w.gap_to - 1])
               : lab__text("%s, %.4g s to %.4g s", whole->source, t[w.from], t[w.to - 1]);
}

/* the settings of the record, without its initial state if the window begins later */
static void cut_settings(data__file *out, const lab_data *whole, int from)
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

stein_status data__cut(lab_data **to, const lab_data *whole, data__window w, stein_err *err)
{
    size_t n = (size_t)(w.to - w.from);
    data__file *out = calloc(1, sizeof *out);
    if (out == NULL) {
        return lab__no_memory(err);
    }
    out->data = *whole;
    out->data.nset = 0;
    out->data.nrow = (int)n;
    out->data.first_row = w.from;
    out->data.gap_from = w.gap_from;
    out->data.gap_to = w.gap_to;
    out->file = label_of(whole, w);
    out->source = lab__text("%s", whole->source);
    out->text = whole->text != NULL ? lab__text("%s", whole->text) : NULL;
    out->time = copy(whole->time + w.from, sizeof *whole->time * n);
    out->column = calloc((size_t)whole->ncolumn + 1, sizeof *out->column);
    out->set = calloc((size_t)whole->nset + 1, sizeof *out->set);
    out->note = calloc((size_t)whole->nnote + 1, sizeof *out->note);
    out->data.nnote = out->note != NULL ? whole->nnote : 0;
    int ok = out->file != NULL && out->source != NULL && out->time != NULL && out->set != NULL &&
             (whole->text == NULL || out->text != NULL) && out->column != NULL &&
             out->note != NULL && cut_columns(out, whole, w) && cut_notes(out, whole);
    data__hand_over(out);
    if (!ok) {
        lab_data_close(&out->data);
        return lab__no_memory(err);
    }
    cut_settings(out, whole, w.from);
    *to = &out->data;
    return STEIN_OK;
}

/* the next window of a set */
static stein_status add(lab_dataset *set, int *of, const lab_dataset *whole, int record,
                        data__window w, stein_err *err)
{
    stein_status status = data__cut(&set->stroke[set->n], whole->stroke[record], w, err);
    if (status == STEIN_OK) {
        of[set->n++] = record;
        set->stroke[set->n - 1]->number = set->n;
    }
    return status;
}

static stein_status make_set(lab_dataset **set, int **of, size_t n, stein_err *err)
{
    *set = calloc(1, sizeof **set);
    *of = malloc(sizeof **of * (n + 1));
    if (*set == NULL || *of == NULL ||
        ((*set)->stroke = calloc(n + 1, sizeof(lab_data *))) == NULL) {
        lab_dataset_close(*set);
        return lab__no_memory(err);
    }
    return STEIN_OK;
}

static stein_status hand_set(lab_dataset **out, lab_dataset *set, stein_status status)
{
    if (status == STEIN_OK) {
        *out = set;
    } else {
        lab_dataset_close(set);
    }
    return status;
}

/* row at which part k of n begins */
static int row_of(const lab_data *d, int k, int n)
{
    return (int)((long long)d->nrow * k / n);
}

/* how many windows a record makes */
static int windows_of(const lab_data *d, double length, int least)
{
    double lasts = d->time[d->nrow - 1] - d->time[0];
    int most = d->nrow / least;
    double n = fmin(ceil(lasts / length - 1e-9), most);
    return n > 1.0 && data__can_cut(d) ? (int)n : 1;
}

stein_status data__cut_all(lab_dataset **out, const lab_dataset *whole, const double *length,
                           int least, int **of, stein_err *err)
{
    size_t n = 0;
    for (int s = 0; s < whole->n; s++) {
        n += (size_t)windows_of(whole->stroke[s], length[s], least);
    }
    lab_dataset *set;
    stein_status status = make_set(&set, of, n, err);
    if (status != STEIN_OK) {
        return status;
    }
    for (int s = 0; s < whole->n; s++) {
        const lab_data *d = whole->stroke[s];
        int parts = windows_of(d, length[s], least);
        for (int k = 0; status == STEIN_OK && k < parts; k++) {
            data__window w = {.from = row_of(d, k, parts), .to = row_of(d, k + 1, parts)};
            status = add(set, *of, whole, s, w, err);
        }
    }
    return hand_set(out, set, status);
}

stein_status data__hold_blocks(lab_dataset **out, const lab_dataset *whole, int **of,
                               stein_err *err)
{
    lab_dataset *set;
    stein_status status = make_set(&set, of, 2 * (size_t)whole->n, err);
    if (status != STEIN_OK) {
        return status;
    }
    for (int s = 0; status == STEIN_OK && s < whole->n; s++) {
        const lab_data *d = whole->stroke[s];
        data__window fitted = {0, row_of(d, 5, 6), row_of(d, 2, 6), row_of(d, 3, 6)},
                     held = {row_of(d, 2, 6), d->nrow, row_of(d, 3, 6), row_of(d, 5, 6)};
        status = add(set, *of, whole, s, fitted, err);
        status = status == STEIN_OK ? add(set, *of, whole, s, held, err) : status;
    }
    return hand_set(out, set, status);
}
