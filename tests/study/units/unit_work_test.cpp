// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/units/unit_work.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/file.h"
#include "tests/core/temporary_folder.h"

namespace thermotwin::study {
namespace {

namespace fs = std::filesystem;

class UnitWork : public ::testing::Test {
protected:
  /// Each unit writes its number; that of `failing` cannot be solved.
  Work compute_units(const std::string& part, std::size_t failing = 99) {
    return compute(folder_.path(), units_, part_of(part), [&](std::size_t unit, const fs::path& folder) -> UnitFiles {
      order_.push_back(unit);
      if (unit == failing) throw core::SolverError("no convergence");
      core::write_file(folder / checkpoint_file, "stopped");
      core::write_file(folder / "below/number", std::to_string(unit));
      return {"below/number"};
    });
  }

  core::TemporaryFolder folder_;
  const std::vector<Unit> units_{{"a0", "first"}, {"a1", "second"}, {"a2", "third"}};
  std::vector<std::size_t> order_;
};

TEST_F(UnitWork, PartsAreEveryNthUnitAndNoneIsComputedTwice) {
  EXPECT_EQ(compute_units("1/2").computed, 1U);
  EXPECT_EQ(order_, (std::vector<std::size_t>{1}));
  const Work all = compute_units("");
  EXPECT_EQ(all.computed, 2U);
  EXPECT_EQ(all.kept, 1U);
  EXPECT_EQ(order_, (std::vector<std::size_t>{1, 0, 2}));
  EXPECT_FALSE(fs::exists(unit_folder(folder_.path(), units_[0]) / checkpoint_file));
  // One whose file was changed is computed again.
  core::write_file(unit_folder(folder_.path(), units_[2]) / "below/number", "7");
  EXPECT_EQ(compute_units("").computed, 1U);
  EXPECT_EQ(order_.back(), 2U);
}

TEST_F(UnitWork, AFailedUnitIsNotedAndTheOthersGoOn) {
  const Work work = compute_units("", 1);
  EXPECT_EQ(work.computed, 2U);
  EXPECT_EQ(work.failed, (std::vector<std::string>{"second: no convergence"}));
  EXPECT_TRUE(work.unsolved);
  const Standing standing = standing_of(folder_.path(), units_);
  EXPECT_EQ(standing.done, (std::vector<std::size_t>{0, 2}));
  EXPECT_EQ(failed_words(units_, standing), work.failed);
  EXPECT_TRUE(standing.missing.empty());
  compute_units("");
  EXPECT_EQ(standing_of(folder_.path(), units_).done.size(), 3U);
  EXPECT_FALSE(fs::exists(unit_folder(folder_.path(), units_[1]) / "failed"));
}

TEST_F(UnitWork, MissingAndStaleUnitsAreNamed) {
  compute_units("0/3");
  const std::vector<Unit> others{units_[1], units_[2]};
  EXPECT_EQ(stale_units(folder_.path(), others), (std::vector<std::string>{"a0"}));
  EXPECT_EQ(missing_words(others, standing_of(folder_.path(), others)),
            (std::vector<std::string>{"unit a1: second", "unit a2: third"}));
}

TEST_F(UnitWork, PublishedFilesAreTheUnitsOwn) {
  compute_units("");
  const fs::path out = folder_.path() / "out";
  publish(folder_.path(), units_[2], out);
  EXPECT_EQ(core::read_file(out / "below/number"), "2");
  EXPECT_FALSE(fs::exists(out / "done"));
  EXPECT_FALSE(fs::exists(out / "below/lock"));
}

TEST(Part, IsAnIndexBelowACount) {
  for (const char* wrong : {"1", "2/2", "0/0", "0/2x", "a/b"}) EXPECT_THROW(part_of(wrong), core::UsageError) << wrong;
  EXPECT_EQ(part_of("1/3").index, 1U);
  EXPECT_EQ(part_of("").of, 1U);
}

}  // namespace
}  // namespace thermotwin::study
