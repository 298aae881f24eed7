// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/tool_places.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

namespace thermotwin::metrology {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

constexpr double tools_apart = 1e-3;  ///< m, between two tool points
constexpr Index most_tools = 200;

/// Another reading of a point.
using Reading = std::function<void(RTestPoint&)>;

Vector3d tool_of(const RTestRecord& record, RTestPoint point, const Reading& read) {
  read(point);
  const int last = std::ssize(record.chain.tool) - 1;
  return mesh::KinematicChain::frame(record.chain.tool, last, point.positions).inverse() * point.nominal;
}

Index count_tools(const RTestRecord& record, const Reading& read) {
  std::vector<Vector3d> places;
  for (const RTestCycle& cycle : record.cycles) {
    for (const RTestPoint& point : cycle.points) {
      const Vector3d place = tool_of(record, point, read);
      const auto same = [&](const Vector3d& other) { return (other - place).norm() < tools_apart; };
      if (std::any_of(places.begin(), places.end(), same)) continue;
      places.push_back(place);
      if (std::ssize(places) >= most_tools) return most_tools;
    }
  }
  return std::ssize(places);
}

struct Slip {
  std::string words;
  Reading read;
};

std::vector<Slip> slips_of(const RTestRecord& record) {
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

ToolPlaces tool_places(const RTestRecord& record) {
  const Reading as_it_is = [](RTestPoint&) {};
  ToolPlaces places;
  places.count = count_tools(record, as_it_is);
  places.is_cut = places.count >= most_tools;
  places.first = tool_of(record, record.cycles.front().points.front(), as_it_is);
  if (places.count < 2) return places;
  Index fewest = places.count / 2 + 1;
  std::string why;
  for (const Slip& slip : slips_of(record)) {
    const Index other = count_tools(record, slip.read);
    if (other >= fewest) continue;
    fewest = other;
    why = fmt::format(", {} {}", slip.words, other);
  }
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
