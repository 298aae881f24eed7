// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/machine/laws.h"

#include <cmath>

#include "core/interpolation.h"

namespace thermotwin::mesh {

double Curve::operator()(double x) const { return at.empty() ? 1.0 : core::linear_at(at, value, x); }

TableInput table_input(const std::string& channel) {
  if (channel == time_of_day) return TableInput::hour;
  return channel.ends_with(".T_C") ? TableInput::value : TableInput::magnitude;
}

double at_input(TableInput input, double value) {
  constexpr double day = 24.0;
  switch (input) {
    case TableInput::value: return value;
    case TableInput::hour: return value - day * std::floor(value / day);
    case TableInput::magnitude: break;
  }
  return std::abs(value);
}

double ContactLaw::factor(bool clamped) const {
  if (!(pressure.value > 0.0)) return 1.0;
  const double now = clamped && clamped_pressure > 0.0 ? clamped_pressure : pressure.value;
  return by_pressure.at.empty() ? std::pow(now / nominal_pressure, exponent) : by_pressure(now);
}

}  // namespace thermotwin::mesh
