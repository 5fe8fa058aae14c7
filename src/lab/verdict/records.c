/* SPDX-License-Identifier: GPL-3.0-or-later
 * records.c - record by record, in their order: what is left without and with the causes, and what
 * the amount of the first cause would be in that record alone.
 *
 *      a_s = a + G_s'V_s^-1 d_s / I_s,   sd = I_s^-1/2,   I_s = G_s'V_s^-1 G_s
 *
 * with the numbers that all records share as fitted; d_s is the residual with the record's own
 * unknowns taken out. A step, a drift or one odd record are seen there.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "verdict.h"

static double rms(const fit__problem *p, const double *r, int s)
{
    const fit__stroke *t = &p->stroke[s];
    const double *v = r + fit__offset(p, s);
    return sqrt(lab__dot(v, v, (size_t)t->nch * (size_t)t->n) / fmax(1.0, t->samples));
}

static lab_seen *add(lab_diagnosis *o, const lab_data *data, int reporting)
{
    lab_seen *to = &o->record[o->nrecord++];
    *to = (lab_seen){.number = data->number,
                     .file = data->file,
                     .reporting = reporting,
                     .before = NAN,
                     .after = NAN,
                     .amount = NAN,
                     .sd = NAN};
    return to;
}

/* of cause i of a row in each record: into the first records of the list */
static stein_status amounts(const diag__row *row, int i, double limit, lab_diagnosis *o,
                            stein_err *err)
{
    const fit__problem *p = &row->p;
    int k = diag__unknown_at(row, i);
    lab__mixed m = {.nf = 0};
    lab__shares h = {.n = 0};
    double *x = malloc(sizeof *x * (size_t)p->nu), *G = diag__column(p, row->J, k);
    const double *column[] = {G};
    stein_status status = x != NULL && G != NULL ? STEIN_OK : lab__no_memory(err);
    if (status == STEIN_OK) {
        memcpy(x, row->x, sizeof *x * (size_t)p->nu);
        memset(x, 0, sizeof *x * (size_t)p->np); // what all share stays as fitted
        status = diag__mixed_at(&m, p, x, row->J, row->r, column, 1, err);
    }
    if (status == STEIN_OK) {
        memcpy(m.D, row->D, sizeof m.D);
        lab__mixed_weigh(&m);
        status = lab__shares_make(&h, &m, NULL, 0, err);
    }
    for (int s = 0; status == STEIN_OK && s < p->nstroke; s++) {
        if (h.info[s] > 0.0) {
            o->record[s].amount = limit * (row->x[k] + h.score[s] / h.info[s]);
            o->record[s].sd = limit / sqrt(h.info[s]);
        }
    }
    lab__shares_free(&h);
    lab__mixed_free(&m);
    free(G);
    free(x);
    return status;
}

static int by_number(const void *a, const void *b)
{
    const lab_seen *x = a, *y = b;
    return (x->number > y->number) - (x->number < y->number);
}

stein_status diag__list_records(const diag__row *null, const diag__row *best,
                                const diag__reported *before, const diag__reported *after,
                                lab_diagnosis *o, stein_err *err)
{
    int reporting = isfinite(before->rmse) ? before->p.nstroke : 0;
    stein_status status = STEIN_OK;
    o->record = malloc(sizeof *o->record * (size_t)(null->p.nstroke + reporting + 1));
    if (o->record == NULL) {
        return lab__no_memory(err);
    }
    for (int s = 0; s < null->p.nstroke; s++) {
        lab_seen *to = add(o, null->p.stroke[s].data, 0);
        to->before = rms(&null->p, null->r, s) * null->scale;
        to->after = best != NULL ? rms(&best->p, best->r, s) * best->scale : to->before;
    }
    for (int s = 0; s < reporting; s++) {
        lab_seen *to = add(o, before->p.stroke[s].data, 1);
        to->before = rms(&before->p, before->r, s);
        to->after = isfinite(after->rmse) ? rms(&after->p, after->r, s) : to->before;
    }
    for (int i = 0; best != NULL && best->J != NULL && i < best->h.n && o->ncause > 0; i++) {
        if (diag__is_same(&best->cause[i], &o->suspect[0].candidate)) {
            status = amounts(best, i, best->cause[i].limit, o, err);
        }
    }
    qsort(o->record, (size_t)o->nrecord, sizeof *o->record, by_number);
    return status;
}
