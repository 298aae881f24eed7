// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/measurement/virtual_measurement.h"

#include "compensation/evaluation/evaluate.h"
#include "compensation/evaluation/result.h"
#include "compensation/measurement/measurement_check.h"
#include "compensation/online/compensator.h"
#include "mesh/machine/kinematics.h"
#include "reduction/basis/reduce.h"
#include "solver/campaign/full_model.h"
#include "solver/thermal/assembly.h"
#include "tests/compensation/scratch.h"
#include "tests/machines/boxes.h"
#include "tests/machines/five_axis.h"

namespace thermotwin::compensation {
namespace {

const char* const load_text = R"(
schema = 1
title = "spindle, X, rest"
initial_C = 20.0
time_step_s = 120
output_s = 600
[[phase]]
name = "spindle"
duration_h = 3
spindle_rpm = 9000
air_C = [20.0, 22.0]
[[phase]]
name = "X"
duration_h = 2
spindle_rpm = 0
air_C = 22.0
[[phase.axis]]
id = "X"
low_mm = -150
high_mm = 150
feed_mm_min = 20000
[[phase]]
name = "rest"
duration_h = 2
)";

/// The boxes of the reduction's tests with uncertain parameters and two sensors more.
mesh::Machine uncertain_boxes() {
  mesh::Machine machine = thermotwin::test::small_machine();
  for (mesh::SourceSpec& source : machine.sources) source.scale.std_percent = 5;
  for (mesh::FilmSpec& film : machine.films) film.coefficient.std_percent = 10;
  for (mesh::JointSpec& joint : machine.joints) joint.conductance.std_percent = 20;
  for (mesh::CoolantSpec& coolant : machine.coolants) {
    for (mesh::CoolantSegment& segment : coolant.segments) segment.film_coefficient.std_percent = 10;
  }
  mesh::SensorSpec sensor = machine.sensors.front();
  sensor.id = "T3";
  sensor.body = "column";
  sensor.point = {0.0, 0.3, 0.4};
  machine.sensors.push_back(sensor);
  sensor.id = "T4";
  sensor.body = "table";
  sensor.point = {0.05, 0.0, 0.18};
  machine.sensors.push_back(sensor);
  return machine;
}

solver::FullModel boxes(const mesh::Machine& machine, int finer) {
  mesh::MachineMesh mesh = thermotwin::test::small_machine_mesh(finer);
  mesh.machine = machine;
  solver::ThermalSystem thermal = solver::assemble_thermal(mesh);
  solver::ElasticModel elastic(mesh, thermal);
  return {std::move(mesh), std::move(thermal), std::move(elastic)};
}

solver::LoadProgram load_of(const test::Scratch& scratch, const mesh::Machine& machine) {
  scratch.write("shift.toml", load_text);
  return solver::LoadProgram::read(scratch.path() / "shift.toml", machine);
}

TEST(Perturbed, ChangesEveryUncertainValueAndNothingElse) {
  const mesh::Machine machine = test::five_axis_machine(), other = perturbed(machine, 5);
  EXPECT_NE(other.sources[0].scale.value, machine.sources[0].scale.value);
  EXPECT_NE(other.films[0].coefficient.value, machine.films[0].coefficient.value);
  EXPECT_NE(other.joints[2].conductance.value, machine.joints[2].conductance.value);
  EXPECT_NE(other.coolants[0].segments[0].film_coefficient.value,
            machine.coolants[0].segments[0].film_coefficient.value);
  EXPECT_EQ(other.materials[0].expansion.value, machine.materials[0].expansion.value);  // stated as certain
  EXPECT_EQ(other.films[0].coefficient.std_percent, machine.films[0].coefficient.std_percent);
  EXPECT_EQ(perturbed(machine, 5, 0.0).joints[2].conductance.value, machine.joints[2].conductance.value);
}

TEST(Perturbed, ChangesVolumesToo) {
  mesh::Machine machine = test::five_axis_machine();
  const double film = perturbed(machine, 5).films[0].coefficient.value;
  mesh::VolumeSpec tank;
  tank.id = "tank";
  tank.capacity = {1e6, 10};
  mesh::VolumeExchange exchange;
  exchange.with = machine.ambients.front().id;
  exchange.conductance = {80, 20};
  tank.exchanges.push_back(exchange);
  machine.volumes.push_back(tank);
  const mesh::Machine all = perturbed(machine, 5), thermal = perturbed(machine, 5, 1.0, Perturb::thermal);
  EXPECT_NE(all.volumes[0].capacity.value, 1e6);
  EXPECT_NE(all.volumes[0].exchanges[0].conductance.value, 80);
  EXPECT_EQ(thermal.volumes[0].capacity.value, 1e6);
  EXPECT_EQ(thermal.volumes[0].exchanges[0].conductance.value, all.volumes[0].exchanges[0].conductance.value);
  EXPECT_EQ(all.films[0].coefficient.value, film);  // other seeds' machines stay what they were
}

TEST(Perturbed, SeedsRepeatAndDiffer) {
  const mesh::Machine machine = test::five_axis_machine();
  EXPECT_EQ(perturbed(machine, 5).films[1].coefficient.value, perturbed(machine, 5).films[1].coefficient.value);
  EXPECT_NE(perturbed(machine, 5).films[1].coefficient.value, perturbed(machine, 6).films[1].coefficient.value);
}

TEST(Perturbed, SpreadsAsStatedAndStaysPositive) {
  const mesh::Machine machine = test::five_axis_machine();
  double sum = 0.0, squares = 0.0, least = 1.0;
  constexpr int seeds = 4000;
  for (int seed = 0; seed < seeds; ++seed) {
    const double factor = perturbed(machine, static_cast<std::uint64_t>(seed)).joints[1].conductance.value /
                          machine.joints[1].conductance.value;
    sum += factor;
    squares += factor * factor;
    least = std::min(least, perturbed(machine, static_cast<std::uint64_t>(seed), 10.0).joints[1].conductance.value /
                                machine.joints[1].conductance.value);
  }
  const double mean = sum / seeds, std = std::sqrt(squares / seeds - mean * mean);
  EXPECT_NEAR(mean, 1.0, 0.015);
  EXPECT_NEAR(std, 0.2, 0.01);
  EXPECT_NEAR(least, 0.2, 1e-12);
}

TEST(VirtualMeasurement, HasInputsSensorsAndDisplacementsThatFitTheMachine) {
  const test::Scratch scratch;
  const mesh::Machine machine = uncertain_boxes();
  const solver::FullModel truth = boxes(machine, 1);
  const mesh::Pose pose = mesh::parse_pose(machine, "X=100,Z=-50", "test");
  VirtualOptions options;
  options.seed = 3;
  const solver::LoadProgram load = load_of(scratch, machine);
  const Measurement m = measure_virtually(truth, load, {mesh::home_pose(machine), pose}, options);
  require_fits(m, machine);
  EXPECT_EQ(m.data.rows(), 43);
  for (const char* id :
       {"spindle.speed_rpm", "air.T_C", "axis.X.low_mm", "cutting_fluid.on", "T1", "T4", "dx@1", "dz@2"}) {
    EXPECT_TRUE(m.data.find(id)) << id;
  }
  EXPECT_FALSE(m.data.find("foundation.T_C"));
  // Rows hold from their time on: at 3 h the spindle has stopped and X moves.
  EXPECT_EQ(m.data.column("spindle.speed_rpm")[17], 9000.0);
  EXPECT_EQ(m.data.column("spindle.speed_rpm")[18], 0.0);
  EXPECT_EQ(m.data.column("axis.X.high_mm")[18], 150.0);
  // The range ends with the motion.
  EXPECT_TRUE(std::isnan(m.data.column("axis.X.high_mm")[40]));
  EXPECT_EQ(m.data.column("axis.X.feed_mm_min")[40], 0.0);
  for (const MeasuredChannel& channel : m.channels) {
    if (channel.kind == ChannelKind::displacement) {
      EXPECT_EQ(channel.uncertainty, options.probe_noise_um);
    }
    if (!channel.sensor.empty()) {
      EXPECT_EQ(channel.uncertainty, options.sensor_noise_K);
    }
  }
  // The same seed is the same measurement; without noise it is the load's run itself.
  EXPECT_EQ(m.data.column("dx@1"),
            measure_virtually(truth, load, {mesh::home_pose(machine), pose}, options).data.column("dx@1"));
  options.sensor_noise_K = options.probe_noise_um = 0.0;
  const Measurement clean = measure_virtually(truth, load, {mesh::home_pose(machine), pose}, options);
  const Eigen::VectorXd noise = m.data.column("dz@2") - clean.data.column("dz@2");
  EXPECT_NEAR(std::sqrt(noise.squaredNorm() / noise.size()), 0.3, 0.1);
  EXPECT_GT(clean.data.column("dz@2").cwiseAbs().maxCoeff(), 1.0);
}

/// Two outputs of a run: circuits on, then off; each segment takes the same heat all the time.
solver::LoadResult cooled_run(const mesh::Machine& machine, double power_W) {
  const solver::Channels channels(machine);
  solver::LoadResult run;
  const auto begin = [](core::Table& table) {
    table.columns = {"time_s"};
    table.values = Eigen::Vector3d(0, 600, 1200);
  };
  const auto add = [](core::Table& table, const std::string& name, const Eigen::Vector3d& values) {
    table.columns.push_back(name);
    table.values.conservativeResize(Eigen::NoChange, std::ssize(table.columns));
    table.values.rightCols(1) = values;
  };
  for (core::Table* table : {&run.sensors, &run.inputs, &run.heat_flows}) begin(*table);
  for (const mesh::SensorSpec& sensor : machine.sensors) add(run.sensors, sensor.id + "_C", {20, 21, 22});
  for (Eigen::Index k = 0; k < channels.size(); ++k) {
    const std::string& name = channels.names()[k];
    const double value = channels.defaults()[k];
    const bool is_circuit = name.starts_with("coolant.") && name.ends_with(".on");
    add(run.inputs, name, is_circuit ? Eigen::Vector3d(1, 1, 0) : Eigen::Vector3d::Constant(value));
  }
  for (const mesh::CoolantSpec& coolant : machine.coolants) {
    for (const mesh::CoolantSegment& segment : coolant.segments)
      add(run.heat_flows, "coolant." + coolant.id + "." + segment.id + ".cooling_power_W",
          Eigen::Vector3d::Constant(power_W));
  }
  return run;
}

TEST(VirtualMeasurement, ACoolantRisesByItsHeatOverItsFlow) {
  const mesh::Machine machine = uncertain_boxes();
  const mesh::CoolantSpec& coolant = machine.coolants.front();
  const solver::LoadResult run = cooled_run(machine, 90.0);
  VirtualOptions quiet;
  quiet.sensor_noise_K = quiet.probe_noise_um = 0.0;
  const std::string rise = "coolant." + coolant.id + "." + coolant.segments.front().id + ".rise";
  EXPECT_FALSE(measure_run(run, machine, {}, quiet).data.find(rise));
  quiet.coolant_rise = true;
  const Measurement m = measure_run(run, machine, {}, quiet);
  ASSERT_TRUE(m.data.find(rise));
  EXPECT_NEAR(m.data.column(rise)[1], 90.0 / (coolant.flow.value * coolant.specific_heat), 1e-9);
  EXPECT_EQ(m.data.column(rise)[2], 0.0) << "the circuit is off";
}

TEST(VirtualMeasurement, WithoutNoiseItIsReadAsItWasWritten) {
  const mesh::Machine machine = uncertain_boxes();
  VirtualOptions quiet;
  quiet.sensor_noise_K = quiet.probe_noise_um = 0.0;
  const Measurement m = measure_run(cooled_run(machine, 90.0), machine, {}, quiet);
  for (const MeasuredChannel& channel : m.channels) {
    if (channel.kind == ChannelKind::temperature || channel.kind == ChannelKind::displacement) {
      EXPECT_GT(channel.uncertainty, 0.0) << channel.id;
    }
  }
  const test::Scratch scratch;
  write_measurement(scratch.path() / "quiet", m);
  EXPECT_EQ(read_measurement(scratch.path() / "quiet").channels.size(), m.channels.size());
}

TEST(VirtualMeasurement, SensorsReduceTheErrorOfTheReducedModelOnAFinerPerturbedMachine) {
  const test::Scratch scratch;
  const mesh::Machine machine = uncertain_boxes();
  const solver::LoadProgram load = load_of(scratch, machine);
  reduction::ReducedModel model =
      reduction::reduce(boxes(machine, 2), {load}, {}, {.tolerance_um = 0.1, .max_order = 40, .order = 30});
  model.machine = machine;
  const std::vector<mesh::Pose> poses{mesh::home_pose(machine), mesh::parse_pose(machine, "X=-150,Z=80,C=90", "test")};
  // What the meshes (and the probe's noise) make is beyond the sensors: it is most of what is left.
  double without = 0.0, with = 0.0, before = 0.0;
  for (const std::uint64_t seed : {21U, 22U, 23U, 24U}) {
    VirtualOptions options;
    options.seed = seed;
    const Measurement m = measure_virtually(boxes(perturbed(machine, seed), 3), load, poses, options);
    const Evaluation evaluation = evaluate(m, &model, {});
    for (const EvaluationRow& row : evaluation.rows) {
      if (row.model == "reduced_model") {
        without += row.measures.rms * row.measures.rms;
        before += row.measures.rms_before * row.measures.rms_before;
      }
      if (row.model == "reduced_model_sensors") with += row.measures.rms * row.measures.rms;
    }
  }
  std::printf("  rms over channels and seeds: %.3f um uncompensated, %.3f um without, %.3f um with sensors\n",
              std::sqrt(before / 24), std::sqrt(without / 24), std::sqrt(with / 24));
  EXPECT_LT(without, before);
  EXPECT_LT(with, without);
}

}  // namespace
}  // namespace thermotwin::compensation
