/* SPDX-License-Identifier: GPL-3.0-or-later
 * scope_columns.h - which causes of a part of the records are worth a column.
 * Included by: this folder.
 */
#ifndef DIAG_SCOPE_COLUMNS_H
#define DIAG_SCOPE_COLUMNS_H

#include "search.h"

enum { DIAG_SCOPED = 32 }; /* columns of causes in a part of the records, at most */

/** Causes of a part of the records that are worth a column.
 *  @param p      of the records that are used
 *  @param m      weighed, its candidates those of `base`
 *  @param base   [nbase] candidates; the first ones are the row's own causes
 *  @param cause  [DIAG_SCOPED] out, n of them  @return OK, ENOMEM */
stein_status diag__choose_scopes(const diag__problem *q, const diag__row *row,
                                 const fit__problem *p, const lab__mixed *m, const int *base,
                                 int nbase, int *cause, int *n, stein_err *err);

#endif
