/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The twin behind FMI 2.0 for Co-Simulation. A step from t to t + h is a row at t + h with the inputs that are set; the
 * first row is that of the start, when initialisation ends. */
#include "fmi2.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fmu_twin.h"

typedef enum { instantiated, initialising, stepping, terminated, failed } phase;

typedef struct instance {
  fmu_twin* twin;
  char* name;
  fmi2CallbackFunctions callbacks;
  double start;
  phase now;
} instance;

static void* own_allocate(size_t count, size_t size) { return calloc(count, size); }

static fmi2Status complain(const instance* i, fmi2Status status, const char* text) {
  if (i->callbacks.logger)
    i->callbacks.logger(i->callbacks.componentEnvironment, i->name ? i->name : "", status, "error", "%s", text);
  return status;
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
  i = (instance*)empty.callbacks.allocateMemory(1, sizeof *i);
  if (!i) return NULL;
  *i = empty;
  i->name = (char*)i->callbacks.allocateMemory(name ? strlen(name) + 1 : 1, 1);
  if (i->name && name) memcpy(i->name, name, strlen(name));
  i->twin = fmu_open(resources, guid, i->callbacks.allocateMemory, i->callbacks.freeMemory, &why);
  if (i->twin && i->name) return i;
  complain(i, fmi2Error, why ? why : "no memory");
  fmi2FreeInstance(i);
  return NULL;
}

void fmi2FreeInstance(fmi2Component c) {
  instance* i = (instance*)c;
  if (!i) return;
  fmu_close(i->twin);
  if (i->name) i->callbacks.freeMemory(i->name);
  i->callbacks.freeMemory(i);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean has_stop, fmi2Real stop) {
  instance* i = (instance*)c;
  (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
  if (!i || i->now != instantiated || !isfinite(start)) return fmi2Error;
  i->start = start;
  return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
  instance* i = (instance*)c;
  if (!i || i->now != instantiated) return fmi2Error;
  i->now = initialising;
  return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
  instance* i = (instance*)c;
  if (!i || i->now != initialising) return fmi2Error;
  if (fmu_row(i->twin, i->start) < 0) return complain(i, fmi2Error, "the start is no time");
  i->now = stepping;
  return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c) {
  instance* i = (instance*)c;
  if (!i || i->now != stepping) return fmi2Error;
  i->now = terminated;
  return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) {
  instance* i = (instance*)c;
  if (!i) return fmi2Error;
  fmu_begin(i->twin);
  i->start = 0.0;
  i->now = instantiated;
  return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real v[]) {
  const instance* i = (const instance*)c;
  if (!i) return fmi2Error;
  const unsigned inputs = (unsigned)fmu_inputs(i->twin), outputs = (unsigned)fmu_outputs(i->twin);
  for (size_t k = 0; k < n; ++k) {
    if (r[k] >= inputs + outputs) return complain(i, fmi2Error, "no real variable of this reference");
    v[k] = r[k] < inputs ? i->twin->inputs[r[k]] : fmu_output(i->twin, (int)(r[k] - inputs));
  }
  return fmi2OK;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Integer v[]) {
  const instance* i = (const instance*)c;
  if (!i) return fmi2Error;
  for (size_t k = 0; k < n; ++k) {
    if (r[k] >= (unsigned)fmu_integers(i->twin)) return complain(i, fmi2Error, "no integer variable of this reference");
    v[k] = fmu_integer(i->twin, (int)r[k]);
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
  const instance* i = (const instance*)c;
  if (!i) return fmi2Error;
  for (size_t k = 0; k < n; ++k) {
    if (r[k] >= (unsigned)fmu_inputs(i->twin)) return complain(i, fmi2Error, "no input of this reference");
    i->twin->inputs[r[k]] = v[k];
  }
  return fmi2OK;
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer v[]) {
  (void)r, (void)v;
  return c && n == 0 ? fmi2OK : fmi2Error;
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Boolean v[]) {
  (void)r, (void)v;
  return c && n == 0 ? fmi2OK : fmi2Error;
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2String v[]) {
  (void)r, (void)v;
  return c && n == 0 ? fmi2OK : fmi2Error;
}

/* A copied state: phase and start, then the twin's. */
typedef struct copied {
  double start, now;
} copied;

static size_t copied_bytes(const instance* i) { return sizeof(copied) + fmu_state_bytes(i->twin); }

static void copy_out(const instance* i, void* bytes) {
  const copied head = {i->start, (double)i->now};
  memcpy(bytes, &head, sizeof head);
  fmu_save(i->twin, (char*)bytes + sizeof head);
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate* state) {
  const instance* i = (const instance*)c;
  if (!i || !state) return fmi2Error;
  if (!*state) *state = i->callbacks.allocateMemory(copied_bytes(i), 1);
  if (!*state) return complain(i, fmi2Error, "no memory");
  copy_out(i, *state);
  return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
  instance* i = (instance*)c;
  copied head;
  if (!i || !state) return fmi2Error;
  memcpy(&head, state, sizeof head);
  if (fmu_load(i->twin, (const char*)state + sizeof head, fmu_state_bytes(i->twin)))
    return complain(i, fmi2Error, "not a state of this model");
  i->start = head.start;
  i->now = (phase)head.now;
  return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate* state) {
  const instance* i = (const instance*)c;
  if (!i || !state) return fmi2Error;
  if (*state) i->callbacks.freeMemory(*state);
  *state = NULL;
  return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t* size) {
  const instance* i = (const instance*)c;
  if (!i || !state || !size) return fmi2Error;
  *size = copied_bytes(i);
  return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
  const instance* i = (const instance*)c;
  if (!i || !state || size < copied_bytes(i)) return fmi2Error;
  memcpy(bytes, state, copied_bytes(i));
  return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate* state) {
  const instance* i = (const instance*)c;
  if (!i || !state || size != copied_bytes(i)) return fmi2Error;
  if (!*state) *state = i->callbacks.allocateMemory(size, 1);
  if (!*state) return complain(i, fmi2Error, "no memory");
  memcpy(*state, bytes, size);
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
  instance* i = (instance*)c;
  (void)no_return;
  if (!i || i->now != stepping) return fmi2Error;
  if (fmu_row(i->twin, time + step) < 0) return complain(i, fmi2Error, "the step does not lead on in time");
  return fmi2OK;
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
  const instance* i = (const instance*)c;
  if (!i || kind != fmi2LastSuccessfulTime) return fmi2Discard;
  *value = i->twin->twin.now->time;
  return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, fmi2StatusKind kind, fmi2Integer* value) {
  (void)c, (void)kind, (void)value;
  return fmi2Discard;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, fmi2StatusKind kind, fmi2Boolean* value) {
  if (!c || kind != fmi2Terminated) return fmi2Discard;
  *value = ((const instance*)c)->now == terminated;
  return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, fmi2StatusKind kind, fmi2String* value) {
  (void)c, (void)kind, (void)value;
  return fmi2Discard;
}
