/* SPDX-License-Identifier: GPL-3.0-or-later
 * table.c - hypotheses, and the rows that fits of them are.
 *
 * A hypothesis may have several rows, one a start; the one of least objective stands for it.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "functions.h"
#include "search.h"

/* ---- hypotheses ---- */

int diag__has(const diag__hypothesis *h, int k)
{
    for (int i = 0; i < h->n; i++) {
        if (h->cause[i] == k) {
            return 1;
        }
    }
    return 0;
}

int diag__contains(const diag__hypothesis *whole, const diag__hypothesis *part)
{
    int yes = 1;
    for (int i = 0; i < part->n; i++) {
        yes &= diag__has(whole, part->cause[i]);
    }
    return yes;
}

diag__hypothesis diag__with(diag__hypothesis h, int k)
{
    int at = h.n;
    if (diag__has(&h, k) || h.n == DIAG_CAUSES) {
        return h;
    }
    for (; at > 0 && h.cause[at - 1] > k; at--) {
        h.cause[at] = h.cause[at - 1];
    }
    h.cause[at] = k;
    h.n++;
    return h;
}

diag__hypothesis diag__without(diag__hypothesis h, int k)
{
    diag__hypothesis to = {.n = 0};
    for (int i = 0; i < h.n; i++) {
        if (h.cause[i] != k) {
            to.cause[to.n++] = h.cause[i];
        }
    }
    return to;
}

int diag__equals(const diag__hypothesis *a, const diag__hypothesis *b)
{
    return a->n == b->n && memcmp(a->cause, b->cause, sizeof *a->cause * (size_t)a->n) == 0;
}

/* ---- rows ---- */

int diag__unknown_at(const diag__row *row, int i)
{
    return row->p.first_accepted + FIT__NUMBERS * i;
}

double diag__amount(const diag__row *row, int i, double *sd)
{
    int k = diag__unknown_at(row, i);
    *sd = row->sd[k];
    return row->x[k];
}

int diag__is_far_off(const diag__row *row)
{
    return row == NULL || (row->chi2_dof > diag__seven_noises && row->relative > diag__followed);
}

double diag__most_amount(const lab_candidate *c)
{
    double tenfold = (diag__largest_read - 1.0) * c->number / c->limit;
    return lab_candidate_is_mistakable(c) ? fmax(diag__largest_read, tenfold) : diag__largest;
}

double diag__mistake(const lab_candidate *c, double amount)
{
    return lab_candidate_is_mistakable(c) ? fit__long_tail(amount) - amount * amount : 0.0;
}

int diag__thinkable(const lab_candidate *c, double amount)
{
    return fabs(amount) <= diag__most_amount(c) && (lab_candidate_is_signed(c) || amount > 0.0);
}

int diag__amount_is_possible(const diag__problem *q, const diag__row *row, int i)
{
    double sd, amount = diag__amount(row, i, &sd),
               times = diag__leaves_noise(q, row) ? diag__largest_read : 1.0;
    return diag__thinkable(diag__base(q, row->h.cause[i]), amount / times);
}

int diag__is_possible(const diag__problem *q, const diag__row *row)
{
    int yes = row->failed == NULL && !row->superseded && !row->impossible;
    for (int i = 0; yes && i < row->h.n; i++) {
        yes = diag__amount_is_possible(q, row, i);
    }
    return yes;
}

stein_status diag__table_add(diag__table *t, diag__row *row, stein_err *err)
{
    diag__row **more = realloc(t->row, sizeof *more * (size_t)(t->n + 1));
    if (more == NULL) {
        diag__row_free(row);
        return lab__no_memory(err);
    }
    t->row = more;
    t->row[t->n++] = row;
    return STEIN_OK;
}

void diag__table_free(diag__table *t)
{
    for (int i = 0; i < t->n; i++) {
        diag__row_free(t->row[i]);
    }
    free(t->row);
    diag__linear_free(&t->last);
    *t = (diag__table){.n = 0};
}

diag__row *diag__find(const diag__table *t, const diag__hypothesis *h)
{
    diag__row *best = NULL;
    for (int i = 0; i < t->n; i++) {
        diag__row *row = t->row[i];
        if (!row->superseded && diag__equals(&row->h, h) &&
            (best == NULL || row->objective < best->objective)) {
            best = row;
        }
    }
    return best;
}

int diag__index(const diag__table *t, const diag__row *row)
{
    for (int i = 0; i < t->n; i++) {
        if (t->row[i] == row) {
            return i;
        }
    }
    return -1;
}

diag__row *diag__best(const diag__problem *q, const diag__table *t, int n)
{
    diag__row *best = NULL;
    for (int i = 0; i < t->n; i++) {
        diag__row *row = t->row[i];
        if ((n < 0 || row->h.n == n) && diag__is_possible(q, row) &&
            (best == NULL || row->objective < best->objective)) {
            best = row;
        }
    }
    return best;
}

/* unknowns without a prior, which the data decide */
static int flat(const fit__problem *p)
{
    int n = 0;
    for (int k = 0; k < p->nu; k++) {
        n += !p->unknown[k].prior && !p->unknown[k].idle;
    }
    return n;
}

/* Where noise is estimated: beside k unknowns without a prior, n samples of unknown noise v count
 * as n - k; of those one in m counts. */
double diag__weighed(const diag__problem *q, const diag__row *row)
{
    double k = flat(&row->p), dof = (row->p.samples - k) / q->memory;
    return q->scale_free ? dof * stein__log_of(row->chi2_dof) + row->rest : row->objective;
}

void diag__weigh(diag__problem *q, diag__table *t)
{
    const diag__row *least = NULL;
    for (int i = 0; i < t->n; i++) {
        const diag__row *row = t->row[i];
        if (row->failed == NULL && !row->superseded &&
            (least == NULL || row->chi2_dof < least->chi2_dof)) {
            least = row;
        }
    }
    q->memory = least != NULL ? least->memory : 1.0;
    for (int i = 0; i < t->n; i++) {
        diag__row *row = t->row[i];
        if (row->failed == NULL && !row->superseded) {
            row->objective = diag__weighed(q, row);
        }
    }
}

stein_status diag__note_standing(const diag__table *t, diag__standing *kept, stein_err *err)
{
    *kept = (diag__standing){t->n, malloc((size_t)t->n + 1)};
    for (int i = 0; kept->superseded != NULL && i < t->n; i++) {
        kept->superseded[i] = (unsigned char)t->row[i]->superseded;
    }
    return kept->superseded != NULL ? STEIN_OK : lab__no_memory(err);
}

void diag__take_back(diag__problem *q, diag__table *t, const diag__standing *kept)
{
    for (int i = 0; i < t->n; i++) {
        t->row[i]->superseded = i >= kept->rows || kept->superseded[i];
    }
    diag__weigh(q, t);
}

int diag__is_tolerated(const diag__problem *q, int cause)
{
    const lab_candidate *c = diag__base(q, cause);
    return !diag__is_scoped(q, cause) && c->effect->needs == NULL && c->nparam == 1 &&
           diag__has_tolerance(q, c->param[0]);
}

int diag__scatters(const diag__problem *q, int cause)
{
    const lab_candidate *c = diag__base(q, cause);
    return !diag__is_scoped(q, cause) && q->fit_def.scatter && c->nparam > 0 &&
           c->effect->needs == NULL && q->null.group[c->param[0]] != FIT__CALM;
}
