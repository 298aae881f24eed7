// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The observer of the online core and the class that it restates, side by side on the same rows.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "compensation/online/compensator.h"
#include "compensation/online/observer.h"
#include "tests/compensation/control/day_of_work.h"
#include "tests/compensation/control/observer_parts.h"
#include "tests/compensation/control/unit_capacity.h"

namespace thermotwin::compensation::test {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

inline const reduction::ReducedModel& nominal() {
  static const reduction::ReducedModel model = unit_capacity(lumped_model());
  return model;
}

/// Class and core, each with a clock of the same class, on the same rows. Follows Compensator::Work.
class Beside {
public:
  explicit Beside(const CompensatorOptions& o = {})
      : options(o),
        operating(nominal().machine, nominal().system.layout),
        clock(nominal(), operating, o.step_s),
        own_clock(nominal(), operating, o.step_s),
        classic(nominal(), operating, options, clock),
        data(nominal(), options),
        core(tt_observer_lay, data.observer()),
        row(operating.channels().defaults()) {
    const VectorXd start = nominal().system.one_kelvin * (o.start_C - nominal().machine.reference_C);
    clock.set_state(start);
    own_clock.set_state(start);
    tt_observer_reset(core.get());
    EXPECT_EQ(data.sensors().drives, std::ssize(classic.errors().drives()));
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
    classic.take_out_inputs(given);
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
  test::ObserverParts data;
  test::InArena<tt_observer, tt_observer_model> core;
  VectorXd row;
  bool started = false;
  double largest = 0.0, worst = 0.0;  ///< K, of corrections; of the difference of states
  std::set<int> named;                ///< faults
  std::string failed;                 ///< by the class, last

private:
  int spindle() const { return operating.channels().index("spindle.speed_rpm"); }

  void start(double time) {
    const Day day(nominal(), row);
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
    EXPECT_LE(slices, tt_past_slices(core->past.model));
    double uniform_K = 0.0;
    if (tt_observer_uniform(core.get(), &uniform_K)) own_clock.set_state(nominal().system.one_kelvin * uniform_K);
    moment = now();
    VectorXd guide =
        Eigen::Map<const VectorXd>(tt_observer_guide(core.get(), &moment), own_clock.sensors_state().size());
    own_clock.start(time, row, guide);
    moment = now();
    tt_observer_begin_taking(core.get(), &moment);
    while (tt_observer_take_slice(core.get()) == 0) continue;
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
    EXPECT_LE(slices, tt_observer_correction_slices(&data.observer()));
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
    const int all = tt_errors_count(&data.sensors());
    for (int k = 0; k < all; ++k) own_sigma += core->errors.sigma[k + static_cast<long>(k) * all];
    ASSERT_NEAR(own_sigma, sigma, 1e-8 * sigma) << time;
  }
};

}  // namespace thermotwin::compensation::test
