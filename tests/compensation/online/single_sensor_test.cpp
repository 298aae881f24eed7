// SPDX-License-Identifier: GPL-3.0-or-later
// One or two sensors have no others to check them: a constant error of theirs looks like a warm machine at the first
// row. The stated deviation covers both until the hours after it tell.
#include <gtest/gtest.h>

#include <cstdio>
#include <vector>

#include "compensation/measurement/virtual_measurement.h"
#include "compensation/online/compensator.h"
#include "core/missing.h"
#include "mesh/machine/kinematics.h"
#include "tests/compensation/shift.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

const reduction::ReducedModel& nominal() {
  static const reduction::ReducedModel model = test::lumped_model();
  return model;
}

const test::Truth& day(double start_C) {
  static const std::vector<mesh::Pose> home{mesh::home_pose(nominal().machine)};
  static const test::Truth cold = test::run_truth(nominal().machine, nominal(), 60.0, 1, 10 * 3600.0, home);
  static const test::Truth warm = test::run_truth(nominal().machine, nominal(), 60.0, 1, 10 * 3600.0, home, 26.0);
  return start_C > 20.0 ? warm : cold;
}

struct Outcome {
  double worst = 0.0;  ///< largest residual over its stated deviation, ten minutes after the start and later
  VectorXd first_std, last_std;
  std::string failed;  ///< sensors named at the end
};

/// These sensors alone, the first of them off by a constant, from a row of the day on.
Outcome outcome(const test::Truth& truth, std::size_t first, const std::vector<Index>& kept, double bias_K) {
  Compensator compensator(nominal());
  Outcome result;
  for (std::size_t i = first; i < truth.time.size(); ++i) {
    VectorXd readings = VectorXd::Constant(truth.readings_C[i].size(), core::missing);
    for (const Index s : kept) readings[s] = truth.readings_C[i][s];
    readings[kept.front()] += bias_K;
    const Offsets& offsets = compensator.step(truth.time[i], truth.rows[i], readings);
    result.failed = offsets.failed_sensors;
    if (truth.time[i] - truth.time[first] < 600.0) continue;
    const VectorXd residual = offsets.offset_um + 1e6 * truth.errors[i][0].error.head<3>();
    result.worst = std::max(result.worst, residual.cwiseQuotient(offsets.std_um).cwiseAbs().maxCoeff());
    if (result.first_std.size() == 0) result.first_std = offsets.std_um;
    result.last_std = offsets.std_um;
  }
  return result;
}

TEST(SingleSensor, ItsConstantErrorIsCoveredAndFoundByTheHoursThatFollow) {
  const auto count = std::ssize(nominal().machine.sensors);
  for (Index s = 0; s < count; ++s) {
    for (const double bias : {3.0, 5.0, 15.0, -5.0}) {
      const Outcome found = outcome(day(20.0), 0, {s}, bias);
      EXPECT_LT(found.worst, 3.0) << nominal().machine.sensors[s].id << " " << bias;
      if (std::abs(bias) < 5.0) continue;
      EXPECT_EQ(found.failed, nominal().machine.sensors[s].id + "=offset") << bias;
    }
  }
}

// The sensors of table and swivel, the last two, hardly see what spindle and drives have warmed.
TEST(SingleSensor, AWarmMachineIsCoveredToo) {
  const auto count = std::ssize(nominal().machine.sensors);
  for (Index s = 0; s < count; ++s) {
    for (const double bias : {0.0, 5.0}) {
      EXPECT_LT(outcome(day(26.0), 0, {s}, bias).worst, 3.0) << "rested in a warm hall, " << s << " " << bias;
      if (s >= count - 2) continue;
      EXPECT_LT(outcome(day(20.0), 150, {s}, bias).worst, 3.0) << "at work, " << s << " " << bias;
    }
  }
}

TEST(SingleSensor, OneThatAgreesWithTheAirIsBelieved) {
  const Outcome sound = outcome(day(20.0), 0, {0}, 0.0);
  EXPECT_LT(sound.worst, 3.0);
  EXPECT_EQ(sound.failed, "");
  const Outcome off = outcome(day(20.0), 0, {0}, 5.0);
  EXPECT_GT(off.first_std.maxCoeff(), 3.0 * sound.first_std.maxCoeff());
}

TEST(SingleSensor, OfTwoTheOneThatIsOffIsCovered) {
  const auto count = std::ssize(nominal().machine.sensors);
  for (Index s = 0; s + 1 < count; ++s) {
    for (const double bias : {0.0, 3.0, 15.0}) {
      EXPECT_LT(outcome(day(20.0), 0, {s, s + 1}, bias).worst, 5.0) << s << " " << bias;
    }
  }
}

}  // namespace
}  // namespace thermotwin::compensation
