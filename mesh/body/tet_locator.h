// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The tetrahedron that a point lies in. A grid of cells over the body, about one cell an element, lists
// the elements whose bounding box meets each cell.

#include <Eigen/Geometry>

#include <vector>

#include "mesh/body/tet_mesh.h"

namespace thermotwin::mesh {

class TetLocator {
public:
  /// @param mesh  must outlive the locator
  explicit TetLocator(const TetMesh& mesh);

  /// @param point  (3) m, frame of the mesh
  /// @return the first element that holds the point, faces included; -1: outside of the body
  int find(const Eigen::Vector3d& point) const;
  const Eigen::AlignedBox3d& box() const { return box_; }

private:
  Eigen::Vector3i cell_of(const Eigen::Vector3d& point) const;
  Eigen::Index number(int x, int y, Eigen::Index z) const { return (z * cells_[1] + y) * cells_[0] + x; }
  bool holds(int element, const Eigen::Vector3d& point) const;

  const TetMesh& mesh_;
  Eigen::AlignedBox3d box_;
  Eigen::Vector3i cells_ = Eigen::Vector3i::Ones();
  std::vector<int> first_;  ///< (cells + 1) offsets into elements_
  std::vector<int> elements_;
};

}  // namespace thermotwin::mesh
