// SPDX-License-Identifier: GPL-3.0-or-later
// Steady states by one solution beside the ends of long runs.
#include "solver/campaign/steady_state.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "solver/campaign/simulation.h"
#include "solver/operation/layout.h"
#include "solver/thermal/assembly.h"
#include "solver/thermal/heat_balance.h"
#include "solver/thermal/integrator.h"
#include "tests/machines/slide_machine.h"

namespace thermotwin::solver {
namespace {

constexpr const char* steady_work =
    "spindle_rpm = 9000\nair_C = 23\ncutting_fluid = true\n"
    "[[phase.axis]]\nid = \"X\"\nlow_mm = -150\nhigh_mm = 50\nfeed_mm_min = 20000\n";

struct SteadyRig {
  explicit SteadyRig(mesh::Machine machine)
      : mesh(test::slide_mesh(1, std::move(machine))),
        system(assemble_thermal(mesh)),
        model(mesh.machine, system.layout) {}

  SteadyState steady(const std::string& state = steady_work) const {
    const LoadProgram program = load("output_s = 3600\n[[phase]]\nduration_s = 3600\n" + state);
    return steady_state(system, model, steady_phases(program).front().row);
  }
  /// The end of a run of many time constants.
  Eigen::VectorXd end_of_run(const std::string& steps, const std::string& state = steady_work) const {
    const LoadProgram program = load(steps + "[time]\nscheme = \"backward_euler\"\n[[phase]]\n" + state);
    IntegratorOptions options;
    options.backward_euler = true;
    ThermalIntegrator integrator(system, options);
    SimulationOptions simulation;
    simulation.progress = false;
    Eigen::VectorXd last;
    simulate(integrator, model, {&program}, simulation, [&](const OutputState& out) { last = out.state; });
    return last;
  }

  mesh::MachineMesh mesh;
  ThermalSystem system;
  OperatingModel model;

private:
  LoadProgram load(const std::string& text) const {
    return LoadProgram::parse("schema = 1\n" + text, "p.toml", mesh.machine);
  }
};

constexpr const char* settled_steps = "time_step_s = 50000\noutput_s = 5000000\n";
const std::string settled_phase = std::string("duration_s = 5000000\n") + steady_work;

double farthest_from_run(const SteadyRig& rig, const SteadyState& state, const std::string& steps,
                         const std::string& phase) {
  return (state.temperature - rig.end_of_run(steps, phase)).cwiseAbs().maxCoeff();
}

/// Share of what flows that does not balance.
double share_unbalanced(const SteadyRig& rig, const SteadyState& state) {
  HeatBalance balance(rig.mesh.machine, rig.system);
  balance.add(state.temperature, state.temperature, state.temperature, state.coefficients.p, state.coefficients.q, 1.0,
              state.local.empty() ? nullptr : &state.local);
  return balance.gap();
}

TEST(SteadyState, IsTheEndOfALongRunWhoseChillerFollowsTheBed) {
  const SteadyRig rig(test::slide_machine());
  const SteadyState state = rig.steady();
  EXPECT_EQ(state.passes, 1);
  EXPECT_GT(state.temperature.maxCoeff(), 2.0);
  EXPECT_LT(farthest_from_run(rig, state, settled_steps, settled_phase), 1e-5);
  EXPECT_NEAR(state.inlet_K[0], state.sensors_K[0], 1e-9);  // guided by T1
  EXPECT_LT(share_unbalanced(rig, state), 1e-9);
}

TEST(SteadyState, FollowsFilmsOfTheTemperatureAndRadiationByFourthPowers) {
  mesh::Machine machine = test::slide_machine();
  machine.films[0].of_temperature = true;
  machine.films[0].exact_radiation = true;
  const SteadyRig rig(machine);
  const SteadyState state = rig.steady();
  EXPECT_GT(state.passes, 2);
  EXPECT_LT(farthest_from_run(rig, state, settled_steps, settled_phase), 1e-4);
  EXPECT_LT(share_unbalanced(rig, state), 1e-6);
}

TEST(SteadyState, KeepsTheReturnOfAPiChillerWhereItCan) {
  mesh::Machine machine = test::slide_machine();
  mesh::CoolantSpec& coolant = machine.coolants[0];
  coolant.control = mesh::ChillerControl::pi;
  coolant.controls_return = true;
  coolant.guide_sensor.clear();
  coolant.time_constant = 60.0;
  coolant.gain = 1.0;
  coolant.integral_time = 200.0;
  for (const double power : {400.0, 60.0}) {
    machine.coolants[0].power = power;
    const SteadyRig rig(machine);
    const SteadyState state = rig.steady();
    EXPECT_EQ(state.at_limit.size(), power < 100.0 ? 1u : 0u) << power;
    EXPECT_LT(farthest_from_run(rig, state, "time_step_s = 100\noutput_s = 400000\n",
                                std::string("duration_s = 400000\n") + steady_work),
              0.02)
        << power;
  }
}

TEST(SteadyState, AChillerIsHeldToItsLimitByTheLastSolutionOnly) {
  // Films at their nominal temperature take less heat, so that the first solution asks the chiller for more.
  mesh::Machine machine = test::slide_machine();
  machine.films[0].of_temperature = true;
  machine.films[0].exact_radiation = true;
  mesh::CoolantSpec& coolant = machine.coolants[0];
  coolant.control = mesh::ChillerControl::pi;
  coolant.controls_return = true;
  coolant.guide_sensor.clear();
  coolant.power = 1e4;
  const SteadyRig strong(machine);
  const SteadyState free = strong.steady();
  const int returns = reading_index(machine, strong.system.layout, ObservedKind::coolant_return, 0);
  const double cooling = (strong.system.sensors * free.temperature)[returns] - free.inlet_K[0];
  coolant.power = 1.0005 * cooling * coolant.flow.value * coolant.specific_heat;
  const SteadyRig enough(machine);
  const SteadyState state = enough.steady();
  EXPECT_TRUE(state.at_limit.empty());
  EXPECT_LT((state.temperature - free.temperature).cwiseAbs().maxCoeff(), 1e-5);
}

TEST(SteadyState, NamesACompressorThatSwitches) {
  mesh::Machine machine = test::slide_machine();
  machine.coolants[0].control = mesh::ChillerControl::two_point;
  EXPECT_EQ(SteadyRig(machine).steady().switching, std::vector<int>{0});
}

TEST(SteadyState, NeedsAPathToAnAmbient) {
  mesh::Machine machine = test::slide_machine();
  machine.films.clear();
  machine.joints.pop_back();  // the mount
  machine.coolants.clear();
  const SteadyRig rig(machine);
  EXPECT_THROW(rig.steady("spindle_rpm = 9000\n"), core::SolverError);
}

TEST(SteadyState, APhaseIsItsEnd) {
  const SteadyRig rig(test::slide_machine());
  const LoadProgram program = LoadProgram::parse(
      "schema = 1\noutput_s = 600\n[[phase]]\nname = \"warm\"\nduration_s = 1800\nair_C = [20, 26]\n"
      "[[phase]]\nname = \"fast\"\nduration_s = 900\nspindle_rpm = 12000\n",
      "p.toml", rig.mesh.machine);
  const auto phases = steady_phases(program);
  ASSERT_EQ(phases.size(), 2u);
  EXPECT_EQ(phases[0].name, "warm");
  EXPECT_EQ(phases[1].name, "fast");
  EXPECT_EQ(phases[1].start, 1800.0);
  EXPECT_EQ(phases[1].end, 2700.0);
  EXPECT_EQ(phases[0].row[rig.model.channels().index("air.T_C")], 26.0);
  EXPECT_EQ(phases[0].row[rig.model.channels().index("spindle.speed_rpm")], 0.0);
  EXPECT_EQ(phases[1].row[rig.model.channels().index("spindle.speed_rpm")], 12000.0);
}

}  // namespace
}  // namespace thermotwin::solver
