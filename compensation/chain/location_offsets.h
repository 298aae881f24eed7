// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Axis offsets from location errors: equations (6.1) to (6.12) of Gebhardt (2014) for any kinematic chain. A location
// error moves the parts carried by its axis as a rigid body, d + w x (p - o), in the frame of the body on which the
// axis stands. So Y0C, Z0T and A0C of a rotary table turn with the swivel axis below it. R0T stretches the table by R0T
// / r times the distance from its axis. The sum of all motions is the error of the tool against the workpiece at the
// functional point; the sum of the rotations is the error of the functional orientation. Offsets o solve
//   sum a_i o_i = -error(point),   sum b_j o_j = -error(orientation)
// in the least-squares sense: first the orientation (rotary axes), then the point (linear axes), with the shift by the
// rotary offsets included. The error that these axes cannot compensate is returned.
// The printed (6.6) and (6.7) have signs that no rigid table has (e_x turned by B goes to -sin B in z where e_z goes to
// +sin B in x; a rotation about x moves z and y in opposite senses); here the motion is rigid. The printed C is the
// shift of the coordinate system, the negative of an offset.

#include <Eigen/Core>

#include <map>
#include <string>
#include <vector>

#include "mesh/machine/kinematic_chain.h"

namespace thermotwin::compensation {

using mesh::ChainAxis;
using mesh::KinematicChain;

struct OffsetOptions {
  bool orientation = false;       ///< rotary axes may be used for the functional orientation
  std::vector<std::string> axes;  ///< ids of the axes that may move; empty: all of the chain
  double table_radius = 0.3;      ///< m, at which R0T is stated
  void validate() const;          ///< @throws InputError
};

struct AxisOffsets {
  Eigen::VectorXd offset;             ///< (axes) m or rad, in the order of axes()
  Eigen::Vector3d point_error;        ///< m, tool minus workpiece without offsets, machine frame
  Eigen::Vector3d orientation_error;  ///< rad, the same
  Eigen::Vector3d point_left;         ///< m, remaining error with the offsets
  Eigen::Vector3d orientation_left;   ///< rad, the same
};

class LocationOffsets {
public:
  /// @throws InputError for axes that the chain does not have, or a radius that is not above 0
  explicit LocationOffsets(KinematicChain chain, const OffsetOptions& options = {});

  const std::vector<std::string>& axes() const { return axes_; }
  /// Names of location errors of this chain: X0C ... C0C of each axis, X0T Y0T Z0T A0T B0T C0T R0T.
  const std::vector<std::string>& known_errors() const { return known_; }

  struct Motion {
    Eigen::Vector3d shift = Eigen::Vector3d::Zero(), turn = Eigen::Vector3d::Zero();
  };
  /// The definition of a location error: its share in the error of the tool against the workpiece at a point.
  /// @param value  m (R0T: m at the radius) or rad @param point  m, machine frame, at these positions
  /// @return m and rad, machine frame  @throws InputError for an unknown error
  Motion motion_of(const std::string& error, double value, const std::map<std::string, double>& positions,
                   const Eigen::Vector3d& point) const;

  /// @param errors     m (R0T: m at the radius) and rad by name
  /// @param positions  m and rad by axis
  /// @param functional_point  m, machine frame, at these positions
  /// @throws InputError for an unknown error
  AxisOffsets offsets(const std::map<std::string, double>& errors, const std::map<std::string, double>& positions,
                      const Eigen::Vector3d& functional_point) const;

private:
  KinematicChain chain_;
  OffsetOptions options_;
  std::vector<std::string> axes_, known_;
};

}  // namespace thermotwin::compensation
