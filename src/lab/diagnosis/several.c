/* SPDX-License-Identifier: GPL-3.0-or-later
 * several.c - one cause after the other, up to three, and each of them asked again in the end.
 *
 *      search --leader--> pays on held-out strokes? --> more than noise left? --> search again,
 *                                                       with the leader in the model
 *
 * A later search begins where the last one ended: the causes found so far act, their amounts are
 * unknowns like all others, and what the first cause had taken over for the second it may give
 * back. That is also what shows a wrong first one: with the right one beside it nothing is left for
 * it to do. So every cause but the last is left out once, all else refitted, and goes when
 *
 *      L(without) - L(with all) is nothing to speak of, or the held-out strokes do not miss it
 *
 * and one cause is not called two. Before that each but the last is searched for again with the
 * others in the model: another one may do better in its place.
 *
 * Races and fits along the strokes are most of a search, and in vain where the other cause is not
 * the right one yet. So further searches are hasty at first:
 *
 *      second one in haste --> first one again, in haste --> but noise left? --> done
 *                                  |
 *                                  +--> a law, if both are in one place --> what was put off, and
 *                                                                           both again with care
 *
 * A pair that was found along the strokes (along.c) begins with both: the second search leads the
 * second one where they have ended.
 *
 * Where two leave more than the noise that the data state, a law in no table may be what is missing
 * (curve.c): that is asked before a third one is searched for.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "searching.h"

enum { EXCHANGES = 4 };
static const double pieces = 1.5;     /* chi2/dof: two causes leave more where a law leaves none */
static const double no_worse = 1.005; /* ratio of held-out errors */

/* ---- where a search stands ---- */

/* where all causes act: the last of them on trial, or all accepted */
double diag__objective(const diag__found *f)
{
    return f->leader != NULL ? f->leader->objective : f->end->null_objective;
}

/* ---- held-out strokes ---- */

/* numerical failures leave rmse NAN */
static stein_status judge(diag *d, const diag__suspect *s, diag__held *to, stein_err *err)
{
    stein_err why = {STEIN_OK, ""};
    *to = (diag__held){.rmse = NAN};
    if (d->held_data->n < 1 || diag__held_out(d, s, to, &why) != STEIN_ENOMEM) {
        return STEIN_OK;
    }
    return lab__no_memory(err);
}

/* do held-out strokes miss a cause? */
static int is_missed(const diag__held *without, const diag__held *with, diag__asked asked)
{
    double before, after, most = asked == DIAG_TOLERANCE ? no_worse * no_worse : 1.0;
    diag__compare(without, with, asked == DIAG_LIKELIHOOD, &before, &after);
    return after < most * before;
}

/* the leader of that search is the last cause, and all of them act at its end */
static void lead(diag__found *f, diag *d, diag__asked asked)
{
    f->asked[f->n] = asked;
    f->cause[f->n] = d->suspect[0].s;
    f->from[f->n++] = d;
    f->end = d;
    f->leader = &d->suspect[0];
    f->chi2_dof = d->suspect[0].s.chi2_dof;
}

static void drop(diag__found *f, int i)
{
    for (int k = i; k + 1 < f->n; k++) {
        f->cause[k] = f->cause[k + 1];
        f->from[k] = f->from[k + 1];
        f->asked[k] = f->asked[k + 1];
    }
    f->n--;
}

/* @return does the leader of this search pay where nothing was fitted? Then it is a cause. Where it
 * leaves more than the stated noise it may be one before it pays: what else is missing bends the
 * numbers until that is found, too. */
static int accept(diag__found *f, diag *d, const diag__held *before, int begins,
                  stein_status *status, stein_err *err)
{
    diag__suspect *best = d->n > 0 ? &d->suspect[0] : NULL;
    diag__held after;
    if (best == NULL || !best->s.refitted || !isfinite(best->objective)) {
        return 0;
    }
    *status = judge(d, best, &after, err);
    best->s.held_out = after.rmse;
    diag__asked asked = diag__is_mean(d, best)     ? DIAG_LIKELIHOOD
                        : diag__is_beyond(d, best) ? DIAG_TOLERANCE
                                                   : DIAG_ERROR;
    int pays = d->held_data->n < 1 || is_missed(before, &after, asked) ||
               (isfinite(after.rmse) && best->s.chi2_dof > diag__most_noise(d));
    double had, has;
    diag__compare(before, &after, 0, &had, &has);
    int seen = diag__is_seen(d) || asked != DIAG_ERROR || had - has > diag__convincing;
    if (*status != STEIN_OK || (!begins && (!pays || !seen || !diag__spoken(d)))) {
        diag__held_free(&after);
        return 0;
    }
    diag__held_free(&f->held);
    f->held = after;
    lead(f, d, asked);
    return 1;
}

/* the end is one where all causes are accepted and none is on trial */
static stein_status end_at(diag__found *f, diag *d, stein_err *err)
{
    diag__held_free(&f->held);
    f->end = d;
    f->leader = NULL;
    f->chi2_dof = fit__chi2_dof(&d->p, d->r);
    return judge(d, NULL, &f->held, err);
}

/* ---- is each of them needed? ---- */

/* the end without cause i */
static stein_status leave_out(diag__found *f, const diag *first, int i, diag **without,
                              diag__held *held, stein_err *err)
{
    const lab_candidate *c = &f->cause[i].candidate;
    int on_trial = f->leader != NULL && diag__is_same(&f->leader->s.candidate, c);
    stein_status status = STEIN_OK;
    *without = f->end; // where only the others act
    if (!on_trial) {
        status = diag__stage_open(f, first, f->end, f->leader, c, without, err);
    }
    return status == STEIN_OK ? judge(*without, NULL, held, err) : status;
}

/* @param held  strokes held out, without cause i */
static int is_needless(const diag__found *f, int i, const diag *without, const diag__held *held)
{
    double loss = (without->null_objective - diag__objective(f)) / f->excess;
    int judged = isfinite(held->rmse) && isfinite(f->held.rmse);
    double least = f->asked[i] == DIAG_TOLERANCE ? 0.0 : diag__least_gain;
    return !(loss > least) || (judged && !is_missed(held, &f->held, f->asked[i]));
}

/* a cause that the others do without goes. @return whether one went */
static int prune(diag__found *f, const diag *first, stein_status *status, stein_err *err)
{
    for (int i = 0; i < f->n && *status == STEIN_OK; i++) {
        diag *without = NULL;
        diag__held held = {.rmse = NAN};
        stein_err why = {STEIN_OK, ""};
        stein_status tried = leave_out(f, first, i, &without, &held, &why);
        if (tried == STEIN_OK) { // else it cannot be simulated without: it is needed
            tried = diag__ratio(&held, &f->held, &f->cause[i], &why);
        }
        if (tried == STEIN_ENOMEM) {
            *status = lab__no_memory(err);
        }
        int goes = tried == STEIN_OK && is_needless(f, i, without, &held);
        diag__held_free(&held);
        if (goes) {
            drop(f, i);
            *status = end_at(f, without, err);
            return 1;
        }
    }
    return 0;
}

static stein_status prune_all(diag__found *f, const diag *first, stein_err *err)
{
    stein_status status = STEIN_OK;
    if (f->pruned == f->end && f->pruned_leader == f->leader) {
        return STEIN_OK; // each has been left out of this end once
    }
    while (status == STEIN_OK && f->n > 1 && prune(f, first, &status, err)) {
    }
    f->pruned = f->end;
    f->pruned_leader = f->leader;
    return status;
}

/* ---- would another one do better in its place? ---- */

/* the causes of a search that the data prefer take the place of those so far, its leader that of
 * cause i */
static stein_status take_over(diag__found *f, diag *d, int i, stein_err *err)
{
    diag__suspect *best = &d->suspect[0];
    diag__held after;
    stein_status status = judge(d, best, &after, err);
    if (status != STEIN_OK ||
        (isfinite(f->held.rmse) && !is_missed(&f->held, &after, DIAG_TOLERANCE))) {
        diag__held_free(&after);
        return status;
    }
    best->s.held_out = after.rmse;
    diag__held_free(&f->held);
    f->held = after;
    drop(f, i);
    lead(f, d, DIAG_ERROR);
    return STEIN_OK;
}

/* What could stand in the place of a cause that is a number where all of them leave but noise:
 * linear predictions are good there, and no search from the null fit is needed. (Numbers are not
 * predicted in the place of a part.) */
static stein_status search_in_place(const diag__found *f, diag *d, const lab_candidate *cause,
                                    stein_err *err)
{
    stein_status status = diag__changes(d, err);
    status = status == STEIN_OK ? diag__rank(d, err) : status;
    diag__suspect *s = NULL;
    for (int i = 0; i < d->n && s == NULL; i++) {
        int here = diag__is_same(&d->suspect[i].s.candidate, cause) && d->suspect[i].never == NULL;
        s = here ? &d->suspect[i] : NULL;
    }
    if (status != STEIN_OK || s == NULL) {
        return status;
    }
    status = diag__make_room(d, s, err);
    if (status != STEIN_OK) {
        return status;
    }
    diag__carry_over(d, f->end, f->leader, cause, s->x);
    return diag__refit_from(d, s, err);
}

/* What could stand in the place of any other one. In haste that one leads again from where all have
 * ended, which is quick. With care it does not: who has to come near it on the way is given up too
 * soon where both causes are wrong. */
static stein_status search_beside(const diag__found *f, diag *d, const lab_candidate *cause,
                                  stein_err *err)
{
    if (!f->hasty) {
        return diag__search(d, err);
    }
    double *x = malloc(sizeof *x * (size_t)(d->p.nu + 1));
    if (x == NULL) {
        return lab__no_memory(err);
    }
    diag__carry_over(d, f->end, f->leader, cause, x);
    d->known = cause;
    d->known_x = x;
    stein_status status = diag__search(d, err);
    d->known = NULL;
    d->known_x = NULL;
    free(x);
    return status;
}

/* The search for cause i again, with the others in the model. @param changed  1: it is another one
 */
static stein_status search_again(diag__found *f, const diag *first, int i, int *changed,
                                 stein_err *err)
{
    const lab_candidate was = f->cause[i].candidate;
    double objective = diag__objective(f);
    diag *d = NULL;
    stein_status status = diag__stage_open(f, first, f->end, f->leader, &was, &d, err);
    status = status == STEIN_OK ? diag__suspects(d, err) : status;
    int in_place = was.effect->needs == NULL && !diag__is_more(first, f->chi2_dof);
    if (status == STEIN_OK) {
        status = in_place ? search_in_place(f, d, &was, err) : search_beside(f, d, &was, err);
    }
    const diag__suspect *best = status == STEIN_OK && d->n > 0 ? &d->suspect[0] : NULL;
    *changed = 0;
    if (best == NULL || !best->s.refitted || !isfinite(best->objective) || !best->s.possible ||
        diag__is_same(&best->s.candidate, &was) ||
        !(best->objective < objective - diag__convincing * f->excess)) {
        return status;
    }
    status = take_over(f, d, i, err);
    *changed = f->end == d;
    return status;
}

/* The first cause was found while all that came after was missing, and may have been chosen by
 * that. So each but the last is searched for again beside the others, until none gives way. */
static stein_status exchange(diag__found *f, const diag *first, stein_err *err)
{
    stein_err why = {STEIN_OK, ""};
    stein_status status = STEIN_OK;
    int kept = 1; // searches in a row that have changed nothing; the last cause is new
    for (int n = 0; status == STEIN_OK && n < EXCHANGES && kept < f->n; n++) {
        int changed;
        status = search_again(f, first, kept - 1, &changed, &why);
        kept = changed ? 1 : kept + 1;
    }
    return fit__forgive(status, err);
}

/* ---- the whole ---- */

/* Does the leader of a first search alone explain how the strokes begin? It may be one of two
 * causes of which the other one hides it later. */
static int begins(const diag *d)
{
    return d->naccepted == 0 && d->n > 0 && d->suspect[0].begins != NULL;
}

/* Two causes leave more than the noise that the data state. Before a third one is searched for, a
 * law is asked for at any price, if it was not. */
static stein_status ask_for_law(diag *first, const diag__held *before, stein_err *err)
{
    int off = fit__noise_given(&first->p) && first->only == NULL;
    return off ? diag__try_laws(first, before, INFINITY, err) : STEIN_OK;
}

/* The leader of a search is a cause; of a hasty one also when it pays after what was put off. */
static int accept_or_go_on(diag__found *f, diag *d, const diag__held *before, int begins,
                           stein_status *status, stein_err *err)
{
    int is_cause = accept(f, d, before, begins, status, err);
    if (!is_cause && *status == STEIN_OK && d->naccepted > 0 && d->put_off) {
        stein_err why = {STEIN_OK, ""};
        *status = fit__forgive(diag__refit_on(d, &why), err); // what was found stays found
        is_cause = *status == STEIN_OK && accept(f, d, before, begins, status, err);
    }
    return is_cause;
}

/* What the last search has put off. Its leader is a cause already; who leads now takes its place.
 */
static stein_status go_on(diag__found *f, stein_err *err)
{
    diag *d = f->end;
    if (!d->put_off || f->leader == NULL) {
        return STEIN_OK;
    }
    diag__held after;
    diag__asked asked = f->asked[f->n - 1];
    stein_err why = {STEIN_OK, ""};
    stein_status status = fit__forgive(diag__refit_on(d, &why), err); // the best is the first
    status = status == STEIN_OK ? judge(d, &d->suspect[0], &after, err) : status;
    if (status == STEIN_OK) {
        d->suspect[0].s.held_out = after.rmse;
        diag__held_free(&f->held);
        f->held = after;
        f->n--;
        lead(f, d, asked);
    }
    return status;
}

/* Hasty searches have led to a pair that leaves more than noise: what they have put off, and again
 * with care. Where that is clearly more and both are in one place they may be pieces of a law
 * there, which is asked first; not of a pair that was found along the strokes, as a law was asked
 * for in haste before that. @return  1: they are, nobody goes on */
static int with_care(diag__found *f, diag *first, const diag__held *before, int known,
                     stein_status *status, stein_err *err)
{
    const lab_candidate *a = &f->cause[0].candidate, *b = &f->cause[1].candidate;
    if (!known && f->chi2_dof > diag__most_noise(first) && diag__related(a, b)) {
        *status = ask_for_law(first, before, err);
        if (*status != STEIN_OK || diag__law_is_all(first) || diag__law_has_all(first, f)) {
            return 1;
        }
    }
    f->hasty = 0;
    *status = go_on(f, err);
    *status = *status == STEIN_OK ? exchange(f, first, err) : *status;
    return 0;
}

/* a further search for the second one of a pair that leads it where they have ended */
static stein_status search_second(diag *d, const diag__pair *pair, stein_err *err)
{
    d->known = &pair->second;
    d->known_x = pair->x;
    stein_status status = diag__search(d, err);
    d->known = NULL;
    d->known_x = NULL;
    return status;
}

stein_status diag__causes(diag *first, const diag__held *before, const diag__pair *pair,
                          diag__found *f, stein_err *err)
{
    stein_status status = STEIN_OK;
    diag *d = first;
    int known = pair != NULL && pair->x != NULL;
    int hasty = (known || pair == NULL) && first->only == NULL && fit__noise_given(&first->p);
    *f = (diag__found){.end = first, .excess = 1.0, .hasty = hasty, .held = {.rmse = NAN}};
    while (accept_or_go_on(f, d, f->n > 0 ? &f->held : before, pair != NULL && begins(d), &status,
                           err)) {
        f->excess = diag__excess(d, f->leader);
        if (first->only != NULL && f->n > 1 && f->chi2_dof > pieces) {
            break; // it is the law: nobody has to be asked again
        }
        if (pair != NULL && !known && f->n > 1 && diag__is_more(first, f->chi2_dof)) {
            return status;
        }
        int last = first->only != NULL ? 2 : FIT__ACCEPTED;
        int more = diag__is_more(first, f->chi2_dof);
        status = !more ? prune_all(f, first, err) : STEIN_OK;
        if (more && f->n == FIT__ACCEPTED) {
            break; // they are not all
        }
        if (status == STEIN_OK && !(known && more)) { // else with care at once
            status = exchange(f, first, err);
        }
        if (status == STEIN_OK && f->hasty && f->n > 1 && diag__is_more(first, f->chi2_dof) &&
            with_care(f, first, before, known, &status, err)) {
            break;
        }
        d = f->end;
        if (status != STEIN_OK || f->n == last || !diag__is_more(first, f->chi2_dof) ||
            (known && f->n > 1)) {
            break;
        }
        if (f->n > 1) {
            status = ask_for_law(first, before, err);
            if (status != STEIN_OK || diag__law_is_all(first) || diag__law_is_ahead(first, f)) {
                break;
            }
        }
        stein_err why = {STEIN_OK, ""};
        diag *next = NULL;
        status = diag__stage_open(f, first, d, f->leader, NULL, &next, &why);
        if (status == STEIN_OK && !diag__is_more(first, fit__chi2_dof(&next->p, next->r))) {
            status = end_at(f, next, err); // the leader's fit had not ended
            break;
        }
        status = status == STEIN_OK ? diag__suspects(next, &why) : status;
        if (status == STEIN_OK) {
            status = known ? search_second(next, pair, &why) : diag__search(next, &why);
        }
        if (status != STEIN_OK) { // what was found stays found
            status = fit__forgive(status, err);
            break;
        }
        d = next;
    }
    status = status == STEIN_OK ? prune_all(f, first, err) : status;
    if (f->n > 0 && isfinite(before->rmse) && !is_missed(before, &f->held, f->asked[f->n - 1])) {
        f->n = 0; // all of them together do not pay
        f->end = first;
        f->leader = NULL;
    }
    return status;
}

void diag__found_free(diag__found *f)
{
    for (int i = f->nstage - 1; i >= 0; i--) {
        diag__close(f->stage[i]);
        free(f->stage[i]);
    }
    free(f->stage);
    diag__held_free(&f->held);
}

/* ---- numbers of the causes at the end ---- */

const fit__unknown *diag__amount(const diag__found *f, int i, double *x, double *sd)
{
    diag__numbers told = {.x = f->end->x, .sd = f->end->sd};
    int k = diag__amount_of(f->end, f->leader, &f->cause[i].candidate);
    fit__problem *p = &f->end->p;
    if (f->leader != NULL) {
        p = diag__problem(f->end, f->leader);
        fit__problem_try(p, &f->leader->s.candidate);
        told = diag__numbers_of(f->end, f->leader);
    }
    for (int j = 0; j < FIT__NUMBERS; j++) {
        x[j] = told.x[k + j];
        sd[j] = told.sd[k + j];
    }
    return &p->unknown[k];
}
