// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A body-centred cubic lattice about a surface: its points, numbered, and where they are.

#include <Eigen/Core>

#include "mesh/surface/surface.h"

namespace thermotwin::mesh {

/// Points of a body-centred cubic lattice: corners of cubes and their centres. Place p counts half cubes; its three
/// numbers are all even or all odd.
class Lattice {
public:
  Lattice(const Surface& surface, double spacing) : spacing_(spacing) {
    const Eigen::Vector3d low = surface.points.rowwise().minCoeff(), high = surface.points.rowwise().maxCoeff();
    // A margin of more than one cube, by no simple part of it: flat sides do not fall onto lattice planes.
    cubes_ = ((high - low) / spacing).array().ceil().cast<int>() + 4;
    origin_ = 0.5 * (low + high) - 0.5 * spacing * cubes_.cast<double>() + Eigen::Vector3d::Constant(0.1237 * spacing);
    corners_ = (cubes_.array() + 1).prod();
  }
  const Eigen::Vector3i& cubes() const { return cubes_; }
  double spacing() const { return spacing_; }
  int size() const { return corners_ + cubes_.prod(); }
  bool has(const Eigen::Vector3i& place) const {
    return (place.array() >= 0).all() && (place.array() <= 2 * cubes_.array()).all();
  }
  int index(const Eigen::Vector3i& place) const {
    const int i = place[0] / 2, j = place[1] / 2, k = place[2] / 2;
    if (place[0] % 2 == 0) return (k * (cubes_[1] + 1) + j) * (cubes_[0] + 1) + i;
    return corners_ + (k * cubes_[1] + j) * cubes_[0] + i;
  }
  Eigen::Vector3d point(const Eigen::Vector3i& place) const { return origin_ + 0.5 * spacing_ * place.cast<double>(); }

private:
  double spacing_;
  Eigen::Vector3i cubes_;
  Eigen::Vector3d origin_;
  int corners_;
};

/// Visits the places from `low` to `high`, both included, `step` apart.
template <class Visit>
void for_each_place(const Eigen::Vector3i& low, const Eigen::Vector3i& high, int step, const Visit& visit) {
  for (int k = low[2]; k <= high[2]; k += step)
    for (int j = low[1]; j <= high[1]; j += step)
      for (int i = low[0]; i <= high[0]; i += step) visit(Eigen::Vector3i(i, j, k));
}

}  // namespace thermotwin::mesh
