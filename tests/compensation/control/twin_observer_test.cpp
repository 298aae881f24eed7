// SPDX-License-Identifier: GPL-3.0-or-later
// The twin with sensors beside the compensator, on machines that are not nominal.
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "compensation/control/twin_jobs.h"
#include "compensation/measurement/virtual_measurement.h"
#include "core/missing.h"
#include "tests/compensation/control/twin_of_lumps.h"
#include "tests/compensation/shift.h"

namespace thermotwin::compensation {
namespace {

using core::missing;
using Eigen::VectorXd;
using test::Twin;

const reduction::ReducedModel& lumps() {
  static const reduction::ReducedModel model = [] {
    reduction::ReducedModel lumped = test::lumps_with_lines();
    lumped.errors.resize(1);
    lumped.errors[0].rms_um = 0.4;
    return lumped;
  }();
  return model;
}

ControlData data_with(double start_over_s, double correction_s = 300.0) {
  ControlOptions options;
  options.tolerance = 1e-14;
  options.start_over_s = start_over_s;
  options.compensator.correction_s = correction_s;
  return control_data(lumps(), options);
}

const tt_model& core() {
  static const ControlModel model(data_with(0.0));
  return model.model();
}

test::Truth other_machine(std::uint64_t seed, double rows_s, double duration_s, double start_C = 20.0) {
  const double step_s = std::min(10.0, rows_s);
  return test::run_truth(perturbed(lumps().machine, seed), test::lumped_model({1.02, 0.96, 0.05}), step_s,
                         static_cast<int>(std::lround(rows_s / step_s)), duration_s, {}, start_C);
}

/// "T1=stuck T3=offset", as Offsets::failed_sensors has it.
std::string failed_sensors(const tt_twin& twin) {
  std::string text;
  for (int s = 0; s < twin.model->sensors; ++s) {
    if (tt_twin_sensor_fault(&twin, s) == TT_SENSOR_FINE) continue;
    text += (text.empty() ? "" : " ") + std::string(twin.model->sensor_names[s]) + "=" +
            tt_twin_sensor_fault_text(&twin, s);
  }
  return text;
}

/// Both on the same rows, with axes that move.
class Beside {
public:
  explicit Beside(const CompensatorOptions& options = {}) : compensator(lumps(), options) {}

  void step(double time, const VectorXd& shift, const VectorXd& readings_C) {
    const VectorXd row = test::working_row(lumps().machine, compensator.channels(), shift, time);
    const Offsets& expected = compensator.step(time, row, readings_C);
    const int status = twin.row(time, row, readings_C);
    worst = std::max(worst, (twin.offset_um() - expected.offset_um).cwiseAbs().maxCoeff());
    worst_std = std::max(worst_std, (twin.std_um() - expected.std_um).cwiseAbs().maxCoeff());
    largest = std::max(largest, expected.offset_um.cwiseAbs().maxCoeff());
    statuses.insert(status_text(expected.status));
    const std::string failed = failed_sensors(twin.get());
    if (tt_status_text(status) != std::string(status_text(expected.status)) || failed != expected.failed_sensors)
      ++others;
    if (!failed.empty()) named.insert(failed);
  }

  Compensator compensator;
  Twin twin{core()};
  double worst = 0, worst_std = 0, largest = 0;
  int others = 0;  ///< rows with another status or other failed sensors
  std::set<std::string> statuses, named;
};

VectorXd noisy(VectorXd reading, test::Uniform& noise, double noise_K = 0.02) {
  for (double& value : reading) value += noise_K * noise.normal();
  return reading;
}

TEST(ControlTwinSensors, RowsAMinuteApartGiveWhatTheCompensatorGives) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const test::Truth truth = other_machine(seed, 60.0, 10 * 3600.0, seed == 3 ? 26.0 : 20.0);
    test::Uniform noise(seed);
    Beside both;
    for (std::size_t i = 0; i < truth.time.size(); ++i)
      both.step(truth.time[i], truth.rows[i], noisy(truth.readings_C[i], noise));
    EXPECT_LT(both.worst, 1e-5) << seed;
    EXPECT_LT(both.worst_std, 1e-5) << seed;
    EXPECT_EQ(both.others, 0) << seed;
    EXPECT_GT(both.largest, 10.0);
    EXPECT_TRUE(both.statuses.count("ok"));
  }
}

// Sensors that fail one after the other, and a start in the middle of work.
TEST(ControlTwinSensors, FailedSensorsAndAWarmStartGiveItToo) {
  const test::Truth truth = other_machine(4, 60.0, 10 * 3600.0);
  for (const std::size_t first : {std::size_t{0}, std::size_t{150}}) {
    test::Uniform noise(4);
    Beside both;
    VectorXd kept;
    for (std::size_t i = first; i < truth.time.size(); ++i) {
      const double h = truth.time[i] / 3600.0;
      VectorXd reading = noisy(truth.readings_C[i], noise);
      if (h > 3.5 && h < 5.0) reading[0] = kept[0];
      if (h > 4.0) reading[1] += 4.0;
      if (h > 5.0 && h < 6.0) reading[2] = missing;
      if (h > 6.0) reading[3] += 273.15;
      if (h > 8.0) reading.setConstant(missing);
      both.step(truth.time[i], truth.rows[i], reading);
      kept = reading;
    }
    EXPECT_LT(both.worst, 1e-6) << first;
    EXPECT_LT(both.worst_std, 1e-6) << first;
    EXPECT_EQ(both.others, 0) << first;
    EXPECT_TRUE(both.statuses.count("sensor_failed"));
    EXPECT_GE(both.named.size(), 4U);
  }
}

// Sensors that no others check: a constant error from the first row on, and a start in the middle of work.
TEST(ControlTwinSensors, OneSensorAndTwoGiveItToo) {
  const test::Truth truth = other_machine(6, 60.0, 10 * 3600.0);
  for (const std::size_t first : {std::size_t{0}, std::size_t{150}}) {
    for (const Eigen::Index kept : {1, 2}) {
      test::Uniform noise(6);
      Beside both;
      for (std::size_t i = first; i < truth.time.size(); ++i) {
        VectorXd reading = noisy(truth.readings_C[i], noise);
        reading[0] += 8.0;
        reading.tail(reading.size() - kept).setConstant(missing);
        both.step(truth.time[i], truth.rows[i], reading);
      }
      EXPECT_LT(both.worst, 1e-5) << first << " " << kept;
      EXPECT_LT(both.worst_std, 1e-5) << first << " " << kept;
      EXPECT_EQ(both.others, 0) << first << " " << kept;
      EXPECT_TRUE(both.statuses.count("sensor_failed")) << first << " " << kept;
    }
  }
}

TEST(ControlTwinSensors, LongAndUnevenRowsGiveItToo) {
  test::Uniform number(6);
  const test::Truth truth = other_machine(6, 30.0, 10 * 3600.0);
  Beside both;
  for (std::size_t i = 0; i < truth.time.size();
       i += 1 + static_cast<std::size_t>(number(0.0, 1.0) < 0.1 ? number(0.0, 40.0) : number(0.0, 3.0)))
    both.step(truth.time[i], truth.rows[i], noisy(truth.readings_C[i], number));
  EXPECT_LT(both.worst, 1e-5);
  EXPECT_LT(both.worst_std, 1e-5);
  EXPECT_EQ(both.others, 0);
}

/// A speed that no row has, and one that is missing for two hours.
TEST(ControlTwinSensors, ChannelsThatNobodyGivesAreInTheDeviation) {
  const test::Truth truth = other_machine(5, 60.0, 7 * 3600.0);
  test::Uniform noise(5);
  Beside both, told;
  const auto channel = [&](const char* name) { return both.compensator.channels().index(name); };
  both.compensator.never_told({channel("axis.X.feed_mm_min"), channel("air.T_C")});
  tt_twin_never_given(&both.twin.get(), channel("axis.X.feed_mm_min"));
  tt_twin_never_given(&both.twin.get(), channel("air.T_C"));
  double wider = 0.0;
  for (std::size_t i = 0; i < truth.time.size(); ++i) {
    const VectorXd reading = noisy(truth.readings_C[i], noise);
    VectorXd row = truth.rows[i];
    told.step(truth.time[i], row, reading);
    row[channel("axis.X.feed_mm_min")] = 0.0;  // a value of nobody
    row[channel("air.T_C")] = missing;
    const double h = truth.time[i] / 3600.0;
    if (h > 1.0 && h < 3.0) row[channel("spindle.speed_rpm")] = missing;
    both.step(truth.time[i], row, reading);
    wider = std::max(wider, (both.twin.std_um() - told.twin.std_um()).maxCoeff());
  }
  EXPECT_LT(both.worst, 1e-6);
  EXPECT_LT(both.worst_std, 1e-6);
  EXPECT_EQ(both.others, 0);
  EXPECT_GT(wider, 1.0);
}

/// Steps and corrections take effect up to a step later: offsets differ by a share of what a minute changes.
TEST(ControlTwinSensors, QuickRowsFollowWithinTheDelayOfAStep) {
  const test::Truth truth = other_machine(7, 1.0, 8 * 3600.0);
  test::Uniform noise(7);
  Compensator compensator(lumps());
  Twin twin(core());
  std::vector<VectorXd> expected;
  double worst = 0.0, squares = 0.0, minute = 0.0, mean_std = 0.0;
  for (std::size_t i = 0; i < truth.time.size(); ++i) {
    const VectorXd reading = noisy(truth.readings_C[i], noise);
    const Offsets& wanted = compensator.step(truth.time[i], truth.rows[i], reading);
    twin.row(truth.time[i], truth.rows[i], reading);
    expected.push_back(wanted.offset_um);
    if (i < 600) continue;
    const double off = (twin.offset_um() - wanted.offset_um).cwiseAbs().maxCoeff();
    worst = std::max(worst, off);
    squares += off * off;
    minute = std::max(minute, (expected[i] - expected[i - 60]).cwiseAbs().maxCoeff());
    const double share = (twin.std_um().array() / wanted.std_um.array() - 1.0).abs().maxCoeff();
    mean_std += share / static_cast<double>(truth.time.size());
  }
  EXPECT_LT(worst, 1.0 * minute);
  EXPECT_LT(std::sqrt(squares / static_cast<double>(truth.time.size())), 0.05 * minute);
  EXPECT_LT(mean_std, 0.02);
}

/// The start, steps and corrections are left in the middle, saved and gone on with.
TEST(ControlTwinSensors, ASavedStateGoesOnWithTheSameBits) {
  const ControlModel model(data_with(240.0));
  const test::Truth truth = other_machine(8, 0.5, 1800.0);
  test::Uniform noise(8);
  Twin twin(model.model());
  std::vector<VectorXd> readings;
  for (const VectorXd& reading : truth.readings_C) readings.push_back(noisy(reading, noise));
  std::set<int> jobs;
  for (std::size_t i = 0; i + 500 < truth.time.size(); ++i) {
    twin.row(truth.time[i], truth.rows[i], readings[i]);
    if (i % 37 != 0) continue;
    jobs.insert(twin.get().now->job);
    Twin loaded(model.model());
    loaded.row(3.0, truth.rows[0], readings[5]);
    ASSERT_EQ(loaded.load(twin.saved()), TT_LOADED);
    Twin beside(model.model());
    ASSERT_EQ(beside.load(twin.saved()), TT_LOADED);
    const std::size_t rows = i % 5 == 0 ? 400 : 20;
    for (std::size_t k = i + 1; k < i + rows; ++k) {
      loaded.row(truth.time[k], truth.rows[k], readings[k]);
      beside.row(truth.time[k], truth.rows[k], readings[k]);
    }
    ASSERT_EQ(loaded.saved(), beside.saved()) << i;
    Twin same(model.model());
    ASSERT_EQ(same.load(twin.saved()), TT_LOADED);
    for (std::size_t k = 1; k < 30; ++k, ++i) {
      twin.row(truth.time[i + 1], truth.rows[i + 1], readings[i + 1]);
      same.row(truth.time[i + 1], truth.rows[i + 1], readings[i + 1]);
      ASSERT_EQ(twin.saved(), same.saved()) << i;
    }
  }
  EXPECT_EQ(jobs, (std::set<int>{TT_JOB_NONE, TT_JOB_STEP, TT_JOB_CORRECTION, TT_JOB_START}));
}

/// Slices of the start are spread over rows; then the offsets come up, and come near those of a start at once.
TEST(ControlTwinSensors, AStartThatIsSpreadOverRowsSaysSo) {
  const ControlModel model(data_with(120.0));
  const test::Truth truth = other_machine(9, 1.0, 4 * 3600.0, 24.0);
  Twin spread(model.model()), at_once(core());
  double begun = 0.0, apart = 0.0;
  for (std::size_t i = 0; i < truth.time.size(); ++i) {
    const int status = spread.row(truth.time[i], truth.rows[i], truth.readings_C[i]);
    at_once.row(truth.time[i], truth.rows[i], truth.readings_C[i]);
    if (status == TT_STARTING) {
      ASSERT_EQ(begun, 0.0);
      ASSERT_EQ(spread.offset_um().norm(), 0.0);
      ASSERT_EQ(spread.std_um()[0], model.model().largest_um);
    } else if (begun == 0.0) {
      begun = truth.time[i];
    }
    if (truth.time[i] < 3600.0) continue;
    const VectorXd difference = spread.offset_um() - at_once.offset_um();
    apart = std::max(apart, (difference.array() / at_once.std_um().array()).abs().maxCoeff());
  }
  EXPECT_GT(begun, 20.0);
  EXPECT_LE(begun, 120.0);
  EXPECT_GT(at_once.offset_um().norm(), 5.0);
  EXPECT_LT(apart, 1.5) << "standard deviations, from one hour on";
}

TEST(ControlTwinSensors, ACorrectionTakesEffectWithinAStep) {
  const test::Truth truth = other_machine(11, 0.5, 1500.0, 23.0);
  Twin twin(core());
  double began = 0.0, longest = 0.0;
  int corrections = 0;
  for (std::size_t i = 0; i < truth.time.size(); ++i) {
    twin.row(truth.time[i], truth.rows[i], truth.readings_C[i]);
    const bool corrects = twin.get().now->job == TT_JOB_CORRECTION;
    if (corrects && began == 0.0) began = truth.time[i];
    if (corrects || began == 0.0) continue;
    longest = std::max(longest, truth.time[i] - began);
    began = 0.0;
    ++corrections;
  }
  EXPECT_GE(corrections, 5);
  EXPECT_LE(longest, 30.5);
  EXPECT_GT(longest, 5.0);
}

}  // namespace
}  // namespace thermotwin::compensation
