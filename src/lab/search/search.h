/* SPDX-License-Identifier: GPL-3.0-or-later
 * search.h - the search for causes: a table of hypotheses, one way into it.
 *
 *   diagnosis_problem.c   records, null hypothesis, mechanisms with parts: the same in all rows
 *   candidate_list.c      what may explain the records, numbered
 *   scope.c        causes that act in one record, or from one on
 *   row_start.c    where a fit begins
 *   evaluate.c     fits one hypothesis from one start; the only writer of rows
 *   table.c        rows by hypothesis
 *   columns.c      what every candidate changes at a row
 *   linear.c       the same, all else refitted linearly
 *   propose_*.c    proposers: which hypothesis, from which start, is worth its cost
 *   search.c       proposals in the order of their expected gain, until the budget is spent
 *   search_again.c the same under other assumptions of settings, noise and bodies
 *   simpler.c      hypotheses that no proposer makes: without an idle cause
 *   single_causes.c  likewise: every single cause
 *   bodies.c       masses, centres and inertias without a tolerance, refitted where nothing fits
 *   trace.c        one JSON line a row
 *   likelihood.c, mixed.c, shares.c   the records as a mixed model
 *
 *      problem -> [proposer -> proposal -> evaluate -> row -> table] ... -> judge (verdict/)
 *
 * A hypothesis is a set of causes. All that is known of one comes from evaluate(): proposers
 * predict by linear models, and their predictions order the work, nothing else.
 *
 * A model that lacks a cause leaves the records after the first event that comes late, and then its
 * derivatives say nothing. So at first rows are fitted and linearised while an observer holds the
 * simulation near the records (fit/observer.c). The residual is what the observer has to correct.
 * Events stay those of the records, and the correction is linear in what is missing even where that
 * is large. The observer's gain is then reduced to 0.
 * Included by: this folder, src/lab/verdict.
 */
#ifndef DIAG_SEARCH_H
#define DIAG_SEARCH_H

#include <gsl/gsl_rng.h>

#include "diagnosing.h"
#include "mixed.h"
#include "thresholds.h"

enum {
    DIAG_CAUSES = FIT__ACCEPTED,
    DIAG_CLASSES = 3,              /* scatter: joints, contacts, drive; behind these, settings */
    DIAG_FORCES = LAB_SCATTERS - 1 /* errors of measured forces */
};

/** A set of causes: candidates by number, ascending. */
typedef struct diag__hypothesis {
    int n, cause[DIAG_CAUSES];
} diag__hypothesis;

/** A mechanism with parts in it, the records bound to it. Candidates count as in the problem. */
typedef struct diag__mechanism {
    int npart, part[DIAG_CAUSES]; /* candidates whose parts it has */
    const lab_model *model;
    const lab_dataset *fitted;
    lab_candidate *candidate; /* as the problem's, bound to it; nparam 0: its part is absent */
    lab_model *own;           /* NULL: the file's own mechanism */
    lab_dataset *own_fitted;
    char *why; /* it cannot be made; NULL: it can */
} diag__mechanism;

/** What is fitted, and what may explain it. */
typedef struct diag__problem {
    const char *file;
    const lab_model *model;
    const lab_diagnose_def *def;
    lab_fit_def fit_def, rough_def; /* rough: settings are off by what their digits allow */
    double *smooth;    /* [inputs] bands of measured motions [Hz], NAN: as their noise allows */
    const char **name; /* [nname] free parameters */
    double *name_sd;   /* [nname] tolerances that are assumed, 0: the file states one, or none */
    double *body_sd;  /* [nname] the same of numbers of bodies before they were set free (bodies.c);
                       * NAN: it is none of them */
    int nname, nbody; /* nbody of them are such numbers */
    int assumed;      /* of them have an assumed tolerance */
    const lab_dataset *fitted;
    fit__problem null;        /* of the file's own mechanism without a cause */
    lab_candidate *candidate; /* [n + nsetting] the last ones: settings, each of one record alone */
    const char **untestable;  /* [n + nsetting] why no fit of these records could tell; NULL: it may
                               */
    int n, nsetting;
    int records;                 /* largest number of one */
    diag__mechanism **mechanism; /* made when they are asked for */
    int nmechanism;
    lab_force_errors forces; /* what the noise of measured forces does to the records */
    double input_share;      /* what it adds to chi2/dof */
    double input_noise; /* the same beyond the unknowns that describe it, no more than fits leave */
    int scale_free; /* noise is estimated with every fit: it is not stated, or the best hypothesis
                     * leaves more or less than was stated */
    double
        least_noise; /* variance, in that of file or audit: an audit sees what a fit takes away */
    double memory;   /* of the row that leaves least: samples that count as one, scale_free */
    double
        *step; /* [n + nsetting] amounts that columns were made with last [limits]; 0: none yet */
    struct diag__kept *kept; /* columns of the last free linear model, NULL: none (linear.c) */
    int most_scatter;        /* 1: linear models have scatter as large as a fit allows */
    long strokes;            /* simulated so far */
    long most_strokes;       /* the budget, 0: none */
    double most_seconds;     /* 0: none */
    double begin;            /* of the clock [s] */
    FILE *trace;             /* of rows, NULL: none */
} diag__problem;

struct diag__proposer; /* what makes rows: below */

/** One fit of a hypothesis. */
typedef struct diag__row {
    diag__hypothesis h;
    const diag__mechanism *in;
    lab_candidate cause[DIAG_CAUSES]; /* bound to its mechanism */
    fit__problem p;                   /* its causes act; nothing is on trial */
    double *x, *r;                    /* [nu], [rows] at the end; one block with sd and J */
    double *sd;                       /* [np] in x, scatter estimated */
    double *J;                        /* derivatives there, NULL: not kept */
    double D[LAB_SCATTERS];           /* variances of scatter, in those of the prior */
    double scale; /* of the noise in p beside that of file or audit, > 1 where it is estimated with
                   * the fit */
    double price; /* of causes whose record was chosen */
    double objective; /* -2 ln marginal likelihood (Laplace), and the price */
    double rest;      /* what of it are priors, volumes and the price */
    double chi2_dof;  /* in noise of file or audit */
    double memory;    /* samples that the residual is alike over */
    double relative;  /* RMS residual in that of the motion */
    int converged;
    char *failed; /* why it has no numbers; NULL: it has */
    const struct diag__proposer *by;
    int parent;   /* row that it was proposed from, -1: none */
    long strokes; /* simulated for it */
    double seconds;
    int rough;      /* its settings are off by what their digits allow */
    int shorter;    /* it is a second start of a proposal, from smaller amounts */
    int superseded; /* it was fitted with noise that turned out too small */
    int impossible; /* a body has an inertia that no body can have */
    double within;  /* of the objective: so near its end it is fitted (diag__refine_row); INFINITY:
                     * as the search has left it */
    int expanded;   /* proposers have seen it: 1 held near the records, 2 free */
} diag__row;

/** Columns of a linear model around a row: candidates with all else eliminated. */
typedef struct diag__linear {
    const diag__row *row;
    double gain;         /* of the observer, 0: free */
    int n, own;          /* columns; the first `own` are the row's own causes */
    int *cause;          /* [n] candidate */
    double *price;       /* [n] of its choice; NULL: none */
    double *step;        /* [n] amount that a column was made with, in limits */
    double *side;        /* [n] number beside it [quarters of its range]; NAN: its usual one */
    double *I, *s;       /* [n*n], [n]: G'PG, G'Pr with P what all else leaves */
    double square;       /* r'Pr: what is left without any column */
    double samples;      /* of the records that were used */
    const char **unseen; /* [candidates] why a candidate has no column; NULL: it has */
} diag__linear;

/** A hypothesis worth a fit, and where that begins. */
typedef struct diag__proposal {
    diag__hypothesis h;
    double amount[DIAG_CAUSES]; /* of each cause [limits]; NAN: as the parent has it */
    double side[DIAG_CAUSES];   /* first number beside it [quarters of its range]; NAN likewise */
    int parent;                 /* row whose end is the start of everything else */
    double expected;            /* objective that is expected */
    double value;               /* the same, few causes first: the order of the work */
    int rough;                  /* settings are off; or they are in the parent */
    int held;                   /* it was proposed where an observer holds: its fit begins there */
    const struct diag__proposer *by;
} diag__proposal;

/** All rows of a search. */
typedef struct diag__table {
    diag__row **row; /* in the order of evaluation */
    int n;
    diag__linear last;                   /* linear model of the row that was expanded last */
    diag__proposal aside[DIAG_FEW_FITS]; /* parts that were no first choice, see search.c */
    int naside;
} diag__table;

/* ---- problem.c ---- */

/** @param def, fitted  outlive it  @return OK, ENAME, EINVAL, ENOMEM, numerical failures at the
 *  file's own values; close it in any case */
stein_status diag__problem_open(diag__problem *q, const char *file, const lab_model *model,
                                const lab_dataset *fitted, const lab_diagnose_def *def,
                                stein_err *err);
void diag__problem_close(diag__problem *q);
/** The null hypothesis once more, after the names of what is free have changed. */
stein_status diag__problem_null(diag__problem *q, stein_err *err);
/** What the noise of measured forces does to more records: in fits to these it is unknown, too.
 *  @return OK, ENOMEM, the failure of making a problem */
stein_status diag__know_forces(diag__problem *q, const lab_dataset *records, stein_err *err);
/** The mechanism with the parts that a hypothesis needs. @return NULL: no memory (err), else with
 *  `why` where it cannot be made */
const diag__mechanism *diag__mechanism_of(diag__problem *q, const diag__hypothesis *h,
                                          stein_err *err);
/** The same records bound to another model. @return OK, or what lab_dataset_open returns */
stein_status diag__read_again(const lab_dataset *set, const lab_model *model, lab_dataset **to,
                              stein_err *err);
/** Of integration steps, as fine as the noise asks for [rad or m]. */
double diag__tolerance_of(const fit__problem *p);
/** Is the budget spent? */
int diag__is_spent(const diag__problem *q);
double diag__clock(void);
/** Are they the same effect at the same place? */
int diag__is_same(const lab_candidate *a, const lab_candidate *b);
/** Are they at one element of the mechanism, as "stop" and "stop.normal.c"? */
int diag__related(const lab_candidate *a, const lab_candidate *b);

/* ---- candidate_list.c ---- */

/** Are words to leave effects out by words of the table? @return OK, ENAME */
stein_status diag__check_without(const lab_diagnose_def *def, stein_err *err);
/** Candidates, settings, and why one cannot be told. @return OK, ENOMEM, the failure of a run */
stein_status diag__list_candidates(diag__problem *q, stein_err *err);

/* ---- scope.c ---- */

/** The candidate behind a cause, in whatever records it acts. */
const lab_candidate *diag__base(const diag__problem *q, int cause);
/** A cause as a candidate: of the file's own mechanism, or bound to another one. */
lab_candidate diag__candidate(const diag__problem *q, int cause);
lab_candidate diag__bound(const diag__problem *q, const diag__mechanism *in, int cause);
/** Does it act in a part of the records? */
int diag__is_scoped(const diag__problem *q, int cause);
/** A candidate in one record alone, from one on, by the number of the record. */
int diag__in_record(const diag__problem *q, int base, int record);
int diag__from_record(const diag__problem *q, int base, int record);
/** Do all changes of a hypothesis begin at the same record? */
int diag__is_coherent(const diag__problem *q, const diag__hypothesis *h);
/** What the choice of a record costs of -2 ln L. */
double diag__price(const diag__problem *q, int cause);

/* ---- hypotheses (table.c) ---- */

/** h with candidate k, without it. */
diag__hypothesis diag__with(diag__hypothesis h, int k);
diag__hypothesis diag__without(diag__hypothesis h, int k);
int diag__has(const diag__hypothesis *h, int k);
int diag__contains(const diag__hypothesis *whole, const diag__hypothesis *part);
int diag__equals(const diag__hypothesis *a, const diag__hypothesis *b);
/** Where cause number i of a row is among its unknowns. */
int diag__unknown_at(const diag__row *row, int i);

/* ---- row_start.c ---- */

/** The unknown u of a record of `from` as one of the same record in `to`, whose mechanism may have
 * a part more or less. @return its index, -1: it has none */
int diag__counterpart(const fit__problem *to, const fit__problem *from, int stroke,
                      const fit__unknown *u);
/** The records' own unknowns of one problem, and their steps, as those of another one of the same
 *  records. @param x, y  [nu] of `from`, out of `to` */
void diag__own_unknowns(const fit__problem *from, const double *x, const fit__problem *to,
                        double *y);
/** x and steps of a row before its fit. @param parent  NULL: the file's numbers */
void diag__start_row(diag__row *row, const diag__row *parent, const diag__proposal *from);
/** The parent's derivatives, where its motion is the start of the row's: what its columns say is
 * near enough for the first steps. @param known  [nu] out: unknowns whose columns are there */
void diag__inherit(diag__row *row, const diag__row *parent, unsigned char *known);

/* ---- simpler.c ---- */

/** Rows of a hypothesis; of those that one proposer made (NULL: any), the ones from other rows. */
int diag__tries(const diag__table *t, const diag__hypothesis *h, const struct diag__proposer *by,
                int parent);
/** Fits a proposal, and tells the trace. @param one  out: its row, NULL: no memory */
stein_status diag__try(diag__problem *q, diag__table *t, const diag__proposal *p, diag__row **one,
                       stein_err *err);
/** A row's hypothesis without each cause whose amount may be 0 or is of no possible sign. */
stein_status diag__drop_idle(diag__problem *q, diag__table *t, const diag__row *row,
                             stein_err *err);
/** A row's hypothesis with causes in all records that begin at one. */
stein_status diag__everywhere(diag__problem *q, diag__table *t, const diag__row *row,
                              stein_err *err);
/** The fit without a cause, once more from where a better end is expected.
 *  @param again  out: the row that stands for the null hypothesis now, NULL: as before */
stein_status diag__null_again(diag__problem *q, diag__table *t, diag__row **again, stein_err *err);

/* ---- single_causes.c ---- */

/** Single causes that have no row yet, while no row leaves noise. @return OK, ENOMEM */
stein_status diag__try_each(diag__problem *q, diag__table *t, stein_err *err);

/* ---- wrong_factor.c ---- */

/** Single numbers of the file that are far off, where the null row is, over the horizon of the
 *  problem. @param step  every step-th factor is tried  @return OK, ENOMEM */
stein_status diag__try_factors(diag__problem *q, diag__table *t, int step, stein_err *err);

/* ---- descend.c ---- */

/** How a fit begins: without an observer; with derivatives that are there already; while it holds
 *  with one gain after the other; without it first, and held where that ends far from the records.
 */
typedef enum { DIAG_FREE, DIAG_KNOWN, DIAG_HELD, DIAG_IF_FAR } diag__start;
/** A fit from x; its end is without an observer. @return OK, or a failure of the simulation */
stein_status diag__descend(fit__problem *p, fit__end *e, diag__start from, stein_err *err);
/** How far a fit over growing horizons follows the records [s]: the last one over which it does not
 *  end far off, 0: none; INFINITY: all of them. */
stein_status diag__follows(fit__problem *p, fit__end *e, double *until, stein_err *err);
/** What scatters from record to record stays as it is, or moves. While an observer holds, it would
 *  cost half of the derivatives and explain little. */
void diag__hold_scatter(fit__problem *p, int hold);
/** RMS of residuals r over RMS of the measured motion about its mean, both in noise. */
double diag__relative(const fit__problem *p, const double *r);
/** Samples between two corrections of the observer in these records. */
int diag__stride_of(const fit__problem *p);
/** chi2 per sample of every record, then the same in order. @param chi2  [2*nstroke] out  @return
 *  the one in the middle */
double diag__by_record(const fit__problem *p, const double *r, double *chi2);
/** The records of a problem, only the records' own unknowns fitted, the others as they are in x.
 *  @param D  variances of scatter, in those of the prior  @return OK, ENOMEM, a failure */
stein_status diag__fit_own(fit__problem *p, const double *D, int restarts, double *x, double *r,
                           stein_err *err);
/** Records that are far off while most are near: what is shared is fitted to the others, and each
 * of them is followed from its start. @param e  the end of a fit, and a better one  @return OK,
 * ENOMEM */
stein_status diag__recover(fit__problem *p, fit__end *e, double scale, stein_err *err);

/* ---- evaluate.c ---- */

/** Fits a hypothesis: into a new row of the table.
 *  @return OK (row->failed where the hypothesis cannot be simulated), ENOMEM */
stein_status diag__evaluate(diag__problem *q, diag__table *t, const diag__proposal *from,
                            diag__row **out, stein_err *err);
/** Noise of the records in p times a factor. */
void diag__scale_noise(fit__problem *p, double factor);
/** The same of a hypothesis, from the numbers of the file; 0, too, where it cannot be simulated. */
stein_status diag__reach(diag__problem *q, const diag__proposal *from, double *until,
                         stein_err *err);
/** What is left at the start of a fit, as chi2; INFINITY where it cannot be simulated. */
stein_status diag__misfit(diag__problem *q, const diag__proposal *from, double *chi2,
                          stein_err *err);
/** A row to the end of its fit, with central differences and fine steps where it is to come near.
 *  @param within  of the objective  @return OK, ENOMEM */
stein_status diag__refine_row(diag__row *row, double within, stein_err *err);
void diag__row_free(diag__row *row);

/* ---- table.c ---- */

stein_status diag__table_add(diag__table *t, diag__row *row, stein_err *err);
void diag__table_free(diag__table *t);
/** The best row of a hypothesis; NULL: it has none. */
diag__row *diag__find(const diag__table *t, const diag__hypothesis *h);
/** Objective of a row with the memory of the table. */
double diag__weighed(const diag__problem *q, const diag__row *row);
/** Objectives of the rows that count, with the memory of the one that leaves least. */
void diag__weigh(diag__problem *q, diag__table *t);
/** Number of a row, -1: none. */
int diag__index(const diag__table *t, const diag__row *row);
/** The row of least objective with n causes (n < 0: any) that is possible; NULL: there is none. */
diag__row *diag__best(const diag__problem *q, const diag__table *t, int n);
/** Amount of cause i [limits], and its standard deviation. */
double diag__amount(const diag__row *row, int i, double *sd);
/** Has its fit ended far from the records, in noises and in their motion? NULL: yes. */
int diag__is_far_off(const diag__row *row);
/** Are all amounts of a row of a possible sign and size? */
int diag__is_possible(const diag__problem *q, const diag__row *row);

/* ---- linear.c ---- */

/** @param most  records that are used at most  @return OK, ENOMEM, numerical failures; free it in
 *  any case */
stein_status diag__linearise(diag__problem *q, const diag__row *row, double gain, int most,
                             diag__linear *l, stein_err *err);
void diag__linear_free(diag__linear *l);
void diag__kept_free(struct diag__kept *k);
/** What -2 ln L of a row may fall by until it leaves noise. */
double diag__excess(const diag__row *row);
/** Fall of -2 ln L by columns `set` [n <= DIAG_CAUSES], priors of amounts included.
 *  @param amount  [n] out [limits] */
double diag__linear_gain(const diag__linear *l, const int *set, int n, double *amount);
/** Which of the free numbers is called so; -1: none. */
int diag__name_of(const diag__problem *q, const char *name);
/** Does the file state a tolerance of this number of its own mechanism, or is one assumed? */
int diag__has_tolerance(const diag__problem *q, int param);
/** Does a cause move a number with a tolerance? */
int diag__is_tolerated(const diag__problem *q, int cause);
/** Does it act like what differs from record to record by itself? */
int diag__scatters(const diag__problem *q, int cause);
/** The largest amount of a candidate [limits]. Instruments are scaled; numbers of a file are
 * mistyped, taken from the wrong end or in another unit, up to tenfold. */
double diag__most_amount(const lab_candidate *c);
/** What a large amount a of such a candidate costs less than by the normal prior of a fit: its
 * prior has long tails (fit__long_tail). @return <= 0 */
double diag__mistake(const lab_candidate *c, double amount);
/** Is the amount of a candidate of a possible sign and size? */
int diag__thinkable(const lab_candidate *c, double amount);
/** The same of cause i of a row, whose amount may be ten times as large if the row leaves noise. */
int diag__amount_is_possible(const diag__problem *q, const diag__row *row, int i);
/** Correlation of two columns. */
double diag__likeness(const diag__linear *l, int a, int b);
/** Objective of a fit that columns with these amounts and this gain let expect. */
double diag__expected(const diag__linear *l, const int *set, int n, const double *amount,
                      double gain);

/* ---- propose_*.c ---- */

/** A proposer: what makes rows. Its letter stands here alone, and only the trace shows it; the
 *  search reads the properties. */
typedef struct diag__proposer {
    char letter;
    const char *name;
    /** Proposals about a row, at most `most`, the least expected objective first (but those of
     *  drop and restart, in the order of the row's causes). NULL: its hypotheses follow from the
     *  table. @return how many */
    int (*propose)(const diag__problem *q, const diag__table *t, const diag__linear *l,
                   diag__proposal *out, int most);
    int look_alike; /* tried before all others and beside their number, at the best row, while that
                     * is no answer */
    int restarts;   /* another start of the row's own hypothesis: once from every row */
    int removes;    /* a cause less: first of all, where it loses nothing to speak of */
    int only_near;  /* tried only where little more than noise is left */
    const struct diag__proposer *parts; /* one of its proposals that is contained is tried before */
} diag__proposer;
extern const diag__proposer diag__propose_moved, diag__propose_add, diag__propose_pair,
    diag__propose_exchange, diag__propose_merge, diag__propose_drop, diag__propose_restart,
    diag__propose_twin;
/** Rows that no linear model proposes: no cause; settings off by what their digits allow; the best
 * rows once more, with estimated noise, or with the numbers of bodies free; single causes. */
extern const diag__proposer diag__step_null, diag__step_settings, diag__step_noise,
    diag__step_bodies, diag__step_longer, diag__step_single, diag__step_factor;

/* ---- search.c ---- */

/** Fills the table: rows of the null hypothesis and of whatever was worth a fit.
 *  @return OK, ENOMEM, a failure of the null hypothesis */
stein_status diag__search(diag__problem *q, diag__table *t, stein_err *err);
/** The row that stands for the verdict: of the best rows with 0, 1, 2, 3 causes the one from which
 *  on a cause more gains nothing to speak of. */
diag__row *diag__incumbent(const diag__problem *q, const diag__table *t);
/** Gain of the observer with which a row is linearised first; 0: it is near enough without. */
double diag__observer_gain(const diag__row *row);
int diag__leaves_noise(const diag__problem *q, const diag__row *row);
/** Expands rows until nothing proposed can be better. @return OK, ENOMEM */
stein_status diag__expand_all(diag__problem *q, diag__table *t, stein_err *err);
/** Largest chi2/dof of noise: stated noise is known better than estimated noise. */
double diag__most_noise(const diag__problem *q, const fit__problem *p);

/** The rows of a table that count, before others take their place. */
typedef struct diag__standing {
    int rows;
    unsigned char *superseded;
} diag__standing;
/** @return OK, ENOMEM; free kept->superseded in any case */
stein_status diag__note_standing(const diag__table *t, diag__standing *kept, stein_err *err);
/** They count again, and those since do not. */
void diag__take_back(diag__problem *q, diag__table *t, const diag__standing *kept);

/* ---- search_again.c ---- */

/** The best hypothesis of each number of causes once more, where noise, the numbers of the file or
 *  the horizon have changed; over a longer horizon the rivals of the best one, too. Rows so far no
 *  longer count. @param by  diag__step_noise, diag__step_bodies or diag__step_longer
 *  @return OK, ENOMEM */
stein_status diag__fit_again(diag__problem *q, diag__table *t, const diag__proposer *by,
                             stein_err *err);

/** If the fit without a cause has lost long swings, the search begins with their first period and
 *  a half. What it finds is fitted over a horizon three times as long, where the search goes on.
 *  The horizon grows until the records are fitted whole. A pendulum whose frequency is 1 % wrong is
 * half a period late after fifty periods; a fit to all of them at once adapts causes to that delay.
 *  Before the last horizon the noise is taken from the samples, not from the residuals: while the
 *  fit is poor, those are too large and hide what a cause explains.
 *  @return OK, ENOMEM */
stein_status diag__over_growing_horizons(diag__problem *q, diag__table *t, stein_err *err);
/** Where stated initial states are grossly wrong they are uncertain in all rows from then on.
 *  @param exact  the null row, with starts as stated  @return OK, ENOMEM */
stein_status diag__doubt_starts(diag__problem *q, diag__table *t, diag__row *exact, stein_err *err);
/** The search once more with uncertain settings, estimated noise, free numbers of bodies, each
 * where what is left asks for it. @return OK, ENOMEM */
stein_status diag__with_settings(diag__problem *q, diag__table *t, stein_err *err);
stein_status diag__with_noise(diag__problem *q, diag__table *t, stein_err *err);
stein_status diag__with_bodies(diag__problem *q, diag__table *t, stein_err *err);

/* ---- bodies.c ---- */

/** The search with the numbers of the bodies free, and the way back. */
typedef struct diag__bodies {
    int free; /* 1: it goes on with them */
    diag__standing kept;
} diag__bodies;
/** Notes whether the numbers of a row are those of bodies. @return OK, ENOMEM */
stein_status diag__bodies_exist(diag__row *row, stein_err *err);
/** Where the file states no tolerance of its bodies, the best hypotheses with these numbers free.
 *  diag__bodies_end in any case.  @return OK, ENOMEM, a failure of the null hypothesis */
stein_status diag__bodies_begin(diag__problem *q, diag__table *t, diag__bodies *b, stein_err *err);
/** @param back  1: the rows before count, those since do not */
stein_status diag__bodies_end(diag__problem *q, diag__table *t, diag__bodies *b, int back,
                              stein_err *err);

/* ---- step.c ---- */

/** Is the file's own step good enough? @param line  out: a finding, freed by the caller; NULL: it
 * is
 *  @return OK, ENOMEM */
stein_status diag__check_step(const fit__problem *p, char **line, stein_err *err);

/* ---- trace.c ---- */

/** Appends a line about a row. @return OK, EIO */
stein_status diag__trace_row(FILE *f, const diag__problem *q, const diag__table *t,
                             const diag__row *row);
/** What became of a proposal. */
typedef enum {
    DIAG_TRIED,
    DIAG_UNEXPECTED, /* it is expected to be no rival, or to gain too little for its causes */
    DIAG_NOT_NEW,    /* its hypothesis has a row, and no better end is expected */
    DIAG_OFTEN,      /* it has as many rows as one may have */
    DIAG_ELSEWHERE,  /* its proposer is not asked here: what is left is too large, or an answer */
    DIAG_BEHIND,     /* fits of this row's proposals were not what it lets expect */
    DIAG_FULL,       /* as many as are tried at a row were */
    DIAG_FOUND,      /* a row leaves noise */
    DIAG_SPENT,      /* the budget is */
    DIAG_FATES
} diag__fate;
/** The proposals of one proposer at a row, counted. */
typedef struct diag__counted {
    const diag__proposer *by;
    int n[DIAG_FATES];
} diag__counted;
/** Appends a line about the proposals at a row, [n] proposers. @return OK, EIO */
stein_status diag__trace_proposals(FILE *f, int row, int held, const diag__counted *of, int n);

/* ---- likelihood.c ---- */

/** How many records the prior of a scatter counts as, beside so many. */
double diag__scatter_worth(int records);
/** Of what scatters from record to record: its variance in D; -1: it has a prior alone. */
int diag__class_of(const fit__problem *p, const fit__unknown *u);
/** Do strokes scatter in something by as much as is allowed for? @param D  [LAB_SCATTERS] */
int diag__scatters_most(const double *D);
/** The mixed model of a problem at unknowns x, with columns of candidates [nc], each of all rows;
 *  lab__mixed_free in any case. @return OK, ENOMEM */
stein_status diag__mixed_at(lab__mixed *m, const fit__problem *p, const double *x, const double *J,
                            const double *r, const double *const *column, int nc, stein_err *err);
/** The column of unknown k < np over all rows, freed by the caller; NULL: out of memory. */
double *diag__column(const fit__problem *p, const double *J, int k);
/** -2 log likelihood at unknowns x with derivatives J and residuals r, scatter estimated: as
 *  Laplace has it, with the sum of squares that is reached.
 *  @param D   variances of scatter, out
 *  @param sd  [np] standard deviations of the free unknowns in x, out
 *  @param objective  out, may be NULL  @return OK, ENOMEM */
stein_status diag__likelihood(const fit__problem *p, const double *x, const double *J,
                              const double *r, double *D, double *sd, double *objective,
                              stein_err *err);
/** Covariance of all unknowns that all records share. */
typedef struct diag__local {
    lab__mixed m;
    int nfree, *free;   /* unknowns that are of all strokes */
    double *beta, *cov; /* [nfree], its square */
} diag__local;
/** @return OK, ENOMEM; diag__local_close in any case */
stein_status diag__local_open(diag__local *l, const fit__problem *p, const double *x,
                              const double *J, const double *r, stein_err *err);
void diag__local_close(diag__local *l);

#endif
