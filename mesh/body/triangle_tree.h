// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Tree of bounding boxes over the triangles of a surface: which triangles a box meets, and which
// triangle is nearest to a point. Built once in O(n log n); queries may run on several threads.

#include <Eigen/Geometry>

#include <vector>

namespace thermotwin::mesh {

class TriangleTree {
public:
  struct Nearest {
    int triangle = -1;
    double distance = 0.0;                            ///< m
    Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< m, on the triangle
  };

  /// @param points (3 x n) and triangles (3 x m): must outlive the tree
  TriangleTree(const Eigen::Matrix3Xd& points, const Eigen::Matrix3Xi& triangles);

  /// Triangles whose bounding box meets the box, in no fixed order; found is cleared first.
  void find(const Eigen::AlignedBox3d& box, std::vector<int>& found) const;

  /// The triangle nearest to the point; of equally near ones the one with the smallest index.
  /// @return triangle -1 for a surface without triangles
  Nearest nearest(const Eigen::Vector3d& point) const;

  Eigen::AlignedBox3d box(int triangle) const;

private:
  struct Branch {
    Eigen::AlignedBox3d box;
    int first, last;            ///< range in order_
    int left = -1, right = -1;  ///< children; -1 for a leaf
  };
  int build(int first, int last);

  const Eigen::Matrix3Xd& points_;
  const Eigen::Matrix3Xi& triangles_;
  std::vector<int> order_;
  std::vector<Branch> branches_;
};

/// Point of the triangle a, b, c nearest to p (Voronoi regions of corners, edges and inside).
Eigen::Vector3d nearest_on_triangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                                    const Eigen::Vector3d& c);

}  // namespace thermotwin::mesh
