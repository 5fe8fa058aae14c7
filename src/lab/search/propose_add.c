/* SPDX-License-Identifier: GPL-3.0-or-later
 * propose_add.c - one cause more, or two at once, by what a linear model at a row lets expect.
 *
 * What only a part of the records needs is asked beside causes that are there, or as a pair of
 * such. Beside a cause that is not fitted yet it explains what a linear model misses of that one.
 *
 * Two at once are asked because of two causes each alone may explain little: which pair explains
 * most is a question to the same matrix, without a simulation more.
 */
#include <math.h>
#include <string.h>

#include "proposals.h"

/* the row's own causes and columns a, b (-1: none) */
static int take(const diag__linear *l, int a, int b, diag__proposal *to)
{
    int set[DIAG_CAUSES], n = 0;
    double amount[DIAG_CAUSES + 1];
    for (; n < l->own; n++) {
        set[n] = n;
    }
    set[n++] = a;
    if (b >= 0) {
        set[n++] = b;
    }
    return diag__proposal_of(l, set, n, amount, to);
}

/* is it what a better one says, too? */
static int is_repeated(const diag__linear *l, const diag__ranked *list, int n,
                       const diag__ranked *one)
{
    for (int i = 0; i < n; i++) {
        int same_first =
            diag__likeness(l, list[i].a, one->a) > (one->b < 0 ? diag__the_same : diag__alike);
        int crossed =
            one->b >= 0 && ((same_first && diag__likeness(l, list[i].b, one->b) > diag__alike) ||
                            (diag__likeness(l, list[i].a, one->b) > diag__alike &&
                             diag__likeness(l, list[i].b, one->a) > diag__alike));
        if (one->b < 0 ? same_first : crossed) {
            return 1;
        }
    }
    return 0;
}

/* the first of a ranked list that differ from each other. @return how many */
static int choose(const diag__problem *q, const diag__linear *l, diag__ranked *list, int n,
                  const diag__proposer *by, diag__proposal *out, int most)
{
    int found = 0;
    diag__rank(list, n);
    for (int i = 0; i < n && found < most; i++) {
        int part = diag__base(q, l->cause[list[i].a])->effect->needs != NULL;
        if (!part && is_repeated(l, list, found, &list[i])) {
            continue;
        }
        if (take(l, list[i].a, list[i].b, &out[found])) {
            out[found].by = by;
            list[found++] = list[i];
        }
    }
    return found;
}

static int add(const diag__problem *q, const diag__table *t, const diag__linear *l,
               diag__proposal *out, int most)
{
    diag__ranked list[DIAG_COLUMNS];
    diag__proposal p;
    int n = 0;
    (void)t;
    for (int a = l->own; l->own < DIAG_CAUSES && a < l->n && n < DIAG_COLUMNS; a++) {
        if (take(l, a, -1, &p) && diag__is_thinkable(q, &p)) {
            list[n++] = (diag__ranked){a, -1, p.expected};
        }
    }
    return choose(q, l, list, n, &diag__propose_add, out, most);
}

static int pair(const diag__problem *q, const diag__table *t, const diag__linear *l,
                diag__proposal *out, int most)
{
    diag__ranked single[DIAG_COLUMNS], list[DIAG_POOL * DIAG_POOL / 2];
    diag__proposal p;
    int n = 0, m = 0;
    (void)t;
    for (int a = l->own; l->own < DIAG_CAUSES - 1 && a < l->n && n < DIAG_COLUMNS; a++) {
        if (take(l, a, -1, &p)) {
            single[n++] = (diag__ranked){a, -1, p.expected};
        }
    }
    diag__rank(single, n);
    for (int i = 0; i < n && i < DIAG_POOL; i++) {
        for (int k = 0; k < i; k++) {
            int a = single[k].a, b = single[i].a;
            int parted = diag__is_scoped(q, l->cause[a]) != diag__is_scoped(q, l->cause[b]);
            if (l->cause[a] != l->cause[b] && !parted && diag__likeness(l, a, b) < diag__alike &&
                take(l, a, b, &p) && diag__is_thinkable(q, &p)) {
                list[m++] = (diag__ranked){a, b, p.expected};
            }
        }
    }
    return choose(q, l, list, m, &diag__propose_pair, out, most);
}

/* Numbers that every fit moves anyhow, within a tolerance or from record to record, gain little
 * whatever is wrong with them; the judge has rules of their own for them. So they are fitted where
 * their score is beyond chance. */
static int moved(const diag__problem *q, const diag__table *t, const diag__linear *l,
                 diag__proposal *out, int most)
{
    diag__ranked list[DIAG_COLUMNS];
    diag__proposal p;
    int n = 0;
    (void)t;
    for (int a = 0; l->own == 0 && l->gain == 0.0 && a < l->n && n < DIAG_COLUMNS; a++) {
        int cause = l->cause[a];
        size_t k = (size_t)a;
        double info = l->I[k * (size_t)l->n + k], z = info > 0.0 ? fabs(l->s[k]) / sqrt(info) : 0.0;
        if ((diag__is_tolerated(q, cause) || diag__scatters(q, cause)) && z > diag__beyond_chance &&
            take(l, a, -1, &p) && diag__is_thinkable(q, &p)) {
            list[n++] = (diag__ranked){a, -1, -z};
        }
    }
    return choose(q, l, list, n, &diag__propose_moved, out, most < DIAG_TRIES ? most : DIAG_TRIES);
}

const diag__proposer diag__propose_moved = {
    .letter = 'T', .name = "a number that fits move anyhow", .propose = moved, .only_near = 1};
const diag__proposer diag__propose_add = {.letter = 'A', .name = "one cause more", .propose = add};
const diag__proposer diag__propose_pair = {
    .letter = 'P', .name = "two causes more", .propose = pair, .parts = &diag__propose_add};
