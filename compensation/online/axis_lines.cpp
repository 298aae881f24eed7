// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/axis_lines.h"

#include <algorithm>
#include <cmath>
#include <iterator>

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

/// Of the workspace; an axis that the grid does not have: its own travel.
Travel travel_of(const mesh::Machine& machine, int axis) {
  const mesh::Axis& own = machine.axes[axis];
  const auto& names = machine.workspace.axes;
  const auto place = std::find(names.begin(), names.end(), own.id) - names.begin();
  if (place == std::ssize(names)) return {own.low, own.high};
  const std::vector<double>& at = machine.workspace.positions[place];
  return {at.front(), at.back()};
}

mesh::Pose with(mesh::Pose pose, int axis, double position) {
  pose[axis] = position;
  return pose;
}

/// The grid's poses, axes outside of the grid at their present positions.
std::vector<mesh::Pose> poses_from(const mesh::Machine& machine, const mesh::Pose& present) {
  std::vector<mesh::Pose> poses = mesh::workspace_poses(machine);
  const auto& names = machine.workspace.axes;
  for (mesh::Pose& pose : poses) {
    for (int a = 0; a < std::ssize(machine.axes); ++a)
      if (std::find(names.begin(), names.end(), machine.axes[a].id) == names.end()) pose[a] = present[a];
  }
  return poses;
}

Vector6 error_um(const OnlineModel& model, const mesh::Pose& pose) { return model.tcp(pose).error / core::units::um; }

}  // namespace

std::vector<AxisLine> axis_lines(const OnlineModel& model, const OutputMap& map, const mesh::Machine& machine,
                                 const VectorXd& offset_um) {
  const auto offsets_at = [&](const mesh::Pose& pose) -> VectorXd {
    return map.offsets(model.tcp(pose)) / core::units::um;
  };
  const mesh::Pose present = model.pose();
  const VectorXd here = offsets_at(present);
  const std::vector<mesh::Pose> poses = poses_from(machine, present);
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
  for (const int axis : axes) {
    const Travel travel = travel_of(machine, axis);
    middle[axis] = 0.5 * (travel.low + travel.high);
  }
  ErrorTables tables;
  tables.at_middle = error_um(model, middle);
  for (const int axis : axes) {
    AxisErrors along{machine.axes[axis].id, travel_of(machine, axis).even(), Eigen::MatrixXd(6, positions)};
    for (Index i = 0; i < positions; ++i)
      along.errors.col(i) = error_um(model, with(middle, axis, along.position[i])) - tables.at_middle;
    tables.axes.push_back(std::move(along));
  }
  tables.left_um.setZero();
  for (const mesh::Pose& pose : poses_from(machine, middle)) {
    Vector3d sum = tables.at_middle.head<3>();
    for (const int axis : axes) sum += (error_um(model, with(middle, axis, pose[axis])) - tables.at_middle).head<3>();
    tables.left_um = tables.left_um.cwiseMax((error_um(model, pose).head<3>() - sum).cwiseAbs());
  }
  return tables;
}

}  // namespace thermotwin::compensation
