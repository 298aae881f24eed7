/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/sensor_trust.h"

#include <math.h>

#include "compensation/control/scalars.h"

/* A constant offset is named, and no longer named, from these multiples of its stated deviation and of its own on. */
static const double named_stated = 6.0, named_own = 5.0, unnamed = 3.0, least_stated_K = 0.03;

void tt_trust_lay(tt_trust* trust, const tt_reading_model* model, const double* std, tt_arena* arena) {
  const ptrdiff_t sensors = model->sensors;
  tt_reading_check_lay(&trust->check, model, arena);
  tt_monitor_lay(&trust->monitor, model->sensors, std, arena);
  tt_drift_lay(&trust->drift, model->sensors, std, arena);
  trust->named = tt_ints(arena, sensors);
  trust->named_check = tt_ints(arena, sensors);
  trust->biased = tt_ints(arena, sensors);
  trust->offset = tt_doubles(arena, sensors);
  trust->offset_std = tt_doubles(arena, sensors);
}

void tt_trust_start(tt_trust* trust) {
  tt_monitor_start(&trust->monitor);
  tt_drift_start(&trust->drift);
  for (int s = 0; s < trust->monitor.sensors; ++s) {
    trust->named[s] = trust->named_check[s] = TT_SENSOR_FINE;
    trust->biased[s] = 0;
  }
}

int tt_trusted(const tt_trust* trust, int sensor) {
  return trust->monitor.watched[sensor].trusted && !trust->drift.drifts[sensor];
}

/* Whether a reading is what degF makes of the expected one. */
static int reads_fahrenheit(const tt_trust* trust, int s) {
  const tt_watched* w = &trust->monitor.watched[s];
  const double reference_C = trust->check.model->reference_C;
  const double value_C = w->last_reading + reference_C, expected_C = w->last_expected + w->usual + reference_C;
  return trust->check.fahrenheit_like[s] &&
         fabs((value_C - 32.0) / 1.8 - expected_C) < 0.25 * fabs(value_C - expected_C);
}

/* Why a sensor is left out. */
static int fault_of(const tt_trust* trust, int s) {
  const int fault = trust->monitor.watched[s].fault;
  if (trust->check.sensor_fault[s] != TT_SENSOR_FINE) return trust->check.sensor_fault[s];
  if (fault == TT_SENSOR_OFFSET && reads_fahrenheit(trust, s)) return TT_SENSOR_FAHRENHEIT;
  if (fault != TT_SENSOR_FINE) return fault;
  if (trust->drift.drifts[s]) return TT_SENSOR_DRIFT;
  return trust->biased[s] ? TT_SENSOR_OFFSET : TT_SENSOR_FINE;
}

static void name_sensors(tt_trust* trust) {
  for (int s = 0; s < trust->monitor.sensors; ++s) trust->named[s] = fault_of(trust, s);
}

void tt_trust_watch(tt_trust* trust, double time, const double* reading_K, const double* expected_K, int inputs_leapt,
                    const double* unsure_K_s) {
  int changed = tt_monitor_judge(&trust->monitor, time, reading_K, expected_K, inputs_leapt, unsure_K_s);
  for (int s = 0; s < trust->monitor.sensors; ++s) {
    changed = changed || trust->check.sensor_fault[s] != trust->named_check[s];
    trust->named_check[s] = trust->check.sensor_fault[s];
  }
  if (changed) name_sensors(trust);
}

/* Whether a sensor in doubt since the start has an offset by now. */
static int is_biased(const tt_trust* trust, const tt_errors* errors, int s) {
  if (!tt_errors_doubts(errors, s)) return 0;
  const tt_sensor_offset own = tt_errors_own_offset(errors, s);
  const double stated = tt_max(trust->monitor.std[s], least_stated_K), size = fabs(own.value);
  return trust->biased[s] ? size > unnamed * tt_max(stated, own.std)
                          : size > tt_max(named_stated * stated, named_own * own.std);
}

static void watch_offsets(tt_trust* trust, const tt_errors* errors) {
  int changed = 0;
  for (int s = 0; s < trust->monitor.sensors; ++s) {
    const int biased = is_biased(trust, errors, s);
    changed = changed || biased != trust->biased[s];
    trust->biased[s] = biased;
  }
  if (changed) name_sensors(trust);
}

void tt_trust_watch_drift(tt_trust* trust, double time, tt_errors* errors) {
  watch_offsets(trust, errors);
  for (int s = 0; s < trust->monitor.sensors; ++s) {
    trust->offset[s] = trust->offset_std[s] = tt_nan();
    if (!tt_trusted(trust, s)) continue;
    const tt_sensor_offset seen = tt_errors_offset(errors, s);
    trust->offset[s] = seen.value;
    trust->offset_std[s] = seen.std;
  }
  const int s = tt_drift_judge(&trust->drift, time, trust->offset, trust->offset_std);
  if (s < 0) return;
  tt_errors_release(errors, s);
  name_sensors(trust);
}
