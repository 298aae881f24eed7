// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/rewrite/coordinates.h"

#include <Eigen/Geometry>

#include <cmath>
#include <numbers>
#include <string>

#include "nc/control/letters.h"

namespace thermotwin::nc {

int decimals_of(const Frame& frame) { return frame.unit > 0.01 ? 5 : 4; }

double half_step(const Frame& frame) { return decimals_of(frame) == 5 ? 0.5 * 1e-5 : 0.5 * 1e-4; }

Plane plane_of(const Arc& arc, const Frame& frame) {
  // The normal is an axis of the program; a rotation turns X and Y only.
  const Eigen::Vector3d normal = arc.first.cross(arc.second).cwiseAbs();
  if (normal.z() > 0.5) return {{0, 1}, {'I', 'J'}};
  const double turned = std::abs(std::cos(frame.rotation));
  const bool across_y = (normal.y() > normal.x()) == (turned > std::numbers::sqrt2 / 2.0);
  if (across_y) return {{0, 2}, {'I', 'K'}};
  return {{1, 2}, {'J', 'K'}};
}

bool take_polar(ProgramLine& line) {
  const bool polar = line.find('@') != nullptr || line.find('^') != nullptr;
  line.remove('@');
  line.remove('^');
  return polar;
}

Nine write_end(ProgramLine& line, bool absolute, const Frame& frame, const Nine& at, const Nine& target, bool whole) {
  const double half = half_step(frame);
  const Nine now = frame.to_program(at), wanted = frame.to_program(target);
  Nine reached = wanted;
  take_polar(line);
  for (int i = 0; i < 9; ++i) {
    const char letter = letters[i];
    const Word* word = line.find(letter);
    const double goal = absolute ? wanted[i] : wanted[i] - now[i], base = absolute ? 0.0 : now[i];
    if (word != nullptr && !word->expression && std::abs(word->value - goal) <= half) {
      reached[i] = base + word->value;
      continue;
    }
    if (word == nullptr && std::abs(wanted[i] - now[i]) <= half) {
      reached[i] = now[i];
      continue;
    }
    if (i >= 3 && word == nullptr && !whole) continue;
    const std::string number = nc_number(goal, decimals_of(frame));
    reached[i] = base + std::stod(number);
    line.set(letter, number, "XYZABCUVWG");
  }
  return frame.to_axes(reached);
}

void write_centre(ProgramLine& line, bool absolute, const Source& source, const Eigen::Vector3d& start,
                  const Eigen::Vector3d& centre) {
  const Frame& frame = source.frame;
  const Plane plane = plane_of(source.move.arc, frame);
  Nine a = source.move.from, b = source.move.from;
  a.head<3>() = start;
  b.head<3>() = centre;
  const Nine from = frame.to_program(a), to = frame.to_program(b);
  const double half = half_step(frame);
  for (int k = 0; k < 2; ++k) {
    const int axis = plane.axes[k];
    const char letter = plane.centre[k];
    const double value = absolute ? to[axis] : to[axis] - from[axis];
    const Word* word = line.find(letter);
    if (word != nullptr && !word->expression && std::abs(word->value - value) <= half) continue;
    if (word == nullptr && !absolute && std::abs(value) <= half) continue;
    line.set(letter, nc_number(value, decimals_of(frame)), "XYZABCUVWIJK");
  }
}

}  // namespace thermotwin::nc
