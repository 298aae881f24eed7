// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/benchmarks/body_work.h"

#include <Eigen/Cholesky>

#include <vector>

#include "core/thread_pool.h"
#include "solver/elastic/assembly.h"
#include "solver/linear/multigrid.h"
#include "solver/linear/sparse_factor.h"
#include "solver/operation/operating_model.h"
#include "solver/thermal/assembly.h"
#include "solver/thermal/integrator.h"
#include "tools/benchmarks/body_case.h"
#include "tools/benchmarks/report.h"
#include "tools/benchmarks/stopwatch.h"

namespace thermotwin::bench {

void write_files(const Options& options) {
  const Setup setup(options);
  const BodyCase one = body_case(setup.machine_case.machine, options.body, setup.factor, options.folder / "cache");
  write_plain(options.folder / "body.txt", one);
  write_decks(options.folder, one, options.decks);
  print("nodes", one.mesh.nodes());
  print("elements", one.mesh.bodies[0].elements());
}

void heat(const Options& options) {
  const Setup setup(options);
  const BodyCase one = body_case(setup.machine_case.machine, options.body, setup.factor, options.folder / "cache");
  Watch time(options.threads, options.wall);
  const solver::ThermalSystem system = solver::assemble_thermal(one.mesh);
  print("assembly", time.seconds());
  const solver::OperatingModel model(one.mesh.machine, system.layout);
  // Further loads have the same films and other powers.
  std::vector<solver::Coefficients> c(options.columns,
                                      model.coefficients(model.channels().defaults(), Eigen::VectorXd(0)));
  for (std::size_t l = 1; l < c.size(); ++l) c[l].q *= 1.0 + 0.1 * l;
  solver::ThermalIntegrator integrator(system);
  Eigen::MatrixXd state = integrator.uniform(0.0).replicate(1, options.columns);
  time.restart();
  integrator.advance(state, c, one.step_s);
  print("first_step", time.seconds());
  std::vector<double> each;
  for (int i = 1; i < options.steps; ++i) {
    time.restart();
    integrator.advance(state, c, one.step_s);
    each.push_back(time.seconds());
  }
  print("step", median(each));
  const solver::SparseFactor factor(system.conduction + system.capacity / one.step_s);
  print("factor_GB", 1e-9 * factor.memory_bytes());
  print("largest_K", state.col(0).maxCoeff());
  print("mean_K", state.col(0).mean());
}

void memory(const Options& options) {
  constexpr std::size_t chunks = 64, each = 1 << 20;  // 512 MiB
  const std::vector<double> values(chunks * each, 1.0);
  std::vector<double> sums(chunks), seconds;
  for (int i = 0; i < 8; ++i) {
    const Watch time(options.threads, options.wall);
    core::parallel_for(0, chunks, [&](std::size_t chunk) {
      sums[chunk] = Eigen::Map<const Eigen::VectorXd>(values.data() + chunk * each, each).sum();
    });
    seconds.push_back(time.seconds());
  }
  print("GB_s", 8e-9 * (chunks * each) / median(seconds));
  print("checksum", Eigen::Map<const Eigen::VectorXd>(sums.data(), chunks).sum());
}

void elastic(const Options& options) {
  const Setup setup(options);
  const BodyCase one = body_case(setup.machine_case.machine, options.body, setup.factor, options.folder / "cache");
  const mesh::TetMesh& mesh = one.mesh.bodies[0];
  Watch time(options.threads);
  const solver::ElasticBody body =
      solver::assemble_elastic(mesh, one.mesh.machine.material(one.mesh.machine.bodies[0].material), options.body);
  print("assembly", time.seconds());
  time.restart();
  solver::SparseFactorOptions factor_options;
  factor_options.block = 3;
  const solver::SparseFactor factor(body.stiffness, factor_options);
  print("factor", time.seconds());
  print("factor_nonzeros", factor.nonzeros());
  time.restart();
  Eigen::MatrixXd loads = Eigen::MatrixXd::Zero(3 * mesh.nodes(), 3 * load_nodes);
  for (int i = 0; i < load_nodes; ++i)
    for (int k = 0; k < 3; ++k) loads(3 * load_node(mesh.nodes(), i) + k, 3 * i + k) = 1.0;
  solver::clear_fixed(body, loads);
  const Eigen::MatrixXd rows = body.thermal_load.transpose() * factor.solve(loads);
  print("rows", time.seconds());
  print("rows_norm", rows.norm());
}

void iterative(const Options& options) {
  const Setup setup(options);
  const BodyCase one = body_case(setup.machine_case.machine, options.body, setup.factor, options.folder / "cache");
  const mesh::TetMesh& mesh = one.mesh.bodies[0];
  solver::ElasticBody body =
      solver::assemble_elastic(mesh, one.mesh.machine.material(one.mesh.machine.bodies[0].material), options.body);
  constexpr Eigen::Index columns = 8;
  Watch time(options.threads);
  solver::MultigridOptions multigrid;
  multigrid.block = 3;
  multigrid.near_null = body.rigid;
  multigrid.tolerance = 1e-8;
  const solver::MultigridSolver solver(body.stiffness, multigrid);
  print("setup", time.seconds());
  time.restart();
  Eigen::MatrixXd loads = Eigen::MatrixXd::Zero(3 * mesh.nodes(), columns), motion(3 * mesh.nodes(), columns);
  for (int i = 0; i < columns; ++i) loads(3 * load_node(mesh.nodes(), 2 * i + 1) + i % 3, i) = 1.0;
  loads -= body.rigid * (body.rigid.transpose() * body.rigid).llt().solve(body.rigid.transpose() * loads);
  solver::clear_fixed(body, loads);
  print("iterations", solver.solve(loads, motion));
  print("rows_norm", (body.thermal_load.transpose() * motion).norm());
  print("rows", time.seconds());
  print("columns", columns);
  print("multigrid_MiB", solver.memory_bytes() / 1048576.0);
  print("unknowns", loads.rows());
}

}  // namespace thermotwin::bench
