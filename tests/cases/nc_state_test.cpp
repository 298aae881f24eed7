// SPDX-License-Identifier: GPL-3.0-or-later
// `nc --state`: the error along a program begins from the machine as `compensate --state` saved it.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "core/table.h"
#include "tests/cases/nc_programs.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;

/// Two hours of work with the spindle, then no work. With 123 rows the last ones end no step of the state.
/// @param column, value  one more, in the second hour
std::string morning(int rows = 123, const std::string& column = "", const std::string& value = "") {
  const std::string comma = column.empty() ? "" : ",";
  std::string text = "time_s,spindle.speed_rpm,axis.X.position_mm,axis.Z.position_mm,axis.X.feed_mm_min,air.T_C" +
                     comma + column + "\n";
  for (int i = 0; i <= rows; ++i) {
    const bool works = i < 119;
    text += fmt::format("{},{},40,60,{},{:.3f}{}{}\n", i <= 120 ? 60 * i : 7200 + 7 * (i - 120), works ? 9000 : 0,
                        works ? 6000 : 0, 20.0 + i / 60.0, comma, i < 60 ? "" : value);
  }
  return text;
}

/// The columns of numbers: all but the status, the last one.
core::Table numbers_of(const std::string& csv) {
  std::string text;
  std::istringstream in(csv);
  for (std::string line; std::getline(in, line);) text += line.substr(0, line.rfind(',')) + "\n";
  return core::parse_csv(text, "offsets.csv");
}

class NcState : public testing::Test {
protected:
  void SetUp() override {
    if (!has_interpreter()) GTEST_SKIP() << "the program was built without LinuxCNC's interpreter";
  }
  core::Table offsets(const std::string& rows, const std::vector<std::string>& more = {},
                      const std::string& state = "state") {
    std::vector<std::string> arguments = {"compensate", toy_model(), "--state", toy.file(state)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Result result = thermotwin(arguments, rows);
    EXPECT_EQ(result.status, 0) << result.err;
    return numbers_of(result.out);
  }
  Result nc(const std::string& text, std::vector<std::string> more) {
    toy.write("part.ngc", text);
    std::vector<std::string> arguments = {"nc", toy_model(), toy.file("part.ngc"), "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return toy.run(arguments);
  }
  core::Table blocks(const std::string& text, const std::vector<std::string>& more) {
    const Result result = nc(text, more);
    EXPECT_EQ(result.status, 0) << result.err;
    return core::read_csv(toy.result("blocks.csv"));
  }
  std::string state() const { return toy.file("state"); }
  Toy toy;
};

/// rows.csv with the air as it was last measured; `compensate` takes its default otherwise.
std::string with_air(const std::string& rows, double air_C) {
  std::string text;
  std::istringstream in(rows);
  for (std::string line; std::getline(in, line);)
    text += line + (line.starts_with("#") ? "" : line.starts_with("t") ? ",air.T_C" : fmt::format(",{}", air_C)) + "\n";
  return text;
}

double last(const core::Table& table, const std::string& column) { return table.column(column)[table.rows() - 1]; }
std::string of(const std::string& what, char axis) { return fmt::format("{}_{}_um", what, axis); }

// Eleven minutes: M3 takes a second, a move of 120 mm at 0.2 m/s from rest to rest with 3 m/s2 two thirds of one.
constexpr const char* work =
    "G21 G90 G61.1\nM3 S12000\nG4 P59\no1 repeat [450]\nG1 X-80 F12000\nG1 X40\no1 endrepeat\nM2\n";
// A second in which the axes all but stand.
constexpr const char* touch = "G21 G91\nG1 X0.01 F600\nM2\n";

// The model beside the control says the same of the rows once they have happened. Shorter steps change little.
TEST_F(NcState, TheErrorIsThatOfTheCompensatorOnTheSameRows) {
  offsets(morning());
  const std::string before = read(state());
  fs::copy_file(state(), toy.file("copy"));
  const core::Table along = blocks(work, {"--state", state(), "--row-s", "60"});
  EXPECT_EQ(read(state()), before) << "nc goes on from a copy";
  const core::Table after = offsets(with_air(read(toy.result("rows.csv")), 22.05));
  const core::Table finer = blocks(work, {"--state", toy.file("copy"), "--row-s", "10"});
  EXPECT_NEAR(last(after, "time_s"), 7221.0 + 60.0 + 660.0, 1e-6);
  double moved = 0.0;
  for (const char axis : {'x', 'y', 'z'}) {
    const char upper = static_cast<char>(axis - 'a' + 'A');
    const double offset = last(along, of("offset", upper));
    EXPECT_NEAR(offset, last(after, of("offset", axis)), 2e-3) << axis;
    EXPECT_NEAR(last(along, of("std", upper)), last(after, of("std", axis)), 5e-3) << axis;
    EXPECT_NEAR(offset, last(finer, of("offset", upper)), 0.02 * std::abs(offset) + 0.1) << axis;
    moved = std::max(moved, std::abs(offset - along.column(of("offset", upper))[0]));
  }
  EXPECT_GT(moved, 2.0) << "the program heats too little to show anything";
}

// Error, deviation and axes are those of the machine when the state was saved; what was probed holds as well.
TEST_F(NcState, AProgramBeginsWithTheMachineAsItIs) {
  const core::Table present_unprobed = offsets(morning(120), {}, "unprobed");
  const core::Table present = offsets(morning(120, "probe_dz_um", "-15"), {"--probe-std", "0.2"});
  const core::Table first = blocks(touch, {"--state", state(), "--after", "0"});
  const core::Table unprobed = blocks(touch, {"--state", toy.file("unprobed"), "--after", "0"});
  const core::Table cold = blocks(touch, {"--start", "X=40,Z=60"});
  for (const char axis : {'x', 'y', 'z'}) {
    const char upper = static_cast<char>(axis - 'a' + 'A');
    EXPECT_NEAR(unprobed.column(of("offset", upper))[0], last(present_unprobed, of("offset", axis)), 0.01) << axis;
    EXPECT_NEAR(unprobed.column(of("std", upper))[0], last(present_unprobed, of("std", axis)), 0.01) << axis;
    // The value probed with the last row takes effect behind it.
    EXPECT_NEAR(first.column(of("offset", upper))[0], last(present, of("offset", axis)), 0.3) << axis;
    EXPECT_NEAR(first.column(of("std", upper))[0], last(present, of("std", axis)), 0.3) << axis;
  }
  const auto z = [](const core::Table& table) { return table.column("offset_Z_um")[0]; };
  EXPECT_GT(std::abs(z(unprobed) - z(cold)), 10.0);
  EXPECT_GT(std::abs(z(first) - z(unprobed)), 1.0);
  EXPECT_NEAR(first.column("X_mm")[0], 40.01, 1e-6);
  EXPECT_NEAR(first.column("Z_mm")[0], 60.0, 1e-6);
}

// Of a night the machine was off; of a minute it stood.
TEST_F(NcState, TimeBetweenStateAndProgramCools) {
  offsets(morning());
  const auto size = [&](const char* after) {
    const core::Table first = blocks(touch, {"--state", state(), "--after", after});
    return std::abs(first.column("offset_Z_um")[0]);
  };
  const double now = size("0"), soon = size("60"), night = size("28800");
  EXPECT_GT(now, 5.0);
  EXPECT_NEAR(soon, 0.8 * now, 0.2 * now);
  EXPECT_LT(night, 0.5 * now);
  EXPECT_EQ(nc(touch, {"--state", state(), "--after", "1e6"}).status, 2);
}

// A program has no measured powers: five kilowatts of the morning do not go on while the spindle stands.
TEST_F(NcState, AMeasuredPowerEndsWithTheState) {
  offsets(morning(120, "spindle.power_W", "5000"));
  const core::Table standing =
      blocks("G21 G91\nG1 X0.01 F600\nG4 P1800\nG1 X0.01 F600\nM2\n", {"--state", state(), "--after", "0"});
  const Eigen::VectorXd offset = standing.column("offset_Z_um");
  EXPECT_GT(std::abs(offset[0]), 10.0);
  EXPECT_LT(std::abs(offset[1]), 0.6 * std::abs(offset[0]));
}

TEST_F(NcState, AStateOfOtherOptionsIsRefused) {
  offsets(morning(), {"--step", "30"});
  Result result = nc(touch, {"--state", state()});
  EXPECT_EQ(result.status, 3);
  EXPECT_SAYS(result.err, "with other options");
  EXPECT_SAYS(result.err, "state");
  EXPECT_EQ(nc(touch, {"--state", state(), "--step", "30"}).status, 0);
  fs::remove_all(toy.out());
  result = nc(touch, {"--state", toy.file("missing")});
  EXPECT_EQ(result.status, 3);
  EXPECT_SAYS(result.err, "missing");
  toy.write("short", read(state()).substr(0, 300));
  EXPECT_EQ(nc(touch, {"--state", toy.file("short")}).status, 3);
  EXPECT_FALSE(fs::exists(toy.result("rows.csv")));
  result = toy.run({"nc", toy.file("machine.toml"), toy.file("part.ngc"), "--state", state()});
  EXPECT_EQ(result.status, 2);
  EXPECT_SAYS(result.err, "reduced model");
}

}  // namespace
}  // namespace thermotwin::cases
