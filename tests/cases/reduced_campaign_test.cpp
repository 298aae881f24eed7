// SPDX-License-Identifier: GPL-3.0-or-later
// `campaign --reduced`: the full campaign's files from the reduced model, with an estimate of the error.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/table.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

double largest(const Eigen::VectorXd& values) { return values.cwiseAbs().maxCoeff(); }

TEST(ReducedCampaign, LeavesTheFilesOfTheFullOneAndEstimatesTheirError) {
  const Toy toy;
  const Result result = toy.run({"campaign", toy.path(), "--reduced", "--model", toy_model(), "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const json summary = json::parse(result.out);
  EXPECT_EQ(summary["loads"].size(), 3U);
  EXPECT_GT(summary["reference_order"].get<int>(), summary["order"].get<int>());
  for (const std::string load : {"ambient", "warm_up", "mixed"}) {
    const fs::path reduced = toy.result("campaign_reduced/" + load), full = toy_run() / "campaign" / load;
    const core::Table ours = core::read_csv(reduced / "tcp.csv"), theirs = core::read_csv(full / "tcp.csv");
    const core::Table estimate = core::read_csv(reduced / "error_estimate.csv");
    ASSERT_EQ(ours.columns, theirs.columns);
    ASSERT_EQ(ours.rows(), theirs.rows());
    ASSERT_EQ(estimate.rows(), ours.rows());
    EXPECT_EQ(core::read_csv(reduced / "sensors.csv").columns, core::read_csv(full / "sensors.csv").columns);
    EXPECT_EQ(core::read_csv(reduced / "inputs.csv").columns, core::read_csv(full / "inputs.csv").columns);
    for (const std::string axis : {"dx_um", "dy_um", "dz_um"}) {
      const Eigen::VectorXd error = theirs.column(axis) - ours.column(axis);
      EXPECT_LT(largest(error), 0.02 * largest(theirs.column("dz_um"))) << load << " " << axis;
      // With the estimate added, what is left is what the reference misses too.
      if (largest(error) > 0.05) {
        EXPECT_LT(largest(error - estimate.column(axis)), 0.7 * largest(error)) << load << " " << axis;
      }
    }
  }
}

TEST(ReducedCampaign, IsNeverTakenForTheFullOne) {
  const Toy toy;
  toy.take_results();
  const auto before = files_in(toy.result("campaign"));
  const Result run = toy.run({"campaign", toy.path(), "--reduced"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(files_in(toy.result("campaign")), before);
  const Result identified = toy.run({"reduce", toy.path(), "--from-campaign", toy.result("campaign_reduced").string()});
  EXPECT_EQ(identified.status, 3);
  EXPECT_SAYS(identified.err, "made by the reduced model of order");

  // Tables of another make in the full campaign's place, as an earlier version left them: they are run anew.
  const std::string full = read(toy.result("campaign/mixed/tcp.csv"));
  fs::copy_file(toy.result("campaign_reduced/mixed/tcp.csv"), toy.result("campaign/mixed/tcp.csv"),
                fs::copy_options::overwrite_existing);
  const Result resumed = toy.run({"campaign", toy.path(), "--resume"});
  ASSERT_EQ(resumed.status, 0) << resumed.err;
  EXPECT_EQ(read(toy.result("campaign/mixed/tcp.csv")), full);
}

TEST(ReducedCampaign, HasTheGridAtAllTiltsOrThePosesAskedFor) {
  const Toy toy;
  const std::vector<std::string> words{"campaign",  toy.path(), "--reduced", "--model",
                                       toy_model(), "--load",   "warm_up"};
  const auto table = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all = words;
    all.insert(all.end(), more.begin(), more.end());
    const Result result = toy.run(all);
    EXPECT_EQ(result.status, 0) << result.err;
    return core::read_csv(toy.result("campaign_reduced/warm_up/tcp.csv"));
  };
  const core::Table grid = table({}), tilts = table({"--all-tilts"});
  const Eigen::Index times = grid.rows() / 27;
  ASSERT_EQ(tilts.rows(), 3 * 27 * times);
  // The tilts of machine.toml; at the first of them the table is that of the grid.
  for (const double tilt : {0.0, 45.0, 90.0})
    EXPECT_EQ((tilts.column("B_deg").array() == tilt).count(), 27 * times) << tilt;
  for (Eigen::Index i = 0; i < times; ++i) {
    EXPECT_LT(largest((tilts.values.middleRows(81 * i, 27) - grid.values.middleRows(27 * i, 27)).reshaped()), 1e-6)
        << i;
  }
  const core::Table two = table({"--pose", "X=0,Y=40,Z=50,B=45", "--pose", "X=33,B=90"});
  ASSERT_EQ(two.rows(), 2 * times);
  EXPECT_EQ(two.column("X_mm")[1], 33.0);
  for (Eigen::Index row = 0; row < 81; ++row) {
    if (tilts.column("X_mm")[row] != 0.0 || tilts.column("Y_mm")[row] != 40.0 || tilts.column("Z_mm")[row] != 50.0 ||
        tilts.column("B_deg")[row] != 45.0)
      continue;
    EXPECT_LT(largest((two.values.row(2 * (times - 1)) - tilts.values.row(81 * (times - 1) + row)).transpose()), 1e-6);
  }
  std::vector<std::string> both = words;
  both.insert(both.end(), {"--pose", "X=0", "--all-tilts"});
  EXPECT_EQ(toy.run(both).status, 2);
  EXPECT_EQ(toy.run({"campaign", toy.path(), "--all-tilts"}).status, 2);
  const Result outside = toy.run({"campaign", toy.path(), "--reduced", "--model", toy_model(), "--pose", "Q=1"});
  EXPECT_EQ(outside.status, 3);
  EXPECT_SAYS(outside.err, "Q");
}

TEST(ReducedCampaign, WhatDoesNotFitIsRefused) {
  const Toy toy;
  for (const std::vector<std::string>& option :
       {std::vector<std::string>{"--resume"}, {"--size", "0.5"}, {"--solver", "direct"}, {"--order", "2"}}) {
    std::vector<std::string> words{"campaign", toy.path(), "--reduced", "--model", toy_model()};
    words.insert(words.end(), option.begin(), option.end());
    EXPECT_EQ(toy.run(words).status, 2) << option.front();
  }
  EXPECT_EQ(toy.run({"campaign", toy.path(), "--exact"}).status, 2);
  const Result missing = toy.run({"campaign", toy.path(), "--reduced", "--model", toy.file("none.h5")});
  EXPECT_EQ(missing.status, 3);
  EXPECT_SAYS(missing.err, "none.h5: no such file");
  const Result same =
      toy.run({"campaign", toy.path(), "--reduced", "--model", toy_model(), "--reference", toy_model()});
  EXPECT_EQ(same.status, 3);
  EXPECT_SAYS(same.err, "a larger order of the same machine");
  EXPECT_FALSE(fs::exists(toy.result("campaign_reduced/warm_up")));
}

TEST(ReducedCampaign, AMachineWithOtherTermsIsRefused) {
  const Toy toy;
  const std::string machine = read(toy.file("machine.toml"));
  const std::size_t film = machine.find("[[film]]"), next = machine.find("[[", film + 2);
  ASSERT_NE(next, std::string::npos);
  toy.edit("machine.toml", machine.substr(film, next - film), "");
  const Result result = toy.run({"campaign", toy.path(), "--reduced", "--model", toy_model()});
  EXPECT_EQ(result.status, 3) << result.err;
  EXPECT_SAYS(result.err, "other films, joints, sources");
}

}  // namespace
}  // namespace thermotwin::cases
