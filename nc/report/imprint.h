// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Error that a finishing tool leaves in the surface of the workpiece: the TCP error at the time of the cut, tool
// against workpiece, in the directions of the workpiece with all axes at home. The workpiece is the machine's table
// body. If it is modelled as a separate body, its thermal growth at the time of the cut is part of the error. The
// finished workpiece then has this error at the reference temperature. A block is a line of the program, also if it
// runs several times.

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "nc/motion/axis_motion.h"
#include "nc/report/error_over_time.h"
#include "nc/report/path_samples.h"

namespace thermotwin::nc {

class Imprint {
public:
  struct Block {
    long runs = 0;
    double from_s = 0, to_s = 0;  ///< ends of its first and of its last run
    ErrorOverTime::Interval error;
  };
  /// Up to this number of lines, the page draws a curve for each line; beyond it, one for the whole pass.
  static constexpr std::size_t most_curves = 8;

  /// @param motion  must outlive the imprint  @param tool  number of the finishing tool; 0: no tool was called
  Imprint(const AxisMotion& motion, int tool);

  /// @param move  rapid moves, moves of other tools and moves whose element has no source are not in the pass
  /// @return rows of imprint.csv, one for each point of the move; empty if the move is not in the pass
  std::string add(const PredictedMove& move);
  static std::string header() { return "line,run,time_s,x_mm,y_mm,z_mm,dx_um,dy_um,dz_um\n"; }

  int tool() const { return tool_; }
  const std::map<std::uint32_t, Block>& blocks() const { return blocks_; }
  const ErrorOverTime& pass() const { return pass_; }
  /// Error over time of each line; empty if there are more than most_curves lines.
  const std::map<std::uint32_t, ErrorOverTime>& curves() const { return curves_; }

private:
  void take(PathPoint point, const Positions& positions);

  const mesh::Machine& machine_;
  int tool_, body_;
  PathSamples samples_;
  std::map<std::uint32_t, Block> blocks_;
  std::map<std::uint32_t, ErrorOverTime> curves_;
  ErrorOverTime pass_;
  std::string rows_;
  double end_s_ = 0;  ///< of the last move of the pass
};

/// A header and a row for each block. @param most  largest number of blocks in the table
std::vector<std::vector<std::string>> imprint_table(const Imprint& imprint, std::size_t most);

/// A picture of its own: the error over the pass. @param imprint  with a block
std::string imprint_svg(const Imprint& imprint);

/// Section of the page: the error over the pass, and the table of its blocks. @param most  as for imprint_table()
std::string imprint_section(const Imprint& imprint, std::size_t most);

}  // namespace thermotwin::nc
