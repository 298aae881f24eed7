// SPDX-License-Identifier: GPL-3.0-or-later
// `reduce --from-campaign`: a model from tables alone; what `reduce` says beside its model.
#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/table.h"
#include "reduction/systems/system_file.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

TEST(FromCampaign, TablesSufficeAndTheModelSaysWhatItsNumbersAre) {
  const Toy toy;
  // No mesh, no snapshots: CAD files and everything but the tables are gone.
  for (const std::string load : {"ambient", "warm_up", "mixed"}) {
    for (const std::string table : {"inputs.csv", "sensors.csv", "tcp.csv"}) {
      fs::create_directories(toy.file("tables/" + load));
      fs::copy(toy_run() / "campaign" / load / table, toy.file("tables/" + load + "/" + table));
    }
  }
  const Result result = toy.run({"reduce", toy.path(), "--from-campaign", toy.file("tables"), "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_FALSE(fs::exists(toy.result("cache")));
  const json summary = json::parse(result.out);
  EXPECT_TRUE(summary["stable"]);
  ASSERT_EQ(summary["heldout"].size(), 1U);
  EXPECT_LT(summary["heldout"][0]["rms_um"].get<double>(), 0.5 * summary["heldout"][0]["peak_um"].get<double>());
  std::vector<std::string> films;
  const reduction::ReducedLinearSystem system = reduction::read_system(toy.result("system.rom.h5"), &films);
  EXPECT_EQ(system.order(), summary["order"].get<Eigen::Index>());
  EXPECT_EQ(system.C.rows(), 27 * 6 + 4);
  EXPECT_EQ(system.B.cols(), summary["inputs"].get<Eigen::Index>());
  EXPECT_TRUE(films.empty());
  EXPECT_LT(system.A.eigenvalues().real().maxCoeff(), 0.0);
  for (const char* name : {"A.mtx", "B.mtx", "C.mtx", "E.mtx", "order.svg"})
    EXPECT_TRUE(fs::exists(toy.result(name))) << name;

  const Result fixed = toy.run({"reduce", toy.path(), "--from-campaign", toy.file("tables"), "--order", "4", "--json"});
  EXPECT_EQ(json::parse(fixed.out)["order"], 4);
}

TEST(FromCampaign, WhatIsMissingOrDoesNotFitIsNamed) {
  const Toy toy;
  const Result none = toy.run({"reduce", toy.path(), "--from-campaign"});
  EXPECT_EQ(none.status, 3);
  EXPECT_SAYS(none.err, "campaign/ambient/inputs.csv: no such file");
  for (const char* option : {"--bound", "--resume", "--compare"})
    EXPECT_EQ(toy.run({"reduce", toy.path(), "--from-campaign", "x", option}).status, 2) << option;
  EXPECT_EQ(toy.run({"reduce", "--from-campaign", "x"}).status, 2);
  EXPECT_EQ(toy.run({"reduce", toy.path(), "--order", "many"}).status, 2);
  EXPECT_EQ(toy.run({"reduce", toy.path(), "--from-campaign", "x", "--order", "observer"}).status, 2);
}

// Of quadratic tetrahedra of this size the mesh alone makes 0.25 % of the motion in x, the pads of joints 1.5 %.
TEST(Reduce, CountsThePadsOfJointsToTheMeshError) {
  const Toy toy;
  const Result result = toy.run({"reduce", toy.path(), "--size", "2", "--mesh-order", "2", "--order", "10", "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const json error = json::parse(result.out)["mesh_error"];
  EXPECT_TRUE(error["second"].get<std::string>().ends_with(", finer joints")) << error;
  EXPECT_GT(error["tcp"][0].get<double>(), 0.01);
  EXPECT_LT(error["tcp"][0].get<double>(), 0.03);
}

TEST(Reduce, TellsErrorsBetweenStoredPosesItsTimeAndTheObserver) {
  const Toy toy;
  toy.take_results();
  const Result result = toy.run({"reduce", toy.path(), "--resume", "--order", "observer", "--compare", "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const json summary = json::parse(result.out);
  const json& last = summary["orders"].back();
  EXPECT_EQ(last["order"], summary["order"]);
  EXPECT_LE(last["error_um"].get<double>(), last["observer_um"].get<double>());
  EXPECT_EQ(summary["order_of_observer"], summary["order"]);
  for (const json& order : summary["orders"]) {
    EXPECT_GT(order["observer_um"].get<double>(), 0.0);
    if (order["order"] != summary["order"]) {
      EXPECT_GT(order["error_um"].get<double>(), order["observer_um"].get<double>());
    }
  }
  const json& building = summary["building"];
  EXPECT_GT(building["transient_s"].get<double>(), 0.0);
  EXPECT_NEAR(building["ratio"].get<double>(), building["all_s"].get<double>() / building["transient_s"].get<double>(),
              1e-9);
  ASSERT_EQ(summary["off_grid"].size(), 1U);
  const json& between = summary["off_grid"][0];
  EXPECT_GT(between["peak_um"].get<double>(), 10.0);
  EXPECT_GT(between["max_um"].get<double>(), 0.0);
  EXPECT_LT(between["max_um"].get<double>(), 0.2 * between["peak_um"].get<double>());
  EXPECT_LT(between["own_rows_max_um"].get<double>(), 1.5 * summary["heldout"][0]["max_um"].get<double>())
      << "with rows of their own, these poses are as the stored ones";
  const std::string table = read(toy.result("off_grid.csv"));
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 1 + 12);
  EXPECT_SAYS(table, "load,X_mm,Y_mm,Z_mm,B_deg,C_deg,peak_um,max_um,rms_um,own_rows_max_um\nmixed,");
  // The sensors of both runs, compared here once more.
  const Result again = toy.run({"campaign", toy.path(), "--reduced", "--load", "mixed", "--quiet"});
  ASSERT_EQ(again.status, 0) << again.err;
  const core::Table full = core::read_csv(toy.result("campaign/mixed/sensors.csv"));
  const core::Table reduced = core::read_csv(toy.result("campaign_reduced/mixed/sensors.csv"));
  ASSERT_EQ(summary["sensors"].size(), 4U);
  for (const json& sensor : summary["sensors"]) {
    const std::string column = sensor["sensor"].get<std::string>() + "_C";
    const Eigen::VectorXd off = reduced.column(column) - full.column(column);
    EXPECT_EQ(sensor["load"], "mixed");
    EXPECT_NEAR(sensor["max_K"].get<double>(), off.cwiseAbs().maxCoeff(), 2e-4) << column;
    EXPECT_NEAR(sensor["rms_K"].get<double>(), std::sqrt(off.squaredNorm() / off.size()), 2e-4) << column;
    EXPECT_GT(sensor["range_K"].get<double>(), sensor["max_K"].get<double>()) << column;
  }
  bool identified = false;
  for (const json& row : summary["comparison"]) identified = identified || row["method"] == "identified";
  EXPECT_TRUE(identified);
  EXPECT_SAYS(read(toy.result("order.svg")), "identified");
}

}  // namespace
}  // namespace thermotwin::cases
