/* SPDX-License-Identifier: MIT
 * stiff.c - which steps are implicit, and which are not.
 *
 * Explicit steps are limited by stability where h rho is at the border of the stability
 * region, rho being the rate of the fastest decay. Of the stages at the end of a step, y7 and g6 at
 * the same time, rho = |f(y7) - f(g6)| / |y7 - g6| (Hairer, Norsett & Wanner 1993, IV.2: 3.25 for
 * Dormand & Prince, 15 times without 6 in between that are not). In implicit steps, rho is what a
 * power iteration finds of f_y; where explicit steps of the same length would be stable for 10
 * steps, they come back. This memory is part of the state.
 */
#include <math.h>

#include "core.h"

enum { TIMES_STIFF = 15, TIMES_BETWEEN = 6, TIMES_CALM = 10 };
static const double border = 3.25;   /* of h rho for explicit steps */
static const double well_inside = 2; /* of it */

/* why the motion has no implicit steps as it is now, NULL: it has */
static const char *refusal(const stein_sim *sim)
{
    return sim->implicit == NULL       ? "the equations came without derivatives"
           : sim->on_force != NULL     ? "a force hook has no derivative"
           : sim->signals              ? "a signal has no derivative by time"
           : sim->follower_is_explicit ? "sensitivities go with explicit steps"
                                       : NULL;
}

int stein__is_implicit(stein_sim *sim)
{
    int always = sim->def.integrator == STEIN_IMPLICIT;
    const char *why = always || sim->head->implicit ? refusal(sim) : "";
    if (always) {
        sim->counts.refused = why;
    }
    return why == NULL;
}

void stein__implicit_leave(stein_sim *sim)
{
    if (sim->implicit != NULL) {
        sim->implicit->placed = sim->implicit->inside = 0;
    }
}

/* a kind of step begins */
static void change(stein_sim *sim, int implicit)
{
    sim->head->implicit = (unsigned char)implicit;
    sim->head->stiff = sim->head->calm = 0;
}

/* explicit steps of h, with that h rho, are stiff. @return do implicit ones follow? */
static int begin_implicit(stein_sim *sim, double h, double stiffness)
{
    sim->counts.refused = refusal(sim);
    if (!(sim->counts.rate > 0.0)) {
        sim->counts.rate = stiffness / h;
        sim->counts.first = sim->head->t;
    }
    change(sim, sim->counts.refused == NULL);
    sim->counts.changes += sim->head->implicit;
    return sim->head->implicit;
}

int stein__begin_implicit(stein_sim *sim, double h)
{
    return sim->def.integrator == STEIN_CONTROLLED && !sim->head->implicit &&
           begin_implicit(sim, h, border);
}

void stein__note_explicit(stein_sim *sim, double h, double stiffness)
{
    state_head *head = sim->head;
    if (stiffness > border) {
        head->calm = 0;
        head->stiff++;
    } else if (head->stiff > 0 && ++head->calm >= TIMES_BETWEEN) {
        change(sim, 0);
    }
    if (head->stiff >= TIMES_STIFF) {
        (void)begin_implicit(sim, h, stiffness);
    }
}

void stein__note_implicit(stein_sim *sim, double h)
{
    state_head *head = sim->head;
    if (sim->def.integrator == STEIN_IMPLICIT) {
        return;
    }
    head->calm = sim->implicit->h_rho(sim, h) < well_inside ? (unsigned char)(head->calm + 1) : 0;
    if (head->calm >= TIMES_CALM) {
        change(sim, 0);
    }
}

void stein_steps_taken(const stein_sim *sim, stein_step_counts *counts)
{
    *counts = sim->counts;
}
