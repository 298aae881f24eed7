/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/reading_check.h"

#include <math.h>

#include "compensation/control/scalars.h"
#include "compensation/control/special.h"

static const double colder_K = 40.0, warmer_K = 100.0; /* than the surroundings: what a machine's sensor may read */
static const double too_warm_K = 30.0, near_K = 15.0;  /* of the surroundings: degF taken for degC; then in degC */
static const double zero_C_in_K = 273.15;

enum { started, fahrenheit, flag_count };

const char* tt_sensor_fault_text(int fault) {
  static const char* const texts[] = {"none",  "implausible", "kelvin", "fahrenheit", "absent",
                                      "stuck", "offset",      "noise",  "drift"};
  return fault >= 0 && fault <= TT_SENSOR_DRIFT ? texts[fault] : "";
}

void tt_reading_check_lay(tt_reading_check* check, const tt_reading_model* model, tt_arena* arena) {
  check->model = model;
  check->sensor_fault = tt_ints(arena, model->sensors);
  check->fahrenheit_like = tt_ints(arena, model->sensors);
  check->flags = tt_ints(arena, flag_count);
  check->around = tt_doubles(arena, model->ambients);
}

static int outside(const tt_reading_model* m, double value_C) { return !(value_C >= m->low_C && value_C <= m->high_C); }

static int fault_outside(double value_C, double surroundings_C) {
  const double above_K = value_C - zero_C_in_K - surroundings_C;
  return above_K >= -colder_K && above_K <= warmer_K ? TT_SENSOR_KELVIN : TT_SENSOR_IMPLAUSIBLE;
}

static int like_fahrenheit(double value_C, double surroundings_C) {
  return value_C - surroundings_C > too_warm_K && fabs((value_C - 32.0) / 1.8 - surroundings_C) <= near_K;
}

/* Half of the ambients are below the middle one: a warm fluid among them does not count. */
static double surroundings(tt_reading_check* check, const double* row) {
  const tt_reading_model* m = check->model;
  if (m->ambients == 0) return m->reference_C;
  for (int i = 0; i < m->ambients; ++i) check->around[i] = row[m->ambient[i]];
  return tt_nth_smallest(m->ambients, check->around, (m->ambients - 1) / 2);
}

void tt_take_out_sensors(tt_reading_check* check, double* readings_C, const double* row) {
  const tt_reading_model* m = check->model;
  const double around_C = surroundings(check, row);
  int some = 0, all_fahrenheit = 1, one_less = 0;
  for (int s = 0; s < m->sensors; ++s) {
    check->sensor_fault[s] = TT_SENSOR_FINE;
    check->fahrenheit_like[s] = 0;
    if (tt_is_nan(readings_C[s])) continue;
    if (outside(m, readings_C[s])) {
      check->sensor_fault[s] = fault_outside(readings_C[s], around_C);
      readings_C[s] = tt_nan();
      continue;
    }
    some = 1;
    check->fahrenheit_like[s] = like_fahrenheit(readings_C[s], around_C);
    all_fahrenheit = all_fahrenheit && check->fahrenheit_like[s];
    one_less = one_less || readings_C[s] - around_C <= too_warm_K;
  }
  if (some) {
    check->flags[fahrenheit] = check->flags[started] ? check->flags[fahrenheit] && !one_less : all_fahrenheit;
    check->flags[started] = 1;
  }
  if (!check->flags[fahrenheit]) return;
  for (int s = 0; s < m->sensors; ++s) {
    if (tt_is_nan(readings_C[s])) continue;
    check->sensor_fault[s] = TT_SENSOR_FAHRENHEIT;
    readings_C[s] = tt_nan();
  }
}

int tt_any_sensor_out(const tt_reading_check* check) {
  for (int s = 0; s < check->model->sensors; ++s) {
    if (check->sensor_fault[s] != TT_SENSOR_FINE) return 1;
  }
  return 0;
}
