// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Tetrahedra of a body whose surface is too faulty to be meshed: a regular lattice that is cut at the surface, which
// the winding number tells (isosurface stuffing: Labelle and Shewchuk, ACM Transactions on Graphics 26, 2007). Flat
// and round sides come out as they are; edges are chamfered, and walls thinner than the lattice are lost.

#include <Eigen/Core>

#include "mesh/surface/surface.h"

namespace thermotwin::mesh {

struct LatticeFill {
  Eigen::Matrix3Xd points;  ///< (3 x n) m
  Eigen::Matrix4Xi tets;    ///< (4 x m) positive volumes
  double volume = 0.0;      ///< m^3 of the tetrahedra
  double inside = 0.0;      ///< m^3 that the surface encloses, shells that overlap counted once; by sampling
  double ambiguous = 0.0;   ///< m^3 away from the surface whose winding number is near no whole number
  int crumbs = 0;           ///< pieces dropped since they hold less than a thousandth of the body
};

/// Lattice points that the box of the surface would need.
double lattice_points(const Surface& surface, double spacing);

/// LatticeFill::inside alone.
double volume_inside(const Surface& surface, double spacing);

/// @param surface  any triangles with normals that mostly point outwards
/// @param spacing  m, of the body-centred cubic lattice; edges are this long and 0.87 of it, 12 tetrahedra a cube
LatticeFill fill_by_lattice(const Surface& surface, double spacing);

}  // namespace thermotwin::mesh
