// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The variables of an FMU in the order of their value references, for the descriptions of FMI 2.0 and 3.0: channels,
// sensors, offsets, standard deviations of the offsets, then the integers (status, guard, faults of sensors).

#include <array>
#include <string>
#include <vector>

#include "compensation/control/control_data.h"

namespace thermotwin::compensation {

inline constexpr double fmu_not_given = -1e30;  ///< an input with this value counts as not given

/// Unit of the channels whose names have an ending: name of the unit, and the XML attributes of its BaseUnit in FMI.
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
