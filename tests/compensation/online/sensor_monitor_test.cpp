// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/sensor_monitor.h"

#include <fmt/format.h>

#include <functional>
#include <limits>

#include "compensation/measurement/virtual_measurement.h"
#include "compensation/online/compensator.h"
#include "core/missing.h"
#include "mesh/machine/kinematics.h"
#include "tests/compensation/records.h"
#include "tests/compensation/scratch.h"
#include "tests/compensation/shift.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using core::missing;

constexpr double sigma = 0.05;
constexpr Index sensors = 5;

/// Ten hours of a machine that warms and cools, expected by a model that errs by a tenth.
struct Day {
  double step;
  std::vector<double> time;
  std::vector<VectorXd> truth, expected;
  explicit Day(double step_s) : step(step_s) {
    double warm = 0.0;
    for (double t = 0.0; t < 36000.0; t += step) {
      const double wanted = std::fmod(t, 18000.0) < 10800.0 ? 12.0 : 0.0;
      warm += (wanted - warm) * (1.0 - std::exp(-step / 3600.0));
      VectorXd at(sensors);
      for (Index s = 0; s < sensors; ++s) at[s] = 20.0 + warm * (0.2 + 0.2 * s);
      time.push_back(t);
      truth.push_back(at);
      expected.push_back(20.0 + 0.9 * (at.array() - 20.0));
    }
  }
};

struct Fault {
  SensorFault name;
  std::function<double(double reading, double before, double noise)> reading;  ///< before: at the fault's start
};
const std::vector<Fault>& faults() {
  static const std::vector<Fault> all = {
      {SensorFault::stuck, [](double, double before, double) { return before; }},
      {SensorFault::offset, [](double reading, double, double) { return reading + 2.0; }},
      {SensorFault::offset, [](double reading, double, double) { return reading - 2.0; }},
      {SensorFault::noise, [](double reading, double, double noise) { return reading + 9.0 * noise; }},
      {SensorFault::absent, [](double, double, double) { return missing; }},
  };
  return all;
}

bool all_healthy(const SensorMonitor& monitor) {
  for (Index s = 0; s < sensors; ++s)
    if (monitor.fault(s) != SensorFault::none) return false;
  return true;
}

// Named within 15 minutes after the true reading has moved by 5 sigma, at rows 1 s to 5 min apart.
TEST(SensorMonitor, NamesEachFaultInTime) {
  for (const double step : {1.0, 10.0, 60.0, 300.0}) {
    const Day day(step);
    for (std::size_t f = 0; f < faults().size(); ++f) {
      for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        test::Uniform uniform(100 * seed + f);
        SensorMonitor monitor(VectorXd::Constant(sensors, sigma));
        const Index failing = seed % sensors;
        const double from = 5000.0 + 3000.0 * seed;
        double stuck_at = missing, true_at = 0.0, moved_at = -1.0, named_at = -1.0;
        for (std::size_t i = 0; i < day.time.size() && named_at < 0.0; ++i) {
          VectorXd reading = day.truth[i];
          VectorXd noise(sensors);
          for (double& n : noise) n = sigma * uniform.normal();
          reading += noise;
          if (day.time[i] >= from) {
            if (std::isnan(stuck_at)) {
              stuck_at = reading[failing];
              true_at = day.truth[i][failing];
            }
            if (moved_at < 0.0 && std::abs(day.truth[i][failing] - true_at) > 5 * sigma) moved_at = day.time[i];
            reading[failing] = faults()[f].reading(reading[failing], stuck_at, noise[failing]);
          }
          monitor.judge(day.time[i], reading, day.expected[i]);
          for (Index s = 0; s < sensors; ++s) {
            if (s != failing || day.time[i] < from) {
              ASSERT_EQ(monitor.fault(s), SensorFault::none)
                  << "false alarm, step " << step << " fault " << f << " at " << day.time[i];
            }
          }
          if (monitor.fault(failing) == faults()[f].name) named_at = day.time[i];
        }
        ASSERT_GE(named_at, 0.0) << fault_text(faults()[f].name) << " never named, step " << step << " seed " << seed;
        if (moved_at >= 0.0) {
          EXPECT_LE(named_at, moved_at + 900.0) << fault_text(faults()[f].name) << " step " << step << " seed " << seed;
        }
      }
    }
  }
}

// The observer's expectation may follow a stuck sensor: its lost scatter names it all the same.
TEST(SensorMonitor, AReadingThatNoLongerScattersIsStuck) {
  test::Uniform uniform(3);
  for (const double digits : {0.0, 0.01, 0.1}) {
    SensorMonitor monitor(VectorXd::Constant(1, 0.05));
    double held = 0.0, named_at = -1.0;
    for (int i = 0; i < 600; ++i) {
      const double time = 60.0 * i, truth = 21.0 + 0.3 * std::sin(time / 4000.0);
      double reading = truth + 0.05 * uniform.normal();
      if (digits > 0.0) reading = digits * std::round(reading / digits);
      if (i == 300) held = reading;
      if (i >= 300) reading = held;
      monitor.judge(time, VectorXd::Constant(1, reading), VectorXd::Constant(1, i < 300 ? truth : held));
      if (i < 300) {
        ASSERT_EQ(monitor.fault(0), SensorFault::none) << digits;
      }
      if (named_at < 0.0 && monitor.fault(0) == SensorFault::stuck) named_at = time - 18000.0;
    }
    if (digits < 0.05) {
      EXPECT_GE(named_at, 300.0) << digits;
      EXPECT_LE(named_at, 900.0) << digits;
    } else {
      EXPECT_LT(named_at, 0.0) << "readings of coarse digits repeat anyway";
    }
  }
}

// Readings of a simulation: they move while the machine warms up, and repeat to all digits once it stands.
TEST(SensorMonitor, ReadingsWithoutScatterMayRepeat) {
  for (const double row_s : {60.0, 300.0}) {
    SensorMonitor monitor(VectorXd::Constant(1, 0.05));
    for (int i = 0; i < 800; ++i) {
      const double warm = std::min(0.02 * i, 3.0);  // hall air that rises, then a coolant that holds
      monitor.judge(row_s * i, VectorXd::Constant(1, 20.0 + warm), VectorXd::Constant(1, 20.02 + 0.99 * warm));
      ASSERT_EQ(monitor.fault(0), SensorFault::none) << row_s << " s, row " << i;
    }
  }
}

// Beside quick rows: the observer learns while coarse digits repeat, and what it expects follows a step of an input up
// to a minute and a half late, then at once.
TEST(SensorMonitor, ExpectedReadingsThatLearnOrFollowLateBlameNoSensor) {
  const auto warm = [](double t) { return t > 1800.0 ? 12.0 * (1.0 - std::exp((1800.0 - t) / 400.0)) : 0.0; };
  test::Uniform random(11);
  for (const double digits : {0.1, 0.01}) {
    for (const double row_s : {0.1, 1.0, 10.0}) {
      SensorMonitor monitor(VectorXd::Constant(1, sigma));
      double learnt = 0.0, next = 300.0;
      for (double t = 0.0; t < 7200.0; t += row_s) {
        const double truth = 20.0 + warm(t), model = 20.0 + 0.9 * warm(60.0 * std::floor((t - 30.0) / 60.0));
        if (t >= next) {
          const double change = 0.5 * (truth - model - learnt);
          monitor.correct(VectorXd::Constant(1, change));
          learnt += change;
          next += 300.0;
        }
        const double reading = digits * std::round((truth + 0.02 * random.normal()) / digits);
        monitor.judge(t, VectorXd::Constant(1, reading), VectorXd::Constant(1, model + learnt));
        ASSERT_EQ(monitor.fault(0), SensorFault::none) << digits << " K, rows of " << row_s << " s, at " << t;
      }
    }
  }
}

// Readings of coarse digits repeat in quick rows; that is no sign that one is stuck still.
// A sensor beside a fast spindle, in rows of 10 s: the reading runs ahead of what is expected for 100 s. The same
// course without a change of the inputs is a fault.
TEST(SensorMonitor, AReadingThatRunsAheadBehindAJumpOfAnInputIsNoFault) {
  for (const bool inputs_leapt : {true, false}) {
    SensorMonitor monitor(VectorXd::Constant(1, 0.03));
    const auto warm = [](double t) { return 25.0 * (1.0 - std::exp(-std::max(t, 0.0) / 180.0)); };
    double named_at = -1.0;
    for (double t = -600.0; t <= 3600.0; t += 10.0) {
      const VectorXd reading = VectorXd::Constant(1, warm(t)),
                     expected = VectorXd::Constant(1, t < 100.0 ? 0.0 : warm(t));
      monitor.judge(t, reading, expected, inputs_leapt && t == 0.0);
      if (named_at < 0.0 && monitor.fault(0) != SensorFault::none) named_at = t;
    }
    if (inputs_leapt) {
      EXPECT_EQ(named_at, -1.0);
    } else {
      EXPECT_GT(named_at, 0.0);
      EXPECT_LE(named_at, 100.0);
    }
  }
}

TEST(SensorMonitor, AStuckSensorThatMovesAgainComesBack) {
  for (const double row_s : {1.0, 60.0}) {
    SensorMonitor monitor(VectorXd::Constant(1, sigma));
    double held = 0.0;
    for (double t = 0.0; t <= 6000.0; t += row_s) {
      const double truth = 20.0 + 3.0 * std::sin(t / 1200.0);
      double reading = 0.1 * std::round(truth / 0.1);
      if (t <= 1200.0) held = reading;
      if (t > 1200.0 && t < 3000.0) reading = held;
      monitor.judge(t, VectorXd::Constant(1, reading), VectorXd::Constant(1, truth));
      if (t < 1200.0) {
        ASSERT_EQ(monitor.fault(0), SensorFault::none) << row_s << " s, at " << t;
      } else if (t > 2400.0 && t < 4700.0) {
        ASSERT_EQ(monitor.fault(0), SensorFault::stuck) << row_s << " s, at " << t;
      }
    }
    EXPECT_EQ(monitor.fault(0), SensorFault::none) << "half an hour after it moved, rows of " << row_s << " s";
  }
}

// Beside a spindle that starts and stops a tenth of what moves is more than the sensor is off by.
TEST(SensorMonitor, ASensorThatIsOffStaysNamedWhileMuchMoves) {
  SensorMonitor monitor(VectorXd::Constant(1, sigma));
  test::Uniform random(7);
  double truth = 20.0;
  for (double t = 0.0; t < 8 * 3600.0; t += 60.0) {
    truth += ((std::fmod(t, 2400.0) < 1200.0 ? 80.0 : 20.0) - truth) * (1.0 - std::exp(-60.0 / 300.0));
    const double off = t < 3600.0 ? 0.0 : 2.0;
    monitor.judge(t, VectorXd::Constant(1, truth + off + sigma * random.normal()), VectorXd::Constant(1, truth));
    if (t < 3600.0) {
      EXPECT_EQ(monitor.fault(0), SensorFault::none) << t;
    } else if (t > 3720.0) {
      ASSERT_EQ(monitor.fault(0), SensorFault::offset) << t;
    }
    if (t >= 3600.0) {
      ASSERT_FALSE(monitor.trusted(0)) << t;
    }
  }
}

TEST(SensorMonitor, AHealthySensorIsNeverNamedAndASensorComesBack) {
  for (const double step : {1.0, 60.0, 300.0}) {
    const Day day(step);
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      test::Uniform uniform(seed);
      SensorMonitor monitor(VectorXd::Constant(sensors, sigma));
      for (std::size_t i = 0; i < day.time.size(); ++i) {
        VectorXd reading = day.truth[i];
        for (double& value : reading) value += sigma * uniform.normal();
        monitor.judge(day.time[i], reading, day.expected[i]);
        ASSERT_TRUE(all_healthy(monitor)) << "step " << step << " seed " << seed << " at " << day.time[i];
      }
    }
  }
  const Day day(60.0);
  test::Uniform uniform(4);
  SensorMonitor monitor(VectorXd::Constant(sensors, sigma));
  for (std::size_t i = 0; i < day.time.size(); ++i) {
    VectorXd reading = day.truth[i];
    for (double& value : reading) value += sigma * uniform.normal();
    const bool off = day.time[i] > 4000.0 && day.time[i] < 8000.0;
    if (off) reading[2] += 2.0;
    monitor.judge(day.time[i], reading, day.expected[i]);
    if (off && day.time[i] > 4100.0) {
      ASSERT_EQ(monitor.fault(2), SensorFault::offset);
      ASSERT_FALSE(monitor.trusted(2)) << "withheld at once";
    }
  }
  EXPECT_TRUE(all_healthy(monitor));
}

/// What a failed sensor costs the whole compensator.
class FailedSensor : public testing::Test {
protected:
  FailedSensor() : model_(test::lumped_model()) {
    for (const char* text : {"", "X=-250,Y=100,Z=400", "X=300,Y=-200,Z=50,B=45,C=90"})
      poses_.push_back(mesh::parse_pose(model_.machine, text, "test"));
  }

  test::Truth machine(std::uint64_t seed) const {
    return test::run_truth(perturbed(model_.machine, seed), test::lumped_model({1.02, 0.96, 0.05}), 20.0, 6,
                           10 * 3600.0, poses_);
  }
  std::vector<VectorXd> readings(const test::Truth& truth, std::uint64_t seed) const {
    test::Uniform uniform(seed);
    std::vector<VectorXd> result = truth.readings_C;
    for (VectorXd& row : result) {
      for (double& value : row) value += 0.04 * uniform.normal();
    }
    return result;
  }
  double squares(Compensator& compensator, const test::Truth& truth, const std::vector<VectorXd>& given,
                 std::string* named) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < truth.time.size(); ++i) {
      const Offsets& offsets = compensator.step(truth.time[i], truth.rows[i], given[i]);
      if (named) *named = offsets.failed_sensors;
      for (std::size_t p = 0; p < poses_.size(); ++p)
        sum += (compensator.tcp(poses_[p]).error.head<3>() - truth.errors[i][p].error.head<3>()).squaredNorm();
    }
    return sum;
  }

  reduction::ReducedModel model_;
  std::vector<mesh::Pose> poses_;
};

TEST_F(FailedSensor, CostsAtMostAFifthOfTheReduction) {
  const char* names[] = {"stuck", "offset", "offset", "noise", "absent"};
  for (const std::uint64_t seed : {401U, 402U}) {
    const test::Truth truth = machine(seed);
    const std::vector<VectorXd> healthy = readings(truth, seed);
    double before = 0.0;
    for (const auto& errors : truth.errors) {
      for (const solver::TcpError& error : errors) before += error.error.head<3>().squaredNorm();
    }
    Compensator all(model_);
    std::string named;
    const double reduction = 1.0 - std::sqrt(squares(all, truth, healthy, &named) / before);
    EXPECT_EQ(named, "");
    for (std::size_t f = 0; f < faults().size(); ++f) {
      for (Index failing = 0; failing < healthy.front().size(); ++failing) {
        std::vector<VectorXd> given = healthy;
        test::Uniform uniform(seed + f);
        const std::size_t from = given.size() / 4;
        for (std::size_t i = from; i < given.size(); ++i) {
          given[i][failing] = faults()[f].reading(given[i][failing], healthy[from][failing], 0.05 * uniform.normal());
        }
        Compensator compensator(model_);
        const double with_fault = 1.0 - std::sqrt(squares(compensator, truth, given, &named) / before);
        EXPECT_GT(with_fault, 0.8 * reduction) << names[f] << " of sensor " << failing;
        // Nor does one that guides the chiller take the coolant with it.
        if (names[f] == std::string("offset")) {
          EXPECT_GT(with_fault, 0.95 * reduction) << model_.machine.sensors[failing].id;
        }
        const std::string expected = model_.machine.sensors[failing].id + "=" + names[f];
        EXPECT_EQ(named, expected) << "seed " << seed;
        if (failing == 0) {
          std::printf("  %s: %.1f %% removed, %.1f %% with all sensors\n", expected.c_str(), 100 * with_fault,
                      100 * reduction);
        }
      }
    }
  }
}

// After a power-off nobody knows the thermal state: the compensator starts anew in mid-shift.
TEST_F(FailedSensor, NoneAndAnUnknownStateIsFoundSoon) {
  for (const std::uint64_t seed : {403U, 404U}) {
    const test::Truth truth = machine(seed);
    const std::vector<VectorXd> given = readings(truth, seed);
    const std::size_t from = truth.time.size() / 3;
    Compensator compensator(model_);
    double before = 0.0, after[2] = {0.0, 0.0}, error[2] = {0.0, 0.0};
    for (std::size_t i = from; i < truth.time.size(); ++i) {
      compensator.step(truth.time[i], truth.rows[i], given[i]);
      const double since = truth.time[i] - truth.time[from];
      for (std::size_t p = 0; p < poses_.size(); ++p) {
        before = truth.errors[i][p].error.head<3>().squaredNorm();
        const double left =
            (compensator.tcp(poses_[p]).error.head<3>() - truth.errors[i][p].error.head<3>()).squaredNorm();
        for (const int k : {0, 1}) {
          const double after_s = k == 0 ? 1800.0 : 7200.0;
          if (since < after_s || since > after_s + 1800.0) continue;
          error[k] += before;
          after[k] += left;
        }
      }
    }
    const double early = std::sqrt(after[0] / error[0]), late = std::sqrt(after[1] / error[1]);
    fmt::print("  seed {}: {:.1f} % of the error left after 30 min, {:.1f} % after 2 h\n", seed, 100 * early,
               100 * late);
    EXPECT_LT(early, 0.2);
    EXPECT_LT(late, 0.1);
  }
}

}  // namespace
}  // namespace thermotwin::compensation
