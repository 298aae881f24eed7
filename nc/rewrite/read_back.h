// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The corrected program read by the interpreter again: its moves have to end where the rewriter means them to, with the
// tool, length offset, spindle, fluid, zero, unit, path mode and feed of the program, and pass the points at which the
// planner has the axes every two seconds or so, each displaced by the offset of then. A difference is an error.

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
  double unit = 1e-3;              ///< m
  std::array<double, 3> tool_offset{};
  std::array<double, 9> zero{};  ///< work offset and G92 or G52, m and rad
  double spindle_rpm = 0, dwelt = 0, path_tolerance = 0;
  std::uint32_t line = 0;
  int tool = 0, operation = 0;
  int path_mode = 3;  ///< 0: not compared
  MoveKind kind = MoveKind::traverse;
  std::uint16_t file = 0;
  bool flood = false, mist = false, tcp = false;

  /// The whole of a move or a share of it. @param to  where it ends
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
  /// @param file  where the moves wait; it is removed with this
  explicit ReadBack(std::filesystem::path file);
  ~ReadBack();
  ReadBack(const ReadBack&) = delete;
  ReadBack& operator=(const ReadBack&) = delete;

  void expect(const ExpectedMove& move, const std::vector<ExpectedPoint>& inside = {});

  /// @param options  of the corrected program  @param program  as it was read
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
  std::vector<Inside> inside_;  ///< in the order of moves
};

}  // namespace thermotwin::nc
