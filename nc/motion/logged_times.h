// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Times of a control's log in place of the planner's. The log is a CSV with the column time_s and one of line (of the
// program's file, from 1) and block (the number of its N word); a row says what the control runs from then on. Rows of
// one line after the other are one. The lines that run from one row's to the next one's take the time between both,
// divided as the planner has it; where they move nothing and wait for nothing, the machine stands. Rows of equal time
// are one clock tick. Before the first row's line and behind the last one's the planner's times hold.

#include <filesystem>
#include <functional>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include "nc/motion/planner.h"

namespace thermotwin::nc {

struct ControlLog {
  /// The control begins with a line.
  struct Event {
    double time = 0;        ///< s
    int number = 0;         ///< line of the file, or block number
    Eigen::Index line = 0;  ///< of the log's file
  };
  std::string source, program;  ///< files, for messages
  bool by_block = false;
  std::vector<Event> events;
  std::vector<int> numbers;          ///< (lines of the program) by_block: that of its N word, -1 without; else its own
  std::vector<double> times, power;  ///< s and W of all rows; power is empty where the log has no spindle_power_W

  /// @throws InputError (file, line, column): an unknown column, a time that runs back, a line that the program's file
  ///   does not have
  static ControlLog read(const std::filesystem::path& path, const std::filesystem::path& program);
  /// J of the spindle between two times of the log: a row's power holds until the next row.
  double energy(double from, double to) const;
};

class LoggedTimes {
public:
  /// @param log  must outlive this  @param start  positions before the program
  LoggedTimes(const ControlLog& log, const Positions& start, std::function<void(const Timed&)> take);

  /// A line is about to run. @param state  before it, with its line
  void block(const MoveState& state);
  void skipped();  ///< the last line did not run after all
  /// Events of the log whose lines have run so far: MoveState::logged of the next elements.
  int reached() const { return std::ssize(states_); }

  void add(const Timed& timed);
  void finish();  ///< @throws InputError for the first row of the log whose line did not run
  /// Time of the program at the log's time 0, s; infinite before the first line of the log runs.
  double log_zero() const { return zero_; }

private:
  void reach(int event);
  void close(double duration, const MoveState& after);
  void give(Timed timed);

  const ControlLog& log_;
  std::function<void(const Timed&)> take_;
  std::vector<MoveState> states_;  ///< (events reached) before the event's line
  bool matched_ = false;           ///< the last line is that of an event
  Positions at_;
  std::vector<Timed> held_;  ///< since the open event
  int passed_ = 0;           ///< events that the elements have reached
  MoveState open_;           ///< state of the event that is open
  double opened_ = 0;        ///< its time in the log
  double time_ = 0, zero_ = std::numeric_limits<double>::infinity();
};

}  // namespace thermotwin::nc
