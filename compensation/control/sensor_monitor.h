/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef THERMOTWIN_SENSOR_MONITOR_H
#define THERMOTWIN_SENSOR_MONITOR_H
/* Detects and names temperature sensors that have failed: absent, stuck, offset, noise (the C++ class, with the rules:
 * online/sensor_monitor.h). */

#include "compensation/control/reading_check.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { tt_recent = 65, tt_turns = 63 }; /* samples kept of a sensor */

typedef struct tt_recent_sample {
  double time, difference, reading;
} tt_recent_sample;

/* What is known of one sensor; values only. */
typedef struct tt_watched {
  double seen_at, last_reading;
  double usual; /* slow part of reading - expected; frozen while the sensor is not trusted */
  double last_difference, last_expected, last_unknown;
  double expected_memory; /* slow part of the expected reading */
  double same_value, same_expected, same_unsure, same_learnt, same_since;
  double readings, repeats; /* in runs that have ended: how often readings repeat by chance */
  double smallest_step;     /* between two readings: the resolution of a coarse sensor */
  double leapt_at, leap, agreed_since, inputs_leapt_at;
  double turns[tt_turns]; /* K, magnitudes of the last second differences while readings moved */
  tt_recent_sample recent[tt_recent];
  int32_t far[tt_recent]; /* of the recent samples */
  int32_t recent_first, recent_count, turn_count, turn_next;
  int32_t fault, trusted, known, leapt, from_start, same_count;
  int32_t explained; /* 1: the other sensors explain its first reading, however large */
  int32_t held;      /* the present run of equal readings was found stuck */
} tt_watched;

typedef struct tt_monitor {
  int32_t sensors;
  const double* std;   /* (sensors) stated standard deviation of a reading, K */
  double* scratch;     /* (sensors) */
  tt_watched* watched; /* (sensors) */
} tt_monitor;

void tt_monitor_lay(tt_monitor* monitor, int sensors, const double* std, tt_arena* arena);
void tt_monitor_start(tt_monitor* monitor); /* all are trusted */

/* Readings of one time, NaN where missing, and the observer's expectation. inputs_leapt: an input jumped since the last
 * call. unsure_K_s: standard deviation of the rate of expected_K. Returns 1 if the fault of any sensor changed. */
int tt_monitor_judge(tt_monitor* monitor, double time, const double* reading_K, const double* expected_K,
                     int inputs_leapt, const double* unsure_K_s);
/* Shifts the expected readings by a correction of the observer, so that no sensor is blamed for it. */
void tt_monitor_correct(tt_monitor* monitor, const double* change_K);

#ifdef __cplusplus
}
#endif
#endif
