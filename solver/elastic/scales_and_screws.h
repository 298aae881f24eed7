// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What fixes the position of a linear axis. A scale: the head stands where the tape under it is. A screw
// with the motor's encoder: the nut stands where the screw's own expansion from its fixed bearing A puts
// it, u_nut = u_A + e(A, nut), e the integral of alpha T along the screw. A screw stretched to a second
// bearing B pulls at both, N = (u_B - u_A - e(A, B)) / F on top of its pretension, F its own and the
// bearings' compliance, and the nut stands at u_A + e(A, nut) + r (u_B - u_A - e(A, B)), r the share of F
// from A to the nut: with stiff bearings an even expansion moves nothing until the pretension is used up,
// where the linear equation ends (ElasticModel::screw_tensions).

#include <Eigen/Core>

#include <array>
#include <optional>
#include <vector>

#include "mesh/machine/kinematics.h"
#include "mesh/machine_mesh.h"
#include "solver/elastic/spring.h"

namespace thermotwin::solver {

/// A linear scale, or a screw whose motor has the encoder or that is stretched between two bearings.
struct AxisFeedback {
  /// Adds to units what it needs. @param index  into Machine::scales
  /// @throws InputError: a tape that is not along its axis, an inelastic body
  static AxisFeedback of_scale(const mesh::MachineMesh& mesh, int index, UnitFunctionals& units);
  /// @param index  into Machine::screws  @return nothing: it neither holds its axis nor pulls at two bearings
  static std::optional<AxisFeedback> of_screw(const mesh::MachineMesh& mesh, int index, UnitFunctionals& units);

  void append(const mesh::Machine& machine, const mesh::Pose& pose, std::vector<Spring>& springs) const;

  /// Temperature along a tape or screw: the mean over points of its skin, linear between stations.
  struct Station {
    double at;
    std::vector<SkinPoint> points;
  };
  /// Mean displacement of points of a body's skin along the axis, carried to the line of the tape.
  struct End {
    int body = -1, unit = -1;
    std::array<int, 3> rotation{-1, -1, -1};            ///< units of the body's mean rotation
    Eigen::Vector3d bracket = Eigen::Vector3d::Zero();  ///< m, times the rotation
  };
  int carrier, head;
  Eigen::Vector3d direction, start, fixed, head_point;
  double expansion;
  bool constrains = true;                         ///< holds the axis; false: a stretched screw under a scale
  End fixed_end, head_end, far_end;               ///< far_end: of a screw that is stretched between two bearings
  int body = -1;                                  ///< whose temperature counts: the carrier's, or the screw's
  int scale = -1, screw = -1;                     ///< index into Machine::scales or screws, whichever it is
  double far = 0;                                 ///< m along direction from the fixed end to the far one
  double compliance = 0, bearing_compliance = 0;  ///< 1/N of the screw a metre; m/N of one bearing
  std::vector<Station> stations;                  ///< along direction from start, m, rising
};

}  // namespace thermotwin::solver
