// SPDX-License-Identifier: GPL-3.0-or-later
// A test on the twin from its plan to a cause: `measure plan`, `simulate`, `analyse`, `diagnose`.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <map>

#include "core/file.h"
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

/// `measure analyse` of a record of the toy, then `diagnose`. @param channels  "errors" or "points"
json diagnosed(const Toy& toy, const std::string& record, const std::string& channels, std::string* said = nullptr) {
  const std::string folder = toy.file(record);
  const Result analysed =
      toy.run({"measure", "analyse", folder, "--record", folder + "/loads", "--channels", channels, "--quiet"});
  EXPECT_EQ(analysed.status, 0) << analysed.err;
  const Result found = thermotwin({"diagnose", toy.path(), "--data", toy.result("measurement").string(), "--model",
                                   toy_model(), "--out", toy.file("diagnosis"), "--json", "--quiet"});
  EXPECT_EQ(found.status, 0) << found.err;
  if (said != nullptr) *said = found.err;
  return json::parse(found.out);
}

// From the plan to the cause, on a finer mesh with noise: by the deviations at the points, and by the location errors
// that they give. Without a hidden effect there is no cause.
TEST(MeasureTwin, AHiddenCauseIsNamed) {
  const Toy toy;
  ASSERT_EQ(plan(toy, "rtest", {{"--warm-up", "3"}, {"--cool-down", "2"}}).status, 0);
  simulate(toy, {"--hide", "source_power:C.drive:1.8", "--size", "0.8"});
  for (const char* channels : {"points", "errors"}) {
    std::string said;
    const json causes = diagnosed(toy, "record", channels, &said)["causes"];
    ASSERT_EQ(causes.size(), 1U) << channels;
    EXPECT_EQ(causes[0]["kind"], "source_power") << channels;
    EXPECT_EQ(causes[0]["where"], "C.drive") << channels;
    EXPECT_EQ(said.find("wrong cause"), std::string::npos) << said;
  }
  // Of what is not there, nothing is named.
  simulate(toy, {"--machine-seed", "4", "--size", "0.8"}, "clean");
  EXPECT_TRUE(diagnosed(toy, "clean", "errors")["causes"].empty());
  // The reduced model predicts the errors as they were evaluated.
  const Result evaluated = thermotwin({"evaluate", toy.path(), "--data", toy.result("measurement").string(), "--model",
                                       toy_model(), "--models", "static_regression", "--out", toy.file("evaluated")});
  EXPECT_EQ(evaluated.status, 0) << evaluated.err;
  EXPECT_EQ(evaluated.err.find("wrong cause"), std::string::npos);
  // Without the points location errors would mislead: the program says so.
  const std::string channels = toy.result("measurement").string() + "/channels.toml";
  std::string text = read(channels), without;
  for (std::size_t start = 0; start < text.size();) {
    const std::size_t end = std::min(text.find('\n', start), text.size());
    const std::string line = text.substr(start, end - start);
    if (!line.starts_with("arrangement =") && !line.starts_with("weights =")) without += line + "\n";
    start = end + 1;
  }
  core::write_file(channels, without);
  const Result warned = thermotwin({"evaluate", toy.path(), "--data", toy.result("measurement").string(), "--model",
                                    toy_model(), "--models", "static_regression", "--out", toy.file("evaluated")});
  EXPECT_EQ(warned.status, 0) << warned.err;
  EXPECT_SAYS(warned.err, "may name a wrong cause");
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

TEST(MeasureTwin, CommonOptionsStandBeforeOrAfterTheSecondWord) {
  const Toy toy;
  const std::vector<std::string> rest{"plan",      "spindle", "--case",      toy.path(),
                                      "--warm-up", "0.5",     "--cool-down", "0.5"};
  std::vector<std::string> words{"measure", "--out", toy.file("before"), "--quiet"};
  words.insert(words.end(), rest.begin(), rest.end());
  ASSERT_EQ(thermotwin(words).status, 0);
  EXPECT_TRUE(fs::exists(toy.file("before/program.nc")));
  words.insert(words.end(), {"--out", toy.file("after")});
  ASSERT_EQ(thermotwin(words).status, 0);
  EXPECT_TRUE(core::read_file(toy.file("after/program.nc")) == core::read_file(toy.file("before/program.nc")));
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
