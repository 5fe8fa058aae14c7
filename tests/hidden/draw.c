/* SPDX-License-Identifier: GPL-3.0-or-later
 * draw.c - one draw: the measurements are made, diagnosed by a separate program, judged.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "hidden.h"

enum { SEEDS_A_LEVEL = 10000 };

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

static const struct {
    const char *name;
    char kind;
} of_world[] = {{"null", 'n'}, {"small", 'L'}, {"clear", 'L'}, {"gross", 'L'},
                {"two", 'L'},  {"law", 'X'},   {"wrong", 'W'}, {"mistake", 'L'}};

int draw_world(const char *level)
{
    for (size_t i = 0; i < sizeof of_world / sizeof *of_world; i++) {
        if (strcmp(of_world[i].name, level) == 0) {
            return (int)i;
        }
    }
    return -1;
}

char draw_kind(const char *level)
{
    int k = draw_world(level);
    return k >= 0 ? of_world[k].kind : level[0];
}

/* "L1x2": two effects, each of that size */
static int is_double(const char *level)
{
    return strcmp(level + strlen(level) - 2, "x2") == 0;
}

/* Sets of different levels are different sets: each level has its own seeds. */
static unsigned long seed_of(const setup *s, const char *level, int draw)
{
    char kind = draw_kind(level);
    if (s->world) {
        return s->seed * SEEDS_A_RUN + (unsigned long)draw_world(level) * SEEDS_A_LEVEL +
               (unsigned long)draw;
    }
    unsigned long k = kind == 'n'   ? 0
                      : kind == 'X' ? 4
                      : kind == 'T' ? 8
                                    : (unsigned long)(level[1] - '0') + (is_double(level) ? 4 : 0);
    return s->seed * SEEDS_A_RUN + k * SEEDS_A_LEVEL + (unsigned long)draw;
}

static int world_command(const setup *s, int level, int draw, char *argv[], char program[PATH],
                         char seed[NAME])
{
    int n = 0;
    snprintf(program, PATH, "%s/world", s->build);
    snprintf(seed, NAME, "%lu", seed_of(s, s->level[level], draw));
    argv[n++] = program;
    argv[n++] = "draw";
    argv[n++] = "--level";
    argv[n++] = (char *)s->level[level];
    argv[n++] = "--seed";
    argv[n++] = seed;
    if (s->only != NULL) {
        argv[n++] = "--mechanism";
        argv[n++] = (char *)s->only;
    }
    argv[n] = NULL;
    return n;
}

int draw_command(const setup *s, int level, int draw, char *argv[], char program[PATH],
                 char seed[NAME])
{
    static char *const sizes[] = {"L1", "L2", "L3"};
    const char *name = s->level[level];
    char kind = draw_kind(name);
    int n = 0;
    if (s->world) {
        return world_command(s, level, draw, argv, program, seed);
    }
    snprintf(program, PATH, "%s/reality", s->build);
    snprintf(seed, NAME, "%lu", seed_of(s, name, draw));
    argv[n++] = program;
    argv[n++] = "--model";
    argv[n++] = (char *)s->model;
    argv[n++] = "--seed";
    argv[n++] = seed;
    if (kind == 'n') {
        argv[n++] = "--null";
    } else {
        argv[n++] = "--level";
        argv[n++] = sizes[kind == 'T' ? 2 : name[1] - '1'];
    }
    if (kind == 'X' || kind == 'T' || is_double(name)) {
        argv[n++] = kind == 'X' ? "--outside" : kind == 'T' ? "--twins" : "--also";
    }
    argv[n] = NULL;
    return n;
}

/* the answer is written last, so a set with an answer is complete */
static int make(const setup *s, int level, int draw, const char *set, const char *answer)
{
    enum { WORDS = 16 };
    char program[PATH], seed[NAME], part[PATH + 8], log[PATH + 8], *argv[WORDS];
    snprintf(part, sizeof part, "%s.part", answer);
    snprintf(log, sizeof log, "%s.log", answer);
    int n = draw_command(s, level, draw, argv, program, seed);
    argv[n++] = "-o";
    argv[n++] = (char *)set;
    argv[n++] = "--answer";
    argv[n++] = part;
    argv[n] = NULL;
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

/* the records of a set that are called so, FIT or HELD of the action, and what a world has drawn */
static int add_files(const setup *s, const char *set, const char *name, int most, char *argv[],
                     char file[][PATH + 20])
{
    int n = 0;
    for (int i = 0; i < (s->world ? RECORDS : most); i++) {
        snprintf(file[n], PATH + 20, "%s/%s_%02d.csv", set, name, i + 1);
        if (s->world && access(file[n], R_OK) != 0) {
            break;
        }
        argv[n] = file[n];
        n++;
    }
    return n;
}

int draw_diagnose(const setup *s, const char *set, const char *next, int more, const char *out,
                  double *cpu)
{
    enum { MORE = 99 };
    char file[2 * RECORDS + MORE][PATH + 20], program[PATH + 8], log[PATH + 8], threads[12];
    char trace[PATH + 20];
    char *argv[2 * RECORDS + MORE + 12];
    int n = 0, k = 0;
    snprintf(program, sizeof program, "%s/stein", s->results);
    snprintf(log, sizeof log, "%s.log", out);
    snprintf(trace, sizeof trace, "%s/trace.jsonl", out);
    argv[n++] = program;
    argv[n++] = "diagnose";
    argv[n++] = (char *)s->model;
    k = add_files(s, set, "fit", FIT, argv + n, file);
    n += k;
    for (int i = 0; i < more && i < MORE; i++) {
        snprintf(file[k], sizeof file[k], "%s/next_%02d.csv", next, i + 1);
        argv[n++] = file[k++];
    }
    argv[n++] = "--holdout";
    int held = add_files(s, set, "held", HELD, argv + n, file + k);
    n += held > 0 ? held : -1;
    argv[n++] = "-j";
    snprintf(threads, sizeof threads, "%d", s->threads);
    argv[n++] = threads;
    argv[n++] = "--trace";
    argv[n++] = trace;
    argv[n++] = "-o";
    argv[n++] = (char *)out;
    argv[n] = NULL;
    return process_run(argv, log, s->limit, cpu);
}

static void report(const score *r)
{
    if (*r->mechanism != '\0' && *r->mechanism != '-') {
        printf("%s, ", r->mechanism);
    }
    printf("%s %3d  %s at %s: %s, %s at %s, rank %d, %.1f s", r->level, r->draw, r->kind, r->place,
           r->verdict, r->first_kind, r->first_place, r->rank, r->cpu);
    if (r->outside) {
        printf("; law at %s over %s", r->law_place, r->law_of);
    }
    if (r->compared) {
        printf(", off by %.1f %%, %.0f %% covered", 100.0 * r->law_error, 100.0 * r->law_cover);
    }
    if (*r->film != '\0' && *r->film != '-') {
        printf("; of %d, %s x %d: %s, then %s at %s%s", r->causes + r->rivals, r->experiment,
               r->repeats, r->film, r->after_kind, r->after_place,
               r->separated ? ", separated" : "");
    }
    printf("\n");
    fflush(stdout);
}

int draw_run(const setup *s, int level, int draw)
{
    char set[PATH], answer[PATH], out[PATH], scored[PATH], model[PATH + 16];
    setup own = *s; // with the model of this set
    score r = {
        .draw = draw, .seed = (double)seed_of(s, s->level[level], draw), .threads = s->threads};
    draw_paths(s, s->level[level], draw, set, answer, out, scored);
    if (access(scored, R_OK) == 0) {
        return 0;
    }
    if (s->world) {
        snprintf(model, sizeof model, "%s/model.yaml", set);
        own.model = model;
    }
    snprintf(r.level, sizeof r.level, "%s", s->level[level]);
    snprintf(r.build, sizeof r.build, "%s", s->hash);
    if (make(s, level, draw, set, answer) != 0) {
        return -1;
    }
    if (s->only_sets) {
        return 0;
    }
    double start = process_clock();
    r.exit_code = draw_diagnose(&own, set, "", 0, out, &r.cpu);
    r.wall = process_clock() - start;
    if (judge(&own, answer, out, &r) != 0) {
        return -1;
    }
    if (draw_kind(r.level) == 'T') {
        twin_run(s, level, draw, set, answer, out, &r);
    }
    if (s->verbose) {
        report(&r);
    }
    return score_write(scored, &r);
}
