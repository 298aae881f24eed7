// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// From reduced states to axis offsets at any pose, fast enough for every row of a control. The
// outputs of the workspace grid are formed once a step; a row then costs its grid weights and the
// rigid motion of the table. Offsets cancel the TCP error: with a_i the motion of the tool against
// the table for a unit of linear axis i, sum_i a_i offset_i = -error (least squares where the
// machine has fewer than three linear axes). Variances are formed on the grid too, at table angles
// 0 and 90 deg, and interpolated.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "reduction/reduced_model.h"

namespace thermotwin::compensation {

class OutputMap {
 public:
  /// @param model  must outlive the map
  explicit OutputMap(const reduction::ReducedModel& model);

  /// Outputs of one state at all poses of the grid.
  struct Projected {
    Eigen::MatrixXd tool, axis, own;  ///< (6 x tool poses), (6 x table poses), (7 x table poses)
  };
  void project(const Eigen::VectorXd& state, Projected& out) const;

  /// TCP error of base + share * change at the pose.
  solver::TcpError tcp(const Projected& base, const Projected& change, double share, const mesh::Pose& pose) const;

  /// Names of the linear axes.
  const std::vector<std::string>& axes() const { return axes_; }
  /// (axes) offsets in m that cancel the error
  Eigen::VectorXd offsets(const solver::TcpError& error) const { return to_axes_ * error.error.head<3>(); }

  /// Covariance of the state as directions * covariance * directions^T.
  void set_covariance(const Eigen::MatrixXd& directions, const Eigen::MatrixXd& covariance);
  /// (axes) variance of the offsets in m^2 at a pose; never below the smallest of the grid.
  Eigen::VectorXd variance(const mesh::Pose& pose) const;

 private:
  const reduction::ReducedModel& model_;
  std::vector<std::string> axes_;
  Eigen::MatrixXd to_axes_;           ///< (axes x 3)
  Eigen::MatrixXd tool_, axis_, own_; ///< rows of all poses below each other
  Eigen::Index tool_poses_ = 0, table_poses_ = 0;
  static constexpr Eigen::Index angles = 2;
  Eigen::MatrixXd rows_;              ///< offsets on the grid: ((tool, table, angle, axis) x order)
  Eigen::MatrixXd variance_;          ///< (axes x (tool, table)), mean over the angles
  Eigen::VectorXd smallest_;
};

}  // namespace thermotwin::compensation
