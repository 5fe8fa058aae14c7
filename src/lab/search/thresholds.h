/* SPDX-License-Identifier: GPL-3.0-or-later
 * thresholds.h - the thresholds of a diagnosis: each number that decides something, once.
 *
 * Reasons: docs/diagnosis-details.md, section Thresholds; tests/test_docs.sh compares both. Steps
 * of differences, floors of divisions, iterations of a minimiser and sizes of arrays decide
 * nothing: they stand beside their use.
 *
 * Included by: this folder, src/lab/verdict, src/lab/law, src/lab/diagnosis, src/lab/effects.
 */
#ifndef DIAG_THRESHOLDS_H
#define DIAG_THRESHOLDS_H

/* ---- evidence [-2 ln L] ---- */

static const double diag__least_gain = 25.0; /* to name a cause */
static const double diag__convincing = 9.2;  /* odds of 1 to 100 */
static const double diag__same_fit = 2.0;    /* no difference */

/* ---- probability ---- */

static const double diag__by_chance = 0.01;      /* that one of all numbers is so far off */
static const double diag__by_chance_mean = 1e-3; /* the same of a mean of what scatters */
static const double diag__beyond_doubt = 1e-4;   /* the same of one record or setting among all */

/* ---- deviations [sd] ---- */

static const double diag__interval = 1.96;     /* half of a 95 % interval */
static const double diag__one_sided = 1.645;   /* 95 % to one side */
static const double diag__beyond_chance = 3.0; /* more is no chance */
static const double diag__certain = 5.0;       /* the same of what a verdict rests on */

/* ---- residual [chi2 per sample] ---- */

static const double diag__slack = 0.05;        /* no law is exactly that of the file */
static const double diag__near_noise = 1.5;    /* it may be noise */
static const double diag__guessed = 2.25;      /* the same in an estimated noise: 1.5 noises */
static const double diag__seven_noises = 50.0; /* the mechanism errs in more than one law */

/* ---- residual, in the motion ---- */

static const double diag__followed = 0.05; /* less: the simulation follows the records */
static const double diag__no_model = 0.1;  /* more: it does not */

/* ---- share of a misfit ---- */

static const double diag__most_of = 0.5;  /* it explains most */
static const double diag__some_of = 0.25; /* more is worth another fit */
static const double diag__part_of = 0.1;  /* less is what a linear model misses */

/* ---- ratio of errors in reporting records ---- */

static const double diag__no_gain = 0.98;

/* ---- correlation of two columns ---- */

static const double diag__the_same = 0.99; /* one proposal stands for both */
static const double diag__alike = 0.95;    /* no pair; two such pairs are the same */

/* ---- end of a fit [objective] ---- */

static const double diag__fit_ends = 0.3;

/* ---- gain of the observer, of a sample ---- */

static const double diag__rung[] = {0.05, 0.012}; /* one after the other, then 0 */
enum { DIAG_RUNGS = sizeof diag__rung / sizeof *diag__rung };

/* ---- amounts and variances ---- */

static const double diag__largest = 3.0;       /* amount that is possible [limits] */
static const double diag__largest_read = 10.0; /* the same of a clock, or where noise is left */
static const double diag__most_scatter = 6.25; /* variance [of the prior] */
static const double diag__visible = 0.01;      /* change at the limit that shows [noise] */

/* ---- growth of a small change ---- */

static const double diag__grown = 10.0; /* within a window of chaotic motion */

/* ---- ratio of time scales ---- */

static const double diag__other_pace = 4.0; /* records of another mechanism */

/* ---- counts ---- */

enum {
    DIAG_WHITE = 5,         /* samples over which white residuals are correlated, at most */
    DIAG_COUNTED = 10,      /* independent samples that a record counts as, at least */
    DIAG_EACH_SIDE = 2,     /* records before and after a change */
    DIAG_HOLD_EVERY = 3,    /* one of so many records reports */
    DIAG_FEW_RECORDS = 5,   /* that determine a number; of a linear model far from them */
    DIAG_MANY_RECORDS = 16, /* the same near them */
    DIAG_TRIES = 3,         /* fits of one hypothesis; expansions without a better one */
    DIAG_FEW_FITS = 4,      /* of proposals far from the records; one after the other in vain */
    DIAG_MANY_FITS = 10,    /* of proposals near the records; expansions of a search */
    DIAG_POOL = 60          /* columns that are paired; single causes one by one */
};

/* ---- what follows from them ---- */

/* half of what a cause has to gain: a linear prediction may be wrong by that, and promises less */
static inline double diag__worth(void)
{
    return 0.5 * diag__least_gain;
}

/* so far above its minimum may a fit of the search end */
static inline double diag__unended(void)
{
    return 2.0 * diag__least_gain;
}

/* Residuals that are no noise, as chi2 per sample. Of three noises the simulation may have other
 * events than the records; of five a free fit may be lost. */
static inline double diag__three_noises(void)
{
    return diag__beyond_chance * diag__beyond_chance;
}

static inline double diag__five_noises(void)
{
    return diag__certain * diag__certain;
}

/* Growth within a record from which on its motion is chaotic. The record then has a window that
 * reports beside those that are fitted. */
static inline double diag__chaotic(void)
{
    double growth = 1.0;
    for (int i = 0; i < DIAG_HOLD_EVERY; i++) {
        growth *= diag__grown;
    }
    return growth;
}

/* share of a misfit beside which no more is left than a linear model misses */
static inline double diag__nearly_all(void)
{
    return 1.0 - diag__part_of;
}

#endif
