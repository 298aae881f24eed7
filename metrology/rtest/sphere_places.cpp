// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/sphere_places.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <vector>

#include "core/text.h"
#include "core/units.h"

namespace thermotwin::metrology {

using Eigen::Index;
using Eigen::Vector3d;
namespace units = core::units;

namespace {

constexpr double apart = 1e-3;  ///< m, between two places, and least size of a record whose axes move
constexpr Index stop_at = 200;

using Positions = std::map<std::string, double>;

/// Places of the points with the positions as another reading of the file would have them.
Index count_places(const RTestRecord& record, const std::function<void(Positions&)>& read) {
  const auto last = static_cast<int>(std::ssize(record.chain.table)) - 1;
  std::vector<Vector3d> places;
  for (const RTestCycle& cycle : record.cycles) {
    for (const RTestPoint& point : cycle.points) {
      Positions positions = point.positions;
      read(positions);
      const Vector3d place = mesh::KinematicChain::frame(record.chain.table, last, positions).inverse() * point.nominal;
      const auto same = [&](const Vector3d& other) { return (other - place).norm() < apart; };
      if (std::any_of(places.begin(), places.end(), same)) continue;
      places.push_back(place);
      if (std::ssize(places) >= stop_at) return stop_at;
    }
  }
  return std::ssize(places);
}

/// Points of a cycle that differ in the positions of axes or in their nominal place.
Index distinct_points(const RTestCycle& cycle) {
  std::vector<const RTestPoint*> distinct;
  for (const RTestPoint& point : cycle.points) {
    const auto same = [&](const RTestPoint* other) {
      return other->positions == point.positions && (other->nominal - point.nominal).norm() < apart;
    };
    if (std::none_of(distinct.begin(), distinct.end(), same)) distinct.push_back(&point);
    if (std::ssize(distinct) >= stop_at) break;
  }
  return std::ssize(distinct);
}

double size_of(const RTestRecord& record) {
  Vector3d low = record.cycles.front().points.front().nominal, high = low;
  for (const RTestCycle& cycle : record.cycles) {
    for (const RTestPoint& point : cycle.points) {
      low = low.cwiseMin(point.nominal);
      high = high.cwiseMax(point.nominal);
    }
  }
  return (high - low).norm();
}

/// The reading of the positions that leaves the fewest places, at most half: a slip that it names; empty: none.
std::string slip_of(const RTestRecord& record, Index count) {
  const std::vector<std::string> moved = record.moved_axes();
  std::vector<std::vector<std::string>> groups;
  for (const std::string& id : moved) groups.push_back({id});
  if (moved.size() > 1) groups.push_back(moved);
  const std::pair<const char*, double> readings[] = {{"with the sign of {} reversed (with_letter of the axis)", -1.0},
                                                     {"with {} in rad", 1.0 / units::deg},
                                                     {"with {} in rad and the sign reversed", -1.0 / units::deg}};
  Index fewest = count / 2 + 1;
  std::string slip;
  for (const std::vector<std::string>& group : groups) {
    for (const auto& [words, factor] : readings) {
      const double times = factor;
      const Index other = count_places(record, [&](Positions& positions) {
        for (const std::string& id : group)
          if (const auto at = positions.find(id); at != positions.end()) at->second *= times;
      });
      if (other >= fewest) continue;
      fewest = other;
      slip = fmt::format(fmt::runtime(words), core::join(group, " and ")) + fmt::format(" they mean {}", other);
    }
  }
  return slip;
}

}  // namespace

SpherePlaces sphere_places(const RTestRecord& record) {
  SpherePlaces places;
  places.count = count_places(record, [](Positions&) {});
  places.is_cut = places.count >= stop_at;
  // Axes that carry the tool move no sphere on the table.
  const std::vector<std::string> moved = record.moved_axes();
  if (std::none_of(moved.begin(), moved.end(), [&](const auto& id) { return record.chain.find(id)->table_side; }))
    return places;
  if (const double size = size_of(record); size < apart) {
    places.doubt = fmt::format(
        "{}: x_mm, y_mm, z_mm change by {:.3g} mm over the record while axes turn; allowed: nominal centres of the "
        "sphere in mm at the positions of each row",
        record.source, size / units::mm);
    return places;
  }
  const Index points = distinct_points(record.cycles.front());
  if (places.count < 2) return places;
  const std::string why = slip_of(record, places.count);
  // Many spheres that are measured once or twice are not a test that is known.
  constexpr Index many = 4;
  const bool each = points >= 3 && places.count >= points;
  if (why.empty() && !each && (places.count <= many || 2 * places.count <= points)) return places;
  places.doubt = fmt::format(
      "{}: x_mm, y_mm, z_mm of {} points mean {} places of the sphere on the table{}; the nominal points of one sphere "
      "have to follow the positions of the axes",
      record.source, points, places.count, why.empty() ? "" : ", " + why);
  return places;
}

}  // namespace thermotwin::metrology
