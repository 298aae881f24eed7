// SPDX-License-Identifier: GPL-3.0-or-later
// `validate`: what the measured machines are made by, and truths side by side.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>

#include "core/table.h"
#include "solver/campaign/case.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

using nlohmann::json;

std::string made(const char* file) { return (toy_run() / file).string(); }

/// Largest difference of the columns whose names begin so, over the largest value.
double apart(const core::Table& a, const core::Table& b, const std::string& beginning) {
  double difference = 0.0, largest = 0.0;
  for (const std::string& name : a.columns) {
    if (!name.starts_with(beginning)) continue;
    difference = std::max(difference, (a.column(name) - b.column(name)).cwiseAbs().maxCoeff());
    largest = std::max(largest, a.column(name).cwiseAbs().maxCoeff());
  }
  return difference / largest;
}

// The models step at the program's time_step_s; the machines that they are judged on must not.
TEST(MeasuredMachine, IsNotSteppedAsTheModelsAre) {
  const Toy fine, coarse;
  coarse.edit("loads/mixed.toml", "time_step_s = 120", "time_step_s = 240");
  const auto measured = [](const Toy& toy) {
    const Result result =
        toy.run({"validate", toy.path(), "--model", made("model.rom.h5"), "--load", "mixed", "--draws", "1", "--json"});
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_EQ(json::parse(result.out)["time_scheme"], "adaptive");
    return core::read_csv(toy.result("measured/all/mixed/machine_1/data.csv"));
  };
  const auto modelled = [](const Toy& toy) {
    const Result result =
        toy.run({"campaign", toy.path(), "--reduced", "--model", made("model.rom.h5"), "--load", "mixed", "--json"});
    EXPECT_EQ(result.status, 0) << result.err;
    for (const char* folder : {"campaign_reduced", "campaign"}) {
      if (std::filesystem::exists(toy.result(std::string(folder) + "/mixed/tcp.csv")))
        return core::read_csv(toy.result(std::string(folder) + "/mixed/tcp.csv"));
    }
    return core::Table{};
  };
  EXPECT_GT(apart(modelled(fine), modelled(coarse), "dz"), 1e-4);
  EXPECT_LT(apart(measured(fine), measured(coarse), "dz"), 1e-9);
}

// It would count twice in every mean.
TEST(Validate, ALoadNamedTwiceIsRefused) {
  const Toy toy;
  const Result twice = toy.run(
      {"validate", toy.path(), "--model", made("model.rom.h5"), "--load", "mixed", "--load", "mixed", "--draws", "1"});
  EXPECT_EQ(twice.status, 3);
  for (const char* words : {"'mixed'", "named twice", "each load program once"}) EXPECT_SAYS(twice.err, words);
}

TEST(Validate, PrintsFullAndReducedTruthsSideBySide) {
  const Toy toy;
  for (const char* study : {"--power-off", "--failed-sensors", ""}) {
    std::vector<std::string> arguments{
        "validate", toy.path(), "--model", made("model.rom.h5"), "--truth", made("reference.rom.h5"), "--load",
        "mixed",    "--draws",  "2",       "--full-draws",       "1"};
    if (*study) arguments.emplace_back(study);
    const Result told = toy.run(arguments);
    ASSERT_EQ(told.status, 0) << told.err;
    for (const char* words :
         {"full models, ", "TR-BDF2", "reduced, same machines", "reduced, all machines", "on the model's own mesh"})
      EXPECT_SAYS(told.out, words);
    arguments.emplace_back("--json");
    const Result result = toy.run(arguments);
    ASSERT_EQ(result.status, 0) << result.err;
    const json found = json::parse(result.out);
    EXPECT_GT(found["measured_nodes"], 0);
    ASSERT_FALSE(found["full"]["rows"].empty());
    EXPECT_EQ(found["rows"].size(), 2 * found["full"]["rows"].size()) << study;
    // The same machines and programs, another truth.
    const char* figure = std::string(study) == "--power-off"        ? "before_um"
                         : std::string(study) == "--failed-sensors" ? "reduction_percent"
                                                                    : "rms_before_um";
    EXPECT_NE(found["rows"][0][figure], found["full"]["rows"][0][figure]) << study;
  }
  EXPECT_TRUE(std::filesystem::exists(toy.result("measured/thermal/mixed/machine_1/made_from.txt")));
}

TEST(Validate, FullDrawsNeedATruthAndAreSomeOfTheDraws) {
  const Toy toy;
  const Result alone = toy.run({"validate", toy.path(), "--full-draws", "1"});
  EXPECT_EQ(alone.status, 2);
  EXPECT_SAYS(alone.err, "--truth");
  const Result more = toy.run({"validate", toy.path(), "--model", made("model.rom.h5"), "--truth",
                               made("reference.rom.h5"), "--draws", "1", "--full-draws", "2"});
  EXPECT_EQ(more.status, 2);
  EXPECT_SAYS(more.err, "--full-draws 2");
}

// The hour lies between the second and the third of four phases; offsets after it begin at 0.
TEST(Validate, ARestartIsJudgedBesideARunThatNeverStopped) {
  const Toy toy;
  const auto study = [&](const std::string& load, const std::string& rate = "") {
    std::vector<std::string> words{
        "validate", toy.path(), "--model", made("model.rom.h5"), "--truth", made("reference.rom.h5"), "--load",
        load,       "--draws",  "2",       "--restart",          "--json"};
    if (!rate.empty()) words.insert(words.end(), {"--offset-rate", rate});
    return toy.run(words);
  };
  const Result result = study("mixed");
  ASSERT_EQ(result.status, 0) << result.err;
  const json found = json::parse(result.out);
  ASSERT_EQ(found["rows"].size(), 2U);
  double through = 0.0, restarted = 0.0;
  for (const json& row : found["rows"]) {
    EXPECT_EQ(row["load"], "mixed_off");
    EXPECT_DOUBLE_EQ(row["off_at_h"], 3.0);
    EXPECT_GT(row["rms_before_um"], 10.0);
    EXPECT_LT(row["rms_restarted_um"], 0.2 * row["rms_before_um"].get<double>());
    EXPECT_NE(row["rms_restarted_um"], row["rms_through_um"]);
    through += std::pow(row["rms_through_um"].get<double>(), 2);
    restarted += std::pow(row["rms_restarted_um"].get<double>(), 2);
  }
  EXPECT_NEAR(found["ratio"]["mixed_off"], std::sqrt(restarted / through), 1e-6);
  EXPECT_LE(found["ratio"]["mixed_off"], 1.2);
  const json slow = json::parse(study("mixed", "0.2").out), quick = json::parse(study("mixed", "20").out);
  EXPECT_DOUBLE_EQ(slow["offset_rate_um_s"], 0.2);
  EXPECT_GT(slow["ratio"]["mixed_off"], 1.2 * found["ratio"]["mixed_off"].get<double>());
  EXPECT_LT(quick["ratio"]["mixed_off"], found["ratio"]["mixed_off"]);
  // Without the guard its rate does not matter, and a fast guard comes near it.
  for (std::size_t i = 0; i < 2; ++i) {
    const json &by_slow = slow["rows"][i], &by_quick = quick["rows"][i];
    EXPECT_EQ(by_slow["rms_restarted_at_once_um"], by_quick["rms_restarted_at_once_um"]);
    const double at_once = by_quick["rms_restarted_at_once_um"], restarted = by_quick["rms_restarted_um"];
    EXPECT_NEAR(restarted, at_once, 0.03 * at_once);
    EXPECT_GT(by_slow["rms_restarted_um"].get<double>(), 1.2 * at_once);
  }
  EXPECT_GT(quick["ratio"]["mixed_off"], quick["ratio_at_once"]["mixed_off"]);
  EXPECT_SAYS(read(toy.result("validation/report.html")), "Restart after an hour off");
  toy.write(
      "loads/one.toml",
      "schema = 1\ntitle = \"one\"\ninitial_C = 20\n[[phase]]\nname = \"all\"\nduration_h = 6\nspindle_rpm = 3000\n");
  const Result one = study("one");
  EXPECT_EQ(one.status, 3);
  EXPECT_SAYS(one.err, "two phases or more");
}

}  // namespace
}  // namespace thermotwin::cases
