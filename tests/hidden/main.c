/* SPDX-License-Identifier: GPL-3.0-or-later
 * main.c - command line of the blind tests.
 *
 *   hidden run [--draws 200] [--levels null,L1,L2,L3,L1x2,X1,T1] [--jobs 2] [--threads 1]
 *       [--seed 1] [--quiet]
 *       make, diagnose and judge what is not judged yet, then print the table; --jobs at once, each
 *       diagnosis on --threads: what one takes on two cores is that of --jobs 1 --threads 2
 *   hidden sets ...                     only make the sets
 *   hidden table ...                    the table of what is judged, also by a run that goes on
 *   hidden readme FILE ...              the table into a document, between the two marker lines of
 *                                       these levels
 *   hidden judge ANSWER OUT             one diagnosis in the folder OUT, as "name value" lines
 * and for all of them: --world any (mechanisms of tests/world; --levels
 * null,small,clear,gross,two,law,wrong,mistake; --only MECHANISM), --limit SECONDS of processor
 * time,
 * --build build, --model models/stein1788.yaml, -o DIR (build/hidden-sets),
 * --record FILE.csv: results that are kept. Draws that are in it are not made again; run adds its
 * own, table shows them.
 *
 * Seeds: tables of docs/validation.md are drawn with seeds that nothing was tuned on.
 */
#include <errno.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "hidden.h"

enum { OK, FAILED, USAGE };

static int usage(const char *why, const char *what)
{
    fprintf(stderr,
            "hidden: %s%s\nusage: hidden run|sets|table|readme FILE|judge ANSWER OUT [--world any] "
            "[--only MECHANISM] [--draws N] [--levels null,L1,L2,L3] [--limit SECONDS] [--jobs N] "
            "[--threads N] [--seed N] [--build DIR] [--model FILE] "
            "[-o DIR] [--record FILE]\n",
            why, what);
    return USAGE;
}

/* ---- options ---- */

static int read_levels(setup *s, const char *list)
{
    s->nlevel = 0;
    while (*list != '\0') {
        size_t n = strcspn(list, ", ");
        int two = n == 4 && strncmp(list + 2, "x2", 2) == 0; // effects at once
        int known = (n == 4 && strncmp(list, "null", 4) == 0) ||
                    (n == 2 && (strncmp(list, "X1", 2) == 0 || strncmp(list, "T1", 2) == 0)) ||
                    ((n == 2 || two) && list[0] == 'L' && list[1] >= '1' && list[1] <= '3');
        char name[NAME];
        snprintf(name, sizeof name, "%.*s", (int)n, list);
        known |= draw_world(name) >= 0;
        if (!known || s->nlevel == (int)(sizeof s->level / sizeof *s->level)) {
            return -1;
        }
        snprintf(s->level[s->nlevel++], NAME, "%.*s", (int)n, list);
        list += n + strspn(list + n, ", ");
    }
    return s->nlevel > 0 ? 0 : -1;
}

static int option(setup *s, const char *name, const char *value)
{
    long n = strtol(value, NULL, 10);
    if (strcmp(name, "--draws") == 0) {
        s->draws = (int)n;
        return n >= 1 && n <= DRAWS;
    }
    if (strcmp(name, "--jobs") == 0) {
        s->jobs = (int)n;
        return n >= 1 && n <= 64;
    }
    if (strcmp(name, "--threads") == 0) {
        s->threads = (int)n;
        return n >= 1 && n <= 64;
    }
    if (strcmp(name, "--seed") == 0) {
        s->seed = (unsigned long)n;
        return n >= 1 && n <= 40000;
    }
    if (strcmp(name, "--levels") == 0) {
        return read_levels(s, value) == 0;
    }
    if (strcmp(name, "--limit") == 0) {
        s->limit = (int)n;
        return n >= 1 && n <= 100000;
    }
    if (strcmp(name, "--world") == 0) {
        s->world = 1;
        return strcmp(value, "any") == 0;
    }
    const struct {
        const char *name, **to;
    } texts[] = {{"--build", &s->build},
                 {"--only", &s->only},
                 {"--model", &s->model},
                 {"-o", &s->folder},
                 {"--record", &s->record}};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        if (strcmp(name, texts[i].name) == 0) {
            *texts[i].to = value;
            return strlen(value) < PATH / 3;
        }
    }
    return 0;
}

/* @return the number of words that are no option, -1 after a message */
static int parse(setup *s, int argc, char **argv, const char *word[3])
{
    int n = 0;
    *s = (setup){.build = "build",
                 .model = "models/stein1788.yaml",
                 .seed = 1,
                 .draws = 200,
                 .jobs = 2,
                 .threads = 1,
                 .limit = 1200,
                 .verbose = 1};
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--quiet") == 0) {
            s->verbose = 0;
        } else if (argv[i][0] == '-') {
            if (i + 1 >= argc || !option(s, argv[i], argv[i + 1])) {
                return usage("what is ", argv[i]), -1;
            }
            i++;
        } else if (n < 3) {
            word[n++] = argv[i];
        } else {
            return usage("one word too many: ", argv[i]), -1;
        }
    }
    if (s->nlevel == 0) {
        read_levels(s, s->world ? "null,small,clear,gross" : "null,L1,L2,L3");
    }
    for (int k = 0; k < s->nlevel; k++) {
        int there = strcmp(s->level[k], "null") == 0 || (draw_world(s->level[k]) >= 0) == s->world;
        if (!there) {
            return usage("no level of this world: ", s->level[k]), -1;
        }
    }
    return n;
}

/* ---- what is judged: a copy, that a later build does not change ---- */

static int hash_of(const char *path, char hash[NAME])
{
    uint64_t h = 14695981039346656037u;
    int c;
    FILE *f = fopen(path, "rb");
    if (f == NULL) {
        fprintf(stderr, "hidden: %s: %s\n", path, strerror(errno));
        return -1;
    }
    while ((c = getc(f)) != EOF) {
        h = (h ^ (uint64_t)(unsigned char)c) * 1099511628211u;
    }
    fclose(f);
    snprintf(hash, NAME, "%08lx", (unsigned long)((h ^ (h >> 32)) & 0xffffffffu));
    return 0;
}

static int prepare(setup *s, int copy)
{
    char program[PATH], mine[PATH + 8], path[PATH];
    static char folder[PATH];
    if (s->folder == NULL) {
        snprintf(folder, sizeof folder, s->world ? "%s/world-sets" : "%s/hidden-sets", s->build);
        s->folder = folder;
    }
    snprintf(program, sizeof program, "%s/stein", s->build);
    if (hash_of(program, s->hash) != 0) {
        return -1;
    }
    snprintf(s->results, sizeof s->results, "%s/%s", s->folder, s->hash);
    snprintf(mine, sizeof mine, "%s/stein", s->results);
    if (!copy) {
        return 0;
    }
    snprintf(path, sizeof path, "%s/sets", s->folder);
    int status = process_folder(path);
    snprintf(path, sizeof path, "%s/sealed", s->folder);
    status = status == 0 ? process_folder(path) : status;
    status = status == 0 ? process_folder(s->results) : status;
    return status == 0 && access(mine, X_OK) != 0 ? process_copy("", program, mine) : status;
}

/* ---- draws in parallel ---- */

/* wait for one of the draws under way. @return 1 when it failed */
static int wait_one(int *running)
{
    int status = 0;
    pid_t child = wait(&status);
    --*running;
    return child < 0 || !WIFEXITED(status) || WEXITSTATUS(status) != 0;
}

/* levels take turns, so that a run that is broken off has something of each */
static int run_all(const setup *s)
{
    int running = 0, failed = 0;
    for (int i = 0; i < s->draws * s->nlevel; i++) {
        fflush(NULL);
        pid_t child = fork();
        if (child == 0) {
            _exit(draw_run(s, i % s->nlevel, i / s->nlevel + 1) == 0 ? 0 : 1);
        }
        failed += child < 0;
        running += child > 0;
        if (running == s->jobs) {
            failed += wait_one(&running);
        }
    }
    while (running > 0) {
        failed += wait_one(&running);
    }
    return failed;
}

static int show(const setup *s)
{
    char path[PATH + 20];
    snprintf(path, sizeof path, "%s/confusions.txt", s->results);
    table_print(stdout, s);
    if (table_confusions(path, s) != 0) {
        return FAILED;
    }
    printf("%s\n", path);
    return OK;
}

static int judge_one(const setup *s, const char *answer, const char *out)
{
    score r = {0};
    snprintf(r.level, sizeof r.level, "-");
    snprintf(r.build, sizeof r.build, "%s", s->hash);
    if (judge(s, answer, out, &r) != 0) {
        return FAILED;
    }
    score_print(stdout, &r);
    return OK;
}

int main(int argc, char **argv)
{
    setup s;
    const char *word[3] = {"", "", ""};
    int n = parse(&s, argc, argv, word);
    if (n < 0) {
        return USAGE;
    }
    int is_run = n == 1 && strcmp(word[0], "run") == 0;
    int is_sets = n == 1 && strcmp(word[0], "sets") == 0;
    int is_table = n == 1 && strcmp(word[0], "table") == 0;
    int is_readme = n == 2 && strcmp(word[0], "readme") == 0;
    int is_judge = n == 3 && strcmp(word[0], "judge") == 0;
    if (!is_run && !is_sets && !is_table && !is_readme && !is_judge) {
        return usage("what is to be done? ", word[0]);
    }
    if (prepare(&s, !is_table && !is_readme) != 0) {
        return FAILED;
    }
    if (is_judge) {
        return judge_one(&s, word[1], word[2]);
    }
    if (record_read(&s) != 0) {
        return FAILED;
    }
    if (is_readme) {
        return table_into(word[1], &s) == 0 ? OK : FAILED;
    }
    s.only_sets = is_sets;
    int failed = is_run || is_sets ? run_all(&s) : 0;
    if (failed > 0) {
        fprintf(stderr, "hidden: %d draws failed\n", failed);
    }
    int kept = is_run ? record_write(&s) : 0; // looking changes nothing
    int status = is_sets ? OK : kept != 0 ? FAILED : show(&s);
    return failed > 0 ? FAILED : status;
}
