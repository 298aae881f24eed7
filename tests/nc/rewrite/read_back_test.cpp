// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/rewrite/read_back.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "core/error.h"
#include "core/file.h"
#include "nc/control/control_profile.h"
#include "tests/core/temporary_folder.h"
#include "tests/nc/interpreter_there.h"

namespace thermotwin::nc {
namespace {

constexpr const char* text =
    "G21 G90 G17\nT1 M6 G43 H1\nS800 M3\nM8\nG1 X10 F600\nG3 X-10 I-10 J0 P2\nG4 P2\nG64 P0.02\nG0 Z5\nM9\nM2\n";

class NcReadBack : public testing::Test {
protected:
  void SetUp() override {
    if (!interpreter_there()) GTEST_SKIP() << "the program was built without LinuxCNC's interpreter";
    mesh::Machine machine;
    machine.axes.resize(3);
    for (std::size_t i = 0; i < 3; ++i) machine.axes[i].id = std::string(1, letters[i]);
    control = ControlProfile::parse("schema = 1\n[[tool]]\nnumber = 1\nlength_mm = 12\n", "test", machine);
  }
  InterpreterOptions program(const std::string& name, const std::string& content) const {
    core::write_file(folder / name, content);
    InterpreterOptions options;
    options.program = folder / name;
    return options;
  }
  /// What the check says on another program with the moves and states of the text; empty: nothing.
  std::string said(const std::string& other) {
    ReadBack read_back(folder / "moves.bin");
    ProgramSink sink;
    sink.pause = [](const Pause&) {};
    sink.move = [&](const Move& move, const Frame& frame) {
      ExpectedMove expected = ExpectedMove::of(move, frame, move.to);
      expected.speed = move.speed;
      if (move.kind == MoveKind::arc) expected.angle = move.arc.angle;
      read_back.expect(expected);
    };
    const ProgramSummary summary = read_program(program("part.ngc", text), control, sink);
    try {
      read_back.check(program("part.corrected.ngc", other), control, summary, 0.0);
    } catch (const core::InputError& error) {
      return error.what();
    }
    return "";
  }
  static std::string with(const std::string& old, const std::string& other) {
    std::string changed = text;
    changed.replace(changed.find(old), old.size(), other);
    return changed;
  }
  core::TemporaryFolder folder;
  ControlProfile control;
};

TEST_F(NcReadBack, TakesTheSameProgramAndOneWithinRounding) {
  EXPECT_EQ(said(text), "");
  EXPECT_EQ(said(with("X10 F600", "X10.00005 F600")), "");
  EXPECT_EQ(said(with("G0 Z5", "G0 Z5\nZ5.0001\nZ5")), "") << "moves within rounding";
}

TEST_F(NcReadBack, NamesTheLineAndTheDifference) {
  struct Case {
    const char *old, *other, *line, *says;
  };
  for (const Case& one : {Case{"T1 M6 G43 H1\n", "", ":5", "tool"},
                          {" G43 H1", "", ":5", "tool length offset in mm 0 instead of 12"},
                          {"S800 M3\n", "", ":5", "spindle speed in rpm 0 instead of 800"},
                          {"M8\n", "", ":5", "flood off instead of on"},
                          {"X10 F", "X10.01 F", ":5", "X ends at 10.0100 instead of 10.0000"},
                          {"F600", "F700", ":5", "feed"},
                          {" P2\n", "\n", ":6", "an arc of"},
                          {"G4 P2\n", "", ":9", "dwell"},
                          {"G64 P0.02\n", "", ":9", "path tolerance"},
                          {"G0 Z5", "G52 X1\nG0 X-11 Z5", ":9", "X: the zero of the program in 1 instead of 0"},
                          {"G0 Z5", "G1 Z5", ":9", "a line instead of a rapid move"},
                          {"G0 Z5\n", "", ":9", "is missing"},
                          {"G0 Z5\n", "G0 Z5\nX0\n", ":9", "a rapid move more"},
                          {"M9\n", "M9\nM0\n", ":11", "at its end tool change or stop"},
                          {"M2\n", "", ":9", "the interpreter refuses the corrected program"}}) {
    const std::string message = said(with(one.old, one.other));
    EXPECT_NE(message.find("part.ngc" + std::string(one.line)), std::string::npos) << one.old << one.other << message;
    EXPECT_NE(message.find(one.says), std::string::npos) << one.old << one.other << message;
  }
}

// A feed that counts along other axes is another duration, whatever its F is.
TEST_F(NcReadBack, ComparesTheSecondsOfAFeed) {
  const auto said_of = [&](double seconds) {
    constexpr const char* part = "G21 G90\nG1 X10 F600\nM2\n";
    ReadBack read_back(folder / "moves.bin");
    ProgramSink sink;
    sink.pause = [](const Pause&) {};
    sink.move = [&](const Move& move, const Frame& frame) {
      ExpectedMove expected = ExpectedMove::of(move, frame, move.to);
      expected.seconds = seconds;
      read_back.expect(expected);
    };
    const ProgramSummary summary = read_program(program("part.ngc", part), control, sink);
    try {
      read_back.check(program("part.corrected.ngc", part), control, summary, 0.0);
    } catch (const core::InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(said_of(1.0), "");
  EXPECT_NE(said_of(4.0).find(":2: the corrected program does not do the same here: seconds of a feed move 1 instead"),
            std::string::npos)
      << said_of(4.0);
}

// Ends alone do not show a line or an arc that is displaced by the wrong offset within.
TEST_F(NcReadBack, ComparesPointsWithinABlock) {
  constexpr const char* part = "G21 G90 G17\nG1 X10 Z0 F600\nG3 X-10 I-10 J0\nM2\n";
  const auto said_of = [&](double line_z, double arc_y) {
    ReadBack read_back(folder / "moves.bin");
    ProgramSink sink;
    sink.pause = [](const Pause&) {};
    sink.move = [&](const Move& move, const Frame& frame) {
      const bool arc = move.kind == MoveKind::arc;
      const ExpectedPoint first{0.25, {2.5e-3, 0, 0}, 1e-6}, second{0.5, {5e-3, 0, line_z}, 1e-6},
          third{0.5, {0, arc_y, 0}, 1e-6};
      read_back.expect(ExpectedMove::of(move, frame, move.to), arc ? std::vector{third} : std::vector{first, second});
    };
    const ProgramSummary summary = read_program(program("part.ngc", part), control, sink);
    try {
      read_back.check(program("part.corrected.ngc", part), control, summary, 0.0);
    } catch (const core::InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(said_of(0.0, 10e-3), "");
  for (const auto& [line_z, arc_y, words] :
       {std::tuple{11.6e-6, 10e-3, ":2: the corrected program does not do the same"},
        {11.6e-6, 10e-3, "a line is 11.60 um off at 50 % of it"},
        {0.0, 10.0048e-3, "an arc is 4.80 um off at 50 % of it"}})
    EXPECT_NE(said_of(line_z, arc_y).find(words), std::string::npos) << said_of(line_z, arc_y);
}

}  // namespace
}  // namespace thermotwin::nc
