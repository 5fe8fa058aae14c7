/* SPDX-License-Identifier: GPL-3.0-or-later
 * diagnosis_page.c - report.html: one file without network, scripts or fonts of its own.
 *
 * The first screen is the whole story: verdict, place, phase, size, rivals, gain, what to do next.
 * The rest is detail.
 */
#include <math.h>
#include <string.h>

#include "diagnosis_page.h"

static const char *const style[] = {
    ":root{color-scheme:light dark;--paper:#fbfaf7;--card:#fff;--ink:#23241f;--quiet:#6d6a60;"
    "--line:#e2ded2;--grid:#efece3;--blue:#1f4e79;--rust:#b5482f;--dot:#9b988c;--area:#e9ecdf;"
    "--band:#d5dfe9;--phase:#f5f3ec;--h1:#f6e6cf;--h2:#f1cda6;--h3:#e6a57a;--h4:#d27554;--h5:#"
    "b5482f;--hot:#fff}\n",
    "@media(prefers-color-scheme:dark){:root{--paper:#16181a;--card:#1d2023;--ink:#e4e1d8;"
    "--quiet:#9a978c;--line:#33373b;--grid:#282c2f;--blue:#7fb2e0;--rust:#e58a6c;--dot:#77756c;"
    "--area:#2b3128;--band:#26394a;--phase:#212528;--h1:#3a3025;--h2:#553a26;--h3:#7a4a2c;"
    "--h4:#a55a38;--h5:#cf6f4d;--hot:#fff}}\n",
    "*{box-sizing:border-box}html{-webkit-text-size-adjust:100%}\n"
    "body{margin:0;background:var(--paper);color:var(--ink);font:17px/1.55 Georgia,'Times New "
    "Roman',serif}\n"
    "main{max-width:1160px;margin:0 auto;padding:2.2rem 1.2rem 4rem}\n"
    ".eyebrow,.quiet,figcaption,.legend,small,dt,.tag{font-family:Helvetica,Arial,sans-serif}\n"
    ".eyebrow{color:var(--quiet);font-size:.8rem;letter-spacing:.02em;margin:0 0 .5rem}\n"
    "h1{font-size:clamp(1.55rem,4.4vw,2.35rem);line-height:1.2;font-weight:normal;margin:0 0 "
    ".7rem;max-width:24em}\n"
    "h2{font-size:1.35rem;font-weight:normal;margin:0 0 .5rem}\n"
    "h3{font-size:1.05rem;font-weight:normal;font-style:italic;margin:1.2rem 0 .4rem}\n"
    "p{max-width:46rem;margin:.4rem 0 .9rem}.reason{font-size:1.08rem}\n"
    "section{border-top:1px solid var(--line);padding-top:1.3rem;margin-top:2.6rem}\n"
    "sup{font-size:.7em;line-height:0}.ci{color:var(--quiet);white-space:nowrap}\n"
    ".quiet{color:var(--quiet);font-size:.85rem}\n",
    ".story{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,310px),1fr));gap:."
    "9rem;"
    "margin:1.4rem 0 0}\n"
    ".card{background:var(--card);border:1px solid var(--line);border-radius:6px;padding:.8rem "
    "1rem .9rem}\n"
    ".card h2{font:600 .78rem/1.3 Helvetica,Arial,sans-serif;color:var(--quiet);margin:0 0 "
    ".35rem}\n"
    ".card p{margin:.2rem 0}.card .big{font-size:1.3rem;line-height:1.3}\n"
    ".card .ci{font-size:.8em}.card ul{margin:.2rem 0;padding-left:1.1rem}.card "
    "svg{display:block;width:100%;height:auto;"
    "margin-top:.4rem}\n"
    ".wide{grid-column:1/-1}\n",
    ".plots{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,330px),1fr));"
    "gap:.9rem}\n"
    "figure{margin:0;padding:.5rem .5rem .6rem;background:var(--card);border:1px solid "
    "var(--line);border-radius:6px;max-width:30rem}\n"
    "figure svg{display:block;width:100%;height:auto}figcaption{font-size:.78rem;"
    "color:var(--quiet);padding:.1rem .4rem 0}\n"
    ".legend{font-size:.85rem;color:var(--quiet)}.key{display:inline-block;width:1.5em;height:0;"
    "border-top:2.5px solid;vertical-align:.25em;margin:0 .45em 0 1.3em}\n"
    ".key.dot{border-top-style:dotted;border-color:var(--dot);margin-left:0}.key.rust{border-color:"
    "var(--rust)}.key.blue{border-color:var(--blue)}.key.area{border-top:.8em solid var(--area);"
    "vertical-align:-.1em}\n",
    "svg text{font:10.5px Helvetica,Arial,sans-serif;fill:var(--quiet);text-anchor:middle}\n"
    "svg .side,svg .label{text-anchor:end}svg .begin{text-anchor:start}svg .label{fill:var(--ink)}"
    "svg .name{font-size:8.5px}\n"
    ".grid{stroke:var(--grid);fill:none}.zero{stroke:var(--dot);fill:none}.phase{fill:var(--phase)}"
    ".noise{fill:var(--area)}.band{fill:var(--band)}\n"
    ".before,.after{fill:none;stroke-width:1.7;stroke-linejoin:round}.thin{stroke-width:.8;opacity:"
    ".28}\n"
    ".before{stroke:var(--rust)}.after{stroke:var(--blue)}.measured{fill:none;stroke:var(--dot);"
    "stroke-width:2.6;stroke-linecap:round}\n",
    ".scroll{overflow-x:auto}table{border-collapse:collapse;font:14px/1.4 Helvetica,Arial,"
    "sans-serif;margin:.6rem 0}\n"
    "th,td{text-align:left;padding:.34rem .9rem .34rem 0;border-bottom:1px solid var(--line);"
    "font-weight:normal;vertical-align:top;white-space:nowrap}\n"
    "tr:first-child>th{color:var(--quiet);font-size:.85em}td:last-child{white-space:normal}\n"
    "small{color:var(--quiet);font-size:.8em}th small{display:block}td small{margin-left:.4em}\n"
    ".map{border-collapse:separate;border-spacing:3px}.map th,.map td{border:0;padding:.3rem "
    ".55rem}.map small{display:block;margin:0;color:inherit;opacity:.75}\n"
    "th[scope=row]{position:sticky;left:0;background:var(--paper)}.map td:last-child{white-space:"
    "nowrap}\n"
    ".map .half th{color:var(--quiet);font-size:.85em;padding-top:.7rem}\n"
    ".heat{border-radius:4px;background:var(--phase);min-width:5.2em}.heat.none{background:none}"
    ".h1{background:var(--h1)}.h2{background:var(--h2)}.h3{background:var(--h3)}.h4{background:"
    "var(--h4);color:var(--hot)}.h5{background:var(--h5);color:var(--hot)}\n",
    ".bar{width:34%;min-width:110px}.bar svg{display:block;width:100%;height:15px}\n"
    ".full{fill:var(--dot)}.predicted{fill:var(--grid)}.cause .full{fill:var(--rust)}.rival "
    ".full{fill:var(--rust);opacity:.5}.gains .full{fill:var(--blue)}.span{fill:var(--band)}.one{"
    "stroke:var(--dot);vector-effect:non-scaling-stroke}\n"
    ".impossible{color:var(--quiet)}.cause th{font-weight:600}\n"
    "ul{max-width:52rem}li{margin:.15rem 0}footer{margin-top:3rem}\n"
    "@media(max-width:480px){body{font-size:16px}main{padding:1.3rem .9rem 3rem}}\n"
    "@media print{body{background:#fff}figure,table,.card{break-inside:avoid}}\n"};

static int has_cause(const lab_diagnosis *d)
{
    return d->ncause > 0 && d->nsuspect > 0;
}

static int has_law(const lab_diagnosis *d)
{
    return d->nlaw > 0 && d->law[0].pays;
}

/* ---- the first screen ---- */

static void causes(FILE *f, const lab_diagnosis *d)
{
    for (int i = 0; i < d->ncause && i < d->nsuspect; i++) {
        fputs(i == 0 ? "" : i + 1 < d->ncause ? ", " : " and ", f);
        page__cause(f, &d->suspect[i].candidate);
    }
}

static void headline(FILE *f, const lab_diagnosis *d)
{
    static const char *const begin[] = {"The model explains these strokes",
                                        "A number of the file is wrong",
                                        "An instrument does not show what is there",
                                        "The input is not what the record says",
                                        "The model lacks something",
                                        "Something is missing, and no known effect explains it",
                                        "No fit to trust, so no verdict",
                                        "The model is far from these records"};
    fputs(begin[d->verdict], f);
    if (has_cause(d)) {
        fputs(": ", f);
        causes(f, d);
    }
}

static void card(FILE *f, const char *title)
{
    fprintf(f, "<div class=\"card\"><h2>%s</h2>\n", title);
}

static int is_first_there(const lab_diagnosis *d, int cause)
{
    for (int i = 0; i < cause; i++) {
        if (strcmp(d->suspect[i].candidate.place, d->suspect[cause].candidate.place) == 0) {
            return 0;
        }
    }
    return 1;
}

static void where_card(FILE *f, const lab_diagnosis *d)
{
    card(f, "Where and when");
    fputs("<p class=\"big\">", f);
    for (int i = 0; i < d->ncause && i < d->nsuspect; i++) {
        if (is_first_there(d, i)) {
            fputs(i == 0 ? "" : ", ", f);
            page__text(f, d->suspect[i].candidate.place);
        }
    }
    fputs("</p>\n<p>", f);
    if (d->phase != NULL) {
        fputs("shows most in: ", f);
        page__text(f, d->phase);
    } else {
        fputs("in no phase more than in others", f);
    }
    fputs("</p>\n", f);
    for (int i = 0; i < d->ncause && i < d->nsuspect; i++) {
        const lab_effect *e = d->suspect[i].candidate.effect;
        if (e != NULL) {
            fputs("<p class=\"quiet\">", f);
            page__text(f, e->equation);
            fputs("<br>looks like: ", f);
            page__text(f, e->looks);
            fputs("</p>\n", f);
        }
    }
    fputs("</div>\n", f);
}

/* which of several causes, and what the others are without it */
static void cause_line(FILE *f, const lab_suspect *s)
{
    fputs("<p>", f);
    page__cause(f, &s->candidate);
    if (isfinite(s->own_ratio)) {
        fputs(" <small>error ", f);
        page__number(f, s->own_ratio, 2);
        fputs(" of what it is without it</small>", f);
    }
    fputs("</p>\n", f);
}

static void size_card(FILE *f, const lab_diagnosis *d)
{
    card(f, "How large, with 95 % interval");
    for (int i = 0; i < d->ncause && i < d->nsuspect; i++) {
        const lab_suspect *s = &d->suspect[i];
        if (d->ncause > 1) {
            cause_line(f, s);
        }
        for (int k = 0; k < s->nnumber; k++) {
            const lab_cause_number *n = &s->number[k];
            fputs(k == 0 ? "<p class=\"big\">" : "<p>", f);
            page__words(f, n->name);
            fputs(" = ", f);
            page__interval(f, n->value, n->lo, n->hi, n->unit);
            fputs("</p>\n", f);
        }
    }
    fputs("<p class=\"quiet\">chance of a score like this where nothing is: ", f);
    page__number(f, d->p, 2);
    fputs("</p></div>\n", f);
}

static void rivals_card(FILE *f, const lab_diagnosis *d)
{
    card(f, "What else it could be");
    if (d->nrival == 0) {
        fputs("<p>Nothing in the table of effects: every other one leaves more unexplained.</p>"
              "</div>\n",
              f);
        return;
    }
    fputs("<p>These strokes cannot tell it from</p><ul>", f);
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
    page__svg_open(f, 300, 62, "error on held-out strokes before and after, and the noise floor");
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

static void gain_card(FILE *f, const lab_diagnosis *d)
{
    const lab_gain *g = &d->gain;
    int after = has_cause(d) || has_law(d);
    card(f, after ? "Gain on strokes held out" : "Error on strokes held out");
    if (!isfinite(g->rmse_before)) {
        fputs("<p>not measured</p></div>\n", f);
        return;
    }
    fputs("<p class=\"big\">", f);
    page__number(f, g->rmse_before, 3);
    if (after && isfinite(g->rmse_after)) {
        fputs(" \xe2\x86\x92 ", f);
        page__number(f, g->rmse_after, 3);
    }
    fputs(" noises</p>\n", f);
    if (after) {
        fputs("<p>after over before ", f);
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
        return "Use the model as it is. Effects smaller than the noise and the scatter of these "
               "strokes could still hide.";
    case LAB_VERDICT_NOT_CONVERGED:
        return "Look at the data and the starting numbers below first; nothing about physics can "
               "be said before the fit holds.";
    case LAB_VERDICT_UNKNOWN_EFFECT:
        if (has_law(d)) {
            return "Go on with extended.yaml: it has the law below as a table. Its shape is what a "
                   "physical explanation has to have.";
        }
        return "Look where the map below is darkest, and at the force that is missing there: its "
               "course over time is what a new effect has to explain.";
    case LAB_VERDICT_UNUSABLE_MODEL:
        return "Compare signs, units, planes, the start and the clock of the first record with the "
               "mechanism file; nothing about physics can be said before they agree.";
    default: break;
    }
    if (d->nrival > 0) {
        return "Go on with extended.yaml for predictions like these strokes. Before you change the "
               "instrument for it, make a stroke in which the candidates would differ.";
    }
    return d->verdict == LAB_VERDICT_SENSOR
               ? "Check the instrument; extended.yaml corrects for it until then."
           : d->verdict == LAB_VERDICT_INPUT
               ? "Check how the input was recorded; extended.yaml corrects for it until then."
               : "Go on with extended.yaml: it has the cause and the refitted numbers, and runs "
                 "everywhere the old file does.";
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
            fprintf(f, "; %d stroke%s will do.", d->next->repeats,
                    d->next->repeats == 1 ? "" : "s");
        } else {
            fputs("; even that takes very many strokes.", f);
        }
        fputs(" <code>stein plan</code> has the list and writes the stroke.</p>", f);
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
    card(f, "Best suspect");
    if (d->nsuspect == 0) {
        fputs("<p>none was tested</p></div>\n", f);
        return;
    }
    fputs("<p class=\"big\">", f);
    page__cause(f, &d->suspect[0].candidate);
    fputs("</p>\n<p>chance of a score like this where nothing is: ", f);
    page__number(f, d->p, 2);
    fputs("</p></div>\n", f);
}

static void fit_card(FILE *f, const lab_diagnosis *d)
{
    card(f, "The fit");
    fputs("<p class=\"big\">", f);
    page__number(f, d->chi2_dof_before, 3);
    if (has_cause(d) || has_law(d)) {
        fputs(" \xe2\x86\x92 ", f);
        page__number(f, d->chi2_dof_after, 3);
    }
    fputs("</p>\n<p>\xcf\x87\xc2\xb2 per degree of freedom; 1 is noise alone</p>\n", f);
    fprintf(f, "<p class=\"quiet\">%d samples of %d strokes</p></div>\n", d->samples, d->nfit);
}

static void story(FILE *f, const lab_diagnosis *d)
{
    fprintf(
        f,
        "<header><p class=\"eyebrow\">Diagnosis \xc2\xb7 %d stroke%s fitted, %d held out</p>\n<h1>",
        d->nfit, d->nfit == 1 ? "" : "s", d->nheld);
    headline(f, d);
    fputs("</h1>\n<p class=\"reason\">", f);
    page__text(f, d->reason);
    fputs("</p>\n<div class=\"story\">\n", f);
    if (has_cause(d)) {
        where_card(f, d);
        size_card(f, d);
        rivals_card(f, d);
    } else {
        hottest_card(f, d);
        suspect_card(f, d);
    }
    gain_card(f, d);
    fit_card(f, d);
    next_card(f, d);
    fputs("</div></header>\n", f);
}

/* ---- the page ---- */

static void write_page(FILE *f, const lab_diagnosis *d)
{
    fputs("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta "
          "name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>Diagnosis: ",
          f);
    fputs(diag__verdict_words(d->verdict), f);
    fputs("</title>\n<style>\n", f);
    for (size_t i = 0; i < sizeof style / sizeof *style; i++) {
        fputs(style[i], f);
    }
    fputs("</style>\n</head>\n<body>\n<main>\n", f);
    story(f, d);
    page__law(f, d);
    page__strokes(f, d);
    page__map(f, d);
    page__forces(f, d);
    page__motion(f, d);
    page__suspects(f, d);
    page__seen(f, d);
    page__gains(f, d);
    page__parameters(f, d);
    page__audit(f, d);
    fprintf(f, "<footer><p class=\"quiet\">%d fits, %d strokes simulated, ", d->fits,
            d->strokes_simulated);
    page__number(f, d->seconds, 3);
    fputs("&nbsp;s. The same figures for programs are in diagnosis.json.</p></footer>\n</main>\n"
          "</body>\n</html>\n",
          f);
}

stein_status lab_diagnosis_page(const char *path, const lab_diagnosis *d, stein_err *err)
{
    lab__file file;
    stein_status status = lab__file_open(&file, path, err);
    if (status == STEIN_OK) {
        write_page(file.stream, d);
        status = lab__file_close(&file, 1, err);
    }
    return status;
}
