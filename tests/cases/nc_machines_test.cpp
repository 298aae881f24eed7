// SPDX-License-Identifier: GPL-3.0-or-later
// tools/nc_machines: what `nc` predicts along a program, beside the toy machine measured virtually.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>

#include "core/table.h"
#include "tests/cases/nc_programs.h"
#include "tests/cases/texts.h"
#include "tests/cases/toy.h"
#include "tests/core/temporary_folder.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class NcMachines : public testing::Test {
protected:
  void SetUp() override {
    if (!has_interpreter()) GTEST_SKIP() << "the program was built without LinuxCNC's interpreter";
    toy.write("part.ngc",
              "G21 G90\nM3 S9000\nG0 X0 Y0 Z50\no1 repeat [20]\nG1 X100 F20000\nX-100\no1 endrepeat\nG4 P200\n"
              "G1 X60 Y20 Z60 F8000\nB30\nM2\n");
  }
  /// Exit status and both outputs.
  std::pair<int, std::string> run(const std::string& arguments) const {
    const fs::path log = folder / "log.txt";
    const std::string command =
        fmt::format("THERMOTWIN_BUILD='{}' python3 '{}' '{}' '{}' --model '{}' --out '{}' --json '{}' {} > '{}' 2>&1",
                    fs::path(THERMOTWIN_PROGRAM).parent_path().string(), (source_tree() / "tools/nc_machines").string(),
                    toy.path(), toy.file("part.ngc"), toy_model(), (folder / "out").string(),
                    (folder / "figures.json").string(), arguments, log.string());
    const int status = std::system(command.c_str());
    return {WEXITSTATUS(status), read(log)};
  }
  core::Table blocks(const std::string& variant) const {
    return core::read_csv(folder / "out/part" / variant / "blocks.csv");
  }
  Toy toy;
  core::TemporaryFolder folder;
};

TEST_F(NcMachines, TheKnownStartRemovesMostAndAWrongOneLess) {
  const auto [status, said] = run("--parts 6 --pause 60 --draws 2 --points 6 --row-s 120 --perturb thermal");
  ASSERT_TRUE(fs::exists(folder / "figures.json")) << said;
  const json part = json::parse(read(folder / "figures.json"))["part"];
  EXPECT_EQ(part["parts"], 6);
  for (const char* seed : {"1", "2"}) {
    const json machine = part["machines"][seed];
    EXPECT_GT(machine["known"]["before_um"], 5.0) << "the program heats too little to show anything";
    EXPECT_GT(machine["known"]["removed_percent"], 60.0) << said;
    const auto removed = [&](const char* variant) { return machine[variant]["removed_percent"].get<double>(); };
    EXPECT_LT(removed("unknown"), removed("known"));
    EXPECT_LT(machine["known"]["std_um"], 0.5 * machine["unknown"]["std_um"].get<double>()) << "of a rested machine";
    EXPECT_LT(machine["known"]["left_um"], 2.0 * machine["known"]["std_um"].get<double>()) << said;
    // A machine that is warmer than the nominal one is nearer to the longer program, a cooler one to the shorter.
    EXPECT_LT(0.5 * (removed("longer") + removed("shorter")), removed("known"));
    EXPECT_NE(removed("longer"), removed("shorter"));
  }
  EXPECT_NE(part["machines"]["1"]["known"]["before_um"], part["machines"]["2"]["known"]["before_um"]);
  EXPECT_EQ(status, part["median"]["known"] >= 85.0 && part["10th percentile"]["known"] >= 75.0 ? 0 : 1);
  for (const char* words : {"start unknown %", "10th percentile", "6 parts of ", "part: "}) EXPECT_SAYS(said, words);
}

}  // namespace
}  // namespace thermotwin::cases
