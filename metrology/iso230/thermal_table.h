// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The results of an ISO 230-3 test from a measurement folder: of each displacement the range in the first hour and in
// the whole test, and its gradient over a temperature. The extremes of many values are those of their scatter too, so a
// range is also stated without it (scatter.h). The gradient is the slope of the least-squares line, divided by the
// reliability of the temperature (Fuller 1987, 1.2: errors in variables), with its scatter, at most what is stated.
// Rows with a missing value of the displacement (for the gradient also of the temperature) are left out.

#include <limits>
#include <string>
#include <vector>

#include "compensation/measurement/measurement.h"
#include "core/units.h"

namespace thermotwin::metrology {

struct ThermalRow {
  std::string channel, unit;  ///< um or um/m
  Eigen::Index count = 0;
  /// Range within an hour from the start of the record, unit; NaN: fewer than two values in it, or a shorter record
  double first_hour = std::numeric_limits<double>::quiet_NaN();
  double whole = 0;     ///< range of all values, unit
  double last = 0;      ///< last value less the first, unit
  double last_std = 0;  ///< one standard deviation: sqrt(2) of the stated one of a value
  /// Ranges less what the scatter of the values adds to them, and their standard deviation; NaN as above.
  double first_hour_motion = std::numeric_limits<double>::quiet_NaN(), first_hour_std = first_hour_motion;
  double motion = 0, motion_std = 0;
  double gradient = std::numeric_limits<double>::quiet_NaN();      ///< unit per K
  double gradient_std = std::numeric_limits<double>::quiet_NaN();  ///< of the line's residuals and the stated one
  /// Variance of the temperature that is its own, over that with its scatter: the slope of the plain line is too small
  /// by this factor, the gradient is corrected by it.
  double reliability = std::numeric_limits<double>::quiet_NaN();
};

struct ThermalTable {
  double duration = 0;           ///< s, of the record
  std::string ambient;           ///< channel of the gradients; empty: none
  double ambient_range = 0;      ///< K
  std::vector<ThermalRow> rows;  ///< one a displacement channel
  bool has_an_hour() const { return duration >= core::units::hour * (1.0 - 1e-9); }
};

/// @param ambient  a temperature channel; empty: no gradients
/// @throws InputError: no displacement channel, an unknown temperature, a displacement with fewer than two values, a
///         temperature that does not change
ThermalTable thermal_table(const compensation::Measurement& measurement, const std::string& ambient);

}  // namespace thermotwin::metrology
