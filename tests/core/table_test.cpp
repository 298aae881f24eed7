// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/table.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "core/error.h"
#include "core/file.h"
#include "tests/core/temporary_folder.h"

namespace thermotwin::core {
namespace {

std::string refusal(const std::string& text) {
  return message_of<InputError>([&] { parse_csv(text, "data.csv"); });
}

void expect_holds(const std::string& message, const std::vector<std::string>& parts) {
  for (const std::string& part : parts) {
    EXPECT_NE(message.find(part), std::string::npos) << "'" << part << "' not in: " << message;
  }
}

TEST(Csv, ReadsNumbersAndMissingCells) {
  const Table table = parse_csv("time_s,a b, c\n0,1.5,-2e-3\n1,,nan\r\n2, +4 ,NaN", "data.csv");
  EXPECT_EQ(table.columns, (std::vector<std::string>{"time_s", "a b", "c"}));
  ASSERT_EQ(table.rows(), 3);
  EXPECT_EQ(table.values(0, 1), 1.5);
  EXPECT_EQ(table.values(0, 2), -2e-3);
  EXPECT_TRUE(std::isnan(table.values(1, 1)));
  EXPECT_TRUE(std::isnan(table.values(1, 2)));
  EXPECT_EQ(table.values(2, 1), 4.0);
  EXPECT_TRUE(std::isnan(table.values(2, 2)));
  EXPECT_EQ(table.column("time_s"), Eigen::Vector3d(0, 1, 2));
  EXPECT_EQ(table.find("c"), 2);
  EXPECT_FALSE(table.find("d"));
}

TEST(Csv, AcceptsByteOrderMarkQuotedNamesAndBlankEnd) {
  const Table table = parse_csv("\xEF\xBB\xBF\"time_s\",\"T1\"\r\n1,2\r\n\r\n  \n", "data.csv");
  EXPECT_EQ(table.columns, (std::vector<std::string>{"time_s", "T1"}));
  EXPECT_EQ(table.rows(), 1);
}

TEST(Csv, HeaderAloneHasNoRows) {
  const Table table = parse_csv("time_s,a\n", "data.csv");
  EXPECT_EQ(table.rows(), 0);
  EXPECT_EQ(table.values.cols(), 2);
}

TEST(Csv, BlankLineOfASingleColumnIsAMissingValue) {
  const Table table = parse_csv("a\n1\n\n3\n", "data.csv");
  ASSERT_EQ(table.rows(), 3);
  EXPECT_TRUE(std::isnan(table.values(1, 0)));
}

TEST(Csv, NumbersAreExactlyWhatIsWritten) {
  const Table table = parse_csv("a,b,c,d\n0.1,1e-320,123456789012345678,1e-400\n", "data.csv");
  EXPECT_EQ(table.values(0, 0), 0.1);
  EXPECT_EQ(table.values(0, 1), 1e-320);
  EXPECT_EQ(table.values(0, 2), 123456789012345678.0);
  EXPECT_EQ(table.values(0, 3), 0.0);
}

TEST(Csv, RefusalsSayWhere) {
  expect_holds(refusal(""), {"data.csv", "empty file"});
  expect_holds(refusal(" \n\n"), {"empty file"});
  expect_holds(refusal("a,,b\n"), {"data.csv:1 column 2", "no name"});
  expect_holds(refusal("a,b,a\n"), {"data.csv:1 column 3", "'a' a second time"});
  expect_holds(refusal("a;b\n1;2\n"), {"data.csv:1", "commas"});
  expect_holds(refusal("a,b\n1,2\n3\n"), {"data.csv:3", "1 cells", "2"});
  expect_holds(refusal("a,b\n1,2,3\n"), {"data.csv:2", "more than 2 cells"});
  expect_holds(refusal("a,b\n1,2\n\n3,4\n"), {"data.csv:3"});
  expect_holds(refusal("a,b\n1,2\n3,x4\n"), {"data.csv:3 b", "'x4'"});
}

TEST(Csv, RefusesWhatIsNoFiniteNumber) {
  for (const char* cell : {"1.2.3", "1,5e", "12a", "inf", "-inf", "1e400", "0x10", "--1", "+-1", "+", "-", "nan(1)",
                           "1 2", "1e", "\"1\"", "na"}) {
    EXPECT_FALSE(refusal(std::string("a,b\n") + cell + ",0\n").empty()) << cell;
  }
}

TEST(Csv, UnknownColumnNamesTheNearest) {
  const Table table = parse_csv("time_s,spindle.speed_rpm\n0,1\n", "data.csv");
  expect_holds(message_of<InputError>([&] { table.column("spindel.speed_rpm"); }),
               {"data.csv", "spindel.speed_rpm", "nearest is spindle.speed_rpm"});
}

TEST(Csv, RequireCompleteNamesTheLine) {
  const Table table = parse_csv("time_s,a\n0,1\n1,\n", "data.csv");
  EXPECT_NO_THROW(table.require_complete("time_s"));
  expect_holds(message_of<InputError>([&] { table.require_complete("a"); }), {"data.csv:3 a", "missing"});
}

TEST(Csv, TimeMustRise) {
  const auto problem = [](const std::string& text) {
    return message_of<InputError>([&] { require_time_column(parse_csv(text, "data.csv")); });
  };
  EXPECT_EQ(problem("time_s,a\n-1,0\n0,\n0.5,0\n"), "");
  EXPECT_EQ(problem("time_s\n"), "");
  expect_holds(problem("time_s\n0\n2\n1\n"), {"data.csv:4 time_s", "time runs backwards", "1 s after 2 s"});
  expect_holds(problem("time_s\n0\n0\n"), {"data.csv:3", "stands still"});
  expect_holds(problem("time_s,a\n0,1\n,1\n"), {"data.csv:3 time_s", "missing"});
  expect_holds(problem("a,time_s\n0,1\n"), {"data.csv:1", "'a'", "time_s"});
}

TEST(Csv, SeventeenDigitsComeBackExactly) {
  const TemporaryFolder folder;
  Table table;
  table.columns = {"time_s", "value", "µm/m"};
  table.values.resize(500, 3);
  std::mt19937_64 random(7);
  for (Eigen::Index i = 0; i < table.values.size(); ++i) {
    double value = std::numeric_limits<double>::infinity();
    while (!std::isfinite(value)) value = std::bit_cast<double>(random());
    table.values.data()[i] = value;
  }
  table.values(3, 1) = std::numeric_limits<double>::quiet_NaN();
  write_csv(folder / "deep/table.csv", table, 17);
  const Table back = read_csv(folder / "deep/table.csv");
  EXPECT_EQ(back.columns, table.columns);
  ASSERT_EQ(back.rows(), table.rows());
  for (Eigen::Index i = 0; i < table.values.size(); ++i) {
    const double a = table.values.data()[i];
    const double b = back.values.data()[i];
    EXPECT_TRUE(a == b || (std::isnan(a) && std::isnan(b))) << a << " " << b;
  }
  EXPECT_TRUE(std::isnan(back.values(3, 1)));
}

TEST(Csv, DigitsAreSignificant) {
  const TemporaryFolder folder;
  Table table;
  table.columns = {"a"};
  table.values = Eigen::MatrixXd::Constant(1, 1, 1.0 / 3.0);
  write_csv(folder / "t.csv", table, 3);
  EXPECT_EQ(read_file(folder / "t.csv"), "a\n0.333\n");
}

TEST(Csv, NamesThatCannotBeReadAgainAreNotWritten) {
  const TemporaryFolder folder;
  for (const char* name : {"", "a,b", "a;b", "a\nb", " a", "a\""}) {
    Table table;
    table.columns = {name};
    table.values.resize(0, 1);
    EXPECT_THROW(write_csv(folder / "t.csv", table), InputError) << name;
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Csv, MissingFileIsAnInputError) {
  expect_holds(message_of<InputError>([] { read_csv("/nowhere/data.csv"); }), {"/nowhere/data.csv", "read"});
}

// A reader whose time grows faster than its rows would not end within the time of a suite.
TEST(Csv, MillionRowsAreReadWhole) {
  std::string text = "time_s,a,b,c,d\n";
  for (int i = 0; i < 1000000; ++i) {
    text += std::to_string(i) + ",21.2534,-0.0012345,1.5e-6,6000\n";
  }
  const Table table = parse_csv(text, "data.csv");
  ASSERT_EQ(table.rows(), 1000000);
  EXPECT_EQ(table.values.col(0), Eigen::VectorXd::LinSpaced(1000000, 0.0, 999999.0));
  for (const auto& [column, value] : {std::pair{1, 21.2534}, {2, -0.0012345}, {3, 1.5e-6}, {4, 6000.0}}) {
    EXPECT_TRUE((table.values.col(column).array() == value).all()) << column;
  }
}

// A binary file by mistake: no byte of it upsets the terminal.
TEST(Csv, RubbishIsNotEchoed) {
  for (const std::string text : {"a,\x82\x1b[2J\n1,\x9b\x31x\n", "a,b\n1,\x1b\xff\n"}) {
    try {
      parse_csv(text, "data.csv");
      ADD_FAILURE() << "accepted";
    } catch (const InputError& error) {
      for (const char c : std::string(error.what())) EXPECT_TRUE(c >= 0x20 && c < 0x7f) << error.what();
    }
  }
}

TEST(Csv, TimesSince1970KeepTheirMilliseconds) {
  Table table;
  table.columns = {"time_s", "x"};
  table.values.resize(2, 2);
  table.values << 1764381660.125, 1.0 / 3.0, 1764381660.625, 2.0;
  const TemporaryFolder folder;
  write_csv(folder / "t.csv", table, 9);
  const Table read = read_csv(folder / "t.csv");
  EXPECT_NEAR(read.values(1, 0) - read.values(0, 0), 0.5, 1e-6);
  EXPECT_NE(read_file(folder / "t.csv").find(",0.333333333\n"), std::string::npos);
}

}  // namespace
}  // namespace thermotwin::core
