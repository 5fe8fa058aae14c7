/* SPDX-License-Identifier: GPL-3.0-or-later
 * testable.c - what no fit of these strokes could tell of a candidate, and why: what it moves was
 * not measured or not used, or somebody knows already.
 */
#include <string.h>

#include "searching.h"
#include "structure.h"

static int measures(const diag *d, int channel)
{
    for (int s = 0; s < d->p.nstroke; s++) {
        for (int c = 0; c < d->p.stroke[s].nch; c++) {
            if (d->p.stroke[s].channel[c] == channel) {
                return 1;
            }
        }
    }
    return 0;
}

static int has_input(const diag *d, const char *name)
{
    const stein_model *m = lab_equations(d->model);
    for (int s = 0; s < d->p.nstroke; s++) {
        for (int k = 0; k < d->p.stroke[s].nsignal; k++) {
            if (strcmp(m->inputs[d->p.stroke[s].signal[k].input].name, name) == 0) {
                return 1;
            }
        }
    }
    return 0;
}

/* has somebody looked at all its numbers by themselves, for every stroke? */
static int is_known(const diag *d, const lab_candidate *c)
{
    int known = c->effect->needs == NULL && c->nparam > 0;
    for (int k = 0; known && k < c->nparam; k++) {
        known = fit__always_known(d->fit_data, c->param[k]);
    }
    return known;
}

/* has nobody played with the part that it supposes? */
static int was_off(const diag *d, const lab_candidate *c)
{
    char name[LAB_NUMBERS][LAB_PLACE];
    int n = 0;
    lab__structure_names(c, name);
    while (n < d->fit_data->n && lab_data_without(d->fit_data->stroke[n], name[0])) {
        n++;
    }
    return n > 0 && n == d->fit_data->n;
}

const char *diag__untestable(const diag *d, const lab_candidate *c)
{
    if (c->channel >= 0 && !measures(d, c->channel)) {
        return "the channel was not measured";
    }
    if (c->effect->site == LAB_AT_INPUT && !has_input(d, c->place)) {
        return "the input was not used";
    }
    if (is_known(d, c)) {
        return "every stroke states it";
    }
    if (was_off(d, c)) {
        return "every stroke was played without it";
    }
    if (strcmp(c->effect->kind, "sensor_offset") == 0) {
        return "the offset of the marker, fitted anyhow, says the same";
    }
    for (int i = 0; i < d->def->nfree; i++) {
        if (c->effect->site == LAB_AT_PARAMETER && strcmp(d->def->free[i], c->place) == 0) {
            return "it is refitted anyhow";
        }
    }
    for (int i = 0; i < d->naccepted; i++) {
        if (diag__is_same(&d->accepted[i], c)) {
            return "it was found already";
        }
    }
    return NULL;
}
