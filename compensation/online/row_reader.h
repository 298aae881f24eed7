// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The rows of a control as lines of CSV, one at a time. Buffers are reused from row to row.

#include <Eigen/Core>

#include <cstddef>
#include <iosfwd>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compensation/online/compensator.h"
#include "compensation/online/input_limits.h"
#include "core/error.h"
#include "core/missing.h"

namespace thermotwin::compensation {

/// Longest line of a stream, with room for thousands of columns.
inline constexpr std::size_t longest_line = 1U << 18U;

class RowReader {
public:
  /// Reads the header. The stream, the options and their functions have to outlive the reader.
  /// @throws InputError (no header, an unknown column, another machine's rows)
  RowReader(std::istream& in, const std::string& name, const StreamOptions& options, const solver::Channels& channels,
            const mesh::Machine& machine);

  /// @return whether there was another row
  /// @throws InputError (a time that does not rise or leaps, a line too long)
  bool next();

  /// Whether the row has a time and as many cells as the header.
  bool readable() const { return readable_; }
  /// Cells that were not readable, and values that the machine cannot have, as text for the status:
  /// "air.T_C=unreadable spindle.speed_rpm=beyond_12000". Their values are missing. Empty: none.
  const std::string& unreadable() const { return unreadable_; }
  /// Whether one of these cells is in another column than that of a sensor.
  bool input_unreadable() const { return input_unreadable_; }
  /// Channels without a column that have a default value.
  const std::vector<Eigen::Index>& absent() const { return absent_; }
  /// Logs each channel of the row that has had no value for so long that its status is input_missing; once until it has
  /// one again.
  void tell_lacking();
  /// File and line of the row, for messages.
  std::string place() const;
  bool names_machine() const { return names_machine_; }

  double time() const { return time_; }
  const Eigen::VectorXd& row() const { return row_; }
  const Eigen::VectorXd& sensors() const { return sensors_; }
  /// Probed TCP error of the row, um, NaN where blank.
  const Eigen::Vector3d& probed() const { return probed_; }

private:
  /// Where a column's numbers go.
  struct Column {
    enum class Target { time, channel, sensor, probe } target;
    Eigen::Index index;
    std::string name;
    bool state = false;  ///< a state: 0 off, 1 on, between them a share of time
    InputLimits limits = {};
    bool has_default = false;         ///< of a channel
    double given_at = core::missing;  ///< s, last row with a value
    bool is_nan = false;              ///< nan stands in the cell of this row
    bool nan_told = false, lack_told = false;

    /// Whether the machine can have the value. NaN, a missing value, is allowed.
    bool can_be(double value) const;
  };
  bool next_line();

  /// Stores each cell of the line in the target of its column. @return whether there were as many cells as columns
  bool read_cells();

  [[noreturn]] void fail(long line, const std::string& found, const std::string& allowed) const;

  /// With options.strict an InputError, else a warning for the first most_noted calls.
  void note(const std::string& place, const std::string& found, const std::string& allowed);

  void note_cell_count();

  /// @param text  of a comment line, without its #: "machine NAME HASH" is compared, any other text is ignored
  void compare_machine(std::string_view text, const mesh::Machine& machine);

  void read_header(std::string_view header, const solver::Channels& channels, const mesh::Machine& machine);

  /// Logs the inputs without a column. They stay at their defaults, as if the machine stood still.
  void tell_absent(const std::vector<std::string>& columns, const solver::Channels& channels);

  /// Logs a warning if there is only one sensor, because no other sensor can check it.
  void tell_single_sensor();

  /// Keeps when the columns had values, and logs the first nan of one that had numbers.
  void follow_values();

  double number(std::string_view cell, Column& column);

  /// Notes a value that the machine cannot have. @return its word for the status, such as beyond_12000
  std::string refuse(double value, const Column& column);

  /// Adds COLUMN=why to unreadable().
  void leave_out(const Column& column, const std::string& why);

  static constexpr long most_noted = 10;

  std::istream& in_;
  std::string name_, line_;
  const StreamOptions& options_;
  std::vector<char> buffer_;
  long number_ = 0, blank_line_ = 0, noted_ = 0;
  int misfits_ = 0;  ///< rows with another number of cells before the first that fits
  std::optional<core::InputError> first_misfit_;
  bool any_row_ = false, readable_ = true, time_blank_ = false, input_unreadable_ = false, names_machine_ = false;
  std::string unreadable_;
  std::vector<Column> columns_;
  std::vector<Eigen::Index> absent_;
  Eigen::VectorXd row_, sensors_;
  Eigen::Vector3d probed_ = Eigen::Vector3d::Constant(core::missing);
  double time_ = core::missing, last_time_ = -std::numeric_limits<double>::infinity();
};

}  // namespace thermotwin::compensation
