// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What a tool leaves in the surface that it finishes: the TCP error at the time of the cut, tool against workpiece, in
// the directions of the workpiece with all axes at home. The workpiece is the machine's table body. Where that is a
// body of its own, its growth at the time of the cut is part of the error; the finished workpiece has the error at the
// reference temperature. A block is a line of the program, however often it runs.

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
  /// One after the other, a curve each is drawn of no more lines.
  static constexpr std::size_t most_curves = 8;

  /// @param motion  must outlive this  @param tool  of the finishing pass; 0: none was called
  Imprint(const AxisMotion& motion, int tool);

  /// @param move  with the source of its element
  /// @return rows of imprint.csv: points of the move; empty where it is not of the pass
  std::string add(const PredictedMove& move);
  static std::string header() { return "line,run,time_s,x_mm,y_mm,z_mm,dx_um,dy_um,dz_um\n"; }

  int tool() const { return tool_; }
  const std::map<std::uint32_t, Block>& blocks() const { return blocks_; }
  const ErrorOverTime& pass() const { return pass_; }
  /// Of each line; empty where there are too many.
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

/// A header and a row for each block. @param most  blocks
std::vector<std::vector<std::string>> imprint_table(const Imprint& imprint, std::size_t most);

/// Section of the page: the error over the pass, and the table of its blocks. @param most  blocks
std::string imprint_section(const Imprint& imprint, std::size_t most);

}  // namespace thermotwin::nc
