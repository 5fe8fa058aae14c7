/* SPDX-License-Identifier: GPL-3.0-or-later
 * fitting.h - what the files of the fit share.
 *
 *   problem.c      unknowns from model and data
 *   stroke.c       strokes from data
 *   signal.c       measured inputs as smooth signals
 *   force_error.c  the noise of measured forces as unknowns
 *   band.c         how far they are smoothed where the forces of a motion were measured
 *   start_window.c value and slope of a channel at the start of its record
 *   start_kinematics.c positions and speeds from what the channels show there
 *   start_state.c  one state out of these, start_state.h
 *   initial.c      initial states from the records
 *   start_follow.c the initial state from which a simulation follows a record's beginning
 *   horizon.c      how far ahead a stroke can be predicted
 *   setup.c        what keeps a record from beginning as the model moves: sense, zero, plane
 *   simulate.c     one stroke at the data's own times, stroke_reader.h
 *   event_times.c  the times of its events
 *   observer.c     the same, held near the data
 *   many.c         many strokes, on threads and in lanes
 *   row.c, row.h   those in the lanes of one thread
 *   pool.c         several fits at once, in the same lanes
 *   residuals.c    weighted residuals of all strokes
 *   sensitivity.c  their derivatives
 *   normal.c       normal equations of what moves
 *   minimise.c     Levenberg-Marquardt, and descent with derivatives at hand
 *   starts.c       ladder, several starts
 *   resume.c       state, safe from kill -9
 *   intervals.c    what the data tell
 *   profile.c      profile likelihood
 *   patch.c        the file with new numbers
 *   place.c        where a new number goes
 *   fit.c          the whole
 *   fit_report.c   results in lists
 *
 * Unknowns are counted in prior standard deviations from their start: x = (z - z0)/sd with z the
 * value or its logarithm. Globals come first, then each stroke's own in the order of the strokes.
 * Included by: this folder, src/lab.
 */
#ifndef FITTING_H
#define FITTING_H

#include <gsl/gsl_matrix.h>

#include "run.h"
#include "stein/diagnose.h"

/* ---- signal.c ---- */

/** u = a0 + s (a1 + s (a2 + s a3)), s = t less the knot that it begins at. */
typedef struct fit__cubic {
    double t, a[4];
} fit__cubic;
/** One measured input: a motion smoothed, as a cubic spline; a force straight from sample to
 * sample. */
typedef struct fit__signal {
    int input, motion, n;
    int first;         /* knot among those of the record's signals, where their errors are */
    double *t, *g;     /* [n] knots, values */
    fit__cubic *piece; /* [n] from knot to knot: what a simulation reads in one go lies side by
                          side, and nothing is divided */
    double decades;    /* how much it was smoothed: log10 of a in intervals^5 (signal.c) */
    double noise;      /* sd of one sample that it was made with */
    double taken;      /* RMS of what smoothing took away */
} fit__signal;
/** @param noise  sd of one sample; what is smoother than that is taken as motion. 0: interpolate
 *  @param hz     instead, the frequency of which half is kept; NAN: as the noise allows */
stein_status fit__signal_make(fit__signal *s, int input, int motion, const lab_data *data,
                              const lab_column *column, double noise, double hz, stein_err *err);
/** Frequency of which smoothing has kept half [Hz]. */
double fit__signal_band(const fit__signal *s);
/** The same of a motion u over times t, n of each; u NAN: no sample.
 *  @param decades  how much it is smoothed, log10 of a in intervals^5 (signal.c); NAN: as the noise
 *                  allows */
stein_status fit__signal_through(fit__signal *s, int input, const double *t, const double *u, int n,
                                 double noise, double decades, stein_err *err);
/** Its pieces from t and g. @param c  [n] second derivatives; NULL: straight */
void fit__signal_pieces(const fit__signal *s, const double *c);
void fit__signal_free(fit__signal *s);
/** Value and derivatives at t. @param at  where it was found last, kept by the caller; 0 at first
 */
void fit__signal_at(const fit__signal *s, double t, int *at, double u[3]);

/* ---- problem.c ---- */

typedef enum {
    FIT__PARAM,
    FIT__TAU,
    FIT__OFFSET,
    FIT__POSITION,
    FIT__SPEED,
    FIT__SCATTER,
    FIT__FORCE,   /* error of the measured forces; index: shape */
    FIT__SETTING, /* what a number that the stroke sets is off by; index: parameter */
    FIT__AMOUNT,  /* of an effect */
    FIT__SIDE     /* a number beside it; index: which */
} fit__kind;
/** Numbers that scatter together from stroke to stroke. */
enum { FIT__CALM, FIT__JOINTS, FIT__CONTACTS, FIT__DRIVE, FIT__GROUPS };
/** The class of a group: those of places are beyond FIT__GROUPS. */
static inline int fit__class(int group)
{
    return group % FIT__GROUPS;
}

/** The numbers of an effect: its amount and those beside it. */
enum { FIT__NUMBERS = 1 + LAB_SIDES };
/** "amount", "side", "other": what a posterior calls them. */
extern const char *const fit__number_name[FIT__NUMBERS];
/** Which of them is called so; -1: none. */
int fit__find_number(const char *name);

/** Which events a channel of a stroke holds times of. */
typedef struct fit__event {
    int is;             /* 0: it holds samples */
    int end;            /* 1: events that open the place; 0: that close it */
    int contact, notch; /* the place; -1: the other one */
    const char *name;   /* of its column */
    int n;              /* measured times */
    double shortest;    /* interval of two of them, or from the start to the first one [s] */
} fit__event;

/** One unknown. */
typedef struct fit__unknown {
    fit__kind kind;
    int stroke;       /* -1: of all */
    int index;        /* parameter; channel slot of the stroke; joint; group */
    int log, prior;   /* prior 0: sd is only a scale */
    int idle;         /* stays where it is */
    int mistake;      /* its prior has long tails (fit__long_tail) */
    double least;     /* of an amount, in sd: a compliance near 0 is a stiffness which no step
                         follows, a mass or a damping stays positive; -INFINITY: none */
    double start, sd; /* of z */
} fit__unknown;

/** One stroke as the fit uses it. Sample c, i is y[c*n + i]. */
typedef struct fit__stroke {
    const lab_data *data;
    int n, nch;
    int nsampled;        /* channels with samples, which come first; times of events follow */
    int *channel;        /* [nch] of the model; of times of events the one that reads the time */
    fit__event *event;   /* [nch] */
    double *noise;       /* [nch] sd */
    double *audited;     /* [nch] noise by file or audit, before the residual was asked */
    double *residual;    /* [nch] noise as the residual has it */
    double *step;        /* [nch] quantisation step as the record shows it, 0: none */
    int *given;          /* [nch] noise by the file */
    int *delay;          /* [nch] parameter of the instrument's delay, -1: none */
    double *y;           /* [nch*n], NAN: missing. Of events: when the i-th one was [s] */
    double *weight;      /* [nch*n] square roots of robust weights; NULL: all 1 */
    double *share;       /* [nch*n] square root of what a sample counts as: 1, less where an encoder
                            repeats its reading; 0: missing */
    int samples;         /* as many as they count as */
    double origin;       /* time of the data at which the simulation starts, before tau [s] */
    int waits;           /* 1: it rests in its initial state until t = 0 */
    double window;       /* length of the start window that its initial state comes from [s] */
    double half;         /* half a swing of the fastest channel [s]; 0: it does not swing */
    fit__signal *signal; /* [nsignal] */
    int nsignal;
    const struct fit__force_error *force; /* shapes that their noise may have, NULL: none */
    int first, own;                       /* its unknowns */
    int tau;                              /* unknown of its trigger, -1: none */
} fit__stroke;

/** Square root of the weight of a sample. */
static inline double fit__weight(const fit__stroke *s, int i)
{
    return s->weight != NULL ? s->weight[i] * s->share[i] : s->share[i];
}

/** What a measurement is more than its prediction [unit], 0 where it is missing. @param r  of
 * fit__weigh */
static inline double fit__off(const fit__stroke *s, const double *r, int i)
{
    double w = fit__weight(s, i);
    return w > 0.0 ? r[i] * s->noise[i / s->n] / w : 0.0;
}

enum { FIT__ACCEPTED = 3 };

typedef struct fit__problem {
    const lab_model *model;
    const lab_fit_def *def;
    const lab_dataset *data; /* the strokes as they were read */
    fit__stroke *stroke;
    int nstroke;
    fit__unknown *unknown;
    int np, nu;            /* free parameters; all unknowns */
    unsigned short *group; /* [np of the model] what each parameter scatters with */
    int places;            /* that scatter by themselves; 0: by class only */
    int clock;             /* parameter of the recorder's time base, -1: none */
    double *step;          /* [nu] half-width of differences, in x */
    double gain;           /* of the ladder, 0: plain simulation */
    int stride;            /* samples from one correction of the ladder to the next; 0: one */
    double tolerance;      /* of one step [rad or m] */
    int plain;             /* 1: steps as long as the file's instead */
    double horizon;        /* samples after it do not count [s of the simulation] */
    double limit;          /* fit__descend: parameters stay within so many prior sd */
    int central;           /* differences to both sides */
    const lab_candidate *accepted[FIT__ACCEPTED]; /* effects that act, with unknowns of their own */
    int naccepted, first_accepted;                /* FIT__NUMBERS of each, one behind the other */
    const lab_candidate *given;                   /* acts anyway, by given_amount; NULL: none */
    double given_amount;
    const lab_candidate *effect; /* on trial, NULL: none */
    int amount, side;            /* its unknowns, side the first of LAB_SIDES; -1: no room */
    int fixed;                   /* this unknown stays (profile); -1: none */
    int flat;                    /* the prior of this unknown does not count; -1: none */
    int samples, rows;           /* rows: largest stroke */
    int threads, lanes;          /* lanes of each thread; 0: as many as there are */
    struct fit__pool *pool;      /* where its strokes are simulated instead; NULL: nowhere else */
    long *simulated;             /* strokes so far are counted there; NULL: nowhere */
    lab__stop stop;
} fit__problem;

/** The group of a parameter by its name; FIT__CALM: it is the same in all records.
 *  @param by_place  1: the friction of every place is a group of its own, of the same class */
int fit__group_of(const stein_model *m, const char *name, int by_place);
/** Do group g of problem a and group h of problem b belong to the same joint or contact? The
 *  mechanism of one may have more joints than that of the other. */
int fit__same_group(const fit__problem *a, int g, const fit__problem *b, int h);
/** All of its unknowns move at once: fewer samples than that are refused. */
stein_status fit__problem_make(fit__problem *p, const lab_model *model, const lab_dataset *data,
                               const lab_fit_def *def, stein_err *err);
/** The same with room for an effect: FIT__NUMBERS more unknowns behind the parameters, idle until
 *  fit__problem_try. def->nfree may be 0. Samples may be few: which unknowns move at once is up to
 *  the caller, who asks fit__check_samples where they all do. */
stein_status fit__problem_make_open(fit__problem *p, const lab_model *model,
                                    const lab_dataset *data, const lab_fit_def *def,
                                    stein_err *err);
/** The same with effects that act in it, n <= FIT__ACCEPTED: the FIT__NUMBERS of each are unknowns
 *  between the parameters and those of the effect on trial.
 *  @param accepted  must outlive the problem */
stein_status fit__problem_make_with(fit__problem *p, const lab_model *model,
                                    const lab_dataset *data, const lab_fit_def *def,
                                    const lab_candidate *accepted, int n, stein_err *err);
/** Put an effect on trial (NULL: none). Its amount counts in limits, the numbers beside it from
 *  where they begin in quarters of their range. */
void fit__problem_try(fit__problem *p, const lab_candidate *effect);
/** Only samples up to a horizon count [s of the simulation]; INFINITY: all of them. */
void fit__limit(fit__problem *p, double horizon);
/** @return EINVAL unless there are more samples than unknowns */
stein_status fit__check_samples(const fit__problem *p, stein_err *err);
void fit__problem_free(fit__problem *p);
/** Does the stroke state this parameter itself (# set)? */
int fit__is_set(const lab_data *data, int param);
/** Do all of them? */
int fit__always_set(const lab_dataset *data, int param);
/** ... and was it looked at by itself, so that it is what they say? */
int fit__always_known(const lab_dataset *data, int param);
/** Value of an unknown at x [SI]. */
double fit__value(const fit__unknown *u, double x);
/** dz value: value for a logarithm, else 1. */
double fit__slope(const fit__unknown *u, double x);

/* ---- stroke.c ---- */

/** A stroke of p from its data. @return OK, EINVAL (no output to fit), ENOMEM */
stein_status fit__take_stroke(fit__problem *p, int stroke, const lab_data *data, stein_err *err);
/** Quantisation steps of an encoder that only some records show, in all that lie on them. */
void fit__share_steps(fit__problem *p);

/* ---- event_times.c ---- */

/** When sample k of [nch*n] was taken [s of the data]; of an event when it was, NAN: missing. */
static inline double fit__time_of(const fit__stroke *s, int k)
{
    return s->event[k / s->n].is ? s->y[k] : s->data->time[k % s->n];
}
/** The row of the record at that time: of an event that is missing, row 0. */
int fit__row_of(const fit__stroke *s, int k);
/** Name and unit of a channel of the model in these strokes; the one of the time stands for times
 *  of events. */
const char *fit__name_of(const fit__problem *p, int channel);
/** Measured times of events that the simulation lacks: it has fewer events in the record.
 *  @param lacking  out: [nstroke] of each stroke  @return OK, ENOMEM */
stein_status fit__lacking(const fit__problem *p, const double *x, int *lacking, stein_err *err);

/* ---- start_window.c ---- */

/** Does a channel show where something is, or how fast it moves? */
static inline int fit__shows_place(const stein_channel *c)
{
    return stein_reads_place((int)c->read);
}

static inline int fit__shows_speed(const stein_channel *c)
{
    return c->read == STEIN_READ_SPEED || c->read == STEIN_READ_VX || c->read == STEIN_READ_VY ||
           c->read == STEIN_READ_VZ;
}

/** A channel at the start of its record. */
typedef struct fit__start {
    double value, slope;       /* [unit], [unit/s] */
    double value_sd, slope_sd; /* standard deviations */
    double length;             /* of the window [s] */
    int samples;               /* in it */
} fit__start;
/** The angle of a turning joint without the jumps that an instrument makes at its turn's end: a
 *  record that has them lies within one turn. @param y  [n] */
void fit__unwrap(double *y, int n);
/** Value and slope at time `at` of samples in order of their distance from the start, forwards or
 *  backwards in time.
 *  @param noise  sd of one sample  @return 1; 0: fewer than three samples, out is untouched */
int fit__start_of(const double *t, const double *y, int n, double noise, double at,
                  fit__start *out);

/* ---- simulate.c ---- */

/** Called when the simulation stands at sample i (of the first channel). */
typedef void fit__watch_fn(void *ctx, stein_sim *sim, int i);

typedef struct fit__reader fit__reader;

/** What a trial's failure means for the search that tries: the trial lost, and nothing else. But
 *  memory that ended, and a stop, end the search. @return OK, ENOMEM (and said so) */
static inline stein_status fit__forgive(stein_status trial, stein_err *err)
{
    return trial == STEIN_ENOMEM || trial == STEIN_ESTOPPED ? lab__no_memory(err) : STEIN_OK;
}

/** What one simulation of strokes needs, one after the other. */
typedef struct fit__bench {
    stein_sim *sim, *probe; /* probe: only for the ladder */
    double *p;              /* [np] */
    double *q, *qd;         /* [nq] */
    double *shown;          /* [nch] what is added to the readings of a stroke */
    double *x, *y;          /* [nu], [rows] for whoever asks for a stroke */
    fit__reader *reader;
    struct fit__observer *observer;
    stein_force_fn *force; /* forces that the model lacks, not with the ladder; NULL: none */
    void *force_ctx;
    double faster; /* what the time of the frames is taken as more than it is, a share of it */
    fit__watch_fn *watch; /* called at every frame; may be NULL */
    void *watch_ctx;
    int no_memory; /* a simulation had none: no property of the model */
} fit__bench;
stein_status fit__bench_make(fit__bench *b, const fit__problem *p, stein_err *err);
void fit__bench_free(fit__bench *b);
/** An effect with its unknowns, `amount` and those behind it, in parameters `to`. */
void fit__apply(const fit__problem *p, const lab_candidate *effect, int amount, const double *x,
                double *to);
/** Predicted channels of a stroke at the data's times, offsets included.
 *  @param x  [nu]; y [nch*n] out
 *  @return OK or a numerical failure */
stein_status fit__simulate(const fit__problem *p, fit__bench *b, int stroke, const double *x,
                           double *y, stein_err *err);

/** The same in parts, for strokes that run side by side: up to where the steps begin. Neither p nor
 *  x is needed afterwards. */
stein_status fit__begin(const fit__problem *p, fit__bench *b, int stroke, const double *x,
                        double *y, stein_err *err);
/** 1: the steps can be made in a batch, run by run; 0: by fit__alone only. */
int fit__can_ride(const fit__bench *b);
/** The next run of its simulation, to t_end at this pace. @return 0: there is none */
int fit__next_run(fit__bench *b, double *t_end, stein_pace **pace);
/** All steps. @return as fit__simulate */
stein_status fit__alone(fit__bench *b);
/** The rest of y. @param status  of the steps  @return as fit__simulate */
stein_status fit__finish(fit__bench *b, stein_status status);

/* ---- force_error.c ---- */

enum { FIT__FORCES = 20 }; /* shapes of a record: cost */
/** How the noise of the measured forces of one record may move it. */
typedef struct fit__force_error {
    int number;         /* of the record */
    int n, knots;       /* shapes; samples of all signals */
    double *shape;      /* [n][knots] with the standard deviation of their amplitude */
    double share, left; /* what the noise adds to chi2/dof; without what the shapes describe */
} fit__force_error;
typedef struct lab_force_errors {
    int n;
    fit__force_error **record; /* [n] they stay where they are: strokes point to them */
} lab_force_errors;
/** Those of the strokes of p, at its start, behind the ones there are.
 *  @return OK, ENOMEM, the failure of making a simulation */
stein_status fit__force_errors_add(lab_force_errors *to, const fit__problem *p, stein_err *err);
void fit__force_errors_free(lab_force_errors *e);
/** The means over the records. */
void fit__force_errors_share(const lab_force_errors *e, double *share, double *left);
/** Of a stroke of p, NULL: there are none. */
const fit__force_error *fit__force_error_of(const fit__problem *p, const fit__stroke *t);
/** What is added to the knots of all signals of a stroke at x. @param error  [knots] out */
void fit__force_error_at(const fit__problem *p, const fit__stroke *t, const double *x,
                         double *error);

/* ---- band.c ---- */

/** The band of a prescribed motion in a record: that of def->smooth where that is for all, else the
 *  one that the record states, else that of def->smooth [Hz]; NAN: as its noise allows. */
double fit__band_of(const fit__problem *p, const lab_data *data, int input);

/** The frequency up to which each measured motion is taken as motion, where the force that it
 * needed was measured, too. The signals of p become those, but where a record states its band.
 *  @param hz  [ninput] out; NAN: as the noise of the motion allows, or stated by all records
 *  @return OK, ENOMEM, the failure of making a simulation */
stein_status fit__choose_bands(fit__problem *p, double *hz, stein_err *err);
/** Raises the noise of channel k of a stroke to the RMS of what it does above the band of its
 *  motion. Only a measured force of a prescribed motion with a band has such a part, and a noise
 * that the file states stays. @return OK, ENOMEM */
stein_status fit__widen_noise(const fit__problem *p, fit__stroke *s, int k, stein_err *err);
/** Samples of a measured force at the ends of the record, where its smoothed motion has neighbours
 * on one side only, count no longer. */
void fit__mute_ends(const fit__problem *p, fit__stroke *s);

/* ---- hidden.c ---- */

/** Does a coordinate of a body that turns in all directions begin as the file or the stroke states,
 *  because the stroke shows nothing of it there? */
int fit__is_hidden(const fit__problem *p, const fit__stroke *s, int joint);

/* ---- initial.c ---- */

/** Estimate the initial state of every stroke from its first samples. start, sd and prior of the
 *  unknowns FIT__POSITION and FIT__SPEED are replaced: x = 0 is the estimated state, prior = 0
 * where the data decide. Unknowns of strokes without usable channels, or that are only planned,
 * keep what they had.
 *  @return OK, ENOMEM, the failure of making a simulation */
stein_status fit__initial_states(fit__problem *p, stein_err *err);
/** The same for one stroke, whose samples may have changed since: x of its initial state.
 *  Overwrites b->x, b->y, except that x may be b->x. @return 1; 0: there is none, x is untouched
 */
int fit__initial_state(const fit__problem *p, fit__bench *b, int stroke, double *x);
/** Does the mechanism rest until t = 0, where it is let go? */
int fit__waits(const fit__stroke *s, const lab_audit *a);
/** chi2 per sample of a stroke from its start to `until` [s of the simulation], without weights.
 *  Overwrites b->y. @param x  [nu]  @return INFINITY when it cannot be simulated */
double fit__misfit(const fit__problem *p, fit__bench *b, int stroke, const double *x, double until);

/* ---- start_follow.c ---- */

/** What is to be followed. */
typedef struct fit__follow {
    const double *sd; /* [nch] of a sample against the model [unit] */
    double until;     /* horizon [s of the simulation] */
    double most;      /* |x| of a number that the data decide, which then costs x^2; INFINITY: any,
                         at no cost. One with a prior costs x^2 and stays within 1 in any case */
    int steps;        /* of Gauss-Newton, at most */
} fit__follow;
/** Improve x of a stroke's initial state. @param x  [nu] in and out
 *  @return objective per sample; INFINITY when it cannot be simulated */
double fit__follow_start(const fit__problem *p, fit__bench *b, int stroke, const fit__follow *how,
                         double *x);

/* ---- horizon.c ---- */

/** What becomes of a small error of a stroke's initial position. */
typedef struct fit__horizon {
    double time;   /* at which it has grown as many times as was asked for, from the start of the
                      record [s]; INFINITY: it never does, or unknown */
    double growth; /* how many times it has grown at most; 0: unknown */
} fit__horizon;
/** Of every stroke at x = 0. @param of  [nstroke] out
 *  @return OK, ENOMEM, the failure of making a simulation */
stein_status fit__horizons(const fit__problem *p, double by, fit__horizon *of, stein_err *err);

/* ---- setup.c ---- */

typedef enum {
    FIT__SENSE,    /* a channel has the other sign */
    FIT__ZERO,     /* an angle counts from elsewhere */
    FIT__UNIT,     /* deg for rad, mm for m */
    FIT__EXCHANGE, /* two columns are exchanged */
    FIT__ABSOLUTE, /* an angle of a body against the frame, not against its parent, or the reverse
                    */
    FIT__GRAVITY,  /* gravity along another axis */
    FIT__PACE,     /* the motion is faster or slower than the model's */
    FIT__NOTHING   /* none of these helps */
} fit__doubt;
/** What would let the beginning of the records follow from the equations. */
typedef struct fit__finding {
    fit__doubt doubt;
    int channel, other;   /* of the model; -1: none */
    double before, after; /* chi2 per sample with and without it */
    double pace;          /* of FIT__PACE: times as fast as the model; else 1 */
    char *text;           /* one sentence */
} fit__finding;
/** Do the records begin as the model moves? Up to four strokes are simulated for about half a swing
 * from their initial states. Where the residual is much more than wrong parameters explain, the
 * alternatives are simulated as well. Samples are changed meanwhile and put back.
 *  @param list  out, freed by fit__setup_free; best first  @return OK, ENOMEM, the failure of
 *  making a simulation */
stein_status fit__setup(fit__problem *p, fit__finding **list, int *n, stein_err *err);
void fit__setup_free(fit__finding *list, int n);

/* ---- observer.c ---- */

typedef struct fit__observer fit__observer;
fit__observer *fit__observer_make(const stein_model *model);
void fit__observer_free(fit__observer *o);
/** Forces for the interval from sample i to sample `next`, that bring the measured points nearer to
 *  the data.
 *  @param y  predictions of sample i, [nch] apart n */
stein_status fit__observe(fit__bench *b, const fit__stroke *s, int i, int next, const double *y,
                          stein_err *err);
/** The half of the interval that comes. */
void fit__observer_half(fit__observer *o, double gain, int second);
void fit__observer_force(void *ctx, double t, const double *q, const double *qd, double *Q);
void fit__observer_rest(fit__observer *o);

/* ---- many.c ---- */

/** Run one(ctx, bench, job) for all jobs on the problem's threads. @return OK or ENOMEM or the
 *  failure of making a simulation */
typedef void fit__work(void *ctx, fit__bench *bench, int job);
stein_status fit__parallel(const fit__problem *p, int jobs, fit__work *one, void *ctx,
                           stein_err *err);
/** What job simulates: fit__begin, once. @return its status; not OK: there is nothing to run */
typedef stein_status fit__ask(void *ctx, fit__bench *bench, int job);
/** What came out, when the job is over. */
typedef void fit__take(void *ctx, fit__bench *bench, int job, int failed);
/** One simulation for each job, on the problem's threads and in the lanes of each, with the bits of
 *  fit__simulate. @return as fit__parallel */
stein_status fit__many(const fit__problem *p, int jobs, fit__ask *ask, fit__take *take, void *ctx,
                       stein_err *err);

/* ---- pool.c ---- */

/** What several fits simulate their strokes in, side by side. */
typedef struct fit__pool fit__pool;
/** One of them, on a thread of its own; `pool` is for its problem, of the same model as p and with
 *  no other strokes than p has. @return as work of a lab__thread_pool */
typedef stein_status fit__piece(void *ctx, int i, fit__pool *pool, stein_err *err);
/** n fits at once on the threads and lanes of p, with the bits of one after the other.
 *  @return OK, ENOMEM, the first failure */
stein_status fit__together(const fit__problem *p, int n, fit__piece *piece, void *ctx,
                           stein_err *err);

/* ---- residuals.c ---- */

/** -2 ln p of an amount x that may be a mistake: x^2 up to 3, from there on 9 + 9 ln(x^2/9), which
 * is Student's t far out. */
double fit__long_tail(double x);
/** Weight w of the prior of an unknown at x: its derivative is that of w x^2, with w fixed. Where
 *  priors are tempered, that of a mistake is not: large misfits are what it is for. */
double fit__prior_weight(const fit__unknown *u, double x, double tempered);

/** Weighted residuals r of every stroke, [nstroke][nch*n] behind each other; missing samples 0.
 *  @param failed  out: strokes that could not be simulated
 *  @return OK, ENOMEM */
stein_status fit__residuals(const fit__problem *p, const double *x, double *r, int *failed,
                            stein_err *err);
/** Where the residuals of a stroke begin. */
size_t fit__offset(const fit__problem *p, int stroke);
/** Sum of squares and priors. */
double fit__chi2(const fit__problem *p, const double *r);
/** The same over samples less unknowns. */
double fit__chi2_dof(const fit__problem *p, const double *r);
/** Do the files state the noise of every channel? */
int fit__noise_given(const fit__problem *p);
double fit__priors(const fit__problem *p, const double *x);
/** Prediction to weighted residual, in place. */
void fit__weigh(const fit__stroke *s, double *y);
/** Noise of a stroke's channels as the residuals r have it, pooled over the strokes, in
 *  stroke->residual; stated noise stays what it is. */
void fit__estimate_noise(fit__problem *p, int stroke, const double *r);
/** Factor on variances because residuals of unstated noise are alike from sample to sample. */
double fit__inflation(const fit__problem *p, const double *r);
/** The same of residuals that are more than noise, whoever stated that. */
double fit__memory(const fit__problem *p, const double *r);
/** Bisquare weights from residuals r (of unweighted samples). @return samples below half weight */
stein_status fit__robust_weights(fit__problem *p, const double *r, stein_err *err);

/* ---- sensitivity.c ---- */

/** Derivatives of the residuals: column k of stroke s at J + fit__column(p, s, k), [nch*n], k < np
 * a free parameter, k >= np the stroke's own. */
size_t fit__column(const fit__problem *p, int stroke, int k);
size_t fit__columns(const fit__problem *p); /* doubles in all */
/** @param r  residuals at x (one-sided differences start from them)
 *  @return OK, ENOMEM, or the failure of a simulation next to x */
stein_status fit__sensitivities(const fit__problem *p, const double *x, const double *r, double *J,
                                stein_err *err);
/** The same where the columns of some unknowns are there already.
 *  @param known  [nu] of them; NULL: none */
stein_status fit__more_sensitivities(const fit__problem *p, const double *x, const double *r,
                                     const unsigned char *known, double *J, stein_err *err);
/** To order four, from the present steps and their halves, with fine integration; the steps are the
 *  halves then. @param error  out: largest relative error of a column of the halved steps */
stein_status fit__fine_sensitivities(fit__problem *p, const double *x, const double *r, double *J,
                                     double *error, stein_err *err);
/** Steps for the next differences from the change the last ones made. */
void fit__choose_steps(fit__problem *p, const double *J);

/* ---- normal.c ---- */

/** Normal equations, nuisances eliminated: arrow matrix of globals and strokes. Globals are those
 *  parameters that move: a search for a law has hundreds that stay. */
typedef struct fit__normal {
    int np, nu, nstroke;
    int n, *moving, *row; /* globals; the unknown of each; [np] which of them, -1: it stays */
    gsl_matrix *A;        /* [n x n] globals */
    gsl_matrix **B, **C;  /* per stroke: own x own, own x globals; NULL: none */
    double *g;            /* [nu] half the gradient; 0 of what stays */
    double *product;      /* [nu] workspace */
    gsl_matrix *S;        /* Schur complement, then its Cholesky factor */
    gsl_matrix **BL, **X; /* factors of B and B^-1 C at the present damping */
} fit__normal;
stein_status fit__normal_make(fit__normal *n, const fit__problem *p, stein_err *err);
void fit__normal_free(fit__normal *n);
/** Fill from J and r, priors included unless prior = 0. */
void fit__normal_fill(fit__normal *n, const fit__problem *p, const double *x, const double *r,
                      const double *J, int prior);
/** Factor with damping. @param scale  D, [nu] squares of what an unknown is measured in; NULL: none
 *  @return 0, or -1 when not positive definite */
int fit__normal_factor(fit__normal *n, const fit__problem *p, double mu, const double *scale);
/** dx [nu] = -(A + mu D)^-1 g. */
void fit__normal_step(const fit__normal *n, const fit__problem *p, double *dx);
/** Diagonal element of an unknown; NULL: it stays. */
double *fit__normal_diagonal(const fit__normal *n, const fit__problem *p, int u);
/** g at another point with the same derivatives. @param prior  weight of the priors */
void fit__normal_gradient(fit__normal *n, const fit__problem *p, const double *x, const double *r,
                          const double *J, double prior);
/** Second derivative of the residuals along dx, by a difference, r there being at x + h dx.
 *  @param there  in: residuals at x + h dx; out: d2 r(x + t dx) / dt2 */
void fit__normal_curvature(const fit__normal *n, const fit__problem *p, const double *r,
                           const double *J, const double *dx, double h, double *there);

/* ---- minimise.c ---- */

/** Exact state of a search, between two iterations. */
typedef struct fit__state {
    double *x, *step; /* [nu] */
    double *scale;    /* [nu] of the damping; zeros where a search begins */
    double mu, nu;
    double objective;
    int iteration;
    double decrement;
    int ended;
} fit__state;

typedef stein_status fit__checkpoint(void *ctx, const fit__state *state, stein_err *err);
/** Levenberg-Marquardt from the state on.
 *  @param enough  stop when the expected gain falls below enough * (1 + relative * objective)
 *  @return OK (state->ended says whether it converged), or a failure at the start itself */
stein_status fit__minimise(fit__problem *p, fit__state *state, double enough, double relative,
                           int iterations, fit__checkpoint *checkpoint, void *ctx, stein_err *err);

/** Where a descent stands: unknowns [nu], derivatives and residuals there, chi2 + priors. */
typedef struct fit__end {
    double *x, *J, *r, objective;
    int ended;   /* its minimum is found */
    int current; /* J is that of x, but for steps that gain less than what ends a fit */
    int fits;    /* how many have led here, where that is counted */
    double mu;   /* damping to begin with, in units of the priors */
} fit__end;
/** Descent from e->x with the same derivatives as long as they do what they promise: a step costs
 *  one residual, new derivatives cost one for every unknown. Parameters stay within p->limit.
 *  @param known     1: e->J holds derivatives from somewhere near; 0: they are found first
 *  @param enough    expected gain at which it has ended
 *  @param renewals  of the derivatives, at most
 *  @return OK (e->ended says whether it converged), or a failure where it begins */
stein_status fit__descend(fit__problem *p, fit__end *e, int known, double enough, int renewals,
                          stein_err *err);

/* ---- resume.c ---- */

/** The whole search: what is done and where it stands. */
typedef struct fit__search {
    int stage, nstage; /* present stage */
    fit__state state;
    double *entry; /* [nu] x at the beginning of the stage */
    int nstart;
    double *best[LAB_FIT_STARTS]; /* ends of finished starts [nu] */
    lab_fit_start start[LAB_FIT_STARTS];
    double *steps[LAB_FIT_STARTS];
} fit__search;
/** @return OK (found 1 when there is one), ESTALE, EPARSE, EIO, ENOMEM */
stein_status fit__search_load(fit__search *s, int nu, const char *path, unsigned long long key,
                              int *found, stein_err *err);
stein_status fit__search_save(const fit__search *s, int nu, const char *path,
                              unsigned long long key, stein_err *err);
/** Fingerprint of everything that decides about the search. */
unsigned long long fit__key(const fit__problem *p);

/* ---- place.c ---- */

/** The first key of a mapping of a YAML text, from 1; flow: the mapping is written in braces. */
typedef struct fit__place {
    int line, column, flow;
    int no_memory; /* 1: it was not found for want of it */
} fit__place;
/** @return 1 when there is a mapping with at least one key under the names of the path */
int fit__find_mapping(const char *text, size_t size, const char *const *path, int n,
                      fit__place *place);

/* ---- patch.c ---- */

/** One number of a mechanism file, what it shall be and its standard deviation, 0: none [SI]. */
typedef struct fit__number {
    const char *name;
    double value, sd;
} fit__number;
/** The text of a mechanism file with new numbers in the old places, freed by the caller. It is
 *  read again: the same mechanism with these numbers.
 *  @param m       the mechanism of the text
 *  @param digits  of the numbers
 *  @return OK, EPARSE, EINVAL (a number has no place in the file), ENOMEM */
stein_status fit__patch(char **out, size_t *nout, const mechanism *m, const char *text, size_t size,
                        const fit__number *number, int n, int digits, stein_err *err);

/* ---- starts.c ---- */

/** All searches; the best end goes to x. */
stein_status fit__search_run(fit__problem *p, fit__search *s, unsigned long long key, int *resumed,
                             stein_err *err);
void fit__search_free(fit__search *s);
/** Can an observer pull the simulation to these records: is a position, a place or a gap among
 * them? */
int fit__can_hold(const fit__problem *p);
stein_status fit__search_make(fit__search *s, const fit__problem *p, stein_err *err);

/* ---- intervals.c, profile.c, fit_report.c ---- */

/** Covariance, correlations, condition at x from full-accuracy sensitivities. */
stein_status fit__intervals(fit__problem *p, lab_fit *fit, const double *x, const double *r,
                            const double *J, stein_err *err);
stein_status fit__profile(fit__problem *p, lab_fit *fit, int k, const double *x, double objective,
                          stein_err *err);
stein_status fit__describe(const fit__problem *p, lab_fit *fit, const double *x, const double *r,
                           stein_err *err);

#endif
