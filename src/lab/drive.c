/* SPDX-License-Identifier: GPL-3.0-or-later
 * drive.c - inputs of a mechanism driven by the columns of a CSV file.
 *
 * The file has the form of measured data: "#" lines, a header of `channel [unit]` with `time [s]`
 * first, rows in increasing time, an empty cell for a missing sample. A prescribed motion needs two
 * derivatives that do not jump by themselves: natural cubic splines (GSL). A force needs none, and
 * straight lines do not overshoot where it is switched on.
 */
#include <errno.h>
#include <gsl/gsl_spline.h>
#include <stdlib.h>
#include <string.h>

#include "inner.h"

enum { MAX_COLUMNS = 256 };

/* one column that drives an input */
typedef struct track {
    int input;     /* of the model */
    double factor; /* to the input's unit */
    double *t, *u; /* [n] */
    int n, room;
    gsl_spline *spline;
    gsl_interp_accel *accel;
} track;

struct lab_drive {
    const stein_model *model;
    track *track; /* [ntrack] */
    int ntrack;
    int column[MAX_COLUMNS]; /* track of each column, -1: not an input */
    int ncolumn;
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

/* ---- reading ---- */

/* next cell of a line: text without blanks around it; NULL at the end */
static char *next_cell(char **rest)
{
    char *cell = *rest;
    if (cell == NULL) {
        return NULL;
    }
    char *comma = strchr(cell, ',');
    *rest = comma != NULL ? comma + 1 : NULL;
    char *end = comma != NULL ? comma : cell + strlen(cell);
    while (end > cell && strchr(" \t\r\n", end[-1]) != NULL) {
        end--;
    }
    *end = '\0';
    return cell + strspn(cell, " \t");
}

/* "name [unit]" cut in two; the unit is "1" when there is none */
static void cut_title(char *cell, const char **unit)
{
    char *open = strchr(cell, '['), *shut = open != NULL ? strchr(open, ']') : NULL;
    *unit = "1";
    if (shut != NULL) {
        *shut = '\0';
        *unit = open + 1;
        while (open > cell && (open[-1] == ' ' || open[-1] == '\t')) {
            open--;
        }
        *open = '\0';
    }
}

/* a unit of the file against one of the model; 0 when it is another quantity */
static int convert(const char *unit, const char *wanted, double *factor)
{
    mech_dim a, b;
    double fa, fb;
    if (mech_parse_unit(unit, &a, &fa) != 0 || mech_parse_unit(wanted, &b, &fb) != 0 ||
        a.kg != b.kg || a.m != b.m || a.s != b.s) {
        return 0;
    }
    *factor = fa / fb;
    return 1;
}

static stein_status add_column(lab_drive *d, const char *file, int line, const char *name,
                               const char *unit, stein_err *err)
{
    int input = stein_find_input(d->model, name);
    int track_of = -1;
    double factor = 1.0;
    if (d->ncolumn == 0 && (strcmp(name, "time") != 0 || !convert(unit, "s", &factor))) {
        return lab__fail(err, STEIN_EPARSE,
                         "%s:%d: the first column is \"%s [%s]\": expected time [s]", file, line,
                         name, unit);
    }
    if (d->ncolumn == MAX_COLUMNS) {
        return lab__fail(err, STEIN_EPARSE, "%s:%d: more than %d columns", file, line,
                         (int)MAX_COLUMNS);
    }
    if (input >= 0 || d->ncolumn == 0) {
        if (input >= 0 && !convert(unit, d->model->inputs[input].unit, &factor)) {
            return lab__fail(err, STEIN_EPARSE, "%s:%d: input \"%s\" in [%s]: expected [%s]", file,
                             line, name, unit, d->model->inputs[input].unit);
        }
        track *grown = realloc(d->track, sizeof *grown * (size_t)(d->ntrack + 1));
        if (grown == NULL) {
            return lab__fail(err, STEIN_ENOMEM, "out of memory");
        }
        d->track = grown;
        track_of = d->ntrack++;
        d->track[track_of] = (track){.input = input, .factor = factor};
    }
    d->column[d->ncolumn++] = track_of;
    return STEIN_OK;
}

static stein_status read_header(lab_drive *d, const char *file, int line, char *text,
                                stein_err *err)
{
    stein_status status = STEIN_OK;
    for (char *cell = next_cell(&text); status == STEIN_OK && cell != NULL;
         cell = next_cell(&text)) {
        const char *unit;
        cut_title(cell, &unit);
        status = add_column(d, file, line, cell, unit, err);
    }
    if (status == STEIN_OK && d->ntrack < 2) {
        return lab__fail(err, STEIN_EINVAL, "%s:%d: no column is named like an input of \"%s\"",
                         file, line, d->model->name);
    }
    return status;
}

static stein_status append(track *k, double t, double u, stein_err *err)
{
    if (k->n == k->room) {
        k->room = k->room == 0 ? 256 : 2 * k->room;
        double *more_t = realloc(k->t, sizeof *more_t * (size_t)k->room);
        k->t = more_t != NULL ? more_t : k->t;
        double *more_u = realloc(k->u, sizeof *more_u * (size_t)k->room);
        k->u = more_u != NULL ? more_u : k->u;
        if (more_t == NULL || more_u == NULL) {
            k->room = k->n;
            return lab__fail(err, STEIN_ENOMEM, "out of memory");
        }
    }
    k->t[k->n] = t;
    k->u[k->n++] = u;
    return STEIN_OK;
}

/* one cell; the time, track 0, is kept as well to check its order */
static stein_status read_cell(track *k, const char *cell, double *time, int column, stein_err *err)
{
    double value;
    stein_status status = mech_parse_quantity(cell, (mech_dim){0, 0, 0, 0}, &value, err);
    if (status != STEIN_OK) {
        return status;
    }
    value *= k->factor;
    if (column == 0) {
        if (k->n > 0 && value <= k->t[k->n - 1]) {
            return lab__fail(err, STEIN_EPARSE, "the time does not increase");
        }
        *time = value;
    }
    return append(k, *time, value, err);
}

static stein_status read_row(lab_drive *d, const char *file, int line, char *text, stein_err *err)
{
    double time = 0.0;
    int column = 0;
    for (char *cell = next_cell(&text); cell != NULL; cell = next_cell(&text), column++) {
        stein_err why = {STEIN_OK, ""};
        if (column >= d->ncolumn || (column == 0 && *cell == '\0')) {
            return lab__fail(err, STEIN_EPARSE, "%s:%d: %s", file, line,
                             column == 0 ? "a row without time" : "more cells than columns");
        }
        int k = d->column[column];
        if (k < 0 || *cell == '\0') {
            continue;
        }
        if (read_cell(&d->track[k], cell, &time, column, &why) != STEIN_OK) {
            return lab__fail(err, why.code, "%s:%d: column %d: %s", file, line, column + 1,
                             why.msg);
        }
    }
    return STEIN_OK;
}

static stein_status read_lines(lab_drive *d, const char *file, FILE *f, stein_err *err)
{
    char *text = NULL;
    size_t size = 0;
    int line = 0;
    stein_status status = STEIN_OK;
    while (status == STEIN_OK && getline(&text, &size, f) >= 0) {
        line++;
        if (text[0] == '#' || text[strspn(text, " \t\r\n")] == '\0') {
            continue;
        }
        status = d->ncolumn == 0 ? read_header(d, file, line, text, err)
                                 : read_row(d, file, line, text, err);
    }
    free(text);
    if (status == STEIN_OK && ferror(f)) {
        return lab__fail(err, STEIN_EIO, "%s cannot be read", file);
    }
    if (status == STEIN_OK && d->ncolumn == 0) {
        return lab__fail(err, STEIN_EPARSE, "%s: no header line", file);
    }
    return status;
}

/* ---- signals ---- */

static stein_status make_splines(lab_drive *d, const char *file, stein_err *err)
{
    for (int i = 1; i < d->ntrack; i++) { // 0 is the time
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
            return lab__fail(err, STEIN_ENOMEM, "out of memory");
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
    FILE *f = fopen(file, "r");
    if (f == NULL) {
        return lab__fail(err, STEIN_EIO, "%s cannot be read: %s", file, strerror(errno));
    }
    lab_drive *d = calloc(1, sizeof *d);
    stein_status status = d != NULL ? STEIN_OK : lab__fail(err, STEIN_ENOMEM, "out of memory");
    if (status == STEIN_OK) {
        d->model = model;
        status = read_lines(d, file, f, err);
    }
    fclose(f);
    if (status == STEIN_OK) {
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
    for (int i = 1; status == STEIN_OK && i < d->ntrack; i++) {
        status = stein_drive(sim, d->model->inputs[d->track[i].input].name, signal_at, &d->track[i],
                             err);
    }
    return status;
}
