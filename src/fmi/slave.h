/* SPDX-License-Identifier: MIT
 * slave.h - one instance of a mechanism, whatever the version of FMI: in a co-simulation, or as
 * equations that the importer integrates (model exchange).
 *
 *   fmi3.c, fmi2.c  the functions of the two standards       slave.c        life, variables, steps
 *   exchange3.c     those of FMI 3 for model exchange        exchange.c     states, events
 *   none3.c         those of FMI 3 that an FMU like this     slave_state.c  states kept and sent
 *                   does not have                            slave_slope.c  derivatives
 *   fmi3.h, fmi2.h  their declarations                       variables.h    value references
 *
 * Compiled when an FMU is written, together with src/core, the equations of one mechanism and
 * fmu_model.c, which holds the values of its file. An instance owns its memory, all of it taken by
 * slave_create; after that only slave_keep with nothing to write into and slave_unpack take some.
 * So a step allocates nothing, and any number of instances may run on as many threads.
 *
 * Times of the importer are counted from its start time; the mechanism's own time starts at 0.
 * Included by: this folder.
 */
#ifndef FMI_SLAVE_H
#define FMI_SLAVE_H

#include "core.h"
#include "variables.h"

/** Data of a mechanism file in fmu_model.c. */
typedef struct slave_model {
    const stein_model *equations;
    const char *token;            /* instantiation token, GUID */
    const double *values;         /* [np] of the file */
    const unsigned char *tunable; /* [np] 1: may be changed while it runs */
    double dt;                    /* [s] */
    int integrator, settle;
} slave_model;
extern const slave_model slave_the_model;

typedef enum { SLAVE_OK, SLAVE_DISCARD, SLAVE_ERROR } slave_status;

/** State of an instance; one bit each, for lists of allowed states. */
typedef enum {
    SLAVE_INSTANTIATED = 1,
    SLAVE_INITIALIZING = 2, /* Initialization Mode */
    SLAVE_STEPPING = 4,     /* Step Mode */
    SLAVE_FAILED = 8,       /* FMI 2: the last step was discarded */
    SLAVE_TERMINATED = 16,
    SLAVE_BROKEN = 32,      /* after an error */
    SLAVE_EVENTS = 64,      /* model exchange: Event Mode */
    SLAVE_CONTINUOUS = 128, /* model exchange: Continuous-Time Mode */
    SLAVE_RUNNING = SLAVE_STEPPING | SLAVE_EVENTS | SLAVE_CONTINUOUS,
    SLAVE_ANY = 255
} slave_phase;

/** Logged categories; one bit each. */
typedef enum {
    SLAVE_LOG_EVENTS = 1,
    SLAVE_LOG_DISCARD = 2,
    SLAVE_LOG_ERROR = 4,
    SLAVE_LOG_REFUSED = SLAVE_LOG_DISCARD | SLAVE_LOG_ERROR
} slave_category;
enum { SLAVE_CATEGORIES = 3 };
extern const char *const slave_category_name[SLAVE_CATEGORIES];

/** One line to the importer. @param category  index into slave_category_name */
typedef void slave_log_fn(void *ctx, slave_status status, int category, const char *message);

/** An input and how it goes on: value, first and second time derivative at `since`. */
typedef struct slave_input {
    double u[3];
    double since; /* [s] of the mechanism; no number: never set */
    int follow;   /* MOTION: the joint follows it */
    int bound;
} slave_input;

typedef struct slave {
    stein_model model; /* with the values of the file */
    stein_param *params;
    stein_sim *sim;
    double *p;          /* [np] as the importer has set them */
    slave_input *input; /* [ninput] */
    int load;           /* is the free load to be there? */
    double dt;          /* [s] */
    double start, stop; /* [s]; stop INFINITY: none */
    slave_phase phase;
    int exchange;        /* 1: the importer integrates */
    int jumped;          /* 1: states have changed since the last report to the importer */
    int changed;         /* p is newer than the simulation's parameters */
    int unsettled;       /* Initialization Mode: the initial state is older than its parameters */
    unsigned char *kept; /* state at the beginning of a step */
    double reached;      /* end of the last step that succeeded [s] */
    unsigned log;        /* enabled categories */
    slave_log_fn *tell;
    void *ctx;
    stein_err err;
} slave;

/* ---- slave.c ---- */

/** @param exchange  1: for model exchange  @param log  enabled categories  @return NULL after
 *  telling why */
slave *slave_create(const char *name, const char *token, int exchange, slave_log_fn *tell,
                    void *ctx, unsigned log);
void slave_destroy(slave *s);
/** Log s->err, which stein__fail has just written, and go to SLAVE_BROKEN.
 *  @param why  what stein__fail returned  @return SLAVE_ERROR */
slave_status slave_refuse(slave *s, stein_status why);
/** Log s->err as the reason of a discarded step. */
void slave_tell_discarded(slave *s);
/** Is a function allowed now? @param phases  bits  @return SLAVE_OK or, refused, SLAVE_ERROR */
slave_status slave_allow(slave *s, const char *function, unsigned phases);
/** Turn categories on or off. @param n  0: all of them */
slave_status slave_set_log(slave *s, int on, size_t n, const char *const *names);

/** State after creation. */
slave_status slave_reset(slave *s);
slave_status slave_set_time(slave *s, double start, double stop);
slave_status slave_enter_initialization(slave *s);
slave_status slave_exit_initialization(slave *s);

/** One variable [SI]; Booleans apart. */
slave_status slave_get(slave *s, unsigned reference, double *value);
slave_status slave_set(slave *s, unsigned reference, double value);
slave_status slave_get_flag(slave *s, unsigned reference, int *value);
slave_status slave_set_flag(slave *s, unsigned reference, int value);
/** Time derivative of a force input at the present time; order 1 or 2. */
slave_status slave_set_slope(slave *s, unsigned reference, int order, double value);
/** An input has changed: let the simulation call it, or no longer. */
void slave_bind(slave *s, int input);
/** Pass the set values to the simulation. */
slave_status slave_settle(slave *s);

/** From `at` on by h. A step that fails numerically is logged and discarded; the instance keeps its
 *  earlier state. */
slave_status slave_step(slave *s, double at, double h);

/* ---- exchange.c: model exchange ----
 *
 * The continuous states are q and qd of every joint, side by side: {q_0, qd_0, q_1, ...}. A joint
 * that follows a signal has the state of the signal, whatever its states are set to. Event
 * indicators are the guards of contacts and notches, > 0 where their force acts; modes are memory
 * and change in Event Mode only, so between events the equations are smooth. */

int slave_states(const slave *s);
int slave_indicators(const slave *s);
slave_status slave_set_now(slave *s, double t);
slave_status slave_put_states(slave *s, const double *x);
slave_status slave_get_states(slave *s, double *x);
slave_status slave_get_rates(slave *s, double *rate);
slave_status slave_get_indicators(slave *s, double *z);
/** Does the sign of an indicator differ from the memory? */
slave_status slave_complete(slave *s, int *event);
/** Indicators with a changed sign switch, set values act. @param moved  out: 1: a state has jumped
 * (the
 *  load that is put back) */
slave_status slave_update(slave *s, int *moved);

/* ---- slave_state.c: everything that decides how it goes on, as a block ----
 *
 * These six are the functions of the standards with other names: an instance or an argument may
 * be missing, which is refused in the name of `function`. */

/** Keep the state. @param block  in: NULL or one of slave_keep; out: the state */
slave_status slave_keep(slave *s, const char *function, void **block);
/** Back to a kept state. */
slave_status slave_take(slave *s, const char *function, const void *block);
/** Give a kept state back; *block becomes NULL. */
slave_status slave_free(const slave *s, void **block);
/** A kept state as bytes, and back; bytes may come from anywhere. @param n  room, or bytes */
slave_status slave_size(slave *s, const char *function, const void *block, size_t *size);
slave_status slave_pack(slave *s, const char *function, const void *block, void *bytes, size_t n);
slave_status slave_unpack(slave *s, const char *function, const void *bytes, size_t n,
                          void **block);

/* ---- slave_slope.c ---- */

/** d unknown / d known at the present communication point, or in Initialization Mode through the
 *  initial state. */
slave_status slave_slope(slave *s, unsigned unknown, unsigned known, double *slope);

#endif
