// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A triangulated surface.

#include <Eigen/Core>

#include <string>
#include <vector>

namespace thermotwin::mesh {

/// A triangulated surface as read from a file.
struct Surface {
  Eigen::Matrix3Xd points;     ///< (3 x n) m
  Eigen::Matrix3Xi triangles;  ///< (3 x m)
  std::vector<int> part;       ///< (m) index into part_names (named solids or objects of the file)
  std::vector<std::string> part_names;
};

}  // namespace thermotwin::mesh
