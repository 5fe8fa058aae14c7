/* SPDX-License-Identifier: MIT
 * fmi3.c - FMI 3.0: the functions that have something to do; the functions of model exchange are in
 * exchange3.c.
 *
 * In co-simulation a simple slave: no clocks, no event mode (located events are handled inside of a
 * step), no intermediate update, no early return. Other functions of the standard are in none3.c.
 *
 * After an error an instance is over, as the standard has it (2.3.1): it can be read, reset, freed
 * or set to a state kept before. A step that fails numerically is discarded and the instance keeps
 * its earlier state; with other inputs, other parameters or a shorter step it may go on.
 */
#include <math.h>
#include <stdlib.h>

#include "internal3.h"

/* where the messages of an instance go */
typedef struct instance {
    slave *slave;
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
} instance;

enum { READABLE = SLAVE_ANY & ~SLAVE_INSTANTIATED };

fmi3Status status3(slave_status status)
{
    return status == SLAVE_OK ? fmi3OK : status == SLAVE_DISCARD ? fmi3Discard : fmi3Error;
}

static void tell3(void *ctx, slave_status status, int category, const char *message)
{
    const instance *in = ctx;
    if (in->log != NULL) {
        in->log(in->environment, status3(status), slave_category_name[category], message);
    }
}

slave *slave3_of(fmi3Instance c)
{
    return c != NULL ? ((instance *)c)->slave : NULL;
}

/* refuse for a reason without numbers */
static fmi3Status refuse(slave *s, const char *why)
{
    return status3(slave_refuse(s, stein__fail(&s->err, STEIN_EINVAL, "%s", why)));
}

/* ---- life ---- */

const char *fmi3GetVersion(void)
{
    return "3.0";
}

/* refusals are always logged, events on request */
fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t n,
                               const fmi3String categories[])
{
    slave *s = slave3_of(c);
    if (s == NULL) {
        return fmi3Error;
    }
    if (n > 0 && categories == NULL) {
        return refuse(s, "fmi3SetDebugLogging without categories");
    }
    slave_status status = slave_set_log(s, on, n, categories);
    s->log |= SLAVE_LOG_REFUSED;
    return status3(status);
}

/* before there is an instance */
static void tell_early(fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                       const char *message)
{
    if (log != NULL) {
        log(environment, fmi3Error, slave_category_name[2], message);
    }
}

static fmi3Instance create(fmi3String name, fmi3String token, int exchange, fmi3Boolean loggingOn,
                           fmi3InstanceEnvironment environment, fmi3LogMessageCallback log)
{
    instance *in = malloc(sizeof *in);
    if (in == NULL) {
        tell_early(environment, log, "out of memory");
        return NULL;
    }
    *in = (instance){NULL, log, environment};
    in->slave = slave_create(name, token, exchange, tell3, in, loggingOn ? ~0u : SLAVE_LOG_REFUSED);
    if (in->slave == NULL) {
        free(in);
        return NULL;
    }
    return in;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resourcePath,
                                         fmi3Boolean visible, fmi3Boolean loggingOn,
                                         fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
                                         const fmi3ValueReference intermediate[],
                                         size_t nintermediate, fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update)
{
    (void)resourcePath, (void)visible, (void)earlyReturnAllowed, (void)intermediate, (void)update;
    if (eventModeUsed || nintermediate > 0) {
        tell_early(environment, log,
                   eventModeUsed ? "this FMU has no event mode (hasEventMode is false)"
                                 : "this FMU has no variables for intermediate updates");
        return NULL;
    }
    return create(name, token, 0, loggingOn, environment, log);
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token,
                                          fmi3String resourcePath, fmi3Boolean visible,
                                          fmi3Boolean loggingOn,
                                          fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback log)
{
    (void)resourcePath, (void)visible;
    return create(name, token, 1, loggingOn, environment, log);
}

fmi3Instance
fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resourcePath,
                                  fmi3Boolean visible, fmi3Boolean loggingOn,
                                  fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                  fmi3ClockUpdateCallback clock, fmi3LockPreemptionCallback lock,
                                  fmi3UnlockPreemptionCallback unlock)
{
    (void)name, (void)token, (void)resourcePath, (void)visible, (void)loggingOn;
    (void)clock, (void)lock, (void)unlock;
    tell_early(environment, log, "this FMU is for co-simulation and model exchange");
    return NULL;
}

void fmi3FreeInstance(fmi3Instance c)
{
    if (c != NULL) {
        slave_destroy(slave3_of(c));
        free(c);
    }
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean toleranceDefined,
                                       fmi3Float64 tolerance, fmi3Float64 startTime,
                                       fmi3Boolean stopTimeDefined, fmi3Float64 stopTime)
{
    slave *s = slave3_of(c);
    (void)toleranceDefined, (void)tolerance; // steps are fixed
    if (s == NULL || slave_allow(s, "fmi3EnterInitializationMode", SLAVE_INSTANTIATED) ||
        slave_set_time(s, startTime, stopTimeDefined ? stopTime : (double)INFINITY)) {
        return fmi3Error;
    }
    return status3(slave_enter_initialization(s));
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c)
{
    slave *s = slave3_of(c);
    if (s == NULL || slave_allow(s, "fmi3ExitInitializationMode", SLAVE_INITIALIZING)) {
        return fmi3Error;
    }
    return status3(slave_exit_initialization(s));
}

fmi3Status fmi3Terminate(fmi3Instance c)
{
    slave *s = slave3_of(c);
    if (s == NULL || slave_allow(s, "fmi3Terminate", SLAVE_RUNNING)) {
        return fmi3Error;
    }
    s->phase = SLAVE_TERMINATED;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance c)
{
    slave *s = slave3_of(c);
    return s != NULL ? status3(slave_reset(s)) : fmi3Error;
}

/* ---- variables ---- */

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference references[], size_t nreferences,
                          fmi3Float64 values[], size_t nvalues)
{
    slave *s = slave3_of(c);
    if (s == NULL) {
        return fmi3Error;
    }
    if (nvalues != nreferences) {
        return refuse(s, "fmi3GetFloat64: all variables are scalars, so there is one value each");
    }
    for (size_t i = 0; i < nreferences; i++) {
        if (slave_get(s, references[i], &values[i]) != SLAVE_OK) {
            return fmi3Error;
        }
    }
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference references[], size_t nreferences,
                          const fmi3Float64 values[], size_t nvalues)
{
    slave *s = slave3_of(c);
    if (s == NULL) {
        return fmi3Error;
    }
    if (nvalues != nreferences) {
        return refuse(s, "fmi3SetFloat64: all variables are scalars, so there is one value each");
    }
    for (size_t i = 0; i < nreferences; i++) {
        if (slave_set(s, references[i], values[i]) != SLAVE_OK) {
            return fmi3Error;
        }
    }
    return fmi3OK;
}

fmi3Status fmi3GetBoolean(fmi3Instance c, const fmi3ValueReference references[], size_t nreferences,
                          fmi3Boolean values[], size_t nvalues)
{
    slave *s = slave3_of(c);
    if (s == NULL) {
        return fmi3Error;
    }
    if (nvalues != nreferences) {
        return refuse(s, "fmi3GetBoolean: all variables are scalars, so there is one value each");
    }
    for (size_t i = 0; i < nreferences; i++) {
        int value = 0;
        if (slave_get_flag(s, references[i], &value) != SLAVE_OK) {
            return fmi3Error;
        }
        values[i] = value != 0;
    }
    return fmi3OK;
}

fmi3Status fmi3SetBoolean(fmi3Instance c, const fmi3ValueReference references[], size_t nreferences,
                          const fmi3Boolean values[], size_t nvalues)
{
    slave *s = slave3_of(c);
    if (s == NULL) {
        return fmi3Error;
    }
    if (nvalues != nreferences) {
        return refuse(s, "fmi3SetBoolean: all variables are scalars, so there is one value each");
    }
    for (size_t i = 0; i < nreferences; i++) {
        if (slave_set_flag(s, references[i], values[i]) != SLAVE_OK) {
            return fmi3Error;
        }
    }
    return fmi3OK;
}

/* ---- the complete state ---- */

fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state)
{
    return status3(slave_keep(slave3_of(c), "fmi3GetFMUState", state));
}

fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state)
{
    return status3(slave_take(slave3_of(c), "fmi3SetFMUState", state));
}

fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state)
{
    return status3(slave_free(slave3_of(c), state));
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size)
{
    return status3(slave_size(slave3_of(c), "fmi3SerializedFMUStateSize", state, size));
}

fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    return status3(slave_pack(slave3_of(c), "fmi3SerializeFMUState", state, bytes, size));
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size,
                                   fmi3FMUState *state)
{
    return status3(slave_unpack(slave3_of(c), "fmi3DeserializeFMUState", bytes, size, state));
}

/* ---- derivatives ---- */

/* sum[row or column] += d unknown / d known * seed */
static fmi3Status add_slopes(slave *s, const fmi3ValueReference unknowns[], size_t nunknowns,
                             const fmi3ValueReference knowns[], size_t nknowns, const double seed[],
                             double sum[], int adjoint)
{
    for (size_t k = 0; k < (adjoint ? nknowns : nunknowns); k++) {
        sum[k] = 0.0;
    }
    for (size_t i = 0; i < nunknowns; i++) {
        for (size_t k = 0; k < nknowns; k++) {
            double slope, weight = seed[adjoint ? i : k];
            if (weight == 0.0) {
                continue;
            }
            if (slave_slope(s, unknowns[i], knowns[k], &slope) != SLAVE_OK) {
                return fmi3Error;
            }
            sum[adjoint ? k : i] += slope * weight;
        }
    }
    return fmi3OK;
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference unknowns[],
                                        size_t nunknowns, const fmi3ValueReference knowns[],
                                        size_t nknowns, const fmi3Float64 seed[], size_t nseed,
                                        fmi3Float64 sensitivity[], size_t nsensitivity)
{
    slave *s = slave3_of(c);
    if (s == NULL || slave_allow(s, "fmi3GetDirectionalDerivative", READABLE)) {
        return fmi3Error;
    }
    if (nseed != nknowns || nsensitivity != nunknowns) {
        return refuse(s, "fmi3GetDirectionalDerivative: expected a seed for every known and a "
                         "sensitivity for every unknown");
    }
    return add_slopes(s, unknowns, nunknowns, knowns, nknowns, seed, sensitivity, 0);
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance c, const fmi3ValueReference unknowns[],
                                    size_t nunknowns, const fmi3ValueReference knowns[],
                                    size_t nknowns, const fmi3Float64 seed[], size_t nseed,
                                    fmi3Float64 sensitivity[], size_t nsensitivity)
{
    slave *s = slave3_of(c);
    if (s == NULL || slave_allow(s, "fmi3GetAdjointDerivative", READABLE)) {
        return fmi3Error;
    }
    if (nseed != nunknowns || nsensitivity != nknowns) {
        return refuse(s, "fmi3GetAdjointDerivative: expected a seed for every unknown and a "
                         "sensitivity for every known");
    }
    return add_slopes(s, unknowns, nunknowns, knowns, nknowns, seed, sensitivity, 1);
}

/* ---- steps ---- */

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 currentCommunicationPoint,
                      fmi3Float64 communicationStepSize, fmi3Boolean noSetPrior,
                      fmi3Boolean *eventHandlingNeeded, fmi3Boolean *terminate,
                      fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime)
{
    slave *s = slave3_of(c);
    (void)noSetPrior;
    if (s == NULL || slave_allow(s, "fmi3DoStep", SLAVE_STEPPING)) {
        return fmi3Error;
    }
    slave_status status = slave_step(s, currentCommunicationPoint, communicationStepSize);
    fmi3Boolean *const no[] = {eventHandlingNeeded, terminate, earlyReturn};
    for (int i = 0; i < 3; i++) {
        if (no[i] != NULL) {
            *no[i] = fmi3False;
        }
    }
    if (lastSuccessfulTime != NULL) {
        *lastSuccessfulTime = s->reached;
    }
    return status3(status);
}

/* ---- for other files ---- */

fmi3Status refuse3(fmi3Instance c, const char *function, const char *why)
{
    slave *s = slave3_of(c);
    if (s == NULL) {
        return fmi3Error;
    }
    return status3(
        slave_refuse(s, stein__fail(&s->err, STEIN_EINVAL, "%s: this FMU %s", function, why)));
}
