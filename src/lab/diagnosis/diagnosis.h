/* SPDX-License-Identifier: GPL-3.0-or-later
 * diagnosis.h - one diagnosis on its way, from records to a verdict.
 *
 *   diagnose.c   records, audit, slips, split, search
 *   windows.c    records of chaotic motion, or too few of them, cut into windows
 *   conclude.c   the closed table -> finding, causes, law, what is written
 *   held_out.c   records that report, predicted with and without the causes
 *   shown.c      where the model departs, the force it lacks, the motion check
 * Included by: this folder, src/lab/plan.
 */
#ifndef DIAG_DIAGNOSIS_H
#define DIAG_DIAGNOSIS_H

#include "curve.h"
#include "motion.h"
#include "verdict.h"

typedef struct diagnosis {
    diag__problem q;
    diag__table t;
    diag__judgement j;
    diag__setting setting;
    lab_dataset *windows;          /* the records as they are cut; NULL: they are not */
    int *record_of;                /* of each window */
    int cut;                       /* 1: the windows are used */
    int blocks;                    /* 1: every second window holds samples that report */
    lab_dataset fitted, reporting; /* of the records or windows */
    const lab_diagnose_def *def;
    diag__laws laws;
    diag__reported before, after;
    char suspicion[300]; /* what would let the records begin as the model moves; "": nothing */
    lab_diagnosis *out;
} diagnosis;

static inline void diag__progress(const diagnosis *d, double fraction, const char *step)
{
    if (d->def->progress != NULL) {
        d->def->progress(d->def->ctx, fraction, step);
    }
}

/* ---- diagnose.c ---- */

/** Does record number `record` of n, from 0, report, if nobody says which ones do? */
int diag__reports(int record, int n);

/* ---- windows.c ---- */

/** Cuts records of chaotic motion into windows, d->windows, and one or two records of which nobody
 *  says what to hold out into blocks, where the records show the positions that these begin in:
 *  d->cut.
 *  @param line  out, for free(): what was done; NULL: nothing
 *  @return OK, ENOMEM, the failure of making a simulation */
stein_status diag__cut(diagnosis *d, const lab_model *model, const lab_dataset *data, char **line,
                       stein_err *err);

/* ---- conclude.c ---- */

/** From the closed table to all that is reported. @return OK, ENOMEM, ESTOPPED */
stein_status diag__conclude(diagnosis *d, stein_err *err);

/* ---- held_out.c ---- */

/** The records that report, predicted for the first time: d->before, d->after; numerical failures
 *  leave rmse NAN. @return OK, ENOMEM */
stein_status diag__predict(diagnosis *d, stein_err *err);
/** Names the setting of a reporting record that does not fit this record, where the verdict is
 *  `explained` or a cause. @return OK, ENOMEM */
stein_status diag__name_odd_setting(diagnosis *d, stein_err *err);
/** One of several causes that reporting records do not show, and that has a row without it, is
 * none: they are predicted as well without it, or nearly so where more than noise is left.
 *  @return 1: that row stands for the verdict now */
int diag__drop_unshown(diagnosis *d);
/** Do most reporting records differ by three stated noises from a model that explains the fitted
 *  ones? @param yes  out  @return OK, ENOMEM */
stein_status diag__differ(const diagnosis *d, int *yes, stein_err *err);
/** Do the reporting records allow what is named? By no row without a cause they may be predicted
 *  better, and where it leaves more than noise they must be predicted better by it. What leaves
 * noise may be too small to show beside the records' own unknowns. @param yes  out  @return OK,
 * ENOMEM */
stein_status diag__is_shown(const diagnosis *d, int *yes, stein_err *err);

/* ---- shown.c ---- */

/** Is what is written what was found? A difference is an error of ours, and said so. @return OK,
 *  ENOMEM */
stein_status diag__verify_written(diagnosis *d, stein_err *err);
/** Departures, traces, the force that the model lacks, the motion check. @return OK, ENOMEM */
stein_status diag__show_all(diagnosis *d, stein_err *err);

#endif
