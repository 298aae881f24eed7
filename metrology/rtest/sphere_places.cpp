// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/sphere_places.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "core/text.h"
#include "core/units.h"
#include "metrology/rtest/slips.h"

namespace thermotwin::metrology {

using Eigen::Index;
using Eigen::Vector3d;
namespace units = core::units;

namespace {

/// Place of the sphere on the table.
PlaceOf sphere_of(const RTestRecord& record) {
  const Eigen::Index last = std::ssize(record.chain.table) - 1;
  return [&record, last](const RTestPoint& point) -> Vector3d {
    return mesh::KinematicChain::frame(record.chain.table, last, point.positions).inverse() * point.nominal;
  };
}

/// Points of a cycle that differ in the positions of axes or in their nominal place.
Index distinct_points(const RTestCycle& cycle) {
  std::vector<const RTestPoint*> distinct;
  for (const RTestPoint& point : cycle.points) {
    const auto same = [&](const RTestPoint* other) {
      return other->positions == point.positions && (other->nominal - point.nominal).norm() < places_apart;
    };
    if (std::none_of(distinct.begin(), distinct.end(), same)) distinct.push_back(&point);
    if (std::ssize(distinct) >= most_counted) break;
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

std::vector<Slip> turned_slips(const RTestRecord& record) {
  const std::vector<std::string> moved = record.moved_axes();
  std::vector<std::vector<std::string>> groups;
  for (const std::string& id : moved) groups.push_back({id});
  if (moved.size() > 1) groups.push_back(moved);
  std::vector<Slip> slips;
  for (const std::vector<std::string>& group : groups) {
    const std::string names = core::join(group, " and ");
    const auto times = [&](double factor) {
      return [group, factor](RTestPoint& point) {
        for (const std::string& id : group)
          if (const auto at = point.positions.find(id); at != point.positions.end()) at->second *= factor;
      };
    };
    slips.push_back({fmt::format("with the sign of {} reversed (with_letter of the axis)", names), times(-1.0)});
    slips.push_back({fmt::format("with {} in rad", names), times(1.0 / units::deg)});
    slips.push_back({fmt::format("with {} in rad and the sign reversed", names), times(-1.0 / units::deg)});
  }
  return slips;
}

}  // namespace

SpherePlaces sphere_places(const RTestRecord& record) {
  SpherePlaces places;
  places.count = count_places(record, sphere_of(record));
  places.is_cut = places.count >= most_counted;
  // Axes that carry the tool move no sphere on the table.
  const std::vector<std::string> moved = record.moved_axes();
  if (std::none_of(moved.begin(), moved.end(), [&](const auto& id) { return record.chain.find(id)->table_side; }))
    return places;
  if (const double size = size_of(record); size < places_apart) {
    places.doubt = fmt::format(
        "{}: x_mm, y_mm, z_mm change by {:.3g} mm over the record while axes turn; allowed: nominal centres of the "
        "sphere in mm at the positions of each row",
        record.source, size / units::mm);
    return places;
  }
  const Index points = distinct_points(record.cycles.front());
  if (places.count < 2) return places;
  const std::string why = slip_of(record, sphere_of(record), places.count, turned_slips(record));
  // Many spheres that are measured once or twice are not a test that is known.
  constexpr Index many = 4;
  const bool each = points >= 3 && places.count >= points;
  if (why.empty() && !each && (places.count <= many || 2 * places.count <= points)) return places;
  places.doubt = fmt::format(
      "{}: x_mm, y_mm, z_mm of {} points mean {} places of the sphere on the table{}; the nominal points of one sphere "
      "have to follow the positions of the axes",
      record.source, points, places.count, why);
  return places;
}

}  // namespace thermotwin::metrology
