/* SPDX-License-Identifier: GPL-3.0-or-later
 * shown.c - what the report shows beside the verdict, and whether extended.yaml reproduces what was
 * found.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "diagnosis.h"

enum { TRACES = 4, TRACES_HELD = 2 };

/* predictions of a record from its weighted residuals */
static void predict(const fit__problem *p, int s, const double *r, double *y)
{
    const fit__stroke *t = &p->stroke[s];
    r += fit__offset(p, s);
    for (int i = 0; i < t->nch * t->n; i++) {
        y[i] = t->y[i] - fit__off(t, r, i);
    }
}

static stein_status traces(diagnosis *d, const fit__problem *p, const double *before,
                           const double *after, const char *const *phase, int reporting, int most,
                           stein_err *err)
{
    size_t size = (size_t)p->rows;
    double *y = malloc(sizeof *y * (2 * size + 1));
    stein_status status = y != NULL ? STEIN_OK : lab__no_memory(err);
    for (int k = 0; status == STEIN_OK && k < most && k < p->nstroke; k++) {
        int s = k * p->nstroke / (most < p->nstroke ? most : p->nstroke);
        predict(p, s, before, y);
        if (after != NULL) {
            predict(p, s, after, y + size);
        }
        status = diag__trace(&d->out->trace, &d->out->ntrace, p, s, reporting, y,
                             after != NULL ? y + size : NULL, phase + diag__frame(p, s), err);
    }
    free(y);
    return status;
}

/* where the extension acts: the best row, or the law. @return 0: there is none */
static int extended(const diagnosis *d, diag__side *to)
{
    const diag__row *best = d->t.row[d->j.best];
    if (d->out->ncause > 0) {
        *to = (diag__side){&best->p, best->x, best->r};
    } else if (d->out->nlaw > 0 && d->out->law[0].pays) {
        *to = (diag__side){&d->laws.all.p, d->laws.curve[0].x, d->laws.curve[0].r};
    }
    return to->p != NULL;
}

static stein_status motion(diagnosis *d, const char *const *phase, const char *const *held_phase,
                           stein_err *err)
{
    const diag__row *null = d->t.row[d->j.null];
    diag__side from = {&null->p, null->x, null->r}, to = {NULL, NULL, NULL};
    int more = extended(d, &to), read = isfinite(d->before.rmse);
    if (read) {
        from = (diag__side){&d->before.p, d->before.x, d->before.r};
        more = more && isfinite(d->after.rmse);
        to = (diag__side){&d->after.p, d->after.x, d->after.r};
    }
    stein_status status =
        diag__motion_check(&from, more ? &to : NULL, read ? held_phase : phase, d->out->verdict,
                           read ? d->fitted.n : 0, &d->out->motion, err);
    d->out->motion.held_out = read;
    return status;
}

stein_status diag__verify_written(diagnosis *d, stein_err *err)
{
    diag__side side[2] = {{NULL, NULL, NULL}, {&d->after.p, d->after.x, d->after.r}};
    lab_diagnosis *o = d->out;
    stein_err why = {STEIN_OK, ""};
    int changed = d->def->options != NULL && d->def->options->nset > 0; // by no file
    if (!lab_diagnosis_extends(o) || !extended(d, &side[0]) || changed) {
        return STEIN_OK;
    }
    stein_status status = diag__verify(&d->q, side, 1 + isfinite(d->after.rmse), o, &why);
    if (status == STEIN_OK && o->verified.same) {
        return STEIN_OK;
    }
    size_t n = strlen(o->reason);
    if (status == STEIN_OK) {
        snprintf(o->reason + n, sizeof o->reason - n,
                 " An error of this program: extended.yaml leaves %.4g noises where its fit left "
                 "%.4g.",
                 o->verified.file, o->verified.table);
    } else {
        o->verified = (lab_verified){.done = 1, .table = NAN, .file = NAN};
        snprintf(o->reason + n, sizeof o->reason - n,
                 " An error of this program: extended.yaml cannot be simulated: %s.", why.msg);
    }
    return fit__forgive(status, err);
}

stein_status diag__show_all(diagnosis *d, stein_err *err)
{
    const diag__row *null = d->t.row[d->j.null];
    const fit__problem *p = &null->p;
    diag__side end = {NULL, NULL, NULL};
    const double *r = extended(d, &end) ? end.r : NULL;
    int read = isfinite(d->before.rmse);
    size_t frames = diag__frame(p, p->nstroke),
           more = read ? diag__frame(&d->before.p, d->before.p.nstroke) : 0;
    const char **phase = malloc(sizeof *phase * (frames + more + 1));
    double *time = malloc(sizeof *time * (frames + 1));
    stein_status status = phase != NULL && time != NULL ? diag__phases(p, null->x, phase, time, err)
                                                        : lab__no_memory(err);
    if (status == STEIN_OK && more > 0) {
        status = diag__phases(&d->before.p, d->before.x, phase + frames, NULL, err);
    }
    if (status == STEIN_OK && r != NULL) {
        d->out->phase = diag__phase_shown(p, null->r, r, phase);
    }
    status = status == STEIN_OK ? traces(d, p, null->r, r, phase, 0, TRACES, err) : status;
    if (status == STEIN_OK && more > 0) {
        int better = isfinite(d->after.rmse);
        status = traces(d, &d->before.p, d->before.r, better ? d->after.r : NULL, phase + frames, 1,
                        TRACES_HELD, err);
    }
    diag__progress(d, 0.94, "the force that the measured motion needs");
    status = status == STEIN_OK ? diag__show(d->out, p, null->x, null->r, null->J, phase, time, err)
                                : status;
    status = status == STEIN_OK ? motion(d, phase, phase + frames, err) : status;
    free(phase);
    free(time);
    return status;
}
