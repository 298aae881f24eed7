// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/report/time_text.h"

#include <fmt/format.h>

#include "core/units.h"

namespace thermotwin::nc {

namespace units = core::units;

std::string time_text(double seconds) {
  if (seconds < 120.0) return fmt::format("{:.1f} s", seconds);
  if (seconds < 2.0 * units::hour) return fmt::format("{:.1f} min", seconds / units::minute);
  return fmt::format("{:.2f} h", seconds / units::hour);
}

TimeUnit unit_for(double duration) {
  if (duration < 300.0) return {"s", 1.0};
  if (duration < 5.0 * units::hour) return {"min", units::minute};
  return {"h", units::hour};
}

}  // namespace thermotwin::nc
