/* SPDX-License-Identifier: GPL-3.0-or-later
 * scope_columns.c - which causes of a part of the records are worth a column of a linear model.
 *
 * Every candidate may begin at every record, every setting may be wrong in every record: two
 * thousand columns, which are all scored from those of the candidates (shares.c). A few are kept:
 * those that gain most beside the row's causes, and those that gain most in the place of one of
 * them. Where a candidate gains as much in all records, that is the simpler cause.
 */
#include <math.h>
#include <stdlib.h>

#include "scope_columns.h"

/* a cause of a part of the records */
typedef struct ranked {
    int cause, base; /* base: column */
    double gain;
} ranked;

typedef struct chooser {
    const diag__problem *q;
    const fit__problem *p; /* of the records that are used */
    const diag__row *row;
    const int *base; /* [n] candidate of each column */
    int n, first;    /* columns from the first one on are no own causes */
    lab__shares shares;
    ranked *list;
    int nlist;
} chooser;

static int by_gain(const void *a, const void *b)
{
    const ranked *x = a, *y = b;
    return x->gain > y->gain ? -1 : x->gain < y->gain;
}

/* column k in records first .. last, if that gains more than `least` */
static void weigh(chooser *c, int k, int cause, int first, int last, double least)
{
    double amount, gain = lab__shares_gain(&c->shares, k, first, last, &amount);
    gain -= diag__price(c->q, cause);
    if (gain > least && diag__thinkable(diag__base(c->q, cause), amount) &&
        !diag__has(&c->row->h, cause)) {
        c->list[c->nlist++] = (ranked){cause, k, gain};
    }
}

/* does the record state the setting, and may it be wrong? */
static int states(const lab_data *data, int param)
{
    for (int i = 0; i < data->nset; i++) {
        if (data->set[i].param == param) {
            return !data->set[i].last_word;
        }
    }
    return 0;
}

static void weigh_all(chooser *c, int k)
{
    const lab_candidate *of = diag__base(c->q, c->base[k]);
    int n = c->p->nstroke, setting = of->effect->site == LAB_AT_SETTING;
    double amount, all = setting ? 0.0 : lab__shares_gain(&c->shares, k, 0, n - 1, &amount);
    for (int s = 0; setting && s < n; s++) {
        const lab_data *data = c->p->stroke[s].data;
        if (states(data, of->param[0])) {
            weigh(c, k, diag__in_record(c->q, c->base[k], data->number), s, s, 0.0);
        }
    }
    for (int s = DIAG_EACH_SIDE; !setting && s <= n - DIAG_EACH_SIDE; s++) {
        int cause = diag__from_record(c->q, c->base[k], c->p->stroke[s].data->number);
        weigh(c, k, cause, s, n - 1, fmax(0.0, all + diag__convincing));
    }
}

/* The best of the list, behind those that are there: pairs for the few proposals that are fitted.
 * @return how many there are then */
static int take_best(chooser *c, int *cause, int n)
{
    int kept = 0;
    qsort(c->list, (size_t)c->nlist, sizeof *c->list, by_gain);
    for (int i = 0; i < c->nlist && kept < 2 * DIAG_FEW_FITS && n < DIAG_SCOPED; i++) {
        int same = 0, there = 0;
        for (int k = 0; k < i; k++) {
            same += c->list[k].base == c->list[i].base;
        }
        for (int k = 0; k < n; k++) {
            there |= cause[k] == c->list[i].cause;
        }
        if (same < DIAG_TRIES && !there) {
            cause[n++] = c->list[i].cause;
            kept++;
        }
    }
    return n;
}

/* beside the causes `with` of the row */
static stein_status choose(chooser *c, const lab__mixed *m, const int *with, int nwith, int *cause,
                           int *n, stein_err *err)
{
    stein_status status = lab__shares_make(&c->shares, m, with, nwith, err);
    c->nlist = 0;
    for (int k = c->first; status == STEIN_OK && k < c->n; k++) {
        if (diag__base(c->q, c->base[k])->effect->needs == NULL) {
            weigh_all(c, k);
        }
    }
    *n = status == STEIN_OK ? take_best(c, cause, *n) : *n;
    lab__shares_free(&c->shares);
    return status;
}

stein_status diag__choose_scopes(const diag__problem *q, const diag__row *row,
                                 const fit__problem *p, const lab__mixed *m, const int *base,
                                 int nbase, int *cause, int *n, stein_err *err)
{
    chooser c = {.q = q, .p = p, .row = row, .base = base, .n = nbase, .first = row->h.n};
    size_t most = (size_t)nbase * (size_t)p->nstroke + 1;
    int own[DIAG_CAUSES] = {0, 1, 2};
    *n = 0;
    c.list = malloc(sizeof *c.list * most);
    stein_status status = c.list != NULL ? STEIN_OK : lab__no_memory(err);
    if (status == STEIN_OK && row->h.n < DIAG_CAUSES) {
        status = choose(&c, m, own, row->h.n, cause, n, err);
    }
    for (int i = 0; status == STEIN_OK && i < row->h.n; i++) {
        int others[DIAG_CAUSES], k = 0;
        for (int a = 0; a < row->h.n; a++) {
            if (a != i) {
                others[k++] = a;
            }
        }
        status = choose(&c, m, others, k, cause, n, err);
    }
    free(c.list);
    return status;
}
