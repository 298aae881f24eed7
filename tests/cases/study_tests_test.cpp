// SPDX-License-Identifier: GPL-3.0-or-later
// `study tests` as a user meets it, on the toy: the chosen test, its files for other verbs, slips.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <regex>
#include <sstream>

#include "core/table.h"
#include "tests/cases/program.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class StudyTests : public ::testing::Test {
protected:
  Result run(std::vector<std::string> more) const {
    std::vector<std::string> words{"study", "tests", toy_.path(), "--model", toy_model(), "--orders", "5", "--quiet"};
    words.insert(words.end(), more.begin(), more.end());
    return toy_.run(words);
  }
  fs::path study() const { return toy_.result("study/tests"); }

  Toy toy_;
};

std::vector<std::string> lines_of(const fs::path& file) {
  std::istringstream text(read(file));
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

TEST_F(StudyTests, ATestIsShortenedToWhatItMayLeave) {
  const Result whole = run({"--hours", "4", "--exchanges", "0", "--json"});
  ASSERT_EQ(whole.status, 0) << whole.err;
  const json all = json::parse(whole.out);
  // Between the start and the end of the whole test, so that blocks can go.
  const double leave = 1.3 * std::sqrt(all["chosen_um2"].get<double>());
  const Result made = run({"--hours", "4", "--exchanges", "0", "--leave", fmt::format("{}", leave), "--json"});
  ASSERT_EQ(made.status, 0) << made.err;
  const json shorter = json::parse(made.out);
  EXPECT_LT(shorter["blocks"].size(), all["blocks"].size());
  EXPECT_LE(shorter["chosen_um2"].get<double>(), leave * leave * (1 + 1e-9));
  EXPECT_SAYS(read(study() / "report.html"), "--leave");
}

TEST_F(StudyTests, AValueNamedTwiceIsRefused) {
  const Result twice = run(
      {"--hours", "3", "--parameter", "coolant_coupling:main.spindle", "--parameter", "coolant_coupling:main.spindle"});
  EXPECT_EQ(twice.status, 3);
  EXPECT_SAYS(twice.err, "a second time");
}

TEST_F(StudyTests, TheChosenTestTellsMoreThanRandomOrdersAndRunsElsewhere) {
  const Result made = run({"--hours", "3", "--exchanges", "1", "--json"});
  ASSERT_EQ(made.status, 0) << made.err;
  const json summary = json::parse(made.out);
  const double chosen = summary["chosen_um2"];
  EXPECT_LT(chosen, 0.1 * summary["prior_um2"].get<double>());
  EXPECT_EQ(summary["random_um2"].size(), 5U);
  for (const json& random : summary["random_um2"]) EXPECT_LT(chosen, random.get<double>());
  EXPECT_LT(chosen, summary["iso_230_3_um2"].get<double>());
  EXPECT_EQ(summary["left_out"], json({"ambient"}));
  EXPECT_NEAR(summary["below_best_random_percent"].get<double>(),
              100.0 * (1.0 - chosen / summary["best_random_um2"].get<double>()), 1e-9);

  // The table: one row a block, hours that rise to three, variances that fall to the last.
  const std::vector<std::string> tests = lines_of(study() / "tests.csv");
  EXPECT_EQ(tests[0], "hours,block,variance_um2,left_um,tells");
  ASSERT_EQ(tests.size(), 2 + summary["blocks"].size());
  EXPECT_EQ(tests.back().substr(0, 2), "3,");
  double before = summary["prior_um2"];
  for (const json& block : summary["blocks"]) {
    EXPECT_LE(block["variance_um2"].get<double>(), (1 + 1e-9) * before);
    before = block["variance_um2"];
    EXPECT_FALSE(block["tells"].get<std::string>().empty());
  }
  EXPECT_DOUBLE_EQ(before, chosen);
  EXPECT_SAYS(read(study() / "report.html"), "order of ISO 230-3");
  const std::string parameters = read(study() / "parameters.csv");
  EXPECT_EQ(parameters.find("contact_pressure:"), std::string::npos) << "no joint of the toy has a pressure";
  EXPECT_SAYS(read(study() / "parameters.csv"), "coolant_coupling:main.spindle,10.00,");

  // The same command, the same bytes but for the time that it took.
  const auto files = files_in(study());
  ASSERT_EQ(run({"--hours", "3", "--exchanges", "1"}).status, 0);
  for (const auto& [name, bytes] : files_in(study()))
    if (name != "tests.json" && !name.ends_with("lock")) {
      EXPECT_EQ(bytes, files.at(name)) << name;
    }

  // Its load program runs as one of the case, its plan as a virtual measurement.
  fs::copy(study() / "load.toml", toy_.file("loads/test.toml"));
  const Result simulated = toy_.run({"simulate", toy_.path(), "--load", "test", "--quiet"});
  EXPECT_EQ(simulated.status, 0) << simulated.err;
  const core::Table sensors = core::read_csv(toy_.result("simulate/test/sensors.csv"));
  EXPECT_NEAR(sensors.values(sensors.rows() - 1, 0), 3 * 3600.0, 1e-6);
  const std::string record = toy_.result("record").string();
  const Result measured =
      thermotwin({"measure", "simulate", study().string(), "--case", toy_.path(), "--quiet", "--out", record});
  ASSERT_EQ(measured.status, 0) << measured.err;
  EXPECT_SAYS(read(fs::path(record) / "channels.toml"), "quantity = \"dz\"");
}

TEST_F(StudyTests, TakesTheFewestHoursThatLeaveWhatIsAsked) {
  const Result whole = run({"--hours", "4", "--exchanges", "0", "--json"});
  ASSERT_EQ(whole.status, 0) << whole.err;
  const json all = json::parse(whole.out);
  const double left_um = std::sqrt(all["chosen_um2"].get<double>());
  const double wanted_um = 0.5 * (left_um + std::sqrt(all["prior_um2"].get<double>()));
  const std::string wanted = fmt::format("{:.6f}", wanted_um);

  const Result made = run({"--hours", "4", "--exchanges", "0", "--leave", wanted, "--json"});
  ASSERT_EQ(made.status, 0) << made.err;
  const json summary = json::parse(made.out);
  const double hours = summary["hours_until"]["chosen"];
  EXPECT_LT(hours, 4.0);
  EXPECT_EQ(summary["blocks"].back()["until_h"].get<double>(), hours) << "it ends where it is reached";
  EXPECT_LE(std::sqrt(summary["chosen_um2"].get<double>()), wanted_um);
  EXPECT_EQ(summary["hours_until"]["random"].size(), 5U);
  if (const json& iso = summary["hours_until"]["iso_230_3"]; !iso.is_null()) {
    EXPECT_LE(hours, iso.get<double>());
  }
  for (const json& random : summary["hours_until"]["random"])
    if (!random.is_null()) {
      EXPECT_LE(hours, random.get<double>());
    }
  // The next step repeats all digits that were given, not six of them.
  EXPECT_SAYS(read(study() / "report.html"), fmt::format("--leave {} ", std::stod(wanted)));

  const Result never = run({"--hours", "1", "--exchanges", "0", "--leave", "0.001"});
  ASSERT_EQ(never.status, 0) << never.err;
  EXPECT_SAYS(never.out, "1 h of this test leave");
  EXPECT_SAYS(never.out, "more than the 0.001 um of --leave");
  EXPECT_EQ(run({"--leave", "0"}).status, 2);
  const Result needless = run({"--hours", "1", "--leave", "1000"});
  EXPECT_EQ(needless.status, 3) << needless.err;
  EXPECT_SAYS(needless.err, "no test is needed");
}

TEST_F(StudyTests, TakesABetterOrderThatItHasSeen) {
  // One block of the sensors alone: sooner or later a random order beats the greedy one without exchanges.
  bool taken = false;
  for (int seed = 1; seed <= 12 && !taken; ++seed) {
    const Result made = run({"--hours", "3", "--exchanges", "0", "--seed", std::to_string(seed), "--json"});
    ASSERT_EQ(made.status, 0) << made.err;
    const json summary = json::parse(made.out);
    EXPECT_GE(summary["below_best_random_percent"].get<double>(), 0.0) << seed;
    EXPECT_GE(summary["below_iso_230_3_percent"].get<double>(), 0.0) << seed;
    EXPECT_LE(summary["chosen_um2"].get<double>(), summary["greedy_um2"].get<double>()) << seed;
    taken = summary["start"] != "greedy";
    if (!taken) continue;
    EXPECT_LT(summary["chosen_um2"].get<double>(), summary["greedy_um2"].get<double>());
    EXPECT_SAYS(read(study() / "report.html"), "The greedy order left");
  }
  EXPECT_TRUE(taken) << "no seed tells";
}

TEST_F(StudyTests, ConfirmsTheTestOnMachinesMeasuredVirtually) {
  const Result made = run({"--hours", "2", "--exchanges", "0", "--json", "--confirm", "1"});
  ASSERT_EQ(made.status, 0) << made.err;
  const json confirmed = json::parse(made.out)["confirmed"];
  ASSERT_EQ(confirmed["chosen_um"].size(), 1U);
  EXPECT_GT(confirmed["chosen_um"][0].get<double>(), 0.0);
  EXPECT_LT(confirmed["chosen_um"][0].get<double>(), confirmed["nominal_um"][0].get<double>());
  EXPECT_SAYS(read(study() / "report.html"), "On one machine measured virtually");
  EXPECT_SAYS(read(study() / "report.html"), "The test makes the prediction better");
  // Finished machines are kept.
  const auto kept = files_in(study() / "measured");
  EXPECT_EQ(json::parse(run({"--hours", "2", "--exchanges", "0", "--json", "--confirm", "1"}).out)["confirmed"],
            confirmed);
  EXPECT_EQ(files_in(study() / "measured"), kept);
}

TEST_F(StudyTests, ReadsOneValueOrTheProbeAlone) {
  const Result one = run({"--hours", "1", "--parameter", "source_power:spindle.bearings", "--json", "--no-programs"});
  ASSERT_EQ(one.status, 0) << one.err;
  EXPECT_EQ(json::parse(one.out)["parameters"], 1);
  // An hour in the order of ISO 230-3 tells more than an hour of the spindle alone; it begins with a standstill.
  const json found = json::parse(one.out);
  const bool iso = found["start"] == "iso_230_3";
  EXPECT_SAYS(found["blocks"][iso ? 1 : 0]["block"].get<std::string>(), "spindle");
  EXPECT_LE(found["chosen_um2"].get<double>(), found["greedy_um2"].get<double>());
  const Result without = run({"--hours", "1", "--no-probe", "--json"});
  ASSERT_EQ(without.status, 0) << without.err;
  EXPECT_EQ(read(study() / "load.toml").find("name = \"probe\""), std::string::npos);
}

struct BadTest {
  std::vector<std::string> words;
  std::vector<const char*> says;
};

TEST_F(StudyTests, SlipsNamePlaceValueAndWhatIsAllowed) {
  const std::vector<BadTest> slips = {
      {{"--parameter", "source_power:spindle.bearing"},
       {"--parameter", "'source_power:spindle.bearing'", "nearest: source_power:spindle.bearings"}},
      {{"--program", "warmup"}, {"no load program 'warmup'", "did you mean 'warm_up'"}},
      {{"--load", "mixd"}, {"no load program 'mixd'", "mixed"}},
      {{"--hours", "0.5", "--no-programs"}, {"--hours", "0.5 h", "length of one block"}},
      {{"--no-standard", "--program", "ambient"}, {"--hours", "ambient", "--chamber"}},
      {{"--probe-pose", "Q=3"}, {"--probe-pose", "Q"}},
  };
  for (const BadTest& slip : slips) {
    const Result result = run(slip.words);
    EXPECT_EQ(result.status, 3) << slip.words.front() << result.err;
    for (const char* part : slip.says) EXPECT_SAYS(result.err, part);
    EXPECT_FALSE(fs::exists(study() / "load.toml"));
  }
  EXPECT_EQ(run({"--hours", "0"}).status, 2);
  for (const char* option : {"--hours", "--leave"}) {
    const Result nan = run({option, "nan"});
    EXPECT_EQ(nan.status, 3) << option;
    EXPECT_SAYS(nan.err, std::string(option) + ": nan; allowed: a number");
  }
  EXPECT_EQ(run({"--no-probe", "--probe-every", "30"}).status, 2);

  // Exact values only.
  const std::regex uncertain(R"(\{\s*value = ([^,]+), std_percent = [^}]*\})");
  const std::string machine = std::regex_replace(read(toy_.file("machine.toml")), uncertain, "$1");
  toy_.write("machine.toml", machine);
  const Result certain = run({"--hours", "1"});
  EXPECT_EQ(certain.status, 3);
  EXPECT_SAYS(certain.err, "machine.toml: no value has a std_percent");
}

}  // namespace
}  // namespace thermotwin::cases
