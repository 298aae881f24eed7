// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The program's motion as rows of channels: means over intervals of one length. A row holds for each axis the mean feed
// (distance over time), the range that it sweeps and its position at the end; the means of the spindle speed and of the
// cutting fluid and of process powers. The distances of all rows add to those of the program.

#include <functional>
#include <string>
#include <vector>

#include "mesh/machine/machine.h"
#include "nc/load/process_heat.h"
#include "nc/motion/planner.h"

namespace thermotwin::nc {

struct Row {
  double from = 0, to = 0;           ///< s
  Positions travel, low, high, end;  ///< (axes) m and rad
  Positions positive;      ///< (axes) share of the time whose last motion was in positive direction; empty: not known
  double spindle_rpm = 0;  ///< mean of the absolute value
  double fluid = 0;        ///< share of the time
  Eigen::VectorXd process_W;  ///< (drives of the process) mean power
};

class RowBuilder {
public:
  /// @param start  (axes) positions before the program  @param process  must outlive this
  /// @param take  receives each row when it is full
  RowBuilder(Positions start, double interval, ProcessHeat& process, std::function<void(const Row&)> take);

  void add(const Timed& timed);
  void finish();                                       ///< the last row may be shorter
  const Positions& travel() const { return travel_; }  ///< (axes) of the rows so far

private:
  void begin();
  void close(double to);
  /// A stretch of one element within one row.
  void stretch(const Timed& timed, double from, double to);

  double interval_;
  ProcessHeat& process_;
  std::function<void(const Row&)> take_;
  Row row_;
  double fastest_rpm_ = 0;  ///< of the row
  Positions at_, travel_;
  Positions direction_;  // (axes) of the last motion: 1 positive, 0 negative
};

/// Header and rows of rows.csv, which `compensate` reads. @param drives  of the process
std::string rows_header(const mesh::Machine& machine, const std::vector<std::string>& drives);
/// @param clock  time of the program's start in the file, s
std::string row_text(const mesh::Machine& machine, const Row& row, double clock);
/// The row at the start: the machine stands.
std::string first_row_text(const mesh::Machine& machine, const std::vector<std::string>& drives, const Positions& start,
                           double clock);

/// Channels of a row in the order of solver::Channels. NaN: not given. @param drives  of the process
Eigen::VectorXd row_channels(const mesh::Machine& machine, const std::vector<std::string>& names,
                             const std::vector<std::string>& drives, const Row& row);

/// load.toml, which `simulate` reads: one phase a row.
class LoadText {
public:
  /// @param drives  of the process
  LoadText(const mesh::Machine& machine, const std::vector<std::string>& drives, const std::string& title,
           double initial_C, const Positions& start);
  void add(const Row& row);
  /// @param interval  s, output_s
  std::string finish(double interval);

private:
  const mesh::Machine& machine_;
  const std::vector<std::string>& drives_;
  bool has_fluid_;
  std::string head_, phases_;
};

}  // namespace thermotwin::nc
