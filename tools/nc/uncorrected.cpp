// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/nc/uncorrected.h"

#include <fmt/format.h>

#include <algorithm>

namespace thermotwin::tools {

/// Linear axes turn none.
const compensation::AxisReach& Uncorrected::reach(const mesh::Pose& pose) {
  bool same = reach_.has_value();
  for (std::size_t a = 0; same && a < machine_.axes.size(); ++a)
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
