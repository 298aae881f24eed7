// SPDX-License-Identifier: GPL-3.0-or-later
// The observer of the online core beside the class that it restates, over hours of a machine that is not nominal.
#include "compensation/control/observer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

#include "compensation/control/sensor_model.h"
#include "compensation/measurement/virtual_measurement.h"
#include "compensation/online/compensator.h"
#include "compensation/online/observer.h"
#include "core/missing.h"
#include "solver/campaign/simulation.h"
#include "tests/compensation/control/day_of_work.h"
#include "tests/compensation/control/reading_data.h"
#include "tests/compensation/control/unit_capacity.h"
#include "tests/compensation/records.h"
#include "tests/compensation/shift.h"

namespace thermotwin::compensation {
namespace {

using core::missing;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

const reduction::ReducedModel& nominal() {
  static const reduction::ReducedModel model = test::unit_capacity(test::lumped_model());
  return model;
}

/// The data of tt_observer_model.
class ObserverData {
public:
  ObserverData(const solver::OperatingModel& operating, const CompensatorOptions& options, int drives, int heats)
      : sensors_(nominal(), drives),
        readings_(nominal().machine, operating.channels()),
        offset_(solver::sensor_offsets(nominal().machine, nominal().system.layout)) {
    for (const mesh::AmbientSpec& ambient : nominal().machine.ambients)
      ambients_.push_back(operating.channels().index(ambient.id + ".T_C"));
    model_ = {&sensors_.data(),
              &readings_.model(),
              heats,
              static_cast<std::int32_t>(ambients_.size()),
              operating.channels().index("air.T_C"),
              ambients_.data(),
              offset_.data(),
              options.step_s,
              options.correction_s,
              options.start_from_sensors};
  }
  ObserverData(const ObserverData&) = delete;
  ObserverData& operator=(const ObserverData&) = delete;
  const tt_observer_model& model() const { return model_; }

private:
  SensorModel sensors_;
  test::ReadingData readings_;
  VectorXd offset_;
  std::vector<std::int32_t> ambients_;
  tt_observer_model model_{};
};

/// Class and core, each with a clock of the same class, on the same rows. Follows Compensator::Work.
class Beside {
public:
  explicit Beside(const CompensatorOptions& o = {})
      : options(o),
        operating(nominal().machine, nominal().system.layout),
        clock(nominal(), operating, o.step_s),
        own_clock(nominal(), operating, o.step_s),
        classic(nominal(), operating, options, clock),
        data(operating, options, static_cast<int>(classic.errors().drives().size()),
             static_cast<int>(test::Day(nominal()).heats().cols())),
        core(tt_observer_lay, data.model()),
        row(operating.channels().defaults()) {
    const VectorXd start = nominal().system.one_kelvin * (o.start_C - nominal().machine.reference_C);
    clock.set_state(start);
    own_clock.set_state(start);
    tt_observer_reset(core.get());
  }

  tt_moment now() const {
    return {own_clock.time(),
            own_clock.step_end(),
            own_clock.started_at(),
            own_clock.last_step(),
            own_clock.interval_s(),
            own_clock.state().data(),
            own_clock.change().data(),
            own_clock.sensors_state().data(),
            own_clock.sensors_change().data()};
  }

  void step(double time, VectorXd given, const VectorXd& sensors_C, const std::vector<char>& untold = {}) {
    VectorXd own_given = given;
    classic.take_out_inputs(given);
    tt_take_out_inputs(&core->trust.check, own_given.data());
    const VectorXd before = row;
    operating.channels().update(given, row);
    classic.read(sensors_C, row);
    tt_observer_read(core.get(), sensors_C.size() > 0 ? sensors_C.data() : nullptr, row.data());
    ASSERT_EQ(tt_observer_any_reading(core.get()) != 0, classic.any_reading());
    if (started) {
      add_drives(time, untold);
      advance(time, std::abs(row[spindle()] - before[spindle()]) > 0.2 * std::max(row[spindle()], before[spindle()]));
    } else {
      classic.start(time, row);
      start(time);
      started = true;
    }
    expect_equal(time);
  }

  void learn(const Eigen::Vector3d& error_m) {
    if (clock.interval_s() > 0.0) correct();
    ErrorModel::ErrorRows rows;
    rows.tool = nominal().outputs.tool[2].topRows(3);
    rows.table = -nominal().outputs.table_axis[0].topRows(3);
    classic.learn(rows, error_m, 0.6e-6);
    const MatrixXd tool = rows.tool.transpose(), table = rows.table.transpose();
    const VectorXd state = own_clock.state() + own_clock.share_ahead() * own_clock.change();
    const tt_moment moment = now();
    tt_observer_learn(core.get(), &moment, tool.data(), table.data(), state.data(), error_m.data(), 0.6e-6);
  }

  const CompensatorOptions options;
  solver::OperatingModel operating;
  StateClock clock, own_clock;
  Observer classic;
  ObserverData data;
  test::InArena<tt_observer, tt_observer_model> core;
  VectorXd row;
  bool started = false;
  double largest = 0.0, worst = 0.0;  ///< K, of corrections; of the difference of states
  std::set<int> named;                ///< faults
  std::string failed;                 ///< by the class, last

private:
  int spindle() const { return operating.channels().index("spindle.speed_rpm"); }

  void start(double time) {
    const test::Day day(nominal(), row);
    const MatrixXd heats = day.heats();
    tt_past_set_heats(&core->past, heats.data());
    for (const auto& [kind, at] :
         {std::pair{TT_MODES_COOLING, &day.off()}, {TT_MODES_STILL, &day.rest()}, {TT_MODES_SWEPT, &day.swept()}}) {
      const MatrixXd matrix = day.operator_at(*at);
      tt_past_begin_modes(&core->past, kind, matrix.data());
      while (tt_past_slice(&core->past) == 0) continue;
    }
    tt_moment moment = now();
    moment.time = time;
    tt_observer_begin_start(core.get(), &moment, row.data());
    int slices = 1;
    while (tt_observer_start_slice(core.get()) == 0) ++slices;
    EXPECT_LE(slices, tt_observer_start_slices(&data.model()));
    double uniform_K = 0.0;
    if (tt_observer_uniform(core.get(), &uniform_K)) own_clock.set_state(nominal().system.one_kelvin * uniform_K);
    moment = now();
    VectorXd guide =
        Eigen::Map<const VectorXd>(tt_observer_guide(core.get(), &moment), own_clock.sensors_state().size());
    own_clock.start(time, row, guide);
    moment = now();
    tt_observer_finish_start(core.get(), &moment);
    const MatrixXd matrix = own_clock.operator_at(own_clock.coefficients().p);
    tt_observer_begin_foresight(core.get(), matrix.data());
    while (tt_sensitivities_slice(&core->errors.sensitivities) == 0) continue;
    tt_observer_finish_foresight(core.get(), &moment);
  }

  void add_drives(double time, const std::vector<char>& untold) {
    std::vector<char> each = untold;
    each.resize(classic.errors().drives().size(), 0);
    const double duration = time - clock.time();
    classic.add_drives(each, row, duration);
    tt_observer_add_row(core.get(), duration);
    for (Index d = 0; d < std::ssize(each); ++d) {
      if (each[d] == 0) continue;
      const DriveHeat& drive = classic.errors().drives()[d];
      const VectorXd heat = heat_at_half_speed(nominal().system, operating, drive, row);
      tt_observer_add_drive(core.get(), static_cast<int>(d), duration, heat.data(),
                            std::abs(row[drive.channel]) / drive.half_speed);
    }
  }

  void close_step() {
    const StateClock::Step step = clock.take_step(), own_step = own_clock.take_step();
    for (int i = 0; i < step.parts; ++i) {
      correct_if_due();
      clock.advance(step.mean, classic.guide_readings(), step.part_s);
      const tt_moment moment = now();
      const VectorXd guide =
          Eigen::Map<const VectorXd>(tt_observer_guide(core.get(), &moment), clock.sensors_state().size());
      EXPECT_LT((guide - classic.guide_readings()).cwiseAbs().maxCoeff(), 1e3) << "not a number";
      own_clock.advance(own_step.mean, guide, own_step.part_s);
    }
    clock.end_step();
    own_clock.end_step();
    if (step.parts == 0) return;
    classic.show(step.duration);
    tt_observer_show(core.get(), step.duration);
    classic.set_corrected();
    const tt_moment moment = now();
    tt_observer_set_corrected(core.get(), &moment);
  }

  void correct_if_due() {
    const tt_moment moment = now();
    ASSERT_EQ(tt_observer_due(core.get(), &moment) != 0, classic.due());
    if (classic.due()) correct();
  }

  void correct() {
    classic.correct();
    tt_moment moment = now();
    const ErrorModel::Interval& interval = own_clock.take_interval();
    const tt_interval same = {interval.duration, interval.p.data(), interval.q.data(), interval.state.data(),
                              interval.operator_matrix.data()};
    tt_observer_begin_correction(core.get(), &moment, &same);
    int slices = 1;
    while (tt_observer_correction_slice(core.get()) == 0) ++slices;
    EXPECT_LE(slices, tt_observer_correction_slices(&data.model()));
    moment = now();
    tt_observer_finish_correction(core.get(), &moment);
  }

  void advance(double time, bool leapt) {
    if (clock.ends_before(time - clock.time())) {
      close_step();
      correct_if_due();
    }
    clock.add(row, time);
    own_clock.add(row, time);
    if (clock.full()) close_step();
    classic.add_readings(leapt);
    const tt_moment moment = now();
    tt_observer_add_readings(core.get(), &moment, leapt);
    if (clock.step_end() == clock.time()) correct_if_due();
  }

  void expect_equal(double time) {
    const VectorXd own = Eigen::Map<const VectorXd>(core->corrected, nominal().system.order());
    const VectorXd own_rate = Eigen::Map<const VectorXd>(core->correction_rate, nominal().system.order());
    const VectorXd& state = classic.corrected();
    // Coordinates of capacity 1: K times the root of the capacity of a lump.
    const double kelvin = nominal().system.one_kelvin.norm();
    worst = std::max(worst, (own - state).norm() / kelvin);
    largest = std::max(largest, (state - clock.state()).norm() / kelvin);
    ASSERT_LT((own - state).norm(), 1e-9 * kelvin * (1.0 + largest)) << time;
    ASSERT_LT((own_rate - classic.correction_rate()).norm(), 1e-11 * kelvin) << time;
    VectorXd predicted(core->trust.monitor.sensors);
    const tt_moment moment = now();
    tt_observer_predicted_C(core.get(), &moment, predicted.data());
    ASSERT_LT((predicted - classic.predicted_sensors_C().head(predicted.size())).cwiseAbs().maxCoeff(), 1e-8) << time;
    std::string text;
    for (Index s = 0; s < predicted.size(); ++s) {
      const int fault = core->trust.named[s];
      ASSERT_EQ(tt_trusted(&core->trust, static_cast<int>(s)) != 0, classic.trust().trusted(s)) << time << " " << s;
      if (fault == TT_SENSOR_FINE) continue;
      named.insert(fault);
      text += (text.empty() ? "" : " ") + nominal().machine.sensors[s].id + "=" + tt_sensor_fault_text(fault);
    }
    failed = classic.trust().failed_sensors();
    ASSERT_EQ(text, failed) << time;
    const double sigma = classic.errors().all_covariance().trace();
    double own_sigma = 0.0;
    const int all = tt_errors_count(data.model().sensors);
    for (int k = 0; k < all; ++k) own_sigma += core->errors.sigma[k + static_cast<long>(k) * all];
    ASSERT_NEAR(own_sigma, sigma, 1e-8 * sigma) << time;
  }
};

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

// A warm start, rows of a second, sensors that fail one after the other, and readings that nobody can believe.
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

}  // namespace
}  // namespace thermotwin::compensation
