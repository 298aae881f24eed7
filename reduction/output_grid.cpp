// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "reduction/reduced_model.h"

namespace thermotwin::reduction {
namespace {

/// Positions of one axis of a grid.
struct GridAxis {
  int axis = -1;  ///< index into Machine::axes
  std::vector<double> positions;
};

Eigen::VectorXd linear_weights(const std::vector<double>& positions, double x) {
  const std::size_t n = positions.size();
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(n));
  const double inside = std::clamp(x, positions.front(), positions.back());
  std::size_t cell = 0;
  while (cell + 2 < n && inside > positions[cell + 1]) ++cell;
  if (n == 1) {
    weights(0) = 1.0;
    return weights;
  }
  const double share = (inside - positions[cell]) / (positions[cell + 1] - positions[cell]);
  weights(static_cast<Eigen::Index>(cell)) = 1.0 - share;
  weights(static_cast<Eigen::Index>(cell + 1)) = share;
  return weights;
}

/// Quadratic for three positions; a grid of more is joined by straight lines, as one of two is.
Eigen::VectorXd smooth_weights(const std::vector<double>& positions, double x) {
  if (positions.size() != 3) return linear_weights(positions, x);
  const double a = positions[0], b = positions[1], c = positions[2];
  const double t = std::clamp(x, a, c);
  Eigen::Vector3d weights;
  weights << (t - b) * (t - c) / ((a - b) * (a - c)), (t - a) * (t - c) / ((b - a) * (b - c)),
      (t - a) * (t - b) / ((c - a) * (c - b));
  return weights;
}

/// An endless axis repeats after a turn: between its last and first position goes a straight line.
Eigen::VectorXd endless_weights(const std::vector<double>& positions, double x) {
  constexpr double turn = 2.0 * std::numbers::pi;
  const double first = positions.front();
  std::vector<double> closed = positions;
  closed.push_back(first + turn);
  const Eigen::VectorXd weights =
      linear_weights(closed, x - turn * std::floor((x - first) / turn));
  Eigen::VectorXd folded = weights.head(weights.size() - 1);
  folded(0) += weights(weights.size() - 1);
  return folded;
}

/// Kronecker product, first axis slowest.
Eigen::VectorXd product(const std::vector<Eigen::VectorXd>& factors) {
  Eigen::VectorXd result = Eigen::VectorXd::Ones(1);
  for (const Eigen::VectorXd& factor : factors) {
    Eigen::VectorXd next(result.size() * factor.size());
    for (Eigen::Index i = 0; i < result.size(); ++i) {
      next.segment(i * factor.size(), factor.size()) = result(i) * factor;
    }
    result = std::move(next);
  }
  return result;
}

std::vector<GridAxis> tool_grid(const mesh::Machine& machine) {
  std::vector<GridAxis> grid;
  for (std::size_t i = 0; i < machine.workspace.axes.size(); ++i) {
    grid.push_back({machine.axis_index(machine.workspace.axes[i]), machine.workspace.positions[i]});
  }
  return grid;
}

/// Axes of the workspace that move the body which carries the table. The table's own rotary axis is
/// none of them: tcp_error turns the table by it.
std::vector<GridAxis> table_grid(const mesh::Machine& machine) {
  std::vector<std::string> moving;
  int body = machine.body_index(machine.tcp.table_body);
  if (body >= 0) {
    const mesh::BodySpec& table = machine.bodies[static_cast<std::size_t>(body)];
    const int own = table.axis.empty() ? -1 : machine.axis_index(table.axis);
    const bool turns = own >= 0 && machine.axes[static_cast<std::size_t>(own)].kind == mesh::AxisKind::rotary;
    if (turns) body = machine.body_index(table.parent);
  }
  for (; body >= 0; body = machine.body_index(machine.bodies[static_cast<std::size_t>(body)].parent)) {
    const std::string& axis = machine.bodies[static_cast<std::size_t>(body)].axis;
    if (!axis.empty()) moving.push_back(axis);
  }
  const auto moves_table = [&](const std::string& axis) {
    return std::find(moving.begin(), moving.end(), axis) != moving.end();
  };
  std::vector<GridAxis> grid;
  const mesh::Workspace& workspace = machine.workspace;
  for (std::size_t i = 0; i < workspace.axes.size(); ++i) {
    if (!moves_table(workspace.axes[i])) continue;
    grid.push_back({machine.axis_index(workspace.axes[i]), workspace.positions[i]});
  }
  for (std::size_t i = 0; i < workspace.table_axes.size(); ++i) {
    if (!moves_table(workspace.table_axes[i])) continue;
    grid.push_back({machine.axis_index(workspace.table_axes[i]), workspace.table_positions[i]});
  }
  return grid;
}

/// Smooth along linear axes, straight lines between the angles of rotary ones.
Eigen::VectorXd weights_on(const std::vector<GridAxis>& grid, const mesh::Machine& machine,
                           const mesh::Pose& pose) {
  std::vector<Eigen::VectorXd> factors;
  for (const GridAxis& on : grid) {
    const mesh::Axis& axis = machine.axes[static_cast<std::size_t>(on.axis)];
    const double x = pose(on.axis);
    factors.push_back(axis.endless                           ? endless_weights(on.positions, x)
                      : axis.kind == mesh::AxisKind::linear ? smooth_weights(on.positions, x)
                                                            : linear_weights(on.positions, x));
  }
  return product(factors);
}

/// Rows between the stored ones, times one state or several.
template <int components, class States>
auto combine(const std::vector<Eigen::MatrixXd>& rows, const Eigen::VectorXd& weights, const States& state) {
  Eigen::Matrix<double, components, States::ColsAtCompileTime> sum =
      Eigen::Matrix<double, components, States::ColsAtCompileTime>::Zero(components, state.cols());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double weight = weights(static_cast<Eigen::Index>(i));
    if (weight != 0.0) sum.noalias() += weight * (rows[i] * state);
  }
  return sum;
}

}  // namespace

Eigen::VectorXd pose_weights(const mesh::Machine& machine, const mesh::Pose& pose) {
  return weights_on(tool_grid(machine), machine, pose);
}

Eigen::VectorXd table_weights(const mesh::Machine& machine, const mesh::Pose& pose) {
  return weights_on(table_grid(machine), machine, pose);
}

std::vector<mesh::Pose> table_poses(const mesh::Machine& machine) {
  std::vector<mesh::Pose> poses{mesh::home_pose(machine)};
  for (const GridAxis& axis : table_grid(machine)) {
    std::vector<mesh::Pose> next;
    for (const mesh::Pose& pose : poses) {
      for (const double position : axis.positions) {
        next.push_back(pose);
        next.back()(axis.axis) = position;
      }
    }
    poses = std::move(next);
  }
  return poses;
}

solver::TcpError ReducedModel::tcp(const Eigen::VectorXd& state, const mesh::Pose& pose) const {
  assert(state.size() == system.order());
  const Eigen::VectorXd tool_shares = pose_weights(machine, pose);
  const Eigen::VectorXd table_shares = table_weights(machine, pose);
  assert(tool_shares.size() == static_cast<Eigen::Index>(outputs.tool.size()));
  assert(table_shares.size() == static_cast<Eigen::Index>(outputs.table_axis.size()));
  return solver::tcp_error(machine, pose, combine<6>(outputs.tool, tool_shares, state),
                           combine<6>(outputs.table_axis, table_shares, state),
                           combine<7>(outputs.table_own, table_shares, state));
}

Eigen::MatrixXd side_rows(const mesh::Machine& machine, const ReducedOutputs& outputs, const mesh::Pose& pose) {
  const Eigen::Index r = outputs.tool.front().cols();
  const Eigen::VectorXd tool = pose_weights(machine, pose), table = table_weights(machine, pose);
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(19, r);
  for (std::size_t i = 0; i < outputs.tool.size(); ++i) rows.topRows<6>() += tool(static_cast<Eigen::Index>(i)) * outputs.tool[i];
  for (std::size_t i = 0; i < outputs.table_axis.size(); ++i) {
    rows.middleRows<6>(6) += table(static_cast<Eigen::Index>(i)) * outputs.table_axis[i];
    rows.bottomRows<7>() += table(static_cast<Eigen::Index>(i)) * outputs.table_own[i];
  }
  return rows;
}

Eigen::MatrixXd value_rows(const ReducedModel& model, const std::vector<mesh::Pose>& poses) {
  const Eigen::Index r = model.system.order();
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(r, r);
  Eigen::MatrixXd rows;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Eigen::VectorXd tool_shares = pose_weights(model.machine, poses[i]), table_shares = table_weights(model.machine, poses[i]);
    const auto tool = combine<6>(model.outputs.tool, tool_shares, identity);
    const auto axis = combine<6>(model.outputs.table_axis, table_shares, identity);
    const auto own = combine<7>(model.outputs.table_own, table_shares, identity);
    for (Eigen::Index k = 0; k < r; ++k) {
      const Eigen::VectorXd values = solver::tcp_values(solver::tcp_error(model.machine, poses[i], tool.col(k), axis.col(k), own.col(k)));
      if (rows.size() == 0) rows.resize(values.size() * static_cast<Eigen::Index>(poses.size()), r);
      rows.col(k).segment(static_cast<Eigen::Index>(i) * values.size(), values.size()) = values;
    }
  }
  return rows;
}

}  // namespace thermotwin::reduction
