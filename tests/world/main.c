/* SPDX-License-Identifier: GPL-3.0-or-later
 * main.c - command line of the world.
 *
 *   world draw --level LEVEL --seed N [--mechanism NAME] -o DIR --answer FILE.json
 *       a set: DIR/model.yaml, fit_01.csv ..., held_01.csv ..., and what is hidden in it
 *   world exact NAME [--seed N] [--hide I] -o DIR
 *       model.yaml and exact.csv: nothing hidden, exact instruments, for comparison with another
 *       simulator; with --hide effect I of the list is in the record and not in the file, and the
 *       options that put it into `stein simulate` are printed
 *   world compare A.csv B.csv
 *       largest difference of each column that both have, over the largest value of it
 *   world list               the mechanisms
 *   world effects NAME       kind and place of all that can be hidden in one
 *
 * Levels: null, small, clear, gross (0.5, 2, 100 noises are left of one effect when everything else
 * is refitted), two (two effects, clear each), law (clear, a law in no table), wrong (the set-up is
 * wrong), mistake (a number of the file is off by a factor).
 */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "world.h"

enum { OK, FAILED, USAGE };
enum { CANDIDATES = 200 };

typedef struct options {
    const char *word[3], *level, *mechanism, *folder, *answer, *hide;
    int words;
    unsigned long seed;
} options;

static int usage(const char *why)
{
    fprintf(stderr,
            "world: %s\nusage: world draw --level L --seed N [--mechanism NAME] -o DIR --answer "
            "FILE | exact NAME -o DIR | compare A B | list | effects NAME\n",
            why);
    return USAGE;
}

static const entry *entry_of(const char *name)
{
    for (int i = 0; i < catalog_count(); i++) {
        if (strcmp(catalog[i].name, name) == 0) {
            return &catalog[i];
        }
    }
    fprintf(stderr, "world: no mechanism %s\n", name);
    return NULL;
}

static int folder_made(const char *path)
{
    if (mkdir(path, 0777) != 0 && errno != EEXIST) {
        perror(path);
        return 0;
    }
    return 1;
}

/* hide effect number `which` in p, as large as a quarter of its limit, and print it as options of
 * another simulator. @return 0, -1: it is none of a simulation, but of whoever samples; or none
 */
static int hide_in(const mech *m, const design *d, double *p, int which, chance *c)
{
    static effect list[CANDIDATES];
    double clean[NUMBERS];
    extent x;
    memcpy(clean, p, sizeof clean);
    int n = size_extent(m, p, d, &x) == 0 ? effect_list(m, &x, list, CANDIDATES, 0) : 0;
    if (which >= n) {
        return -1;
    }
    effect *e = &list[which];
    effect_sides(e, m, &x, c);
    fprintf(stderr, "%s %s\n", e->kind->name, e->place);
    if (strstr(e->kind->name, "delay") != NULL || strchr("tx", e->kind->site) != NULL) {
        return 0;
    }
    effect_apply(e, m, 0.25 * e->limit, p);
    for (int i = 0; i < m->nnumber; i++) {
        if (fabs(p[i] - clean[i]) > 0.0) {
            printf("--set %s=%.17g\n", m->number[i].name, p[i]);
        }
    }
    return 0;
}

static int exact(const options *o)
{
    const entry *e = entry_of(o->word[1]);
    static mech m;
    static design d;
    chance c;
    wrong w;
    double p[NUMBERS];
    char path[PATH];
    if (e == NULL || !folder_made(o->folder)) {
        return FAILED;
    }
    chance_seed(&c, o->seed);
    e->build(&m, &c);
    design_draw(&d, &m, &c, 1);
    wrong_none(&w);
    for (int i = 0; i < m.nnumber; i++) {
        p[i] = m.number[i].value = m.number[i].file;
    }
    if (o->hide != NULL && hide_in(&m, &d, p, (int)strtol(o->hide, NULL, 10), &c) != 0) {
        return FAILED;
    }
    snprintf(path, sizeof path, "%.900s/exact.csv", o->folder);
    return write_model(o->folder, &m, &d, 1) == 0 &&
                   write_record(path, &m, &m, p, &d, &d.record[0], &w, &c, 1) == 0
               ? OK
               : FAILED;
}

/* all that can be hidden in a mechanism, in the numbering of `exact --hide` */
static int list_effects(const options *o)
{
    const entry *e = entry_of(o->word[1]);
    static mech m;
    static design d;
    static effect list[CANDIDATES];
    double p[NUMBERS];
    extent x;
    chance c;
    if (e == NULL) {
        return FAILED;
    }
    chance_seed(&c, o->seed);
    e->build(&m, &c);
    design_draw(&d, &m, &c, 1);
    for (int i = 0; i < m.nnumber; i++) {
        p[i] = m.number[i].value;
    }
    int n = size_extent(&m, p, &d, &x) == 0 ? effect_list(&m, &x, list, CANDIDATES, 0) : 0;
    for (int i = 0; i < n; i++) {
        printf("%s %s\n", list[i].kind->name, list[i].place);
    }
    return n > 0 ? OK : FAILED;
}

/* ---- a draw ---- */

static const struct {
    const char *name;
    double target; /* noises that are left */
} levels[] = {{"null", 0.0}, {"small", 0.5}, {"clear", 2.0}, {"gross", 100.0},
              {"two", 2.0},  {"law", 2.0},   {"wrong", 0.0}, {"mistake", 20.0}};
enum { LEVELS = sizeof levels / sizeof *levels, REDRAWS = 25 };

/* a kind first, then a place: else channels and lengths, which are many, would be most of it */
static effect picked(const effect *list, int n, chance *c)
{
    const kind *distinct[CANDIDATES];
    int kinds_there = 0, places = 0, at[CANDIDATES];
    for (int i = 0; i < n; i++) {
        if (i == 0 || list[i].kind != list[i - 1].kind) {
            distinct[kinds_there++] = list[i].kind;
        }
    }
    const kind *k = distinct[chance_pick(c, kinds_there)];
    for (int i = 0; i < n; i++) {
        if (list[i].kind == k) {
            at[places++] = i;
        }
    }
    return list[at[chance_pick(c, places)]];
}

/* hide one effect in p. @return 1: it is as large as it shall be */
static int hide(answer *a, sizer *z, int which, double *p, chance *c)
{
    static effect list[CANDIDATES];
    int n = effect_list(a->told, &a->x, list, CANDIDATES, strcmp(a->level, "law") == 0);
    for (int i = 0; i < REDRAWS && n > 0; i++) {
        effect e = picked(list, n, c);
        effect_sides(&e, a->told, &a->x, c);
        // numbers of a body that is cut in two belong to its parts
        int cut = a->e[0].kind != NULL && a->e[0].kind->site == 'x' && strchr("bp", e.kind->site);
        if (which == 1 && (cut || strcmp(e.place, a->e[0].place) == 0)) {
            continue;
        }
        if (size_find(z, &e, a->target, &a->reached) == 1) {
            a->e[which] = e;
            static mech room[2];
            double q[NUMBERS];
            a->m = structure_with(&room[which], a->m, &e, e.size, p, q);
            memcpy(p, q, sizeof q);
            return 1;
        }
    }
    return 0;
}

/* what else would look like the first effect */
static void find_alike(answer *a, sizer *z, chance *c)
{
    static effect list[CANDIDATES];
    int n = effect_list(a->told, &a->x, list, CANDIDATES, 0);
    for (int i = 0; i < n; i++) {
        effect_sides(&list[i], a->told, &a->x, c);
    }
    n = size_alike(z, &a->e[0], list, n);
    a->nalike = n < ALIKE ? n : ALIKE;
    memcpy(a->alike, list, sizeof *list * (size_t)a->nalike);
}

/* numbers that are true, with what is hidden. @return 0, -1: it cannot be done with this design */
static int hidden_numbers(answer *a, mech *told, double *p, chance *c)
{
    double clean[NUMBERS];
    for (int i = 0; i < a->m->nnumber; i++) {
        p[i] = a->m->number[i].value;
    }
    memcpy(clean, p, sizeof clean);
    a->met = 1;
    if (!(a->target > 0.0)) {
        return 0;
    }
    sizer *z = size_begin(a->m, clean, a->d);
    int status = z != NULL && size_extent(a->m, clean, a->d, &a->x) == 0 ? 0 : -1;
    if (status == 0 && strcmp(a->level, "mistake") == 0) {
        status = mistake_draw(told, clean, z, &a->x, &a->e[0], &a->reached, c) ? 0 : -1;
        size_drop(z);
        return status;
    }
    for (int k = 0; status == 0 && k < 1 + (strcmp(a->level, "two") == 0); k++) {
        status = hide(a, z, k, p, c) ? 0 : -1;
    }
    if (status == 0 && !a->e[0].kind->outside) {
        chance apart = *c; // the records do not depend on it
        find_alike(a, z, &apart);
    }
    size_drop(z);
    return status;
}

static int write_set(const options *o, const answer *a, chance *c)
{
    char path[PATH];
    int status = folder_made(o->folder) ? write_model(o->folder, a->told, a->d, 0) : -1;
    for (int i = 0; status == 0 && i < a->d->nfit + a->d->nheld; i++) {
        int fit = i < a->d->nfit;
        snprintf(path, sizeof path, "%.900s/%s_%02d.csv", o->folder, fit ? "fit" : "held",
                 fit ? i + 1 : i - a->d->nfit + 1);
        status = write_record(path, a->m, a->told, a->p, a->d, &a->d->record[i], &a->w, c, 0);
    }
    return status == 0 ? write_answer(o->answer, a) : -1;
}

/* the file describes another mechanism than the records */
static int find_other(mech *told, const mech *m, chance *c)
{
    static design unused;
    for (int i = 0; i < 100; i++) {
        catalog[chance_pick(c, catalog_count())].build(told, c);
        design_draw(&unused, told, c, 0);
        if (wrong_fits(m, told)) {
            return 1;
        }
    }
    return 0;
}

static int attempt(const options *o, int level, const entry *e, unsigned long seed)
{
    static mech m, told;
    static design d;
    static double p[NUMBERS];
    chance c;
    answer a = {.seed = o->seed,
                .level = levels[level].name,
                .target = levels[level].target,
                .m = &m,
                .told = &told,
                .d = &d,
                .p = p};
    chance_seed(&c, seed);
    e->build(&m, &c);
    design_draw(&d, &m, &c, 0);
    wrong_none(&a.w);
    told = m;
    if (hidden_numbers(&a, &told, p, &c) != 0) {
        return -1;
    }
    if (strcmp(a.level, "wrong") == 0 && !wrong_draw(&a.w, &told, &m, p, &d, &c)) {
        return -1;
    }
    if (a.w.other && !find_other(&told, &m, &c)) {
        return -1;
    }
    return write_set(o, &a, &c);
}

static int draw(const options *o)
{
    int level = -1;
    for (int i = 0; i < LEVELS; i++) {
        level = o->level != NULL && strcmp(o->level, levels[i].name) == 0 ? i : level;
    }
    if (level < 0 || o->answer == NULL) {
        return usage("draw needs --level and --answer");
    }
    const entry *e = o->mechanism != NULL ? entry_of(o->mechanism)
                                          : &catalog[o->seed % (unsigned long)catalog_count()];
    for (unsigned long i = 0; e != NULL && i < 8; i++) {
        if (attempt(o, level, e, o->seed * 1000 + i) == 0) {
            return OK;
        }
    }
    fprintf(stderr, "world: no such set can be made with seed %lu\n", o->seed);
    return FAILED;
}

static int parse(options *o, int argc, char **argv)
{
    *o = (options){.seed = 1, .folder = "."};
    for (int i = 1; i < argc; i++) {
        const char *value = i + 1 < argc ? argv[i + 1] : NULL;
        const struct {
            const char *name, **to;
        } texts[] = {{"--level", &o->level},
                     {"--mechanism", &o->mechanism},
                     {"-o", &o->folder},
                     {"--answer", &o->answer},
                     {"--hide", &o->hide}};
        int known = 0;
        if (argv[i][0] != '-') {
            if (o->words == 3) {
                return -1;
            }
            o->word[o->words++] = argv[i];
            continue;
        }
        for (size_t k = 0; k < sizeof texts / sizeof *texts && value != NULL; k++) {
            if (strcmp(argv[i], texts[k].name) == 0) {
                *texts[k].to = value;
                known = 1;
            }
        }
        if (value != NULL && strcmp(argv[i], "--seed") == 0) {
            o->seed = strtoul(value, NULL, 10);
            known = 1;
        }
        if (!known) {
            return -1;
        }
        i++;
    }
    return o->words > 0 ? 0 : -1;
}

int main(int argc, char **argv)
{
    options o;
    if (parse(&o, argc, argv) != 0) {
        return usage("what is to be done?");
    }
    const char *what = o.word[0];
    if (strcmp(what, "exact") == 0 && o.words == 2) {
        return exact(&o);
    }
    if (strcmp(what, "effects") == 0 && o.words == 2) {
        return list_effects(&o);
    }
    if (strcmp(what, "draw") == 0 && o.words == 1) {
        return draw(&o);
    }
    if (strcmp(what, "compare") == 0 && o.words == 3) {
        return compare_files(o.word[1], o.word[2], 20) == 0 ? OK : FAILED;
    }
    if (strcmp(what, "list") == 0) {
        for (int i = 0; i < catalog_count(); i++) {
            printf("%s\n", catalog[i].name);
        }
        return OK;
    }
    return usage("what is to be done?");
}
