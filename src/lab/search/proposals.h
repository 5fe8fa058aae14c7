/* SPDX-License-Identifier: GPL-3.0-or-later
 * proposals.h - what the proposers share.
 * Included by: this folder.
 */
#ifndef DIAG_PROPOSALS_H
#define DIAG_PROPOSALS_H

#include "search.h"

enum { DIAG_COLUMNS = 1000 }; /* of a linear model that are ranked, at most */

/** Columns of a proposal with what it lets expect; b: a second column, a cause, or -1. */
typedef struct diag__ranked {
    int a, b;
    double expected;
} diag__ranked;

/** A hypothesis whose fit begins where that of its parent row ended. */
diag__proposal diag__as_parent(diag__hypothesis h, int parent, const diag__proposer *by);
/** The proposal of a set of columns, amounts as the linear model has them.
 *  @param amount  [n] out  @return 0: it has no solution, or names a cause twice */
int diag__proposal_of(const diag__linear *l, const int *set, int n, double *amount,
                      diag__proposal *to);
/** Are all its amounts of a possible sign and size, and its changes at one record? */
int diag__is_thinkable(const diag__problem *q, const diag__proposal *p);
/** The least expected objective first. */
void diag__rank(diag__ranked *list, int n);

#endif
