// SPDX-License-Identifier: GPL-3.0-or-later
// compensate_stream: CSV rows in, CSV rows out, one at a time. Buffers are reused from row to row.
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

#include "compensation/compensator.h"
#include "core/error.h"
#include "core/progress.h"
#include "core/text.h"

namespace thermotwin::compensation {
namespace {

using core::InputError;

constexpr double missing = std::numeric_limits<double>::quiet_NaN();
/// No quantity of a machine is larger in its unit; what is would make every later state infinite.
constexpr double largest = 1e10;

std::string_view trimmed(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

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
};

class RowReader {
 public:
  RowReader(std::istream& in, const std::string& name, const solver::Channels& channels, const mesh::Machine& machine)
      : in_(in), name_(name), row_(channels.defaults()),
        sensors_(Eigen::VectorXd::Constant(static_cast<Eigen::Index>(machine.sensors.size()), missing)) {
    if (!next_line()) throw InputError(name_, "no header", "a first line of column names: time_s and inputs of the model");
    std::string_view header = line_;
    if (header.starts_with("\xEF\xBB\xBF")) header.remove_prefix(3);
    read_header(header, channels, machine);
  }

  /// @return whether there was another row
  bool next() {
    do {
      if (!next_line()) return false;
      // Blank lines may only end the input; one between rows is seen when a row follows.
      if (trimmed(line_).empty()) {
        blank_line_ = blank_line_ == 0 ? number_ : blank_line_;
        continue;
      }
      break;
    } while (true);
    if (blank_line_ != 0) fail(blank_line_, "a blank line between rows", "rows without gaps");
    const char* at = line_.data();
    const char* const end = at + line_.size();
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      const char* const cell_end = std::find(at, end, ',');
      const double value = number({at, static_cast<std::size_t>(cell_end - at)}, c);
      // A film or a flow times a negative state would make the model unstable.
      if (columns_[c].state && (value < 0.0 || value > 1.0))
        fail(number_, fmt::format("{} = {}", columns_[c].name, value), "a state: 0 (off) to 1 (on)");
      switch (columns_[c].target) {
        case Column::Target::time: time_ = value; break;
        case Column::Target::channel: row_[columns_[c].index] = value; break;
        case Column::Target::sensor: sensors_[columns_[c].index] = value; break;
        case Column::Target::probe: probed_[columns_[c].index] = value; break;
      }
      const bool last = c + 1 == columns_.size();
      if (last != (cell_end == end)) fail_cell_count();
      at = last ? cell_end : cell_end + 1;
    }
    if (std::isnan(time_)) fail(number_, "no time_s", "a number of seconds in every row");
    if (time_ <= last_time_) {
      fail(number_, fmt::format("time {}: {} s after {} s", time_ < last_time_ ? "runs backwards" : "stands still", time_, last_time_),
           "times that rise from row to row");
    }
    if (time_ - last_time_ > longest_gap_s && std::isfinite(last_time_)) {
      fail(number_, fmt::format("time leaps: {} s after {} s", time_, last_time_),
           fmt::format("rows at most {} s apart; after a longer break start anew", longest_gap_s));
    }
    last_time_ = time_;
    return true;
  }

  double time() const { return time_; }
  const Eigen::VectorXd& row() const { return row_; }
  const Eigen::VectorXd& sensors() const { return sensors_; }
  /// Probed TCP error of the row, um, NaN where blank.
  const Eigen::Vector3d& probed() const { return probed_; }

 private:
  bool next_line() {
    if (!std::getline(in_, line_)) {
      core::check_interrupt();  // an input that waits for rows may end for that reason
      if (in_.bad()) throw InputError(name_, fmt::format("cannot be read after line {}", number_), "a readable file or pipe");
      return false;
    }
    ++number_;
    return true;
  }

  [[noreturn]] void fail(long line, const std::string& found, const std::string& allowed) const {
    throw InputError(fmt::format("{}:{}", name_, line), found, allowed);
  }

  [[noreturn]] void fail_cell_count() const {
    const auto found = std::count(line_.begin(), line_.end(), ',') + 1;
    fail(number_, fmt::format("{} cells", found), fmt::format("{}, one for each column of the header", columns_.size()));
  }

  void read_header(std::string_view header, const solver::Channels& channels, const mesh::Machine& machine) {
    std::vector<std::string> known{"time_s"}, seen;
    known.insert(known.end(), channels.names().begin(), channels.names().end());
    for (const mesh::SensorSpec& sensor : machine.sensors) known.push_back(sensor.id + "_C");
    static constexpr const char* probe_columns[] = {"probe_dx_um", "probe_dy_um", "probe_dz_um"};
    known.insert(known.end(), std::begin(probe_columns), std::end(probe_columns));
    bool has_time = false;
    for (bool ended = false; !ended;) {
      const std::size_t comma = header.find(',');
      ended = comma == std::string_view::npos;
      const std::string_view text = trimmed(header.substr(0, comma));
      if (!ended) header.remove_prefix(comma + 1);
      const std::string column(text);
      const std::string place = fmt::format("{}:1 column {}", name_, columns_.size() + 1);
      if (std::find(seen.begin(), seen.end(), column) != seen.end()) throw InputError(place, shown(text) + " a second time", "each column once");
      seen.push_back(column);
      if (column == "time_s") {
        columns_.push_back({Column::Target::time, 0, column});
        has_time = true;
      } else if (const int index = channels.index(column); index >= 0) {
        columns_.push_back({Column::Target::channel, index, column, column.ends_with(".on")});
      } else if (column.size() > 2 && column.ends_with("_C") && machine.sensor_index(column.substr(0, column.size() - 2)) >= 0) {
        columns_.push_back({Column::Target::sensor, machine.sensor_index(column.substr(0, column.size() - 2)), column});
      } else if (const auto probe = std::find(std::begin(probe_columns), std::end(probe_columns), column); probe != std::end(probe_columns)) {
        columns_.push_back({Column::Target::probe, probe - std::begin(probe_columns), column});
      } else {
        throw InputError(place, "unknown column " + shown(text), "time_s, an input of the model or <sensor>_C (nearest: " + core::nearest(column, known) + ")");
      }
    }
    if (!has_time) throw InputError(name_ + ":1", "no column time_s", "a column time_s with the time of each row");
  }

  double number(std::string_view cell, std::size_t column) const {
    if (!cell.empty() && (cell.front() <= ' ' || cell.back() <= ' ')) cell = trimmed(cell);
    if (cell.empty()) return missing;
    double value = 0.0;
    const char* first = cell.data() + (cell.front() == '+' && cell.size() > 1 && cell[1] != '-' ? 1 : 0);
    const char* const last = cell.data() + cell.size();
    const auto [end, error] = std::from_chars(first, last, value);
    if (end == last && error == std::errc() && !(std::abs(value) > largest)) return value;
    if (end == last && error == std::errc::result_out_of_range && cell.find("e-") != std::string_view::npos) return 0.0;
    throw InputError(fmt::format("{}:{} {}", name_, number_, columns_[column].name), shown(cell), fmt::format("a number of at most {:.0e}, blank or nan (missing)", largest));
  }

  std::istream& in_;
  std::string name_, line_;
  long number_ = 0, blank_line_ = 0;
  std::vector<Column> columns_;
  Eigen::VectorXd row_, sensors_;
  Eigen::Vector3d probed_ = Eigen::Vector3d::Constant(missing);
  double time_ = missing, last_time_ = -std::numeric_limits<double>::infinity();
};

}  // namespace

long compensate_stream(Compensator& compensator, const mesh::Machine& machine, std::istream& in, const std::string& in_name,
                       std::ostream& out, const StreamOptions& options) {
  RowReader reader(in, in_name, compensator.channels(), machine);
  fmt::memory_buffer text;
  const auto write = [&] {
    out.write(text.data(), static_cast<std::streamsize>(text.size()));
    if (options.unbuffered) out.flush();
    text.clear();
    if (!out) throw InputError("output of " + in_name, "cannot be written", "a writable file or pipe with room");
  };
  const auto add_axes = [&](const char* prefix) {
    for (const std::string& axis : compensator.axes()) {
      std::string lower = axis;
      for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
      fmt::format_to(std::back_inserter(text), "{}{}_um,", prefix, lower);
    }
  };
  fmt::format_to(std::back_inserter(text), "time_s,");
  add_axes("offset_");
  add_axes("std_");
  fmt::format_to(std::back_inserter(text), "status\n");
  if (options.unbuffered) write();

  constexpr std::size_t chunk = 1U << 16U;
  constexpr long between_checks = 4096;
  long rows = 0;
  Eigen::VectorXd last_applied = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(compensator.axes().size()));
  while (reader.next()) {
    const Offsets& offsets = compensator.step(reader.time(), reader.row(), reader.sensors());
    fmt::format_to(std::back_inserter(text), FMT_COMPILE("{},"), offsets.time);
    const Eigen::VectorXd& applied = options.guard != nullptr ? options.guard->step(offsets.time, offsets.offset_um) : offsets.offset_um;
    for (const double value : applied) fmt::format_to(std::back_inserter(text), FMT_COMPILE("{:.3f},"), value);
    for (const double value : offsets.std_um) fmt::format_to(std::back_inserter(text), FMT_COMPILE("{:.3f},"), value);
    fmt::format_to(std::back_inserter(text), FMT_COMPILE("{}"), status_text(offsets.status));
    if (offsets.status == Status::sensor_failed) fmt::format_to(std::back_inserter(text), FMT_COMPILE(" {}"), offsets.failed_sensors);
    text.push_back('\n');
    ++rows;
    if (reader.probed().array().isFinite().any()) {
      const mesh::Pose pose = compensator.pose();
      if (options.probed_compensated) compensator.probe_compensated(pose, reader.probed(), last_applied, options.probe_std_um);
      else compensator.probe(pose, reader.probed(), options.probe_std_um);
    }
    if (options.probed_compensated) last_applied = applied;
    if (options.unbuffered || text.size() >= chunk) write();
    if (rows % between_checks == 0) core::check_interrupt();
  }
  write();
  if (!options.unbuffered) out.flush();
  if (!out) throw InputError("output of " + in_name, "cannot be written", "a writable file or pipe with room");
  return rows;
}

}  // namespace thermotwin::compensation
