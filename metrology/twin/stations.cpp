// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/twin/stations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "core/error.h"
#include "core/units.h"

namespace thermotwin::metrology {

using Eigen::Index;
using mesh::Machine;
using mesh::Pose;

namespace {

constexpr double same = 1e-7;                       ///< m or rad
constexpr double spacing = 5.0 * core::units::deg;  ///< of stations along an arc
constexpr std::size_t nodes = 4;                    ///< of an interpolation

/// Endless axes count modulo a turn.
std::vector<long long> key_of(const Machine& machine, const Pose& pose) {
  std::vector<long long> key;
  for (Index i = 0; i < pose.size(); ++i) {
    double value = pose[i];
    if (machine.axes[i].endless) {
      const double turn = 2.0 * std::numbers::pi;
      value -= turn * std::floor(value / turn);
      if (turn - value < same) value = 0.0;
    }
    key.push_back(std::llround(value / same));
  }
  return key;
}

/// The rotary axis that alone turns; -1: several or none.
Index swept_axis(const Machine& machine, const std::vector<PlannedPoint>& points) {
  Index swept = -1;
  for (Index i = 0; i < std::ssize(machine.axes); ++i) {
    if (machine.axes[i].kind == mesh::AxisKind::linear) continue;
    const bool turns = std::any_of(points.begin(), points.end(), [&](const PlannedPoint& point) {
      return std::abs(point.pose[i] - points.front().pose[i]) > same;
    });
    if (!turns) continue;
    if (swept >= 0) return -1;
    swept = i;
  }
  return swept;
}

}  // namespace

std::size_t Stations::add(const Machine& machine, const Pose& pose) {
  const auto key = key_of(machine, pose);
  for (std::size_t i = 0; i < poses.size(); ++i)
    if (key_of(machine, poses[i]) == key) return i;
  poses.push_back(pose);
  return poses.size() - 1;
}

Stations stations_of(const Machine& machine, const std::vector<PlannedPoint>& points) {
  Stations stations;
  std::map<std::vector<long long>, std::size_t> known;
  for (const PlannedPoint& point : points) {
    if (known.size() > most_stations) break;
    known.emplace(key_of(machine, point.pose), known.size());
  }
  if (known.size() <= most_stations) {
    stations.poses.resize(known.size());
    for (const PlannedPoint& point : points) {
      const std::size_t at = known.at(key_of(machine, point.pose));
      stations.poses[at] = point.pose;
      stations.of_point.push_back({{at, 1.0}});
    }
    return stations;
  }
  const Index axis = swept_axis(machine, points);
  if (axis < 0) {
    throw core::InputError("points.csv", fmt::format("more than {} poses of several rotary axes", most_stations),
                           "fewer poses, or the sweep of one rotary axis");
  }
  std::vector<const PlannedPoint*> sorted;
  for (const PlannedPoint& point : points) sorted.push_back(&point);
  std::stable_sort(sorted.begin(), sorted.end(),
                   [&](const auto* a, const auto* b) { return a->pose[axis] < b->pose[axis]; });
  const double low = sorted.front()->pose[axis], high = sorted.back()->pose[axis];
  const std::size_t count = std::max(nodes, static_cast<std::size_t>(std::ceil((high - low) / spacing)) + 1);
  std::size_t next = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const double wanted = low + (high - low) * k / (count - 1);
    while (next + 1 < sorted.size() && sorted[next]->pose[axis] < wanted - same) ++next;
    if (stations.poses.empty() || sorted[next]->pose[axis] > stations.poses.back()[axis] + same)
      stations.poses.push_back(sorted[next]->pose);
  }
  for (const PlannedPoint& point : points) {
    const double at = point.pose[axis];
    const auto above = std::upper_bound(stations.poses.begin(), stations.poses.end(), at,
                                        [&](double value, const Pose& pose) { return value < pose[axis]; });
    const auto last = static_cast<std::size_t>(above - stations.poses.begin());
    const std::size_t first = std::min(last < 2 ? 0 : last - 2, stations.poses.size() - nodes);
    std::vector<std::pair<std::size_t, double>> weights;
    for (std::size_t i = first; i < first + nodes; ++i) {
      double weight = 1.0;
      for (std::size_t j = first; j < first + nodes; ++j) {
        if (j != i) weight *= (at - stations.poses[j][axis]) / (stations.poses[i][axis] - stations.poses[j][axis]);
      }
      weights.emplace_back(i, weight);
    }
    stations.of_point.push_back(std::move(weights));
  }
  return stations;
}

}  // namespace thermotwin::metrology
