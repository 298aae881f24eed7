// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/thermal/integrator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <numbers>
#include <random>

#include "core/binary.h"
#include "core/thread_pool.h"
#include "solver/operation/layout.h"
#include "solver/thermal/assembly.h"
#include "solver/thermal/direct.h"
#include "solver/thermal/system.h"
#include "tests/machines/slide_machine.h"

namespace thermotwin::solver {

namespace {

struct Rig {
  explicit Rig(int refine = 1)
      : mesh(test::slide_mesh(refine)),
        system(assemble_thermal(mesh)),
        model(mesh.machine, system.layout) {}

  /// Speed, position, fluid and coolant that change from step to step, other ones for each load.
  Coefficients coefficients(int step, int load) const {
    Eigen::VectorXd row = model.channels().defaults();
    const auto at = [&](const std::string& name) -> double& { return row[model.channels().index(name)]; };
    at("spindle.speed_rpm") = 1500.0 * ((step + 3 * load) % 8);
    at("axis.X.position_mm") = 200.0 * std::sin(0.9 * step + load);
    at("axis.X.feed_mm_min") = 6000.0 * ((step + load) % 4);
    at("cutting_fluid.on") = (step / 3 + load) % 2;
    at("coolant.main.on") = (step / 4 + load) % 2;
    at("air.T_C") = 20.0 + load + 0.3 * step;
    return model.coefficients(row, Eigen::VectorXd::Constant(1, 1.0 - load));
  }

  Eigen::VectorXd conducted(const Coefficients& c, const Eigen::VectorXd& x) const {
    Eigen::VectorXd k = system.conduction * x;
    for (std::size_t t = 0; t < system.terms.size(); ++t) k += c.p[t] * (system.terms[t] * x);
    return k;
  }

  mesh::MachineMesh mesh;
  ThermalSystem system;
  OperatingModel model;
};

IntegratorOptions strict(bool backward_euler) {
  IntegratorOptions options;
  options.tolerance = 1e-13;
  options.backward_euler = backward_euler;
  return options;
}

/// Backward Euler by a new factorisation in each step.
Eigen::VectorXd direct_step(const Rig& s, ThermalDirectSolver& solver, const Coefficients& c,
                            const Eigen::VectorXd& state, double h) {
  solver.factorise(c.p, 1.0 / h);
  return solver.solve(s.system.inputs * c.q + s.system.capacity * state / h);
}

/// SDIRK2 in its textbook form, with the same direct solves.
Eigen::VectorXd direct_sdirk_step(const Rig& s, ThermalDirectSolver& solver, const Coefficients& c,
                                  const Eigen::VectorXd& state, double h) {
  const double g = sdirk_gamma;
  solver.factorise(c.p, 1.0 / (g * h));
  const Eigen::VectorXd f = s.system.inputs * c.q;
  const Eigen::VectorXd k1 = solver.solve(f - s.conducted(c, state)) / (g * h);
  const Eigen::VectorXd k2 = solver.solve(f - s.conducted(c, state + (1 - g) * h * k1)) / (g * h);
  return state + h * ((1 - g) * k1 + g * k2);
}

}  // namespace

TEST(ThermalIntegrator, ChangingLoadsMatchANewFactorisationInEachStep) {
  const Rig s;
  for (bool backward_euler : {true, false}) {
    ThermalIntegrator integrator(s.system, strict(backward_euler));
    ThermalDirectSolver direct(s.system);
    constexpr int loads = 3;
    Eigen::MatrixXd state = Eigen::MatrixXd::Zero(s.system.size, loads), expected = state;
    for (int step = 0; step < 24; ++step) {
      const double h = step < 12 ? 60.0 : 35.0;
      std::vector<Coefficients> c;
      for (int l = 0; l < loads; ++l) {
        c.push_back(s.coefficients(step, l));
        expected.col(l) = backward_euler ? direct_step(s, direct, c.back(), expected.col(l), h)
                                         : direct_sdirk_step(s, direct, c.back(), expected.col(l), h);
      }
      integrator.advance(state, c, h);
    }
    EXPECT_GT(expected.cwiseAbs().maxCoeff(), 1.0);
    EXPECT_LT((state - expected).cwiseAbs().maxCoeff(), 1e-9 * expected.cwiseAbs().maxCoeff()) << backward_euler;
    EXPECT_LT(integrator.statistics().factorisations, 24);
  }
}

TEST(ThermalIntegrator, ConstantCoefficientsNeedOneFactorAndOneIterationAStage) {
  const Rig s;
  ThermalIntegrator integrator(s.system);
  Eigen::MatrixXd state = Eigen::MatrixXd::Zero(s.system.size, 1);
  for (int step = 0; step < 10; ++step) integrator.advance(state, {s.coefficients(5, 1)}, 60.0);
  EXPECT_EQ(integrator.statistics().factorisations, 1);
  EXPECT_EQ(integrator.statistics().iterations, 20);
}

TEST(ThermalIntegrator, ALongRunEndsInTheSteadyState) {
  const Rig s;
  const Coefficients c = s.coefficients(2, 1);
  ThermalIntegrator integrator(s.system);
  Eigen::MatrixXd state = Eigen::MatrixXd::Zero(s.system.size, 1);
  for (int step = 0; step < 60; ++step) integrator.advance(state, {c}, 20000.0);
  const Eigen::VectorXd steady = solve_steady(s.system, c);
  EXPECT_LT((state - steady).cwiseAbs().maxCoeff(), 1e-7 * steady.cwiseAbs().maxCoeff());
}

TEST(ThermalIntegrator, HeatIsBalancedInEveryStep) {
  // What is stored is what came in by sources, films, mounts and the coolant's flow, each computed
  // from the temperatures at the end of the step (backward Euler).
  const Rig s;
  ThermalIntegrator integrator(s.system, strict(true));
  const Eigen::VectorXd one = Eigen::VectorXd::Ones(s.system.size);
  Eigen::MatrixXd state = Eigen::MatrixXd::Constant(s.system.size, 1, 2.0);
  double imbalance = 0.0, throughput = 0.0;
  for (int step = 0; step < 30; ++step) {
    constexpr double h = 45.0;
    const Coefficients c = s.coefficients(step, 2);
    const Eigen::VectorXd before = state;
    integrator.advance(state, {c}, h);
    double in = 0.0;
    for (std::size_t k = 0; k < s.system.layout.inputs.size(); ++k) {
      const Input& input = s.system.layout.inputs[k];
      const Eigen::Index index = k;
      const double given = c.q[index] * s.system.inputs.col(index).sum();
      double lost = 0.0;
      if (input.kind == InputKind::film_ambient || input.kind == InputKind::contact_ambient)
        lost = c.p[input.term] * state.col(0).dot(Eigen::VectorXd(s.system.inputs.col(index)));  // p * integral of T
      if (input.kind == InputKind::coolant_inlet)
        lost = c.p[input.term] * s.mesh.machine.coolants[0].specific_heat * state(s.system.size - 1, 0);  // outlet
      in += h * (given - lost);
      throughput += h * (std::abs(given) + std::abs(lost));
    }
    imbalance += std::abs(one.dot(s.system.capacity * (state.col(0) - before)) - in);
  }
  EXPECT_GT(throughput, 1e5);
  EXPECT_LT(imbalance, 1e-10 * throughput);
}

TEST(ThermalIntegrator, AnInsulatedMachineStoresAllPower) {
  mesh::Machine machine = test::slide_machine();
  machine.films.clear();
  machine.joints.pop_back();  // the mount
  const mesh::MachineMesh mesh = test::slide_mesh(1, machine);
  const ThermalSystem system = assemble_thermal(mesh);
  const OperatingModel model(machine, system.layout);
  Eigen::VectorXd row = model.channels().defaults();
  row[model.channels().index("spindle.speed_rpm")] = 12000;
  row[model.channels().index("axis.X.feed_mm_min")] = 30000;
  row[model.channels().index("axis.X.low_mm")] = -200;
  row[model.channels().index("axis.X.high_mm")] = 150;
  row[model.channels().index("coolant.main.on")] = 0;
  ThermalIntegrator integrator(system, strict(false));
  Eigen::MatrixXd state = Eigen::MatrixXd::Zero(system.size, 1);
  for (int step = 0; step < 20; ++step) {
    row[model.channels().index("axis.X.high_mm")] = 150 - 5 * step;  // a pad that moves keeps the heat
    integrator.advance(state, {model.coefficients(row, Eigen::VectorXd::Zero(1))}, 60.0);
  }
  // Of the motor's 240 W, a tenth leaves with the air.
  const double power = 0.9 * 240.0 + 90.0 + 40.0, stored = (system.capacity * state).sum();
  EXPECT_NEAR(stored / (power * 1200.0), 1.0, 1e-10);
}

TEST(ThermalIntegrator, ObservedOrdersInTime) {
  const Rig s;
  const Coefficients base = s.coefficients(3, 0);
  constexpr double duration = 4000.0;
  // The air warms up and cools down smoothly; each step sees its exact mean.
  const auto run = [&](int steps, bool backward_euler) {
    ThermalIntegrator integrator(s.system, strict(backward_euler));
    Eigen::MatrixXd state = Eigen::MatrixXd::Zero(s.system.size, 1);
    const double h = duration / steps, w = 2.0 * std::numbers::pi / duration;
    for (int i = 0; i < steps; ++i) {
      const double a = i * h, b = a + h;
      const double mean = 0.5 * (1.0 - (std::sin(w * b) - std::sin(w * a)) / (w * h));  // of sin^2
      Coefficients c = base;
      c.q *= mean;
      integrator.advance(state, {c}, h);
    }
    return Eigen::VectorXd(state.col(0));
  };
  const Eigen::VectorXd exact = run(2560, false);
  const auto order = [&](bool backward_euler) {
    const double coarse = (run(80, backward_euler) - exact).norm(), fine = (run(160, backward_euler) - exact).norm();
    return std::log2(coarse / fine);
  };
  EXPECT_NEAR(order(false), 2.0, 0.1);
  EXPECT_NEAR(order(true), 1.0, 0.1);
}

TEST(ThermalIntegrator, SameBitsForAnyNumberOfThreads) {
  const auto run = [](int threads) {
    core::set_thread_count(threads);
    const Rig s(3);
    ThermalIntegrator integrator(s.system);
    Eigen::MatrixXd state = Eigen::MatrixXd::Zero(s.system.size, 7);
    for (int step = 0; step < 6; ++step) {
      std::vector<Coefficients> c;
      for (int l = 0; l < 7; ++l) c.push_back(s.coefficients(step, l));
      integrator.advance(state, c, 60.0);
    }
    core::set_thread_count(0);
    return state;
  };
  const Eigen::MatrixXd one = run(1), two = run(2), five = run(5);
  EXPECT_EQ(std::memcmp(one.data(), two.data(), sizeof(double) * one.size()), 0);
  EXPECT_EQ(std::memcmp(one.data(), five.data(), sizeof(double) * one.size()), 0);
}

TEST(ThermalIntegrator, ALoadDoesNotDependOnItsNeighboursBeyondTheTolerance) {
  const Rig s;
  ThermalIntegrator alone(s.system, strict(false)), together(s.system, strict(false));
  Eigen::MatrixXd single = Eigen::MatrixXd::Zero(s.system.size, 1), block = Eigen::MatrixXd::Zero(s.system.size, 4);
  for (int step = 0; step < 10; ++step) {
    std::vector<Coefficients> c;
    for (int l = 0; l < 4; ++l) c.push_back(s.coefficients(step, l));
    together.advance(block, c, 60.0);
    alone.advance(single, {c[2]}, 60.0);
  }
  EXPECT_LT((block.col(2) - single.col(0)).cwiseAbs().maxCoeff(), 1e-9 * single.cwiseAbs().maxCoeff());
}

TEST(ThermalIntegrator, AFirstGuessOfEarlierStepsSavesIterationsOnly) {
  const Rig s;
  constexpr int loads = 4, steps = 40;
  const auto run = [&](int recycled, int stop, long& iterations) {
    IntegratorOptions options;
    options.tolerance = 1e-11;
    options.recycled = recycled;
    options.factor_memory = 0.0;  // one factor, which fits no load
    auto integrator = std::make_unique<ThermalIntegrator>(s.system, options);
    Eigen::MatrixXd state = Eigen::MatrixXd::Zero(s.system.size, loads);
    for (int step = 0; step < steps; ++step) {
      std::vector<Coefficients> c;
      for (int l = 0; l < loads; ++l) c.push_back(s.coefficients(step / 20, l));
      if (step == stop) {
        // From a checkpoint it goes on with the same bits.
        core::BinaryWriter out;
        integrator->save(out);
        integrator = std::make_unique<ThermalIntegrator>(s.system, options);
        core::BinaryReader in(out.bytes(), "checkpoint");
        integrator->load(in);
      }
      integrator->advance(state, c, 60.0);
    }
    iterations = integrator->statistics().iterations;
    return state;
  };
  long without = 0, with = 0, resumed = 0;
  const Eigen::MatrixXd plain = run(0, -1, without), guessed = run(8, -1, with), again = run(8, 13, resumed);
  EXPECT_LT(with, 0.8 * without);
  EXPECT_LT((guessed - plain).cwiseAbs().maxCoeff(), 1e-8 * plain.cwiseAbs().maxCoeff());
  EXPECT_EQ(guessed, again);
  EXPECT_EQ(with, resumed);
}

}  // namespace thermotwin::solver
