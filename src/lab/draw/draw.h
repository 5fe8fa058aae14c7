/* SPDX-License-Identifier: GPL-3.0-or-later
 * draw.h - a mechanism as a drawing with names: SVG.
 * Included by: src/cli.
 *
 *   place.c  where bodies, points and shapes are, in the plane of the drawing
 *   label.c  names that do not cover each other
 *   draw.c   the drawing
 */
#ifndef LAB_DRAW_H
#define LAB_DRAW_H

#include "open.h"

/** Draw the mechanism in the state of its file.
 *  @param path  of the SVG; "-" is standard output
 *  @return OK, EIO, ENOMEM, or why there is no initial state */
stein_status lab__draw(const char *path, const lab_model *model, stein_err *err);

/* ---- place.c ---- */

typedef struct draw__frame {
    double R[3][3], o[3]; /* axes as columns, origin [m], in the fixed frame */
} draw__frame;

typedef struct draw__place {
    const mechanism *m;
    const double *p;    /* [nparam] */
    draw__frame *frame; /* [nbody] */
    int right, up;      /* axes of the plane */
} draw__place;

/** A point of the plane [m]. */
typedef struct draw__at {
    double x, y;
} draw__at;

/** Frames of all bodies. @param p [nparam], q [nbody], both kept or read  @return OK, ENOMEM */
stein_status draw__place_init(draw__place *place, const mechanism *m, const double *p,
                              const double *q, stein_err *err);
void draw__place_free(draw__place *place);
/** A vector in the axes of a body (-1: frame), seen in the plane. */
draw__at draw__point(const draw__place *place, int body, const mech_scalar v[3]);
draw__at draw__origin(const draw__place *place, int body);
/** Direction at an angle of a body's plane. */
draw__at draw__direction(const draw__place *place, int body, double angle);
double draw__value(const draw__place *place, mech_scalar s);

/* ---- label.c ---- */

enum { DRAW_LABELS = 400 };
typedef struct draw__label {
    double x0, y0, x1, y1; /* box [px] */
} draw__label;
typedef struct draw__labels {
    draw__label taken[DRAW_LABELS];
    int n;
    double width, height; /* of the drawing [px] */
} draw__labels;

/** Keep names off a box. */
void draw__keep_off(draw__labels *all, double x, double y, double half);
/** Write a name near a place [px], where the drawing is empty, with a line to the place if it is
 * far. */
void draw__name(draw__labels *all, FILE *f, double x, double y, const char *kind, const char *name);

#endif
