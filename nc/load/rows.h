// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The program's motion as rows of channels: means over intervals of one length. A row holds for each axis the mean feed
// (distance over time), the range that it sweeps and its position at the end; the means of the spindle speed and of the
// cutting fluid. The distances of all rows add to those of the program.

#include <functional>
#include <string>
#include <vector>

#include "mesh/machine/machine.h"
#include "nc/motion/planner.h"

namespace thermotwin::nc {

struct Row {
  double from = 0, to = 0;           ///< s
  Positions travel, low, high, end;  ///< (axes) m and rad
  double spindle_rpm = 0;            ///< mean of the absolute value
  double fluid = 0;                  ///< share of the time
};

class RowBuilder {
public:
  /// @param start  (axes) positions before the program  @param take  receives each row when it is full
  RowBuilder(Positions start, double interval, std::function<void(const Row&)> take);

  void add(const Timed& timed);
  void finish();                                       ///< the last row may be shorter
  const Positions& travel() const { return travel_; }  ///< (axes) of the rows so far

private:
  void begin();
  void close(double to);
  /// A stretch of one element within one row.
  void stretch(const Timed& timed, double from, double to);

  double interval_;
  std::function<void(const Row&)> take_;
  Row row_;
  Positions at_, travel_;
};

/// Header and rows of rows.csv, which `compensate` reads.
std::string rows_header(const mesh::Machine& machine);
/// @param clock  time of the program's start in the file, s
std::string row_text(const mesh::Machine& machine, const Row& row, double clock);
/// The row at the start: the machine stands.
std::string first_row_text(const mesh::Machine& machine, const Positions& start, double clock);

/// Channels of a row in the order of solver::Channels. NaN: not given.
Eigen::VectorXd row_channels(const mesh::Machine& machine, const std::vector<std::string>& names, const Row& row);

/// load.toml, which `simulate` reads: one phase a row.
class LoadText {
public:
  LoadText(const mesh::Machine& machine, const std::string& title, double initial_C, const Positions& start);
  void add(const Row& row);
  /// @param interval  s, output_s
  std::string finish(double interval);

private:
  const mesh::Machine& machine_;
  std::string head_, phases_;
};

}  // namespace thermotwin::nc
