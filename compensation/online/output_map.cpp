// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/output_map.h"

#include <Eigen/QR>

#include <algorithm>
#include <iterator>
#include <numbers>

#include "mesh/machine/kinematics.h"
#include "reduction/model/output_grid.h"
#include "solver/operation/grid_occupancy.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index parts = 19;  // tool 6, table axis 6, table own 7

MatrixXd stacked(const std::vector<MatrixXd>& blocks, Index columns) {
  Index rows = 0;
  for (const MatrixXd& block : blocks) rows += block.rows();
  MatrixXd all(rows, columns);
  rows = 0;
  for (const MatrixXd& block : blocks) {
    all.middleRows(rows, block.rows()) = block;
    rows += block.rows();
  }
  return all;
}

bool carries(const mesh::Machine& machine, int body, const std::string& axis) {
  for (; body >= 0; body = machine.body_index(machine.bodies[body].parent)) {
    if (machine.bodies[body].axis == axis) return true;
  }
  return false;
}

/// Error of the TCP (3) for each of the 19 outputs: tcp_error is linear in them.
Eigen::Matrix<double, 3, parts> output_columns(const mesh::Machine& machine, const mesh::Pose& pose) {
  Eigen::Matrix<double, 3, parts> columns;
  for (Index k = 0; k < parts; ++k) {
    Eigen::Matrix<double, parts, 1> unit = Eigen::Matrix<double, parts, 1>::Zero();
    unit[k] = 1.0;
    columns.col(k) =
        solver::tcp_error(machine, pose, unit.head<6>(), unit.segment<6>(6), unit.tail<7>()).error.head<3>();
  }
  return columns;
}

/// Index of the rotary axis that turns the table itself, or -1.
int table_axis(const mesh::Machine& machine) {
  const int body = machine.body_index(machine.tcp.table_body);
  if (body < 0) return -1;
  const std::string& id = machine.bodies[body].axis;
  const int axis = id.empty() ? -1 : machine.axis_index(id);
  return axis >= 0 && machine.axes[axis].kind == mesh::AxisKind::rotary ? axis : -1;
}

/// Sum of columns by their weights, of which many are 0.
template <int rows>
Eigen::Matrix<double, rows, 1> weighted(const MatrixXd& columns, const VectorXd& weights) {
  Eigen::Matrix<double, rows, 1> sum = Eigen::Matrix<double, rows, 1>::Zero();
  for (Index j = 0; j < weights.size(); ++j)
    if (weights[j] != 0.0) sum += weights[j] * columns.col(j).template head<rows>();
  return sum;
}

}  // namespace

OutputMap::OutputMap(const reduction::ReducedModel& model)
    : model_(model),
      grid_(model.machine, model.outputs.tool.size()) {
  find_travels();
  const mesh::Machine& machine = model.machine;
  const Index order = model.system.order();
  tool_ = stacked(model.outputs.tool, order);
  axis_ = stacked(model.outputs.table_axis, order);
  own_ = stacked(model.outputs.table_own, order);
  tool_poses_ = std::ssize(model.outputs.tool);
  grid_poses_ = grid_.grid_count();
  table_poses_ = std::ssize(model.outputs.table_axis);

  std::vector<Eigen::Vector3d> motions;
  const int tool_body = machine.body_index(machine.tcp.tool_body);
  for (const mesh::Axis& axis : machine.axes) {
    if (axis.kind != mesh::AxisKind::linear) continue;
    axes_.push_back(axis.id);
    motions.push_back(carries(machine, tool_body, axis.id) ? axis.direction : Eigen::Vector3d(-axis.direction));
  }
  const auto count = std::ssize(axes_);
  to_axes_.resize(count, 3);
  motions_.resize(3, count);
  if (count > 0) {
    MatrixXd motion(3, count);
    for (Index i = 0; i < count; ++i) motion.col(i) = motions[i];
    to_axes_ = -motion.completeOrthogonalDecomposition().pseudoInverse();
    motions_ = motion;
  }

  const int turning = table_axis(machine);
  const std::vector<std::size_t>& table_grid = grid_.table_grid_places();
  grid_tables_ = std::ssize(table_grid);
  rows_.resize(grid_poses_ * grid_tables_ * angles * count, order);
  Index row = 0;
  for (Index i = 0; i < grid_poses_; ++i) {
    for (const std::size_t table : table_grid) {
      const Index j = table;
      mesh::Pose pose = model.outputs.tool_poses[i];
      for (const std::string& id : machine.workspace.table_axes) {
        const int axis = machine.axis_index(id);
        if (axis >= 0) pose[axis] = model.outputs.table_poses[table][axis];
      }
      for (Index angle = 0; angle < angles; ++angle) {
        if (turning >= 0) pose[turning] = angle * std::numbers::pi / 2.0;
        workspace_poses_.push_back(pose);
        columns_.push_back(output_columns(machine, pose));
        const MatrixXd columns = to_axes_ * columns_.back();
        rows_.middleRows(row, count).noalias() = columns.leftCols(6) * tool_.middleRows(6 * i, 6);
        rows_.middleRows(row, count).noalias() += columns.middleCols(6, 6) * axis_.middleRows(6 * j, 6);
        rows_.middleRows(row, count).noalias() += columns.rightCols(7) * own_.middleRows(7 * j, 7);
        row += count;
      }
    }
  }
  variance_ = MatrixXd::Zero(count, grid_poses_ * grid_tables_);
  smallest_ = VectorXd::Zero(count);
}

void OutputMap::project(const VectorXd& state, Projected& out) const {
  out.tool.resize(6, tool_poses_);
  out.axis.resize(6, table_poses_);
  out.own.resize(7, table_poses_);
  out.tool.reshaped().noalias() = tool_ * state;
  out.axis.reshaped().noalias() = axis_ * state;
  out.own.reshaped().noalias() = own_ * state;
}

solver::TcpError OutputMap::tcp(const Projected& base, const Projected& change, double share,
                                const mesh::Pose& pose) const {
  VectorXd at_tool, at_table;
  grid_.tool_weights(pose, at_tool);
  grid_.table_weights(pose, at_table);
  solver::Vector6 tool = weighted<6>(base.tool, at_tool), axis = weighted<6>(base.axis, at_table);
  solver::Vector7 own = weighted<7>(base.own, at_table);
  if (share != 0.0) {
    tool += share * weighted<6>(change.tool, at_tool);
    axis += share * weighted<6>(change.axis, at_table);
    own += share * weighted<7>(change.own, at_table);
  }
  return solver::tcp_error(model_.machine, pose, tool, axis, own);
}

void OutputMap::rows(const mesh::Pose& pose, Eigen::Matrix3Xd& tool, Eigen::Matrix3Xd& table) const {
  VectorXd at_tool, at_table;
  grid_.tool_weights(pose, at_tool);
  grid_.table_weights(pose, at_table);
  MatrixXd outputs = MatrixXd::Zero(parts, model_.system.order());
  for (Index i = 0; i < tool_poses_; ++i) {
    if (at_tool[i] != 0.0) outputs.topRows(6) += at_tool[i] * tool_.middleRows(6 * i, 6);
  }
  for (Index j = 0; j < table_poses_; ++j) {
    if (at_table[j] == 0.0) continue;
    outputs.middleRows(6, 6) += at_table[j] * axis_.middleRows(6 * j, 6);
    outputs.bottomRows(7) += at_table[j] * own_.middleRows(7 * j, 7);
  }
  const Eigen::Matrix<double, 3, parts> columns = output_columns(model_.machine, pose);
  tool = columns.leftCols(6) * outputs.topRows(6);
  table = columns.rightCols(13) * outputs.bottomRows(13);
}

void OutputMap::set_covariance(const MatrixXd& directions, const MatrixXd& covariance) {
  set_variance(rows_ * directions, covariance);
}

void OutputMap::set_covariance(const MatrixXd& directions, const MatrixXd& covariance, const Projected& present) {
  constexpr Index more = 9;
  const Index quantities = directions.cols(), count = std::ssize(axes_);
  MatrixXd influence(rows_.rows(), quantities + more);
  influence.leftCols(quantities).noalias() = rows_ * directions;
  Index pose = 0;
  for (Index i = 0; i < grid_poses_; ++i) {
    for (const std::size_t place : grid_.table_grid_places()) {
      const Index j = place;
      for (Index angle = 0; angle < angles; ++angle, ++pose) {
        const auto& columns = columns_[pose];
        const Eigen::Vector3d tool = columns.leftCols(6) * present.tool.col(i);
        const Eigen::Vector3d table =
            columns.middleCols(6, 6) * present.axis.col(j) + columns.rightCols(7) * present.own.col(j);
        auto block = influence.block(pose * count, quantities, count, more);
        block.leftCols(3) = to_axes_ * tool.asDiagonal();
        block.middleCols(3, 3) = to_axes_ * table.asDiagonal();
        block.rightCols(3) = to_axes_;
      }
    }
  }
  set_variance(influence, covariance);
}

void OutputMap::set_variance(const MatrixXd& influence, const MatrixXd& covariance) {
  const VectorXd variance = (influence * covariance).cwiseProduct(influence).rowwise().sum();
  const auto count = std::ssize(axes_);
  for (Index pose = 0; pose < variance_.cols(); ++pose) {
    for (Index a = 0; a < count; ++a) {
      double sum = 0.0;
      for (Index angle = 0; angle < angles; ++angle) sum += variance[(pose * angles + angle) * count + a];
      variance_(a, pose) = std::max(0.0, sum / angles);
    }
  }
  smallest_ = variance_.rowwise().minCoeff();
}

VectorXd OutputMap::variance(const mesh::Pose& pose) const {
  VectorXd at_tool, at_table;
  grid_.grid_weights(pose, at_tool);
  grid_.table_grid_weights(pose, at_table);
  VectorXd sum = VectorXd::Zero(variance_.rows());
  for (Index i = 0; i < grid_poses_; ++i) {
    if (at_tool[i] != 0.0)
      sum.noalias() += at_tool[i] * (variance_.middleCols(i * grid_tables_, grid_tables_) * at_table);
  }
  return sum.cwiseMax(smallest_);
}

MatrixXd OutputMap::workspace_offsets(const VectorXd& state) const {
  return (rows_ * state).reshaped(std::ssize(axes_), std::ssize(workspace_poses_));
}

void OutputMap::find_travels() {
  const mesh::Machine& machine = model_.machine;
  const auto add = [&](const std::vector<std::string>& axes, const std::vector<std::vector<double>>& positions) {
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const int axis = machine.axis_index(axes[i]);
      if (axis < 0 || positions[i].size() < 2 || machine.axes[axis].endless) continue;
      const double slack = 1e-6 * (positions[i].back() - positions[i].front());
      travels_.push_back({axis, positions[i].front() - slack, positions[i].back() + slack});
    }
  };
  add(machine.workspace.axes, machine.workspace.positions);
  add(machine.workspace.table_axes, machine.workspace.table_positions);
}

bool OutputMap::outside(const mesh::Pose& pose) const {
  return std::any_of(travels_.begin(), travels_.end(), [&](const Travel& travel) {
    return pose[travel.axis] < travel.low || pose[travel.axis] > travel.high;
  });
}

}  // namespace thermotwin::compensation
