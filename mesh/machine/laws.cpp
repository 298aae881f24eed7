// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/machine/laws.h"

#include <cmath>

#include "core/interpolation.h"

namespace thermotwin::mesh {

double Curve::operator()(double x) const { return at.empty() ? 1.0 : core::linear_at(at, value, x); }

double ContactLaw::factor(bool clamped) const {
  if (!(pressure > 0.0)) return 1.0;
  const double now = clamped && clamped_pressure > 0.0 ? clamped_pressure : pressure;
  return by_pressure.at.empty() ? std::pow(now / nominal_pressure, exponent) : by_pressure(now);
}

}  // namespace thermotwin::mesh
