// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/axis_lines.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <utility>

#include "core/units.h"
#include "mesh/machine/kinematics.h"

namespace thermotwin::compensation {

namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr Index positions = 21;  ///< along an axis

struct Travel {
  double low, high;
  VectorXd even() const { return VectorXd::LinSpaced(positions, low, high); }
};

/// Positions of an axis in the workspace. Outside of its grid: quarters of a turn where the axis has no ends, else
/// ends and middle of its travel.
std::vector<double> positions_of(const mesh::Machine& machine, int axis) {
  const mesh::Axis& own = machine.axes[axis];
  const mesh::Workspace& workspace = machine.workspace;
  for (const auto& [names, all] : {std::pair(&workspace.axes, &workspace.positions),
                                   std::pair(&workspace.table_axes, &workspace.table_positions)}) {
    const auto place = std::find(names->begin(), names->end(), own.id) - names->begin();
    if (place < std::ssize(*names)) return (*all)[place];
  }
  constexpr double quarter = std::numbers::pi / 2;
  if (own.endless) return {0.0, quarter, 2 * quarter, 3 * quarter};
  return {own.low, 0.5 * (own.low + own.high), own.high};
}

Travel travel_of(const mesh::Machine& machine, int axis) {
  const std::vector<double> at = positions_of(machine, axis);
  return {at.front(), at.back()};
}

/// An axis without ends has none: 0.
double middle_of(const mesh::Machine& machine, int axis) {
  if (machine.axes[axis].endless) return 0.0;
  const Travel travel = travel_of(machine, axis);
  return 0.5 * (travel.low + travel.high);
}

mesh::Pose with(mesh::Pose pose, int axis, double position) {
  pose[axis] = position;
  return pose;
}

/// All axes at all of their positions. @param moves  an axis that does not stays at `from`
template <class Moves>
std::vector<mesh::Pose> poses_from(const mesh::Machine& machine, const mesh::Pose& from, Moves moves) {
  std::vector<mesh::Pose> poses = {from};
  for (int axis = 0; axis < std::ssize(machine.axes); ++axis) {
    if (!moves(axis)) continue;
    std::vector<mesh::Pose> finer;
    for (const mesh::Pose& pose : poses)
      for (const double position : positions_of(machine, axis)) finer.push_back(with(pose, axis, position));
    poses = std::move(finer);
  }
  return poses;
}

bool all_move(int /*axis*/) { return true; }

Vector6 error_um(const OnlineModel& model, const mesh::Pose& pose) { return model.tcp(pose).error / core::units::um; }

}  // namespace

std::vector<AxisLine> axis_lines(const OnlineModel& model, const OutputMap& map, const mesh::Machine& machine,
                                 const VectorXd& offset_um) {
  const auto offsets_at = [&](const mesh::Pose& pose) -> VectorXd {
    return map.offsets(model.tcp(pose)) / core::units::um;
  };
  const mesh::Pose present = model.pose();
  const VectorXd here = offsets_at(present);
  const std::vector<mesh::Pose> poses = poses_from(machine, present, all_move);
  std::vector<VectorXd> offsets;
  for (const mesh::Pose& pose : poses) offsets.push_back(offsets_at(pose));
  std::vector<AxisLine> lines;
  for (Index k = 0; k < std::ssize(model.axes()); ++k) {
    const int axis = machine.axis_index(model.axes()[k]);
    AxisLine line;
    line.reference = present[axis];
    line.offset_um = offset_um[k];
    const VectorXd away = travel_of(machine, axis).even().array() - line.reference;
    VectorXd change(away.size());
    for (Index i = 0; i < away.size(); ++i)
      change[i] = offsets_at(with(present, axis, line.reference + away[i]))[k] - here[k];
    if (const double squares = away.squaredNorm(); squares > 0.0) line.slope_um_m = away.dot(change) / squares;
    line.left_travel_um = (change - line.slope_um_m * away).cwiseAbs().maxCoeff();
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const double by_line = here[k] + line.slope_um_m * (poses[i][axis] - line.reference);
      line.left_across_um = std::max(line.left_across_um, std::abs(offsets[i][k] - by_line));
    }
    lines.push_back(line);
  }
  return lines;
}

ErrorTables error_tables(const OnlineModel& model, const mesh::Machine& machine) {
  mesh::Pose middle = model.pose();
  std::vector<int> axes;
  for (const std::string& name : model.axes()) axes.push_back(machine.axis_index(name));
  for (int axis = 0; axis < std::ssize(machine.axes); ++axis) middle[axis] = middle_of(machine, axis);
  ErrorTables tables;
  for (int axis = 0; axis < std::ssize(machine.axes); ++axis) {
    if (machine.axes[axis].kind == mesh::AxisKind::linear) continue;
    const Travel travel = travel_of(machine, axis);
    tables.rotary.push_back({machine.axes[axis].id, middle[axis], travel.low, travel.high});
  }
  tables.at_middle = error_um(model, middle);
  for (const int axis : axes) {
    AxisErrors along{machine.axes[axis].id, travel_of(machine, axis).even(), Eigen::MatrixXd(6, positions)};
    machine.axes[axis].direction.cwiseAbs().maxCoeff(&along.along);
    for (Index i = 0; i < positions; ++i)
      along.errors.col(i) = error_um(model, with(middle, axis, along.position[i])) - tables.at_middle;
    tables.axes.push_back(std::move(along));
  }
  const auto largest_left = [&](const std::vector<mesh::Pose>& poses) {
    Vector3d left = Vector3d::Zero();
    for (const mesh::Pose& pose : poses) {
      Vector3d sum = tables.at_middle.head<3>();
      for (const int axis : axes) sum += (error_um(model, with(middle, axis, pose[axis])) - tables.at_middle).head<3>();
      left = left.cwiseMax((error_um(model, pose).head<3>() - sum).cwiseAbs());
    }
    return left;
  };
  const auto is_linear = [&](int axis) { return machine.axes[axis].kind == mesh::AxisKind::linear; };
  tables.left_um = largest_left(poses_from(machine, middle, all_move));
  tables.left_at_rotary_middle_um = largest_left(poses_from(machine, middle, is_linear));
  return tables;
}

}  // namespace thermotwin::compensation
