// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/rewrite/arc_words.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "nc/rewrite/coordinates.h"
#include "nc/rewrite/displaced_move.h"

namespace thermotwin::nc {

Nine closed(const Nine& target, const Nine& at, const Source& source) {
  Nine to = source.frame.to_program(target);
  const Nine here = source.frame.to_program(at);
  for (const int axis : plane_of(source.move.arc, source.frame).axes) to[axis] = here[axis];
  return source.frame.to_axes(to);
}

void write_turns(ProgramLine& line, const Move& move, const Piece& piece) {
  const Word* word = move.kind == MoveKind::arc ? line.find('P') : nullptr;
  if (word == nullptr) return;
  if (!piece.is_whole()) {
    line.remove('P');
  } else if (word->expression) {
    line.set('P', fmt::format("{:.0f}", std::ceil(move.arc.angle / (2.0 * std::numbers::pi) - 1e-9)), "");
  }
}

void write_arc(ProgramLine& line, const LineModes& modes, const Source& source, const Piece& piece, const Nine& at,
               const Nine& reached, bool changed) {
  const Move& move = source.move;
  const auto off = [&](const Eigen::Vector3d& point, double u) -> Eigen::Vector3d {
    return point - AxisMotion::values_at(move, u).head<3>();
  };
  const Eigen::Vector3d start = at.head<3>(), end = reached.head<3>();
  const Eigen::Vector3d normal = move.arc.first.cross(move.arc.second);
  const Eigen::Vector3d a = off(start, piece.begin), b = off(end, piece.end);
  const bool radius = line.find('R') != nullptr;
  const bool moved = a.norm() > 1e-9 || changed || !piece.is_whole();
  if (radius && !moved) return;
  if (radius) line.remove('R');
  const bool circle = piece.is_whole() && whole_turns(move.arc);
  const Eigen::Vector3d centre =
      circle ? Eigen::Vector3d(move.arc.centre + a) : centre_of(start, end, move.arc.centre + 0.5 * (a + b), normal);
  write_centre(line, modes.arc_absolute, source, start, centre);
}

}  // namespace thermotwin::nc
