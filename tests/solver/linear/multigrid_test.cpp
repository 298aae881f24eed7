// SPDX-License-Identifier: GPL-3.0-or-later
// Iterative against direct, and the choice between them.
#include "solver/linear/multigrid.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cstring>
#include <malloc.h>
#include <unistd.h>

#include "core/error.h"
#include "core/file.h"
#include "core/thread_pool.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/adaptive_simulation.h"
#include "solver/campaign/simulation.h"
#include "solver/elastic/assembly.h"
#include "solver/linear/available_memory.h"
#include "solver/linear/sparse_factor.h"
#include "solver/thermal/adaptive.h"
#include "solver/thermal/assembly.h"
#include "solver/thermal/direct.h"
#include "solver/thermal/integrator.h"
#include "solver/thermal/memory_plan.h"
#include "tests/machines/box_machine.h"
#include "tests/machines/slide_machine.h"

namespace thermotwin::solver {
namespace {

/// A bar with elements of unequal edges, held at three nodes as the elastic model does it.
ElasticBody bar() {
  return assemble_elastic(test::box_mesh({0, 0, 0}, {1.2, 0.2, 0.3}, {36, 8, 8}), test::steel(), "bar");
}

Eigen::MatrixXd balanced_loads(const ElasticBody& body, Eigen::Index columns) {
  Eigen::MatrixXd loads(body.stiffness.rows(), columns);
  for (Eigen::Index j = 0; j < columns; ++j) {
    for (Eigen::Index i = 0; i < loads.rows(); ++i)
      loads(i, j) = std::sin(0.37 * i + j) + ((i + j) % 97 == 0 ? 5.0 : 0.0);
  }
  loads -= body.rigid * (body.rigid.transpose() * body.rigid).inverse() * (body.rigid.transpose() * loads);
  clear_fixed(body, loads);
  return loads;
}

MultigridOptions elastic_options(const ElasticBody& body, double tolerance) {
  MultigridOptions options;
  options.block = 3;
  options.near_null = body.rigid;
  options.tolerance = tolerance;
  return options;
}

bool same_bits(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return std::memcmp(a.data(), b.data(), sizeof(double) * a.size()) == 0;
}

}  // namespace

TEST(Multigrid, ElasticBodyAgreesWithItsFactor) {
  const ElasticBody body = bar();
  const Eigen::MatrixXd loads = balanced_loads(body, 11);
  SparseFactorOptions factor_options;
  factor_options.block = 3;
  const Eigen::MatrixXd exact = SparseFactor(body.stiffness, factor_options).solve(loads);
  const MultigridSolver solver(body.stiffness, elastic_options(body, 1e-8));
  EXPECT_GE(solver.levels(), 3);
  Eigen::MatrixXd found(loads.rows(), loads.cols());
  EXPECT_LE(solver.solve(loads, found), 60);
  for (Eigen::Index j = 0; j < loads.cols(); ++j) {
    EXPECT_LE((body.stiffness * found.col(j) - loads.col(j)).norm(), 1.01e-8 * loads.col(j).norm()) << j;
    EXPECT_LT((found - exact).col(j).norm(), 1e-5 * exact.col(j).norm()) << j;
  }
  // Without the rotations it gets there too, but not as soon.
  MultigridOptions blind = elastic_options(body, 1e-8);
  blind.near_null.resize(0, 0);
  Eigen::MatrixXd slow(loads.rows(), 1);
  Eigen::MatrixXd fast(loads.rows(), 1);
  EXPECT_GT(MultigridSolver(body.stiffness, blind).solve(loads.leftCols(1), slow),
            solver.solve(loads.leftCols(1), fast));
}

TEST(Multigrid, TheCycleIsSymmetric) {
  const ElasticBody body = bar();
  const Eigen::MatrixXd loads = balanced_loads(body, 2);
  const MultigridSolver solver(body.stiffness, elastic_options(body, 1e-8));
  SideBySide z(loads.rows(), 2);
  solver.precondition(SideBySide(loads), z);
  EXPECT_NEAR(loads.col(0).dot(z.col(1)) / loads.col(1).dot(z.col(0)), 1.0, 1e-9);
  EXPECT_GT(loads.col(0).dot(z.col(0)), 0.0);
}

TEST(Multigrid, SameBitsForAnyNumberOfThreads) {
  const ElasticBody body = bar();
  const Eigen::MatrixXd loads = balanced_loads(body, 19);
  const auto run = [&](int threads) {
    core::set_thread_count(threads);
    Eigen::MatrixXd found(loads.rows(), loads.cols());
    MultigridSolver(body.stiffness, elastic_options(body, 1e-8)).solve(loads, found);
    core::set_thread_count(0);
    return found;
  };
  const Eigen::MatrixXd one = run(1);
  EXPECT_TRUE(same_bits(one, run(2)));
  EXPECT_TRUE(same_bits(one, run(5)));
}

TEST(Multigrid, WhatIsNotHeldIsAnError) {
  // The Laplacian of a closed box: constants cost nothing.
  mesh::Machine machine = test::slide_machine();
  machine.films.clear();
  machine.joints.pop_back();
  const ThermalSystem system = assemble_thermal(test::slide_mesh(2, machine));
  Eigen::MatrixXd x(system.nodes, 1), b = Eigen::MatrixXd::Ones(system.nodes, 1);
  const SparseMatrix closed = system.conduction.topLeftCorner(system.nodes, system.nodes);
  EXPECT_THROW(MultigridSolver(closed).solve(b, x), core::SolverError);
}

TEST(Multigrid, TcpRowsAgreeWithDirectOnes) {
  test::BoxMachineOptions finer;
  finer.finer = 3;
  const mesh::MachineMesh mesh = test::box_machine_mesh(finer);
  const ThermalSystem thermal = assemble_thermal(mesh);
  ElasticOptions iterative;
  iterative.choice = SolverChoice::iterative;
  const ElasticModel direct(mesh, thermal), found(mesh, thermal, iterative);
  EXPECT_EQ(found.summary().solver, LinearSolver::iterative);
  for (const mesh::Pose& pose : {test::box_pose(0, 0), test::box_pose(0.2, -0.1)}) {
    const OutputRows a = direct.output_rows(pose), b = found.output_rows(pose);
    for (Eigen::Index i = 0; i < 6; ++i) {
      EXPECT_LT((a.tool.row(i) - b.tool.row(i)).norm(), 1e-7 * a.tool.row(i).norm()) << i;
      EXPECT_LT((a.table_axis.row(i) - b.table_axis.row(i)).norm(), 1e-7 * a.table_axis.row(i).norm()) << i;
    }
    for (Eigen::Index i = 0; i < 7; ++i)
      EXPECT_LT((a.table_own.row(i) - b.table_own.row(i)).norm(), 1e-7 * a.table_own.row(i).norm()) << i;
    const Eigen::VectorXd temperature = test::uneven_temperature(mesh, thermal.size);
    const Eigen::Matrix3Xd u = direct.displacement(temperature, pose), v = found.displacement(temperature, pose);
    EXPECT_LT((u - v).norm(), 1e-7 * u.norm());
  }
}

TEST(Multigrid, TemperaturesAgreeWithDirectOnes) {
  ThermalSystem direct = assemble_thermal(test::slide_mesh(3)), iterative = assemble_thermal(test::slide_mesh(3));
  iterative.solver = LinearSolver::iterative;
  const mesh::Machine machine = test::slide_machine();
  const OperatingModel model(machine, direct.layout);
  Eigen::VectorXd row = model.channels().defaults();
  row[model.channels().index("spindle.speed_rpm")] = 6000;
  const Coefficients c = model.coefficients(row, Eigen::VectorXd::Constant(1, -2.0));
  const Eigen::VectorXd steady = solve_steady(direct, c);
  EXPECT_LT((solve_steady(iterative, c) - steady).cwiseAbs().maxCoeff(), 1e-7 * steady.cwiseAbs().maxCoeff());
  // Adjoints with the coolant's flow.
  const Eigen::MatrixXd right = direct.sensors.transpose();
  const Eigen::MatrixXd adjoint = solve_shifted(direct, c, 1e-4, right, true);
  EXPECT_LT((solve_shifted(iterative, c, 1e-4, right, true) - adjoint).cwiseAbs().maxCoeff(),
            1e-8 * adjoint.cwiseAbs().maxCoeff());

  const std::string program =
      "schema = 1\noutput_s = 600\n[[phase]]\nduration_s = 1200\nspindle_rpm = 9000\n"
      "[[phase]]\nduration_s = 1200\nspindle_rpm = 0\ncutting_fluid = true\n";
  const LoadProgram fixed = LoadProgram::parse(program, "p.toml", machine);
  const LoadProgram adaptive =
      LoadProgram::parse("schema = 1\noutput_s = 600\n[time]\n" + program.substr(25), "p.toml", machine);
  SimulationOptions options;
  options.progress = false;
  for (const bool by_error : {false, true}) {
    std::vector<Eigen::VectorXd> states[2];
    const auto run = [&](const ThermalSystem& system, std::vector<Eigen::VectorXd>& found) {
      const auto keep = [&](const OutputState& out) { found.push_back(out.state); };
      if (by_error) {
        AdaptiveIntegrator integrator(system);
        simulate_adaptive(integrator, model, adaptive, options, keep);
      } else {
        ThermalIntegrator integrator(system);
        simulate(integrator, model, {&fixed}, options, keep);
      }
    };
    run(direct, states[0]);
    run(iterative, states[1]);
    for (std::size_t i = 1; i < states[0].size(); ++i) {
      EXPECT_LT((states[0][i] - states[1][i]).cwiseAbs().maxCoeff(), 1e-6 * states[0][i].cwiseAbs().maxCoeff())
          << by_error << i;
    }
  }
}

TEST(MemoryPlan, PredictsTheFactor) {
  const ElasticBody body =
      assemble_elastic(test::box_mesh({0, 0, 0}, {1.0, 0.8, 0.6}, {20, 16, 12}), test::steel(), "block");
  SparseFactorOptions options;
  options.block = 3;
  const SparseAnalysis analysis = analyse(body.stiffness, options);
  const auto in_use = [] {
    const struct mallinfo2 info = mallinfo2();
    return 1.0 * info.uordblks + info.hblkhd;
  };
  const double before = in_use();
  const SparseFactor factor(body.stiffness, options, analysis);
  const double taken = in_use() - before;
  EXPECT_GT(factor.memory_bytes(), 2e7);
  EXPECT_NEAR(analysis.factor_bytes / factor.memory_bytes(), 1.0, 0.01);
  EXPECT_NEAR(analysis.factor_bytes / taken, 1.0, 0.3);
  EXPECT_FALSE(analysis.wide);
  // With 64-bit indices the same numbers.
  options.force_wide = true;
  const SparseFactor wide(body.stiffness, options);
  EXPECT_TRUE(wide.wide());
  EXPECT_TRUE(wide.clone().wide());
  const Eigen::MatrixXd loads = balanced_loads(body, 2);
  EXPECT_LT((wide.solve(loads) - factor.solve(loads)).norm(), 1e-12 * factor.solve(loads).norm());
}

TEST(MemoryPlan, ChoosesWhatFits) {
  constexpr double GB = 1e9;
  MemoryPlan plan;
  plan.heat = {1 * GB, 0.2 * GB, 0.5 * GB, 0.3 * GB};
  plan.elastic = {10 * GB, 2 * GB, 1 * GB, 1.5 * GB};
  const auto choose = [&](SolverChoice choice, double available) {
    decide(plan, choice, available);
    return std::pair(plan.heat_solver, plan.elastic_solver);
  };
  const auto direct = LinearSolver::direct, iterative = LinearSolver::iterative;
  EXPECT_EQ(choose(SolverChoice::automatic, 20 * GB), std::pair(direct, direct));
  EXPECT_EQ(choose(SolverChoice::automatic, 15 * GB), std::pair(direct, iterative));
  EXPECT_EQ(choose(SolverChoice::automatic, 5 * GB), std::pair(iterative, iterative));
  EXPECT_EQ(choose(SolverChoice::iterative, 20 * GB), std::pair(iterative, iterative));
  EXPECT_EQ(choose(SolverChoice::direct, 15 * GB), std::pair(direct, direct));
  EXPECT_THROW(decide(plan, SolverChoice::direct, 10 * GB), core::SolverError);
  EXPECT_THROW(decide(plan, SolverChoice::automatic, 2 * GB), core::SolverError);
  EXPECT_THROW(solver_choice("fast", "--solver"), core::InputError);
}

TEST(MemoryPlan, AvailableMemoryHeedsCgroups) {
  const auto root = std::filesystem::temp_directory_path() / ("thermotwin_memory_" + std::to_string(::getpid()));
  std::filesystem::create_directories(root / "a" / "b");
  core::write_file(root / "meminfo", "MemTotal: 32000000 kB\nMemFree: 1000000 kB\nMemAvailable: 16000000 kB\n");
  const auto available = [&](const std::string& group) {
    return available_memory((root / "meminfo").string(), group, root.string());
  };
  EXPECT_DOUBLE_EQ(available("0::/a/b\n"), 16e6 * 1024);
  core::write_file(root / "a" / "b" / "memory.max", "max\n");
  core::write_file(root / "a" / "b" / "memory.current", "1000\n");
  EXPECT_DOUBLE_EQ(available("0::/a/b\n"), 16e6 * 1024);
  core::write_file(root / "a" / "memory.max", "8000000000\n");  // of the group around it
  core::write_file(root / "a" / "memory.current", "3000000000\n");
  core::write_file(root / "a" / "memory.stat", "anon 5\ninactive_file 500000000\n");
  EXPECT_DOUBLE_EQ(available("0::/a/b\n"), 5.5e9);
  EXPECT_GT(available_memory(), 1e7);
  std::filesystem::remove_all(root);
}

}  // namespace thermotwin::solver
