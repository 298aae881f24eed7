/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The pins of the thermal model in HAL. This process owns pins and does hardly anything else: the model is a process of
 * its own (thermotwin_model), which may die and is started again. Offsets go to thermotwin_guard, never to an axis.
 *
 *   thermotwin_pins --model PROGRAM --state FILE [--name thermotwin] [--period-ms 10] [--mm-per-unit 1]
 *
 * Inputs: a pin for each channel of the model, in the channel's unit; positions of linear axes in the machine's unit.
 * A float pin that nothing is linked to is not given. Feeds follow from the positions. A pin for each temperature
 * sensor, degC. Outputs: offset-X-um and so on, and their standard deviations;
 * heartbeat, which changes with every valid answer; status (twin.h), fault (model_rows.h), model-is-up, restarts, and
 * the time from reading the inputs to setting the offsets. */
#define _POSIX_C_SOURCE 200809L
#include <hal.h>
#include <math.h>
#include <rtapi_errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "model_link.h"
#include "twin.h"

typedef struct all_pins {
  hal_float_t *value[TT_CHANNELS], *sensor_C[TT_SENSORS + 1], *offset_um[TT_LINEAR_AXES], *std_um[TT_LINEAR_AXES];
  hal_float_t *answer_ms, *slowest_ms;
  hal_bit_t *state[TT_CHANNELS], *model_is_up;
  hal_u32_t *heartbeat, *restarts, *fault;
  hal_s32_t* status;
} all_pins;

typedef struct settings {
  const char *model, *state, *name;
  double period_s, mm_per_unit;
} settings;

static const tt_model* const model = &tt_the_model;
static volatile sig_atomic_t ended;
static void end(int number) {
  (void)number;
  ended = 1;
}

static double seconds_of(const struct timespec* time) { return time->tv_sec + 1e-9 * time->tv_nsec; }

static double seconds(clockid_t clock) {
  struct timespec now;
  clock_gettime(clock, &now);
  return seconds_of(&now);
}

/* The axis that a channel belongs to in the array (axes) of channels; -1: none. */
static int axis_with(const int32_t* channel_of_axis, int channel) {
  for (int a = 0; a < model->axes; ++a) {
    if (channel_of_axis[a] == channel) return a;
  }
  return -1;
}

static int has_no_pin(int channel) {
  return axis_with(model->axis_feed, channel) >= 0 || axis_with(model->axis_low, channel) >= 0 ||
         axis_with(model->axis_high, channel) >= 0;
}

static int make_pins(all_pins* pins, int component, const char* name) {
  int bad = 0;
  for (int k = 0; k < model->channels; ++k) {
    const char* channel = model->channel_names[k];
    if (has_no_pin(k)) continue;
    if (model->channel_state[k]) {
      bad |= hal_pin_bit_newf(HAL_IN, &pins->state[k], component, "%s.%s", name, channel);
      if (!bad) *pins->state[k] = model->channel_default[k] > 0.5;
    } else {
      bad |= hal_pin_float_newf(HAL_IN, &pins->value[k], component, "%s.%s", name, channel);
      if (!bad) *pins->value[k] = NAN;
    }
  }
  for (int s = 0; s < model->sensors; ++s) {
    bad |= hal_pin_float_newf(HAL_IN, &pins->sensor_C[s], component, "%s.%s_C", name, model->sensor_names[s]);
    if (!bad) *pins->sensor_C[s] = NAN;
  }
  for (int i = 0; i < model->linear_axes; ++i) {
    const char* axis = model->axis_names[model->linear_axis[i]];
    bad |= hal_pin_float_newf(HAL_OUT, &pins->offset_um[i], component, "%s.offset-%s-um", name, axis);
    bad |= hal_pin_float_newf(HAL_OUT, &pins->std_um[i], component, "%s.std-%s-um", name, axis);
  }
  bad |= hal_pin_float_newf(HAL_OUT, &pins->answer_ms, component, "%s.answer-ms", name);
  bad |= hal_pin_float_newf(HAL_OUT, &pins->slowest_ms, component, "%s.slowest-ms", name);
  bad |= hal_pin_bit_newf(HAL_OUT, &pins->model_is_up, component, "%s.model-is-up", name);
  bad |= hal_pin_u32_newf(HAL_OUT, &pins->heartbeat, component, "%s.heartbeat", name);
  bad |= hal_pin_u32_newf(HAL_OUT, &pins->restarts, component, "%s.restarts", name);
  bad |= hal_pin_u32_newf(HAL_OUT, &pins->fault, component, "%s.fault", name);
  bad |= hal_pin_s32_newf(HAL_OUT, &pins->status, component, "%s.status", name);
  return bad;
}

static void read_pins(const all_pins* pins, const settings* how, model_row* row) {
  double* channels = row->channels;
  for (int k = 0; k < model->channels; ++k) {
    channels[k] = pins->state[k] ? (*pins->state[k] ? 1.0 : 0.0) : pins->value[k] ? *pins->value[k] : NAN;
  }
  for (int s = 0; s < model->sensors; ++s) row->sensors_C[s] = *pins->sensor_C[s];
  for (int a = 0; a < model->axes; ++a) {
    if (!model->axis_rotary[a]) channels[model->axis_position[a]] *= how->mm_per_unit;
  }
}

/* Feeds per minute from the positions of this row and the one before. */
static void add_feeds(const double* before, double dt, double* channels) {
  for (int a = 0; a < model->axes; ++a) {
    const int position = model->axis_position[a], feed = model->axis_feed[a];
    const double moved = fabs(channels[position] - before[position]);
    if (feed >= 0) channels[feed] = dt > 0.0 && isfinite(moved) ? 60.0 * moved / dt : 0.0;
  }
}

static void show(all_pins* pins, const model_answer* answer, double took_ms) {
  int valid = answer->status != TT_REFUSED_TIME && answer->status != TT_FAILED;
  for (int i = 0; i < model->linear_axes; ++i) valid = valid && isfinite(answer->offset_um[i]);
  *pins->status = answer->status;
  *pins->fault = answer->fault;
  *pins->answer_ms = took_ms;
  if (took_ms > *pins->slowest_ms) *pins->slowest_ms = took_ms;
  if (!valid) return; /* no heartbeat: the guard holds, then returns to zero */
  for (int i = 0; i < model->linear_axes; ++i) {
    *pins->offset_um[i] = answer->offset_um[i];
    *pins->std_um[i] = answer->std_um[i];
  }
  __sync_synchronize();
  ++*pins->heartbeat;
}

static void run(all_pins* pins, const settings* how) {
  static model_row row, before;
  const double wall = seconds(CLOCK_REALTIME), begun = seconds(CLOCK_MONOTONIC);
  const int wait_ms = how->period_s > 2e-3 ? (int)(0.8e3 * how->period_s) : 1;
  const uint64_t process = getpid();
  struct timespec next;
  model_link link;
  model_answer answer;
  model_link_begin(&link, how->model, how->state);
  row.session = (uint64_t)(wall * 1e6) ^ (process << 48);
  clock_gettime(CLOCK_MONOTONIC, &next);
  while (!ended) {
    const double now = seconds(CLOCK_MONOTONIC);
    model_link_tend(&link, now);
    before = row;
    row.time_s = wall + (now - begun); /* a clock that is set meanwhile does not matter */
    read_pins(pins, how, &row);
    add_feeds(before.channels, before.time_s > 0.0 ? row.time_s - before.time_s : 0.0, row.channels);
    model_link_send(&link, &row, now);
    if (model_link_answer(&link, wait_ms, seconds(CLOCK_MONOTONIC), &answer))
      show(pins, &answer, 1e3 * (seconds(CLOCK_MONOTONIC) - begun - (answer.time_s - wall)));
    *pins->model_is_up = link.link.process > 0;
    *pins->restarts = link.link.starts > 0 ? link.link.starts - 1 : 0;
    next.tv_nsec += (long)(1e9 * how->period_s);
    while (next.tv_nsec >= 1000000000L) ++next.tv_sec, next.tv_nsec -= 1000000000L;
    if (seconds(CLOCK_MONOTONIC) > seconds_of(&next))
      clock_gettime(CLOCK_MONOTONIC, &next); /* late: no row is made up for */
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, NULL);
  }
  model_link_end(&link);
}

static int read_settings(int argc, char** argv, settings* how) {
  for (int i = 1; i + 1 < argc; i += 2) {
    const char *option = argv[i], *value = argv[i + 1];
    if (strcmp(option, "--model") == 0)
      how->model = value;
    else if (strcmp(option, "--state") == 0)
      how->state = value;
    else if (strcmp(option, "--name") == 0)
      how->name = value;
    else if (strcmp(option, "--period-ms") == 0)
      how->period_s = 1e-3 * atof(value);
    else if (strcmp(option, "--mm-per-unit") == 0)
      how->mm_per_unit = atof(value);
    else
      return 0;
  }
  return argc % 2 == 1 && how->model && how->state && how->period_s >= 1e-3 && how->period_s <= 1.0 &&
         how->mm_per_unit > 0.0;
}

int main(int argc, char** argv) {
  settings how = {NULL, NULL, "thermotwin", 0.01, 1.0};
  all_pins* pins;
  int component;
  if (!read_settings(argc, argv, &how)) {
    fprintf(stderr,
            "usage: thermotwin_pins --model PROGRAM --state FILE [--name NAME] [--period-ms 1 to 1000] "
            "[--mm-per-unit NUMBER]\n");
    return 2;
  }
  component = hal_init(how.name);
  if (component < 0) return 3;
  pins = hal_malloc(sizeof *pins);
  if (pins) memset(pins, 0, sizeof *pins);
  if (!pins || make_pins(pins, component, how.name)) {
    fprintf(stderr, "thermotwin_pins: pins of %s cannot be made\n", how.name);
    hal_exit(component);
    return 3;
  }
  signal(SIGINT, end);
  signal(SIGTERM, end);
  hal_ready(component);
  run(pins, &how);
  hal_exit(component);
  return 0;
}
