/* SPDX-License-Identifier: GPL-3.0-or-later
 * step.c - is the file's own step good enough for these strokes?
 *
 * The diagnosis takes steps of controlled error (simulate.c of the fit), so a step that is too
 * coarse cannot pass for physics here; every other command takes the file's. Where the two differ
 * by what the films can show, the extended file would miss the strokes it was fitted to, so that is
 * said. For a stroke in the middle, at the file's numbers, with Dormand-Prince steps of either
 * length (the step, not the tableau, is in question), RMS of a channel:
 *
 *      |y(file's step) - y(controlled steps)|  >  0.3 noise
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "search.h"

static const double visible = 0.3; /* of the noise */

/* predictions of a stroke with the file's numbers. @return OK, ENOMEM; else it cannot be simulated
 */
static stein_status predict(const fit__problem *of, int stroke, int plain, double *y)
{
    fit__problem p = *of;
    fit__bench b;
    p.plain = plain;
    double *x = calloc((size_t)p.nu + 1, sizeof *x);
    stein_status status = fit__bench_make(&b, &p, NULL);
    if (status == STEIN_OK) {
        status = x != NULL ? fit__simulate(&p, &b, stroke, x, y, NULL) : STEIN_ENOMEM;
    }
    fit__bench_free(&b);
    free(x);
    return status;
}

/* the channel that the step spoils most. @return RMS [noise] */
static double worst(const fit__stroke *t, const double *a, const double *b, int *channel)
{
    double most = 0.0;
    for (int c = 0; c < t->nch; c++) {
        double sum = 0.0;
        for (int i = 0; i < t->n; i++) {
            double off = a[c * t->n + i] - b[c * t->n + i];
            sum += off * off;
        }
        double rms = sqrt(sum / t->n) / t->noise[c];
        *channel = rms > most ? c : *channel;
        most = fmax(most, rms);
    }
    return most;
}

stein_status diag__check_step(const fit__problem *p, char **line, stein_err *err)
{
    int stroke = p->nstroke / 2, channel = 0;
    const fit__stroke *t = &p->stroke[stroke];
    const stein_model *m = lab_equations(p->model);
    size_t size = (size_t)t->nch * (size_t)t->n;
    double *y = malloc(sizeof *y * (2 * size + 1)), off = 0.0;
    *line = NULL;
    if (y == NULL) {
        return lab__no_memory(err);
    }
    stein_status fine = predict(p, stroke, 0, y);
    stein_status plain = fine == STEIN_OK ? predict(p, stroke, 1, y + size) : STEIN_OK;
    if (fine == STEIN_OK && plain == STEIN_OK) {
        off = worst(t, y, y + size, &channel);
    }
    free(y);
    if (fine == STEIN_ENOMEM || plain == STEIN_ENOMEM) {
        return lab__no_memory(err);
    }
    int said = plain != STEIN_OK || off > visible;
    if (plain != STEIN_OK) {
        *line = lab__text("%s: it cannot be simulated with the file's own step of %g s: that "
                          "is too coarse; the diagnosis takes finer ones",
                          t->data->file, m->dt);
    } else if (off > visible) {
        *line = lab__text("%s: the file's own step of %g s is too coarse: it moves %s by %.2g "
                          "of its noise; the diagnosis takes finer ones, other commands do not",
                          t->data->file, m->dt, fit__name_of(p, t->channel[channel]), off);
    }
    return !said || *line != NULL ? STEIN_OK : lab__no_memory(err);
}
