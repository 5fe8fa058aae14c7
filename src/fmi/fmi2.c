/* SPDX-License-Identifier: MIT
 * fmi2.c - FMI 2.0; the functions of model exchange are in exchange2.c.
 *
 * The states of figure 11 of the standard. After fmi2Discard an instance waits for fmi2SetFMUstate,
 * fmi2Reset or fmi2Terminate, after fmi2Error for fmi2SetFMUstate or fmi2Reset; both can be read.
 * The last successful time of a discarded step is its beginning. Memory is the FMU's own
 * (canNotUseMemoryManagementFunctions).
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "internal2.h"

enum { LONGEST_NAME = 128 };

/* where the messages of an instance go */
typedef struct instance {
    slave *slave;
    fmi2CallbackFunctions functions;
    char name[LONGEST_NAME];
} instance;

enum { READABLE = SLAVE_ANY & ~SLAVE_INSTANTIATED };

fmi2Status status2(slave_status status)
{
    return status == SLAVE_OK ? fmi2OK : status == SLAVE_DISCARD ? fmi2Discard : fmi2Error;
}

static void tell2(void *ctx, slave_status status, int category, const char *message)
{
    const instance *in = ctx;
    if (in->functions.logger != NULL) { // the message is no format
        in->functions.logger(in->functions.componentEnvironment, in->name, status2(status),
                             slave_category_name[category], "%s", message);
    }
}

slave *slave2_of(fmi2Component c)
{
    return c != NULL ? ((instance *)c)->slave : NULL;
}

static fmi2Status refuse(slave *s, const char *why)
{
    return status2(slave_refuse(s, stein__fail(&s->err, STEIN_EINVAL, "%s", why)));
}

/* ---- life ---- */

const char *fmi2GetTypesPlatform(void)
{
    return "default";
}

const char *fmi2GetVersion(void)
{
    return "2.0";
}

/* refusals are always logged, events on request */
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n,
                               const fmi2String categories[])
{
    slave *s = slave2_of(c);
    if (s == NULL) {
        return fmi2Error;
    }
    if (n > 0 && categories == NULL) {
        return refuse(s, "fmi2SetDebugLogging without categories");
    }
    slave_status status = slave_set_log(s, on, n, categories);
    s->log |= SLAVE_LOG_REFUSED;
    return status2(status);
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid,
                              fmi2String resourceLocation, const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean loggingOn)
{
    (void)resourceLocation, (void)visible;
    instance *in = functions != NULL ? calloc(1, sizeof *in) : NULL;
    if (in == NULL) {
        return NULL;
    }
    in->functions = *functions;
    if (name != NULL) {
        strncpy(in->name, name, LONGEST_NAME - 1);
    }
    in->slave = slave_create(name, guid, type == fmi2ModelExchange, tell2, in,
                             loggingOn ? ~0u : SLAVE_LOG_REFUSED);
    if (in->slave == NULL) {
        free(in);
        return NULL;
    }
    return in;
}

void fmi2FreeInstance(fmi2Component c)
{
    if (c != NULL) {
        slave_destroy(slave2_of(c));
        free(c);
    }
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance,
                               fmi2Real startTime, fmi2Boolean stopTimeDefined, fmi2Real stopTime)
{
    slave *s = slave2_of(c);
    (void)toleranceDefined, (void)tolerance; // steps are fixed
    if (s == NULL || slave_allow(s, "fmi2SetupExperiment", SLAVE_INSTANTIATED)) {
        return fmi2Error;
    }
    return status2(slave_set_time(s, startTime, stopTimeDefined ? stopTime : (double)INFINITY));
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    slave *s = slave2_of(c);
    if (s == NULL || slave_allow(s, "fmi2EnterInitializationMode", SLAVE_INSTANTIATED)) {
        return fmi2Error;
    }
    return status2(slave_enter_initialization(s));
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    slave *s = slave2_of(c);
    if (s == NULL || slave_allow(s, "fmi2ExitInitializationMode", SLAVE_INITIALIZING)) {
        return fmi2Error;
    }
    return status2(slave_exit_initialization(s));
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    slave *s = slave2_of(c);
    if (s == NULL || slave_allow(s, "fmi2Terminate", SLAVE_RUNNING | SLAVE_FAILED)) {
        return fmi2Error;
    }
    s->phase = SLAVE_TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    slave *s = slave2_of(c);
    return s != NULL ? status2(slave_reset(s)) : fmi2Error;
}

/* ---- variables ---- */

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference references[], size_t nreferences,
                       fmi2Real values[])
{
    slave *s = slave2_of(c);
    for (size_t i = 0; s != NULL && i < nreferences; i++) {
        if (slave_get(s, references[i], &values[i]) != SLAVE_OK) {
            return fmi2Error;
        }
    }
    return s != NULL ? fmi2OK : fmi2Error;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference references[], size_t nreferences,
                       const fmi2Real values[])
{
    slave *s = slave2_of(c);
    for (size_t i = 0; s != NULL && i < nreferences; i++) {
        if (slave_set(s, references[i], values[i]) != SLAVE_OK) {
            return fmi2Error;
        }
    }
    return s != NULL ? fmi2OK : fmi2Error;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference references[],
                          size_t nreferences, fmi2Boolean values[])
{
    slave *s = slave2_of(c);
    for (size_t i = 0; s != NULL && i < nreferences; i++) {
        if (slave_get_flag(s, references[i], &values[i]) != SLAVE_OK) {
            return fmi2Error;
        }
    }
    return s != NULL ? fmi2OK : fmi2Error;
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference references[],
                          size_t nreferences, const fmi2Boolean values[])
{
    slave *s = slave2_of(c);
    for (size_t i = 0; s != NULL && i < nreferences; i++) {
        if (slave_set_flag(s, references[i], values[i]) != SLAVE_OK) {
            return fmi2Error;
        }
    }
    return s != NULL ? fmi2OK : fmi2Error;
}

/* to read or write no variables at all is no error */
static fmi2Status no_variables(fmi2Component c, size_t n, const char *why)
{
    slave *s = slave2_of(c);
    return s != NULL && n > 0 ? refuse(s, why) : s != NULL ? fmi2OK : fmi2Error;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference references[],
                          size_t nreferences, fmi2Integer values[])
{
    (void)references, (void)values;
    return no_variables(c, nreferences, "fmi2GetInteger: this FMU has no variables of Integer");
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference references[],
                          size_t nreferences, const fmi2Integer values[])
{
    (void)references, (void)values;
    return no_variables(c, nreferences, "fmi2SetInteger: this FMU has no variables of Integer");
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference references[], size_t nreferences,
                         fmi2String values[])
{
    (void)references, (void)values;
    return no_variables(c, nreferences, "fmi2GetString: this FMU has no variables of String");
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference references[], size_t nreferences,
                         const fmi2String values[])
{
    (void)references, (void)values;
    return no_variables(c, nreferences, "fmi2SetString: this FMU has no variables of String");
}

/* ---- the complete state ---- */

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    return status2(slave_keep(slave2_of(c), "fmi2GetFMUstate", state));
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    return status2(slave_take(slave2_of(c), "fmi2SetFMUstate", state));
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    return status2(slave_free(slave2_of(c), state));
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    return status2(slave_size(slave2_of(c), "fmi2SerializedFMUstateSize", state, size));
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    return status2(slave_pack(slave2_of(c), "fmi2SerializeFMUstate", state, bytes, size));
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                   fmi2FMUstate *state)
{
    return status2(slave_unpack(slave2_of(c), "fmi2DeSerializeFMUstate", bytes, size, state));
}

/* ---- derivatives ---- */

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknowns[],
                                        size_t nunknowns, const fmi2ValueReference knowns[],
                                        size_t nknowns, const fmi2Real seed[],
                                        fmi2Real sensitivity[])
{
    slave *s = slave2_of(c);
    if (s == NULL || slave_allow(s, "fmi2GetDirectionalDerivative", READABLE)) {
        return fmi2Error;
    }
    for (size_t i = 0; i < nunknowns; i++) {
        sensitivity[i] = 0.0;
        for (size_t k = 0; k < nknowns; k++) {
            double slope = 0.0;
            if (seed[k] != 0.0 && slave_slope(s, unknowns[i], knowns[k], &slope) != SLAVE_OK) {
                return fmi2Error;
            }
            sensitivity[i] += slope * seed[k];
        }
    }
    return fmi2OK;
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference references[],
                                       size_t nreferences, const fmi2Integer orders[],
                                       const fmi2Real values[])
{
    slave *s = slave2_of(c);
    if (s == NULL || slave_allow(s, "fmi2SetRealInputDerivatives",
                                 SLAVE_INSTANTIATED | SLAVE_INITIALIZING | SLAVE_STEPPING)) {
        return fmi2Error;
    }
    for (size_t i = 0; i < nreferences; i++) {
        if (slave_set_slope(s, references[i], orders[i], values[i]) != SLAVE_OK) {
            return fmi2Error;
        }
    }
    return fmi2OK;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference references[],
                                        size_t nreferences, const fmi2Integer orders[],
                                        fmi2Real values[])
{
    (void)references, (void)orders, (void)values;
    return no_variables(c, nreferences,
                        "fmi2GetRealOutputDerivatives: this FMU has no derivatives of outputs");
}

/* ---- steps ---- */

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint,
                      fmi2Real communicationStepSize, fmi2Boolean noSetPrior)
{
    slave *s = slave2_of(c);
    (void)noSetPrior;
    if (s == NULL || slave_allow(s, "fmi2DoStep", SLAVE_STEPPING)) {
        return fmi2Error;
    }
    slave_status status = slave_step(s, currentCommunicationPoint, communicationStepSize);
    s->phase = status == SLAVE_DISCARD ? SLAVE_FAILED : s->phase;
    return status2(status);
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    slave *s = slave2_of(c);
    return s != NULL ? refuse(s, "fmi2CancelStep: no step is under way, all of them are complete "
                                 "when fmi2DoStep returns")
                     : fmi2Error;
}

/* ---- status ---- */

/* what cannot be told is discarded, as the standard has it; nothing else changes */
static fmi2Status untold(fmi2Component c, const char *why)
{
    if (c != NULL) {
        tell2(c, SLAVE_DISCARD, 1, why);
    }
    return c != NULL ? fmi2Discard : fmi2Error;
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    (void)kind, (void)value;
    return untold(c, "fmi2GetStatus: no step is ever pending");
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    if (c == NULL || value == NULL || kind != fmi2LastSuccessfulTime) {
        return untold(c, "fmi2GetRealStatus: only fmi2LastSuccessfulTime is known");
    }
    *value = slave2_of(c)->reached;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
{
    (void)kind, (void)value;
    return untold(c, "fmi2GetIntegerStatus: there is no such status");
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    if (c == NULL || value == NULL || kind != fmi2Terminated) {
        return untold(c, "fmi2GetBooleanStatus: only fmi2Terminated is known");
    }
    *value = fmi2False; // it never ends the simulation
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
{
    (void)kind, (void)value;
    return untold(c, "fmi2GetStringStatus: no step is ever pending");
}
