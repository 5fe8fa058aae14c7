/* SPDX-License-Identifier: GPL-3.0-or-later
 * simpler.c - hypotheses that follow from rows alone, without a linear model.
 *
 *      without a cause whose amount may be 0, from where the fit with it ended
 *      with a cause in all records that begins at one
 *      without any cause, from where a better end of that fit is expected
 */
#include <math.h>

#include "proposals.h"

static const double shorter = 0.1; /* share of an amount from which a fit is repeated */

/* Rows of a hypothesis; of those that one proposer made, the ones from other rows than `parent`. */
int diag__tries(const diag__table *t, const diag__hypothesis *h, const diag__proposer *by,
                int parent)
{
    int n = 0;
    for (int i = 0; i < t->n; i++) {
        const diag__row *row = t->row[i];
        int counts = by == NULL || (row->by == by && row->parent != parent);
        n += counts && !row->superseded && !row->shorter && diag__equals(&row->h, h);
    }
    return n;
}

/* Has the fit of a row with causes more than its parent ended above that one, which it contains? */
static int is_behind(const diag__problem *q, const diag__row *row, const diag__row *parent)
{
    int more = row->h.n > parent->h.n && diag__contains(&row->h, &parent->h);
    return more && !parent->superseded && row->rough == parent->rough && row->failed == NULL &&
           !q->scale_free && row->objective > parent->objective + diag__unended();
}

/* the same from smaller amounts of the new causes: the linear model has promised too much */
static void shorten(diag__proposal *p, const diag__row *parent)
{
    for (int i = 0; i < p->h.n; i++) {
        p->amount[i] *= diag__has(&parent->h, p->h.cause[i]) ? 1.0 : shorter;
    }
}

/* Fits a proposal, from smaller amounts again where it ends above its parent, and writes the trace.
 * @param one  out: the best of its rows */
stein_status diag__try(diag__problem *q, diag__table *t, const diag__proposal *p, diag__row **one,
                       stein_err *err)
{
    diag__proposal from = *p;
    const diag__row *parent = p->parent >= 0 ? t->row[p->parent] : NULL;
    stein_status status = STEIN_OK;
    *one = NULL;
    for (int k = 0; k < DIAG_TRIES && status == STEIN_OK; k++) {
        diag__row *row = NULL;
        status = diag__evaluate(q, t, &from, &row, err);
        if (row == NULL) {
            break;
        }
        row->shorter = k > 0;
        if (q->trace != NULL) {
            diag__trace_row(q->trace, q, t, row);
        }
        if (*one == NULL || row->objective < (*one)->objective) {
            *one = row;
        }
        if (parent == NULL || diag__is_spent(q) || !is_behind(q, row, parent)) {
            break;
        }
        shorten(&from, parent);
    }
    return status;
}

/* a row's hypothesis without cause i, or with it in all records where it begins at one */
static diag__proposal simpler(const diag__problem *q, const diag__table *t, const diag__row *row,
                              int i, const diag__proposer *by)
{
    int cause = row->h.cause[i];
    diag__proposal p = diag__as_parent(diag__without(row->h, cause), diag__index(t, row), by);
    if (!by->removes) {
        p.h = diag__with(p.h, (int)(diag__base(q, cause) - q->candidate));
    }
    return p;
}

/* A row with a cause whose amount may be 0, or is of no possible sign, is fitted without it, from
 * the row's end. That needs no linear model. The row without the cause is then linearised. Where it
 * was fitted before and ended worse than is expected, that was another minimum. */
stein_status diag__drop_idle(diag__problem *q, diag__table *t, const diag__row *row, stein_err *err)
{
    stein_status status = STEIN_OK;
    for (int i = 0; i < row->h.n && row->h.n > 1 && status == STEIN_OK; i++) {
        double sd, amount = diag__amount(row, i, &sd), z = amount / sd;
        int idles = fabs(z) < diag__interval || !diag__amount_is_possible(q, row, i);
        diag__proposal p = simpler(q, t, row, i, &diag__propose_drop);
        const diag__row *had = diag__find(t, &p.h);
        int better = had == NULL || (row->objective + z * z < had->objective - diag__worth() &&
                                     diag__tries(t, &p.h, &diag__propose_drop, -1) < DIAG_TRIES);
        diag__row *one = NULL;
        if (idles && better && !diag__is_spent(q)) {
            status = diag__try(q, t, &p, &one, err);
        }
        if (status == STEIN_OK && one != NULL && one == diag__incumbent(q, t)) {
            return diag__drop_idle(q, t, one, err);
        }
    }
    return status;
}

/* The row was linearised, is still the best, leaves more than noise and has a cause that begins at
 * a record. Such a cause may replace the same cause in all records, which the model lacks.
 */
stein_status diag__everywhere(diag__problem *q, diag__table *t, const diag__row *row,
                              stein_err *err)
{
    stein_status status = STEIN_OK;
    int open = row == diag__incumbent(q, t) && !diag__leaves_noise(q, row);
    for (int i = 0; i < row->h.n && status == STEIN_OK && open; i++) {
        const lab_candidate c = diag__candidate(q, row->h.cause[i]);
        diag__proposal p = simpler(q, t, row, i, &diag__propose_exchange);
        diag__row *one;
        if (c.from > 0 && c.until == 0 && diag__find(t, &p.h) == NULL && !diag__is_spent(q)) {
            status = diag__try(q, t, &p, &one, err);
        }
    }
    return status;
}

/* The row whose end lets expect a better fit without a cause than the null row, NULL: none. With a
 * cause of amount a +- sd the fit without it is worth (a/sd)^2 less. Where the null row ended far
 * off and the best row came nearer, its numbers and initial states may be the reason. */
static const diag__row *start_of_null(const diag__problem *q, const diag__table *t,
                                      const diag__row *null)
{
    const diag__row *best = diag__incumbent(q, t), *from = NULL;
    double least = null->objective - diag__worth();
    for (int i = 0; i < t->n; i++) {
        const diag__row *row = t->row[i];
        double sd, z = row->h.n == 1 && diag__is_possible(q, row) ? diag__amount(row, 0, &sd) / sd
                                                                  : (double)INFINITY;
        if (row->objective + z * z < least && row->rough == null->rough) {
            least = row->objective + z * z;
            from = row;
        }
    }
    int lost = best->h.n > 0 && !(null->converged && null->chi2_dof < diag__five_noises()) &&
               best->chi2_dof < diag__some_of * null->chi2_dof;
    return from == NULL && lost ? best : from;
}

/* The fit without a cause begins at the file's numbers; once more from where a better end is
 * expected. */
stein_status diag__null_again(diag__problem *q, diag__table *t, diag__row **again, stein_err *err)
{
    const diag__row *null = diag__best(q, t, 0);
    const diag__row *from = null != NULL ? start_of_null(q, t, null) : NULL;
    *again = NULL;
    int parent = from != NULL ? diag__index(t, from) : -1, had = 0;
    for (int i = 0; i < t->n; i++) {
        const diag__row *row = t->row[i];
        had |= row->h.n == 0 && row->by == &diag__propose_drop && row->parent == parent;
    }
    if (from == NULL || had || diag__is_spent(q)) {
        return STEIN_OK;
    }
    const diag__proposal p =
        diag__as_parent((diag__hypothesis){.n = 0}, parent, &diag__propose_drop);
    stein_status status = diag__try(q, t, &p, again, err);
    if (*again != diag__best(q, t, 0)) {
        *again = NULL;
    }
    return status;
}
