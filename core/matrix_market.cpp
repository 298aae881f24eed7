// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/matrix_market.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "core/error.h"
#include "core/file.h"
#include "core/text.h"

namespace thermotwin::core {
namespace {

struct Banner {
  bool coordinate = false, pattern = false, integer = false, natural = false;
  enum class Symmetry { general, symmetric, skew } symmetry = Symmetry::general;
  bool triangle() const { return symmetry != Symmetry::general; }
};

/// Words of the text with their lines; blank lines and comments are passed over.
class Scanner {
public:
  Scanner(std::string_view text, const std::string& source)
      : at_(text.data()),
        end_(text.data() + text.size()),
        source_(source) {}

  [[noreturn]] void fail(const std::string& value, const std::string& allowed) const {
    throw InputError(fmt::format("{}:{}", source_, line_), value, allowed);
  }

  /// The rest of this line; the next one begins.
  std::string_view take_line() {
    const char* begin = at_;
    while (at_ != end_ && *at_ != '\n') ++at_;
    std::string_view line(begin, at_ - begin);
    if (at_ != end_) {
      ++at_;
      next_line_ = line_ + 1;
    }
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    return line;
  }
  void begin_line() { line_ = next_line_; }

  /// To the next word, over ends of lines. @return false at the end of the text
  bool seek() {
    for (; at_ != end_; ++at_) {
      if (*at_ == '\n') {
        ++line_;
        fresh_ = true;
      } else if (*at_ == '%' && fresh_) {
        while (at_ != end_ && *at_ != '\n') ++at_;
        if (at_ == end_) return false;
        ++line_;
      } else if (!blank(*at_)) {
        fresh_ = false;
        return true;
      }
    }
    return false;
  }
  /// To the next word of this line. @return false where there is none
  bool seek_in_line() {
    while (at_ != end_ && blank(*at_)) ++at_;
    return at_ != end_ && *at_ != '\n';
  }

  std::string word() const {
    const char* end = at_;
    while (end != end_ && !blank(*end) && *end != '\n') ++end;
    constexpr std::ptrdiff_t longest = 40;
    return "'" + std::string(at_, std::min(end, at_ + longest)) + "'";
  }

  long long whole_number(long long low, long long high, const char* what) {
    long long value = 0;
    const auto [end, error] = std::from_chars(at_, end_, value);
    if (error != std::errc() || !ends_word(end) || value < low || value > high)
      fail(fmt::format("{} {}", what, word()), fmt::format("a whole number from {} to {}", low, high));
    at_ = end;
    return value;
  }

  double number(const Banner& banner) {
    const char* begin = at_;
    if (*begin == '+') ++begin;
    double value = 0;
    auto [end, error] = std::from_chars(begin, end_, value);
    if (error == std::errc::result_out_of_range || (end != end_ && (*end == 'd' || *end == 'D')))
      value = unusual_number(begin, end, error);
    if (error != std::errc() || !ends_word(end)) fail("the entry " + word(), "a finite number");
    if (!std::isfinite(value)) fail("the entry " + word(), "a finite number");
    if (banner.integer && value != std::floor(value)) fail("the entry " + word(), "a whole number, as the banner says");
    if (banner.natural && value < 0.0) fail("the entry " + word(), "0 or more, as the banner says 'unsigned-integer'");
    at_ = end;
    return value;
  }

private:
  static bool blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
  bool ends_word(const char* at) const { return at == end_ || blank(*at) || *at == '\n'; }

  /// Fortran's exponent letter, and numbers too small for a double, which are 0.
  double unusual_number(const char* begin, const char*& end, std::errc& error) const {
    const char* stop = begin;
    while (!ends_word(stop)) ++stop;
    std::string copy(begin, stop);
    std::replace_if(
        copy.begin(), copy.end(), [](char c) { return c == 'd' || c == 'D'; }, 'e');
    double value = 0;
    const auto result = std::from_chars(copy.data(), copy.data() + copy.size(), value);
    error = result.ec;
    if (error == std::errc::result_out_of_range) {
      value = std::strtod(copy.c_str(), nullptr);
      if (std::isfinite(value)) error = std::errc();
    }
    end = begin + (result.ptr - copy.data());
    return value;
  }

  const char *at_, *end_;
  const std::string& source_;
  long long line_ = 1, next_line_ = 1;
  bool fresh_ = true;
};

std::vector<std::string> lower_words(std::string_view line) {
  std::vector<std::string> words(1);
  for (const unsigned char c : line) {
    if (std::isspace(c) != 0) {
      if (!words.back().empty()) words.emplace_back();
    } else {
      words.back().push_back(std::tolower(c));
    }
  }
  if (words.back().empty()) words.pop_back();
  return words;
}

std::string shown(std::string_view line) {
  constexpr std::size_t longest = 60;
  return "'" + std::string(line.substr(0, longest)) + "'";
}

Banner read_banner(Scanner& scan) {
  const std::string_view line = scan.take_line();
  const std::vector<std::string> words = lower_words(line);
  if (words.empty() || words[0] != "%%matrixmarket")
    scan.fail(shown(line), "'%%MatrixMarket matrix coordinate real general' or another banner of a Matrix Market file");
  if (words.size() != 5 || words[1] != "matrix")
    scan.fail(shown(line), "five words: %%MatrixMarket matrix FORMAT FIELD SYMMETRY");
  const auto one_of = [&](std::size_t word, const std::vector<std::string>& known) {
    const auto found = std::find(known.begin(), known.end(), words[word]);
    if (found == known.end()) scan.fail("'" + words[word] + "' in the banner", "one of: " + join(known));
    return found - known.begin();
  };
  Banner banner;
  banner.coordinate = one_of(2, {"coordinate", "array"}) == 0;
  const auto field = one_of(3, {"real", "integer", "pattern", "double", "unsigned-integer"});
  banner.natural = field == 4;
  banner.integer = field == 1 || banner.natural;
  banner.pattern = field == 2;
  banner.symmetry = static_cast<Banner::Symmetry>(one_of(4, {"general", "symmetric", "skew-symmetric"}));
  if (banner.pattern && !banner.coordinate)
    scan.fail("'array pattern' in the banner", "coordinate with pattern, or array with real or integer");
  if (banner.pattern && banner.symmetry == Banner::Symmetry::skew)
    scan.fail("'pattern skew-symmetric' in the banner", "pattern with general or symmetric");
  scan.begin_line();
  return banner;
}

/// Entries as they come; columns are sorted at the end.
struct Entries {
  std::vector<int> row, column;
  std::vector<double> value;

  void add(long long i, long long j, double v) {
    row.push_back(i);
    column.push_back(j);
    value.push_back(v);
  }
  void add_with_mirror(long long i, long long j, double v, Banner::Symmetry symmetry) {
    add(i, j, v);
    if (symmetry != Banner::Symmetry::general && i != j) add(j, i, symmetry == Banner::Symmetry::skew ? -v : v);
  }

  /// Two stable counting sorts, by row and by column, then sums of equal places.
  SparseMatrix matrix(Eigen::Index rows, Eigen::Index columns) const {
    const std::size_t count = value.size();
    const auto sorted = [count](const std::vector<int>& key, Eigen::Index keys,
                                const std::vector<std::size_t>* before) {
      std::vector<std::size_t> begin(keys + 1, 0), order(count);
      for (const int k : key) ++begin[k + 1];
      for (std::size_t k = 1; k < begin.size(); ++k) begin[k] += begin[k - 1];
      for (std::size_t i = 0; i < count; ++i) {
        const std::size_t entry = before ? (*before)[i] : i;
        order[begin[key[entry]]++] = entry;
      }
      return order;
    };
    const std::vector<std::size_t> by_row = sorted(row, rows, nullptr), by_column = sorted(column, columns, &by_row);
    std::vector<int> outer(columns + 1, 0), inner;
    std::vector<double> values;
    inner.reserve(count);
    values.reserve(count);
    int last = -1;
    for (const std::size_t entry : by_column) {
      if (column[entry] == last && inner.back() == row[entry]) {
        values.back() += value[entry];
        continue;
      }
      last = column[entry];
      inner.push_back(row[entry]);
      values.push_back(value[entry]);
      ++outer[last + 1];
    }
    for (std::size_t j = 1; j < outer.size(); ++j) outer[j] += outer[j - 1];
    return Eigen::Map<const SparseMatrix>(rows, columns, std::ssize(values), outer.data(), inner.data(), values.data());
  }
};

void read_coordinates(Scanner& scan, const Banner& banner, long long rows, long long columns, long long count,
                      Entries& entries) {
  for (long long k = 0; k < count; ++k) {
    if (!scan.seek()) {
      scan.fail(fmt::format("the end of the file after {} of {} entries", k, count),
                "as many entries as the size line says");
    }
    const long long i = scan.whole_number(1, rows, "row") - 1;
    if (!scan.seek_in_line()) scan.fail("an entry without a column", "row, column and value in one line");
    const long long j = scan.whole_number(1, columns, "column") - 1;
    double value = 1.0;
    if (!banner.pattern) {
      if (!scan.seek_in_line()) scan.fail("an entry without a value", "row, column and value in one line");
      value = scan.number(banner);
    }
    if (scan.seek_in_line())
      scan.fail(scan.word() + " after the entry", banner.pattern ? "row and column" : "row, column and value");
    if (banner.triangle() && j > i) {
      scan.fail(fmt::format("entry ({}, {}) above the diagonal", i + 1, j + 1),
                "the lower triangle only, as the banner says");
    }
    if (banner.symmetry == Banner::Symmetry::skew && i == j && value != 0.0) {
      scan.fail(fmt::format("entry ({}, {}) on the diagonal", i + 1, j + 1),
                "zeros there, as the banner says skew-symmetric");
    }
    entries.add_with_mirror(i, j, value, banner.symmetry);
  }
}

void read_array(Scanner& scan, const Banner& banner, long long rows, long long columns, Entries& entries) {
  for (long long j = 0; j < columns; ++j) {
    const long long first = banner.symmetry == Banner::Symmetry::skew ? j + 1 : banner.triangle() ? j : 0;
    for (long long i = first; i < rows; ++i) {
      if (!scan.seek()) {
        scan.fail(fmt::format("the end of the file before entry ({}, {})", i + 1, j + 1),
                  fmt::format("all entries of a matrix of {} x {}, column by column", rows, columns));
      }
      const double value = scan.number(banner);
      if (value != 0.0) entries.add_with_mirror(i, j, value, banner.symmetry);
    }
  }
}

}  // namespace

SparseMatrix parse_matrix_market(std::string_view text, const std::string& source) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  Scanner scan(text, source);
  const Banner banner = read_banner(scan);
  const auto extent = [&](const char* what, long long high) {
    if (!scan.seek_in_line()) {
      scan.fail(fmt::format("a size line without {}", what),
                banner.coordinate ? "rows, columns and entries" : "rows and columns");
    }
    return scan.whole_number(1, high, what);
  };
  if (!scan.seek()) scan.fail("no size line", banner.coordinate ? "rows, columns and entries" : "rows and columns");
  const long long rows = extent("rows", largest_market_extent), columns = extent("columns", largest_market_extent);
  if (banner.triangle() && rows != columns)
    scan.fail(fmt::format("{} x {}", rows, columns), "a square matrix, as the banner says symmetric");
  Entries entries;
  // An entry is at least two characters: what the text cannot hold is not allocated.
  const long long room = text.size() / 2 + 1;
  if (banner.coordinate) {
    if (!scan.seek_in_line()) scan.fail("a size line without entries", "rows, columns and entries");
    const long long count = scan.whole_number(0, 2'000'000'000, "number of entries");
    if (scan.seek_in_line()) scan.fail(scan.word() + " after the size", "rows, columns and entries");
    const std::size_t reserved = std::min(count, room) * (banner.triangle() ? 2 : 1);
    for (auto* list : {&entries.row, &entries.column}) list->reserve(reserved);
    entries.value.reserve(reserved);
    read_coordinates(scan, banner, rows, columns, count, entries);
  } else {
    if (scan.seek_in_line()) scan.fail(scan.word() + " after the size", "rows and columns");
    if (rows > room * (banner.triangle() ? 2 : 1) / columns + 1) {
      scan.fail(fmt::format("{} x {} in a file of {} bytes", rows, columns, text.size()),
                "all entries of the matrix, column by column");
    }
    read_array(scan, banner, rows, columns, entries);
  }
  if (scan.seek()) scan.fail(scan.word() + " after the last entry", "as many entries as the size line says");
  constexpr std::size_t most = 2'000'000'000;
  if (entries.value.size() > most)
    scan.fail(fmt::format("{} entries", entries.value.size()), fmt::format("at most {}", most));
  SparseMatrix matrix = entries.matrix(rows, columns);
  for (Eigen::Index k = 0; k < matrix.nonZeros(); ++k) {
    if (!std::isfinite(matrix.valuePtr()[k]))
      throw InputError(source, "a sum of entries of one place overflows", "finite numbers");
  }
  return matrix;
}

SparseMatrix read_matrix_market(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    throw InputError(path.string(), std::filesystem::is_directory(path, error) ? "a folder" : "no such file",
                     "a Matrix Market file");
  return parse_matrix_market(read_file(path), path.string());
}

std::string format_matrix_market(const Eigen::MatrixXd& matrix, const std::string& comment) {
  std::string text =
      fmt::format("%%MatrixMarket matrix array real general\n% {}\n{} {}\n", comment, matrix.rows(), matrix.cols());
  for (Eigen::Index i = 0; i < matrix.size(); ++i)
    fmt::format_to(std::back_inserter(text), "{:.17g}\n", matrix.data()[i]);
  return text;
}

std::string format_matrix_market(const SparseMatrix& matrix, const std::string& comment) {
  bool symmetric = matrix.rows() == matrix.cols();
  if (symmetric) {
    const SparseMatrix difference = matrix - SparseMatrix(matrix.transpose());
    for (Eigen::Index k = 0; k < difference.nonZeros(); ++k) symmetric = symmetric && difference.valuePtr()[k] == 0.0;
  }
  std::string entries;
  Eigen::Index count = 0;
  for (int j = 0; j < matrix.outerSize(); ++j) {
    for (SparseMatrix::InnerIterator it(matrix, j); it; ++it) {
      if (it.value() == 0.0 || (symmetric && it.row() < it.col())) continue;
      fmt::format_to(std::back_inserter(entries), "{} {} {:.17g}\n", it.row() + 1, it.col() + 1, it.value());
      ++count;
    }
  }
  return fmt::format("%%MatrixMarket matrix coordinate real {}\n% {}\n{} {} {}\n", symmetric ? "symmetric" : "general",
                     comment, matrix.rows(), matrix.cols(), count) +
         entries;
}

}  // namespace thermotwin::core
