// SPDX-License-Identifier: GPL-3.0-or-later
// A test on the twin from its plan to a cause: `measure plan`, `simulate`, `analyse`, `diagnose`.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <map>

#include "core/table.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A test of the toy's table under load. @param more  options in place of the usual ones
Result plan(const Toy& toy, const std::string& kind, const std::map<std::string, std::string>& more = {}) {
  std::map<std::string, std::string> options{
      {"--radius", "35"}, {"--height", "60"}, {"--clearance", "10"}, {"--warm-up", "0.75"}, {"--cool-down", "0.25"}};
  for (const auto& [name, value] : more) options[name] = value;
  std::vector<std::string> words{"measure", "plan", kind, "--case", toy.path(), "--out", toy.file("plan"), "--quiet"};
  for (const auto& [name, value] : options) words.insert(words.end(), {name, value});
  return thermotwin(words);
}

json simulate(const Toy& toy, std::vector<std::string> more, const std::string& out = "record") {
  std::vector<std::string> words{"measure", "simulate", toy.file("plan"), "--case",     toy.path(),
                                 "--json",  "--quiet",  "--out",          toy.file(out)};
  words.insert(words.end(), more.begin(), more.end());
  const Result result = thermotwin(words);
  EXPECT_EQ(result.status, 0) << result.err;
  return result.status == 0 ? json::parse(result.out) : json();
}

TEST(MeasureTwin, LocationErrorsAreThoseOfTheMachine) {
  const Toy toy;
  ASSERT_EQ(plan(toy, "rtest", {{"--azimuth", "0,180"}}).status, 0);
  const json result = simulate(toy, {"--machine-seed", "3", "--draws", "200"});
  const json& study = result["study"];
  EXPECT_LT(study["largest_difference"]["um"].get<double>(), 0.3);
  EXPECT_LT(study["largest_difference"]["um_per_m"].get<double>(), 1.0);
  EXPECT_GT(study["covered_percent"].get<double>(), 90.0);
  EXPECT_LT(study["covered_percent"].get<double>(), 98.0);
  // The raw signals, calibrated and evaluated, against the machine itself, up to noise and the tool's side.
  const Result analysed = toy.run({"measure", "analyse", toy.file("record"), "--json"});
  ASSERT_EQ(analysed.status, 0) << analysed.err;
  const json found = json::parse(analysed.out)["cycles"].back()["errors"];
  const core::Table own = core::read_csv(toy.file("record") + "/functionals.csv");
  const Eigen::VectorXd growth = own.column("R0T_um");
  const double grown = growth[growth.size() - 1] - growth[0], tool = study["largest_with_tool"]["um"].get<double>();
  EXPECT_GT(grown, 3.0);
  EXPECT_NEAR(found["R0T"]["value"].get<double>(), grown, 0.5 + tool);
}

TEST(MeasureTwin, AHiddenCauseIsNamed) {
  const Toy toy;
  ASSERT_EQ(plan(toy, "rtest", {{"--warm-up", "3"}, {"--cool-down", "2"}}).status, 0);
  simulate(toy, {"--hide", "source_power:C.drive:1.8", "--size", "0.8"});
  const Result analysed = toy.run({"measure", "analyse", toy.file("record"), "--record", toy.file("record") + "/loads",
                                   "--channels", "points", "--quiet"});
  ASSERT_EQ(analysed.status, 0) << analysed.err;
  const fs::path model = toy_run() / "model.rom.h5";
  const Result diagnosed = thermotwin({"diagnose", toy.path(), "--data", toy.result("measurement").string(), "--model",
                                       model.string(), "--out", toy.file("diagnosis"), "--json", "--quiet"});
  ASSERT_EQ(diagnosed.status, 0) << diagnosed.err;
  const json causes = json::parse(read(toy.file("diagnosis") + "/diagnosis/diagnosis.json"))["causes"];
  ASSERT_FALSE(causes.empty());
  EXPECT_EQ(causes[0]["kind"], "source_power");
  EXPECT_EQ(causes[0]["where"], "C.drive");
  // Location errors as channels would mislead: both verbs say so.
  const Result errors = toy.run({"measure", "analyse", toy.file("record"), "--record", toy.file("record") + "/loads"});
  ASSERT_EQ(errors.status, 0) << errors.err;
  EXPECT_SAYS(errors.out, "needs --channels points");
  const Result evaluated =
      thermotwin({"evaluate", toy.path(), "--data", toy.result("measurement").string(), "--model", model.string(),
                  "--models", "static_regression", "--out", toy.file("evaluated")});
  EXPECT_EQ(evaluated.status, 0) << evaluated.err;
  EXPECT_SAYS(evaluated.err, "may then name a wrong cause");
}

TEST(MeasureTwin, ThermalTestsBecomeTables) {
  const Toy toy;
  ASSERT_EQ(plan(toy, "spindle", {{"--speed", "9000"}}).status, 0);
  simulate(toy, {"--no-noise"});
  const Result analysed = toy.run({"measure", "analyse", toy.file("record"), "--json"});
  ASSERT_EQ(analysed.status, 0) << analysed.err;
  const json rows = json::parse(analysed.out)["rows"];
  ASSERT_EQ(rows.size(), 6u);
  EXPECT_EQ(rows[2]["channel"], "dz@1");
  EXPECT_GT(rows[2]["range"].get<double>(), 3.0);
  EXPECT_EQ(rows[2]["count"], 13);
}

TEST(MeasureTwin, SlipsAreRefused) {
  const Toy toy;
  const Result low = plan(toy, "rtest", {{"--height", "5"}});
  EXPECT_EQ(low.status, 3);
  EXPECT_SAYS(low.err, "axis Z");
  EXPECT_FALSE(fs::exists(toy.file("plan")));
  EXPECT_EQ(plan(toy, "rtset").status, 3);
  ASSERT_EQ(plan(toy, "rtest").status, 0);
  EXPECT_EQ(
      thermotwin({"measure", "simulate", toy.file("plan"), "--case", toy.path(), "--hide", "source_power"}).status, 2);
  const Result nowhere = thermotwin({"measure", "simulate", toy.file("plan"), "--case", toy.path(), "--hide",
                                     "source_power:D.drive:2", "--out", toy.file("record")});
  EXPECT_EQ(nowhere.status, 3);
  EXPECT_SAYS(nowhere.err, "D.drive");
  EXPECT_FALSE(fs::exists(toy.file("record")));
}

}  // namespace
}  // namespace thermotwin::cases
