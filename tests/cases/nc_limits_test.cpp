// SPDX-License-Identifier: GPL-3.0-or-later
// Limits of the offsets in `nc`: stated with or without a saved state, counted, never passed by a corrected program.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "core/table.h"
#include "tests/cases/nc_programs.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* part = "G21 G90\nG0 X10 Y10 Z60\nG1 X60 F600\nX-100\nM2\n";

class NcLimits : public testing::Test {
protected:
  void SetUp() override {
    if (!has_interpreter()) GTEST_SKIP() << "the program was built without LinuxCNC's interpreter";
    toy.write("part.ngc", part);
  }
  Result nc(std::vector<std::string> more) const {
    std::vector<std::string> arguments = {"nc", toy_model(), toy.file("part.ngc"), "--start", "X=0,Y=0,Z=50"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return toy.run(arguments);
  }
  void expect_refused(const std::vector<std::string>& more, const std::vector<std::string>& says) const {
    const Result result = nc(more);
    EXPECT_EQ(result.status, 3) << result.out;
    for (const std::string& words : says) EXPECT_SAYS(result.err, words);
    EXPECT_TRUE(files_in(toy.out()).empty()) << "results of a refused program";
  }
  Toy toy;
};

TEST_F(NcLimits, ACorrectedProgramPassesNone) {
  for (const char* how : {"path", "shift"}) {
    expect_refused({"--rewrite", how, "--start-C", "26", "--largest-offset", "2"},
                   {"part.ngc:2: an offset of ", " um with --rewrite; allowed: at most 2 um (--largest-offset)"});
    expect_refused({"--rewrite", how, "--start-C", "26", "--offset-rate", "0.001"},
                   {"part.ngc:3: an offset that changes by ", "allowed: at most 0.001 um/s (--offset-rate)"});
  }
}

TEST_F(NcLimits, TheSummaryCountsMovesBeyond) {
  const std::vector<std::string> how = {"--start-C", "26", "--largest-offset", "2", "--offset-rate", "0.001"};
  const Result said = nc(how);
  ASSERT_EQ(said.status, 0) << said.err;
  EXPECT_SAYS(said.out, "3 moves have an offset above the limit of 2 um: up to ");
  EXPECT_SAYS(said.out, "first in line 2");
  EXPECT_SAYS(said.out, "2 moves have an offset that changes faster than the limit of 0.001 um/s: up to ");
  EXPECT_SAYS(said.out, "first in line 3");
  std::vector<std::string> as_json = how;
  as_json.emplace_back("--json");
  const json summary = json::parse(nc(as_json).out);
  EXPECT_EQ(summary["moves_beyond_largest_offset"], 3);
  EXPECT_EQ(summary["moves_beyond_offset_rate"], 2);
  EXPECT_EQ(summary["offset_limits"], (json{{"largest_um", 2.0}, {"rate_um_s", 0.001}}));
  const Result within = nc({"--start-C", "26", "--json"});
  const json limits = json::parse(within.out);
  EXPECT_EQ(limits["moves_beyond_largest_offset"], 0);
  EXPECT_GT(limits["offset_limits"]["largest_um"], 10.0) << "by the model";
}

// Limits that hold change no byte; the largest offset of the table is the one that just fits.
TEST_F(NcLimits, OffsetsWithinThemAreWritten) {
  const std::vector<std::string> how = {"--rewrite", "path", "--start-C", "26"};
  ASSERT_EQ(nc(how).status, 0);
  const std::string free = read(toy.result("part.corrected.ngc"));
  const core::Table blocks = core::read_csv(toy.result("blocks.csv"));
  double largest = 0.0;
  for (const char* column : {"offset_X_um", "offset_Y_um", "offset_Z_um"})
    largest = std::max(largest, blocks.column(column).cwiseAbs().maxCoeff());
  const auto with = [&](double limit) {
    std::vector<std::string> words = how;
    words.insert(words.end(), {"--largest-offset", std::to_string(limit)});
    fs::remove_all(toy.out());
    return nc(words);
  };
  const Result fits = with(largest + 0.01);
  ASSERT_EQ(fits.status, 0) << fits.err;
  EXPECT_EQ(read(toy.result("part.corrected.ngc")), free);
  EXPECT_EQ(with(largest - 0.01).status, 3);
}

// A circle that begins and ends where the offset is small, through a place where it is larger.
TEST_F(NcLimits, MomentsWithinABlockCount) {
  toy.write("part.ngc", "G21 G90\nG0 Z80\nM2\n");
  ASSERT_EQ(nc({"--start-C", "26"}).status, 0);
  const Eigen::VectorXd offset = core::read_csv(toy.result("blocks.csv")).column("offset_Z_um").cwiseAbs();
  ASSERT_EQ(offset.size(), 1);
  toy.write("part.ngc", "G21 G90\nG0 Z20\nG18 G2 X0 Z20 I0 K30 F600\nM2\n");
  ASSERT_EQ(nc({"--start-C", "26"}).status, 0);
  const core::Table ends = core::read_csv(toy.result("blocks.csv"));
  double largest = 0.0;
  for (const char* column : {"offset_X_um", "offset_Y_um", "offset_Z_um"})
    largest = std::max(largest, ends.column(column).cwiseAbs().maxCoeff());
  ASSERT_GT(offset[0], largest + 0.5) << "the offset depends too little on the place to show anything";
  const std::string limit = std::to_string(0.5 * (offset[0] + largest));
  const json summary = json::parse(nc({"--start-C", "26", "--largest-offset", limit, "--json"}).out);
  EXPECT_EQ(summary["moves_beyond_largest_offset"], 1);
  fs::remove_all(toy.out());
  expect_refused({"--start-C", "26", "--largest-offset", limit, "--rewrite", "shift"}, {"part.ngc:3: an offset of "});
}

// The limits of a saved state are those of the compensator that saved it.
TEST_F(NcLimits, ASavedStateHasItsOwn) {
  std::string rows = "time_s,spindle.speed_rpm,axis.X.position_mm,axis.Z.position_mm,air.T_C\n";
  for (int i = 0; i <= 120; ++i) rows += std::to_string(60 * i) + ",9000,40,60,24\n";
  const std::vector<std::string> limits = {"--largest-offset", "2"};
  std::vector<std::string> words = {"compensate", toy_model(), "--state", toy.file("state")};
  words.insert(words.end(), limits.begin(), limits.end());
  ASSERT_EQ(thermotwin(words, rows).status, 0);
  expect_refused({"--state", toy.file("state"), "--rewrite", "path", "--largest-offset", "2"},
                 {"part.ngc:2: an offset of ", "allowed: at most 2 um (--largest-offset)"});
  expect_refused({"--state", toy.file("state"), "--largest-offset", "3"}, {"with other options"});
}

}  // namespace
}  // namespace thermotwin::cases
