// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A part of every day in which a source heats: sun through a window, a heating schedule, a shift. It rises and falls
// in straight lines.

#include <string>

#include "mesh/machine/machine.h"

namespace thermotwin::diagnosis {

struct DailyWindow {
  double from_h = 0, to_h = 12;  ///< hours of the day at half the height; to_h may be beyond midnight, up to 48
  double ramp_h = 1;             ///< of each side, at most to_h - from_h
};

/// @return 0 to 1 @param hour  hours since a midnight, any
double height(const DailyWindow& window, double hour);

/// @return the window as a table of machine.toml over the time of day, times a power in W
mesh::PowerLaw law_of(const DailyWindow& window, double power_W);

/// "from 13:30 to 17:00 every day"
std::string in_words(const DailyWindow& window);

}  // namespace thermotwin::diagnosis
