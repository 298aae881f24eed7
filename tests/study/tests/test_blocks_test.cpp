// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/tests/test_blocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>

#include "core/error.h"
#include "solver/operation/channels.h"
#include "tests/machines/rods.h"

namespace thermotwin::study {
namespace {

BlockOptions probed_options() {
  BlockOptions of;
  of.block_s = 5400;
  of.probe_every_s = 1800;
  of.probe_pose = mesh::home_pose(lumped::machine());
  return of;
}

TEST(StandardBlocks, LoadEachDriveAndStandWhereTheProbeMeasures) {
  const mesh::Machine machine = lumped::machine();
  const solver::Channels channels(machine);
  const std::vector<TestBlock> blocks = standard_blocks(machine, probed_options());
  std::set<std::string> names;
  for (const TestBlock& block : blocks) {
    EXPECT_TRUE(names.insert(block.name).second) << block.name;
    EXPECT_DOUBLE_EQ(block.seconds(), 5400.0) << block.name;
    int probed = 0;
    double now = 0.0;
    for (const TestPhase& phase : block.phases) {
      now += phase.seconds;
      if (!phase.probes) continue;
      EXPECT_NEAR(now, 1800.0 * ++probed, 1e-6);
      EXPECT_EQ(phase.from[channels.index("spindle.speed_rpm")], 0.0);
      EXPECT_EQ(phase.from[channels.index("axis.Z.feed_mm_min")], 0.0);
      EXPECT_EQ(phase.from[channels.index("axis.Z.position_mm")], 0.0);
    }
    EXPECT_EQ(probed, 3) << block.name;
  }
  for (const char* name : {"standstill", "standstill, no coolant", "spindle", "spindle, random", "Z", "Z, random",
                           "all", "spindle, axes high"})
    EXPECT_TRUE(names.contains(name)) << name;
  const auto random = std::find_if(blocks.begin(), blocks.end(), [](const auto& b) { return b.name == "Z, random"; });
  std::set<double> feeds;
  for (const TestPhase& phase : random->phases) feeds.insert(phase.from[channels.index("axis.Z.feed_mm_min")]);
  EXPECT_GT(feeds.size(), 3U);
}

TEST(IsoBlocks, FillTheTimeInTheOrderOfItsClauses) {
  const mesh::Machine machine = lumped::machine();
  const std::vector<TestBlock> blocks = iso_230_3_blocks(machine, probed_options(), 24 * 3600.0);
  std::vector<std::string> names;
  double seconds = 0.0;
  for (const TestBlock& block : blocks) {
    seconds += block.seconds();
    if (block.name != "standstill") names.push_back(block.name);
  }
  EXPECT_EQ(blocks.front().name, "standstill");
  EXPECT_EQ(names, (std::vector<std::string>{"spindle", "Z"}));
  EXPECT_NEAR(seconds, 24 * 3600.0, 1e-6);
}

TEST(TestText, ReadsBackAsItsBlocks) {
  const mesh::Machine machine = lumped::machine();
  const solver::LoadProgram own = solver::LoadProgram::parse(
      "schema = 1\n[[phase]]\nname = \"ramp\"\nduration_h = 1\nair_C = [20, 24]\nspindle_rpm = 6000\n[[phase]]\n"
      "duration_min = 30\ncoolant = false\nspindle_rpm = 0\n[[phase.axis]]\nid = \"Z\"\nlow_mm = 50\nhigh_mm = "
      "300\nfeed_mm_min = 9000\nduty_percent = 40\n",
      "own.toml", machine);
  EXPECT_TRUE(moves_surroundings(machine, own));
  std::vector<TestBlock> blocks = standard_blocks(machine, probed_options());
  blocks.push_back(program_block(machine, own, probed_options(), own.duration()));
  EXPECT_DOUBLE_EQ(blocks.back().seconds(), 5400.0);
  std::vector<const TestBlock*> order;
  for (const TestBlock& block : blocks) order.push_back(&block);
  const solver::LoadProgram load =
      solver::LoadProgram::parse(test_text(machine, order, "all", 20.0, 600.0), "all.toml", machine);
  EXPECT_FALSE(moves_surroundings(
      machine, solver::LoadProgram::parse(test_text(machine, {order.front()}, "", 20.0, 600.0), "one.toml", machine)));
  BlockOptions as_it_is = probed_options();
  as_it_is.probe_every_s = 0.0;
  const TestBlock read = program_block(machine, load, as_it_is, std::numeric_limits<double>::infinity());
  std::size_t at = 0;
  for (const TestBlock& block : blocks) {
    for (const TestPhase& phase : block.phases) {
      ASSERT_LT(at, read.phases.size());
      const TestPhase& back = read.phases[at++];
      EXPECT_EQ(back.name, phase.name);
      EXPECT_NEAR(back.seconds, phase.seconds, 1e-6);
      for (Eigen::Index c = 0; c < phase.from.size(); ++c) {
        for (const auto& [ours, theirs] : {std::pair{back.from[c], phase.from[c]}, {back.to[c], phase.to[c]}}) {
          if (std::isnan(theirs))
            EXPECT_TRUE(std::isnan(ours));
          else
            EXPECT_NEAR(ours, theirs, 1e-6) << block.name << " " << solver::Channels(machine).names()[c];
        }
      }
    }
  }
  EXPECT_EQ(at, read.phases.size());
}

TEST(BlockOptions, RefuseShorterIntervals) {
  BlockOptions hasty = probed_options();
  hasty.interval_s = 60;
  EXPECT_THROW(standard_blocks(lumped::machine(), hasty), core::InputError);
}

}  // namespace
}  // namespace thermotwin::study
