// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Runs of a small machine with load programs as text, for tests of the physics in time.

#include "solver/campaign/adaptive_simulation.h"
#include "solver/campaign/simulation.h"
#include "solver/thermal/adaptive.h"
#include "solver/thermal/assembly.h"
#include "solver/thermal/integrator.h"
#include "tests/machines/box_mesh.h"

namespace thermotwin::test {

struct Run {
  std::vector<double> times;
  std::vector<Eigen::VectorXd> states, sensors;
  solver::RunSummary summary;
  solver::HeatBalance heat;
};

class Bench {
public:
  explicit Bench(mesh::MachineMesh machine_mesh)
      : mesh(std::move(machine_mesh)),
        system(solver::assemble_thermal(mesh)),
        model(mesh.machine, system.layout) {}

  solver::LoadProgram program(const std::string& text) const {
    return solver::LoadProgram::parse("schema = 1\n" + text, "p.toml", mesh.machine);
  }
  /// With error control if the text has a [time].
  Run run(const std::string& text, double tolerance = 1e-12) const {
    const solver::LoadProgram load = program(text);
    std::vector<solver::HeatBalance> balances{solver::HeatBalance(mesh.machine, system)};
    Run result{{}, {}, {}, {}, balances[0]};
    solver::SimulationOptions options;
    options.balances = &balances;
    options.progress = false;
    const auto record = [&](const solver::OutputState& out) {
      result.times.push_back(out.time);
      result.states.push_back(out.state);
      result.sensors.push_back(out.sensors_K);
    };
    if (load.time().scheme == solver::TimeScheme::adaptive) {
      solver::AdaptiveOptions of_integrator;
      of_integrator.tolerance = tolerance;
      solver::AdaptiveIntegrator integrator(system, of_integrator);
      result.summary = solver::simulate_adaptive(integrator, model, load, options, record);
    } else {
      solver::IntegratorOptions of_integrator;
      of_integrator.tolerance = tolerance;
      of_integrator.keep_mean = true;
      of_integrator.backward_euler = load.time().scheme == solver::TimeScheme::backward_euler;
      solver::ThermalIntegrator integrator(system, of_integrator);
      result.summary = solver::simulate(integrator, model, {&load}, options, record);
    }
    result.heat = balances[0];
    return result;
  }

  mesh::MachineMesh mesh;
  solver::ThermalSystem system;
  solver::OperatingModel model;
};

/// A bar along x of 0.1 x 0.02 x 0.02 m; nothing acts on it yet.
inline mesh::Machine bar_machine(mesh::Material material = steel()) {
  mesh::Machine m;
  m.name = "bar";
  m.path = "bar/machine.toml";
  m.materials = {std::move(material)};
  m.bodies = {body("bar", m.materials[0].id)};
  m.ambients = {ambient("air", 20.0)};
  for (const char* side : {"x0", "x1", "y0", "y1", "z0", "z1"}) m.surfaces.push_back(surface(side, "bar", {side}));
  m.surfaces.push_back(surface("skin", "bar"));
  return m;
}

inline mesh::MachineMesh bar_mesh(mesh::Machine machine, int order = 1, int finer = 1) {
  mesh::TetMesh bar = box_mesh({0, 0, 0}, {0.1, 0.02, 0.02}, finer * Eigen::Vector3i(10, 2, 2));
  machine.order = order;
  mesh::set_order(bar, order);
  return machine_mesh(std::move(machine), {std::move(bar)});
}

inline mesh::SourceSpec heat_source(const std::string& id, double power, const std::string& surface_id,
                                    const std::string& volume = "") {
  mesh::SourceSpec source;
  source.id = id;
  source.laws = {{"machine.on", {0, 1}, {0, power}}};
  source.places.resize(1);
  source.places[0].surface = surface_id;
  source.places[0].volume = volume;
  return source;
}

}  // namespace thermotwin::test
