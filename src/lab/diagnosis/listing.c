/* SPDX-License-Identifier: GPL-3.0-or-later
 * listing.c - the candidates of a search: those of the mechanism as it stands there, with the
 * causes found so far, in scales of its strokes where it moves by its records only, and without
 * what shall be left out.
 */
#include <stdlib.h>
#include <string.h>

#include "searching.h"
#include "structure.h"

/* ---- what is left out ---- */

stein_status diag__check_without(const diag *d, stein_err *err)
{
    for (int i = 0; i < d->def->nwithout; i++) {
        int known, any = 0;
        const lab_effect *e = lab_effects(&known);
        for (int k = 0; k < known; k++) {
            any |= lab_effect_is(&e[k], d->def->without[i]);
        }
        if (!any) {
            return lab__fail(err, STEIN_ENAME,
                             "no effect is called \"%s\" by kind, site or class: nothing to go "
                             "without",
                             d->def->without[i]);
        }
    }
    return STEIN_OK;
}

static int is_left_out(const diag *d, const lab_candidate *c)
{
    int out = d->only != NULL && strcmp(c->place, d->only) != 0;
    for (int i = 0; i < d->def->nwithout; i++) {
        out |= lab_effect_is(c->effect, d->def->without[i]);
    }
    return out;
}

/* ---- how far and how fast it goes ---- */

/* Is a joint moved as it was recorded? Without the record the mechanism stands still. */
static int is_moved(const diag *d)
{
    const stein_model *m = lab_equations(d->model);
    const fit__stroke *s = &d->p.stroke[0];
    for (int k = 0; k < s->nsignal; k++) {
        if (m->inputs[s->signal[k].input].kind == STEIN_INPUT_MOTION) {
            return 1;
        }
    }
    return 0;
}

typedef struct viewer {
    stein_status (*look)(void *watch, stein_sim *sim);
    void *watch;
} viewer;

static void show(void *ctx, stein_sim *sim, int i)
{
    viewer *v = ctx;
    (void)i;
    v->look(v->watch, sim);
}

/* all strokes that are fitted to */
static stein_status run_strokes(void *ctx, stein_status (*look)(void *watch, stein_sim *sim),
                                void *watch, stein_err *err)
{
    diag *d = ctx;
    const fit__problem *p = &d->p;
    fit__bench bench;
    viewer v = {look, watch};
    double *y = malloc(sizeof *y * ((size_t)p->rows + 1));
    stein_status status = fit__bench_make(&bench, p, err);
    if (y == NULL && status == STEIN_OK) {
        status = lab__no_memory(err);
    }
    bench.watch = show;
    bench.watch_ctx = &v;
    for (int s = 0; status == STEIN_OK && s < p->nstroke; s++) {
        status = fit__simulate(p, &bench, s, d->x, y, err);
    }
    bench.watch = NULL;
    fit__bench_free(&bench);
    free(y);
    return status;
}

/* ---- the list ---- */

stein_status diag__list(diag *d, lab_candidate **list, stein_err *err)
{
    size_t size = sizeof(double) * ((size_t)lab_equations(d->model)->np + 1);
    double *p = malloc(size);
    if (p == NULL) {
        return lab__no_memory(err);
    }
    memcpy(p, lab_parameters(d->model), size - sizeof *p);
    for (int i = 0; i < d->naccepted; i++) {
        const int k = d->p.first_accepted + FIT__NUMBERS * i;
        lab_candidate_apply(&d->accepted[i], fit__value(&d->p.unknown[k], d->x[k]), p);
    }
    lab__strokes strokes = {run_strokes, d};
    stein_status status =
        lab__candidates_at(list, &d->n, d->model, p, is_moved(d) ? &strokes : NULL, err);
    free(p);
    int left = 0;
    for (int i = 0; status == STEIN_OK && i < d->n; i++) {
        if (!is_left_out(d, &(*list)[i])) {
            (*list)[left++] = (*list)[i];
        }
    }
    d->n = status == STEIN_OK ? left : 0;
    return status;
}
