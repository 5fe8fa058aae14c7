/* SPDX-License-Identifier: GPL-3.0-or-later
 * single_causes.c - single causes one by one, where nothing that a linear model promised leaves
 * noise.
 *
 * Far from the records a linear model ranks causes poorly. The effect of a large cause is not that
 * of a small one, and a missing cause distorts the numbers of the null hypothesis. Then each cause
 * that has no row yet is fitted, the best expected ones first, with as much work as the search has
 * taken so far.
 *
 * A long swing with friction and a wrong length has another phase than every start. Then no row is
 * near, and rows that ended far off give no evidence about their hypotheses. A cause is then ranked
 * by how far it follows the records from their beginning, with the numbers of the file at the
 * start. The best ones are fitted over horizons that grow from there.
 */
#include <math.h>
#include <stdlib.h>

#include "proposals.h"

const diag__proposer diag__step_single = {.letter = 'E', .name = "single causes one by one"};

/* the proposal of column a, its amount within its limit and of a possible sign */
static int single(const diag__problem *q, const diag__linear *l, int a, diag__proposal *to)
{
    double amount;
    if (diag__is_scoped(q, l->cause[a]) || !diag__proposal_of(l, &a, 1, &amount, to)) {
        return 0;
    }
    const lab_candidate *c = diag__base(q, l->cause[a]);
    amount = fmin(fmax(amount, -1.0), 1.0);
    to->amount[0] = lab_candidate_is_signed(c) ? amount : fabs(amount);
    to->by = &diag__step_single;
    to->held = l->gain > 0.0;
    return 1;
}

/* the causes that follow the records furthest first, equal ones in their order */
static stein_status rank_by_reach(diag__problem *q, const diag__linear *l, diag__ranked *list,
                                  int n, stein_err *err)
{
    stein_status status = STEIN_OK;
    long most = 2 * q->strokes;
    for (int i = 0; i < n && status == STEIN_OK && !diag__is_spent(q) && q->strokes < most; i++) {
        diag__proposal p;
        double until = 0.0;
        single(q, l, list[i].a, &p);
        p.rough = l->row->rough;
        status = diag__reach(q, &p, &until, err);
        list[i].expected = -until;
        list[i].b = i;
    }
    diag__rank(list, n);
    return status;
}

static stein_status try_columns(diag__problem *q, diag__table *t, const diag__linear *l,
                                stein_err *err)
{
    diag__ranked list[DIAG_COLUMNS];
    diag__proposal p;
    int n = 0, found = 0, anew = diag__is_far_off(diag__incumbent(q, t));
    long most = 2 * q->strokes;
    for (int a = 0; a < l->n && n < DIAG_COLUMNS; a++) {
        if (single(q, l, a, &p) && (anew || diag__find(t, &p.h) == NULL)) {
            list[n++] = (diag__ranked){a, -1, p.expected};
        }
    }
    diag__rank(list, n);
    stein_status status = STEIN_OK;
    if (anew) {
        n = n < DIAG_POOL ? n : DIAG_POOL;
        status = rank_by_reach(q, l, list, n, err);
        most += 2 * q->strokes;
    }
    for (int i = 0; i < n && i < (anew ? DIAG_FEW_FITS : DIAG_POOL) && !found &&
                    status == STEIN_OK && q->strokes < most;
         i++) {
        diag__row *one = NULL;
        single(q, l, list[i].a, &p);
        p.parent = anew ? -1 : diag__index(t, l->row);
        p.rough = l->row->rough;
        if ((anew || diag__find(t, &p.h) == NULL) && !diag__is_spent(q)) {
            status = diag__try(q, t, &p, &one, err);
        }
        found = one != NULL && diag__is_possible(q, one) &&
                (anew ? !diag__is_far_off(one) : diag__leaves_noise(q, one));
    }
    return status;
}

stein_status diag__try_each(diag__problem *q, diag__table *t, stein_err *err)
{
    const diag__row *null = diag__best(q, t, 0), *best = diag__incumbent(q, t);
    diag__linear l;
    stein_err why = {STEIN_OK, ""};
    int found = null == NULL || diag__leaves_noise(q, best) ||
                (best->h.n > 0 && !diag__is_far_off(best) &&
                 best->chi2_dof - 1.0 < diag__some_of * (null->chi2_dof - 1.0));
    if (found || diag__is_spent(q)) {
        return STEIN_OK;
    }
    stein_status status =
        diag__linearise(q, null, diag__observer_gain(null), DIAG_FEW_RECORDS, &l, &why);
    status = status == STEIN_OK ? try_columns(q, t, &l, err) : fit__forgive(status, err);
    diag__linear_free(&l);
    return status;
}
