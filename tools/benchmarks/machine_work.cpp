// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/benchmarks/machine_work.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/thread_pool.h"
#include "mesh/machine/kinematics.h"
#include "reduction/model/model_file.h"
#include "reduction/model/reduced_simulation.h"
#include "solver/elastic/model.h"
#include "solver/operation/operating_model.h"
#include "solver/thermal/assembly.h"
#include "solver/thermal/integrator.h"
#include "tools/benchmarks/report.h"
#include "tools/benchmarks/stopwatch.h"

namespace thermotwin::bench {

namespace {

/// Coefficients of each step of a load program, chillers at the reference temperature.
std::vector<solver::Coefficients> coefficients(const solver::OperatingModel& model, const solver::LoadProgram& load,
                                               const std::vector<double>& ends) {
  const Eigen::VectorXd inlet = Eigen::VectorXd::Zero(std::ssize(model.machine().coolants));
  std::vector<solver::Coefficients> all;
  double from = 0.0;
  for (const double end : ends) {
    all.push_back(model.coefficients(load.row(from, end), inlet));
    from = end;
  }
  return all;
}

std::vector<double> first_steps(const solver::LoadProgram& load, int steps) {
  std::vector<double> ends = load.step_ends();
  ends.resize(std::min<std::size_t>(ends.size(), steps));
  return ends;
}

}  // namespace

void loads(const Options& options) {
  const Setup setup(options);
  const mesh::MachineMesh mesh = setup.mesh(options);
  const solver::ThermalSystem system = solver::assemble_thermal(mesh);
  const solver::OperatingModel model(mesh.machine, system.layout);
  std::vector<std::string> names;
  if (options.set == "ambient") {
    for (int i = 1; i <= 9; ++i) names.push_back(fmt::format("ambient_{}", i));
  } else {
    names = {"spindle_3000", "spindle_6000", "spindle_12000", "x_rapid",   "y_rapid",
             "z_rapid",      "table_150",    "table_600",     "table_1200"};
  }
  std::vector<std::vector<solver::Coefficients>> c;
  std::vector<double> ends;
  for (const std::string& name : names) {
    const solver::LoadProgram load = setup.machine_case.load(name);
    const std::vector<double> own = first_steps(load, options.steps);
    if (!ends.empty() && own != ends)
      throw core::InputError(name, "other time steps than " + names[0], "loads of one time grid");
    ends = own;
    c.push_back(coefficients(model, load, ends));
  }
  Watch time(options.threads);
  const std::size_t width = options.apart ? 1 : names.size();
  double checksum = 0;
  for (std::size_t first = 0; first < names.size(); first += width) {
    solver::ThermalIntegrator integrator(system);
    Eigen::MatrixXd state = integrator.uniform(0.0).replicate(1, width);
    for (std::size_t i = 0; i < ends.size(); ++i) {
      std::vector<solver::Coefficients> now;
      for (std::size_t l = first; l < first + width; ++l) now.push_back(c[l][i]);
      integrator.advance(state, now, ends[i] - (i == 0 ? 0.0 : ends[i - 1]));
    }
    checksum += state.sum();
  }
  print("load_step", time.seconds() / (names.size() * ends.size()));
  print("mean_K", checksum / (system.size * names.size()));
  print("unknowns", system.size);
}

void poses(const Options& options) {
  const Setup setup(options);
  const mesh::MachineMesh mesh = setup.mesh(options);
  const solver::ThermalSystem system = solver::assemble_thermal(mesh);
  Watch time(options.threads);
  const solver::ElasticModel model(mesh, system);
  print("model", time.seconds());
  print("factor", model.summary().factor_seconds);
  print("unit_solves", model.summary().unit_solves);
  const std::vector<mesh::Pose> grid = mesh::workspace_poses(mesh.machine);
  std::vector<double> each;
  for (const mesh::Pose& pose : grid) {
    time.restart();
    if (!model.output_rows(pose).tool.allFinite()) throw core::SolverError("rows that are not finite");
    each.push_back(time.seconds());
  }
  print("pose", median(each));
  time.restart();
  core::parallel_for(0, grid.size(), [&](std::size_t i) { model.output_rows(grid[i]); });
  print("all_poses", time.seconds());
  print("poses", grid.size());
  print("nodes", mesh.nodes());
}

void steps(const Options& options) {
  const Setup setup(options);
  const mesh::MachineMesh mesh = setup.mesh(options);
  const solver::ThermalSystem system = solver::assemble_thermal(mesh);
  const reduction::ReducedModel reduced = reduction::read_model(options.model);
  const solver::LoadProgram load = setup.machine_case.load(options.load);
  const std::vector<double> ends = first_steps(load, options.steps);
  const solver::OperatingModel model(mesh.machine, system.layout);
  const std::vector<solver::Coefficients> c = coefficients(model, load, ends);
  solver::ThermalIntegrator full(system);
  reduction::ReducedStepper stepper(reduced.system);
  Eigen::MatrixXd state = full.uniform(load.initial_C() - mesh.machine.reference_C);
  Eigen::VectorXd small = stepper.uniform(load.initial_C() - mesh.machine.reference_C);
  double full_s = 0, reduced_s = 0;
  for (std::size_t first = 0; first < ends.size(); first += 10) {
    const std::size_t last = std::min(ends.size(), first + 10);
    const auto size = [&](std::size_t i) { return ends[i] - (i == 0 ? 0.0 : ends[i - 1]); };
    Watch time(options.threads);
    for (std::size_t i = first; i < last; ++i) full.advance(state, {c[i]}, size(i));
    full_s += time.seconds();
    time.restart();
    for (std::size_t i = first; i < last; ++i) stepper.advance(small, c[i], size(i));
    reduced_s += time.seconds();
  }
  const double count = ends.size();
  const mesh::Pose home = mesh::home_pose(mesh.machine);
  Watch time(options.threads);
  double sum = 0;
  for (int i = 0; i < 1000; ++i) sum += reduced.tcp(small, home).error[0];
  print("tcp", time.seconds() / 1000);
  print("tcp_um", 1e3 * sum);
  print("full", full_s / count);
  print("reduced", reduced_s / count);
  print("order", reduced.system.order());
  print("unknowns", system.size);
  // Sensors of both at the end: the same physics was run.
  print("sensors_apart_K", (full.sensors(state) - stepper.sensors(small)).cwiseAbs().maxCoeff());
}

}  // namespace thermotwin::bench
