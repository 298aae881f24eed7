// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

#include "reduction/output_grid.h"
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

/// Cubic through the four positions about x of more than three: the joints' pads make rows kink.
Eigen::VectorXd cubic_weights(const std::vector<double>& positions, double x) {
  const std::size_t n = positions.size();
  const double t = std::clamp(x, positions.front(), positions.back());
  std::size_t cell = 0;
  while (cell + 2 < n && t > positions[cell + 1]) ++cell;
  const std::size_t first = std::min(cell == 0 ? 0 : cell - 1, n - 4);
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(n));
  for (std::size_t i = first; i < first + 4; ++i) {
    double product = 1.0;
    for (std::size_t j = first; j < first + 4; ++j)
      if (j != i) product *= (t - positions[j]) / (positions[i] - positions[j]);
    weights(static_cast<Eigen::Index>(i)) = product;
  }
  return weights;
}

/// Exact for 1, cos and sin through three angles (trigonometric Lagrange polynomials): what stands still in the
/// machine turns in a swivel's own frame.
Eigen::Vector3d turning_weights(const std::array<double, 3>& at, double x) {
  const auto half = [](double angle) { return std::sin(0.5 * angle); };
  Eigen::Vector3d weights;
  for (std::size_t i = 0; i < 3; ++i) {
    const double a = at[(i + 1) % 3], b = at[(i + 2) % 3];
    weights(static_cast<Eigen::Index>(i)) = half(x - a) * half(x - b) / (half(at[i] - a) * half(at[i] - b));
  }
  return weights;
}

/// Angles of a swivel: by the cell's ends and the position before them (after them in the first cell), so that rows
/// are continuous; one or two positions by straight lines.
Eigen::VectorXd swivel_weights(const std::vector<double>& positions, double x, bool endless) {
  constexpr double turn = 2.0 * std::numbers::pi;
  const std::size_t n = positions.size();
  if (n == 1) return Eigen::VectorXd::Ones(1);
  std::vector<double> closed = positions;
  if (endless) {
    x -= turn * std::floor((x - positions.front()) / turn);
    closed.push_back(positions.front() + turn);
  }
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(n));
  if (n == 2) {
    const Eigen::VectorXd straight = linear_weights(closed, x);
    for (Eigen::Index i = 0; i < straight.size(); ++i) weights(i % 2) += straight(i);
    return weights;
  }
  const double t = std::clamp(x, closed.front(), closed.back());
  std::size_t cell = 0;
  while (cell + 2 < closed.size() && t > closed[cell + 1]) ++cell;
  const std::size_t third = cell > 0 ? cell - 1 : endless ? n - 1 : 2;
  const std::array<std::size_t, 3> at{cell % n, (cell + 1) % n, third};
  const Eigen::Vector3d shares = turning_weights({positions[at[0]], positions[at[1]], positions[at[2]]}, t);
  for (std::size_t i = 0; i < 3; ++i) weights(static_cast<Eigen::Index>(at[i])) = shares(static_cast<Eigen::Index>(i));
  return weights;
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

/// Smooth along linear axes, by sine and cosine between the angles of rotary ones.
Eigen::VectorXd weights_on(const std::vector<GridAxis>& grid, const mesh::Machine& machine,
                           const mesh::Pose& pose) {
  std::vector<Eigen::VectorXd> factors;
  for (const GridAxis& on : grid) {
    const mesh::Axis& axis = machine.axes[static_cast<std::size_t>(on.axis)];
    const double x = pose(on.axis);
    factors.push_back(axis.kind == mesh::AxisKind::linear ? smooth_weights(on.positions, x) : swivel_weights(on.positions, x, axis.endless));
  }
  return product(factors);
}

/// A line of the grid along an axis of three positions, all others at their first or last one, with a position more in
/// each half.
struct Line {
  std::size_t axis = 0;                    ///< of the grid
  std::vector<double> positions;           ///< five
  std::vector<bool> last;                  ///< (axes of the grid) which end the others are at
  std::array<Eigen::Index, 3> on_grid{};   ///< where its first, third and fifth position are among the grid's poses
};

std::vector<Line> lines_of(const mesh::Machine& machine, const std::vector<GridAxis>& grid) {
  std::vector<Line> lines;
  for (std::size_t d = 0; d < grid.size(); ++d) {
    const std::vector<double>& three = grid[d].positions;
    if (three.size() != 3 || machine.axes[static_cast<std::size_t>(grid[d].axis)].kind != mesh::AxisKind::linear) continue;
    for (std::size_t corner = 0; corner < (std::size_t{1} << grid.size()); ++corner) {
      Line line{d, {three[0], 0.5 * (three[0] + three[1]), three[1], 0.5 * (three[1] + three[2]), three[2]}, {}, {}};
      bool new_line = true;
      for (std::size_t k = 0; k < grid.size(); ++k) {
        line.last.push_back((corner >> k & 1) != 0);
        new_line = new_line && !(line.last[k] && (k == d || grid[k].positions.size() == 1));
      }
      if (!new_line) continue;
      for (std::size_t i = 0; i < 3; ++i) {
        Eigen::Index at = 0;
        for (std::size_t k = 0; k < grid.size(); ++k) {
          const std::size_t n = grid[k].positions.size();
          at = at * static_cast<Eigen::Index>(n) + static_cast<Eigen::Index>(k == d ? i : line.last[k] ? n - 1 : 0);
        }
        line.on_grid[i] = at;
      }
      lines.push_back(std::move(line));
    }
  }
  return lines;
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

std::vector<mesh::Pose> tool_poses(const mesh::Machine& machine) {
  std::vector<mesh::Pose> poses = mesh::workspace_poses(machine);
  const std::vector<GridAxis> grid = tool_grid(machine);
  for (const Line& line : lines_of(machine, grid))
    for (const std::size_t extra : {1, 3}) {
      poses.push_back(poses[static_cast<std::size_t>(line.on_grid[1])]);
      poses.back()(grid[line.axis].axis) = line.positions[extra];
    }
  return poses;
}

Eigen::VectorXd pose_weights(const mesh::Machine& machine, const mesh::Pose& pose, std::size_t stored) {
  const std::vector<GridAxis> grid = tool_grid(machine);
  const Eigen::VectorXd on_grid = weights_on(grid, machine, pose);
  if (static_cast<Eigen::Index>(stored) == on_grid.size()) return on_grid;
  const std::vector<Line> lines = lines_of(machine, grid);
  assert(static_cast<Eigen::Index>(stored) == on_grid.size() + 2 * static_cast<Eigen::Index>(lines.size()));
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(stored));
  weights.head(on_grid.size()) = on_grid;
  Eigen::Index next = on_grid.size();
  for (const Line& line : lines) {
    const double x = pose(grid[line.axis].axis);
    double share = 1.0;  // of this line: straight between the ends of the other axes
    for (std::size_t k = 0; k < grid.size(); ++k) {
      const std::vector<double>& positions = grid[k].positions;
      if (k == line.axis || positions.size() == 1) continue;
      const Eigen::VectorXd ends = linear_weights({positions.front(), positions.back()}, pose(grid[k].axis));
      share *= ends(line.last[k] ? 1 : 0);
    }
    const Eigen::VectorXd fine = share * cubic_weights(line.positions, x), coarse = share * smooth_weights(grid[line.axis].positions, x);
    for (Eigen::Index i = 0; i < 3; ++i) weights(line.on_grid[static_cast<std::size_t>(i)]) += fine(2 * i) - coarse(i);
    weights(next++) = fine(1);
    weights(next++) = fine(3);
  }
  return weights;
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
  const Eigen::VectorXd tool_shares = pose_weights(machine, pose, outputs.tool.size());
  const Eigen::VectorXd table_shares = table_weights(machine, pose);
  assert(tool_shares.size() == static_cast<Eigen::Index>(outputs.tool.size()));
  assert(table_shares.size() == static_cast<Eigen::Index>(outputs.table_axis.size()));
  return solver::tcp_error(machine, pose, combine<6>(outputs.tool, tool_shares, state),
                           combine<6>(outputs.table_axis, table_shares, state),
                           combine<7>(outputs.table_own, table_shares, state));
}

Eigen::MatrixXd side_rows(const mesh::Machine& machine, const ReducedOutputs& outputs, const mesh::Pose& pose) {
  const Eigen::Index r = outputs.tool.front().cols();
  const Eigen::VectorXd tool = pose_weights(machine, pose, outputs.tool.size()), table = table_weights(machine, pose);
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
    const Eigen::VectorXd tool_shares = pose_weights(model.machine, poses[i], model.outputs.tool.size()), table_shares = table_weights(model.machine, poses[i]);
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
