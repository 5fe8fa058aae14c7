/* SPDX-License-Identifier: GPL-3.0-or-later
 * step_tolerance.c - how many runs are stepped, and the tolerance of their steps.
 *
 * A tolerance is stated for an output channel that shows a place, in its unit: an error that a
 * reader of results understands. Steps are controlled by their errors in the coordinates [rad or
 * m]. With
 *
 *      slope = max over j of |dh/dq_j|      of the channel h, in the initial state
 *
 * a step's error of e in a coordinate is one of slope e at most in the channel. In strokes of the
 * 1788 action the channel is off by 3 to 1900 times that (dx = -1.2 .. 0.25 mm, steps of 1e-11 to
 * 1e-9). The errors of a thousand steps add up, and impacts enlarge them. So
 *
 *      tolerance of a step = stated / (3000 slope)
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "run.h"

static const double lasting = 3000.0;
static const double longest = 30.0; /* of the file's steps */
static const double nudge = 1e-7;   /* [rad or m] for the slope */

/* "CHANNEL=VALUE[unit]" */
static stein_status read_stated(lab__steps *steps, const stein_model *m, const char *text,
                                stein_err *err)
{
    const char *value = strchr(text, '=');
    char name[MECH_NAME];
    if (value == NULL || value == text || (size_t)(value - text) >= sizeof name) {
        return lab__fail(err, STEIN_EINVAL,
                         "tolerance %s: expected CHANNEL=VALUE[unit], e.g. string_distance=0.1um",
                         text);
    }
    memcpy(name, text, (size_t)(value - text));
    name[value - text] = '\0';
    steps->channel = stein_find_channel(m, name);
    if (steps->channel < 0) {
        return lab__fail(err, STEIN_ENAME, "tolerance %s: \"%s\" has no output %s", text, m->name,
                         name);
    }
    stein_err why;
    if (lab_quantity(&steps->stated, value + 1, m->channels[steps->channel].unit, &why) !=
        STEIN_OK) {
        return lab__fail(err, STEIN_EINVAL, "tolerance %s: %s", text, why.msg);
    }
    return STEIN_OK;
}

/* the channel with coordinate j moved by d, everything else as in q, qd */
static stein_status read_beside(double *h, stein_sim *sim, int channel, double *q, double *qd,
                                int j, double d, stein_err *err)
{
    double q0 = q[j];
    q[j] += d;
    stein_status status = stein_set_state(sim, 0.0, q, qd, err);
    q[j] = q0;
    *h = status == STEIN_OK ? stein_read(sim, channel) : 0.0;
    return status;
}

/* largest |dh/dq_j| of the channel in the initial state */
static stein_status find_slope(double *slope, const lab_model *model, int channel, stein_err *err)
{
    size_t nq = (size_t)lab_equations(model)->nq;
    double *q = malloc(sizeof *q * 2 * (nq + 1));
    stein_sim *sim = NULL;
    *slope = 0.0;
    if (q == NULL) {
        return lab__no_memory(err);
    }
    stein_status status = lab_sim(model, NULL, &sim, err);
    if (status == STEIN_OK) {
        memcpy(q, stein_q(sim), sizeof *q * nq);
        memcpy(q + nq, stein_qd(sim), sizeof *q * nq);
    }
    for (int j = 0; status == STEIN_OK && j < (int)nq; j++) {
        double up, down = 0.0;
        status = read_beside(&up, sim, channel, q, q + nq, j, nudge, err);
        status = status == STEIN_OK ? read_beside(&down, sim, channel, q, q + nq, j, -nudge, err)
                                    : status;
        *slope = fmax(*slope, fabs(up - down) / (2.0 * nudge));
    }
    stein_sim_destroy(sim);
    free(q);
    return status;
}

stein_status lab__steps_of(lab__steps *steps, const lab_model *model, const char *stated, int fixed,
                           stein_err *err)
{
    const stein_model *m = lab_equations(model);
    const mechanism *mech = lab__mechanism(model);
    double slope = 0.0;
    *steps = (lab__steps){.channel = -1, .longest = longest * m->dt};
    stein_status status = STEIN_OK;
    if (fixed) {
        return stated == NULL
                   ? STEIN_OK
                   : lab__fail(err, STEIN_EINVAL, "tolerance %s: fixed steps have none", stated);
    }
    if (stated != NULL) {
        status = read_stated(steps, m, stated, err);
    } else if (mech->tolerance > 0.0) {
        steps->channel = stein_find_channel(m, mech->channels[mech->tolerated].name);
        steps->stated = mech->tolerance;
    }
    if (status != STEIN_OK || steps->channel < 0) {
        return status;
    }
    const stein_channel *c = &m->channels[steps->channel];
    if (!stein_reads_place((int)c->read) || !(steps->stated > 0.0) || !isfinite(steps->stated)) {
        return lab__fail(
            err, STEIN_EINVAL,
            "a tolerance of %g %s in \"%s\": expected a positive one in an output that "
            "reads a position, x, y, z or gap",
            steps->stated, c->unit, c->name);
    }
    status = find_slope(&slope, model, steps->channel, err);
    if (status == STEIN_OK && !(slope > 0.0)) {
        return lab__fail(err, STEIN_EINVAL,
                         "a tolerance in \"%s\": no coordinate moves it in the initial state",
                         c->name);
    }
    steps->tolerance = steps->stated / (lasting * slope);
    return status;
}
