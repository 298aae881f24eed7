// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The words of an arc in the corrected program: its centre, and P, which counts turns.

#include "nc/motion/element.h"
#include "nc/rewrite/line_modes.h"
#include "nc/rewrite/piece.h"
#include "nc/rewrite/program_line.h"

namespace thermotwin::nc {

/// @return the target with the coordinates in the plane of the arc as they are at its start: a circle ends where it
///   began. @param at  where the control is, m and rad
Nine closed(const Nine& target, const Nine& at, const Source& source);

/// The word P of an arc counts turns: a piece is less than one.
void write_turns(ProgramLine& line, const Move& move, const Piece& piece);

/// The centre of an arc that leads from where the control is to a point.
/// @param changed  another word of the line has
void write_arc(ProgramLine& line, const LineModes& modes, const Source& source, const Piece& piece, const Nine& at,
               const Nine& reached, bool changed);

}  // namespace thermotwin::nc
