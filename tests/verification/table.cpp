// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/verification/table.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <vector>

namespace thermotwin::test {

namespace {

struct Row {
  std::vector<std::string> cells;  // name, source, quantity, reference, ours, error
};

std::string line(const Row& row) {
  std::string text = "|";
  for (const std::string& cell : row.cells) text += " " + cell + " |";
  return text;
}

const char* table_to_write() { return std::getenv("THERMOTWIN_VERIFICATION_TABLE"); }

/// Rows of README.md, each by its cells.
const std::vector<Row>& rows_of_readme() {
  static const std::vector<Row> rows = [] {
    std::vector<Row> read;
    std::ifstream file(THERMOTWIN_SOURCE_DIR "/tests/verification/README.md");
    for (std::string text; std::getline(file, text);) {
      if (!text.starts_with("| ")) continue;
      Row row;
      std::istringstream cells(text.substr(1));
      for (std::string cell; std::getline(cells, cell, '|');) {
        const auto first = cell.find_first_not_of(' '), last = cell.find_last_not_of(' ');
        row.cells.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
      }
      if (row.cells.size() == 6) read.push_back(std::move(row));
    }
    return read;
  }();
  return rows;
}

class Table : public ::testing::Environment {
public:
  static Table*& instance() {
    static Table* one = nullptr;
    return one;
  }
  void TearDown() override {
    if (!table_to_write()) return;
    // The text before the table stays as it is.
    std::ifstream before(THERMOTWIN_SOURCE_DIR "/tests/verification/README.md");
    std::string text;
    for (std::string read; std::getline(before, read) && !read.starts_with("| case |");) text += read + "\n";
    text += "| case | source | quantity | reference | ours | error |\n|---|---|---|---:|---:|---:|\n";
    for (const Row& row : rows_) text += line(row) + "\n";
    before.close();
    std::ofstream(table_to_write()) << text;
  }
  void add(Row row) { rows_.push_back(std::move(row)); }

private:
  std::vector<Row> rows_;
};

const auto* const registered = ::testing::AddGlobalTestEnvironment(Table::instance() = new Table);

/// @param closeness  by which the figure of README.md may differ from this one
void tell(const Row& row, double ours, double closeness) {
  if (table_to_write()) {
    Table::instance()->add(row);
    return;
  }
  for (const Row& known : rows_of_readme()) {
    if (std::equal(row.cells.begin(), row.cells.begin() + 3, known.cells.begin())) {
      const std::string& told = known.cells[4];
      if (std::isnan(ours))
        EXPECT_EQ(told, row.cells[4]) << "README.md is out of date";
      else
        EXPECT_NEAR(std::atof(told.c_str()), ours, closeness) << "README.md is out of date: " << line(row);
      return;
    }
  }
  ADD_FAILURE() << "README.md has no row " << line(row);
}

}  // namespace

void expect_value(const Figure& figure, double reference, double ours, double tolerance) {
  EXPECT_NEAR(ours, reference, tolerance) << figure.name << ": " << figure.quantity;
  const double difference = ours - reference;
  const std::string error = reference != 0.0 ? fmt::format("{:+.2f} %", 100.0 * difference / std::abs(reference))
                                             : fmt::format("{:+.2g}", difference);
  tell({{figure.name, figure.source, figure.quantity, fmt::format("{:.6g}", reference), fmt::format("{:.6g}", ours),
         error}},
       ours, 1e-3 * std::abs(ours) + 0.02 * tolerance);
}

void expect_order(const Figure& figure, double theory, double observed) {
  EXPECT_NEAR(observed, theory, 0.1) << figure.name << ": " << figure.quantity;
  tell({{figure.name, figure.source, figure.quantity, fmt::format("{:g}", theory), fmt::format("{:.2f}", observed),
         fmt::format("{:+.2f}", observed - theory)}},
       observed, 0.02);
}

void expect_below(const Figure& figure, double bound, double error) {
  EXPECT_LT(error, bound) << figure.name << ": " << figure.quantity;
  EXPECT_TRUE(std::isfinite(error));
  tell({{figure.name, figure.source, figure.quantity, "0", fmt::format("< {:.0e}", bound),
         fmt::format("< {:.0e}", bound)}},
       std::nan(""), 0.0);
}

}  // namespace thermotwin::test
