// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/response/seen_sides.h"

#include "compensation/evaluation/reduced_models.h"
#include "core/units.h"

namespace thermotwin::diagnosis {

Sides sides_of(const mesh::Machine& machine, const ObservedChannel& observed) {
  const compensation::ObservedQuantity quantity(machine, observed.channel, observed.pose);
  if (observed.channel.points.empty()) {
    const auto seen = [&](const auto& error_at, const mesh::Pose&) {
      std::vector<solver::TcpError> errors;
      for (const mesh::Pose& at : quantity.poses()) errors.push_back(error_at(at));
      return Eigen::VectorXd::Constant(1, quantity(errors));
    };
    return {{observed.pose}, {sides_at(machine, observed.pose, 1, seen)}};
  }
  Sides sides;
  for (std::size_t k = 0; k < quantity.poses().size(); ++k) {
    const auto seen = [&](const auto& error_at, const mesh::Pose& pose) {
      return Eigen::VectorXd::Constant(
          1, observed.channel.points[k].weight.dot(error_at(pose).error.template head<3>()) / core::units::um);
    };
    sides.poses.push_back(quantity.poses()[k]);
    sides.rows.emplace_back(sides_at(machine, sides.poses.back(), 1, seen));
  }
  return sides;
}

}  // namespace thermotwin::diagnosis
