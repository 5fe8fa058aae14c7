/* SPDX-License-Identifier: GPL-3.0-or-later
 * diagnosis_chart.c - axes, curves and bands as inline SVG. Colours and fonts are classes of the
 * page's style sheet, so that a picture follows light and dark.
 */
#include <math.h>
#include <string.h>

#include "diagnosis_page.h"

enum { MOST_POINTS = 500, TIPS = 50 };

double page__x(const page__plot *p, double x)
{
    return p->left + p->width * (x - p->x0) / (p->x1 - p->x0);
}

double page__y(const page__plot *p, double y)
{
    return p->top + p->height * (p->y1 - y) / (p->y1 - p->y0);
}

void page__range(double *lo, double *hi, double margin)
{
    if (!(*hi > *lo)) {
        double wide = fmax(1e-12, 0.1 * fmax(fabs(*lo), fabs(*hi)));
        *lo = isfinite(*lo) ? *lo - wide : -1.0;
        *hi = isfinite(*hi) ? *hi + wide : 1.0;
        if (!(*hi > *lo)) {
            *lo = -1.0;
            *hi = 1.0;
        }
    }
    double more = margin * (*hi - *lo);
    *lo -= more;
    *hi += more;
}

void page__svg_open(FILE *f, int width, int height, const char *what)
{
    fprintf(f, "<svg viewBox=\"0 0 %d %d\" role=\"img\" aria-label=\"", width, height);
    page__text(f, what);
    fputs("\">\n", f);
}

void page__svg_close(FILE *f)
{
    fputs("</svg>\n", f);
}

/* ---- axes ---- */

/* a round step of which about n fit into a width */
static double round_step(double width, double n)
{
    double raw = width / n, e = pow(10.0, floor(log10(raw))), m = raw / e;
    return e * (m < 1.5 ? 1.0 : m < 3.5 ? 2.0 : m < 7.5 ? 5.0 : 10.0);
}

static void tick_text(FILE *f, double value, double step)
{
    char text[32];
    int decimals = (int)fmax(0.0, ceil(-log10(step) - 1e-9));
    snprintf(text, sizeof text, "%.*f", decimals > 9 ? 9 : decimals, value);
    int zero = strspn(text, "-0.") == strlen(text);
    int minus = text[0] == '-';
    fprintf(f, "%s%s", minus && !zero ? "\xe2\x88\x92" : "", text + minus);
}

static void x_axis(const page__plot *p, int numbers)
{
    double step = round_step(p->x1 - p->x0, p->width / 62.0), bottom = p->top + p->height;
    long long first = (long long)ceil(p->x0 / step - 1e-9),
              last = (long long)floor(p->x1 / step + 1e-9);
    for (long long k = first; k <= last; k++) {
        double v = step * (double)k, x = page__x(p, v);
        fprintf(p->f, "<path class=\"grid\" d=\"M%.1f %.1fV%.1f\"/>", x, p->top, bottom);
        if (numbers) {
            fprintf(p->f, "<text class=\"tick\" x=\"%.1f\" y=\"%.1f\">", x, bottom + 13.0);
            tick_text(p->f, v, step);
            fputs("</text>", p->f);
        }
    }
}

static void y_axis(const page__plot *p)
{
    double step = round_step(p->y1 - p->y0, fmin(p->height / 27.0, 6.0));
    long long first = (long long)ceil(p->y0 / step - 1e-9),
              last = (long long)floor(p->y1 / step + 1e-9);
    for (long long k = first; k <= last; k++) {
        double v = step * (double)k, y = page__y(p, v);
        fprintf(p->f, "<path class=\"grid\" d=\"M%.1f %.1fH%.1f\"/>", p->left, y,
                p->left + p->width);
        fprintf(p->f, "<text class=\"tick side\" x=\"%.1f\" y=\"%.1f\">", p->left - 5.0, y + 3.5);
        tick_text(p->f, v, step);
        fputs("</text>", p->f);
    }
}

void page__axes(const page__plot *p, const char *xlabel, const char *ylabel)
{
    x_axis(p, xlabel != NULL);
    y_axis(p);
    if (xlabel != NULL) {
        fprintf(p->f, "<text class=\"label\" x=\"%.1f\" y=\"%.1f\">", p->left + p->width,
                p->top + p->height + 29.0);
        page__text(p->f, xlabel);
        fputs("</text>", p->f);
    }
    if (ylabel != NULL) {
        fprintf(p->f, "<text class=\"label begin\" x=\"2\" y=\"%.1f\">", p->top - p->caption);
        page__text(p->f, ylabel);
        fputs("</text>", p->f);
    }
    putc('\n', p->f);
}

/* ---- data ---- */

static double clamped(const page__plot *p, double y)
{
    double pixel = page__y(p, y), reach = 0.5 * p->height;
    return fmin(fmax(pixel, p->top - reach), p->top + p->height + reach);
}

/* one of how many points is drawn */
static int stride_of(int n)
{
    return n > MOST_POINTS ? (n + MOST_POINTS - 1) / MOST_POINTS : 1;
}

void page__curve(const page__plot *p, const char *cls, const double *x, const double *y, int n,
                 double sx, double sy)
{
    int pen = 0;
    fprintf(p->f, "<path class=\"%s\" d=\"", cls);
    for (int i = 0; i < n; i += stride_of(n)) {
        double px = page__x(p, sx * x[i]), py = clamped(p, sy * y[i]);
        int seen =
            isfinite(px) && isfinite(y[i]) && px >= p->left - 0.5 && px <= p->left + p->width + 0.5;
        if (seen) {
            fprintf(p->f, "%s%.1f %.1f", pen ? "L" : "M", px, py);
        }
        pen = seen;
    }
    fputs("\"/>\n", p->f);
}

void page__dots(const page__plot *p, const char *cls, const double *x, const double *y, int n,
                double sx, double sy)
{
    fprintf(p->f, "<path class=\"%s\" d=\"", cls);
    for (int i = 0; i < n; i += stride_of(n)) {
        double px = page__x(p, sx * x[i]), py = page__y(p, sy * y[i]);
        if (isfinite(px) && isfinite(py) && py >= p->top && py <= p->top + p->height &&
            px >= p->left && px <= p->left + p->width) {
            fprintf(p->f, "M%.1f %.1fh0", px, py);
        }
    }
    fputs("\"/>\n", p->f);
}

void page__band(const page__plot *p, const char *cls, const double *x, const double *lo,
                const double *hi, int n, double sx, double sy)
{
    fprintf(p->f, "<path class=\"%s\" d=\"", cls);
    for (int i = 0; i < 2 * n; i++) {
        int k = i < n ? i : 2 * n - 1 - i;
        double y = i < n ? hi[k] : lo[k];
        fprintf(p->f, "%s%.1f %.1f", i == 0 ? "M" : "L", page__x(p, sx * x[k]),
                isfinite(y) ? clamped(p, sy * y) : page__y(p, 0.0));
    }
    fputs("Z\"/>\n", p->f);
}

void page__tips(const page__plot *p, const double *x, const double *y, int n, double sx,
                page__tip_fn *tip, const void *ctx)
{
    double wide = p->width / TIPS;
    int next = 0; /* the first strip without a tip */
    for (int i = 0; i < n; i++) {
        double at = page__x(p, sx * x[i]) - p->left;
        int strip = isfinite(at) && isfinite(y[i]) ? (int)floor(at / wide) : -1;
        if (strip < next || strip >= TIPS) {
            continue;
        }
        fprintf(p->f, "<rect class=\"tip\" x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\">",
                p->left + wide * strip, p->top, wide, p->height);
        fputs("<title>", p->f);
        tip(p->f, ctx, i);
        fputs("</title></rect>\n", p->f);
        next = strip + 1;
    }
}

void page__rect(const page__plot *p, const char *cls, double x0, double x1, double y0, double y1)
{
    double left = page__x(p, x0), right = page__x(p, x1);
    double top = fmax(p->top, page__y(p, y1)), bottom = fmin(p->top + p->height, page__y(p, y0));
    fprintf(p->f, "<rect class=\"%s\" x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\"/>\n",
            cls, fmin(left, right), top, fabs(right - left), fmax(0.0, bottom - top));
}

void page__phases(const page__plot *p, const double *t, const char *const *phase, int n, double sx)
{
    static const double letter = 6.2; /* [px] */
    for (int i = 0, end, turn = 0; i < n; i = end, turn++) {
        for (end = i + 1; end < n && phase[end] == phase[i]; end++) {
        }
        double from = fmax(p->left, page__x(p, sx * t[i]));
        double to = fmin(p->left + p->width, page__x(p, sx * t[end < n ? end : n - 1]));
        if (!(to > from)) {
            continue;
        }
        if (turn % 2 == 1) {
            fprintf(p->f,
                    "<rect class=\"phase\" x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\"/>",
                    from, p->top, to - from, p->height);
        }
        if (phase[i] != NULL && to - from > letter * (double)strlen(phase[i]) + 3.0) {
            fprintf(p->f, "<text class=\"name\" x=\"%.1f\" y=\"%.1f\">", 0.5 * (from + to),
                    p->top - 4.0);
            page__text(p->f, phase[i]);
            fputs("</text>", p->f);
        }
    }
    putc('\n', p->f);
}
