// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/machine/machine.h"

#include <algorithm>

#include "core/error.h"

namespace thermotwin::mesh {

using core::InputError;

namespace {

template <class Item>
int index_of(const std::vector<Item>& items, const std::string& id) {
  for (int i = 0; i < std::ssize(items); ++i)
    if (items[i].id == id) return i;
  return -1;
}

/// @return whether a holding law of the axis meets the condition
template <class Condition>
bool holds(const Machine& machine, const std::string& axis, const Condition& condition) {
  return std::any_of(machine.sources.begin(), machine.sources.end(), [&](const SourceSpec& source) {
    return std::any_of(source.losses.begin(), source.losses.end(), [&](const LossLaw& loss) {
      const auto* holding = std::get_if<HoldingLoss>(&loss.law);
      return loss.motion == axis && holding != nullptr && condition(*holding);
    });
  });
}

}  // namespace

Machine::Machine() = default;
Machine::Machine(const Machine&) = default;
Machine::Machine(Machine&&) noexcept = default;
Machine& Machine::operator=(const Machine&) = default;
Machine& Machine::operator=(Machine&&) noexcept = default;
Machine::~Machine() = default;

const Material& Machine::material(const std::string& id) const {
  const int index = index_of(materials, id);
  if (index < 0) throw InputError(path.string(), "material '" + id + "'", "a material of the machine");
  return materials[index];
}
int Machine::body_index(const std::string& id) const { return index_of(bodies, id); }
int Machine::axis_index(const std::string& id) const { return index_of(axes, id); }
int Machine::surface_index(const std::string& id) const { return index_of(surfaces, id); }
int Machine::joint_index(const std::string& id) const { return index_of(joints, id); }
int Machine::sensor_index(const std::string& id) const { return index_of(sensors, id); }
int Machine::ambient_index(const std::string& id) const { return index_of(ambients, id); }
int Machine::coolant_index(const std::string& id) const { return index_of(coolants, id); }
int Machine::volume_index(const std::string& id) const { return index_of(volumes, id); }
PlausibleRange Machine::plausible_range() const {
  return {plausible_low_C, plausible_high_C, "plausible_C of machine.toml"};
}
void Machine::require_plausible(double value_C, const std::string& place) const {
  plausible_range().require(value_C, place);
}
bool Machine::has_clamp(const std::string& axis) const {
  return std::any_of(joints.begin(), joints.end(),
                     [&](const JointSpec& joint) { return joint.axis == axis && joint.law.clamped_pressure > 0.0; }) ||
         holds(*this, axis, [](const HoldingLoss&) { return true; });
}
bool Machine::has_direction(const std::string& axis) const {
  return holds(*this, axis, [](const HoldingLoss& holding) { return holding.friction > 0.0; });
}

}  // namespace thermotwin::mesh
