// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/slips.h"

#include <fmt/format.h>

#include <algorithm>

namespace thermotwin::metrology {

using Eigen::Index;
using Eigen::Vector3d;

Index count_places(const RTestRecord& record, const PlaceOf& place_of) {
  std::vector<Vector3d> places;
  for (const RTestCycle& cycle : record.cycles) {
    for (const RTestPoint& point : cycle.points) {
      const Vector3d place = place_of(point);
      const auto same = [&](const Vector3d& other) { return (other - place).norm() < places_apart; };
      if (std::any_of(places.begin(), places.end(), same)) continue;
      places.push_back(place);
      if (std::ssize(places) >= most_counted) return most_counted;
    }
  }
  return std::ssize(places);
}

std::string slip_of(const RTestRecord& record, const PlaceOf& place_of, Index count, const std::vector<Slip>& slips) {
  Index fewest = count / 2 + 1;
  std::string found;
  for (const Slip& slip : slips) {
    const Index other = count_places(record, [&](RTestPoint point) {
      slip.read(point);
      return place_of(point);
    });
    if (other >= fewest) continue;
    fewest = other;
    found = fmt::format(", {} they mean {}", slip.words, other);
  }
  return found;
}

}  // namespace thermotwin::metrology
