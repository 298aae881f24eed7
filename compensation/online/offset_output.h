// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Computes the offsets of a row from the corrected state x, its change over the last step, and the share a of a step by
// which the row is ahead (state_clock.h). Side s of the error, tool or table, is y_s = C_s(pose) (x + a change). With
// the corrections by probing (shares d_s, remainder r, see error_model.h)
//   error = (1 + d_tool) y_tool - (1 + d_table) y_table + r,   sum_i a_i offset_i = -error  (output_map.h),
//   std^2 = var(offset) + (c offset)^2 + e^2 + k^2,
// where var follows from the observer's covariance, c is a share for quantities that it does not estimate, e is the
// stated error of the reduced model, and k is the part that the guard (offset_guard.h) holds back.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "compensation/online/compensator.h"
#include "compensation/online/error_model.h"
#include "compensation/online/offset_guard.h"
#include "compensation/online/offset_limits.h"
#include "compensation/online/output_map.h"

namespace thermotwin::compensation {

class OffsetOutput {
public:
  /// @param model  must outlive it
  OffsetOutput(const reduction::ReducedModel& model, const CompensatorOptions& options);

  const OutputMap& map() const { return map_; }
  const OffsetLimits& limits() const { return limits_; }
  double model_error() const { return model_error_; }  ///< m, of the reduced against the full model

  void set_state(const Eigen::VectorXd& corrected) { map_.project(corrected, base_); }
  void set_change(const Eigen::VectorXd& change) { map_.project(change, slope_); }
  /// Prepares outputs and variances for the present state.
  void set_covariance(const ErrorModel& errors);

  /// @return the TCP error without the guard  @param ahead  a
  solver::TcpError tcp(const ErrorModel& errors, double ahead, const mesh::Pose& pose) const;
  /// (axes) standard deviation of the offsets at a pose, um, without what the guard keeps back.
  Eigen::VectorXd std_um(const ErrorModel& errors, double ahead, const mesh::Pose& pose) const {
    return deviation_um(errors, map_.offsets(tcp(errors, ahead, pose)), pose);
  }

  /// The condition of a row, for its status.
  struct RowCondition {
    bool input_missing, no_sensors;
    const std::string &failed_sensors, &failed_inputs;
  };
  const Offsets& write(double time, const mesh::Pose& pose, const ErrorModel& errors, double ahead,
                       const RowCondition& condition);

private:
  Eigen::VectorXd deviation_um(const ErrorModel& errors, const Eigen::VectorXd& offset, const mesh::Pose& pose) const;

  OutputMap map_;
  OffsetLimits limits_;
  OffsetGuard guard_;
  double model_error_ = 0;
  OutputMap::Projected base_, slope_;
  Offsets offsets_;
  bool started_ = false;
  mesh::Pose last_pose_;
};

}  // namespace thermotwin::compensation
