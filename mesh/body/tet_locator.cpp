// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/body/tet_locator.h"

#include <algorithm>
#include <cmath>

namespace thermotwin::mesh {

namespace {

Eigen::AlignedBox3d box_of(const TetMesh& mesh, Eigen::Index element) {
  Eigen::AlignedBox3d box;
  for (int i = 0; i < 4; ++i) box.extend(Eigen::Vector3d(mesh.points.col(mesh.tets(i, element))));
  return box;
}

}  // namespace

TetLocator::TetLocator(const TetMesh& mesh) : mesh_(mesh) {
  for (Eigen::Index e = 0; e < mesh.elements(); ++e) box_.extend(box_of(mesh, e));
  if (box_.isEmpty()) return;
  const Eigen::Vector3d size = box_.sizes().cwiseMax(1e-9);
  const double edge = std::cbrt(size.prod() / mesh.elements());
  for (int k = 0; k < 3; ++k) cells_[k] = static_cast<int>(std::clamp(size[k] / edge, 1.0, 256.0));
  const auto for_each_cell = [&](Eigen::Index element, const auto& visit) {
    const Eigen::AlignedBox3d box = box_of(mesh_, element);
    const Eigen::Vector3i low = cell_of(box.min()), high = cell_of(box.max());
    for (int z = low[2]; z <= high[2]; ++z) {
      for (int y = low[1]; y <= high[1]; ++y)
        for (int x = low[0]; x <= high[0]; ++x) visit(number(x, y, z));
    }
  };
  first_.assign(number(0, 0, cells_[2]) + 1, 0);
  for (Eigen::Index e = 0; e < mesh.elements(); ++e) for_each_cell(e, [&](std::size_t cell) { ++first_[cell + 1]; });
  for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
  elements_.resize(first_.back());
  std::vector<int> next(first_.begin(), first_.end() - 1);
  for (int e = 0; e < mesh.elements(); ++e) for_each_cell(e, [&](std::size_t cell) { elements_[next[cell]++] = e; });
}

Eigen::Vector3i TetLocator::cell_of(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d size = box_.sizes().cwiseMax(1e-9);
  Eigen::Vector3i cell;
  for (int k = 0; k < 3; ++k)
    cell[k] = std::clamp(static_cast<int>((point[k] - box_.min()[k]) / size[k] * cells_[k]), 0, cells_[k] - 1);
  return cell;
}

bool TetLocator::holds(int element, const Eigen::Vector3d& point) const {
  const auto corner = [&](int i) -> Eigen::Vector3d { return mesh_.points.col(mesh_.tets(i, element)); };
  const Eigen::Vector3d a = corner(0), u = corner(1) - a, v = corner(2) - a, w = corner(3) - a, p = point - a;
  const double six_volumes = u.cross(v).dot(w);
  const double b = p.cross(v).dot(w), c = u.cross(p).dot(w), d = u.cross(v).dot(p);
  return b >= 0.0 && c >= 0.0 && d >= 0.0 && b + c + d <= six_volumes;
}

int TetLocator::find(const Eigen::Vector3d& point) const {
  if (!box_.contains(point)) return -1;
  const Eigen::Vector3i at = cell_of(point);
  const std::size_t cell = number(at[0], at[1], at[2]);
  for (int i = first_[cell]; i < first_[cell + 1]; ++i)
    if (const int element = elements_[i]; holds(element, point)) return element;
  return -1;
}

}  // namespace thermotwin::mesh
