/* SPDX-License-Identifier: GPL-3.0-or-later
 * inner.h - what the files of the lab share with each other and with the commands. Not installed.
 *
 *   open.c       mechanism file -> equations
 *   compile.c    equations -> shared object
 *   strike.c     one stroke, by its events
 *   record.c     samples, CSV
 *   binary.c     records for NumPy and MATLAB
 *   drive.c      inputs from a CSV file
 *   sweep.c      many strokes on threads
 *   crew.c       work on threads
 *   batch.c      many simulations
 *   vary.c       a sweep over a grid
 *   grid.c       points from --vary
 *   grid_file.c  does the file accept them?
 *   table.c      results of a sweep, keyed by point
 *   journal.c    the same, safe from kill -9
 *   facts.c      the paper against strokes
 *   plot.c       a stroke as a picture
 *   map.c        a sweep as a picture
 *   gnuplot.c    a script becomes a picture
 *   output.c     messages, numbers, files that appear whole
 *   json.c       JSON
 *   process.c    other programs: compilers, gnuplot
 *   identity.c   hashes of standard sweeps and fits
 *
 * Folders: data/, fit/, diagnosis/, plan/, study/, page/, import/, each with a header of its own.
 */
#ifndef LAB_INNER_H
#define LAB_INNER_H

#include <locale.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "gen.h"
#include "mechanism.h"
#include "stein/identity.h"
#include "stein/lab.h"
#include "stein/load.h"

/* ---- equations that are built in, by the structure of their mechanisms (written by make) ---- */

typedef struct lab__structure {
    const char *hash; /* gen_structure() */
    const stein_model *model;
} lab__structure;
extern const lab__structure lab__structures[]; /* closed by a NULL hash */

/* ---- files of the project that the program carries as text (written by make) ---- */

/** One file, line by line; a list of files is closed by a NULL name. */
typedef struct lab__source {
    const char *name; /* "src/core/sim.c" */
    const char *const *lines;
} lab__source;
/** Is it compiled by itself? */
static inline int lab__is_c(const char *name)
{
    size_t n = strlen(name);
    return n > 2 && strcmp(name + n - 2, ".c") == 0;
}
/** What is compiled beside equations, what a page is made of, what makes an FMU of them; the
 *  mechanism file to begin with. */
extern const lab__source lab__core_files[], lab__page_files[], lab__fmu_files[],
    lab__starter_files[];

/* ---- output.c: messages, texts, numbers, files ---- */

/** Fill err (nullable) with a printf-like message and return the code. */
stein_status lab__fail(stein_err *err, stein_status code, const char *format, ...);
/** ENOMEM, and said so. */
/** Has it bodies that turn in all directions, or contacts in space? */
static inline int lab__in_space(const stein_model *model)
{
    int any = model->nball > 0;
    for (int i = 0; i < model->nspot; i++) {
        any |= model->spots[i].side[0].kind == STEIN_SPHERE;
    }
    return any;
}

static inline stein_status lab__no_memory(stein_err *err)
{
    lab__fail(err, STEIN_ENOMEM, "out of memory");
    return STEIN_ENOMEM;
}
/** A new string from a printf-like format; NULL without memory. The caller frees it. */
char *lab__text(const char *format, ...);
/** A text that may come from anywhere (a file's name, a word of the command line) as part of one
 *  line: control characters become "?". @return text */
char *lab__one_line(char *text);
/** The same written in full, with a newline; for control characters blanks. */
void lab__put_line(FILE *f, const char *text);
enum { LAB_SHOWN = 260 };
/** The same as a copy, cut where it is longer than a file's name. @param to [LAB_SHOWN] */
const char *lab__shown(char *to, const char *text);
enum { LAB_NUMBER = 32 };
/** The shortest decimal that reads back as exactly this double; a point whatever the locale.
 *  @param text  [LAB_NUMBER] out, returned */
char *lab__number(char *text, double value);

/** Go on with a hash (FNV-1a of 64 bits, begun with STEIN_HASH): identifies bytes, no protection
 *  against intent. */
unsigned long long lab__hash(unsigned long long hash, const void *bytes, size_t n);

/** A stream into a new text, as open_memstream gives one, which however forgets that it could not
 *  grow and goes on with a hole. @param text  out: the text, from lab__text_close on
 *  @return NULL without memory */
FILE *lab__text_open(char **text);
/** End a text that was written with lab__text_open.
 *  @param text  freed and NULL on failure
 *  @return OK, ENOMEM */
stein_status lab__text_close(FILE *stream, char **text, stein_err *err);

/** Numbers with a point for this thread, whatever the host's locale. @return what it had, for
 *  lab__as_before; 0: no memory, and nothing has changed */
locale_t lab__plain(void);
void lab__as_before(locale_t before);

/** A file that appears whole or not at all: written beside its place, then renamed. Devices, pipes
 *  and "-" (standard output) are written directly. */
typedef struct lab__file {
    FILE *stream;
    char *path, *temporary; /* temporary NULL: written directly */
    locale_t before;        /* of this thread; between open and close it is "C" */
} lab__file;
stein_status lab__file_open(lab__file *file, const char *path, stein_err *err);
/** Put the file in its place, or with keep = 0 drop it. @return OK, EIO */
stein_status lab__file_close(lab__file *file, int keep, stein_err *err);
/** Is this path the standard output? */
int lab__is_stdout(const char *path);
/** A text of lines, closed by NULL, as a file that appears whole. @return OK, EIO */
stein_status lab__write_lines(const char *path, const char *const *lines, stein_err *err);
/** A whole file, one 0 behind it; freed by the caller. @return OK, EIO, ENOMEM */
stein_status lab__read_file(const char *path, char **text, size_t *size, stein_err *err);
/** A folder with all its parents. @return OK, EIO */
stein_status lab__folder(const char *path, stein_err *err);

/* ---- json.c ---- */

enum { LAB_JSON_DEPTH = 16 };
/** Writer of one JSON value. Keys are NULL inside lists. */
typedef struct lab__json {
    FILE *stream;
    int depth;
    int filled[LAB_JSON_DEPTH]; /* has this level an entry? */
    char closing[LAB_JSON_DEPTH];
} lab__json;
void lab__json_open(lab__json *j, const char *key, char bracket); /* '{' or '[' */
void lab__json_close(lab__json *j);
void lab__json_text(lab__json *j, const char *key, const char *value);       /* NULL: null */
void lab__json_real(lab__json *j, const char *key, double value);            /* not finite: null */
void lab__json_reals(lab__json *j, const char *key, const double *v, int n); /* a list */
void lab__json_int(lab__json *j, const char *key, int value);
void lab__json_bool(lab__json *j, const char *key, int value);
void lab__json_null(lab__json *j, const char *key);

/* ---- process.c ---- */

/** Run a program found in PATH and wait for it; its output goes to the file `log`.
 *  @param code  its exit code; 127 when there is no such program, 128 + n when signal n ended it
 *  @return OK, EIO */
stein_status lab__spawn(char *const argv[], const char *log, int *code, stein_err *err);

/** Words of a command line, as many as there are; begun with {0}. */
typedef struct lab__words {
    char **word; /* [n] and NULL behind them, all owned */
    int n, failed;
} lab__words;
/** One word more, which is the list's from now on; NULL, or no memory, makes lab__words_run fail.
 */
void lab__word(lab__words *words, char *word);
/** All words of a text, between its blanks: a compiler may bring words of its own ("ccache gcc").
 */
void lab__words_of(lab__words *words, const char *text);
/** lab__spawn them and free them, in any case. @return OK, EIO, ENOMEM */
stein_status lab__words_run(lab__words *words, const char *log, int *code, stein_err *err);
/** The first line of a compiler's log that tells of an error; "" when there is none. */
void lab__complaint(const char *log, char *text, int size);

/* ---- gnuplot.c ---- */

typedef void lab__script_fn(FILE *f, const void *ctx);
/** Draw a picture of width x height, .svg or .png (1.5 times as many pixels), with the script that
 *  `write` writes; terminal and output are set before. @return OK, EIO, EINVAL (other ending) */
stein_status lab__gnuplot(const char *path, int width, int height, lab__script_fn *write,
                          const void *ctx, stein_err *err);
/** Does the name end in .svg or .png? @return OK, EINVAL */
stein_status lab__picture_name(const char *path, stein_err *err);
/** A text in single quotes. */
void lab__quoted(FILE *f, const char *text);

/* ---- grid.c ---- */

/** One varied parameter. */
typedef struct lab__axis {
    char *name, *text;     /* "-1.2:0:13 mm": written always the same way */
    char unit[MECH_UNIT];  /* SI */
    char shown[MECH_UNIT]; /* the unit its values were given in */
    double factor;         /* of that unit [SI] */
    double *value;         /* [n], SI */
    int n;
} lab__axis;
struct lab_grid {
    lab__axis *axis; /* [naxis] */
    int naxis, n;
};
/** An empty grid, and one axis more. @return OK, EINVAL (what was expected), ENOMEM */
stein_status lab__grid_new(lab_grid **grid, stein_err *err);
stein_status lab__grid_add(lab_grid *grid, const char *name, const char *unit, const char *values,
                           stein_err *err);

/* ---- stop.c ---- */

/** Who may stop long work. Zeros: nobody. */
typedef struct lab__stop {
    lab_stop_fn *fn;
    void *ctx;
} lab__stop;
int lab__stop_asked(const lab__stop *stop);
/** The failure with which work that shall stop goes up: that of memory, which every caller passes
 * on and nobody takes for a property of the model. @return ENOMEM */
stein_status lab__stop_work(stein_err *err);
/** At the public call that was given the question. @return ESTOPPED in place of ENOMEM, if that is
 *  why; else status */
stein_status lab__stop_end(stein_status status, const lab__stop *stop, stein_err *err);

/* ---- crew.c ---- */

/** Work that several threads share. */
typedef struct lab__crew {
    int n, threads;
    const unsigned char *skip; /* [n] 1: leave out this piece; may be NULL */
    /** What a thread needs of its own; may be NULL. A failure ends the work. */
    stein_status (*begin)(void *ctx, void **bench, stein_err *err);
    /** One piece, in any order, from any thread. Anything but OK ends the work. */
    stein_status (*work)(void *ctx, void *bench, int i, stein_err *err);
    /** What a thread has begun and not ended when there is no piece left; may be NULL. As work. */
    stein_status (*rest)(void *ctx, void *bench, stein_err *err);
    void (*end)(void *bench);  /* also after a failed begin; may be NULL */
    lab__stop stop;            /* asked before every piece */
    lab_progress_fn *progress; /* may be NULL; counts what is not skipped */
    void *progress_ctx, *ctx;
} lab__crew;
/** @return OK, ENOMEM, or the first failure */
stein_status lab__crew_run(const lab__crew *crew, stein_err *err);

/* ---- dots.c ---- */

/** Sum of a[i] b[i] over n samples, in their order. */
double lab__dot(const double *a, const double *b, size_t n);
/** The same with each row of b [rows*n], to the last bit; sum [rows] out. */
void lab__dots(const double *a, const double *b, size_t n, int rows, double *sum);

/* ---- pace.c ---- */

/** How runs are stepped: with controlled error, or (tolerance 0) with the file's fixed steps. */
typedef struct lab__steps {
    int channel;      /* of which an error is told, -1: of none */
    double told;      /* [its unit] */
    double tolerance; /* of a step [rad or m] */
    double longest;   /* step [s] */
} lab__steps;
/** @param told   "CHANNEL=VALUE[unit]"; NULL: what the file tells, fixed steps where it tells none
 *  @param fixed  1: the file's fixed steps, whatever it tells
 *  @return OK, ENAME (no such channel), EINVAL, or what making a simulation returns */
stein_status lab__steps_of(lab__steps *steps, const lab_model *model, const char *told, int fixed,
                           stein_err *err);

/* ---- batch.c ---- */

enum { LAB_THREADS = 64 };
/** What came out at one point. Called from any thread, once a point, in any order; what it stores
 *  belongs to the point alone.
 *  @param sim     at the end of its run, from a reset with the point's parameters; NULL when there
 *                 was none
 *  @param stroke  what it was, where it was one and status is OK
 *  @param status  OK, or why there is no simulation or no stroke
 *  @return OK; anything else ends the batch */
typedef stein_status lab__point_fn(void *ctx, int point, stein_sim *sim, const lab_stroke *stroke,
                                   stein_status status, stein_err *err);
/** Many runs of one model, each with parameters of its own: strokes, where the model names one. */
typedef struct lab__batch {
    const lab_stroke_def *def; /* of every run, without samples */
    const lab_model *model;
    const stein_sim_def *sim; /* how they are computed; NULL: as the file says */
    const lab__steps *steps;  /* NULL: fixed steps */
    int n, threads;
    const unsigned char *skip;                    /* [n] 1: leave out this point; may be NULL */
    void (*set)(void *ctx, int point, double *p); /* p [np]: the file's values, to be changed */
    lab__point_fn *run;
    lab__stop stop;            /* asked between steps */
    lab_progress_fn *progress; /* may be NULL; counts what is not skipped */
    void *progress_ctx, *ctx;
} lab__batch;
/** @return OK, ENOMEM, or what `run` returned. Failures of a point are handed to `run`. */
stein_status lab__batch_run(const lab__batch *batch, stein_err *err);

/* ---- vary.c ---- */

/** Find out what every point would fail with, by a run of one step: a stroke if the model names
 * one.
 *  @return OK (also when the file's own parameters fail numerically), EINVAL, ENOMEM */
stein_status lab__try(const lab_model *model, double until, double release, stein_err *err);

/* ---- table.c ---- */

/** Results of a sweep as rows of CSV, keyed by point. The head says everything that decides about
 *  the rows, so two tables with equal heads belong to the same sweep. */
struct lab_table {
    char *head;     /* "# name: value" lines and the line of columns, each with its newline */
    lab_grid *grid; /* read back from the head */
    int ncolumn;
    char **row; /* [n] without newline; NULL: not there */
    int n;
};
/** A table without rows from its head. @return OK, EPARSE (no such head), ENOMEM */
stein_status lab__table_new(lab_table **table, const char *head, stein_err *err);
/** Take a row with its index in the first cell.
 *  @return OK, EPARSE (no row of this table), EINVAL (another result is there), ENOMEM */
stein_status lab__table_take(lab_table *table, const char *row, size_t length, stein_err *err);
/** Column by its name without unit, -1 when absent. */
int lab__table_column(const lab_table *table, const char *name);
/** Text of a cell (not terminated). @return its length, 0 when it is empty or the row is absent */
size_t lab__table_cell(const lab_table *table, int point, int column, const char **text);
/** Number in a cell, NAN when there is none. */
double lab__table_number(const lab_table *table, int point, int column);
/** Status of a point is "ok". */
int lab__table_ok(const lab_table *table, int point);

/* ---- journal.c ---- */

typedef struct lab__journal {
    int fd;
    char *path;
} lab__journal;
/** Open or begin the journal of a sweep; finished points go into the table.
 *  @param damaged  out, may be NULL: lines that could not be read and count as not there
 *  @return OK, EIO (cannot be read, written or locked), ESTALE (of another sweep), EPARSE (no
 *          journal), ENOMEM */
stein_status lab__journal_open(lab__journal *journal, const char *path, lab_table *table,
                               int *damaged, stein_err *err);
/** Add a row: one write of one line. From any thread. @return OK, EIO */
stein_status lab__journal_add(const lab__journal *journal, const char *row, stein_err *err);
void lab__journal_close(lab__journal *journal);
/** Read a journal into a table, which is made when *table is NULL. @return as lab__journal_open */
stein_status lab__journal_read(lab_table **table, const char *path, int *damaged, stein_err *err);

/* ---- open.c ---- */

/** lab_open of a text in memory; `name` stands for the file. */
stein_status lab__open_text(lab_model **out, const char *name, const char *text, size_t size,
                            const lab_options *options, stein_err *err);
/** The text that a model was opened from, freed by the caller.
 *  @param file  where it is when that was no text in memory
 *  @return OK, EIO, ENOMEM */
stein_status lab__model_text(const lab_model *model, const char *file, char **text, size_t *size,
                             stein_err *err);
/** The file behind a model. */
const mechanism *lab__mechanism(const lab_model *model);

/* ---- compile.c ---- */

/** Folder of the cache for this version of the library, not yet made; freed by the caller.
 *  @return OK, EIO (the environment names none), ENOMEM */
stein_status lab__cache(char **folder, const lab_options *options, stein_err *err);
/** Equations of a mechanism from the cache, compiled into it when they are absent or stale. */
stein_status lab__compiled(stein_library **library, const stein_model **model, const mechanism *m,
                           const gen_result *equations, const lab_options *options, stein_err *err);

/* ---- strike.c ---- */

/** A run that says step by step what its simulation is to do. */
typedef struct lab__play lab__play;
/** What the next call of lab__play_next needs of a simulation that may be in a lane: what is always
 *  up to date, its state to look at, or the whole of it to be changed. */
typedef enum { LAB_NOTHING, LAB_TO_LOOK, LAB_TO_CHANGE } lab__need;
/** Begin a run of a simulation, which stays its owner's, as a stroke or as a motion that nobody
 *  judges.
 *  @param steps  of controlled error, without samples (def->sample); NULL: fixed ones
 *  @return OK, EINVAL, ENOMEM */
stein_status lab__play_new(lab__play **play, stein_sim *sim, const lab_stroke_def *def,
                           const lab__steps *steps, int as_stroke, stein_err *err);
void lab__play_drop(lab__play *play);
lab__need lab__play_needs(const lab__play *play);
/** Steps that may be taken in one go before lab__play_next is called, as long as there is no event
 *  on the way; 1 at least. */
long lab__play_steps(const lab__play *play);
/** The pace of its runs, where their error is controlled. */
stein_pace *lab__play_pace(lab__play *play);
/** Between steps. @param status  of what was done last, OK at the beginning
 *  @param stop  out: INFINITY: one step is next; a time: a run to it; NAN: it is over. Where the
 *               error is controlled always a run
 *  @return OK, or why it is over */
stein_status lab__play_next(lab__play *play, stein_status status, double *stop, stein_err *err);
/** What a stroke that is over was. */
void lab__play_stroke(lab__play *play, lab_stroke *stroke);
/** Output channel that reads `read` of thing `index`, counted absolutely; -1 when there is none. */
int lab__channel_of(const stein_model *model, stein_read_kind read, int index);

/* ---- record.c ---- */

const stein_model *lab__record_model(const lab_record *record);
int lab__record_rows(const lab_record *record);
double lab__record_at(const lab_record *record, int row, int channel);
/** LAB_CSV_PLAIN. @return OK, EIO */
stein_status lab__write_csv_plain(const char *path, const lab_record *record, stein_err *err);

#endif
