// SPDX-License-Identifier: GPL-3.0-or-later
// compensate_stream: CSV rows in, CSV rows out, one at a time. Buffers are reused from row to row.

#include "compensation/online/stream.h"

#include <fmt/compile.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <istream>
#include <iterator>
#include <limits>
#include <ostream>
#include <string_view>

#include "compensation/measurement/channel.h"
#include "compensation/online/compensator.h"
#include "compensation/online/input_limits.h"
#include "core/error.h"
#include "core/missing.h"
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

/// Text of the input for a message: short, without bytes that upset a terminal.
std::string shown(std::string_view text) {
  std::string result = "'";
  for (const char c : text.substr(0, 40)) {
    const auto byte = static_cast<unsigned char>(c);
    result += byte < 0x20 || byte >= 0x7F ? '?' : c;
  }
  return result + (text.size() > 40 ? "...'" : "'");
}

/// Where a column's numbers go.
struct Column {
  enum class Target { time, channel, sensor, probe } target;
  Eigen::Index index;
  std::string name;
  bool state = false;  ///< off, on or a share of the time between
  InputLimits limits = {};

  /// NaN, a missing value, can.
  bool can_be(double value) const {
    // A film or a flow times a negative state would make the model unstable.
    if (state && (value < 0.0 || value > 1.0)) return false;
    if (target == Target::probe && std::abs(value) > largest_probe_um) return false;
    return !limits.passed_by(value);
  }
};

class RowReader {
public:
  RowReader(std::istream& in, const std::string& name, const StreamOptions& options, const solver::Channels& channels,
            const mesh::Machine& machine)
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

  /// @return whether there was another row
  bool next() {
    unreadable_.clear();
    input_unreadable_ = false;
    readable_ = true;
    do {
      if (!next_line()) return false;
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
      if (readable_ && time_blank_)
        note(fmt::format("{}:{}", name_, number_), "no time_s", "a number of seconds in every row");
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
    return true;
  }

  /// Whether the row has a time and as many cells as the header.
  bool readable() const { return readable_; }
  /// Cells that could not be read or that the machine cannot have, "air.T_C=unreadable
  /// spindle.speed_rpm=beyond_12000"; their values are missing.
  const std::string& unreadable() const { return unreadable_; }
  /// Whether one of these is not a sensor's.
  bool input_unreadable() const { return input_unreadable_; }
  /// Channels with a default that have no column.
  const std::vector<Eigen::Index>& absent() const { return absent_; }
  bool names_machine() const { return names_machine_; }

  double time() const { return time_; }
  const Eigen::VectorXd& row() const { return row_; }
  const Eigen::VectorXd& sensors() const { return sensors_; }
  /// Probed TCP error of the row, um, NaN where blank.
  const Eigen::Vector3d& probed() const { return probed_; }

private:
  bool next_line() {
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

  /// Cells to where their columns go. @return whether there were as many as columns
  bool read_cells() {
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

  [[noreturn]] void fail(long line, const std::string& found, const std::string& allowed) const {
    throw InputError(fmt::format("{}:{}", name_, line), found, allowed);
  }

  /// An error where that is wanted, else a line on stderr for the first few.
  void note(const std::string& place, const std::string& found, const std::string& allowed) {
    const InputError error(place, found, allowed);
    if (options_.strict) throw error;
    if (++noted_ > most_noted) return;
    options_.warn(
        fmt::format("{}; {}", error.what(),
                    noted_ < most_noted ? "taken as missing" : "taken as missing; further ones are only counted"));
  }

  void note_cell_count() {
    const auto found = std::count(line_.begin(), line_.end(), ',') + 1;
    const std::string allowed = fmt::format("{}, one for each column of the header", columns_.size());
    // The first row tells whether header and rows belong together.
    if (!any_row_) fail(number_, fmt::format("{} cells", found), allowed);
    readable_ = false;
    note(fmt::format("{}:{}", name_, number_), fmt::format("{} cells", found), allowed);
  }

  /// @param text  of a line "# machine NAME HASH" without its sign; other remarks say nothing
  void compare_machine(std::string_view text, const mesh::Machine& machine) {
    constexpr std::string_view word = "machine ";
    if (!text.starts_with(word)) return;
    text = trimmed(text.substr(word.size()));
    const std::size_t space = text.find_last_of(" \t");
    const std::string_view hash = space == std::string_view::npos ? "" : text.substr(space + 1),
                           its_name = trimmed(text.substr(0, space));
    names_machine_ = true;
    if (hash == machine.hash && its_name == machine.name) return;
    const std::string place = fmt::format("{}:{}", name_, number_),
                      found = fmt::format("rows of machine {} with hash {}", shown(its_name), shown(hash));
    const std::string allowed = fmt::format("rows of the model's machine: # machine {} {}", machine.name, machine.hash);
    if (options_.strict || its_name != machine.name) throw InputError(place, found, allowed);
    options_.warn(fmt::format("{}: {}; the model was made from another version of machine.toml, with hash {}", place,
                              found, machine.hash));
  }

  void read_header(std::string_view header, const solver::Channels& channels, const mesh::Machine& machine) {
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
        columns_.push_back(
            {Column::Target::channel, index, column, channel_named(column).quantity == Quantity::state, limits[index]});
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
  }

  /// Inputs that the rows will never tell stay at their defaults, as if the machine stood still.
  void tell_absent(const std::vector<std::string>& columns, const solver::Channels& channels) {
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
                      "uncertainty of missing drives and air temperatures",
                      name_, list));
    }
  }

  double number(std::string_view cell, const Column& column) {
    if (!cell.empty() && (cell.front() <= ' ' || cell.back() <= ' ')) cell = trimmed(cell);
    if (cell.empty()) {
      if (column.target == Column::Target::time) time_blank_ = true;
      return missing;
    }
    double value = 0.0;
    const char* first = cell.data() + (cell.front() == '+' && cell.size() > 1 && cell[1] != '-' ? 1 : 0);
    const char* const last = cell.data() + cell.size();
    const auto [end, error] = std::from_chars(first, last, value);
    const bool tiny =
        end == last && error == std::errc::result_out_of_range && cell.find("e-") != std::string_view::npos;
    if (tiny) value = 0.0;
    if (tiny || (end == last && error == std::errc() && !(std::abs(value) > largest))) {
      if (std::isnan(value) && column.target == Column::Target::time) time_blank_ = true;
      if (column.can_be(value)) return value;
      leave_out(column, refuse(value, column));
    } else {
      note(fmt::format("{}:{} {}", name_, number_, column.name), shown(cell),
           fmt::format("a number of at most {:.0e}, blank or nan (missing)", largest));
      leave_out(column, "unreadable");
    }
    return missing;
  }

  /// Says that the number cannot be. @return the word for it in the status
  std::string refuse(double value, const Column& column) {
    const std::string place = fmt::format("{}:{}", name_, number_), found = fmt::format("{} = {}", column.name, value);
    const InputLimits& limits = column.limits;
    if (column.target == Column::Target::probe)
      note(place, found, fmt::format("at most {:.0e} um", largest_probe_um));
    else if (column.state)
      note(place, found, "a state: 0 (off) to 1 (on)");
    else
      note(place, found, fmt::format("{:.6g} to {:.6g} ({} of machine.toml)", limits.low, limits.high, limits.stated));
    return limits.passed_by(value) ? fmt::format("beyond_{:.6g}", limits.passed(value)) : "unreadable";
  }

  void leave_out(const Column& column, const std::string& why) {
    unreadable_ += fmt::format("{}{}={}", unreadable_.empty() ? "" : " ", column.name, why);
    input_unreadable_ = input_unreadable_ || column.target != Column::Target::sensor;
  }

  static constexpr long most_noted = 10;

  std::istream& in_;
  std::string name_, line_;
  const StreamOptions& options_;
  std::vector<char> buffer_;
  long number_ = 0, blank_line_ = 0, noted_ = 0;
  bool any_row_ = false, readable_ = true, time_blank_ = false, input_unreadable_ = false, names_machine_ = false;
  std::string unreadable_;
  std::vector<Column> columns_;
  std::vector<Eigen::Index> absent_;
  Eigen::VectorXd row_, sensors_;
  Eigen::Vector3d probed_ = Eigen::Vector3d::Constant(missing);
  double time_ = missing, last_time_ = -std::numeric_limits<double>::infinity();
};

/// The status of a row's offsets, with what of the row could not be read.
Status row_status(const RowReader& reader, Status status) {
  if (reader.unreadable().empty() || status == Status::failed || status == Status::input_missing) return status;
  if (!reader.readable() || reader.input_unreadable()) return Status::input_missing;
  return status == Status::outside_workspace ? status : Status::sensor_failed;
}

class OffsetWriter {
public:
  OffsetWriter(std::ostream& out, const std::string& in_name, const StreamOptions& options)
      : out_(out),
        in_name_(in_name),
        options_(options) {}

  void header(const std::vector<std::string>& axes) {
    if (options_.line) return;
    add(FMT_COMPILE("time_s,"));
    columns("offset_", axes);
    columns("std_", axes);
    add(FMT_COMPILE("status\n"));
    if (options_.unbuffered) write();
  }

  /// @return the row's status with the names of what failed; empty: ok. Valid until the next row
  std::string_view row(const Offsets& offsets, const RowReader& reader) {
    if (!options_.line) {
      add(FMT_COMPILE("{},"), offsets.time);
      for (const double value : offsets.offset_um) add(FMT_COMPILE("{:.3f},"), value);
      for (const double value : offsets.std_um) add(FMT_COMPILE("{:.3f},"), value);
    }
    const Status status = row_status(reader, offsets.status);
    const std::size_t begin = text_.size();
    add(FMT_COMPILE("{}"), status_text(status));
    if (status == Status::sensor_failed) names(offsets.failed_sensors);
    if (status == Status::input_missing) names(offsets.failed_inputs);
    names(reader.unreadable());
    status_.assign(text_.data() + begin, text_.size() - begin);
    if (options_.line) {
      text_.resize(begin);
      add(FMT_COMPILE("{}"), options_.line(offsets, status_));
    }
    text_.push_back('\n');
    return status == Status::ok ? std::string_view() : std::string_view(status_);
  }

  /// After a row and all that follows from it.
  void end_row() {
    constexpr std::size_t chunk = 1U << 16U;
    if (options_.unbuffered || text_.size() >= chunk) write();
  }

  void finish() {
    write();
    if (!options_.unbuffered) out_.flush();
    check();
  }

private:
  template <class Format, class... Values>
  void add(const Format& format, const Values&... values) {
    fmt::format_to(std::back_inserter(text_), format, values...);
  }

  void columns(const char* prefix, const std::vector<std::string>& axes) {
    for (const std::string& axis : axes) {
      std::string lower = axis;
      for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
      add(FMT_COMPILE("{}{}_um,"), prefix, lower);
    }
  }

  void names(std::string_view text) {
    if (!text.empty()) add(FMT_COMPILE(" {}"), text);
  }

  void write() {
    out_.write(text_.data(), std::ssize(text_));
    if (options_.unbuffered) out_.flush();
    text_.clear();
    check();
  }

  void check() const {
    if (!out_) throw InputError("output of " + in_name_, "cannot be written", "a writable file or pipe with room");
  }

  std::ostream& out_;
  const std::string& in_name_;
  const StreamOptions& options_;
  fmt::memory_buffer text_;
  std::string status_;  ///< of the last row
};

/// From a row to its offsets, and probed values to the model.
class Answers {
public:
  Answers(OnlineModel& model, const StreamOptions& options) : model_(model), options_(options), last_(&nothing_) {
    const auto axes = std::ssize(model.axes());
    nothing_.offset_um = nothing_.before_um = Eigen::VectorXd::Zero(axes);
    nothing_.std_um = Eigen::VectorXd::Constant(axes, model.limits().largest_um);
    for (Eigen::Index a = 0; a < axes; ++a) moved_ += model.motion_um(Eigen::VectorXd::Unit(axes, a)).cwiseAbs();
  }
  Answers(const Answers&) = delete;
  Answers& operator=(const Answers&) = delete;

  /// A row that cannot be read gets the answer of the row before.
  const Offsets& step(const RowReader& reader) {
    if (reader.readable()) last_ = &model_.step(reader.time(), reader.row(), reader.sensors());
    return *last_;
  }

  const Offsets& last() const { return *last_; }

  void probe(const RowReader& reader, StreamSummary& summary) {
    if (!reader.readable() || !reader.probed().array().isFinite().any()) return;
    const mesh::Pose pose = model_.pose();
    if (options_.probed_compensated) {
      model_.probe_compensated(pose, reader.probed(), last_->before_um, options_.probe_std_um);
    } else {
      compare(reader.probed(), summary);
      model_.probe(pose, reader.probed(), options_.probe_std_um);
    }
  }

private:
  /// Adds squares; the end of the stream makes RMS of them.
  void compare(const Eigen::Vector3d& probed, StreamSummary& summary) const {
    const Eigen::Vector3d left = probed + model_.motion_um(last_->offset_um);
    for (Eigen::Index i = 0; i < 3; ++i) {
      if (moved_[i] < 1e-6 || !std::isfinite(probed[i])) continue;
      ++summary.probed;
      summary.probed_rms_um += probed[i] * probed[i];
      summary.left_rms_um += left[i] * left[i];
    }
  }

  OnlineModel& model_;
  const StreamOptions& options_;
  Offsets nothing_;  ///< before there is a row that can be read
  const Offsets* last_;
  Eigen::Vector3d moved_ = Eigen::Vector3d::Zero();  ///< how much offsets of 1 um move the TCP along x y z, um
};

void count_status(std::string_view status, StreamSummary& summary) {
  if (status.empty()) return;
  auto known = summary.not_ok.find(status);
  if (known == summary.not_ok.end()) {
    const bool room = summary.not_ok.size() < StreamSummary::most_statuses;
    known = summary.not_ok.try_emplace(room ? std::string(status) : "others", 0).first;
  }
  ++known->second;
}

void ask_for_machine(const std::string& in_name, const mesh::Machine& machine, const StreamOptions& options) {
  options.log(fmt::format(
      "{} does not name its machine; the model's machine is '{}'. To have it checked, begin with '# machine {} {}'",
      in_name, machine.name, machine.name, machine.hash));
}

}  // namespace

StreamSummary compensate_stream(OnlineModel& model, const mesh::Machine& machine, std::istream& in,
                                const std::string& in_name, std::ostream& out, const StreamOptions& options,
                                const std::function<void(const Offsets&)>& after_row) {
  options.validate();
  RowReader reader(in, in_name, options, model.channels(), machine);
  StreamSummary summary;
  summary.first_s = summary.last_s = missing;
  summary.names_machine = reader.names_machine();
  if (!summary.names_machine) ask_for_machine(in_name, machine, options);
  OffsetWriter writer(out, in_name, options);
  writer.header(model.axes());

  model.never_told(reader.absent());
  constexpr long between_checks = 4096;
  Answers answers(model, options);
  while (reader.next()) {
    count_status(writer.row(answers.step(reader), reader), summary);
    ++summary.rows;
    summary.unreadable += !reader.unreadable().empty();
    if (reader.readable()) {
      if (!std::isfinite(summary.first_s)) summary.first_s = reader.time();
      summary.last_s = reader.time();
    }
    answers.probe(reader, summary);
    if (reader.readable() && after_row) after_row(answers.last());
    writer.end_row();
    if (summary.rows % between_checks == 0) core::check_interrupt();
  }
  writer.finish();
  for (double* sum : {&summary.probed_rms_um, &summary.left_rms_um})
    *sum = summary.probed > 0 ? std::sqrt(*sum / static_cast<double>(summary.probed)) : 0.0;
  return summary;
}

}  // namespace thermotwin::compensation
