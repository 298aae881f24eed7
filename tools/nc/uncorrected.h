// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The part of the predicted error in directions along which no linear axis moves the tool. Neither offsets nor a
// corrected program remove it.

#include <nlohmann/json.hpp>

#include <optional>
#include <string>

#include "compensation/online/axis_reach.h"
#include "nc/prediction/prediction.h"

namespace thermotwin::tools {

class Uncorrected {
public:
  explicit Uncorrected(const mesh::Machine& machine);

  void add(const nc::PredictedMove& move);
  /// A sentence for the summary; empty if linear axes move the tool along all directions.
  std::string sentence(const std::string& unit = "um") const;
  /// Adds the keys unmoved_directions and largest_unmoved_um.
  void to(nlohmann::json& json) const;

private:
  const compensation::AxisReach& reach(const mesh::Pose& pose);

  const mesh::Machine& machine_;
  bool turned_;  ///< a rotary axis carries a linear one: the directions depend on the pose
  std::optional<compensation::AxisReach> reach_;
  mesh::Pose reached_at_;
  std::string directions_;
  double largest_um_ = 0;
};

}  // namespace thermotwin::tools
