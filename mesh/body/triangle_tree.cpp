// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/body/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace thermotwin::mesh {

namespace {

using Eigen::Vector3d;

Vector3d nearest_on_segment(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  const Vector3d along = b - a;
  const double square = along.squaredNorm();
  const double t = square > 0.0 ? std::clamp((p - a).dot(along) / square, 0.0, 1.0) : 0.0;
  return a + t * along;
}

}  // namespace

Vector3d nearest_on_triangle(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d u = b - a, v = c - a, normal = u.cross(v);
  const double area2 = normal.squaredNorm();
  if (area2 > 0.0) {
    const Vector3d w = p - a;
    const double beta = w.cross(v).dot(normal) / area2, gamma = u.cross(w).dot(normal) / area2;
    if (beta >= 0.0 && gamma >= 0.0 && beta + gamma <= 1.0) return a + beta * u + gamma * v;
  }
  Vector3d best = nearest_on_segment(p, a, b);
  for (const Vector3d& other : {nearest_on_segment(p, b, c), nearest_on_segment(p, c, a)})
    if ((other - p).squaredNorm() < (best - p).squaredNorm()) best = other;
  return best;
}

TriangleTree::TriangleTree(const Eigen::Matrix3Xd& points, const Eigen::Matrix3Xi& triangles)
    : points_(points),
      triangles_(triangles),
      order_(triangles.cols()) {
  std::iota(order_.begin(), order_.end(), 0);
  branches_.reserve(order_.size());
  if (!order_.empty()) build(0, order_.size());
}

Eigen::AlignedBox3d TriangleTree::box(int triangle) const {
  Eigen::AlignedBox3d result;
  for (int i = 0; i < 3; ++i) result.extend(Vector3d(points_.col(triangles_(i, triangle))));
  return result;
}

int TriangleTree::build(int first, int last) {
  const int index = branches_.size();
  branches_.push_back({{}, first, last});
  Eigen::AlignedBox3d bounds, centres;
  for (int i = first; i < last; ++i) {
    const Eigen::AlignedBox3d part = box(order_[i]);
    bounds.extend(part);
    centres.extend(Vector3d(part.center()));
  }
  branches_[index].box = bounds;
  if (last - first <= 8) return index;
  int axis = 0;
  centres.sizes().maxCoeff(&axis);
  const int middle = first + (last - first) / 2;
  const auto twice_centre = [&](int triangle) {
    const Eigen::AlignedBox3d part = box(triangle);
    return part.min()[axis] + part.max()[axis];
  };
  std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last, [&](int a, int b) {
    const double x = twice_centre(a), y = twice_centre(b);
    return x != y ? x < y : a < b;
  });
  const int left = build(first, middle), right = build(middle, last);
  branches_[index].left = left;
  branches_[index].right = right;
  return index;
}

void TriangleTree::find(const Eigen::AlignedBox3d& query, std::vector<int>& found) const {
  found.clear();
  if (branches_.empty()) return;
  std::vector<int> open = {0};
  while (!open.empty()) {
    const Branch& branch = branches_[open.back()];
    open.pop_back();
    if (!branch.box.intersects(query)) continue;
    if (branch.left >= 0) {
      open.push_back(branch.right);
      open.push_back(branch.left);
      continue;
    }
    for (int i = branch.first; i < branch.last; ++i)
      if (const int t = order_[i]; box(t).intersects(query)) found.push_back(t);
  }
}

TriangleTree::Nearest TriangleTree::nearest(const Vector3d& point) const {
  Nearest best;
  if (branches_.empty()) return best;
  double square = std::numeric_limits<double>::infinity();
  std::vector<int> open = {0};
  while (!open.empty()) {
    const Branch& branch = branches_[open.back()];
    open.pop_back();
    if (branch.box.squaredExteriorDistance(point) > square) continue;
    if (branch.left >= 0) {
      const double left = branches_[branch.left].box.squaredExteriorDistance(point);
      const double right = branches_[branch.right].box.squaredExteriorDistance(point);
      open.push_back(left <= right ? branch.right : branch.left);
      open.push_back(left <= right ? branch.left : branch.right);
      continue;
    }
    for (int i = branch.first; i < branch.last; ++i) {
      const int t = order_[i];
      const Vector3d on = nearest_on_triangle(point, points_.col(triangles_(0, t)), points_.col(triangles_(1, t)),
                                              points_.col(triangles_(2, t)));
      const double distance = (on - point).squaredNorm();
      if (distance < square || (distance == square && t < best.triangle)) {
        square = distance;
        best = {t, std::sqrt(distance), on};
      }
    }
  }
  return best;
}

}  // namespace thermotwin::mesh
