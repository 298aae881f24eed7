// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/campaign/start_field.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include "core/error.h"
#include "core/file.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/simulation.h"
#include "solver/campaign/start_field_vtu.h"
#include "solver/export/vtk_output.h"
#include "solver/thermal/assembly.h"
#include "solver/thermal/integrator.h"
#include "tests/machines/slide_machine.h"

namespace thermotwin::solver {
namespace {

std::filesystem::path scratch(const std::string& name) {
  return std::filesystem::temp_directory_path() / ("thermotwin_start_" + std::to_string(::getpid()) + "_" + name);
}

/// A field that is linear in the place, another one in each body; fluid nodes 0.
Eigen::VectorXd linear_field(const mesh::MachineMesh& mesh, Eigen::Index size) {
  Eigen::VectorXd field = Eigen::VectorXd::Zero(size);
  for (std::size_t b = 0; b < mesh.bodies.size(); ++b) {
    for (Eigen::Index i = 0; i < mesh.bodies[b].points.cols(); ++i) {
      field[mesh.first_node[b] + i] =
          3.0 + Eigen::Vector3d(5, -8, 20).dot(mesh.bodies[b].points.col(i)) * (b == 0 ? 1.0 : -1.0);
    }
  }
  return field;
}

/// The slide machine with ten sensors all over.
mesh::Machine observed_machine() {
  mesh::Machine machine = test::slide_machine();
  machine.sensors.clear();
  int count = 0;
  for (const double x : {0.02, 0.2, 0.4, 0.58}) {
    for (const double z : {0.01, 0.09}) {
      mesh::SensorSpec sensor;
      sensor.id = "B" + std::to_string(++count);
      sensor.body = "bed";
      sensor.point = {x, 0.06, z};
      machine.sensors.push_back(sensor);
    }
  }
  for (const double x : {0.26, 0.34}) {
    mesh::SensorSpec sensor;
    sensor.id = "S" + std::to_string(++count);
    sensor.body = "slide";
    sensor.point = {x, 0.06, 0.13};
    machine.sensors.push_back(sensor);
  }
  machine.coolants[0].guide_sensor = "B1";
  return machine;
}

}  // namespace

TEST(StartField, ComesFromAnotherMeshAtAnotherPose) {
  const mesh::Machine machine = test::slide_machine();
  const mesh::MachineMesh coarse = test::slide_mesh(1), fine = test::slide_mesh(2);
  const ThermalSystem from = assemble_thermal(coarse), to = assemble_thermal(fine);
  const auto file = scratch("field.vtu");
  mesh::Pose pose(1);
  pose << 0.15;
  const Eigen::VectorXd field = linear_field(coarse, from.size);
  write_fields(file, coarse, pose, (field.head(coarse.nodes()).array() + machine.reference_C).matrix(),
               Eigen::Matrix3Xd::Zero(3, coarse.nodes()), 60.0);
  const StartField start = field_from_vtu(file, fine, to);
  const Eigen::VectorXd exact = linear_field(fine, to.size);
  EXPECT_LT((start.temperature - exact).head(to.nodes).cwiseAbs().maxCoeff(), 1e-5);  // single precision in the file
  EXPECT_LT(start.farthest, 1e-6);
  // Fluid: mean of the walls y0 and y1 of the slide, centre (0.3, y, 0.1305).
  EXPECT_NEAR(start.temperature[to.nodes], 3.0 - (5 * 0.3 - 8 * 0.01 + 20 * 0.1305), 1e-4);
  EXPECT_NEAR(start.temperature[to.nodes + 2], 3.0 - (5 * 0.3 - 8 * 0.11 + 20 * 0.1305), 1e-4);

  mesh::MachineMesh renamed = fine;
  renamed.machine.bodies[1].id = "carriage";
  EXPECT_THROW(field_from_vtu(file, renamed, to), core::InputError);
  EXPECT_THROW(field_from_vtu(scratch("missing.vtu"), fine, to), core::InputError);
  std::filesystem::remove(file);
}

TEST(StartField, HonoursItsSensorsAndIsNearTheField) {
  const mesh::MachineMesh mesh = test::slide_mesh(2, observed_machine());
  const ThermalSystem thermal = assemble_thermal(mesh);
  const OperatingModel model(mesh.machine, thermal.layout);
  const LoadProgram program = LoadProgram::parse(
      "schema = 1\n[[phase]]\nduration_h = 3\nspindle_rpm = 9000\nair_C = 23\n", "p.toml", mesh.machine);
  // The truth: an hour into a warm-up, with heat that the field knows nothing of.
  ThermalIntegrator integrator(thermal);
  SimulationOptions options;
  options.progress = false;
  Eigen::VectorXd truth;
  simulate(integrator, model, {&program}, options, [&](const OutputState& out) {
    if (out.time == 3600.0) truth = out.state;
  });
  const Eigen::VectorXd seen = thermal.sensors * truth;
  std::vector<int> all(mesh.machine.sensors.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  const Coefficients still = model.coefficients(model.channels().defaults(), Eigen::VectorXd::Zero(1));
  const Eigen::VectorXd field = field_from_sensors(thermal, still, all, seen);
  EXPECT_LT((thermal.sensors * field - seen).cwiseAbs().maxCoeff(), 1e-8);
  const auto rms = [&](const Eigen::VectorXd& off) {
    return std::sqrt(off.head(thermal.nodes).squaredNorm() / thermal.nodes);
  };
  const Eigen::VectorXd uniform = Eigen::VectorXd::Constant(thermal.size, seen.mean());
  EXPECT_LT(rms(field - truth), 0.3 * rms(uniform - truth));
  // No spikes: nowhere far from what the sensors saw.
  EXPECT_LT(field.head(thermal.nodes).maxCoeff(), seen.maxCoeff() + 1.0);
  EXPECT_GT(field.head(thermal.nodes).minCoeff(), seen.minCoeff() - 1.0);

  // Where the sensors see the steady field, it is the steady field.
  const Eigen::VectorXd steady = solve_steady(thermal, still);
  EXPECT_LT((field_from_sensors(thermal, still, all, thermal.sensors * steady) - steady).cwiseAbs().maxCoeff(), 1e-8);
  // A sensor given twice counts once; two that contradict each other are averaged.
  const std::vector<int> twice{0, 3, 3, 9};
  Eigen::VectorXd values(4);
  values << 1.0, 2.0, 2.2, 3.0;
  const Eigen::VectorXd mean = thermal.sensors * field_from_sensors(thermal, still, twice, values);
  EXPECT_NEAR(mean[0], 1.0, 1e-6);
  EXPECT_NEAR(mean[3], 2.1, 1e-6);
  EXPECT_NEAR(mean[9], 3.0, 1e-6);
}

TEST(StartField, ReadsATableOfSensors) {
  mesh::Machine machine = observed_machine();
  machine.sensors[1].offset = 0.5;
  const mesh::MachineMesh mesh = test::slide_mesh(1, machine);
  const ThermalSystem thermal = assemble_thermal(mesh);
  const OperatingModel model(machine, thermal.layout);
  const LoadProgram program = LoadProgram::parse("schema = 1\n[[phase]]\nduration_h = 1\n", "p.toml", machine);
  const core::Table table =
      core::parse_csv("time_s,B1_C,B2_C,other\n0,21,22,1\n100,nan,24,1\n200,23,26,1\n", "sensors.csv");
  const Eigen::VectorXd seen = thermal.sensors * field_from_sensors(table, 50.0, model, program, thermal);
  EXPECT_NEAR(seen[0], 1.5, 1e-8);        // 21.5 degC across the gap
  EXPECT_NEAR(seen[1], 3.0 - 0.5, 1e-8);  // the reading without its offset
  EXPECT_THROW(field_from_sensors(table, 300.0, model, program, thermal), core::InputError);
  EXPECT_THROW(field_from_sensors(core::parse_csv("time_s,x\n0,1\n", "s.csv"), 0.0, model, program, thermal),
               core::InputError);

  // A run starts there.
  ThermalIntegrator integrator(thermal);
  SimulationOptions options;
  options.progress = false;
  options.start = field_from_sensors(table, 0.0, model, program, thermal);
  bool first = true;
  simulate(integrator, model, {&program}, options, [&](const OutputState& out) {
    if (first) {
      EXPECT_NEAR(out.sensors_K[1], 2.0, 1e-8);
    }
    first = false;
  });
}

}  // namespace thermotwin::solver
