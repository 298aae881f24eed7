// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The value of what was not measured, in tables and series: not a number.

#include <limits>

namespace thermotwin::core {

inline constexpr double missing = std::numeric_limits<double>::quiet_NaN();

}  // namespace thermotwin::core
