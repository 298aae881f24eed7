// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The range of a number in files and in options.

#include <string>

namespace thermotwin::core {

/// The bounds are inclusive; NaN and infinity are never allowed.
struct Range {
  double low = -1e300;
  double high = 1e300;
  bool holds(double value) const { return value >= low && value <= high; }
};
inline constexpr Range any_number{};
inline constexpr Range positive{1e-300, 1e300};
inline constexpr Range non_negative{0.0, 1e300};

/// "a number from 1 to 5", "a number above 0", ...
std::string phrase(const Range& range);

/// @throws InputError naming the field, its value and what is allowed, unless it holds. @param allowed  as a phrase
void require_option(bool holds, const std::string& field, double value, const std::string& allowed);

/// @throws InputError naming the field ("integrator options: tolerance"), its value and the range
void require_within(const std::string& field, double value, const Range& range);

}  // namespace thermotwin::core
