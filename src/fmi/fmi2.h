/* SPDX-License-Identifier: MIT
 * fmi2.h - the C interface of FMI 2.0, declared after the text of the specification.
 *
 * Names, types and the order of arguments follow the standard, chapters 2.1 (common functions), 3.2
 * (model exchange) and 4.2 (co-simulation): 44 functions. Prefixes as in fmi3.h.
 * Included by: this folder.
 */
#ifndef FMI_FMI2_H
#define FMI_FMI2_H

#include <stddef.h>

typedef void *fmi2Component, *fmi2ComponentEnvironment, *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer, fmi2Boolean;
typedef char fmi2Char, fmi2Byte;
typedef const fmi2Char *fmi2String;
enum { fmi2False = 0, fmi2True = 1 };

typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum {
    fmi2DoStepStatus,
    fmi2PendingStatus,
    fmi2LastSuccessfulTime,
    fmi2Terminated
} fmi2StatusKind;

/** What an event has changed. */
typedef struct fmi2EventInfo {
    fmi2Boolean newDiscreteStatesNeeded, terminateSimulation;
    fmi2Boolean nominalsOfContinuousStatesChanged, valuesOfContinuousStatesChanged;
    fmi2Boolean nextEventTimeDefined;
    fmi2Real nextEventTime;
} fmi2EventInfo;

/** What an importer provides; its message is a format of printf. */
typedef struct fmi2CallbackFunctions {
    void (*logger)(fmi2ComponentEnvironment environment, fmi2String instanceName, fmi2Status status,
                   fmi2String category, fmi2String message, ...);
    void *(*allocateMemory)(size_t n, size_t size);
    void (*freeMemory)(void *block);
    void (*stepFinished)(fmi2ComponentEnvironment environment, fmi2Status status);
    fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;

#if defined FMI2_FUNCTION_PREFIX && !defined FMI2_OVERRIDE_FUNCTION_PREFIX
#define FMI2_JOINED(prefix, name) prefix##name
#define FMI2_JOIN(prefix, name)   FMI2_JOINED(prefix, name)
#define FMI2_NAME(name)           FMI2_JOIN(FMI2_FUNCTION_PREFIX, name)
#else
#define FMI2_NAME(name) name
#endif
/* clang-format off */
#define fmi2GetTypesPlatform FMI2_NAME(fmi2GetTypesPlatform)
#define fmi2GetVersion FMI2_NAME(fmi2GetVersion)
#define fmi2SetDebugLogging FMI2_NAME(fmi2SetDebugLogging)
#define fmi2Instantiate FMI2_NAME(fmi2Instantiate)
#define fmi2FreeInstance FMI2_NAME(fmi2FreeInstance)
#define fmi2SetupExperiment FMI2_NAME(fmi2SetupExperiment)
#define fmi2EnterInitializationMode FMI2_NAME(fmi2EnterInitializationMode)
#define fmi2ExitInitializationMode FMI2_NAME(fmi2ExitInitializationMode)
#define fmi2Terminate FMI2_NAME(fmi2Terminate)
#define fmi2Reset FMI2_NAME(fmi2Reset)
#define fmi2GetReal FMI2_NAME(fmi2GetReal)
#define fmi2GetInteger FMI2_NAME(fmi2GetInteger)
#define fmi2GetBoolean FMI2_NAME(fmi2GetBoolean)
#define fmi2GetString FMI2_NAME(fmi2GetString)
#define fmi2SetReal FMI2_NAME(fmi2SetReal)
#define fmi2SetInteger FMI2_NAME(fmi2SetInteger)
#define fmi2SetBoolean FMI2_NAME(fmi2SetBoolean)
#define fmi2SetString FMI2_NAME(fmi2SetString)
#define fmi2GetFMUstate FMI2_NAME(fmi2GetFMUstate)
#define fmi2SetFMUstate FMI2_NAME(fmi2SetFMUstate)
#define fmi2FreeFMUstate FMI2_NAME(fmi2FreeFMUstate)
#define fmi2SerializedFMUstateSize FMI2_NAME(fmi2SerializedFMUstateSize)
#define fmi2SerializeFMUstate FMI2_NAME(fmi2SerializeFMUstate)
#define fmi2DeSerializeFMUstate FMI2_NAME(fmi2DeSerializeFMUstate)
#define fmi2GetDirectionalDerivative FMI2_NAME(fmi2GetDirectionalDerivative)
#define fmi2SetRealInputDerivatives FMI2_NAME(fmi2SetRealInputDerivatives)
#define fmi2GetRealOutputDerivatives FMI2_NAME(fmi2GetRealOutputDerivatives)
#define fmi2DoStep FMI2_NAME(fmi2DoStep)
#define fmi2CancelStep FMI2_NAME(fmi2CancelStep)
#define fmi2GetStatus FMI2_NAME(fmi2GetStatus)
#define fmi2GetRealStatus FMI2_NAME(fmi2GetRealStatus)
#define fmi2GetIntegerStatus FMI2_NAME(fmi2GetIntegerStatus)
#define fmi2GetBooleanStatus FMI2_NAME(fmi2GetBooleanStatus)
#define fmi2GetStringStatus FMI2_NAME(fmi2GetStringStatus)
#define fmi2EnterEventMode FMI2_NAME(fmi2EnterEventMode)
#define fmi2NewDiscreteStates FMI2_NAME(fmi2NewDiscreteStates)
#define fmi2EnterContinuousTimeMode FMI2_NAME(fmi2EnterContinuousTimeMode)
#define fmi2CompletedIntegratorStep FMI2_NAME(fmi2CompletedIntegratorStep)
#define fmi2SetTime FMI2_NAME(fmi2SetTime)
#define fmi2SetContinuousStates FMI2_NAME(fmi2SetContinuousStates)
#define fmi2GetDerivatives FMI2_NAME(fmi2GetDerivatives)
#define fmi2GetEventIndicators FMI2_NAME(fmi2GetEventIndicators)
#define fmi2GetContinuousStates FMI2_NAME(fmi2GetContinuousStates)
#define fmi2GetNominalsOfContinuousStates FMI2_NAME(fmi2GetNominalsOfContinuousStates)
/* clang-format on */

#if defined _WIN32
#define FMI2_EXPORT __declspec(dllexport)
#elif defined __GNUC__
#define FMI2_EXPORT __attribute__((visibility("default")))
#else
#define FMI2_EXPORT
#endif

#define FMI2_REFERENCES const fmi2ValueReference references[], size_t nreferences

/* ---- life ---- */

FMI2_EXPORT const char *fmi2GetTypesPlatform(void);
FMI2_EXPORT const char *fmi2GetVersion(void);
FMI2_EXPORT fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn,
                                           size_t ncategories, const fmi2String categories[]);
FMI2_EXPORT fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid,
                                          fmi2String resourceLocation,
                                          const fmi2CallbackFunctions *functions,
                                          fmi2Boolean visible, fmi2Boolean loggingOn);
FMI2_EXPORT void fmi2FreeInstance(fmi2Component c);
FMI2_EXPORT fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined,
                                           fmi2Real tolerance, fmi2Real startTime,
                                           fmi2Boolean stopTimeDefined, fmi2Real stopTime);
FMI2_EXPORT fmi2Status fmi2EnterInitializationMode(fmi2Component c);
FMI2_EXPORT fmi2Status fmi2ExitInitializationMode(fmi2Component c);
FMI2_EXPORT fmi2Status fmi2Terminate(fmi2Component c);
FMI2_EXPORT fmi2Status fmi2Reset(fmi2Component c);

/* ---- variables ---- */

FMI2_EXPORT fmi2Status fmi2GetReal(fmi2Component c, FMI2_REFERENCES, fmi2Real values[]);
FMI2_EXPORT fmi2Status fmi2GetInteger(fmi2Component c, FMI2_REFERENCES, fmi2Integer values[]);
FMI2_EXPORT fmi2Status fmi2GetBoolean(fmi2Component c, FMI2_REFERENCES, fmi2Boolean values[]);
FMI2_EXPORT fmi2Status fmi2GetString(fmi2Component c, FMI2_REFERENCES, fmi2String values[]);
FMI2_EXPORT fmi2Status fmi2SetReal(fmi2Component c, FMI2_REFERENCES, const fmi2Real values[]);
FMI2_EXPORT fmi2Status fmi2SetInteger(fmi2Component c, FMI2_REFERENCES, const fmi2Integer values[]);
FMI2_EXPORT fmi2Status fmi2SetBoolean(fmi2Component c, FMI2_REFERENCES, const fmi2Boolean values[]);
FMI2_EXPORT fmi2Status fmi2SetString(fmi2Component c, FMI2_REFERENCES, const fmi2String values[]);

/* ---- the complete state, derivatives ---- */

FMI2_EXPORT fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state);
FMI2_EXPORT fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state);
FMI2_EXPORT fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state);
FMI2_EXPORT fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state,
                                                  size_t *size);
FMI2_EXPORT fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[],
                                             size_t size);
FMI2_EXPORT fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                               fmi2FMUstate *state);
FMI2_EXPORT fmi2Status fmi2GetDirectionalDerivative(fmi2Component c,
                                                    const fmi2ValueReference unknowns[],
                                                    size_t nunknowns,
                                                    const fmi2ValueReference knowns[],
                                                    size_t nknowns, const fmi2Real seed[],
                                                    fmi2Real sensitivity[]);

/* ---- co-simulation ---- */

FMI2_EXPORT fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, FMI2_REFERENCES,
                                                   const fmi2Integer orders[],
                                                   const fmi2Real values[]);
FMI2_EXPORT fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, FMI2_REFERENCES,
                                                    const fmi2Integer orders[], fmi2Real values[]);
FMI2_EXPORT fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint,
                                  fmi2Real communicationStepSize, fmi2Boolean noSetPrior);
FMI2_EXPORT fmi2Status fmi2CancelStep(fmi2Component c);
FMI2_EXPORT fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value);
FMI2_EXPORT fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind,
                                         fmi2Real *value);
FMI2_EXPORT fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind,
                                            fmi2Integer *value);
FMI2_EXPORT fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind,
                                            fmi2Boolean *value);
FMI2_EXPORT fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind,
                                           fmi2String *value);

/* ---- model exchange ---- */

FMI2_EXPORT fmi2Status fmi2EnterEventMode(fmi2Component c);
FMI2_EXPORT fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info);
FMI2_EXPORT fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c);
FMI2_EXPORT fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean noSetPrior,
                                                   fmi2Boolean *enterEventMode,
                                                   fmi2Boolean *terminate);
FMI2_EXPORT fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time);
FMI2_EXPORT fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx);
FMI2_EXPORT fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx);
FMI2_EXPORT fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real indicators[], size_t ni);
FMI2_EXPORT fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx);
FMI2_EXPORT fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real nominals[],
                                                         size_t nx);

#endif
