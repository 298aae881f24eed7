// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/motion/logged_times.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/file.h"
#include "tests/core/temporary_folder.h"

namespace thermotwin::nc {
namespace {

constexpr const char* program = "G21 G90\nN10 G1 X10 F600\n/ n20 X20\nN30 X30\nG4 P1\nM2\n";

class LoggedTimesTest : public testing::Test {
protected:
  ControlLog read(const std::string& csv) {
    core::write_file(folder.path() / "part.ngc", program);
    core::write_file(folder.path() / "log.csv", csv);
    return ControlLog::read(folder.path() / "log.csv", folder.path() / "part.ngc");
  }
  std::string refusal(const std::string& csv) {
    try {
      read(csv);
    } catch (const core::InputError& error) {
      return error.what();
    }
    return "";
  }
  /// Each line of the program takes 1 s in the planner; lines without a move are in `still`.
  std::vector<Timed> run(const ControlLog& log, const std::vector<int>& lines, const std::vector<int>& still = {}) {
    std::vector<Timed> timed;
    LoggedTimes times(log, Positions::Zero(1), [&](const Timed& one) { timed.push_back(one); });
    double x = 0.0;
    for (const int line : lines) {
      MoveState state;
      state.line = line;
      times.block(state);
      if (std::find(still.begin(), still.end(), line) != still.end()) continue;
      Timed one;
      one.element = Element::line(Positions::Constant(1, x), Positions::Constant(1, x + 0.01));
      one.element.state = state;
      one.element.state.logged = times.reached();
      one.length = 0.01;
      one.cruise = 0.01;
      one.t_cruise = 1.0;
      x += 0.01;
      times.add(one);
    }
    times.finish();
    return timed;
  }
  static std::vector<double> durations(const std::vector<Timed>& timed) {
    std::vector<double> seconds;
    for (const Timed& one : timed) seconds.push_back(one.duration());
    return seconds;
  }
  core::TemporaryFolder folder;
};

TEST_F(LoggedTimesTest, DurationsAreThoseOfTheLog) {
  const ControlLog log = read("time_s,line\n100,2\n103,3\n104.5,4\n");
  const std::vector<Timed> timed = run(log, {1, 2, 3, 4, 5}, {1});
  EXPECT_EQ(durations(timed), (std::vector<double>{3.0, 1.5, 1.0, 1.0})) << "behind the last row the planner's";
  for (std::size_t i = 1; i < timed.size(); ++i) EXPECT_DOUBLE_EQ(timed[i].start, timed[i - 1].end());
  EXPECT_DOUBLE_EQ(timed[0].cruise * timed[0].t_cruise, 0.01) << "the way stays";
}

TEST_F(LoggedTimesTest, LinesThatTheLogLacksShareItsTime) {
  EXPECT_EQ(durations(run(read("time_s,line\n0,2\n6,5\n"), {2, 3, 4, 5})), (std::vector<double>{2.0, 2.0, 2.0, 1.0}));
}

TEST_F(LoggedTimesTest, ASampledLogRepeatsItsLines) {
  EXPECT_EQ(durations(run(read("time_s,line\n0,2\n1,2\n2,2\n3,4\n4,4\n5,5\n"), {2, 3, 4, 5})),
            (std::vector<double>{1.5, 1.5, 2.0, 1.0}));
}

TEST_F(LoggedTimesTest, RowsOfOneClockTickShareTheTimeToTheNextOne) {
  EXPECT_EQ(durations(run(read("time_s,line\n0,2\n0,3\n4,4\n4,5\n"), {2, 3, 4, 5})),
            (std::vector<double>{2.0, 2.0, 1.0, 1.0}));
}

TEST_F(LoggedTimesTest, ALineThatMovesNothingStands) {
  const std::vector<Timed> timed = run(read("time_s,line\n0,2\n2,3\n7,4\n8,5\n"), {2, 3, 4, 5}, {3});
  EXPECT_EQ(durations(timed), (std::vector<double>{2.0, 5.0, 1.0, 1.0}));
  EXPECT_EQ(timed[1].element.pause, 5.0);
  EXPECT_EQ(timed[1].element.state.line, 3U);
  EXPECT_NEAR(timed[1].element.base[0], 0.01, 1e-15);
}

TEST_F(LoggedTimesTest, LoopsAreFollowedInTheirOrder) {
  EXPECT_EQ(durations(run(read("time_s,line\n0,2\n2,3\n3,2\n7,3\n8,5\n"), {2, 3, 2, 3, 5})),
            (std::vector<double>{2.0, 1.0, 4.0, 1.0, 1.0}));
}

TEST_F(LoggedTimesTest, BlocksAreKnownByTheirNumbers) {
  EXPECT_EQ(durations(run(read("time_s,block\n0,10\n2,20\n5,30\n"), {2, 3, 4, 5})),
            (std::vector<double>{2.0, 3.0, 1.0, 1.0}));
}

TEST_F(LoggedTimesTest, PowerOfARowHoldsUntilTheNextOne) {
  const ControlLog log = read("time_s,line,spindle_power_W\n10,2,100\n12,2,400\n16,3,50\n");
  EXPECT_DOUBLE_EQ(log.energy(11.0, 14.0), 100.0 + 800.0);
  EXPECT_DOUBLE_EQ(log.energy(0.0, 10.0), 0.0);
  EXPECT_DOUBLE_EQ(log.energy(15.0, 30.0), 400.0) << "nothing is known behind the last row";
}

TEST_F(LoggedTimesTest, WhatContradictsTheProgramIsRefused) {
  const auto says = [](const std::string& text, std::vector<std::string> words) {
    for (const std::string& word : words) EXPECT_NE(text.find(word), std::string::npos) << word << " in: " << text;
  };
  says(refusal("time_s,line,feed\n0,2,1\n"), {"log.csv", "feed", "time_s", "line and block"});
  says(refusal("time_s,line,block\n0,2,10\n"), {"line and block"});
  says(refusal("line\n2\n"), {"time_s"});
  says(refusal("time_s,line\n0,2\n5,3\n4,4\n"), {"log.csv:4 time_s", "4 after 5", "run back"});
  says(refusal("time_s,line\n0,2\n1,7\n"), {"log.csv:3 line", "7", "1 to 6"});
  says(refusal("time_s,line\n0,2.5\n"), {"log.csv:2 line", "2.5"});
  says(refusal("time_s,block\n0,40\n"), {"log.csv:2 block", "40", "block numbers (N)"});
  says(refusal("time_s,block\n0,-1\n"), {"log.csv:2 block", "-1"});
  says(refusal("time_s,line\n0,\n"), {"log.csv:2"});
  says(refusal("time_s,line\n"), {"log.csv", "row"});
  const ControlLog log = read("time_s,line\n0,2\n1,4\n2,3\n");
  try {
    run(log, {2, 3, 4, 5});
    FAIL() << "line 3 does not run behind line 4";
  } catch (const core::InputError& error) {
    says(error.what(), {"log.csv:4 line", "3 after 4", "in the order", "part.ngc"});
  }
}

TEST_F(LoggedTimesTest, ALineThatIsSkippedIsNotThatOfTheLog) {
  const ControlLog log = read("time_s,line\n0,3\n2,4\n");
  LoggedTimes times(log, Positions::Zero(1), [](const Timed&) {});
  MoveState state;
  state.line = 3;
  times.block(state);
  EXPECT_EQ(times.reached(), 1);
  times.skipped();
  EXPECT_EQ(times.reached(), 0);
}

}  // namespace
}  // namespace thermotwin::nc
