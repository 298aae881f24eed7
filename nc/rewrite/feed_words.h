// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The word F in the corrected program. A move of rotary axes that gets words of linear axes has a feed of its own, so
// that its duration stays; the next move has the program's feed again.

#include <string>

#include "nc/motion/element.h"
#include "nc/rewrite/executed_line.h"
#include "nc/rewrite/line_modes.h"
#include "nc/rewrite/piece.h"
#include "nc/rewrite/program_line.h"

namespace thermotwin::nc {

class FeedWords {
public:
  /// The next line of the program is written; its pieces follow.
  void begin_line() { per_minute_ = false; }
  /// A line of the new text: its own F holds from here on.
  void see(const ProgramLine& line, const LineModes& modes) {
    if (!modes.inverse_time && line.find('F') != nullptr) other_feed_ = false;
  }
  /// @param at  where the control is before the piece, m and rad  @param reached  where it is at its end
  void write(ProgramLine& line, const LineModes& modes, const Source& source, const Piece& piece, const Nine& at,
             const Nine& reached);
  /// @return " F..." for the first line of a cycle whose own line has no F, where another feed holds than the
  ///   program's; else empty
  std::string of_cycle(const ExecutedLine& cycle);
  /// @return whether the new text has left G93 for the present line
  bool is_per_minute() const { return per_minute_; }

private:
  bool other_feed_ = false;  ///< the last F of the new text is another one than the program's
  bool per_minute_ = false;  ///< the new text has left G93 for the present line
};

/// An expression for F becomes its value: parameters are written out.
/// @throws InputError  for an expression of another word  @param place  file:line
void write_out_feed(ProgramLine& line, const LineModes& modes, const std::string& place, const Source& source);

}  // namespace thermotwin::nc
