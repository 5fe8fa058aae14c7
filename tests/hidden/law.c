/* SPDX-License-Identifier: GPL-3.0-or-later
 * law.c - a recovered law against the hidden one.
 *
 * Right is unknown_effect at the place of the answer, over its variable. A law with a memory has no
 * variable that a curve could be drawn over: there right is the place, and that no state function
 * is said to explain it - whatever curve came nearest.
 *
 * The curve is compared where the strokes to fit have been, at even distances: RMS error over the
 * RMS of the truth, and the share of these points inside of the band. Between its points it is read
 * as in law.h: Hermite, with slopes of parabolas; level beyond the ends.
 */
#include <math.h>
#include <string.h>

#include "hidden.h"

enum { POINTS = 200 };

static int numbers(const tree *list, double v[POINTS])
{
    int n = 0;
    for (const tree *c = list != NULL ? list->child : NULL; c != NULL && n < POINTS; c = c->next) {
        v[n++] = c->number;
    }
    return n;
}

static double slope(int n, const double *x, const double *y, int i)
{
    if (i == 0 || i == n - 1) {
        int k = i == 0 ? 1 : i;
        return (y[k] - y[k - 1]) / (x[k] - x[k - 1]);
    }
    double h = x[i] - x[i - 1], g = x[i + 1] - x[i];
    return (g * (y[i] - y[i - 1]) / h + h * (y[i + 1] - y[i]) / g) / (h + g);
}

static double curve_at(int n, const double *x, const double *y, double at)
{
    int k = 1;
    if (at <= x[0] || at >= x[n - 1]) {
        return at <= x[0] ? y[0] : y[n - 1];
    }
    while (x[k] < at) {
        k++;
    }
    double h = x[k] - x[k - 1], u = (at - x[k - 1]) / h, v = 1.0 - u;
    return (1.0 + 2.0 * u) * v * v * y[k - 1] + u * u * (1.0 + 2.0 * v) * y[k] +
           h * u * v * (v * slope(n, x, y, k - 1) - u * slope(n, x, y, k));
}

static void compare(const tree *law, const tree *truth, score *r)
{
    double x[POINTS], y[POINTS], low[POINTS], high[POINTS], at[POINTS], value[POINTS];
    int n = numbers(tree_get(law, "at"), x), m = numbers(tree_get(truth, "at"), at);
    int whole = numbers(tree_get(law, "value"), y) == n && numbers(tree_get(law, "lo"), low) == n &&
                numbers(tree_get(law, "hi"), high) == n &&
                numbers(tree_get(truth, "value"), value) == m;
    double off = 0.0, all = 0.0;
    int inside = 0;
    if (!whole || n < 2 || m < 2) {
        return;
    }
    for (int i = 0; i < m; i++) {
        double d = curve_at(n, x, y, at[i]) - value[i];
        off += d * d;
        all += value[i] * value[i];
        inside += curve_at(n, x, low, at[i]) <= value[i] && value[i] <= curve_at(n, x, high, at[i]);
    }
    r->law_error = sqrt(off / all);
    r->law_cover = (double)inside / m;
    r->compared = isfinite(r->law_error);
}

void judge_law(const tree *found, const tree *answer, score *r)
{
    const tree *truth = tree_get(answer, "law_curve"), *law = tree_get(found, "law");
    const tree *tried = tree_get(found, "laws_tried");
    int named = law != NULL && law->type == '{';
    r->law_error = r->law_cover = NAN;
    snprintf(r->law_place, NAME, "-");
    snprintf(r->law_of, NAME, "-");
    r->outside = truth != NULL && truth->type == '{';
    law = named ? law : tried != NULL ? tried->child : NULL;
    if (!r->outside || law == NULL) {
        return;
    }
    int unknown = strcmp(r->verdict, "unknown_effect") == 0;
    int none = strstr(tree_text(found, "reason"), "o state function") != NULL;
    const char *of = tree_text(truth, "of");
    snprintf(r->law_place, NAME, "%s", tree_text(law, "place"));
    snprintf(r->law_of, NAME, "%s%s", tree_text(law, "of"), none ? "?" : "");
    r->law_here = unknown && strcmp(r->law_place, tree_text(truth, "place")) == 0;
    if (strcmp(of, "history") == 0) {
        r->law_right = r->law_here && none;
    } else {
        r->law_right = r->law_here && named && strcmp(tree_text(law, "of"), of) == 0;
    }
    if (r->law_right) {
        compare(law, truth, r);
    }
}
