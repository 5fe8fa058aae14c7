/* SPDX-License-Identifier: GPL-3.0-or-later
 * twin.c - after a diagnosis with rivals: the experiment that `stein plan` proposes, made.
 *
 *      OUT-plan/                       what `stein plan` wrote
 *      OUT-next/next_01.csv ...        its strokes, filmed in the world of the set
 *      OUT-checked/                    or, where no stroke but checks are asked for,
 *                                      the old strokes with what the checks found
 *      OUT-after/                      the diagnosis of the old strokes and the new ones
 *
 * Separated means one of two results. The truth is the first cause, and no other candidate of the
 * first set is left in the second. Or a check has found the truth, and with it nothing is left to
 * explain. Of quantities that were not filmed the other laboratory has an instrument only for the
 * hammer's angle. Quantities that it cannot film are reported and counted separately; an experiment
 * with too many strokes counts as separating nothing.
 */
#include <math.h>
#include <string.h>
#include <unistd.h>

#include "hidden.h"

enum { MOST_STROKES = 24, WORDS = 60, WORD = 200 };

/* words of a command line, with room for those that are made here */
typedef struct words {
    char *argv[WORDS], room[WORDS][WORD];
    int n;
} words;

static void say(words *w, const char *option, const char *text)
{
    if (w->n + 3 < WORDS) {
        w->argv[w->n++] = (char *)option;
        if (text != NULL) {
            snprintf(w->room[w->n], WORD, "%.199s", text);
            w->argv[w->n] = w->room[w->n];
            w->n++;
        }
        w->argv[w->n] = NULL;
    }
}

/* an experiment of plan.json as options of the other laboratory.
 * @return 0, or -1: it lacks it; the reason in why */
static int ask(words *w, const tree *e, char why[NAME])
{
    char text[WORD];
    const tree *set = tree_get(e, "set"), *drive = tree_get(e, "drive");
    const char *channel = tree_text(e, "channel");
    for (const tree *c = set != NULL ? set->child : NULL; c != NULL; c = c->next) {
        snprintf(text, sizeof text, "%s=%.15g", c->key, c->number);
        say(w, "--set", text);
    }
    if (drive != NULL && drive->type == '{') {
        snprintf(text, sizeof text, "%s,%s,%.15g,%.15g", tree_text(drive, "input"),
                 tree_text(drive, "shape"), tree_number(drive, "to") - tree_number(drive, "from"),
                 tree_number(drive, "time"));
        say(w, "--drive", text);
    }
    if (strcmp(channel, "hammer_angle") == 0) {
        say(w, "--hammer", NULL);
    } else if (*channel != '\0') {
        snprintf(why, NAME, "no_instrument_for_%.60s", channel);
        return -1;
    }
    if (tree_number(e, "frames_for_one") > 1.0) {
        snprintf(text, sizeof text, "%.15g", 4000.0 * tree_number(e, "frames_for_one"));
        say(w, "--rate", text);
    }
    return 0;
}

/* without blanks or commas: results are words, in a line and in a table */
static void name_of(char to[NAME], const char *from)
{
    snprintf(to, NAME, "%s", *from != '\0' ? from : "-");
    for (char *c = to; *c != '\0'; c++) {
        *c = *c == ' ' ? '_' : *c == ',' ? ';' : *c;
    }
}

static int is_one_of(const tree *list, const tree *candidates, names n)
{
    for (const tree *c = list != NULL ? list->child : NULL; c != NULL; c = c->next) {
        if (names_alike(candidates, names_of(c), n)) {
            return 1;
        }
    }
    return 0;
}

/* is a candidate of the list other than the truth still in the second set? */
static int any_left(const tree *list, const tree *after, const tree *candidates, names truth)
{
    for (const tree *c = list != NULL ? list->child : NULL; c != NULL; c = c->next) {
        names n = names_of(c);
        if (!names_alike(candidates, n, truth) &&
            (is_one_of(tree_get(after, "causes"), candidates, n) ||
             is_one_of(tree_get(after, "indistinguishable"), candidates, n))) {
            return 1;
        }
    }
    return 0;
}

int twin_separated(const tree *before, const tree *after, const tree *answer,
                   const tree *candidates)
{
    names truth = names_of(answer);
    const tree *causes = tree_get(after, "causes");
    return causes != NULL && causes->child != NULL &&
           names_alike(candidates, names_of(causes->child), truth) &&
           !any_left(tree_get(before, "causes"), after, candidates, truth) &&
           !any_left(tree_get(before, "indistinguishable"), after, candidates, truth);
}

/* @return the plan's first experiment, NULL: no plan */
static const tree *plan(const setup *s, const char *out, tree **whole)
{
    char program[PATH + 8], diagnosis[PATH + 20], folder[PATH + 8], log[PATH + 12], file[PATH + 20];
    snprintf(program, sizeof program, "%s/stein", s->results);
    snprintf(diagnosis, sizeof diagnosis, "%s/diagnosis.json", out);
    snprintf(folder, sizeof folder, "%s-plan", out);
    snprintf(log, sizeof log, "%s-plan.log", out);
    snprintf(file, sizeof file, "%s-plan/plan.json", out);
    char *argv[] = {program,        "plan", (char *)s->model, diagnosis, "-j", "1", "--instruments",
                    "hammer_angle", "-o",   folder,           NULL};
    *whole = process_run(argv, log, 0.0, NULL) == 0 ? tree_read(file) : NULL;
    const tree *list = tree_get(*whole, "experiments");
    return list != NULL ? list->child : NULL;
}

/* @return 0: filmed; -1: not, the reason in r->film */
static int film(const setup *s, int level, int draw, const char *out, const tree *e, score *r)
{
    words w = {.n = 0};
    char folder[PATH + 8], log[PATH + 12], program[PATH], seed[NAME], text[WORD];
    snprintf(folder, sizeof folder, "%s-next", out);
    snprintf(log, sizeof log, "%s-next.log", out);
    w.n = draw_command(s, level, draw, w.argv, program, seed);
    if (ask(&w, e, r->film) != 0) {
        return -1;
    }
    snprintf(text, sizeof text, "%d", r->repeats);
    say(&w, "--next", text);
    w.argv[w.n++] = "-o";
    w.argv[w.n++] = folder;
    w.argv[w.n] = NULL;
    int code = process_run(w.argv, log, 0.0, NULL);
    snprintf(r->film, NAME, code == 0 ? "filmed" : code == 3 ? "not_here" : "failed");
    return code == 0 ? 0 : -1;
}

/* checks, or strokes more. @return 0: they were made; -1: not, the reason in r->film */
static int carry_out(const setup *s, int level, int draw, const char *set, const char *out,
                     const tree *e, const tree *answer, score *r)
{
    const tree *checks = tree_get(e, "check");
    char folder[PATH + 12];
    if (checks == NULL || checks->child == NULL) {
        return film(s, level, draw, out, e, r);
    }
    snprintf(folder, sizeof folder, "%s-checked", out);
    int status = check_make(checks, answer, r->repeats, set, folder);
    snprintf(r->film, NAME, status == 0 ? "checked" : "not_here");
    return status;
}

/* the whole of it, after the first verdict was judged */
static void experiment(const setup *s, int level, int draw, const char *set, const char *out,
                       const tree *before, const tree *answer, score *r)
{
    tree *whole = NULL;
    const tree *e = plan(s, out, &whole);
    char after_folder[PATH + 8], file[PATH + 30], next[PATH + 12];
    double repeats = tree_number(e, "repeats");
    name_of(r->experiment, e != NULL ? tree_text(e, "experiment") : "no plan");
    r->repeats = isfinite(repeats) ? (int)repeats : 0;
    if (e == NULL || r->repeats < 1 || r->repeats > MOST_STROKES) {
        snprintf(r->film, NAME, e == NULL ? "no_plan" : "too_many_strokes");
    } else if (carry_out(s, level, draw, set, out, e, answer, r) == 0) {
        int checked = strcmp(r->film, "checked") == 0;
        snprintf(after_folder, sizeof after_folder, "%s-after", out);
        snprintf(next, sizeof next, checked ? "%s-checked" : "%s-next", out);
        snprintf(file, sizeof file, "%s/diagnosis.json", after_folder);
        int code = draw_diagnose(s, checked ? next : set, next, checked ? 0 : r->repeats,
                                 after_folder, &r->cpu_after);
        tree *after = code == 0 || code == 3 ? tree_read(file) : NULL;
        tree *effects = judge_effects(s, after_folder);
        const tree *causes = tree_get(after, "causes");
        const tree *first = causes != NULL ? causes->child : NULL;
        name_of(r->after_kind, first != NULL ? tree_text(first, "kind") : "");
        name_of(r->after_place, first != NULL ? tree_text(first, "place") : "");
        r->separated = checked && check_covers(tree_get(e, "check"), answer)
                           ? strcmp(tree_text(after, "verdict"), "explained") == 0
                           : twin_separated(before, after, answer, tree_get(effects, "candidates"));
        tree_free(after);
        tree_free(effects);
    }
    tree_free(whole);
}

int twin_run(const setup *s, int level, int draw, const char *set, const char *answer,
             const char *out, score *r)
{
    char path[PATH + 20];
    snprintf(path, sizeof path, "%s/diagnosis.json", out);
    tree *before = tree_read(path), *sealed = tree_read(answer);
    snprintf(r->film, NAME, "-");
    if (r->causes > 0 && r->rivals > 0) {
        experiment(s, level, draw, set, out, before, sealed, r);
    }
    tree_free(before);
    tree_free(sealed);
    return 0;
}
