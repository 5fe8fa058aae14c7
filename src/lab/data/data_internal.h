/* SPDX-License-Identifier: GPL-3.0-or-later
 * data_internal.h - shared by the files that read and audit data.
 *
 *   bytes --data_lines.c--> lines, cells, numbers --data_titles.c, data_header.c,
 *                       data_columns.c, data_events.c, data.c, data_unwrap.c--> lab_data
 *                                                        |
 *                   lab_audit <--data_audit.c, data_noise.c, data_rest.c--+
 *                       +--data_findings.c--> sentences, text
 * Included by: this folder, src/lab/plan.
 */
#ifndef DATA_INTERNAL_H
#define DATA_INTERNAL_H

#include <locale.h>

#include "open.h"
#include "stein/data.h"

/* ---- data_lines.c ---- */

enum {
    DATA_ROWS = 20000000,
    DATA_LINES = 100000000,
    DATA_LINE = 1 << 16, /* bytes */
    DATA_COLUMNS = 256,
    DATA_PROBLEMS = 20,
    DATA_NOTES = 10000,
    DATA_CELL = 200 /* bytes of a number */
};

/** Kinds of problems that are counted; per column: kind + DATA_KINDS * (1 + column). */
enum {
    DATA_NOTE_BELOW = 2,
    DATA_RAGGED,
    DATA_NO_TIME,
    DATA_TIME_ORDER,
    DATA_BAD_CELL,
    DATA_QUOTES,
    DATA_EVENT_ORDER,
    DATA_EVENT_GAP,
    DATA_EVENT_EARLY,
    DATA_KINDS
};
/** Problems of one file. Problems of one kind (not 0) are reported once, with a count. */
typedef struct data__problems {
    const char *file;
    struct data__problem {
        char *text;
        int line, column, kind, again;
    } list[DATA_PROBLEMS];
    int n, more, nomem;
} data__problems;
void data__problem(data__problems *p, int kind, int line, int column, const char *format, ...);
/** Hand all over in the order of the file and free them. @return OK when there are none, EPARSE,
 *  ENOMEM */
stein_status data__problems_flush(data__problems *p, lab_report_fn *report, void *ctx,
                                  stein_err *err);
/** Text of a file made printable and short. @param to [DATA_SHOWN], returned */
enum { DATA_SHOWN = 64 };
char *data__shown(char *to, const char *text, size_t n);

/** Lines of a file, without their ends. */
typedef struct data__lines {
    FILE *stream;
    char *buffer;
    size_t at, have;
    int line; /* number of the present one */
    int ended;
    unsigned long long hash; /* of all bytes so far, FNV-1a */
    double bytes, total;     /* read, of this file and those before; of all files; 0: not known */
    lab_read_progress_fn *progress;
    void *ctx;
} data__lines;
stein_status data__lines_open(data__lines *l, const char *file, const char *text, stein_err *err);
void data__lines_close(data__lines *l);
/** @return 1; 0 at the end or after a problem that leaves no lines to read */
int data__next_line(data__lines *l, data__problems *p, const char **text, size_t *size);

/** Part of a line, without blanks and quotes around it. */
typedef struct data__cell {
    const char *s;
    size_t n;
    int at; /* byte in the line */
} data__cell;
/** Separator of the titles of a header: a comma where there is one, else a semicolon, a tab,
 *  else blanks (' '). */
char data__separator(const char *text, size_t size);
/** Cut a line at its separators. @return cells (DATA_COLUMNS + 1: more than that), or -1 - the byte
 *  where quotes do not close */
int data__cells(const char *text, size_t size, char separator, data__cell cell[DATA_COLUMNS + 1]);
/** Column of a byte of a line, in characters from 1. */
int data__column(const char *text, int at);

/** Decimal number times 10^exp10, correctly rounded. `c` is the "C" locale.
 *  @param point  in, out: decimal sign of the file, 0 until a number has shown it
 *  @return NULL, or what is wrong: "expected a number" ... (static text) */
const char *data__number(data__cell cell, int exp10, locale_t c, char *point, double *value);
/** One of the last digit that a good number is written with, times 10^exp10. */
double data__last_digit(data__cell cell, int exp10, char point);

/* ---- data_titles.c ---- */

/** A unit against the one of the model: the number in the file times 10^exp10 * factor is SI.
 *  @return 0; 1 another quantity, 2 no unit at all */
int data__unit(const char *unit, const char *wanted, int *exp10, double *factor);
/** A title cut in two: "name [unit]", "name (unit)", "name / unit", "name, unit", or "name_unit"
 *  where only the name without the suffix is `time`, a channel or an input of the model. A name of
 * the model in other upper and lower case gets the model's spelling.
 *  @return 1 with a unit, 0 without, -1 the bracket does not close */
int data__cut_title(const stein_model *m, data__cell cell, char name[], char unit[]);
/** Is a title of another name one of a time, "Zeit [s]" or "temps_ms"?
 *  @param unit, has_unit  of data__cut_title; in, out: those of the suffix
 *  @return 1: it has a unit of time */
int data__cut_time(const char *name, char unit[], int *has_unit);
/** A cell that is a unit alone, in brackets or without. @param unit  out [DATA_SHOWN] */
void data__cut_unit(data__cell cell, char unit[]);
/** Is it the title of the time: "time", "timestamp", "seconds" in any case, or "t"? */
int data__is_time(const stein_model *m, const char *name);
/** Unit of the model for a name; NULL: neither the time nor a channel or input. */
const char *data__wanted_unit(const stein_model *m, const char *name);

/* ---- data_unwrap.c ---- */

/** Make an angle that was kept within one turn continuous. @param value  [n] of the column
 *  @return turns that were taken out */
int data__unwrap(const stein_model *m, lab_column *c, double *value, int n);

/* ---- data_names.c ---- */

enum { DATA_OUTPUTS = 320 }; /* room for a list of them */
/** ", did you mean ...?" with the nearest parameter, output or input of a model, or nothing.
 *  @param to  [room] out, returned */
const char *data__near_param(char *to, size_t room, const stein_model *m, const char *name);
char *data__near_channel(char *to, size_t room, const stein_model *m, const char *name);
/** The same for a word that is no unit, if a unit that can be converted into `wanted` is near. */
void data__near_unit(char *to, size_t room, const char *unit, const char *wanted);
/** "angle [rad], rate [rad/s]": the outputs of a model, without its time. */
const char *data__list_outputs(char *to, size_t room, const stein_model *m);

/* ---- data_header.c ---- */

/** Has a stroke that sets it the last word about a number: of a channel's sensor, of the clock, the
 *  amount of a part that comes off? */
int data__has_last_word(const stein_model *m, const char *param);

/** The public structs grown while reading; `data` comes first; users hold a pointer to it. */
typedef struct data__file {
    lab_data data;
    char *file, *source, *text; /* text NULL: it was read from the file */
    char *passed_over;          /* titles of columns that the model does not know; NULL: none */
    double *time;
    lab_column *column; /* [DATA_COLUMNS]; without the time */
    lab_setting *set;
    lab_note *note;
} data__file;
/** The public part points to the grown arrays. */
void data__hand_over(data__file *out);
/** Bytes of a file, or of its text; 0: unknown. */
double data__bytes(const char *file, const char *text);
/** Read one file, or its text (NULL: none).
 *  @param before, total  bytes of earlier files and of all files, for the progress
 *  @return as lab_data_open */
stein_status data__open(lab_data **data, const char *file, const char *text,
                        const lab_data_options *options, double before, double total,
                        stein_err *err);

/** Lines about a column: "# WORD NAME: VALUE". */
enum { DATA_NOISE, DATA_SMOOTH, DATA_EVENTS, DATA_ABOUTS };
extern const char *const data__about_word[DATA_ABOUTS];
/** One of them until the header is known. */
typedef struct data__about {
    int word;
    char *name, *value;
    int line, name_column, value_column;
} data__about;

/** A column of the file. */
typedef struct data__title {
    char name[DATA_SHOWN], unit[DATA_SHOWN];
    int has_unit; /* of data__cut_title */
    int known;    /* 1: a channel or an input, with a place in the data */
    int to;       /* which */
    int at;       /* character column of the title */
    int exp10;    /* as in data__unit */
    double factor;
    double *value; /* being filled */
    unsigned char *present;
    int samples, varies, refused;
    double first; /* value, to detect a constant channel */
    int events;   /* 1: it holds times of events */
    int ended;    /* 1: of these, an empty cell has been seen */
    double last;  /* of these [s] */
    double digit; /* smallest last digit of these [s] */
} data__title;

typedef struct data__reader {
    const lab_data_options *options;
    const stein_model *model;
    data__file *out;
    data__problems problems;
    data__lines lines;
    double before, total; /* bytes of the files before this one, of all */
    data__title *title;   /* [ntitle] */
    int ntitle, header_line;
    char separator, point; /* of cells; of decimals, 0: not seen yet */
    int time_at;           /* column of the time; -1: none */
    int alone;             /* 1: there is no time, only times of events; time_at is -1 */
    char *above;           /* the last line above the rows that is no header; NULL: none */
    int above_line, nabove;
    int trigger_line, notes;
    data__about *about; /* [nabout] */
    int nabout;
    int room, rows; /* of the columns; rows with problems are counted, not kept */
    int refused;    /* rows without a good time, or ragged */
    double last;    /* time of the row before */
    double start;   /* of the first row; without a time 0 */
    locale_t c;
    int stop; /* reading on makes no sense */
} data__reader;

/** Is there a column of this name in front of it? That is told. */
int data__is_repeated(data__reader *r, const data__title *t);
/** A "#" line before the header. */
void data__note_line(data__reader *r, const char *text, size_t size);
/** @param line  of the file */
void data__header_line(data__reader *r, int line, const char *text, size_t size);
/** Is one of its cells the title of the time, or of times of events? */
int data__is_header(const data__reader *r, const char *text, size_t size);
/** Units in a line of their own below the titles. @return 0: it is none */
int data__unit_line(data__reader *r, const data__cell *cell, int n);
/** Does a column have nothing to do with the model? It is kept for the audit.
 *  @return 0: it may be a slip */
int data__pass_over(data__reader *r, const data__title *t);

/* ---- data_events.c ---- */

/** Do these titles belong to a file of times of events alone? Then the columns that hold them are
 *  added. Errors of lines "# events" are reported. @return 1: the titles are done with, or
 *  nothing can be read */
int data__event_titles(data__reader *r);
/** The declaration of a title's times of events; NULL: it holds samples. */
const data__about *data__events_of(const data__reader *r, const char *name);
/** The column of such a title. */
void data__add_events(data__reader *r, data__title *t, const data__about *about);
/** One cell of it. @param v  NAN: empty  @return 1 when it may stand there */
int data__take_event(data__reader *r, int k, int column, double v);
/** The rows of a file of times of events alone: 0 and these times. @return 1; 0: no memory */
int data__event_rows(data__reader *r);

/* ---- data_columns.c ---- */

/** Give every line about a column to it. */
void data__settle_columns(data__reader *r);

/* ---- audit: data_findings.c, data_noise.c, data_rest.c ---- */

/** A finding: a sentence that the audit keeps. */
void data__finding(lab_audit *a, int *nomem, const char *format, ...);
/** All findings about the record, from its numbers. */
void data__findings(lab_audit *a, int *nomem);
/** "20.3 um": four digits, a prefix that suits. @param text [DATA_SHOWN], returned */
char *data__quantity(char *text, double value, const char *unit);

/** The samples of one channel that are present. */
typedef struct data__series {
    double *t, *v;
    int n;
    double range, sigma; /* max - min; working sd of one sample: never 0 */
    int window, degree;  /* of the polynomials that the noise in motion comes from; 0: none */
    double *scratch, *residual; /* [n] */
    double *difference;         /* [DATA_DIFFERENCES] */
} data__series;
enum { DATA_DIFFERENCES = 20000 };

double data__median(double *v, int n); /* reorders v; NAN for n = 0 */
/** Quantisation step; 0 when there is none. */
double data__step(const data__series *s);
/** Noise of a channel: standard deviation about polynomials fitted in windows. Their length and
 *  degree follow the motion and are left in s.
 *  @param error  out: relative sd of the result  @return [unit]; NAN: too few samples */
double data__noise_in_windows(data__series *s, int *samples, double *error);
/** Rest phases as index ranges [first, last]. @return their number, at most `max` */
int data__rests(const data__series *s, int (*rest)[2], int max);
/** Noise and its correlation from rests. @return samples used; 0: too few, nothing is written */
int data__noise_at_rest(const data__series *s, int (*rest)[2], int n, double *noise, double *error,
                        double correlation[LAB_LAGS]);
/** Correlation from windows. */
void data__correlation_in_windows(const data__series *s, double correlation[LAB_LAGS]);
/** Residual of a polynomial of `degree` <= 11 by least squares; r [n] out. @return sum of squares
 */
double data__residual(const double *t, const double *v, int n, int degree, double *r);
void data__spikes(const data__series *s, lab_channel_audit *a);
void data__saturation(const data__series *s, lab_channel_audit *a);
void data__first_motion(const data__series *s, const int rest[2], lab_channel_audit *a);

#endif
