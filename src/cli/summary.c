/* SPDX-License-Identifier: GPL-3.0-or-later
 * summary.c - a diagnosis in a terminal: one line a question. The report has the rest.
 */
#include <math.h>
#include <string.h>

#include "cli.h"
#include "diagnosis_page.h"

enum { RIVALS = 4 };

/* value and interval in one unit that suits them, to three digits */
static void put_number(const lab_cause_number *n)
{
    page__unit u = page__unit_for(n->unit, n->value);
    printf("%s = %.3g", n->name, u.factor * n->value);
    if (isfinite(n->lo) && isfinite(n->hi)) {
        printf(" (95 %%: %.3g to %.3g)", u.factor * n->lo, u.factor * n->hi);
    }
    printf("%s%s", *u.name != '\0' ? " " : "", u.name);
}

static void put_cause(const lab_suspect *s)
{
    const lab_candidate *c = &s->candidate;
    char scope[LAB_PLACE];
    printf("cause: %s at %s%s", c->effect->kind, c->place, lab_candidate_scope(c, scope));
    char change[LAB_CHANGE_TEXT];
    int changed = *lab_change_text(s, change) != '\0';
    if (changed) {
        printf(": %s", change);
    }
    for (int i = changed; i < s->nnumber; i++) {
        printf("%s ", i == 0 ? ":" : ",");
        put_number(&s->number[i]);
    }
    printf("\n");
}

static void put_rivals(const lab_diagnosis *d)
{
    for (int i = 0; i < d->nrival && i < RIVALS; i++) {
        const lab_candidate *c = &d->suspect[d->ncause + i].candidate;
        char scope[LAB_PLACE];
        printf("%s%s at %s%s", i == 0 ? "the data cannot separate it from: " : ", ",
               c->effect->kind, c->place, lab_candidate_scope(c, scope));
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
    double least = INFINITY, most = -INFINITY;
    for (int k = 0; k < l->n; k++) {
        least = fmin(least, l->value[k]);
        most = fmax(most, l->value[k]);
    }
    page__unit u = page__unit_for(l->unit, fmax(fabs(least), fabs(most)));
    printf("law: %s at %s over its %s, %.3g to %.3g %s, table %s of %d points\n", l->what, l->place,
           l->of, u.factor * least, u.factor * most, u.name, l->table, l->n);
}

/* the most significant departure of the file, if nothing explains it */
static void put_departure(const lab_diagnosis *d)
{
    const lab_departure *worst = NULL;
    for (int i = 0; i < d->ndeparture; i++) {
        const lab_departure *w = &d->departure[i];
        worst = worst == NULL || fabs(w->z) > fabs(worst->z) ? w : worst;
    }
    if (worst != NULL) {
        char size[CLI_TEXT];
        printf("largest departure of the file at %s, %s: %s %s (z = %.1f)\n", worst->place,
               worst->phase, worst->is_force ? "missing" : "off by",
               cli_quantity(size, worst->size, worst->unit), worst->z);
    }
}

static void before_after(const lab_gain *g, int after, double factor, const char *unit)
{
    printf("%.3g", factor * g->rmse_before);
    if (after) {
        printf(" -> %.3g", factor * g->rmse_after);
    }
    printf("%s%s", *unit != '\0' ? " " : "", unit);
}

/* of each channel in the unit of the records and of SI, of all in noises */
static void put_error(const lab_diagnosis *d)
{
    const lab_gain *g = &d->gain;
    int after = lab_diagnosis_extends(d) && isfinite(g->ratio);
    if (!isfinite(g->rmse_before) || d->nheld == 0) {
        return;
    }
    printf("held-out error: ");
    for (int i = 0; i < d->ngain; i++) {
        const lab_gain *c = &d->gains[i];
        if (c->channel == NULL || c->phase != NULL) {
            continue;
        }
        page__unit u = page__unit_for(c->unit, c->rmse_before);
        int written = c->written[0] != '\0';
        printf("%s ", c->channel);
        if (written) {
            before_after(c, after, c->per_unit, c->written);
        }
        printf("%s", written ? " (" : "");
        before_after(c, after, u.factor, u.name);
        printf("%s, ", written ? ")" : "");
    }
    before_after(g, after, 1.0, "noise");
    printf(" (noise alone leaves %.3g)\n", d->noise_floor);
}

void cli_summary(const char *model, const lab_diagnosis *d)
{
    int has_law = d->nlaw > 0 && d->law->pays;
    char counts[DIAG_COUNTS];
    printf("%s: %s (%s", model, lab_verdict_text(d->verdict), diag__counts(counts, d));
    if (d->slip[0] == '\0') {
        printf(", %d samples", d->samples);
    }
    printf(", %.3g s)\n", d->seconds);
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
