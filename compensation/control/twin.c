/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/twin.h"

#include <math.h>
#include <string.h>

#include "compensation/control/guard.h"
#include "compensation/control/linear.h"
#include "compensation/control/operating.h"
#include "compensation/control/outputs.h"
#include "compensation/control/row_check.h"
#include "compensation/control/scalars.h"

#ifdef __clang__
#pragma STDC FP_CONTRACT OFF
#endif

static const double longest_gap_s = 30 * 86400.0, news_s = 300.0, least_step_s = 1e-6, never = -1e300;

static void lay_out_state(tt_twin* t, tt_arena* arena) {
  const tt_model* m = t->model;
  const size_t channels = (size_t)m->channels, order = (size_t)m->order, linear = (size_t)m->linear_axes,
               readings = (size_t)m->readings, outputs = (size_t)tt_output_count(m), terms = (size_t)m->terms,
               inputs = (size_t)m->inputs;
  t->now = (tt_numbers*)tt_doubles(arena, (sizeof(tt_numbers) + 7) / 8);
  t->row = tt_doubles(arena, channels);
  t->given_at = tt_doubles(arena, channels);
  t->fault = tt_ints(arena, channels);
  t->mean = tt_mean_row_in(arena, m);
  t->chiller = tt_chiller_in(arena, m);
  t->p = tt_doubles(arena, terms);
  t->q = tt_doubles(arena, inputs);
  t->state = tt_doubles(arena, order);
  t->before = tt_doubles(arena, order);
  t->sensors = tt_doubles(arena, readings);
  t->sensors_change = tt_doubles(arena, readings);
  t->base = tt_doubles(arena, outputs);
  t->slope = tt_doubles(arena, outputs);
  t->pose = tt_doubles(arena, (size_t)m->axes);
  t->wanted_um = tt_doubles(arena, linear);
  t->offset_um = tt_doubles(arena, linear);
  t->last_um = tt_doubles(arena, linear);
  t->interval_p = tt_doubles(arena, terms);
  t->interval_q = tt_doubles(arena, inputs);
  t->interval_state = tt_doubles(arena, order);
}

static void lay_out_work(tt_twin* t, tt_arena* arena) {
  const tt_model* m = t->model;
  t->work = tt_work_in(arena, m);
  t->mean_row = tt_doubles(arena, (size_t)m->channels);
  t->given = tt_doubles(arena, (size_t)m->channels);
  t->readings = tt_doubles(arena, (size_t)m->readings);
  t->guide = tt_doubles(arena, (size_t)m->coolants);
  t->occupancy = tt_doubles(arena, (size_t)m->terms);
  t->offset = tt_doubles(arena, (size_t)(m->linear_axes + m->axes));
}

size_t tt_twin_state_bytes(const tt_model* m) {
  tt_twin twin;
  tt_arena arena = {NULL, 0};
  twin.model = m;
  lay_out_state(&twin, &arena);
  return arena.used;
}

size_t tt_twin_work_bytes(const tt_model* m) {
  tt_twin twin;
  tt_arena arena = {NULL, 0};
  twin.model = m;
  lay_out_work(&twin, &arena);
  return arena.used;
}

static void read_sensors(tt_twin* t) {
  const tt_model* m = t->model;
  tt_zero(m->readings, t->sensors);
  tt_gemv_t(m->order, m->readings, 1.0, m->sensor_rows, t->state, t->sensors);
}

void tt_twin_begin(tt_twin* t, const tt_model* m, void* state, void* work) {
  tt_arena of_state = {(unsigned char*)state, 0}, of_work = {(unsigned char*)work, 0};
  t->model = m;
  lay_out_state(t, &of_state);
  lay_out_work(t, &of_work);
  t->block = (unsigned char*)state;
  t->block_bytes = of_state.used;
  tt_copy(m->channels, m->channel_default, t->row);
  for (int k = 0; k < m->channels; ++k) t->given_at[k] = never;
  for (int i = 0; i < m->order; ++i) t->state[i] = m->one_kelvin[i] * (m->start_C - m->reference_C);
  tt_copy(m->order, t->state, t->before);
  read_sensors(t);
  tt_work_prepare(m, &t->work);
  tt_project(m, 0, tt_output_count(m), t->state, t->work.difference, t->base, t->work.next_slope);
}

const double* tt_twin_defaults(const tt_model* m) { return m->channel_default; }

/* Readings that chillers and laws use: predicted ones, with the sensors' own offsets. */
static void guide_readings(tt_twin* t) {
  const tt_model* m = t->model;
  for (int s = 0; s < m->readings; ++s) t->readings[s] = t->sensors[s] + m->sensor_offset[s];
}

/* Times differ by rounding; steps that are meant equal must be equal to reuse a factor. */
static double rounded(double duration) { return duration > 1e-3 ? floor(duration * 1e6 + 0.5) / 1e6 : duration; }

static void begin_job(tt_twin* t, double step_s, double end) {
  const tt_model* m = t->model;
  guide_readings(t);
  tt_guide_K(m, t->mean_row, t->guide);
  tt_chiller_advance(m, t->mean_row, t->readings, t->guide, step_s, &t->chiller);
  tt_coefficients(m, t->mean_row, t->chiller.inlet, t->readings, t->p, t->q, t->occupancy);
  t->now->job_active = 1;
  t->now->slices_done = 0;
  t->now->job_step = step_s;
  t->now->job_end = end;
}

static void take_effect(tt_twin* t) {
  const tt_model* m = t->model;
  const tt_work* w = &t->work;
  const double h = t->now->job_step;
  tt_copy(m->order, t->state, t->before);
  tt_copy(m->order, w->stage, t->state);
  for (int s = 0; s < m->readings; ++s) t->sensors_change[s] = w->next_sensors[s] - t->sensors[s];
  tt_copy(m->readings, w->next_sensors, t->sensors);
  tt_copy(tt_output_count(m), w->next_base, t->base);
  tt_copy(tt_output_count(m), w->next_slope, t->slope);
  t->now->last_step = h;
  t->now->interval_s += h;
  tt_axpy(m->terms, h, t->p, t->interval_p);
  tt_axpy(m->inputs, h, t->q, t->interval_q);
  tt_axpy(m->order, 0.5 * h, t->before, t->interval_state);
  tt_axpy(m->order, 0.5 * h, t->state, t->interval_state);
}

/* Does slices of the job; the last one takes effect. */
static void work_on(tt_twin* t, int slices) {
  tt_numbers* now = t->now;
  const int all = tt_slices(&t->work);
  for (; slices > 0 && now->job_active; --slices) {
    const int bad = tt_slice(t->model, &t->work, now->job_step, t->p, t->q, t->state, now->slices_done);
    if (bad) t->work.factor_step = 0.0;
    if (!bad && ++now->slices_done < all) continue;
    now->job_active = 0;
    now->failed = bad;
    now->step_end = now->job_end;
    if (!bad) take_effect(t);
  }
}

static void finish_job(tt_twin* t) { work_on(t, tt_slices(&t->work)); }

/* Ends the step of the rows so far at the last row's time. whole: its job is done at once */
static void close_step(tt_twin* t, int whole) {
  const double duration = *t->mean.duration, step_s = t->model->step_s;
  finish_job(t);
  tt_mean_take(t->model, &t->mean, t->mean_row);
  if (duration < least_step_s) { /* no heat flows, but the matrix of a step would overflow */
    t->now->step_end = t->now->time;
    return;
  }
  const double wanted = ceil(duration / step_s * (1.0 - 1e-9));
  const int parts = wanted > 1.0 ? (int)wanted : 1;
  const double part_s = rounded(duration / parts);
  t->now->job_began = t->now->time;
  for (int i = 0; i < parts; ++i) {
    begin_job(t, part_s, t->now->time);
    if (whole || parts > 1) finish_job(t);
  }
}

static void advance(tt_twin* t, double time) {
  tt_numbers* now = t->now;
  const double dt = time - now->time, step_s = t->model->step_s, latency = 0.5 * step_s;
  const double share = dt / latency * tt_slices(&t->work);
  const int whole = dt >= latency, active = now->job_active;
  if (*t->mean.duration > 0.0 && *t->mean.duration + dt > step_s * (1.0 + 1e-9)) close_step(t, whole);
  tt_mean_add(t->model, t->row, dt, &t->mean);
  now->time = time;
  if (*t->mean.duration >= step_s * (1.0 - 1e-9)) close_step(t, whole);
  if (whole)
    finish_job(t);
  else if (active || now->job_active)
    work_on(t, (int)ceil(share));
}

/* How far the row is ahead of the last step, in steps: at most 1, and while a job runs as much more, up to 1.5. */
static double share_ahead(const tt_numbers* now) {
  if (!(now->last_step > 0.0)) return 0.0;
  const double more = now->job_active ? tt_min(0.5, (now->time - now->job_began) / now->last_step) : 0.0;
  return tt_min(1.0 + more, (now->time - now->step_end) / now->last_step);
}

void tt_twin_offsets_at(const tt_twin* t, const double* pose, double* offset_um) {
  const tt_model* m = t->model;
  double error[3];
  tt_tcp_error(m, t->base, t->slope, share_ahead(t->now), pose, t->work.scratch, error);
  tt_offsets(m, error, offset_um);
  for (int i = 0; i < m->linear_axes; ++i) offset_um[i] /= 1e-6;
}

/* Takes the given values over. Returns whether an input is missing. */
static int take_inputs(tt_twin* t, double time) {
  const tt_model* m = t->model;
  int missing = tt_check_row(m, t->given, t->fault) > 0;
  tt_update_row(m, t->given, t->row);
  for (int k = 0; k < m->channels; ++k) {
    if (!tt_is_nan(t->given[k]))
      t->given_at[k] = time;
    else if (!tt_is_nan(m->channel_default[k]) && time - t->given_at[k] > news_s)
      missing = 1; /* the last value holds for a while; then it is no longer news */
  }
  return missing;
}

static void start(tt_twin* t, double time) {
  const tt_model* m = t->model;
  t->now->time = t->now->step_end = t->now->started_at = time;
  t->now->started = 1;
  guide_readings(t);
  tt_guide_K(m, t->row, t->guide);
  tt_chiller_start(m, t->readings, t->guide, &t->chiller);
  tt_coefficients(m, t->row, t->chiller.outlet, t->readings, t->p, t->q, t->occupancy);
}

static void write_offsets(tt_twin* t, double time, double duration, int first, int missing) {
  const tt_model* m = t->model;
  tt_numbers* now = t->now;
  double* pose = t->offset + m->linear_axes;
  tt_pose(m, t->row, pose);
  tt_twin_offsets_at(t, pose, t->wanted_um);
  for (int i = 0; now->failed && i < m->linear_axes; ++i) t->wanted_um[i] = tt_nan();
  tt_guard(t, time, duration, first, pose);
  now->status = now->guard == TT_HOLDING_STILL || now->guard == TT_RETURNING ? TT_FAILED
                : missing                                                    ? TT_INPUT_MISSING
                : tt_outside(m, pose)                                        ? TT_OUTSIDE_WORKSPACE
                                                                             : TT_NO_SENSORS;
}

int tt_twin_row(tt_twin* t, double time, const double* channels) {
  const int first = !t->now->started;
  const double duration = first ? 0.0 : time - t->now->time;
  if (!tt_is_finite(time) || (!first && (!(duration > 0.0) || duration > longest_gap_s))) return TT_REFUSED_TIME;
  tt_copy(t->model->channels, channels, t->given);
  const int missing = take_inputs(t, time);
  if (first)
    start(t, time);
  else
    advance(t, time);
  write_offsets(t, time, duration, first, missing);
  return t->now->status;
}

const char* tt_status_text(int status) {
  static const char* const texts[] = {"ok", "limited", "no_sensors", "outside_workspace", "input_missing", "failed"};
  return status >= TT_OK && status <= TT_FAILED ? texts[status] : "refused_time";
}

const char* tt_fault_text(int fault) {
  static const char* const texts[] = {"none", "unreadable", "beyond", "implausible", "kelvin", "fahrenheit"};
  return fault >= TT_FAULT_NONE && fault <= TT_FAULT_FAHRENHEIT ? texts[fault] : "";
}

typedef struct head {
  char magic[8];
  uint64_t version, model, bytes, sum;
} head;

static const char magic[8] = {'t', 't', ' ', 's', 't', 'a', 't', 'e'};
enum { state_version = 1 };

static uint64_t sum_of(const unsigned char* bytes, size_t count) {
  uint64_t sum = UINT64_C(0xCBF29CE484222325);
  for (size_t i = 0; i < count; ++i) sum = (sum ^ bytes[i]) * UINT64_C(0x100000001B3);
  return sum;
}

size_t tt_twin_saved_bytes(const tt_model* m) { return sizeof(head) + tt_twin_state_bytes(m); }

void tt_twin_save(const tt_twin* t, void* saved) {
  head h;
  memcpy(h.magic, magic, sizeof magic);
  h.version = state_version;
  h.model = t->model->hash;
  h.bytes = t->block_bytes;
  h.sum = sum_of(t->block, t->block_bytes);
  memcpy(saved, &h, sizeof h);
  memcpy((unsigned char*)saved + sizeof h, t->block, t->block_bytes);
}

int tt_twin_load(tt_twin* t, const void* saved, size_t bytes) {
  const unsigned char* block = (const unsigned char*)saved + sizeof(head);
  head h;
  if (bytes < sizeof h) return TT_NO_STATE;
  memcpy(&h, saved, sizeof h);
  if (memcmp(h.magic, magic, sizeof magic) != 0) return TT_NO_STATE;
  if (h.version != state_version) return TT_OTHER_VERSION;
  if (h.model != t->model->hash || h.bytes != t->block_bytes) return TT_OTHER_MODEL;
  if (bytes < sizeof h + t->block_bytes || sum_of(block, t->block_bytes) != h.sum) return TT_DAMAGED;
  memcpy(t->block, block, t->block_bytes);
  /* An unfinished job is done again as far as it had come: its slices follow from the state. */
  t->work.factor_step = 0.0;
  for (int i = 0; i < t->now->slices_done && t->now->job_active; ++i)
    tt_slice(t->model, &t->work, t->now->job_step, t->p, t->q, t->state, i);
  return TT_LOADED;
}
