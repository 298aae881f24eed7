// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Displacement probes around a sphere (Gebhardt 2014, 4.1 to 4.3). A probe with a flat tip reads u . s, with u the unit
// direction in which it measures, towards the sphere, and s the displacement of the sphere's centre. A tip and a sphere
// whose radii add up to rho touch elsewhere as the sphere moves across:
//   m = u . s + rho - sqrt(rho^2 - |s - u u.s|^2).
// A calibration moves the sphere by known displacements D, +-2 mm along each axis, and solves (M - mean) T = D - mean
// in the least-squares sense, M the readings less what the contact adds.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "core/table.h"

namespace thermotwin::metrology {

/// Three probes that are normal to each other, at equal angles to the tool's axis z: columns are unit vectors.
Eigen::Matrix3Xd tripod();

/// @param directions  (3 x n) unit @param contact_radius  m; 0: flat @return (n) readings, m
Eigen::VectorXd probe_readings(const Eigen::Matrix3Xd& directions, double contact_radius,
                               const Eigen::Vector3d& displacement);

/// Smallest singular value of the directions over the largest, below which an arrangement is refused.
inline constexpr double flattest = 0.05;
/// @throws InputError (place): fewer than three probes, or nearly in one plane
void require_spatial(const Eigen::Matrix3Xd& directions, const std::string& place);

class Calibration {
public:
  /// @param table  x_mm, y_mm, z_mm and a column for each probe, in um @throws InputError: a missing column or value,
  ///   fewer than four rows, displacements or probes that do not span space; with a contact radius a table without a
  ///   row at 0, 0, 0
  static Calibration fit(const core::Table& table, double contact_radius);

  Eigen::Index probes() const { return transform_.rows(); }
  const std::vector<std::string>& names() const { return names_; }  ///< columns of the probes, "P1_um"
  const Eigen::MatrixXd& transform() const { return transform_; }   ///< (n x 3), s = T^T m
  /// @param readings  (n) m, against the zero of the calibration @return m
  Eigen::Vector3d displacement(const Eigen::VectorXd& readings) const;
  double residual_rms() const { return residual_rms_; }  ///< m, of a coordinate
  /// (3 x n) reading per displacement of each probe: its direction, of length 1 where the probe reads true
  const Eigen::Matrix3Xd& directions() const { return directions_; }
  const Eigen::VectorXd& zero() const { return zero_; }  ///< (n) m, readings at the displacement 0
  double way() const { return way_; }                    ///< m, largest coordinate of a displacement

private:
  std::vector<std::string> names_;
  Eigen::MatrixXd transform_;
  Eigen::Matrix3Xd directions_;
  Eigen::VectorXd zero_;  ///< (n) m, readings at the displacement 0
  double contact_radius_ = 0, residual_rms_ = 0, way_ = 0;
};

}  // namespace thermotwin::metrology
