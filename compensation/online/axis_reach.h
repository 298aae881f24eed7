// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The translations of the tool against the table that offsets of the linear axes make at a pose, and the directions
// that no linear axis moves. An error in those directions stays, however well it is predicted.

#include <Eigen/Core>

#include <string>

#include "mesh/machine/kinematics.h"

namespace thermotwin::compensation {

class AxisReach {
public:
  AxisReach(const mesh::Machine& machine, const mesh::Pose& pose);

  /// Translations that offsets (linear axes, in the order of Machine::axes) make, in their unit.
  Eigen::Vector3d motion(const Eigen::VectorXd& offsets) const { return motions_ * offsets; }
  /// The part of a translation that no linear axis moves; exactly nought where the axes move all directions.
  Eigen::Vector3d unmoved(const Eigen::Vector3d& translation) const { return unmoved_ * translation; }
  /// Those directions in words, in machine coordinates: "z (dz)", "y (dy) and z (dz)"; empty: there are none.
  const std::string& unmoved_directions() const { return words_; }

private:
  Eigen::Matrix3Xd motions_;
  Eigen::Matrix3d unmoved_;  ///< projector
  std::string words_;
};

}  // namespace thermotwin::compensation
