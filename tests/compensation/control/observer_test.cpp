// SPDX-License-Identifier: GPL-3.0-or-later
// The observer of the online core beside the class that it restates, over hours of a machine that is not nominal.
#include "compensation/control/observer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <vector>

#include "compensation/measurement/virtual_measurement.h"
#include "core/missing.h"
#include "tests/compensation/control/observers.h"
#include "tests/compensation/records.h"
#include "tests/compensation/shift.h"

namespace thermotwin::compensation {
namespace {

using core::missing;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::Beside;
using test::nominal;

test::Truth other_machine(std::uint64_t seed, double step_s, int rows_every, double duration_s, double start_C = 20.0) {
  const reduction::ReducedModel structure = test::lumped_model({1.02, 0.96, 0.05});
  return test::run_truth(perturbed(nominal().machine, seed), structure, step_s, rows_every, duration_s, {}, start_C);
}

VectorXd noisy(VectorXd reading, test::Uniform& noise, double noise_K = 0.02) {
  for (double& value : reading) value += noise_K * noise.normal();
  return reading;
}

TEST(ControlObserver, FollowsTheClassThroughADay) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const test::Truth truth = other_machine(seed, 20.0, seed == 2 ? 18 : 6, 10 * 3600.0, seed == 3 ? 24.0 : 20.0);
    test::Uniform noise(seed);
    Beside both;
    for (std::size_t i = 0; i < truth.time.size() && !testing::Test::HasFatalFailure(); ++i)
      both.step(truth.time[i], truth.rows[i], noisy(truth.readings_C[i], noise));
    EXPECT_GT(both.largest, 0.05) << "the sensors correct something";
    RecordProperty("worst_K_" + std::to_string(seed), std::to_string(both.worst));
  }
}

// A warm start, rows of ten seconds, sensors that fail one after the other, and readings that nobody can believe.
TEST(ControlObserver, NamesTheSensorsThatTheClassNames) {
  const test::Truth truth = other_machine(4, 10.0, 1, 9 * 3600.0, 26.0);
  test::Uniform noise(4);
  Beside both;
  VectorXd kept;
  for (std::size_t i = 0; i < truth.time.size() && !testing::Test::HasFatalFailure(); ++i) {
    const double h = truth.time[i] / 3600.0;
    VectorXd reading = noisy(truth.readings_C[i], noise);
    if (h > 1.0 && h < 3.0) reading[0] = kept[0];
    if (h > 2.0) reading[1] += 4.0;
    if (h > 3.0 && h < 4.0) reading[2] = missing;
    if (h > 4.0) reading[2] += 273.15;
    if (h > 5.0 && h < 6.0) reading[3] += 2.0 * noise.normal();
    if (i == 0) reading[4] += 30.0;
    both.step(truth.time[i], truth.rows[i], reading);
    kept = reading;
  }
  for (const int fault : {TT_SENSOR_STUCK, TT_SENSOR_OFFSET, TT_SENSOR_ABSENT, TT_SENSOR_KELVIN, TT_SENSOR_NOISE})
    EXPECT_TRUE(both.named.count(fault)) << fault;
}

// A machine at work: first readings lie far apart, the others explain some, and one of them is wrong.
TEST(ControlObserver, StartsInTheMiddleOfWork) {
  const test::Truth truth = other_machine(10, 20.0, 3, 8 * 3600.0);
  for (const double off_K : {0.0, 6.0}) {
    test::Uniform noise(10);
    Beside both;
    double lowest = 1e9, highest = -1e9;
    for (std::size_t i = 400; i < 460 && !testing::Test::HasFatalFailure(); ++i) {
      VectorXd reading = noisy(truth.readings_C[i], noise);
      reading[2] += off_K;
      if (i == 400) lowest = reading.minCoeff(), highest = reading.maxCoeff();
      both.step(truth.time[i], truth.rows[i], reading);
    }
    EXPECT_GT(highest - lowest, 5.0);
    int explained = 0;
    for (int s = 0; s < both.core->trust.monitor.sensors; ++s) explained += both.core->explained[s];
    EXPECT_GT(explained, 2);
  }
}

TEST(ControlObserver, TakesDrivesThatNobodyRecordsAndProbing) {
  const test::Truth truth = other_machine(5, 20.0, 3, 6 * 3600.0);
  test::Uniform noise(5);
  Beside both;
  const auto drives = both.classic.errors().drives().size();
  for (std::size_t i = 0; i < truth.time.size() && !testing::Test::HasFatalFailure(); ++i) {
    const double h = truth.time[i] / 3600.0;
    std::vector<char> untold(drives, 0);
    if (h > 1.0 && h < 2.5) untold[0] = 1;
    if (h > 2.0 && h < 2.2) untold[drives - 1] = 1;
    both.step(truth.time[i], truth.rows[i], noisy(truth.readings_C[i], noise), untold);
    if (i == 100 || i == 201) both.learn({20e-6, missing, -8e-6});
  }
  EXPECT_GT(both.largest, 0.1);
}

TEST(ControlObserver, RunsWithoutSensorsAndWithGapsBetweenRows) {
  const test::Truth truth = other_machine(6, 60.0, 60, 10 * 3600.0);
  for (const bool sensors : {false, true}) {
    CompensatorOptions options;
    options.start_from_sensors = sensors;
    options.start_C = 22.0;
    Beside both(options);
    for (std::size_t i = 0; i < truth.time.size() && !testing::Test::HasFatalFailure(); ++i)
      both.step(truth.time[i], truth.rows[i], sensors ? truth.readings_C[i] : VectorXd());
    EXPECT_EQ(both.largest > 0.01, sensors);
  }
}

// Slices that rows carry: the correction takes effect later, all at once, and the estimate is the same.
TEST(ControlObserver, ACorrectionTakesEffectAtItsEnd) {
  const test::Truth truth = other_machine(7, 20.0, 3, 2 * 3600.0);
  test::Uniform noise(7);
  Beside both;
  // The last correction is some rows ago.
  for (std::size_t i = 0; i + 2 < truth.time.size(); ++i)
    both.step(truth.time[i], truth.rows[i], noisy(truth.readings_C[i], noise));
  const std::vector<double> block = both.core.block();
  const auto order = nominal().system.order();
  const tt_moment moment = both.now();
  const MatrixXd matrix = both.own_clock.operator_at(both.own_clock.coefficients().p);
  const tt_interval interval = {300.0, both.own_clock.coefficients().p.data(), both.own_clock.coefficients().q.data(),
                                both.own_clock.state().data(), matrix.data()};
  const auto corrected = [&] { return VectorXd(Eigen::Map<VectorXd>(both.core->corrected, order)); };
  const auto run = [&](bool rows_between) {
    both.core.block() = block;
    tt_moment later = moment;
    later.interval_s = 300.0;
    tt_observer_begin_correction(both.core.get(), &later, &interval);
    EXPECT_FALSE(tt_observer_due(both.core.get(), &later)) << "one is in progress";
    const VectorXd before = corrected();
    int slices = 0;
    while (tt_observer_correction_slice(both.core.get()) == 0) {
      ++slices;
      if (!rows_between) continue;
      tt_observer_set_corrected(both.core.get(), &later);
      EXPECT_LT((corrected() - before).norm(), 1e-12 * before.norm()) << slices;
    }
    EXPECT_GT(slices, 5);
    tt_observer_finish_correction(both.core.get(), &later);
    EXPECT_GT((corrected() - before).norm(), 1e-9 * before.norm());
    return corrected();
  };
  const VectorXd at_once = run(false), with_rows = run(true);
  EXPECT_TRUE(at_once == with_rows) << "the same bits";
}

// All values lie in the block, those of a job too: a copy goes on with the same bits.
TEST(ControlObserver, GoesOnFromACopyWithTheSameBits) {
  const test::Truth truth = other_machine(8, 20.0, 3, 3600.0);
  Beside both;
  for (std::size_t i = 0; i + 2 < truth.time.size(); ++i) both.step(truth.time[i], truth.rows[i], truth.readings_C[i]);
  const MatrixXd matrix = both.own_clock.operator_at(both.own_clock.coefficients().p);
  const tt_interval interval = {300.0, both.own_clock.coefficients().p.data(), both.own_clock.coefficients().q.data(),
                                both.own_clock.state().data(), matrix.data()};
  tt_moment moment = both.now();
  moment.interval_s = 300.0;
  tt_observer_begin_correction(both.core.get(), &moment, &interval);
  for (int slices = 0; slices < 4; ++slices) tt_observer_correction_slice(both.core.get());
  test::InArena<tt_observer, tt_observer_model> copy(tt_observer_lay, both.data.observer());
  copy.block() = both.core.block();
  for (tt_observer* one : {both.core.get(), copy.get()}) {
    while (tt_observer_correction_slice(one) == 0) continue;
    tt_observer_finish_correction(one, &moment);
    moment.time += 20.0;
    tt_observer_read(one, truth.readings_C[20].data(), truth.rows[20].data());
    tt_observer_add_readings(one, &moment, 0);
    moment.time -= 20.0;
  }
  EXPECT_EQ(std::memcmp(copy.block().data(), both.core.block().data(), copy.block().size() * sizeof(double)), 0);
}

TEST(ControlObserver, ACorrectionThatFailsChangesNothing) {
  const test::Truth truth = other_machine(9, 20.0, 3, 3600.0);
  Beside both;
  for (std::size_t i = 0; i + 2 < truth.time.size(); ++i) both.step(truth.time[i], truth.rows[i], truth.readings_C[i]);
  MatrixXd matrix = both.own_clock.operator_at(both.own_clock.coefficients().p);
  const VectorXd p = VectorXd::Constant(both.data.sensors().terms, 0.123);
  const tt_interval interval = {300.0, p.data(), both.own_clock.coefficients().q.data(), both.own_clock.state().data(),
                                matrix.data()};
  tt_moment moment = both.now();
  moment.interval_s = 300.0;
  const auto corrected = [&] { return VectorXd(Eigen::Map<VectorXd>(both.core->corrected, nominal().system.order())); };
  const auto correct = [&] {
    tt_observer_begin_correction(both.core.get(), &moment, &interval);
    int state = 0;
    while (state == 0) state = tt_observer_correction_slice(both.core.get());
    tt_observer_finish_correction(both.core.get(), &moment);
    tt_observer_set_corrected(both.core.get(), &moment);
    return state;
  };
  tt_observer_set_corrected(both.core.get(), &moment);
  const VectorXd before = corrected();
  const double good = matrix(1, 1);
  matrix(1, 1) = missing;
  EXPECT_EQ(correct(), 2);
  EXPECT_TRUE(corrected() == before);
  EXPECT_TRUE(tt_observer_due(both.core.get(), &moment)) << "the next one may come";
  matrix(1, 1) = good;
  EXPECT_EQ(correct(), 1);
  EXPECT_FALSE(corrected() == before);
  EXPECT_TRUE(corrected().allFinite());
}

}  // namespace
}  // namespace thermotwin::compensation
