/* SPDX-License-Identifier: GPL-3.0-or-later
 * propose_exchange.c - another cause in the place of one or two, a cause less, other amounts.
 *
 * The first cause was chosen while all later ones were missing, which may have decided the choice.
 * What the data cannot distinguish from a cause is its rival. Both are the same question: what does
 * as well in its place, all else refitted. Two causes that came first may together imitate one that
 * was not within reach then: no exchange of one at a time leads there.
 */
#include <math.h>
#include <string.h>

#include "proposals.h"

static const double quarters = 1.2; /* of its range: another start of a number beside an amount */

/* own causes but i and j, and column c (-1: none) */
static int take(const diag__linear *l, int i, int j, int c, diag__proposal *to)
{
    int set[DIAG_CAUSES], n = 0;
    double amount[DIAG_CAUSES + 1];
    for (int k = 0; k < l->own; k++) {
        if (k != i && k != j) {
            set[n++] = k;
        }
    }
    if (c >= 0) {
        set[n++] = c;
    }
    return diag__proposal_of(l, set, n, amount, to);
}

static int exchange(const diag__problem *q, const diag__table *t, const diag__linear *l,
                    diag__proposal *out, int most)
{
    diag__ranked list[DIAG_COLUMNS * DIAG_CAUSES];
    diag__proposal p;
    int n = 0, found = 0;
    (void)t;
    for (int i = 0; i < l->own; i++) {
        for (int c = l->own; c < l->n && n < DIAG_COLUMNS * DIAG_CAUSES; c++) {
            if (take(l, i, i, c, &p) && diag__is_thinkable(q, &p)) {
                list[n++] = (diag__ranked){c, i, p.expected};
            }
        }
    }
    diag__rank(list, n);
    for (int k = 0; k < n && found < most; k++) {
        if (take(l, list[k].b, list[k].b, list[k].a, &out[found])) {
            out[found++].by = &diag__propose_exchange;
        }
    }
    return found;
}

static int merge(const diag__problem *q, const diag__table *t, const diag__linear *l,
                 diag__proposal *out, int most)
{
    int found = 0;
    (void)t;
    for (int i = 0; i < l->own; i++) {
        for (int j = i + 1; j < l->own && found < most; j++) {
            diag__proposal p;
            int any = 0;
            for (int c = l->own; c < l->n; c++) {
                if (take(l, i, j, c, &p) && diag__is_thinkable(q, &p) &&
                    (!any || p.expected < out[found].expected)) {
                    out[found] = p;
                    out[found].by = &diag__propose_merge;
                    any = 1;
                }
            }
            found += any;
        }
    }
    return found;
}

static int drop(const diag__problem *q, const diag__table *t, const diag__linear *l,
                diag__proposal *out, int most)
{
    int found = 0;
    (void)q;
    (void)t;
    for (int i = 0; l->own > 1 && i < l->own && found < most; i++) {
        if (take(l, i, i, -1, &out[found])) {
            out[found++].by = &diag__propose_drop;
        }
    }
    return found;
}

static int is_at_contact(const lab_candidate *c)
{
    return c->effect->site == LAB_AT_CONTACT || c->effect->site == LAB_AT_SURFACE;
}

/* Is b at the same place, and one of the kinds that the table calls hard to tell from a? Of a
 * contact all kinds are: they act in the same few milliseconds. */
static int is_twin(const lab_candidate *a, const lab_candidate *b)
{
    if (is_at_contact(a) && is_at_contact(b)) {
        return strcmp(a->place, b->place) == 0;
    }
    const char *at = strstr(a->effect->twins, b->effect->kind);
    size_t n = strlen(b->effect->kind);
    int is_word =
        at != NULL && (at == a->effect->twins || at[-1] == ' ') && (at[n] == ' ' || at[n] == '\0');
    return is_word && strcmp(a->place, b->place) == 0;
}

/* What acts like a clock that is off, and is the likelier one: a number of the file, or the scale
 * of a channel. */
static int is_likelier(const diag__problem *q, const diag__linear *l, int own, int c)
{
    const lab_effect *other = diag__base(q, l->cause[c])->effect;
    return diag__base(q, l->cause[own])->effect->site == LAB_AT_CLOCK &&
           (other->site == LAB_AT_PARAMETER || strcmp(other->kind, "sensor_gain") == 0) &&
           diag__likeness(l, own, c) > diag__the_same;
}

/* Two more starts of a proposal, of the number beside the new cause c: a gap, a place of a stop. */
static int more_starts(const lab_candidate *c, int cause, diag__proposal *out, int most)
{
    int found = 0, at = 0;
    while (at < out->h.n - 1 && out->h.cause[at] != cause) {
        at++;
    }
    for (int up = 0; c->side[0].name != NULL && up < 2 && found + 1 < most; up++) {
        out[++found] = out[0];
        out[found].side[at] = up ? quarters : -quarters;
    }
    return found;
}

/* An effect that is hard to separate from a cause, in its place, whatever a linear model predicts.
 * A large cause of the wrong kind distorts all that is fitted beside it. From there a linear model
 * may not reach the right cause: a spring instead of a backlash without a gap. */
static int twin(const diag__problem *q, const diag__table *t, const diag__linear *l,
                diag__proposal *out, int most)
{
    int found = 0;
    (void)t;
    for (int i = 0; i < l->own; i++) {
        const lab_candidate *own = diag__base(q, l->cause[i]);
        for (int c = l->own; c < l->n && found < most; c++) {
            const lab_candidate *other = diag__base(q, l->cause[c]);
            int alike = is_twin(own, other) || is_twin(other, own) || is_likelier(q, l, i, c);
            if (!diag__is_scoped(q, l->cause[c]) && alike && take(l, i, i, c, &out[found])) {
                out[found].by = &diag__propose_twin;
                found += 1 + more_starts(other, l->cause[c], &out[found], most - found);
            }
        }
    }
    return found;
}

/* The amounts that the linear model at the row wants, where they are far from the row's: its fit
 * has ended in another minimum. Numbers beside an amount from further on and further back. */
static int restart(const diag__problem *q, const diag__table *t, const diag__linear *l,
                   diag__proposal *out, int most)
{
    int set[DIAG_CAUSES] = {0, 1, 2}, found = 0, off = 0;
    double amount[DIAG_CAUSES + 1], sd;
    (void)t;
    if (l->own == 0 || most < 1 || !diag__proposal_of(l, set, l->own, amount, &out[0])) {
        return 0;
    }
    for (int i = 0; i < l->own; i++) {
        double is = diag__amount(l->row, i, &sd);
        off |= fabs(amount[i] - is) > diag__some_of * fabs(is);
    }
    if (off && diag__is_thinkable(q, &out[0])) {
        out[found++].by = &diag__propose_restart;
    }
    for (int i = 0; i < l->own; i++) {
        const lab_side *side = &l->row->cause[i].side[0];
        for (int up = 0; side->param >= 0 && side->hi > side->lo && up < 2 && found < most; up++) {
            double at = l->row->x[diag__unknown_at(l->row, i) + 1];
            diag__proposal_of(l, set, l->own, amount, &out[found]);
            for (int k = 0; k < DIAG_CAUSES; k++) {
                out[found].amount[k] = NAN;
            }
            out[found].side[i] = up ? at + quarters : at - quarters;
            out[found++].by = &diag__propose_restart;
        }
    }
    return found;
}

const diag__proposer diag__propose_exchange = {
    .letter = 'X', .name = "another cause in the place of one", .propose = exchange};
const diag__proposer diag__propose_merge = {
    .letter = 'M', .name = "one cause in the place of two", .propose = merge};
const diag__proposer diag__propose_drop = {
    .letter = 'D', .name = "a cause less", .propose = drop, .removes = 1};
const diag__proposer diag__propose_twin = {
    .letter = 'L', .name = "what looks like a cause", .propose = twin, .look_alike = 1};
const diag__proposer diag__propose_restart = {
    .letter = 'R', .name = "other amounts", .propose = restart, .restarts = 1};
