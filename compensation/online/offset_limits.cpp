// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/offset_limits.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "core/units.h"
#include "mesh/machine/kinematics.h"
#include "reduction/basis/responses.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double surroundings_K = 20.0, worked_s = 8 * 3600.0, margin = 2.0;
constexpr double least_um = 1.0;  ///< of a machine that its model does not move
/// Rapids of axes that state none, m/s and rad/s.
constexpr double usual_rapid = 1.0, usual_turning = 2.0 * std::numbers::pi;

/// The axis in which two poses differ, if it is one; else -1.
Index only_difference(const mesh::Pose& one, const mesh::Pose& other) {
  Index axis = -1;
  for (Index a = 0; a < one.size(); ++a) {
    if (one[a] == other[a]) continue;
    if (axis >= 0) return -1;
    axis = a;
  }
  return axis;
}

}  // namespace

std::vector<VectorXd> worked_states(const reduction::ReducedModel& model) {
  const reduction::ReducedSystem& system = model.system;
  const solver::OperatingModel operating(model.machine, system.layout);
  std::vector<VectorXd> states;
  for (const reduction::OperatingPoint& point : reduction::operating_points(operating)) {
    MatrixXd matrix = system.conduction + system.capacity / worked_s;
    for (Index j = 0; j < point.c.p.size(); ++j) {
      if (point.c.p[j] != 0.0) matrix += point.c.p[j] * system.terms[j];
    }
    states.push_back(matrix.partialPivLu().solve(system.inputs * point.c.q));
  }
  return states;
}

double OffsetLimits::motion_um(const mesh::Pose& from, const mesh::Pose& to, double duration) const {
  return slope_um.dot((to - from).cwiseAbs().cwiseMin(rapid * duration));
}

OffsetLimits offset_limits(const reduction::ReducedModel& model, const OutputMap& map) {
  const std::vector<mesh::Axis>& axes = model.machine.axes;
  OffsetLimits limits;
  limits.slope_um = limits.rapid = VectorXd::Zero(std::ssize(axes));
  for (std::size_t a = 0; a < axes.size(); ++a) {
    const double usual = axes[a].kind == mesh::AxisKind::linear ? usual_rapid : usual_turning;
    limits.rapid[a] = axes[a].rapid > 0.0 ? axes[a].rapid : usual;
  }
  // Offsets of the surroundings and the largest of what the machine's own work makes, at each pose.
  const std::vector<mesh::Pose>& poses = map.workspace_poses();
  const auto count = std::ssize(poses);
  std::vector<MatrixXd> offsets{map.workspace_offsets(surroundings_K * model.system.one_kelvin)};
  for (const VectorXd& state : worked_states(model)) {
    if (state.allFinite()) offsets.push_back(map.workspace_offsets(state));
  }
  const auto together = [&](const auto& value) {
    double worked = 0.0;
    for (std::size_t k = 1; k < offsets.size(); ++k) worked = std::max(worked, value(offsets[k]));
    return margin * (value(offsets[0]) + worked) / core::units::um;
  };
  const auto size = [](const MatrixXd& at) { return at.size() > 0 ? at.cwiseAbs().maxCoeff() : 0.0; };
  limits.largest_um = std::max(least_um, together(size));
  limits.rate_um_s = limits.largest_um / offset_settle_s;
  for (Index i = 0; i < count; ++i) {
    for (Index j = 0; j < i; ++j) {
      const mesh::Pose &one = poses[i], &other = poses[j];
      const Index axis = only_difference(one, other);
      if (axis < 0) continue;
      const double distance = std::abs(one[axis] - other[axis]);
      const double slope = together([&](const MatrixXd& at) {
        return at.rows() > 0 ? (at.col(i) - at.col(j)).cwiseAbs().maxCoeff() / distance : 0.0;
      });
      limits.slope_um[axis] = std::max(limits.slope_um[axis], slope);
    }
  }
  return limits;
}

}  // namespace thermotwin::compensation
