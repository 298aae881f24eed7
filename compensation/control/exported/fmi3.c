/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The twin behind FMI 3.0 for Co-Simulation. A step from t to t + h is a row at t + h with the inputs that are set; the
 * first row is that of the start, when initialisation ends. References: inputs and real outputs as fmu_twin.h numbers
 * them, then its integers, then the time. */
#include "fmi3.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmu_twin.h"

typedef enum { instantiated, initialising, stepping, terminated } phase;

typedef struct instance {
  fmu_twin* twin;
  fmi3InstanceEnvironment environment;
  fmi3LogMessageCallback log;
  fmi3Boolean is_logging;
  double start, stop; /* HUGE_VAL: none */
  phase now;
} instance;

static fmi3Status complain(const instance* i, const char* text) {
  if (i->log && i->is_logging) i->log(i->environment, fmi3Error, FMU_LOG_CATEGORY, text);
  return fmi3Error;
}

static const char for_co_simulation[] = "this FMU is for co-simulation";

/* A call that the state of the instance does not allow. */
static fmi3Status not_now(const instance* i, const char* function) {
  static const char* const phases[] = {"instantiated", "initialised", "stepped", "terminated"};
  char text[128];
  if (!i) return fmi3Error;
  snprintf(text, sizeof text, "%s: not allowed while the instance is %s", function, phases[i->now]);
  return complain(i, text);
}

const char* fmi3GetVersion(void) { return "3.0"; }

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t n, const fmi3String categories[]) {
  instance* i = c;
  (void)n, (void)categories;
  if (!i) return fmi3Error;
  i->is_logging = on;
  return fmi3OK;
}

static fmi3Instance refuse(fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3Boolean logging,
                           const char* why) {
  instance none;
  memset(&none, 0, sizeof none);
  none.environment = environment;
  none.log = log;
  none.is_logging = logging;
  complain(&none, why);
  return NULL;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback log) {
  (void)name, (void)token, (void)resources, (void)visible;
  return refuse(environment, log, logging, for_co_simulation);
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                               fmi3Boolean visible, fmi3Boolean logging,
                                               fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                               fmi3ClockUpdateCallback update, fmi3PreemptionCallback lock,
                                               fmi3PreemptionCallback unlock) {
  (void)name, (void)token, (void)resources, (void)visible, (void)update, (void)lock, (void)unlock;
  return refuse(environment, log, logging, for_co_simulation);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early_return,
                                         const fmi3ValueReference between[], size_t n_between,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
  const char* why = "no memory";
  instance* i;
  (void)name, (void)visible, (void)early_return, (void)between, (void)update;
  if (events) return refuse(environment, log, logging, "eventModeUsed: this FMU has no event mode");
  if (n_between > 0) return refuse(environment, log, logging, "this FMU has no intermediate variables");
  i = calloc(1, sizeof *i);
  if (!i) return NULL;
  i->is_logging = logging;
  i->environment = environment;
  i->log = log;
  i->stop = HUGE_VAL;
  i->twin = fmu_open(resources, token, calloc, free, &why);
  if (i->twin) return i;
  complain(i, why);
  free(i);
  return NULL;
}

void fmi3FreeInstance(fmi3Instance c) {
  instance* i = c;
  if (!i) return;
  fmu_close(i->twin);
  free(i);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean has_tolerance, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean has_stop, fmi3Float64 stop) {
  instance* i = c;
  (void)has_tolerance, (void)tolerance;
  if (!i || i->now != instantiated) return not_now(i, "fmi3EnterInitializationMode");
  if (!isfinite(start)) return complain(i, "the start is no time");
  if (has_stop && !(stop >= start)) return complain(i, "the stop time is before the start");
  i->start = start;
  i->stop = has_stop ? stop : HUGE_VAL;
  i->now = initialising;
  return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
  instance* i = c;
  if (!i || i->now != initialising) return not_now(i, "fmi3ExitInitializationMode");
  const char* why = fmu_first(i->twin, i->start);
  if (why) return complain(i, why);
  i->now = stepping;
  return fmi3OK;
}

fmi3Status fmi3Terminate(fmi3Instance c) {
  instance* i = c;
  if (!i || i->now != stepping) return not_now(i, "fmi3Terminate");
  i->now = terminated;
  return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance c) {
  instance* i = c;
  if (!i) return fmi3Error;
  fmu_begin(i->twin);
  i->start = 0.0;
  i->stop = HUGE_VAL;
  i->now = instantiated;
  return fmi3OK;
}

/* The instance is always in step mode; events and configuration are not in the description. */
fmi3Status fmi3EnterStepMode(fmi3Instance c) {
  const instance* i = c;
  return i && i->now == stepping ? fmi3OK : not_now(i, "fmi3EnterStepMode");
}
fmi3Status fmi3EnterEventMode(fmi3Instance c) { return (void)c, fmi3Error; }
fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) { return (void)c, fmi3Error; }
fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) { return (void)c, fmi3Error; }
fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c) { return (void)c, fmi3Error; }
fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance c) { return (void)c, fmi3Error; }

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 step, fmi3Boolean no_return, fmi3Boolean* event,
                      fmi3Boolean* terminate, fmi3Boolean* early, fmi3Float64* last) {
  instance* i = c;
  (void)no_return;
  if (!i || i->now != stepping) return not_now(i, "fmi3DoStep");
  if (event) *event = false;
  if (terminate) *terminate = false;
  if (early) *early = false;
  if (last) *last = i->twin->time;
  const char* why = fmu_step(i->twin, time, step, i->stop);
  if (why) return complain(i, why);
  if (last) *last = i->twin->time;
  return fmi3OK;
}

/* While it is initialised, outputs are those of the inputs that are set. */
static fmi3Status bring_up(const instance* i) {
  const char* why = i->now == initialising ? fmu_first(i->twin, i->start) : NULL;
  if (why) return complain(i, why);
  return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference r[], size_t n, fmi3Float64 v[], size_t values) {
  const instance* i = c;
  if (!i || values != n) return fmi3Error;
  if (bring_up(i) != fmi3OK) return fmi3Error;
  const unsigned inputs = fmu_inputs(i->twin), outputs = fmu_outputs(i->twin),
                 time = inputs + outputs + fmu_integers(i->twin);
  for (size_t k = 0; k < n; ++k) {
    if (r[k] != time && r[k] >= inputs + outputs) return complain(i, "no real variable of this reference");
    v[k] = r[k] == time ? i->twin->time : r[k] < inputs ? i->twin->inputs[r[k]] : fmu_output(i->twin, r[k] - inputs);
  }
  return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference r[], size_t n, const fmi3Float64 v[],
                          size_t values) {
  const instance* i = c;
  if (!i || i->now == terminated) return not_now(i, "fmi3SetFloat64");
  if (values != n) return complain(i, "fmi3SetFloat64: as many values as references are needed");
  for (size_t k = 0; k < n; ++k)
    if (r[k] >= fmu_inputs(i->twin)) return complain(i, "no input of this reference");
  for (size_t k = 0; k < n; ++k) fmu_set(i->twin, r[k], v[k]);
  return fmi3OK;
}

fmi3Status fmi3GetInt32(fmi3Instance c, const fmi3ValueReference r[], size_t n, fmi3Int32 v[], size_t values) {
  const instance* i = c;
  if (!i || values != n) return fmi3Error;
  if (bring_up(i) != fmi3OK) return fmi3Error;
  const unsigned first = fmu_inputs(i->twin) + fmu_outputs(i->twin), count = fmu_integers(i->twin);
  for (size_t k = 0; k < n; ++k) {
    if (r[k] < first || r[k] >= first + count) return complain(i, "no integer variable of this reference");
    v[k] = fmu_integer(i->twin, r[k] - first);
  }
  return fmi3OK;
}

fmi3Status fmi3SetInt32(fmi3Instance c, const fmi3ValueReference r[], size_t n, const fmi3Int32 v[], size_t values) {
  (void)r, (void)v;
  if (!c) return fmi3Error;
  return n == 0 && values == 0 ? fmi3OK : complain(c, "all inputs are of type Float64");
}

/* A copied state: phase, start and stop, then the twin's. */
typedef struct copied {
  double start, stop, now;
} copied;

static size_t copied_bytes(const instance* i) { return sizeof(copied) + fmu_state_bytes(i->twin); }

fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState* state) {
  const instance* i = c;
  if (!i || !state) return fmi3Error;
  const copied head = {i->start, i->stop, i->now};
  if (!*state) *state = calloc(copied_bytes(i), 1);
  char* to = *state;
  if (!to) return complain(i, "no memory");
  memcpy(to, &head, sizeof head);
  fmu_save(i->twin, to + sizeof head);
  return fmi3OK;
}

fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) {
  instance* i = c;
  const char* from = state;
  copied head;
  if (!i) return fmi3Error;
  if (!state) return complain(i, "fmi3SetFMUState: no state is given");
  memcpy(&head, from, sizeof head);
  if (fmu_load(i->twin, from + sizeof head, fmu_state_bytes(i->twin))) return complain(i, "not a state of this model");
  i->start = head.start;
  i->stop = head.stop;
  i->now = (phase)head.now;
  return fmi3OK;
}

fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState* state) {
  if (!c || !state) return fmi3Error;
  free(*state);
  *state = NULL;
  return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t* size) {
  if (!c || !state || !size) return fmi3Error;
  *size = copied_bytes(c) + fmu_sum_bytes;
  return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
  const instance* i = c;
  if (!i || !state || size < copied_bytes(i) + fmu_sum_bytes) return fmi3Error;
  fmu_serialise(state, copied_bytes(i), bytes);
  return fmi3OK;
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState* state) {
  const instance* i = c;
  if (!i || !state) return fmi3Error;
  if (size != copied_bytes(i) + fmu_sum_bytes) return complain(i, "not a state of this model");
  if (!fmu_is_whole(bytes, size)) return complain(i, "a damaged state");
  if (!*state) *state = calloc(size, 1);
  if (!*state) return complain(i, "no memory");
  memcpy(*state, bytes, copied_bytes(i));
  return fmi3OK;
}
