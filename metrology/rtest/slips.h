// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Slips of the positions of a record: in a test of one sphere, or one tool, all points mean one place. Where they mean
// several, the slip is named with which they mean the fewest.

#include <Eigen/Core>

#include <functional>
#include <string>
#include <vector>

#include "metrology/rtest/record.h"

namespace thermotwin::metrology {

inline constexpr double places_apart = 1e-3;       ///< m, between two places
inline constexpr Eigen::Index most_counted = 200;  ///< more are not counted

/// Where a point means the sphere, or the tool, to be, m.
using PlaceOf = std::function<Eigen::Vector3d(const RTestPoint&)>;

/// Another reading of the points.
struct Slip {
  std::string words;  ///< "with X_mm in m"
  std::function<void(RTestPoint&)> read;
};

/// @return number of places that the points mean, at most most_counted
Eigen::Index count_places(const RTestRecord& record, const PlaceOf& place_of);

/// @param count  places of the points as they are
/// @return ", with X_mm in m they mean 1" of the slip that leaves the fewest places, at most half; empty: none does
std::string slip_of(const RTestRecord& record, const PlaceOf& place_of, Eigen::Index count,
                    const std::vector<Slip>& slips);

}  // namespace thermotwin::metrology
