/* SPDX-License-Identifier: GPL-3.0-or-later
 * diagnosis_page.h - shared by the files of report.html.
 *
 *   diagnosis_page.c   the page, its style              diagnosis_chart.c  axes and curves
 *   diagnosis_summary.c  the first screen
 *   diagnosis_plots.c  strokes over time, forces          diagnosis_text.c   texts and numbers
 *   diagnosis_lists.c  maps, bars and tables             diagnosis_detectability.c   every
 * candidate
 * Included by: this folder, src/cli, src/lab/law, src/lab/verdict.
 */
#ifndef DIAGNOSIS_PAGE_H
#define DIAGNOSIS_PAGE_H

#include "diagnosing.h"

/* ---- diagnosis_text.c ---- */

/** Text with everything escaped that HTML reads, also quotes. NULL: nothing. */
void page__text(FILE *f, const char *text);
/** A name of the library in words: "quadratic_drag" as "quadratic drag". */
void page__words(FILE *f, const char *name);
/** "quadratic drag of the hammer". */
void page__cause(FILE *f, const lab_candidate *candidate);

/** What a cause changes in the file (lab_change_text). @return 0: nothing */
int page__change(FILE *f, const lab_suspect *cause);

enum { PAGE_UNIT = 48 };
/** A unit in a size that suits a typical value: shown = factor * SI. */
typedef struct page__unit {
    double factor;
    char name[PAGE_UNIT];
} page__unit;
page__unit page__unit_for(const char *unit, double typical);
/** The name of a unit, powers raised. */
void page__unit_name(FILE *f, const char *name);
/** A number of so many significant digits, large and small ones with a power of ten. */
void page__number(FILE *f, double value, int digits);
/** The same with its unit. */
void page__quantity(FILE *f, double value, const char *unit, int digits);
/** An error of a channel, in the unit of the records where that is another one than of SI. */
void page__error(FILE *f, const lab_gain *gain, double value);
/** Value, interval and unit, rounded as the interval deserves. */
void page__interval(FILE *f, double value, double lo, double hi, const char *unit);

/* ---- diagnosis_chart.c ---- */

/** A plot: data coordinates on a rectangle of an SVG element. */
typedef struct page__plot {
    FILE *f;
    double left, top, width, height; /* [px] */
    double x0, x1, y0, y1;           /* data at its sides */
    double caption;                  /* name of the y axis, above the plot by this [px] */
} page__plot;
double page__x(const page__plot *p, double x);
double page__y(const page__plot *p, double y);
void page__svg_open(FILE *f, int width, int height, const char *what);
void page__svg_close(FILE *f);
/** Grid, numbers along the axes; labels may be NULL, xlabel NULL also leaves out its numbers. */
void page__axes(const page__plot *p, const char *xlabel, const char *ylabel);
/** A curve, interrupted where it is not finite. x and y are multiplied by sx and sy. */
void page__curve(const page__plot *p, const char *cls, const double *x, const double *y, int n,
                 double sx, double sy);
void page__dots(const page__plot *p, const char *cls, const double *x, const double *y, int n,
                double sx, double sy);
/** The area between lo and hi. */
void page__band(const page__plot *p, const char *cls, const double *x, const double *lo,
                const double *hi, int n, double sx, double sy);
/** Text of a tip for sample i. */
typedef void page__tip_fn(FILE *f, const void *ctx, int i);
/** Strips over the plot that show their values when a pointer rests on them, for samples with a y.
 */
void page__tips(const page__plot *p, const double *x, const double *y, int n, double sx,
                page__tip_fn *tip, const void *ctx);
/** A rectangle between data coordinates. */
void page__rect(const page__plot *p, const char *cls, double x0, double x1, double y0, double y1);
/** Where phases change, and their names above the plot where there is room. */
void page__phases(const page__plot *p, const double *t, const char *const *phase, int n, double sx);
/** Limits that hold [lo, hi] with a margin; a nonempty range. */
void page__range(double *lo, double *hi, double margin);

/* ---- diagnosis_summary.c ---- */

void page__summary(FILE *f, const lab_diagnosis *d);

/* ---- diagnosis_plots.c ---- */

void page__strokes(FILE *f, const lab_diagnosis *d);
void page__forces(FILE *f, const lab_diagnosis *d);

/* ---- diagnosis_detectability.c ---- */

void page__seen(FILE *f, const lab_diagnosis *d);

/* ---- diagnosis_lists.c ---- */

/** Significance from which on a cell of the map has a colour. */
extern const double page__least_z;
void page__map(FILE *f, const lab_diagnosis *d);
void page__suspects(FILE *f, const lab_diagnosis *d);
void page__gains(FILE *f, const lab_diagnosis *d);
void page__law(FILE *f, const lab_diagnosis *d);    /* curve_show.c */
void page__motion(FILE *f, const lab_diagnosis *d); /* motion_show.c */
void page__audit(FILE *f, const lab_diagnosis *d);
void page__parameters(FILE *f, const lab_diagnosis *d);

#endif
