/* SPDX-License-Identifier: GPL-3.0-or-later
 * curve_show.c - a recovered law in report.html and diagnosis.json.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "curve.h"
#include "diagnosis_page.h"
#include "stein/law.h"

enum { WIDTH = 360, BETWEEN = 8 };

static void write_law(lab__json *j, const char *key, const lab_law *l)
{
    lab__json_open(j, key, '{');
    lab__json_text(j, "site", l->site);
    lab__json_text(j, "place", l->place);
    lab__json_text(j, "of", l->of);
    lab__json_text(j, "what", l->what);
    lab__json_text(j, "at_unit", l->at_unit);
    lab__json_text(j, "unit", l->unit);
    lab__json_text(j, "table", l->table);
    lab__json_reals(j, "at", l->at, l->n);
    lab__json_reals(j, "value", l->value, l->n);
    lab__json_reals(j, "lo", l->lo, l->n);
    lab__json_reals(j, "hi", l->hi, l->n);
    lab__json_open(j, "seen", '[');
    for (int i = 0; i < l->n; i++) {
        lab__json_int(j, NULL, l->seen[i]);
    }
    lab__json_close(j);
    lab__json_real(j, "gain", l->gain);
    lab__json_real(j, "chi2_dof", l->chi2_dof);
    lab__json_real(j, "held_out", l->held_out);
    lab__json_real(j, "share", l->share);
    lab__json_bool(j, "pays", l->pays);
    lab__json_close(j);
}

/* "law": the one of the extension, null without; "laws_tried": all that were fitted, best first */
void diag__law_json(lab__json *j, const lab_diagnosis *d)
{
    if (d->nlaw > 0 && d->law[0].pays) {
        write_law(j, "law", &d->law[0]);
    } else {
        lab__json_null(j, "law");
    }
    lab__json_open(j, "laws_tried", '[');
    for (int i = 0; i < d->nlaw; i++) {
        write_law(j, NULL, &d->law[i]);
    }
    lab__json_close(j);
}

/* ---- the page ---- */

/* y of the curve through values, n points, at m places */
static int curve_at(const lab_law *l, const double *value, const double *x, double *y, int m)
{
    double *slope = malloc(sizeof *slope * (size_t)l->n);
    if (slope == NULL) {
        return -1;
    }
    stein_table_slopes(l->n, l->at, value, slope);
    for (int i = 0; i < m; i++) {
        y[i] = stein_table_value(l->n, l->at, value, slope, x[i]);
    }
    free(slope);
    return 0;
}

static void draw(FILE *f, const lab_law *l)
{
    int m = BETWEEN * (l->n - 1) + 1;
    double *x = calloc(4 * (size_t)m, sizeof *x), lo = 0.0, hi = 0.0;
    if (x == NULL) {
        return;
    }
    double *y = x + m, *low = y + m, *high = low + m;
    for (int i = 0; i < m; i++) {
        x[i] = l->at[0] + (l->at[l->n - 1] - l->at[0]) * i / (m - 1);
    }
    if (curve_at(l, l->value, x, y, m) == 0 && curve_at(l, l->lo, x, low, m) == 0 &&
        curve_at(l, l->hi, x, high, m) == 0) {
        for (int i = 0; i < l->n; i++) {
            lo = fmin(lo, l->lo[i]);
            hi = fmax(hi, l->hi[i]);
        }
        char at[2 * LAB_PLACE], label[2 * LAB_PLACE];
        page__unit ux = page__unit_for(l->at_unit, fmax(fabs(x[0]), fabs(x[m - 1])));
        page__unit uy = page__unit_for(l->unit, fmax(fabs(lo), fabs(hi)));
        snprintf(at, sizeof at, "%s of %s [%s]", l->of, l->place, ux.name);
        snprintf(label, sizeof label, uy.name[0] != '\0' ? "%s [%s]" : "%s", l->what, uy.name);
        page__plot p = {.f = f,
                        .left = 56.0,
                        .top = 26.0,
                        .width = WIDTH - 72.0,
                        .height = 220.0,
                        .caption = 13.0,
                        .x0 = ux.factor * x[0],
                        .x1 = ux.factor * x[m - 1],
                        .y0 = uy.factor * lo,
                        .y1 = uy.factor * hi};
        page__range(&p.x0, &p.x1, 0.02);
        page__range(&p.y0, &p.y1, 0.06);
        page__svg_open(f, WIDTH, 290, "the recovered law with its band");
        page__band(&p, "noise", x, low, high, m, ux.factor, uy.factor);
        page__axes(&p, at, label);
        fprintf(f, "<path class=\"zero\" d=\"M%.1f %.1fh%.1f\"/>\n", p.left, page__y(&p, 0.0),
                p.width);
        page__curve(&p, "cause-curve", x, y, m, ux.factor, uy.factor);
        page__dots(&p, "measured", l->at, l->value, l->n, ux.factor, uy.factor);
        page__svg_close(f);
    }
    free(x);
}

static void one_row(FILE *f, const lab_law *l)
{
    fputs("<tr><td>", f);
    page__words(f, l->place);
    fprintf(f, "</td><td>%s of the %s</td><td class=\"number\">", l->of, l->site);
    page__number(f, l->gain, 3);
    fputs("</td><td class=\"number\">", f);
    page__number(f, l->chi2_dof, 3);
    fputs("</td><td class=\"number\">", f);
    if (isfinite(l->held_out)) {
        page__number(f, l->held_out, 3);
    }
    fputs("</td></tr>\n", f);
}

void page__law(FILE *f, const lab_diagnosis *d)
{
    if (d->nlaw == 0) {
        return;
    }
    const lab_law *l = &d->law[0];
    fputs("<section id=\"law\"><h2>The law itself</h2>\n", f);
    if (l->pays) {
        fprintf(f, "<p>The unexplained force acts at the %s ", l->site);
        page__words(f, l->place);
        fprintf(f,
                " as a function of its %s. The curve with its 95&nbsp;%% band, everything else "
                "refitted; dots are the points of the table <code>",
                l->of);
        page__text(f, l->table);
        fputs("</code> in extended.yaml.</p>\n<div class=\"plots\"><figure>", f);
        draw(f, l);
        fputs("</figure></div>\n", f);
    } else {
        fputs("<p>No curve over one state of one place predicts the held-out records better: "
              "the missing effect is no such law, or needs other records.</p>\n",
              f);
    }
    fputs("<div class=\"scroll\" tabindex=\"0\"><table><tr><th>place</th><th>as a function "
          "of</th><th>gain</th>"
          "<th>\xcf\x87\xc2\xb2/dof</th><th>held out [noise]</th></tr>\n",
          f);
    for (int i = 0; i < d->nlaw; i++) {
        one_row(f, &d->law[i]);
    }
    fputs("</table></div>\n</section>\n", f);
}
