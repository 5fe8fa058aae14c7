/* SPDX-License-Identifier: GPL-3.0-or-later
 * data.h - measured data: CSV files, read strictly, and their audit. Part of libsteinlab.a.
 *
 *      # set pawl.stop_shift: -0.3 mm         a known parameter of this stroke
 *      # known key.below.x: 181.2 mm          the same, measured by itself: no effect acts on it
 *      # set key_dip.sensor.gain: 1.002       an instrument that was checked is known as well
 *      # set key_wire.k: 0                    played without a wire at the key, if it has one
 *      # noise string_distance: 0.01 mm       standard deviation of one sample
 *      # smooth crank: 12 Hz                  a measured motion counts as motion up to there
 *      # events floor: begin                  the column floor holds times at which it is touched
 *      # trigger: unsynchronised              the origin of the time is unknown
 *      # camera: any other name: value        kept
 *      time [ms],string_distance [mm]         channels or inputs of the model, with their units
 *      0,39.23
 *      0.25,                                  an empty cell: a missing sample
 *
 * Forms of other programs are read too. Titles: `name [unit]`, `name (unit)`, `name_unit` or `name`
 * (SI; the audit reports it). Separators: commas, semicolons or tabs, with the latter two also
 * decimal commas. An index without a name may precede the time; the titles may be in the last "#"
 * line. Angles that stay within one turn and jump are made continuous.
 *
 * All problems of a file are reported, "file:line:column: ...", and a file with problems gives no
 * data. Doubtful data (gaps, saturation, a trigger that does not fit) are findings of the audit.
 * Everything is SI after reading.
 */
#ifndef STEIN_DATA_H
#define STEIN_DATA_H

#include "stein/lab.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- reading ---- */

/** Contents of a column: samples of an output or input at the times of the rows, or times at which
 *  a contact or notch closes or opens. */
typedef enum { LAB_OUTPUT, LAB_INPUT, LAB_EVENT_TIMES } lab_role;

/** Which events: those that close the place, those that open it. */
typedef enum { LAB_EVENTS_BEGIN, LAB_EVENTS_END } lab_events;

/** Does t = 0 mean the start of the stroke? UNSTATED counts as yes where the model has a stroke. */
typedef enum {
    LAB_TRIGGER_UNSTATED,
    LAB_TRIGGER_SYNCHRONISED,
    LAB_TRIGGER_UNSYNCHRONISED
} lab_trigger;

enum { LAB_UNIT = 24 };

/** One measured channel. A name that is an input and an output of the model is an input. Times of
 *  events do not belong to rows: value[i] is the time of the i-th event, and unit is "s". */
typedef struct lab_column {
    const char *name, *unit; /* of the model, SI */
    lab_role role;
    lab_events events;            /* of LAB_EVENT_TIMES */
    int index;                    /* channel or input of the model */
    int contact, notch;           /* place of LAB_EVENT_TIMES; the other one is -1 */
    const double *value;          /* [nrow] [unit], NAN where missing */
    const unsigned char *present; /* [nrow] 0 where missing */
    int samples;                  /* present ones; of events the first ones */
    double digit;                 /* one of the last digit of the times of events [s] */
    double noise;                 /* `# noise` [unit], NAN when not given */
    double smooth;                /* `# smooth` of a prescribed motion [Hz], 0 when not given */
    int line, column;             /* place of its title in the file, from 1 */
    int unit_assumed;             /* 1: the title states no unit, the values were read as SI */
    int wraps;                    /* turns by 2 pi that were taken out of an angle */
    /* its unit in the file where that is no power of ten of `unit`, "deg", "deg/s"; "" */
    char written[LAB_UNIT];
    double factor; /* one of that unit [unit] */
} lab_column;

/** A `# set` or `# known`. */
typedef struct lab_setting {
    const char *name;
    int param;    /* of the model */
    double value; /* [SI] */
    int line, column;
    int last_word; /* 1: known, an instrument, or a part that was taken off: no effect acts on it */
    double step;   /* unit of its last written digit [SI]: "20 deg" means 19.5 to 20.5 deg */
} lab_setting;

#define LAB_NOTE_WITHOUT "without"

/** Any other `# name: value`; name is "" for a line without a colon. A part that was taken off, and
 *  that the model lacks too, is the note LAB_NOTE_WITHOUT with the name of its amount. */
typedef struct lab_note {
    const char *name, *value;
    int line;
} lab_note;

/** One stroke: one file. Read only; owned by lab_data_open or its dataset. */
typedef struct lab_data {
    const char *file;
    const stein_model *model;
    int nrow, ncolumn, nset, nnote;
    const double *time; /* [nrow], increasing [s]; with events alone 0 and their times */
    int events_alone;   /* 1: the file has no time column, only times of events */
    const lab_column *column;
    const lab_setting *set;
    const lab_note *note;
    lab_trigger trigger;
    unsigned long long hash; /* of the file's bytes */
    int planned;           /* 1: the record is planned, not made: values of outputs mean nothing */
    int time_unit_assumed; /* 1: the title of the time states no unit, it was read as s */
    int number;            /* in its dataset, in the order of the files, from 1; 0: of none */
    const char *text; /* its source text, lab_data_options.text; NULL: it was read from its file */
    const char
        *passed_over; /* titles of columns that are no output or input of the model; NULL: none */
    /* A long record may be cut into windows: `file` is "FILE, 1.2 s to 3.4 s" then */
    const char *source;       /* the file itself */
    int first_row, file_rows; /* of the file's rows: the first one here, from 0; all of them */
    int gap_from, gap_to;     /* of the file's rows: no output is present from..to - 1 */
} lab_data;

/** Progress of reading, 0 <= fraction <= 1 of all bytes of all files. */
typedef void lab_read_progress_fn(void *ctx, double fraction);

/** How to read. Start from lab_data_options_default(model). */
typedef struct lab_data_options {
    const stein_model *model; /* must outlive the data */
    int min_samples;          /* of every column, but one time of events; default 4 */
    int inputs_only;          /* 1: only columns that are inputs count, any other is passed over */
    /* contents of the files, if they are not on a disk; else NULL: [1], of lab_dataset_open [n].
     * The names of the files appear in messages */
    const char *const *text;
    lab_report_fn *report; /* is called with every problem; may be NULL */
    void *ctx;
    lab_read_progress_fn *progress; /* called every 64 KiB; may be NULL */
} lab_data_options;
lab_data_options lab_data_options_default(const stein_model *model);

/** Read a file.
 *  @return OK, EIO, EPARSE (err has the first problem, report gets up to 20), EINVAL (inputs_only
 *  and no column is an input), ENOMEM; *data untouched on failure */
stein_status lab_data_open(lab_data **data, const char *file, const lab_data_options *options,
                           stein_err *err);
void lab_data_close(lab_data *data);
/** Column by name; NULL when the file has none. */
const lab_column *lab_data_column(const lab_data *data, const char *name);
/** Was it made without a part that its model lacks too (LAB_NOTE_WITHOUT)?
 *  @param amount  of the part, "key_wire.k" */
int lab_data_without(const lab_data *data, const char *amount);
/** Apply the stroke's settings: p [np] holds values (of the file, of a fit); values that the stroke
 *  sets are replaced. */
void lab_data_apply(const lab_data *data, double *p);

/** Several strokes. */
typedef struct lab_dataset {
    int n;
    lab_data **stroke; /* [n] in the order of the files */
} lab_dataset;
/** All files or none; every problem of every file is reported. Files with the same bytes are
 *  accepted, report is called with it. @return as lab_data_open; EINVAL for n < 1 */
stein_status lab_dataset_open(lab_dataset **set, const char *const *file, int n,
                              const lab_data_options *options, stein_err *err);
void lab_dataset_close(lab_dataset *set);

/* ---- audit ---- */

enum { LAB_LAGS = 8, LAB_SPANS = 16 };

/** A stretch of time [s]. */
typedef struct lab_span {
    double from, to;
} lab_span;

/** Source of the noise estimate of a channel. */
typedef enum {
    LAB_NOISE_REST,   /* the scatter while nothing moves */
    LAB_NOISE_MOTION, /* residual of a smooth motion */
    LAB_NOISE_STEP, /* below the quantisation step: step / sqrt(12). Of times of events: their last
                       digit or the interval of the rows, / sqrt(12) */
    LAB_NOISE_UNKNOWN /* too few samples: NAN */
} lab_noise_source;

/** Audit of one channel [its unit, s]. Counts are complete, lists stop at LAB_SPANS. */
typedef struct lab_channel_audit {
    int samples;
    double missing;      /* share of rows without a sample */
    int longest_missing; /* rows in a row */
    double low, high;
    double noise;           /* sd of one sample, to be used: `# noise`, or the estimate */
    double noise_estimated; /* from the record alone, quantisation included */
    double noise_error;     /* relative sd of the estimate; NAN when unknown */
    lab_noise_source noise_from;
    int noise_samples;            /* behind the estimate */
    double correlation[LAB_LAGS]; /* of the noise at lags 1, 2, ... samples; NAN when unknown */
    double step;                  /* quantisation step; 0: none found */
    double locking;               /* share of the resting samples on one level; 0 without a step */
    int saturated_low, saturated_high; /* samples in runs that are cut off at low, high */
    int spikes;                        /* single samples far from both neighbours */
    double spike[LAB_SPANS];           /* their times */
    int nrest;
    lab_span rest[LAB_SPANS]; /* where it does not move */
    int starts_at_rest;
    double motion, motion_error; /* first motion after the rest at the start; NAN without */
} lab_channel_audit;

/** Audit of one stroke. */
typedef struct lab_audit {
    const lab_data *data;
    double rate;                  /* 1 / median interval [Hz] */
    double interval;              /* median [s] */
    double jitter_sd, jitter_max; /* of the intervals that are no gaps, about the median [s] */
    int uniform;                  /* 0: the rate varies, gaps have no meaning */
    int gaps, dropped;            /* intervals above 1.5 medians, frames lost in them */
    double longest_gap;           /* interval [s] */
    lab_span gap[LAB_SPANS];
    int nrest;
    lab_span rest[LAB_SPANS];    /* where no channel moves */
    int starts_at_rest;          /* all channels that show a place do */
    double motion, motion_error; /* first motion of any of them [s], NAN when it is not seen */
    int trigger_fits;            /* 0: see the findings */
    int nfinding;
    char **finding;             /* sentences: contradictions, and limits of a fit */
    lab_channel_audit *channel; /* [ncolumn] */
} lab_audit;

/** @return OK, ENOMEM */
stein_status lab_audit_create(lab_audit **audit, const lab_data *data, stein_err *err);
void lab_audit_destroy(lab_audit *audit);
/** How many of n audits after audit `record` have a finding, too. @return -1: one before it has */
int lab_audit_repeats(lab_audit *const *audit, int n, int record, const char *finding);
/** The audit as lines of text. @return OK, ENOMEM */
stein_status lab_audit_text(const lab_audit *audit, lab_report_fn *line, void *ctx, stein_err *err);

/* ---- does a stroke fit its own settings? ---- */

/** Values of the columns at rest: the model with the stroke's settings in its initial state.
 *  @param value  [ncolumn] out; NAN for inputs
 *  @return OK, or what lab_sim, stein_set_all and stein_reset return */
stein_status lab_data_rest(const lab_data *data, const lab_model *model, double *value,
                           stein_err *err);
/** Compare the values at the start of the record with expected ones: every channel that differs by
 *  more than its tolerance is reported. The value is the mean of the rest at the start or, without
 *  one, the first sample where that is the instant of the trigger. Otherwise, and where `expected`
 *  is NAN, nothing is compared.
 *  @param expected, tolerance  [ncolumn] [SI]
 *  @return OK, EPARSE, ENOMEM */
stein_status lab_data_check_rest(const lab_audit *audit, const double *expected,
                                 const double *tolerance, lab_report_fn *report, void *ctx,
                                 stein_err *err);
/** Compare every stroke with the motion at its own settings, at values that a slip of the pen leads
 *  to, and with the other strokes. Wrong numbers of the model do not matter. Each stroke that
 *  contradicts its settings is reported, "file:line:column: ...".
 *  @return OK, EPARSE, ENOMEM, numerical failures at the file's own values */
stein_status lab_data_check_settings(const lab_dataset *data, const lab_model *model,
                                     lab_report_fn *report, void *ctx, stein_err *err);

/* ---- suspicions: misread records ---- */

/** Kind of a suspicion. */
typedef enum {
    LAB_DOUBT_SCALE,   /* a column, or all of one unit, in another unit than stated */
    LAB_DOUBT_SIGN,    /* a column has the opposite sign of the model */
    LAB_DOUBT_SWAPPED, /* two columns of one unit are exchanged */
    LAB_DOUBT_TIME,    /* the time is in another unit than stated */
    LAB_DOUBT_ALIEN    /* nothing explains this record, but all others are explained */
} lab_doubt_kind;

/** One suspicion. Columns are indices into the columns of the record. */
typedef struct lab_doubt {
    lab_doubt_kind kind;
    int grave;  /* 1: with this reading of the data no verdict about the mechanism can be trusted */
    int stroke; /* first record that it concerns */
    int records;       /* how many it concerns */
    int column, other; /* -1: none (time, all columns of a unit, the whole record); other: exchanged
                          with it, or as likely to have the wrong sign */
    double factor;     /* of the numbers read; 1: not a matter of scale */
    double off, then;  /* misfit of the affected channels as read, and with the other reading:
                          sd(y - h) / (sd(y) + sd(h)), 0 the same motion, 0.7 unrelated */
    char *text;        /* "file: column: what; what would fit" */
    char brief[200];   /* "angle is in deg, not in rad" */
} lab_doubt;

/** Suspicions, the worst first. */
typedef struct lab_doubts {
    int n, grave; /* grave: at least one is */
    lab_doubt *item;
} lab_doubts;
/** Simulate every record once with the numbers of the file and its own settings, and compare sizes,
 *  signs, order of columns and time scale with those measured: milliseconds a record. A suspicion
 *  needs a reading that fits; wrong numbers of the model and missing physics give none.
 *  @return OK, ENOMEM, or what makes the model unusable */
stein_status lab_doubts_find(lab_doubts **doubts, const lab_model *model, const lab_dataset *data,
                             stein_err *err);
void lab_doubts_free(lab_doubts *doubts);
/** Their texts alone. @param finding  out: [*n], for lab_suspicions_free; NULL for none
 *  @return as lab_doubts_find */
stein_status lab_suspicions(char ***finding, int *n, const lab_model *model,
                            const lab_dataset *data, stein_err *err);
void lab_suspicions_free(char **finding, int n);

#ifdef __cplusplus
}
#endif
#endif
