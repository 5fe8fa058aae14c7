/* SPDX-License-Identifier: GPL-3.0-or-later
 * plan.h - the next experiment: which feasible stroke tells a cause from its rivals best, and how
 * often it has to be repeated. Part of libsteinlab.a.
 *
 * The cause and every rival predict an experiment, each with the numbers it was fitted with and
 * what is uncertain about them. The experiment is worth what the odds between them are expected to
 * become (src/lab/plan/expected_evidence.c).
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
    int most;                   /* repeats that are still counted */
    int strokes;                /* simulated */
    double seconds;
} lab_plan;

/** How to plan. Start from lab_plan_def_default(). */
typedef struct lab_plan_def {
    double wanted; /* odds, default 100 */
    int rivals;    /* at most so many, default LAB_PLAN_RIVALS */
    int quick;     /* 1: differences to one side, half of the strokes; odds are right to some % */
    int threads;   /* results do not depend on it */
    /** Channels that there are instruments for, besides those that were measured; NULL: for all. */
    const char *const *instrument;
    int ninstrument;
    const lab_options *options; /* for rivals that need a part; NULL: defaults */
    lab_fit_progress_fn *progress;
    lab_stop_fn *stop; /* may be NULL */
    void *ctx;
} lab_plan_def;
lab_plan_def lab_plan_def_default(void);

/** Plan the next experiment for a diagnosis with rivals.
 *  @param file, model  that were diagnosed
 *  @param diagnosis    of lab_diagnose, or of lab_diagnosis_read
 *  @return OK, EINVAL (nothing to tell apart, def), ESTOPPED, ENOMEM, numerical failures of the
 * cause's own model in the conditions of the diagnosis */
stein_status lab_plan_make(lab_plan **out, const char *file, const lab_model *model,
                           const lab_diagnosis *diagnosis, const lab_plan_def *def, stein_err *err);
void lab_plan_destroy(lab_plan *plan);

/** What a plan needs of a diagnosis.json: verdict, causes and rivals with their numbers, scatter,
 *  conditions. Everything else is empty.
 *  @param model  that was diagnosed
 *  @return OK, EIO, EPARSE (file:line: field, what would be right), ENOMEM */
stein_status lab_diagnosis_read(lab_diagnosis **out, const char *path, const lab_model *model,
                                stein_err *err);

/** A stroke of an experiment as a suspect of the diagnosis predicts it, without noise, in the form
 *  of measured data: "# set", "# noise", driven inputs, channels.
 *  @param suspect  a cause or rival
 *  @return OK, EIO, ENOMEM, EINVAL, numerical failures */
stein_status lab_plan_stroke(const char *path, const lab_experiment *experiment, int suspect,
                             const char *file, const lab_model *model,
                             const lab_diagnosis *diagnosis, const lab_plan_def *def,
                             stein_err *err);
enum { LAB_PLAN_JSON, LAB_PLAN_STROKE, LAB_PLAN_RIVAL, LAB_PLAN_FILES };
/** What `stein plan -o` leaves in a folder, which is made when it is missing: plan.json, and where
 * the best experiment without checks can be simulated next_stroke.csv and next_rival.csv.
 *  @param path  [LAB_PLAN_FILES] out, each freed by the caller: what was written, NULL: not
 *  @return OK, EIO, ENOMEM, or what lab_plan_stroke returns */
stein_status lab_plan_files(const char *folder, const lab_plan *plan, const char *file,
                            const lab_model *model, const lab_diagnosis *diagnosis,
                            const lab_plan_def *def, char **path, stein_err *err);
/** The plan as JSON. @param stroke  [2] files of the best experiment; NULL: none
 *  @return OK, EIO */
stein_status lab_plan_json(const char *path, const lab_plan *plan, const lab_diagnosis *diagnosis,
                           char *const *stroke, stein_err *err);

/* ---- before anything is measured ---- */

/** Planned records, of which nothing is measured yet. */
typedef struct lab_before_def {
    /** "[N x] TIME at RATE [with NAME=VALUE[unit], ...]", several behind ";": so many records of a
     * length [s] and rate [Hz], with what they set. Equal records differ by their noise alone. */
    const char *records;
    const char *const *channel; /* [nchannel] outputs that are measured */
    int nchannel;
    const char *const *noise; /* [nnoise] "NAME=VALUE[unit]": sd of one sample; else 1 mrad, 0.1 mm,
                                 of any other unit 1 % of the largest reading */
    int nnoise;
    int no_help;                /* 1: nothing is tried besides */
    int threads;                /* results do not depend on it */
    const lab_options *options; /* for candidates that need a part; NULL: defaults */
    lab_fit_progress_fn *progress;
    lab_stop_fn *stop; /* may be NULL */
    void *ctx;
} lab_before_def;

/** A candidate, and what these records would say about it. */
typedef struct lab_before_cause {
    lab_candidate candidate;
    double nameable; /* from this amount on it is named, with 95 % [its unit]; NAN: it has no column
                      */
    int named;       /* 1: that is within its limit */
    char why[LAB_PLAN_TEXT]; /* why it has no column; "" */
} lab_before_cause;

/** Something else that could be measured or done, and what it changes. */
typedef struct lab_before_help {
    char name[LAB_PLAN_TEXT], why[LAB_PLAN_TEXT];
    double cost;  /* in records: one more is 1, to set up something else 4 */
    int named;    /* candidates that are named then and were not before */
    int told;     /* pairs that are told apart then and were not before */
    double finer; /* ratio of the amounts that are named, before over then: geometric mean */
    char most[LAB_PLAN_TEXT]; /* the candidate that gains most, "KIND at PLACE" */
    double most_finer;        /* its ratio */
} lab_before_help;

/** What the records could tell. */
typedef struct lab_before {
    int n;
    lab_before_cause *cause; /* [n] those with a column first */
    int ncolumn;             /* so many */
    double *apart; /* [ncolumn*ncolumn] from this share of its limit on cause i is told from j */
    int records;   /* that are meant; every third one reports and is not fitted */
    int nhelp, ntried; /* worth most for its cost first; what changes nothing is left out */
    lab_before_help *help;
    long strokes; /* simulated */
    double seconds;
} lab_before;
/** Can causes i and j be told apart, each at its limit? */
int lab_before_told(const lab_before *before, int i, int j);
/** Is cause i, where it is just large enough to be named, not told from j? (i, j < ncolumn) */
int lab_before_mistaken(const lab_before *before, int i, int j);

/** Which causes could records tell apart, and from which size on, before they are made? They are
 *  simulated with the numbers of the file and with noise (of a fixed seed) in a temporary folder,
 *  and linearised as a diagnosis does (src/lab/search/linear.c).
 *  @param file, model  of the mechanism
 *  @return OK, EINVAL (def: what is wrong with records, channels, noise), ENAME, EIO, ESTOPPED,
 *  ENOMEM, numerical failures of the records */
stein_status lab_before_make(lab_before **out, const char *file, const lab_model *model,
                             const lab_before_def *def, stein_err *err);
void lab_before_destroy(lab_before *before);
/** As JSON. @param path  "-": standard output  @return OK, EIO */
stein_status lab_before_json(const char *path, const lab_before *before, stein_err *err);

#ifdef __cplusplus
}
#endif
#endif
