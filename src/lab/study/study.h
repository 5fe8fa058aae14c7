/* SPDX-License-Identifier: GPL-3.0-or-later
 * study.h - shared by the files of the study, the command and the tests. Not installed.
 *
 *   study.c  the order of the parts          pool.c   many simulations on threads
 *   stroke_details.c   one stroke, seen closely        static_escapement.c  the key pressed
 * infinitely slowly part.c   tables, sentences, files        chart.c  pictures        page.c
 * study.html
 *
 *   paper.c        figures 9, 11, 12, 13     touch.c        loads, key motions, dynamic range
 *   regulation.c   the stop or the spring    repetition.c   how fast again
 *   angle.c        the notch's angle         sensitivity.c  every parameter
 *   regulate.c        a parameter for a height  tolerance.c    Monte Carlo
 *
 * A part of the study simulates, fills tables (they become CSV files), writes its results in
 * sentences, and lists the pictures of its tables. All numbers in the sentences are computed from
 * the run.
 * Included by: this folder, src/cli.
 */
#ifndef STUDY_H
#define STUDY_H

#include "plot.h"
#include "run.h"

/* ---- pool.c ---- */

/** Progress of one part; called from several threads, one at a time. */
typedef void study_progress_fn(void *ctx, const char *what, int done, int total);

/** One sensitivity: parameter k and d(height, speed, force) per unit step. */
enum { STUDY_RESPONSES = 3 };
typedef struct study_slope {
    int param;
    double unit; /* the step that the slopes refer to: 0.1 mm, 0.1 deg or 1 % */
    const char *unit_text;
    double slope[STUDY_RESPONSES]; /* [m], [m/s], [N] per unit step */
    double doubt[STUDY_RESPONSES]; /* difference to the slope from the doubled step */
    double step;                   /* of the central difference, in unit steps */
    int agrees;                    /* halving the step changed nothing to speak of */
} study_slope;
/** One study: the model, settings of the computation, data about the action for all parts. */
typedef struct study {
    const lab_model *model;
    int threads;
    double dt;                   /* step of the strokes beyond the sweep [s], RK4 */
    unsigned long long seed;     /* of the Monte Carlo */
    int samples;                 /* of the Monte Carlo */
    study_progress_fn *progress; /* may be NULL */
    void *ctx;

    const lab_point *point; /* the sweep over dx */
    int npoint;
    const lab_fact *fact;
    int nfact;
    const study_slope *slope; /* of all parameters, in study_run */
    int nslope;

    /* from the reference stroke (study_begin) */
    lab_stroke reference;
    double key_rest, key_down; /* key angle at rest and under the load at the end [rad] */
    double arm;                /* dip of the key at the load per angle [m/rad] */
    int input;                 /* the key's prescribed motion, or -1 */
    char left_out[160];        /* why parts with a prescribed motion are missing; "" */
} study;

/** Job i of n on a simulation with the file's parameters. Every job of a part has its own
 *  simulation and results, so these do not depend on the number of threads.
 *  @return how its last stroke ended: without memory the study is over, any other failure is one of
 *  the results */
typedef stein_status study_job_fn(void *ctx, stein_sim *sim, int i);
/** Run jobs 0..n-1. @return OK, ENOMEM or what stein_sim_create returns */
stein_status study_each(const study *s, const char *what, int n, study_job_fn *job, void *ctx,
                        stein_err *err);
/** The same on simulations of another kind. */
stein_status study_each_by(const study *s, const stein_sim_def *def, const char *what, int n,
                           study_job_fn *job, void *ctx, stein_err *err);
/** How strokes beyond the sweep are computed: RK4, steps of s->dt. */
stein_sim_def study_def(const study *s);
/** For long motions, of which only events count: steps of controlled error. */
stein_sim_def study_def_controlled(const study *s);
/** A simulation as the jobs get it. */
stein_status study_sim(const study *s, stein_sim **sim, stein_err *err);
/** Find the reference stroke and its results; `s` has model, threads, dt.
 *  @return OK, EINVAL or ENAME (the model lacks what a study needs), numerical failures */
stein_status study_begin(study *s, stein_err *err);

/* ---- stroke_details.c ---- */

typedef enum {
    STUDY_LOAD,    /* the file's load falls */
    STUDY_PRESSED, /* the key goes down from rest to rest, quintic in time */
    STUDY_STRUCK,  /* the key starts at full speed and slows down evenly */
    STUDY_STEADY   /* the key moves evenly after a soft start */
} study_touch;

/** How a stroke is driven. Start from study_drive_default(). */
typedef struct study_drive {
    study_touch touch;
    double travel;  /* duration of the key's way down, of a prescribed motion [s] */
    double depth;   /* how far down: 1 as far as the load leaves the key */
    double until;   /* [s] */
    double release; /* the load is lifted [s]; NAN: never */
} study_drive;
study_drive study_drive_default(void);

/** A stroke with further results beside lab_stroke. NAN where there was none. */
typedef struct study_details {
    stein_status status;
    lab_stroke stroke;
    double key_force;    /* largest force at the load's place shortly before escapement [N] */
    double forced_force; /* largest force there between impact and forced escapement [N] */
    double slip_start;   /* first sliding in phase iii, faster than the friction law's vt [s] */
    double slip_time;    /* from there to escapement [s] */
    double slip_work;    /* friction in the notch meanwhile [J] >= 0 */
    double rearm_time;   /* from the release until the beak is under the roof for good [s] */
    double rearm_margin; /* overlap s of beak and roof when the next stroke could begin [m] */
} study_details;

/** Called after each step, beside the readings of the details. */
typedef struct study_watch {
    lab_sample_fn *sample;
    void *ctx;
} study_watch;

/** Reset `sim`, with its present parameters, and run the stroke. Failures are in
 * details->status. */
void study_strike(const study *s, stein_sim *sim, const study_drive *drive,
                  const study_watch *watch, study_details *details);
/** The key's motion of a touch: share of the way [0, 1] and its derivatives by t/travel. */
void study_motion(study_touch touch, double u, double s[3]);
/** Motion of the key by a prescribed signal from a way and its derivatives by time. */
typedef struct study_key {
    const study *s;
    study_touch touch;
    double travel, depth;
} study_key;

/* ---- static_escapement.c ---- */

/** The key pressed infinitely slowly: a chain of static equilibria. */
typedef struct study_static {
    stein_status status;
    int escaped;
    double height; /* head to string at the last equilibrium with the beak under the roof [m] */
    double dip;    /* of the key there [m] */
    double force;  /* largest force at the load's place on the way [N] */
} study_static;
/** Needs the prescribed motion of the key (s->input >= 0). */
void study_press_slowly(const study *s, stein_sim *sim, study_static *statics);

/* ---- regulate.c ---- */

/** The value of parameter `name` between lo and hi at which the dynamic escapement height is
 *  `height` [m]: bisection, the simulation is left with that value. @return 1, or 0 when lo and hi
 *  do not bracket it */
int study_level(const study *s, stein_sim *sim, const char *name, double lo, double hi,
                double height, double *value);
/** Dynamic escapement height of the simulation's parameters; NAN without escapement. */
double study_height(const study *s, stein_sim *sim);
/** d height / d parameter by a central difference of `step`. */
double study_height_slope(const study *s, stein_sim *sim, const char *name, double step);

/* ---- part.c ---- */

enum {
    STUDY_COLUMNS = 20,
    STUDY_TABLES = 5,
    STUDY_CHARTS = 4,
    STUDY_PANELS = 6,
    STUDY_CURVES = 10,
    STUDY_PARTS = 12,
    STUDY_LINES = 6
};

/** A table of numbers that becomes NAME.csv; without a name it stays inside. */
typedef struct study_table {
    char name[32];
    const char *head[STUDY_COLUMNS]; /* "dx [m]" */
    int ncolumn, nrow;
    double *cell; /* [nrow * ncolumn] */
    char **label; /* [nrow] texts of a first column, or NULL */
    const char *label_head;
} study_table;

typedef enum {
    STUDY_LINE,
    STUDY_POINTS,
    STUDY_BOTH,
    STUDY_DASHED,
    STUDY_BARS,
    STUDY_STEPS
} study_style;

typedef struct study_curve {
    const study_table *table;
    int x, y;      /* columns; BARS: x the length, y ignored (row number) */
    double sx, sy; /* from the table's unit to the axis' */
    const char *title;
    study_style style;
    int colour; /* 0..7 */
} study_curve;

typedef struct study_panel {
    const char *xlabel, *ylabel;
    double x0, x1, y0, y1; /* NAN: by the data */
    double band[2];        /* shaded between these x; NAN: none */
    int logx, logy;
    int legend; /* its curves are named above the picture; one panel of a picture */
    study_curve curve[STUDY_CURVES];
    int ncurve;
    struct {
        double x, y, x2, y2;
        const char *title;
    } line[STUDY_LINES]; /* the paper's lines */
    int nline;
} study_panel;

/** A picture NAME.svg. */
typedef struct study_chart {
    char name[32];
    char *text; /* HTML, sentences under it */
    int width, height, columns;
    double left; /* margin for long row names, share of the width; 0: normal */
    study_panel panel[STUDY_PANELS];
    int npanel;
} study_chart;

typedef struct study_part {
    const char *id, *title;
    study_table table[STUDY_TABLES];
    int ntable;
    study_chart chart[STUDY_CHARTS];
    int nchart;
    char *text; /* HTML, sentences ahead of the pictures */
    int lost;   /* there was no memory for a sentence: study_write refuses */
} study_part;

/** A new table; its cells are NAN. NULL without memory. */
study_table *study_table_new(study_part *part, const char *name, int nrow, const char *const *head);
/** A table of some columns of another. @return 0 without memory */
int study_table_copy(study_part *part, const char *name, const study_table *from, const int *column,
                     int n);
double *study_row(const study_table *t, int row);
/** Has every row the text of a first column? */
int study_is_labelled(const study_table *t);
/** A new picture; panels and curves are added to it. */
study_chart *study_chart_new(study_part *part, const char *name, int width, int height,
                             int columns);
study_panel *study_panel_new(study_chart *chart, const char *xlabel, const char *ylabel);
void study_curve_add(study_panel *panel, const study_table *table, int x, double sx, int y,
                     double sy, study_style style, int colour, const char *title);
void study_line_add(study_panel *panel, double x, double y, double x2, double y2,
                    const char *title);
/** Another sentence: under the picture that was added last, or ahead of all. */
void study_say(study_part *part, const char *format, ...);
void study_part_free(study_part *part);
stein_status study_write_csv(const study *s, const study_table *t, const char *path,
                             stein_err *err);
stein_status study_draw(const study_chart *chart, const char *path, stein_err *err);
/* ---- the parts ---- */

typedef stein_status study_part_fn(const study *s, study_part *part, stein_err *err);
study_part_fn study_paper, study_regulation, study_angle, study_touches, study_repetition,
    study_sensitivity, study_tolerance;

/** The reference with parameter `param` changed by `by` [its unit], and its results. */
typedef struct study_bend {
    int param;
    double by;
    int struck;                /* 0: no stroke, the rest means nothing */
    double y[STUDY_RESPONSES]; /* height [m], speed [m/s], force [N] */
} study_bend;
/** All of them, on all threads and in the lanes of each. @return OK, ENOMEM */
stein_status study_bends(const study *s, study_bend *bend, int n, stein_err *err);
/** Slopes of all parameters that can have one. @param slope [np] @return their number in *n */
stein_status study_slopes(const study *s, study_slope *slope, int *n, stein_err *err);

/** How the key is repeated. */
typedef struct study_rhythm {
    double down;  /* duration of the way down [s]; at most 35 % of the period */
    double depth; /* share of the key's way that is given back between the strokes, 1 = all */
    int pushes;   /* 1: a finger that only pushes: the key comes up by itself or not at all */
} study_rhythm;
/** Does repetition with this period work: does every one of a few strokes escape and strike?
 *  @param sim  by study_def_controlled(), as for the two below */
int study_repeats(const study *s, stein_sim *sim, double period, const study_rhythm *how);
/** Shortest period down to which all work [s]; *fails: a period just below that does not. NAN:
 * none, even the slowest (0.3 s) fails. */
double study_repetition_limit(const study *s, stein_sim *sim, const study_rhythm *how,
                              double *fails);
/** Smallest share of the key's way that must be given back, at a period; *fails: just below. */
double study_return_needed(const study *s, stein_sim *sim, double period, double down,
                           double *fails);

/** Monte Carlo over making tolerances, `scale` times as large: heights [samples] (NAN: no
 *  escapement). */
stein_status study_monte_carlo(const study *s, double scale, double *height, stein_err *err);

/* ---- study.c, page.c ---- */

typedef struct study_report {
    study_part part[STUDY_PARTS];
    int npart;
} study_report;
/** Simulate all parts. */
stein_status study_run(study *s, study_report *report, stein_err *err);
/** Write NAME.csv, NAME.svg and study.html into the folder. */
stein_status study_write(const study *s, const study_report *report, const char *folder,
                         stein_err *err);
void study_report_free(study_report *report);
/** The page; pictures are read back from the folder. */
stein_status study_page(const study *s, const study_report *report, const char *folder,
                        stein_err *err);

#endif
