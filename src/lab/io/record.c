/* SPDX-License-Identifier: GPL-3.0-or-later
 * record.c - samples of all output channels, in memory and as CSV.
 *
 * One block of doubles, row by row, that doubles when it is full: a stroke of 0.3 s at every step
 * is 3 MB. The CSV has the form of measured data, so a simulated stroke can replace a measured one.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io.h"

struct lab_record {
    const stein_model *model;
    double every, due; /* [s] */
    double *cell;      /* [room * nchannel] */
    int rows, room;
};

stein_status lab_record_create(lab_record **out, const stein_model *model, double every,
                               stein_err *err)
{
    if (!(every >= 0.0) || !isfinite(every)) {
        return lab__fail(err, STEIN_EINVAL, "sampling every %g s: expected an interval", every);
    }
    lab_record *record = calloc(1, sizeof *record);
    if (record == NULL) {
        return lab__no_memory(err);
    }
    record->model = model;
    record->every = every;
    record->due = -INFINITY;
    *out = record;
    return STEIN_OK;
}

void lab_record_destroy(lab_record *record)
{
    if (record != NULL) {
        free(record->cell);
        free(record);
    }
}

static stein_status append(lab_record *r, stein_sim *sim)
{
    int n = r->model->nchannel;
    if (r->rows == r->room) {
        size_t room = r->room == 0 ? 1024 : 2 * (size_t)r->room;
        double *cell = room > 1 << 30 ? NULL : realloc(r->cell, sizeof *cell * room * (size_t)n);
        if (cell == NULL) {
            return STEIN_ENOMEM;
        }
        r->cell = cell;
        r->room = (int)room;
    }
    double *row = r->cell + (size_t)r->rows * (size_t)n;
    for (int i = 0; i < n; i++) {
        row[i] = stein_read(sim, i);
    }
    r->rows++;
    return STEIN_OK;
}

stein_status lab_record_sample(void *record, stein_sim *sim)
{
    lab_record *r = record;
    double t = stein_time(sim), slack = 1e-6 * r->every;
    if (t < r->due - slack) {
        return STEIN_OK;
    }
    r->due = r->rows == 0 ? t : r->due;
    while (r->every > 0.0 && r->due - slack <= t) {
        r->due += r->every;
    }
    return append(r, sim);
}

stein_status lab_record_finish(lab_record *r, stein_sim *sim)
{
    int taken = r->rows > 0 && lab__record_at(r, r->rows - 1, 0) >= stein_time(sim);
    return taken ? STEIN_OK : append(r, sim);
}

const double *lab_record_numbers(const lab_record *record, int *rows)
{
    *rows = record->rows;
    return record->cell;
}

const stein_model *lab__record_model(const lab_record *record)
{
    return record->model;
}

int lab__record_rows(const lab_record *record)
{
    return record->rows;
}

double lab__record_at(const lab_record *r, int row, int channel)
{
    return r->cell[(size_t)row * (size_t)r->model->nchannel + (size_t)channel];
}

/* @param plain  1: titles are the names alone */
static void put_table(FILE *f, const lab_record *r, int plain)
{
    int n = r->model->nchannel;
    for (int i = 0; i < n; i++) {
        const stein_channel *c = &r->model->channels[i];
        fputs(c->name, f);
        if (!plain) {
            fprintf(f, " [%s]", c->unit);
        }
        putc(i + 1 < n ? ',' : '\n', f);
    }
    for (int row = 0; row < r->rows; row++) {
        char text[LAB_NUMBER];
        for (int i = 0; i < n; i++) {
            fputs(lab__number(text, lab__record_at(r, row, i)), f);
            putc(i + 1 < n ? ',' : '\n', f);
        }
    }
}

stein_status lab__write_csv_plain(const char *path, const lab_record *r, stein_err *err)
{
    lab__file file;
    stein_status status = lab__file_open(&file, path, err);
    if (status != STEIN_OK) {
        return status;
    }
    put_table(file.stream, r, 1);
    return lab__file_close(&file, 1, err);
}

stein_status lab_write_csv(const char *path, const lab_record *r, const char *const *notes,
                           stein_err *err)
{
    lab__file file;
    stein_status status = lab__file_open(&file, path, err);
    if (status != STEIN_OK) {
        return status;
    }
    lab__put_notes(file.stream, notes);
    put_table(file.stream, r, 0);
    return lab__file_close(&file, 1, err);
}
