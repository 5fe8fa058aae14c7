/* SPDX-License-Identifier: GPL-3.0-or-later
 * searching.h - what the search for a cause shares. Not installed.
 *
 *   diagnose.c    the whole: null fit, suspects, refits, held-out strokes, verdict
 *   step.c        is the file's own step good enough
 *   listing.c     candidates of the mechanism as it stands
 *   testable.c    which of them no fit of these strokes could tell
 *   suspects.c    what each of the others would change
 *   pursue.c      the null fit, along the strokes
 *   likelihood.c  the strokes of a problem as a mixed model
 *   rank.c        which of them the residual looks like, with the strokes' scatter taken out
 *   early.c       the same where the strokes begin, or where numbers are believed
 *   race.c        who explains how the strokes begin
 *   refine.c      the best suspects fitted in full
 *   contest.c     what could stand in the leader's place
 *   anew.c        the same from other starts
 *   order.c       in the order of what they have reached
 *   strays.c      single strokes that a fit has lost
 *   singles.c     strokes that are fitted one by one
 *   parts.c       how much of a part could stand in a leader's place
 *   power.c       which of the others could have been seen
 *   settle.c      the numbers of a cause, from what of its strokes can be predicted
 *   posterior.c   what is known of causes and rivals, for the next experiment
 *   heldout.c     error on strokes that nothing was fitted to
 *   several.c     one cause after the other, and whether each is needed
 *   stage.c       a further search, with the causes so far in the model
 *   along.c       two causes, in the order in which the strokes show them
 *   restart.c     the same with another one to begin with
 *   motion.h      the verdict once more, from a prescribed motion and its force
 *   verdict.c     from numbers to one of seven words
 *   note.c        the numbers that a diagnosis tells
 *   curve.c       the law of an effect that is in no table
 */
#ifndef SEARCHING_H
#define SEARCHING_H

#include <gsl/gsl_rng.h>

#include "diagnosing.h"
#include "mixed.h"

/** A candidate with what is needed to try it. */
typedef struct diag__suspect {
    lab_suspect s;
    lab_model *model;                  /* extended mechanism; NULL: the one diagnosed */
    lab_dataset *fit_data, *held_data; /* the strokes in it */
    fit__problem *fit;                 /* of the extended mechanism; NULL: the base's */
    lab_candidate *beside;             /* the accepted causes in it; NULL: of no part */
    const char *never;                 /* the data cannot show it, because ... */
    const char *unseen;                /* G says nothing, because ...; NULL: it does */
    double step;                       /* amount that G was made with, in limits */
    int scanned;                       /* and that of many which the residual asks for most */
    double *G;     /* change of all weighted residuals per limit; NULL: nothing to see */
    double *small; /* the same of a part with a smaller amount; where strokes begin of a number with
                    * one of the other sign; NULL: there is none */
    double small_step;
    double *x, *J, *r;      /* of a refit, one block; NULL before */
    double objective;       /* -2 log likelihood of the refit, scatter taken out */
    double promised;        /* the same where its derivatives lead to */
    double left;            /* chi2 + priors of the refit */
    double D[LAB_SCATTERS]; /* variances of scatter in prior variances */
    double *sd;             /* [np] of the free unknowns, in x */
    int promising;          /* its linear gain is a share of the best one */
    double alike;           /* that gain; 0 when it would need an amount below 0 */
    int ended;              /* the refit has */
    double tried;           /* objective that another start has led to; INFINITY: nowhere */
    double stuck;           /* objective from which new derivatives brought nothing; INFINITY */
    double unheeded;        /* and from which strays were called back in vain */
    int unknown_J;          /* derivatives of a refit are to be taken first */
    int begun;              /* it was fitted from the file's own numbers, too */
    double
        early; /* amount with which it leads where the strokes begin, in limits; NAN: it does not */
    double *early_G;   /* G where the strokes begin; NULL: it does not lead there */
    double early_left; /* what it left in their race; 0: there was none */
    double *led;       /* unknowns where it has ended in their race; NULL: it is not among the first
                        * there, of which each is of another element */
    double *begins;  /* unknowns with which it explains how the strokes begin, alone or as the first
                      * of two (along.c); NULL: others do as well, or nobody */
    double swap;     /* predicted objective in the leader's place */
    double near;     /* the same, when a fit from there has been made, too */
    double *start;   /* and unknowns */
    double *settled; /* [nu + np + columns of J] x, sd and J of settle.c; NULL: it was not asked */
    double settled_D[LAB_SCATTERS];
} diag__suspect;

/** Where a fit along the strokes stops on its way, in shares of the longest one (diag__horizon). */
enum { DIAG_HORIZONS = 7 };
/** chi2 + priors at each of them, before and after strays are called back; 0: it did not stop there
 */
typedef struct diag__marks {
    double at[DIAG_HORIZONS][2];
} diag__marks;

/** Where a null fit up to a horizon has ended that leaves more than noise. */
typedef struct diag__early {
    double *x;                 /* NULL: it was not looked for */
    double *J;                 /* derivatives there; NULL: nobody leads */
    double horizon, objective; /* [s], chi2 + priors */
    double samples, z;         /* up to there; chi2 in sd from noise, 0: there is none */
    double left; /* what the best suspect leaves there, after a race; 0: there was none */
} diag__early;

enum { DIAG_CLASSES = 3 }; /* kinds of scatter: joints, contacts, drive */

typedef struct diag {
    const char *file;
    const lab_model *model;
    const lab_diagnose_def *def;
    lab_fit_def fit_def;
    const char **name; /* free parameters */
    int nname;
    const lab_dataset *fit_data, *held_data;
    lab_model *own_model; /* these three where they are nobody else's; NULL: they are */
    lab_dataset *own_fit, *own_held;
    lab_candidate accepted[FIT__ACCEPTED]; /* causes that earlier searches have found: they act */
    int naccepted;
    const char *only; /* place of all candidates of further searches, which are light ones then: a
                       * law explains all there already; NULL: anywhere */
    fit__problem p;
    double *x, *J, *r;      /* null fit: nothing hidden */
    diag__marks null_marks; /* of the first search's */
    diag__early early;
    int ended;  /* it found its minimum */
    double *sd; /* [np] of the free unknowns, in x */
    double null_objective, null_D[LAB_SCATTERS];
    diag__suspect *suspect;
    int n;
    double p_value, z_by_chance; /* of the best score; score with a p_value of 0.01 */
    int anew;                    /* fits of suspects from the file's own numbers */
    struct diag__curves *curves; /* of an unknown effect; NULL: none */
    int laws_tried;
    const lab_candidate *known; /* who led in an earlier search of the same; NULL: there was none */
    const double *known_x;      /* and where that has ended */
    int hasty;   /* 1: what refits cost most for waits where more is left (several.c) */
    int raced;   /* 1: races have been run, or nobody had to (refine.c) */
    int put_off; /* 1: what costs most waits for the laws, or for other causes (refine.c) */
    lab_diagnosis *out;
} diag;

/* ---- diagnose.c ---- */

/** p for d->model, fit_data, fit_def and accepted, with room for x (0), J, r and sd.
 *  @return OK, or what fit__problem_make_with returns */
stein_status diag__open_problem(diag *d, stein_err *err);
/** From where the model stands: what every suspect would change, ranks, refits. */
stein_status diag__search(diag *d, stein_err *err);
/** A line for the findings of the audit, which takes it over. @return OK, ENOMEM (line NULL, too)
 */
stein_status diag__add_finding(diag *d, char *line, stein_err *err);
/** The same of all strokes: it is told at once, and stands before those of single files. */
stein_status diag__tell(diag *d, char *line, stein_err *err);
/** What a search owns. */
void diag__close(diag *d);

/* ---- step.c ---- */

/** A finding where the file's own step is too coarse for the strokes. @return OK, ENOMEM */
stein_status diag__check_step(diag *d, stein_err *err);

/* ---- listing.c ---- */

/** Do the words of what is to be left out mean anything in the table? @return OK, ENAME */
stein_status diag__check_without(const diag *d, stein_err *err);
/** The candidates of a search, d->n of them, freed by the caller. @return as lab_candidates */
stein_status diag__list(diag *d, lab_candidate **list, stein_err *err);

/* ---- testable.c ---- */

/** Why these strokes say nothing of a candidate, NULL: they may. */
const char *diag__untestable(const diag *d, const lab_candidate *c);

/* ---- suspects.c ---- */

/** All candidates; `why` of those that the data cannot show. */
stein_status diag__suspects(diag *d, stein_err *err);
/** G of all others at the present point (x, r) and horizon. */
stein_status diag__changes(diag *d, stein_err *err);
/** fit__begin of one stroke with an amount of a suspect, the numbers beside it where they begin,
 * all other unknowns at x. For threads: problem is not changed. @param y  its prediction, out */
stein_status diag__begin_with(const fit__problem *problem, fit__bench *bench,
                              const diag__suspect *s, const double *x, double amount, int stroke,
                              double *y);
/** The number of the fit (< nname) that a suspect moves as well, -1: none. */
int diag__number_of(const diag *d, const diag__suspect *s);
/** The small secant of a part becomes G, and G the small one. */
void diag__swap_secants(diag__suspect *s);
void diag__suspects_free(diag *d);
/** The same files bound to another model, which counts parameters and channels differently.
 *  @return OK, or what lab_dataset_open returns */
stein_status diag__read_again(const lab_dataset *set, const lab_model *model, lab_dataset **to,
                              stein_err *err);
/** Of integration steps where numbers are reported, and of a search for little that is missing
 *  [rad or m]. */
extern const double diag__tolerance;
/** The problem in which a suspect is simulated. */
fit__problem *diag__problem(diag *d, const diag__suspect *s);

/* ---- pursue.c ---- */

extern const double diag__horizon[DIAG_HORIZONS];

/** Time of the last sample of the longest stroke [s]. */
double diag__longest(const fit__problem *p);
/** Samples up to the problem's horizon. */
double diag__samples(const fit__problem *p);
/** Sum of squares of residuals r up to a horizon [s]. */
double diag__chi2_to(const fit__problem *p, const double *r, double horizon);
/** Is that chi2 clearly more than noise, in size and beyond chance? @param dof  or samples */
int diag__is_clear(double chi2, double dof);
/** What a fit along the strokes is held against on its way. */
typedef struct diag__pursuit {
    const double *most;      /* [DIAG_HORIZONS] of the objective there; NULL: no bound */
    const diag__marks *null; /* of the null fit; NULL: none */
    diag__marks *reached;    /* out; NULL: not wanted */
    int to_noise;            /* 1: lost where it clearly leaves more than noise */
    double first;            /* horizon to begin with [s]; 0: as far as it predicts */
    int given_up;            /* out: it was lost before its end */
} diag__pursuit;
/** What a fit may leave at each horizon and still end as low as another one, whose residuals r
 * leave `left` with its priors: what that has left there, and all that is more than noise of its
 * rest.
 *  @param most  [DIAG_HORIZONS] out */
void diag__ahead(const fit__problem *p, const double *r, double left, double *most);
/** A fit from e->x over growing horizons up to p->horizon, which is INFINITY then, with whatever
 *  effect the problem has on trial; strays are called back on the way.
 *  @param c  NULL: it is never given up */
stein_status diag__follow(diag *d, fit__problem *p, fit__end *e, diag__pursuit *c, stein_err *err);
/** The null fit over growing horizons: x, J, r, ended. */
stein_status diag__pursue(diag *d, stein_err *err);
/** On from there, after the steps of the integration have become others. */
stein_status diag__pursue_on(diag *d, stein_err *err);
/** Once more from where a leader has ended, without it: if that leads lower it is the null fit, and
 *  all gains are less. A null fit that is stuck makes a cause of whatever frees it.
 *  @return OK (also when it fails), ENOMEM */
stein_status diag__pursue_again(diag *d, const diag__suspect *leader, stein_err *err);

/* ---- likelihood.c ---- */

/** Do strokes scatter in something by as much as is allowed for? @param D  [LAB_SCATTERS] */
int diag__scatters_most(const double *D);
/** The mixed model of a problem at unknowns x, with columns of candidates [nc], each of all rows;
 *  lab__mixed_free in any case. @return OK, ENOMEM */
stein_status diag__mixed_at(lab__mixed *m, const fit__problem *p, const double *x, const double *J,
                            const double *r, const double *const *column, int nc, stein_err *err);
/** The column of unknown k < np over all rows, freed by the caller; NULL: out of memory. */
double *diag__column(const fit__problem *p, const double *J, int k);
/** -2 log likelihood at unknowns x with derivatives J and residuals r, scatter estimated: as
 *  Laplace has it, with the sum of squares that is reached, not what derivatives promise beyond.
 *  @param D   variances of scatter, out
 *  @param sd  [np] standard deviations of the free unknowns in x, out
 *  @param objective, promised  out: it, and what derivatives promise; NULL: not wanted
 *  @return OK, ENOMEM */
stein_status diag__likelihood(const fit__problem *p, const double *x, const double *J,
                              const double *r, double *D, double *sd, double *objective,
                              double *promised, stein_err *err);
/** The mixed model around x with the numbers of the effect on trial among its columns. */
typedef struct diag__local {
    lab__mixed m;
    int n, with[FIT__NUMBERS], unknown[FIT__NUMBERS]; /* those numbers */
    double *column[FIT__NUMBERS];
    int nfree, *free;   /* the other unknowns that are of all strokes */
    double *beta, *cov; /* [nfree + n], its square */
} diag__local;
/** @return OK, ENOMEM; diag__local_close in any case */
stein_status diag__local_open(diag__local *l, const fit__problem *p, const double *x,
                              const double *J, const double *r, stein_err *err);
void diag__local_close(diag__local *l);
/** The unknown of number i of beta. */
int diag__unknown_of(const diag__local *l, int i);
/** Standard deviations of the unknowns of all strokes, sd [np]; l is solved. */
void diag__deviations(const diag__local *l, const fit__problem *p, double *sd);
/** Sum of squares at x with residuals r, all priors included, at the present variances. */
double diag__squares(const diag__local *l, const fit__problem *p, const double *x, const double *r);
/** Somewhere near x, as the linear posterior has it: `to` [nu] is eps times as far from x as a draw
 *  from it. l is solved. @return OK, ENOMEM, EINVAL: there is no such thing */
stein_status diag__draw(const diag__local *l, const fit__problem *p, double eps, gsl_rng *rng,
                        const double *x, double *to, stein_err *err);
/** Unknowns x [nu] at beta, the numbers `with` of an effect among it, and the expected differences
 *  of the strokes that go with it; what is idle stays. */
void diag__linear_end(const fit__problem *p, const lab__mixed *m, const int *with, int nwith,
                      const double *beta, double *x);

/* ---- rank.c ---- */

/** Scores of all suspects at the null fit: s.score, s.amount, s.possible; sorted. */
stein_status diag__rank(diag *d, stein_err *err);
/** Scores of all suspects in the place of the leader, at its end: swap and start.
 *  diag__changes was called there. */
stein_status diag__in_place(diag *d, diag__suspect *leader, stein_err *err);

/* ---- settle.c ---- */

/** The numbers of a suspect once more, from what of its strokes can be predicted. J holds central
 *  derivatives at x. All else of the suspect stays where its search has ended.
 *  @return OK (also when it stays there), ENOMEM */
stein_status diag__settle(diag *d, diag__suspect *s, stein_err *err);
/** What is told about a suspect: where it has settled, else where its search has ended. */
typedef struct diag__numbers {
    const double *x, *sd, *J, *D;
} diag__numbers;
diag__numbers diag__numbers_of(const diag *d, const diag__suspect *s);

/* ---- power.c ---- */

/** Could it have been seen? s.power of all suspects of a search; the verdict is known.
 *  @param led  1: its best suspect is a cause  @return OK, ENOMEM */
stein_status diag__power(diag *d, int led, stein_err *err);
/** That of a cause with its amount and the standard deviation; wide: factor that its variance has.
 */
void diag__present(const diag *d, lab_suspect *cause, double sd, double wide);

/* ---- refine.c ---- */

/** Full fits of the best suspects; the best first. What costs most is put off (d->put_off) where no
 *  single suspect explains the strokes: it is not needed if a law explains all, or two causes do.
 * In a hasty search the races are put off, too. */
stein_status diag__refit(diag *d, stein_err *err);
/** What has been put off. */
stein_status diag__refit_on(diag *d, stein_err *err);
/** A hasty search where one led in an earlier one of the same: what could stand in its place, where
 * it leaves but noise. @param found  0: it leaves more, or nobody is known */
stein_status diag__refit_known(diag *d, int *found, stein_err *err);
/** What could stand in the place of one that describes the strokes.
 *  @param s  ranked, with room, and s->x where it does */
stein_status diag__refit_from(diag *d, diag__suspect *s, stein_err *err);

/* ---- contest.c ---- */

/** Is but noise left to the leader, or to the null fit? */
int diag__leaves_noise(const diag *d);
/** What could stand in the leader's place, until nobody else leads. @return OK, ENOMEM */
stein_status diag__contest(diag *d, stein_err *err);
/** A gain that may be that of a null fit which is stuck is asked again from the leader's end.
 *  @return OK, ENOMEM */
stein_status diag__doubt(diag *d, stein_err *err);
/** Fits along the strokes of those at the place of suspect k that had none, the first ones; the
 *  order stays. @return OK, ENOMEM */
stein_status diag__hear_place(diag *d, int k, stein_err *err);

/* ---- order.c ---- */

/** Those that were fitted first, the best before all; an amount that is not physical has reached
 *  nothing. */
void diag__sort(diag *d);
/** Are they the same effect at the same place? */
int diag__is_same(const lab_candidate *a, const lab_candidate *b);
/** Are they places of one element of the mechanism, as "stop" and "stop.normal.c"? */
int diag__one_element(const char *a, const char *b);
/** The same of two candidates. */
int diag__related(const lab_candidate *a, const lab_candidate *b);

/* ---- parts.c ---- */

/** All parts tried in the leader's place, at its end: swap, what is left of the misfit of a few
 *  strokes at the best amount, and start; swap INFINITY of parts that leave most of it, and of all
 *  else. @return OK, ENOMEM */
stein_status diag__scan_parts(diag *d, const diag__suspect *leader, stein_err *err);

/* ---- refine.c, for contest.c and anew.c ---- */

/** Numbers in the block of x, r, J and sd of a refit. */
size_t diag__room_of(const fit__problem *p);
/** That block, if there is none yet. @return OK, ENOMEM */
stein_status diag__make_room(diag *d, diag__suspect *s, stein_err *err);
/** An amount at which it can be simulated [limits]: parts have no 0, and what was scanned does
 *  nothing there. */
double diag__least_amount(const diag__suspect *s);
/** Derivatives [fit__columns] of a base, J, with the suspect's own column G. */
void diag__borrow(const fit__problem *p, const double *J, const double *G, double *to);
/** Is it still open how far the fit of a suspect leads? */
int diag__is_open(const diag__suspect *s);
/** The fit of a suspect, from s->x with s->J. */
stein_status diag__fit_on(diag *d, diag__suspect *s, int renewals, stein_err *err);
/** The same; numerical failures are the suspect's misfortune. @return OK, ENOMEM */
stein_status diag__attempt(diag *d, diag__suspect *s, int renewals, stein_err *err);

/* ---- anew.c: all of these keep what is better, and return OK or ENOMEM ---- */

extern const double diag__worth_anew;   /* gain: worth a fit from another start */
extern const double diag__worth_starts; /* of the best gain: worth more than one */

/** Another start of a suspect's fit: s->x, and s->J or unknown_J. `found` 0: there is none. */
typedef stein_status diag__start(diag *d, diag__suspect *s, const void *ctx, int *found,
                                 stein_err *err);
/** A fit from there. */
stein_status diag__again(diag *d, diag__suspect *s, diag__start *start, const void *ctx,
                         stein_err *err);
/** From the file's own numbers and an amount [limits] along the strokes, then to the end. */
stein_status diag__from_the_file(diag *d, diag__suspect *s, double amount, stein_err *err);
/** From where it alone explains how the strokes begin (s->begins) to their end, whatever that
 * leaves and whatever it had. */
stein_status diag__from_the_begin(diag *d, diag__suspect *s, stein_err *err);
/** Until the fit has ended or new derivatives bring nothing any more; not again from where they
 *  have brought nothing. */
stein_status diag__to_the_end(diag *d, diag__suspect *s, stein_err *err);
/** Without the strays of where it is, and once more when that has brought something; not again from
 *  where it has brought nothing. */
stein_status diag__recall(diag *d, diag__suspect *s, stein_err *err);
/** From the file's own numbers and other amounts, until one of the starts leads to noise. */
stein_status diag__begin_anew(diag *d, diag__suspect *s, stein_err *err);
/** From where it ended with the first number beside its amount a quarter of its range more, and
 *  less: a dip from which on something acts is seen in nothing but what lies behind it, and a fit
 *  ends near where it began. */
stein_status diag__from_beside(diag *d, diag__suspect *s, stein_err *err);
/** Those that lead early along the strokes, until one leaves but noise: from where their race has
 *  ended, or
 *  @param relatives  1: from the file's own numbers, and then those at its place, too */
stein_status diag__early_ones(diag *d, int relatives, stein_err *err);
/** Does it leave more than noise and gain enough to be worth a search, or have strokes of it
 *  numbers that nobody believes? */
int diag__leaves_more(diag *d, const diag__suspect *s);

/* ---- early.c ---- */

/** The suspects that lead where the strokes begin: is_early, early. All else of the search stays
 * but scores and G, which are to be made anew. @return OK (also when no fit can be made), ENOMEM */
stein_status diag__look_early(diag *d, stein_err *err);
/** The same where the numbers of the file stay within their tolerances. */
stein_status diag__look_believing(diag *d, stein_err *err);
/** On along the strokes from where a search stands, d->x, that has explained them up to some
 * horizon [s], to the first one from there on at which it clearly leaves more than noise: early. x,
 * J and r are lost.
 *  @return OK (early.z is 0 where there is none), ENOMEM, a numerical failure */
stein_status diag__go_on(diag *d, double horizon, stein_err *err);
/** The suspects that lead there. @return as of diag__look_early */
stein_status diag__look_there(diag *d, stein_err *err);

/* ---- race.c ---- */

enum { DIAG_RACE = 64 }; /* suspects */
/** Those that lead early are fitted up to that horizon: where the ones have ended that explain most
 *  of what is left there is their start, and the others are early no more. @return OK, ENOMEM */
stein_status diag__race(diag *d, stein_err *err);
/** Has the race shown that no single suspect explains how the strokes begin? */
int diag__is_beyond_one(const diag *d);

/* ---- strays.c ---- */

/** chi2 per sample of the stroke in the middle. @param r  of all strokes; room [nstroke] */
double diag__middle(const fit__problem *p, const double *r, double *room);
/** chi2 if the worst strokes, as many as may be strays, came back and left no more than the others
 *  do. @param room  [nstroke] */
double diag__come_back(const fit__problem *p, const double *r, double *room);
/** Is a stroke further from its data than the one in the middle, and not by chance? */
int diag__is_stray(const fit__problem *p, const double *r, int stroke, double middle);
/** Is that more than noise for a stroke in the middle? */
int diag__is_far(double middle);
/** Are there some strokes, a third at most, with numbers of their own that nobody believes? */
int diag__has_bent(const fit__problem *p, const double *x);
/** Who fits the strokes that are not lost. */
typedef struct diag__fitter {
    diag *d;
    fit__problem *p; /* with the effect that is on trial in it */
    const double *D; /* variances that p's scatter is in, in those of the prior; NULL: those */
    /* from e->x to an end, strays weigh nothing; NULL: least squares */
    stein_status (*fit)(void *ctx, fit__end *e, stein_err *err);
    void *ctx;
} diag__fitter;
/** Single strokes that a fit has lost: the others fitted without them, and their own numbers anew.
 *  x is a start for a fit of all then; J and r are not those of x.
 *  @param e      where its fit has ended
 *  @param bent_too  also those with numbers that nobody believes
 *  @param found  how many; 0: x, J and r are as they were
 *  @return OK, ENOMEM, a numerical failure (x, J, r are lost) */
stein_status diag__recall_by(const diag__fitter *f, fit__end *e, int bent_too, int *found,
                             stein_err *err);
/** The same by least squares. */
stein_status diag__recall_strays(diag *d, fit__problem *p, fit__end *e, int bent_too, int *found,
                                 stein_err *err);

/* ---- singles.c ---- */

/** A problem of some strokes in which only their own unknowns move.
 *  @param like    one of the same mechanism and accepted causes
 *  @param effect  on trial, NULL: none
 *  @param D       variances of what differs from stroke to stroke, in those of the prior
 *  @return OK, ENOMEM, a failure; free it in any case */
stein_status diag__own_problem(diag *d, const fit__problem *like, const lab_dataset *data,
                               const lab_candidate *effect, const double *D, fit__problem *p,
                               stein_err *err);
/** Strokes that are fitted one by one, what they share as it is. */
typedef struct diag__singles {
    diag *d;
    const fit__problem *p; /* of all strokes, with the effect that is on trial in it */
    const double *D;       /* as of diag__own_problem */
    double *x, *r;         /* of all strokes: in, and where the fits have ended */
    double middle;         /* chi2 per sample of the stroke that strays are measured by; NAN: the
                              one in the middle */
    int fits;              /* out: how many were made */
} diag__singles;
/** The own unknowns of the marked strokes (NULL: of all) from 0 along their course up to the
 *  problem's horizon, and those of strays from other starts, too. @return OK, ENOMEM, a failure */
stein_status diag__fit_singles(diag__singles *s, const unsigned char *marked, stein_err *err);
/** -2 log likelihood of each stroke at x, what is its own marginalised. @return OK, ENOMEM */
stein_status diag__deviance(const diag__singles *s, double *each, stein_err *err);

/* ---- heldout.c ---- */

/** Held-out strokes as a model predicts them, each with its own unknowns fitted. */
typedef struct diag__held {
    fit__problem p;
    double *x, *r;    /* unknowns, weighted residuals */
    double rmse;      /* in units of noise */
    double *deviance; /* [nstroke] -2 log likelihood, what is a stroke's own marginalised */
    double *lost;     /* [nstroke] 1: it is lost while the others are at their noise */
} diag__held;
/** @param s  NULL: nothing found  @return OK, ENOMEM, a numerical failure; free in any case */
stein_status diag__held_out(diag *d, const diag__suspect *s, diag__held *to, stein_err *err);
/** Sums of squared residuals of two models on the same strokes, but those that the second one has
 *  lost; NAN: one of them has none.
 *  @param likely  1: of deviances instead */
void diag__compare(const diag__held *without, const diag__held *with, int likely, double *before,
                   double *after);
void diag__held_free(diag__held *h);
/** Error with a cause over that without it: own_ratio, own_lo, own_hi. NAN without strokes.
 *  @return OK, ENOMEM */
stein_status diag__ratio(const diag__held *without, const diag__held *with, lab_suspect *cause,
                         stein_err *err);
/** gain and gains of a diagnosis. @param phase  of all held-out frames */
stein_status diag__gain(lab_diagnosis *out, const diag__held *before, const diag__held *after,
                        const char *const *phase, stein_err *err);

/* ---- several.c ---- */

/** What held-out strokes are asked about a cause. */
typedef enum diag__asked {
    DIAG_ERROR,      /* is their error smaller with it? */
    DIAG_LIKELIHOOD, /* it acts like what differs from stroke to stroke by itself, and each stroke's
                        own differences predict it as well; they have a price, though */
    DIAG_TOLERANCE   /* it is a number out of its tolerance, which the fit without it has moved
                        there already: they may not be predicted worse, that is all */
} diag__asked;

/** Where all searches have ended. */
typedef struct diag__found {
    int n;
    lab_suspect cause[FIT__ACCEPTED];
    diag *from[FIT__ACCEPTED];        /* the search that found it */
    diag__asked asked[FIT__ACCEPTED]; /* of the held-out strokes */
    diag *end;                        /* where all of them act */
    diag__suspect *leader;            /* one of them is on trial there; NULL: all are accepted */
    const diag *pruned;               /* the end at which no cause was needless, and */
    const diag__suspect *pruned_leader;
    double chi2_dof, excess;
    int hasty;       /* 1: further searches put off what costs most */
    diag__held held; /* held-out strokes at the end */
    diag **stage;    /* searches after the first one */
    int nstage;
} diag__found;
/** Two causes, as where the strokes begin has shown them (along.c). */
typedef struct diag__pair {
    int first;            /* suspect of the first search; -1: there is none */
    lab_candidate second; /* beside it */
    double *x;            /* the unknowns of both; NULL: who is second is not known */
} diag__pair;
/** All causes, after the first search has ended; its best suspect is the first of them.
 *  @param before  held-out strokes of the mechanism as it is; rmse and deviance NAN: none
 *  @param pair    not NULL: nobody goes on where the first two leave more than noise, and a first
 *                 one that explains how the strokes begin need not gain anything by itself
 *  @return OK, ENOMEM; free in any case */
stein_status diag__causes(diag *first, const diag__held *before, const diag__pair *pair,
                          diag__found *found, stein_err *err);
void diag__found_free(diag__found *found);
/** -2 log likelihood at the end. */
double diag__objective(const diag__found *found);
/** The unknowns of a cause at the end, amount and the numbers beside it: x and sd [FIT__NUMBERS].
 *  @return the amount; the others follow */
const fit__unknown *diag__amount(const diag__found *found, int cause, double *x, double *sd);

/* ---- stage.c ---- */

/** A search with the causes of `from` and its leader in the model, all but one, at its minimum; it
 * is the found's, which frees it.
 *  @param leader   on trial in `from`; NULL: nobody
 *  @param without  NULL: all act  @param out  the search  @return OK, ENOMEM, or why not */
stein_status diag__stage_open(diag__found *f, const diag *first, const diag *from,
                              const diag__suspect *leader, const lab_candidate *without, diag **out,
                              stein_err *err);
/** The same where the leader is, whatever that leaves: no fit is made. */
stein_status diag__stage_at(diag__found *f, const diag *first, const diag *from,
                            const diag__suspect *leader, const lab_candidate *without, diag **out,
                            stein_err *err);
/** Where a search has ended as unknowns of another one, to [nu]; c: on trial there, NULL: nothing.
 */
void diag__carry_over(const diag *next, const diag *from, const diag__suspect *leader,
                      const lab_candidate *c, double *to);
/** Unknown that an effect's amount is at a leader's end, -1: it does not act there. */
int diag__amount_of(const diag *from, const diag__suspect *leader, const lab_candidate *c);

/* ---- along.c ---- */

/** Two causes in the order in which the strokes show them, where they explain nearly all; pair->x
 * is freed by the caller. @return OK, ENOMEM */
stein_status diag__along(diag *first, diag__pair *pair, stein_err *err);

/* ---- restart.c ---- */

/** The suspect that alone explains how the strokes begin, -1: there is none. */
int diag__beginner(const diag *d);

/** Two causes in the order in which the strokes show them (along.c), where the first search leaves
 *  more than the noise that is stated. @param found  n is 0 where they do, too; free in any case
 *  @return OK, ENOMEM */
stein_status diag__two_along(diag *first, const diag__held *before, diag__found *found,
                             stein_err *err);
/** All causes; where they leave more than noise and that was stated, pairs that begin with other
 *  suspects are tried. Parameters and @return as of diag__causes. */
stein_status diag__several(diag *first, const diag__held *before, diag__found *found,
                           stein_err *err);

/* ---- curve.c ---- */

/** After the verdict: is there an unknown effect, or does what was found leave more than the noise
 *  that the data state? */
int diag__asks_for_law(const diag *d, const diag__found *found);
/** The laws that an unknown effect could have, into d->out; nothing where that was done.
 *  @param before  the held-out strokes without them
 *  @param bound   chi2/dof: where no law comes below it in a few steps, none is tried
 *  @return OK (also when there is none), ENOMEM */
stein_status diag__try_laws(diag *d, const diag__held *before, double bound, stein_err *err);
/** Is nothing but the stated noise left to the best one of those that were tried, and no scatter as
 *  large as it may be? */
int diag__law_is_all(const diag *d);
/** Was a law found that leaves more than noise, but half of what several causes leave beyond it?
 * They would be pieces of what it is a piece of. */
int diag__law_is_ahead(const diag *d, const diag__found *f);
/** Is it, and all of those causes are in its place, or numbers of that? */
int diag__law_has_all(const diag *d, const diag__found *f);
/** The law of an unknown effect, if it has one, into d->out. Causes that leave more than noise
 *  give way to a law that predicts better: then the verdict is an unknown effect.
 *  @param before  the held-out strokes without it
 *  @param found   with the law, if it pays: no cause, held-out strokes with it
 *  @return OK (also when there is none), ENOMEM */
stein_status diag__unknown_law(diag *d, const diag__held *before, diag__found *found,
                               stein_err *err);
/** Weighted residuals of the strokes with a law that pays; NULL: there is none. */
const double *diag__law_residuals(const diag *d);
void diag__law_free(diag *d);

/* ---- note.c ---- */

/** Suspects, refitted numbers of the file and scatter of the diagnosis. @return OK, ENOMEM */
stein_status diag__note(diag *d, diag__found *found, stein_err *err);
/** A number of the file as it was refitted, behind the others of d->out->value, which has room;
 *  unknown k of p is one, or an amount and left out.
 *  @param wide  factor of sd */
void diag__note_value(diag *d, const fit__problem *p, int k, double x, double sd, double wide);
/** Scatter of the strokes with these variances [DIAG_CLASSES]. */
void diag__note_scatter(diag *d, const double *D);

/* ---- posterior.c ---- */

/** Standard deviations of the best suspect of a search and its rivals from derivatives at their
 *  ends. The fits stop with what they had on the way, which may be too narrow.
 *  @return OK, ENOMEM */
stein_status diag__widths(diag *d, stein_err *err);

/** What causes and rivals are known to be, and what the strokes were like: into the diagnosis, for
 *  who plans the next experiment.
 *  @param alone  1: the first suspect is the only cause; of several nothing is planned
 *  @return OK, ENOMEM */
stein_status diag__posteriors(diag *d, int alone, stein_err *err);
void diag__posteriors_free(lab_diagnosis *o);

/** The next experiment, where there are rivals. @return OK (also when no experiment can be
 *  simulated), ENOMEM */
stein_status diag__next(diag *d, stein_err *err);

/* ---- verdict.c ---- */

/** How many suspects of a search, which are sorted, the data cannot tell from the best one: up to
 * the last that comes near. */
int diag__rivals(const diag *d);
extern const double diag__least_gain;   /* of -2 log likelihood, to speak of */
extern const double diag__must_explain; /* share of the misfit beyond noise */
extern const double diag__convincing;   /* of -2 log likelihood: odds of 1 to 100 */
/** Share of the misfit beyond noise that a fit with this chi2/dof explains. */
double diag__share(const diag *d, double chi2_dof);
/** Does the best suspect of a search gain enough to speak of, and not by chance? */
int diag__spoken(const diag *d);
/** Is a suspect a mean of what differs from stroke to stroke by itself, and not by chance? */
int diag__is_mean(const diag *d, const diag__suspect *s);
/** Does a suspect move a number of the file out of its tolerance, farther than chance does? */
int diag__is_beyond(const diag *d, const diag__suspect *s);
/** Does the null fit have numbers out of their tolerances, farther than chance takes them? */
int diag__is_strained(const diag *d);
/** Are the linear scores at the null fit larger than chance makes them, or the deviations of its
 *  numbers from the file? */
int diag__is_seen(const diag *d);
/** Is more than noise left by so much that a search begins anew from other places? */
int diag__is_off(const diag *d, double chi2_dof);
/** Standard deviation of chi2/dof where there is nothing but noise. */
double diag__noise_sd(const diag *d);
/** Largest chi2/dof of noise that the data state; INFINITY where they do not state it. */
double diag__most_noise(const diag *d);
/** Is a residual of this chi2/dof more than noise? Where nobody stated the noise it may be. */
int diag__is_more(const diag *d, double chi2_dof);
/** By how much it is more than noise that is stated; < 0: it is not. */
double diag__by_more(const diag *d, double chi2_dof);
/** Does a search go on where its leader leaves that? The first one as long as it is off: of all
 * that may lead it has to find the one. A further one while it is more: its leader has ended there
 * with the causes of others. */
int diag__is_on(const diag *d, double chi2_dof);
/** Verdict and reason from what the searches have found; without a cause that holds, found->n is 0
 *  afterwards. */
void diag__verdict(diag *d, diag__found *found);
/** How much more than its noise a residual varies whose noise nobody stated: chi2/dof with this
 *  suspect, times the length of the residual's memory; 1 where it was stated. */
double diag__excess(const diag *d, const diag__suspect *s);

#endif
