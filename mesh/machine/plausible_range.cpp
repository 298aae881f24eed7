// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/machine/plausible_range.h"

#include <fmt/format.h>

#include "core/error.h"
#include "core/units.h"

namespace thermotwin::mesh {

std::string PlausibleRange::phrase() const {
  return fmt::format("{:.9g} to {:.9g} degC{}", low_C, high_C, stated.empty() ? "" : " (" + stated + ")");
}

void PlausibleRange::require(double value_C, const std::string& place) const {
  if (holds(value_C)) return;
  const double from_kelvin = value_C - core::units::zero_C_in_K;
  throw core::InputError(place,
                         holds(from_kelvin)
                             ? fmt::format("{:.9g} degC ({:.9g} degC if in kelvin)", value_C, from_kelvin)
                             : fmt::format("{:.9g} degC", value_C),
                         phrase());
}

}  // namespace thermotwin::mesh
