/* SPDX-License-Identifier: GPL-3.0-or-later
 * story.c - a diagnosis in a terminal: one line a question. The report has the rest.
 */
#include <math.h>
#include <string.h>

#include "cli.h"

enum { RIVALS = 4 };

/* "  0.12 N m (0.11 .. 0.13)" for each number, on one line */
static void put_cause(const lab_suspect *s)
{
    const lab_candidate *c = &s->candidate;
    char value[CLI_TEXT], lo[CLI_TEXT], hi[CLI_TEXT], scope[LAB_PLACE];
    printf("cause: %s at %s%s", c->effect->kind, c->place, lab_candidate_scope(c, scope));
    for (int i = 0; i < s->nnumber; i++) {
        const lab_cause_number *n = &s->number[i];
        printf("%s %s = %s", i == 0 ? ":" : ",", n->name, cli_quantity(value, n->value, n->unit));
        if (isfinite(n->lo) && isfinite(n->hi)) {
            printf(" (95 %%: %s to %s)", cli_quantity(lo, n->lo, n->unit),
                   cli_quantity(hi, n->hi, n->unit));
        }
    }
    printf("\n");
}

static void put_rivals(const lab_diagnosis *d)
{
    for (int i = 0; i < d->nrival && i < RIVALS; i++) {
        const lab_candidate *c = &d->suspect[d->ncause + i].candidate;
        char scope[LAB_PLACE];
        printf("%s%s at %s%s", i == 0 ? "the data cannot tell it from: " : ", ", c->effect->kind,
               c->place, lab_candidate_scope(c, scope));
    }
    if (d->nrival > RIVALS) {
        printf(", %d more", d->nrival - RIVALS);
    }
    if (d->nrival > 0) {
        printf("\n");
    }
}

static void put_law(const lab_law *l)
{
    char lo[CLI_TEXT], hi[CLI_TEXT];
    double least = INFINITY, most = -INFINITY;
    for (int k = 0; k < l->n; k++) {
        least = fmin(least, l->value[k]);
        most = fmax(most, l->value[k]);
    }
    printf("law: %s at %s over its %s, %s to %s, table %s of %d points\n", l->what, l->place, l->of,
           cli_quantity(lo, least, l->unit), cli_quantity(hi, most, l->unit), l->table, l->n);
}

/* the strongest departure of the file as it is, when nothing explains it */
static void put_departure(const lab_diagnosis *d)
{
    const lab_departure *worst = NULL;
    for (int i = 0; i < d->ndeparture; i++) {
        const lab_departure *w = &d->departure[i];
        worst = worst == NULL || fabs(w->z) > fabs(worst->z) ? w : worst;
    }
    if (worst != NULL) {
        char size[CLI_TEXT];
        printf("the file as it is departs most at %s, %s: %s %s (z = %.1f)\n", worst->place,
               worst->phase, worst->is_force ? "missing" : "off by",
               cli_quantity(size, worst->size, worst->unit), worst->z);
    }
}

static void put_error(const lab_diagnosis *d)
{
    const lab_gain *g = &d->gain;
    int extends = lab_diagnosis_extends(d);
    if (!isfinite(g->rmse_before) || d->nheld == 0) {
        return;
    }
    printf("held-out error: %.3g", g->rmse_before);
    if (extends && isfinite(g->ratio)) {
        printf(" -> %.3g noise, ratio %.3g (95 %%: %.3g to %.3g)", g->rmse_after, g->ratio, g->lo,
               g->hi);
    } else {
        printf(" noise");
    }
    printf("; noise alone leaves %.3g\n", d->noise_floor);
}

void cli_story(const char *model, const lab_diagnosis *d)
{
    int has_law = d->nlaw > 0 && d->law->pays;
    printf("%s: %s (%d records fitted, %d held out, %d samples, %.3g s)\n", model,
           lab_verdict_text(d->verdict), d->nfit, d->nheld, d->samples, d->seconds);
    if (d->reason[0] != '\0') {
        lab__put_line(stdout, d->reason);
    }
    for (int i = 0; i < d->ncause; i++) {
        put_cause(&d->suspect[i]);
    }
    if (d->ncause > 0) {
        put_rivals(d);
    }
    if (has_law) {
        put_law(d->law);
    } else if (d->ncause == 0 && d->verdict != LAB_VERDICT_EXPLAINED) {
        put_departure(d);
    }
    put_error(d);
    if (d->motion.says != LAB_MOTION_NOT_DONE) {
        printf("motion-driven check: %s: %s\n", lab_motion_text(d->motion.says), d->motion.why);
    }
}
