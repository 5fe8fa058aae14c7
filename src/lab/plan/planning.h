/* SPDX-License-Identifier: GPL-3.0-or-later
 * planning.h - shared by the files of the plan.
 *
 *   plan.c               the whole
 *   reference.c          the strokes so far
 *   experiments.c        what could be done next
 *   predict.c            what a suspect predicts of it
 *   refit.c              how near another one comes to that
 *   expected_evidence.c  expected evidence of a stroke
 *   instrument_check.c   an instrument or a number checked by itself
 *   write_plan.c         plan.json, files of strokes
 *   read_diagnosis.c     diagnosis.json
 *
 * before anything is measured:
 *   before.c              the whole
 *   before_information.c  statements of an information matrix
 *   before_json.c         plan.json
 *   before_record.c       planned records
 * Included by: this folder, src/lab/report.
 */
#ifndef PLANNING_H
#define PLANNING_H

#include "fitting.h"
#include "stein/plan.h"

/** The hypothesis of the cause or of a rival, ready to be simulated. */
typedef struct plan__model {
    const lab_suspect *s;
    lab_candidate candidate[FIT__ACCEPTED]; /* bound to the model, second numbers as fitted: that of
                                               s, then those beside it */
    int n;
    const lab_model *model;
    lab_model *own; /* mechanism with its parts; NULL: the file's */
} plan__model;
stein_status plan__model_open(plan__model *side, const lab_suspect *s, const char *file,
                              const lab_model *model, const lab_options *options, stein_err *err);
void plan__model_close(plan__model *side);
/** Its parameters with all its candidates at their amounts, of which that of candidate `which` is
 *  `by` standard deviations off (-1: none is). @param p  [np] those without them; in, out */
void plan__model_apply(const plan__model *side, int which, double by, double *p);

/** A channel that could be measured. */
typedef struct plan__output {
    char name[LAB_PLACE];
    double noise;
    double reach; /* largest reading in the base */
    int measured; /* 1: it was */
} plan__output;

enum { PLAN_OUTPUTS = 32 };

/** Reference of the experiments. */
typedef struct plan__reference {
    const lab_diagnosis *d;
    const stein_model *m; /* of the file */
    const lab_plan_def *def;
    double *p;           /* [np] the file's numbers as the cause has them */
    lab_experiment base; /* the strokes so far, in the middle of their range */
    int noutput;
    plan__output output[PLAN_OUTPUTS];
    double *deep;              /* [ncontact] largest depth in the base [m] */
    double *low, *high, *rest; /* [nq] of every joint in the base [rad or m] */
    double *fast;              /* [nq] largest speed [rad/s or m/s] */
    double *when;              /* [nq] time of nearly all of its travel [s] */
    int strokes;               /* simulated */
} plan__reference;

/* ---- reference.c ---- */

/** Base, outputs and joints of a reference. @return OK, ENOMEM, numerical failures of the base */
stein_status plan__reference_make(plan__reference *b, const plan__model *cause,
                                  const lab_diagnosis *d, const stein_model *m,
                                  const lab_plan_def *def, stein_err *err);
void plan__reference_free(plan__reference *b);
/** Farthest way of a joint from rest in the base, with its sign [rad or m]. */
double plan__travel(const plan__reference *b, int joint);
/** Entry by name, NULL: there is none. */
const lab_used *plan__used(const lab_used *list, int n, const char *name);
/** Value of a number in an experiment, NULL: it leaves it. */
const lab_planned_set *plan__set_of(const lab_experiment *e, const char *name);
/** Set a number in an experiment. @return 0: no room for one more */
int plan__set(lab_experiment *e, const char *name, const char *unit, double value);
/** The input of an experiment at t, a stein_signal_fn. @param ctx  lab_experiment */
void plan__signal(void *ctx, double t, double u[3]);
/** To three digits. */
double plan__rounded(double value);

/* ---- experiments.c ---- */

/** All experiments that the mechanism has room for, the base first. @return OK, ENOMEM */
stein_status plan__experiments(const plan__reference *b, const plan__model *side, int nside,
                               lab_experiment **list, int *n, stein_err *err);

/** The changes of two experiments at once. @return 0: both change the same thing, or b none
 */
int plan__together(lab_experiment *to, const lab_experiment *a, const lab_experiment *b,
                   const lab_experiment *base);

/* ---- predict.c ---- */

/** A stroke without values, in one block of memory each. */
typedef struct plan__blank {
    lab_data data, *list[1];
    lab_dataset set;
    lab_column *column;
    lab_setting *setting;
    double *time, *value, *zero;
    unsigned char *present;
} plan__blank;
/** A stroke with its problem: places of its numbers, and of the numbers of the columns of P and
 * Z. */
typedef struct plan__stage {
    plan__blank stroke;
    fit__problem p;
    double *x;   /* [nu] */
    double *way; /* [np][p.np] */
    double *own; /* [nz] */
} plan__stage;
/** Prediction of a side for an experiment, in units of noise: y, and the effects of its uncertain
 *  numbers (P) and of a stroke's own ones (Z), each column for one standard deviation. */
typedef struct plan__prediction {
    int rows, noutput; /* rows of one channel; channels */
    int until;         /* rows that can be predicted */
    int np, nz;
    double *y;          /* [noutput*rows] */
    double *P;          /* [np][noutput*rows] */
    const char **name;  /* [np] uncertain numbers */
    double *D, *L;      /* [np][noutput*rows] what each does; [np][np]: P_b = sum over k L_bk D_k;
                           NULL: P is all that is known */
    double *Z;          /* [nz][noutput*rows] */
    double *time;       /* [rows] */
    plan__stage *stage; /* to simulate it with other numbers; NULL: it is straight */
} plan__prediction;
/** @param only_y  1: P and Z are left out
 *  @return OK, ENOMEM, numerical failures; plan__prediction_free in any case */
stein_status plan__predict(plan__prediction *v, plan__reference *b, const plan__model *side,
                           const lab_experiment *e, int only_y, stein_err *err);
void plan__prediction_free(plan__prediction *v);

/* ---- instrument_check.c ---- */

/** Checks of the instruments, lengths, masses and felts that a side moves, each once.
 *  @return how many */
int plan__checks(lab_check check[LAB_PLAN_CHECKS], const plan__reference *b,
                 const plan__model *side, int nside);
/** The check and the resulting statement, in words. */
void plan__check_says(const lab_check *c, char name[LAB_PLAN_TEXT], char why[LAB_PLAN_TEXT]);
/** Its instrument, in words. */
const char *plan__check_by(const lab_check *c);
/** Prediction of a side for the readings of an experiment's checks: a view of one channel that is
 *  straight, with an unknown zero of every scale. @return OK, ENOMEM; plan__prediction_free in any
 * case
 */
stein_status plan__check_prediction(plan__prediction *v, const plan__model *side,
                                    const lab_experiment *e, stein_err *err);

/* ---- refit.c ---- */

/** Prediction of a side that is fitted to the prediction of another one.
 *  @param to  [noutput*rows] y - P w - Z u with y simulated at the w, u that come nearest: the
 *             prediction at w = u = 0 as seen from there
 *  @param P   [np][noutput*rows] of v as it counts beside the noise of `of` (expected_evidence.c)
 *  @param Z   [nz][noutput*rows] that both have
 *  @return OK, ENOMEM */
stein_status plan__refit(double *to, plan__prediction *v, plan__reference *b,
                         const plan__prediction *of, const double *P, const double *Z,
                         stein_err *err);

/* ---- write_plan.c ---- */

/** One experiment of a diagnosis. */
void plan__experiment_json(lab__json *j, const char *key, const lab_experiment *e,
                           const lab_diagnosis *d);

/* ---- expected_evidence.c ---- */

/** Gram matrices of X = [y_A - y_B|A, y_A|B - y_B, P_A, Z, P_B, Z], one a channel; y_B|A: B fitted
 *  to the prediction of A. */
typedef struct plan__pair {
    int np[2], nz[2], n, noutput;
    double *K; /* [noutput][n*n] */
} plan__pair;
/** P of a as it counts beside b: the column of a number of the file is the mean of both.
 *  @param to  [np][noutput*rows] of a, 0; beside itself it is a->P */
void plan__spread(double *to, const plan__prediction *a, const plan__prediction *b);
stein_status plan__pair_make(plan__pair *pair, plan__reference *reference, plan__prediction *a,
                             plan__prediction *b, stein_err *err);
void plan__pair_free(plan__pair *pair);
/** Odds of an experiment with some channels.
 *  @param use     [noutput]
 *  @param wanted  2 ln of the odds wanted
 *  @param most    repeats at most
 *  @param rivals  there are so many, 1..LAB_PLAN_RIVALS, of which none may be left
 *  @return OK, ENOMEM */
stein_status plan__odds(const plan__pair *pair, const unsigned char *use, double wanted, int most,
                        int rivals, lab_experiment *e, stein_err *err);

/* ---- before_information.c ---- */

/** Detectability and separability of causes from their columns.
 *  @param I      [n*n] information (inverse variance) with all that is refitted projected out, in
 *                limits; of one cause's columns the best one counts
 *  @param cause  [n] which cause a column is of, 0 to ncause - 1
 *  @param nameable  [ncause] out: smallest amount that is named [limits], INFINITY: none, or it has
 *                   no column
 *  @param apart     [ncause*ncause] out: amount of i from which on it is separated from j [limits],
 *                   INFINITY: none; 0 on the diagonal */
void plan__tell(const double *I, int n, const int *cause, int ncause, double *nameable,
                double *apart);

/* ---- before_record.c ---- */

/** A planned record: an experiment, how long and how fast. */
typedef struct plan__meant {
    lab_experiment e;
    double until, rate; /* [s], [Hz] */
} plan__meant;
/** Read lab_before_def.records. @param list  out, freed by the caller
 *  @return OK, EINVAL (what is wrong), ENAME, ENOMEM */
stein_status plan__meant_read(const char *text, const stein_model *m, plan__meant **list, int *n,
                              stein_err *err);
/** One of the channels, and the noise of one sample. */
typedef struct plan__sensor {
    int channel;
    double noise; /* NAN: by its unit, or 1 % of its largest reading */
} plan__sensor;
/** Simulate a record and write it as a data file, with noise of a seed.
 *  @return OK, EIO, ENOMEM, numerical failures */
stein_status plan__meant_write(const char *path, const plan__meant *meant, const lab_model *model,
                               const plan__sensor *sensor, int nsensor, unsigned long seed,
                               stein_err *err);

#endif
