// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/load/process_heat.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "tests/core/reference_page.h"

namespace thermotwin::nc {
namespace {

constexpr const char* shares =
    "schema = 1\n[[heat]]\ndrive = \"chips\"\nshare = 0.7\n[[heat]]\ndrive = \"tool\"\nshare = 0.1\n";

mesh::Machine machine() {
  mesh::Machine machine;
  machine.name = "mill";
  for (const char* drive : {"chips", "tool", "", "fluid", "chips"}) {
    machine.sources.emplace_back();
    machine.sources.back().drive = drive;
  }
  return machine;
}

ProcessHeat parse(const std::string& text) {
  return {core::Config::parse(text, "process.toml", &process_keys()), machine()};
}

Timed cut(int tool, double rpm = 6000, bool rapid = false) {
  Timed timed;
  timed.element = Element::line(Positions::Zero(1), Positions::Ones(1));
  timed.element.state.tool = tool;
  timed.element.state.spindle_rpm = rpm;
  timed.element.rapid = rapid;
  timed.t_cruise = 10.0;
  return timed;
}

Eigen::VectorXd energy(ProcessHeat& heat, const Timed& timed, double from = 0, double to = 10) {
  Eigen::VectorXd energy = Eigen::VectorXd::Zero(std::ssize(heat.drives()));
  heat.add(timed, from, to, energy);
  return energy;
}

TEST(ProcessHeat, ReferencePageIsThatOfTheReader) {
  core::expect_reference_page("process", process_keys(), "nc_tests");
}

TEST(ProcessHeat, SharesOfAToolsPowerGoToTheirSources) {
  ProcessHeat heat = parse(std::string(shares) +
                           "[[tool]]\nnumber = 1\npower_W = 500\nidle_W = 100\n[[tool]]\nnumber = 2\npower_W = 200\n"
                           "[[tool.heat]]\ndrive = \"fluid\"\nshare = 0.5\n");
  EXPECT_EQ(heat.drives(), (std::vector<std::string>{"chips", "tool", "fluid"}));
  EXPECT_TRUE(energy(heat, cut(1)).isApprox(Eigen::Vector3d(2800, 400, 0)));
  EXPECT_TRUE(energy(heat, cut(2), 4, 6).isApprox(Eigen::Vector3d(0, 0, 200)));
  EXPECT_TRUE(heat.unknown_tools().empty());
}

TEST(ProcessHeat, NothingIsCutInRapidsAndWhileTheSpindleStands) {
  ProcessHeat heat = parse(std::string(shares) + "[[tool]]\nnumber = 1\npower_W = 500\n");
  Timed pause = cut(1);
  pause.element.pause = 10.0;
  for (const Timed& timed : {cut(1, 0.0), cut(1, 6000, true), pause}) EXPECT_TRUE(energy(heat, timed).isZero(0));
  EXPECT_FALSE(energy(heat, cut(1, -6000)).isZero(0)) << "counterclockwise";
}

TEST(ProcessHeat, AToolThatTheFileDoesNotHaveIsNamed) {
  ProcessHeat heat = parse(shares);
  EXPECT_TRUE(energy(heat, cut(7)).isZero(0));
  EXPECT_EQ(heat.unknown_tools(), std::set<int>{7});
}

TEST(ProcessHeat, MeasuredPowerReplacesThatOfTheTools) {
  ProcessHeat heat = parse(std::string(shares) + "[[tool]]\nnumber = 1\npower_W = 9000\nidle_W = 100\n");
  heat.use([](double from, double to) { return 300.0 * (to - from); });
  EXPECT_TRUE(energy(heat, cut(1)).isApprox(Eigen::Vector2d(1400, 200)));
  EXPECT_TRUE(energy(heat, cut(5), 0, 1).isApprox(Eigen::Vector2d(210, 30))) << "a tool without an entry";
  heat.use([](double from, double to) { return 50.0 * (to - from); });
  EXPECT_TRUE(energy(heat, cut(1)).isZero(0)) << "below the idle power";
}

TEST(ProcessHeat, WrongSharesAreRefused) {
  const auto says = [](const std::string& text, const std::vector<std::string>& words) {
    try {
      parse(text);
      FAIL() << text;
    } catch (const core::InputError& error) {
      for (const std::string& word : words)
        EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << word << " in: " << error.what();
    }
  };
  says(std::string(shares) + "[[heat]]\ndrive = \"fluid\"\nshare = 0.3\n", {"process.toml:", "1.1", "at most 1"});
  says("schema = 1\n[[heat]]\ndrive = \"swarf\"\nshare = 0.3\n", {"swarf", "mill", "chips, tool, fluid"});
  says(std::string(shares) + "[[heat]]\ndrive = \"chips\"\nshare = 0.1\n", {"chips"});
  says("schema = 1\n", {"no heat", "[[heat]]"});
  says(std::string(shares) + "[[tool]]\nnumber = 1\n[[tool]]\nnumber = 1\n", {"tool 1 twice"});
}

}  // namespace
}  // namespace thermotwin::nc
