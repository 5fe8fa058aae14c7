/* SPDX-License-Identifier: GPL-3.0-or-later
 * plan.h - the next experiment: which feasible stroke tells a cause from its rivals best, and how
 * often it has to be repeated. Part of libsteinlab.a.
 *
 * The cause and every rival predict an experiment, each with the numbers it was fitted with and
 * what is uncertain about them. The experiment is worth what the odds between them are expected to
 * become (src/lab/plan/odds.c).
 */
#ifndef STEIN_PLAN_H
#define STEIN_PLAN_H

#include "stein/diagnose.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { LAB_PLAN_SETS = 8, LAB_PLAN_RIVALS = 4, LAB_PLAN_TEXT = 200 };

/** How an input is driven: zero + size * shape(t). */
typedef enum {
    LAB_SHAPE_NONE,
    LAB_SHAPE_RISE, /* 0 to 1 in `time`, then 1 */
    LAB_SHAPE_BACK, /* 0 to 1 in `time`, and back in the same time */
    LAB_SHAPE_SWING /* one period of a sine, 2 `time` long */
} lab_shape;
/** Shape at t [s]; 0 before t = 0. */
double lab_shape_at(lab_shape shape, double time, double t);

/** A number that the experiment sets, "# set NAME: VALUE". */
typedef struct lab_planned_set {
    char name[LAB_PLACE];
    const char *unit;
    double value; /* [SI] */
} lab_planned_set;

/** One experiment. */
typedef struct lab_experiment {
    char name[LAB_PLAN_TEXT]; /* in words */
    char why[LAB_PLAN_TEXT];  /* what has to be done or is assumed; why it is impossible */
    int nset;
    lab_planned_set set[LAB_PLAN_SETS];
    char input[LAB_PLACE]; /* driven input, "": none */
    lab_shape shape;
    double zero, size, time; /* of its signal [SI] */
    char channel[LAB_PLACE]; /* measured besides the channels so far, "": none */
    double noise;            /* of that channel, sd of one sample */
    int faster;              /* frames per frame so far */
    int feasible;            /* 0: it cannot be simulated */
    double odds;             /* expected 2 ln of the odds that one stroke gives, whoever is right */
    double odds_worst;       /* what 9 of 10 strokes exceed */
    int repeats;             /* strokes after which 9 of 10 times the odds wanted are reached; 0:
                                more than lab_plan.most */
    int against;             /* suspect of the diagnosis that is hardest to tell from the cause */
} lab_experiment;

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
    double wanted;              /* odds, default 100 */
    int threads;                /* results do not depend on it */
    const lab_options *options; /* for rivals that need a part; NULL: defaults */
    lab_fit_progress_fn *progress;
    void *ctx;
} lab_plan_def;
lab_plan_def lab_plan_def_default(void);

/** Plan the next experiment for a diagnosis with rivals.
 *  @param file, model  that were diagnosed
 *  @param diagnosis    of lab_diagnose, or of lab_diagnosis_read
 *  @return OK, EINVAL (nothing to tell apart, def), ENOMEM, numerical failures of the cause's own
 *  model in the conditions of the diagnosis */
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
/** The plan as JSON. @param stroke  [2] files of the best experiment; NULL: none
 *  @return OK, EIO */
stein_status lab_plan_json(const char *path, const lab_plan *plan, const lab_diagnosis *diagnosis,
                           char *const *stroke, stein_err *err);

#ifdef __cplusplus
}
#endif
#endif
