// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A time of day in a file: "06:30".

#include <optional>
#include <string_view>

namespace thermotwin::core {

inline constexpr const char* time_of_day_form = "a time of day from \"00:00\" to \"23:59\"";

/// @return the hours since midnight of "HH:MM"; nothing if it is no time of day
std::optional<double> hours_of_day(std::string_view text);

}  // namespace thermotwin::core
