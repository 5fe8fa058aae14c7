/* SPDX-License-Identifier: GPL-3.0-or-later
 * diagnosis_summary.c - the first screen of report.html: verdict, contradictions, size, error in
 * the channels' units, rivals, the remaining residual, the check by forces, the next step.
 */
#include <math.h>
#include <string.h>

#include "diagnosis_page.h"

static int has_cause(const lab_diagnosis *d)
{
    return d->ncause > 0 && d->nsuspect > 0;
}

static int has_law(const lab_diagnosis *d)
{
    return d->nlaw > 0 && d->law[0].pays;
}

/* ---- the first screen ---- */

/* the causes of one kind of verdict, where they are `mixed`; else all */
static void causes_of(FILE *f, const lab_diagnosis *d, lab_verdict v, int mixed)
{
    int n = 0, k = 0;
    for (int i = 0; i < d->ncause && i < d->nsuspect; i++) {
        n += !mixed || diag__verdict_of(&d->suspect[i]) == v;
    }
    for (int i = 0; i < d->ncause && i < d->nsuspect; i++) {
        if (!mixed || diag__verdict_of(&d->suspect[i]) == v) {
            fputs(k == 0 ? "" : k + 1 < n ? ", " : " and ", f);
            page__cause(f, &d->suspect[i].candidate);
            k++;
        }
    }
}

static void headline(FILE *f, const lab_diagnosis *d)
{
    static const char *const begin[] = {
        "The model explains these records",
        "A number of the file is wrong",
        "An instrument has an error",
        "The input differs from what the records state",
        "The model lacks an effect",
        "Records and model differ, and no effect of the table explains it",
        "No fit converged: no verdict",
        "The model is far from these records with every candidate"};
    int said[sizeof begin / sizeof *begin] = {0}, n = 0, mixed = 0;
    if (d->slip[0] != '\0') {
        page__text(f, d->slip);
        return;
    }
    for (int i = 1; i < d->ncause && i < d->nsuspect; i++) {
        mixed |= diag__verdict_of(&d->suspect[i]) != diag__verdict_of(&d->suspect[0]);
    }
    for (int i = 0; i < d->ncause && i < d->nsuspect; i++) {
        lab_verdict v = mixed ? diag__verdict_of(&d->suspect[i]) : d->verdict;
        if (!said[v]) {
            fprintf(f, "%s%s: ", n++ > 0 ? ". " : "", begin[v]);
            causes_of(f, d, v, mixed);
            said[v] = 1;
        }
    }
    fputs(n > 0 ? "" : begin[d->verdict], f);
}

static void card(FILE *f, const char *title)
{
    fprintf(f, "<div class=\"card\"><h2>%s</h2>\n", title);
}

/* one of several causes, and the error of the others without it */
static void cause_line(FILE *f, const lab_suspect *s)
{
    fputs("<p>", f);
    page__cause(f, &s->candidate);
    if (isfinite(s->own_ratio)) {
        fputs(" <small>with it the error on held-out records is ", f);
        page__number(f, s->own_ratio, 2);
        fputs(" times that without it</small>", f);
    }
    fputs("</p>\n", f);
}

static void law_of(FILE *f, const lab_diagnosis *d, const lab_candidate *c)
{
    const lab_effect *e = c->effect;
    fputs("<p class=\"quiet\">", f);
    page__text(f, lab_candidate_equation(c));
    fputs("<br>usual signs: ", f);
    page__text(f, e->looks);
    if (d->phase != NULL) {
        fputs("<br>shows most in: ", f);
        page__text(f, d->phase);
    }
    fputs("</p>\n", f);
}

/* How sure the cause itself is, apart from its size. */
static void certainty(FILE *f, const lab_diagnosis *d, const lab_suspect *s)
{
    if (!s->refitted || !isfinite(s->gain)) {
        return;
    }
    fputs("<p class=\"quiet\">How sure it is: the misfit falls by ", f);
    page__number(f, s->gain, 3);
    fprintf(f, " with it, and %.0f is enough to name any cause. %s</p>\n", diag__enough(),
            d->nrival > 0 ? "The size holds only if it is this one and none of those beside."
                          : "The size holds if it is this one.");
}

static void chance(FILE *f, double p)
{
    if (isfinite(p)) {
        fputs("<p class=\"quiet\">chance of such a score without the effect: ", f);
        page__number(f, p, 2);
        fputs("</p>\n", f);
    }
}

static void size_card(FILE *f, const lab_diagnosis *d)
{
    card(f, d->ncause > 1 ? "How large they are, with 95 % interval"
                          : "How large it is, with 95 % interval");
    for (int i = 0; i < d->ncause && i < d->nsuspect; i++) {
        const lab_suspect *s = &d->suspect[i];
        if (d->ncause > 1) {
            cause_line(f, s);
        }
        if (s->nchange > 0) {
            fputs("<p class=\"big\">", f);
            page__change(f, s);
            fputs("</p>\n", f);
        }
        for (int k = s->nchange > 0; k < s->nnumber; k++) {
            const lab_cause_number *n = &s->number[k];
            fputs(k == 0 ? "<p class=\"big\">" : "<p>", f);
            page__words(f, n->name);
            fputs(" = ", f);
            page__interval(f, n->value, n->lo, n->hi, n->unit);
            fputs("</p>\n", f);
        }
        if (s->candidate.effect != NULL) {
            law_of(f, d, &s->candidate);
        }
        certainty(f, d, s);
    }
    chance(f, d->p);
    fputs("</div>\n", f);
}

static void rivals_card(FILE *f, const lab_diagnosis *d)
{
    card(f, "What else it could be");
    for (int i = 0; i < d->ncause && i < d->nsuspect; i++) {
        const lab_candidate *c = &d->suspect[i].candidate;
        if (c->effect != NULL && c->alias[0] != '\0') {
            fputs("<p>A wrong ", f);
            page__text(f, c->alias);
            fputs(" of the file acts in exactly the same way as ", f);
            page__cause(f, c);
            fputs(": no record of these outputs separates them. Measure that number.</p>\n", f);
        }
    }
    if (d->nrival == 0) {
        fputs("<p>No other effect of the table explains the records as well.</p>"
              "</div>\n",
              f);
        return;
    }
    fputs("<p>These records cannot separate it from</p><ul>", f);
    for (int i = d->ncause; i < d->ncause + d->nrival && i < d->nsuspect; i++) {
        fputs("<li>", f);
        page__cause(f, &d->suspect[i].candidate);
        fputs(" <small>", f);
        page__number(f, 100.0 * d->suspect[i].likeness, 2);
        fputs("&nbsp;% alike</small></li>", f);
    }
    fputs("</ul></div>\n", f);
}

/* error before and after as bars, and the floor that noise alone leaves */
static void gain_bars(FILE *f, const lab_diagnosis *d)
{
    const lab_gain *g = &d->gain;
    double most = 1.12 * fmax(d->noise_floor, fmax(g->rmse_before, g->rmse_after));
    double scale = isfinite(most) && most > 0.0 ? 236.0 / most : 0.0;
    page__svg_open(f, 300, 62, "error on held-out records before and after, and the noise floor");
    fprintf(
        f,
        "<text class=\"begin\" x=\"0\" y=\"16\">before</text><rect fill=\"var(--rust)\" x=\"46\" "
        "y=\"6\" width=\"%.1f\" height=\"13\" rx=\"2\"/>",
        isfinite(g->rmse_before) ? scale * g->rmse_before : 0.0);
    fprintf(
        f,
        "<text class=\"begin\" x=\"0\" y=\"36\">after</text><rect fill=\"var(--blue)\" x=\"46\" "
        "y=\"26\" width=\"%.1f\" height=\"13\" rx=\"2\"/>",
        isfinite(g->rmse_after) ? scale * g->rmse_after : 0.0);
    double floor_x = 46.0 + scale * (isfinite(d->noise_floor) ? d->noise_floor : 0.0);
    fprintf(f,
            "<path class=\"zero\" stroke-dasharray=\"3 2\" d=\"M%.1f 0V46\"/><text x=\"%.1f\" "
            "y=\"58\">noise</text>",
            floor_x, floor_x);
    page__svg_close(f);
}

static void before_after(FILE *f, const lab_gain *g, int after, double factor, const char *unit)
{
    page__number(f, factor * g->rmse_before, 3);
    if (after && isfinite(g->rmse_after)) {
        fputs(" \xe2\x86\x92 ", f);
        page__number(f, factor * g->rmse_after, 3);
    }
    fputs("&nbsp;", f);
    page__unit_name(f, unit);
}

/* one channel, in the unit of the records and of SI */
static void gain_line(FILE *f, const lab_gain *g, int after)
{
    page__unit u = page__unit_for(g->unit, g->rmse_before);
    fputs("<p class=\"big\"><small>", f);
    page__words(f, g->channel);
    fputs("</small> ", f);
    if (g->written[0] != '\0') {
        before_after(f, g, after, g->per_unit, g->written);
        fputs(" <small>", f);
        before_after(f, g, after, u.factor, u.name);
        fputs("</small></p>\n", f);
        return;
    }
    before_after(f, g, after, u.factor, u.name);
    fputs("</p>\n", f);
}

static void gain_card(FILE *f, const lab_diagnosis *d)
{
    const lab_gain *g = &d->gain;
    int after = has_cause(d) || has_law(d);
    card(f, after ? "Error on records held out, before and after" : "Error on records held out");
    if (!isfinite(g->rmse_before)) {
        fprintf(f, "<p>not measured%s</p></div>\n", d->nheld > 0 ? "" : ": no record was held out");
        return;
    }
    for (int i = 0; i < d->ngain; i++) {
        if (d->gains[i].channel != NULL && d->gains[i].phase == NULL) {
            gain_line(f, &d->gains[i], after);
        }
    }
    fputs("<p>all channels ", f);
    page__number(f, g->rmse_before, 3);
    if (after && isfinite(g->rmse_after)) {
        fputs(" \xe2\x86\x92 ", f);
        page__number(f, g->rmse_after, 3);
    }
    fputs(" times the noise</p>\n", f);
    if (after) {
        fputs("<p>error after, as a share of that before: ", f);
        page__interval(f, g->ratio, g->lo, g->hi, "1");
        fputs("</p>\n", f);
        gain_bars(f, d);
    } else {
        fputs("<p>noise alone would leave ", f);
        page__number(f, d->noise_floor, 3);
        fputs("</p>\n", f);
    }
    fputs("</div>\n", f);
}

static const char *advice(const lab_diagnosis *d)
{
    switch (d->verdict) {
    case LAB_VERDICT_EXPLAINED:
        return "Use the model without changes. Effects smaller than the noise and scatter of these "
               "records may still be missing.";
    case LAB_VERDICT_NOT_CONVERGED:
        return "Check the data and the starting numbers below first. No statement about physics "
               "is possible before a fit converges.";
    case LAB_VERDICT_UNKNOWN_EFFECT:
        if (has_law(d)) {
            return "Use extended.yaml: it has the law below as a table. A physical explanation "
                   "must "
                   "have this shape.";
        }
        return "Look where the map below is darkest, and at the missing force there. A new effect "
               "must explain its course over time.";
    case LAB_VERDICT_UNUSABLE_MODEL:
        if (d->slip[0] != '\0') {
            return has_cause(d)
                       ? "Correct the sign in the records or in the file and diagnose again; "
                         "extended.yaml reads these records as they are. Nothing has been "
                         "fitted yet."
                       : "Correct this in the records, their titles or the file, and "
                         "diagnose again. Nothing has been fitted yet.";
        }
        return "Compare signs, units, planes, the start and the clock of the first record with the "
               "mechanism file. No statement about physics is possible before they agree.";
    default: break;
    }
    if (d->nrival > 0) {
        return "Use extended.yaml for predictions like these records. Before you act on this "
               "cause, "
               "make a record in which the candidates differ.";
    }
    return d->verdict == LAB_VERDICT_SENSOR
               ? "Check the instrument; extended.yaml corrects for it until then."
           : d->verdict == LAB_VERDICT_INPUT
               ? "Check how the input was recorded; extended.yaml corrects for it until then."
               : "Use extended.yaml: it has the cause and the refitted numbers, and replaces "
                 "the old file.";
}

static void next_card(FILE *f, const lab_diagnosis *d)
{
    card(f, "What to do next");
    fprintf(f, "<p>%s</p>", advice(d));
    if (d->next != NULL) {
        fputs("<p>Best of the experiments tried: <b>", f);
        page__text(f, d->next->name);
        fputs("</b> against ", f);
        page__cause(f, &d->suspect[d->next->against].candidate);
        if (d->next->ncheck > 0) {
            fputs("; ", f);
            page__text(f, d->next->why);
            fputs(".", f);
        } else if (d->next->repeats > 0) {
            fprintf(f, "; %d record%s will do.", d->next->repeats,
                    d->next->repeats == 1 ? "" : "s");
        } else {
            fputs("; even so it takes very many records.", f);
        }
        fputs(" <code>stein plan</code> has the list and writes the record.</p>", f);
    }
    fputs("</div>\n", f);
}

static void hottest_card(FILE *f, const lab_diagnosis *d)
{
    const lab_departure *hot = NULL;
    for (int i = 0; i < d->ndeparture; i++) {
        const lab_departure *r = &d->departure[i];
        hot = isfinite(r->z) && (hot == NULL || r->z > hot->z) ? r : hot;
    }
    card(f, "Largest departure");
    if (hot == NULL) {
        fputs("<p>none was measured</p></div>\n", f);
        return;
    }
    fputs("<p class=\"big\">", f);
    page__words(f, hot->place);
    fputs(", ", f);
    page__text(f, hot->phase);
    fputs("</p>\n<p>", f);
    page__quantity(f, hot->size, hot->unit, 2);
    fputs(hot->is_force ? " of force missing, z " : " RMS, z ", f);
    page__number(f, hot->z, 2);
    fputs("</p></div>\n", f);
}

static void suspect_card(FILE *f, const lab_diagnosis *d)
{
    if (d->nsuspect == 0) {
        return;
    }
    card(f, "Best candidate");
    fputs("<p class=\"big\">", f);
    page__cause(f, &d->suspect[0].candidate);
    fputs("</p>\n", f);
    chance(f, d->p);
    fputs("</div>\n", f);
}

/* residual of the best model, and effects that may exist without being named */
static void remains_card(FILE *f, const lab_diagnosis *d)
{
    int weak = diag__count(d, LAB_WEAK), unseen = diag__count(d, LAB_NOT_TESTABLE);
    card(f, "What remains unexplained");
    if (isfinite(d->chi2_dof_before)) {
        fputs("<p class=\"big\">", f);
        page__number(f, d->chi2_dof_before, 3);
        if (has_cause(d) || has_law(d)) {
            fputs(" \xe2\x86\x92 ", f);
            page__number(f, d->chi2_dof_after, 3);
        }
        fputs("</p>\n<p>\xcf\x87\xc2\xb2 per degree of freedom of the fit; 1 is noise alone</p>\n",
              f);
    }
    if (weak + unseen > 0) {
        fprintf(
            f,
            "<p class=\"quiet\">Of %d candidates, <a href=\"#seen\">plausible but weak: %d, not "
            "testable with these records: %d</a>.</p>\n",
            d->nsuspect, weak, unseen);
    }
    fprintf(f, "<p class=\"quiet\">%d samples of %d %s%s</p></div>\n", d->samples, d->nfit,
            diag__record_word(d), d->nfit == 1 ? "" : "s");
}

static void forces_card(FILE *f, const lab_motion *m)
{
    static const char *const says[] = {"not checked", "supports it", "contradicts it",
                                       "cannot tell"};
    if (m->why[0] == '\0') {
        return;
    }
    fprintf(f, "<div class=\"card%s\"><h2>Check by forces</h2>\n<p class=\"big\">%s</p><p>",
            m->says == LAB_MOTION_CONTRADICTS ? " warning" : "", says[m->says]);
    page__text(f, m->why);
    fputs("</p></div>\n", f);
}

/* ---- contradictions of the verdict ---- */

/* one more entry of a list that is there only when it has one */
static void item(FILE *f, int *n)
{
    fputs((*n)++ == 0 ? "<ul class=\"against\">\n<li>" : "</li>\n<li>", f);
}

static void against_forces(FILE *f, const lab_diagnosis *d, int *n)
{
    if (d->motion.says == LAB_MOTION_CONTRADICTS) {
        item(f, n);
        fputs("The forces contradict it: ", f);
        page__text(f, d->motion.why);
        putc('.', f);
    }
    if (d->verified.done && !d->verified.same) {
        item(f, n);
        fputs("extended.yaml, run from the file, leaves ", f);
        page__number(f, d->verified.file, 3);
        fputs(" noises where its fit left ", f);
        page__number(f, d->verified.table, 3);
        putc('.', f);
    }
}

static void against_gain(FILE *f, const lab_diagnosis *d, int *n)
{
    int worse = 0, judged = 0;
    for (int i = 0; i < d->nrecord; i++) {
        judged += d->record[i].reporting;
        worse += d->record[i].reporting && d->record[i].after > d->record[i].before;
    }
    if (d->gain.hi >= 1.0) {
        item(f, n);
        fputs("The gain on records held out is not certain: after over before may be ", f);
        page__number(f, d->gain.hi, 3);
        putc('.', f);
    }
    if (worse > 0) {
        item(f, n);
        fprintf(f, "In %d of %d %ss held out the error grows.", worse, judged,
                diag__record_word(d));
    }
}

static void against(FILE *f, const lab_diagnosis *d)
{
    int n = 0;
    against_forces(f, d, &n);
    if (has_cause(d) && d->slip[0] == '\0') {
        against_gain(f, d, &n);
    }
    if (has_cause(d) && d->nrival > 0) {
        item(f, &n);
        fprintf(f, "%s explain%s the records as well; \"What else it could be\" names %s.",
                d->nrival == 1 ? "Another effect" : "Other effects", d->nrival == 1 ? "s" : "",
                d->nrival == 1 ? "it" : "them");
    }
    if (d->nsetting_off > 0) {
        item(f, &n);
        fprintf(f, "It needs %d setting%s other than the records state.", d->nsetting_off,
                d->nsetting_off == 1 ? "" : "s");
    }
    fputs(n > 0 ? "</li>\n</ul>\n" : "", f);
}

/* ---- all of it ---- */

void page__summary(FILE *f, const lab_diagnosis *d)
{
    int explained = d->verdict == LAB_VERDICT_EXPLAINED;
    char counts[DIAG_COUNTS];
    fprintf(f, "<header><p class=\"eyebrow\">Diagnosis \xc2\xb7 %s \xc2\xb7 %s</p>\n<h1>",
            diag__verdict_words(d->verdict), diag__counts(counts, d));
    headline(f, d);
    fputs("</h1>\n<p class=\"reason\">", f);
    page__text(f, d->reason);
    fputs("</p>\n", f);
    against(f, d);
    fputs("<div class=\"story\">\n", f);
    if (d->slip[0] != '\0') { // nothing was fitted
        if (has_cause(d)) {
            size_card(f, d);
        }
        next_card(f, d);
        fputs("</div></header>\n", f);
        return;
    }
    if (has_cause(d)) {
        size_card(f, d);
        gain_card(f, d);
        rivals_card(f, d);
    } else {
        gain_card(f, d);
        if (!explained) {
            hottest_card(f, d);
            suspect_card(f, d);
        }
    }
    remains_card(f, d);
    forces_card(f, &d->motion);
    next_card(f, d);
    fputs("</div></header>\n", f);
}
