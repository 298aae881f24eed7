// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/nc/uncorrected.h"

#include <fmt/format.h>

#include <algorithm>

namespace thermotwin::tools {

namespace {

bool turns_a_linear_axis(const mesh::Machine& machine) {
  const auto kind_of = [&](const mesh::BodySpec& body) {
    const int axis = machine.axis_index(body.axis);
    return axis < 0 ? std::nullopt : std::optional(machine.axes[axis].kind);
  };
  return std::any_of(machine.bodies.begin(), machine.bodies.end(), [&](const mesh::BodySpec& body) {
    if (kind_of(body) != mesh::AxisKind::linear) return false;
    for (int at = machine.body_index(body.parent); at >= 0; at = machine.body_index(machine.bodies[at].parent))
      if (kind_of(machine.bodies[at]) == mesh::AxisKind::rotary) return true;
    return false;
  });
}

}  // namespace

Uncorrected::Uncorrected(const mesh::Machine& machine) : machine_(machine), turned_(turns_a_linear_axis(machine)) {}

const compensation::AxisReach& Uncorrected::reach(const mesh::Pose& pose) {
  bool same = reach_.has_value();
  for (std::size_t a = 0; turned_ && same && a < machine_.axes.size(); ++a)
    same = machine_.axes[a].kind == mesh::AxisKind::linear || pose[a] == reached_at_[a];
  if (!same) {
    reach_.emplace(machine_, pose);
    reached_at_ = pose;
  }
  return *reach_;
}

void Uncorrected::add(const nc::PredictedMove& move) {
  const compensation::AxisReach& here = reach(move.end);
  if (here.unmoved_directions().empty()) return;
  if (directions_.empty()) directions_ = here.unmoved_directions();
  largest_um_ = std::max(largest_um_, here.unmoved(move.error_um).norm());
}

std::string Uncorrected::sentence(const std::string& unit) const {
  if (directions_.empty()) return "";
  return fmt::format("No axis moves the tool along {}: up to {:.2f} {} of a cutting move's error stay there.",
                     directions_, largest_um_, unit);
}

void Uncorrected::to(nlohmann::json& json) const {
  json["unmoved_directions"] = directions_;
  json["largest_unmoved_um"] = largest_um_;
}

}  // namespace thermotwin::tools
