// SPDX-License-Identifier: GPL-3.0-or-later
// `study sensors` as a user meets it, on the toy: a choice no worse than the case's sensors, confirmed on machines
// measured virtually, and slips.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

#include "core/table.h"
#include "tests/cases/program.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// The case's own sizes make the same mesh at 0.8 of them; a bed of smaller elements does not.
TEST(StudySensors, RegardsTheErrorOfASmallerMeshToo) {
  const Toy toy;
  toy.edit("machine.toml", "element_size_mm = 160", "element_size_mm = 70");
  std::vector<std::string> words{"study",   "sensors", toy.path(),    "--spacing", "300",
                                 "--count", "1",       "--exchanges", "0",         "--every",
                                 "60",      "--load",  "warm_up",     "--json",    "--quiet"};
  const Result made = toy.run(words);
  ASSERT_EQ(made.status, 0) << made.err;
  const json summary = json::parse(made.out);
  const std::string meshes = summary["second_mesh"];
  EXPECT_SAYS(meshes, "quadratic tetrahedra, ");
  EXPECT_SAYS(meshes, " nodes and linear tetrahedra, ");
  EXPECT_EQ(made.err.find("the mesh error is that of one other mesh"), std::string::npos) << made.err;
  words.insert(words.end(), {"--size", "1.5"});
  const Result larger = toy.run(words);
  ASSERT_EQ(larger.status, 0) << larger.err;
  EXPECT_NE(json::parse(larger.out)["second_mesh"], meshes);
  EXPECT_SAYS(read(toy.result("study/sensors/report.html")), "--size 1.5 --count 1");
}

TEST(StudySensors, ChoosesNoWorseThanTheCaseAndConfirmsIt) {
  const Toy toy;
  toy.take_results();
  const Result made = toy.run(
      {"study", "sensors", toy.path(), "--spacing", "80", "--every", "21", "--json", "--quiet", "--confirm", "1"});
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_SAYS(made.err, "--every 21: 'mixed' has a row every 4 min, so the filter corrects every 20 min");
  EXPECT_SAYS(made.err, "the mesh error is that of one other mesh: element_size_mm has no influence on its bodies");
  const json summary = json::parse(made.out);
  EXPECT_EQ(summary["chosen"]["sensors"], summary["own"]["sensors"]);
  EXPECT_LT(summary["chosen"]["left_um"].get<double>(), summary["own"]["left_um"].get<double>());
  EXPECT_LT(summary["own"]["left_um"].get<double>(), summary["without_um"].get<double>());
  EXPECT_GE(summary["chosen"]["after_loss_um"].get<double>(), summary["chosen"]["left_um"].get<double>());
  const json confirmed = summary["confirmed"];
  const double chosen = confirmed["chosen_um"][0], of_case = confirmed["own_um"][0];
  EXPECT_GT(chosen, 0.0);
  // One measurement of a machine serves both: it has the case's sensors and the chosen ones.
  const std::string channels = read(toy.result("study/sensors/measured/mixed/machine_1/channels.toml"));
  for (const std::string sensor : {"\"T1\"", "\"chosen_S1\""}) EXPECT_SAYS(channels, "sensor = " + sensor);
  // The toy's mesh does not follow element_size_mm: the machines have no mesh error.
  EXPECT_EQ(confirmed["own_mesh"], true);
  double squares = 0.0;
  for (const json& load : confirmed["loads"]) {
    squares += std::pow(load["chosen_um"].get<double>(), 2);
    EXPECT_GT(load["without_um"], 0.0);
  }
  ASSERT_GT(confirmed["loads"].size(), 0U);
  EXPECT_NEAR(chosen, std::sqrt(squares / confirmed["loads"].size()), 1e-3 * chosen);
  const double predicted = confirmed["predicted_chosen_um"], predicted_of_case = confirmed["predicted_own_um"];
  EXPECT_LT(predicted, 0.5 * summary["chosen"]["left_um"].get<double>());
  EXPECT_EQ(confirmed["borne_out"], (chosen < of_case) == (predicted < predicted_of_case));
  EXPECT_NEAR(confirmed["change_percent"], 100.0 * (chosen / of_case - 1.0), 1e-9);
  EXPECT_SAYS(read(toy.result("study/sensors/report.html")), confirmed["borne_out"].get<bool>()
                                                                 ? "machines bear out the prediction"
                                                                 : "do not bear out that the choice is better");
  EXPECT_FALSE(summary["second_mesh"].get<std::string>().empty());
  EXPECT_SAYS(read(toy.result("study/sensors/report.html")), "The mesh error (against quadratic tetrahedra");
  EXPECT_GT(summary["chosen"]["mesh_um"].get<double>(), 0.0);
  EXPECT_GT(summary["own"]["mesh_um"].get<double>(), 0.0);
  const core::Table curve = core::read_csv(toy.result("study/sensors/curve.csv"));
  ASSERT_EQ(curve.rows(), summary["chosen"]["sensors"].get<int>());
  for (Eigen::Index k = 1; k < curve.rows(); ++k) EXPECT_LE(curve.values(k, 1), curve.values(k - 1, 1) * (1 + 1e-9));
  EXPECT_TRUE(fs::exists(toy.result("study/sensors/report.html")));
  // No sensor sits on a table that turns without end, nor where a rule forbids it.
  EXPECT_EQ(read(toy.result("study/sensors/sensors.toml")).find("body = \"table\""), std::string::npos);
  // They take the place of those of machine.toml, with the one that a chiller follows.
  const std::string tables = read(toy.result("study/sensors/sensors.toml"));
  EXPECT_SAYS(tables, "[[sensor]]\nid = \"T3\"\nbody = \"bed\"\npoint_mm = [200, 0, -300]\n");
  std::string machine = read(toy.file("machine.toml"));
  for (std::size_t at = machine.find("[[sensor]]"); at != std::string::npos; at = machine.find("[[sensor]]"))
    machine.erase(at, machine.find("\n[", at + 1) + 1 - at);
  toy.write("machine.toml", machine + tables);
  // As the case's own they leave what was said of them, and less by the chiller's.
  const Result again =
      toy.run({"study", "sensors", toy.path(), "--spacing", "120", "--count", "2", "--json", "--quiet"});
  ASSERT_EQ(again.status, 0) << again.err;
  const json own = json::parse(again.out)["own"];
  EXPECT_EQ(own["sensors"], summary["chosen"]["sensors"].get<int>() + 1);
  EXPECT_LT(own["left_um"].get<double>(), 1.02 * summary["chosen"]["left_um"].get<double>());
  EXPECT_GT(own["left_um"].get<double>(), 0.8 * summary["chosen"]["left_um"].get<double>());
  const Result wrong = toy.run({"study", "sensors", toy.path(), "--without", "swivell", "--quiet"});
  EXPECT_EQ(wrong.status, 3);
  EXPECT_SAYS(wrong.err, "nearest: swivel");
}

TEST(StudySensors, AskForCheckPointsBeforeTheWork) {
  const Toy toy;
  const std::string words = read(toy.file("case.toml"));
  const auto at = words.find("[check_points]");
  ASSERT_NE(at, std::string::npos);
  toy.write("case.toml", words.substr(0, at) + words.substr(std::min(words.size(), words.find("\n[", at + 1))));
  const Result refused = toy.run({"study", "sensors", toy.path(), "--confirm", "2", "--quiet"});
  EXPECT_EQ(refused.status, 3);
  EXPECT_SAYS(refused.err, "case.toml: no check points, which --confirm compares at");
  EXPECT_FALSE(fs::exists(toy.result("campaign")));
}

}  // namespace
}  // namespace thermotwin::cases
