// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The variables of an FMU in the order of their references, for the descriptions of FMI 2.0 and 3.0: channels, sensors,
// offsets, their deviations, then the integers.

#include <array>
#include <string>
#include <vector>

#include "compensation/control/control_data.h"

namespace thermotwin::compensation {

inline constexpr double fmu_not_given = -1e30;  ///< an input at this value has none

/// Unit of a channel by the end of its name: name, and what it is in SI units.
struct FmuUnit {
  const char *ending, *name, *base;
};
const std::array<FmuUnit, 11>& fmu_units();
const FmuUnit& fmu_unit(const std::string& channel);
/// @return the elements of UnitDefinitions, the same in both versions
std::string fmu_unit_definitions();

struct FmuVariable {
  enum class Kind { input, output, integer_output };
  Kind kind;
  std::string name, meaning, unit;
  double start;  ///< of an input
};
std::vector<FmuVariable> fmu_variables(const ControlData& data);

std::string fmu_escaped(const std::string& text);  ///< for XML
std::string fmu_purpose(const ControlData& data);  ///< a sentence for the description

}  // namespace thermotwin::compensation
