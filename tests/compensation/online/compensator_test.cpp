// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/compensator.h"

#include <fmt/format.h>

#include <iterator>
#include <random>

#include "compensation/measurement/virtual_measurement.h"
#include "core/missing.h"
#include "mesh/machine/kinematics.h"
#include "tests/compensation/scratch.h"
#include "tests/compensation/shift.h"

namespace thermotwin::compensation {
namespace {

using Eigen::VectorXd;
using test::expect_input_error;

using core::missing;

const reduction::ReducedModel& nominal() {
  static const reduction::ReducedModel model = test::lumped_model();
  return model;
}

std::vector<mesh::Pose> some_poses() {
  std::vector<mesh::Pose> poses;
  for (const char* text : {"", "X=-250,Y=100,Z=400", "X=300,Y=-200,Z=50,B=45,C=90", "B=90,C=200"}) {
    poses.push_back(mesh::parse_pose(nominal().machine, text, "test"));
  }
  return poses;
}

/// Root mean square of the translations' residual over all poses and times, um.
double rms_um(Compensator& compensator, const test::Truth& truth, const std::vector<mesh::Pose>& poses,
              const std::vector<VectorXd>& readings) {
  double sum = 0.0;
  long count = 0;
  for (std::size_t i = 0; i < truth.time.size(); ++i) {
    compensator.step(truth.time[i], truth.rows[i], readings.empty() ? VectorXd() : readings[i]);
    for (std::size_t p = 0; p < poses.size(); ++p) {
      sum += (compensator.tcp(poses[p]).error.head<3>() - truth.errors[i][p].error.head<3>()).squaredNorm();
      ++count;
    }
  }
  return 1e6 * std::sqrt(sum / static_cast<double>(count));
}

/// Readings with white noise and a constant bias each.
std::vector<VectorXd> noisy(const test::Truth& truth, std::uint64_t seed, double noise_K = 0.02, double bias_K = 0.03) {
  std::mt19937_64 engine(seed);
  const auto normal = [&] {
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += static_cast<double>(engine() >> 11) * 0x1p-53;
    return sum;
  };
  VectorXd bias(truth.readings_C.front().size());
  for (double& b : bias) b = bias_K * normal();
  std::vector<VectorXd> readings;
  for (const VectorXd& clean : truth.readings_C) {
    VectorXd reading = clean + bias;
    for (double& value : reading) value += noise_K * normal();
    readings.push_back(reading);
  }
  return readings;
}

/// Another machine than the nominal one: parameters within their uncertainty, lumps that no
/// parameter can express, another time step.
test::Truth other_machine(std::uint64_t seed, const std::vector<mesh::Pose>& poses) {
  const auto sign = seed % 2 == 0 ? 1.0 : -1.0;
  const reduction::ReducedModel structure = test::lumped_model({1.0 + 0.02 * sign, 1.0 - 0.04 * sign, 0.05});
  return test::run_truth(perturbed(nominal().machine, seed), structure, 20.0, 6, 10 * 3600.0, poses);
}

TEST(Compensator, WithoutSensorsEqualsTheReducedModelsRun) {
  const std::vector<mesh::Pose> poses = some_poses();
  const test::Truth run = test::run_truth(nominal().machine, nominal(), 60.0, 1, 10 * 3600.0, poses);
  Compensator compensator(nominal());
  EXPECT_EQ(compensator.tcp(poses[0]).error.norm(), 0.0) << "nothing is known before the first row";
  double worst = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < run.time.size(); ++i) {
    compensator.step(run.time[i], run.rows[i], {});
    for (std::size_t p = 0; p < poses.size(); ++p) {
      worst = std::max(worst, (compensator.tcp(poses[p]).error - run.errors[i][p].error).cwiseAbs().maxCoeff());
      largest = std::max(largest, run.errors[i][p].error.head<3>().norm());
    }
  }
  EXPECT_GT(largest, 10e-6);
  EXPECT_LT(worst, 1e-9 * largest);
}

TEST(Compensator, RowsOfASecondFollowTheModelBetweenItsSteps) {
  const std::vector<mesh::Pose> poses = some_poses();
  const test::Truth run = test::run_truth(nominal().machine, nominal(), 1.0, 1, 4000.0, poses);
  Compensator compensator(nominal());
  double worst = 0.0, later = 0.0, minute = 0.0;
  for (std::size_t i = 0; i < run.time.size(); ++i) {
    compensator.step(run.time[i], run.rows[i], {});
    for (std::size_t p = 0; p < poses.size(); ++p) {
      const double off = (compensator.tcp(poses[p]).error - run.errors[i][p].error).head<3>().norm();
      worst = std::max(worst, off);
      if (run.time[i] > 900.0) later = std::max(later, off);
      if (i >= 60) minute = std::max(minute, (run.errors[i][p].error - run.errors[i - 60][p].error).head<3>().norm());
    }
  }
  // In the first minute after a start nothing tells how fast it goes; a minute of drift is the limit.
  EXPECT_LT(worst, 1.3 * minute);
  EXPECT_LT(later, 0.05 * minute);
}

TEST(Compensator, LongRowsAreDividedAndShortOnesJoined) {
  const std::vector<mesh::Pose> poses = some_poses();
  // Three hours: all changes fall on ends of the long rows.
  const test::Truth fine = test::run_truth(nominal().machine, nominal(), 60.0, 1, 3 * 3600.0, poses);
  const test::Truth coarse = test::run_truth(nominal().machine, nominal(), 60.0, 10, 3 * 3600.0, poses);
  Compensator compensator(nominal());
  rms_um(compensator, coarse, poses, {});
  EXPECT_LT((compensator.tcp(poses[2]).error - fine.errors.back()[2].error).norm(), 1e-12);
  CompensatorOptions options;
  options.step_s = 120.0;
  Compensator joined(nominal(), options);
  EXPECT_LT(rms_um(joined, fine, poses, {}), 0.15);
  EXPECT_LT((joined.tcp(poses[2]).error - fine.errors.back()[2].error).norm(), 0.05e-6);
}

TEST(Compensator, ARowThatComesAtOnceAfterAnotherDoesNoHarm) {
  Compensator compensator(nominal()), calm(nominal());
  VectorXd row = compensator.channels().defaults();
  row[compensator.channels().index("spindle.speed_rpm")] = 6000.0;
  for (const double time : {0.0, 1e-300, 61.0, 61.0 + 1e-9, 122.0, 3000.0}) compensator.step(time, row, {});
  for (const double time : {0.0, 61.0, 122.0, 3000.0}) calm.step(time, row, {});
  ASSERT_TRUE(compensator.state().allFinite());
  EXPECT_LT((compensator.state() - calm.state()).norm(), 1e-6 * calm.state().norm());
}

TEST(Compensator, OffsetsCancelTheErrorAtTheRowsOwnPose) {
  Compensator compensator(nominal());
  ASSERT_EQ(compensator.axes(), (std::vector<std::string>{"X", "Y", "Z"}));
  const solver::Channels& channels = compensator.channels();
  VectorXd row = channels.defaults();
  row[channels.index("spindle.speed_rpm")] = 6000;
  row[channels.index("air.T_C")] = 24;
  compensator.step(0.0, row, {});
  compensator.step(7200.0, row, {});
  for (const auto& [b, c] : {std::pair{0.0, 0.0}, {45.0, 90.0}, {90.0, 200.0}, {22.5, -30.0}}) {
    row[channels.index("axis.X.position_mm")] = 123;
    row[channels.index("axis.Z.position_mm")] = 400;
    row[channels.index("axis.B.position_deg")] = b;
    row[channels.index("axis.C.position_deg")] = c;
    static double time = 7200.0;
    const Offsets offsets = compensator.step(time += 60.0, row, {});
    mesh::Pose pose = mesh::home_pose(nominal().machine);
    pose << 0.123, 0.0, 0.4, b * M_PI / 180.0, c * M_PI / 180.0;
    const VectorXd expected = -1e6 * nominal().tcp(compensator.state(), pose).error.head<3>();
    EXPECT_GT(expected.norm(), 1.0);
    EXPECT_LT((offsets.offset_um - expected).norm(), 1e-9 * expected.norm()) << "B " << b << " C " << c;
    EXPECT_TRUE((offsets.std_um.array() > 0.0).all());
  }
}

TEST(Compensator, SensorsReduceTheErrorOfAnotherMachineAndNeverHarm) {
  const std::vector<mesh::Pose> poses = some_poses();
  double sum_without = 0.0, sum_with = 0.0;
  for (std::uint64_t seed = 101; seed <= 112; ++seed) {
    const test::Truth truth = other_machine(seed, poses);
    Compensator blind(nominal()), seeing(nominal());
    const double without = rms_um(blind, truth, poses, {}), with = rms_um(seeing, truth, poses, noisy(truth, seed));
    fmt::print("  seed {}: {:.3f} um without, {:.3f} um with sensors\n", seed, without, with);
    EXPECT_LT(with, without) << "seed " << seed;
    sum_without += without * without;
    sum_with += with * with;
  }
  const double reduction = 1.0 - std::sqrt(sum_with / sum_without);
  std::printf("  mean reduction by sensors %.1f %%\n", 100.0 * reduction);
  EXPECT_GT(reduction, 0.4);
}

TEST(Compensator, StatedDeviationCoversTheResidual) {
  // Residual over stated deviation should be about 1; much more would be a boast, much less useless.
  const std::vector<mesh::Pose> poses{mesh::home_pose(nominal().machine)};
  for (const bool sensors : {false, true}) {
    double sum = 0.0;
    long count = 0;
    for (std::uint64_t seed = 201; seed <= 208; ++seed) {
      const test::Truth truth = other_machine(seed, poses);
      const std::vector<VectorXd> readings = noisy(truth, seed);
      Compensator compensator(nominal());
      for (std::size_t i = 0; i < truth.time.size(); ++i) {
        const Offsets& offsets = compensator.step(truth.time[i], truth.rows[i], sensors ? readings[i] : VectorXd());
        if (truth.time[i] < 3600.0) continue;
        const VectorXd residual = offsets.offset_um + 1e6 * truth.errors[i][0].error.head<3>();
        sum += residual.cwiseQuotient(offsets.std_um).squaredNorm();
        count += residual.size();
      }
    }
    const double ratio = std::sqrt(sum / static_cast<double>(count));
    std::printf("  residual over stated deviation %s sensors: %.2f\n", sensors ? "with" : "without", ratio);
    EXPECT_GT(ratio, 0.3);
    EXPECT_LT(ratio, 2.0);
  }
}

TEST(Compensator, AWarmStartIsFoundBySensors) {
  const std::vector<mesh::Pose> poses = some_poses();
  const test::Truth truth = test::run_truth(nominal().machine, nominal(), 60.0, 1, 3 * 3600.0, poses, 24.0);
  Compensator blind(nominal()), seeing(nominal());
  const double without = rms_um(blind, truth, poses, {}), with = rms_um(seeing, truth, poses, noisy(truth, 7));
  EXPECT_LT(with, 0.15 * without);
}

TEST(Compensator, SensorsFindAFoundationThatNobodyMeasures) {
  // A hall at 32 degC for long: machine and foundation are there, the control is told of the air only.
  mesh::Machine hall = nominal().machine;
  for (mesh::AmbientSpec& ambient : hall.ambients) {
    if (ambient.id == "foundation") ambient.default_C.value = 32.0;
  }
  const std::vector<mesh::Pose> poses = some_poses();
  test::Truth truth = test::run_truth(hall, nominal(), 60.0, 1, 10 * 3600.0, poses, 32.0);
  const solver::Channels channels(nominal().machine);
  const int foundation = channels.index("foundation.T_C");
  for (VectorXd& row : truth.rows) row[foundation] = channels.defaults()[foundation];
  Compensator blind(nominal(), {.start_C = 32.0}), seeing(nominal());
  const double without = rms_um(blind, truth, poses, {}), with = rms_um(seeing, truth, poses, noisy(truth, 9));
  std::printf("  %.2f um without, %.2f um with sensors\n", without, with);
  EXPECT_LT(with, 0.25 * without);
}

TEST(Compensator, AStartInKelvinIsRefused) {
  try {
    const Compensator compensator(nominal(), {.start_C = 293.15});
    FAIL() << "taken";
  } catch (const core::InputError& refused) {
    EXPECT_NE(std::string(refused.what()).find("start_C: 293.15 degC (20 degC if in kelvin)"), std::string::npos)
        << refused.what();
  }
}

TEST(Compensator, AMissingSensorIsLeftOutAndTheOthersStillHelp) {
  const std::vector<mesh::Pose> poses = some_poses();
  const test::Truth truth = other_machine(301, poses);
  std::vector<VectorXd> readings = noisy(truth, 301);
  Compensator blind(nominal()), all(nominal()), fewer(nominal()), late(nominal());
  const double without = rms_um(blind, truth, poses, {}), with_all = rms_um(all, truth, poses, readings);
  for (VectorXd& reading : readings) reading[0] = missing;  // the most telling one
  const double with_fewer = rms_um(fewer, truth, poses, readings);
  EXPECT_LT(with_fewer, without);
  EXPECT_LT(with_all, with_fewer * 1.2);
  for (std::size_t i = readings.size() / 2; i < readings.size(); ++i) readings[i].setConstant(missing);
  EXPECT_LT(rms_um(late, truth, poses, readings), without);
  EXPECT_EQ(late.step(truth.time.back() + 60.0, truth.rows.back(), readings.back()).status, Status::no_sensors);
}

TEST(Compensator, ABrokenSensorDoesLittle) {
  const std::vector<mesh::Pose> poses = some_poses();
  const test::Truth truth = other_machine(302, poses);
  std::vector<VectorXd> readings = noisy(truth, 302);
  Compensator blind(nominal()), broken(nominal());
  for (std::size_t i = readings.size() / 3; i < readings.size(); ++i) readings[i][2] = 850.0;  // an open lead
  EXPECT_LT(rms_um(broken, truth, poses, readings), 1.1 * rms_um(blind, truth, poses, {}));
}

TEST(Compensator, StatusSaysWhatIsMissing) {
  Compensator compensator(nominal());
  const solver::Channels& channels = compensator.channels();
  VectorXd row = channels.defaults();
  const VectorXd readings = VectorXd::Constant(std::ssize(nominal().machine.sensors), 20.0);
  EXPECT_EQ(compensator.step(0, row, readings).status, Status::ok);
  EXPECT_EQ(compensator.step(10, row, {}).status, Status::no_sensors);
  row[channels.index("axis.B.position_deg")] = 100.0;
  EXPECT_EQ(compensator.step(20, row, readings).status, Status::outside_workspace);
  row[channels.index("axis.B.position_deg")] = 90.0;
  row[channels.index("air.T_C")] = missing;
  EXPECT_EQ(compensator.step(30, row, readings).status, Status::ok);  // blank: the last one holds a while
  EXPECT_EQ(compensator.step(400, row, readings).status, Status::input_missing);
  Compensator fresh(nominal());
  EXPECT_EQ(fresh.step(0, row, readings).status, Status::input_missing);
  EXPECT_STREQ(status_text(Status::outside_workspace), "outside_workspace");
}

/// Rows of a control that goes through everything: a hot start, axes at rapid, all-at-once inputs, wild sensors.
TEST(Compensator, OffsetsKeepToTheirLimitsWhateverComesIn) {
  Compensator compensator(nominal());
  const OffsetLimits& limits = compensator.limits();
  EXPECT_GT(limits.largest_um, 20.0);
  EXPECT_GT(limits.fastest_um_s(), limits.rate_um_s);
  const solver::Channels& channels = compensator.channels();
  VectorXd row = channels.defaults();
  VectorXd readings = VectorXd::Constant(std::ssize(nominal().machine.sensors), 35.0);
  std::mt19937_64 engine(5);
  const auto share = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
  VectorXd before = VectorXd::Zero(3);
  double time = 0.0;
  for (int i = 0; i < 3000; ++i) {
    const double step = i % 7 == 0 ? 30.0 : 0.01 + share();
    time += step;
    row[channels.index("axis.X.position_mm")] = 800.0 * share() - 400.0;
    row[channels.index("axis.B.position_deg")] = 90.0 * share();
    row[channels.index("spindle.speed_rpm")] = i % 11 == 0 ? 1e9 : 12000.0 * share();
    row[channels.index("air.T_C")] = i % 13 == 0 ? 1e9 : i % 5 == 0 ? 293.15 : 35.0;
    readings[i % 3] = i % 17 == 0 ? missing : i % 19 == 0 ? -1e10 : 200.0 * share() - 50.0;
    const Offsets& offsets = compensator.step(time, row, readings);
    ASSERT_TRUE(offsets.offset_um.allFinite() && offsets.std_um.allFinite()) << i;
    ASSERT_LE(offsets.offset_um.cwiseAbs().maxCoeff(), limits.largest_um) << i;
    ASSERT_LE((offsets.offset_um - before).cwiseAbs().maxCoeff(),
              i == 0 ? 0.0 : limits.fastest_um_s() * step * (1.0 + 1e-9))
        << i;
    before = offsets.offset_um;
  }
}

TEST(Compensator, AHotStartIsGoneIntoAtTheRateOfAStandingMachine) {
  Compensator compensator(nominal()), slow(nominal(), {.largest_um = 10.0, .rate_um_s = 0.5});
  const VectorXd row = compensator.channels().defaults();
  const VectorXd readings = VectorXd::Constant(std::ssize(nominal().machine.sensors), 35.0);
  const double rate = compensator.limits().rate_um_s;
  const Offsets first = compensator.step(0.0, row, readings);
  EXPECT_EQ(first.offset_um.norm(), 0.0);
  EXPECT_EQ(first.status, Status::limited);
  const VectorXd wanted = -1e6 * compensator.tcp(compensator.pose()).error.head<3>();
  ASSERT_GT(wanted.cwiseAbs().maxCoeff(), 30.0);
  EXPECT_GE(first.std_um.maxCoeff(), wanted.cwiseAbs().maxCoeff()) << "what is kept back is part of the deviation";
  EXPECT_LE(compensator.step(1.0, row, readings).offset_um.cwiseAbs().maxCoeff(), rate * (1.0 + 1e-9));
  const Offsets last = compensator.step(300.0, row, readings);
  EXPECT_NE(last.status, Status::limited);
  EXPECT_LT((last.offset_um + 1e6 * compensator.tcp(compensator.pose()).error.head<3>()).norm(), 1e-9);
  slow.step(0.0, row, readings);
  EXPECT_NEAR(slow.step(4.0, row, readings).offset_um.cwiseAbs().maxCoeff(), 2.0, 1e-9);
  EXPECT_NEAR(slow.step(400.0, row, readings).offset_um.cwiseAbs().maxCoeff(), 10.0, 1e-9);
  expect_input_error([] { Compensator(nominal(), {.rate_um_s = -1.0}); }, {"rate_um_s", "0 (by the model)"});
}

TEST(Compensator, MovesOfTheAxesPassTheGuard) {
  // A warm machine swings through its workspace at rapid, ten rows a second: no row is held back.
  Compensator compensator(nominal());
  const solver::Channels& channels = compensator.channels();
  VectorXd row = channels.defaults();
  row[channels.index("spindle.speed_rpm")] = 12000;
  row[channels.index("air.T_C")] = 26;
  double time = 0.0;
  for (int i = 0; i < 400; ++i) compensator.step(time += 60.0, row, {});
  double moved = 0.0;
  VectorXd before;
  for (int i = 0; i < 600; ++i) {
    const double swing = std::abs(std::fmod(0.1 * i, 1.6) - 0.8);  // s at 1 m/s
    row[channels.index("axis.X.position_mm")] = 1000.0 * swing - 400.0;
    row[channels.index("axis.Z.position_mm")] = 500.0 * swing;
    row[channels.index("axis.B.position_deg")] = 100.0 * swing;
    const Offsets& offsets = compensator.step(time += 0.1, row, {});
    ASSERT_LT((offsets.offset_um + 1e6 * compensator.tcp(compensator.pose()).error.head<3>()).norm(), 1e-6) << i;
    if (i > 0) moved = std::max(moved, (offsets.offset_um - before).norm());
    before = offsets.offset_um;
  }
  EXPECT_GT(moved, 3.0 * 0.1 * compensator.limits().rate_um_s) << "the swing is worth guarding";
}

TEST(Compensator, TemperaturesThatCannotBeDoNotEnter) {
  const auto sensors = std::ssize(nominal().machine.sensors);
  const VectorXd row = Compensator(nominal()).channels().defaults();
  const auto run = [&](const VectorXd& readings, Status expected, const char* name) {
    Compensator compensator(nominal());
    double largest = 0.0;
    for (int i = 0; i <= 300; ++i) {
      const Offsets& offsets = compensator.step(60.0 * i, row, readings);
      EXPECT_EQ(offsets.status, expected) << name << " row " << i << " " << offsets.failed_sensors;
      EXPECT_NE(offsets.failed_sensors.find(name), std::string::npos) << offsets.failed_sensors;
      largest = std::max(largest, offsets.offset_um.cwiseAbs().maxCoeff());
    }
    return largest;
  };
  EXPECT_LT(run(VectorXd::Constant(sensors, 293.15), Status::sensor_failed, "T_nose=kelvin"), 8.0);
  EXPECT_LT(run(VectorXd::Constant(sensors, 68.0), Status::sensor_failed, "T_nose=fahrenheit"), 8.0);
  EXPECT_LT(run(VectorXd::Constant(sensors, 850.0), Status::sensor_failed, "T_nose=implausible"), 8.0);
  VectorXd one = VectorXd::Constant(sensors, 20.0);
  one[1] -= 273.15;
  const std::string id = nominal().machine.sensors[1].id;
  EXPECT_LT(run(one, Status::sensor_failed, (id + "=implausible").c_str()), 8.0);
  // Two sensors only, one of them in kelvin: the good one keeps its name.
  VectorXd two = VectorXd::Constant(sensors, missing);
  two[0] = 20.0;
  two[1] = 293.15;
  Compensator compensator(nominal());
  for (int i = 0; i <= 300; ++i) EXPECT_EQ(compensator.step(60.0 * i, row, two).failed_sensors, id + "=kelvin");
  // A machine that is warm all over is believed, and so is one hot sensor.
  Compensator warm(nominal()), hot(nominal());
  EXPECT_EQ(warm.step(0.0, row, VectorXd::Constant(sensors, 45.0)).failed_sensors, "");
  one[1] = 60.0;
  EXPECT_EQ(hot.step(0.0, row, one).failed_sensors.find("fahrenheit"), std::string::npos);
}

// A jump on a hot machine lies near the surroundings when taken as degF; degF of what is expected is another thing.
TEST(Compensator, AJumpOnAHotMachineIsAnOffset) {
  const auto sensors = std::ssize(nominal().machine.sensors);
  const VectorXd row = Compensator(nominal()).channels().defaults();
  const std::string id = nominal().machine.sensors[1].id;
  const auto fault_after = [&](double usual_C, double jump_C) {
    Compensator compensator(nominal());
    VectorXd readings = VectorXd::Constant(sensors, usual_C);
    for (int i = 0; i < 5; ++i) compensator.step(60.0 * i, row, readings);
    readings[1] = jump_C;
    for (int i = 5; i < 8; ++i) compensator.step(60.0 * i, row, readings);
    return compensator.step(480.0, row, readings).failed_sensors;
  };
  EXPECT_NE(fault_after(45.0, 53.0).find(id + "=offset"), std::string::npos);
  EXPECT_NE(fault_after(20.0, 68.0).find(id + "=fahrenheit"), std::string::npos);
}

TEST(Compensator, AnInputInKelvinIsMissingAndNamed) {
  Compensator compensator(nominal()), without(nominal());
  VectorXd row = compensator.channels().defaults();
  const VectorXd usual = row;
  row[compensator.channels().index("air.T_C")] = 293.15;
  for (int i = 0; i <= 60; ++i) {
    const Offsets& offsets = compensator.step(60.0 * i, row, {});
    EXPECT_EQ(offsets.status, Status::input_missing);
    EXPECT_EQ(offsets.failed_inputs, "air.T_C=kelvin");
    EXPECT_EQ(offsets.offset_um, without.step(60.0 * i, usual, {}).offset_um);
  }
  row[compensator.channels().index("air.T_C")] = 20.0;
  EXPECT_EQ(compensator.step(4000.0, row, {}).failed_inputs, "");
}

TEST(Compensator, TheGuideSensorsReadingDrivesTheChiller) {
  // The machine stays at 20 degC, but the guide sensor says 25: the coolant must warm the spindle.
  Compensator compensator(nominal());
  const VectorXd row = compensator.channels().defaults();
  const int guide = nominal().machine.sensor_index("T_bed");
  VectorXd readings = VectorXd::Constant(std::ssize(nominal().machine.sensors), missing);
  readings[guide] = 25.0;
  CompensatorOptions options;
  options.start_from_sensors = false;
  Compensator guided(nominal(), options);
  for (int i = 0; i <= 60; ++i) {
    guided.step(60.0 * i, row, readings);
    compensator.step(60.0 * i, row, {});
  }
  const int nose = nominal().machine.sensor_index("T_nose");
  EXPECT_GT(guided.predicted_sensors_C()[nose], compensator.predicted_sensors_C()[nose] + 0.5);
}

TEST(Compensator, AGuideSensorThatIsOffFromTheStartIsNotFollowed) {
  // All is at 20 degC but the guide's reading, which is absurd: the first set point is not taken from it either.
  CompensatorOptions options;
  options.start_from_sensors = false;
  Compensator compensator(nominal(), options), misled(nominal(), options);
  const VectorXd row = compensator.channels().defaults();
  VectorXd readings = VectorXd::Constant(std::ssize(nominal().machine.sensors), 20.0);
  const int guide = nominal().machine.sensor_index("T_bed"), nose = nominal().machine.sensor_index("T_nose");
  for (int i = 0; i <= 5; ++i) {
    readings[guide] = 20.0;
    compensator.step(60.0 * i, row, readings);
    readings[guide] = 80.0;
    misled.step(60.0 * i, row, readings);
  }
  EXPECT_NEAR(misled.predicted_sensors_C()[nose], compensator.predicted_sensors_C()[nose], 0.01);
}

// The start of a machine that has stood off leaves its uniform temperature alone, known to 0.5 K.
TEST(Compensator, ARestedMachineCarriesNoHeatOfEarlierWork) {
  CompensatorOptions options;
  options.use_sensors = false;
  Compensator rested(nominal(), options), unknown(nominal(), options);
  rested.rested();
  options.start_C += 0.5;
  Compensator warmer(nominal(), options);
  VectorXd row = rested.channels().defaults();
  row[rested.channels().index("machine.on")] = 0.0;
  const mesh::Pose pose = some_poses()[0];
  for (int i = 0; i <= 1; ++i) {
    rested.step(i, row, {});
    unknown.step(i, row, {});
    warmer.step(i, row, {});
  }
  const double half_kelvin_um =
      (warmer.tcp(pose).error.head<3>() - rested.tcp(pose).error.head<3>()).norm() / core::units::um;
  const double std_um = rested.std_um(pose).norm();
  EXPECT_GT(std_um, 0.9 * half_kelvin_um);
  EXPECT_LT(std_um, 2.0 * half_kelvin_um) << "what is left is the error of the model";
  EXPECT_GT(unknown.std_um(pose).norm(), 3.0 * std_um);
  EXPECT_THROW(rested.rested(), core::InputError) << "after a row";
  Compensator measured(nominal());
  EXPECT_THROW(measured.rested(), core::InputError) << "with sensors";
}

TEST(Compensator, PredictedReadingsMeetTheReadingsOfItsOwnModel) {
  const std::vector<mesh::Pose> poses = some_poses();
  const test::Truth run = test::run_truth(nominal().machine, nominal(), 60.0, 1, 4 * 3600.0, poses);
  Compensator compensator(nominal());
  for (std::size_t i = 0; i < run.time.size(); ++i) compensator.step(run.time[i], run.rows[i], run.readings_C[i]);
  EXPECT_LT((compensator.predicted_sensors_C() - run.readings_C.back()).cwiseAbs().maxCoeff(), 0.01);
}

TEST(Compensator, WrongCallsAreInputErrors) {
  Compensator compensator(nominal());
  const VectorXd row = compensator.channels().defaults();
  compensator.step(100.0, row, {});
  expect_input_error([&] { compensator.step(99.0, row, {}); }, {"99 s after 100 s"});
  expect_input_error([&] { compensator.step(100.0, row, {}); }, {"rise"});
  expect_input_error([&] { compensator.step(missing, row, {}); }, {"time"});
  expect_input_error([&] { compensator.step(1e12, row, {}); }, {"1000000000000 s after 100 s"});
  expect_input_error([&] { compensator.step(200.0, row.head(3), {}); }, {"3 values"});
  expect_input_error([&] { compensator.step(200.0, row, VectorXd::Zero(2)); }, {"2 readings"});
  CompensatorOptions options;
  options.step_s = 0.0;
  expect_input_error([&] { Compensator(nominal(), options); }, {"step_s"});
}

TEST(Compensator, IsTheSameBitForBitWhenRunAgain) {
  const std::vector<mesh::Pose> poses = some_poses();
  const test::Truth truth = other_machine(303, poses);
  const std::vector<VectorXd> readings = noisy(truth, 303);
  Compensator one(nominal()), other(nominal());
  EXPECT_EQ(rms_um(one, truth, poses, readings), rms_um(other, truth, poses, readings));
  EXPECT_EQ(one.state(), other.state());
}

}  // namespace
}  // namespace thermotwin::compensation
