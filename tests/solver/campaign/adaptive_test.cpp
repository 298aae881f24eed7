// SPDX-License-Identifier: GPL-3.0-or-later
// TR-BDF2 with error control: orders, ladder of steps, cooler switches.
#include "solver/thermal/adaptive.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.h"
#include "solver/campaign/adaptive_simulation.h"
#include "solver/campaign/simulation.h"
#include "solver/operation/layout.h"
#include "solver/thermal/assembly.h"
#include "solver/thermal/integrator.h"
#include "tests/machines/slide_machine.h"

namespace thermotwin::solver {
namespace {

struct Rig {
  explicit Rig(mesh::Machine machine = test::slide_machine())
      : mesh(test::slide_mesh(1, std::move(machine))),
        system(assemble_thermal(mesh)),
        model(mesh.machine, system.layout) {}

  LoadProgram program(const std::string& text) const {
    return LoadProgram::parse("schema = 1\n" + text, "p.toml", mesh.machine);
  }

  struct Result {
    RunSummary summary;
    std::vector<double> times;
    std::vector<Eigen::VectorXd> states;
  };
  Result run(const LoadProgram& load, double solver_tolerance = 1e-12) const {
    Result result;
    AdaptiveOptions options;
    options.tolerance = solver_tolerance;
    AdaptiveIntegrator integrator(system, options);
    SimulationOptions simulation;
    simulation.progress = false;
    result.summary = simulate_adaptive(integrator, model, load, simulation, [&](const OutputState& out) {
      result.times.push_back(out.time);
      result.states.push_back(out.state);
    });
    return result;
  }

  mesh::MachineMesh mesh;
  ThermalSystem system;
  OperatingModel model;
};

/// Warm-up, cool-down under another film, a ramp of the air; no chiller in the loop.
const std::string program_text =
    "initial_C = 20\noutput_s = 900\n"
    "[[phase]]\nduration_s = 3600\nspindle_rpm = 9000\ncoolant = false\n"
    "[[phase.axis]]\nid = \"X\"\nlow_mm = -150\nhigh_mm = 150\nfeed_mm_min = 20000\n"
    "[[phase]]\nduration_s = 2700\nspindle_rpm = 0\ncutting_fluid = true\nair_C = [20.0, 26.0]\n"
    "[[phase]]\nduration_s = 4500\ncutting_fluid = false\n";

std::string adaptive(double tolerance_K, double longest_s = 7200) {
  return fmt::format("[time]\ntolerance_K = {}\nlongest_step_s = {}\nshortest_step_s = 0.001\n", tolerance_K,
                     longest_s);
}

}  // namespace

TEST(AdaptiveIntegrator, SecondOrderAndAnEstimateOfThirdOrder) {
  const Rig s;
  Eigen::VectorXd row = s.model.channels().defaults();
  row[s.model.channels().index("spindle.speed_rpm")] = 6000;
  const Coefficients base = s.model.coefficients(row, Eigen::VectorXd::Constant(1, -1.0));
  constexpr double duration = 4000.0;
  double estimate = 0.0;
  const auto run = [&](int steps) {
    AdaptiveOptions options;
    options.tolerance = 1e-13;
    AdaptiveIntegrator integrator(s.system, options);
    Eigen::VectorXd state = Eigen::VectorXd::Zero(s.system.size);
    const double h = duration / steps, w = std::numbers::pi / duration;
    const auto q = [&](double t) { return Eigen::VectorXd(base.q * std::pow(std::sin(w * t), 2)); };
    AdaptiveIntegrator::Step step;
    for (int i = 0; i < steps; ++i) {
      integrator.attempt(state, base.p, {q(i * h), q((i + tr_bdf2_stage) * h), q((i + 1) * h)}, h, true, step);
      state = step.end;
      if (i == steps / 4) estimate = step.error_K;
    }
    EXPECT_EQ(integrator.statistics().factorisations, 1);
    return state;
  };
  const Eigen::VectorXd exact = run(2560);
  const double coarse = (run(80) - exact).norm(), coarse_estimate = estimate;
  const double fine = (run(160) - exact).norm();
  EXPECT_NEAR(std::log2(coarse / fine), 2.0, 0.1);
  EXPECT_NEAR(std::log2(coarse_estimate / estimate), 3.0, 0.3);
}

TEST(AdaptiveIntegrator, WithoutTheEstimateAStepIsTheSameForTwoSolvesOfThree) {
  const Rig s;
  Eigen::VectorXd row = s.model.channels().defaults();
  row[s.model.channels().index("spindle.speed_rpm")] = 6000;
  const Coefficients c = s.model.coefficients(row, Eigen::VectorXd::Constant(1, -1.0));
  AdaptiveIntegrator integrator(s.system);
  AdaptiveIntegrator::Step with, without;
  const Eigen::VectorXd start = Eigen::VectorXd::Zero(s.system.size);
  integrator.attempt(start, c.p, {c.q, c.q, c.q}, 60.0, true, with);
  EXPECT_EQ(integrator.statistics().solves, 3);
  without.error_K = 1e9;
  integrator.attempt(start, c.p, {c.q, c.q, c.q}, 60.0, true, without, false);
  EXPECT_EQ(integrator.statistics().solves, 5);
  EXPECT_GT(with.error_K, 0.0);
  EXPECT_EQ(without.error_K, 0.0);
  EXPECT_EQ(with.stage, without.stage);
  EXPECT_EQ(with.end, without.end);
}

TEST(AdaptiveIntegrator, FactorsOfSinglePrecisionReachTheTolerance) {
  const Rig s;
  Eigen::VectorXd row = s.model.channels().defaults();
  row[s.model.channels().index("spindle.speed_rpm")] = 6000;
  const Coefficients c = s.model.coefficients(row, Eigen::VectorXd::Constant(1, -1.0));
  AdaptiveIntegrator exact(s.system, {.tolerance = 1e-12});
  for (const double tolerance : {1e-5, 1e-10}) {
    AdaptiveIntegrator rounded(s.system, {.tolerance = tolerance, .single_precision = true});
    AdaptiveIntegrator::Step one, other;
    Eigen::VectorXd start = Eigen::VectorXd::Zero(s.system.size);
    for (int step = 0; step < 20; ++step) {
      exact.attempt(start, c.p, {c.q, c.q, c.q}, 300.0, true, one);
      rounded.attempt(start, c.p, {c.q, c.q, c.q}, 300.0, true, other);
      EXPECT_LT((one.end - other.end).norm(), 10.0 * tolerance * one.end.norm()) << step;
      EXPECT_NE(one.end, other.end);
      start = one.end;
    }
    EXPECT_EQ(rounded.statistics().factorisations, 1);
    if (tolerance > 1e-6)
      EXPECT_EQ(rounded.statistics().iterations, rounded.statistics().solves);
    else
      EXPECT_GT(rounded.statistics().iterations, rounded.statistics().solves);
  }
}

TEST(AdaptiveIntegrator, TheErrorFollowsTheTolerance) {
  const Rig s;
  const auto exact = s.run(s.program(program_text + adaptive(1e-7)));
  double last = 1e300;
  for (const double tolerance : {1e-1, 1e-2, 1e-3, 1e-4}) {
    const auto found = s.run(s.program(program_text + adaptive(tolerance)));
    ASSERT_EQ(found.times, exact.times);
    double error = 0.0;
    for (std::size_t i = 0; i < exact.states.size(); ++i)
      error = std::max(error, (found.states[i] - exact.states[i]).cwiseAbs().maxCoeff());
    EXPECT_LT(error, 5.0 * tolerance) << tolerance;
    EXPECT_LT(error, 0.5 * last) << tolerance;
    EXPECT_EQ(found.summary.over_tolerance, 0);
    last = error;
  }
}

TEST(AdaptiveIntegrator, AgreesWithFixedStepsAndNeedsFewerOfThem) {
  const Rig s;
  const LoadProgram steps = s.program(program_text + adaptive(1e-3)),
                    fixed = s.program("time_step_s = 5\n" + program_text);
  ASSERT_EQ(fixed.time().scheme, TimeScheme::fixed);
  const auto found = s.run(steps);
  ThermalIntegrator integrator(s.system);
  SimulationOptions options;
  options.progress = false;
  std::size_t i = 0;
  const RunSummary summary = simulate(integrator, s.model, {&fixed}, options, [&](const OutputState& out) {
    EXPECT_LT((out.state - found.states[i]).cwiseAbs().maxCoeff(), 0.02) << out.time;
    EXPECT_DOUBLE_EQ(out.time, found.times[i++]);
  });
  EXPECT_EQ(i, found.states.size());
  EXPECT_LT(found.summary.steps, summary.steps / 5);
}

TEST(AdaptiveIntegrator, StepsStandOnALadderAndFactorsAreKept) {
  const Rig s;
  const auto found = s.run(s.program(program_text + adaptive(1e-3)), 1e-9);
  EXPECT_EQ(found.summary.shortest_step,
            std::ldexp(900.0, static_cast<int>(std::log2(found.summary.shortest_step / 900.0))));
  EXPECT_LE(found.summary.longest_step, 900.0);  // the outputs' distance
  EXPECT_LT(found.summary.factorisations, found.summary.steps / 2);
  EXPECT_GT(found.summary.factorisations, 3);
  // Corners and outputs are met to the bit.
  for (std::size_t i = 0; i < found.times.size(); ++i) EXPECT_EQ(found.times[i], 900.0 * i);
}

TEST(AdaptiveIntegrator, OutputsCanBeChosen) {
  const Rig s;
  LoadProgram load = s.program(program_text + adaptive(1e-3));
  const auto all = s.run(load);
  load.choose_outputs({0.0, 1234.5, 3600.0, 7000.25}, "--output-times");
  const auto found = s.run(load);
  EXPECT_EQ(found.times, (std::vector<double>{0.0, 1234.5, 3600.0, 7000.25}));
  EXPECT_LT((found.states[2] - all.states[4]).cwiseAbs().maxCoeff(), 5e-3);
  EXPECT_THROW(load.choose_outputs({0.0, 20000.0}, "--output-times"), core::InputError);
  EXPECT_THROW(load.choose_outputs({50.0, 20.0}, "--output-times"), core::InputError);
}

namespace {

/// The coolant's chiller switches; what guides it is the air or the bed below the slide that it cools.
mesh::Machine switching_machine(bool guided_by_bed) {
  mesh::Machine machine = test::slide_machine();
  mesh::CoolantSpec& coolant = machine.coolants[0];
  coolant.control = mesh::ChillerControl::two_point;
  coolant.band = 1.0;
  coolant.pull_down = 4.0;
  coolant.drift_up = 2.0;
  coolant.time_constant = 300.0;
  coolant.guide_sensor = guided_by_bed ? "T1" : "";
  return machine;
}

}  // namespace

TEST(TwoPointCooler, SwitchesWhereTheExponentialsMeetTheBand) {
  const Rig s(switching_machine(false));
  const auto found =
      s.run(s.program("output_s = 1800\n[[phase]]\nduration_s = 7200\nspindle_rpm = 6000\n" + adaptive(0.01)));
  // From the set point up to +0.5, then between the band's ends.
  const double tau = 300.0, up = tau * std::log(2.5 / 1.5), down = tau * std::log(4.5 / 3.5);
  double time = tau * std::log(2.0 / 1.5);
  ASSERT_GE(found.summary.switches.size(), 40u);
  for (std::size_t i = 0; i < found.summary.switches.size(); ++i) {
    EXPECT_NEAR(found.summary.switches[i].time, time, 1e-3) << i;
    EXPECT_EQ(found.summary.switches[i].running, i % 2 == 0);
    time += i % 2 == 0 ? down : up;
  }
}

TEST(TwoPointCooler, SwitchTimesConvergeWithSecondOrder) {
  // The bed's sensor feels the coolant and the spindle by way of the slide.
  const Rig s(switching_machine(true));
  const auto switch_times = [&](double longest_s, double tolerance) {
    const auto found = s.run(s.program("output_s = 3600\n[[phase]]\nduration_s = 7200\nspindle_rpm = 12000\n" +
                                       adaptive(tolerance, longest_s)));
    std::vector<double> times;
    for (const auto& at : found.summary.switches) times.push_back(at.time);
    return times;
  };
  const auto exact = switch_times(3.0, 1e-6);
  ASSERT_GE(exact.size(), 8u);
  // Steps that only the longest one limits: what remains is the scheme's own error.
  const auto error = [&](double longest_s) {
    const auto times = switch_times(longest_s, 10.0);
    EXPECT_EQ(times.size(), exact.size());
    double sum = 0.0;
    for (std::size_t i = 0; i < std::min(times.size(), exact.size()); ++i) sum += std::pow(times[i] - exact[i], 2);
    return std::sqrt(sum / std::ssize(exact));
  };
  const double coarse = error(24.0), fine = error(6.0);
  EXPECT_LT(fine, 0.02);
  EXPECT_NEAR(std::log2(coarse / fine) / 2.0, 2.0, 0.3);
  // And with the tolerance.
  const auto times = switch_times(3600.0, 1e-3), closer = switch_times(3600.0, 1e-5);
  ASSERT_EQ(times.size(), exact.size());
  EXPECT_NEAR(times.back(), exact.back(), 1.0);
  EXPECT_NEAR(closer.back(), exact.back(), 0.1);
}

TEST(TwoPointCooler, AFixedStepSeesTheMeanOfTheSwitchingOutlet) {
  const mesh::Machine machine = switching_machine(false);
  const Channels channels(machine);
  const Layout layout;
  Chiller coarse(machine, layout, channels, Eigen::VectorXd::Zero(1)),
      fine(machine, layout, channels, Eigen::VectorXd::Zero(1));
  const Eigen::VectorXd readings = Eigen::VectorXd::Zero(2), air = Eigen::VectorXd::Constant(1, 0.3);
  double sum = 0.0;
  for (int i = 0; i < 100000; ++i) sum += fine.advance(channels.defaults(), readings, air, 0.01)[0] * 0.01;
  EXPECT_NEAR(coarse.advance(channels.defaults(), readings, air, 1000.0)[0], sum / 1000.0, 1e-9);
  EXPECT_NEAR(coarse.outlet_K()[0], fine.outlet_K()[0], 1e-9);
}

}  // namespace thermotwin::solver
