// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/tool_places.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>
#include <vector>

#include "metrology/rtest/slips.h"

namespace thermotwin::metrology {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

/// Place of the tool point.
PlaceOf tool_of(const RTestRecord& record) {
  const Eigen::Index last = std::ssize(record.chain.tool) - 1;
  return [&record, last](const RTestPoint& point) -> Vector3d {
    return mesh::KinematicChain::frame(record.chain.tool, last, point.positions).inverse() * point.nominal;
  };
}

std::vector<Slip> grid_slips(const RTestRecord& record) {
  std::vector<std::string> linear;
  for (const auto& [axis, position] : record.cycles.front().points.front().positions)
    if (!record.chain.find(axis)->rotary) linear.push_back(axis);
  std::vector<Slip> slips;
  const auto times = [](const std::string& axis, double factor) {
    return [axis, factor](RTestPoint& point) { point.positions.at(axis) *= factor; };
  };
  for (const std::string& axis : linear) {
    slips.push_back({fmt::format("with the sign of {}_mm reversed", axis), times(axis, -1.0)});
    slips.push_back({fmt::format("with {}_mm in m", axis), times(axis, 1e3)});
    slips.push_back({fmt::format("with {}_mm in um", axis), times(axis, 1e-3)});
  }
  for (std::size_t i = 0; i < linear.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      slips.push_back({fmt::format("with {}_mm and {}_mm exchanged", linear[k], linear[i]),
                       [a = linear[i], b = linear[k]](RTestPoint& point) {
                         std::swap(point.positions.at(a), point.positions.at(b));
                       }});
    }
  }
  for (Index i = 0; i < 3; ++i) {
    slips.push_back({fmt::format("with the sign of {}_mm reversed", "xyz"[i]),
                     [i](RTestPoint& point) { point.nominal[i] = -point.nominal[i]; }});
  }
  slips.push_back({"with x_mm, y_mm, z_mm in m", [](RTestPoint& point) { point.nominal *= 1e3; }});
  return slips;
}

}  // namespace

bool has_linear_positions(const RTestRecord& record) {
  const std::vector<RTestPoint>& points = record.cycles.front().points;
  for (const auto& [axis, position] : points.front().positions) {
    if (record.chain.find(axis)->rotary) continue;
    for (const RTestPoint& point : points)
      if (std::abs(point.positions.at(axis) - position) > places_apart) return true;
  }
  return false;
}

ToolPlaces tool_places(const RTestRecord& record) {
  ToolPlaces places;
  const PlaceOf tool = tool_of(record);
  places.count = count_places(record, tool);
  places.is_cut = places.count >= most_counted;
  places.first = tool(record.cycles.front().points.front());
  if (places.count < 2) return places;
  const std::string why = slip_of(record, tool, places.count, grid_slips(record));
  constexpr Index many = 4;  // tools of a record
  if (why.empty() && (places.count <= many || 2 * places.count <= std::ssize(record.cycles.front().points)))
    return places;
  places.doubt = fmt::format(
      "{}: the positions of the axes and x_mm, y_mm, z_mm mean {}{} places of the tool point{}; the nominal points "
      "have "
      "to follow the linear axes",
      record.source, places.count, places.is_cut ? " or more" : "", why);
  return places;
}

}  // namespace thermotwin::metrology
