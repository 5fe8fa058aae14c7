/* SPDX-License-Identifier: GPL-3.0-or-later
 * thresholds.h - the thresholds of a diagnosis: each number that decides something, once.
 *
 * Reasons: docs/diagnosis-details.md, section Thresholds; tests/test_docs.sh compares both. Steps
 * of differences, floors of divisions, iterations of a minimiser and sizes of arrays decide
 * nothing: they stand beside their use.
 *
 * Included by: this folder, src/lab/verdict, src/lab/law, src/lab/diagnosis.
 */
#ifndef DIAG_THRESHOLDS_H
#define DIAG_THRESHOLDS_H

/* ---- evidence [-2 ln L] ---- */

static const double diag__least_gain = 25.0; /* to name a cause */
static const double diag__convincing = 9.2;  /* odds of 1 to 100 */
static const double diag__same_fit = 2.0;    /* no difference */
static const double diag__worth = 12.0;   /* error of a linear prediction; promised: worth a fit */
static const double diag__unended = 50.0; /* that a fit of the search may end above its minimum */

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

static const double diag__slack = 0.05;          /* no law is exactly that of the file */
static const double diag__near_noise = 1.5;      /* it may be noise */
static const double diag__guessed = 2.25;        /* the same in an estimated noise: 1.5 noises */
static const double diag__three_noises = 9.0;    /* events of simulation and record differ */
static const double diag__five_noises = 25.0;    /* a free fit may be lost */
static const double diag__seven_noises = 50.0;   /* the mechanism errs in more than one law */
static const double diag__twenty_noises = 400.0; /* a free linear model says nothing */

/* ---- residual, in the motion ---- */

static const double diag__no_model = 0.2;

/* ---- share of a misfit ---- */

static const double diag__most_of = 0.5; /* it explains most */
static const double diag__nearly_all = 0.9;
static const double diag__part_of = 0.1; /* less is what a linear model misses */

/* ---- ratio of errors in reporting records ---- */

static const double diag__no_gain = 0.98;

/* ---- correlation of two columns ---- */

static const double diag__the_same = 0.99; /* one proposal stands for both */
static const double diag__alike = 0.95;    /* both at once cannot be told */

/* ---- end of a fit [objective] ---- */

static const double diag__fit_ends = 0.3;
static const double diag__refined = 0.1; /* where numbers are reported */

/* ---- gain of the observer, of a sample ---- */

static const double diag__rung[] = {0.05, 0.012}; /* one after the other, then 0 */
enum { DIAG_RUNGS = sizeof diag__rung / sizeof *diag__rung };

/* ---- amounts and variances ---- */

static const double diag__largest = 3.0;       /* amount that is possible [limits] */
static const double diag__largest_read = 10.0; /* the same of a clock, or where noise is left */
static const double diag__most_scatter = 6.25; /* variance [of the prior] */
static const double diag__visible = 0.01;      /* change at the limit that shows [noise] */

/* ---- growth of a small change ---- */

static const double diag__chaotic = 1000.0; /* within a record: its motion is chaotic */
static const double diag__grown = 10.0;     /* within a window */

/* ---- counts ---- */

enum {
    DIAG_WHITE = 5,         /* samples over which white residuals are correlated, at most */
    DIAG_EACH_SIDE = 2,     /* records before and after a change */
    DIAG_HOLD_EVERY = 3,    /* one of so many records reports */
    DIAG_SEVERAL = 5,       /* records for each number that they have to tell */
    DIAG_FEW_RECORDS = 6,   /* of a linear model that is far from the records */
    DIAG_MANY_RECORDS = 16, /* the same near them */
    DIAG_TRIES = 3,         /* fits of one hypothesis; expansions without a better one */
    DIAG_FEW_FITS = 4,      /* of proposals far from the records; one after the other in vain */
    DIAG_SOME_FITS = 6,     /* parts set aside, starts of a lost record, causes anew */
    DIAG_MANY_FITS = 10,    /* of proposals near the records; expansions of a search */
    DIAG_SINGLE_FITS = 24,  /* single causes one by one */
    DIAG_POOL = 60          /* columns that are paired */
};

#endif
