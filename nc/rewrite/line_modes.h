// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Modes that give the words of a line their meaning, as G words set them.

#include <string>
#include <vector>

#include "nc/control/control_profile.h"
#include "nc/rewrite/program_line.h"

namespace thermotwin::nc {

struct LineModes {
  bool absolute = true;       ///< coordinates, G90
  bool arc_absolute = false;  ///< centres of arcs, G90.1
  bool inverse_time = false;  ///< F, G93
  bool cycle = false;         ///< a drilling cycle repeats at each position
  bool machine = false;       ///< this line moves in machine coordinates: G28, G30, G53
  bool coordinates = true;    ///< this line's axis words are coordinates: no offsets (G10, G52, G43.1), no dwell

  /// Takes the G words of a line.
  /// @param rules  of the control profile: what stands in a word's place counts
  /// @param place  of the line, for messages
  /// @throws InputError  for words that --rewrite path does not follow
  void read(const ProgramLine& line, const std::vector<WordRule>& rules, const std::string& place);

private:
  void take(const Word& word, const ProgramLine& line, const std::string& place);
};

/// @throws InputError always: --rewrite path does not follow the value
[[noreturn]] void refuse_path(const std::string& place, const std::string& value, const std::string& allowed);

}  // namespace thermotwin::nc
