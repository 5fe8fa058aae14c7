/* SPDX-License-Identifier: GPL-3.0-or-later
 * draw.c - one draw: the measurements are made, diagnosed as a program of its own, judged.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "hidden.h"

enum { FIT = 12, HELD = 6, SECONDS = 1200, SEEDS_A_LEVEL = 10000, SEEDS_A_RUN = 100000 };

void draw_paths(const setup *s, const char *level, int draw, char set[PATH], char answer[PATH],
                char out[PATH], char scored[PATH])
{
    char name[2 * NAME];
    snprintf(name, sizeof name, "%lu-%s-%04d", s->seed, level, draw);
    snprintf(set, PATH, "%s/sets/%s", s->folder, name);
    snprintf(answer, PATH, "%s/sealed/%s.json", s->folder, name);
    snprintf(out, PATH, "%.500s/%s", s->results, name);
    snprintf(scored, PATH, "%.500s/%s.score", s->results, name);
}

/* "L1x2": two effects, each of that size */
static int is_double(const char *level)
{
    return strcmp(level + strlen(level) - 2, "x2") == 0;
}

/* Sets of different levels are different sets: each level has seeds of its own. */
static unsigned long seed_of(const setup *s, const char *level, int draw)
{
    unsigned long k = strcmp(level, "null") == 0 ? 0 : (unsigned long)(level[1] - '0');
    k += is_double(level) ? 4 : 0;
    return s->seed * SEEDS_A_RUN + k * SEEDS_A_LEVEL + (unsigned long)draw;
}

/* the answer is written last, so a set with an answer is complete */
static int make(const setup *s, const char *level, int draw, const char *set, const char *answer)
{
    char program[PATH], seed[NAME], part[PATH + 8], log[PATH + 8], size[3] = "";
    snprintf(program, sizeof program, "%s/reality", s->build);
    snprintf(seed, sizeof seed, "%lu", seed_of(s, level, draw));
    snprintf(part, sizeof part, "%s.part", answer);
    snprintf(log, sizeof log, "%s.log", answer);
    int null = strcmp(level, "null") == 0;
    snprintf(size, sizeof size, "%.2s", level);
    char *argv[] = {program,
                    "--model",
                    (char *)s->model,
                    "--seed",
                    seed,
                    "-o",
                    (char *)set,
                    "--answer",
                    part,
                    null ? "--null" : "--level",
                    null ? NULL : size,
                    is_double(level) ? "--also" : NULL,
                    NULL};
    if (access(answer, R_OK) == 0) {
        return 0;
    }
    int code = process_run(argv, log, 0.0, NULL);
    if (code != 0 || rename(part, answer) != 0) {
        fprintf(stderr, "hidden: %s: the set cannot be made (exit %d), see %s\n", set, code, log);
        return -1;
    }
    unlink(log);
    return 0;
}

static void diagnose(const setup *s, const char *set, const char *out, score *r)
{
    char file[FIT + HELD][PATH + 20], program[PATH + 8], log[PATH + 8];
    char *argv[FIT + HELD + 10];
    int n = 0;
    snprintf(program, sizeof program, "%s/stein", s->results);
    snprintf(log, sizeof log, "%s.log", out);
    argv[n++] = program;
    argv[n++] = "diagnose";
    argv[n++] = (char *)s->model;
    for (int i = 0; i < FIT + HELD; i++) {
        snprintf(file[i], sizeof file[i], "%s/%s_%02d.csv", set, i < FIT ? "fit" : "held",
                 i < FIT ? i + 1 : i - FIT + 1);
        if (i == FIT) {
            argv[n++] = "--holdout";
        }
        argv[n++] = file[i];
    }
    argv[n++] = "-j";
    argv[n++] = "1";
    argv[n++] = "-o";
    argv[n++] = (char *)out;
    argv[n] = NULL;
    double start = process_clock();
    r->exit_code = process_run(argv, log, SECONDS, &r->cpu);
    r->wall = process_clock() - start;
}

int draw_run(const setup *s, int level, int draw)
{
    char set[PATH], answer[PATH], out[PATH], scored[PATH];
    score r = {.draw = draw, .seed = (double)seed_of(s, s->level[level], draw)};
    draw_paths(s, s->level[level], draw, set, answer, out, scored);
    if (access(scored, R_OK) == 0) {
        return 0;
    }
    snprintf(r.level, sizeof r.level, "%s", s->level[level]);
    snprintf(r.build, sizeof r.build, "%s", s->hash);
    if (make(s, s->level[level], draw, set, answer) != 0) {
        return -1;
    }
    if (s->only_sets) {
        return 0;
    }
    diagnose(s, set, out, &r);
    if (judge(s, answer, out, &r) != 0) {
        return -1;
    }
    if (s->verbose) {
        printf("%s %3d  %s at %s: %s, %s at %s, rank %d, %.1f s\n", r.level, draw, r.kind, r.place,
               r.verdict, r.first_kind, r.first_place, r.rank, r.cpu);
        fflush(stdout);
    }
    return score_write(scored, &r);
}
