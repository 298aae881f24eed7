/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_FMI3_H
#define THERMOTWIN_FMI3_H
/* What FMI 3.0 asks of a model: types, status values and functions, written from the standard's description of its
 * interface (FMI 3.0.1, sections 2.2 to 5.2). This FMU is for co-simulation alone. */

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "fmi3_names.h"

#if defined(_WIN32)
#define FMI3_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define FMI3_EXPORT __attribute__((visibility("default")))
#else
#define FMI3_EXPORT
#endif

typedef void *fmi3Instance, *fmi3InstanceEnvironment, *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef float fmi3Float32;
typedef double fmi3Float64;
typedef int8_t fmi3Int8;
typedef uint8_t fmi3UInt8, fmi3Byte;
typedef int16_t fmi3Int16;
typedef uint16_t fmi3UInt16;
typedef int32_t fmi3Int32;
typedef uint32_t fmi3UInt32;
typedef int64_t fmi3Int64;
typedef uint64_t fmi3UInt64;
typedef bool fmi3Boolean, fmi3Clock;
typedef const char* fmi3String;
typedef const fmi3Byte* fmi3Binary;
typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef int fmi3DependencyKind, fmi3IntervalQualifier;

typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment, fmi3Status, fmi3String category, fmi3String message);
typedef void (*fmi3ClockUpdateCallback)(fmi3InstanceEnvironment);
typedef void (*fmi3IntermediateUpdateCallback)(fmi3InstanceEnvironment, fmi3Float64 time, fmi3Boolean set,
                                               fmi3Boolean get, fmi3Boolean finished, fmi3Boolean can_return,
                                               fmi3Boolean* return_requested, fmi3Float64* return_time);
typedef void (*fmi3PreemptionCallback)(void);

/* Values of each type; ANY(type) */
#define FMI3_TYPES(ANY) \
  ANY(Float32)          \
  ANY(Float64)          \
  ANY(Int8) ANY(UInt8) ANY(Int16) ANY(UInt16) ANY(Int32) ANY(UInt32) ANY(Int64) ANY(UInt64) ANY(Boolean) ANY(String)
#define FMI3_DECLARE(type)                                                                                           \
  FMI3_EXPORT fmi3Status fmi3Get##type(fmi3Instance c, const fmi3ValueReference r[], size_t n, fmi3##type v[],       \
                                       size_t values);                                                               \
  FMI3_EXPORT fmi3Status fmi3Set##type(fmi3Instance c, const fmi3ValueReference r[], size_t n, const fmi3##type v[], \
                                       size_t values);
FMI3_TYPES(FMI3_DECLARE)
#undef FMI3_DECLARE
FMI3_EXPORT fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference r[], size_t n, size_t sizes[],
                                     fmi3Binary v[], size_t values);
FMI3_EXPORT fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference r[], size_t n, const size_t sizes[],
                                     const fmi3Binary v[], size_t values);
FMI3_EXPORT fmi3Status fmi3GetClock(fmi3Instance c, const fmi3ValueReference r[], size_t n, fmi3Clock v[]);
FMI3_EXPORT fmi3Status fmi3SetClock(fmi3Instance c, const fmi3ValueReference r[], size_t n, const fmi3Clock v[]);

FMI3_EXPORT const char* fmi3GetVersion(void);
FMI3_EXPORT fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t n, const fmi3String categories[]);
FMI3_EXPORT fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
                                                      fmi3Boolean visible, fmi3Boolean logging,
                                                      fmi3InstanceEnvironment environment, fmi3LogMessageCallback log);
FMI3_EXPORT fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                                     fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean events,
                                                     fmi3Boolean early_return, const fmi3ValueReference between[],
                                                     size_t n_between, fmi3InstanceEnvironment environment,
                                                     fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update);
FMI3_EXPORT fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                                           fmi3Boolean visible, fmi3Boolean logging,
                                                           fmi3InstanceEnvironment environment,
                                                           fmi3LogMessageCallback log, fmi3ClockUpdateCallback update,
                                                           fmi3PreemptionCallback lock, fmi3PreemptionCallback unlock);
FMI3_EXPORT void fmi3FreeInstance(fmi3Instance c);
FMI3_EXPORT fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean has_tolerance, fmi3Float64 tolerance,
                                                   fmi3Float64 start, fmi3Boolean has_stop, fmi3Float64 stop);
FMI3_EXPORT fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 step, fmi3Boolean no_return,
                                  fmi3Boolean* event, fmi3Boolean* terminate, fmi3Boolean* early, fmi3Float64* last);
FMI3_EXPORT fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState* state);
FMI3_EXPORT fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state);
FMI3_EXPORT fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState* state);
FMI3_EXPORT fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t* size);
FMI3_EXPORT fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size);
FMI3_EXPORT fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size,
                                               fmi3FMUState* state);
FMI3_EXPORT fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t* n);
FMI3_EXPORT fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t* n);
FMI3_EXPORT fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance c, fmi3ValueReference r, size_t* n);

/* Changes of mode, by name. */
#define FMI3_MODES(ANY)       \
  ANY(ExitInitializationMode) \
  ANY(Terminate)              \
  ANY(Reset)                  \
  ANY(EnterEventMode)         \
  ANY(EnterStepMode)          \
  ANY(EnterConfigurationMode) ANY(ExitConfigurationMode) ANY(EnterContinuousTimeMode) ANY(EvaluateDiscreteStates)
#define FMI3_DECLARE(name) FMI3_EXPORT fmi3Status fmi3##name(fmi3Instance c);
FMI3_MODES(FMI3_DECLARE)
#undef FMI3_DECLARE

/* What this FMU does not have: each of these returns fmi3Error. ANY(name, further arguments) */
#define FMI3_REFERENCES const fmi3ValueReference *r, size_t n
#define FMI3_ABSENT(ANY)                                                                                               \
  ANY(GetVariableDependencies, (fmi3Instance c, fmi3ValueReference r, size_t * i, fmi3ValueReference * on, size_t * j, \
                                fmi3DependencyKind * kinds, size_t n))                                                 \
  ANY(GetDirectionalDerivative, (fmi3Instance c, FMI3_REFERENCES, const fmi3ValueReference* k, size_t nk,              \
                                 const fmi3Float64* seed, size_t ns, fmi3Float64* v, size_t nv))                       \
  ANY(GetAdjointDerivative, (fmi3Instance c, FMI3_REFERENCES, const fmi3ValueReference* k, size_t nk,                  \
                             const fmi3Float64* seed, size_t ns, fmi3Float64* v, size_t nv))                           \
  ANY(GetIntervalDecimal, (fmi3Instance c, FMI3_REFERENCES, fmi3Float64 * v, fmi3IntervalQualifier * q))               \
  ANY(GetIntervalFraction,                                                                                             \
      (fmi3Instance c, FMI3_REFERENCES, fmi3UInt64 * v, fmi3UInt64 * by, fmi3IntervalQualifier * q))                   \
  ANY(GetShiftDecimal, (fmi3Instance c, FMI3_REFERENCES, fmi3Float64 * v))                                             \
  ANY(GetShiftFraction, (fmi3Instance c, FMI3_REFERENCES, fmi3UInt64 * v, fmi3UInt64 * by))                            \
  ANY(SetIntervalDecimal, (fmi3Instance c, FMI3_REFERENCES, const fmi3Float64* v))                                     \
  ANY(SetIntervalFraction, (fmi3Instance c, FMI3_REFERENCES, const fmi3UInt64* v, const fmi3UInt64* by))               \
  ANY(SetShiftDecimal, (fmi3Instance c, FMI3_REFERENCES, const fmi3Float64* v))                                        \
  ANY(SetShiftFraction, (fmi3Instance c, FMI3_REFERENCES, const fmi3UInt64* v, const fmi3UInt64* by))                  \
  ANY(UpdateDiscreteStates, (fmi3Instance c, fmi3Boolean * again, fmi3Boolean * terminate, fmi3Boolean * nominals,     \
                             fmi3Boolean * values, fmi3Boolean * has_next, fmi3Float64 * next))                        \
  ANY(CompletedIntegratorStep, (fmi3Instance c, fmi3Boolean no_return, fmi3Boolean * event, fmi3Boolean * terminate))  \
  ANY(SetTime, (fmi3Instance c, fmi3Float64 time))                                                                     \
  ANY(SetContinuousStates, (fmi3Instance c, const fmi3Float64* v, size_t n))                                           \
  ANY(GetContinuousStateDerivatives, (fmi3Instance c, fmi3Float64 * v, size_t n))                                      \
  ANY(GetEventIndicators, (fmi3Instance c, fmi3Float64 * v, size_t n))                                                 \
  ANY(GetContinuousStates, (fmi3Instance c, fmi3Float64 * v, size_t n))                                                \
  ANY(GetNominalsOfContinuousStates, (fmi3Instance c, fmi3Float64 * v, size_t n))                                      \
  ANY(GetOutputDerivatives, (fmi3Instance c, FMI3_REFERENCES, const fmi3Int32* orders, fmi3Float64* v, size_t values)) \
  ANY(ActivateModelPartition, (fmi3Instance c, fmi3ValueReference clock, fmi3Float64 time))
#define FMI3_DECLARE(name, arguments) FMI3_EXPORT fmi3Status fmi3##name arguments;
FMI3_ABSENT(FMI3_DECLARE)
#undef FMI3_DECLARE

#endif
