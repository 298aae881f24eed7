/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_FMU_TWIN_H
#define THERMOTWIN_FMU_TWIN_H
/* A twin as an FMU has it: its model from resources/model.bin, inputs that are held, a state that can be copied.
 * Values: inputs 0 to channels - 1, sensors in degC, the offsets of the linear axes in um, with an observer their
 * standard deviations; integers 0 the status, 1 the guard, then the fault of each sensor. Numbers of values are
 * unsigned, as the references of FMI are. */

#include "model_bytes.h"
#include "twin.h"

#define FMU_LOG_CATEGORY "logStatusError" /* as the description states it */

typedef void* (*fmu_allocate)(size_t count, size_t size); /* of zeros */
typedef void (*fmu_free)(void*);

typedef struct fmu_twin {
  fmu_allocate allocate;
  fmu_free release;
  unsigned char* bytes;
  const char** texts;
  void *state, *work;
  double *given, *inputs; /* (channels, then sensors) scratch; as they were set, then whether */
  double time;
  int is_current; /* while it is initialised: outputs are those of the inputs */
  tt_model model;
  tt_twin twin;
} fmu_twin;

/* From the folder of resources (a path or a file URI) and the hash that the description states, 16 digits.
 * NULL where there is no such model, with the reason in *why. */
fmu_twin* fmu_open(const char* resources, const char* hash, fmu_allocate allocate, fmu_free release, const char** why);
unsigned fmu_inputs(const fmu_twin* f); /* channels and sensors */
unsigned fmu_outputs(const fmu_twin* f);
double fmu_output(const fmu_twin* f, unsigned i);
/* A channel that was never set counts as one without a column (tt_twin_never_given). */
void fmu_set(fmu_twin* f, unsigned input, double value);
unsigned fmu_integers(const fmu_twin* f);
int fmu_integer(const fmu_twin* f, unsigned i);
void fmu_close(fmu_twin* f);
void fmu_begin(fmu_twin* f); /* anew, with default inputs */
/* The row of the start, with the inputs that are set; may be done again when they have changed. NULL or why not. */
const char* fmu_first(fmu_twin* f, double start);
/* A row at time + step, which begins where the last one ended; inputs below -1e29 or NaN are not given. NULL, or why it
 * is refused: then nothing has changed. stop: HUGE_VAL where there is none. */
const char* fmu_step(fmu_twin* f, double time, double step, double stop);
size_t fmu_state_bytes(const fmu_twin* f);
void fmu_save(const fmu_twin* f, void* bytes);
int fmu_load(fmu_twin* f, const void* bytes, size_t count); /* 0: done */
/* A copied state as bytes: behind it, the check sum of all of them. */
enum { fmu_sum_bytes = 8 };
void fmu_serialise(const void* state, size_t count, void* bytes);
int fmu_is_whole(const void* bytes, size_t count); /* count with the sum */

#endif
