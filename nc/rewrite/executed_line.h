// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A line of the program in the order of execution, with what the corrected program has in its place.

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "nc/program/program.h"
#include "nc/rewrite/line_modes.h"
#include "nc/rewrite/program_line.h"

namespace thermotwin::nc {

struct ExecutedLine {
  ProgramLine line;
  std::string place;
  std::size_t number = 0;
  int expected = 0, done = 0;                  ///< moves
  std::vector<std::pair<int, double>> dwells;  ///< moves before each, s
  LineModes modes;
  bool skipped = false, settled = false;
  Frame frame;               ///< behind it
  std::string before, text;  ///< lines that come instead of it, and the line itself
  std::string feed;          ///< word F of a cycle that waits for its first line
  bool edited = false;
};

}  // namespace thermotwin::nc
