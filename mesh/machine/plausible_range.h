// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Temperatures that readings, load programs and defaults keep to; one outside is wrong, often in kelvin.

#include <string>

namespace thermotwin::mesh {

/// By default that of data which belong to no machine.
struct PlausibleRange {
  double low_C = -40.0, high_C = 150.0;
  std::string stated = {};  ///< "plausible_C of machine.toml"; empty: nowhere

  bool holds(double value_C) const { return value_C >= low_C && value_C <= high_C; }
  /// "-40 to 150 degC (plausible_C of machine.toml)"
  std::string phrase() const;
  /// @throws InputError (place) for a temperature outside; says its value in degC where it may be in kelvin
  void require(double value_C, const std::string& place) const;
};

}  // namespace thermotwin::mesh
