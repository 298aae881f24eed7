// SPDX-License-Identifier: GPL-3.0-or-later
// Effects of no kind, on a machine that is measured on a finer mesh, with other parameters and noise: whatever fits
// best, no name of it is sure.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "compensation/measurement/measurement.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/diagnose.h"
#include "diagnosis/judge/action.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/judge/ranking.h"
#include "mesh/machine/kinematics.h"
#include "tests/machines/meshed_boxes.h"

namespace {

using namespace thermotwin;
using diagnosis::Diagnosis;
using diagnosis::Kind;

compensation::Measurement measured(const std::string& machine_text, std::uint64_t seed) {
  const mesh::Machine machine =
      compensation::perturbed(mesh::parse_machine(machine_text, "boxes/machine.toml"), seed, 0.7);
  std::vector<mesh::Pose> poses;
  for (const char* pose : {"X=0,Z=0", "X=150,Z=80", "X=-150,Z=-80"})
    poses.push_back(mesh::parse_pose(machine, pose, "test"));
  return compensation::measure_virtually(
      meshed::full_model(machine, 2), meshed::load(machine, "shift", meshed::shift), poses,
      {.sensor_noise_K = 0.03, .probe_noise_um = 0.2, .seed = seed, .mesh_cache = {}});
}

compensation::Measurement with_added(compensation::Measurement record, const std::string& quantity,
                                     const std::function<double(double)>& added_at_h) {
  for (const compensation::MeasuredChannel& channel : record.channels) {
    if (channel.quantity != quantity && channel.id != quantity) continue;
    for (Eigen::Index i = 0; i < record.data.values.rows(); ++i)
      record.data.values(i, channel.column) += added_at_h(record.data.values(i, 0) / 3600.0);
  }
  return record;
}

void expect_nothing_sure(const Diagnosis& d) {
  SCOPED_TRACE(d.sentence);
  EXPECT_TRUE(d.verdict == diagnosis::Verdict::ambiguous || d.verdict == diagnosis::Verdict::unexplained);
  EXPECT_EQ(d.ranking.front().parameter.kind, Kind::unknown);
  for (const diagnosis::RankedCause& cause : d.ranking) {
    if (!cause.parameter.name.empty()) {
      EXPECT_LT(cause.probability, diagnosis::sure) << name_of(cause.parameter);
    }
  }
  ASSERT_FALSE(d.actions.empty());
}

/// Cast iron at 46 W/mK, and something that hardly conducts.
TEST(DiagnoseOutside, AConductivityIsNoCapacityForSure) {
  std::string text = meshed::replaced(meshed::machine_text(), "id = \"head\"\nmaterial = \"iron\"\n",
                                      "id = \"head\"\nmaterial = \"other\"\n");
  text = meshed::replaced(text, "[[body]]\nid = \"bed\"",
                          "[[material]]\nid = \"other\"\ndensity_kg_m3 = 7200\nspecific_heat_J_kgK = 500\n"
                          "conductivity_W_mK = 12\nexpansion_1_K = 11e-6\nyoung_GPa = 120\npoisson = 0.26\n"
                          "[[body]]\nid = \"bed\"");
  const Diagnosis d = diagnosis::diagnose(meshed::reduced(), measured(text, 13), {});
  expect_nothing_sure(d);
  EXPECT_NE(d.actions.front().find("no known kind of cause explains it"), std::string::npos) << d.actions.front();
}

struct Step {
  double at_h, size;
};

void expect_steps(const Diagnosis& d, const std::vector<std::string>& channels, const std::vector<Step>& steps,
                  double near) {
  EXPECT_EQ(d.steps.channels, channels);
  ASSERT_EQ(d.steps.steps.size(), steps.size());
  for (std::size_t k = 0; k < steps.size(); ++k) {
    EXPECT_NEAR(d.steps.steps[k].from_s / 3600.0, steps[k].at_h, 0.1);
    EXPECT_NEAR(d.steps.steps[k].size, steps[k].size, near);
    EXPECT_LT(d.steps.steps[k].std, near);
  }
}

/// All displacements in one direction jump at 4 h and half back at 7 h.
TEST(DiagnoseOutside, AToolThatSlipsIsNoScaleForSure) {
  const Diagnosis d = diagnosis::diagnose(meshed::reduced(),
                                          with_added(measured(meshed::machine_text(), 14), "dz",
                                                     [](double hour) {
                                                       return hour > 7.0 ? 6.0 : hour > 4.0 ? 12.0 : 0.0;
                                                     }),
                                          {});
  expect_nothing_sure(d);
  expect_steps(d, {"dz@1", "dz@2", "dz@3"}, {{4.0, 12.0}, {7.0, -6.0}}, 1.0);
  EXPECT_NE(d.actions.front().find("dz@1 and dz@2 and dz@3 changed suddenly by"), std::string::npos)
      << d.actions.front();
}

/// A scale that slips by 5 um.
TEST(DiagnoseOutside, ASmallSlipIsNoHeatSource) {
  const Diagnosis d = diagnosis::diagnose(
      meshed::reduced(),
      with_added(measured(meshed::machine_text(), 15), "dx", [](double hour) { return hour > 5.0 ? 5.0 : 0.0; }), {});
  expect_nothing_sure(d);
  expect_steps(d, {"dx@1", "dx@2", "dx@3"}, {{5.0, 5.0}}, 0.5);
  ASSERT_EQ(d.verdict, diagnosis::Verdict::unexplained);
  EXPECT_EQ(d.next.channel, "dx@1 and dx@2 and dx@3");
  EXPECT_EQ(d.next.load.find("the same load as "), 0U) << d.next.load;
  EXPECT_EQ(d.next.outcomes.size(), 2U);
}

/// A fixture that settles after it was clamped: no expansion of a scale.
TEST(DiagnoseOutside, ACreepOfAFixtureIsNoScale) {
  const Diagnosis d = diagnosis::diagnose(meshed::reduced(),
                                          with_added(measured(meshed::machine_text(), 18), "dx",
                                                     [](double hour) { return 10.0 * (1.0 - std::exp(-hour / 4.0)); }),
                                          {});
  expect_nothing_sure(d);
  EXPECT_EQ(d.steps.channels, (std::vector<std::string>{"dx@1", "dx@2", "dx@3"}));
  ASSERT_TRUE(d.steps.creeps());
  EXPECT_NEAR(d.steps.steps.front().size, 10.0, 1.5);
  EXPECT_NEAR(d.steps.steps.front().memory_s, 4.0 * 3600.0, 1.0);
  EXPECT_NE(d.actions.front().find("a fixture, workpiece, tool or probe that was clamped shortly before"),
            std::string::npos)
      << d.actions.front();
}

/// Rows of 300 +- 60 s of which none tells when an input changed: what that leaves is no step of a reading, but a short
/// deviation about the change.
TEST(DiagnoseOutside, AChangeAtAnUnknownTimeIsNoStep) {
  constexpr double change_h = 8.0;  // of the load
  for (const double off_K : {0.0, 2.0}) {
    compensation::Measurement record = with_added(measured(meshed::machine_text(), 21), "T1", [off_K](double hour) {
      return hour > change_h + 0.03 && hour < change_h + 0.2 ? off_K : 0.0;
    });
    record.rows_at_changes = false;
    std::mt19937_64 random(21);
    std::uniform_real_distribution<double> apart(240.0, 360.0);
    std::vector<Eigen::Index> kept = {0};
    double next = apart(random);
    for (Eigen::Index i = 1; i < record.data.values.rows(); ++i) {
      if (record.data.values(i, 0) < next) continue;
      kept.push_back(i);
      next = record.data.values(i, 0) + apart(random);
    }
    record.data.values = record.data.values(kept, Eigen::all).eval();
    const Diagnosis d = diagnosis::diagnose(meshed::reduced(), record, {});
    SCOPED_TRACE(d.sentence);
    if (off_K == 0.0) {
      EXPECT_NE(d.verdict, diagnosis::Verdict::unexplained);
    }
    for (const diagnosis::ReadingStep& step : d.steps.steps)
      EXPECT_GT(std::abs(step.from_s / 3600.0 - change_h), 0.3) << in_words(d.steps);
  }
}

TEST(DiagnoseOutside, ASensorThatJumpsIsNoHeatSource) {
  const compensation::Measurement clean = measured(meshed::machine_text(), 16);
  const auto sensor = std::find_if(clean.channels.begin(), clean.channels.end(), [](const auto& channel) {
    return channel.kind == compensation::ChannelKind::temperature && channel.input.empty();
  });
  ASSERT_NE(sensor, clean.channels.end());
  const Diagnosis d = diagnosis::diagnose(
      meshed::reduced(), with_added(clean, sensor->id, [](double hour) { return hour > 5.0 ? 1.0 : 0.0; }), {});
  expect_nothing_sure(d);
  expect_steps(d, {sensor->id}, {{5.0, 1.0}}, 0.2);
  EXPECT_NE(d.actions.front().find("a sensor or its cable that was touched"), std::string::npos) << d.actions.front();
}

/// The same in all directions, each by its own size.
TEST(DiagnoseOutside, ACreepOfAllDisplacementsIsNoHeatSource) {
  compensation::Measurement record = measured(meshed::machine_text(), 20);
  for (const auto& [quantity, size] : {std::pair{"dx", 6.0}, {"dy", 6.0}, {"dz", 9.0}}) {
    record = with_added(std::move(record), quantity,
                        [size = size](double hour) { return size * (1.0 - std::exp(-hour / 2.0)); });
  }
  const Diagnosis d = diagnosis::diagnose(meshed::reduced(), record, {});
  expect_nothing_sure(d);
  ASSERT_TRUE(d.steps.creeps()) << d.sentence;
  EXPECT_EQ(d.steps.channels.size(), 9U);
  EXPECT_EQ(d.steps.quantity, "dz");
  EXPECT_NEAR(d.steps.steps.front().size, 9.0, 1.5);
  EXPECT_NE(d.actions.front().find("all 9 displacements together creep, dz by"), std::string::npos)
      << d.actions.front();
}

/// Two sensors whose cables are exchanged, and two directions of a probe: no heat source, and no loose sensor.
TEST(DiagnoseOutside, ExchangedChannelsAreNoCause) {
  const compensation::Measurement clean = measured(meshed::machine_text(), 19);
  const auto exchanged = [&](const std::string& one, const std::string& other) {
    compensation::Measurement record = clean;
    const auto column = [&](const std::string& id) {
      return std::find_if(record.channels.begin(), record.channels.end(), [&](const auto& c) { return c.id == id; })
          ->column;
    };
    record.data.values.col(column(one)).swap(record.data.values.col(column(other)));
    return record;
  };
  const auto expect_named = [](const Diagnosis& d, const std::string& clause) {
    SCOPED_TRACE(d.sentence);
    EXPECT_NE(d.verdict, diagnosis::Verdict::explained);
    EXPECT_NE(d.sentence.find(clause), std::string::npos);
    ASSERT_FALSE(d.actions.empty());
    EXPECT_EQ(d.actions.front().find("Check the connections first: " + clause), 0U) << d.actions.front();
    ASSERT_FALSE(d.warnings.empty());
    EXPECT_NE(d.warnings.front().find("may be exchanged"), std::string::npos) << d.warnings.front();
    EXPECT_TRUE(d.extended_machine_text.empty());
  };
  expect_named(diagnosis::diagnose(meshed::reduced(), exchanged("T1", "T3"), {}), "T1 and T3 seem to be exchanged");
  expect_named(diagnosis::diagnose(meshed::reduced(), exchanged("dy@1", "dz@1"), {}),
               "dy@1 and dz@1 seem to be exchanged");
  EXPECT_TRUE(diagnosis::diagnose(meshed::reduced(), clean, {}).connection.empty());
}

/// A wheel that wears: no expansion of a scale.
TEST(DiagnoseOutside, ADriftOfAllDisplacementsOfAQuantityIsOneCause) {
  const Diagnosis d = diagnosis::diagnose(
      meshed::reduced(), with_added(measured(meshed::machine_text(), 17), "dz", [](double hour) { return 1.5 * hour; }),
      {});
  SCOPED_TRACE(d.sentence);
  ASSERT_FALSE(d.causes.empty());
  EXPECT_EQ(name_of(d.causes.front().parameter), "probe_drift of displacement.dz");
  EXPECT_NEAR(d.causes.front().value, 1.5, 3.0 * d.causes.front().std);
  ASSERT_FALSE(d.actions.empty());
  EXPECT_NE(d.actions.front().find("creep or wear: all displacements dz drift by"), std::string::npos)
      << d.actions.front();
}

}  // namespace
