/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_drive.c - inputs of a mechanism driven by the columns of a data file.
 *
 * Every column that is an input is a signal; the rest of the file is passed over. A prescribed
 * motion needs two derivatives that do not jump by themselves: natural cubic splines (GSL). A force
 * needs none, and straight lines do not overshoot where it is switched on.
 *
 * A position that jumps between two samples has no such derivatives: the spline overshoots, and the
 * force of the motion is an artefact of the sampling. It is found by its slope, which is far above
 * those beside it; the spline is used all the same, and lab_drive_doubt reports it.
 */
#include <gsl/gsl_spline.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io.h"
#include "stein/data.h"

static const double jump_share = 0.05; /* of the range of a column, at least */
static const double jump_slope = 20.0; /* against the slopes beside it */

/* one column that drives an input: its samples that are present */
typedef struct track {
    int input;     /* of the model */
    double *t, *u; /* [n] */
    int n, line;   /* line of its title in the file */
    gsl_spline *spline;
    gsl_interp_accel *accel;
} track;

struct lab_drive {
    const stein_model *model;
    track *track; /* [ntrack] */
    int ntrack;
    char doubt[400]; /* fault of a motion; "": nothing */
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
        k->line = c->line;
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

/* how far the spline leaves the samples near interval i */
static double overshoot(const track *k, int i)
{
    double low = INFINITY, high = -INFINITY, most = 0.0;
    int first = i > 3 ? i - 3 : 0, last = i + 4 < k->n - 1 ? i + 4 : k->n - 1;
    for (int s = first; s <= last; s++) {
        low = fmin(low, k->u[s]);
        high = fmax(high, k->u[s]);
    }
    for (int n = 0; n <= 200; n++) {
        double t = k->t[first] + (k->t[last] - k->t[first]) * n / 200.0;
        double u = gsl_spline_eval(k->spline, t, k->accel);
        most = fmax(most, fmax(u - high, low - u));
    }
    return most;
}

static double slope_of(const track *k, int i)
{
    return fabs(k->u[i + 1] - k->u[i]) / (k->t[i + 1] - k->t[i]);
}

/* the largest jump of a motion, if it has one */
static void find_jump(lab_drive *d, const track *k, const char *file)
{
    const stein_input *input = &d->model->inputs[k->input];
    double low = k->u[0], high = k->u[0];
    int at = -1;
    for (int i = 0; i < k->n; i++) {
        low = fmin(low, k->u[i]);
        high = fmax(high, k->u[i]);
    }
    for (int i = 1; i + 2 < k->n; i++) {
        double beside = fmax(slope_of(k, i - 1), slope_of(k, i + 1));
        double step = fabs(k->u[i + 1] - k->u[i]);
        if (step > jump_share * (high - low) && slope_of(k, i) > jump_slope * beside &&
            (at < 0 || step > fabs(k->u[at + 1] - k->u[at]))) {
            at = i;
        }
    }
    if (at >= 0) {
        snprintf(d->doubt, sizeof d->doubt,
                 "%s: column \"%s\" (line %d): the motion jumps by %.3g %s between %g s and "
                 "%g s; the spline through its samples overshoots by %.3g %s and its force is an "
                 "artefact of the sampling: give the transition several samples, or a force",
                 file, input->name, k->line, k->u[at + 1] - k->u[at], input->unit, k->t[at],
                 k->t[at + 1], overshoot(k, at), input->unit);
    }
}

const char *lab_drive_doubt(const lab_drive *d)
{
    return d->doubt[0] != '\0' ? d->doubt : NULL;
}

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
        if (smooth && d->doubt[0] == '\0') {
            find_jump(d, k, file);
        }
    }
    return STEIN_OK;
}

static void signal_at(void *ctx, double t, double u[3])
{
    const track *k = ctx;
    double first = k->t[0], last = k->t[k->n - 1];
    u[1] = u[2] = 0.0;
    if (t < first || t > last) { // at both ends the spline, which may move there
        u[0] = t < first ? k->u[0] : k->u[k->n - 1];
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
    options.min_samples = 1; // make_splines checks the number of samples
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
