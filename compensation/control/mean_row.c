/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/mean_row.h"

#include "compensation/control/linear.h"
#include "compensation/control/scalars.h"

#ifdef __clang__
#pragma STDC FP_CONTRACT OFF
#endif

tt_mean_row tt_mean_row_in(tt_arena* arena, const tt_model* m) {
  tt_mean_row mean;
  const ptrdiff_t channels = m->channels, axes = m->axes;
  mean.duration = tt_doubles(arena, 1);
  mean.first = tt_doubles(arena, channels);
  mean.sum = tt_doubles(arena, channels);
  mean.weight = tt_doubles(arena, channels);
  mean.least = tt_doubles(arena, axes);
  mean.most = tt_doubles(arena, axes);
  mean.changed = tt_ints(arena, channels);
  return mean;
}

void tt_mean_add(const tt_model* m, const double* row, double duration, tt_mean_row* mean) {
  const int begins = *mean->duration == 0.0;
  if (begins) {
    tt_copy(m->channels, row, mean->first);
    tt_zero(m->channels, mean->sum);
    tt_zero(m->channels, mean->weight);
    for (int k = 0; k < m->channels; ++k) mean->changed[k] = 0;
  }
  *mean->duration += duration;
  for (int k = 0; k < m->channels; ++k) {
    const double value = row[k];
    if (tt_is_nan(value)) {
      mean->changed[k] = mean->changed[k] || !tt_is_nan(mean->first[k]);
      continue;
    }
    mean->changed[k] = mean->changed[k] || !(value == mean->first[k]);
    mean->sum[k] += duration * value;
    mean->weight[k] += duration;
  }
  for (int a = 0; a < m->axes; ++a) {
    const double position = row[m->axis_position[a]];
    double low = row[m->axis_low[a]], high = row[m->axis_high[a]];
    if (!tt_is_finite(low) || !tt_is_finite(high)) low = high = position;
    mean->least[a] = begins ? low : tt_min(mean->least[a], low);
    mean->most[a] = begins ? high : tt_max(mean->most[a], high);
  }
}

void tt_mean_take(const tt_model* m, tt_mean_row* mean, double* row) {
  tt_copy(m->channels, mean->first, row);
  for (int k = 0; k < m->channels; ++k) {
    if (mean->changed[k] && mean->weight[k] > 0.0) row[k] = mean->sum[k] / mean->weight[k];
  }
  for (int a = 0; a < m->axes; ++a) {
    if (!(mean->most[a] > mean->least[a])) continue;
    row[m->axis_low[a]] = mean->least[a];
    row[m->axis_high[a]] = mean->most[a];
  }
  *mean->duration = 0.0;
}
