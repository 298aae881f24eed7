/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "fmu_twin.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { longest_path = 4096, longest_model = 1 << 30 };
#define FMU_NOT_GIVEN (-1e29)
#define FMU_START_NOT_GIVEN (-1e30)

static int hexadecimal(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

/* file:///a%20b/resources, file:/a, file://localhost/a or a path, as a path to the model. */
static int path_of(const char* uri, char* path) {
  size_t n = 0;
  if (strncmp(uri, "file:", 5) == 0) {
    uri += 5;
    if (strncmp(uri, "//localhost/", 12) == 0)
      uri += 11;
    else if (strncmp(uri, "//", 2) == 0)
      uri += 2;
  }
  for (; *uri; ++uri) {
    if (n + 16 > longest_path) return 0;
    if (*uri == '%' && hexadecimal(uri[1]) >= 0 && hexadecimal(uri[2]) >= 0) {
      const int code = 16 * hexadecimal(uri[1]) + hexadecimal(uri[2]);
      if (code == 0) return 0;
      path[n++] = (char)code;
      uri += 2;
    } else {
      path[n++] = *uri;
    }
  }
  while (n > 0 && path[n - 1] == '/') --n;
  memcpy(path + n, "/model.bin", 11);
  return 1;
}

/* The whole file; NULL where it cannot be read. */
static unsigned char* read_whole(const char* path, fmu_allocate allocate, fmu_free release, size_t* size) {
  FILE* file = fopen(path, "rb");
  unsigned char* bytes = NULL;
  long length = -1;
  if (!file) return NULL;
  if (fseek(file, 0, SEEK_END) == 0) length = ftell(file);
  if (length > 0 && length <= longest_model && fseek(file, 0, SEEK_SET) == 0) {
    *size = length;
    bytes = allocate(*size + 8, 1);
    if (bytes && fread(bytes, 1, *size, file) != *size) {
      release(bytes);
      bytes = NULL;
    }
  }
  fclose(file);
  return bytes;
}

static unsigned channels_of(const fmu_twin* f) { return f->model.channels; }

unsigned fmu_inputs(const fmu_twin* f) { return channels_of(f) + (f->model.observer ? f->model.sensors : 0); }

unsigned fmu_outputs(const fmu_twin* f) { return (f->model.observer ? 2 : 1) * f->model.linear_axes; }

double fmu_output(const fmu_twin* f, unsigned i) {
  const unsigned linear = f->model.linear_axes;
  return i < linear ? f->twin.offset_um[i] : f->twin.std_um[i - linear];
}

unsigned fmu_integers(const fmu_twin* f) { return 2 + fmu_inputs(f) - channels_of(f); }

int fmu_integer(const fmu_twin* f, unsigned i) {
  if (i == 0) return f->twin.now->status;
  return i == 1 ? f->twin.now->guard : tt_twin_sensor_fault(&f->twin, i - 2);
}

static const char* read_model(fmu_twin* f, const char* resources, const char* hash) {
  char path[longest_path], own[17];
  size_t size = 0;
  if (!resources || !path_of(resources, path)) return "no path of resources";
  f->bytes = read_whole(path, f->allocate, f->release, &size);
  if (!f->bytes) return "resources/model.bin cannot be read";
  const long texts = tt_model_texts(f->bytes, size);
  if (texts < 0) return "resources/model.bin is no model of this version";
  f->texts = f->allocate(texts + 1, sizeof *f->texts);
  if (!f->texts) return "no memory";
  if (tt_model_read(f->bytes, size, f->texts, &f->model)) return "resources/model.bin is damaged";
  sprintf(own, "%016" PRIx64, f->model.hash);
  if (!hash) return "no guid or token of the description is given";
  return strstr(hash, own) ? NULL : "resources/model.bin belongs to another description";
}

static const char* make_room(fmu_twin* f) {
  f->state = f->allocate(tt_twin_state_bytes(&f->model) + 8, 1);
  f->work = f->allocate(tt_twin_work_bytes(&f->model) + 8, 1);
  f->given = f->allocate(fmu_inputs(f) + 1, sizeof(double));
  f->inputs = f->allocate(2 * fmu_inputs(f) + 1, sizeof(double));
  return f->state && f->work && f->given && f->inputs ? NULL : "no memory";
}

fmu_twin* fmu_open(const char* resources, const char* hash, fmu_allocate allocate, fmu_free release, const char** why) {
  fmu_twin* f = allocate(1, sizeof *f);
  *why = "no memory";
  if (!f) return NULL;
  f->allocate = allocate;
  f->release = release;
  *why = read_model(f, resources, hash);
  if (!*why) *why = make_room(f);
  if (!*why) {
    fmu_begin(f);
    return f;
  }
  fmu_close(f);
  return NULL;
}

void fmu_close(fmu_twin* f) {
  if (!f) return;
  if (f->inputs) f->release(f->inputs);
  if (f->given) f->release(f->given);
  if (f->work) f->release(f->work);
  if (f->state) f->release(f->state);
  if (f->texts) f->release(f->texts);
  if (f->bytes) f->release(f->bytes);
  f->release(f);
}

static void restart(fmu_twin* f) {
  tt_twin_begin(&f->twin, &f->model, f->state, f->work);
  f->time = 0.0;
  f->is_current = 0;
}

/* 1: the input was set; behind the inputs, so that it is saved with them. */
static double* was_set(const fmu_twin* f) { return f->inputs + fmu_inputs(f); }

void fmu_set(fmu_twin* f, unsigned input, double value) {
  f->inputs[input] = value;
  f->is_current = 0;
  if (input < channels_of(f) && was_set(f)[input] == 0.0) f->twin.untold[input] = 0;
  was_set(f)[input] = 1.0;
}

void fmu_begin(fmu_twin* f) {
  restart(f);
  for (int k = 0; k < f->model.channels; ++k) {
    const double usual = f->model.channel_default[k];
    f->inputs[k] = isnan(usual) ? FMU_START_NOT_GIVEN : usual;
  }
  for (unsigned k = channels_of(f); k < fmu_inputs(f); ++k) f->inputs[k] = FMU_START_NOT_GIVEN;
  for (unsigned k = 0; k < fmu_inputs(f); ++k) was_set(f)[k] = 0.0;
}

static int row(fmu_twin* f, double time) {
  for (unsigned k = 0; k < fmu_inputs(f); ++k) f->given[k] = f->inputs[k] > FMU_NOT_GIVEN ? f->inputs[k] : NAN;
  const int status = tt_twin_row(&f->twin, time, f->given, f->given + f->model.channels);
  if (status >= 0) f->time = time;
  return status;
}

const char* fmu_first(fmu_twin* f, double start) {
  if (f->is_current) return NULL;
  restart(f);
  /* Nothing is connected to an input that nobody has set: its value is a guess. */
  for (int k = 0; k < f->model.channels; ++k)
    if (was_set(f)[k] == 0.0 && !isnan(f->model.channel_default[k])) tt_twin_never_given(&f->twin, k);
  if (row(f, start) < 0) return "the start is no time";
  f->is_current = 1;
  return NULL;
}

const char* fmu_step(fmu_twin* f, double time, double step, double stop) {
  if (!isfinite(time) || !isfinite(step)) return "the step is no number of seconds";
  /* Of sums of steps in an importer. */
  const double slack = 1e-6 * fabs(step) + 1e-12 * fabs(time);
  if (!(fabs(time - f->time) <= slack)) return "the step does not begin where the last one ended";
  if (time + step > stop + slack) return "the step ends behind the stop time";
  return row(f, time + step) < 0 ? "the step does not lead on in time" : NULL;
}

/* Time, inputs and which of them were set, then the twin's own saved state. */
static size_t head_bytes(const fmu_twin* f) { return (2 * fmu_inputs(f) + 1) * sizeof(double); }
size_t fmu_state_bytes(const fmu_twin* f) { return head_bytes(f) + tt_twin_saved_bytes(&f->model); }

void fmu_save(const fmu_twin* f, void* bytes) {
  unsigned char* to = bytes;
  memcpy(to, &f->time, sizeof f->time);
  memcpy(to + sizeof f->time, f->inputs, head_bytes(f) - sizeof f->time);
  tt_twin_save(&f->twin, to + head_bytes(f));
}

int fmu_load(fmu_twin* f, const void* bytes, size_t count) {
  const unsigned char* from = bytes;
  if (count != fmu_state_bytes(f)) return 1;
  if (tt_twin_load(&f->twin, from + head_bytes(f), count - head_bytes(f)) != TT_LOADED) return 1;
  memcpy(&f->time, from, sizeof f->time);
  memcpy(f->inputs, from + sizeof f->time, head_bytes(f) - sizeof f->time);
  f->is_current = 0;
  return 0;
}

/* FNV-1a of 64 bits. */
static uint64_t sum_of(const unsigned char* bytes, size_t count) {
  uint64_t sum = UINT64_C(0xCBF29CE484222325);
  for (size_t k = 0; k < count; ++k) sum = (sum ^ bytes[k]) * UINT64_C(0x100000001B3);
  return sum;
}

void fmu_serialise(const void* state, size_t count, void* bytes) {
  const uint64_t sum = sum_of(state, count);
  unsigned char* to = bytes;
  memcpy(to, state, count);
  memcpy(to + count, &sum, fmu_sum_bytes);
}

int fmu_is_whole(const void* bytes, size_t count) {
  const unsigned char* from = bytes;
  uint64_t sum;
  if (count < fmu_sum_bytes) return 0;
  memcpy(&sum, from + count - fmu_sum_bytes, fmu_sum_bytes);
  return sum == sum_of(from, count - fmu_sum_bytes);
}
