// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A coarse picture of the machine's skin: boundary nodes are taken out one after the other, each drawn into the
// neighbour where that moves the surface least (half-edge collapse by error quadrics: Garland, Heckbert 1997). Each
// vertex is a node of the mesh, so fields are taken there as they are. Edges and corners of the bodies stay; on even
// faces the nodes thin out uniformly, as fields need them there too.

#include <Eigen/Core>

#include <vector>

#include "mesh/machine_mesh.h"

namespace thermotwin::solver {

struct Skin {
  Eigen::Matrix3Xd points;          ///< (3 x vertices) m, home frames of the bodies
  std::vector<Eigen::Index> nodes;  ///< (vertices) of the machine mesh
  Eigen::Matrix3Xi triangles;       ///< outward
  std::vector<Eigen::Index> first;  ///< (bodies + 1) first vertex of each body
  Eigen::Index vertices() const { return points.cols(); }
};

/// @param most  vertices of all bodies together; more remain only where a body cannot be told with fewer
Skin make_skin(const mesh::MachineMesh& mesh, Eigen::Index most);

}  // namespace thermotwin::solver
