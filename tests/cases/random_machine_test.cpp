// SPDX-License-Identifier: GPL-3.0-or-later
// tools/random_machine: a case that the program accepts as it stands, the same bytes for the same seed.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstdlib>

#include "tests/cases/texts.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;

/// Runs the script. @return 0 where it succeeded
int make_case(const std::string& seed, const fs::path& folder) {
  const std::string script = (source_tree() / "tools/random_machine").string();
  return std::system(("python3 '" + script + "' " + seed + " '" + folder.string() + "' 2>/dev/null").c_str());
}

class RandomMachine : public testing::Test {
protected:
  void SetUp() override {
    if (std::system("command -v python3 > /dev/null 2>&1") != 0) GTEST_SKIP() << "no python3";
  }
  core::TemporaryFolder folder_;
};

TEST_F(RandomMachine, IsMeshedAndEveryJointTouches) {
  for (const std::string seed : {"8", "14"}) {
    ASSERT_EQ(make_case(seed, folder_ / seed), 0) << seed;
    const Result mesh =
        thermotwin({"mesh", (folder_ / seed).string(), "--out", (folder_ / "out").string(), "--quiet", "--json"});
    ASSERT_EQ(mesh.status, 0) << seed << ": " << mesh.err;
    EXPECT_EQ(mesh.err, "") << seed;
    for (const auto& joint : nlohmann::json::parse(mesh.out)["joints"])
      EXPECT_GT(joint["contact_area_m2"].get<double>(), 0.0) << seed << " " << joint["id"];
  }
}

TEST_F(RandomMachine, SameSeedHasTheSameBytes) {
  for (const char* name : {"once", "again"}) ASSERT_EQ(make_case("3", folder_ / name), 0);
  ASSERT_EQ(make_case("4", folder_ / "other"), 0);
  const auto once = files_in(folder_ / "once");
  EXPECT_TRUE(once.contains("machine.toml") && once.contains("case.toml") && once.contains("loads/day.toml"));
  EXPECT_EQ(once, files_in(folder_ / "again"));
  EXPECT_NE(once.at("machine.toml"), files_in(folder_ / "other").at("machine.toml"));
}

TEST_F(RandomMachine, LeavesAFolderWithFilesAlone) {
  ASSERT_EQ(make_case("3", folder_ / "case"), 0);
  const auto before = files_in(folder_ / "case");
  EXPECT_NE(make_case("4", folder_ / "case"), 0);
  EXPECT_EQ(before, files_in(folder_ / "case"));
}

}  // namespace
}  // namespace thermotwin::cases
