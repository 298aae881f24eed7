// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A missing value in tables and series is NaN.

#include <limits>

namespace thermotwin::core {

inline constexpr double missing = std::numeric_limits<double>::quiet_NaN();

}  // namespace thermotwin::core
