/* SPDX-License-Identifier: GPL-3.0-or-later
 * truth.c - the step of a diagnosis that lost the hidden effect, from its trace.
 *
 *   not_offered    it is no candidate of the mechanism
 *   not_evaluated  no row has it, that is, no proposer asked for it with enough to gain
 *   not_converged  rows have it, but no fit of them has come to its end
 *   outbid         another row has more evidence
 *   judged_away    its row has the most evidence, and the verdict is another one
 *   found          it is the verdict
 */
#include <math.h>
#include <string.h>

#include "hidden.h"

/* does a list of causes have it, or an identical description? */
static int has(const tree *list, names what, const tree *candidates)
{
    for (const tree *c = list != NULL ? list->child : NULL; c != NULL; c = c->next) {
        if (names_alike(candidates, names_of(c), what)) {
            return 1;
        }
    }
    return 0;
}

static int has_all(const tree *list, const tree *answer, const tree *also, const tree *candidates)
{
    return has(list, names_of(answer), candidates) &&
           (also == NULL || has(list, names_of(also), candidates));
}

/* rows from there on were compared with one another: with estimated noise begin again */
static const tree *first_row(const tree *rows)
{
    const tree *first = rows != NULL ? rows->child : NULL;
    for (const tree *r = first; r != NULL; r = r->next) {
        if (strcmp(tree_text(r, "source"), "N") == 0) {
            return r;
        }
    }
    return first;
}

static const char *step_of(const tree *rows, const tree *answer, const tree *also,
                           const tree *candidates)
{
    double best = -INFINITY, least = -INFINITY;
    int evaluated = 0, converged = 0;
    const tree *all = rows != NULL ? rows->child : NULL, *from = first_row(rows);
    for (const tree *r = all; r != NULL; r = r->next) {
        evaluated |= has_all(tree_get(r, "hypothesis"), answer, also, candidates);
    }
    for (const tree *r = from; r != NULL; r = r->next) {
        const tree *possible = tree_get(r, "possible"), *ended = tree_get(r, "converged");
        double evidence = tree_number(r, "evidence");
        int is = has_all(tree_get(r, "hypothesis"), answer, also, candidates);
        if (possible != NULL && possible->type == 't' && isfinite(evidence)) {
            best = fmax(best, evidence);
            least = is ? fmax(least, evidence) : least;
        }
        converged |= is && ended != NULL && ended->type == 't';
    }
    return !evaluated     ? "not_evaluated"
           : !converged   ? "not_converged"
           : least < best ? "outbid"
                          : "judged_away";
}

void truth_judge(const char *out, const tree *found, const tree *answer, const tree *candidates,
                 score *r)
{
    char path[PATH + 20];
    snprintf(path, sizeof path, "%s/trace.jsonl", out);
    tree *rows = tree_lines(path);
    const tree *also = tree_get(answer, "also");
    also = also != NULL && also->type == '{' ? also : NULL;
    int is = has_all(tree_get(found, "causes"), answer, also, candidates);
    const char *step = is            ? "found"
                       : !r->offered ? "not_offered"
                                     : step_of(rows, answer, also, candidates);
    int effect = strcmp(r->kind, "-") != 0 && !r->outside;
    snprintf(r->lost, NAME, "%s", effect ? step : "-");
    tree_free(rows);
}
