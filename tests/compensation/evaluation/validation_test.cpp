// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/evaluation/validation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "compensation/evaluation/failed_sensors.h"
#include "compensation/evaluation/power_off.h"
#include "compensation/evaluation/replay.h"
#include "solver/campaign/case.h"
#include "tests/compensation/scratch.h"
#include "tests/machines/five_axis.h"

namespace thermotwin::compensation {
namespace {

const char* const load_text = R"(
schema = 1
title = "spindle and C"
initial_C = 24.0
time_step_s = 60
output_s = 300
[[phase]]
name = "work"
duration_h = 4
air_C = 24.0
foundation_C = 24.0
spindle_rpm = 9000
[[phase.axis]]
id = "C"
speed_rpm = 100
[[phase]]
name = "rest"
duration_h = 2
spindle_rpm = 0
)";

/// A case of the lumped machine, and a truth whose lumps no parameter expresses.
struct Lumps {
  test::Scratch scratch;
  solver::Case machine_case;
  reduction::ReducedModel model = test::lumped_model(), truth = test::lumped_model({1.02, 0.96, 0.05});
  Lumps() {
    machine_case.folder = scratch.path();
    machine_case.machine = model.machine;
    for (const char* text : {"X=-250,Y=100,Z=400", "X=300,Y=-200,Z=50,B=45"})
      machine_case.check_points.push_back(mesh::parse_pose(model.machine, text, "test"));
    scratch.write("loads/shift.toml", load_text);
  }
  ValidationOptions options(int draws) const {
    ValidationOptions options;
    options.loads = {"shift"};
    options.draws = draws;
    options.reference = &truth;
    return options;
  }
};

TEST(Quantile, IsLinearBetweenSortedValues) {
  EXPECT_EQ(quantile({3.0, 1.0, 2.0}, 0.5), 2.0);
  EXPECT_DOUBLE_EQ(quantile({4.0, 1.0, 2.0, 3.0}, 0.1), 1.3);
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
}

TEST(Validation, SensorsBeatTheModelAloneOnPerturbedMachines) {
  const Lumps lumps;
  const Validation validation = validate_online(lumps.machine_case, lumps.model, lumps.options(6));
  const std::vector<double> with = validation.reductions("shift", With::sensors),
                            told = validation.reductions("shift", With::told);
  ASSERT_EQ(with.size(), 6U);
  EXPECT_GT(quantile(with, 0.5), 85.0);
  EXPECT_GT(quantile(with, 0.5), quantile(told, 0.5));
  // Nobody tells the foundation's 24 degC: whoever is told does better without sensors.
  EXPECT_GT(quantile(told, 0.5), quantile(validation.reductions("shift", With::model), 0.5));
  EXPECT_GT(quantile(validation.cuts("shift"), 0.5), 30.0);
  EXPECT_NE(validation.brief().find("10th percentile"), std::string::npos);
  EXPECT_EQ(validation.measured_nodes, 0);
  // The cut is what the table's two columns say.
  double told_squares = 0.0, sensor_squares = 0.0;
  for (const ValidationRow& row : validation.rows) {
    if (row.draw != 0) continue;
    told_squares += row.rms_told_um * row.rms_told_um;
    sensor_squares += row.rms_sensors_um * row.rms_sensors_um;
  }
  EXPECT_NEAR(validation.cuts("shift")[0], 100.0 * (1.0 - std::sqrt(sensor_squares / told_squares)), 1e-9);
}

TEST(PowerOff, AnUnknownStateIsFoundWithinTwoHours) {
  const Lumps lumps;
  ValidationOptions options = lumps.options(6);
  options.first_seed = 51;
  const PowerOffStudy study = study_power_off(lumps.machine_case, lumps.model, options);
  ASSERT_EQ(study.rows.size(), 6U);
  for (const PowerOffRow& row : study.rows) {
    EXPECT_GE(row.off_h, 0.5);
    EXPECT_LE(row.off_h, 10.0);
    EXPECT_GE(row.worked_h, 2.0 - 0.1);
    EXPECT_GT(row.before_um[0], 0.0);
  }
  std::printf("%s", study.brief().c_str());
  EXPECT_LT(quantile(study.left_percent(1), 0.5), 20.0);
  EXPECT_LT(quantile(study.left_percent(2), 0.5), 10.0);
}

TEST(FailedSensors, CostLittleAndAreNamed) {
  const Lumps lumps;
  const FailedSensorStudy study = study_failed_sensors(lumps.machine_case, lumps.model, lumps.options(2));
  const std::size_t sensors = lumps.model.machine.sensors.size();
  ASSERT_EQ(study.rows.size(), 2 * 4 * sensors);
  EXPECT_EQ(study.false_alarms(), 0);
  std::printf("%s", study.brief().c_str());
  int soon = 0, told = 0;
  for (const FailedSensorRow& row : study.rows) {
    EXPECT_GT(row.whole_percent, 70.0);
    EXPECT_LT(row.cost_percent(), 20.0) << row.sensor << ' ' << row.fault;
    EXPECT_GE(row.named_min, 0.0);
    told += row.told;
    soon += row.told && row.named_min <= 15.0;
  }
  EXPECT_GT(told, static_cast<int>(study.rows.size()) / 2);
  EXPECT_EQ(soon, told);
}

TEST(PowerOff, ProgramsOfAllSeedsAreLegalAndDiffer) {
  const mesh::Machine machine = test::five_axis_machine();
  std::string last;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const std::string text = random_power_off(machine, seed);
    EXPECT_NE(text, last);
    last = text;
    const solver::LoadProgram load = solver::LoadProgram::parse(text, "random.toml", machine);
    EXPECT_GT(load.duration(), 3600.0 * 5.0);
    // Phases end at rows.
    const double back = load.duration() - 3.0 * 3600.0;
    EXPECT_NEAR(std::remainder(back, 300.0), 0.0, 1e-3) << seed;
  }
}

TEST(MeasuredRun, StartsAnewAfterAGap) {
  const Lumps lumps;
  const ValidationOptions options = lumps.options(1);
  MeasuredMachines machines(lumps.machine_case, options.machine, {}, options.reference);
  const Measurement once = machines.measure(7, {lumps.machine_case.load("shift"), ""});
  Measurement twice = once;
  const Eigen::Index rows = once.data.rows();
  twice.data.values.resize(2 * rows, once.data.values.cols());
  twice.data.values << once.data.values, once.data.values;
  const auto second = [&](double hours) {
    twice.data.values.col(0).tail(rows) =
        once.data.values.col(0).array() + once.data.values(rows - 1, 0) + 3600.0 * hours;
    return run_compensator(twice, lumps.model, lumps.machine_case.check_points, {});
  };
  const auto alone = run_compensator(once, lumps.model, lumps.machine_case.check_points, {});
  const auto days = second(48.0), night = second(8.0);
  const std::size_t i = rows / 3, j = i + static_cast<std::size_t>(rows);
  EXPECT_LT((days[0][j].error - alone[0][i].error).norm(), 1e-12);
  // Eight hours do not cool a machine as far.
  EXPECT_GT((night[0][j].error - alone[0][i].error).head<3>().norm(), 1e-8);
}

TEST(MeasuredMachines, ThermalPerturbationsLeaveMaterialsAlone) {
  mesh::Machine machine = test::five_axis_machine();
  for (mesh::Material& material : machine.materials) material.expansion.std_percent = 3;
  const mesh::Machine all = perturbed(machine, 5), thermal = perturbed(machine, 5, 1.0, Perturb::thermal);
  EXPECT_NE(all.materials[0].expansion.value, machine.materials[0].expansion.value);
  EXPECT_EQ(thermal.materials[0].expansion.value, machine.materials[0].expansion.value);
  EXPECT_EQ(thermal.coolants[0].flow.value, machine.coolants[0].flow.value);
  // The others draw the same numbers.
  EXPECT_EQ(thermal.films[1].coefficient.value, all.films[1].coefficient.value);
  EXPECT_EQ(thermal.sources[0].scale.value, all.sources[0].scale.value);
}

}  // namespace
}  // namespace thermotwin::compensation
