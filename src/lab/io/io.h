/* SPDX-License-Identifier: GPL-3.0-or-later
 * io.h - texts, numbers, files, JSON, records, and other programs.
 *
 *   output.c         messages, numbers, files that appear whole
 *   json.c           JSON
 *   record.c         samples, CSV
 *   record_binary.c  records for NumPy and MATLAB
 *   process.c        other programs: compilers, gnuplot
 *
 * Included by: src/lab, src/cli.
 */
#ifndef LAB_IO_H
#define LAB_IO_H

#include <locale.h>
#include <stddef.h>
#include <stdio.h>

#include "stein/identity.h"
#include "stein/lab.h"

/* ---- output.c: messages, texts, numbers, files ---- */

/** Fill err (nullable) with a printf-like message and return the code. */
stein_status lab__fail(stein_err *err, stein_status code, const char *format, ...);

/** ENOMEM, and said so. */
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
/** Comments at the head of a table, each in a line of its own behind "# ".
 *  @param notes  NULL behind the last one; NULL: none */
void lab__put_notes(FILE *f, const char *const *notes);
enum { LAB_PRINTABLE = 260 };
/** The same as a copy, cut where it is longer than a file's name. @param to [LAB_PRINTABLE] */
const char *lab__printable(char *to, const char *text);
enum { LAB_NUMBER = 32 };
/** The shortest decimal that reads back as exactly this double; a point whatever the locale.
 *  @param text  [LAB_NUMBER] out, returned */
char *lab__number(char *text, double value);

/** Go on with a hash (FNV-1a of 64 bits, begun with STEIN_HASH): identifies bytes, no protection
 *  against intent. */
unsigned long long lab__hash(unsigned long long hash, const void *bytes, size_t n);

/** A stream into a new text, like open_memstream, whose stream continues with a hole after it could
 *  not grow. @param text  out: the text, from lab__text_close on
 *  @return NULL without memory */
FILE *lab__text_open(char **text);
/** End a text that was written with lab__text_open.
 *  @param text  freed and NULL on failure
 *  @return OK, ENOMEM */
stein_status lab__text_close(FILE *stream, char **text, stein_err *err);

/** Numbers with a point for this thread, whatever the host's locale. @return what it had, for
 *  lab__locale_restore; 0: no memory, and nothing has changed */
locale_t lab__locale_c(void);
void lab__locale_restore(locale_t before);

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
 *  @param code  its exit code; 127 when the program is missing, 128 + n when signal n ended it
 *  @return OK, EIO */
stein_status lab__spawn(char *const argv[], const char *log, int *code, stein_err *err);

/** Words of a command line, as many as there are; begun with {0}. */
typedef struct lab__command {
    char **word; /* [n] and NULL behind them, all owned */
    int n, failed;
} lab__command;
/** One word more, which is the list's from now on; NULL, or no memory, makes lab__command_run fail.
 */
void lab__command_add(lab__command *words, char *word);
/** All words of a text, between its blanks: a compiler may contain options ("ccache gcc").
 */
void lab__command_split(lab__command *words, const char *text);
/** lab__spawn them and free them, in any case. @return OK, EIO, ENOMEM */
stein_status lab__command_run(lab__command *words, const char *log, int *code, stein_err *err);
/** The first line of a compiler's log that reports an error; "" when there is none. */
void lab__first_error(const char *log, char *text, int size);

/* ---- record.c ---- */

const stein_model *lab__record_model(const lab_record *record);
int lab__record_rows(const lab_record *record);
double lab__record_at(const lab_record *record, int row, int channel);
/** LAB_CSV_PLAIN. @return OK, EIO */
stein_status lab__write_csv_plain(const char *path, const lab_record *record, stein_err *err);

#endif
