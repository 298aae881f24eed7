// SPDX-License-Identifier: GPL-3.0-or-later
// `nc --rewrite`: the corrected program, read again by the same interpreter, against the offsets of the first reading.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <sstream>

#include "core/table.h"
#include "tests/cases/nc_programs.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

using nlohmann::json;
using Point = Eigen::Vector3d;

class NcRewrite : public testing::Test {
protected:
  void SetUp() override {
    if (!has_interpreter()) GTEST_SKIP() << "the program was built without LinuxCNC's interpreter";
  }
  /// @return the summary; the tables are in the folder
  json run(const std::string& text, const std::string& folder, std::vector<std::string> more) {
    toy.write(folder + ".ngc", text);
    std::vector<std::string> arguments = {"nc",
                                          (toy_run() / "model.rom.h5").string(),
                                          toy.file(folder + ".ngc"),
                                          "--json",
                                          "--start",
                                          "X=0,Y=0,Z=50",
                                          "--out",
                                          toy.file(folder)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Result result = thermotwin(arguments);
    EXPECT_EQ(result.status, 0) << result.err;
    return result.status == 0 ? json::parse(result.out) : json();
  }
  core::Table blocks(const std::string& folder) const { return core::read_csv(toy.file(folder + "/blocks.csv")); }
  std::string corrected(const std::string& folder) const {
    return read(toy.file(folder + "/" + folder + ".corrected.ngc"));
  }
  static Point position(const core::Table& table, Eigen::Index row) {
    return {table.column("X_mm")[row], table.column("Y_mm")[row], table.column("Z_mm")[row]};
  }
  static Point offset_mm(const core::Table& table, Eigen::Index row) {
    return 1e-3 *
           Point(table.column("offset_X_um")[row], table.column("offset_Y_um")[row], table.column("offset_Z_um")[row]);
  }
  /// Each move of the corrected program ends where that of the program does, plus its offset.
  void expect_displaced(const std::string& before, const std::string& after, double within_mm) const {
    const core::Table a = blocks(before), b = blocks(after);
    ASSERT_EQ(a.rows(), b.rows()) << corrected(before);
    double largest = 0.0;
    for (Eigen::Index i = 0; i < a.rows(); ++i) {
      EXPECT_NEAR((position(b, i) - position(a, i) - offset_mm(a, i)).cwiseAbs().maxCoeff(), 0.0, within_mm) << i;
      largest = std::max(largest, offset_mm(a, i).norm());
    }
    EXPECT_GT(largest, 2e-3) << "the offsets are too small to show anything";
  }
  Toy toy;
};

/// Lines and arcs of a program with X Y Z I J K in absolute mm, as this test writes them.
class Path {
public:
  explicit Path(const std::string& text) {
    std::istringstream lines(text);
    Point at(0, 0, 50);
    int motion = 0, plane = 17;
    for (std::string line; std::getline(lines, line);) {
      line = line.substr(0, line.find('('));
      Point to = at, centre = at;
      bool moves = false;
      for (std::size_t i = 0; i < line.size(); ++i) {
        const char letter = line[i];
        if (std::string("GXYZIJK").find(letter) == std::string::npos) continue;
        const double value = std::stod(line.substr(i + 1));
        if (letter == 'G' && value < 4) motion = static_cast<int>(value);
        if (letter == 'G' && value >= 17 && value <= 19) plane = static_cast<int>(value);
        const std::size_t axis = std::string("XYZ").find(letter), c = std::string("IJK").find(letter);
        if (axis != std::string::npos) to[static_cast<Eigen::Index>(axis)] = value;
        if (c != std::string::npos) centre[static_cast<Eigen::Index>(c)] += value;
        moves = moves || letter != 'G';
      }
      if (!moves) continue;
      pieces_.push_back({at, to, centre, motion, plane});
      at = to;
    }
  }
  std::size_t pieces() const { return pieces_.size(); }
  /// Shortest distance to the path.
  double distance(const Point& p) const {
    double shortest = 1e9;
    for (const Piece& piece : pieces_) shortest = std::min(shortest, piece.distance(p));
    return shortest;
  }

private:
  struct Piece {
    Point from, to, centre;
    int motion, plane;
    double distance(const Point& p) const {
      if (motion < 2) {
        const Point along = to - from;
        const double u =
            along.squaredNorm() > 0 ? std::clamp((p - from).dot(along) / along.squaredNorm(), 0.0, 1.0) : 0;
        return (from + u * along - p).norm();
      }
      const Point normal = plane == 17 ? Point::UnitZ() : plane == 18 ? Point::UnitY() : Point::UnitX();
      const double sense = motion == 3 ? 1.0 : -1.0;
      const auto flat = [&](const Point& v) -> Point { return v - v.dot(normal) * normal; };
      const auto angle_to = [&](const Point& v) {
        const Point a = flat(from - centre), b = flat(v - centre);
        double angle = sense * std::atan2(normal.dot(a.cross(b)), a.dot(b));
        return angle < 1e-12 ? angle + 2.0 * std::numbers::pi : angle;
      };
      const double whole = angle_to(to), angle = angle_to(p);
      if (angle > whole) return std::min((p - from).norm(), (p - to).norm());
      const double rise = (to - from).dot(normal) * angle / whole;
      return std::hypot(flat(p - centre).norm() - flat(from - centre).norm(), (p - from).dot(normal) - rise);
    }
  };
  std::vector<Piece> pieces_;
};

// At the reference temperature nothing is displaced: the same bytes, whatever the program has.
TEST_F(NcRewrite, ZeroOffsetKeepsEveryByte) {
  const std::string text =
      "%\r\nN1 g21 G90 (start)\r\n o10 sub\nG91 G1 X 1.50 F100\nG90\no10 endsub\n#1 = 3\nG0 X#1 Y[1+1]\no10 call\n"
      "G81 X5 Y5 Z40 R45 F200\nG80\n/ G1 X 1\n; end\nM2\n%";
  for (const char* how : {"path", "shift"}) {
    const json summary = run(text, "zero", {"--rewrite", how, "--start-C", "20"})["rewrite"];
    EXPECT_EQ(corrected("zero"), text) << how;
    EXPECT_EQ(summary["changed"], 0) << how;
    EXPECT_EQ(summary["cycles_written_out"], 0) << how;
    EXPECT_EQ(summary["lines_after"], summary["lines_before"]) << how;
  }
}

// The wanted path is sampled ten times a block by a program that names these points: position plus offset there.
TEST_F(NcRewrite, PathIsWithinToleranceTenTimesABlock) {
  const std::string head = "G21 G90 F2000\n";
  std::string whole = head, fine = head;
  const auto add_line = [&](const Point& from, const Point& to) {
    whole += fmt::format("N{} G1 X{:.4f} Y{:.4f} Z{:.4f} (line)\n", 10 * Path(whole).pieces(), to.x(), to.y(), to.z());
    for (int k = 1; k <= 10; ++k) {
      const Point p = from + 0.1 * k * (to - from);
      fine += fmt::format("G1 X{:.6f} Y{:.6f} Z{:.6f}\n", p.x(), p.y(), p.z());
    }
  };
  const auto add_arc = [&](int plane, const Point& from, double radius, double start, double sweep) {
    const std::array<Eigen::Index, 2> axes = plane == 17   ? std::array<Eigen::Index, 2>{0, 1}
                                             : plane == 18 ? std::array<Eigen::Index, 2>{2, 0}
                                                           : std::array<Eigen::Index, 2>{1, 2};
    Point centre = from;
    centre[axes[0]] -= radius * std::cos(start);
    centre[axes[1]] -= radius * std::sin(start);
    const auto at = [&](double share) {
      Point p = from;
      p[axes[0]] = centre[axes[0]] + radius * std::cos(start + share * sweep);
      p[axes[1]] = centre[axes[1]] + radius * std::sin(start + share * sweep);
      return p;
    };
    const Point c = centre - from;
    const Point to = at(1.0);
    const char* word = sweep > 0 ? "G3" : "G2";
    const std::string ijk = plane == 17   ? fmt::format("I{:.6f} J{:.6f}", c.x(), c.y())
                            : plane == 18 ? fmt::format("I{:.6f} K{:.6f}", c.x(), c.z())
                                          : fmt::format("J{:.6f} K{:.6f}", c.y(), c.z());
    whole += fmt::format("G{} {} X{:.6f} Y{:.6f} Z{:.6f} {}\n", plane, word, to.x(), to.y(), to.z(), ijk);
    for (int k = 1; k <= 10; ++k) {
      const Point p = at(0.1 * k);
      fine += fmt::format("G1 X{:.6f} Y{:.6f} Z{:.6f}\n", p.x(), p.y(), p.z());
    }
  };
  const double pi = std::numbers::pi;
  add_line({0, 0, 50}, {110, 35, 90});
  add_line({110, 35, 90}, {-110, -30, 20});
  add_line({-110, -30, 20}, {30, 0, 50});
  add_arc(17, {30, 0, 50}, 30, 0, 1.5 * pi);
  add_arc(17, {0, -30, 50}, 30, 1.5 * pi, -2.0 * pi);
  add_arc(18, {0, -30, 50}, 40, 0.5 * pi, -0.7);
  const double x = -40 + 40 * std::sin(0.5 * pi - 0.7), z = 50 + 40 * std::cos(0.5 * pi - 0.7);
  add_arc(19, {x, -30, z}, 20, pi, 2.0);
  whole += "M2\n";
  fine += "M2\n";
  for (const double tolerance : {0.3, 5.0}) {
    const json summary =
        run(whole, "whole", {"--rewrite", "path", "--start-C", "30", "--tolerance", fmt::format("{}", tolerance)});
    run(fine, "fine", {"--start-C", "30"});
    const core::Table wanted = blocks("fine");
    ASSERT_EQ(wanted.rows(), 70);
    const Path path(corrected("whole")), before(whole);
    double worst = 0.0, uncorrected = 0.0;
    for (Eigen::Index i = 0; i < wanted.rows(); ++i) {
      const Point point = position(wanted, i) + offset_mm(wanted, i);
      worst = std::max(worst, 1e3 * path.distance(point));
      uncorrected = std::max(uncorrected, 1e3 * before.distance(point));
    }
    EXPECT_LE(worst, tolerance + 0.2) << corrected("whole");
    EXPECT_GT(uncorrected, 5.0);
    EXPECT_GE(summary["rewrite"]["split"], tolerance < 1.0 ? 1 : 0) << "the offset does not bend enough to show splits";
  }
  EXPECT_NE(corrected("whole").find("G19 G3 X"), std::string::npos) << "arcs stay arcs";
}

// A line and a circle of a minute each while the spindle heats the machine: the offset is that of place and time, also
// in the means of operations.csv and in the update of --rewrite shift.
TEST_F(NcRewrite, LongBlocksFollowTheDrift) {
  constexpr double pi = std::numbers::pi, tolerance = 0.5;
  const std::string head = "G21 G90 G17\nM3 S9000\nG0 X-50 Y0 Z30\n";
  std::string whole = head + "G1 X50 F100\nG2 X50 Y0 I-15 J0 F90\n", fine = head;
  for (int k = 1; k <= 60; ++k) fine += fmt::format("G1 X{:.6f} F100\n", -50.0 + k / 0.6);
  for (int k = 1; k <= 120; ++k) {
    const double angle = -2.0 * pi * k / 120;
    fine += fmt::format("G1 X{:.6f} Y{:.6f} F90\n", 35.0 + 15.0 * std::cos(angle), 15.0 * std::sin(angle));
  }
  whole += "M2\n";
  fine += "M2\n";
  const json summary = run(whole, "whole", {"--rewrite", "path", "--tolerance", fmt::format("{}", tolerance)});
  run(fine, "fine", {});
  EXPECT_LE(summary["rewrite"]["lines_after"], 16) << corrected("whole");
  const core::Table wanted = blocks("fine");
  ASSERT_EQ(wanted.rows(), 181);
  const Path path(corrected("whole"));
  double worst = 0.0;
  for (Eigen::Index i = 0; i < wanted.rows(); ++i)
    worst = std::max(worst, 1e3 * path.distance(position(wanted, i) + offset_mm(wanted, i)));
  EXPECT_LE(worst, tolerance + 0.2) << corrected("whole");
  const Eigen::VectorXd z = wanted.column("offset_Z_um");
  EXPECT_GT(std::abs(z[60] - z[0]), 4.0) << "the line heats the machine too little to show anything";
  EXPECT_GT(std::abs(z[180] - z[60]), 4.0) << "the circle heats the machine too little to show anything";
  const auto mean = [&](const char* folder) {
    return core::read_csv(toy.file(std::string(folder) + "/operations.csv")).column("mean_offset_Z_um")[0];
  };
  EXPECT_NEAR(mean("whole"), mean("fine"), 0.02);
  const double line_s = 60.0, circle_s = 20.0 * pi;
  const double over_time = (line_s * z.segment(1, 60).mean() + circle_s * z.tail(120).mean()) / (line_s + circle_s);
  EXPECT_NEAR(mean("whole"), over_time, 0.2);
  run(whole, "update", {"--rewrite", "shift"});
  const std::string text = corrected("update");
  const std::size_t update = text.find("G10 L2 P1");
  ASSERT_NE(update, std::string::npos) << text;
  EXPECT_NEAR(1e3 * std::stod(text.substr(text.find('Z', update) + 1)), mean("whole"), 0.1) << text;
}

// A byte order mark is none of the program's text.
TEST_F(NcRewrite, AByteOrderMarkIsKeptOutOfTheWay) {
  const std::string mark = "\xEF\xBB\xBF", text = "G21 G90\nG0 X10 Z60\nG1 X20 F500\nM2\n";
  const std::vector<std::string> how = {"--rewrite", "path", "--start-C", "26"};
  run(mark + text, "marked", how);
  run(text, "plain", how);
  EXPECT_EQ(corrected("marked"), corrected("plain"));
  run(mark + text, "cold", {"--rewrite", "path", "--start-C", "20"});
  EXPECT_EQ(corrected("cold"), mark + text) << "without an offset the same bytes";
}

TEST_F(NcRewrite, TextOfALineStays) {
  run("G21 G90 (start)\nN10 G0 X10 Y10 S500 M3 (to the part)\nN20 G1 Z45 F120 ; down\nX20 Y10\nM9 (off)\nM5\nM2\n",
      "text", {"--rewrite", "path", "--start-C", "24", "--tolerance", "50"});
  std::istringstream lines(corrected("text"));
  std::vector<std::string> text;
  for (std::string line; std::getline(lines, line);) text.push_back(line);
  ASSERT_EQ(text.size(), 7U);
  EXPECT_EQ(text[0], "G21 G90 (start)");
  EXPECT_TRUE(text[1].starts_with("N10 G0 X") && text[1].ends_with(" S500 M3 (to the part)")) << text[1];
  EXPECT_TRUE(text[2].starts_with("N20 G1 Z") && text[2].ends_with(" F120 ; down")) << text[2];
  EXPECT_EQ(text[4] + text[5] + text[6], "M9 (off)M5M2");
}

// Name, percent signs and words of the control stay, in a program of one pass and in one that is written out; what does
// not run is left out there.
TEST_F(NcRewrite, NamesAndWordsOfTheControlStay) {
  const std::vector<std::string> how = {"--control", "fanuc", "--rewrite",   "path",
                                        "--start-C", "26",    "--tolerance", "50"};
  run("%\nO1234 (part)\nG21 G90\nG5.1 Q1 R5 (fast)\nG0 X10. Y0 Z50.\nG1 X20. F500\nG5.1 Q0\nM30\n%\n", "name", how);
  std::string text = corrected("name");
  EXPECT_TRUE(text.starts_with("%\nO1234 (part)\nG21 G90\nG5.1 Q1 R5 (fast)\nG0 X10.0")) << text;
  EXPECT_TRUE(text.ends_with("G5.1 Q0\nM30\n%\n")) << text;
  run("%\nO1234 (part)\nG21 G90\n#1 = 5\nG5.1 Q1\nG0 X#1 Y0 Z50.\no1 if [0]\nG5.1 Q1 R7\no1 endif\nG1 X20. F500\n"
      "M98 P7\nM30\nO7\nG1 X30.\nG5.1 Q0\nM99\n%\n",
      "loops", how);
  text = corrected("loops");
  EXPECT_TRUE(text.starts_with("%\nO1234 (part)\nG21 G90\nG5.1 Q1\nG0 X5.00")) << text;
  EXPECT_TRUE(text.ends_with("\nG5.1 Q0\nM30\n%\n")) << text;
  EXPECT_EQ(text.find("R7"), std::string::npos) << text;
  EXPECT_EQ(text.find("O7"), std::string::npos) << text;
}

// Moves in the machine's own coordinates stay, and a block in inverse time takes its time in parts as well.
TEST_F(NcRewrite, MachineCoordinatesAndInverseTimeAreRespected) {
  const json summary = run("G21 G90\nG0 X-110 Z60\nG53 G0 X0\nG53 G0 X-110\nG93 G1 X110 Y35 Z90 F2\nG94\nM2\n",
                           "inverse", {"--rewrite", "path", "--start-C", "30", "--tolerance", "0.3"});
  EXPECT_GE(summary["rewrite"]["split"], 1);
  EXPECT_NE(corrected("inverse").find("\nG53 G0 X0\nG53 G0 X-110\n"), std::string::npos) << corrected("inverse");
  const json again = run(corrected("inverse"), "again", {"--start-C", "30"});
  EXPECT_NEAR(again["cutting_s"].get<double>(), summary["cutting_s"].get<double>(), 0.02);
}

// Loops, subprograms, parameters, incremental words and a drilling cycle are written out.
TEST_F(NcRewrite, WhatRunsSeveralTimesIsWrittenOut) {
  const std::string text =
      "G21 G90\no1 sub\nG91 G1 X2 F500\nY1\nG90\no1 endsub\n#1 = 0\nG0 X-60 Y-20 Z60\no2 while [#1 lt 4]\nG1 Z[60 - "
      "#1] "
      "F[300 + #1]\no1 call\n#1 = [#1 + 1]\no2 endwhile\no3 if [#1 gt 9]\nG91\nG1 "
      "X5\no3 else\nG1 X[#1 + 1]\no3 endif\nG0 X0\nG99 G81 X10 Y10 Z30 R55 F200\nX20\nG80\nG91 G81 X5 Z-5 R2 "
      "F200\nX5\nG80\nG1 X3\nG90\nG0 Z70\nM2\n";
  run(text, "loops", {"--rewrite", "path", "--start-C", "26", "--tolerance", "50"});
  run(corrected("loops"), "again", {"--start-C", "26"});
  expect_displaced("loops", "again", 1.2e-4);
  EXPECT_EQ(corrected("loops").find("o1"), std::string::npos);
  // The feed of a cycle goes with its first line.
  EXPECT_EQ(corrected("loops").find("\nF"), std::string::npos) << corrected("loops");
  EXPECT_EQ(corrected("loops").find("\n "), std::string::npos) << corrected("loops");
}

TEST_F(NcRewrite, InchesRotationAndWorkOffsetsAreRespected) {
  toy.write("control.toml",
            "schema = 1\n[[work_offset]]\nnumber = 2\nX_mm = 10\nY_mm = -5\nZ_mm = 20\nrotation_deg = 30\n");
  const std::vector<std::string> how = {"--control", toy.file("control.toml"), "--start-C", "26"};
  std::vector<std::string> rewrite = how;
  rewrite.insert(rewrite.end(), {"--rewrite", "path", "--tolerance", "50"});
  const std::string text =
      "G20 G90 G55 F20\nG0 X1 Y0.5 Z1\nG1 X1.2\nG3 X0.8 Y0.7 I-0.2 J0.1\nG91 G1 X-0.3 Y0.2\nZ-0.1\nM2\n";
  run(text.substr(0, text.find("G3")) + "G3 X0.8 Y0.5 I-0.2 J0\nG91 G1 X-0.3 Y0.2\nZ-0.1\nM2\n", "inch", rewrite);
  run(corrected("inch"), "again", how);
  expect_displaced("inch", "again", 2e-4);
}

// Under tool centre point control the axes end at their positions plus offsets, with the table tilted and turned.
TEST_F(NcRewrite, ToolCentrePointControlIsRespected) {
  toy.write("control.toml",
            "schema = 1\n[[word]]\nword = \"M428\"\naction = \"tcp_on\"\n[[word]]\nword = \"M429\"\naction = "
            "\"tcp_off\"\n[[tool]]\nnumber = 1\nlength_mm = 45\n");
  const std::vector<std::string> how = {"--control", toy.file("control.toml"), "--start-C", "26"};
  std::vector<std::string> rewrite = how;
  rewrite.insert(rewrite.end(), {"--rewrite", "path", "--tolerance", "50"});
  const std::string text =
      "G21 G90 F2000\nT1 M6\nG43 H1\nM428\nG0 X20 Y5 Z20\nG1 X30 B20 C30\nX10 Y-10 B40 C80\nG2 X-10 Y-10 I-10 J0\nG1 "
      "C-30\nM429\nM2\n";
  run(text, "boat", rewrite);
  run(corrected("boat"), "again", how);
  expect_displaced("boat", "again", 1.5e-4);
}

// A tool change that does not move stays with all of its line where the program is written out.
TEST_F(NcRewrite, ToolChangesThatDoNotMoveStay) {
  toy.write("control.toml", "schema = 1\n[[tool]]\nnumber = 1\nlength_mm = 20\n[[tool]]\nnumber = 2\nlength_mm = 30\n");
  const std::vector<std::string> how = {"--control", toy.file("control.toml"), "--start-C", "26"};
  std::vector<std::string> rewrite = how;
  rewrite.insert(rewrite.end(), {"--rewrite", "path", "--tolerance", "50"});
  const std::string change = "T1 M6 G43 H1 S8000 M3 (first)\n";
  const json before = run("G21 G90 G17 G54\n#1=5\n" + change +
                              "G0 X#1 Y-20 Z30\nM66 P0 L0\no1 repeat [2]\nG91 G1 X1 F500\n"
                              "G90\no1 endrepeat\nT2\nM6\nG43 H2\nM8\nG1 X20 F500\nM30\n",
                          "tools", rewrite);
  const std::string text = corrected("tools");
  EXPECT_SAYS(text, "G21 G90 G17 G54\n" + change + "G0 X5.0");
  EXPECT_SAYS(text, "T2\nM6\nG43 H2\nM8\n");
  EXPECT_SAYS(text, "M66 P0 L0\n");
  const json again = run(text, "again", how);
  EXPECT_EQ(again["tool_changes"], before["tool_changes"]);
  expect_displaced("tools", "again", 1.2e-4);
}

// An arc of several turns is split into parts of less than one turn: none keeps the number of turns.
TEST_F(NcRewrite, TurnsOfASplitArcAreThoseOfTheProgram) {
  for (const char* arc : {"G3 X-28 Y0 Z90 I-28 J0 P3", "G2 X28 Y0 Z80 I-28 J0 P2", "G2 X28 Y0.001 I-28 J0.0005"}) {
    const std::string text = fmt::format("G21 G90 F6000\nG0 X28 Y0 Z20\n{}\nM2\n", arc);
    const json before = run(text, "turns", {"--rewrite", "path", "--start-C", "34", "--tolerance", "0.1"});
    EXPECT_GE(before["rewrite"]["split"], 1);
    EXPECT_EQ(corrected("turns").find('P'), std::string::npos) << corrected("turns");
    const json again = run(corrected("turns"), "again", {"--start-C", "34"});
    for (const char* axis : {"X_mm", "Y_mm", "Z_mm"})
      EXPECT_NEAR(again["travel"][axis].get<double>(), before["travel"][axis].get<double>(), 0.5) << arc << axis;
  }
}

// Words that state a point in another way than the new coordinates go with them.
TEST_F(NcRewrite, PolarWordsAndRadiiFromParametersAreWrittenOut) {
  run("G21 G90 G17 F1000\nG1 @20 ^30\nG1 @25\nG91 ^10\nG90 G1 @5 ^0 Z40\n@5 ^0\nM2\n", "polar",
      {"--rewrite", "path", "--start-C", "26", "--tolerance", "50"});
  EXPECT_EQ(corrected("polar").find_first_of("@^"), std::string::npos) << corrected("polar");
  run(corrected("polar"), "again", {"--start-C", "26"});
  expect_displaced("polar", "again", 1.2e-4);
  const json summary = run("G21 G90 G17 F1000\n#<r>=28\n#2=900\nG0 X28 Y0 Z20\nG3 X-28 Y0 Z40 R#<r> F#2\nM2\n",
                           "radius", {"--rewrite", "path", "--start-C", "34", "--tolerance", "0.1"});
  EXPECT_GE(summary["rewrite"]["split"], 1);
  EXPECT_EQ(corrected("radius").find('#'), std::string::npos) << corrected("radius");
  EXPECT_EQ(corrected("radius").find('R'), std::string::npos) << corrected("radius");
}

// A dwell of a cycle stays, and a main program may end with M99.
TEST_F(NcRewrite, DwellsOfCyclesAndTheEndStay) {
  const std::vector<std::string> how = {"--rewrite", "path", "--start-C", "26", "--tolerance", "50"};
  const json before = run("G21 G90\nG0 X0 Y0 Z60\nG99 G82 X10 Y10 Z30 R55 P1.5 F600\nX20\nG80\nM2\n", "dwell", how);
  const json again = run(corrected("dwell"), "again", {"--start-C", "26"});
  EXPECT_NEAR(again["pause_s"].get<double>(), 3.0, 1e-9) << corrected("dwell");
  EXPECT_NEAR(before["pause_s"].get<double>(), 3.0, 1e-9);
  run("G21 G90\n#1=1\nG0 X#1 Z60\no1 if [#1 gt 0]\nG0 X5\nM30\no1 endif\nG0 X9\nM30\n", "branch", how);
  EXPECT_TRUE(corrected("branch").ends_with("M30\n")) << corrected("branch");
}

TEST_F(NcRewrite, ShiftUpdatesTheWorkOffsetAtRetracts) {
  const std::string text =
      "G21 G90 G54 (two pockets)\nG0 X-80 Y-30\nG1 Z20 F500\nX-60\nG0 Z90\nX100 Y30\nG1 Z70\nX110\nG0 Z95\nM2\n";
  const json summary = run(text, "shift", {"--rewrite", "shift", "--start-C", "28"});
  const std::string out = corrected("shift");
  std::string without;
  std::istringstream lines(out);
  int updates = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("G10 L2 P1 X"))
      ++updates;
    else
      without += line + "\n";
  }
  EXPECT_EQ(without, text);
  EXPECT_EQ(updates, 2) << out;
  EXPECT_LT(out.find("Z90"), out.rfind("G10 L2"));
  run(out, "again", {"--start-C", "28"});
  const core::Table a = blocks("shift"), b = blocks("again");
  ASSERT_EQ(a.rows(), b.rows());
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    if (a.column("rapid")[i] != 0) continue;
    EXPECT_LT((position(b, i) - position(a, i) - offset_mm(a, i)).cwiseAbs().maxCoeff() * 1e3,
              summary["rewrite"]["largest_deviation_um"].get<double>() + 0.1)
        << i;
    EXPECT_GT(offset_mm(a, i).norm(), 2e-3);
  }
}

// An axis that is not named behind an update, or only in G91, would stay at the old zero.
TEST_F(NcRewrite, ShiftUpdatesOnlyWhereEachAxisIsNamedAgain) {
  const std::string head = "G21 G90 G54\nG0 X-80 Y-30 Z90\nZ40\nG1 Z30 F500\nX-20\nG0 Z90\nG4 P1200\n";
  const auto updates = [](const std::string& text) {
    int count = 0;
    for (std::size_t at = text.find("G10 L2"); at != std::string::npos; at = text.find("G10 L2", at + 1)) ++count;
    return count;
  };
  const std::vector<std::string> how{"--rewrite", "shift", "--start-C", "28"};
  run(head + "G0 Z40\nG1 Z30\nX60\nG0 Z90\nM2\n", "modal", how);
  EXPECT_EQ(updates(corrected("modal")), 1) << corrected("modal");
  run(head + "G91\nG0 X40 Y5 Z-50\nG1 Z-10\nX40\nG0 Z60\nG90\nM2\n", "relative", how);
  EXPECT_EQ(updates(corrected("relative")), 1) << corrected("relative");
  const json summary = run(head + "G0 X60 Y30\nZ40\nG1 Z30\nX90\nG0 Z90\nM2\n", "named", how);
  EXPECT_EQ(updates(corrected("named")), 2) << corrected("named");
  run(corrected("named"), "again", {"--start-C", "28"});
  const core::Table a = blocks("named"), b = blocks("again");
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    if (a.column("rapid")[i] != 0) continue;
    EXPECT_LT((position(b, i) - position(a, i) - offset_mm(a, i)).cwiseAbs().maxCoeff() * 1e3,
              summary["rewrite"]["largest_deviation_um"].get<double>() + 0.1)
        << i;
  }
  // The first update cannot wait.
  toy.write("never.ngc", "G21 G90 G54\nG0 X-80 Y-30\nG91\nG1 Z-10 F500\nG90\nG0 Z90\nM2\n");
  std::vector<std::string> words{"nc", toy_model(), toy.file("never.ngc"), "--start", "X=0,Y=0,Z=50"};
  words.insert(words.end(), how.begin(), how.end());
  const Result refused = toy.run(words);
  EXPECT_EQ(refused.status, 3);
  EXPECT_SAYS(refused.err, "never.ngc:4");
  EXPECT_SAYS(refused.err, "X, Y and Z in G90 between an update of the zero and the next feed move");
}

// The folder in which the program is started is nobody's business.
TEST_F(NcRewrite, SubprogramFilesAreThoseBesideTheProgram) {
  toy.write("parts/main.ngc", "G21 G90 F1000\nG0 X-80 Y-30\no<slot> call [60]\nG0 Z90\nM2\n");
  toy.write("parts/slot.ngc", "o<slot> sub\nG1 Z20 (the part's own)\nX#1\no<slot> endsub\nM2\n");
  for (const char* kind : {"path", "shift"}) {
    const Result made = toy.run({"nc", toy_model(), toy.file("parts/main.ngc"), "--rewrite", kind, "--start-C", "28",
                                 "--start", "X=0,Y=0,Z=50", "--json"});
    ASSERT_EQ(made.status, 0) << kind << made.err;
    const json summary = json::parse(made.out);
    ASSERT_EQ(summary["files"].size(), 2U);
    EXPECT_EQ(summary["files"][1], toy.file("parts/slot.ngc"));
    const core::Table table = core::read_csv(toy.result("blocks.csv"));
    EXPECT_EQ(table.column("file").maxCoeff(), 1.0);
    EXPECT_EQ(table.column("line")[1], 2.0);
  }
  const auto files = files_in(toy.out());
  for (const auto& [name, bytes] : files) EXPECT_EQ(name.find("slot"), std::string::npos) << name;
}

// An update is written in the unit that holds at its place, whatever unit follows.
TEST_F(NcRewrite, ShiftKnowsTheUnitAtEachUpdate) {
  const std::string text =
      "G21 G90\nG0 X-80 Y-30\nG1 Z20 F500\nX-60\nG0 Z90\nG20\nX4 Y1.2\nG1 Z2.8 F20\nX4.3\nG0 Z3.7\nM2\n";
  const json summary = run(text, "units", {"--rewrite", "shift", "--start-C", "28"});
  EXPECT_EQ(summary["rewrite"]["changed"], 2) << corrected("units");
  run(corrected("units"), "again", {"--start-C", "28"});
  const core::Table a = blocks("units"), b = blocks("again");
  ASSERT_EQ(a.rows(), b.rows());
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    if (a.column("rapid")[i] != 0) continue;
    EXPECT_LT((position(b, i) - position(a, i) - offset_mm(a, i)).cwiseAbs().maxCoeff() * 1e3,
              summary["rewrite"]["largest_deviation_um"].get<double>() + 0.1)
        << i;
  }
}

// A feed of rotary axes alone stays when the unit of length changes, that of lines is converted.
TEST_F(NcRewrite, FeedsOfAnglesOutliveAChangeOfUnit) {
  const json before = run("G21 G90\nG0 X30 Y0 Z50 C0\nG1 C180 F360\nG20\nG1 C180.5\nG1 X1.5\nG1 C190\nM2\n", "units",
                          {"--rewrite", "path", "--start-C", "26"});
  const json again = run(corrected("units"), "again", {"--start-C", "26"});
  EXPECT_NEAR(again["cutting_s"].get<double>(), before["cutting_s"].get<double>(), 0.7) << corrected("units");
  EXPECT_SAYS(corrected("units"), "G1 C180.5 F360.0\n");
}

// An update replaces the control's own work offset: one that nobody stated is named. None follows the program's end.
TEST_F(NcRewrite, ShiftNamesWorkOffsetsThatAreNotStated) {
  toy.write("control.toml", "schema = 1\n[[work_offset]]\nnumber = 2\nZ_mm = 10\n");
  const auto warned = [&](const char* offset, const std::string& rest) {
    toy.write("part.ngc", fmt::format("G21 G90 {}\n{}", offset, rest));
    return toy.run({"nc", toy_model(), toy.file("part.ngc"), "--rewrite", "shift", "--start-C", "28", "--control",
                    toy.file("control.toml"), "--start", "X=0,Y=0,Z=50", "--json"});
  };
  const std::string cut = "G0 X-80 Y-30\nG1 Z20 F500\nX-60\nG0 Z80\nM30\n";
  const Result unstated = warned("G54", cut), stated = warned("G55", cut);
  ASSERT_EQ(unstated.status + stated.status, 0) << unstated.err << stated.err;
  EXPECT_SAYS(unstated.err, "warning: ");
  EXPECT_SAYS(unstated.err, "G54 is not stated and taken to be zero");
  EXPECT_EQ(json::parse(unstated.out)["rewrite"]["work_offsets_assumed_zero"], json::parse("[1]"));
  EXPECT_EQ(stated.err.find("not stated"), std::string::npos) << stated.err;
  EXPECT_EQ(json::parse(stated.out)["rewrite"]["work_offsets_assumed_zero"], json::array());
  const Result sub = warned("G55", "M98 P7\nG0 Z80\nM30\nO7\nG0 X-80 Y-30\nG1 Z20 F500\nX-60\nM99\n");
  ASSERT_EQ(sub.status, 0) << sub.err;
  const std::string text = read(toy.result("part.corrected.ngc"));
  EXPECT_LT(text.find("G10 L2 P2"), text.find("M98 P7")) << text;
  EXPECT_EQ(text.find("G10", text.find("M30")), std::string::npos) << text;
}

// Words of linear axes in a move of rotary axes make its feed count along these: the duration stays.
TEST_F(NcRewrite, RotaryFeedsKeepTheirDuration) {
  for (const char* move : {"G1 C360 F360", "G93 G1 C360 F1\nG94", "M3 S100\nG95 G1 C360 F3.6"}) {
    const json before = run(fmt::format("G21 G90\nG0 X30 Y0 Z50 C0\n{}\nG94\nG1 X40 F600\nM2\n", move), "rotary",
                            {"--rewrite", "path", "--start-C", "26"});
    const json again = run(corrected("rotary"), "again", {"--start-C", "26"});
    EXPECT_NEAR(before["cutting_s"].get<double>(), 61.0, 0.3) << move;
    EXPECT_NEAR(again["cutting_s"].get<double>(), before["cutting_s"].get<double>(), 0.7) << corrected("rotary");
  }
}

// P is the time of a dwell in a line with a move, whose axis words are coordinates.
TEST_F(NcRewrite, ADwellInTheLineOfAMoveStays) {
  const json before = run("G21 G90\nG0 X0 Y0 Z60\n#2=55\nG1 Z#2 G4 P0.5 F600\nG4 P1\nX20\nM2\n", "dwells",
                          {"--rewrite", "path", "--start-C", "26"});
  const json again = run(corrected("dwells"), "again", {"--start-C", "26"});
  EXPECT_NEAR(before["pause_s"].get<double>(), 1.5, 1e-9);
  EXPECT_NEAR(again["pause_s"].get<double>(), 1.5, 1e-9) << corrected("dwells");
  expect_displaced("dwells", "again", 1.2e-4);
}

// Axis words of G52 and G43.1 are offsets.
TEST_F(NcRewrite, OffsetsOfTheProgramStay) {
  const std::string text = "G21 G90\nG0 X0 Y0 Z60\nG52 X5\nG1 X30 F400\nG52 X0\nG1 Y10\nG43.1 Z5\nG1 X0\nM2\n";
  run(text, "offsets", {"--rewrite", "path", "--start-C", "26", "--tolerance", "50"});
  for (const char* line : {"\nG52 X5\n", "\nG52 X0\n", "\nG43.1 Z5\n"})
    EXPECT_NE(corrected("offsets").find(line), std::string::npos) << corrected("offsets");
  run(corrected("offsets"), "again", {"--start-C", "26"});
  expect_displaced("offsets", "again", 1.2e-4);
}

// An axis that is parked at the end of its travel stays there.
TEST_F(NcRewrite, RapidsEndAtTheTravel) {
  toy.write("home.ngc", "G21 G90\nG0 X10 Y10 Z60\nG1 X30 F400\nG0 X120\nG0 Y0\nG1 X20\nM2\n");
  const Result result = toy.run(
      {"nc", (toy_run() / "model.rom.h5").string(), toy.file("home.ngc"), "--rewrite", "path", "--start-C", "26"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_SAYS(result.err, "home.ngc:4: the offset is cut at the end of an axis's travel (2 rapid moves");
  EXPECT_NE(read(toy.result("home.corrected.ngc")).find("\nG0 X120 "), std::string::npos);
}

TEST_F(NcRewrite, NamesFeedsThatBeginUncorrected) {
  toy.write("ramp.ngc", "G21 G90\nG0 X10 Y10 Z60\nG53 G0 Z70\nG1 X30 F400\nM2\n");
  const Result result = toy.run(
      {"nc", (toy_run() / "model.rom.h5").string(), toy.file("ramp.ngc"), "--rewrite", "path", "--start-C", "26"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_SAYS(result.err, "ramp.ngc:4: a feed move begins without its offset, which comes in along it (1 such move in");
}

TEST_F(NcRewrite, RefusesWhatItWouldGetWrong) {
  const auto refused = [&](const std::string& text, const std::string& how, const std::vector<std::string>& says) {
    toy.write("part.ngc", text);
    const Result result = toy.run(
        {"nc", (toy_run() / "model.rom.h5").string(), toy.file("part.ngc"), "--rewrite", how, "--start-C", "26"});
    EXPECT_EQ(result.status, 3) << text << result.out;
    for (const std::string& words : says) EXPECT_SAYS(result.err, words);
    EXPECT_FALSE(std::filesystem::exists(toy.result("part.corrected.ngc")));
  };
  refused("G21\nG0 X5\nG92 X0\nG1 X1 F100\nM2\n", "path", {"part.ngc:3", "G92"});
  refused("G21\nG0 X5\nG10 L2 P1 X3\nG1 X1 F100\nM2\n", "shift", {"part.ngc:3", "G10"});
  refused("G21 G90\nG1 X120 F900\nM2\n", "path", {"part.ngc:2", "axis X at 120.", "with its offset"});
  refused("G21 G90\nG0 X5\nG53 G1 X50 F100\nM2\n", "path", {"part.ngc:3", "machine coordinates"});
  const Result machine = toy.run({"nc", toy.file("machine.toml"), toy.file("part.ngc"), "--rewrite", "path"});
  EXPECT_EQ(machine.status, 2);
  EXPECT_SAYS(machine.err, "reduced model");
}

}  // namespace
}  // namespace thermotwin::cases
