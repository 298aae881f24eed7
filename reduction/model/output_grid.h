// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Where output rows are stored and how they are interpolated. The tool side's: at the workspace grid, quadratic in
// between; and, for each linear axis of three positions, on the lines along it with all other axes at an end of
// theirs, and on that through the middle where all axes have one, at three poses more in each half. The difference of
// the piecewise cubic through nine and the quadratic through three positions, between the outer lines straight and
// towards the
// middle one as quadratics go, is added to the grid's interpolant: a Boolean sum (W. J. Gordon 1971), exact at all
// stored poses, for quadratics, and for a cubic of each axis that is linear in the others. The table
// side's: on the grid of the axes that carry the table, a tilt axis that is not endless at angles between its own too,
// six degrees apart at most; by sine and cosine in between.

#include <Eigen/Core>

#include <array>
#include <vector>

#include "mesh/machine/kinematics.h"
#include "mesh/machine_mesh.h"
#include "solver/operation/grid_occupancy.h"

namespace thermotwin::reduction {

class OutputGrid {
public:
  /// With lines.
  explicit OutputGrid(const mesh::Machine& machine);
  /// @param stored  tool poses that a model has: those of the grid alone, or with the lines'
  /// @throws SolverError for any other number
  OutputGrid(const mesh::Machine& machine, std::size_t stored);
  /// Whether a model of this machine can have as many tool poses.
  static bool can_store(const mesh::Machine& machine, std::size_t tool_poses);

  /// The workspace grid, then what lies between on the lines. 117 poses for vmc5.
  const std::vector<mesh::Pose>& tool_poses() const { return tool_poses_; }
  /// The grid of the axes that carry the table, tilts at more angles than the workspace's; its own rotary axis at home.
  const std::vector<mesh::Pose>& table_poses() const { return table_poses_; }

  std::size_t grid_count() const { return grid_count_; }
  std::size_t tool_count() const { return tool_count_; }
  std::size_t table_count() const { return table_count_; }

  /// Weights of the stored tool poses at a pose. (tool_count)
  void tool_weights(const mesh::Pose& pose, Eigen::VectorXd& weights) const;
  /// Of the workspace grid alone, without its lines. (grid_count)
  void grid_weights(const mesh::Pose& pose, Eigen::VectorXd& weights) const;
  /// (table_count)
  void table_weights(const mesh::Pose& pose, Eigen::VectorXd& weights) const;
  /// Which of table_poses() have the workspace's own angles, and weights of these alone.
  const std::vector<std::size_t>& table_grid_places() const { return table_grid_; }
  void table_grid_weights(const mesh::Pose& pose, Eigen::VectorXd& weights) const;

private:
  struct GridAxis {
    int axis = -1;  ///< index into Machine::axes
    std::vector<double> positions;
    bool linear = true, endless = false;
  };
  /// A line of the grid along an axis of three positions, all others at their first or last one, or all in the middle.
  struct Line {
    std::size_t axis = 0;                   ///< of the grid
    std::vector<std::size_t> at;            ///< (axes of the grid) which of their positions the others are at
    std::array<Eigen::Index, 3> on_grid{};  ///< where its first, middle and last position are among the grid's poses
  };

  static std::vector<GridAxis> tool_grid(const mesh::Machine& machine);
  static std::vector<GridAxis> table_grid(const mesh::Machine& machine);
  /// Whether all axes have a middle: then there are lines through it.
  static bool with_middle(const std::vector<GridAxis>& grid);
  static std::vector<Line> lines_of(const std::vector<GridAxis>& grid);
  static void weights_on(const std::vector<GridAxis>& grid, const mesh::Pose& pose, Eigen::VectorXd& weights);
  enum class Lines { none, all };
  OutputGrid(const mesh::Machine& machine, Lines lines);
  double line_share(const Line& line, const mesh::Pose& pose, const std::vector<Eigen::VectorXd>& smooth) const;

  std::vector<GridAxis> tool_, table_,
      stored_table_;  ///< table_ with the workspace's own angles, and with all that are stored
  std::vector<Line> lines_;
  std::vector<std::vector<double>> fine_;  ///< (axes of the grid) all positions of a line along it
  bool has_middle_ = false;
  std::vector<mesh::Pose> tool_poses_, table_poses_;
  std::vector<std::size_t> table_grid_;
  std::size_t grid_count_ = 0, tool_count_ = 0, table_count_ = 0;
};

/// Of the table's poses at one pose; many want an OutputGrid.
Eigen::VectorXd table_weights(const mesh::Machine& machine, const mesh::Pose& pose);

}  // namespace thermotwin::reduction
