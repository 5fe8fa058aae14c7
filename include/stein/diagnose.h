/* SPDX-License-Identifier: GPL-3.0-or-later
 * diagnose.h - diagnosis of a simulation: the physical effects that a mechanism may lack, their
 * possible places, and those that measured strokes show. Part of libsteinlab.a.
 *
 * One table holds every kind of effect: its equation, its appearance in records, the parameter that
 * switches it on. A candidate is a kind at a place of one mechanism. All laws have all terms
 * (law.h), so most candidates only move a parameter away from its neutral value and need no new
 * equations.
 */
#ifndef STEIN_DIAGNOSE_H
#define STEIN_DIAGNOSE_H

#include "stein/fit.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Where a kind of effect can sit. */
typedef enum {
    LAB_AT_JOINT,     /* every body's joint, the load's excepted */
    LAB_AT_BODY,      /* every body, the load excepted */
    LAB_AT_CONTACT,   /* every contact, the load's included */
    LAB_AT_SURFACE,   /* contacts and notches */
    LAB_AT_LINK,      /* every link */
    LAB_AT_LOAD,      /* the free load */
    LAB_AT_INPUT,     /* every input */
    LAB_AT_CHANNEL,   /* every output that shows a place or a force */
    LAB_AT_MARKER,    /* every output that shows a point */
    LAB_AT_CLOCK,     /* the recorder */
    LAB_AT_PARAMETER, /* every other number of the file */
    LAB_AT_SETTING    /* every number that a record states, `# set`; of one record alone */
} lab_site;

/** How the amount a of an effect moves its parameters from their present values v. */
typedef enum {
    LAB_MOVE_ADD,    /* v + a */
    LAB_MOVE_LOWER,  /* v - a */
    LAB_MOVE_SCALE,  /* v exp(a), of all parameters alike */
    LAB_MOVE_SPRING, /* k + a, and theta0 such that k theta0 stays: a torque -a q */
    LAB_MOVE_VALUE   /* a itself: the number of a part that the mechanism lacks */
} lab_move;

/** One kind of effect. */
typedef struct lab_effect {
    const char *kind; /* stable name */
    const char *cls;  /* missing_effect, wrong_parameter, sensor, input */
    /* group of kinds that data often cannot separate: "dissipation", "stiffness", "inertia",
     * "geometry", "contact", "drive", "sensor", "clock", "part", "setting" */
    const char *family;
    lab_site site;
    const char *size;      /* name of its amount */
    const char *parameter; /* path after the place, "%.damping"; NULL with `needs` */
    const char *side;      /* a second parameter that it needs, NULL: none; with `needs` its name */
    /* the number that its amount is a share of, a path after the place: "damping" of an asymmetry.
     * Where that number is absent there is no candidate. NULL: the amount is no share */
    const char *share;
    const char *equation, *looks;
    const char *twins; /* kinds that data often cannot distinguish from it; "" none */
    const char *needs; /* "structure": one more part or degree of freedom (lab_candidate_open).
                        * NULL: nothing
                        */
    int both_signs;
    int sampled; /* acts on the samples of channels, not on the motion */
} lab_effect;

/** The table; n out. Kinds are unique. */
const lab_effect *lab_effects(int *n);
/** By kind, NULL when there is none. */
const lab_effect *lab_effect_find(const char *kind);
/** Is its amount a compliance [rad/(N m) or m/N], of which 0 is rigid? */
int lab_effect_is_compliance(const lab_effect *effect);
/** Does a word select it: its kind, its class, its site ("joint", "channel" ...) or "all"? */
int lab_effect_is(const lab_effect *effect, const char *word);
/** Its field `share`. */
const char *lab_effect_share(const lab_effect *effect);
/** Its field `family`; "unknown" for NULL. */
const char *lab_effect_family(const lab_effect *effect);
/** "joint", "body", "contact" ... */
const char *lab_site_text(lab_site site);

enum { LAB_MOVED = 3, LAB_SIDES = 4, LAB_PLACE = 100 };

/** A number of an effect beside its amount: a gap, a range, a damping ratio. */
typedef struct lab_side {
    const char *name, *unit; /* NULL: there is none */
    int param;               /* of the model; -1: none, or of a part that has not been opened */
    double value, lo, hi;    /* start value and range */
    int log;                 /* the range is logarithmic */
} lab_side;

/** A kind of effect at a place of a mechanism. */
typedef struct lab_candidate {
    const lab_effect *effect;
    char place[LAB_PLACE]; /* "hammer", "string", "key_dip", "clock", "pawl.corner.x" */
    lab_move move;
    int nparam, param[LAB_MOVED]; /* of the model; the first one names the effect */
    const char *unit;             /* of the amount */
    lab_side side[LAB_SIDES];
    double limit;       /* plausible largest amount */
    double number;      /* size of the file's number that it changes; 0: there is none */
    double start;       /* first secant, a share of the limit */
    int joint, channel; /* of its place, -1: none */
    /* records in which it acts, by lab_data.number: all (from 0), one (until = from), from one on
     * (until 0) */
    int from, until;
    /* numbers of the file with exactly the same effect, separated by blanks */
    char alias[2 * LAB_PLACE];
} lab_candidate;

/** Does it act in the record of that number? */
int lab_candidate_acts(const lab_candidate *candidate, int number);
/** The records in which it acts, in words: "", " of stroke 5", " from stroke 7 on". @return text */
const char *lab_candidate_scope(const lab_candidate *candidate, char text[LAB_PLACE]);

/** All candidates of a mechanism, from its structure. Limits follow from its weights and springs
 * and from one run with the file's own numbers. No two candidates have the same effect. A number of
 * the file with exactly the same effect, as the height of a felt and its gap, is an alias of the
 * candidate. Effects with `needs` have no parameter before lab_candidate_open (nparam 0).
 *  @param list  out, freed by the caller with free()
 *  @return OK, ENOMEM, numerical failures of that run */
stein_status lab_candidates(lab_candidate **list, int *n, const lab_model *model, stein_err *err);
/** Move the parameters p [np] of the equations by an amount; 0 leaves all bits. For a part, 0 is
 *  the state after lab_candidate_open. The mechanism without the part is the limit of compliance 0,
 *  or a force or stiffness of 0. */
void lab_candidate_apply(const lab_candidate *candidate, double amount, double *p);
/** May its amount be negative? An effect that changes a number of the file may reduce it, as a
 *  damping; where that number is 0, it can only add. */
int lab_candidate_is_signed(const lab_candidate *candidate);
/** May it be wrong by a mistake? A number of the file is mistyped or taken from the wrong end, an
 *  instrument scaled for another purpose: its amount may be many limits large. */
int lab_candidate_is_mistakable(const lab_candidate *candidate);
/** Name of its amount, and its equation. Where the file's number is 0, an effect that would scale
 * it has no logarithm: its amount is the "change" of the number. */
const char *lab_candidate_size(const lab_candidate *candidate);
const char *lab_candidate_equation(const lab_candidate *candidate);

/** The mechanism in which an effect with `needs` can be simulated: the file's, with the part in
 *  it, generated, compiled and cached as any other. Every number, input, output, contact of the
 *  file keeps name, meaning, tolerance and value there; joints may have other indices. The part's
 *  amount is start * limit (a compliance) or 0. Without `needs`: the file itself.
 *  @param candidate  of the file; its parameters are bound to the new model's
 *  @param options    as for lab_open, NULL: defaults
 *  @return OK, EINVAL (impossible place), or what lab_open returns */
stein_status lab_candidate_open(lab_candidate *candidate, lab_model **model, const char *file,
                                const lab_options *options, stein_err *err);
/** Bind a candidate to the parameters of another model of the same mechanism, by kind and place.
 *  @return OK, ENAME (it has no such place or parameter), ENOMEM */
stein_status lab_candidate_bind(lab_candidate *candidate, const lab_model *model, stein_err *err);

/* ---- diagnosis ---- */

/** Result of a diagnosis. */
typedef enum {
    LAB_VERDICT_EXPLAINED,       /* the residual is noise and scatter */
    LAB_VERDICT_WRONG_PARAMETER, /* a number of the file is wrong */
    LAB_VERDICT_SENSOR,          /* an instrument */
    LAB_VERDICT_INPUT,          /* the drive of the mechanism differs from the record's statement */
    LAB_VERDICT_MISSING_EFFECT, /* physics that the file lacks */
    LAB_VERDICT_UNKNOWN_EFFECT, /* more than noise is left, and no candidate explains it */
    LAB_VERDICT_NOT_CONVERGED,  /* no fit converged, so there is no verdict on physics */
    LAB_VERDICT_UNUSABLE_MODEL  /* the model is far from the records with every candidate */
} lab_verdict;
/** "explained", "wrong_parameter", "sensor", "input", "missing_effect", "unknown_effect",
 *  "not_converged", "unusable_model". */
const char *lab_verdict_text(lab_verdict verdict);

/** One number of a cause [SI] with its 95 % interval: Student's t where strokes scatter, because
 * the scatter is estimated from these strokes alone. The numbers of a cause come from the
 * predictable part of the strokes; if that ends early the audit reports it.
 */
typedef struct lab_cause_number {
    char name[LAB_PLACE]; /* from lab_effect.size and .side: "T", "range" */
    const char *unit;
    double value, sd, lo, hi;
} lab_cause_number;

enum { LAB_CHANGE_TEXT = 300 };
/** A number of the file that a cause changes, with the 95 % interval of its new value: that of the
 *  amount, moved along. */
typedef struct lab_change {
    char name[LAB_PLACE]; /* "rod.inertia.yy" */
    char unit[LAB_UNIT];  /* as the file writes it, "kg cm^2"; SI where it writes none; "" of "1" */
    double factor;        /* one of that unit [SI] */
    double from, to, lo, hi; /* in the file, with the refitted numbers and the cause [SI] */
} lab_change;

/** Evidence for or against a candidate. */
typedef enum {
    LAB_NOT_JUDGED, /* no fit has converged */
    LAB_PRESENT,    /* it is a cause */
    LAB_WEAK, /* plausible, but too weak to be named: there is some evidence, or it may be hidden */
    LAB_ABSENT,      /* it would have been named at its plausible limit, and was not */
    LAB_NOT_TESTABLE /* these data have no information about it */
} lab_presence;
enum { LAB_PRESENCES = LAB_NOT_TESTABLE + 1 };
/** "present", "weak", "absent", "not_testable"; NULL: not judged. */
const char *lab_presence_text(lab_presence presence);

/** Estimate and detectability of a candidate's amount, all else refitted linearly at the accepted
 *  model; in the candidate's unit, NAN where unknown. */
typedef struct lab_power {
    lab_presence presence;
    double amount, sd;   /* beside the causes, without its prior */
    double detectable;   /* least amount that would have been named with 95 % probability */
    double upper;        /* 95 % upper limit of its true amount */
    const char *because; /* a reason in words; NULL: not judged */
    int beside; /* 1: it gains too little to be named, but its amount is three standard deviations
                 * from 0. The intervals of the causes contain what they would be beside it. */
} lab_power;

/** Joint distribution of all numbers of a fit, near its end: z is the logarithm of a number that
 * was fitted as one, else the number itself. */
typedef struct lab_posterior {
    int n;
    struct lab_uncertain {
        char name[LAB_PLACE]; /* a parameter of the file; "amount", "side", "other" of the effect,
                                 "amount_2" .. of the first one in `beside`, "amount_3" .. */
        int logarithmic;
        double value, sd; /* [SI], of z */
    } * number;
    double *correlation; /* [n*n] of z */
    /* the other candidates of its hypothesis, which act in the same fit; NULL: it is the only one
     */
    lab_candidate *beside;
    int nbeside;
} lab_posterior;

/** A candidate, judged. Gains are falls of -2 log likelihood with the strokes' scatter taken out.
 */
typedef struct lab_suspect {
    lab_candidate candidate;
    double score;  /* predicted gain, all else refitted linearly; NAN: not testable */
    double amount; /* predicted, then fitted [candidate.unit] */
    int possible;  /* sign and size are physical */
    int refitted;  /* 1: gain is from a full fit */
    double gain;   /* NAN unless refitted */
    int nnumber;   /* of a refitted one */
    lab_cause_number number[1 + LAB_SIDES];
    int nchange; /* of a cause or rival that changes numbers which the file states, else 0 */
    lab_change change[LAB_MOVED];
    char fitted_beside[2 * LAB_PLACE]; /* other candidates of the fit that its numbers are from */
    double chi2_dof;                   /* of the refit */
    double held_out; /* RMSE on held-out strokes over the noise; NAN unless refitted */
    /* of one cause of several: ratio of held-out errors with all causes and without this one, all
     * else refitted, with a 95 % bootstrap interval over strokes; else NAN */
    double own_ratio, own_lo, own_hi;
    double likeness; /* |correlation| of its column with the first one's, all else refitted */
    const char *why; /* reason, if not testable or not possible; NULL */
    lab_power power; /* detectability */
    lab_posterior posterior; /* of causes and rivals; n 0: unknown */
    /* of a cause in a part of the records, by lab_data.number */
    const char *file; /* of the record that it acts in alone; NULL */
    double stated;    /* the setting as that record states it [candidate.unit], NAN */
    int after,
        after_most; /* it begins after a record of this range; equal: exactly known; 0: none */
} lab_suspect;

/** Error on held-out strokes before and after the extension. */
typedef struct lab_gain {
    const char *channel;      /* NULL: all, in units of noise; else in the channel's unit */
    const char *unit, *phase; /* phase NULL: all */
    int samples;
    double rmse_before, rmse_after, noise;
    char written[LAB_UNIT]; /* unit of the records where it is deg instead of rad; "" */
    double per_unit;        /* one `unit` in that */
    double ratio, lo, hi;   /* after/before with a 95 % bootstrap interval over strokes */
} lab_gain;

/** One channel of one stroke as measured and as predicted [unit]; arrays are [n]. */
typedef struct lab_trace {
    int stroke, held_out;
    const char *file, *channel, *unit;
    char written[LAB_UNIT]; /* as of lab_gain */
    double per_unit;
    int n;
    double noise;
    double *t, *y, *before, *after; /* y NAN: no sample; after = before when nothing was found */
    const char **phase;             /* of the stroke at each sample */
} lab_trace;

/** Departures of the unextended model: one row a channel or joint, and phase. */
typedef struct lab_departure {
    const char *place, *unit; /* channel, or joint (then a force) */
    int is_force;
    const char *phase;
    int samples;
    double size, sd; /* RMS residual; or mean missing force and its standard deviation [unit] */
    double z;        /* significance against correlated noise, as a normal deviate */
    double lag1;     /* autocorrelation of the residual at one sample; NAN for forces */
} lab_departure;

/** The missing force on a joint over the time of one stroke, with its standard deviation. */
typedef struct lab_latent {
    const char *joint, *unit, *file;
    int n;
    double *t, *force, *sd; /* [n] */
} lab_latent;

/** Ranges of the strokes. */
typedef struct lab_used {
    char name[LAB_PLACE];
    const char *unit;
    double lo, hi; /* of a setting over the strokes, of an input over its samples [SI] */
    double noise;  /* of a channel: sd of one sample */
} lab_used;
typedef struct lab_conditions {
    double from, until, interval; /* recorded times, median interval [s] */
    int unsynchronised;           /* 1: the trigger was not known */
    int nchannel, ninput, nsetting;
    lab_used *channel, *input, *setting; /* measured, driven, set by the strokes */
} lab_conditions;

enum { LAB_PLAN_SETS = 8, LAB_PLAN_TEXT = 200 };

/** How an input is driven: zero + size * shape(t). */
typedef enum {
    LAB_SHAPE_NONE,
    LAB_SHAPE_RISE, /* 0 to 1 in `time`, then 1 */
    LAB_SHAPE_BACK, /* 0 to 1 in `time`, and back in the same time */
    LAB_SHAPE_SWING /* one period of a sine, 2 `time` long */
} lab_shape;
/** A number that the experiment sets, "# set NAME: VALUE". */
typedef struct lab_planned_set {
    char name[LAB_PLACE];
    const char *unit;
    double value; /* [SI] */
} lab_planned_set;

/** The reference for an instrument, or the instrument for a number of the mechanism. */
typedef enum {
    LAB_CHECK_LEVEL,    /* a plumb line: its tilt */
    LAB_CHECK_SCALE,    /* known values from 0 to `reach`: its gain and curvature */
    LAB_CHECK_LIGHT,    /* a light at known instants: its delay */
    LAB_CHECK_CLOCK,    /* another clock: the error of the time base */
    LAB_CHECK_CALIPERS, /* a length */
    LAB_CHECK_EDGE,     /* a knife edge: where a body's centre of mass is */
    LAB_CHECK_BALANCE,  /* a mass */
    LAB_CHECK_PRESS     /* known depths from 0 to `reach`: the slow force of a felt */
} lab_check_by;
enum { LAB_PLAN_CHECKS = 4, LAB_CHECK_VALUES = 11, LAB_CHECK_NUMBERS = 4 };
/** A check of an instrument or of a number of the mechanism, without a stroke. Its result is stated
 *  in every file of a stroke, "# known NAME.sensor.tilt: 3 mrad". */
typedef struct lab_check {
    lab_check_by by;
    char of[LAB_PLACE]; /* channel, "" the clock; length or mass; contact */
    int n;
    struct lab_checked {
        char name[LAB_PLACE];
        double file;             /* the value of the model [SI] */
    } number[LAB_CHECK_NUMBERS]; /* that it finds */
    double noise; /* sd of one reading: of the angle [rad], of the value [its unit], of an instant
                     [s], of the error [1]; of a press in the force that is read (check.c) [1] */
    double reach; /* of a scale: largest value [its unit]; of a press: depth [m] */
} lab_check;

/** An experiment, and its value (plan.h). */
typedef struct lab_experiment {
    char name[LAB_PLAN_TEXT]; /* in words */
    char why[LAB_PLAN_TEXT];  /* preparations and assumptions; or why it is impossible */
    int nset;
    lab_planned_set set[LAB_PLAN_SETS];
    char input[LAB_PLACE]; /* driven input, "": none */
    lab_shape shape;
    double zero, size, time; /* of its signal [SI] */
    char channel[LAB_PLACE]; /* measured besides the channels so far, "": none */
    double noise;            /* of that channel, sd of one sample */
    int faster;              /* frames per frame so far */
    int ncheck;              /* > 0: it is no stroke, but checks */
    lab_check check[LAB_PLAN_CHECKS];
    int feasible; /* 0: it cannot be simulated */
    double odds;  /* expected 2 ln of the odds from one stroke (or check), averaged over the true
                     hypothesis */
    double odds_worst; /* exceeded by 9 of 10 strokes; with k rivals by all but one in 10 k */
    int repeats;   /* strokes after which 9 of 10 times the wanted odds are reached against every
                      rival, at least two; 0: too many */
    int all;       /* 1: also between all pairs of rivals, in 12 strokes at most */
    double beyond; /* product of ratios to the present strokes, over all changes: 1 within their
                      range, 2 twice the force, 5 with a body 2.5 times as heavy too */
    int against;   /* candidate of the diagnosis that is hardest to separate from the cause */
} lab_experiment;

/** A law recovered from the strokes, as a curve with its 95 % band: a force beside the laws of the
 *  file, as a function of one state at its place. It becomes a table of the extended file. */
typedef struct lab_law {
    char place[LAB_PLACE]; /* body of the joint, contact or notch */
    const char *site;      /* "joint", "contact", "notch" */
    const char *of;        /* "position", "speed", "depth", "rate" */
    const char *what;      /* "torque", "force", "factor": of the normal force */
    const char *at_unit, *unit;
    char table[LAB_PLACE]; /* its name in the extended file */
    int n;
    double *at, *value, *lo, *hi, *sd; /* [n] */
    int *seen;   /* [n] frames (of a contact: evaluations) nearer to this point than to others */
    double gain; /* fall of -2 ln marginal likelihood, relative to the fit without it */
    double chi2_dof, held_out; /* of the fit with it; RMSE on held-out strokes over the noise */
    double share; /* explained share of the misfit beyond noise, on held-out strokes if any */
    int pays;     /* it explains enough of the misfit to be written into extended.yaml */
} lab_law;

/** Result of the check by forces of a verdict that was found from positions. */
typedef enum {
    LAB_MOTION_NOT_DONE,    /* it is impossible: lab_motion.why */
    LAB_MOTION_SUPPORTS,    /* the same model is nearer to the forces as well */
    LAB_MOTION_CONTRADICTS, /* the other model is nearer, or much of the departure remains */
    LAB_MOTION_CANNOT_TELL  /* noise of the measured motion hides it */
} lab_motion_says;
/** "not_done", "supports", "contradicts", "cannot_tell". */
const char *lab_motion_text(lab_motion_says says);

/** Errors under the measured motion: of the required force, or of a channel that is not prescribed.
 *  Means over blocks of a few milliseconds. `noise` is the result of the same check for simulated
 *  strokes with the noise of the data: it contains position noise and the bias of smoothing. */
typedef struct lab_motion_row {
    const char *channel;      /* NULL: the force */
    const char *unit, *phase; /* phase NULL: all */
    int samples;
    double present;                          /* RMS of the force that acted; NAN for channels */
    double before, after, noise;             /* RMS [unit]; after NAN without extension */
    double mean_before, mean_after, mean_sd; /* signed mean, and its sd by noise [unit] */
} lab_motion_row;

/** One group of such errors, in units of their own uncertainty. */
typedef struct lab_motion_part {
    lab_motion_says says;
    double before, after;     /* RMS of error/sd; 1: noise alone */
    double z_before, z_after; /* excess over noise, as a normal deviate */
    /* share of the extension's change that is present: 0 as without it, 1 as with it; and its sd */
    double share, share_sd;
} lab_motion_part;

/** The motion-driven check: the measured motion is prescribed to a joint, the rest is simulated,
 *  and the required force is compared with the force that acted. It changes no verdict. */
typedef struct lab_motion {
    lab_motion_says says;
    char why[200];                            /* a phrase */
    const char *input, *joint, *force, *unit; /* of the motion, its joint, the output with its force
                                               */
    const char *channel; /* that measures the motion; NULL: the strokes prescribe it themselves */
    int strokes, held_out, draws;
    lab_motion_part of_force, of_channels, all;
    int nrow;
    lab_motion_row *row; /* the force, all and by phase; then channels */
    int n;               /* one stroke over time */
    const char *file;
    double *t, *present, *before, *after,
        *sd; /* [n] force that acted, required forces; sd of one frame */
} lab_motion;

/** extended.yaml read again as a file: its RMS residual in the records that it describes, with each
 *  record's own start and scatter as fitted, and the RMS residual of the verdict's fit. */
typedef struct lab_verified {
    int done, same;     /* same: to one percent */
    double table, file; /* [noise] */
} lab_verified;

/** One record: its RMS residual without and with the causes [noise]. `amount` is the amount of the
 * first cause fitted to this record alone, all else as fitted [the cause's unit]; NAN: it does not
 * act there, or the record was not fitted. */
typedef struct lab_seen {
    int number; /* of lab_data */
    const char *file;
    int reporting; /* 1: no fit has read it */
    double before, after, amount, sd;
} lab_seen;

/** A setting that was made by hand: its true values differ from the stated ones. */
enum { LAB_SETTINGS_OFF = 8 };
typedef struct lab_setting_off {
    const char *name, *unit;
    double rms; /* over the records [SI] */
} lab_setting_off;

/** A diagnosis. */
typedef struct lab_diagnosis {
    lab_verdict verdict;
    char reason[800];  /* a few sentences */
    char slip[200];    /* what the records state wrongly, for which nothing was fitted; "" */
    const char *phase; /* phase in which the cause is largest; NULL without one */
    int nsuspect;
    lab_suspect *suspect; /* causes in the order they were found, rivals, then all others */
    int ncause;           /* suspect[0 .. ncause-1] are the causes, at most 3 */
    int nrival;           /* the next nrival cannot be separated from it */
    double p;             /* family-wise probability of the best score without any effect */
    lab_gain gain;        /* all channels, in units of noise */
    int ngain;
    lab_gain *gains; /* by channel and phase */
    int nfit, nheld; /* strokes; pieces of them where `in_pieces` */
    int in_pieces;   /* 1: long records, or too few, were cut into pieces */
    int nfile;       /* records that were read */
    int samples;
    lab_conditions conditions;
    lab_experiment *next; /* best separates the cause from its rivals; NULL: no rivals */
    double noise_floor;   /* RMSE that noise alone leaves, in units of noise: 1 */
    double chi2_dof_before, chi2_dof_after;
    double remainder; /* RMS residual of the best hypothesis [noise] */
    double share;     /* of the misfit beyond noise that it explains */
    lab_verified verified;
    int nrecord; /* all records in their order; 0: nothing was fitted */
    lab_seen *record;
    int nsetting_off; /* settings that the verdict requires to be off, within their digits */
    lab_setting_off setting_off[LAB_SETTINGS_OFF];
    double scatter[3]; /* sd of ln joint friction, ln contact friction, ln drive */
    int nvalue;        /* refitted parameters of the file, after the extension */
    lab_fit_value *value;
    int nfinding;
    char **finding; /* of the audit, "file: what" */
    int ntrace, ndeparture, nlatent;
    lab_trace *trace;
    lab_departure *departure;
    lab_latent *latent;
    lab_law *law; /* with an unknown effect: best first; law[0].pays: it is in the extension */
    int nlaw;
    lab_motion motion; /* the check by forces */
    char *explanation; /* why a candidate is in the verdict or not; NULL: not requested */
    int fits, strokes_simulated;
    double seconds;
    lab_model **kept; /* mechanisms with parts, which own names and units */
    int nkept;
    lab_dataset *pieces; /* of long records that were cut, which own their names; NULL: none */
} lab_diagnosis;

/** How to diagnose. Start from lab_diagnose_def_default(). */
typedef struct lab_diagnose_def {
    const unsigned char *held_out; /* [strokes] 1: reporting record, not fitted; NULL: chosen */
    const char *const *free;       /* [nfree] refitted besides the numbers with a tolerance */
    int nfree;
    const char *const *without; /* [nwithout] effects that are left out of the table: */
    int nwithout;               /* words of lab_effect_is */
    double smooth;              /* cut-off frequency of measured motions [Hz]; 0: chosen */
    int threads;
    long most_strokes;          /* budget of simulated strokes, 0: none */
    double most_seconds;        /* budget of time [s], 0: none */
    const lab_options *options; /* for mechanisms with added parts; NULL: defaults */
    const char *explain;        /* "KIND@PLACE": lab_diagnosis.explanation; NULL: nothing */
    const char *trace;          /* file of the search's rows, one JSON object a line; NULL: none */
    lab_fit_progress_fn *progress;
    lab_report_fn *report;
    lab_stop_fn *stop; /* may be NULL */
    void *ctx;
} lab_diagnose_def;
lab_diagnose_def lab_diagnose_def_default(void);

/** Diagnose a mechanism file against strokes.
 *  @param file  the mechanism file of the model
 *  @return OK (whatever the verdict), EINVAL (too few strokes, def), ENAME (`without` names no
 *  effect), numerical failures at the file's own
 *  values, ESTOPPED, ENOMEM */
stein_status lab_diagnose(lab_diagnosis **out, const char *file, const lab_model *model,
                          const lab_dataset *data, const lab_diagnose_def *def, stein_err *err);
void lab_diagnosis_destroy(lab_diagnosis *diagnosis);
/** Does the extended file differ from the file: by a law, or by a cause that is not one record's
 *  own setting? */
int lab_diagnosis_extends(const lab_diagnosis *diagnosis);

/** What a cause changes, in one unit: "inertia.yy: 0.052 -> 0.0040 kg m^2 (95 %: 0.0012 to 0.0068),
 *  13 times smaller". "" where it changes no number that the file states. @return text */
const char *lab_change_text(const lab_suspect *cause, char text[LAB_CHANGE_TEXT]);

/** Write the mechanism file with the causes and the refitted numbers. Comments are kept; a head
 * states the additions and the data. Numbers come from diagnosis->value; then lab_candidate_apply
 * acts with every cause's amount and its second and third number (from the list `number`, by name,
 * else the candidate's own). So `value` holds a number that a cause moves without that cause.
 * With an unknown effect whose law pays: with that law as a table.
 *  @return OK, EIO, EPARSE, EINVAL (there is no cause; a number or part has no place in the file),
 *  ENOMEM, or what lab_open returns for the mechanism with its parts */
stein_status lab_extend(const char *path, const char *file, const lab_diagnosis *diagnosis,
                        stein_err *err);
/** DIR/diagnosis.json. @return OK, EIO, ENOMEM */
stein_status lab_diagnosis_json(const char *path, const lab_diagnosis *diagnosis, stein_err *err);
/** DIR/report.html, one self-contained page. @return OK, EIO, ENOMEM */
stein_status lab_diagnosis_page(const char *path, const lab_diagnosis *diagnosis, stein_err *err);

#ifdef __cplusplus
}
#endif
#endif
