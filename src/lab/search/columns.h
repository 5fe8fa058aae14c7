/* SPDX-License-Identifier: GPL-3.0-or-later
 * columns.h - columns of a linear model while they are computed.
 * Included by: this folder.
 */
#ifndef DIAG_COLUMNS_H
#define DIAG_COLUMNS_H

#include "search.h"

/** What a candidate changes, per limit. */
typedef struct diag__secant {
    int cause, ready; /* 1: it is there already */
    double step;
    double *G;
    const char *why; /* it shows nothing; NULL: it does */
} diag__secant;

/** A row, and what is made of it. */
typedef struct diag__work {
    diag__problem *q;
    const diag__row *row;
    fit__problem p; /* of the records that are used */
    lab_dataset records;
    double *x, *r, *J;
    diag__secant *column; /* [n] the row's own causes first */
    int n;
} diag__work;

/** Fills the columns behind the row's own causes, G [rows] of each allocated.
 *  @return OK, ENOMEM, numerical failures */
stein_status diag__fill_columns(diag__work *w, stein_err *err);

#endif
