// SPDX-License-Identifier: GPL-3.0-or-later
// `nc`: programs in, time, loads and errors out, through the built program and the helper beside it. Where LinuxCNC's
// interpreter is not installed the tests are skipped, unless THERMOTWIN_LINUXCNC says that it must be there.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "core/config.h"
#include "core/table.h"
#include "tests/cases/nc_programs.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
constexpr double pi = std::numbers::pi;

class Nc : public testing::Test {
protected:
  void SetUp() override {
    if (!has_interpreter()) GTEST_SKIP() << "the program was built without LinuxCNC's interpreter";
  }
  /// Runs a program on the toy's machine.toml without a model. @return the summary
  json loads(const std::string& text, std::vector<std::string> more = {}) {
    toy.write("part.ngc", text);
    std::vector<std::string> arguments = {"nc", toy.file("machine.toml"), toy.file("part.ngc"), "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Result result = toy.run(arguments);
    EXPECT_EQ(result.status, 0) << result.err;
    return result.status == 0 ? json::parse(result.out) : json();
  }
  Result refused(const std::string& text, std::vector<std::string> more = {}) {
    toy.write("part.ngc", text);
    std::vector<std::string> arguments = {"nc", toy.file("machine.toml"), toy.file("part.ngc")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    Result result = toy.run(arguments);
    EXPECT_EQ(result.status, 3) << text << result.out << result.err;
    EXPECT_FALSE(fs::exists(toy.result("rows.csv")));
    return result;
  }
  Toy toy;
};

// A long feed move: from rest to rest with the profile's acceleration.
TEST_F(Nc, DurationOfALongMoveIsThatOfATrapezoid) {
  const json summary = loads("G21 G90 G61.1\nG1 X100 F6000\nG1 X0\nM2\n");
  const double one = 0.1 / 0.1 + 0.1 / 3.0;  // s/v + v/a: 100 mm at 100 mm/s, 3 m/s2
  EXPECT_NEAR(summary["duration_s"].get<double>(), 2.0 * one, 1e-9);
  EXPECT_EQ(summary["feeds"], 2);
}

// A short one never reaches its feed: 2 sqrt(s / a).
TEST_F(Nc, AShortMoveIsATriangle) {
  const json summary = loads("G21 G90 G61.1\nG0 X0.1\nM2\n");
  EXPECT_NEAR(summary["duration_s"].get<double>(), 2.0 * std::sqrt(1e-4 / 3.0), 1e-9);
}

// At a right angle with a tolerance of 0.02 mm: v^2 = a d c / (1 - c), c = cos 45 deg.
TEST_F(Nc, ACornerIsTakenAtTheSpeedOfItsTolerance) {
  const json summary = loads("G21 G90 G64 P0.02\nG1 X50 F6000\nY30\nM2\n");
  const double a = 3.0, v = 0.1, c = std::sqrt(0.5), corner = std::sqrt(a * 2e-5 * c / (1.0 - c));
  const auto side = [&](double s) {
    const double slow = (v * v - corner * corner) / (2.0 * a), fast = v * v / (2.0 * a);
    return v / a + (v - corner) / a + (s - slow - fast) / v;
  };
  EXPECT_NEAR(summary["duration_s"].get<double>(), side(0.05) + side(0.03), 1e-9);
}

// Arcs in the three planes, a helix and a whole circle: distances by hand, and those of the rows to 1e-9.
TEST_F(Nc, TravelIsExactAndThatOfTheRows) {
  const json summary = loads(
      "G21 G90 G17 F3000\nG0 X0 Y0 Z50\nG1 X10\nG2 X10 Y0 I-10 J0\nG3 X0 Y10 Z55 I-10\nG18 G2 X20 Z55 I10 K0\n"
      "G19 G3 Y30 Z75 J0 K20\nG1 B30 C-400\nM2\n",
      {"--row-s", "0.7"});
  // X: 10, circle 4 r, quarter r, half circle 2 r. Y: 4 r, quarter, quarter. Z: 50, helix 5, half circle, quarter.
  const std::vector<std::pair<const char*, double>> expected = {
      {"X_mm", 10 + 40 + 10 + 20}, {"Y_mm", 40 + 10 + 20}, {"Z_mm", 50 + 5 + 20 + 20}, {"B_deg", 30}, {"C_deg", 400}};
  for (const auto& [name, value] : expected) {
    EXPECT_NEAR(summary["travel"][name].get<double>(), value, 1e-9) << name;
    EXPECT_NEAR(summary["travel_rows"][name].get<double>(), value, 1e-9) << name;
  }
  const core::Table rows = core::parse_csv(after_first_line(read(toy.result("rows.csv"))), "rows.csv");
  const Eigen::VectorXd time = rows.column("time_s");
  EXPECT_NEAR(time[time.size() - 1], summary["duration_s"].get<double>(), 1e-9);
  for (const auto& [name, value] : expected) {
    const std::string axis(name, 1), unit = std::string(name).substr(2);
    const Eigen::VectorXd feed = rows.column("axis." + axis + ".feed_" + unit + "_min");
    double distance = 0.0;
    for (Eigen::Index i = 1; i < time.size(); ++i) distance += feed[i] * (time[i] - time[i - 1]) / 60.0;
    EXPECT_NEAR(distance, value, 1e-9) << name;
  }
  const Eigen::VectorXd low = rows.column("axis.X.low_mm"), high = rows.column("axis.X.high_mm");
  double lowest = 0.0, highest = 0.0;
  for (Eigen::Index i = 0; i < low.size(); ++i) {
    if (low[i] < lowest) lowest = low[i];
    if (high[i] > highest) highest = high[i];
  }
  EXPECT_NEAR(lowest, -10.0, 1e-9) << "the circle reaches beyond the ends of its blocks";
  EXPECT_NEAR(highest, 20.0, 1e-9);
}

TEST_F(Nc, RowsHaveTheMeansOfSpindleFluidAndPauses) {
  toy.write("control.toml",
            "schema = 1\ntool_change_s = 4\nspindle_start_s = 0\n[[tool]]\nnumber = 2\nlength_mm = 10\n");
  const json summary = loads("G21 G90\nT2 M6\nM3 S6000\nG4 P6\nM8\nG4 P5\nM9 M5\nM2\n",
                             {"--control", toy.file("control.toml"), "--row-s", "5"});
  EXPECT_NEAR(summary["duration_s"].get<double>(), 15.0, 1e-9);
  EXPECT_EQ(summary["tool_changes"], 1);
  const core::Table rows = core::parse_csv(after_first_line(read(toy.result("rows.csv"))), "rows.csv");
  ASSERT_EQ(rows.rows(), 4);
  const Eigen::VectorXd rpm = rows.column("spindle.speed_rpm"), fluid = rows.column("cutting_fluid.on");
  EXPECT_NEAR(rpm[1], 6000 * 0.2, 1e-6);
  EXPECT_NEAR(rpm[2], 6000, 1e-6);
  EXPECT_NEAR(fluid[1], 0.0, 1e-9);
  EXPECT_NEAR(fluid[3], 1.0, 1e-9);
  const core::Table operations = core::read_csv(toy.result("operations.csv"));
  ASSERT_EQ(operations.rows(), 1);
  EXPECT_NEAR(operations.column("fluid_share")[0], 5.0 / 15.0, 1e-5);
  EXPECT_NEAR(operations.column("mean_spindle_rpm")[0], 6000 * 11.0 / 15.0, 0.1);
}

// Work offset, rotation, inches and a tool length end in the axes' own coordinates.
TEST_F(Nc, OffsetsUnitsAndRotationReachTheAxes) {
  toy.write("control.toml",
            "schema = 1\n[[tool]]\nnumber = 1\nlength_mm = 12\n[[work_offset]]\nnumber = 2\nX_mm = 10\nY_mm = -5\n"
            "Z_mm = 20.00001\nC_deg = 0.00001\nrotation_deg = 90\n");
  loads("G21 G90\nT1 M6\nG43 H1\nG55\nG20\nG0 X1 Y0 Z1\nM2\n", {"--control", toy.file("control.toml")});
  const core::Table rows = core::parse_csv(after_first_line(read(toy.result("rows.csv"))), "rows.csv");
  const Eigen::Index last = rows.rows() - 1;
  EXPECT_NEAR(rows.column("axis.X.position_mm")[last], 10.0, 1e-9);
  EXPECT_NEAR(rows.column("axis.Y.position_mm")[last], -5.0 + 25.4, 1e-9);
  EXPECT_NEAR(rows.column("axis.Z.position_mm")[last], 20.00001 + 25.4 + 12.0, 1e-9);
}

// Tool centre point control: the rotated table carries the point away, and the linear axes follow it. The toy's B
// turns about (0, ., -50), C about Z; the tool's point at home is at Z 20, its tip 40 mm below.
TEST_F(Nc, ToolCentrePointControlFollowsTheTable) {
  toy.write("control.toml",
            "schema = 1\n[[word]]\nword = \"G43.4\"\naction = \"tcp_on\"\nby = \"G43\"\n[[tool]]\nnumber = "
            "1\nlength_mm = 40\n");
  const json summary = loads("G21 G90\nT1 M6\nG0 Z60\nG43.4 H1\nG0 X30 Y0 Z10\nG1 B30 F1000\nC90\nM2\n",
                             {"--control", toy.file("control.toml")});
  ASSERT_FALSE(summary.is_null());
  const core::Table rows = core::parse_csv(after_first_line(read(toy.result("rows.csv"))), "rows.csv");
  const Eigen::Index last = rows.rows() - 1;
  // The point (30, 0, 20 + 10) turned by C 90 about Z: (0, 30, 30); by B 30 about Y at Z -50: x = 80 sin 30,
  // z = -50 + 80 cos 30. The tool's point must be there; at home it is at Z 20.
  EXPECT_NEAR(rows.column("axis.X.position_mm")[last], 80.0 * std::sin(pi / 6), 1e-9);
  EXPECT_NEAR(rows.column("axis.Y.position_mm")[last], 30.0, 1e-9);
  EXPECT_NEAR(rows.column("axis.Z.position_mm")[last], -70.0 + 40.0 + 80.0 * std::cos(pi / 6), 1e-9);
  EXPECT_NEAR(summary["travel"]["C_deg"].get<double>(), 90.0, 1e-9);
  EXPECT_NEAR(summary["travel_rows"]["X_mm"].get<double>(), summary["travel"]["X_mm"].get<double>(), 1e-9);
}

TEST_F(Nc, FanucsWordsAreMapped) {
  toy.write("control.toml", "schema = 1\n[[tool]]\nnumber = 1\n");
  const json summary =
      loads("%\nO1234\nG21 G90\nG5.1 Q1 R5\nG0 X1\nG5 P10000\nG1 X2 F100\nG5 P0\nM30\n%\n", {"--control", "fanuc"});
  EXPECT_EQ(summary["moves"], 2);
  toy.write("part.ngc", "G21\nG0 X1\nG68.2 X0 Y0 Z0 I0 J0 K0\nM30\n");
  const Result tilted = toy.run({"nc", toy.file("machine.toml"), toy.file("part.ngc"), "--control", "fanuc"});
  EXPECT_EQ(tilted.status, 3);
  for (const char* words : {"part.ngc:3", "G68.2", "tilted working plane"}) EXPECT_SAYS(tilted.err, words);
}

// Without blanks, a coordinate behind a G word is no part of its number.
TEST_F(Nc, WordsNeedNoBlanks) {
  for (const char* control : {"linuxcnc", "fanuc"}) {
    const json summary = loads("G21G90\nG0X5Y1\nG0X45\nG0X8.\nM2\n", {"--control", control});
    EXPECT_EQ(summary["moves"], 3) << control;
    EXPECT_NEAR(summary["travel"]["X_mm"].get<double>(), 45 + 37, 1e-9) << control;
  }
}

// Words of the profile stand beside comments and words that are left out with them.
TEST_F(Nc, WordsOfAProfileHoldBesideComments) {
  toy.write("control.toml",
            "schema = 1\n[[word]]\nword = \"G43.4\"\naction = \"tcp_on\"\nby = \"G43\"\nwith = \"Q\"\n"
            "[[word]]\nword = \"M21\"\naction = \"skip\"\n[[tool]]\nnumber = 1\nlength_mm = 40\n");
  const auto travel = [&](const std::string& behind) {
    return loads("G21 G90\nT1 M6\nG0 Z60\nG43.4 H1" + behind + "\nG0 X30 Y0 Z10\nG1 B30 C90 F1000\nM2\n",
                 {"--control", toy.file("control.toml")})["travel"]["X_mm"]
        .get<double>();
  };
  const double alone = travel("");
  EXPECT_GT(alone, 31.0) << "X follows the table";
  for (const char* behind : {" (tool 1)", " ; tool 1", " Q2 (tool 1) M21 (clamp)", " M21", " (tool 1)\r"})
    EXPECT_NEAR(travel(behind), alone, 1e-9) << behind;
}

// Exact path mode stops at the ends of moves, not between the lines that tool centre point control makes of one.
TEST_F(Nc, ExactPathDoesNotStopWithinAMove) {
  toy.write("control.toml", "schema = 1\n[[word]]\nword = \"M428\"\naction = \"tcp_on\"\n");
  const auto duration = [&](const std::string& mode) {
    return loads("G21 G90 " + mode + "\nG0 Z60\nM428\nG0 X30\nG1 B30 C90 F1000\nX10 B10 C0\nM2\n",
                 {"--control", toy.file("control.toml")})["duration_s"]
        .get<double>();
  };
  EXPECT_NEAR(duration("G61"), duration("G61.1"), 1e-9);
  EXPECT_LT(duration("G64 P0.02"), duration("G61"));
}

// Switched on with the table tilted, a move begins where the axes are: at X -65, Z 42.58 of the workpiece.
TEST_F(Nc, ToolCentrePointControlBeginsWhereTheAxesAre) {
  toy.write("control.toml", "schema = 1\n[[word]]\nword = \"M428\"\naction = \"tcp_on\"\n");
  const json summary = loads("G21 G90 G61.1\nG0 Z60\nG0 B30\nM428\nG1 X30 Y0 Z60 B30 C0 F600\nM2\n",
                             {"--control", toy.file("control.toml")});
  const double length = std::hypot(30.0 + 130.0 * std::sin(pi / 6), 60.0 + 70.0 - 130.0 * std::cos(pi / 6));
  EXPECT_NEAR(summary["cutting_s"].get<double>(), length / 10.0, 5e-3);
  const json turn = loads("G21 G90\nM428\nG0 X30\nG1 C360 F3600\nM2\n", {"--control", toy.file("control.toml")});
  EXPECT_NEAR(turn["travel"]["X_mm"].get<double>(), 30.0 + 4 * 30.0, 0.01) << "the table carries the point round";
  EXPECT_NEAR(turn["travel"]["Y_mm"].get<double>(), 4 * 30.0, 0.01);
}

// Each part begins where the one before ended.
TEST_F(Nc, PartsFollowOneAnother) {
  loads("G21 G91\nG0 X10\nM2\n", {"--repeat", "3"});
  const core::Table rows = core::parse_csv(after_first_line(read(toy.result("rows.csv"))), "rows.csv");
  EXPECT_NEAR(rows.column("axis.X.position_mm")[rows.rows() - 1], 30.0, 1e-9);
}

// A revolution, a helix, a thread and an arc that its radius limits: durations by hand, but for the acceleration.
TEST_F(Nc, FeedsOfAllKindsTakeTheirTime) {
  const auto cutting = [&](const std::string& text) {
    return loads("G21 G90 G61.1\nM3 S600\nG0 Z50\n" + text + "\nM2\n")["cutting_s"].get<double>();
  };
  EXPECT_NEAR(cutting("G95 G1 X50 F0.5"), 10.0, 0.01);
  EXPECT_NEAR(cutting("G3 X0 Y20 Z80 J10 F600"), std::hypot(10.0 * pi, 30.0) / 10.0, 0.02);
  EXPECT_NEAR(cutting("G33.1 Z40 K1"), 2.0, 0.02);
  const double speed = std::sqrt(0.87 * 3.0 * 1e-3);
  EXPECT_GE(cutting("G3 I1 F20000"), 2.0 * pi * 1e-3 / speed);
}

TEST_F(Nc, TheSpindleStartsOnce) {
  EXPECT_NEAR(loads("G21 G90\nM3 S1000.1\nS1000.1\nM3\nS1000.1\nM2\n")["pause_s"].get<double>(), 1.0, 1e-9);
  EXPECT_NEAR(loads("G21 G90\nM3 S1000.1\nS2000\nM2\n")["pause_s"].get<double>(), 2.0, 1e-9);
}

// Rounding of times makes no row, and load.toml is read whatever the program's name.
TEST_F(Nc, EveryRowIsAPhase) {
  toy.write("a\"b\\c.ngc", "G21 G90\nG4 P0.1\nG4 P0.1\nG4 P0.1\nM2\n");
  const Result result = toy.run({"nc", toy.file("machine.toml"), toy.file("a\"b\\c.ngc"), "--row-s", "0.3"});
  ASSERT_EQ(result.status, 0) << result.err;
  const core::Config load = core::Config::load(toy.result("load.toml"));
  EXPECT_EQ(load.root().text("title"), "a\"b\\c");
  EXPECT_EQ(load.root().tables("phase").size(), 1U);
  const core::Table rows = core::parse_csv(after_first_line(read(toy.result("rows.csv"))), "rows.csv");
  EXPECT_EQ(rows.rows(), 2);
}

TEST_F(Nc, AToolWithoutATableIsNamedWithTheRemedy) { EXPECT_SAYS(refused("G21 G90\nT1 M6\nM2\n").err, "[[tool]]"); }

// Each refusal of the interpreter says what is allowed there.
TEST_F(Nc, RefusalsOfTheInterpreterNameTheRemedy) {
  const std::pair<const char*, const char*> cases[] = {
      {"F100\nG2 X5 Y5 I1 J0\n", "equally far from the arc's start and end"},
      {"F100\nG2 X5 Y5\n", "arcs with a radius R or with a centre I, J, K"},
      {"F100\nG2 X5 Y5 R1\n", "half of the distance"},
      {"F0\nG1 X5\n", "a feed rate F above 0"},
      {"(py, x = 1)\n", "comments without Python"},
      {"F100\nG81 X1 Y1 Z-1\n", "R, the height to which a cycle retracts"},
      {"F100\nG5 I0 J3 P0 Q-3 X1 Y1\n", "a spline (G5, G5.1 or G5.2); allowed: lines and arcs"},
      {"G0 X1 X2\n", "each letter once in a line"}};
  for (const auto& [lines, says] : cases) EXPECT_SAYS(refused(fmt::format("G21 G90\n{}M2\n", lines)).err, says);
}

// The same part over and over: a series is settled where little drift lies ahead, and says so where it is not.
TEST_F(Nc, AShortSeriesIsNotTakenForASettledOne) {
  toy.write("part.ngc",
            "G21 G90\nM3 S9000\nG0 Z50\no1 repeat [8]\nG1 X100 F20000\nX-100\no1 endrepeat\nG4 P1500\nM2\n");
  const auto series = [&](const char* parts, const char* tolerance) {
    return toy.run({"nc", (toy_run() / "model.rom.h5").string(), toy.file("part.ngc"), "--repeat", parts, "--tolerance",
                    tolerance, "--row-s", "60"});
  };
  EXPECT_SAYS(series("4", "0.5").out, "The series has not settled");
  const Result long_one = series("40", "0.5");
  EXPECT_EQ(long_one.out.find("not settled"), std::string::npos) << long_one.out;
  EXPECT_SAYS(long_one.out, "first part within 0.5 um of the last one: number ");
  EXPECT_SAYS(read(toy.result("report.html")), "The first good part is number");
}

TEST_F(Nc, AToolTableReachesTheAxes) {
  toy.write("tools.tbl", "T3 P1 Z+15 D6 ;end mill\n");
  const json summary = loads("G21 G90\nT3 M6\nG43 H3\nG0 Z20\nM2\n", {"--tools", toy.file("tools.tbl")});
  EXPECT_NEAR(summary["travel"]["Z_mm"].get<double>(), 35.0, 1e-9);
}

// Where the probe would touch is not known; the time of the move is that of its whole way.
TEST_F(Nc, AProbingMoveThatRunsToItsEndIsNamed) {
  toy.write("part.ngc", "G21 G90\nG0 Z20\nG38.2 Z10 F100\nG38.3 Z0 F100\nM2\n");
  const Result probing = toy.run({"nc", toy.file("machine.toml"), toy.file("part.ngc")});
  ASSERT_EQ(probing.status, 0) << probing.err;
  for (const char* words : {"part.ngc:3", "2 probing moves run to their end"}) EXPECT_SAYS(probing.err, words);
  toy.write("part.ngc", "G21 G90\nG0 Z20\nG1 Z10 F100\nM2\n");
  EXPECT_EQ(toy.run({"nc", toy.file("machine.toml"), toy.file("part.ngc")}).err.find("probing"), std::string::npos);
}

// Parts in a row: the pause belongs to the last operation, and the first good part is the one that parts.csv shows.
TEST_F(Nc, ASeriesOfPartsWarmsUp) {
  toy.write("part.ngc",
            "G21 G90\nT1 M6\nM3 S9000\nG0 Z50\no1 repeat [30]\nG1 X100 F20000\nX-100\no1 endrepeat\nG1 X0\nM2\n");
  toy.write("control.toml", "schema = 1\n[[tool]]\nnumber = 1\n");
  const double tolerance = 3.0;
  const Result result =
      toy.run({"nc", (toy_run() / "model.rom.h5").string(), toy.file("part.ngc"), "--control", toy.file("control.toml"),
               "--repeat", "6", "--pause", "100", "--tolerance", fmt::format("{}", tolerance), "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const json summary = json::parse(result.out);
  const core::Table parts = core::read_csv(toy.result("parts.csv")),
                    operations = core::read_csv(toy.result("operations.csv"));
  ASSERT_EQ(parts.rows(), 6);
  ASSERT_EQ(operations.rows(), 6);
  for (Eigen::Index i = 0; i < 6; ++i) {
    EXPECT_EQ(operations.column("tool")[i], 1.0);
    EXPECT_NEAR(operations.column("pause_s")[i], 5.0 + 1.0 + (i < 5 ? 100.0 : 0.0), 1e-6);
    EXPECT_NEAR(operations.column("start_s")[i], i > 0 ? operations.column("end_s")[i - 1] : 0.0, 1e-5);
  }
  Eigen::Index good = 5;
  const auto apart = [&](Eigen::Index i) {
    double most = 0.0;
    for (const char* axis : {"X", "Y", "Z"}) {
      const Eigen::VectorXd mean = parts.column(fmt::format("mean_offset_{}_um", axis));
      most = std::max(most, std::abs(mean[i] - mean[5]));
    }
    return most;
  };
  while (good > 0 && apart(good - 1) <= tolerance) --good;
  EXPECT_GT(good, 0) << "the first part is as good as the last one";
  EXPECT_LT(good, 5);
  EXPECT_EQ(summary["first_good_part"], good + 1);
  // The parts look alike long before the machine is warm (NcSeries has the long series).
  EXPECT_EQ(summary["settled"], false);
  EXPECT_GT(summary["drift_ahead_um"].get<double>(), tolerance);
  EXPECT_NEAR(summary["warm_up_s"].get<double>(), parts.column("start_s")[good], 1e-5);
  const std::string picture = read(toy.result("parts.svg"));
  for (const std::string& words :
       {std::string("<svg xmlns"), fmt::format("of the last one, number {}, after", good + 1), std::string("</svg>")})
    EXPECT_SAYS(picture, words);
}

// Moves and dwells take a multiple of the planned time, the pause between parts does not.
TEST_F(Nc, TheTimeFactorStretchesTheProgramAndNotThePause) {
  toy.write("part.ngc", "G21 G90\nM3 S9000\nG0 Z50\no1 repeat [5]\nG1 X100 F20000\nX-100\no1 endrepeat\nG4 P30\nM2\n");
  const auto rows_of = [&](const char* factor) {
    const Result result = toy.run({"nc", toy_model(), toy.file("part.ngc"), "--repeat", "2", "--pause", "100",
                                   "--row-s", "5", "--time-factor", factor, "--json"});
    EXPECT_EQ(result.status, 0) << result.err;
    return std::pair{json::parse(result.out), core::read_csv(toy.result("blocks.csv"))};
  };
  const auto [planned, planned_blocks] = rows_of("1");
  const auto [slow, slow_blocks] = rows_of("1.2");
  EXPECT_NEAR(slow["duration_s"].get<double>() - 100.0, 1.2 * (planned["duration_s"].get<double>() - 100.0), 1e-6);
  ASSERT_EQ(slow_blocks.rows(), planned_blocks.rows());
  const Eigen::VectorXd time = planned_blocks.column("time_s"), slow_time = slow_blocks.column("time_s"),
                        part = planned_blocks.column("part");
  for (Eigen::Index i = 0; i < time.size(); ++i) {
    const double pause = part[i] > 1.5 ? 100.0 : 0.0;
    EXPECT_NEAR(slow_time[i] - pause, 1.2 * (time[i] - pause), 1e-4) << i;
  }
  for (const char* axis : {"X_mm", "Z_mm"}) EXPECT_EQ(slow["travel_rows"][axis], planned["travel_rows"][axis]) << axis;
  EXPECT_EQ(toy.run({"nc", toy_model(), toy.file("part.ngc"), "--time-factor", "0"}).status, 2);
}

// A folder of subprograms holds the program as well.
TEST_F(Nc, FoldersAndResultsThatCannotBeUsedAreNamed) {
  toy.write("part.ngc", "G21 G90\no1 repeat [50]\nG0 X100\nG0 X-100\no1 endrepeat\nM2\n");
  fs::create_directories(toy.path() + "/inner");
  const auto bad = [&](const std::vector<std::string>& more, const std::vector<std::string>& says,
                       const Surroundings& surroundings = {}) {
    std::vector<std::string> arguments = {"nc", toy.file("machine.toml"), toy.file("part.ngc")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Result result = thermotwin(arguments, "", surroundings);
    EXPECT_EQ(result.status, 3) << result.err;
    for (const std::string& words : says) EXPECT_SAYS(result.err, words);
    EXPECT_FALSE(fs::exists(toy.result("load.toml")));
  };
  bad({"--folder", toy.file("missing"), "--out", toy.out()}, {"missing", "no folder"});
  bad({"--folder", toy.file("part.ngc"), "--out", toy.out()}, {"part.ngc", "no folder"});
  bad({"--folder", toy.file("inner"), "--out", toy.out()}, {"part.ngc", "outside", "below", "inner"});
  bad({"--out", toy.file("part.ngc")}, {"part.ngc", "folder"});
  bad({"--pause", "nan", "--out", toy.out()}, {"--pause", "nan"});
  bad({"--tolerance", "nan", "--out", toy.out()}, {"--tolerance", "nan"});
  Surroundings full;
  full.largest_file = 3000;
  bad({"--row-s", "0.1", "--out", toy.out()}, {"rows.csv", "cannot be written"}, full);
}

TEST_F(Nc, AMoveOfASubprogramIsNamedByItsOwnFile) {
  toy.write("far.ngc", "o<far> sub\nG0 X500\no<far> endsub\n");
  const Result result = refused("G21 G90\n\n\no<far> call\nM2\n");
  EXPECT_SAYS(result.err, "far.ngc:2");
}

struct Bad {
  std::string name, program;
  std::vector<std::string> says;
};

class NcBad : public Nc, public testing::WithParamInterface<Bad> {};

TEST_P(NcBad, NamesPlaceValueAndWhatIsAllowed) {
  const Result result = refused(GetParam().program);
  for (const std::string& words : GetParam().says) EXPECT_SAYS(result.err, words);
  EXPECT_SAYS(result.err, "allowed:");
}

INSTANTIATE_TEST_SUITE_P(
    Programs, NcBad,
    testing::Values(
        Bad{"arc",
            "G21 G90 F100\nG0 X100 Y0\nG3 X98.5300 Y17.3735 I-100 J0\nM2\n",
            {"part.ngc:3", "radii differ", "100.0000 mm", "100.0500 mm", "arc_radius_tolerance_mm"}},
        Bad{"tool", "G21\nT7 M6\nM2\n", {"part.ngc:2", "tool 7"}},
        Bad{"code", "G21\nG0 X1\nG12.9 X2\nM2\n", {"part.ngc:3", "g code"}},
        Bad{"m_code", "G21\nM177\nM2\n", {"part.ngc:2"}},
        Bad{"travel", "G21 G90\nG0 X10\nG0 X130\nM2\n", {"part.ngc:3", "axis X at 130", "-120.0000 to 120.0000"}},
        Bad{"travel_on_arc",
            "G21 G90 F100\nG0 X110\nG2 X110 Y0 I5 J0\nG2 X110 Y10 J5\nG2 I10\nM2\n",
            {"part.ngc:5", "axis X at 130"}},
        Bad{"axis", "G21 G90\nG0 A5\nM2\n", {"part.ngc:2", "'a'"}},
        Bad{"endless", "G21 G91\no1 while [1]\nG0 X1\nG0 X-1\no1 endwhile\nM2\n", {"part.ngc:", "does it end"}},
        Bad{"idle", "G21\no1 while [1]\n#1 = [#1 + 1]\no1 endwhile\nM2\n", {"part.ngc:", "without a move"}},
        Bad{"inside", "G21\no1 sub\nG0 X1\nM2\no1 endsub\no1 call\nM2\n", {"part.ngc:4", "inside a subprogram"}},
        Bad{"no_end_of_sub", "G21\no1 call\nM2\no1 sub\nG0 X1\n", {"part.ngc:"}},
        Bad{"python", "G21\n;py,open('/tmp/thermotwin_nc_python','w').write('x')\nM2\n", {"part.ngc:2", "Python"}},
        Bad{"python_in_brackets", "G21\n( PY,print(1))\nM2\n", {"part.ngc:2", "Python"}},
        Bad{"binary", std::string("G21\nG0 X1\0\1\2\nM2\n", 16), {"part.ngc:2", "byte of value 0"}},
        Bad{"long_line", "G21\n(" + std::string(300, 'x') + ")\nM2\n", {"part.ngc:2", "254 characters"}},
        Bad{"no_feed", "G21\nG1 X1\nM2\n", {"part.ngc:2", "feed"}},
        Bad{"spindle", "G21\nM3 S13000\nG1 X1 F100\nM2\n", {"part.ngc:2", "13000 rpm", "12000 rpm"}},
        Bad{"spindle_while_standing", "G21\nM3 S13000\nG4 P60\nM2\n", {"part.ngc:2", "13000 rpm", "12000 rpm"}},
        Bad{"empty", "", {"part.ngc", "empty"}}, Bad{"blank", " \r\n\n", {"part.ngc", "empty"}},
        Bad{"words", "nan inf\n", {"part.ngc:1"}},
        Bad{"infinite", "G21\nG4 P[exp[1000]]\nM2\n", {"part.ngc:2", "infinity"}},
        Bad{"surface_speed", "G21\nG96 D1000 S100 M3\nM2\n", {"part.ngc:2", "G96"}},
        Bad{"tcp_kinematics", "G21\nM430\nM2\n", {"part.ngc:2", "M430"}}),
    [](const testing::TestParamInfo<Bad>& bad) { return bad.param.name; });

// LinuxCNC expands the name of a subprogram as a shell would; the helper must not.
TEST_F(Nc, NoProgramRunsCodeOrReadsElsewhere) {
  const std::string trace = toy.file("trace");
  fs::remove("/tmp/thermotwin_nc_python");
  refused("G21\n;py,open('/tmp/thermotwin_nc_python','w').write('x')\nM2\n");
  EXPECT_FALSE(fs::exists("/tmp/thermotwin_nc_python"));
  refused("G21\no<$(touch " + trace + ")> call\nM2\n");
  refused("G21\n(LOGOPEN," + trace + ")\n(LOG,x)\nG0 X500\nM2\n");
  EXPECT_FALSE(fs::exists(trace));
  fs::create_directories(toy.path() + "/inner");
  toy.write("outer.ngc", "o<outer> sub\nG0 X1\no<outer> endsub\n");
  toy.write("inner/main.ngc", "G21\no<../outer> call\nM2\n");
  const Result outside = toy.run({"nc", toy.file("machine.toml"), toy.file("inner/main.ngc")});
  EXPECT_EQ(outside.status, 3) << outside.out;
  EXPECT_SAYS(outside.err, "main.ngc:2");
  toy.write("inner/own.ngc", "o<own> sub\nG0 X1\no<own> endsub\nM2\n");
  toy.write("inner/main.ngc", "G21\no<own> call\nM2\n");
  EXPECT_EQ(toy.run({"nc", toy.file("machine.toml"), toy.file("inner/main.ngc")}).status, 0);
}

TEST_F(Nc, MistakesInAProfileAreNamed) {
  toy.write("part.ngc", "G21\nM2\n");
  toy.write("control.toml", "schema = 1\n[[word]]\nword = \"43.4\"\naction = \"skip\"\n");
  Result result =
      toy.run({"nc", toy.file("machine.toml"), toy.file("part.ngc"), "--control", toy.file("control.toml")});
  EXPECT_EQ(result.status, 3);
  for (const char* words : {"control.toml:3", "43.4", "G43.4"}) EXPECT_SAYS(result.err, words);
  toy.write("control.toml", "schema = 1\ntool_chnge_s = 4\n");
  result = toy.run({"nc", toy.file("machine.toml"), toy.file("part.ngc"), "--control", toy.file("control.toml")});
  EXPECT_EQ(result.status, 3);
  EXPECT_SAYS(result.err, "tool_change_s");
  toy.write("control.toml", "schema = 1\n[[word]]\nword = \"M21\"\naction = \"skip\"\nwith = \"Q R\"\n");
  result = toy.run({"nc", toy.file("machine.toml"), toy.file("part.ngc"), "--control", toy.file("control.toml")});
  EXPECT_EQ(result.status, 3);
  for (const char* words : {"control.toml:5", "Q R"}) EXPECT_SAYS(result.err, words);
  toy.write("control.toml", "schema = 1\n[[work_offset]]\nnumber = 2\n[[work_offset]]\nnumber = 2\n");
  result = toy.run({"nc", toy.file("machine.toml"), toy.file("part.ngc"), "--control", toy.file("control.toml")});
  EXPECT_EQ(result.status, 3);
  for (const char* words : {"control.toml:5", "work offset 2 twice"}) EXPECT_SAYS(result.err, words);
  toy.write("tools.tbl", "T1 P1 Z10\nT1 P2 Z11\n");
  result = toy.run({"nc", toy.file("machine.toml"), toy.file("part.ngc"), "--tools", toy.file("tools.tbl")});
  EXPECT_EQ(result.status, 3);
  EXPECT_SAYS(result.err, "tools.tbl:2");
}

// The full model on the load program that nc writes, at the pose where the program ends, against nc's own prediction by
// the reduced model.
TEST_F(Nc, PredictionIsThatOfTheFullModelOnItsLoads) {
  toy.write("part.ngc",
            "G21 G90\nM3 S9000\nG0 X0 Y0 Z50\nM8\no1 repeat [120]\nG1 X100 F20000\nG1 X-100\no1 endrepeat\nM9\n"
            "G1 X0 F5000\nM2\n");
  const Result predicted = toy.run({"nc", (toy_run() / "model.rom.h5").string(), toy.file("part.ngc"), "--json"});
  ASSERT_EQ(predicted.status, 0) << predicted.err;
  const json summary = json::parse(predicted.out);
  fs::copy_file(toy.result("load.toml"), toy.file("loads/part.toml"));
  const Result full = toy.run({"simulate", toy.path(), "--load", "part", "--pose", "X=0,Y=0,Z=50"});
  ASSERT_EQ(full.status, 0) << full.err;
  const core::Table tcp = core::read_csv(toy.result("simulate/part/tcp.csv"));
  const core::Table blocks = core::read_csv(toy.result("blocks.csv"));
  const Eigen::Index a = tcp.rows() - 1, b = blocks.rows() - 1;
  EXPECT_NEAR(blocks.column("time_s")[b], tcp.column("time_s")[a], 0.5);
  double error = 0.0;
  for (const char* name : {"dx_um", "dy_um", "dz_um"}) {
    EXPECT_NEAR(blocks.column(name)[b], tcp.column(name)[a], 0.5) << name;  // as reduced and full model differ
    error = std::max(error, std::abs(tcp.column(name)[a]));
  }
  EXPECT_GT(error, 10.0) << "the program heats too little to show anything";
  EXPECT_GT(blocks.column("std_X_um")[b], 0.0);
  EXPECT_NEAR(blocks.column("offset_X_um")[b], -blocks.column("dx_um")[b], 1e-3);
  const core::Table operations = core::read_csv(toy.result("operations.csv"));
  EXPECT_NEAR(operations.column("end_s")[operations.rows() - 1], summary["duration_s"].get<double>(), 1e-6);
  EXPECT_NEAR(operations.column("feed_length_mm").sum(), 100 + 239 * 200 + 100, 1e-6);
  // The mean over the time of cutting moves.
  const Eigen::VectorXd rapid = blocks.column("rapid"), offset = blocks.column("offset_X_um"),
                        time = blocks.column("time_s");
  double sum = 0.0, seconds = 0.0;
  for (Eigen::Index i = 1; i < blocks.rows(); ++i) {
    if (rapid[i] != 0) continue;
    sum += 0.5 * (offset[i - 1] + offset[i]) * (time[i] - time[i - 1]);
    seconds += time[i] - time[i - 1];
  }
  EXPECT_NEAR(operations.column("mean_offset_X_um")[0], sum / seconds, 2e-3);
  // Several moves end within a row, and the machine warms up between them.
  int standing = 0;
  for (Eigen::Index i = 11; i + 3 < blocks.rows(); ++i)
    standing += blocks.column("dz_um")[i] == blocks.column("dz_um")[i + 2] ? 1 : 0;
  EXPECT_LT(standing, 10) << "the state stands still within a row";
}

// compensate reads the rows as they are.
TEST_F(Nc, RowsFeedTheCompensator) {
  loads("G21 G90\nM3 S9000\nG0 Z50\no1 repeat [20]\nG1 X100 F20000\nG1 X-100\no1 endrepeat\nM2\n");
  const Result result = thermotwin({"compensate", (toy_run() / "model.rom.h5").string(), "--no-sensors", "--strict",
                                    "--in", toy.result("rows.csv").string()});
  EXPECT_EQ(result.status, 0) << result.err;
}

TEST(NcWithout, TheHelperSaysSoAndExitsCleanly) {
  if (has_interpreter()) GTEST_SKIP() << "LinuxCNC's interpreter is there";
  const Toy toy;
  toy.write("part.ngc", "G21\nM2\n");
  const Result result = toy.run({"nc", toy.file("machine.toml"), toy.file("part.ngc")});
  EXPECT_EQ(result.status, 2);
  EXPECT_SAYS(result.err, "linuxcnc-uspace-dev");
}

}  // namespace
}  // namespace thermotwin::cases
