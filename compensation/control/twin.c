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
#include "compensation/control/twin_jobs.h"

#ifdef __clang__
#pragma STDC FP_CONTRACT OFF
#endif

static const double longest_gap_s = 30 * 86400.0, least_step_s = 1e-6, never = -1e300;
static const double leap_share = 0.2;          /* an input leaps if it changes by more of itself from row to row */
static const double offset_error_share = 0.03; /* of an offset, for what the observer does not estimate */
static const double probed_error_share = 0.01; /* the same once probing has estimated expansions */
#define UM 1e-6

static void lay_out(tt_twin* t, tt_arena* state, tt_arena* work) {
  const tt_model* m = t->model;
  const ptrdiff_t channels = m->channels, order = m->order, linear = m->linear_axes, readings = m->readings,
                  outputs = tt_output_count(m), terms = m->terms, inputs = m->inputs;
  t->now = tt_bytes(state, sizeof(tt_numbers));
  double** const of_channels[] = {&t->row, &t->given_at};
  double** const of_states[] = {&t->state, &t->before, &t->change, &t->interval_state};
  double** const of_offsets[] = {&t->wanted_um, &t->offset_um, &t->std_um, &t->last_um};
  for (size_t i = 0; i < sizeof of_channels / sizeof *of_channels; ++i) *of_channels[i] = tt_doubles(state, channels);
  for (size_t i = 0; i < sizeof of_states / sizeof *of_states; ++i) *of_states[i] = tt_doubles(state, order);
  for (size_t i = 0; i < sizeof of_offsets / sizeof *of_offsets; ++i) *of_offsets[i] = tt_doubles(state, linear);
  t->fault = tt_ints(state, channels);
  t->untold = tt_ints(state, channels);
  t->mean = tt_mean_row_in(state, m);
  t->chiller = tt_chiller_in(state, m);
  t->p = tt_doubles(state, terms);
  t->q = tt_doubles(state, inputs);
  t->sensors = tt_doubles(state, readings);
  t->sensors_change = tt_doubles(state, readings);
  t->base = tt_doubles(state, outputs);
  t->slope = tt_doubles(state, outputs);
  t->pose = tt_doubles(state, m->axes);
  t->interval_p = tt_doubles(state, terms);
  t->interval_q = tt_doubles(state, inputs);
  t->work = tt_work_in(work, m);
  t->mean_row = tt_doubles(work, channels);
  t->given = tt_doubles(work, channels);
  t->row_before = tt_doubles(work, channels);
  t->readings = tt_doubles(work, readings);
  t->guide = tt_doubles(work, m->coolants);
  t->occupancy = tt_doubles(work, terms);
  t->offset = tt_doubles(work, linear + m->axes);
  t->off_row = tt_doubles(work, channels);
  t->pose_rows = tt_doubles(work, 7 * order);
  tt_lay_jobs(t, state, work);
}

static tt_arena counted(const tt_model* m, int of_state) {
  tt_twin twin;
  tt_arena state = {NULL, 0}, work = {NULL, 0};
  twin.model = m;
  lay_out(&twin, &state, &work);
  return of_state ? state : work;
}

size_t tt_twin_state_bytes(const tt_model* m) { return counted(m, 1).used; }
size_t tt_twin_work_bytes(const tt_model* m) { return counted(m, 0).used; }

void tt_twin_begin(tt_twin* t, const tt_model* m, void* state, void* work) {
  tt_arena of_state = {state, 0}, of_work = {work, 0};
  t->model = m;
  lay_out(t, &of_state, &of_work);
  t->block = state;
  t->block_bytes = of_state.used;
  tt_copy(m->channels, m->channel_default, t->row);
  for (int k = 0; k < m->channels; ++k) t->given_at[k] = never;
  for (int i = 0; i < m->order; ++i) t->state[i] = m->one_kelvin[i] * (m->start_C - m->reference_C);
  tt_copy(m->order, t->state, t->before);
  tt_read_predicted(t);
  tt_work_prepare(m, &t->work);
  tt_reset_jobs(t);
  tt_project(m, 0, tt_output_count(m), t->state, t->change, t->base, t->work.next_slope);
}

const double* tt_twin_defaults(const tt_model* m) { return m->channel_default; }

void tt_twin_never_given(tt_twin* t, int channel) {
  t->untold[channel] = 1;
  if (t->model->observer && channel == t->model->air_channel) tt_errors_air_is_untold(&t->observer.errors);
}

/* Times differ by rounding; steps that are meant equal must be equal to reuse a factor. */
static double rounded(double duration) { return duration > 1e-3 ? floor(duration * 1e6 + 0.5) / 1e6 : duration; }

/* What is under way, and a correction that is due after it. */
static void finish(tt_twin* t) {
  tt_finish_job(t);
  if (!tt_correction_due(t)) return;
  tt_begin_correction(t);
  tt_finish_job(t);
}

/* Ends the step of the rows so far at the last row's time. whole: its job is done at once */
static void close_step(tt_twin* t, int whole) {
  const double duration = *t->mean.duration, step_s = t->model->step_s;
  finish(t);
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
    if (i > 0) finish(t);
    tt_begin_step(t, part_s, i + 1 < parts ? t->now->step_end + part_s : t->now->time);
    if (whole || parts > 1) tt_finish_job(t);
  }
}

/* Slices of the job in progress that fall to a row. */
static int share_of(const tt_twin* t, double dt, double latency) { return (int)ceil(dt / latency * tt_job_slices(t)); }

/* Each row's readings are judged beside what the model then expects, before they correct it. */
static void use_readings(tt_twin* t) {
  const tt_model* m = t->model;
  const tt_moment now = tt_moment_of(t);
  int leapt = 0;
  for (int i = 0; i < m->leaping; ++i) {
    const double to = t->row[m->leaping_channel[i]], from = t->row_before[m->leaping_channel[i]];
    leapt = leapt || fabs(to - from) > leap_share * tt_max(fabs(to), fabs(from));
  }
  tt_observer_add_readings(&t->observer, &now, leapt);
}

static void advance(tt_twin* t, double time) {
  tt_numbers* now = t->now;
  const double dt = time - now->time, step_s = t->model->step_s, latency = 0.5 * step_s;
  const int whole = dt >= latency, job = now->job, share = share_of(t, dt, latency);
  if (*t->mean.duration > 0.0 && *t->mean.duration + dt > step_s * (1.0 + 1e-9)) {
    close_step(t, whole);
    if (whole) finish(t);
  }
  tt_mean_add(t->model, t->row, dt, &t->mean);
  now->time = time;
  if (*t->mean.duration >= step_s * (1.0 - 1e-9)) close_step(t, whole);
  if (whole)
    tt_finish_job(t);
  else if (now->job != TT_JOB_NONE)
    tt_work_on(t, now->job == job ? share : share_of(t, dt, latency));
  if (!t->model->observer) return;
  use_readings(t);
  if (!tt_correction_due(t)) return;
  tt_begin_correction(t);
  if (whole) tt_finish_job(t);
}

/* Error of the TCP at a pose, with what probing has found of the sides. */
static void error_at(const tt_twin* t, const double* pose, double error[3]) {
  const tt_model* m = t->model;
  double sides[19], side[19] = {0}, tool[3], table[3], shares[tt_outputs];
  tt_sides_at(m, t->base, t->slope, tt_share_ahead(t), pose, t->work.scratch, sides);
  if (!m->observer || !tt_errors_learns(&t->observer.errors)) {
    tt_error_of_sides(m, pose, sides, error);
    return;
  }
  tt_errors_output_shares(&t->observer.errors, shares);
  tt_copy(6, sides, side);
  tt_error_of_sides(m, pose, side, tool);
  tt_zero(6, sides);
  tt_error_of_sides(m, pose, sides, table);
  for (int i = 0; i < 3; ++i) error[i] = (1.0 + shares[i]) * tool[i] + (1.0 + shares[3 + i]) * table[i] + shares[6 + i];
}

void tt_twin_offsets_at(const tt_twin* t, const double* pose, double* offset_um) {
  const tt_model* m = t->model;
  double error[3];
  error_at(t, pose, error);
  tt_offsets(m, error, offset_um);
  for (int i = 0; i < m->linear_axes; ++i) offset_um[i] /= UM;
}

/* Takes the given values over. Returns whether an input is missing. */
static int take_inputs(tt_twin* t, double time) {
  const tt_model* m = t->model;
  int missing = tt_check_row(m, t->given, t->fault) > 0;
  tt_copy(m->channels, t->row, t->row_before);
  tt_update_row(m, t->given, t->row);
  for (int k = 0; k < m->channels; ++k) {
    if (!tt_is_nan(t->given[k]))
      t->given_at[k] = time;
    else if (!tt_is_nan(m->channel_default[k]) && time - t->given_at[k] > m->correction_s)
      missing = 1; /* the last value holds for a while; then it is no longer news */
  }
  return missing;
}

/* Drives whose speed was never told, or not for a while, since the row before. */
static void add_drives(tt_twin* t, double time, double duration) {
  const tt_model* m = t->model;
  tt_observer_add_row(&t->observer, duration);
  for (int d = 0; d < m->heating; ++d) {
    const int drive = m->heating_drive[d], k = m->drive_channel[drive];
    if (!t->untold[k] && !(tt_is_nan(t->given[k]) && time - t->given_at[k] > m->correction_s)) continue;
    tt_zero(m->coolants, t->guide);
    tt_day_drive_heat(&t->day, drive, t->row, t->heat);
    tt_observer_add_drive(&t->observer, d, duration, t->heat, fabs(t->row[k]) / m->drive_half_speed[drive]);
  }
}

/* The first row. */
static void start(tt_twin* t, double time, const double* sensors_C) {
  t->now->time = t->now->step_end = t->now->started_at = time;
  t->now->started = 1;
  if (!t->model->observer) {
    tt_start_clock(t, t->row);
    return;
  }
  tt_observer_read(&t->observer, sensors_C, t->row);
  tt_begin_start(t);
  if (!(t->model->start_over_s > 0.0)) tt_finish_job(t);
}

/* Slices of the start that are to be done by some time after the first row. */
static int due_of_start(const tt_twin* t, double time) {
  return (int)ceil((time - t->now->job_began) / t->model->start_over_s * tt_job_slices(t));
}

/* Whether the start is still under way. */
static int still_starts(tt_twin* t, double time) {
  if (t->now->job != TT_JOB_START) return 0;
  if (time - t->now->time >= t->model->start_over_s)
    tt_finish_job(t);
  else
    tt_work_on(t, due_of_start(t, time) - due_of_start(t, t->now->time));
  if (t->now->job != TT_JOB_START) return 0;
  t->now->time = time;
  return 1;
}

void tt_twin_std_at(const tt_twin* t, const double* pose, const double* offset_um, double* std_um) {
  const tt_model* m = t->model;
  if (!m->observer) {
    for (int i = 0; i < m->linear_axes; ++i) std_um[i] = tt_nan();
    return;
  }
  const double share = tt_errors_learns(&t->observer.errors) ? probed_error_share : offset_error_share;
  tt_deviation_at(&t->deviation, m, pose, std_um);
  for (int i = 0; i < m->linear_axes; ++i) {
    const double rest = share * offset_um[i] * UM;
    std_um[i] = sqrt(std_um[i] + rest * rest + m->model_error * m->model_error) / UM;
  }
}

/* Deviations of the offsets. Returns whether the guard keeps back more than the model's own. */
static int write_deviations(tt_twin* t, const double* pose) {
  int held_back = 0;
  tt_twin_std_at(t, pose, t->wanted_um, t->std_um);
  for (int i = 0; t->model->observer && i < t->model->linear_axes; ++i) {
    const double own_um = t->std_um[i], back_um = t->wanted_um[i] - t->offset_um[i];
    held_back = held_back || fabs(back_um) > own_um;
    t->std_um[i] = sqrt(own_um * own_um + back_um * back_um);
  }
  return held_back;
}

static void set_deviations(tt_twin* t, double value_um) {
  for (int i = 0; t->model->observer && i < t->model->linear_axes; ++i) t->std_um[i] = value_um;
}

/* What the sensors say about a row. */
static int sensor_status(const tt_twin* t, int held_back) {
  const tt_model* m = t->model;
  if (!m->observer) return TT_NO_SENSORS;
  const tt_trust* trust = &t->observer.trust;
  if (!tt_observer_any_reading(&t->observer) && !tt_any_sensor_out(&trust->check)) return TT_NO_SENSORS;
  for (int s = 0; s < m->sensors; ++s) {
    if (trust->named[s] != TT_SENSOR_FINE) return TT_SENSOR_FAILED;
  }
  return held_back ? TT_LIMITED : TT_OK;
}

static void write_offsets(tt_twin* t, double time, double duration, int missing) {
  const tt_model* m = t->model;
  tt_numbers* now = t->now;
  double* pose = t->offset + m->linear_axes;
  tt_pose(m, t->row, pose);
  tt_twin_offsets_at(t, pose, t->wanted_um);
  for (int i = 0; now->failed && i < m->linear_axes; ++i) t->wanted_um[i] = tt_nan();
  tt_guard(t, time, duration, !now->guarded, pose);
  now->guarded = 1;
  const int held_back = write_deviations(t, pose);
  now->status = now->guard == TT_HOLDING_STILL || now->guard == TT_RETURNING ? TT_FAILED
                : missing                                                    ? TT_INPUT_MISSING
                : tt_outside(m, pose)                                        ? TT_OUTSIDE_WORKSPACE
                                                                             : sensor_status(t, held_back);
  if (now->status == TT_FAILED) set_deviations(t, m->largest_um);
}

int tt_twin_row(tt_twin* t, double time, const double* channels, const double* sensors_C) {
  const int first = !t->now->started;
  const double duration = first ? 0.0 : time - t->now->time;
  if (!tt_is_finite(time) || (!first && (!(duration > 0.0) || duration > longest_gap_s))) return TT_REFUSED_TIME;
  tt_copy(t->model->channels, channels, t->given);
  const int missing = take_inputs(t, time);
  if (first) start(t, time, sensors_C);
  if (first ? t->now->job == TT_JOB_START : still_starts(t, time)) {
    set_deviations(t, t->model->largest_um);
    return t->now->status = TT_STARTING;
  }
  if (!first && t->model->observer) {
    tt_observer_read(&t->observer, sensors_C, t->row);
    add_drives(t, time, duration);
  }
  if (!first) advance(t, time);
  write_offsets(t, time, t->now->guarded ? duration : 0.0, missing);
  return t->now->status;
}

int tt_twin_sensor_fault(const tt_twin* t, int sensor) {
  return t->model->observer ? t->observer.trust.named[sensor] : TT_SENSOR_FINE;
}

const char* tt_twin_sensor_fault_text(const tt_twin* t, int sensor) {
  return tt_sensor_fault_text(tt_twin_sensor_fault(t, sensor));
}

void tt_twin_predicted_C(const tt_twin* t, double* readings_C) {
  const tt_moment now = tt_moment_of(t);
  for (int s = 0; s < t->model->sensors; ++s) readings_C[s] = tt_nan();
  if (t->model->observer) tt_observer_predicted_C(&t->observer, &now, readings_C);
}

const char* tt_status_text(int status) {
  static const char* const texts[] = {
      "ok", "limited", "sensor_failed", "no_sensors", "outside_workspace", "input_missing", "starting", "failed"};
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
enum { state_version = 7 };

static uint64_t sum_of(const unsigned char* bytes, size_t count) {
  uint64_t sum = UINT64_C(0xCBF29CE484222325);
  for (size_t i = 0; i < count; ++i) sum = (sum ^ bytes[i]) * UINT64_C(0x100000001B3);
  return sum;
}

size_t tt_twin_saved_bytes(const tt_model* m) { return sizeof(head) + tt_twin_state_bytes(m); }

void tt_twin_save(const tt_twin* t, void* saved) {
  unsigned char* to = saved;
  head h;
  memcpy(h.magic, magic, sizeof magic);
  h.version = state_version;
  h.model = t->model->hash;
  h.bytes = t->block_bytes;
  h.sum = sum_of(t->block, t->block_bytes);
  memcpy(to, &h, sizeof h);
  memcpy(to + sizeof h, t->block, t->block_bytes);
}

int tt_twin_load(tt_twin* t, const void* saved, size_t bytes) {
  const unsigned char* block;
  head h;
  if (bytes < sizeof h) return TT_NO_STATE;
  memcpy(&h, saved, sizeof h);
  block = (const unsigned char*)saved + sizeof h;
  if (memcmp(h.magic, magic, sizeof magic) != 0) return TT_NO_STATE;
  if (h.version != state_version) return TT_OTHER_VERSION;
  if (h.model != t->model->hash || h.bytes != t->block_bytes) return TT_OTHER_MODEL;
  if (bytes != sizeof h + t->block_bytes || sum_of(block, t->block_bytes) != h.sum) return TT_DAMAGED;
  memcpy(t->block, block, t->block_bytes);
  tt_redo_job(t); /* an unfinished one, as far as it had come: its slices follow from the state */
  return TT_LOADED;
}
