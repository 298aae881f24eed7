// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Tells inside from outside by the winding number: how often a surface winds around a point. The surface need not be
// closed, and its triangles may intersect or be oriented inconsistently. Triangles far away count as the dipole of
// their group (Barill, Dickson, Schmidt, Levin and Jacobson, Fast winding numbers for soups and clouds, ACM
// Transactions on Graphics 37, 2018), those near by their solid angle.

#include <Eigen/Geometry>

#include <vector>

#include "mesh/surface/surface.h"

namespace thermotwin::mesh {

/// Solid angle over 4 pi of a triangle seen from the origin (van Oosterom and Strackee, 1983).
double share_of_triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

class WindingNumber {
public:
  /// @param surface  with at least one triangle; it must outlive this object
  explicit WindingNumber(const Surface& surface);

  /// 1 inside of a closed surface whose normals point outwards, 0 outside; the sum over shells that overlap; between
  /// these values near a hole. The error of the dipoles is up to 0.02.
  /// @param point  m
  double operator()(const Eigen::Vector3d& point) const;

  /// @return whether the point is inside of the union of all shells
  bool inside(const Eigen::Vector3d& point) const { return (*this)(point) > 0.5; }

private:
  struct Group {
    int first, last;  ///< range in order_
    int left = -1, right = -1;
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< m, weighted by area
    Eigen::Vector3d dipole = Eigen::Vector3d::Zero();  ///< m^2, sum of area times normal
    double radius = 0.0;                               ///< m, of a ball about the centre that holds the group
  };
  int build(int first, int last);
  double of_group(int group, const Eigen::Vector3d& point) const;

  const Surface& surface_;
  Eigen::Matrix3Xd centres_;
  std::vector<int> order_;
  std::vector<Group> groups_;
};

}  // namespace thermotwin::mesh
