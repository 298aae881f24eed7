/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The first row: the uniform temperature with the most evidence in the readings, sensors that are off, earlier work. */
#include "compensation/control/observer_start.h"

#include <math.h>

#include "compensation/control/linear.h"
#include "compensation/control/scalars.h"
#include "compensation/control/special.h"

/* Standard deviations of the start, K: where nothing is measured, and the least that remains where sensors agree with
 * each other. */
static const double start_uniform_K = 0.5, least_start_K = 0.03;
static const double least_chance = 1e-4; /* of a first reading that is believed though it is far from all others */

enum { enough_sensors = 3 };             /* to tell which of them is off */

enum {
  start_none,
  start_uniform,
  start_explain,
  start_uniform_again,
  start_weigh,
  start_patterns,
  start_done,
  start_failed
};

typedef struct uniform {
  double middle, std;
} uniform;

/* Of the sensors that gave one and are trusted, without their own offsets, into the observer's scratch. */
static tt_first_readings first_readings(tt_observer* o, int without) {
  tt_first_readings readings = {0, o->first_sensor, o->first_value, 0.0, start_uniform_K};
  for (int s = 0; s < o->model->sensors->measured; ++s) {
    if (s == without || !tt_is_finite(o->reading_K[s]) || !tt_trusted(&o->trust, s)) continue;
    o->first_sensor[readings.count] = s;
    o->first_value[readings.count++] = o->reading_K[s] - o->model->sensor_offset[s];
  }
  return readings;
}

/* The temperature of the air; of a machine without air that of the ambient next to a reading, or the reading where it
 * lies between two. */
static double surroundings_near(const tt_observer* o, double value) {
  const int air = o->model->air_channel;
  if (air >= 0 && tt_is_finite(o->row[air])) return o->row[air] - o->model->readings->reference_C;
  double coldest = HUGE_VAL, warmest = -HUGE_VAL;
  for (int i = 0; i < o->model->ambients; ++i) {
    const int channel = o->model->ambient_channel[i];
    const double around = channel < 0 ? tt_nan() : o->row[channel] - o->model->readings->reference_C;
    if (!tt_is_finite(around)) continue;
    coldest = tt_min(coldest, around);
    warmest = tt_max(warmest, around);
  }
  return coldest > warmest ? value : tt_clamp(value, coldest, warmest);
}

/* The offset that a first reading may have because too few others speak against it: one sensor cannot tell a warm
 * machine from its own error, of two the one that is further off may be wrong. */
static double doubt_of(const tt_observer* o, const tt_first_readings* readings, int i) {
  if (readings->count >= enough_sensors) return 0.0;
  const double value = readings->value_K[i], far = fabs(value - surroundings_near(o, value));
  return readings->count == 1 ? far : tt_min(far, fabs(readings->value_K[0] - readings->value_K[1]));
}

/* One sensor alone says nothing of the temperature of the others: far from the surroundings it counts as a part that
 * work has warmed, or as wrong. */
static uniform start_of_one(const tt_observer* o, double value) {
  const double around = surroundings_near(o, value), far = fabs(value - around);
  const uniform near = {value, tt_max(least_start_K, far)}, away = {around, start_uniform_K + 0.5 * far};
  return far > start_uniform_K ? away : near;
}

/* Of a rested machine sensors agree in the middle; one at work rests on the coldest of them, or on the air. */
static int uniform_starts(tt_observer* o, int without, uniform* starts) {
  const tt_first_readings readings = first_readings(o, without);
  const double middle = tt_median(readings.count, readings.value_K),
               lowest = tt_nth_smallest(readings.count, readings.value_K, 0);
  for (int i = 0; i < readings.count; ++i) o->scratch[i] = fabs(readings.value_K[i] - middle);
  starts[0].middle = middle;
  starts[0].std = tt_max(least_start_K, 1.5 * tt_median(readings.count, o->scratch));
  starts[1].middle = lowest;
  starts[1].std = tt_max(least_start_K, 0.25 * (middle - lowest));
  if (readings.count == 1) starts[0] = starts[1] = start_of_one(o, middle);
  const int air = o->model->air_channel;
  if (air < 0 || !tt_is_finite(o->row[air])) return 2;
  const double surroundings = o->row[air] - o->model->readings->reference_C;
  starts[2].middle = surroundings;
  starts[2].std = tt_max(least_start_K, start_uniform_K + 0.25 * fabs(lowest - surroundings));
  return 3;
}

static void begin_offers(tt_observer* o, tt_first_readings readings, uniform start, int predicts, int place) {
  readings.zero_K = start.middle;
  readings.uniform_K = start.std;
  tt_past_begin_offers(&o->past, &readings, predicts, place);
}

static void begin_candidate(tt_observer* o) {
  uniform starts[tt_most_starts];
  uniform_starts(o, -1, starts);
  begin_offers(o, first_readings(o, -1), starts[o->flags[at_candidate]], 0, 0);
}

static void begin_uniform(tt_observer* o, int stage) {
  o->flags[at_start] = stage;
  o->flags[at_candidate] = 0;
  o->numbers[uniform_K] = 0.0;
  o->numbers[uniform_std] = start_uniform_K;
  o->numbers[most_evidence] = -HUGE_VAL;
  begin_candidate(o);
}

void tt_observer_begin_start(tt_observer* o, const tt_moment* now, const double* row) {
  tt_copy(o->model->readings->channels, row, o->row);
  tt_copy(o->model->sensors->sensors, now->seen, o->seen_start);
  o->numbers[corrected_at] = now->time;
  o->numbers[uniform_K] = 0.0;
  o->numbers[uniform_std] = start_uniform_K;
  o->flags[by_sensors] = o->model->start_from_sensors && first_readings(o, -1).count > 0;
  if (o->flags[by_sensors]) {
    begin_uniform(o, start_uniform);
    return;
  }
  tt_observer_watch(o, now->time, o->seen_start, 0);
  tt_past_unmeasured(&o->past);
  o->flags[at_start] = start_patterns;
  tt_past_begin_patterns(&o->past);
}

/* Judges the first readings, then finds the uniform temperature without those that are off. */
static void judge_first(tt_observer* o) {
  const tt_sensor_model* m = o->model->sensors;
  for (int s = 0; s < m->measured; ++s) o->trust.monitor.watched[s].explained = o->explained[s];
  for (int s = 0; s < m->sensors; ++s) o->seen_start[s] = o->seen_one[s] * o->numbers[uniform_K];
  tt_observer_watch(o, o->numbers[corrected_at], o->seen_start, 0);
  if (first_readings(o, -1).count > 0) {
    begin_uniform(o, start_uniform_again);
    return;
  }
  tt_past_unmeasured(&o->past);
  o->flags[at_start] = start_patterns;
  tt_past_begin_patterns(&o->past);
}

static void begin_chance(tt_observer* o) {
  uniform starts[tt_most_starts];
  const int sensor = o->flags[at_sensor];
  uniform_starts(o, sensor, starts);
  tt_first_readings others = first_readings(o, sensor);
  o->first_sensor[others.count] = sensor;
  o->first_value[others.count++] = o->reading_K[sensor] - o->model->sensor_offset[sensor];
  begin_offers(o, others, starts[o->flags[at_candidate]], 1, o->flags[at_candidate]);
}

/* Whether a part that work has not reached, as warm as what surrounds it, may read this. */
static int is_usual(const tt_observer* o, int sensor) {
  const tt_sensor_model* m = o->model->sensors;
  double coldest = 0.0;
  for (int s = 0; s < m->measured; ++s) coldest += o->seen_one[s] * o->numbers[uniform_K];
  coldest /= m->measured;
  double warmest = coldest;
  for (int i = 0; i < o->model->ambients; ++i) {
    const int channel = o->model->ambient_channel[i];
    const double value = channel < 0 ? tt_nan() : o->row[channel] - o->model->readings->reference_C;
    if (!tt_is_finite(value)) continue;
    coldest = tt_min(coldest, value);
    warmest = tt_max(warmest, value);
  }
  const double value = o->reading_K[sensor] - o->model->sensor_offset[sensor];
  return value > coldest - start_uniform_K && value < warmest + start_uniform_K;
}

/* From this sensor on, the first one that only the others can explain. */
static void explain_from(tt_observer* o, int sensor) {
  const int measured = o->model->sensors->measured;
  for (; sensor < measured; ++sensor) {
    if (!tt_is_finite(o->reading_K[sensor]) || !tt_trusted(&o->trust, sensor)) continue;
    o->explained[sensor] = is_usual(o, sensor);
    if (!o->explained[sensor]) break;
  }
  o->flags[at_sensor] = sensor;
  o->flags[at_candidate] = 0;
  if (sensor < measured)
    begin_chance(o);
  else
    judge_first(o);
}

static void begin_explanation(tt_observer* o) {
  for (int s = 0; s < o->model->sensors->measured; ++s) o->explained[s] = 0;
  o->flags[at_start] = start_explain;
  explain_from(o, first_readings(o, -1).count < enough_sensors ? o->model->sensors->measured : 0);
}

static void begin_weighing(tt_observer* o) {
  const uniform found = {o->numbers[uniform_K], o->numbers[uniform_std]};
  for (int s = 0; s < o->model->sensors->sensors; ++s) o->seen_start[s] = o->seen_one[s] * o->numbers[uniform_K];
  o->flags[at_start] = start_weigh;
  begin_offers(o, first_readings(o, -1), found, 0, 0);
}

static void end_candidate(tt_observer* o) {
  uniform starts[tt_most_starts];
  const int count = uniform_starts(o, -1, starts), candidate = o->flags[at_candidate]++;
  const double evidence = tt_past_weigh(&o->past);
  if (evidence > o->numbers[most_evidence]) {
    o->numbers[most_evidence] = evidence;
    o->numbers[uniform_K] = starts[candidate].middle;
    o->numbers[uniform_std] = starts[candidate].std;
  }
  if (o->flags[at_candidate] < count)
    begin_candidate(o);
  else if (o->flags[at_start] == start_uniform)
    begin_explanation(o);
  else
    begin_weighing(o);
}

static void end_chance(tt_observer* o) {
  uniform starts[tt_most_starts];
  const int sensor = o->flags[at_sensor], count = uniform_starts(o, sensor, starts);
  if (++o->flags[at_candidate] < count) {
    begin_chance(o);
    return;
  }
  o->explained[sensor] = tt_past_chance(&o->past, count) > least_chance;
  explain_from(o, sensor + 1);
}

int tt_observer_start_slice(tt_observer* o) {
  int32_t* stage = &o->flags[at_start];
  if (*stage == start_done || *stage == start_failed) return *stage == start_done ? 1 : 2;
  const int state = tt_past_slice(&o->past);
  if (state == 0) return 0;
  switch (*stage) {
    case start_uniform:
    case start_uniform_again: end_candidate(o); break;
    case start_explain: end_chance(o); break;
    case start_weigh:
      tt_past_weigh(&o->past);
      *stage = start_patterns;
      tt_past_begin_patterns(&o->past);
      break;
    default:
      o->flags[shapes_of_start] = state == 1 ? tt_past_shapes(&o->past) : 0;
      *stage = state == 1 ? start_done : start_failed;
      break;
  }
  return *stage == start_done ? 1 : *stage == start_failed ? 2 : 0;
}

int tt_observer_uniform(const tt_observer* o, double* temperature_K) {
  *temperature_K = o->numbers[uniform_K];
  return o->flags[by_sensors];
}

/* An input that stands at its default is one that nobody gives, see tt_errors_start. Too few sensors to check each
 * other are checked by the air, where there is a column of it. */
static void set_gap(tt_observer* o) {
  const int air_counts = first_readings(o, -1).count < enough_sensors && !tt_errors_air_untold(&o->errors);
  const tt_reading_model* readings = o->model->readings;
  for (int i = 0; i < o->model->ambients; ++i) {
    const int channel = o->model->ambient_channel[i];
    o->gap[i] = 0.0;
    if (!o->flags[by_sensors] || channel < 0) continue;
    if (channel == o->model->air_channel && air_counts) continue;
    const double standard = readings->default_C[channel];
    if (o->row[channel] == standard) o->gap[i] = o->numbers[uniform_K] + readings->reference_C - standard;
  }
}

void tt_observer_begin_taking(tt_observer* o, const tt_moment* now) {
  set_gap(o);
  tt_errors_start(&o->errors, o->numbers[uniform_std], o->flags[shapes_of_start], o->past.patterns, o->gap);
  o->numbers[corrected_at] = now->time;
  o->flags[at_sensor] = 0;
  tt_first_readings readings = first_readings(o, -1);
  if (!o->flags[by_sensors]) readings.count = 0;
  for (int i = 0; i < readings.count; ++i) tt_errors_doubt(&o->errors, readings.sensor[i], doubt_of(o, &readings, i));
}

int tt_observer_take_slice(tt_observer* o) {
  const tt_first_readings readings = first_readings(o, -1);
  const int i = o->flags[at_sensor], count = o->flags[by_sensors] ? readings.count : 0;
  if (i == count) {
    if (count > 0) tt_errors_settle(&o->errors);
    return 1;
  }
  const double value = readings.value_K[i] - o->numbers[uniform_K];
  const tt_innovation one = {readings.sensor[i], value, 1.0, value};
  tt_errors_observe(&o->errors, &one, 0.0);
  o->flags[at_sensor] = i + 1;
  return 0;
}

void tt_observer_begin_foresight(tt_observer* o, const double* operator_matrix) {
  tt_sensitivities_begin_foresight(&o->errors.sensitivities, tt_min(o->model->step_s, o->model->correction_s),
                                   operator_matrix);
}

void tt_observer_finish_foresight(tt_observer* o, const tt_moment* now) {
  tt_sensitivities_finish(&o->errors.sensitivities);
  tt_observer_settle(o, now, now->step_end);
}
