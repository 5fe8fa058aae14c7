/* SPDX-License-Identifier: GPL-3.0-or-later
 * lab.h - the laboratory on top of the core: mechanism files, strokes, facts. libsteinlab.a.
 *
 * The lab uses files, memory and GSL as it pleases; the core below it does not. It reports like the
 * core: a status and a message, nothing printed, nothing exits.
 */
#ifndef STEIN_LAB_H
#define STEIN_LAB_H

#include "stein/sim.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A mechanism file, read, with its equations - built in, or generated, compiled and loaded. */
typedef struct lab_model lab_model;

/** Receives every problem of a file, "file:line:column: ...". */
typedef void lab_report_fn(void *ctx, const char *message);

/** Where equations come from and who hears about it. Start from lab_options_default(). */
typedef struct lab_options {
    const char *const *set; /* "NAME=VALUE[unit]" overrides */
    int nset;
    const char *cache;      /* folder of compiled equations; NULL: $XDG_CACHE_HOME/stein or ~/.cache/stein */
    const char *cc;         /* compiler; NULL: $CC or "cc" */
    lab_report_fn *report;  /* may be NULL */
    void *ctx;
} lab_options;
lab_options lab_options_default(void);

/** Read a file and get its equations. A mechanism whose equations hash equals that of a built-in
 *  model uses those; any other is generated, compiled into the cache and loaded.
 *  @return OK, EIO, EPARSE, ENOMEM, EGENERATE, ECOMPILE, ELOAD, ESTALE */
stein_status lab_open(lab_model **out, const char *file, const lab_options *options, stein_err *err);
void lab_close(lab_model *model);
/** The equations; their default parameters may differ from the file's (see lab_parameters). */
const stein_model *lab_equations(const lab_model *model);
/** The file's parameter values after overrides, [np] in the order of the equations' params. */
const double *lab_parameters(const lab_model *model);
/** A simulation with the file's parameters, step and integrator, in its initial state.
 *  @param def  NULL for the file's */
stein_status lab_sim(const lab_model *model, const stein_sim_def *def, stein_sim **sim,
                     stein_err *err);
/** The file's own step, integrator and allocator. */
stein_sim_def lab_def(const lab_model *model);
/** Duration the file asks for [s]. */
double lab_until(const lab_model *model);

typedef enum { LAB_STRUCK, LAB_MISSED_NOTCH, LAB_NO_ESCAPEMENT, LAB_NO_IMPACT } lab_outcome;
/** "struck", "missed_notch", "no_escapement", "no_impact". */
const char *lab_outcome_text(lab_outcome outcome);

/** What happened in one stroke [SI]. Times count from the release of the load. */
typedef struct lab_stroke {
    lab_outcome outcome;
    int escaped;
    double escape_time, escape_height; /* head to string at escapement [s], [m] */
    int impacts;
    double impact_time, impact_speed; /* first impact [s], closing speed of head and string [m/s] */
    double free_flight;               /* impact - escapement [s]; 0 unless escapement came first */
    int forced_escapement;            /* escaped after the first impact */
    double peak_string_force;         /* [N] */
    int rearmed;                      /* beak back under the roof at the end */
} lab_stroke;

/** Called after every step (and at t = 0) for recording. @return 0 to go on */
typedef int lab_sample_fn(void *ctx, stein_sim *sim);

/** How to run a stroke. */
typedef struct lab_stroke_def {
    double until;   /* [s] */
    double release; /* the load is lifted at this time [s]; NAN: never */
    double every;   /* sampling interval [s]; 0: every step */
    lab_sample_fn *sample; /* may be NULL */
    void *ctx;
} lab_stroke_def;

/** Run one stroke from the simulation's present (freshly reset) state.
 *  @return OK or a numerical failure of stein_run; EINVAL when the model names no stroke */
stein_status lab_strike(stein_sim *sim, const lab_stroke_def *def, lab_stroke *stroke,
                        stein_err *err);

#ifdef __cplusplus
}
#endif
#endif
