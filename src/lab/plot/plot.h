/* SPDX-License-Identifier: GPL-3.0-or-later
 * plot.h - pictures by gnuplot.
 *
 *   gnuplot.c     a script becomes a picture
 *   plot_run.c    a run as a picture
 *   plot_sweep.c  a sweep as a picture
 *
 * Included by: src/lab/study, src/cli.
 */
#ifndef LAB_PLOT_H
#define LAB_PLOT_H

#include "io.h"

/* ---- gnuplot.c ---- */

typedef void lab__script_fn(FILE *f, const void *ctx);
/** Draw a picture of width x height, .svg or .png (1.5 times as many pixels), with the script that
 *  `write` writes; terminal and output are set before. @return OK, EIO, EINVAL (other ending) */
stein_status lab__gnuplot(const char *path, int width, int height, lab__script_fn *write,
                          const void *ctx, stein_err *err);
/** Does the name end in .svg or .png? @return OK, EINVAL */
stein_status lab__picture_name(const char *path, stein_err *err);
/** A text in single quotes. */
void lab__quoted(FILE *f, const char *text);

#endif
