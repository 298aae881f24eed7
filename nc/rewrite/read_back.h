// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Reads the corrected program with the interpreter again. Its moves have to end where the rewriter means them to, with
// the tool, length offset, spindle, fluid, zero, unit, path mode and feed of the program. They have to pass the points
// at which the planner has the axes about every two seconds, each displaced by the offset of that time. A difference
// beyond rounding is an error.

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <vector>

#include "nc/program/program.h"

namespace thermotwin::nc {

/// A line or arc of the corrected program as it is meant.
struct ExpectedMove {
  std::array<double, 9> to{};      ///< m and rad
  std::array<double, 3> middle{};  ///< m, of an arc
  double middle_within = 0;        ///< m; 0: the middle is not compared
  double angle = 0;                ///< rad, of an arc; 0: not compared
  double speed = 0;                ///< m/s or rad/s; 0: not compared
  double seconds = 0;              ///< at the feed; 0: not compared
  double slack = 0;                ///< m by which the end may differ
  double unit = 1e-3;              ///< m, length unit of the program
  std::array<double, 3> tool_offset{};
  std::array<double, 9> zero{};  ///< work offset and G92 or G52, m and rad
  /// dwelt: s, of all dwells so far; path_tolerance: m
  double spindle_rpm = 0, dwelt = 0, path_tolerance = 0;
  std::uint32_t line = 0;
  /// operation: number of tool changes and program stops so far
  int tool = 0, operation = 0;
  int path_mode = 3;  ///< 1 exact stop, 2 exact path, 3 continuous; 0: not compared
  MoveKind kind = MoveKind::traverse;
  std::uint16_t file = 0;
  bool flood = false, mist = false, tcp = false;

  /// What is expected of a move, or of one piece of it. @param to  where the move or piece ends
  static ExpectedMove of(const Move& move, const Frame& frame, const Nine& to);
};

/// A point within a line or arc of the corrected program as it is meant.
struct ExpectedPoint {
  double share = 0;            ///< of the line or arc
  std::array<double, 3> at{};  ///< m
  double within = 0;           ///< m
};

class ReadBack {
public:
  /// @param file  temporary file of the expected moves; the destructor removes it
  explicit ReadBack(std::filesystem::path file);
  ~ReadBack();
  ReadBack(const ReadBack&) = delete;
  ReadBack& operator=(const ReadBack&) = delete;

  /// Adds the next expected move. @param inside  points within it, by rising share
  void expect(const ExpectedMove& move, const std::vector<ExpectedPoint>& inside = {});

  /// @param options  of the corrected program  @param program  summary of the program before the correction
  /// @param slack  m by which every end may differ
  /// @throws InputError with the program's line where the corrected program does anything else
  void check(const InterpreterOptions& options, const ControlProfile& control, const ProgramSummary& program,
             double slack);

private:
  class Comparison;
  struct Inside {
    long move;  ///< from 0
    ExpectedPoint point;
  };

  std::filesystem::path file_;
  std::fstream moves_;
  long expected_ = 0;
  std::array<std::uint64_t, 64> last_words_{};  ///< of the move before, in eight bytes each
  std::vector<Inside> inside_;                  ///< in the order of moves
};

}  // namespace thermotwin::nc
