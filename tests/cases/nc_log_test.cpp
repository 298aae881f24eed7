// SPDX-License-Identifier: GPL-3.0-or-later
// `nc --log` and `nc --process`: times and powers of a control's log, and the heat of the cutting process.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>

#include "core/table.h"
#include "tests/cases/nc_programs.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

using nlohmann::json;

constexpr const char* cutting = "G21 G90 G61.1\nT1 M6\nM3 S6000\nN10 G1 X20 F600\nN20 X0\nN30 G0 Z50\nN40 M0\nM2\n";
constexpr const char* heat =
    "schema = 1\n[[heat]]\ndrive = \"chips\"\nshare = 0.6\n[[heat]]\ndrive = \"workpiece\"\nshare = 0.1\n"
    "[[tool]]\nnumber = 1\npower_W = 800\n";

class NcLog : public testing::Test {
protected:
  void SetUp() override {
    if (!has_interpreter()) GTEST_SKIP() << "the program was built without LinuxCNC's interpreter";
    toy.write("part.ngc", cutting);
    toy.write("control.toml", "schema = 1\ntool_change_s = 4\nspindle_start_s = 0\n[[tool]]\nnumber = 1\n");
    toy.write("process.toml", heat);
  }
  Result run(const std::string& model, std::vector<std::string> more) {
    std::vector<std::string> arguments = {"nc",    model, toy.file("part.ngc"), "--control", toy.file("control.toml"),
                                          "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return toy.run(arguments);
  }
  json summary(const std::vector<std::string>& more) {
    const Result result = run(toy.file("machine.toml"), more);
    EXPECT_EQ(result.status, 0) << result.err;
    return result.status == 0 ? json::parse(result.out) : json();
  }
  core::Table rows() const { return core::parse_csv(after_first_line(read(toy.result("rows.csv"))), "rows.csv"); }
  /// Sources of chips and workpiece.
  void add_sources() const {
    toy.edit("machine.toml", "[[sensor]]\nid = \"T1\"",
             "[[source]]\nid = \"chips\"\ndrive = \"chips\"\nplace = [{surface = \"bed.top\"}]\n"
             "[[source]]\nid = \"cut\"\ndrive = \"workpiece\"\nplace = [{surface = \"table.top\"}]\n"
             "[[sensor]]\nid = \"T1\"");
  }
  Toy toy;
};

// 4 s tool change, cuts of 3 and 5 s, a stop of 60 s; the rapid move before it takes the rest up to its line.
TEST_F(NcLog, TimesAreThoseOfTheLog) {
  toy.write("log.csv", "time_s,block\n1000,10\n1003,20\n1008,30\n1009,40\n1069,40\n");
  const json with = summary({"--log", toy.file("log.csv"), "--row-s", "1"});
  EXPECT_NEAR(with["duration_s"].get<double>(), 4.0 + 3.0 + 5.0 + 1.0, 1e-9) << "one line in a row is one event";
  EXPECT_NEAR(with["cutting_s"].get<double>(), 8.0, 1e-9);
  EXPECT_NEAR(with["rapid_s"].get<double>(), 1.0, 1e-9);
  EXPECT_EQ(rows().rows(), 1 + 13);
  toy.write("log.csv", "time_s,line\n1000,4\n1003,5\n1008,6\n1009,7\n1069,8\n");
  const json stops = summary({"--log", toy.file("log.csv"), "--row-s", "1"});
  EXPECT_NEAR(stops["pause_s"].get<double>(), 4.0 + 60.0, 1e-9) << "the stop of line 7, of which the planner has 0 s";
  EXPECT_NEAR(stops["travel_rows"]["X_mm"].get<double>(), 40.0, 1e-9) << "ways stay those of the program";
}

TEST_F(NcLog, ALogOfAnotherProgramIsRefused) {
  toy.write("log.csv", "time_s,line\n0,4\n5,11\n");
  const Result result = run(toy.file("machine.toml"), {"--log", toy.file("log.csv")});
  EXPECT_EQ(result.status, 3);
  for (const char* words : {"log.csv:3 line", "11", "part.ngc, 1 to 8"}) EXPECT_SAYS(result.err, words);
  toy.write("log.csv", "time_s,block\n0,20\n5,10\n");
  const Result back = run(toy.file("machine.toml"), {"--log", toy.file("log.csv")});
  EXPECT_EQ(back.status, 3);
  for (const char* words : {"log.csv:3 block", "10 after 20", "in the order"}) EXPECT_SAYS(back.err, words);
  EXPECT_FALSE(std::filesystem::exists(toy.result("rows.csv"))) << "nothing is written";
}

TEST_F(NcLog, ProcessPowerIsInTheRowsAndInTheLoad) {
  add_sources();
  toy.write("log.csv", "time_s,line\n0,4\n8,6\n10,8\n");
  summary({"--log", toy.file("log.csv"), "--process", toy.file("process.toml"), "--row-s", "4"});
  const core::Table table = rows();
  ASSERT_EQ(table.rows(), 1 + 4);
  const Eigen::VectorXd chips = table.column("chips.power_W"), workpiece = table.column("workpiece.power_W");
  EXPECT_TRUE(chips.isApprox((Eigen::VectorXd(5) << 0, 0, 480, 480, 0).finished())) << chips.transpose();
  EXPECT_TRUE(workpiece.isApprox((Eigen::VectorXd(5) << 0, 0, 80, 80, 0).finished())) << workpiece.transpose();
  toy.write("loads/cut.toml", read(toy.result("load.toml")));
  const Result simulated = toy.run({"simulate", toy.path(), "--load", "cut"});
  EXPECT_EQ(simulated.status, 0) << simulated.err;
  const core::Table heat_flow = core::read_csv(toy.result("simulate/cut/heat.csv"));
  // Powers since the row before: the first row has none.
  const Eigen::VectorXd flow = heat_flow.column("source.chips.power_W").tail(heat_flow.rows() - 1);
  EXPECT_NEAR(flow.maxCoeff(), 480.0, 1e-6);
}

TEST_F(NcLog, MeasuredSpindlePowerReplacesThatOfTheTools) {
  add_sources();
  // Before the first row nothing is known, whatever the clock of the log says.
  toy.write("part.ngc", "G21 G90 G61.1\nT1 M6\nM3 S6000\nN10 G1 X20 F600\nN20 X0\nM2\n");
  toy.write("log.csv", "time_s,line,spindle_power_W\n0,5,1000\n60,6,0\n");
  summary({"--log", toy.file("log.csv"), "--process", toy.file("process.toml"), "--row-s", "4"});
  EXPECT_NEAR(rows().column("chips.power_W").head(2).maxCoeff(), 0.0, 1e-9);
  EXPECT_LT(rows().column("chips.power_W")[2], 600.0) << "4 to 8 s: the first cut until 6.0 s without power";
  toy.write("part.ngc", cutting);
  toy.write("log.csv", "time_s,line,spindle_power_W\n0,4,100\n2,4,300\n8,6,50\n10,8,0\n");
  summary({"--log", toy.file("log.csv"), "--process", toy.file("process.toml"), "--row-s", "4"});
  const Eigen::VectorXd chips = rows().column("chips.power_W");
  EXPECT_NEAR(chips[2], 0.6 * 200.0, 1e-9);
  EXPECT_NEAR(chips[3], 0.6 * 300.0, 1e-9);
  EXPECT_NEAR(chips[4], 0.0, 1e-9) << "nothing is cut in a rapid move";
}

TEST_F(NcLog, ProcessHeatNeedsItsSources) {
  const Result result = run(toy.file("machine.toml"), {"--process", toy.file("process.toml")});
  EXPECT_EQ(result.status, 3);
  for (const char* words : {"process.toml:", "chips", "one of: spindle"}) EXPECT_SAYS(result.err, words);
}

// The toy's nose takes a fifth of what its spindle's drive is given.
TEST_F(NcLog, ProcessHeatMovesTheToolInTheModel) {
  toy.write("process.toml",
            "schema = 1\n[[heat]]\ndrive = \"spindle\"\nshare = 1\n[[tool]]\nnumber = 1\npower_W = 5000\n");
  toy.write("log.csv", "time_s,line\n0,4\n600,5\n1200,6\n");
  const auto error = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"--log", toy.file("log.csv")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Result result = run(toy_model(), arguments);
    EXPECT_EQ(result.status, 0) << result.err;
    const Eigen::VectorXd dz = core::read_csv(toy.result("blocks.csv")).column("dz_um");
    return dz[dz.size() - 2];
  };
  const double without = error({}), with = error({"--process", toy.file("process.toml")});
  EXPECT_GT(std::abs(with - without), 1.0) << with << " and " << without;
}

}  // namespace
}  // namespace thermotwin::cases
