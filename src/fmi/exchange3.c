/* SPDX-License-Identifier: MIT
 * exchange3.c - FMI 3.0, model exchange.
 *
 * Event Mode and Continuous-Time Mode of chapter 3 of the standard. There are no events in time:
 * whatever happens is announced by an indicator.
 */
#include "internal3.h"

/* an instance, a phase, as many numbers as there are. @return NULL after a refusal */
static slave *ready(fmi3Instance c, const char *function, unsigned phases, size_t n, int wanted)
{
    slave *s = slave3_of(c);
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

static int states_of(fmi3Instance c)
{
    return c != NULL ? slave_states(slave3_of(c)) : 0;
}

static int indicators_of(fmi3Instance c)
{
    return c != NULL ? slave_indicators(slave3_of(c)) : 0;
}

enum { LATER = SLAVE_RUNNING & ~SLAVE_STEPPING };

/* ---- modes ---- */

fmi3Status fmi3EnterEventMode(fmi3Instance c)
{
    slave *s = ready(c, "fmi3EnterEventMode", SLAVE_CONTINUOUS, 0, 0);
    if (s == NULL) {
        return fmi3Error;
    }
    s->phase = SLAVE_EVENTS;
    return fmi3OK;
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c)
{
    slave *s = ready(c, "fmi3EnterContinuousTimeMode", SLAVE_EVENTS, 0, 0);
    if (s == NULL) {
        return fmi3Error;
    }
    s->phase = SLAVE_CONTINUOUS;
    return fmi3OK;
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance c)
{
    return ready(c, "fmi3EvaluateDiscreteStates", SLAVE_EVENTS, 0, 0) != NULL ? fmi3OK : fmi3Error;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *needUpdate, fmi3Boolean *terminate,
                                    fmi3Boolean *nominalsChanged, fmi3Boolean *valuesChanged,
                                    fmi3Boolean *nextTimeDefined, fmi3Float64 *nextTime)
{
    slave *s = ready(c, "fmi3UpdateDiscreteStates", SLAVE_EVENTS, 0, 0);
    int moved = 0;
    if (s == NULL || slave_update(s, &moved) != SLAVE_OK) {
        return fmi3Error;
    }
    *needUpdate = *terminate = *nominalsChanged = *nextTimeDefined = fmi3False;
    *valuesChanged = moved != 0;
    *nextTime = 0.0;
    return fmi3OK;
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean noSetPrior,
                                       fmi3Boolean *enterEventMode, fmi3Boolean *terminate)
{
    slave *s = ready(c, "fmi3CompletedIntegratorStep", SLAVE_CONTINUOUS, 0, 0);
    int event = 0;
    (void)noSetPrior;
    if (s == NULL || slave_complete(s, &event) != SLAVE_OK) {
        return fmi3Error;
    }
    *enterEventMode = event != 0;
    *terminate = fmi3False;
    return fmi3OK;
}

/* ---- time and states ---- */

fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 time)
{
    slave *s = ready(c, "fmi3SetTime", SLAVE_CONTINUOUS, 0, 0);
    return s != NULL ? status3(slave_set_now(s, time)) : fmi3Error;
}

fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 states[], size_t n)
{
    slave *s = ready(c, "fmi3SetContinuousStates", SLAVE_CONTINUOUS, n, states_of(c));
    return s != NULL ? status3(slave_put_states(s, states)) : fmi3Error;
}

fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 states[], size_t n)
{
    slave *s = ready(c, "fmi3GetContinuousStates", LATER | SLAVE_INITIALIZING, n, states_of(c));
    return s != NULL ? status3(slave_get_states(s, states)) : fmi3Error;
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 derivatives[], size_t n)
{
    slave *s =
        ready(c, "fmi3GetContinuousStateDerivatives", LATER | SLAVE_INITIALIZING, n, states_of(c));
    return s != NULL ? status3(slave_get_rates(s, derivatives)) : fmi3Error;
}

fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 indicators[], size_t n)
{
    slave *s = ready(c, "fmi3GetEventIndicators", LATER | SLAVE_INITIALIZING, n, indicators_of(c));
    return s != NULL ? status3(slave_get_indicators(s, indicators)) : fmi3Error;
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 nominals[], size_t n)
{
    slave *s = ready(c, "fmi3GetNominalsOfContinuousStates", LATER, n, states_of(c));
    for (size_t i = 0; s != NULL && i < n; i++) {
        nominals[i] = 1.0;
    }
    return s != NULL ? fmi3OK : fmi3Error;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *n)
{
    slave *s = ready(c, "fmi3GetNumberOfEventIndicators", SLAVE_ANY, 0, 0);
    if (s == NULL) {
        return fmi3Error;
    }
    *n = (size_t)slave_indicators(s);
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *n)
{
    slave *s = ready(c, "fmi3GetNumberOfContinuousStates", SLAVE_ANY, 0, 0);
    if (s == NULL) {
        return fmi3Error;
    }
    *n = (size_t)slave_states(s);
    return fmi3OK;
}
