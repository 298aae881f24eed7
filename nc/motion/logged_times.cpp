// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/motion/logged_times.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <sstream>
#include <string_view>

#include "core/error.h"
#include "core/file.h"
#include "core/table.h"
#include "core/text.h"

namespace thermotwin::nc {

using core::InputError;

namespace {

constexpr const char* allowed_columns = "time_s, one of line and block, and spindle_power_W if it was logged";

/// The number of a line's N word; -1: it has none.
int block_number(std::string_view line) {
  line = core::trimmed(line);
  while (!line.empty() && line.front() == '/') line = core::trimmed(line.substr(1));
  if (!line.starts_with('N') && !line.starts_with('n')) return -1;
  line = core::trimmed(line.substr(1));
  int number = -1;
  const auto read = std::from_chars(line.data(), line.data() + line.size(), number);
  return read.ec == std::errc() ? number : -1;
}

std::vector<int> numbers_of(const std::filesystem::path& program, bool by_block) {
  std::istringstream lines(core::read_file(program));
  std::vector<int> numbers;
  int count = 0;
  for (std::string line; std::getline(lines, line);) numbers.push_back(by_block ? block_number(line) : ++count);
  return numbers;
}

void require_columns(const core::Table& table) {
  for (const std::string& column : table.columns) {
    if (column != "time_s" && column != "line" && column != "block" && column != "spindle_power_W")
      throw InputError(table.source, "the column '" + column + "'", allowed_columns);
    table.require_complete(column);
  }
  if (!table.find("time_s") || table.find("line").has_value() == table.find("block").has_value())
    throw InputError(table.source, "the columns " + core::join(table.columns), allowed_columns);
}

}  // namespace

ControlLog ControlLog::read(const std::filesystem::path& path, const std::filesystem::path& program) {
  const core::Table table = core::read_csv(path);
  require_columns(table);
  ControlLog log;
  log.source = path.string();
  log.program = program.string();
  log.by_block = table.find("block").has_value();
  log.numbers = numbers_of(program, log.by_block);
  const std::string name = log.by_block ? "block" : "line";
  const std::set<double> known(log.numbers.begin(), log.numbers.end());
  const Eigen::VectorXd time = table.column("time_s"), number = table.column(name);
  if (time.size() == 0) throw InputError(log.source, "no row", "a row for each line as the control begins with it");
  for (Eigen::Index i = 0; i < time.size(); ++i) {
    const auto place = [&](const char* column) {
      return fmt::format("{}:{} {}", log.source, core::Table::line_of_row(i), column);
    };
    if (i > 0 && time[i] < time[i - 1])
      throw InputError(place("time_s"), fmt::format("{} after {}", time[i], time[i - 1]), "times that do not run back");
    if (number[i] < 0 || !known.contains(number[i]))
      throw InputError(place(name.c_str()), fmt::format("{}", number[i]),
                       log.by_block ? "block numbers (N) of " + log.program
                                    : fmt::format("lines of {}, 1 to {}", log.program, log.numbers.size()));
    const int whole = std::lround(number[i]);
    if (log.events.empty() || log.events.back().number != whole)
      log.events.push_back({time[i], whole, core::Table::line_of_row(i)});
  }
  log.times.assign(time.begin(), time.end());
  if (table.find("spindle_power_W")) {
    const Eigen::VectorXd power = table.column("spindle_power_W");
    for (Eigen::Index i = 0; i < power.size(); ++i)
      if (power[i] < 0.0)
        throw core::InputError(fmt::format("{}:{} spindle_power_W", table.source, core::Table::line_of_row(i)),
                               fmt::format("{:g} W", power[i]), "0 or more; while the drive brakes, 0");
    log.power.assign(power.begin(), power.end());
  }
  return log;
}

double ControlLog::energy(double from, double to) const {
  double energy = 0.0;
  auto row = std::upper_bound(times.begin(), times.end(), from);
  for (double at = from; row != times.begin() && row != times.end() && at < to; ++row) {
    const double until = std::min(to, *row);
    energy += power[row - times.begin() - 1] * (until - at);
    at = until;
  }
  return energy;
}

LoggedTimes::LoggedTimes(const ControlLog& log, const Positions& start, std::function<void(const Timed&)> take)
    : log_(log),
      take_(std::move(take)),
      at_(start) {}

void LoggedTimes::block(const MoveState& state) {
  const std::size_t next = states_.size(), line = state.line;
  matched_ = state.file == 0 && next < log_.events.size() && line >= 1 && line <= log_.numbers.size() &&
             log_.numbers[line - 1] == log_.events[next].number;
  if (matched_) states_.push_back(state);
}

void LoggedTimes::skipped() {
  if (matched_) states_.pop_back();
  matched_ = false;
}

void LoggedTimes::add(const Timed& timed) {
  reach(timed.element.state.logged);
  if (passed_ == 0 || passed_ == std::ssize(log_.events))
    give(timed);
  else
    held_.push_back(timed);
}

void LoggedTimes::reach(int event) {
  for (; passed_ < event; ++passed_) {
    const double time = log_.events[passed_].time;
    const MoveState& state = states_[passed_];
    if (passed_ == 0)
      zero_ = time_ - time;
    else if (time > opened_)
      close(time - opened_, state);
    else
      continue;
    opened_ = time;
    open_ = state;
  }
  if (passed_ < std::ssize(log_.events)) return;
  // Behind the last row's line: what one tick of the clock with it holds has the planner's times.
  for (Timed& timed : held_) give(std::move(timed));
  held_.clear();
}

/// @param after  state behind the lines since the open event
void LoggedTimes::close(double duration, const MoveState& after) {
  double planned = 0.0;
  for (const Timed& timed : held_) planned += timed.duration();
  if (planned > 0.0) {
    const double factor = duration / planned;
    for (Timed& timed : held_) {
      for (double* seconds : {&timed.t_up, &timed.t_cruise, &timed.t_down, &timed.element.pause}) *seconds *= factor;
      for (double* speed : {&timed.v0, &timed.cruise, &timed.v1}) *speed /= factor;
      give(std::move(timed));
    }
  } else {
    Timed stand;
    stand.element = Element::line(at_, at_);
    stand.element.pause = stand.t_cruise = duration;
    stand.element.state = after;
    stand.element.state.line = open_.line;
    give(std::move(stand));
  }
  held_.clear();
}

void LoggedTimes::give(Timed timed) {
  timed.start = time_;
  time_ += timed.duration();
  at_ = timed.element.end();
  take_(timed);
}

void LoggedTimes::finish() {
  reach(reached());
  if (passed_ == std::ssize(log_.events)) return;
  const ControlLog::Event& event = log_.events[passed_];
  const std::string name = log_.by_block ? "block" : "line";
  throw InputError(fmt::format("{}:{} {}", log_.source, event.line, name),
                   passed_ == 0 ? fmt::format("{}", event.number)
                                : fmt::format("{} after {}", event.number, log_.events[passed_ - 1].number),
                   fmt::format("{}s in the order in which {} runs them", name, log_.program));
}

}  // namespace thermotwin::nc
