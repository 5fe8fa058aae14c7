/* SPDX-License-Identifier: GPL-3.0-or-later
 * fit.h - parameters of a mechanism from measured strokes. Part of libsteinlab.a.
 *
 *      minimise  sum over samples ((y - h(t + tau; p)) / noise)^2  +  sum over priors (dp / sd)^2
 *
 * over the free parameters p, which all strokes share, and over each stroke's own nuisances. These
 * are the time of the trigger, the offset of every marker, the initial state, and factors of its
 * friction and drive. The tolerance (+-) of a number in the mechanism file is its prior.
 */
#ifndef STEIN_FIT_H
#define STEIN_FIT_H

#include "stein/data.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Result of the search. */
typedef enum {
    LAB_FIT_CONVERGED, /* one minimum, found again from other starts, as good as the noise allows */
    LAB_FIT_MISFIT,    /* one minimum, found again, but the residual is more than noise */
    LAB_FIT_NOT_CONVERGED /* starts disagree, or the last steps still changed the objective */
} lab_fit_status;
/** "converged", "misfit", "not_converged". */
const char *lab_fit_status_text(lab_fit_status status);

/** Progress of a fit: one line of text about the present step, 0 <= fraction <= 1. */
typedef void lab_fit_progress_fn(void *ctx, double fraction, const char *step);

enum { LAB_SCATTER_PLACES = 2, LAB_SETTINGS_STARTS = 2 };
/** How to fit. Start from lab_fit_def_default(). */
typedef struct lab_fit_def {
    const char *const *free; /* [nfree] names of parameters */
    int nfree;
    const double *tolerance;    /* [nfree] standard deviations where the file states none, 0: none;
                                 * NULL (default): none at all */
    const char *const *profile; /* [nprofile] profile likelihood of these free ones */
    int nprofile;
    int profile_flagged; /* also of up to 3 that the data cannot distinguish; default 0 */
    double prior;        /* relative sd of a number without tolerance; default 0.3 */
    double offset;  /* prior sd of a marker's offset [m; rad by 0.1 m]; 0: none; default 0.2 mm */
    double trigger; /* prior sd of an unknown trigger [s]; default 2 ms. Of a stroke with a recorded
                       input at most a frame / sqrt(12) */
    const double *smooth; /* [inputs] cut-off frequency of a measured motion, at which half of it is
                             kept [Hz]; NAN: chosen by its noise; NULL: all NAN */
    int smooth_all;       /* 1: also in records that state another band (`# smooth`); default 0 */
    int initial; /* initial state: 1 free, 0 as the file states, -1 (default) free where the
                    mechanism neither settles nor has a load, and the stroke does not set it.
                    A free one starts from the first samples of the record; the simulation begins
                    there */
    int scatter; /* friction and drive differ from stroke to stroke: 1 yes, LAB_SCATTER_PLACES the
                  * friction of every place separately, 0 no, -1 (default) with 4 or more strokes
                  */
    double joint_scatter, contact_scatter; /* sd of a stroke's friction factor; default 5 %, 8 % */
    double drive_scatter;                  /* of its load or inputs; default 0.3 % */
    const struct lab_force_errors *force_errors; /* what the noise of measured forces does to
                                                    records; NULL (default): they are exact */
    int settings;   /* settings of strokes are uncertain by their last digit or a percent: 1 all,
                     * LAB_SETTINGS_STARTS those of initial states; default 0: they are exact */
    int starts;     /* searches from different places; default 3 */
    int robust;     /* 1: bisquare weights against single bad frames */
    int ladder;     /* 0: no innovation ladder (for comparisons); default 1 */
    int iterations; /* at most so many in one search; default 40 */
    int threads;    /* results do not depend on it */
    int lanes;      /* strokes side by side on each thread: 8, 4, 2 if the processor has so
                       many, or 1; 0 (default): the most; results do not depend on it */
    const char *journal; /* state of the search, to go on after an interruption; may be NULL */
    lab_fit_progress_fn *progress;
    lab_report_fn *report; /* doubts; may be NULL */
    lab_stop_fn *stop;     /* may be NULL */
    void *ctx;
} lab_fit_def;
lab_fit_def lab_fit_def_default(void);

/** One fitted number [SI]. */
typedef struct lab_fit_value {
    const char *name, *unit;
    int param;           /* of the model; -1 for a nuisance */
    int logarithmic;     /* fitted as ln: sd is value times the sd of the logarithm */
    double start, value; /* before and after */
    double sd, lo, hi;   /* standard deviation and 95 % interval, linear */
    double prior_sd;     /* of the file, or the weak one; NAN: none */
    double data_sd; /* sd by the data alone when all others are known; INFINITY: no information */
    int unseen;     /* 1: no data depend on it */
    int profiled;   /* 1: profile_lo and profile_hi are known (-+INFINITY: not bounded) */
    double profile_lo, profile_hi;
} lab_fit_value;

/** Two parameters that the data hardly distinguish. */
typedef struct lab_fit_pair {
    int a, b;           /* into values */
    double correlation; /* by the data alone */
} lab_fit_pair;

/** Residual of one channel in one stroke. */
typedef struct lab_fit_residual {
    int stroke;
    const char *channel, *unit;
    int samples;
    double noise, rms; /* [unit] */
    double relative;   /* rms over the rms of the measurement */
    int noise_given;   /* 1: by `# noise`; 0: estimated from the residual */
    double audited;    /* noise by the audit [unit] */
    int downweighted;  /* samples with less than half of their weight (robust) */
} lab_fit_residual;

/** Nuisances of one stroke. */
typedef struct lab_fit_stroke {
    const char *file;
    unsigned long long hash;
    int rows;
    int lacking; /* measured times of events for which the fitted model has no event */
    double chi2; /* weighted squares of this stroke */
    int nvalue;
    lab_fit_value *value; /* names "trigger", "offset string_distance", "initial rod" ... */
} lab_fit_stroke;

enum { LAB_FIT_STARTS = 16 };

/** One search. */
typedef struct lab_fit_start {
    double objective;      /* chi2 + priors at its end */
    int iterations, ended; /* ended: 1 the gradient vanished, 0 given up */
    int agrees;            /* with the best one */
} lab_fit_start;

/** A fit. */
typedef struct lab_fit {
    lab_fit_status status;
    char reason[160]; /* why it is not converged, or a misfit */
    int nvalue, nstroke, nresidual, npair, nstart;
    lab_fit_value *value;       /* [nvalue] the free parameters */
    lab_fit_stroke *stroke;     /* [nstroke] */
    lab_fit_residual *residual; /* [nresidual] */
    lab_fit_pair *pair;         /* [npair] */
    lab_fit_start start[LAB_FIT_STARTS];
    double chi2, prior; /* of the samples; of the priors */
    int samples, dof;   /* samples less determined unknowns */
    double chi2_dof, band_lo, band_hi;
    double inflation;   /* of variances, by the correlation of neighbouring residuals; >= 1 */
    int noise_given;    /* of all channels: then the band applies */
    double condition;   /* of the data's information on the free parameters */
    double *weakest;    /* [nvalue] the combination that the data determine least, in prior sd */
    double weakest_sd;  /* its standard deviation by the data alone, in prior sd */
    double *covariance; /* [nvalue*nvalue] of the values (of ln value where logarithmic) */
    double gradient;    /* decrement left: expected change of the objective */
    double sensitivity_error; /* relative, from the halved step */
    int resumed;              /* 1: continued from a journal */
} lab_fit;

/** Fit the free parameters of a model to strokes.
 *  @return OK (the result is in fit->status), ENAME (no such parameter), EINVAL (def; fewer samples
 *  than
 * unknowns), numerical failures of the model at the file's own values, EIO, ESTALE (journal of
 * another fit), ESTOPPED, ENOMEM */
stein_status lab_fit_run(lab_fit **fit, const lab_model *model, const lab_dataset *data,
                         const lab_fit_def *def, stein_err *err);
void lab_fit_destroy(lab_fit *fit);
/** The model's parameters with the fitted ones in place, p [np]. */
void lab_fit_apply(const lab_fit *fit, double *p);

/** The fit as JSON, what `stein fit --json` prints; "-" is standard output. @param model  its name
 *  @return OK, EIO */
stein_status lab_fit_json(const char *path, const char *model, const lab_fit *fit, stein_err *err);
/** Write the mechanism file with the fitted numbers (and the overrides) in their places.
 * Everything else stays; a comment at the head states the fitted numbers and the records.
 *  @param file     the mechanism file of the model
 *  @param options  as for lab_open: its overrides are part of the result
 *  @return OK, EIO, EPARSE, EINVAL (a number has no place in the file), ENOMEM */
stein_status lab_fit_write(const char *path, const lab_fit *fit, const char *file,
                           const lab_options *options, stein_err *err);

#ifdef __cplusplus
}
#endif
#endif
