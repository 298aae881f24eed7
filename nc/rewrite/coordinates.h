// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Positions as the coordinates of a line of the program.

#include <array>

#include "nc/motion/element.h"
#include "nc/program/program.h"
#include "nc/rewrite/program_line.h"

namespace thermotwin::nc {

/// Decimals of a coordinate: 0.1 um in mm, 0.25 um in inches.
int decimals_of(const Frame& frame);
/// Half of a coordinate's last digit, in the program's unit.
double half_step(const Frame& frame);

/// Letters of the plane of an arc, and those of its centre.
struct Plane {
  std::array<int, 2> axes;
  std::array<char, 2> centre;
};
Plane plane_of(const Arc& arc, const Frame& frame);

/// Takes the words @ and ^ of polar coordinates out of a line. @return whether there were any
bool take_polar(ProgramLine& line);

/// Writes the coordinates that bring the control to the target.
/// @param absolute  the line's coordinates are absolute  @param at  where the control is, m and rad
/// @param whole  every coordinate of the target is written that differs from where the control is
/// @return where the control then is
Nine write_end(ProgramLine& line, bool absolute, const Frame& frame, const Nine& at, const Nine& target, bool whole);

/// Writes the centre of an arc. @param absolute  the line's centres are absolute
void write_centre(ProgramLine& line, bool absolute, const Source& source, const Eigen::Vector3d& start,
                  const Eigen::Vector3d& centre);

}  // namespace thermotwin::nc
