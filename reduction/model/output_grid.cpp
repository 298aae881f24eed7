// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/model/output_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>
#include <numbers>

#include "core/error.h"
#include "mesh/machine/kinematics.h"
#include "reduction/model/axis_weights.h"
#include "reduction/model/reduced_model.h"
#include "solver/operation/grid_occupancy.h"

namespace thermotwin::reduction {
namespace {

constexpr std::size_t poses_more = 3, middle = poses_more + 1;  ///< on each half of a line; where its middle is
/// Between angles of a swivel, rad: its bearing's facets make rows ripple. 45 degrees are cut in eight.
constexpr double widest_angle = std::numbers::pi / 30.0;
constexpr std::size_t most_angles_more = 31;  ///< in one cell

/// Positions with so many more between two of them, evenly.
std::vector<double> with_more(const std::vector<double>& positions, std::size_t more) {
  std::vector<double> fine;
  for (std::size_t cell = 0; cell + 1 < positions.size(); ++cell) {
    for (std::size_t i = 0; i <= more; ++i)
      fine.push_back(std::lerp(positions[cell], positions[cell + 1], 1.0 * i / (more + 1)));
  }
  fine.push_back(positions.back());
  return fine;
}

/// Angles with others between them where they are far apart.
std::vector<double> with_angles(const std::vector<double>& angles) {
  std::vector<double> fine{angles.front()};
  for (std::size_t cell = 0; cell + 1 < angles.size(); ++cell) {
    const auto divisions = static_cast<std::size_t>(std::ceil((angles[cell + 1] - angles[cell]) / widest_angle - 1e-9));
    const std::vector<double> inside =
        with_more({angles[cell], angles[cell + 1]}, std::clamp<std::size_t>(divisions, 1, most_angles_more + 1) - 1);
    fine.insert(fine.end(), inside.begin() + 1, inside.end());
  }
  return fine;
}

/// Kronecker product with the weights of one more axis.
template <class Weights>
void spread(const Weights& own, Eigen::Index& count, Eigen::VectorXd& weights) {
  for (Eigen::Index i = count - 1; i >= 0; --i) weights.segment(i * own.size(), own.size()) = weights[i] * own;
  count *= own.size();
}

/// Rows between the stored ones, times one state or several.
template <int components, class States>
auto combine(const std::vector<Eigen::MatrixXd>& rows, const Eigen::VectorXd& weights, const States& state) {
  Eigen::Matrix<double, components, States::ColsAtCompileTime> sum =
      Eigen::Matrix<double, components, States::ColsAtCompileTime>::Zero(components, state.cols());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double weight = weights(i);
    if (weight != 0.0) sum.noalias() += weight * (rows[i] * state);
  }
  return sum;
}

}  // namespace

std::vector<OutputGrid::GridAxis> OutputGrid::tool_grid(const mesh::Machine& machine) {
  std::vector<GridAxis> grid;
  for (std::size_t i = 0; i < machine.workspace.axes.size(); ++i) {
    const int axis = machine.axis_index(machine.workspace.axes[i]);
    const mesh::Axis& moves = machine.axes[axis];
    grid.push_back({axis, machine.workspace.positions[i], moves.kind == mesh::AxisKind::linear, moves.endless});
  }
  return grid;
}

/// Axes of the workspace that move the body which carries the table. The table's own rotary axis is
/// none of them: tcp_error turns the table by it.
std::vector<OutputGrid::GridAxis> OutputGrid::table_grid(const mesh::Machine& machine) {
  std::vector<std::string> moving;
  int body = machine.body_index(machine.tcp.table_body);
  if (body >= 0) {
    const mesh::BodySpec& table = machine.bodies[body];
    const int own = table.axis.empty() ? -1 : machine.axis_index(table.axis);
    const bool turns = own >= 0 && machine.axes[own].kind == mesh::AxisKind::rotary;
    if (turns) body = machine.body_index(table.parent);
  }
  for (; body >= 0; body = machine.body_index(machine.bodies[body].parent)) {
    const std::string& axis = machine.bodies[body].axis;
    if (!axis.empty()) moving.push_back(axis);
  }
  std::vector<GridAxis> grid;
  const auto add = [&](const std::vector<std::string>& axes, const std::vector<std::vector<double>>& positions) {
    for (std::size_t i = 0; i < axes.size(); ++i) {
      if (std::find(moving.begin(), moving.end(), axes[i]) == moving.end()) continue;
      const int axis = machine.axis_index(axes[i]);
      const mesh::Axis& moves = machine.axes[axis];
      grid.push_back({axis, positions[i], moves.kind == mesh::AxisKind::linear, moves.endless});
    }
  };
  add(machine.workspace.axes, machine.workspace.positions);
  add(machine.workspace.table_axes, machine.workspace.table_positions);
  return grid;
}

bool OutputGrid::with_middle(const std::vector<GridAxis>& grid) {
  return grid.size() > 1 && std::all_of(grid.begin(), grid.end(),
                                        [](const GridAxis& on) { return on.linear && on.positions.size() == 3; });
}

std::vector<OutputGrid::Line> OutputGrid::lines_of(const std::vector<GridAxis>& grid) {
  std::vector<Line> lines;
  for (std::size_t d = 0; d < grid.size(); ++d) {
    if (grid[d].positions.size() != 3 || !grid[d].linear) continue;
    const auto add = [&](std::vector<std::size_t> at) {
      Line line{d, std::move(at), {}};
      for (std::size_t i = 0; i < 3; ++i) {
        line.at[d] = i;
        for (std::size_t k = 0; k < grid.size(); ++k)
          line.on_grid[i] = line.on_grid[i] * std::ssize(grid[k].positions) + line.at[k];
      }
      lines.push_back(std::move(line));
    };
    for (std::size_t corner = 0; corner < (std::size_t{1} << grid.size()); ++corner) {
      std::vector<std::size_t> at;
      bool new_line = true;
      for (std::size_t k = 0; k < grid.size(); ++k) {
        const bool last = (corner >> k & 1) != 0;
        new_line = new_line && !(last && (k == d || grid[k].positions.size() == 1));
        at.push_back(last ? grid[k].positions.size() - 1 : 0);
      }
      if (new_line) add(std::move(at));
    }
    if (with_middle(grid)) add(std::vector<std::size_t>(grid.size(), 1));
  }
  return lines;
}

OutputGrid::OutputGrid(const mesh::Machine& machine) : OutputGrid(machine, Lines::all) {}

OutputGrid::OutputGrid(const mesh::Machine& machine, std::size_t stored)
    : OutputGrid(machine, stored > mesh::workspace_poses(machine).size() ? Lines::all : Lines::none) {
  if (stored != tool_count_) {
    throw core::SolverError(fmt::format("{} tool poses; the workspace has {}, or {} with its lines", stored,
                                        grid_count_, OutputGrid(machine).tool_count_));
  }
}

bool OutputGrid::can_store(const mesh::Machine& machine, std::size_t tool_poses) {
  const std::size_t grid = mesh::workspace_poses(machine).size(), lines = lines_of(tool_grid(machine)).size();
  return tool_poses == grid || tool_poses == grid + 2 * poses_more * lines;
}

OutputGrid::OutputGrid(const mesh::Machine& machine, Lines lines)
    : tool_(tool_grid(machine)),
      table_(table_grid(machine)),
      has_middle_(with_middle(tool_)),
      tool_poses_(mesh::workspace_poses(machine)) {
  grid_count_ = tool_poses_.size();
  if (lines == Lines::all) lines_ = lines_of(tool_);
  fine_.resize(tool_.size());
  for (const Line& line : lines_) {
    std::vector<double>& fine = fine_[line.axis];
    if (fine.empty()) fine = with_more(tool_[line.axis].positions, poses_more);
    for (std::size_t i = 1; i + 1 < fine.size(); ++i) {
      if (i == middle) continue;
      tool_poses_.push_back(tool_poses_[line.on_grid[1]]);
      tool_poses_.back()(tool_[line.axis].axis) = fine[i];
    }
  }
  tool_count_ = tool_poses_.size();
  table_poses_ = {mesh::home_pose(machine)};
  table_grid_ = {0};
  for (const GridAxis& axis : table_) {
    std::vector<std::size_t> own;  // where the axis' own positions are among those stored
    stored_table_.push_back(axis);
    stored_table_.back().positions = axis.linear || axis.endless ? axis.positions : with_angles(axis.positions);
    const std::vector<double>& stored = stored_table_.back().positions;
    for (const double position : axis.positions)
      own.push_back(std::find(stored.begin(), stored.end(), position) - stored.begin());
    std::vector<mesh::Pose> next;
    for (const mesh::Pose& pose : table_poses_) {
      for (const double position : stored) {
        next.push_back(pose);
        next.back()(axis.axis) = position;
      }
    }
    table_poses_ = std::move(next);
    std::vector<std::size_t> places;
    for (const std::size_t place : table_grid_)
      for (const std::size_t i : own) places.push_back(place * stored.size() + i);
    table_grid_ = std::move(places);
  }
  table_count_ = table_poses_.size();
}

/// Kronecker product, first axis slowest: along linear axes smooth through three positions, a grid of more is joined by
/// straight lines, as one of two is; by sine and cosine between the angles of rotary ones.
void OutputGrid::weights_on(const std::vector<GridAxis>& grid, const mesh::Pose& pose, Eigen::VectorXd& weights) {
  weights[0] = 1.0;
  Eigen::Index count = 1;
  for (const GridAxis& on : grid) {
    const double x = pose(on.axis);
    if (!on.linear)
      spread(swivel_weights(on.positions, x, on.endless), count, weights);
    else if (on.positions.size() == 3)
      spread(quadratic_weights(on.positions, x), count, weights);
    else
      spread(linear_weights(on.positions, x), count, weights);
  }
}

void OutputGrid::grid_weights(const mesh::Pose& pose, Eigen::VectorXd& weights) const {
  weights.resize(grid_count_);
  weights_on(tool_, pose, weights);
}

void OutputGrid::table_weights(const mesh::Pose& pose, Eigen::VectorXd& weights) const {
  weights.resize(table_count_);
  weights_on(stored_table_, pose, weights);
}

void OutputGrid::table_grid_weights(const mesh::Pose& pose, Eigen::VectorXd& weights) const {
  weights.resize(std::ssize(table_grid_));
  weights_on(table_, pose, weights);
}

/// Between the outer lines straight; the middle one takes what its quadratics do, where there is one.
double OutputGrid::line_share(const Line& line, const mesh::Pose& pose,
                              const std::vector<Eigen::Vector3d>& smooth) const {
  double straight = 1.0, in_middle = 1.0, bubble = 1.0;
  bool is_middle = tool_.size() > 1;
  for (std::size_t k = 0; k < tool_.size(); ++k) {
    const std::vector<double>& positions = tool_[k].positions;
    if (k == line.axis || positions.size() == 1) continue;
    const double low = positions.front(), high = positions.back();
    is_middle = is_middle && line.at[k] == 1 && positions.size() == 3;
    const auto upper = [&](double x) { return (std::clamp(x, low, high) - low) / (high - low); };
    const auto part = [&](double share) { return line.at[k] == 0 ? 1.0 - share : share; };
    straight *= part(upper(pose(tool_[k].axis)));
    if (!has_middle_) continue;
    in_middle *= part(upper(positions[1]));
    bubble *= smooth[k](1);
  }
  if (!has_middle_) return straight;
  return is_middle ? bubble : straight - bubble * in_middle;
}

void OutputGrid::tool_weights(const mesh::Pose& pose, Eigen::VectorXd& weights) const {
  weights.setZero(tool_count_);
  weights_on(tool_, pose, weights);
  Eigen::Index next = grid_count_;
  // Lines are along axes of three positions alone.
  std::vector<Eigen::Vector3d> smooth(lines_.empty() ? 0 : tool_.size(), Eigen::Vector3d::Zero());
  for (std::size_t k = 0; k < smooth.size(); ++k)
    if (tool_[k].linear && tool_[k].positions.size() == 3)
      smooth[k] = quadratic_weights(tool_[k].positions, pose(tool_[k].axis));
  Cubic fine;
  for (std::size_t l = 0; l < lines_.size(); ++l) {
    const Line& line = lines_[l];
    if (l == 0 || lines_[l - 1].axis != line.axis) fine = cubic_weights(fine_[line.axis], pose(tool_[line.axis].axis));
    const double share = line_share(line, pose, smooth);
    const Eigen::Vector3d& coarse = smooth[line.axis];
    for (std::size_t i = 0; i < 3; ++i) weights(line.on_grid[i]) -= share * coarse(i);
    for (std::size_t i = 0; i < 4; ++i) {
      const std::size_t at = fine.first + i;
      const bool on_grid = at % middle == 0;
      weights(on_grid ? line.on_grid[at / middle] : next + (at < middle ? at - 1 : at - 2)) += share * fine.weights[i];
    }
    next += 2 * poses_more;
  }
}

Eigen::VectorXd table_weights(const mesh::Machine& machine, const mesh::Pose& pose) {
  Eigen::VectorXd weights;
  OutputGrid(machine).table_weights(pose, weights);
  return weights;
}

solver::TcpError ReducedModel::tcp(const Eigen::VectorXd& state, const mesh::Pose& pose) const {
  assert(state.size() == system.order());
  const OutputGrid grid(machine, outputs.tool.size());
  Eigen::VectorXd tool_shares, table_shares;
  grid.tool_weights(pose, tool_shares);
  grid.table_weights(pose, table_shares);
  assert(tool_shares.size() == std::ssize(outputs.tool));
  assert(table_shares.size() == std::ssize(outputs.table_axis));
  return solver::tcp_error(machine, pose, combine<6>(outputs.tool, tool_shares, state),
                           combine<6>(outputs.table_axis, table_shares, state),
                           combine<7>(outputs.table_own, table_shares, state));
}

Eigen::MatrixXd side_rows(const mesh::Machine& machine, const ReducedOutputs& outputs, const mesh::Pose& pose) {
  const Eigen::Index r = outputs.tool.front().cols();
  const OutputGrid grid(machine, outputs.tool.size());
  Eigen::VectorXd tool, table;
  grid.tool_weights(pose, tool);
  grid.table_weights(pose, table);
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(19, r);
  for (std::size_t i = 0; i < outputs.tool.size(); ++i) rows.topRows<6>() += tool(i) * outputs.tool[i];
  for (std::size_t i = 0; i < outputs.table_axis.size(); ++i) {
    rows.middleRows<6>(6) += table(i) * outputs.table_axis[i];
    rows.bottomRows<7>() += table(i) * outputs.table_own[i];
  }
  return rows;
}

Eigen::MatrixXd value_rows(const ReducedModel& model, const std::vector<mesh::Pose>& poses) {
  const Eigen::Index r = model.system.order();
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(r, r);
  const OutputGrid grid(model.machine, model.outputs.tool.size());
  Eigen::VectorXd tool_shares, table_shares;
  Eigen::MatrixXd rows;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    grid.tool_weights(poses[i], tool_shares);
    grid.table_weights(poses[i], table_shares);
    const auto tool = combine<6>(model.outputs.tool, tool_shares, identity);
    const auto axis = combine<6>(model.outputs.table_axis, table_shares, identity);
    const auto own = combine<7>(model.outputs.table_own, table_shares, identity);
    for (Eigen::Index k = 0; k < r; ++k) {
      const Eigen::VectorXd values =
          solver::tcp_values(solver::tcp_error(model.machine, poses[i], tool.col(k), axis.col(k), own.col(k)));
      if (rows.size() == 0) rows.resize(values.size() * std::ssize(poses), r);
      rows.col(k).segment(static_cast<Eigen::Index>(i) * values.size(), values.size()) = values;
    }
  }
  return rows;
}

}  // namespace thermotwin::reduction
