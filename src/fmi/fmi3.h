/* SPDX-License-Identifier: MIT
 * fmi3.h - the C interface of FMI 3.0, declared after the text of the specification.
 *
 * Names, types and the order of arguments follow the standard, chapters 2.2 (types, status,
 * variables, states, derivatives), 2.3 (common states), 3.2, 4.2 and 5.2 (the functions of the
 * three kinds of FMU). All 75 functions have to be there.
 *
 * Names have no prefix, so that every importer's compiler can make a shared object of them.
 * To link several FMUs statically, compile each with -DFMI3_FUNCTION_PREFIX=NAME_.
 * Included by: this folder.
 */
#ifndef FMI_FMI3_H
#define FMI_FMI3_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef void *fmi3Instance, *fmi3InstanceEnvironment, *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef float fmi3Float32;
typedef double fmi3Float64;
typedef int8_t fmi3Int8;
typedef uint8_t fmi3UInt8;
typedef int16_t fmi3Int16;
typedef uint16_t fmi3UInt16;
typedef int32_t fmi3Int32;
typedef uint32_t fmi3UInt32;
typedef int64_t fmi3Int64;
typedef uint64_t fmi3UInt64;
typedef bool fmi3Boolean;
typedef char fmi3Char;
typedef const fmi3Char *fmi3String;
typedef uint8_t fmi3Byte;
typedef const fmi3Byte *fmi3Binary;
typedef bool fmi3Clock;
enum { fmi3False = 0, fmi3True = 1 };

typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef enum {
    fmi3Independent,
    fmi3Constant,
    fmi3Fixed,
    fmi3Tunable,
    fmi3Discrete,
    fmi3Dependent
} fmi3DependencyKind;
typedef enum {
    fmi3IntervalNotYetKnown,
    fmi3IntervalUnchanged,
    fmi3IntervalChanged
} fmi3IntervalQualifier;

typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment environment, fmi3Status status,
                                       fmi3String category, fmi3String message);
typedef void (*fmi3ClockUpdateCallback)(fmi3InstanceEnvironment environment);
typedef void (*fmi3IntermediateUpdateCallback)(fmi3InstanceEnvironment environment,
                                               fmi3Float64 time, fmi3Boolean setRequested,
                                               fmi3Boolean getAllowed, fmi3Boolean stepFinished,
                                               fmi3Boolean canReturnEarly,
                                               fmi3Boolean *earlyReturnRequested,
                                               fmi3Float64 *earlyReturnTime);
typedef void (*fmi3LockPreemptionCallback)(void);
typedef void (*fmi3UnlockPreemptionCallback)(void);

#if defined FMI3_FUNCTION_PREFIX && !defined FMI3_OVERRIDE_FUNCTION_PREFIX
#define FMI3_JOINED(prefix, name) prefix##name
#define FMI3_JOIN(prefix, name)   FMI3_JOINED(prefix, name)
#define FMI3_NAME(name)           FMI3_JOIN(FMI3_FUNCTION_PREFIX, name)
#else
#define FMI3_NAME(name) name
#endif
/* clang-format off */
#define fmi3GetVersion FMI3_NAME(fmi3GetVersion)
#define fmi3SetDebugLogging FMI3_NAME(fmi3SetDebugLogging)
#define fmi3InstantiateModelExchange FMI3_NAME(fmi3InstantiateModelExchange)
#define fmi3InstantiateCoSimulation FMI3_NAME(fmi3InstantiateCoSimulation)
#define fmi3InstantiateScheduledExecution FMI3_NAME(fmi3InstantiateScheduledExecution)
#define fmi3FreeInstance FMI3_NAME(fmi3FreeInstance)
#define fmi3EnterInitializationMode FMI3_NAME(fmi3EnterInitializationMode)
#define fmi3ExitInitializationMode FMI3_NAME(fmi3ExitInitializationMode)
#define fmi3EnterEventMode FMI3_NAME(fmi3EnterEventMode)
#define fmi3Terminate FMI3_NAME(fmi3Terminate)
#define fmi3Reset FMI3_NAME(fmi3Reset)
#define fmi3GetFloat32 FMI3_NAME(fmi3GetFloat32)
#define fmi3GetFloat64 FMI3_NAME(fmi3GetFloat64)
#define fmi3GetInt8 FMI3_NAME(fmi3GetInt8)
#define fmi3GetUInt8 FMI3_NAME(fmi3GetUInt8)
#define fmi3GetInt16 FMI3_NAME(fmi3GetInt16)
#define fmi3GetUInt16 FMI3_NAME(fmi3GetUInt16)
#define fmi3GetInt32 FMI3_NAME(fmi3GetInt32)
#define fmi3GetUInt32 FMI3_NAME(fmi3GetUInt32)
#define fmi3GetInt64 FMI3_NAME(fmi3GetInt64)
#define fmi3GetUInt64 FMI3_NAME(fmi3GetUInt64)
#define fmi3GetBoolean FMI3_NAME(fmi3GetBoolean)
#define fmi3GetString FMI3_NAME(fmi3GetString)
#define fmi3GetBinary FMI3_NAME(fmi3GetBinary)
#define fmi3GetClock FMI3_NAME(fmi3GetClock)
#define fmi3SetFloat32 FMI3_NAME(fmi3SetFloat32)
#define fmi3SetFloat64 FMI3_NAME(fmi3SetFloat64)
#define fmi3SetInt8 FMI3_NAME(fmi3SetInt8)
#define fmi3SetUInt8 FMI3_NAME(fmi3SetUInt8)
#define fmi3SetInt16 FMI3_NAME(fmi3SetInt16)
#define fmi3SetUInt16 FMI3_NAME(fmi3SetUInt16)
#define fmi3SetInt32 FMI3_NAME(fmi3SetInt32)
#define fmi3SetUInt32 FMI3_NAME(fmi3SetUInt32)
#define fmi3SetInt64 FMI3_NAME(fmi3SetInt64)
#define fmi3SetUInt64 FMI3_NAME(fmi3SetUInt64)
#define fmi3SetBoolean FMI3_NAME(fmi3SetBoolean)
#define fmi3SetString FMI3_NAME(fmi3SetString)
#define fmi3SetBinary FMI3_NAME(fmi3SetBinary)
#define fmi3SetClock FMI3_NAME(fmi3SetClock)
#define fmi3GetNumberOfVariableDependencies FMI3_NAME(fmi3GetNumberOfVariableDependencies)
#define fmi3GetVariableDependencies FMI3_NAME(fmi3GetVariableDependencies)
#define fmi3GetFMUState FMI3_NAME(fmi3GetFMUState)
#define fmi3SetFMUState FMI3_NAME(fmi3SetFMUState)
#define fmi3FreeFMUState FMI3_NAME(fmi3FreeFMUState)
#define fmi3SerializedFMUStateSize FMI3_NAME(fmi3SerializedFMUStateSize)
#define fmi3SerializeFMUState FMI3_NAME(fmi3SerializeFMUState)
#define fmi3DeserializeFMUState FMI3_NAME(fmi3DeserializeFMUState)
#define fmi3GetDirectionalDerivative FMI3_NAME(fmi3GetDirectionalDerivative)
#define fmi3GetAdjointDerivative FMI3_NAME(fmi3GetAdjointDerivative)
#define fmi3EnterConfigurationMode FMI3_NAME(fmi3EnterConfigurationMode)
#define fmi3ExitConfigurationMode FMI3_NAME(fmi3ExitConfigurationMode)
#define fmi3GetIntervalDecimal FMI3_NAME(fmi3GetIntervalDecimal)
#define fmi3GetIntervalFraction FMI3_NAME(fmi3GetIntervalFraction)
#define fmi3GetShiftDecimal FMI3_NAME(fmi3GetShiftDecimal)
#define fmi3GetShiftFraction FMI3_NAME(fmi3GetShiftFraction)
#define fmi3SetIntervalDecimal FMI3_NAME(fmi3SetIntervalDecimal)
#define fmi3SetIntervalFraction FMI3_NAME(fmi3SetIntervalFraction)
#define fmi3SetShiftDecimal FMI3_NAME(fmi3SetShiftDecimal)
#define fmi3SetShiftFraction FMI3_NAME(fmi3SetShiftFraction)
#define fmi3EvaluateDiscreteStates FMI3_NAME(fmi3EvaluateDiscreteStates)
#define fmi3UpdateDiscreteStates FMI3_NAME(fmi3UpdateDiscreteStates)
#define fmi3EnterContinuousTimeMode FMI3_NAME(fmi3EnterContinuousTimeMode)
#define fmi3CompletedIntegratorStep FMI3_NAME(fmi3CompletedIntegratorStep)
#define fmi3SetTime FMI3_NAME(fmi3SetTime)
#define fmi3SetContinuousStates FMI3_NAME(fmi3SetContinuousStates)
#define fmi3GetContinuousStateDerivatives FMI3_NAME(fmi3GetContinuousStateDerivatives)
#define fmi3GetEventIndicators FMI3_NAME(fmi3GetEventIndicators)
#define fmi3GetContinuousStates FMI3_NAME(fmi3GetContinuousStates)
#define fmi3GetNominalsOfContinuousStates FMI3_NAME(fmi3GetNominalsOfContinuousStates)
#define fmi3GetNumberOfEventIndicators FMI3_NAME(fmi3GetNumberOfEventIndicators)
#define fmi3GetNumberOfContinuousStates FMI3_NAME(fmi3GetNumberOfContinuousStates)
#define fmi3EnterStepMode FMI3_NAME(fmi3EnterStepMode)
#define fmi3GetOutputDerivatives FMI3_NAME(fmi3GetOutputDerivatives)
#define fmi3DoStep FMI3_NAME(fmi3DoStep)
#define fmi3ActivateModelPartition FMI3_NAME(fmi3ActivateModelPartition)
/* clang-format on */

#if defined _WIN32
#define FMI3_EXPORT __declspec(dllexport)
#elif defined __GNUC__
#define FMI3_EXPORT __attribute__((visibility("default")))
#else
#define FMI3_EXPORT
#endif

#define FMI3_REFERENCES const fmi3ValueReference references[], size_t nreferences

/* ---- all kinds: life ---- */

FMI3_EXPORT const char *fmi3GetVersion(void);
FMI3_EXPORT fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean loggingOn,
                                           size_t ncategories, const fmi3String categories[]);
FMI3_EXPORT fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token,
                                                      fmi3String resourcePath, fmi3Boolean visible,
                                                      fmi3Boolean loggingOn,
                                                      fmi3InstanceEnvironment environment,
                                                      fmi3LogMessageCallback log);
FMI3_EXPORT fmi3Instance
fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resourcePath,
                            fmi3Boolean visible, fmi3Boolean loggingOn, fmi3Boolean eventModeUsed,
                            fmi3Boolean earlyReturnAllowed, const fmi3ValueReference intermediate[],
                            size_t nintermediate, fmi3InstanceEnvironment environment,
                            fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update);
FMI3_EXPORT fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String name, fmi3String token, fmi3String resourcePath, fmi3Boolean visible,
    fmi3Boolean loggingOn, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
    fmi3ClockUpdateCallback clock, fmi3LockPreemptionCallback lock,
    fmi3UnlockPreemptionCallback unlock);
FMI3_EXPORT void fmi3FreeInstance(fmi3Instance instance);
FMI3_EXPORT fmi3Status fmi3EnterInitializationMode(fmi3Instance instance,
                                                   fmi3Boolean toleranceDefined,
                                                   fmi3Float64 tolerance, fmi3Float64 startTime,
                                                   fmi3Boolean stopTimeDefined,
                                                   fmi3Float64 stopTime);
FMI3_EXPORT fmi3Status fmi3ExitInitializationMode(fmi3Instance instance);
FMI3_EXPORT fmi3Status fmi3EnterEventMode(fmi3Instance instance);
FMI3_EXPORT fmi3Status fmi3Terminate(fmi3Instance instance);
FMI3_EXPORT fmi3Status fmi3Reset(fmi3Instance instance);
FMI3_EXPORT fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance);
FMI3_EXPORT fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance);

/* ---- variables ---- */

FMI3_EXPORT fmi3Status fmi3GetFloat32(fmi3Instance instance, FMI3_REFERENCES, fmi3Float32 values[],
                                      size_t nvalues);
FMI3_EXPORT fmi3Status fmi3GetFloat64(fmi3Instance instance, FMI3_REFERENCES, fmi3Float64 values[],
                                      size_t nvalues);
FMI3_EXPORT fmi3Status fmi3GetInt8(fmi3Instance instance, FMI3_REFERENCES, fmi3Int8 values[],
                                   size_t nvalues);
FMI3_EXPORT fmi3Status fmi3GetUInt8(fmi3Instance instance, FMI3_REFERENCES, fmi3UInt8 values[],
                                    size_t nvalues);
FMI3_EXPORT fmi3Status fmi3GetInt16(fmi3Instance instance, FMI3_REFERENCES, fmi3Int16 values[],
                                    size_t nvalues);
FMI3_EXPORT fmi3Status fmi3GetUInt16(fmi3Instance instance, FMI3_REFERENCES, fmi3UInt16 values[],
                                     size_t nvalues);
FMI3_EXPORT fmi3Status fmi3GetInt32(fmi3Instance instance, FMI3_REFERENCES, fmi3Int32 values[],
                                    size_t nvalues);
FMI3_EXPORT fmi3Status fmi3GetUInt32(fmi3Instance instance, FMI3_REFERENCES, fmi3UInt32 values[],
                                     size_t nvalues);
FMI3_EXPORT fmi3Status fmi3GetInt64(fmi3Instance instance, FMI3_REFERENCES, fmi3Int64 values[],
                                    size_t nvalues);
FMI3_EXPORT fmi3Status fmi3GetUInt64(fmi3Instance instance, FMI3_REFERENCES, fmi3UInt64 values[],
                                     size_t nvalues);
FMI3_EXPORT fmi3Status fmi3GetBoolean(fmi3Instance instance, FMI3_REFERENCES, fmi3Boolean values[],
                                      size_t nvalues);
FMI3_EXPORT fmi3Status fmi3GetString(fmi3Instance instance, FMI3_REFERENCES, fmi3String values[],
                                     size_t nvalues);
FMI3_EXPORT fmi3Status fmi3GetBinary(fmi3Instance instance, FMI3_REFERENCES, size_t sizes[],
                                     fmi3Binary values[], size_t nvalues);
FMI3_EXPORT fmi3Status fmi3GetClock(fmi3Instance instance, FMI3_REFERENCES, fmi3Clock values[]);
FMI3_EXPORT fmi3Status fmi3SetFloat32(fmi3Instance instance, FMI3_REFERENCES,
                                      const fmi3Float32 values[], size_t nvalues);
FMI3_EXPORT fmi3Status fmi3SetFloat64(fmi3Instance instance, FMI3_REFERENCES,
                                      const fmi3Float64 values[], size_t nvalues);
FMI3_EXPORT fmi3Status fmi3SetInt8(fmi3Instance instance, FMI3_REFERENCES, const fmi3Int8 values[],
                                   size_t nvalues);
FMI3_EXPORT fmi3Status fmi3SetUInt8(fmi3Instance instance, FMI3_REFERENCES,
                                    const fmi3UInt8 values[], size_t nvalues);
FMI3_EXPORT fmi3Status fmi3SetInt16(fmi3Instance instance, FMI3_REFERENCES,
                                    const fmi3Int16 values[], size_t nvalues);
FMI3_EXPORT fmi3Status fmi3SetUInt16(fmi3Instance instance, FMI3_REFERENCES,
                                     const fmi3UInt16 values[], size_t nvalues);
FMI3_EXPORT fmi3Status fmi3SetInt32(fmi3Instance instance, FMI3_REFERENCES,
                                    const fmi3Int32 values[], size_t nvalues);
FMI3_EXPORT fmi3Status fmi3SetUInt32(fmi3Instance instance, FMI3_REFERENCES,
                                     const fmi3UInt32 values[], size_t nvalues);
FMI3_EXPORT fmi3Status fmi3SetInt64(fmi3Instance instance, FMI3_REFERENCES,
                                    const fmi3Int64 values[], size_t nvalues);
FMI3_EXPORT fmi3Status fmi3SetUInt64(fmi3Instance instance, FMI3_REFERENCES,
                                     const fmi3UInt64 values[], size_t nvalues);
FMI3_EXPORT fmi3Status fmi3SetBoolean(fmi3Instance instance, FMI3_REFERENCES,
                                      const fmi3Boolean values[], size_t nvalues);
FMI3_EXPORT fmi3Status fmi3SetString(fmi3Instance instance, FMI3_REFERENCES,
                                     const fmi3String values[], size_t nvalues);
FMI3_EXPORT fmi3Status fmi3SetBinary(fmi3Instance instance, FMI3_REFERENCES, const size_t sizes[],
                                     const fmi3Binary values[], size_t nvalues);
FMI3_EXPORT fmi3Status fmi3SetClock(fmi3Instance instance, FMI3_REFERENCES,
                                    const fmi3Clock values[]);
FMI3_EXPORT fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance,
                                                           fmi3ValueReference reference, size_t *n);
FMI3_EXPORT fmi3Status fmi3GetVariableDependencies(fmi3Instance instance,
                                                   fmi3ValueReference dependent,
                                                   size_t elementsOfDependent[],
                                                   fmi3ValueReference independents[],
                                                   size_t elementsOfIndependents[],
                                                   fmi3DependencyKind kinds[], size_t n);

/* ---- the complete state ---- */

FMI3_EXPORT fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state);
FMI3_EXPORT fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state);
FMI3_EXPORT fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state);
FMI3_EXPORT fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state,
                                                  size_t *size);
FMI3_EXPORT fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state,
                                             fmi3Byte bytes[], size_t size);
FMI3_EXPORT fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[],
                                               size_t size, fmi3FMUState *state);

/* ---- derivatives ---- */

FMI3_EXPORT fmi3Status fmi3GetDirectionalDerivative(
    fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nunknowns,
    const fmi3ValueReference knowns[], size_t nknowns, const fmi3Float64 seed[], size_t nseed,
    fmi3Float64 sensitivity[], size_t nsensitivity);
FMI3_EXPORT fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance,
                                                const fmi3ValueReference unknowns[],
                                                size_t nunknowns, const fmi3ValueReference knowns[],
                                                size_t nknowns, const fmi3Float64 seed[],
                                                size_t nseed, fmi3Float64 sensitivity[],
                                                size_t nsensitivity);

/* ---- clocks and events ---- */

FMI3_EXPORT fmi3Status fmi3GetIntervalDecimal(fmi3Instance instance, FMI3_REFERENCES,
                                              fmi3Float64 intervals[],
                                              fmi3IntervalQualifier qualifiers[]);
FMI3_EXPORT fmi3Status fmi3GetIntervalFraction(fmi3Instance instance, FMI3_REFERENCES,
                                               fmi3UInt64 counters[], fmi3UInt64 resolutions[],
                                               fmi3IntervalQualifier qualifiers[]);
FMI3_EXPORT fmi3Status fmi3GetShiftDecimal(fmi3Instance instance, FMI3_REFERENCES,
                                           fmi3Float64 shifts[]);
FMI3_EXPORT fmi3Status fmi3GetShiftFraction(fmi3Instance instance, FMI3_REFERENCES,
                                            fmi3UInt64 counters[], fmi3UInt64 resolutions[]);
FMI3_EXPORT fmi3Status fmi3SetIntervalDecimal(fmi3Instance instance, FMI3_REFERENCES,
                                              const fmi3Float64 intervals[]);
FMI3_EXPORT fmi3Status fmi3SetIntervalFraction(fmi3Instance instance, FMI3_REFERENCES,
                                               const fmi3UInt64 counters[],
                                               const fmi3UInt64 resolutions[]);
FMI3_EXPORT fmi3Status fmi3SetShiftDecimal(fmi3Instance instance, FMI3_REFERENCES,
                                           const fmi3Float64 shifts[]);
FMI3_EXPORT fmi3Status fmi3SetShiftFraction(fmi3Instance instance, FMI3_REFERENCES,
                                            const fmi3UInt64 counters[],
                                            const fmi3UInt64 resolutions[]);
FMI3_EXPORT fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance);
FMI3_EXPORT fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *needUpdate,
                                                fmi3Boolean *terminate,
                                                fmi3Boolean *nominalsChanged,
                                                fmi3Boolean *valuesChanged,
                                                fmi3Boolean *nextTimeDefined,
                                                fmi3Float64 *nextTime);

/* ---- model exchange ---- */

FMI3_EXPORT fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance);
FMI3_EXPORT fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean noSetPrior,
                                                   fmi3Boolean *enterEventMode,
                                                   fmi3Boolean *terminate);
FMI3_EXPORT fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time);
FMI3_EXPORT fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 states[],
                                               size_t n);
FMI3_EXPORT fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance,
                                                         fmi3Float64 derivatives[], size_t n);
FMI3_EXPORT fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 indicators[],
                                              size_t n);
FMI3_EXPORT fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 states[],
                                               size_t n);
FMI3_EXPORT fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance,
                                                         fmi3Float64 nominals[], size_t n);
FMI3_EXPORT fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *n);
FMI3_EXPORT fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *n);

/* ---- co-simulation, scheduled execution ---- */

FMI3_EXPORT fmi3Status fmi3EnterStepMode(fmi3Instance instance);
FMI3_EXPORT fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, FMI3_REFERENCES,
                                                const fmi3Int32 orders[], fmi3Float64 values[],
                                                size_t nvalues);
FMI3_EXPORT fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint,
                                  fmi3Float64 communicationStepSize, fmi3Boolean noSetPrior,
                                  fmi3Boolean *eventHandlingNeeded, fmi3Boolean *terminate,
                                  fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime);
FMI3_EXPORT fmi3Status fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference clock,
                                                  fmi3Float64 activationTime);

#endif
