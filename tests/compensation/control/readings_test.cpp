// SPDX-License-Identifier: GPL-3.0-or-later
// The checks of readings in the online core beside the classes that they restate: every decision is equal.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "compensation/control/drift_watch.h"
#include "compensation/control/reading_check.h"
#include "compensation/control/sensor_monitor.h"
#include "compensation/control/special.h"
#include "compensation/online/drift_watch.h"
#include "compensation/online/reading_check.h"
#include "compensation/online/sensor_monitor.h"
#include "core/missing.h"
#include "core/statistics.h"
#include "solver/operation/operating_model.h"
#include "tests/compensation/control/observer_parts.h"
#include "tests/compensation/control/unit_capacity.h"

namespace thermotwin::compensation {
namespace {

using core::missing;
using Eigen::Index;
using Eigen::VectorXd;

TEST(ControlSpecial, EqualsTheStandardLibrary) {
  for (const double x : {-30.0, -3.0, -0.5, -0.499, -1e-3, -1e-12, 1e-9, 0.3, 0.51, 4.0})
    EXPECT_NEAR(tt_expm1(x), std::expm1(x), 1e-15 * std::abs(std::expm1(x)) + 1e-300) << x;
  for (const double x : {0.0, 1e-9, 0.1, 1.0, 1.499, 1.5, 2.0, 2.7, 5.0, 12.0, 25.0})
    EXPECT_NEAR(tt_erfc(x), std::erfc(x), 1e-13 * std::erfc(x)) << x;
  const std::vector<double> values = {3.0, 1.0, 2.0, 2.0, -5.0, 9.0};
  for (int n = 0; n < 6; ++n) EXPECT_EQ(tt_nth_smallest(6, values.data(), n), core::nth_smallest(values, n));
  EXPECT_EQ(tt_median(6, values.data()), core::median(values));
  EXPECT_EQ(tt_median(5, values.data()), 2.0);
  EXPECT_TRUE(std::isnan(tt_nth_smallest(0, values.data(), 0)));
}

int code(ReadingFault fault) { return static_cast<int>(fault); }
int code(SensorFault fault) {
  return fault == SensorFault::none ? TT_SENSOR_FINE : TT_SENSOR_ABSENT + static_cast<int>(fault) - 1;
}

TEST(ControlReadings, FaultsHaveTheNamesOfTheClasses) {
  for (const ReadingFault fault :
       {ReadingFault::none, ReadingFault::implausible, ReadingFault::kelvin, ReadingFault::fahrenheit})
    EXPECT_STREQ(tt_sensor_fault_text(code(fault)), fault_text(fault));
  for (const SensorFault fault : {SensorFault::absent, SensorFault::stuck, SensorFault::offset, SensorFault::noise})
    EXPECT_STREQ(tt_sensor_fault_text(code(fault)), fault_text(fault));
  EXPECT_STREQ(tt_sensor_fault_text(TT_SENSOR_DRIFT), "drift");
  EXPECT_STREQ(tt_sensor_fault_text(99), "");
}

TEST(ControlReadings, TakesOutWhatTheClassTakesOut) {
  const reduction::ReducedModel model = test::unit_capacity(test::lumped_model());
  const mesh::Machine& machine = model.machine;
  const solver::OperatingModel operating(machine, model.system.layout);
  const test::ObserverParts parts(model);
  const solver::Channels& channels = operating.channels();
  const auto sensors = std::ssize(machine.sensors);
  std::srand(1);
  int found = 0;
  for (int run = 0; run < 40; ++run) {
    ReadingCheck classic(machine, channels);
    test::InArena<tt_reading_check, tt_reading_model> core(tt_reading_check_lay, parts.readings());
    for (int i = 0; i < 30; ++i) {
      VectorXd given = channels.defaults(), readings = 25.0 + 5.0 * VectorXd::Random(sensors).array();
      for (Index k = 0; k < given.size(); ++k) {
        if (!channels.names()[k].ends_with("T_C")) continue;
        const int kind = std::rand() % 6;
        if (kind == 0) given[k] = missing;
        if (kind == 1) given[k] = 295.0;
        if (kind == 2) given[k] = 70.0;  // degF of a hall
        if (kind == 3) given[k] = -400.0;
      }
      VectorXd row = channels.defaults();
      channels.update(given, row);
      const int way = run % 4;  // all in degF at first; one in kelvin; one missing; as they are
      if (way == 0 && i < 20) readings = readings * 1.8 + VectorXd::Constant(sensors, 32.0);
      if (way == 1) readings[run % sensors] += 273.15;
      if (way == 2) readings[run % sensors] = i % 2 == 0 ? missing : 900.0;
      VectorXd own = readings;
      classic.take_out_sensors(readings, row);
      tt_take_out_sensors(core.get(), own.data(), row.data());
      for (Index s = 0; s < sensors; ++s) {
        ASSERT_EQ(core->sensor_fault[s], code(classic.sensor(s))) << run << " " << i;
        ASSERT_EQ(core->fahrenheit_like[s] != 0, classic.looks_fahrenheit(s));
        ASSERT_TRUE(readings[s] == own[s] || (std::isnan(readings[s]) && std::isnan(own[s])));
        found += core->sensor_fault[s] != TT_SENSOR_FINE;
      }
      ASSERT_EQ(tt_any_sensor_out(core.get()) != 0, classic.any_sensor());
    }
  }
  EXPECT_GT(found, 100);
}

struct Monitored {
  int sensors;
  const double* std;
};
void lay(tt_monitor* monitor, const Monitored* model, tt_arena* arena) {
  tt_monitor_lay(monitor, model->sensors, model->std, arena);
}

// Sensors that stand still, leap, scatter, fall silent, read coarsely or are off from the start, at several intervals.
TEST(ControlReadings, MonitorNamesWhatTheClassNames) {
  constexpr int sensors = 8;
  const VectorXd std = VectorXd::LinSpaced(sensors, 0.01, 0.12);
  std::vector<int> seen(TT_SENSOR_DRIFT + 1, 0);
  for (const double step : {0.5, 10.0, 60.0, 400.0}) {
    std::srand(static_cast<unsigned>(step) + 3);
    SensorMonitor classic(std);
    const Monitored model{sensors, std.data()};
    test::InArena<tt_monitor, Monitored> core(lay, model);
    tt_monitor_start(core.get());
    std::vector<char> explained(sensors, 0);
    explained[7] = core->watched[7].explained = 1;
    classic.explain_first(explained);
    VectorXd expected = VectorXd::Constant(sensors, 0.0), reading(sensors), kept = reading;
    const int rows = step < 1.0 ? 8000 : 3000;
    for (int i = 0; i < rows; ++i) {
      const double time = i * step, work = std::sin(time / 9000.0);
      for (int s = 0; s < sensors; ++s) expected[s] = 6.0 * (0.3 + 0.1 * s) * work * work;
      reading = expected * 1.05 + std.cwiseProduct(VectorXd::Random(sensors));
      const double share = i / static_cast<double>(rows);
      if (share > 0.3 && share < 0.7) reading[0] = kept[0];
      if (share > 0.2 && share < 0.5) reading[1] += 3.0;
      if (share > 0.4 && share < 0.6) reading[2] += 40.0 * std[2] * VectorXd::Random(1)[0];
      if (share > 0.5 && share < 0.8) reading[3] = missing;
      reading[4] = std::round(reading[4] * 2.0) / 2.0;
      reading[5] += share < 0.6 ? 9.0 : 0.0;
      if (i % 97 == 0) reading[6] += 2.0;
      reading[7] += 9.0;
      kept = reading;
      const bool leapt = i % 211 == 0;
      const VectorXd unsure = VectorXd::Constant(sensors, i < 50 ? 1e-4 : 1e-6);
      const bool changed = classic.judge(time, reading, expected, leapt, unsure);
      ASSERT_EQ(tt_monitor_judge(core.get(), time, reading.data(), expected.data(), leapt, unsure.data()) != 0,
                changed);
      for (int s = 0; s < sensors; ++s) {
        ASSERT_EQ(core->watched[s].fault, code(classic.fault(s))) << step << " " << i << " " << s;
        ASSERT_EQ(core->watched[s].trusted != 0, classic.trusted(s)) << step << " " << i << " " << s;
        ++seen[core->watched[s].fault];
      }
      if (i % 30 != 29) continue;
      const VectorXd change = 0.02 * VectorXd::Random(sensors);
      classic.correct(change);
      tt_monitor_correct(core.get(), change.data());
    }
  }
  for (const int fault : {TT_SENSOR_FINE, TT_SENSOR_ABSENT, TT_SENSOR_STUCK, TT_SENSOR_OFFSET, TT_SENSOR_NOISE})
    EXPECT_GT(seen[fault], 100) << fault;
}

void lay_drift(tt_drift_watch* watch, const Monitored* model, tt_arena* arena) {
  tt_drift_lay(watch, model->sensors, model->std, arena);
}

TEST(ControlReadings, DriftWatchFindsWhatTheClassFinds) {
  constexpr int sensors = 6;
  const VectorXd std = VectorXd::LinSpaced(sensors, 0.02, 0.1);
  int drifts = 0;
  for (const double step : {250.0, 700.0, 5000.0}) {
    std::srand(5);
    DriftWatch classic(std);
    const Monitored model{sensors, std.data()};
    test::InArena<tt_drift_watch, Monitored> core(lay_drift, model);
    tt_drift_start(core.get());
    for (double time = 0.0; time < 5 * 86400.0; time += step) {
      VectorXd value = 0.01 * VectorXd::Random(sensors), deviation = VectorXd::Constant(sensors, 0.05);
      value[1] += 0.1 * time / 3600.0;
      value[2] -= time > 86400.0 ? 0.05 * (time - 86400.0) / 3600.0 : 0.0;
      value[3] += 2.0 * (1.0 - std::exp(-time / 20000.0));
      value[4] += 3.0 * std::sin(time / 13000.0);
      if (std::fmod(time, 30000.0) < 4000.0) value[1] = missing;
      deviation[5] = std::numeric_limits<double>::infinity();
      const Index found = classic.judge(time, value, deviation);
      ASSERT_EQ(tt_drift_judge(core.get(), time, value.data(), deviation.data()), found) << time;
      for (int s = 0; s < sensors; ++s) ASSERT_EQ(core->drifts[s] != 0, classic.drifts(s)) << time << " " << s;
    }
    for (int s = 0; s < sensors; ++s) drifts += core->drifts[s];
  }
  EXPECT_GE(drifts, 4);
}

}  // namespace
}  // namespace thermotwin::compensation
