/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Functions of FMI 3.0 for what this FMU does not have. */
#include "fmi3.h"

/* There are no variables of other types. */
#define NONE_OF(type)                                                                                               \
  fmi3Status fmi3Get##type(fmi3Instance c, const fmi3ValueReference r[], size_t n, fmi3##type v[], size_t values) { \
    (void)r, (void)v;                                                                                               \
    return c && n == 0 && values == 0 ? fmi3OK : fmi3Error;                                                         \
  }                                                                                                                 \
  fmi3Status fmi3Set##type(fmi3Instance c, const fmi3ValueReference r[], size_t n, const fmi3##type v[],            \
                           size_t values) {                                                                         \
    (void)r, (void)v;                                                                                               \
    return c && n == 0 && values == 0 ? fmi3OK : fmi3Error;                                                         \
  }
NONE_OF(Float32)
NONE_OF(Int8)
NONE_OF(UInt8)
NONE_OF(Int16)
NONE_OF(UInt16)
NONE_OF(UInt32)
NONE_OF(Int64)
NONE_OF(UInt64)
NONE_OF(Boolean)
NONE_OF(String)

fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference r[], size_t n, size_t sizes[], fmi3Binary v[],
                         size_t values) {
  (void)r, (void)sizes, (void)v;
  return c && n == 0 && values == 0 ? fmi3OK : fmi3Error;
}

fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference r[], size_t n, const size_t sizes[],
                         const fmi3Binary v[], size_t values) {
  (void)r, (void)sizes, (void)v;
  return c && n == 0 && values == 0 ? fmi3OK : fmi3Error;
}

fmi3Status fmi3GetClock(fmi3Instance c, const fmi3ValueReference r[], size_t n, fmi3Clock v[]) {
  (void)r, (void)v;
  return c && n == 0 ? fmi3OK : fmi3Error;
}

fmi3Status fmi3SetClock(fmi3Instance c, const fmi3ValueReference r[], size_t n, const fmi3Clock v[]) {
  (void)r, (void)v;
  return c && n == 0 ? fmi3OK : fmi3Error;
}

static fmi3Status nothing(fmi3Instance c, size_t* n) {
  if (!c || !n) return fmi3Error;
  *n = 0;
  return fmi3OK;
}
fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t* n) { return nothing(c, n); }
fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t* n) { return nothing(c, n); }
fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance c, fmi3ValueReference r, size_t* n) {
  (void)r, (void)n;
  return (void)c, fmi3Error;
}

/* Not in the description. */
fmi3Status fmi3GetVariableDependencies(fmi3Instance c, fmi3ValueReference r, size_t* i, fmi3ValueReference* on,
                                       size_t* j, fmi3DependencyKind* kinds, size_t n) {
  (void)c, (void)r, (void)i, (void)on, (void)j, (void)kinds, (void)n;
  return fmi3Error;
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference* r, size_t n,
                                        const fmi3ValueReference* k, size_t nk, const fmi3Float64* seed, size_t ns,
                                        fmi3Float64* v, size_t nv) {
  (void)c, (void)r, (void)n, (void)k, (void)nk, (void)seed, (void)ns, (void)v, (void)nv;
  return fmi3Error;
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance c, const fmi3ValueReference* r, size_t n, const fmi3ValueReference* k,
                                    size_t nk, const fmi3Float64* seed, size_t ns, fmi3Float64* v, size_t nv) {
  (void)c, (void)r, (void)n, (void)k, (void)nk, (void)seed, (void)ns, (void)v, (void)nv;
  return fmi3Error;
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance c, const fmi3ValueReference* r, size_t n, fmi3Float64* v,
                                  fmi3IntervalQualifier* q) {
  (void)c, (void)r, (void)n, (void)v, (void)q;
  return fmi3Error;
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance c, const fmi3ValueReference* r, size_t n, fmi3UInt64* v, fmi3UInt64* by,
                                   fmi3IntervalQualifier* q) {
  (void)c, (void)r, (void)n, (void)v, (void)by, (void)q;
  return fmi3Error;
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance c, const fmi3ValueReference* r, size_t n, fmi3Float64* v) {
  (void)c, (void)r, (void)n, (void)v;
  return fmi3Error;
}

fmi3Status fmi3GetShiftFraction(fmi3Instance c, const fmi3ValueReference* r, size_t n, fmi3UInt64* v, fmi3UInt64* by) {
  (void)c, (void)r, (void)n, (void)v, (void)by;
  return fmi3Error;
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance c, const fmi3ValueReference* r, size_t n, const fmi3Float64* v) {
  (void)c, (void)r, (void)n, (void)v;
  return fmi3Error;
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance c, const fmi3ValueReference* r, size_t n, const fmi3UInt64* v,
                                   const fmi3UInt64* by) {
  (void)c, (void)r, (void)n, (void)v, (void)by;
  return fmi3Error;
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance c, const fmi3ValueReference* r, size_t n, const fmi3Float64* v) {
  (void)c, (void)r, (void)n, (void)v;
  return fmi3Error;
}

fmi3Status fmi3SetShiftFraction(fmi3Instance c, const fmi3ValueReference* r, size_t n, const fmi3UInt64* v,
                                const fmi3UInt64* by) {
  (void)c, (void)r, (void)n, (void)v, (void)by;
  return fmi3Error;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean* again, fmi3Boolean* terminate, fmi3Boolean* nominals,
                                    fmi3Boolean* values, fmi3Boolean* has_next, fmi3Float64* next) {
  (void)c, (void)again, (void)terminate, (void)nominals, (void)values, (void)has_next, (void)next;
  return fmi3Error;
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean no_return, fmi3Boolean* event,
                                       fmi3Boolean* terminate) {
  (void)c, (void)no_return, (void)event, (void)terminate;
  return fmi3Error;
}

fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 time) {
  (void)c, (void)time;
  return fmi3Error;
}

fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64* v, size_t n) {
  (void)c, (void)v, (void)n;
  return fmi3Error;
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64* v, size_t n) {
  (void)c, (void)v, (void)n;
  return fmi3Error;
}

fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64* v, size_t n) {
  (void)c, (void)v, (void)n;
  return fmi3Error;
}

fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64* v, size_t n) {
  (void)c, (void)v, (void)n;
  return fmi3Error;
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64* v, size_t n) {
  (void)c, (void)v, (void)n;
  return fmi3Error;
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance c, const fmi3ValueReference* r, size_t n, const fmi3Int32* orders,
                                    fmi3Float64* v, size_t values) {
  (void)c, (void)r, (void)n, (void)orders, (void)v, (void)values;
  return fmi3Error;
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance c, fmi3ValueReference clock, fmi3Float64 time) {
  (void)c, (void)clock, (void)time;
  return fmi3Error;
}
