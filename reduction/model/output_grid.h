// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The poses at which output rows are stored, and their interpolation.
//
// Tool side: rows are stored on the workspace grid and interpolated quadratically. For each linear axis with three
// positions they are also stored on lines along that axis, at three more poses in each half. These lines run where all
// other axes are at an end of their range. If all axes have a middle position, lines also run through it. The
// difference between the piecewise cubic through nine positions and the quadratic through three is blended across the
// workspace, linearly between outer lines and quadratically towards the middle one, and added to the interpolant of the
// grid. This Boolean sum (W. J. Gordon 1971) is exact at all stored poses, for quadratics, and for a cubic of each axis
// that is linear in the others.
//
// Table side: rows are stored on the grid of the axes that carry the table. A tilt axis that is not endless has more
// angles, at most six degrees apart. Interpolation in an angle is by sine and cosine.

#include <Eigen/Core>

#include <array>
#include <vector>

#include "mesh/machine/kinematics.h"
#include "mesh/machine_mesh.h"
#include "solver/operation/grid_occupancy.h"

namespace thermotwin::reduction {

class OutputGrid {
public:
  struct GridAxis {
    int axis = -1;  ///< index into Machine::axes
    std::vector<double> positions;
    bool linear = true, endless = false;
  };
  /// A line of the grid along an axis of three positions, all others at their first or last one, or all in the middle.
  struct Line {
    std::size_t axis = 0;                   ///< of the grid
    std::vector<std::size_t> at;            ///< (axes of the grid) indices of the positions of the other axes
    std::array<Eigen::Index, 3> on_grid{};  ///< poses of the grid at its first, middle and last position
  };

  /// The grid of a new model: the workspace grid and the lines.
  explicit OutputGrid(const mesh::Machine& machine);
  /// The grid of an existing model. @param stored  number of its tool poses: those of the workspace grid, with or
  ///   without those of the lines  @throws SolverError for any other number
  OutputGrid(const mesh::Machine& machine, std::size_t stored);
  /// @return whether a model of this machine can have this number of tool poses
  static bool can_store(const mesh::Machine& machine, std::size_t tool_poses);

  /// @return the workspace grid, then the further poses on the lines; vmc5 has 117 poses
  const std::vector<mesh::Pose>& tool_poses() const { return tool_poses_; }
  /// @return the grid of the axes that carry the table, tilts at more angles than in the workspace; table axis at home
  const std::vector<mesh::Pose>& table_poses() const { return table_poses_; }

  std::size_t grid_count() const { return grid_count_; }
  std::size_t tool_count() const { return tool_count_; }
  std::size_t table_count() const { return table_count_; }

  /// Computes the weights of the stored tool poses at a pose, (tool_count).
  void tool_weights(const mesh::Pose& pose, Eigen::VectorXd& weights) const;
  /// Computes the weights of the workspace grid alone, without its lines, (grid_count).
  void grid_weights(const mesh::Pose& pose, Eigen::VectorXd& weights) const;
  /// Computes the weights of the stored table poses at a pose, (table_count).
  void table_weights(const mesh::Pose& pose, Eigen::VectorXd& weights) const;
  /// @return the indices of table_poses() with the angles of the workspace; below, the weights of these alone
  const std::vector<std::size_t>& table_grid_places() const { return table_grid_; }
  void table_grid_weights(const mesh::Pose& pose, Eigen::VectorXd& weights) const;

  // What the weights are made from.
  const std::vector<GridAxis>& tool_axes() const { return tool_; }
  const std::vector<GridAxis>& stored_table_axes() const { return stored_table_; }
  const std::vector<Line>& lines() const { return lines_; }
  const std::vector<std::vector<double>>& line_positions() const { return fine_; }  ///< (axes of the grid) along a line
  bool has_middle() const { return has_middle_; }  ///< whether lines run through the middle

private:
  static std::vector<GridAxis> tool_grid(const mesh::Machine& machine);
  static std::vector<GridAxis> table_grid(const mesh::Machine& machine);
  /// Whether all axes have a middle: then there are lines through it.
  static bool with_middle(const std::vector<GridAxis>& grid);
  static std::vector<Line> lines_of(const std::vector<GridAxis>& grid);
  static void weights_on(const std::vector<GridAxis>& grid, const mesh::Pose& pose, Eigen::VectorXd& weights);
  enum class Lines { none, all };
  OutputGrid(const mesh::Machine& machine, Lines lines);
  double line_share(const Line& line, const mesh::Pose& pose, const std::vector<Eigen::Vector3d>& smooth) const;

  std::vector<GridAxis> tool_, table_,
      stored_table_;  ///< table_ with the workspace's own angles, and with all that are stored
  std::vector<Line> lines_;
  std::vector<std::vector<double>> fine_;  ///< (axes of the grid) all positions of a line along it
  bool has_middle_ = false;
  std::vector<mesh::Pose> tool_poses_, table_poses_;
  std::vector<std::size_t> table_grid_;
  std::size_t grid_count_ = 0, tool_count_ = 0, table_count_ = 0;
};

Eigen::VectorXd table_weights(const mesh::Machine& machine, const mesh::Pose& pose);

}  // namespace thermotwin::reduction
