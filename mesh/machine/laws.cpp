// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/machine/laws.h"

#include <algorithm>
#include <cmath>

namespace thermotwin::mesh {

double Curve::operator()(double x) const {
  if (at.empty()) return 1.0;
  if (x <= at.front()) return value.front();
  if (x >= at.back()) return value.back();
  const std::size_t right = std::upper_bound(at.begin(), at.end(), x) - at.begin();
  const double s = (x - at[right - 1]) / (at[right] - at[right - 1]);
  return value[right - 1] + s * (value[right] - value[right - 1]);
}

double ContactLaw::factor(bool clamped) const {
  if (!(pressure > 0.0)) return 1.0;
  const double now = clamped && clamped_pressure > 0.0 ? clamped_pressure : pressure;
  return by_pressure.at.empty() ? std::pow(now / nominal_pressure, exponent) : by_pressure(now);
}

}  // namespace thermotwin::mesh
