/* SPDX-License-Identifier: GPL-3.0-or-later
 * search.c - proposals in the order of what they let expect, until nothing proposed can be better.
 *
 *      null row
 *      while a row is worth it: linearise there -> proposers -> the best proposals -> evaluate
 *
 * A row that leaves more than noise is linearised with an observer, which holds the simulation near
 * the records. A row that leaves noise is linearised without one. At a row that leaves noise,
 * proposals are worth a fit if they may be as good (its rivals) or have a cause less. At other rows
 * those with the least expected objective are fitted.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "proposals.h"

enum { HELD = 1, FREE = 2 };

double diag__most_noise(const diag__problem *q, const fit__problem *p)
{
    double sd = sqrt(2.0 / fmax(1.0, p->samples - p->nu)),
           most = 1.0 + diag__slack + diag__certain * sd;
    return (fit__noise_given(p) ? fmin(most, diag__guessed) : diag__guessed) +
           diag__guessed * q->input_noise;
}

/* is what a row leaves as small as noise, with what noise of measured forces adds? */
static int is_small(const diag__problem *q, const diag__row *row)
{
    double sd = sqrt(2.0 / fmax(1.0, row->p.samples - row->p.nu));
    double most = fit__noise_given(&row->p) ? 1.0 + diag__beyond_chance * sd : diag__guessed;
    return row->chi2_dof <= most + diag__guessed * q->input_noise;
}

int diag__leaves_noise(const diag__problem *q, const diag__row *row)
{
    return is_small(q, row) && !diag__scatters_most(row->D); // records differ no more than friction
}

diag__row *diag__incumbent(const diag__problem *q, const diag__table *t)
{
    diag__row *best = diag__best(q, t, 0);
    for (int n = 1; n <= DIAG_CAUSES; n++) {
        diag__row *more = diag__best(q, t, n);
        if (more != NULL &&
            (best == NULL || more->objective < best->objective - diag__least_gain)) {
            best = more;
        }
    }
    return best;
}

double diag__observer_gain(const diag__row *row)
{
    return row->chi2_dof > diag__five_noises() ? diag__rung[0] : 0.0;
}

/* ---- which row ---- */

/* how a row is linearised next: 1 held, 2 free, 0: it was, or its hypothesis where it fits as well
 */
static int next_look(const diag__table *t, const diag__row *row)
{
    int seen = 0;
    for (int i = 0; i < t->n; i++) {
        const diag__row *other = t->row[i];
        if (!other->superseded && other->rough == row->rough && diag__equals(&other->h, &row->h) &&
            row->objective > other->objective - diag__worth()) {
            seen |= other->expanded;
        }
    }
    int first = diag__observer_gain(row) > 0.0 ? HELD : FREE, then = HELD + FREE - first;
    int more = row->chi2_dof > diag__near_noise &&
               (then == HELD || row->scale > 1.0 || row->chi2_dof < diag__seven_noises);
    return !(seen & first) ? first : more && !(seen & then) ? then : 0;
}

/* The best row that is to be linearised. Where one leaves noise, that one alone; if the noise is
 * estimated and it leaves more, its rivals, too: what is left may be one more effect beside one of
 * them. A row with more causes than the incumbent has gained too little by them; where noise is
 * estimated, it is looked at if they are convincing. */
static diag__row *next_row(const diag__problem *q, const diag__table *t, int *look)
{
    diag__row *best = diag__incumbent(q, t), *next = NULL;
    int noise = diag__leaves_noise(q, best),
        open = q->scale_free && best->chi2_dof > diag__near_noise;
    for (int i = 0; i < t->n; i++) {
        diag__row *row = t->row[i];
        int how = diag__is_possible(q, row) ? next_look(t, row) : 0;
        int gains = q->scale_free && row->objective < best->objective - diag__convincing;
        int more = row->h.n > best->h.n && !gains;
        int rival = open && row->objective < best->objective + diag__least_gain;
        if (how == 0 || more || (noise && row != best && !rival)) {
            continue;
        }
        if (next == NULL || row->objective < next->objective) {
            next = row;
            *look = how;
        }
    }
    return next;
}

/* ---- which proposals ---- */

static int by_value(const void *a, const void *b)
{
    const diag__proposal *x = a, *y = b;
    return x->value < y->value ? -1 : x->value > y->value;
}

static int has_scoped(const diag__problem *q, const diag__hypothesis *h)
{
    int yes = 0;
    for (int i = 0; i < h->n; i++) {
        yes |= diag__is_scoped(q, h->cause[i]);
    }
    return yes;
}

/* few causes first: a linear model is never exactly right, and more columns explain more of what
 * it misses; and what acts in all records before what acts in some */
static double value_of(const diag__problem *q, const diag__linear *l, double excess,
                       const diag__proposal *p)
{
    int stated = l->gain > 0.0 && l->row->scale <= 1.0;
    double drop = stated ? excess : l->row->objective - p->expected;
    double each = fmax(diag__worth(), diag__part_of * drop);
    int partly = has_scoped(q, &p->h) && l->row->chi2_dof > diag__five_noises();
    return p->expected + p->h.n * each + (partly ? diag__part_of * excess : 0.0);
}

static const diag__proposer *const proposer[] = {
    &diag__propose_add,   &diag__propose_moved, &diag__propose_pair,    &diag__propose_exchange,
    &diag__propose_merge, &diag__propose_drop,  &diag__propose_restart, &diag__propose_twin};
enum { PROPOSERS = sizeof proposer / sizeof *proposer };
const diag__proposer diag__step_null = {.letter = '0', .name = "no cause"};

/* One of two causes may be enough. A linear model cannot decide that where the effect of an amount
 * is not linear. So the one that is expected to explain more is fitted before both. */
static void one_before_both(diag__proposal *list, int n)
{
    for (int i = 0; i < n; i++) {
        int best = -1;
        for (int k = 0; k < n && list[i].by->parts != NULL; k++) {
            int part = list[k].by == list[i].by->parts && diag__contains(&list[i].h, &list[k].h);
            best = part && (best < 0 || list[k].expected < list[best].expected) ? k : best;
        }
        if (best >= 0 && !(list[best].value < list[i].value)) {
            list[best].value = list[i].value - 1.0;
        }
    }
}

/* @param list  [PROPOSERS * PROPOSALS] out, the most valuable ones first  @return how many */
static int collect(const diag__problem *q, const diag__table *t, const diag__linear *l,
                   diag__proposal *list)
{
    int n = 0, row = diag__index(t, l->row);
    double excess = diag__excess(l->row);
    for (size_t i = 0; i < PROPOSERS; i++) {
        n += proposer[i]->propose(q, t, l, list + n, DIAG_MANY_FITS);
    }
    for (int i = 0; i < n; i++) {
        list[i].parent = row;
        list[i].held = l->gain > 0.0;
        for (int k = 0; k < list[i].h.n; k++) {
            const lab_candidate *c = diag__base(q, list[i].h.cause[k]);
            list[i].expected +=
                isfinite(list[i].amount[k]) ? diag__mistake(c, list[i].amount[k]) : 0.0;
        }
        int idle = list[i].by->removes && list[i].expected < l->row->objective + diag__worth();
        list[i].value = idle                     ? -INFINITY
                        : list[i].by->look_alike ? -DBL_MAX
                                                 : value_of(q, l, excess, &list[i]);
    }
    one_before_both(list, n);
    qsort(list, (size_t)n, sizeof *list, by_value);
    return n;
}

/* is it the row's hypothesis without what acts in a part of the records? */
static int drops_scoped(const diag__problem *q, const diag__row *row, const diag__hypothesis *h)
{
    int dropped = 0;
    for (int i = 0; i < row->h.n; i++) {
        dropped |= !diag__has(h, row->h.cause[i]) && diag__is_scoped(q, row->h.cause[i]);
    }
    return dropped && h->n < row->h.n;
}

/* does it begin elsewhere in a number beside an amount? */
static int has_start(const diag__proposal *p)
{
    int yes = 0;
    for (int i = 0; i < p->h.n; i++) {
        yes |= isfinite(p->side[i]);
    }
    return yes;
}

/* Is a proposal worth its cost, with the rows so far? @return DIAG_TRIED: it is; else why not */
static diag__fate is_worth(const diag__problem *q, const diag__table *t, const diag__linear *l,
                           const diag__proposal *p)
{
    const diag__row *best = diag__incumbent(q, t), *had = diag__find(t, &p->h);
    int again = p->by->restarts;
    if (again && (l->row->by->restarts || is_small(q, l->row))) {
        return DIAG_ELSEWHERE; // its fit has ended where nothing is left, or is another start
    }
    if (again ? diag__tries(t, &p->h, p->by, p->parent) > 0
              : diag__tries(t, &p->h, NULL, -1) >= DIAG_TRIES) {
        return DIAG_OFTEN;
    }
    // look-alikes: of a single cause, where the best row is no answer yet, or where the noise that
    // would tell is unknown
    if (p->by->look_alike) {
        int other =
            had == NULL || (had->by->look_alike && has_start(p) && !diag__leaves_noise(q, had));
        int here = l->row == best && (best->h.n == 1 || q->scale_free || !is_small(q, best));
        return !other ? DIAG_NOT_NEW : here ? DIAG_TRIED : DIAG_ELSEWHERE;
    }
    if (had != NULL && !again && !(p->expected < had->objective - diag__worth()) &&
        (diag__leaves_noise(q, had) || had->by == p->by || l->gain == 0.0)) {
        return DIAG_NOT_NEW; // unless a better end of its fit is expected
    }
    if (drops_scoped(q, l->row, &p->h)) {
        return had == NULL ? DIAG_TRIED : DIAG_NOT_NEW;
    }
    if (p->by->only_near) { // it is no answer to what leaves much more than noise
        int here = l->row->chi2_dof < diag__near_noise;
        return had != NULL ? DIAG_NOT_NEW : here ? DIAG_TRIED : DIAG_ELSEWHERE;
    }
    double gain = diag__best(q, t, 0)->objective - best->objective;
    double most = best->objective + diag__convincing + fmax(diag__worth(), diag__some_of * gain);
    if (p->h.n < best->h.n) { // a cause less may lose no more than one has to gain
        most = best->objective + diag__least_gain + diag__worth();
    } else if (p->h.n > best->h.n && (!q->scale_free || diag__leaves_noise(q, best))) {
        // a cause more has to gain; where noise is estimated from a few independent samples, a
        // linear model promises less than the ratio of what is left
        most = best->objective - diag__worth();
    }
    return p->expected < most ? DIAG_TRIED : DIAG_UNEXPECTED;
}

/* counts proposals that were collected, from `from` on */
static void count(diag__counted *of, const diag__proposal *list, int from, int to, diag__fate fate)
{
    for (int i = from; i < to; i++) {
        for (size_t k = 0; k < PROPOSERS; k++) {
            of[k].n[fate] += of[k].by == list[i].by;
        }
    }
}

/* A part that is added bends the motion more than a linear model tells. Those that explain some of
 * what the null row leaves are kept for the case that several causes are needed without them. */
static void set_aside(const diag__problem *q, diag__table *t, const diag__row *row,
                      const diag__proposal *list, int n)
{
    double least = row->objective - diag__part_of * diag__excess(row);
    for (int i = 0; i < n && row->h.n == 0; i++) {
        int had = diag__find(t, &list[i].h) != NULL, cause = list[i].h.cause[0];
        for (int k = 0; k < t->naside; k++) {
            had |= diag__equals(&t->aside[k].h, &list[i].h);
        }
        if (!had && list[i].h.n == 1 && diag__base(q, cause)->effect->needs != NULL &&
            list[i].expected < least && t->naside < DIAG_FEW_FITS) {
            t->aside[t->naside++] = list[i];
        }
    }
}

/* Several causes may stand for a part that was not tried: the parts set aside, each alone. */
static stein_status try_aside(diag__problem *q, diag__table *t, int *better, stein_err *err)
{
    const diag__row *best = diag__incumbent(q, t);
    stein_status status = STEIN_OK;
    int needed = best->h.n > 1 || !diag__leaves_noise(q, best);
    for (int i = 0; needed && i < t->naside && status == STEIN_OK && !diag__is_spent(q); i++) {
        diag__row *one = NULL;
        diag__proposal part = t->aside[i];
        part.parent = diag__index(t, diag__best(q, t, 0)); // there may be another null row by now
        if (diag__find(t, &part.h) == NULL) {
            status = diag__try(q, t, &part, &one, err);
        }
    }
    *better = status == STEIN_OK && diag__incumbent(q, t) != best;
    return status;
}

static stein_status expand(diag__problem *q, diag__table *t, diag__row *row, int look,
                           stein_err *err)
{
    diag__proposal list[PROPOSERS * DIAG_MANY_FITS];
    diag__counted counted[PROPOSERS] = {{.by = NULL}};
    diag__linear l;
    stein_err why = {STEIN_OK, ""};
    double gain = look == HELD ? diag__rung[0] : 0.0;
    // what leaves much more than noise shows in a few records
    int far = look == HELD || row->chi2_dof > diag__near_noise,
        records = far ? DIAG_FEW_RECORDS : DIAG_MANY_RECORDS;
    row->expanded |= look;
    stein_status status = diag__linearise(q, row, gain, records, &l, &why);
    int n = status == STEIN_OK ? collect(q, t, &l, list) : 0, tried = 0, i = 0;
    set_aside(q, t, row, list, n);
    int most = diag__leaves_noise(q, row) ? DIAG_MANY_FITS : DIAG_FEW_FITS, found = 0, broken = 0;
    for (size_t k = 0; k < PROPOSERS; k++) {
        counted[k].by = proposer[k];
    }
    for (; i < n && !found && status == STEIN_OK && !diag__is_spent(q); i++) {
        diag__row *one = NULL;
        int beside = list[i].by->look_alike; // before more causes are asked for
        diag__fate fate = beside || (tried < most && broken < DIAG_FEW_FITS)
                              ? is_worth(q, t, &l, &list[i])
                          : tried < most ? DIAG_BEHIND
                                         : DIAG_FULL;
        count(counted, list, i, i + 1, fate);
        if (fate == DIAG_TRIED) {
            status = diag__try(q, t, &list[i], &one, err);
            tried += !beside;
        }
        if (status == STEIN_OK && one != NULL && one->failed == NULL &&
            one->objective <= diag__incumbent(q, t)->objective) { // also of no possible sign
            status = diag__drop_idle(q, t, one, err);
        }
        found = !diag__leaves_noise(q, row) && one != NULL && diag__is_possible(q, one) &&
                diag__leaves_noise(q, one);
        if (one != NULL && !beside) { // as long as fits keep what the linear model promises
            int far_behind = one->objective > diag__incumbent(q, t)->objective + diag__least_gain;
            broken = far_behind ? broken + 1 : 0;
        }
    }
    count(counted, list, i, n, found ? DIAG_FOUND : DIAG_SPENT);
    if (q->trace != NULL) {
        diag__trace_proposals(q->trace, diag__index(t, row), look == HELD, counted, PROPOSERS);
    }
    diag__linear_free(&t->last); // of the incumbent where it is the last one that was expanded
    t->last = l;
    return fit__forgive(status, err);
}

static stein_status expand_until_best(diag__problem *q, diag__table *t, stein_err *err)
{
    stein_status status = STEIN_OK;
    diag__hypothesis best = diag__best(q, t, -1)->h;
    int waited = 0;
    for (int k = 0; k < DIAG_MANY_FITS && waited < DIAG_TRIES && !diag__is_spent(q); k++) {
        int look = 0;
        diag__row *row = next_row(q, t, &look);
        if (row == NULL || status != STEIN_OK) {
            break;
        }
        status = diag__drop_idle(q, t, row, err);
        int stands = q->scale_free || diag__incumbent(q, t)->h.n >= row->h.n;
        if (status == STEIN_OK && stands) {
            status = expand(q, t, row, look, err);
            status = status == STEIN_OK ? diag__everywhere(q, t, row, err) : status;
        }
        const diag__hypothesis now = diag__best(q, t, -1)->h;
        waited = diag__equals(&now, &best) ? waited + 1 : 0;
        best = now;
    }
    return status;
}

stein_status diag__expand_all(diag__problem *q, diag__table *t, stein_err *err)
{
    diag__row *again = NULL;
    int part = 0;
    stein_status status = expand_until_best(q, t, err);
    status = status == STEIN_OK ? try_aside(q, t, &part, err) : status;
    status = status == STEIN_OK && part ? expand_until_best(q, t, err) : status;
    status = status == STEIN_OK ? diag__null_again(q, t, &again, err) : status;
    status = status == STEIN_OK && again != NULL ? expand_until_best(q, t, err) : status;
    const diag__row *best = diag__incumbent(q, t);
    status = status == STEIN_OK ? diag__try_each(q, t, err) : status;
    if (status != STEIN_OK || diag__incumbent(q, t) == best) {
        return status;
    }
    status = diag__null_again(q, t, &again, err); // a single cause may have found lost records
    return status == STEIN_OK ? expand_until_best(q, t, err) : status;
}

/* Where a fit leaves less than the noise of a measured force would cause, that noise acted on the
 * mechanism: the force is applied with its noise. */
static void limit_input_noise(diag__problem *q, const diag__row *row)
{
    if (row->failed == NULL) {
        q->input_noise = fmin(q->input_noise, fmax(0.0, row->chi2_dof - 1.0));
    }
}

stein_status diag__search(diag__problem *q, diag__table *t, stein_err *err)
{
    diag__proposal null = {.h = {.n = 0}, .parent = -1, .by = &diag__step_null};
    diag__row *row;
    q->least_noise = 1.0;
    q->scale_free = !fit__noise_given(&q->null) || q->input_noise > diag__most_of;
    stein_status status = diag__evaluate(q, t, &null, &row, err);
    if (status == STEIN_OK && row->failed != NULL) {
        return lab__fail(err, STEIN_ENONFINITE, "%s", row->failed);
    }
    if (status == STEIN_OK) {
        limit_input_noise(q, row);
    }
    if (status == STEIN_OK && q->trace != NULL) {
        diag__trace_row(q->trace, q, t, row);
    }
    status = status == STEIN_OK ? diag__doubt_starts(q, t, row, err) : status;
    status = status == STEIN_OK ? diag__over_growing_horizons(q, t, err) : status;
    status = status == STEIN_OK ? diag__expand_all(q, t, err) : status;
    status = status == STEIN_OK ? diag__with_settings(q, t, err) : status;
    status = status == STEIN_OK && !q->scale_free ? diag__with_noise(q, t, err) : status;
    status = status == STEIN_OK ? diag__with_bodies(q, t, err) : status;
    if (status == STEIN_OK) {
        limit_input_noise(q, diag__incumbent(q, t));
    }
    return status;
}
