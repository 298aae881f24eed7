// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The reduced model of the machine beside the models that are fitted.

#include <string>
#include <vector>

#include "compensation/evaluation/scoring.h"
#include "compensation/measurement/measurement.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::compensation {

void score_reduced_model(const Measurement& measurement, const reduction::ReducedModel& model, const std::string& name,
                         bool with_sensors, Scorer& scorer);

/// A displacement channel's quantity as a linear functional of TCP errors. A component dx ... rc is that of the error
/// at the channel's pose. A location error X0C ... is the rigid motion of what the axis carries, the table or the tool
/// alone, at the axis' own point and in the frame of the body on which the axis stands; with T it is that of the table
/// at tcp.table_point, in the frame of the table's carrier. R0T is the growth at tcp.table_radius; it takes part in no
/// other location error. Growth follows from the errors beside the pose, moved along a linear axis. A channel with
/// points is their weighted sum instead, of the tool against the table, as a test between both makes it.
class ObservedQuantity {
public:
  /// @param machine  must outlive the object  @throws InputError for a quantity that the machine does not have
  ObservedQuantity(const mesh::Machine& machine, const MeasuredChannel& channel, const mesh::Pose& pose);

  /// Where the errors are needed: the channel's points; else its pose, then up to two beside it.
  const std::vector<mesh::Pose>& poses() const { return poses_; }
  /// @param errors  (poses) at one time @return um or um/m
  double operator()(const std::vector<solver::TcpError>& errors) const;

private:
  void place_beside(const mesh::Pose& pose);

  const mesh::Machine& machine_;
  std::vector<mesh::Pose> poses_;
  int component_ = 0;                     ///< 0 to 5; 6: R0T
  std::vector<Eigen::Vector3d> weights_;  ///< (poses) of a channel with points
  bool located_ = false;                  ///< a location error
  bool table_side_ = false;               ///< of what carries the workpiece
  Eigen::Matrix3d to_frame_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d arm_ = Eigen::Vector3d::Zero();     ///< m, from the point of the error to the tool, machine frame
  Eigen::Vector3d radial_ = Eigen::Vector3d::Zero();  ///< m, from the table's axis to the tool, normal to it
  Eigen::Vector3d way_ = Eigen::Vector3d::Zero();     ///< m, over the table between both poses beside
  Eigen::Vector3d table_axis_ = Eigen::Vector3d::UnitZ();
};

}  // namespace thermotwin::compensation
