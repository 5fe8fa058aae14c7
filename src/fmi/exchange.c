/* SPDX-License-Identifier: MIT
 * exchange.c - model exchange: the equations for an integrator of the importer.
 *
 * Guards, and the changes at their zeros, are the core's (step.c). The importer locates that
 * instant; in Event Mode it finds the guards on the other side, and they switch.
 */
#include <float.h>
#include <math.h>

#include "slave.h"

enum { MOST_SWITCHES = 50 }; /* of one instant */

int slave_states(const slave *s)
{
    return 2 * s->model.nq;
}

int slave_indicators(const slave *s)
{
    return fmi_guards(&s->model);
}

slave_status slave_set_now(slave *s, double t)
{
    if (!isfinite(t)) {
        return slave_refuse(
            s, stein__fail(&s->err, STEIN_EINVAL, "a time of %g s: expected a finite one", t));
    }
    s->sim->head->t = t - s->start;
    s->sim->fresh = STALE;
    return SLAVE_OK;
}

slave_status slave_put_states(slave *s, const double *x)
{
    for (int i = 0; i < s->model.nq; i++) {
        if (!isfinite(x[2 * i]) || !isfinite(x[2 * i + 1])) {
            return slave_refuse(s, stein__fail(&s->err, STEIN_EINVAL,
                                               "the states of joint %s are %g and %g: expected "
                                               "finite numbers",
                                               s->model.bodies[i].name, x[2 * i], x[2 * i + 1]));
        }
    }
    for (int i = 0; i < s->model.nq; i++) {
        s->sim->q[i] = x[2 * i];
        s->sim->qd[i] = x[2 * i + 1];
    }
    s->sim->fresh = STALE;
    return SLAVE_OK;
}

/* all of it at the present time and state */
static slave_status evaluate(slave *s)
{
    if (slave_settle(s) != SLAVE_OK) {
        return SLAVE_ERROR;
    }
    stein_status status = stein__refresh(s->sim, &s->err);
    return status == STEIN_OK ? SLAVE_OK : slave_refuse(s, status);
}

slave_status slave_get_states(slave *s, double *x)
{
    slave_status status = evaluate(s);
    for (int i = 0; status == SLAVE_OK && i < s->model.nq; i++) {
        x[2 * i] = s->sim->xq[i];
        x[2 * i + 1] = s->sim->xqd[i];
    }
    return status;
}

/* A state that does not exist - the importer may try one - is no reason to end: it is discarded. */
slave_status slave_get_rates(slave *s, double *rate)
{
    if (slave_settle(s) != SLAVE_OK) {
        return SLAVE_ERROR;
    }
    if (stein__refresh(s->sim, &s->err) != STEIN_OK) {
        slave_tell_discarded(s);
        return SLAVE_DISCARD;
    }
    for (int i = 0; i < s->model.nq; i++) {
        rate[2 * i] = s->sim->xqd[i];
        rate[2 * i + 1] = s->sim->qdd[i];
    }
    return SLAVE_OK;
}

slave_status slave_get_indicators(slave *s, double *z)
{
    slave_status status = evaluate(s);
    for (int i = 0; status == SLAVE_OK && i < slave_indicators(s); i++) {
        double guard = s->sim->guard[i]; // a place that begins to slip has the guard 0
        z[i] = i >= s->sim->nguard && guard >= 0.0 ? fmax(guard, DBL_MIN) : guard;
    }
    return status;
}

slave_status slave_complete(slave *s, int *event)
{
    slave_status status = evaluate(s);
    *event = status == SLAVE_OK && stein__any_crossed(s->sim);
    return status;
}

slave_status slave_update(slave *s, int *moved)
{
    slave_status status = evaluate(s);
    // at the start the modes follow from the initial state, also where a guard is 0 to rounding
    for (int n = 0; status == SLAVE_OK && s->sim->head->t > 0.0 && stein__any_crossed(s->sim);
         n++) {
        if (n == MOST_SWITCHES) {
            return slave_refuse(s, stein__fail(&s->err, STEIN_ECHATTER,
                                               "more than %d switches of contacts at t = %g s",
                                               (int)MOST_SWITCHES, s->start + s->sim->head->t));
        }
        stein__mark_crossed(s->sim);
        stein__flip_crossed(s->sim);
        s->jumped |= s->model.nstick > 0; // a place that sticks now is at rest
        status = evaluate(s);
    }
    *moved = s->jumped;
    s->jumped = 0;
    return status;
}
