// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The continuous R-Test of one rotary axis by plane and circle (Gebhardt 2014, 4.16 to 4.32), beside the least squares
// on the chain. The points are the places of the sphere as the axis carries it; position and tilt of the axis are
// stated at the axis' point, in a frame with z along the axis.

#include <vector>

#include "metrology/fit/arc_fit.h"
#include "metrology/rtest/record.h"

namespace thermotwin::metrology {

/// Cycles with fewer points are no continuous test.
inline constexpr std::size_t least_arc_points = 20;

/// @return whether every cycle turns one rotary axis, the same one, and has least_arc_points
bool is_continuous(const RTestRecord& record);

/// @return the fit of each cycle; of a frame that is the same for all: x points to the first point of the first cycle
/// @throws InputError: not continuous, an arc below least_span
std::vector<ArcFit> fit_cycles(const RTestRecord& record, CircleMethod method);

}  // namespace thermotwin::metrology
