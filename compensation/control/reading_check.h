/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_READING_CHECK_H
#define THERMOTWIN_READING_CHECK_H
/* Removes readings of sensors that cannot be values of this machine in degC (the C++ class, with the rules:
 * online/reading_check.h; for channels: row_check.h). Missing is NaN. */

#include <stdint.h>

#include "compensation/control/arena.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Why a reading is left out: by its value alone or, from TT_SENSOR_ABSENT on, by its course over time. */
typedef enum tt_sensor_fault {
  TT_SENSOR_FINE,
  TT_SENSOR_IMPLAUSIBLE,
  TT_SENSOR_KELVIN,
  TT_SENSOR_FAHRENHEIT,
  TT_SENSOR_ABSENT,
  TT_SENSOR_STUCK,
  TT_SENSOR_OFFSET,
  TT_SENSOR_NOISE,
  TT_SENSOR_DRIFT
} tt_sensor_fault;
const char* tt_sensor_fault_text(int fault);

typedef struct tt_reading_model {
  double low_C, high_C, reference_C; /* plausible_C, reference_C of machine.toml */
  int32_t channels, sensors, ambients;
  const int32_t* ambient;  /* (ambients) channels of surroundings that have a temperature of their own */
  const double* default_C; /* (channels) NaN: none */
} tt_reading_model;

typedef struct tt_reading_check {
  const tt_reading_model* model;
  int32_t *sensor_fault, *fahrenheit_like; /* (sensors) of the last reading */
  int32_t* flags;
  double* around; /* (ambients) scratch */
} tt_reading_check;

void tt_reading_check_lay(tt_reading_check* check, const tt_reading_model* model, tt_arena* arena);
/* Sets faulty readings to NaN. row: (channels) in effect; it supplies the temperature of the surroundings. */
void tt_take_out_sensors(tt_reading_check* check, double* readings_C, const double* row);
int tt_any_sensor_out(const tt_reading_check* check);

#ifdef __cplusplus
}
#endif
#endif
