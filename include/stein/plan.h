/* SPDX-License-Identifier: GPL-3.0-or-later
 * plan.h - the next experiment: the feasible stroke that best separates a cause from its rivals,
 * and the number of repeats. Part of libsteinlab.a.
 *
 * The cause and every rival predict an experiment, each with its fitted numbers and their
 * uncertainty. The value of the experiment is the expected odds between them
 * (src/lab/plan/expected_evidence.c).
 */
#ifndef STEIN_PLAN_H
#define STEIN_PLAN_H

#include "stein/diagnose.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { LAB_PLAN_RIVALS = 4 };

/** Shape of a driven input at t [s]; 0 before t = 0. */
double lab_shape_at(lab_shape shape, double time, double t);

/** A plan. */
typedef struct lab_plan {
    int n;
    lab_experiment *experiment; /* best first, infeasible ones last */
    int nrival, left_out;       /* rivals considered; not considered */
    double wanted;              /* odds wanted */
    int most;                   /* largest number of repeats that is counted */
    int strokes;                /* simulated */
    double seconds;
} lab_plan;

/** How to plan. Start from lab_plan_def_default(). */
typedef struct lab_plan_def {
    double wanted; /* odds, default 100 */
    int rivals;    /* at most so many, default LAB_PLAN_RIVALS */
    int quick;     /* 1: one-sided differences, half of the strokes; odds are accurate to some % */
    int threads;   /* results do not depend on it */
    /** Channels that can be measured besides the present ones; NULL: all. */
    const char *const *instrument;
    int ninstrument;
    const lab_options *options; /* for rivals that need a part; NULL: defaults */
    lab_fit_progress_fn *progress;
    lab_stop_fn *stop; /* may be NULL */
    void *ctx;
} lab_plan_def;
lab_plan_def lab_plan_def_default(void);

/** Plan the next experiment for a diagnosis with rivals; without any, n and nrival are 0. Several
 *  causes are one hypothesis, and so is a rival with the causes beside it.
 *  @param file, model  of the diagnosis
 *  @param diagnosis    of lab_diagnose, or of lab_diagnosis_read
 *  @return OK, EINVAL (no posterior; def), ESTOPPED, ENOMEM, numerical failures of the
 * cause's own model in the conditions of the diagnosis */
stein_status lab_plan_make(lab_plan **out, const char *file, const lab_model *model,
                           const lab_diagnosis *diagnosis, const lab_plan_def *def, stein_err *err);
void lab_plan_destroy(lab_plan *plan);

/** Read the input of a plan from diagnosis.json: verdict, causes and rivals with their numbers,
 *  scatter, conditions. Other fields stay empty.
 *  @param model  of the diagnosis
 *  @return OK, EIO, EPARSE (file:line: field, expected value), ENOMEM */
stein_status lab_diagnosis_read(lab_diagnosis **out, const char *path, const lab_model *model,
                                stein_err *err);

/** A stroke of an experiment as a candidate of the diagnosis predicts it, without noise, in the
 *  form of measured data: "# set", "# noise", driven inputs, channels.
 *  @param suspect  a cause or rival
 *  @return OK, EIO, ENOMEM, EINVAL, numerical failures */
stein_status lab_plan_stroke(const char *path, const lab_experiment *experiment, int suspect,
                             const char *file, const lab_model *model,
                             const lab_diagnosis *diagnosis, const lab_plan_def *def,
                             stein_err *err);
enum { LAB_PLAN_JSON, LAB_PLAN_STROKE, LAB_PLAN_RIVAL, LAB_PLAN_FILES };
/** Write the files of `stein plan -o` into a folder, which is made if missing: plan.json and, if
 * the best experiment without checks can be simulated, next_stroke.csv and next_rival.csv.
 *  @param path  [LAB_PLAN_FILES] out, each freed by the caller: written files; NULL: not written
 *  @return OK, EIO, ENOMEM, or what lab_plan_stroke returns */
stein_status lab_plan_files(const char *folder, const lab_plan *plan, const char *file,
                            const lab_model *model, const lab_diagnosis *diagnosis,
                            const lab_plan_def *def, char **path, stein_err *err);
/** The plan as JSON. @param stroke  [2] files of the best experiment; NULL: none
 *  @return OK, EIO */
stein_status lab_plan_json(const char *path, const lab_plan *plan, const lab_diagnosis *diagnosis,
                           char *const *stroke, stein_err *err);

/* ---- plan of records, before any measurement ---- */

/** Planned records. */
typedef struct lab_before_def {
    /** "[N x] TIME at RATE [with NAME=VALUE[unit], ...]", several separated by ";": number of
     * records, length [s], rate [Hz] and settings. Equal records differ by their noise alone. */
    const char *records;
    const char *const *channel; /* [nchannel] outputs that are measured */
    int nchannel;
    const char *const *noise; /* [nnoise] "NAME=VALUE[unit]": sd of one sample; else 1 mrad, 0.1 mm,
                                 of any other unit 1 % of the largest reading */
    int nnoise;
    int no_help;                /* 1: additions are not tried */
    int threads;                /* results do not depend on it */
    const lab_options *options; /* for candidates that need a part; NULL: defaults */
    lab_fit_progress_fn *progress;
    lab_stop_fn *stop; /* may be NULL */
    void *ctx;
} lab_before_def;

/** A candidate, and its detectability with these records. */
typedef struct lab_before_cause {
    lab_candidate candidate;
    double nameable; /* least amount that is named with 95 % probability [its unit]; NAN: it has no
                      * column
                      */
    int named;       /* 1: nameable is within its limit */
    char why[LAB_PLAN_TEXT]; /* why it has no column; "" */
} lab_before_cause;

/** A possible addition, and its effect. */
typedef struct lab_before_help {
    char name[LAB_PLAN_TEXT], why[LAB_PLAN_TEXT];
    double cost;              /* in records: one more record is 1, another set-up 4 */
    int named;                /* candidates that become nameable by it */
    int told;                 /* pairs that become separable by it */
    double finer;             /* ratio of nameable amounts, without over with it: geometric mean */
    char most[LAB_PLAN_TEXT]; /* the candidate that gains most, "KIND at PLACE" */
    double most_finer;        /* its ratio */
} lab_before_help;

/** Detectability of causes in planned records. */
typedef struct lab_before {
    int n;
    lab_before_cause *cause; /* [n] those with a column first */
    int ncolumn;             /* so many */
    double *
        apart; /* [ncolumn*ncolumn] least share of its limit at which cause i is separated from j */
    int records;       /* planned; every third one reports and is not fitted */
    int nhelp, ntried; /* sorted by value over cost; additions without effect are left out */
    lab_before_help *help;
    long strokes; /* simulated */
    double seconds;
} lab_before;
/** Can causes i and j be separated, each at its limit? */
int lab_before_told(const lab_before *before, int i, int j);
/** Is cause i at its least nameable amount not separated from j? (i, j < ncolumn) */
int lab_before_mistaken(const lab_before *before, int i, int j);

/** Before records are made: which causes can they separate, and from which size on? The records are
 *  simulated with the numbers of the file and with noise (of a fixed seed) in a temporary folder,
 *  and linearised as in a diagnosis (src/lab/search/linear.c).
 *  @param file, model  of the mechanism
 *  @return OK, EINVAL (def: records, channels or noise), ENAME, EIO, ESTOPPED, ENOMEM, numerical
 *  failures of the records */
stein_status lab_before_make(lab_before **out, const char *file, const lab_model *model,
                             const lab_before_def *def, stein_err *err);
void lab_before_destroy(lab_before *before);
/** As JSON. @param path  "-": standard output  @return OK, EIO */
stein_status lab_before_json(const char *path, const lab_before *before, stein_err *err);

#ifdef __cplusplus
}
#endif
#endif
