// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The deformation of a table's surface from heights at points of it: the plane, which is Z0T, A0T and B0T of the table,
// and modes of bending. In the table's frame with z along its normal, rho = r / R and phi from x,
//   h = Z0T + A0T y - B0T x + dome (rho^2 - 1/2) + saddle rho^2 cos 2 phi + twist rho^2 sin 2 phi
//     + (coma_x cos phi + coma_y sin phi) (3 rho^3 - 2 rho) + (trefoil_x cos 3 phi + trefoil_y sin 3 phi) rho^3.
// These are Zernike's polynomials, normal to each other on the disc of the radius R; dome is the height of the rim
// above the centre, the others are amplitudes at the rim. Each cycle is solved by least squares. A mode that has the
// same effect on all points as others has no value; a cycle whose points lie on a line determines no plane.
// A folder has surface.toml (docs/reference/surface.md) and points.csv: time_s, cycle, x_mm, y_mm, height_um.

#include <Eigen/Core>

#include <filesystem>
#include <string>
#include <vector>

#include "core/key_table.h"
#include "core/table.h"
#include "metrology/fit/estimates.h"

namespace thermotwin::metrology {

struct SurfaceCycle {
  std::string place;       ///< "points.csv cycle 3"
  double time = 0;         ///< s, middle
  Eigen::MatrixX2d at;     ///< (points x 2) m, table frame
  Eigen::VectorXd height;  ///< (points) m
};

struct SurfaceRecord {
  std::string source;   ///< surface.toml
  double radius = 0.3;  ///< m, R
  int order = 2;        ///< 1: plane; 2: dome, saddle, twist; 3: coma, trefoil
  double std = 0;       ///< m, of a height
  bool against_first = true;
  bool alone = false;  ///< one cycle: as measured, whatever the file says
  std::string pose;    ///< of the machine
  std::vector<SurfaceCycle> cycles;

  /// @throws InputError: an unknown key or column, a missing height, time or cycles that run back, a point beyond the
  ///   radius, no points
  static SurfaceRecord load(const std::filesystem::path& folder);
  static SurfaceRecord parse(const std::string& toml, const core::Table& points, const std::string& source);
};

const core::KeyTable& surface_keys();

/// @throws InputError: fewer points than modes, points on a line
Estimates analyse(const SurfaceRecord& record);

/// Values of the modes up to an order at a point, (modes); the plane first. @param at  m
Eigen::VectorXd surface_modes(const Eigen::Vector2d& at, double radius, int order);

/// The fitted surface on a square grid over the disc: time_s, cycle, x_mm, y_mm, height_um, bending_um (without the
/// plane); modes that are not observable count as 0. @param steps  from the centre to the rim
core::Table surface_map(const SurfaceRecord& record, const Estimates& estimates, int steps);

/// The points themselves: time_s, cycle, x_mm, y_mm, height_um, residual_um of the cycle's own fit.
core::Table surface_points(const SurfaceRecord& record, const Estimates& estimates);

}  // namespace thermotwin::metrology
