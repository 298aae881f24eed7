// SPDX-License-Identifier: GPL-3.0-or-later
// `export --calculix`: whole decks that CalculiX takes, what they leave out is said, bad input leaves
// earlier decks alone.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstdlib>

#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

TEST(Export, CalculiXRunsTheDecksOfAMachine) {
  const Toy toy;
  const Result result = toy.run({"export", toy.path(), "--calculix", "--load", "warm_up", "--time-step", "1800",
                                 "--pose", "X=20,B=30", "--json", "--quiet"});
  ASSERT_EQ(result.status, 0) << result.err;
  const auto said = nlohmann::json::parse(result.out);
  EXPECT_EQ(said["files"], nlohmann::json({"mesh.inp", "heat_only.inp", "static.inp", "heat.inp"}));
  EXPECT_EQ(said["end_s"], 10800.0);
  const std::string heat = read(toy.result("calculix/heat.inp"));
  for (const char* words : {"coolant main", "axes of the program move"}) {
    EXPECT_SAYS(said["notes"].dump(), words);
    EXPECT_SAYS(heat, words);
  }
  if (std::system("command -v ccx > /dev/null 2>&1") != 0) GTEST_SKIP() << "CalculiX (ccx) is not installed";
  const std::string in_folder = "cd '" + toy.result("calculix").string() + "' && OMP_NUM_THREADS=1 ccx ";
  for (const char* job : {"heat", "static"}) {
    EXPECT_EQ(std::system((in_folder + job + " > " + job + ".log 2>&1").c_str()), 0) << job;
    const std::string log = read(toy.result("calculix") / (std::string(job) + ".log"));
    EXPECT_SAYS(log, "Job finished");
    EXPECT_EQ(log.find("*ERROR"), std::string::npos) << log.substr(log.find("*ERROR"), 300);
    EXPECT_EQ(log.find("nan"), std::string::npos);
  }
}

TEST(Export, OneBodyIsADeckOfItsOwn) {
  const Toy toy;
  const Result result =
      toy.run({"export", toy.file("machine.toml"), "--calculix", "--body", "column", "--mesh-order", "2"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_SAYS(result.out, "C3D10");
  EXPECT_SAYS(result.out, "held at three nodes");
  EXPECT_EQ(read(toy.result("calculix/mesh.inp")).find("BODY_BED"), std::string::npos);
}

TEST(Export, BadInputLeavesTheDeckAsItWas) {
  const Toy toy;
  ASSERT_EQ(toy.run({"export", toy.path(), "--calculix", "--body", "column"}).status, 0);
  const auto before = files_in(toy.out());
  const Result body = toy.run({"export", toy.path(), "--calculix", "--body", "colum"});
  EXPECT_EQ(body.status, 3);
  EXPECT_SAYS(body.err, "nearest: column");
  const Result late = toy.run({"export", toy.path(), "--calculix", "--load", "warm_up", "--steady-at", "1e6"});
  EXPECT_EQ(late.status, 3);
  EXPECT_SAYS(late.err, "10800");
  EXPECT_EQ(changes(before, files_in(toy.out())), std::vector<std::string>());
}

}  // namespace
}  // namespace thermotwin::cases
