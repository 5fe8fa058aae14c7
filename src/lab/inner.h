/* SPDX-License-Identifier: GPL-3.0-or-later
 * inner.h - what the files of the lab share with each other and with the commands. Not installed.
 *
 *   open.c     mechanism file -> equations     output.c   numbers, files that appear whole
 *   compile.c  equations -> shared object      json.c     JSON
 *   strike.c   one stroke, by its events       process.c  other programs: cc, gnuplot
 *   record.c   samples, CSV                    plot.c     a stroke as a picture
 *   sweep.c    many strokes on threads         drive.c    inputs from a CSV file
 *   facts.c    the paper against strokes       study.c    section 5 of the paper
 *   gnuplot.c  a script becomes a picture
 *   grid.c     points from --vary              table.c    results of a sweep, keyed by point
 *   batch.c    many simulations on threads     journal.c  finished points, safe from kill -9
 */
#ifndef LAB_INNER_H
#define LAB_INNER_H

#include <stddef.h>
#include <stdio.h>

#include "gen.h"
#include "mechanism.h"
#include "stein/lab.h"
#include "stein/load.h"

/** Fill err (nullable) with a printf-like message and return the code. */
stein_status lab__fail(stein_err *err, stein_status code, const char *format, ...);
/** A new string from a printf-like format; NULL without memory. The caller frees it. */
char *lab__text(const char *format, ...);

/* ---- output.c ---- */

enum { LAB_NUMBER = 32 };
/** The shortest decimal that reads back as exactly this double; a point whatever the locale.
 *  @param text  [LAB_NUMBER] out, returned */
char *lab__number(char *text, double value);

/** A file that appears whole or not at all: written beside its place, then renamed. Devices, pipes
 *  and "-" (standard output) are written directly. */
typedef struct lab__file {
    FILE *stream;
    char *path, *temporary; /* temporary NULL: written directly */
} lab__file;
stein_status lab__file_open(lab__file *file, const char *path, stein_err *err);
/** Put the file in its place, or with keep = 0 drop it. @return OK, EIO */
stein_status lab__file_close(lab__file *file, int keep, stein_err *err);
/** Is this path the standard output? */
int lab__is_stdout(const char *path);
/** A folder with all its parents. @return OK, EIO */
stein_status lab__folder(const char *path, stein_err *err);

/* ---- json.c ---- */

enum { LAB_JSON_DEPTH = 16 };
/** Writer of one JSON value. Keys are NULL inside lists. */
typedef struct lab__json {
    FILE *stream;
    int depth;
    int filled[LAB_JSON_DEPTH]; /* has this level an entry? */
    char closing[LAB_JSON_DEPTH];
} lab__json;
void lab__json_open(lab__json *j, const char *key, char bracket); /* '{' or '[' */
void lab__json_close(lab__json *j);
void lab__json_text(lab__json *j, const char *key, const char *value); /* NULL: null */
void lab__json_real(lab__json *j, const char *key, double value);      /* not finite: null */
void lab__json_int(lab__json *j, const char *key, int value);
void lab__json_bool(lab__json *j, const char *key, int value);
void lab__json_null(lab__json *j, const char *key);

/* ---- process.c ---- */

/** Run a program found in PATH and wait for it; its output goes to the file `log`.
 *  @param code  its exit code; 127 when there is no such program, 128 + n when signal n ended it
 *  @return OK, EIO */
stein_status lab__spawn(char *const argv[], const char *log, int *code, stein_err *err);

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

/* ---- compile.c ---- */

/** Equations of a mechanism from the cache, compiled into it when they are absent or stale. */
stein_status lab__compiled(stein_library **library, const stein_model **model, const mechanism *m,
                           const gen_result *equations, const lab_options *options,
                           stein_err *err);

/* ---- strike.c ---- */

/** Output channel that reads `read` of thing `index`, counted absolutely; -1 when there is none. */
int lab__channel_of(const stein_model *model, stein_read_kind read, int index);

/* ---- record.c ---- */

int lab__record_rows(const lab_record *record);
double lab__record_at(const lab_record *record, int row, int channel);

#endif
