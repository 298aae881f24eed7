// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/surface/winding_number.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace thermotwin::mesh {

namespace {

using Eigen::Vector3d;

/// A group counts as a dipole from this distance on, over its radius.
constexpr double far = 3.5;
constexpr int triangles_of_leaf = 8;

}  // namespace

double share_of_triangle(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double height = a.dot(b.cross(c));
  const double base = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return std::atan2(height, base) / (2.0 * std::numbers::pi);
}

WindingNumber::WindingNumber(const Surface& surface)
    : surface_(surface),
      centres_(3, surface.triangles.cols()),
      order_(surface.triangles.cols()) {
  std::iota(order_.begin(), order_.end(), 0);
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    const Eigen::Vector3i corner = surface.triangles.col(t);
    centres_.col(t) =
        (surface.points.col(corner[0]) + surface.points.col(corner[1]) + surface.points.col(corner[2])) / 3.0;
  }
  groups_.reserve(order_.size());
  if (!order_.empty()) build(0, order_.size());
}

int WindingNumber::build(int first, int last) {
  const int index = groups_.size();
  groups_.push_back({first, last});
  Group group{first, last};
  Eigen::AlignedBox3d bounds;
  double total = 0.0;
  for (int i = first; i < last; ++i) {
    const Eigen::Vector3i corner = surface_.triangles.col(order_[i]);
    const Vector3d a = surface_.points.col(corner[0]), b = surface_.points.col(corner[1]),
                   c = surface_.points.col(corner[2]);
    const Vector3d area = 0.5 * (b - a).cross(c - a);
    group.dipole += area;
    group.centre += area.norm() * centres_.col(order_[i]);
    total += area.norm();
    bounds.extend(Vector3d(centres_.col(order_[i])));
  }
  group.centre = total > 0.0 ? Vector3d(group.centre / total) : Vector3d(bounds.center());
  for (int i = first; i < last; ++i) {
    for (int k = 0; k < 3; ++k) {
      const Vector3d corner = surface_.points.col(surface_.triangles(k, order_[i]));
      group.radius = std::max(group.radius, (corner - group.centre).norm());
    }
  }
  if (last - first > triangles_of_leaf) {
    int axis = 0;
    bounds.sizes().maxCoeff(&axis);
    const int middle = first + (last - first) / 2;
    std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last, [&](int a, int b) {
      return centres_(axis, a) != centres_(axis, b) ? centres_(axis, a) < centres_(axis, b) : a < b;
    });
    group.left = build(first, middle);
    group.right = build(middle, last);
  }
  groups_[index] = group;
  return index;
}

double WindingNumber::of_group(int index, const Vector3d& point) const {
  const Group& group = groups_[index];
  const Vector3d to = group.centre - point;
  const double distance = to.norm();
  if (distance > far * group.radius)
    return group.dipole.dot(to) / (4.0 * std::numbers::pi * distance * distance * distance);
  if (group.left >= 0) return of_group(group.left, point) + of_group(group.right, point);
  double sum = 0.0;
  for (int i = group.first; i < group.last; ++i) {
    const Eigen::Vector3i corner = surface_.triangles.col(order_[i]);
    sum += share_of_triangle(surface_.points.col(corner[0]) - point, surface_.points.col(corner[1]) - point,
                             surface_.points.col(corner[2]) - point);
  }
  return sum;
}

double WindingNumber::operator()(const Vector3d& point) const { return groups_.empty() ? 0.0 : of_group(0, point); }

}  // namespace thermotwin::mesh
