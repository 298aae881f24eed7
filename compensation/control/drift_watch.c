/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/drift_watch.h"

#include <math.h>

#include "compensation/control/scalars.h"

static const double watched_s = 16.0 * 3600.0, spacing_s = 600.0;
static const double drifted = 6.0, apart = 5.0, least_spread_K = 0.03;
static const double least_share = 0.16, most_share = 0.34; /* of a quarter; a settling lag puts more into the first */
enum { quarters = 4 };

void tt_drift_lay(tt_drift_watch* watch, int sensors, const double* std, tt_arena* arena) {
  watch->sensors = sensors;
  watch->std = std;
  watch->time = tt_doubles(arena, sensors * tt_drift_samples);
  watch->value = tt_doubles(arena, sensors * tt_drift_samples);
  watch->first = tt_ints(arena, sensors);
  watch->count = tt_ints(arena, sensors);
  watch->drifts = tt_ints(arena, sensors);
}

void tt_drift_start(tt_drift_watch* watch) {
  for (int s = 0; s < watch->sensors; ++s) watch->first[s] = watch->count[s] = watch->drifts[s] = 0;
}

static int place(const tt_drift_watch* watch, int sensor, int sample) {
  return sensor * tt_drift_samples + (watch->first[sensor] + sample) % tt_drift_samples;
}

static void drop_first(tt_drift_watch* watch, int sensor) {
  watch->first[sensor] = (watch->first[sensor] + 1) % tt_drift_samples;
  --watch->count[sensor];
}

static int grows_steadily(tt_drift_watch* watch, int sensor, double time, double value, double std) {
  int32_t* count = &watch->count[sensor];
  if (watch->drifts[sensor] || !tt_is_finite(value) || !tt_is_finite(std)) return 0;
  if (*count > 0 && time - watch->time[place(watch, sensor, *count - 1)] < spacing_s) return 0;
  if (*count == tt_drift_samples) drop_first(watch, sensor);
  watch->time[place(watch, sensor, *count)] = time;
  watch->value[place(watch, sensor, *count)] = value;
  ++*count;
  while (*count > 1 && time - watch->time[place(watch, sensor, 1)] >= watched_s) drop_first(watch, sensor);
  const double first_time = watch->time[place(watch, sensor, 0)], first_value = watch->value[place(watch, sensor, 0)];
  if (time - first_time < watched_s) return 0;
  const double change = value - first_value;
  if (fabs(change) < drifted * tt_max(watch->std[sensor], least_spread_K) || fabs(value) < apart * std) return 0;
  double last = first_value;
  for (int quarter = 1; quarter <= quarters; ++quarter) {
    const double until = first_time + (time - first_time) * quarter / quarters;
    int at = 0;
    while (at < *count && !(watch->time[place(watch, sensor, at)] >= until - 1e-6)) ++at;
    const double reached = quarter == quarters || at == *count ? value : watch->value[place(watch, sensor, at)];
    const double share = (reached - last) / change;
    if (share < least_share || share > most_share) return 0;
    last = reached;
  }
  return 1;
}

int tt_drift_judge(tt_drift_watch* watch, double time, const double* value, const double* std) {
  int furthest = -1, found = -1;
  for (int i = 0; i < watch->sensors; ++i) {
    if (!tt_is_finite(value[i]) || !tt_is_finite(std[i]) || watch->drifts[i]) continue;
    if (furthest < 0 || fabs(value[i]) * std[furthest] > fabs(value[furthest]) * std[i]) furthest = i;
  }
  for (int i = 0; i < watch->sensors; ++i) {
    if (grows_steadily(watch, i, time, value[i], std[i]) && i == furthest) found = i;
  }
  if (found >= 0) watch->drifts[found] = 1;
  return found;
}
