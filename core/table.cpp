// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <string_view>
#include <unordered_set>

#include "core/character.h"
#include "core/error.h"
#include "core/file.h"
#include "core/missing.h"
#include "core/text.h"

namespace thermotwin::core {
namespace {

/// Text of a file for a message, without bytes that upset a terminal; none above ASCII where some are no UTF-8.
std::string shown_text(std::string_view text) {
  const bool broken = find_invalid_utf8(text).has_value();
  std::string result;
  for (const char c : text) {
    const unsigned char byte = byte_of(c);
    result += byte < 0x20 || byte == 0x7F || (broken && byte > 0x7F) ? '?' : c;
  }
  return result;
}

/// The same, short and in quotes.
std::string shown_cell(std::string_view text) {
  constexpr std::size_t most = 40;
  return "'" + shown_text(text).substr(0, most) + (text.size() > most ? "...'" : "'");
}

/// Takes the text up to the next mark out of rest. @return nothing once rest has ended
std::optional<std::string_view> take_until(std::string_view& rest, bool& ended, char mark) {
  if (ended) return std::nullopt;
  const std::size_t end = rest.find(mark);
  const std::string_view part = rest.substr(0, end);
  ended = end == std::string_view::npos;
  rest.remove_prefix(ended ? rest.size() : end + 1);
  return part;
}

bool is_nan_word(std::string_view cell) {
  const auto is = [](char c, char lower) { return (c | 0x20) == lower; };
  return cell.size() == 3 && is(cell[0], 'n') && is(cell[1], 'a') && is(cell[2], 'n');
}

/// @return the number of a cell, NaN where it is missing, nothing if it is no number
std::optional<double> parse_cell(std::string_view cell) {
  if (cell.empty() || is_nan_word(cell)) return missing;
  std::string_view digits = cell;
  if (digits.front() == '+') digits.remove_prefix(1);
  if (digits.empty() || (digits.front() == '-' && digits.size() != cell.size())) return std::nullopt;
  double value = 0.0;
  const char* const last = digits.data() + digits.size();
  const auto [end, error] = std::from_chars(digits.data(), last, value);
  if (end != last) return std::nullopt;
  if (error == std::errc::result_out_of_range) {
    // Too small is as good as the nearest number that there is; too large is no number.
    value = std::strtod(std::string(digits).c_str(), nullptr);
  } else if (error != std::errc()) {
    return std::nullopt;
  }
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::vector<std::string> parse_header(std::string_view line, const std::string& place) {
  std::vector<std::string> names;
  std::unordered_set<std::string> seen;
  bool ended = false;
  while (const auto cell = take_until(line, ended, ',')) {
    std::string_view name = trimmed(*cell);
    if (name.size() >= 2 && name.front() == '"' && name.back() == '"') {
      name = trimmed(name.substr(1, name.size() - 2));
    }
    const std::string column_place = fmt::format("{} column {}", place, names.size() + 1);
    if (name.empty()) throw InputError(column_place, "no name", "a name for every column");
    if (name.find_first_of("\";") != std::string_view::npos) {
      throw InputError(column_place, shown_cell(name), "names separated by commas");
    }
    names.emplace_back(name);
    if (!seen.insert(names.back()).second) {
      throw InputError(column_place, shown_cell(name) + " a second time", "each name once");
    }
  }
  return names;
}

[[noreturn]] void fail_cell_count(const Table& table, std::size_t line, std::size_t found) {
  const std::string_view comma = found > table.columns.size() ? "; a decimal comma makes two cells of one" : "";
  throw InputError(fmt::format("{}:{}", table.source, line),
                   fmt::format("{}{} cells", found > table.columns.size() ? "more than " : "",
                               std::min(found, table.columns.size())),
                   fmt::format("{}, one for each column of the header{}", table.columns.size(), comma));
}

/// Appends the numbers of a line to values, row by row.
void parse_row(std::string_view line, std::size_t line_number, const Table& table, std::vector<double>& values) {
  std::size_t column = 0;
  bool ended = false;
  while (const auto cell = take_until(line, ended, ',')) {
    if (column == table.columns.size()) fail_cell_count(table, line_number, column + 1);
    const std::string_view text = trimmed(*cell);
    const std::optional<double> value = parse_cell(text);
    if (!value) {
      throw InputError(fmt::format("{}:{} {}", table.source, line_number, shown_text(table.columns[column])),
                       shown_cell(text),
                       fmt::format("a finite number, blank or nan (missing){}",
                                   text.find_first_of(";\"") == std::string_view::npos
                                       ? ""
                                       : "; cells are parted by commas, decimals by a point, without quotes"));
    }
    values.push_back(*value);
    ++column;
  }
  if (column < table.columns.size()) fail_cell_count(table, line_number, column);
}

/// Without blank lines at the end, the byte order mark and the last line's end.
std::string_view content_of(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  const std::size_t last = text.find_last_not_of(" \t\r\n");
  const std::size_t end = last == std::string_view::npos ? 0 : text.find('\n', last);
  return text.substr(0, end);
}

}  // namespace

std::optional<Eigen::Index> Table::find(const std::string& name) const {
  const auto found = std::find(columns.begin(), columns.end(), name);
  if (found == columns.end()) return std::nullopt;
  return found - columns.begin();
}

Eigen::VectorXd Table::column(const std::string& name) const {
  const auto index = find(name);
  if (!index) {
    throw InputError(source, fmt::format("no column {}", name), fmt::format("nearest is {}", nearest(name, columns)));
  }
  return values.col(*index);
}

void Table::require_complete(const std::string& name) const {
  const Eigen::VectorXd numbers = column(name);
  for (Eigen::Index i = 0; i < numbers.size(); ++i) {
    if (std::isnan(numbers[i])) {
      throw InputError(fmt::format("{}:{} {}", source, line_of_row(i), name), "missing value", "a number in every row");
    }
  }
}

Table parse_csv(const std::string& text, const std::string& source) {
  Table table;
  table.source = source;
  std::string_view rest = content_of(text);
  if (rest.empty()) throw InputError(source, "empty file", "a line of column names, then numbers");
  bool ended = false;
  const std::string_view header = *take_until(rest, ended, '\n');
  table.columns = parse_header(header, source + ":1");

  std::vector<double> values;
  values.reserve(rest.size() / 8);
  std::size_t line_number = 1;
  while (const auto line = take_until(rest, ended, '\n')) {
    parse_row(*line, ++line_number, table, values);
  }
  const auto columns = std::ssize(table.columns);
  const Eigen::Index rows = line_number - 1;
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  table.values = Eigen::Map<const RowMajor>(values.data(), rows, columns);
  return table;
}

Table read_csv(const std::filesystem::path& path) { return parse_csv(read_file(path), path.string()); }

namespace {

/// Significant digits that state the milliseconds of the largest time, such as one since 1970.
int digits_of_times(const Table& table) {
  double largest = 0.0;
  if (table.columns.empty() || table.columns[0] != "time_s") return 0;
  for (const double time : table.values.col(0))
    if (std::abs(time) > largest) largest = std::abs(time);
  return std::isfinite(largest) && largest >= 1.0 ? std::min(15, static_cast<int>(std::log10(largest)) + 4) : 0;
}

}  // namespace

void write_csv(const std::filesystem::path& path, const Table& table, int digits) {
  assert(table.values.cols() == std::ssize(table.columns));
  fmt::memory_buffer text;
  const auto out = fmt::appender(text);
  for (const std::string& name : table.columns) {
    if (trimmed(name) != name || name.empty() || name.find_first_of(",;\"\n") != std::string::npos) {
      throw InputError(path.string(), "column name " + shown_cell(name),
                       "a name without comma, semicolon, quote or blank at its ends");
    }
  }
  fmt::format_to(out, "{}\n", join(table.columns, ","));
  const int time_digits = std::max(digits, digits_of_times(table));
  for (Eigen::Index row = 0; row < table.rows(); ++row) {
    for (Eigen::Index column = 0; column < table.values.cols(); ++column) {
      if (column > 0) text.push_back(',');
      const double value = table.values(row, column);
      if (std::isnan(value)) {
        fmt::format_to(out, "nan");
      } else {
        const bool is_time = column == 0 && table.columns[0] == "time_s";
        fmt::format_to(out, "{:.{}g}", value, is_time ? time_digits : digits);
      }
    }
    text.push_back('\n');
  }
  write_file(path, std::string_view(text.data(), text.size()));
}

void require_time_column(const Table& table) {
  if (table.columns.empty() || table.columns.front() != "time_s") {
    throw InputError(table.source + ":1 column 1",
                     table.columns.empty() ? "no column" : shown_cell(table.columns.front()), "time_s");
  }
  table.require_complete("time_s");
  for (Eigen::Index i = 1; i < table.rows(); ++i) {
    const double before = table.values(i - 1, 0);
    const double now = table.values(i, 0);
    if (now > before) continue;
    throw InputError(
        fmt::format("{}:{} time_s", table.source, Table::line_of_row(i)),
        fmt::format("time {}: {} s after {} s", now < before ? "runs backwards" : "stands still", now, before),
        "times that rise from row to row");
  }
}

}  // namespace thermotwin::core
