/* SPDX-License-Identifier: MIT
 * variables.h - the variables of an FMU and their value references.
 *
 * A value reference is a place in this row. The writer of modelDescription.xml and the FMU both
 * compute it from the sizes of the model, so there is no table that could differ.
 *
 *      channel 0 (time), 1, ...                  [nchannel]
 *      input 0: value, speed, acceleration, ...  [3*ninput]  the last two only of a motion
 *      does a joint follow input 0, 1, ...       [ninput]    only of a motion, Boolean
 *      is the free load there?                   [0 or 1]    Boolean
 *      parameter 0, 1, ...                       [np]
 *      step of the integrator                    [1]
 *      q, qd, qdd of joint 0, 1, ...             [3*nq]
 *      guard of spot 0, 1, ..., of notches       [nspot + 4*nnotch]
 * Included by: this folder, src/lab/fmu.
 */
#ifndef FMI_VARIABLES_H
#define FMI_VARIABLES_H

#include "stein/model.h"

typedef enum {
    FMI_CHANNEL,
    FMI_INPUT,
    FMI_FOLLOW,
    FMI_LOAD,
    FMI_PARAMETER,
    FMI_STEP,
    FMI_COORDINATE,
    FMI_GUARD
} fmi_kind;

enum { FMI_NOTCH_GUARDS = 4 };

typedef struct fmi_variable {
    fmi_kind kind;
    int index; /* of the channel, input, parameter, joint or guard */
    int order; /* INPUT, COORDINATE: time derivative */
} fmi_variable;

/** Where a kind begins. */
static inline unsigned fmi_first(const stein_model *m, fmi_kind kind)
{
    int at = 0;
    at += kind > FMI_CHANNEL ? m->nchannel : 0;
    at += kind > FMI_INPUT ? 3 * m->ninput : 0;
    at += kind > FMI_FOLLOW ? m->ninput : 0;
    at += kind > FMI_LOAD && m->load.body >= 0 ? 1 : 0;
    at += kind > FMI_PARAMETER ? m->np : 0;
    at += kind > FMI_STEP ? 1 : 0;
    at += kind > FMI_COORDINATE ? 3 * m->nq : 0;
    return (unsigned)at;
}

/** Of all contacts and notches; one changes its sign where a law switches. */
static inline int fmi_guards(const stein_model *m)
{
    return m->nspot + FMI_NOTCH_GUARDS * m->nnotch + m->nstick;
}

static inline unsigned fmi_reference(const stein_model *m, fmi_variable v)
{
    int has_orders = v.kind == FMI_INPUT || v.kind == FMI_COORDINATE;
    int at = has_orders ? 3 * v.index + v.order : v.index;
    return fmi_first(m, v.kind) + (unsigned)at;
}

static inline int fmi_is_boolean(fmi_kind kind)
{
    return kind == FMI_FOLLOW || kind == FMI_LOAD;
}

/** The variable of a reference. @return 0 when there is none */
static inline int fmi_find(const stein_model *m, unsigned reference, fmi_variable *v)
{
    if (reference >= fmi_first(m, FMI_GUARD) + (unsigned)fmi_guards(m)) {
        return 0;
    }
    fmi_kind kind = FMI_GUARD;
    while (reference < fmi_first(m, kind)) {
        kind = (fmi_kind)(kind - 1);
    }
    int at = (int)(reference - fmi_first(m, kind));
    int step = kind == FMI_INPUT || kind == FMI_COORDINATE ? 3 : 1;
    *v = (fmi_variable){kind, at / step, at % step};
    int of_motion = kind == FMI_FOLLOW || (kind == FMI_INPUT && v->order > 0);
    return !of_motion || m->inputs[v->index].kind == STEIN_INPUT_MOTION;
}

#endif
