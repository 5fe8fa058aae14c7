/* SPDX-License-Identifier: GPL-3.0-or-later
 * bench.h - a mechanism file run as a user would, for rows of `make validate`. What fails ends the
 * program with its reason.
 */
#ifndef VALIDATE_BENCH_H
#define VALIDATE_BENCH_H

#include "stein/lab.h"
#include "stein/stein.h"

/** A mechanism in its initial state. */
typedef struct bench {
    lab_model *model;
    stein_sim *sim;
} bench;

bench bench_start(const char *file);
void bench_end(bench *b);
void bench_run(const bench *b, double t);
double bench_read(const bench *b, const char *channel);
/** Kinetic and potential (gravity). */
double bench_energy(const bench *b);
/** Of f from .. to, to 12 digits. */
double bench_integral(double (*f)(double, void *), void *ctx, double from, double to);
/** Text of a number in a cell; text [64]. */
const char *bench_cell(char *text, const char *format, double value);
void bench_stop(const stein_err *err);

/** Rows of linkages.c and contacts.c. */
void validate_linkages(void);
void validate_contacts(void);

#endif
