// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/row_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <istream>
#include <iterator>

#include "compensation/measurement/channel.h"
#include "core/character.h"
#include "core/error.h"
#include "core/progress.h"
#include "core/text.h"
#include "mesh/machine/kinematics.h"

namespace thermotwin::compensation {

using core::missing;
namespace {

using core::InputError;
using core::trimmed;

/// No quantity of a machine is larger in its unit; what is would make every later state infinite.
constexpr double largest = 1e10;
/// A channel or sensor without a value for longer is missing (tt_model::correction_s, absent_s of sensor_monitor.c).
constexpr double longest_blank_s = 300.0;
/// So many rows from the first on may have another number of cells than the header; if no row fits, the input is wrong.
constexpr int most_misfits = 10;

std::string cells(std::ptrdiff_t count) { return fmt::format("{} cell{}", count, count == 1 ? "" : "s"); }

/// Text of the input for a message: short, without bytes that upset a terminal.
std::string shown(std::string_view text) {
  std::string result = "'";
  for (const char c : text.substr(0, 40)) {
    const unsigned char byte = core::byte_of(c);
    result += byte < 0x20 || byte >= 0x7F ? '?' : c;
  }
  return result + (text.size() > 40 ? "...'" : "'");
}

}  // namespace

bool RowReader::Column::can_be(double value) const {
  // A film or a flow times a negative state would make the model unstable.
  if (state && (value < 0.0 || value > 1.0)) return false;
  if (target == Target::probe && std::abs(value) > largest_probe_um) return false;
  return !limits.passed_by(value);
}

RowReader::RowReader(std::istream& in, const std::string& name, const StreamOptions& options,
                     const solver::Channels& channels, const mesh::Machine& machine)
    : in_(in),
      name_(name),
      options_(options),
      buffer_(longest_line),
      row_(channels.defaults()),
      sensors_(Eigen::VectorXd::Constant(std::ssize(machine.sensors), missing)) {
  for (;;) {
    if (!next_line())
      throw InputError(name_, "no header", "a first line of column names: time_s and inputs of the model");
    std::string_view text = line_;
    if (number_ == 1 && text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    if (!text.starts_with('#')) {
      read_header(text, channels, machine);
      return;
    }
    compare_machine(trimmed(text.substr(1)), machine);
  }
}

bool RowReader::next() {
  unreadable_.clear();
  input_unreadable_ = false;
  readable_ = true;
  do {
    if (!next_line()) {
      if (!any_row_ && first_misfit_) throw *first_misfit_;
      return false;
    }
    // Blank lines may only end the input; one between rows is seen when a row follows.
    if (trimmed(line_).empty()) {
      blank_line_ = blank_line_ == 0 ? number_ : blank_line_;
      continue;
    }
    break;
  } while (true);
  if (blank_line_ != 0)
    note(fmt::format("{}:{}", name_, blank_line_), "a blank line between rows", "rows without gaps");
  blank_line_ = 0;
  const bool complete = read_cells();
  if (!complete) unreadable_ = "row=unreadable";
  if (!complete || std::isnan(time_)) {
    if (complete && unreadable_.find("time_s=") == std::string::npos)
      unreadable_ += unreadable_.empty() ? "time_s=missing" : " time_s=missing";
    if (readable_ && time_blank_) note(place(), "no time_s", "a number of seconds in every row");
    readable_ = false;
    time_ = last_time_;
    return true;
  }
  if (time_ <= last_time_) {
    fail(number_,
         fmt::format("time {}: {} s after {} s", time_ < last_time_ ? "runs backwards" : "stands still", time_,
                     last_time_),
         "times that rise from row to row");
  }
  if (time_ - last_time_ > longest_gap_s && std::isfinite(last_time_)) {
    fail(number_, fmt::format("time gap: {} s after {} s", time_, last_time_),
         fmt::format("rows at most {} s apart; restart the program after a longer break", longest_gap_s));
  }
  last_time_ = time_;
  follow_values();
  return true;
}

void RowReader::follow_values() {
  for (Column& column : columns_) {
    const bool is_channel = column.target == Column::Target::channel;
    if (!is_channel && column.target != Column::Target::sensor) continue;
    if (!std::isnan((is_channel ? row_ : sensors_)[column.index])) {
      column.given_at = time_;
      column.lack_told = false;
    } else if (column.is_nan && !column.nan_told && !std::isnan(column.given_at)) {
      column.nan_told = true;
      options_.lack(fmt::format("{}: {} is nan; this counts as a blank cell: {}", place(), column.name,
                                !is_channel ? "the sensor is not used, and after 300 s it is named absent"
                                : column.has_default
                                    ? "its last value holds, and after 300 s the status is input_missing"
                                    : "the model's own law holds"));
    }
  }
}

void RowReader::tell_lacking() {
  if (!readable_) return;
  for (Column& column : columns_) {
    if (column.target != Column::Target::channel || !column.has_default || column.lack_told) continue;
    if (!std::isnan(row_[column.index]) || time_ - column.given_at <= longest_blank_s) continue;
    column.lack_told = true;
    options_.lack(
        std::isnan(column.given_at)
            ? fmt::format("{}: {} has had no value in these rows; the status is input_missing", place(), column.name)
            : fmt::format("{}: {} has had no value for more than {:g} s; its last value holds with "
                          "status input_missing",
                          place(), column.name, longest_blank_s));
  }
}

std::string RowReader::place() const { return fmt::format("{}:{}", name_, number_); }

bool RowReader::next_line() {
  // A line without end would otherwise be kept whole.
  in_.getline(buffer_.data(), std::ssize(buffer_));
  const std::streamsize count = in_.gcount();
  if (in_.bad()) core::check_interrupt();
  if (in_.fail() && !in_.bad() && !in_.eof() && count > 0) {
    fail(number_ + 1, fmt::format("a line of more than {} characters", buffer_.size() - 1),
         fmt::format("lines of at most {} characters", buffer_.size() - 1));
  }
  if (!in_ && count == 0) {
    core::check_interrupt();  // an input that waits for rows may end for that reason
    if (in_.bad())
      throw InputError(name_, fmt::format("cannot be read after line {}", number_), "a readable file or pipe");
    return false;
  }
  line_.assign(buffer_.data(), in_.eof() ? count : count - 1);
  ++number_;
  return true;
}

bool RowReader::read_cells() {
  const char* at = line_.data();
  const char* const end = at + line_.size();
  time_blank_ = false;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    const char* const cell_end = std::find(at, end, ',');
    const double value = number({at, cell_end}, columns_[c]);
    switch (columns_[c].target) {
      case Column::Target::time: time_ = value; break;
      case Column::Target::channel:
        // A mean over a step of both directions is one of sizes.
        row_[columns_[c].index] = columns_[c].limits.both_ways ? std::abs(value) : value;
        break;
      case Column::Target::sensor: sensors_[columns_[c].index] = value; break;
      case Column::Target::probe: probed_[columns_[c].index] = value; break;
    }
    const bool last = c + 1 == columns_.size();
    if (last != (cell_end == end)) {
      note_cell_count();
      return false;
    }
    at = last ? cell_end : cell_end + 1;
  }
  any_row_ = true;
  return true;
}

void RowReader::fail(long line, const std::string& found, const std::string& allowed) const {
  throw InputError(fmt::format("{}:{}", name_, line), found, allowed);
}

void RowReader::note(const std::string& place, const std::string& found, const std::string& allowed) {
  const InputError error(place, found, allowed);
  if (options_.strict) throw error;
  if (++noted_ > most_noted) return;
  options_.warn(
      fmt::format("{}; {}", error.what(),
                  noted_ < most_noted ? "taken as missing" : "taken as missing; further ones are only counted"));
}

void RowReader::note_cell_count() {
  const auto found = std::count(line_.begin(), line_.end(), ',') + 1;
  const std::string allowed = fmt::format("{}, one for each column of the header", columns_.size());
  // The first rows tell whether header and rows belong together.
  if (!any_row_) {
    if (misfits_++ == 0) first_misfit_ = InputError(place(), cells(found), allowed);
    if (misfits_ == most_misfits) throw *first_misfit_;
  }
  readable_ = false;
  note(place(), cells(found), allowed);
}

void RowReader::compare_machine(std::string_view text, const mesh::Machine& machine) {
  constexpr std::string_view word = "machine ";
  if (!text.starts_with(word)) return;
  text = trimmed(text.substr(word.size()));
  const std::size_t space = text.find_last_of(" \t");
  const std::string_view hash = space == std::string_view::npos ? "" : text.substr(space + 1),
                         its_name = trimmed(text.substr(0, space));
  names_machine_ = true;
  if (hash == machine.hash && its_name == machine.name) return;
  const std::string here = place(),
                    found = fmt::format("rows of machine {} with hash {}", shown(its_name), shown(hash));
  const std::string allowed = fmt::format("rows of the model's machine: # machine {} {}", machine.name, machine.hash);
  if (options_.strict || its_name != machine.name) throw InputError(here, found, allowed);
  if (hash.empty()) {
    options_.warn(fmt::format("{}: rows of machine {} without a hash, which cannot be compared with the model's: {}",
                              here, shown(its_name), machine.hash));
    return;
  }
  options_.warn(fmt::format("{}: {}; the model was made from another version of machine.toml, with hash {}", here,
                            found, machine.hash));
}

void RowReader::read_header(std::string_view header, const solver::Channels& channels, const mesh::Machine& machine) {
  std::vector<std::string> known{"time_s"}, seen;
  known.insert(known.end(), channels.names().begin(), channels.names().end());
  for (const mesh::SensorSpec& sensor : machine.sensors) known.push_back(sensor.id + "_C");
  static constexpr const char* probe_columns[] = {"probe_dx_um", "probe_dy_um", "probe_dz_um"};
  known.insert(known.end(), std::begin(probe_columns), std::end(probe_columns));
  const std::vector<InputLimits> limits = input_limits(machine, channels);
  bool has_time = false;
  for (bool ended = false; !ended;) {
    const std::size_t comma = header.find(',');
    ended = comma == std::string_view::npos;
    const std::string_view text = trimmed(header.substr(0, comma));
    if (!ended) header.remove_prefix(comma + 1);
    const std::string column(text);
    const std::string place = fmt::format("{}:1 column {}", name_, columns_.size() + 1);
    if (std::find(seen.begin(), seen.end(), column) != seen.end())
      throw InputError(place, shown(text) + " a second time", "each column once");
    seen.push_back(column);
    if (column == "time_s") {
      columns_.push_back({Column::Target::time, 0, column});
      has_time = true;
    } else if (const int index = channels.index(column); index >= 0) {
      columns_.push_back({Column::Target::channel, index, column, channel_named(column).quantity == Quantity::state,
                          limits[index], !std::isnan(channels.defaults()[index])});
    } else if (column.size() > 2 && column.ends_with("_C") &&
               machine.sensor_index(column.substr(0, column.size() - 2)) >= 0) {
      columns_.push_back({Column::Target::sensor, machine.sensor_index(column.substr(0, column.size() - 2)), column});
    } else if (const auto probe = std::find(std::begin(probe_columns), std::end(probe_columns), column);
               probe != std::end(probe_columns)) {
      columns_.push_back({Column::Target::probe, probe - std::begin(probe_columns), column});
    } else {
      throw InputError(place, "unknown column " + shown(text),
                       "time_s, an input of the model or <sensor>_C (nearest: " + core::nearest(column, known) + ")");
    }
  }
  if (!has_time) throw InputError(name_ + ":1", "no column time_s", "a column time_s with the time of each row");
  tell_absent(seen, channels);
  tell_single_sensor();
}

void RowReader::tell_single_sensor() {
  const auto is_sensor = [](const Column& column) { return column.target == Column::Target::sensor; };
  if (std::count_if(columns_.begin(), columns_.end(), is_sensor) != 1) return;
  const Column& only = *std::find_if(columns_.begin(), columns_.end(), is_sensor);
  options_.log(
      fmt::format("warning: {}:1: {} is the only sensor: a constant error of it looks like a warm machine at the "
                  "first row; std_um covers both until the following hours distinguish them",
                  name_, only.name));
}

void RowReader::tell_absent(const std::vector<std::string>& columns, const solver::Channels& channels) {
  std::string list;
  for (Eigen::Index k = 0; k < channels.size(); ++k) {
    const std::string& name = channels.names()[k];
    const double value = channels.defaults()[k];
    if (std::find(columns.begin(), columns.end(), name) != columns.end()) continue;
    if (name == mesh::time_of_day) {
      options_.log(fmt::format("warning: {}:1: no column {}: laws of machine.toml over the time of day contribute 0",
                               name_, name));
    }
    if (std::isnan(value)) continue;
    absent_.push_back(k);
    list += fmt::format("{}{} = {:g}", list.empty() ? "" : ", ", name, value);
  }
  if (!list.empty()) {
    options_.log(
        fmt::format("{}:1: inputs of the model without a column keep their defaults: {}; std_um includes the "
                    "uncertainty of missing drives and air temperatures, not that of missing states",
                    name_, list));
  }
}

double RowReader::number(std::string_view cell, Column& column) {
  column.is_nan = false;
  if (!cell.empty() && (cell.front() <= ' ' || cell.back() <= ' ')) cell = trimmed(cell);
  if (cell.empty()) {
    if (column.target == Column::Target::time) time_blank_ = true;
    return missing;
  }
  double value = 0.0;
  const char* first = cell.data() + (cell.front() == '+' && cell.size() > 1 && cell[1] != '-' ? 1 : 0);
  const char* const last = cell.data() + cell.size();
  const auto [end, error] = std::from_chars(first, last, value);
  const bool tiny = end == last && error == std::errc::result_out_of_range && cell.find("e-") != std::string_view::npos;
  if (tiny) value = 0.0;
  if (tiny || (end == last && error == std::errc() && !(std::abs(value) > largest))) {
    column.is_nan = std::isnan(value);
    if (column.is_nan && column.target == Column::Target::time) time_blank_ = true;
    if (column.can_be(value)) return value;
    leave_out(column, refuse(value, column));
  } else {
    note(fmt::format("{}:{} {}", name_, number_, column.name), shown(cell),
         fmt::format("a number of at most {:.0e}, blank or nan (missing)", largest));
    leave_out(column, "unreadable");
  }
  return missing;
}

std::string RowReader::refuse(double value, const Column& column) {
  const std::string here = place(), found = fmt::format("{} = {}", column.name, value);
  const InputLimits& limits = column.limits;
  if (column.target == Column::Target::probe)
    note(here, found, fmt::format("at most {:.0e} um", largest_probe_um));
  else if (column.state)
    note(here, found, "a state: 0 (off) to 1 (on)");
  else
    note(here, found, fmt::format("{:.6g} to {:.6g} ({} of machine.toml)", limits.low, limits.high, limits.stated));
  return limits.passed_by(value) ? fmt::format("beyond_{:.6g}", limits.passed(value)) : "unreadable";
}

void RowReader::leave_out(const Column& column, const std::string& why) {
  unreadable_ += fmt::format("{}{}={}", unreadable_.empty() ? "" : " ", column.name, why);
  input_unreadable_ = input_unreadable_ || column.target != Column::Target::sensor;
}

}  // namespace thermotwin::compensation
