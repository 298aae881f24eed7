// SPDX-License-Identifier: GPL-3.0-or-later
// `nc --control siemens` through the built program: the same part in the language of a Sinumerik control and in
// LinuxCNC's gives the same files.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstdlib>
#include <filesystem>

#include "tests/cases/nc_programs.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class NcSiemens : public testing::Test {
protected:
  void SetUp() override {
    if (!has_interpreter()) GTEST_SKIP() << "the program was built without LinuxCNC's interpreter";
  }
  Result run(const std::string& program, const std::string& control, const std::string& out) {
    return thermotwin(
        {"nc", toy.file("machine.toml"), toy.file(program), "--control", control, "--json", "--out", toy.file(out)});
  }
  Toy toy;
};

constexpr const char* siemens =
    "%_N_PART_MPF\n"
    ";$PATH=/_N_WKS_DIR/_N_PART_WPD\n"
    "N10 G17 G40 G71 G90 G94 G54\n"
    "N20 T=\"MILL\" D1\n"
    "N30 M6 ; change\n"
    "N40 MSG(\"roughing (1)\") S1=4000 M1=3\n"
    "N50 R1=40 R2=R1/2\n"
    "N60 G0 X=R1 Y0 Z60\n"
    "N70 TRANS X10 Y=-R2\n"
    "N80 G1 Z=IC(-5) F1200\n"
    "N90 G2 X=R1 Y20 CR=15\n"
    "N100 G3 X20 Y20 I=AC(30) J=AC(20)\n"
    "N110 G4 F2\n"
    "N120 TRANS\n"
    "N130 TRAORI\n"
    "N140 G1 X0 Y0 Z80 B10 C=DC(350) F3000\n"
    "N150 B0 C=DC(0)\n"
    "N160 TRAFOOF\n"
    "N170 G91 Z5\n"
    "N180 G90 G0 SUPA Z100 D0\n"
    "N190 M30\n";

constexpr const char* linuxcnc =
    "\n\n"
    "G17 G40 G21 G90 G94 G54\n"
    "T4\n"
    "M6 G43\n"
    "S4000 M3\n"
    "\n"
    "G0 X40 Y0 Z60\n"
    "G52 X10 Y-20\n"
    "G91 G1 Z-5 F1200\n"
    "G90 G2 X40 Y20 R15\n"
    "G90.1 G3 X20 Y20 I30 J20\n"
    "G4 P2\n"
    "G52 X0 Y0\n"
    "M428\n"
    "G1 X0 Y0 Z80 B10 C-10 F3000\n"
    "B0 C0\n"
    "M429\n"
    "G91 Z5\n"
    "G90 G0 G49 G53 Z100\n"
    "M30\n";

TEST_F(NcSiemens, TheSamePartGivesTheSameFiles) {
  const std::string tools = "[[tool]]\nnumber = 4\nlength_mm = 12.5\n";
  toy.write("siemens.toml", "schema = 1\ndialect = \"siemens\"\n" + tools + "name = \"mill\"\n");
  toy.write("linuxcnc.toml", "schema = 1\n" + tools +
                                 "[[word]]\nword = \"M428\"\naction = \"tcp_on\"\n[[word]]\nword = \"M429\"\naction = "
                                 "\"tcp_off\"\n");
  toy.write("part.mpf", siemens);
  toy.write("part.ngc", linuxcnc);
  const Result one = run("part.mpf", toy.file("siemens.toml"), "one");
  const Result other = run("part.ngc", toy.file("linuxcnc.toml"), "other");
  ASSERT_EQ(one.status, 0) << one.err;
  ASSERT_EQ(other.status, 0) << other.err;
  json first = json::parse(one.out), second = json::parse(other.out);
  EXPECT_EQ(first["moves"], 8);
  EXPECT_EQ(first["arcs"], 2);
  EXPECT_EQ(first["tool_changes"], 1);
  for (const char* own : {"out", "files"}) {
    first.erase(own);
    second.erase(own);
  }
  EXPECT_EQ(first, second);
  for (const char* file : {"rows.csv", "operations.csv"})
    EXPECT_EQ(read(fs::path(toy.file("one")) / file), read(fs::path(toy.file("other")) / file)) << file;
}

TEST_F(NcSiemens, MessagesHaveTheProgramsOwnPlace) {
  toy.write("part.mpf", "G90\nG1 X5 F100\nCYCLE81(1, 2)\nM30\n");
  Result result = run("part.mpf", "siemens", "out");
  EXPECT_EQ(result.status, 3);
  EXPECT_SAYS(result.err, "part.mpf:3: 'CYCLE81(1, 2)'");
  // Refused by the interpreter behind the reader: an arc without a centre.
  toy.write("part.mpf", "G90 G17\nG1 X5 F100\nG2 X20 Y20\nM30\n");
  result = run("part.mpf", "siemens", "out");
  EXPECT_EQ(result.status, 3);
  EXPECT_SAYS(result.err, "part.mpf:3: ");
  EXPECT_EQ(result.err.find("thermotwin_nc_"), std::string::npos) << result.err;
  // Beyond the travel.
  toy.write("part.mpf", "G90 G17\nG1 X5 F100\nG1 X500\nM30\n");
  result = run("part.mpf", "siemens", "out");
  EXPECT_EQ(result.status, 3);
  EXPECT_SAYS(result.err, "part.mpf:3: axis X at 500");
  EXPECT_EQ(result.err.find("thermotwin_nc_"), std::string::npos) << result.err;
  EXPECT_FALSE(fs::exists(toy.file("out/rows.csv")));
}

// The control starts with G1.
TEST_F(NcSiemens, AProgramMayBeginWithCoordinates) {
  toy.write("part.mpf", "X10 Y5 F500\nX20\nG0 X0\nM30\n");
  const Result result = run("part.mpf", "siemens", "out");
  ASSERT_EQ(result.status, 0) << result.err;
  const json summary = json::parse(result.out);
  EXPECT_EQ(summary["feeds"], 2);
  EXPECT_EQ(summary["traverses"], 1);
  toy.write("part.mpf", "X10\nM30\n");
  const Result slow = run("part.mpf", "siemens", "out");
  EXPECT_EQ(slow.status, 3);
  EXPECT_SAYS(slow.err, "part.mpf:1");
}

TEST_F(NcSiemens, NoTranslationStaysBehind) {
  const fs::path temporary = toy.file("temporary");
  fs::create_directories(temporary);
  toy.write("part.mpf", "G90\nG1 X5 F100\nM30\n");
  toy.write("bad.mpf", "G90\nG1 X5 F100\nGOTOF END\nM30\n");
  setenv("TMPDIR", temporary.c_str(), 1);
  const Result good = run("part.mpf", "siemens", "out"), bad = run("bad.mpf", "siemens", "out");
  unsetenv("TMPDIR");
  EXPECT_EQ(good.status, 0) << good.err;
  EXPECT_EQ(bad.status, 3);
  EXPECT_TRUE(fs::is_empty(temporary));
}

TEST_F(NcSiemens, ARewrittenProgramIsRefused) {
  toy.write("part.mpf", "G90\nG1 X5 F100\nM30\n");
  const Result result = toy.run(
      {"nc", (toy_run() / "model.rom.h5").string(), toy.file("part.mpf"), "--control", "siemens", "--rewrite", "path"});
  EXPECT_EQ(result.status, 2);
  EXPECT_SAYS(result.err, "does not write programs of the control 'siemens'");
}

// A statement of control flow is not to be skipped: what it governs would then run once.
TEST_F(NcSiemens, ControlFlowIsNotOfferedToBeSkipped) {
  for (const char* line : {"WHILE TRUE", "LOOP", "REPEAT", "GOTOF ENDE", "ELSE"}) {
    toy.write("flow.mpf", std::string("N1 G0 X1\n") + line + "\nM30\n");
    const Result result = run("flow.mpf", "siemens", "flow");
    EXPECT_EQ(result.status, 3) << line;
    EXPECT_SAYS(result.err, "flow.mpf:2");
    EXPECT_SAYS(result.err, "write out the lines that run");
    EXPECT_EQ(result.err.find("[[word]]"), std::string::npos) << result.err;
  }
}

}  // namespace
}  // namespace thermotwin::cases
