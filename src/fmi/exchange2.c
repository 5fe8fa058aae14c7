/* SPDX-License-Identifier: MIT
 * exchange2.c - FMI 2.0, model exchange: as exchange3.c.
 */
#include "internal2.h"

/* an instance, a phase, as many numbers as there are. @return NULL after a refusal */
static slave *ready(fmi2Component c, const char *function, unsigned phases, size_t n, int wanted)
{
    slave *s = slave2_of(c);
    if (s == NULL || slave_allow(s, function, phases) != SLAVE_OK) {
        return NULL;
    }
    if (n != (size_t)wanted) {
        (void)slave_refuse(s, stein__fail(&s->err, STEIN_EINVAL, "%s: %d numbers, expected %d",
                                          function, (int)n, wanted));
        return NULL;
    }
    return s;
}

static int states_of(fmi2Component c)
{
    return c != NULL ? slave_states(slave2_of(c)) : 0;
}

enum { LATER = SLAVE_EVENTS | SLAVE_CONTINUOUS | SLAVE_INITIALIZING };

fmi2Status fmi2EnterEventMode(fmi2Component c)
{
    // the standard has an instance in Event Mode after initialization; reading it changes
    // nothing
    slave *s = ready(c, "fmi2EnterEventMode", SLAVE_CONTINUOUS | SLAVE_EVENTS, 0, 0);
    if (s == NULL) {
        return fmi2Error;
    }
    s->phase = SLAVE_EVENTS;
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info)
{
    slave *s = ready(c, "fmi2NewDiscreteStates", SLAVE_EVENTS, 0, 0);
    int moved = 0;
    if (s == NULL || slave_update(s, &moved) != SLAVE_OK) {
        return fmi2Error;
    }
    *info = (fmi2EventInfo){.valuesOfContinuousStatesChanged = moved};
    return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c)
{
    slave *s = ready(c, "fmi2EnterContinuousTimeMode", SLAVE_EVENTS, 0, 0);
    if (s == NULL) {
        return fmi2Error;
    }
    s->phase = SLAVE_CONTINUOUS;
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean noSetPrior,
                                       fmi2Boolean *enterEventMode, fmi2Boolean *terminate)
{
    slave *s = ready(c, "fmi2CompletedIntegratorStep", SLAVE_CONTINUOUS, 0, 0);
    int event = 0;
    (void)noSetPrior;
    if (s == NULL || slave_complete(s, &event) != SLAVE_OK) {
        return fmi2Error;
    }
    *enterEventMode = event != 0;
    *terminate = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time)
{
    slave *s = ready(c, "fmi2SetTime", SLAVE_CONTINUOUS | SLAVE_EVENTS, 0, 0);
    return s != NULL ? status2(slave_set_now(s, time)) : fmi2Error;
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx)
{
    slave *s = ready(c, "fmi2SetContinuousStates", SLAVE_CONTINUOUS, nx, states_of(c));
    return s != NULL ? status2(slave_put_states(s, x)) : fmi2Error;
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx)
{
    slave *s = ready(c, "fmi2GetContinuousStates", LATER, nx, states_of(c));
    return s != NULL ? status2(slave_get_states(s, x)) : fmi2Error;
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx)
{
    slave *s = ready(c, "fmi2GetDerivatives", LATER, nx, states_of(c));
    return s != NULL ? status2(slave_get_rates(s, derivatives)) : fmi2Error;
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real indicators[], size_t ni)
{
    int wanted = c != NULL ? slave_indicators(slave2_of(c)) : 0;
    slave *s = ready(c, "fmi2GetEventIndicators", LATER, ni, wanted);
    return s != NULL ? status2(slave_get_indicators(s, indicators)) : fmi2Error;
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real nominals[], size_t nx)
{
    slave *s = ready(c, "fmi2GetNominalsOfContinuousStates", SLAVE_ANY, nx, states_of(c));
    for (size_t i = 0; s != NULL && i < nx; i++) {
        nominals[i] = 1.0;
    }
    return s != NULL ? fmi2OK : fmi2Error;
}
