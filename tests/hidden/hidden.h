/* SPDX-License-Identifier: GPL-3.0-or-later
 * hidden.h - blind tests: measurements with a hidden effect are made, `stein diagnose` reads the
 * CSV files alone, then the sealed answer is opened and the verdict scored.
 *
 *      DIR/sets/L1-0007/fit_01.csv ... held_06.csv     what the diagnosis sees
 *      DIR/sealed/L1-0007.json                         what is hidden; opened afterwards
 *      DIR/BUILD/L1-0007/                              what the diagnosis wrote
 *      DIR/BUILD/L1-0007.score                         one result, "name value" lines
 *      DIR/BUILD/T1-0007-plan/, -next/, -after/        the experiment it asks for, made
 *      DIR/BUILD/T1-0007-checked/                      strokes that state what was found by checks
 *      DIR/BUILD/stein                                 the program that is judged: a copy
 *
 * BUILD is a hash of the program's bytes: an interrupted run continues; another program starts
 * again on the same sets. Nothing here is linked with the library: the scorer knows what other
 * programs know, files.
 *
 * With `--world any` the sets come from tests/world: each has its own mechanism, SET/model.yaml,
 * and a random number of records. Their levels: null; small, clear, gross one effect of 0.5, 2, 100
 * noises; two; law, one that is in no table; wrong, the set-up is wrong and no verdict may be
 * trusted.
 *
 * Levels of the action: null; L1, L2, L3 one effect of the table, 2, 0.5, 0.15 of one sample's
 * noise; L1x2 two at once; X1 a law outside of the table, as large as L1; T1 twins: an effect of
 * L3's size in strokes that are all made in the same way.
 *
 *   main.c     command line, draws in parallel     judge.c   verdict against answer
 *   draw.c     one draw: make, diagnose            law.c     a recovered law against the hidden one
 *   twin.c     the experiment for rivals, made     table.c   the table, the list of confusions
 *   process.c  other programs                      tree.c    reader of JSON
 *   score.c    results as files                    record.c  results that are kept, as one table
 *   check.c    things looked at by themselves
 */
#ifndef HIDDEN_H
#define HIDDEN_H

#include <stdio.h>

enum { NAME = 100, PATH = 1000, DRAWS = 9999 };
/** Strokes of a set: fit_01.csv ..., held_01.csv ... */
enum { FIT = 12, HELD = 6 };
/** And at most so many of each in a set of tests/world. */
enum { RECORDS = 18 };
/** The seed of a draw is the seed of its run times this, and more (draw.c). */
enum { SEEDS_A_RUN = 100000 };

/* ---- tree.c ---- */

/** A value of JSON. */
typedef struct tree {
    char type;        /* '{' '[' 's' 'n' 't' 'f' '0' (null) */
    char *key, *text; /* key NULL inside lists */
    double number;
    struct tree *child, *next;
} tree;
/** @return NULL when the file is absent or no JSON */
tree *tree_read(const char *path);
/** One value a line, as the members of a list; NULL: it cannot be read, or a line is no JSON. */
tree *tree_lines(const char *path);
void tree_free(tree *t);
/** Member of an object; NULL when there is none (also of NULL). */
const tree *tree_get(const tree *t, const char *key);
/** Text of a member, "" when there is none. */
const char *tree_text(const tree *t, const char *key);
/** Number of a member, NAN when there is none. */
double tree_number(const tree *t, const char *key);

/* ---- process.c ---- */

/** Run a program, its output to the file `log` (NULL: stays where it is).
 *  @param limit  seconds of processor time, 0: none
 *  @param cpu    out, may be NULL: seconds it took
 *  @return its exit code, 128 + n when signal n ended it, 127 when it cannot be run */
int process_run(char *const argv[], const char *log, double limit, double *cpu);
double process_clock(void);
/** A folder with its parents. @return 0, -1 after a message */
int process_folder(const char *path);
/** Copy a file behind a head ("": none). @return 0, -1 after a message */
int process_copy(const char *head, const char *from, const char *to);

/* ---- score.c ---- */

/** One draw, judged. */
typedef struct score {
    char level[NAME], build[NAME];
    int draw, met, rough;
    double seed, reached;
    char kind[NAME], place[NAME], cls[NAME]; /* truth */
    int exit_code;
    char verdict[NAME], first_kind[NAME], first_place[NAME]; /* found; "-" when there is none */
    int causes, rivals;
    int rank;       /* of the truth among all that was judged, 1: first, 0: not in the list */
    int first, set; /* truth is first, is in the set */
    int all;        /* the causes are exactly the hidden effects */
    int first_alike, set_alike; /* the same, with identical descriptions as one */
    int right_class, class_alike;
    int numbered, covered; /* its number is known; is inside the interval */
    double found, lo, hi, truth, error;
    double before, after, floor; /* held-out error */
    double cpu, wall;
    /* of a law outside of the table */
    int outside, law_here, law_right; /* right place; and variable */
    int compared;                     /* the curve was */
    char law_place[NAME], law_of[NAME];
    double law_error, law_cover; /* rms over the truth's; share of the points inside the band */
    /* of twins: the experiment, "filmed", "checked" or why not, what was first afterwards */
    char experiment[NAME], film[NAME], after_kind[NAME], after_place[NAME];
    int repeats, separated;
    double cpu_after;
    int threads;          /* of the diagnosis; 0: an old row, without what follows; it had one */
    int all_alike;        /* as all, with identical descriptions as one */
    char mechanism[NAME]; /* of tests/world; "-": the action */
    int offered;          /* the truth is one of the candidates of `stein effects` */
    int tied; /* effects that the records cannot distinguish from the truth (tests/world) */
    int first_tied, set_tied; /* first, in the set: the truth or one of those */
    char lost[NAME];          /* the step that lost the truth (truth.c); "-": none, or unknown */
} score;
void score_print(FILE *f, const score *s);
int score_write(const char *path, const score *s);
int score_read(const char *path, score *s);
/** The names of the columns, and one row a result. */
void score_head(FILE *f);
void score_row(FILE *f, const score *s);
/** @return 0, -1: the row does not match its head */
int score_of_row(const char *head, const char *row, score *s);

/* ---- draw.c ---- */

typedef struct setup {
    const char *build, *model, *folder;
    const char *record; /* file of results that are kept, NULL: none */
    int world;          /* 1: sets of tests/world */
    const char *only;   /* the mechanism to draw there, NULL: all of them in turn */
    int limit;          /* of processor time of a diagnosis [s] */
    char results[PATH]; /* DIR/BUILD */
    char hash[NAME];
    unsigned long seed;
    int draws, jobs, threads, verbose, only_sets; /* threads of a diagnosis */
    char level[8][NAME];
    int nlevel;
} setup;
/** @return 0: judged, or was before; -1: could not be made, after a message */
int draw_run(const setup *s, int level, int draw);
/** Meaning of the name of a level: 'n' nothing hidden, 'L' an effect of the table, 'X' a law of
 * none, 'T' twins, 'W' the set-up is wrong. */
char draw_kind(const char *level);
/** Number of a level of tests/world, -1: it is none. */
int draw_world(const char *level);
/** Command line that makes a draw's set, without its end. @return words */
int draw_command(const setup *s, int level, int draw, char *argv[], char program[PATH],
                 char seed[NAME]);
/** Diagnose a set, with further strokes of the folder `next` (n of them, next_01.csv ...).
 *  @return exit code */
int draw_diagnose(const setup *s, const char *set, const char *next, int n, const char *out,
                  double *cpu);
void draw_paths(const setup *s, const char *level, int draw, char set[PATH], char answer[PATH],
                char out[PATH], char scored[PATH]);

/* ---- record.c ---- */

/** Results of the file count as judged here. @return 0, also when there is no file yet; -1 after a
 *  message */
int record_read(const setup *s);
/** The file with the judged results in it. @return 0, -1 after a message */
int record_write(const setup *s);

/* ---- judge.c ---- */

/** Compare the result with the answer. @return 0, -1 after a message */
int judge(const setup *s, const char *answer, const char *out, score *result);
/** `stein effects MODEL --json`, or NULL. @param out  a path to write beside */
tree *judge_effects(const setup *s, const char *out);
typedef struct names {
    const char *kind, *place;
} names;
names names_of(const tree *t);
/** The same, or identical descriptions. @param candidates  of judge_effects, may be NULL */
int names_alike(const tree *candidates, names a, names b);

/* ---- truth.c ---- */

/** The step that lost the hidden effect: from the trace in the folder of results. */
void truth_judge(const char *out, const tree *found, const tree *answer, const tree *candidates,
                 score *r);

/* ---- law.c ---- */

void judge_law(const tree *found, const tree *answer, score *r);

/* ---- twin.c ---- */

/** Plan, film and diagnose again, when the verdict has rivals. @return 0 */
int twin_run(const setup *s, int level, int draw, const char *set, const char *answer,
             const char *out, score *r);
/** The truth is first afterwards, and no other candidate of the first set is left. */
int twin_separated(const tree *before, const tree *after, const tree *answer,
                   const tree *candidates);

/* ---- check.c ---- */

/** Check instruments, and state the results in copies of the set's strokes.
 *  @param checks  "check" of an experiment
 *  @param times   as often
 *  @param to      folder of the copies
 *  @return 0, -1: it cannot be done here, or after a message */
int check_make(const tree *checks, const tree *answer, int times, const char *set, const char *to);
/** Would they find the hidden effect? */
int check_covers(const tree *checks, const tree *answer);

/* ---- table.c ---- */

/** The table of all levels; the number of missing draws is below it. */
void table_print(FILE *f, const setup *s);
/** One line a draw: truth, verdict, what was first, rank of the truth. @return 0, -1 */
int table_confusions(const char *path, const setup *s);
/** Put the table between two marker lines of a file. @return 0, -1 after a message */
int table_into(const char *path, const setup *s);

#endif
