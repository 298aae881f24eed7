// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/drift_watch.h"

#include <gtest/gtest.h>

#include <cmath>

#include "compensation/measurement/virtual_measurement.h"
#include "compensation/online/compensator.h"
#include "mesh/machine/kinematics.h"
#include "tests/compensation/records.h"
#include "tests/compensation/shift.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double hour = 3600.0;

TEST(DriftWatch, NamesARampAndNothingThatSettlesOrSwings) {
  const auto named_at = [](const auto& offset) {
    DriftWatch watch(VectorXd::Constant(1, 0.05));
    for (double t = 0.0; t < 48 * hour; t += 300.0) {
      if (watch.judge(t, VectorXd::Constant(1, offset(t)), VectorXd::Constant(1, 0.04)) == 0) return t / hour;
    }
    return -1.0;
  };
  const double ramp = named_at([](double t) { return 0.06 * std::max(0.0, t / hour - 5.0); });
  EXPECT_GT(ramp, 16.0);
  EXPECT_LT(ramp, 26.0);
  EXPECT_GT(named_at([](double t) { return -0.1 * t / hour; }), 0.0);
  EXPECT_EQ(named_at([](double t) { return 3.0 * (1.0 - std::exp(-t / (2.5 * hour))); }), -1.0)
      << "a load's error settles";
  EXPECT_EQ(named_at([](double t) { return 2.0 * std::sin(t / (3.8 * hour)); }), -1.0) << "a hall's day";
  EXPECT_EQ(named_at([](double t) { return t > 20 * hour ? 2.0 : 0.0; }), -1.0) << "a leap is the monitor's";
  EXPECT_EQ(named_at([](double t) { return 0.01 * t / hour; }), -1.0) << "too slow to tell";
}

/// Two days of work, sensors with noise, one of which may drift.
struct Outcome {
  std::string named;
  double named_after_h = -1, rms_um = 0;
};
Outcome run(const reduction::ReducedModel& model, const test::Truth& truth, const std::vector<mesh::Pose>& poses,
            Index drifting, double rate_K_h, std::uint64_t seed) {
  test::Uniform noise(seed);
  Compensator compensator(model);
  Outcome result;
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < truth.time.size(); ++i) {
    VectorXd readings = truth.readings_C[i];
    for (double& value : readings) value += 0.04 * noise.normal();
    if (drifting >= 0) readings[drifting] += rate_K_h * std::max(0.0, truth.time[i] / hour - 6.0);
    const Offsets& offsets = compensator.step(truth.time[i], truth.rows[i], readings);
    if (result.named.empty() && !offsets.failed_sensors.empty()) {
      result.named = offsets.failed_sensors;
      result.named_after_h = truth.time[i] / hour - 6.0;
    }
    for (std::size_t p = 0; p < poses.size(); ++p) {
      sum += (compensator.tcp(poses[p]).error.head<3>() - truth.errors[i][p].error.head<3>()).squaredNorm();
      count += 1.0;
    }
  }
  result.rms_um = 1e6 * std::sqrt(sum / count);
  return result;
}

TEST(DriftWatch, NamesADriftingSensorOfAMachineThatDiffersAndNoHealthyOne) {
  const reduction::ReducedModel model = test::lumped_model();
  const std::vector<mesh::Pose> poses{mesh::home_pose(model.machine),
                                      mesh::parse_pose(model.machine, "X=-250,Y=100,Z=400", "test")};
  for (const std::uint64_t seed : {601U, 602U, 603U}) {
    const test::Truth truth = test::run_truth(perturbed(model.machine, seed), test::lumped_model({1.02, 0.96, 0.05}),
                                              60.0, 5, 40 * hour, poses);
    const Outcome healthy = run(model, truth, poses, -1, 0.0, seed);
    EXPECT_EQ(healthy.named, "") << "seed " << seed;
    for (const Index sensor : {Index{0}, Index{3}, Index{6}}) {
      const Outcome drifted = run(model, truth, poses, sensor, seed % 2 ? 0.12 : -0.12, seed);
      const std::string expected = model.machine.sensors[sensor].id + "=drift";
      std::printf("  %s: named %s %.1f h after the drift began; %.2f um, healthy %.2f um\n", expected.c_str(),
                  drifted.named.c_str(), drifted.named_after_h, drifted.rms_um, healthy.rms_um);
      EXPECT_EQ(drifted.named, expected) << "seed " << seed;
      EXPECT_LT(drifted.named_after_h, 32.0);
    }
  }
}

TEST(DriftWatch, AHiddenHeatSourceIsNoDrift) {
  const reduction::ReducedModel model = test::lumped_model();
  const std::vector<mesh::Pose> poses{mesh::home_pose(model.machine)};
  mesh::Machine machine = model.machine;
  for (mesh::SourceSpec& source : machine.sources) source.scale.value = 1.6;
  const test::Truth truth = test::run_truth(machine, model, 60.0, 5, 40 * hour, poses);
  EXPECT_EQ(run(model, truth, poses, -1, 0.0, 5).named.find("drift"), std::string::npos);
}

}  // namespace
}  // namespace thermotwin::compensation
