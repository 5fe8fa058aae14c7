/* SPDX-License-Identifier: GPL-3.0-or-later
 * verdict.h - from a closed table of hypotheses to a diagnosis.
 *
 *   judge.c          the rules: a pure function of numbers
 *   sentence.c       the reason in words, from the same numbers
 *   reporting.c      reporting records, predicted
 *   verify.c         extended.yaml read again, against the table
 *   explain.c        why a candidate is not the verdict
 *   detectability.c  which other candidates would have been detected
 *   records.c        record by record: what is left, the amount of a cause
 *   odd_setting.c    a setting of a reporting record that does not fit it
 *   sign_error.c     a sign that all records have wrong, as a cause
 *   results.c        numbers of causes, rivals and the file
 *   posterior.c      what is known of causes and rivals, for the next experiment
 *   motion.h         the verdict once more, from a prescribed motion and its force
 * Included by: this folder, src/lab.
 */
#ifndef DIAG_VERDICT_H
#define DIAG_VERDICT_H

#include "search.h"

/* ---- judge.c ---- */

/** What the judge reads of a row of the table: numbers of its fit. */
typedef struct diag__evidence {
    int n, cause[DIAG_CAUSES]; /* candidates */
    double objective, chi2_dof;
    double likelihood; /* the objective without the priors of its amounts */
    double relative;   /* RMS residual in that of the motion */
    double memory;     /* samples that the residual is alike over */
    int scatters_most; /* records differ by as much as is allowed for, which is not noise */
    int rough;         /* settings are off by what their digits allow */
    int converged, possible;
    double amount[DIAG_CAUSES], sd[DIAG_CAUSES]; /* [limits], sd not inflated */
    int tolerated[DIAG_CAUSES]; /* 1: a number of the file whose tolerance is stated */
    int scatters[DIAG_CAUSES];  /* 1: it differs from record to record by itself */
    int single[DIAG_CAUSES];    /* 1: it acts in one record alone */
    int named[DIAG_CAUSES];     /* 1: an effect of the table, 0: a number of the file */
    int clock[DIAG_CAUSES];     /* 1: it is the time base of the records */
    int gain[DIAG_CAUSES];      /* 1: it is the scale of a channel */
    int place[DIAG_CAUSES];     /* which element of the mechanism: equal numbers, equal elements */
} diag__evidence;

/** What holds for the whole table. */
typedef struct diag__setting {
    double most_noise;  /* chi2/dof up to which a residual is noise */
    double input;       /* RMS by which noise of measured forces moves the simulation [noise] */
    int stated;         /* the noise is */
    int records;        /* fitted */
    double freedom;     /* degrees of freedom of the scatter from record to record */
    int tolerances;     /* numbers of the file with one */
    int assumed;        /* of them the file states none of */
    int names;          /* numbers of the file that were fitted */
    const double *body; /* [names] NAN: no number of a body that was refitted since nothing fits as
                         * they are; NULL: none was */
} diag__setting;

/** Why nothing is named, or what is. */
typedef enum {
    DIAG_EXPLAINED,    /* the null hypothesis leaves noise, and no cause gains */
    DIAG_NAMED,        /* causes */
    DIAG_NO_CAUSE,     /* more than noise, and no candidate gains */
    DIAG_MOST_LEFT,    /* the best hypothesis leaves most of the misfit */
    DIAG_UNDECIDED,    /* the best hypothesis's amount may be 0 */
    DIAG_NOT_SHOWN,    /* what explains it best does not show in reporting records */
    DIAG_NOT_HELD,     /* the null hypothesis leaves noise of the fitted records alone */
    DIAG_FAR_OFF,      /* the best hypothesis is far from the records: no usable model */
    DIAG_NOT_CONVERGED /* its fit has not ended */
} diag__finding;

enum { DIAG_RIVALS = 16 };
typedef struct diag__judgement {
    diag__finding finding;
    int best, null; /* rows; the null one takes settings as the best one does */
    int least;      /* row without a cause that has the most evidence, however it takes settings */
    int nrival, rival[DIAG_RIVALS];
    int nearest;  /* row of one cause that explains half of the misfit where none is named; -1 */
    double near;  /* share of the misfit beyond noise that it explains */
    double gain;  /* objective(null) - objective(best) */
    double share; /* of the misfit beyond noise that the best one explains */
} diag__judgement;
/** The verdict of a table [n], of which one row has no cause. */
diag__judgement diag__judge(const diag__evidence *e, int n, const diag__setting *s);
/** The finding where reporting records do not show what was named. @param null  the row without a
 * cause */
diag__finding diag__not_shown(const diag__evidence *null, const diag__setting *s);
/** Does the first hypothesis, with a cause more, gain enough over the second one? */
int diag__gains(const diag__evidence *more, const diag__evidence *less, const diag__setting *s);

/* ---- reporting.c ---- */

/** Reporting records as a row predicts them: what all records share as fitted,
 *  each record's own fitted to it. */
typedef struct diag__reported {
    fit__problem p;
    lab_dataset *own; /* NULL: the file's own mechanism */
    lab_candidate cause[DIAG_CAUSES];
    double *x, *r;
    double rmse; /* in units of noise; NAN: they cannot be simulated */
} diag__reported;
/** @param data  in the file's own mechanism  @return OK, ENOMEM, a failure; free in any case */
stein_status diag__report(const diag__row *row, const lab_dataset *data, diag__reported *to,
                          stein_err *err);
void diag__reported_free(diag__reported *h);
/** Error after over error before, with its interval. @return OK, ENOMEM */
stein_status diag__compare(const diag__reported *before, const diag__reported *after, lab_gain *g,
                           stein_err *err);
/** gain and gains of a diagnosis. @param phase  of all frames of those records  @return OK, ENOMEM
 */
stein_status diag__gain(lab_diagnosis *out, const diag__reported *before,
                        const diag__reported *after, const char *const *phase, stein_err *err);

/* ---- sentence.c ---- */

/** Verdict and reason of a diagnosis; gain and numbers of candidates are known.
 *  @param near       candidate of j->nearest, "": none
 *  @param suspicion  what would let the records begin as the model moves, "": nothing */
void diag__say(lab_diagnosis *o, const diag__judgement *j, const diag__setting *s, const char *near,
               const char *suspicion);

/** What would fit a record whose setting does not: a sentence behind the reason. */
void diag__say_setting(lab_diagnosis *o, const lab_suspect *s);

/* ---- explain.c ---- */

/** Why a candidate, "KIND@PLACE", is not the verdict, or that it is.
 *  @param text  out, freed by the caller  @return OK, ENAME, ENOMEM */
stein_status diag__explain(const diag__problem *q, const diag__table *t, const diag__judgement *j,
                           const char *name, char **text, stein_err *err);

/* ---- detectability.c ---- */

/** Smallest amount that is named with 95 %, by its information beside all else; the same, for a
 *  fit without it to be excluded as a rival (diag__convincing). */
double diag__detectable(double info);
double diag__excludes(double info);
/** Detectability of a candidate with column k, by the linear model at the best row. */
lab_power diag__power(const diag__problem *q, const diag__linear *l, int k);

/* ---- records.c ---- */

/** Record by record. @param best  NULL: no cause is named  @return OK, ENOMEM */
stein_status diag__list_records(const diag__row *null, const diag__row *best,
                                const diag__reported *before, const diag__reported *after,
                                lab_diagnosis *o, stein_err *err);

/* ---- odd_setting.c ---- */

/** A setting of a record that reports, and what it would have to be off by. */
typedef struct diag__odd_setting {
    int setting; /* which one of the problem's; -1: none */
    int record;  /* of the reporting ones */
    const lab_data *data;
    double z, amount, sd; /* amount, sd [limits] */
    double left;          /* chi2 per sample with it */
} diag__odd_setting;
/** The one that is farthest off, beside the row's causes.
 *  @param in  the reporting records as the row predicts them  @return OK, ENOMEM, a failure */
stein_status diag__find_odd_setting(const diag__problem *q, const diag__row *row,
                                    const diag__reported *in, diag__odd_setting *to,
                                    stein_err *err);
/** Is it beyond doubt, and does the record with it fit as those do that were fitted?
 *  @param fitted  records; tested: settings of all reporting records */
int diag__is_odd(const diag__odd_setting *o, const diag__row *row, int fitted, int tested);
/** As a cause of the diagnosis. @return OK, ENOMEM */
stein_status diag__take_odd_setting(const diag__problem *q, const diag__odd_setting *odd,
                                    lab_diagnosis *o, stein_err *err);

/* ---- sign_error.c ---- */

/** The gain -1 of an output that all records show with the wrong sign, as the cause of a diagnosis
 *  without a fit. @return OK (also when there is none), ENOMEM, a failure of lab_candidates */
stein_status diag__name_sign_error(const lab_model *model, const lab_dataset *data,
                                   const lab_doubts *doubts, lab_diagnosis *o, stein_err *err);

/* ---- results.c ---- */

/** A candidate of which nothing is known. */
lab_suspect diag__suspect(const lab_candidate *c);

/** Candidates, refitted numbers and scatter of the diagnosis.
 *  @param l  at the best row  @return OK, ENOMEM */
stein_status diag__results(diag__problem *q, const diag__table *t, const diag__judgement *j,
                           const diag__linear *l, const diag__setting *s, lab_diagnosis *o,
                           stein_err *err);

/* ---- posterior.c ---- */

/** Name of a number of an effect in a posterior: "amount", "side" of the candidate itself (place
 * 0), "amount_2" of the first one beside it. @param index  0: amount, 1 ..: the numbers beside it
 */
void diag__number_name(char to[LAB_PLACE], int place, int index);
/** Place and index of such a name. @return 0: it is none */
int diag__find_number(const char *name, int *place, int *index);
/** Numbers of cause i of a row and of those beside it, with their joint uncertainty.
 *  @return OK, ENOMEM */
stein_status diag__posterior(const diag__row *row, int i, lab_posterior *to, stein_err *err);
/** What the records were like.
 *  @param row  whose fit has estimated the starts that the records do not state; NULL: none has
 *  @return OK, ENOMEM */
stein_status diag__conditions(const fit__problem *p, const diag__row *row, lab_conditions *to,
                              stein_err *err);
/** The next experiment. @return OK (also when none can be simulated), ENOMEM */
stein_status diag__next(const diag__problem *q, lab_diagnosis *o, stein_err *err);
void diag__posteriors_free(lab_diagnosis *o);

#endif
