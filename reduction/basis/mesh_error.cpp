// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/basis/mesh_error.h"

#include <algorithm>
#include <cmath>

#include "core/statistics.h"
#include "core/table.h"
#include "solver/elastic/tcp.h"

namespace thermotwin::reduction {

namespace {

using Eigen::Index;

constexpr double least_ratio = 1.15;
constexpr double least_change_K = 0.2;  // RMS of a sensor, below which its share says nothing

/// Sums of squares of a channel's change and of its difference between the meshes.
struct Squares {
  double change = 0, difference = 0;
  Index count = 0;
  void add(double first, double second) {
    change += first * first;
    difference += (first - second) * (first - second);
    ++count;
  }
};

}  // namespace

std::vector<SecondMesh> second_meshes(int order) {
  if (order == 1) return {{2, 1.6}};
  return {{2, 1.4}, {2, 0.7}, {2, 0.5}, {2, 0.35}};
}

double edge_ratio(double elements, double elements_of_second) { return std::cbrt(elements / elements_of_second); }

double error_of_difference(int order, int order_of_second, double ratio) {
  if (order != order_of_second) return 1.0;
  if (std::max(ratio, 1.0 / ratio) < least_ratio) return 0.0;
  return 1.0 / std::abs(std::pow(ratio, assumed_rate) - 1.0);
}

MeshError estimate_mesh_error(const mesh::Machine& machine, const std::vector<solver::LoadResult>& first,
                              const std::vector<solver::LoadResult>& second, double factor) {
  const Index sensors = std::ssize(machine.sensors);
  std::vector<Squares> sensor(sensors), tcp(6);
  for (std::size_t l = 0; l < first.size(); ++l) {
    const core::Table &a = first[l].sensors, &b = second[l].sensors;
    for (Index s = 0; s < sensors; ++s)  // column 0 is the time
      for (Index row = 0; row < a.rows(); ++row)
        sensor[s].add(a.values(row, 1 + s) - a.values(0, 1 + s), b.values(row, 1 + s) - b.values(0, 1 + s));
    const core::Table &x = first[l].tcp, &y = second[l].tcp;
    const Index poses = a.rows() > 0 ? x.rows() / a.rows() : 0, column = x.values.cols() - 18;
    for (Index k = 0; k < 6; ++k) {
      for (Index row = 0; row < x.rows(); ++row) {
        const Index start = row % poses;
        tcp[k].add(x.values(row, column + k) - x.values(start, column + k),
                   y.values(row, column + k) - y.values(start, column + k));
      }
    }
  }
  const auto limited = [&](double share) { return std::min(largest_mesh_error, factor * share); };
  const auto moves = [](const Squares& s) { return s.count > 0 && std::sqrt(s.change / s.count) >= least_change_K; };
  MeshError error;
  error.sensors.resize(sensors);
  std::vector<double> telling;
  for (const Squares& s : sensor)
    if (moves(s)) telling.push_back(limited(std::sqrt(s.difference / s.change)));
  const double typical = telling.empty() ? largest_mesh_error : core::median(telling);
  for (Index s = 0; s < sensors; ++s)
    error.sensors[s] = moves(sensor[s]) ? limited(std::sqrt(sensor[s].difference / sensor[s].change)) : typical;
  for (Index k = 0; k < 6; ++k) {
    double motion = 0.0;
    for (Index i = 0; i < 3; ++i) motion += tcp[k - k % 3 + i].change;
    error.tcp[k] = motion > 0.0 ? limited(std::sqrt(tcp[k].difference / motion)) : 0.0;
  }
  return error;
}

MeshError both_errors(const MeshError& one, const MeshError& other) {
  const auto both = [](const auto& a, const auto& b) {
    return (a.array().square() + b.array().square()).sqrt().min(largest_mesh_error).matrix().eval();
  };
  return {both(one.sensors, other.sensors), both(one.tcp, other.tcp), one.second};
}

}  // namespace thermotwin::reduction
