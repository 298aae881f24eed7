// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/program/program.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/error.h"
#include "core/file.h"
#include "nc/control/control_profile.h"
#include "tests/core/temporary_folder.h"
#include "tests/nc/interpreter_there.h"

namespace thermotwin::nc {
namespace {

/// Programs through the helper with LinuxCNC's interpreter.
class NcProgram : public testing::Test {
protected:
  void SetUp() override {
    if (!interpreter_there()) GTEST_SKIP() << "the program was built without LinuxCNC's interpreter";
    machine.axes.resize(4);
    for (std::size_t i = 0; i < 4; ++i) machine.axes[i].id = std::string(1, "XYZC"[i]);
    machine.axes[3].kind = mesh::AxisKind::rotary;
    control = ControlProfile::load("fanuc", machine);
  }
  ProgramSummary read(const std::string& text) {
    core::write_file(folder / "part.ngc", text);
    InterpreterOptions options;
    options.program = folder / "part.ngc";
    options.axis_mask = 0x27;
    ProgramSink sink;
    moves.clear();
    sink.pause = [](const Pause&) {};
    sink.move = [&](const Move& move, const Frame&) { moves.push_back(move); };
    return read_program(options, control, sink);
  }
  std::string message(const std::string& text) {
    try {
      read(text);
    } catch (const core::InputError& error) {
      return error.what();
    }
    return "";
  }
  core::TemporaryFolder folder;
  mesh::Machine machine;
  ControlProfile control;
  std::vector<Move> moves;
};

TEST_F(NcProgram, DwellsOfFanucAreMilliseconds) {
  EXPECT_DOUBLE_EQ(read("G21 G90\nG4 P1500\nG4 X2.5\nG4 U.5\nM30\n").end.dwelt, 4.5);
  EXPECT_DOUBLE_EQ(read("G21 G90 F100\nG98 G82 X1 Y0 Z-4 R1 P500\nX2\nX3 P250\nG80\nM30\n").end.dwelt, 1.25);
  EXPECT_DOUBLE_EQ(read("G21 G90\n#1=2000\nG4 P#1\nM30\n").end.dwelt, 2.0);
  EXPECT_NE(message("G21\nG4 P1.5\nM30\n").find("part.ngc:2: P1.5 of a dwell; allowed: P in whole milliseconds"),
            std::string::npos);
  EXPECT_NE(message("G21\nG4 X2\nM30\n").find("decimal point"), std::string::npos);
  control = ControlProfile::load("linuxcnc", machine);
  EXPECT_DOUBLE_EQ(read("G21\nG4 P1.5\nM30\n").end.dwelt, 1.5);
}

TEST_F(NcProgram, VariablesOfFanucThatTheProgramDoesNotSetAreRefused) {
  for (const char* line : {"#1=#5041", "#1=#4001", "#3000=1", "G1 X#150 F100", "#1=#[5000+41]", "#2=[#1+1]"})
    EXPECT_NE(message(std::string("G21\n") + line + "\nM30\n").find("part.ngc:2: #"), std::string::npos) << line;
  EXPECT_EQ(message("G21 F100\n#100=5\n#1=[#100+1]\nG1 X#1\n#[100+1]=7 (#5041)\nG1 X#101\nM30\n"), "");
}

TEST_F(NcProgram, OffsetsThatFanucSetsOtherwiseAreRefused) {
  for (const char* line : {"G10 L20 P1 X0", "G10 L10 P1 R30.", "G10 L11 P1 R3.", "G10 L1 P1 Z3.", "G10 P1 R5.",
                           "G10 L2 P0 X1", "G91 G10 L2 P1 X1"})
    EXPECT_NE(message(std::string("G21\n") + line + "\nM30\n").find("part.ngc:2: G10"), std::string::npos) << line;
  read("G21 G90\nG10 L2 P1 X5\nG54 G0 X1\nM30\n");
  EXPECT_NEAR(moves.back().to[0], 6e-3, 1e-12);
}

TEST_F(NcProgram, AxisWordsOfFanucsPathControlMoveNothing) {
  for (const char* line : {"G05.1 Q2 X0 Y0 Z0", "G5.1 Q3 X0 Y0 Z0", "G05.1 Q1 R5"}) {
    read(std::string("G21 G90\nG0 X30\n") + line + "\nG0 X40\nM30\n");
    ASSERT_EQ(moves.size(), 2U) << line;
    EXPECT_NEAR(moves.back().from[0], 0.03, 1e-12) << line;
  }
}

// LinuxCNC takes F in the unit of its line and keeps the speed when the unit changes.
TEST_F(NcProgram, AFeedKeepsItsSpeedWhenTheUnitChanges) {
  read("G21 G90\nG20\nG1 X1 F48\nG21\nG1 X0\nC48\nM30\n");
  ASSERT_EQ(moves.size(), 3U);
  EXPECT_NEAR(moves[0].length / moves[0].speed, 1.25, 1e-9);
  EXPECT_NEAR(moves[1].length / moves[1].speed, 1.25, 1e-9);
  EXPECT_NEAR(moves[2].length / moves[2].speed, 60.0, 1e-9) << "deg have no unit of length";
  read("G21 G90\nG1 X25.4 F1219.2\nG20\nG1 X0\nM30\n");
  EXPECT_NEAR(moves[1].length / moves[1].speed, 1.25, 1e-9);
}

TEST_F(NcProgram, AMoveOrPauseOfDaysIsRefused) {
  EXPECT_NE(message("G21 G90\nG1 X100 F0.0001\nM30\n").find("part.ngc:2: a move of 1.67e+04 h; allowed: at most 24 h"),
            std::string::npos)
      << message("G21 G90\nG1 X100 F0.0001\nM30\n");
  control = ControlProfile::load("linuxcnc", machine);
  EXPECT_NE(message("G21\nG4 P999999\nM30\n").find("part.ngc:2: a pause of 278 h"), std::string::npos);
}

// A degree counts as a millimetre where lines and angles move together.
TEST_F(NcProgram, MixedFeedsOfFanucCountDegrees) {
  read("G21 G90\nG1 X30 C40 F100\nC80\nM30\n");
  ASSERT_EQ(moves.size(), 2U);
  EXPECT_NEAR(moves[0].length / moves[0].speed, 30.0, 1e-9);
  EXPECT_NEAR(moves[1].length / moves[1].speed, 24.0, 1e-9);
  control = ControlProfile::load("linuxcnc", machine);
  read("G21 G90\nG1 X30 C40 F100\nM30\n");
  EXPECT_NEAR(moves[0].length / moves[0].speed, 18.0, 1e-9);
}

// 29.99 mm have no exact value in inches.
TEST_F(NcProgram, ARotaryMoveAfterAChangeOfUnitTakesItsTime) {
  for (const char* x : {"30", "29.99", "0.1"}) {
    read(fmt::format("G21 G90\nG0 X{}\nG1 C180 F360\nG20\nG1 C270\nM2\n", x));
    ASSERT_EQ(moves.size(), 3U);
    EXPECT_NEAR(moves[2].length / moves[2].speed, 15.0, 1e-9) << x;
  }
}

TEST_F(NcProgram, LinesWithASlashAreCountedAndMayRun) {
  const std::string text = "G21 G90\nG0 X1\n/G0 X2\n /G0 X3\nG0 Y1\nM30\n";
  EXPECT_EQ(read(text).deletable, 2);
  EXPECT_EQ(moves.size(), 2U);
  control.block_delete = false;
  read(text);
  EXPECT_EQ(moves.size(), 4U);
}

TEST_F(NcProgram, AProgramMayEndWithItsFile) {
  for (const char* text : {"G21\nG0 X1\n", "G21\nG0 X1\n%\n", "%\nG21\nG0 X1\n", "G21\nG0 X1\n%\nG0 X7 ?\n"}) {
    EXPECT_TRUE(read(text).open_end) << text;
    EXPECT_EQ(moves.size(), 1U) << text;
  }
  EXPECT_FALSE(read("G21\nG0 X1\nM2\n").open_end);
  EXPECT_FALSE(read("%\nG21\nG0 X1\n%\n").open_end);
  EXPECT_NE(message("G21\no1 call\nM2\no1 sub\nG0 X1\n"), "") << "a subprogram that does not end";
  EXPECT_NE(message("G21\no1 while [0]\nG0 X1\n"), "") << "a loop that does not end";
}

TEST_F(NcProgram, RefusalsOfTheInterpreterSayWhatIsAllowed) {
  for (const auto& [line, says] : {std::pair{"M98 P77", "o1001.ngc for O1001"},
                                   {"G1 X1+2 F100", "square brackets"},
                                   {"G0 A5", "letters of this machine's axes"},
                                   {"G12.9", "[[word]] of the control profile"}})
    EXPECT_NE(message(std::string("G21\n") + line + "\nM30\n").find(says), std::string::npos)
        << message(std::string("G21\n") + line + "\nM30\n");
}

TEST_F(NcProgram, MovesOfATranslationHaveTheProgramsName) {
  control = ControlProfile::load("siemens", machine);
  const ProgramSummary summary = read("G71 G90\nG0 X5\nM30\n");
  EXPECT_EQ(summary.files.at(moves.at(0).state.file), (folder / "part.ngc").string());
}

}  // namespace
}  // namespace thermotwin::nc
