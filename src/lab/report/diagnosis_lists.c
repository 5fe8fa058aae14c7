/* SPDX-License-Identifier: GPL-3.0-or-later
 * diagnosis_lists.c - the map of departures, candidates as bars, gains, audit and parameters.
 */
#include <math.h>
#include <string.h>

#include "diagnosis_page.h"

enum { ROWS = 96, SUSPECTS = 12, FIRST = 6, AUDIT = 40 };

/* ---- place by phase ---- */

static int phase_used(const lab_diagnosis *d, int phase)
{
    for (int i = 0; i < d->ndeparture; i++) {
        if (diag__phase_index(d->departure[i].phase) == phase) {
            return 1;
        }
    }
    return 0;
}

const double page__least_z = 2.0; /* of a cell with a colour */

/* colour of a cell, 0 .. 5 */
static int heat(double z)
{
    return !(z >= page__least_z) ? 0 : z < 3.0 ? 1 : z < 4.0 ? 2 : z < 6.0 ? 3 : z < 10.0 ? 4 : 5;
}

/* a normal deviate, to a tenth */
static void write_z(FILE *f, double z)
{
    if (isfinite(z)) {
        fprintf(f, "%.1f", z);
    } else {
        fputs("\xe2\x80\x93", f);
    }
}

static void cell(FILE *f, const lab_departure *r)
{
    fprintf(f, "<td class=\"heat h%d\" title=\"z = ", heat(r->z));
    write_z(f, r->z);
    fprintf(f, ", %d samples\">", r->samples);
    if (r->is_force) {
        page__unit u = page__unit_for(r->unit, r->size);
        page__quantity(f, r->size, r->unit, 2);
        fputs("<small>\xc2\xb1", f);
        page__number(f, r->sd * u.factor, 2);
    } else {
        page__number(f, r->sd > 0.0 ? r->size / r->sd : (double)NAN, 3);
        fputs("<small>", f);
        page__quantity(f, r->size, r->unit, 2);
    }
    fputs(", z ", f);
    write_z(f, r->z);
    fputs("</small></td>", f);
}

static void map_row(FILE *f, const lab_diagnosis *d, const char *place, int is_force)
{
    fputs("<tr><th scope=\"row\">", f);
    page__words(f, place);
    fputs("</th>", f);
    for (int k = 0; k < DIAG_PHASES; k++) {
        const lab_departure *found = NULL;
        for (int i = 0; i < d->ndeparture; i++) {
            const lab_departure *r = &d->departure[i];
            int here = r->is_force == is_force && strcmp(r->place, place) == 0;
            found = here && diag__phase_index(r->phase) == k ? r : found;
        }
        if (found != NULL) {
            cell(f, found);
        } else if (phase_used(d, k)) {
            fputs("<td class=\"heat none\"></td>", f);
        }
    }
    fputs("</tr>\n", f);
}

static void map_half(FILE *f, const lab_diagnosis *d, int is_force, const char *title)
{
    const char *done[ROWS];
    int n = 0;
    for (int i = 0; i < d->ndeparture; i++) {
        const lab_departure *r = &d->departure[i];
        int known = r->is_force != is_force || n == ROWS;
        for (int k = 0; k < n; k++) {
            known |= strcmp(done[k], r->place) == 0;
        }
        if (known) {
            continue;
        }
        if (n == 0) {
            fprintf(f, "<tr class=\"half\"><th colspan=\"%d\">%s</th></tr>\n", DIAG_PHASES + 1,
                    title);
        }
        done[n++] = r->place;
        map_row(f, d, r->place, is_force);
    }
}

void page__map(FILE *f, const lab_diagnosis *d)
{
    if (d->ndeparture == 0) {
        return;
    }
    fputs(
        "<section id=\"map\"><h2>Where and when model and records differ</h2>\n<p>The model before "
        "anything was added. Channels: RMS residual over the noise. Joints: mean missing force. A "
        "strong colour means: neither noise nor scatter between records explains it. z is that "
        "significance in standard deviations.</p>\n<div class=\"scroll\" tabindex=\"0\"><table "
        "class=\"map\">\n<tr>"
        "<td></td>",
        f);
    for (int k = 0; k < DIAG_PHASES; k++) {
        if (phase_used(d, k)) {
            int turns = strcmp(diag__phase[k], "rest") == 0 && phase_used(d, DIAG_PHASES - 1);
            fprintf(f, "<th scope=\"col\">%s</th>",
                    turns ? "rest or turning point" : diag__phase[k]);
        }
    }
    fputs("</tr>\n", f);
    map_half(f, d, 0, "channels: residual over noise");
    map_half(f, d, 1, "joints: missing force");
    fputs("</table></div>\n</section>\n", f);
}

/* ---- candidates ---- */

static double gain_of(const lab_suspect *s)
{
    return s->refitted && isfinite(s->gain) ? s->gain : s->score;
}

static const char *rank_of(const lab_diagnosis *d, int i)
{
    return i < d->ncause               ? "cause"
           : i < d->ncause + d->nrival ? "rival"
           : d->suspect[i].possible    ? "other"
                                       : "impossible";
}

static void suspect_numbers(FILE *f, const lab_suspect *s)
{
    for (int i = page__change(f, s); i < s->nnumber; i++) {
        fputs(i > 0 ? ", " : "", f);
        page__words(f, s->number[i].name);
        fputs(" ", f);
        page__interval(f, s->number[i].value, s->number[i].lo, s->number[i].hi, s->number[i].unit);
    }
    if (s->nnumber > 0 && s->fitted_beside[0] != '\0') {
        fputs("<small>beside ", f);
        page__words(f, s->fitted_beside);
        fputs("</small>", f);
    }
    if (s->nnumber == 0 && s->candidate.effect != NULL && isfinite(s->amount)) {
        page__words(f, lab_candidate_size(&s->candidate));
        fputs(" \xe2\x89\x88 ", f);
        page__quantity(f, s->amount, s->candidate.unit, 2);
    }
}

static void suspect_row(FILE *f, const lab_diagnosis *d, int i, double most)
{
    const lab_suspect *s = &d->suspect[i];
    const char *rank = rank_of(d, i);
    double share = most > 0.0 ? fmax(0.0, fmin(1.0, gain_of(s) / most)) : 0.0;
    fprintf(f, "<tr class=\"%s\"><th scope=\"row\">", rank);
    page__words(f, s->candidate.effect != NULL ? s->candidate.effect->kind : "");
    fputs("<small>", f);
    page__text(f, s->candidate.place);
    fputs("</small></th><td class=\"bar\"><svg viewBox=\"0 0 100 10\" preserveAspectRatio=\"none\" "
          "aria-hidden=\"true\">",
          f);
    fprintf(f, "<rect class=\"%s\" x=\"0\" y=\"1\" width=\"%.1f\" height=\"8\"/></svg></td><td>",
            s->refitted ? "full" : "predicted", fmax(0.4, 100.0 * share));
    page__number(f, gain_of(s), 3);
    fprintf(f, "%s</td><td>", s->refitted ? "" : "<small>predicted</small>");
    suspect_numbers(f, s);
    fputs("</td><td>", f);
    if (i < d->ncause) {
        fputs("the cause", f);
    } else if (i < d->ncause + d->nrival) {
        fputs("cannot be told from it", f);
    } else {
        page__text(f, s->why != NULL ? s->why : s->power.because);
    }
    fputs("</td></tr>\n", f);
}

void page__suspects(FILE *f, const lab_diagnosis *d)
{
    int shown = 0, untestable = 0;
    double most = 0.0;
    for (int i = 0; i < d->nsuspect; i++) {
        int testable = isfinite(gain_of(&d->suspect[i]));
        untestable += !testable;
        most = testable ? fmax(most, gain_of(&d->suspect[i])) : most;
    }
    if (d->nsuspect == 0) {
        return;
    }
    fputs("<section id=\"suspects\"><h2>Candidates</h2>\n<p>How much the misfit (\xe2\x88\x92"
          "2 log likelihood) falls when the effect is added and everything else is refitted, "
          "with variation from record to record. Pale bars are predictions, not refits. An amount "
          "with an interval is from a fit of that candidate, alone or beside those below it.</p>\n"
          "<div class=\"scroll\" tabindex=\"0\"><table class=\"fold "
          "suspects\">\n<tr><td></td><td></td><th>fall"
          "</th><th>amount</th><td></td></tr>\n",
          f);
    for (int i = 0; i < d->nsuspect; i++) {
        int must = i < d->ncause + d->nrival;
        if (isfinite(gain_of(&d->suspect[i])) && (must || shown < SUSPECTS)) {
            suspect_row(f, d, i, most);
            shown++;
        }
    }
    int rest = d->nsuspect - shown - untestable;
    fputs("</table></div>\n<p class=\"quiet\">", f);
    if (rest > 0) {
        fprintf(f, "%d more explain less. ", rest);
    }
    if (untestable > 0) {
        fprintf(f, "%d cannot be tested with these records.", untestable);
    }
    fputs("</p>\n</section>\n", f);
}

/* ---- gains ---- */

/* ratio after/before on a logarithmic scale from 1/8 to 2 */
static double ratio_x(double ratio)
{
    double x = (log2(fmax(ratio, 1e-9)) + 3.0) / 4.0;
    return 100.0 * fmax(0.0, fmin(1.0, x));
}

static void ratio_bar(FILE *f, const lab_gain *g)
{
    fputs("<td class=\"bar\"><svg viewBox=\"0 0 100 10\" preserveAspectRatio=\"none\" "
          "aria-hidden=\"true\"><path class=\"one\" d=\"M75 0V10\"/>",
          f);
    if (isfinite(g->ratio)) {
        double lo = isfinite(g->lo) ? g->lo : g->ratio, hi = isfinite(g->hi) ? g->hi : g->ratio;
        fprintf(f,
                "<rect class=\"span\" x=\"%.1f\" y=\"3.5\" width=\"%.1f\" height=\"3\"/><rect "
                "class=\"full\" x=\"%.1f\" y=\"1\" width=\"1.2\" height=\"8\"/>",
                ratio_x(lo), fmax(0.5, ratio_x(hi) - ratio_x(lo)), ratio_x(g->ratio) - 0.6);
    }
    fputs("</svg></td>", f);
}

static void gain_row(FILE *f, const lab_gain *g)
{
    const double error[] = {g->rmse_before, g->rmse_after, g->noise};
    fputs("<tr><th scope=\"row\">", f);
    page__words(f, g->channel != NULL ? g->channel : "all channels");
    fputs("<small>", f);
    page__text(f, g->phase != NULL ? g->phase : "all phases");
    fputs("</small></th><td>", f);
    for (int i = 0; i < 3; i++) {
        page__error(f, g, error[i]);
        fputs("</td><td>", f);
    }
    page__interval(f, g->ratio, g->lo, g->hi, "1");
    fputs("</td>", f);
    ratio_bar(f, g);
    fputs("</tr>\n", f);
}

/* of whole records, or by phase */
static void gain_rows(FILE *f, const lab_diagnosis *d, int by_phase)
{
    for (int i = 0; i < d->ngain; i++) {
        if ((d->gains[i].phase != NULL) == by_phase) {
            gain_row(f, &d->gains[i]);
        }
    }
}

static int has_phases(const lab_diagnosis *d)
{
    for (int i = 0; i < d->ngain; i++) {
        if (d->gains[i].phase != NULL) {
            return 1;
        }
    }
    return 0;
}

static const char gain_head[] = "<div class=\"scroll\" tabindex=\"0\"><table class=\"fold "
                                "gains\">\n<tr><td></td><th>before</th><th>after</th>"
                                "<th>noise</th><th>after / before</th><td></td></tr>\n";

void page__gains(FILE *f, const lab_diagnosis *d)
{
    if (d->ngain == 0) {
        return;
    }
    fprintf(
        f,
        "<section id=\"gain\"><h2>The gain on records held out</h2>\n<p>Error on %d %s%s "
        "that took no part in the fit%s. The bar is the 95&nbsp;%% interval of the error after, "
        "as a share of that before, from one eighth to twice; left of the line is better."
        "</p>\n%s",
        d->nheld, diag__record_word(d), d->nheld == 1 ? "" : "s",
        !d->in_pieces   ? ""
        : d->nfile == 1 ? "; the record itself did"
                        : "; the same records did, in other pieces",
        gain_head);
    gain_row(f, &d->gain);
    gain_rows(f, d, 0);
    fputs("</table></div>\n", f);
    if (has_phases(d)) {
        fprintf(f, "<details><summary>by phase</summary>\n%s", gain_head);
        gain_rows(f, d, 1);
        fputs("</table></div></details>\n", f);
    }
    fputs("</section>\n", f);
}

/* ---- audit, parameters ---- */

static void findings(FILE *f, const lab_diagnosis *d, int from, int to)
{
    fputs("<ul>\n", f);
    for (int i = from; i < d->nfinding && i < to; i++) {
        fputs("<li>", f);
        page__text(f, d->finding[i]);
        fputs("</li>\n", f);
    }
    fputs("</ul>\n", f);
}

void page__audit(FILE *f, const lab_diagnosis *d)
{
    fputs("<section id=\"audit\"><h2>The data</h2>\n", f);
    if (d->nfinding == 0) {
        fputs("<p>The audit found nothing in the files that limits the fit.</p>\n", f);
    } else {
        findings(f, d, 0, FIRST);
        if (d->nfinding > FIRST) {
            fprintf(f, "<details><summary>%d more</summary>\n", d->nfinding - FIRST);
            findings(f, d, FIRST, AUDIT);
            if (d->nfinding > AUDIT) {
                fprintf(f, "<p class=\"quiet\">and %d more.</p>\n", d->nfinding - AUDIT);
            }
            fputs("</details>\n", f);
        }
    }
    fputs("</section>\n", f);
}

/* the change that a cause makes of a number, beside the refit; NULL: none does */
static const lab_change *change_of(const lab_diagnosis *d, const char *name)
{
    for (int i = 0; i < d->ncause && i < d->nsuspect; i++) {
        for (int k = 0; k < d->suspect[i].nchange; k++) {
            if (strcmp(d->suspect[i].change[k].name, name) == 0) {
                return &d->suspect[i].change[k];
            }
        }
    }
    return NULL;
}

static void parameter_row(FILE *f, const lab_diagnosis *d, const lab_fit_value *v)
{
    const lab_change *c = change_of(d, v->name);
    fputs("<tr><th scope=\"row\">", f);
    page__text(f, v->name);
    fputs("</th><td>", f);
    page__quantity(f, v->start, v->unit, 5);
    fputs("</td><td>", f);
    page__interval(f, c != NULL ? c->to : v->value, c != NULL ? c->lo : v->lo,
                   c != NULL ? c->hi : v->hi, v->unit);
    fputs("</td><td>", f);
    if (c != NULL) {
        fputs("by the cause; without it ", f);
        page__quantity(f, v->value, v->unit, 4);
    } else if (v->unseen) {
        fputs("not seen by these records", f);
    } else if (isfinite(v->prior_sd) && v->prior_sd > 0.0) {
        double off = (v->value - v->start) / v->prior_sd;
        page__number(f, off, 2);
        fputs(" sd of the file", f);
    }
    fputs("</td></tr>\n", f);
}

void page__parameters(FILE *f, const lab_diagnosis *d)
{
    static const char *const what[] = {"joint friction", "contact friction", "drive"};
    if (d->nvalue > 0) {
        fputs("<section id=\"parameters\"><h2>Refitted numbers</h2>\n<div class=\"scroll\" "
              "tabindex=\"0\"><table "
              "class=\"fold numbers\">"
              "\n<tr><td></td><th>file</th><th>fitted, 95&nbsp;%</th><th>moved</th></tr>\n",
              f);
        for (int i = 0; i < d->nvalue; i++) {
            parameter_row(f, d, &d->value[i]);
        }
        fputs("</table></div>\n", f);
        fputs("<p class=\"quiet\">From record to record:", f);
        for (int i = 0; i < 3; i++) {
            fprintf(f, "%s %s ", i > 0 ? "," : "", what[i]);
            page__number(f, 100.0 * d->scatter[i], 2);
            fputs("&nbsp;%", f);
        }
        fputs(".</p>\n</section>\n", f);
    }
}
