/* SPDX-License-Identifier: GPL-3.0-or-later
 * proposals.c - what the proposers share.
 */
#include <math.h>
#include <stdlib.h>

#include "proposals.h"

diag__proposal diag__as_parent(diag__hypothesis h, int parent, const diag__proposer *by)
{
    diag__proposal p = {.h = h, .parent = parent, .by = by};
    for (int i = 0; i < DIAG_CAUSES; i++) {
        p.amount[i] = p.side[i] = NAN;
    }
    return p;
}

int diag__proposal_of(const diag__linear *l, const int *set, int n, double *amount,
                      diag__proposal *to)
{
    double gain = diag__linear_gain(l, set, n, amount);
    diag__hypothesis h = {.n = 0};
    for (int i = 0; i < n; i++) {
        h = diag__with(h, l->cause[set[i]]);
    }
    if (!isfinite(gain) || h.n != n) {
        return 0;
    }
    *to = diag__as_parent(h, -1, NULL);
    to->expected = diag__expected(l, set, n, amount, gain);
    for (int k = 0; k < n; k++) {
        for (int i = 0; i < n; i++) {
            if (l->cause[set[i]] == h.cause[k]) {
                to->amount[k] = amount[i];
                to->side[k] = l->side != NULL ? l->side[set[i]] : NAN;
            }
        }
    }
    return 1;
}

/* A mistake is rare: one number of the file is far off, alone or beside one other cause. More of
 * them imitate nearly everything. */
int diag__is_thinkable(const diag__problem *q, const diag__proposal *p)
{
    int mistakes = 0;
    for (int i = 0; i < p->h.n; i++) {
        const lab_candidate *c = diag__base(q, p->h.cause[i]);
        if (!diag__thinkable(c, p->amount[i])) {
            return 0;
        }
        mistakes += c->number > 0.0 && fabs(p->amount[i]) > diag__largest;
    }
    int most = p->h.n <= 2 ? 1 : 0;
    return mistakes <= most && diag__is_coherent(q, &p->h);
}

static int by_expected(const void *a, const void *b)
{
    const diag__ranked *x = a, *y = b;
    int order = (x->expected > y->expected) - (x->expected < y->expected);
    order = order != 0 ? order : (x->b > y->b) - (x->b < y->b);
    return order != 0 ? order : (x->a > y->a) - (x->a < y->a);
}

void diag__rank(diag__ranked *list, int n)
{
    qsort(list, (size_t)n, sizeof *list, by_expected);
}
