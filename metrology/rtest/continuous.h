// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Fits a plane and a circle to a continuous R-Test of one rotary axis (Gebhardt 2014, 4.16 to 4.32), as an alternative
// to least squares on the kinematic chain. The points are the positions of the sphere as the axis carries it. Position
// and tilt of the axis are stated like its location errors: at the axis' point, along and about X Y Z of the body on
// which it stands.

#include <array>
#include <string>
#include <vector>

#include "metrology/fit/arc_fit.h"
#include "metrology/rtest/record.h"

namespace thermotwin::metrology {

/// Cycles with fewer points are no continuous test.
inline constexpr std::size_t least_arc_points = 20;

/// @return whether every cycle turns one rotary axis, the same one, has least_arc_points, and its points move
bool is_continuous(const RTestRecord& record);

/// Location errors that the numbers of a fit are, at a deviation of zero from the nominal axis.
struct ArcNames {
  std::array<std::string, 2> centre, tilt;  ///< X0C Y0C, A0C B0C of C; Z0B X0B, C0B A0B of B; Y0A Z0A, B0A C0A of A
};
ArcNames arc_names(const RTestRecord& record);

/// @return the fit of each cycle, centre and tilt in the order of arc_names(), along the axis' letter
/// @throws InputError: not continuous, an arc below least_span
std::vector<ArcFit> fit_cycles(const RTestRecord& record, CircleMethod method);

}  // namespace thermotwin::metrology
