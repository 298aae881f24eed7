// SPDX-License-Identifier: GPL-3.0-or-later
// Sources and joints whose size changes in the course of a record, measured on a finer network.

#include "diagnosis/inference/changing_size.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "diagnosis/report/diagnosis_json.h"
#include "mesh/machine/file.h"
#include "tests/diagnosis/diagnosed_rods.h"

namespace {

using namespace thermotwin;
using diagnosis::Diagnosis;
using diagnosis::Kind;
using diagnosis::Verdict;
using lumped::find, lumped::listed, lumped::run;

Diagnosis of_changing(const std::string& item, std::function<double(double)> factor, std::uint64_t seed) {
  return run(lumped::measure({}, {.seed = seed, .spread = 0.7, .changing = item, .factor = std::move(factor)}));
}

TEST(ChangingSize, ReLubricationIsAStepWithItsTime) {
  const Diagnosis d = of_changing(
      "motor", [](double hour) { return hour < 13.3 ? 1.0 : 2.0; }, 81);
  ASSERT_EQ(d.verdict, Verdict::explained) << listed(d);
  const diagnosis::RankedCause& cause = d.causes.front();
  ASSERT_EQ(name_of(cause.parameter), "source_step of motor") << listed(d);
  EXPECT_NEAR(cause.value, 2.0, 4 * std::hypot(cause.std, 0.05 * 2.0)) << listed(d);
  EXPECT_NEAR(cause.parameter.from_s, 13.3 * 3600, 4 * cause.parameter.from_std_s);
  EXPECT_LT(cause.parameter.from_std_s, 3600.0);
  EXPECT_NE(d.actions.front().find("re-lubrication"), std::string::npos) << d.actions.front();
  const auto json = nlohmann::json::parse(diagnosis::diagnosis_json(d))["causes"][0];
  EXPECT_NEAR(json["since_h"]["value"].get<double>(), 13.3, 1.0);
  ASSERT_FALSE(d.extended_machine_text.empty());
  EXPECT_NEAR(mesh::parse_machine(d.extended_machine_text, "rods/machine.toml").sources[0].scale.value, cause.value,
              1e-6);
}

/// The spindle stands from 18 to 21 h: no data tell when in it the step came.
TEST(ChangingSize, AStepWhileTheSourceIsOffHasAnUncertainTime) {
  const Diagnosis d = of_changing(
      "motor", [](double hour) { return hour < 18.6 ? 1.0 : 2.0; }, 86);
  ASSERT_FALSE(d.causes.empty()) << listed(d);
  const diagnosis::Parameter& step = d.causes.front().parameter;
  ASSERT_EQ(name_of(step), "source_step of motor") << listed(d);
  EXPECT_GT(step.from_std_s, 0.6 * 3600.0);
  EXPECT_LT(step.from_std_s, 2.0 * 3600.0);
  EXPECT_NEAR(step.from_s, 18.6 * 3600.0, 3.0 * step.from_std_s);
}

TEST(ChangingSize, JumpingFrictionIsAnotherLawOfItsSource) {
  const double levels[] = {0.3, 2.6, 0.5, 3.1, 0.2, 2.2, 0.4, 2.9, 0.3, 3.5, 0.2, 2.4};
  const Diagnosis d = of_changing(
      "motor", [&](double hour) { return levels[static_cast<int>(hour / 3.1) % 12]; }, 82);
  ASSERT_EQ(d.verdict, Verdict::ambiguous) << listed(d);
  ASSERT_FALSE(d.ambiguous_set.empty());
  EXPECT_EQ(name_of(d.ambiguous_set.front().parameter), "other_law of motor") << listed(d);
  EXPECT_NE(d.sentence.find("the size of motor"), std::string::npos) << d.sentence;
  ASSERT_FALSE(d.actions.empty());
  EXPECT_NE(d.actions.front().find("Record the power of motor"), std::string::npos) << d.actions.front();
  double all = 0.0;
  for (const diagnosis::Explanation& one : d.explanations) all += one.probability;
  EXPECT_NEAR(all, 1.0, 1e-3);
}

TEST(ChangingSize, APowerThatIsConstantlyWrongIsNeither) {
  for (const std::uint64_t seed : {83, 84}) {
    const Diagnosis d = run(lumped::measure({{find(Kind::source_power, "motor"), 1.7}}, {.seed = seed, .spread = 0.7}));
    ASSERT_EQ(d.verdict, Verdict::explained) << listed(d);
    EXPECT_EQ(name_of(d.causes.front().parameter), "source_power of motor");
    EXPECT_EQ(d.causes.size(), 1u) << listed(d);
  }
}

TEST(ChangingSize, ARecordOfARightMachineHasNone) {
  const Diagnosis d = run(lumped::measure({}, {.seed = 85, .spread = 0.7}));
  EXPECT_EQ(d.verdict, Verdict::no_discrepancy) << listed(d);
}

TEST(ChangingSize, LostPreloadIsAStepOfItsJoint) {
  const Diagnosis d = of_changing(
      "mounts", [](double hour) { return hour < 11.0 ? 1.0 : 0.2; }, 86);
  std::printf("%s", listed(d).c_str());
  ASSERT_FALSE(d.ranking.empty());
  EXPECT_EQ(name_of(d.ranking.front().parameter), "contact_step of mounts") << listed(d);
}

}  // namespace
