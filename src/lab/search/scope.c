/* SPDX-License-Identifier: GPL-3.0-or-later
 * scope.c - causes that act in a part of the records: in one, or from one on.
 *
 *      cause = base + bases * scope        base: candidate of the problem
 *      scope   0          all records
 *              1 .. R     record number `scope` alone: a setting that it states
 *              R+1 .. 2R  from record number `scope - R` on
 *
 * A wrong setting and a change half-way are so hypotheses like all others. Which record it is has
 * been chosen: that costs 2 ln of the number of records, in the objective of the row.
 */
#include "functions.h"
#include "search.h"

static int bases(const diag__problem *q)
{
    return q->n + q->nsetting;
}

const lab_candidate *diag__base(const diag__problem *q, int cause)
{
    return &q->candidate[cause % bases(q)];
}

static void set_scope(const diag__problem *q, int cause, lab_candidate *c)
{
    int scope = cause / bases(q), one = scope <= q->records;
    c->from = one ? scope : scope - q->records;
    c->until = one ? scope : 0;
}

lab_candidate diag__candidate(const diag__problem *q, int cause)
{
    lab_candidate c = *diag__base(q, cause);
    set_scope(q, cause, &c);
    return c;
}

lab_candidate diag__bound(const diag__problem *q, const diag__mechanism *in, int cause)
{
    lab_candidate c = in->candidate[cause % bases(q)];
    set_scope(q, cause, &c);
    return c;
}

int diag__is_scoped(const diag__problem *q, int cause)
{
    return cause >= bases(q);
}

int diag__in_record(const diag__problem *q, int base, int record)
{
    return base + bases(q) * record;
}

int diag__from_record(const diag__problem *q, int base, int record)
{
    return base + bases(q) * (q->records + record);
}

/* the record that a change begins at, 0: it is none */
static int change_at(const diag__problem *q, int cause)
{
    int scope = cause / bases(q);
    return scope > q->records ? scope - q->records : 0;
}

int diag__is_coherent(const diag__problem *q, const diag__hypothesis *h)
{
    int at = 0;
    for (int i = 0; i < h->n; i++) {
        int here = change_at(q, h->cause[i]);
        if (here > 0 && at > 0 && here != at) {
            return 0;
        }
        at = here > 0 ? here : at;
    }
    return 1;
}

double diag__price(const diag__problem *q, int cause)
{
    return diag__is_scoped(q, cause) ? 2.0 * stein__log_of(q->fitted->n) : 0.0;
}
