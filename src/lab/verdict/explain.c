/* SPDX-License-Identifier: GPL-3.0-or-later
 * explain.c - why a candidate is the verdict or not, from the table.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "verdict.h"

/* the candidate called KIND@PLACE, -1: there is none */
static int find(const diag__problem *q, const char *name)
{
    const char *at = strchr(name, '@');
    for (int i = 0; at != NULL && i < q->n; i++) {
        const lab_candidate *c = &q->candidate[i];
        size_t n = strlen(c->effect->kind);
        if (n == (size_t)(at - name) && strncmp(name, c->effect->kind, n) == 0 &&
            strcmp(at + 1, c->place) == 0) {
            return i;
        }
    }
    return -1;
}

/* "coulomb_friction at hammer + mass at key", freed by the caller */
static char *words(const diag__problem *q, const diag__hypothesis *h)
{
    char *text = lab__text(h->n > 0 ? "" : "no cause");
    for (int i = 0; text != NULL && i < h->n; i++) {
        const lab_candidate c = diag__candidate(q, h->cause[i]);
        char *more =
            c.from > 0
                ? lab__text("%s%s%s at %s %s record %d", text, i > 0 ? " + " : "", c.effect->kind,
                            c.place, c.until > 0 ? "in" : "from", c.from)
                : lab__text("%s%s%s at %s", text, i > 0 ? " + " : "", c.effect->kind, c.place);
        free(text);
        text = more;
    }
    return text;
}

static const diag__row *best_with(const diag__table *t, int k)
{
    const diag__row *best = NULL;
    for (int i = 0; i < t->n; i++) {
        const diag__row *row = t->row[i];
        if (diag__has(&row->h, k) && row->failed == NULL && !row->superseded &&
            (best == NULL || row->objective < best->objective)) {
            best = row;
        }
    }
    return best;
}

/* a cause of the verdict: what it gains over the table's row without it */
static char *of_cause(const diag__problem *q, const diag__table *t, const diag__judgement *j, int k,
                      int i)
{
    const diag__row *best = t->row[j->best], *null = t->row[j->null];
    const lab_candidate *c = &q->candidate[k];
    diag__hypothesis less = diag__without(best->h, k);
    const diag__row *row = diag__find(t, &less);
    int fitted = row != NULL && isfinite(row->objective);
    row = fitted ? row : null;
    double sd, amount = diag__amount(best, i, &sd);
    char *is = words(q, &best->h), *without = words(q, &row->h), *text = NULL;
    if (is != NULL && without != NULL) {
        text = lab__text("%s at %s is in the verdict: chi2/dof is %.4g with %s and %.4g with %s, "
                         "-2 ln evidence %.1f and %.1f: a gain of %.1f, where %.0f is enough to "
                         "name a cause. Its amount is %.4g +- %.2g %s.",
                         c->effect->kind, c->place, best->chi2_dof, is, row->chi2_dof, without,
                         best->objective, row->objective, row->objective - best->objective,
                         diag__enough(), amount * c->limit, sd * c->limit, c->unit);
    }
    free(is);
    free(without);
    return text;
}

static char *of_row(const diag__problem *q, const diag__table *t, const diag__judgement *j,
                    const diag__row *row, int k)
{
    const diag__row *best = t->row[j->best];
    const lab_candidate *c = &q->candidate[k];
    int i = 0;
    while (row->h.cause[i] != k) {
        i++;
    }
    if (row == best && j->finding == DIAG_NAMED) {
        return of_cause(q, t, j, k, i);
    }
    double sd, amount = diag__amount(row, i, &sd), behind = row->objective - best->objective;
    char *is = words(q, &row->h), *verdict = words(q, &best->h), *text = NULL;
    const char *why = row == best                          ? "it explains too little to be named"
                      : !diag__is_possible(q, row)         ? "its amount is not possible"
                      : fabs(amount) < diag__interval * sd ? "its interval contains 0"
                      : behind <= diag__convincing && row->h.n == best->h.n
                          ? "it is a rival: the records cannot tell it from the verdict"
                      : row->h.n > best->h.n ? "a cause more does not gain enough"
                                             : "the verdict's hypothesis fits better";
    if (is != NULL && verdict != NULL) {
        text = lab__text("%s at %s: its best fit is row %d (%s), chi2/dof %.4g, -2 ln evidence "
                         "%.1f, amount %.4g +- %.2g %s. The verdict's row %d (%s) has chi2/dof "
                         "%.4g, %.1f: %.1f %s. So: %s.",
                         c->effect->kind, c->place, diag__index(t, row), is, row->chi2_dof,
                         row->objective, amount * c->limit, sd * c->limit, c->unit, j->best,
                         verdict, best->chi2_dof, best->objective, fabs(behind),
                         behind >= 0.0 ? "less" : "more", why);
    }
    free(is);
    free(verdict);
    return text;
}

/* never fitted: what the last linear model predicts of it */
static char *of_column(const diag__problem *q, const diag__linear *l, int k)
{
    const lab_candidate *c = &q->candidate[k];
    int set[DIAG_CAUSES + 1] = {0, 1, 2};
    double amount[DIAG_CAUSES + 1], most = -INFINITY, at = NAN,
                                    has = diag__linear_gain(l, set, l->own, amount);
    for (int i = l->own; i < l->n; i++) {
        set[l->own] = i;
        if (l->cause[i] == k) {
            double gain = diag__linear_gain(l, set, l->own + 1, amount) - has;
            at = gain > most ? amount[l->own] : at;
            most = fmax(most, gain);
        }
    }
    return isfinite(most)
               ? lab__text("%s at %s was never fitted: beside the last hypothesis that was "
                           "linearised it is predicted to gain %.1f of -2 ln evidence with an "
                           "amount of %.4g %s%s; a fit needs 12, a cause 25.",
                           c->effect->kind, c->place, most, at * c->limit, c->unit,
                           diag__thinkable(c, at) ? "" : ", which is not possible")
               : lab__text("%s at %s was never fitted: %s.", c->effect->kind, c->place,
                           l->unseen != NULL && l->unseen[k] != NULL ? l->unseen[k]
                                                                     : "it was not simulated");
}

stein_status diag__explain(const diag__problem *q, const diag__table *t, const diag__judgement *j,
                           const char *name, char **text, stein_err *err)
{
    int k = find(q, name);
    if (k < 0) {
        return lab__fail(err, STEIN_ENAME,
                         "no candidate \"%s\": expected KIND@PLACE as stein effects lists them, "
                         "e.g. viscous_friction@hammer",
                         name);
    }
    const diag__row *row = best_with(t, k);
    *text = row != NULL ? of_row(q, t, j, row, k)
            : q->untestable[k] != NULL
                ? lab__text("%s at %s was never fitted: %s.", q->candidate[k].effect->kind,
                            q->candidate[k].place, q->untestable[k])
                : of_column(q, &t->last, k);
    return *text != NULL ? STEIN_OK : lab__no_memory(err);
}
