/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The twin behind FMI 2.0 for Co-Simulation. A step from t to t + h is a row at t + h with the inputs that are set; the
 * first row is that of the start, when initialisation ends. */
#include "fmi2.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmu_twin.h"

typedef enum { instantiated, initialising, stepping, terminated } phase;

typedef struct instance {
  fmu_twin* twin;
  char* name;
  fmi2CallbackFunctions callbacks;
  double start, stop; /* HUGE_VAL: none */
  phase now;
} instance;

static void* own_allocate(size_t count, size_t size) { return calloc(count, size); }

static fmi2Status complain(const instance* i, fmi2Status status, const char* text) {
  if (i->callbacks.logger)
    i->callbacks.logger(i->callbacks.componentEnvironment, i->name ? i->name : "", status, FMU_LOG_CATEGORY, "%s",
                        text);
  return status;
}

/* A call that the state of the instance does not allow. */
static fmi2Status not_now(const instance* i, const char* function) {
  static const char* const phases[] = {"instantiated", "initialised", "stepped", "terminated"};
  char text[128];
  if (!i) return fmi2Error;
  snprintf(text, sizeof text, "%s: not allowed while the instance is %s", function, phases[i->now]);
  return complain(i, fmi2Error, text);
}

const char* fmi2GetTypesPlatform(void) { return "default"; }
const char* fmi2GetVersion(void) { return "2.0"; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
  (void)on, (void)n, (void)categories;
  return c ? fmi2OK : fmi2Error;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions* callbacks, fmi2Boolean visible, fmi2Boolean logging) {
  instance empty, *i;
  const char* why = NULL;
  (void)visible, (void)logging;
  memset(&empty, 0, sizeof empty);
  if (callbacks) empty.callbacks = *callbacks;
  if (!empty.callbacks.allocateMemory || !empty.callbacks.freeMemory) {
    empty.callbacks.allocateMemory = own_allocate;
    empty.callbacks.freeMemory = free;
  }
  if (type != fmi2CoSimulation) {
    complain(&empty, fmi2Error, "this FMU is for co-simulation");
    return NULL;
  }
  i = empty.callbacks.allocateMemory(1, sizeof *i);
  if (!i) return NULL;
  *i = empty;
  i->name = i->callbacks.allocateMemory(name ? strlen(name) + 1 : 1, 1);
  if (i->name && name) memcpy(i->name, name, strlen(name));
  i->stop = HUGE_VAL;
  i->twin = fmu_open(resources, guid, i->callbacks.allocateMemory, i->callbacks.freeMemory, &why);
  if (i->twin && i->name) return i;
  complain(i, fmi2Error, why ? why : "no memory");
  fmi2FreeInstance(i);
  return NULL;
}

void fmi2FreeInstance(fmi2Component c) {
  instance* i = c;
  if (!i) return;
  fmu_close(i->twin);
  if (i->name) i->callbacks.freeMemory(i->name);
  i->callbacks.freeMemory(i);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean has_stop, fmi2Real stop) {
  instance* i = c;
  (void)has_tolerance, (void)tolerance;
  if (!i || i->now != instantiated) return not_now(i, "fmi2SetupExperiment");
  if (!isfinite(start)) return complain(i, fmi2Error, "the start is no time");
  if (has_stop && !(stop >= start)) return complain(i, fmi2Error, "the stop time is before the start");
  i->start = start;
  i->stop = has_stop ? stop : HUGE_VAL;
  return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
  instance* i = c;
  if (!i || i->now != instantiated) return not_now(i, "fmi2EnterInitializationMode");
  i->now = initialising;
  return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
  instance* i = c;
  if (!i || i->now != initialising) return not_now(i, "fmi2ExitInitializationMode");
  const char* why = fmu_first(i->twin, i->start);
  if (why) return complain(i, fmi2Error, why);
  i->now = stepping;
  return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c) {
  instance* i = c;
  if (!i || i->now != stepping) return not_now(i, "fmi2Terminate");
  i->now = terminated;
  return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) {
  instance* i = c;
  if (!i) return fmi2Error;
  fmu_begin(i->twin);
  i->start = 0.0;
  i->stop = HUGE_VAL;
  i->now = instantiated;
  return fmi2OK;
}

/* While it is initialised, outputs are those of the inputs that are set. */
static fmi2Status bring_up(const instance* i) {
  const char* why = i->now == initialising ? fmu_first(i->twin, i->start) : NULL;
  if (why) return complain(i, fmi2Error, why);
  return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real v[]) {
  const instance* i = c;
  if (!i) return fmi2Error;
  if (bring_up(i) != fmi2OK) return fmi2Error;
  const unsigned inputs = fmu_inputs(i->twin), outputs = fmu_outputs(i->twin);
  for (size_t k = 0; k < n; ++k) {
    if (r[k] >= inputs + outputs) return complain(i, fmi2Error, "no real variable of this reference");
    v[k] = r[k] < inputs ? i->twin->inputs[r[k]] : fmu_output(i->twin, r[k] - inputs);
  }
  return fmi2OK;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Integer v[]) {
  const instance* i = c;
  if (!i) return fmi2Error;
  if (bring_up(i) != fmi2OK) return fmi2Error;
  for (size_t k = 0; k < n; ++k) {
    if (r[k] >= fmu_integers(i->twin)) return complain(i, fmi2Error, "no integer variable of this reference");
    v[k] = fmu_integer(i->twin, r[k]);
  }
  return fmi2OK;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Boolean v[]) {
  (void)r, (void)v;
  return c && n == 0 ? fmi2OK : fmi2Error;
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2String v[]) {
  (void)r, (void)v;
  return c && n == 0 ? fmi2OK : fmi2Error;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real v[]) {
  const instance* i = c;
  if (!i || i->now == terminated) return not_now(i, "fmi2SetReal");
  for (size_t k = 0; k < n; ++k)
    if (r[k] >= fmu_inputs(i->twin)) return complain(i, fmi2Error, "no input of this reference");
  for (size_t k = 0; k < n; ++k) fmu_set(i->twin, r[k], v[k]);
  return fmi2OK;
}

/* Of a type that no variable to be set has. */
static fmi2Status set_none(const instance* i, size_t n) {
  if (!i) return fmi2Error;
  return n == 0 ? fmi2OK : complain(i, fmi2Error, "all inputs are real");
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer v[]) {
  (void)r, (void)v;
  return set_none(c, n);
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Boolean v[]) {
  (void)r, (void)v;
  return set_none(c, n);
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2String v[]) {
  (void)r, (void)v;
  return set_none(c, n);
}

/* A copied state: phase, start and stop, then the twin's. */
typedef struct copied {
  double start, stop, now;
} copied;

static size_t copied_bytes(const instance* i) { return sizeof(copied) + fmu_state_bytes(i->twin); }

static void copy_out(const instance* i, void* bytes) {
  char* to = bytes;
  const copied head = {i->start, i->stop, i->now};
  memcpy(to, &head, sizeof head);
  fmu_save(i->twin, to + sizeof head);
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate* state) {
  const instance* i = c;
  if (!i || !state) return fmi2Error;
  if (!*state) *state = i->callbacks.allocateMemory(copied_bytes(i), 1);
  if (!*state) return complain(i, fmi2Error, "no memory");
  copy_out(i, *state);
  return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
  instance* i = c;
  const char* from = state;
  copied head;
  if (!i) return fmi2Error;
  if (!state) return complain(i, fmi2Error, "fmi2SetFMUstate: no state is given");
  memcpy(&head, from, sizeof head);
  if (fmu_load(i->twin, from + sizeof head, fmu_state_bytes(i->twin)))
    return complain(i, fmi2Error, "not a state of this model");
  i->start = head.start;
  i->stop = head.stop;
  i->now = (phase)head.now;
  return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate* state) {
  const instance* i = c;
  if (!i || !state) return fmi2Error;
  if (*state) i->callbacks.freeMemory(*state);
  *state = NULL;
  return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t* size) {
  const instance* i = c;
  if (!i || !state || !size) return fmi2Error;
  *size = copied_bytes(i) + fmu_sum_bytes;
  return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
  const instance* i = c;
  if (!i || !state || size < copied_bytes(i) + fmu_sum_bytes) return fmi2Error;
  fmu_serialise(state, copied_bytes(i), bytes);
  return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate* state) {
  const instance* i = c;
  if (!i || !state) return fmi2Error;
  if (size != copied_bytes(i) + fmu_sum_bytes) return complain(i, fmi2Error, "not a state of this model");
  if (!fmu_is_whole(bytes, size)) return complain(i, fmi2Error, "a damaged state");
  if (!*state) *state = i->callbacks.allocateMemory(size, 1);
  if (!*state) return complain(i, fmi2Error, "no memory");
  memcpy(*state, bytes, copied_bytes(i));
  return fmi2OK;
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t nu,
                                        const fmi2ValueReference known[], size_t nk, const fmi2Real dk[],
                                        fmi2Real du[]) {
  (void)c, (void)unknown, (void)nu, (void)known, (void)nk, (void)dk, (void)du;
  return fmi2Error; /* the description says that there is none; so with the following */
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference r[], size_t n,
                                       const fmi2Integer order[], const fmi2Real v[]) {
  (void)c, (void)r, (void)n, (void)order, (void)v;
  return fmi2Error;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference r[], size_t n,
                                        const fmi2Integer order[], fmi2Real v[]) {
  (void)c, (void)r, (void)n, (void)order, (void)v;
  return fmi2Error;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_return) {
  instance* i = c;
  (void)no_return;
  if (!i || i->now != stepping) return not_now(i, "fmi2DoStep");
  const char* why = fmu_step(i->twin, time, step, i->stop);
  return why ? complain(i, fmi2Error, why) : fmi2OK;
}

fmi2Status fmi2CancelStep(fmi2Component c) {
  (void)c;
  return fmi2Error; /* steps end at once */
}

fmi2Status fmi2GetStatus(fmi2Component c, fmi2StatusKind kind, fmi2Status* value) {
  (void)c, (void)kind, (void)value;
  return fmi2Discard;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, fmi2StatusKind kind, fmi2Real* value) {
  const instance* i = c;
  if (!i || kind != fmi2LastSuccessfulTime) return fmi2Discard;
  *value = i->twin->twin.now->time;
  return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, fmi2StatusKind kind, fmi2Integer* value) {
  (void)c, (void)kind, (void)value;
  return fmi2Discard;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, fmi2StatusKind kind, fmi2Boolean* value) {
  const instance* i = c;
  if (!i || kind != fmi2Terminated) return fmi2Discard;
  *value = i->now == terminated;
  return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, fmi2StatusKind kind, fmi2String* value) {
  (void)c, (void)kind, (void)value;
  return fmi2Discard;
}
