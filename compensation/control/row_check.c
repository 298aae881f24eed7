/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "compensation/control/row_check.h"

#include <math.h>

#include "compensation/control/scalars.h"
#include "compensation/control/twin.h"

#ifdef __clang__
#pragma STDC FP_CONTRACT OFF
#endif

static const double largest = 1e10; /* no quantity of a machine is larger in its unit */
static const double zero_C_in_K = 273.15, colder_K = 40.0, warmer_K = 100.0, too_warm_K = 30.0, near_K = 15.0;

static int temperature_fault(const tt_model* m, int k, double value) {
  const double usual = tt_is_nan(m->channel_default[k]) ? m->reference_C : m->channel_default[k];
  if (!(value >= m->plausible_low_C && value <= m->plausible_high_C)) {
    const double above = value - zero_C_in_K - usual;
    return above >= -colder_K && above <= warmer_K ? TT_FAULT_KELVIN : TT_FAULT_IMPLAUSIBLE;
  }
  if (m->channel_ambient[k] && value - usual > too_warm_K && fabs((value - 32.0) / 1.8 - usual) <= near_K)
    return TT_FAULT_FAHRENHEIT;
  return TT_FAULT_NONE;
}

static int fault_of(const tt_model* m, int k, double value) {
  if (tt_is_nan(value)) return TT_FAULT_NONE;
  if (!tt_is_finite(value) || fabs(value) > largest) return TT_FAULT_UNREADABLE;
  if (m->channel_state[k] && (value < 0.0 || value > 1.0)) return TT_FAULT_UNREADABLE;
  if (value < m->channel_low[k] || value > m->channel_high[k]) return TT_FAULT_BEYOND;
  return m->channel_temperature[k] ? temperature_fault(m, k, value) : TT_FAULT_NONE;
}

int tt_check_row(const tt_model* m, double* given, int32_t* fault) {
  int count = 0;
  for (int k = 0; k < m->channels; ++k) {
    fault[k] = fault_of(m, k, given[k]);
    if (fault[k] == TT_FAULT_NONE) continue;
    given[k] = tt_nan();
    ++count;
  }
  return count;
}
