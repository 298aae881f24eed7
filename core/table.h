// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Reads and writes tables of numbers with named columns as CSV files. The first line has the names, separated by
// commas; a blank cell or "nan" is a missing value (NaN). Errors name file, line and column.

#include <Eigen/Core>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace thermotwin::core {

struct Table {
  std::string source;                ///< file it came from, for messages
  std::vector<std::string> columns;  ///< unique, non-empty
  Eigen::MatrixXd values;            ///< (rows x columns), NaN where missing

  Eigen::Index rows() const { return values.rows(); }
  /// @return the index of the column, or nothing
  std::optional<Eigen::Index> find(const std::string& name) const;
  /// @throws InputError if absent (with the nearest known name)
  Eigen::VectorXd column(const std::string& name) const;
  /// @throws InputError with file and line where the column has a missing value
  void require_complete(const std::string& column) const;
  /// @return the line of the file (from 1) that holds row i
  static Eigen::Index line_of_row(Eigen::Index i) { return i + 2; }
};

/// @throws InputError: empty file, no header, double or empty names, a cell that is no number, a
///         row with too few or too many cells
Table read_csv(const std::filesystem::path& path);

/// Reads a table from text, for tests and fuzzers. @param source  name for messages
Table parse_csv(const std::string& text, const std::string& source);

/// Writes the file whole or not at all.
/// @param digits  significant digits of each number; times, in the column time_s, keep their milliseconds as well
void write_csv(const std::filesystem::path& path, const Table& table, int digits = 9);

/// Checks that column 0 is time_s, complete and strictly rising ("time runs backwards").
void require_time_column(const Table& table);

}  // namespace thermotwin::core
