/* SPDX-License-Identifier: GPL-3.0-or-later
 * lab.h - the laboratory on top of the core: mechanism files, strokes, facts. libsteinlab.a.
 *
 * The lab uses files, heap memory and GSL; the core below it does not. It reports as the core does,
 * by a status and a message: it never prints or exits.
 */
#ifndef STEIN_LAB_H
#define STEIN_LAB_H

#include "stein/linear.h"
#include "stein/sim.h"
#include "stein/version.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A mechanism file, read, with its equations - built in, or generated, compiled and loaded. */
typedef struct lab_model lab_model;

/** Receives every problem of a file, "file:line:column: ...", and notices of slow work. */
typedef void lab_report_fn(void *ctx, const char *message);

/** Called repeatedly by long work, from any of its threads. @return 0: continue; 1, from then on
 *  always: stop. The call then ends with STEIN_ESTOPPED and keeps only its journal */
typedef int lab_stop_fn(void *ctx);

/** Source of the equations, and the receiver of messages. Start from lab_options_default(). */
typedef struct lab_options {
    const char *const *set; /* "NAME=VALUE[unit]" overrides */
    int nset;
    const char
        *cache; /* folder of compiled equations; NULL: $XDG_CACHE_HOME/stein or ~/.cache/stein */
    const char *cc;        /* compiler; NULL: $CC or "cc" */
    lab_report_fn *report; /* may be NULL */
    void *ctx;
} lab_options;
lab_options lab_options_default(void);

/** Read a file and get its equations. A mechanism with the equations hash of a built-in model uses
 *  the built-in equations. Other equations are generated, compiled into the cache and loaded.
 *  @return OK, EIO, EPARSE, ENOMEM, EGENERATE, ECOMPILE, ELOAD, ESTALE */
stein_status lab_open(lab_model **out, const char *file, const lab_options *options,
                      stein_err *err);
void lab_close(lab_model *model);
/** The equations, with the values of the file (after overrides) as defaults: parameters, step,
 *  integrator, duration. Valid until lab_close. */
const stein_model *lab_equations(const lab_model *model);
/** The file's parameter values after overrides, [np] in the order of the equations' params. */
const double *lab_parameters(const lab_model *model);
/** A simulation with the file's parameters, step and integrator, in its initial state.
 *  @param def  NULL for the file's */
stein_status lab_sim(const lab_model *model, const stein_sim_def *def, stein_sim **sim,
                     stein_err *err);
/** Read a number in the form of a mechanism file, "-0.3 mm".
 *  @param unit  the SI unit of the quantity ("m", "N m s/rad", "1"): a number without unit is in it
 *  @return OK, EINVAL (what was expected) */
stein_status lab_quantity(double *value, const char *text, const char *unit, stein_err *err);
/** The file's own step, integrator and allocator. */
stein_sim_def lab_def(const lab_model *model);
/** Duration stated in the file [s]. */
double lab_until(const lab_model *model);
/** A generated expression as text that SymPy reads, over Symbol('hammer.mass'), Symbol('q.hammer').
 *  @param what  "M" [nq, nq], "c" [nq, 1], "Q" = M qdd + c [nq, 1], "T", "V" (kinetic, potential
 *               energy of the tree [J]), or a point: its position [3, 1] [m]
 *  @param text  out, to be freed with free(); untouched on failure
 *  @return OK, ENAME (nothing is called so), EGENERATE (more than 4 MB), ENOMEM */
stein_status lab_expressions(char **text, const lab_model *model, const char *what, stein_err *err);

/* ---- strokes ---- */

/** Decided by the notch first, then by the string. */
typedef enum {
    LAB_STRUCK,        /* the hammer escaped (or has no notch) and the string was touched */
    LAB_MISSED_NOTCH,  /* the beak never touched roof or corner (phases 1 to 3) */
    LAB_NO_ESCAPEMENT, /* the beak was caught but never escaped, whether or not the string was
                          touched */
    LAB_NO_IMPACT      /* the string was never touched */
} lab_outcome;
/** "struck", "missed_notch", "no_escapement", "no_impact". */
const char *lab_outcome_text(lab_outcome outcome);

/** Results of one stroke [SI]. Times count from the release of the load, which is the initial
 *  state of lab_strike. Without the event a time, height or speed is NAN. */
typedef struct lab_stroke {
    lab_outcome outcome;
    int escaped;
    double escape_time, escape_height; /* head to string at escapement [s], [m] >= 0 */
    int impacts;
    double impact_time, impact_speed; /* first impact [s], closing speed of head and string [m/s] */
    double free_flight;               /* impact - escapement [s]; 0 unless escapement came first */
    int forced_escapement;            /* escaped after the first impact */
    double peak_string_force;         /* [N] */
    double blow;                      /* head to string at the start [m] */
    int rearmed;                      /* defined at lab_strike */
} lab_stroke;

/** Called after every step (and at t = 0) for recording.
 *  @return STEIN_OK to go on, else what lab_strike and lab_simulate return */
typedef stein_status lab_sample_fn(void *ctx, stein_sim *sim);

/** How to run a stroke. Start from lab_stroke_def_default(model). */
typedef struct lab_stroke_def {
    double until;          /* [s] */
    double release;        /* the load is lifted at this time [s]; NAN: never */
    double every;          /* sampling interval [s], rounded up to whole steps; 0: every step */
    lab_sample_fn *sample; /* may be NULL */
    stein_event_fn *event; /* of the motion up to `until`; may be NULL */
    void *ctx;             /* of both */
} lab_stroke_def;
/** The duration of the file, no release, no samples. */
lab_stroke_def lab_stroke_def_default(const stein_model *model);

/** Run one stroke from the simulation's present (freshly reset) state. Takes over the event
 *  subscription and gives it up at the end. The motion after `release` is not part of the stroke;
 *  only `rearmed` depends on it.
 *
 *  rearmed: with the load lifted (`release`), the beak is under the roof and overlaps it and the
 *  hammer is at rest at the end (below 0.5 rad/s relative to its parent). Without a release it is
 * found after the run. The load is lifted from the final state, and the motion continues for 0.5
 * s or until rest (no coordinate faster than 1e-3 rad/s or m/s at four times 5 ms apart). Then the
 * final state is restored.
 *
 *  @return OK or a numerical failure of stein_run; EINVAL when the model names no stroke, has no
 *  output channels for gap and force of its string, or def is out of range */
stein_status lab_strike(stein_sim *sim, const lab_stroke_def *def, lab_stroke *stroke,
                        stein_err *err);
/** The same run without looking for a stroke: any mechanism. */
stein_status lab_simulate(stein_sim *sim, const lab_stroke_def *def, stein_err *err);

/* ---- records ---- */

/** Samples of all output channels. */
typedef struct lab_record lab_record;
/** @param every  interval [s], rounded up to whole steps; 0: every sample that is offered */
stein_status lab_record_create(lab_record **record, const stein_model *model, double every,
                               stein_err *err);
void lab_record_destroy(lab_record *record);
/** Take a sample when one is due (a lab_sample_fn with the record as ctx). @return OK, ENOMEM */
stein_status lab_record_sample(void *record, stein_sim *sim);
/** Take the last sample, unless it has just been taken. @return OK, ENOMEM */
stein_status lab_record_finish(lab_record *record, stein_sim *sim);
/** Its numbers, a row a sample and a column a channel of the model, in the channels' units: [*rows
 * * nchannel], valid until the next sample. */
const double *lab_record_numbers(const lab_record *record, int *rows);

/** Write a record in the form of measured data: "# name: value" lines, a header of channel [unit],
 *  rows. Numbers are the shortest decimals that read back to the same bits.
 *  @param notes  "name: value" texts closed by NULL; may be NULL
 *  @return OK, EIO */
stein_status lab_write_csv(const char *path, const lab_record *record, const char *const *notes,
                           stein_err *err);
/** Forms of a record: CSV; NPY, a structured array of NumPy with a field for each channel; MAT,
 *  MATLAB's level 5 with a column for each channel, a struct `units` and the text `notes`;
 * CSV_PLAIN, names of the channels and rows in SI units, which any program reads without
 * options. */
typedef enum { LAB_CSV, LAB_NPY, LAB_MAT, LAB_CSV_PLAIN } lab_format;
/** By the ending of a path: .npy, .mat, else CSV. */
lab_format lab_format_of(const char *path);
/** Write a record. @param notes  as for lab_write_csv; NPY and CSV_PLAIN have no place for them
 *  @return OK, EIO, ENOMEM, EINVAL (more than 2^28 rows in a binary form) */
stein_status lab_write(const char *path, lab_format format, const lab_record *record,
                       const char *const *notes, stein_err *err);
/** Draw a record with gnuplot, SVG or PNG by the ending of the path. A stroke is drawn as
 * head-string distance, key dip, notch phase and forces, any other record as its first channels.
 *  @param stroke  may be NULL
 *  @return OK, EIO, EINVAL (other ending) */
stein_status lab_plot(const char *path, const lab_record *record, const stein_model *model,
                      const lab_stroke *stroke, stein_err *err);

/* ---- linearisation (linear.h) ---- */

/** Kind of a mode's motion. */
typedef enum {
    LAB_OSCILLATES, /* a pair of complex eigenvalues, whether it decays or grows */
    LAB_DECAYS,     /* a real eigenvalue < 0 */
    LAB_GROWS,      /* > 0 */
    LAB_NEUTRAL     /* 0, to rounding: a body that moves freely */
} lab_mode_kind;
/** One eigenvalue of A of the free coordinates, or a pair of conjugate ones. */
typedef struct lab_mode {
    lab_mode_kind kind;
    double re, im;    /* eigenvalue, im >= 0 [1/s] */
    int count;        /* 2: a pair */
    double frequency; /* |eigenvalue| / 2 pi, of the same without damping [Hz]; 0: no oscillation */
    double damping;   /* -re / |eigenvalue|, 1 is critical, < 0 grows [-] */
    int coordinate;   /* free coordinate with the largest share of the kinetic energy */
    double share;     /* that share [-] */
} lab_mode;
/** All of them, slow ones first. */
typedef struct lab_modes {
    int n;
    lab_mode *mode; /* [n] */
    double *shape;  /* [n][nfree][2] real and imaginary part of each free coordinate, largest 1 */
} lab_modes;
/** Eigenvalues and shapes of a linear system. @return OK, ENOMEM, ENONFINITE (A is not finite) */
stein_status lab_modes_create(lab_modes **modes, const stein_linear_system *system, stein_err *err);
void lab_modes_destroy(lab_modes *modes);
/** SI unit of a state (0 <= state < 2 n), or with derivative 1 of its rate; of an input. */
const char *lab_linear_unit(const stein_model *model, const stein_linear_system *system, int state,
                            int derivative);
const char *lab_linear_input_unit(const stein_model *model, const stein_linear_system *system,
                                  int input);
/** Write A, B, C, D as one CSV table: a row for the rate of each state and for each output, a
 *  column for each state and input, all with their units.
 *  @param notes  "name: value" texts closed by NULL, the first lines; may be NULL
 *  @return OK, EIO */
stein_status lab_linear_write(const char *path, const stein_model *model,
                              const stein_linear_system *system, const char *const *notes,
                              stein_err *err);

/* ---- driving ---- */

/** Signals from a CSV file in the form of measured data: every column named like an input of the
 *  model drives it. Motions are natural cubic splines, forces run straight between the samples;
 *  outside the samples the first and last value hold. */
typedef struct lab_drive lab_drive;
/** @return OK, EIO, EPARSE (file:line), EINVAL (no column is an input), ENOMEM */
stein_status lab_drive_open(lab_drive **drive, const char *file, const stein_model *model,
                            stein_err *err);
/** A warning where samples of a prescribed motion jump (a spline overshoots there): file, column,
 *  times and what helps; NULL: none jumps. Owned by the drive. */
const char *lab_drive_doubt(const lab_drive *drive);
/** Bind all signals; the drive must outlive the simulation's use of them. */
stein_status lab_drive_bind(lab_drive *drive, stein_sim *sim, stein_err *err);
void lab_drive_close(lab_drive *drive);

/* ---- sweeps over named parameters ---- */

/** Progress: done of total; may be called from several threads, one at a time. */
typedef void lab_progress_fn(void *ctx, int done, int total);

/** The points of a sweep: the product of some axes, the last axis fastest. */
typedef struct lab_grid lab_grid;
enum { LAB_POINTS = 1000000 }; /* at most so many */

/** Read axes, "NAME=FROM:TO:COUNT" or "NAME=VALUE,VALUE...", numbers with or without unit. A unit
 *  that is given once holds for all numbers of its axis; without any they are SI. Values are
 * rounded to 15 decimal digits in the unit given, so a grid hits 0.1 mm exactly as a typed 0.1 mm
 * does.
 *  @return OK, EINVAL (what was expected), ENAME (not a parameter of the equations), ENOMEM */
stein_status lab_grid_create(lab_grid **grid, const stein_model *model, const char *const *vary,
                             int nvary, stein_err *err);
void lab_grid_destroy(lab_grid *grid);
int lab_grid_points(const lab_grid *grid);
/** Value of an axis at a point [SI]. */
double lab_grid_value(const lab_grid *grid, int point, int axis);
/** The same for a file: the ends of every axis must be values that the file would accept with
 *  --set, and a name that is not in the equations is explained.
 *  @param file, options  as for lab_open
 *  @return OK, EINVAL, ENOMEM */
stein_status lab_grid_open(lab_grid **grid, const lab_model *model, const char *const *vary,
                           int nvary, const char *file, const lab_options *options, stein_err *err);

/** The results of a sweep, keyed by point. */
typedef struct lab_table lab_table;

/** How to sweep. Start from lab_vary_def_default(). */
typedef struct lab_vary_def {
    double until, release;  /* of every run, as in lab_stroke_def */
    int threads;            /* results do not depend on it */
    int shard, shards;      /* only the points with index % shards == shard */
    const char *journal;    /* finished points are kept there and not computed again; may be NULL */
    const char *const *set; /* the overrides of lab_open, for the record */
    int nset;
    lab_progress_fn *progress;
    lab_stop_fn *stop; /* may be NULL */
    void *ctx;
    const char *tolerance; /* of steps of controlled error, "CHANNEL=VALUE[unit]": error that they
                              may leave in an output of a place; NULL: the file's, and fixed steps
                              where it states none */
    int fixed;             /* 1: the file's fixed steps, whatever tolerance it states */
} lab_vary_def;
lab_vary_def lab_vary_def_default(const lab_model *model);

/** Counts of a sweep. */
typedef struct lab_vary_report {
    int computed, found; /* points computed now; found in the journal */
    int damaged;         /* lines of the journal that could not be read */
} lab_vary_report;

/** One stroke at every point (the final outputs of a mechanism that names no stroke). A point whose
 *  simulation fails keeps its status; the sweep continues. Each point has its own simulation, so
 *  the table does not depend on threads, shards or interruptions.
 *  @param report  may be NULL
 *  @return OK, EINVAL (def), EIO, ESTALE (the journal belongs to another sweep), ESTOPPED, ENOMEM
 */
stein_status lab_vary(lab_table **table, const lab_model *model, const lab_grid *grid,
                      const lab_vary_def *def, lab_vary_report *report, stein_err *err);
/** Put the journals of one sweep together.
 *  @param damaged  out, may be NULL: lines that could not be read
 *  @return OK, EIO, EPARSE (no journal), ESTALE (of different sweeps), EINVAL (two results for one
 *          point), ENOMEM */
stein_status lab_merge(lab_table **table, const char *const *journal, int n, int *damaged,
                       stein_err *err);
void lab_table_destroy(lab_table *table);
int lab_table_points(const lab_table *table);
/** 1 when the point has a result. */
int lab_table_has(const lab_table *table, int point);
/** Write the table as CSV, points in order. @return OK, EIO */
stein_status lab_table_write(const char *path, const lab_table *table, stein_err *err);
/** Draw it, .svg or .png: curves over one varied parameter, a map over two.
 *  @return OK, EINVAL (nothing to draw, or more than two), EIO */
stein_status lab_table_plot(const char *path, const lab_table *table, stein_err *err);

/* ---- study: the paper's facts ---- */

/** A stroke of a sweep over dx, the displacement of the pawl's stop (pawl.stop_shift). */
typedef struct lab_point {
    double dx; /* [m] */
    stein_status status;
    lab_stroke stroke; /* when status is OK */
} lab_point;

/** One published fact and the simulated value. */
typedef struct lab_fact {
    const char *fact, *paper;
    const char *within; /* what counts as reproduced */
    char simulated[64];
    int ok;
    int calibrated; /* 1: numbers of models/stein1788.yaml were chosen so that it comes out */
} lab_fact;
enum { LAB_FACTS_MAX = 24 };

/** Strokes at n values of dx (point[i].dx), on `threads` threads. Results do not depend on their
 *  number.
 *  @return OK, ENAME (no such parameter), EINVAL (no stroke), ENOMEM; numerical failures are kept
 *  in the points */
stein_status lab_sweep(const lab_model *model, lab_point *point, int n, int threads,
                       lab_progress_fn *progress, void *ctx, stein_err *err);
/** The grid of the study, -1.5 .. 0.3 mm in steps of 0.05 mm: fills point[i].dx.
 *  @param point  [n] or NULL to ask for the number
 *  @return the number of points */
int lab_study_grid(lab_point *point, int n);
/** The paper's facts on the strokes of the grid. @param fact [LAB_FACTS_MAX] out
 *  @return their number */
int lab_facts(lab_fact *fact, const lab_point *point, int n);

/* ---- hashes of results ---- */

/** Hashes of standard work: stein_identity() of the built-in mechanisms, the table of a sweep, the
 *  numbers of a fit. */
typedef struct lab_identity {
    unsigned long long core, sweep, fit;
} lab_identity;
/** A film for the fit is written into $TMPDIR or /tmp, and removed.
 *  @param threads  the hashes do not depend on it
 *  @return OK, EIO, ENOMEM, or a failure of the work itself */
stein_status lab_identify(lab_identity *identity, int threads, stein_err *err);

/* ---- pages ---- */

enum { LAB_HASH = 17 };
/** Facts about a written page. */
typedef struct lab_page_facts {
    size_t page, module; /* bytes of the file (0: not a file), of the WebAssembly module in it */
    char hash[LAB_HASH]; /* FNV-1a of the state after the file's own run; the page computes and
                            shows it too */
} lab_page_facts;
/** Write a mechanism as one HTML file that simulates it in a browser. Core and equations are
 * compiled to WebAssembly by clang, or by WASM_CC of the environment (options->cc is not used),
 * once a mechanism, into the cache.
 *  @param facts  out, may be NULL
 *  @return OK, EIO, ENOMEM, ECOMPILE (no clang, lld or wasi-libc: which Debian packages), or what a
 *          run returns */
stein_status lab_page(const char *path, const lab_model *model, const lab_options *options,
                      lab_page_facts *facts, stein_err *err);

/* ---- FMUs ---- */

/** Facts about a written FMU. */
typedef struct lab_fmu_facts {
    size_t bytes, binary; /* of the file (0: not a file), of the shared objects in it */
    int variables;
    char token[40];    /* in the description and in the binary */
    char platform[32]; /* "x86_64-linux"; in FMI 2 "linux64"; of several as many as fit in */
} lab_fmu_facts;
/** Write a mechanism as a co-simulation FMU of FMI 3.0 or 2.0: description, binary for the machine
 *  that the compiler compiles for, sources. Same mechanism, same compiler: same bytes.
 *  @param version  2 or 3
 *  @param options  NULL for the defaults  @param facts  out, may be NULL
 *  @return OK, EIO, ENOMEM, EINVAL (version; two variables of one name), EGENERATE, ECOMPILE */
stein_status lab_fmu(const char *path, const lab_model *model, int version,
                     const lab_options *options, lab_fmu_facts *facts, stein_err *err);
/** The same with binaries for several machines.
 *  @param cc  [ncc] compilers, each for another machine, "x86_64-w64-mingw32-gcc"; options->cc is
 *             not used  @return as lab_fmu; EINVAL also for two compilers for one machine */
stein_status lab_fmu_for(const char *path, const lab_model *model, int version,
                         const char *const *cc, int ncc, const lab_options *options,
                         lab_fmu_facts *facts, stein_err *err);

#ifdef __cplusplus
}
#endif
#endif
