/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/guard.h"

#include <math.h>

#include "compensation/control/linear.h"
#include "compensation/control/scalars.h"

#ifdef __clang__
#pragma STDC FP_CONTRACT OFF
#endif

/* The change that the motion of the axes accounts for, um. */
static double motion_um(const tt_model* m, const double* from, const double* to, double duration) {
  double sum = 0.0;
  for (int a = 0; a < m->axes; ++a)
    sum += m->axis_slope_um[a] * tt_min(fabs(to[a] - from[a]), m->axis_rapid[a] * duration);
  return sum;
}

void tt_guard(tt_twin* twin, double time, double duration, int first, const double* pose) {
  const tt_model* m = twin->model;
  const double reach = m->rate_um_s * tt_max(0.0, duration) + (first ? 0.0 : motion_um(m, twin->pose, pose, duration));
  int valid = 1, limited = 0;
  for (int i = 0; i < m->linear_axes; ++i) valid = valid && tt_is_finite(twin->wanted_um[i]);
  if (valid) {
    twin->now->valid_at = time;
    tt_copy(m->linear_axes, twin->wanted_um, twin->last_um);
  } else if (first || time - twin->now->valid_at > m->hold_s) {
    tt_zero(m->linear_axes, twin->last_um);
  }
  for (int i = 0; i < m->linear_axes; ++i) {
    const double applied = twin->offset_um[i];
    const double allowed = tt_clamp(twin->last_um[i], -m->largest_um, m->largest_um);
    const double next = tt_clamp(allowed, applied - reach, applied + reach);
    limited = limited || next != twin->last_um[i];
    twin->offset_um[i] = next;
  }
  tt_copy(m->axes, pose, twin->pose);
  if (valid)
    twin->now->guard = limited ? TT_GUARD_LIMITED : TT_FOLLOWING;
  else
    twin->now->guard = !first && time - twin->now->valid_at <= m->hold_s ? TT_HOLDING_STILL : TT_RETURNING;
}
