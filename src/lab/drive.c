/* SPDX-License-Identifier: GPL-3.0-or-later
 * drive.c - inputs of a mechanism driven by the columns of a data file.
 *
 * Every column that is an input is a signal; the rest of the file is passed over. A prescribed
 * motion needs two derivatives that do not jump by themselves: natural cubic splines (GSL). A force
 * needs none, and straight lines do not overshoot where it is switched on.
 */
#include <gsl/gsl_spline.h>
#include <stdlib.h>
#include <string.h>

#include "inner.h"
#include "stein/data.h"

/* one column that drives an input: its samples that are present */
typedef struct track {
    int input;     /* of the model */
    double *t, *u; /* [n] */
    int n;
    gsl_spline *spline;
    gsl_interp_accel *accel;
} track;

struct lab_drive {
    const stein_model *model;
    track *track; /* [ntrack] */
    int ntrack;
};

void lab_drive_close(lab_drive *drive)
{
    if (drive == NULL) {
        return;
    }
    for (int i = 0; i < drive->ntrack; i++) {
        free(drive->track[i].t);
        free(drive->track[i].u);
        gsl_spline_free(drive->track[i].spline);
        gsl_interp_accel_free(drive->track[i].accel);
    }
    free(drive->track);
    free(drive);
}

/* the samples of every column */
static stein_status take_columns(lab_drive *d, const lab_data *data, stein_err *err)
{
    d->track = calloc((size_t)data->ncolumn, sizeof *d->track);
    if (d->track == NULL) {
        return lab__no_memory(err);
    }
    for (d->ntrack = 0; d->ntrack < data->ncolumn; d->ntrack++) {
        const lab_column *c = &data->column[d->ntrack];
        track *k = &d->track[d->ntrack];
        k->input = c->index;
        k->t = malloc(sizeof *k->t * ((size_t)c->samples + 1));
        k->u = malloc(sizeof *k->u * ((size_t)c->samples + 1));
        if (k->t == NULL || k->u == NULL) {
            d->ntrack++; // owned all the same
            return lab__no_memory(err);
        }
        for (int i = 0; i < data->nrow; i++) {
            if (c->present[i]) {
                k->t[k->n] = data->time[i];
                k->u[k->n++] = c->value[i];
            }
        }
    }
    return STEIN_OK;
}

/* ---- signals ---- */

static stein_status make_splines(lab_drive *d, const char *file, stein_err *err)
{
    for (int i = 0; i < d->ntrack; i++) {
        track *k = &d->track[i];
        const stein_input *input = &d->model->inputs[k->input];
        int smooth = input->kind == STEIN_INPUT_MOTION;
        if (k->n < (smooth ? 3 : 2)) {
            return lab__fail(err, STEIN_EPARSE, "%s: %d samples of \"%s\": expected at least %d",
                             file, k->n, input->name, smooth ? 3 : 2);
        }
        k->accel = gsl_interp_accel_alloc();
        k->spline = gsl_spline_alloc(smooth ? gsl_interp_cspline : gsl_interp_linear, (size_t)k->n);
        if (k->accel == NULL || k->spline == NULL ||
            gsl_spline_init(k->spline, k->t, k->u, (size_t)k->n) != 0) {
            return lab__no_memory(err);
        }
    }
    return STEIN_OK;
}

static void signal_at(void *ctx, double t, double u[3])
{
    const track *k = ctx;
    double first = k->t[0], last = k->t[k->n - 1];
    u[1] = u[2] = 0.0;
    if (t <= first || t >= last) {
        u[0] = t <= first ? k->u[0] : k->u[k->n - 1];
        return;
    }
    u[0] = gsl_spline_eval(k->spline, t, k->accel);
    u[1] = gsl_spline_eval_deriv(k->spline, t, k->accel);
    u[2] = gsl_spline_eval_deriv2(k->spline, t, k->accel);
}

stein_status lab_drive_open(lab_drive **drive, const char *file, const stein_model *model,
                            stein_err *err)
{
    lab_data_options options = lab_data_options_default(model);
    lab_data *data = NULL;
    options.inputs_only = 1;
    options.min_samples = 1; // make_splines knows better what it needs
    stein_status status = lab_data_open(&data, file, &options, err);
    if (status != STEIN_OK) {
        return status;
    }
    lab_drive *d = calloc(1, sizeof *d);
    if (d == NULL) {
        status = lab__no_memory(err);
    } else {
        d->model = model;
        status = take_columns(d, data, err);
    }
    lab_data_close(data);
    if (status == STEIN_OK && d != NULL) {
        status = make_splines(d, file, err);
    }
    if (status != STEIN_OK) {
        lab_drive_close(d);
        return status;
    }
    *drive = d;
    return STEIN_OK;
}

stein_status lab_drive_bind(lab_drive *d, stein_sim *sim, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int i = 0; status == STEIN_OK && i < d->ntrack; i++) {
        status = stein_drive(sim, d->model->inputs[d->track[i].input].name, signal_at, &d->track[i],
                             err);
    }
    return status;
}
