// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/chain/location_offsets.h"

#include <Eigen/QR>
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/error.h"
#include "core/text.h"

namespace thermotwin::compensation {

using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr std::array<char, 6> components{'X', 'Y', 'Z', 'A', 'B', 'C'};

/// The axis on this branch and its index; -1: not there.
int index_of(const std::vector<ChainAxis>& branch, const std::string& id) {
  for (int i = 0; i < std::ssize(branch); ++i) {
    if (branch[i].id == id) return i;
  }
  return -1;
}

/// The rotary axis nearest to the workpiece: its body is the table. -1: none.
int table_axis(const std::vector<ChainAxis>& table) {
  for (int i = std::ssize(table) - 1; i >= 0; --i) {
    if (table[i].rotary) return i;
  }
  return -1;
}

}  // namespace

void OffsetOptions::validate() const {
  if (!(table_radius > 0.0))
    throw InputError("location offsets: table radius", fmt::format("{} m", table_radius), "a length above 0");
}

LocationOffsets::LocationOffsets(KinematicChain chain, const OffsetOptions& options)
    : chain_(std::move(chain)),
      options_(options) {
  options.validate();
  const std::vector<std::string> all = chain_.ids();
  for (const std::string& id : options.axes) {
    if (std::find(all.begin(), all.end(), id) == all.end()) {
      throw InputError("location offsets: axes", "'" + id + "'",
                       "one of: " + core::join(all) + " (nearest: " + core::nearest(id, all) + ")");
    }
  }
  for (const std::string& id : all) {
    const bool wanted =
        options.axes.empty() || std::find(options.axes.begin(), options.axes.end(), id) != options.axes.end();
    if (wanted && (options.orientation || !chain_.find(id)->rotary)) axes_.push_back(id);
    for (const char component : components) known_.push_back(std::string(1, component) + "0" + id);
  }
  for (const char component : components) known_.push_back(std::string(1, component) + "0T");
  known_.emplace_back("R0T");
}

LocationOffsets::Motion LocationOffsets::motion_of(const std::string& error, double value,
                                                   const std::map<std::string, double>& positions,
                                                   const Vector3d& point) const {
  if (std::find(known_.begin(), known_.end(), error) == known_.end()) {
    throw InputError("location error", "'" + error + "'",
                     "one of: " + core::join(known_) + " (nearest: " + core::nearest(error, known_) + ")");
  }
  const std::string of = error.substr(2);
  const bool of_table = of == "T";
  const bool table_side = of_table || chain_.find(of)->table_side;
  const std::vector<ChainAxis>& branch = table_side ? chain_.table : chain_.tool;
  const int axis = of_table ? table_axis(branch) : index_of(branch, of);
  // Errors stand in the frame of the body that carries the axis.
  const Eigen::Isometry3d carrier = KinematicChain::frame(branch, axis - 1, positions);
  const Vector3d origin = axis >= 0 ? branch[axis].origin : Vector3d::Zero();
  const Vector3d arm = carrier.inverse() * point - origin;
  Motion motion;
  if (error == "R0T") {
    const Vector3d along = axis >= 0 ? branch[axis].direction : Vector3d::UnitZ();
    motion.shift = value / options_.table_radius * (arm - along * along.dot(arm));
  } else {
    const Index component = std::find(components.begin(), components.end(), error[0]) - components.begin();
    if (component < 3) {
      motion.shift[component] = value;
    } else {
      motion.turn[component - 3] = value;
      motion.shift = motion.turn.cross(arm);
    }
  }
  const double sign = table_side ? -1.0 : 1.0;  // error = tool - workpiece
  motion.shift = sign * (carrier.linear() * motion.shift);
  motion.turn = sign * (carrier.linear() * motion.turn);
  return motion;
}

AxisOffsets LocationOffsets::offsets(const std::map<std::string, double>& errors,
                                     const std::map<std::string, double>& positions, const Vector3d& point) const {
  AxisOffsets result;
  result.point_error.setZero();
  result.orientation_error.setZero();
  for (const auto& [name, value] : errors) {
    const Motion motion = motion_of(name, value, positions, point);
    result.point_error += motion.shift;
    result.orientation_error += motion.turn;
  }
  // Motion of the tool against the workpiece for a unit of each axis.
  std::vector<Index> linear, rotary;
  MatrixXd shift = MatrixXd::Zero(3, std::ssize(axes_)), turn = shift;
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    const ChainAxis& axis = *chain_.find(axes_[i]);
    const std::vector<ChainAxis>& branch = axis.table_side ? chain_.table : chain_.tool;
    const Eigen::Isometry3d carrier = KinematicChain::frame(branch, index_of(branch, axis.id) - 1, positions);
    const Vector3d direction = (axis.table_side ? -1.0 : 1.0) * (carrier.linear() * axis.direction);
    const Index column = i;
    if (axis.rotary) {
      turn.col(column) = direction;
      shift.col(column) = direction.cross(point - carrier * axis.origin);
      rotary.push_back(column);
    } else {
      shift.col(column) = direction;
      linear.push_back(column);
    }
  }
  result.offset = VectorXd::Zero(std::ssize(axes_));
  const auto solve = [](const MatrixXd& matrix, const Vector3d& right) {
    Eigen::CompleteOrthogonalDecomposition<MatrixXd> factor(matrix.rows(), matrix.cols());
    constexpr double parallel = 1e-6;  // axes that have turned into each other
    factor.setThreshold(parallel);
    factor.compute(matrix);
    return VectorXd(factor.solve(right));
  };
  if (!rotary.empty()) result.offset(rotary) = solve(turn(Eigen::all, rotary), -result.orientation_error);
  result.orientation_left = result.orientation_error + turn * result.offset;
  const Vector3d at_point = result.point_error + shift * result.offset;
  if (!linear.empty()) result.offset(linear) = solve(shift(Eigen::all, linear), -at_point);
  result.point_left = result.point_error + shift * result.offset;
  return result;
}

}  // namespace thermotwin::compensation
