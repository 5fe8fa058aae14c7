/* SPDX-License-Identifier: GPL-3.0-or-later
 * windows.c - records of chaotic motion, cut into windows that can be predicted, and blocks of one
 * or two records, held out.
 *
 * A small error of the initial state may grow exponentially. Then no numbers of the mechanism
 * follow a whole record, and its sum of squares has a minimum every few noises (as in multiple
 * shooting: Bock, in: Modelling of Chemical Reaction Systems, Springer 1981, 102-125). A window
 * begins in a state of its own, read from its first samples, and ends where an error of it has
 * grown `grown` times. What the record shows of the mechanism is in the windows, each of which
 * loses no more than its initial state.
 */
#include <math.h>
#include <stdlib.h>

#include "data_cut.h"
#include "diagnosis.h"

enum { LEAST_ROWS = 24, ROUNDS = 3 };

/* how the records' motion can be predicted, one problem made for that alone */
typedef struct outlook {
    fit__horizon *horizon; /* [n] */
    double *time;          /* [n] room of time_at */
    int free;              /* an initial position is unknown */
    int shown;             /* the records show every position that they begin in */
    double half;           /* longest half of a swing [s]; 0: one of them does not swing */
} outlook;

static void outlook_free(outlook *o)
{
    free(o->horizon);
    free(o->time);
}

static stein_status look_ahead(const diagnosis *d, const lab_model *model, const lab_dataset *data,
                               outlook *o, stein_err *err)
{
    lab_fit_def def = lab_fit_def_default();
    fit__problem p;
    def.threads = d->def->threads > 0 ? d->def->threads : 1;
    def.stop = d->def->stop;
    def.ctx = d->def->ctx;
    o->shown = 1;
    o->horizon = calloc((size_t)data->n, sizeof *o->horizon);
    o->time = calloc((size_t)data->n, sizeof *o->time);
    if (o->horizon == NULL || o->time == NULL) {
        return lab__no_memory(err);
    }
    stein_status status = fit__problem_make_open(&p, model, data, &def, err);
    if (status == STEIN_OK) {
        p.tolerance = diag__tolerance_of(&p);
        status = fit__horizons(&p, diag__grown, o->horizon, err);
    }
    for (int k = p.np; status == STEIN_OK && k < p.nu; k++) {
        int position = p.unknown[k].kind == FIT__POSITION;
        o->free |= position;
        o->shown &= !(position && p.unknown[k].prior);
    }
    for (int s = 0; status == STEIN_OK && s < p.nstroke; s++) {
        double half = p.stroke[s].half;
        o->half = half > 0.0 && (s == 0 || o->half > 0.0) ? fmax(o->half, half) : 0.0;
    }
    fit__problem_free(&p);
    return status;
}

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* a quantile of the times at which errors have grown; those where they have not count as `whole`.
 * NAN: nothing counts. */
static double time_at(outlook *o, const int *counts, int n, double share, double whole)
{
    int m = 0;
    for (int i = 0; i < n; i++) {
        if (counts == NULL || counts[i]) {
            o->time[m++] = fmin(o->horizon[i].time, whole);
        }
    }
    qsort(o->time, (size_t)m, sizeof *o->time, compare);
    return m > 0 ? o->time[(int)(share * (m - 1))] : (double)NAN;
}

/* length[s] of windows, INFINITY of those of regular motion */
static void set_lengths(double *length, const int *is_chaotic, int n, double at)
{
    for (int s = 0; s < n; s++) {
        length[s] = is_chaotic[s] ? at : (double)INFINITY;
    }
}

/* windows of a length at which three quarters of them can be predicted. @return as cut_all */
static stein_status cut(diagnosis *d, const lab_model *model, const lab_dataset *data,
                        const int *is_chaotic, double *at, stein_err *err)
{
    double *length = malloc(sizeof *length * (size_t)data->n);
    stein_status status = length != NULL ? STEIN_OK : lab__no_memory(err);
    int again = 1;
    for (int round = 0; status == STEIN_OK && again && round < ROUNDS; round++) {
        outlook o = {.horizon = NULL};
        lab_dataset_close(d->windows);
        free(d->record_of);
        d->windows = NULL;
        d->record_of = NULL;
        set_lengths(length, is_chaotic, data->n, *at);
        status = data__cut_all(&d->windows, data, length, LEAST_ROWS, &d->record_of, err);
        status = status == STEIN_OK ? look_ahead(d, model, d->windows, &o, err) : status;
        int n = 0, bad = 0;
        for (int w = 0; status == STEIN_OK && w < d->windows->n; w++) {
            n += is_chaotic[d->record_of[w]];
            bad += is_chaotic[d->record_of[w]] && o.horizon[w].growth > 3.0 * diag__grown;
        }
        again = status == STEIN_OK && bad > diag__some_of * n;
        if (again) {
            *at = time_at(&o, NULL, d->windows->n, diag__some_of, *at);
        }
        d->cut = status == STEIN_OK && o.shown;
        outlook_free(&o);
    }
    free(length);
    return status;
}

static char *tell(const diagnosis *d, const lab_dataset *data, const int *is_chaotic, int n,
                  double growth, double at)
{
    int first = 0;
    while (first < data->n - 1 && !is_chaotic[first]) {
        first++;
    }
    return lab__text("%s%s: the motion is chaotic, an error of the initial state grows %.1g times "
                     "in a record; cut into windows of %.3g s, %d in all",
                     data->stroke[first]->file, n > 1 ? " and others" : "", growth, at,
                     d->windows->n);
}

/* what of each record is held out */
static char *tell_blocks(const lab_dataset *windows)
{
    const lab_data *fitted = windows->stroke[0], *held = windows->stroke[1];
    const double *t = held->time;
    int gap = held->gap_to - held->first_row;
    return lab__text("%s: held out is what lies from %.4g s to %.4g s and from %.4g s to %.4g s%s",
                     fitted->source, t[0], t[held->gap_from - held->first_row - 1], t[gap],
                     t[held->nrow - 1], windows->n > 2 ? ", and the same of the other record" : "");
}

/* Do six blocks of every record show swings, and enough samples? */
static int has_blocks(const outlook *o, const lab_dataset *data)
{
    int yes = o->free && o->shown && o->half > 0.0;
    for (int s = 0; s < data->n; s++) {
        const lab_data *t = data->stroke[s];
        yes &= data__can_cut(t) && t->nrow >= 6 * LEAST_ROWS &&
               t->time[t->nrow - 1] - t->time[0] >= 6.0 * o->half;
    }
    return yes;
}

stein_status diag__cut(diagnosis *d, const lab_model *model, const lab_dataset *data, char **line,
                       stein_err *err)
{
    outlook o = {.horizon = NULL};
    int *is_chaotic = calloc((size_t)data->n, sizeof *is_chaotic), n = 0, whole = 0;
    double growth = 0.0;
    *line = NULL;
    stein_status status =
        is_chaotic != NULL ? look_ahead(d, model, data, &o, err) : lab__no_memory(err);
    for (int s = 0; status == STEIN_OK && s < data->n; s++) {
        is_chaotic[s] = o.horizon[s].growth > diag__chaotic() && data__can_cut(data->stroke[s]);
        whole += o.horizon[s].growth > diag__chaotic() && !is_chaotic[s];
        n += is_chaotic[s];
        growth = fmax(growth, o.horizon[s].growth);
    }
    double at = n > 0 ? time_at(&o, is_chaotic, data->n, 0.5, INFINITY) : (double)NAN;
    if (n > 0 && o.shown && isfinite(at)) {
        status = cut(d, model, data, is_chaotic, &at, err);
        *line = d->cut ? tell(d, data, is_chaotic, n, growth, at) : NULL;
    } else if (status == STEIN_OK && n == 0 && whole > 0) {
        *line =
            lab__text("%d record%s of chaotic motion with times of events: not cut into windows",
                      whole, whole == 1 ? "" : "s");
    } else if (status == STEIN_OK && n == 0 && data->n < DIAG_HOLD_EVERY &&
               d->def->held_out == NULL && has_blocks(&o, data)) {
        status = data__hold_blocks(&d->windows, data, &d->record_of, err);
        d->cut = d->blocks = status == STEIN_OK;
        *line = d->blocks ? tell_blocks(d->windows) : NULL;
    }
    free(is_chaotic);
    outlook_free(&o);
    return status;
}
