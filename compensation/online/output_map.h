// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Maps reduced states to axis offsets at any pose, fast enough for every row of a control. The outputs of all stored
// poses are computed once per step; a row then costs its grid weights and the rigid motion of the table. Offsets cancel
// the TCP error: with a_i the motion of the tool against the table per unit of linear axis i, sum_i a_i offset_i =
// -error (least squares for fewer than three linear axes). Variances are computed on the workspace grid, at table
// angles 0 and 90 deg, and interpolated.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "mesh/machine/kinematics.h"
#include "reduction/model/output_grid.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::compensation {

class OutputMap {
public:
  /// @param model  must outlive the map
  explicit OutputMap(const reduction::ReducedModel& model);

  /// Outputs of one state at all stored poses.
  struct Projected {
    Eigen::MatrixXd tool, axis, own;  ///< (6 x tool poses), (6 x table poses), (7 x table poses)
  };
  void project(const Eigen::VectorXd& state, Projected& out) const;

  /// TCP error of base + share * change at the pose.
  solver::TcpError tcp(const Projected& base, const Projected& change, double share, const mesh::Pose& pose) const;

  /// Rows of the three translations at a pose, tool side and table side apart, each (3 x order):
  /// error = (tool + table) * state.
  void rows(const mesh::Pose& pose, Eigen::Matrix3Xd& tool, Eigen::Matrix3Xd& table) const;

  /// Names of the linear axes.
  const std::vector<std::string>& axes() const { return axes_; }
  /// (axes) offsets in m that cancel the error
  Eigen::VectorXd offsets(const solver::TcpError& error) const { return to_axes_ * error.error.head<3>(); }
  /// Translations of the tool against the table that offsets of the axes make, in their unit.
  Eigen::Vector3d motion(const Eigen::VectorXd& offsets) const { return motions_ * offsets; }

  /// The workspace grid with the table's own axis at 0 and 90 deg, and the offsets (axes x poses) in m of a state
  /// there.
  const std::vector<mesh::Pose>& workspace_poses() const { return workspace_poses_; }
  Eigen::MatrixXd workspace_offsets(const Eigen::VectorXd& state) const;

  /// @return whether an axis stands outside the workspace of the model
  bool outside(const mesh::Pose& pose) const;

  /// Covariance of the state as directions * covariance * directions^T.
  void set_covariance(const Eigen::MatrixXd& directions, const Eigen::MatrixXd& covariance);
  /// The same with uncertain shares of the tool side (x y z) and the table side, and an uncertain remainder.
  /// @param covariance  of the directions' and these nine quantities  @param present  of the state
  void set_covariance(const Eigen::MatrixXd& directions, const Eigen::MatrixXd& covariance, const Projected& present);
  /// (axes) variance of the offsets in m^2 at a pose; never below the smallest of the grid.
  Eigen::VectorXd variance(const mesh::Pose& pose) const;

private:
  void set_variance(const Eigen::MatrixXd& influence, const Eigen::MatrixXd& covariance);
  void find_travels();

  const reduction::ReducedModel& model_;
  reduction::OutputGrid grid_;
  std::vector<std::string> axes_;
  struct Travel {
    int axis;
    double low, high;
  };
  std::vector<Travel> travels_;                        ///< of axes that the workspace bounds, with some slack
  Eigen::MatrixXd to_axes_, motions_;                  ///< (axes x 3), (3 x axes)
  std::vector<Eigen::Matrix<double, 3, 19>> columns_;  ///< error of unit outputs ((tool, table, angle))
  Eigen::MatrixXd tool_, axis_, own_;                  ///< rows of all poses below each other
  Eigen::Index tool_poses_ = 0, table_poses_ = 0, grid_poses_ = 0,
               grid_tables_ = 0;  ///< stored, and those of the workspace grid
  static constexpr Eigen::Index angles = 2;
  std::vector<mesh::Pose> workspace_poses_;  ///< (tool, table, angle)
  Eigen::MatrixXd rows_;                     ///< offsets on the workspace grid: ((tool, table, angle, axis) x order)
  Eigen::MatrixXd variance_;                 ///< (axes x (tool, table)), mean over the angles
  Eigen::VectorXd smallest_;
};

}  // namespace thermotwin::compensation
