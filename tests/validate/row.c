/* SPDX-License-Identifier: GPL-3.0-or-later
 * row.c - rows of `make validate` (validate.h). The last cell of a row is its picture, an SVG in
 * one line.
 */
#include "validate.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

enum { POINTS = 20000, WIDTH = 300, HEIGHT = 150, LEFT = 58, BOTTOM = 30, EDGE = 6, DRAWN = 600 };

static int failed;
static clock_t last;

static struct {
    struct {
        double x, y;
    } point[VALIDATE_CURVES][POINTS];
    int n[VALIDATE_CURVES], shown; /* 1: it was a row's already */
    char x[40], y[40];
    double low[2], high[2];
} picture;

static void begin_picture(void)
{
    if (picture.shown) {
        memset(picture.n, 0, sizeof picture.n);
        picture.shown = 0;
    }
}

void validate_point(int curve, double x, double y)
{
    begin_picture();
    if (picture.n[curve] < POINTS) {
        picture.point[curve][picture.n[curve]].x = x;
        picture.point[curve][picture.n[curve]++].y = y;
    }
}

void validate_axes(const char *x, const char *y)
{
    begin_picture();
    snprintf(picture.x, sizeof picture.x, "%s", x);
    snprintf(picture.y, sizeof picture.y, "%s", y);
}

/* @return points there are */
static int find_range(void)
{
    int n = 0;
    for (int k = 0; k < 2; k++) {
        picture.low[k] = INFINITY;
        picture.high[k] = -INFINITY;
    }
    for (int c = 0; c < VALIDATE_CURVES; c++) {
        for (int i = 0; i < picture.n[c]; i++) {
            double at[2] = {picture.point[c][i].x, picture.point[c][i].y};
            for (int k = 0; k < 2 && isfinite(at[0]) && isfinite(at[1]); k++) {
                picture.low[k] = fmin(picture.low[k], at[k]);
                picture.high[k] = fmax(picture.high[k], at[k]);
                n += k;
            }
        }
    }
    for (int k = 0; k < 2; k++) {
        double least = 1e-12 + 1e-9 * fabs(picture.low[k]);
        picture.high[k] = fmax(picture.high[k], picture.low[k] + least);
    }
    return n;
}

static double across(double x)
{
    return LEFT + (WIDTH - LEFT - EDGE) * (x - picture.low[0]) / (picture.high[0] - picture.low[0]);
}

static double down(double y)
{
    return EDGE +
           (HEIGHT - BOTTOM - EDGE) * (picture.high[1] - y) / (picture.high[1] - picture.low[1]);
}

static void draw_line(int c)
{
    static const char *const colour[] = {"#1f5fa8", "#c2571a", "#3a8a3a"};
    int stride = 1 + picture.n[c] / DRAWN, pen = 0;
    printf("<path fill=\"none\" stroke=\"%s\" stroke-width=\"1.3\" d=\"", colour[c]);
    for (int i = 0; i < picture.n[c]; i += stride) {
        double x = picture.point[c][i].x, y = picture.point[c][i].y;
        if (isfinite(x) && isfinite(y)) {
            printf("%c%.1f %.1f", pen ? 'L' : 'M', across(x), down(y));
        }
        pen = isfinite(x) && isfinite(y);
    }
    printf("\"/>");
}

static void draw(void)
{
    int right = WIDTH - EDGE, low = HEIGHT - BOTTOM;
    printf("<svg viewBox=\"0 0 %d %d\" width=\"%d\" height=\"%d\" font-family=\"sans-serif\" "
           "font-size=\"11\">",
           WIDTH, HEIGHT, WIDTH, HEIGHT);
    printf("<path fill=\"none\" stroke=\"#888\" d=\"M%d %dV%dH%d\"/>", LEFT, EDGE, low, right);
    for (int c = 0; c < VALIDATE_DOTS; c++) {
        if (picture.n[c] > 0) {
            draw_line(c);
        }
    }
    for (int i = 0; i < picture.n[VALIDATE_DOTS]; i++) {
        double x = picture.point[VALIDATE_DOTS][i].x, y = picture.point[VALIDATE_DOTS][i].y;
        if (isfinite(x) && isfinite(y)) {
            printf("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"1.8\" fill=\"#222\"/>", across(x), down(y));
        }
    }
    printf("<g fill=\"#333\"><text x=\"%d\" y=\"%d\">%.3g</text>", LEFT, low + 12, picture.low[0]);
    printf("<text x=\"%d\" y=\"%d\" text-anchor=\"end\">%.3g</text>", right, low + 12,
           picture.high[0]);
    printf("<text x=\"%d\" y=\"%d\" text-anchor=\"middle\">%s</text>", (LEFT + right) / 2, low + 24,
           picture.x);
    printf("<text x=\"%d\" y=\"%d\" text-anchor=\"end\">%.3g</text>", LEFT - 3, low,
           picture.low[1]);
    printf("<text x=\"%d\" y=\"%d\" text-anchor=\"end\">%.3g</text>", LEFT - 3, EDGE + 9,
           picture.high[1]);
    printf("<text transform=\"translate(12 %d) rotate(-90)\" text-anchor=\"middle\">%s</text></g>",
           (EDGE + low) / 2, picture.y);
    printf("</svg>");
}

void validate_row(const char *problem, const char *source, const char *reference, const char *ours,
                  double error, double bar)
{
    int is_fact = isnan(bar), passed = is_fact ? error == 0.0 : error <= bar;
    double took = (double)(clock() - last) / CLOCKS_PER_SEC;
    failed += !passed;
    printf("%s\t%s\t%s\t%s\t", problem, source, reference, ours);
    if (is_fact) {
        printf("\t\t%s\t", passed ? "yes" : "NO");
    } else {
        printf("%.1e\t%.0e\t%s\t", error, bar, passed ? "yes" : "NO");
    }
    if (took >= 5e-4) {
        printf("%.2g", took);
    }
    printf("\t");
    if (!picture.shown && find_range() > 0) {
        draw();
    }
    picture.shown = 1;
    printf("\n");
    last = clock();
}

int validate_failed(void)
{
    return failed;
}
