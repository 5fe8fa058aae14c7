/* SPDX-License-Identifier: GPL-3.0-or-later
 * facts.c - the published facts of the regulation against strokes over dx.
 *
 * Source: the study of the Stein action, section 5: 100 g load, dx the shift of the pawl's stop,
 * positive to the right. The straight lines go through dx = -1.2 .. 0 mm in steps of 0.1 mm
 * (least squares, GSL), the rest is read off the grid of 0.05 mm. Calibrated are the facts that the
 * head of models/stein1788.yaml names, and the blow, for which string.height was chosen.
 */
#include <gsl/gsl_fit.h>
#include <math.h>
#include <string.h>

#include "io.h"

enum { FIRST = -30, LAST = 6, FIT_FIRST = -24, FIT_STEP = 2, FIT_POINTS = 13 };
static const double grid = 0.05e-3; /* [m] */

typedef double figure_fn(const lab_stroke *s);

typedef struct line {
    double at0, slope, r2, residual;
    int known; /* a figure at every point */
} line;

typedef struct table {
    const lab_point *point;
    int n;
    lab_fact *fact;
    int nfact;
} table;

int lab_study_grid(lab_point *point, int n)
{
    for (int i = 0; point != NULL && i < n && i <= LAST - FIRST; i++) {
        memset(&point[i], 0, sizeof point[i]);
        point[i].dx = (FIRST + i) / 20000.0; // correctly rounded
    }
    return LAST - FIRST + 1;
}

/* the stroke at k grid steps, or NULL when it is absent or failed */
static const lab_stroke *at(const table *t, int k)
{
    for (int i = 0; i < t->n; i++) {
        if (fabs(t->point[i].dx - grid * k) < 0.01 * grid && t->point[i].status == STEIN_OK) {
            return &t->point[i].stroke;
        }
    }
    return NULL;
}

static double figure(const table *t, int k, figure_fn *read)
{
    const lab_stroke *s = at(t, k);
    return s != NULL ? read(s) : NAN;
}

static double height(const lab_stroke *s)
{
    return s->escape_height;
}

static double force(const lab_stroke *s)
{
    return s->peak_string_force;
}

static double escape_time(const lab_stroke *s)
{
    return s->escape_time;
}

static double impact_time(const lab_stroke *s)
{
    return s->impact_time;
}

static line fit(const table *t, figure_fn *read)
{
    double x[FIT_POINTS], y[FIT_POINTS], cov[3], sumsq, mean = 0.0, total = 0.0;
    line l = {.known = 1};
    for (int i = 0; i < FIT_POINTS; i++) {
        x[i] = grid * (FIT_FIRST + FIT_STEP * i);
        y[i] = figure(t, FIT_FIRST + FIT_STEP * i, read);
        l.known = l.known && isfinite(y[i]);
        mean += y[i] / FIT_POINTS;
    }
    if (!l.known) {
        return l;
    }
    gsl_fit_linear(x, 1, y, 1, FIT_POINTS, &l.at0, &l.slope, &cov[0], &cov[1], &cov[2], &sumsq);
    for (int i = 0; i < FIT_POINTS; i++) {
        total += (y[i] - mean) * (y[i] - mean);
        l.residual = fmax(l.residual, fabs(y[i] - l.at0 - l.slope * x[i]));
    }
    l.r2 = 1.0 - sumsq / total;
    return l;
}

/* a new row; its `simulated` is for the caller to print into */
static char *row(table *t, const char *fact, const char *paper, const char *within, int calibrated,
                 int ok)
{
    lab_fact *f = &t->fact[t->nfact++];
    *f = (lab_fact){
        .fact = fact, .paper = paper, .within = within, .calibrated = calibrated, .ok = ok};
    return f->simulated;
}

#define SAY(text, ...) snprintf(text, sizeof((lab_fact *)0)->simulated, __VA_ARGS__)

static int rises(const table *t, figure_fn *read, int from, int to, double sign)
{
    for (int k = from + 1; k <= to; k++) {
        if (!(sign * (figure(t, k, read) - figure(t, k - 1, read)) > 0.0)) {
            return 0;
        }
    }
    return 1;
}

static void facts_of_height(table *t)
{
    double h = 1e3 * figure(t, 0, height);
    line l = fit(t, height);
    char *text =
        row(t, "escapement height at dx = 0", "2.2 mm", "+-0.1 mm", 1, fabs(h - 2.2) <= 0.1);
    SAY(text, "%.2f mm", h);
    text = row(t, "slope of escapement height against dx", "-20 mm/mm", "+-1.5 mm/mm", 1,
               l.known && fabs(l.slope + 20.0) <= 1.5);
    SAY(text, "%.1f mm/mm", l.known ? l.slope : NAN);
    text = row(t, "escapement height: residual from the line", "quasi-linear", "below 1 mm", 0,
               l.known && l.residual < 1e-3);
    SAY(text, "%.2f mm", l.known ? 1e3 * l.residual : NAN);
}

static int is_struck(const lab_stroke *s)
{
    return s != NULL && s->outcome == LAB_STRUCK;
}

static void facts_of_range(table *t)
{
    int left = 0, right = 0, missed = 1, forced = 1;
    while (left > FIRST && is_struck(at(t, left - 1))) {
        left--;
    }
    while (right < LAST && is_struck(at(t, right + 1))) {
        right++;
    }
    for (int k = FIRST; k <= -27; k++) {
        const lab_stroke *s = at(t, k);
        missed = missed && s != NULL && s->outcome == LAB_MISSED_NOTCH;
    }
    for (int k = 3; k <= 4; k++) {
        const lab_stroke *s = at(t, k);
        forced = forced && s != NULL && s->forced_escapement;
    }
    int works = is_struck(at(t, 0));
    char *text = row(t, "leftmost dx that strikes", "-1.25 mm", "+-0.05 mm", 1,
                     works && left >= -26 && left <= -24);
    SAY(text, "%+.2f mm", 0.05 * left);
    text = row(t, "notch misses the beak at -1.35 mm and beyond", "yes", "all of them", 0, missed);
    SAY(text, "%s", missed ? "yes" : "no");
    text = row(t, "rightmost dx that escapes", "+0.2 mm", "+-0.05 mm", 1,
               works && right >= 3 && right <= 5);
    SAY(text, "%+.2f mm", 0.05 * right);
    const lab_stroke *s = at(t, LAST);
    text = row(t, "at dx = +0.3 mm", "no escapement", "the same", 0,
               s != NULL && s->outcome == LAB_NO_ESCAPEMENT);
    SAY(text, "%s", s == NULL ? "failed" : lab_outcome_text(s->outcome));
    text[strcspn(text, "_")] = ' ';
    text = row(t, "forced escapement near +0.2 mm", "after the impact", "at +0.15 and +0.2 mm", 1,
               forced);
    s = at(t, 3);
    SAY(text, s != NULL && s->escaped && s->impacts > 0 ? "%+.1f ms at +0.15" : "none",
        s != NULL ? 1e3 * (s->escape_time - s->impact_time) : NAN);
}

static void facts_of_time(table *t)
{
    double e0 = figure(t, FIT_FIRST, escape_time), e1 = figure(t, 4, escape_time);
    char *text = row(t, "time of escapement grows with dx", "yes", "at every step", 0,
                     rises(t, escape_time, FIT_FIRST, 4, 1.0));
    SAY(text, "%.1f → %.1f ms", 1e3 * e0, 1e3 * e1);

    double i0 = figure(t, FIT_FIRST, impact_time), i1 = figure(t, FIT_FIRST / 2, impact_time),
           i2 = figure(t, 0, impact_time);
    text = row(t, "time of impact falls towards an asymptote", "yes", "at every step", 0,
               rises(t, impact_time, FIT_FIRST, 0, -1.0) && i1 - i2 < 0.5 * (i0 - i1));
    SAY(text, "%.1f → %.1f → %.1f ms", 1e3 * i0, 1e3 * i1, 1e3 * i2);

    double most = 0.0;
    for (int k = 1; k <= 4; k++) {
        const lab_stroke *s = at(t, k);
        most = s != NULL ? fmax(most, s->free_flight) : NAN;
    }
    const lab_stroke *s = at(t, 0);
    text = row(t, "free flight vanishes for dx > 0", "→ 0", "below 1.5 ms", 0,
               s != NULL && s->free_flight > 0.0 && most < 1.5e-3);
    SAY(text, "%.1f → %.1f → %.1f ms", 1e3 * (i0 - e0), s != NULL ? 1e3 * s->free_flight : NAN,
        at(t, 4) != NULL ? 1e3 * at(t, 4)->free_flight : NAN);
}

static void facts_of_force(table *t)
{
    line l = fit(t, force);
    double f0 = figure(t, 0, force), change = 0.0;
    for (int k = 1; k <= 3; k++) {
        double here = fabs(figure(t, k, force) / f0 - 1.0);
        change = here > change || isnan(here) ? here : change;
    }
    char *text = row(t, "peak string force at dx = 0", "> 6.25 N", "above 6.25 N", 0, f0 > 6.25);
    SAY(text, "%.2f N", f0);
    text = row(t, "slope of peak force for dx < 0", "5 N/mm", "+-1 N/mm", 1,
               l.known && fabs(1e-3 * l.slope - 5.0) <= 1.0);
    SAY(text, "%.2f N/mm", l.known ? 1e-3 * l.slope : NAN);
    text = row(t, "peak force for dx < 0: R² of the line", "linear", "R² of 0.97", 0,
               l.known && l.r2 >= 0.97);
    SAY(text, "%.3f", l.known ? l.r2 : NAN);
    text = row(t, "change of peak force up to dx = +0.15 mm", "about constant", "below 10 %", 0,
               change < 0.10);
    SAY(text, "%.1f %%", 100.0 * change);
}

static void facts_of_stroke(table *t)
{
    const lab_stroke *s = at(t, 0);
    int rearmed = 0, all = 0;
    for (int k = -25; k <= 4; k++) {
        const lab_stroke *here = at(t, k);
        all++;
        rearmed += here != NULL && here->rearmed;
    }
    char *text =
        row(t, "re-arms when the key is released", "everywhere", "at every dx", 0, rearmed == all);
    SAY(text, "%d of %d dx", rearmed, all);
    double blow = s != NULL ? 1e3 * s->blow : NAN, time = s != NULL ? 1e3 * s->impact_time : NAN;
    double speed = s != NULL ? s->impact_speed : NAN;
    text = row(t, "blow distance", "25-45 mm", "in the range", 1, blow >= 25.0 && blow <= 45.0);
    SAY(text, "%.1f mm", blow);
    text = row(t, "release to impact", "45-70 ms", "in the range", 0, time >= 45.0 && time <= 70.0);
    SAY(text, "%.1f ms", time);
    text = row(t, "head speed at impact", "0.9-1.4 m/s", "in the range", 0,
               speed >= 0.9 && speed <= 1.4);
    SAY(text, "%.2f m/s", speed);
}

int lab_facts(lab_fact *fact, const lab_point *point, int n)
{
    table t = {.point = point, .n = n, .fact = fact};
    locale_t before = lab__locale_c();
    facts_of_height(&t);
    facts_of_range(&t);
    facts_of_time(&t);
    facts_of_force(&t);
    facts_of_stroke(&t);
    lab__locale_restore(before);
    return t.nfact;
}
