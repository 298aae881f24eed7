// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/twin.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "compensation/online/compensator.h"
#include "tests/compensation/control/twin_of_lumps.h"
#include "tests/compensation/shift.h"

namespace thermotwin::compensation {
namespace {

using Eigen::VectorXd;
using test::Twin;

const reduction::ReducedModel& lumps() {
  static const reduction::ReducedModel model = test::lumps_with_lines();
  return model;
}

const tt_model& core() {
  static const ControlModel model(lumps());
  return model.model();
}

CompensatorOptions open_loop() {
  CompensatorOptions options;
  options.use_sensors = false;
  return options;
}

VectorXd work_row(const solver::Channels& channels, double time) {
  return test::working_row(lumps().machine, channels, test::shift_row(channels, std::max(1.0, time)), time);
}

struct Difference {
  double worst = 0, largest = 0;
  int other_status = 0;
};

/// Both along the same rows, so many seconds apart.
Difference compared(const std::function<double(double)>& next, double end) {
  Compensator compensator(lumps(), open_loop());
  Twin twin(core());
  Difference difference;
  for (double time = 0.0; time <= end; time = next(time)) {
    const VectorXd row = work_row(compensator.channels(), time);
    const Offsets& expected = compensator.step(time, row, {});
    const int status = twin.row(time, row);
    difference.other_status += std::string(tt_status_text(status)) != status_text(expected.status);
    difference.worst = std::max(difference.worst, (twin.offset_um() - expected.offset_um).cwiseAbs().maxCoeff());
    difference.largest = std::max(difference.largest, expected.offset_um.cwiseAbs().maxCoeff());
  }
  return difference;
}

TEST(ControlTwin, RowsAMinuteApartGiveTheOffsetsOfTheCompensator) {
  const Difference d = compared([](double time) { return time + 60.0; }, 10 * 3600.0);
  EXPECT_LT(d.worst, 1e-3);
  EXPECT_GT(d.largest, 10.0);
  EXPECT_EQ(d.other_status, 0);
}

TEST(ControlTwin, LongAndUnevenRowsGiveThemToo) {
  test::Uniform number(4);
  const Difference d = compared([&](double time) { return time + number(30.0, 1500.0); }, 20 * 3600.0);
  EXPECT_LT(d.worst, 1e-3);
  EXPECT_GT(d.largest, 10.0);
  EXPECT_EQ(d.other_status, 0);
}

/// Offsets follow up to half a step later, so they differ by a share of what a minute changes at most.
TEST(ControlTwin, QuickRowsFollowWithinTheDelayOfAStep) {
  Compensator compensator(lumps(), open_loop());
  Twin twin(core());
  std::vector<VectorXd> expected;
  double worst = 0.0, minute = 0.0, squares = 0.0, largest = 0.0;
  for (int i = 0; i < 8 * 3600; ++i) {
    const double time = 0.5 * i;
    const VectorXd row = test::shift_row(compensator.channels(), std::max(0.5, time));
    expected.push_back(compensator.step(time, row, {}).offset_um);
    twin.row(time, row);
    if (i < 600) continue;  // the guard, and the first steps, whose rate nothing tells
    const double off = (twin.offset_um() - expected[i]).cwiseAbs().maxCoeff();
    worst = std::max(worst, off);
    squares += off * off;
    minute = std::max(minute, (expected[i] - expected[i - 120]).cwiseAbs().maxCoeff());
    largest = std::max(largest, expected[i].cwiseAbs().maxCoeff());
  }
  EXPECT_LT(worst, 0.6 * minute);
  EXPECT_LT(std::sqrt(squares / (8 * 3600)), 0.02 * minute);
  EXPECT_GT(largest, 10.0);
}

TEST(ControlTwin, AStepTakesEffectWithinHalfAStepOfMachineTime) {
  const solver::OperatingModel operating(lumps().machine, lumps().system.layout);
  Twin twin(core());
  double effect = 0.0;
  for (int i = 0; i < 1000 && effect == 0.0; ++i) {
    twin.row(0.1 * i, work_row(operating.channels(), 3600.0));
    if (twin.get().now->last_step > 0.0) effect = 0.1 * i;
    if (effect == 0.0 && 0.1 * i > 60.05) {
      EXPECT_TRUE(twin.get().now->job);
    }
  }
  EXPECT_GT(effect, 60.0);
  EXPECT_LE(effect, 90.0 + 1e-9);
}

/// Rows of 3 s do one of the 8 slices of this small model each. Offsets go on while a job runs.
TEST(ControlTwin, AStepIsSharedByRowsOfEqualLength) {
  const solver::OperatingModel operating(lumps().machine, lumps().system.layout);
  const VectorXd row = test::shift_row(operating.channels(), 3600.0);
  Twin twin(core());
  ASSERT_EQ(tt_slices(&twin.get().work), 8);
  std::vector<double> offsets;
  std::vector<bool> in_a_job;
  double effect = 0.0;
  for (int i = 0; i < 3600; ++i) {
    twin.row(3.0 * i, row);
    if (effect == 0.0 && twin.get().now->last_step > 0.0) effect = 3.0 * i;
    offsets.push_back(twin.offset_um()[2]);
    in_a_job.push_back(twin.get().now->job == TT_JOB_STEP);
  }
  EXPECT_EQ(effect, 81.0);
  for (int i = 1200; i < 3580; ++i) {
    if (!in_a_job[i]) continue;
    const double mean = (offsets[i + 20] - offsets[i - 20]) / 40.0;
    ASSERT_GT((offsets[i] - offsets[i - 1]) / mean, 0.7) << i;
  }
}

TEST(ControlTwin, ASavedStateGoesOnWithTheSameBits) {
  const solver::OperatingModel operating(lumps().machine, lumps().system.layout);
  test::Uniform number(5);
  Twin twin(core());
  double time = 0.0;
  int in_a_job = 0, loads = 0;
  for (int i = 0; i < 4000; ++i) {
    time += i % 400 < 300 ? 0.25 : number(0.5, 90.0);
    twin.row(time, work_row(operating.channels(), time));
    if (number(0.0, 1.0) > 0.02) continue;
    ++loads;
    in_a_job += twin.get().now->job != 0;
    Twin other(core());
    other.row(3.0, operating.channels().defaults());
    ASSERT_EQ(other.load(twin.saved()), TT_LOADED);
    Twin beside(core());
    ASSERT_EQ(beside.load(twin.saved()), TT_LOADED);
    for (int k = 1; k <= 150; ++k) {
      const double then = time + (k % 50 < 40 ? 0.5 : 20.0) * k;
      const VectorXd row = work_row(operating.channels(), then);
      other.row(then, row);
      beside.row(then, row);
    }
    ASSERT_EQ(other.saved(), beside.saved());
    // The twin itself, which has its factor still.
    if (loads % 4 != 0) continue;
    Twin loaded(core());
    ASSERT_EQ(loaded.load(twin.saved()), TT_LOADED);
    for (int k = 1; k <= 40; ++k) {
      time += k % 8 == 0 ? 35.0 : 0.5;
      const VectorXd row = work_row(operating.channels(), time);
      twin.row(time, row);
      loaded.row(time, row);
      ASSERT_EQ(twin.saved(), loaded.saved()) << k;
    }
  }
  EXPECT_GT(loads, 30);
  EXPECT_GT(in_a_job, 3);
}

TEST(ControlTwin, AStateThatIsNotItsOwnIsRefused) {
  const solver::OperatingModel operating(lumps().machine, lumps().system.layout);
  Twin twin(core());
  twin.row(0.0, operating.channels().defaults());
  const std::vector<unsigned char> good = twin.saved();
  ControlOptions options;
  options.compensator.step_s = 30.0;
  const ControlModel another(lumps(), options);
  Twin other(another.model());
  EXPECT_EQ(other.load(good), TT_OTHER_MODEL);
  for (const std::size_t bytes : {std::size_t{0}, std::size_t{7}, good.size() / 2, good.size() - 1}) {
    std::vector<unsigned char> part(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(bytes));
    EXPECT_EQ(twin.load(part), bytes < 40 ? TT_NO_STATE : TT_DAMAGED) << bytes;
  }
  std::vector<unsigned char> bad = good;
  bad[good.size() / 2] ^= 4;
  EXPECT_EQ(twin.load(bad), TT_DAMAGED);
  bad = good;
  bad[0] = 'x';
  EXPECT_EQ(twin.load(bad), TT_NO_STATE);
  bad = good;
  bad[8] ^= 1;
  EXPECT_EQ(twin.load(bad), TT_OTHER_VERSION);
  EXPECT_EQ(twin.saved(), good) << "a refused state changes nothing";
}

TEST(ControlTwin, ImpossibleValuesAreNamedAndChangeNothing) {
  const solver::OperatingModel operating(lumps().machine, lumps().system.layout);
  const solver::Channels& channels = operating.channels();
  const auto at = [&](const char* name) { return channels.index(name); };
  Twin twin(core()), calm(core());
  VectorXd row = channels.defaults();
  row[at("spindle.speed_rpm")] = 6000.0;
  twin.row(0.0, row);
  calm.row(0.0, row);
  const double infinity = std::numeric_limits<double>::infinity();
  const struct {
    const char* name;
    double value;
    int fault;
  } wrong[] = {{"spindle.speed_rpm", 1e300, TT_FAULT_UNREADABLE}, {"spindle.speed_rpm", -infinity, TT_FAULT_UNREADABLE},
               {"spindle.speed_rpm", 12200.0, TT_FAULT_BEYOND},   {"axis.X.position_mm", 450.0, TT_FAULT_BEYOND},
               {"cutting_fluid.on", 1.5, TT_FAULT_UNREADABLE},    {"air.T_C", 293.15, TT_FAULT_KELVIN},
               {"air.T_C", 1000.0, TT_FAULT_IMPLAUSIBLE},         {"air.T_C", 68.0, TT_FAULT_FAHRENHEIT}};
  double time = 0.0;
  for (const auto& one : wrong) {
    time += 10.0;
    VectorXd bad = row;
    bad[at(one.name)] = one.value;
    EXPECT_EQ(twin.row(time, bad), TT_INPUT_MISSING) << one.name;
    EXPECT_EQ(twin.get().fault[at(one.name)], one.fault) << one.name << " " << one.value;
    EXPECT_EQ(calm.row(time, row), TT_NO_SENSORS);
    EXPECT_EQ((twin.offset_um() - calm.offset_um()).norm(), 0.0) << "the last value holds";
  }
  EXPECT_EQ(twin.row(time + 10.0, row), TT_NO_SENSORS);
  row[at("axis.X.position_mm")] = 402.0;
  EXPECT_EQ(twin.row(time + 20.0, row), TT_OUTSIDE_WORKSPACE);
}

TEST(ControlTwin, ARowAtAnImpossibleTimeIsRefusedAndChangesNothing) {
  const solver::OperatingModel operating(lumps().machine, lumps().system.layout);
  const VectorXd row = operating.channels().defaults();
  Twin twin(core());
  EXPECT_EQ(twin.row(std::nan(""), row), TT_REFUSED_TIME);
  EXPECT_EQ(twin.row(100.0, row), TT_NO_SENSORS);
  const std::vector<unsigned char> before = twin.saved();
  for (const double time : {100.0, 99.0, -1e9, 100.0 + 40 * 86400.0, std::nan("")})
    EXPECT_EQ(twin.row(time, row), TT_REFUSED_TIME) << time;
  EXPECT_EQ(twin.saved(), before);
  EXPECT_EQ(twin.row(101.0, row), TT_NO_SENSORS);
}

TEST(ControlTwin, AChannelThatIsNoLongerNewsIsMissing) {
  const solver::OperatingModel operating(lumps().machine, lumps().system.layout);
  VectorXd row = operating.channels().defaults();
  Twin twin(core());
  twin.row(0.0, row);
  row[operating.channels().index("air.T_C")] = solver::not_given;
  EXPECT_EQ(twin.row(300.0, row), TT_NO_SENSORS);
  EXPECT_EQ(twin.row(301.0, row), TT_INPUT_MISSING);
}

/// A model that gives no number: the guard holds, then returns to 0 at its rate.
TEST(ControlTwin, OffsetsOfAFailedModelAreHeldAndReturn) {
  ControlData data = control_data(lumps());
  data.rate_um_s = 0.5;
  data.hold_s = 200.0;
  const ControlModel model(data);
  const solver::OperatingModel operating(lumps().machine, lumps().system.layout);
  Twin twin(model.model());
  double time = 0.0;
  for (; time < 4 * 3600.0; time += 60.0) twin.row(time, work_row(operating.channels(), 3600.0));
  const VectorXd held = twin.offset_um();
  ASSERT_GT(held.norm(), 5.0);
  twin.get().state[0] = std::nan("");
  for (int i = 0; i < 3; ++i, time += 60.0) {
    EXPECT_EQ(twin.row(time, work_row(operating.channels(), 3600.0)), TT_FAILED);
    EXPECT_EQ((twin.offset_um() - held).norm(), 0.0);
    EXPECT_EQ(twin.get().now->guard, TT_HOLDING_STILL);
  }
  EXPECT_EQ(twin.row(time, work_row(operating.channels(), 3600.0)), TT_FAILED);
  EXPECT_EQ(twin.get().now->guard, TT_RETURNING);
  for (double more = 1.0; more < 200.0; more += 1.0) {
    const VectorXd before = twin.offset_um();
    twin.row(time + more, work_row(operating.channels(), 3600.0));
    ASSERT_LE((twin.offset_um() - before).cwiseAbs().maxCoeff(), 0.5 + 1e-12);
  }
  EXPECT_EQ(twin.offset_um().norm(), 0.0);
}

}  // namespace
}  // namespace thermotwin::compensation
