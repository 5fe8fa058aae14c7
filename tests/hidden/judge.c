/* SPDX-License-Identifier: GPL-3.0-or-later
 * judge.c - the result against the hidden effect.
 *
 * Right cause and place: kind and place of the first cause are the answer's. The set: all causes
 * and their rivals. Class: the verdict.
 *
 * Some descriptions are exactly the same (a contact that lies deeper and a line that is shifted):
 * one of them is a candidate, and `stein effects MODEL --json` lists the others as `also_called`.
 * Both counts are kept: strict, and with these as one cause.
 *
 * The number. Most kinds have a separate amount, which is compared directly. Where a number of the
 * file is wrong the answer has its true value; found is the value in extended.yaml, as `stein
 * check` reads it, with the interval of the amount. Its error is relative to how far the true value
 * is from the file's, not to the value itself: 2 % of a length would be a large error.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "hidden.h"

names names_of(const tree *t)
{
    return (names){tree_text(t, "kind"), tree_text(t, "place")};
}

static int same(names a, names b)
{
    return strcmp(a.kind, b.kind) == 0 && strcmp(a.place, b.place) == 0;
}

/* the output of a program as JSON */
static tree *said(char *const argv[], const char *log)
{
    return process_run(argv, log, 0.0, NULL) == 0 ? tree_read(log) : NULL;
}

/* ---- identical descriptions ---- */

static int has_word(const char *words, const char *word)
{
    size_t n = strlen(word);
    for (const char *at = words; n > 0 && *at != '\0';) {
        size_t length = strcspn(at, " ");
        if (length == n && strncmp(at, word, n) == 0) {
            return 1;
        }
        at += length + strspn(at + length, " ");
    }
    return 0;
}

/* is it this candidate, or one of its aliases? */
static int belongs(const tree *candidate, names n)
{
    return same(names_of(candidate), n) || (strcmp(n.kind, "wrong_parameter") == 0 &&
                                            has_word(tree_text(candidate, "also_called"), n.place));
}

int names_alike(const tree *candidates, names a, names b)
{
    for (const tree *c = candidates != NULL ? candidates->child : NULL; c != NULL; c = c->next) {
        if (belongs(c, a) && belongs(c, b)) {
            return 1;
        }
    }
    return same(a, b);
}

/* place of the truth in a list, counted on from `rank`; 0 when it is not in it */
static int rank_in(const tree *list, names truth, const tree *candidates, int *rank)
{
    int at = 0;
    for (const tree *c = list != NULL ? list->child : NULL; c != NULL; c = c->next) {
        ++*rank;
        if (at == 0 && (candidates != NULL ? names_alike(candidates, names_of(c), truth)
                                           : same(names_of(c), truth))) {
            at = *rank;
        }
    }
    return at;
}

static int length(const tree *list)
{
    int n = 0;
    for (const tree *c = list != NULL ? list->child : NULL; c != NULL; c = c->next) {
        n++;
    }
    return n;
}

/* as many causes as truths, each of them one
 * @param candidates  by which descriptions may be the same; NULL: names have to be */
static int is_all(const tree *causes, names truth, const tree *also, const tree *candidates)
{
    int two = also != NULL && also->type == '{', rank = 0;
    if (length(causes) != 1 + two || rank_in(causes, truth, candidates, &rank) == 0) {
        return 0;
    }
    rank = 0;
    return !two || rank_in(causes, names_of(also), candidates, &rank) > 0;
}

/* @param truth  the one of two that was found first, if it is */
static void judge_names(score *r, const tree *found, names truth, const tree *candidates)
{
    const tree *causes = tree_get(found, "causes"), *rivals = tree_get(found, "indistinguishable");
    const tree *first = causes != NULL ? causes->child : NULL;
    int rank = 0, at = rank_in(causes, truth, NULL, &rank);
    int in_rivals = rank_in(rivals, truth, NULL, &rank);
    r->causes = length(causes);
    r->rivals = length(rivals);
    snprintf(r->first_kind, NAME, "%s", first != NULL ? tree_text(first, "kind") : "-");
    snprintf(r->first_place, NAME, "%s", first != NULL ? tree_text(first, "place") : "-");
    r->first = at == 1;
    r->set = at > 0 || in_rivals > 0;
    r->rank = at > 0 ? at : in_rivals;
    rank = 0;
    at = rank_in(causes, truth, candidates, &rank);
    r->first_alike = at == 1;
    r->set_alike = at > 0 || rank_in(rivals, truth, candidates, &rank) > 0;
    rank = 0;
    if (r->rank == 0) {
        r->rank = rank_in(tree_get(found, "suspects"), truth, NULL, &rank);
    }
}

/* candidates that these records cannot distinguish from the truth count as well: it would be chance
 * to be right */
static void judge_ties(score *r, const tree *found, const tree *answer, const tree *candidates)
{
    const tree *alike = tree_get(answer, "alike"), *causes = tree_get(found, "causes");
    r->tied = length(alike);
    r->first_tied = r->first_alike;
    r->set_tied = r->set_alike;
    for (const tree *a = alike != NULL ? alike->child : NULL; a != NULL; a = a->next) {
        int rank = 0, at = rank_in(causes, names_of(a), candidates, &rank);
        r->first_tied |= at == 1;
        r->set_tied |= at > 0 || rank_in(tree_get(found, "indistinguishable"), names_of(a),
                                         candidates, &rank) > 0;
    }
}

/* ---- the number ---- */

static double extended_value(const setup *s, const char *out, const char *parameter)
{
    char program[PATH + 8], file[PATH + 20], log[PATH + 20];
    snprintf(program, sizeof program, "%s/stein", s->results);
    snprintf(file, sizeof file, "%s/extended.yaml", out);
    snprintf(log, sizeof log, "%s/extended.json", out);
    char *argv[] = {program, "check", file, "--json", NULL};
    tree *check = said(argv, log);
    const tree *list = tree_get(check, "parameters");
    double value = NAN;
    for (const tree *c = list != NULL ? list->child : NULL; c != NULL; c = c->next) {
        if (strcmp(tree_text(c, "name"), parameter) == 0) {
            value = tree_number(c, "value");
        }
    }
    tree_free(check);
    return value;
}

/* the number of what was hidden. @param also  the second effect where that is asked about, else
 * NULL; a number of the file that it changed is not kept with it */
static const tree *hidden_number(const tree *answer, const tree *also)
{
    const tree *numbers = tree_get(answer, "parameters");
    if (also != NULL) {
        return strcmp(tree_text(also, "class"), "wrong_parameter") != 0 ? tree_get(also, "size")
                                                                        : NULL;
    }
    return numbers != NULL ? numbers->child : NULL;
}

/* @param h  the true number of the first cause, NULL: none is known */
static void judge_number(const setup *s, const char *out, const tree *found, const tree *h,
                         score *r)
{
    const tree *causes = tree_get(found, "causes"), *first = causes != NULL ? causes->child : NULL;
    const tree *numbers = tree_get(first, "parameters");
    const tree *n = numbers != NULL ? numbers->child : NULL;
    r->found = r->lo = r->hi = r->truth = r->error = NAN;
    if (!r->first || n == NULL || h == NULL || n->key == NULL || h->key == NULL) {
        return;
    }
    double amount = tree_number(n, "value"), lo = tree_number(n, "lo"), hi = tree_number(n, "hi");
    double file = tree_number(h, "file"), size = tree_number(h, "value");
    r->truth = size;
    r->found = amount, r->lo = lo, r->hi = hi;
    if (!isnan(file)) { // a number of the file: where is it in the end?
        double end = extended_value(s, out, h->key);
        int scaled = strcmp(n->key, "log_scale") == 0;
        r->found = end;
        r->lo = scaled ? end * exp(lo - amount) : end + (lo - amount);
        r->hi = scaled ? end * exp(hi - amount) : end + (hi - amount);
        size -= file;
    }
    r->numbered = isfinite(r->found) && isfinite(r->lo) && isfinite(r->hi);
    r->covered = r->numbered && r->lo <= r->truth && r->truth <= r->hi;
    r->error = fabs(r->found - r->truth) / fabs(size);
}

/* ---- all of it ---- */

static void judge_answer(const setup *s, const char *out, const tree *found, const tree *answer,
                         const tree *candidates, score *r)
{
    const tree *level = tree_get(answer, "level"), *gain = tree_get(found, "gain");
    const tree *met = tree_get(level, "met"), *rough = tree_get(answer, "wrong_start");
    const char *kind = tree_text(answer, "kind");
    snprintf(r->kind, NAME, "%s", *kind != '\0' ? kind : "-");
    snprintf(r->place, NAME, "%s", *kind != '\0' ? tree_text(answer, "place") : "-");
    snprintf(r->cls, NAME, "%s", tree_text(answer, "class"));
    snprintf(r->verdict, NAME, "%s", found != NULL ? tree_text(found, "verdict") : "failed");
    snprintf(r->mechanism, NAME, "%s", tree_text(answer, "mechanism"));
    int rank = 0;
    r->offered = rank_in(candidates, names_of(answer), candidates, &rank) > 0;
    r->reached = tree_number(level, "reached");
    r->met = met != NULL && met->type == 't';
    r->rough = rough != NULL && rough->type == 't';
    r->right_class = strcmp(r->verdict, r->cls) == 0;
    const tree *causes = tree_get(found, "causes"), *also = tree_get(answer, "also");
    const tree *first = causes != NULL ? causes->child : NULL;
    int second =
        also != NULL && also->type == '{' && first != NULL && same(names_of(first), names_of(also));
    judge_names(r, found, second ? names_of(also) : names_of(answer), candidates);
    judge_ties(r, found, answer, candidates);
    r->right_class |= second && strcmp(r->verdict, tree_text(also, "class")) == 0;
    r->all = is_all(causes, names_of(answer), also, NULL);
    r->all_alike = is_all(causes, names_of(answer), also, candidates);
    r->class_alike = r->right_class || r->first_alike;
    judge_number(s, out, found, hidden_number(answer, second ? also : NULL), r);
    r->before = tree_number(gain, "rmse_before");
    r->after = tree_number(gain, "rmse_after");
    r->floor = tree_number(found, "noise_floor");
    judge_law(found, answer, r);
    truth_judge(out, found, answer, candidates, r);
}

tree *judge_effects(const setup *s, const char *out)
{
    char program[PATH + 8], log[PATH + 20];
    snprintf(program, sizeof program, "%s/stein", s->results);
    snprintf(log, sizeof log, "%s.effects", out);
    char *argv[] = {program, "effects", (char *)s->model, "--json", NULL};
    tree *effects = said(argv, log);
    remove(log);
    return effects;
}

int judge(const setup *s, const char *answer, const char *out, score *result)
{
    char path[PATH + 20];
    snprintf(path, sizeof path, "%s/diagnosis.json", out);
    // no verdict was given: 0 and 3 (not converged) have one
    int gave = result->exit_code == 0 || result->exit_code == 3;
    tree *found = gave || result->exit_code == 1 ? tree_read(path) : NULL;
    tree *sealed = tree_read(answer);
    // with 1 there is one verdict only: that the model cannot be used
    if (!gave && strcmp(tree_text(found, "verdict"), "unusable_model") != 0) {
        tree_free(found);
        found = NULL;
    }
    tree *effects = judge_effects(s, out);
    if (sealed != NULL) {
        judge_answer(s, out, found, sealed, tree_get(effects, "candidates"), result);
    } else {
        fprintf(stderr, "hidden: %s cannot be read\n", answer);
    }
    int status = sealed != NULL ? 0 : -1;
    tree_free(found);
    tree_free(sealed);
    tree_free(effects);
    return status;
}
