// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/operation/load_program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "solver/campaign/simulation.h"
#include "solver/thermal/assembly.h"
#include "solver/thermal/integrator.h"
#include "tests/machines/slide_machine.h"

namespace thermotwin::solver {

namespace {

const char* two_phases = R"(
schema = 1
title = "warm up"
initial_C = 21.0
time_step_s = 60
output_s = 300
position = { X_mm = 50 }
[[phase]]
name = "run"
duration_min = 22
spindle_rpm = 6000
air_C = [20, 24]
cutting_fluid = true
[[phase.axis]]
id = "X"
low_mm = -100
high_mm = 150
feed_mm_min = 30000
duty_percent = 40
[[phase]]
duration_h = 1
spindle_rpm = 0
coolant = false
[[phase]]
duration_s = 100
machine_on = false
[[phase]]
duration_s = 100
machine_on = true
cutting_fluid = false
air_C = 19
[[phase.axis]]
id = "X"
position_mm = -30
)";

LoadProgram parse(const std::string& text) {
  return LoadProgram::parse(text, "loads/warm_up.toml", test::slide_machine());
}

struct Row {
  explicit Row(Eigen::VectorXd v) : values(std::move(v)) {}
  double operator[](const std::string& name) const { return values[channels.index(name)]; }
  Eigen::VectorXd values;
  Channels channels{test::slide_machine()};
};

std::string phase_with(const std::string& lines) { return "schema = 1\n[[phase]]\nduration_s = 600\n" + lines; }

}  // namespace

TEST(LoadProgram, StepsMeetCornersAndOutputs) {
  const LoadProgram p = parse(two_phases);
  EXPECT_EQ(p.name(), "warm_up");
  EXPECT_DOUBLE_EQ(p.duration(), 22 * 60 + 3600 + 200);
  EXPECT_DOUBLE_EQ(p.initial_C(), 21.0);
  const std::vector<double> ends = p.step_ends(), outputs = p.output_times();
  EXPECT_DOUBLE_EQ(outputs.front(), 0.0);
  EXPECT_DOUBLE_EQ(outputs[1], 300.0);
  EXPECT_DOUBLE_EQ(outputs.back(), p.duration());
  double before = 0.0;
  for (double end : ends) {
    EXPECT_GT(end, before);
    EXPECT_LE(end - before, 60.0 + 1e-9);
    before = end;
  }
  const auto met = [&](double t) {
    return std::any_of(ends.begin(), ends.end(), [&](double e) { return std::abs(e - t) < 1e-9; });
  };
  for (double t : outputs) EXPECT_TRUE(t == 0.0 || met(t)) << t;
  for (double t : {1320.0, 4920.0, 5020.0}) EXPECT_TRUE(met(t)) << t;
  EXPECT_GE(p.step_ends(0.5).size(), 2 * ends.size() - 10);
}

TEST(LoadProgram, RowsAreMeansAndInputsPersist) {
  const LoadProgram p = parse(two_phases);
  const Row first(p.row(0.0, 60.0));
  EXPECT_DOUBLE_EQ(first["spindle.speed_rpm"], 6000);
  EXPECT_NEAR(first["air.T_C"], 20.0 + 4.0 * 30.0 / 1320.0, 1e-12);
  EXPECT_DOUBLE_EQ(first["axis.X.low_mm"], -100);
  EXPECT_DOUBLE_EQ(first["axis.X.high_mm"], 150);
  EXPECT_DOUBLE_EQ(first["axis.X.feed_mm_min"], 12000);
  EXPECT_DOUBLE_EQ(first["coolant.main.on"], 1);
  const Row second(p.row(2000.0, 2060.0));
  EXPECT_DOUBLE_EQ(second["spindle.speed_rpm"], 0);
  EXPECT_DOUBLE_EQ(second["air.T_C"], 24.0);
  EXPECT_DOUBLE_EQ(second["cutting_fluid.on"], 1);
  EXPECT_DOUBLE_EQ(second["coolant.main.on"], 0);
  EXPECT_DOUBLE_EQ(second["axis.X.position_mm"], 50);
  EXPECT_DOUBLE_EQ(second["axis.X.feed_mm_min"], 0);
  EXPECT_TRUE(std::isnan(second["axis.X.low_mm"]));
  const Row off(p.row(4920.0, 5020.0));
  EXPECT_DOUBLE_EQ(off["machine.on"], 0);
  EXPECT_DOUBLE_EQ(off["cutting_fluid.on"], 0);
  const Row last(p.row(5020.0, 5120.0));
  EXPECT_DOUBLE_EQ(last["machine.on"], 1);
  EXPECT_DOUBLE_EQ(last["air.T_C"], 19.0);
  EXPECT_DOUBLE_EQ(last["axis.X.position_mm"], -30);
  EXPECT_EQ(p.phase_at(10.0), "run");
  EXPECT_EQ(p.phase_at(2000.0), "phase 2");
}

TEST(LoadProgram, TellsTheTimeOfDayWhereALawAsks) {
  mesh::Machine machine = test::slide_machine();
  const std::string text = std::string(two_phases).replace(1, 10, "schema = 1\nstarts_at = \"22:30\"");
  const auto rows = [&] { return LoadProgram::parse(text, "loads/night.toml", machine); };
  EXPECT_EQ(rows().row(0, 60).size(), Channels(machine).size()) << "no law asks, and nothing is told";
  machine.sources[0].laws.push_back({"day.time_h", {0, 24}, {5, 5}});
  const LoadProgram program = rows();
  const int hour = Channels(machine).index("day.time_h");
  EXPECT_NEAR(program.row(0, 60)[hour], 22.5 + 30.0 / 3600.0, 1e-12);
  EXPECT_NEAR(program.row(22 * 60 + 3600 - 60, 22 * 60 + 3600)[hour], 22.5 + (22 * 60 + 3600 - 30) / 3600.0, 1e-9);
  for (const char* wrong : {"24:00", "7:00", "06.30", "noon"}) {
    const std::string bad =
        std::string(two_phases).replace(1, 10, "schema = 1\nstarts_at = \"" + std::string(wrong) + "\"");
    try {
      LoadProgram::parse(bad, "loads/bad.toml", machine);
      ADD_FAILURE() << wrong;
    } catch (const core::InputError& error) {
      const std::string said = error.what();
      EXPECT_NE(said.find("starts_at"), std::string::npos) << said;
      EXPECT_NE(said.find("23:59"), std::string::npos) << said;
    }
  }
}

TEST(LoadProgram, RefusesWhatTheMachineCannotDo) {
  for (const char* bad :
       {"spindle_rpm = 13000", "spindle_rpm = -1", "air_C = [1, 2, 3]", "air_C = 900", "aire_C = 20", "process_W = 100",
        "machine_on = false\nspindle_rpm = 100", "duration_h = 1", "[[phase.axis]]\nid = \"Q\"\nposition_mm = 0",
        "[[phase.axis]]\nid = \"X\"\nposition_mm = 201",
        "[[phase.axis]]\nid = \"X\"\nlow_mm = 10\nhigh_mm = -10\nfeed_mm_min = 100",
        "[[phase.axis]]\nid = \"X\"\nlow_mm = -10\nhigh_mm = 10\nfeed_mm_min = 100000",
        "[[phase.axis]]\nid = \"X\"\nspeed_rpm = 10", "[[phase.axis]]\nid = \"X\""})
    EXPECT_THROW(parse(phase_with(bad)), core::InputError) << bad;
  EXPECT_THROW(parse("schema = 1\n"), core::InputError);
  EXPECT_THROW(parse("schema = 1\noutput_s = 0.001\n[[phase]]\nduration_h = 3\n"), core::InputError);
  EXPECT_THROW(parse("schema = 1\ntime_step_s = 0.01\n[[phase]]\nduration_h = 1e5\n"), core::InputError);
  EXPECT_THROW(parse("schema = 1\n[[phase]]\nname = \"no duration\"\n"), core::InputError);
  EXPECT_NO_THROW(parse(phase_with("air_C = 22")));
}

TEST(LoadProgram, AnEndlessAxisTurnsThroughAllItsPositions) {
  mesh::Machine machine = test::slide_machine();
  mesh::Axis c;
  c.id = "C";
  c.kind = mesh::AxisKind::rotary;
  c.direction = Eigen::Vector3d::UnitZ();
  c.endless = true;
  machine.axes.push_back(c);
  const LoadProgram p =
      LoadProgram::parse(phase_with("[[phase.axis]]\nid = \"C\"\nspeed_rpm = 600\n"), "turn.toml", machine);
  const Eigen::VectorXd row = p.row(0, 60);
  const Channels channels(machine);
  EXPECT_DOUBLE_EQ(row[channels.index("axis.C.feed_deg_min")], 216000);
  EXPECT_DOUBLE_EQ(row[channels.index("axis.C.high_deg")] - row[channels.index("axis.C.low_deg")], 360);
}

TEST(Simulation, BlocksGiveWhatSingleRunsGive) {
  const mesh::MachineMesh mesh = test::slide_mesh();
  const ThermalSystem system = assemble_thermal(mesh);
  const OperatingModel model(mesh.machine, system.layout);
  std::string other = two_phases;
  other.replace(other.find("6000"), 4, "9000");
  std::vector<LoadProgram> programs = {parse(two_phases), parse(other), parse(phase_with("air_C = 25"))};
  const auto blocks = blocks_of_equal_grid(programs);
  ASSERT_EQ(blocks.size(), 2u);
  ASSERT_EQ(blocks[0].size(), 2u);
  SimulationOptions options;
  options.progress = false;
  IntegratorOptions strict;
  strict.tolerance = 1e-12;
  const auto run = [&](const std::vector<const LoadProgram*>& block, std::size_t load) {
    ThermalIntegrator integrator(system, strict);
    std::vector<double> readings;
    simulate(integrator, model, block, options, [&](const OutputState& out) {
      if (out.load == load) readings.push_back(out.sensors_K[0]);
    });
    return readings;
  };
  const auto together = run(blocks[0], 1), alone = run({&programs[1]}, 0);
  ASSERT_EQ(together.size(), programs[1].output_times().size());
  EXPECT_NEAR(together.front(), 1.0, 1e-12);  // starts at 21 degC
  for (std::size_t i = 0; i < alone.size(); ++i) EXPECT_NEAR(together[i], alone[i], 1e-8);
  EXPECT_GT(std::abs(alone.back() - 1.0), 0.01);
  ThermalIntegrator integrator(system);
  EXPECT_THROW(simulate(integrator, model, {&programs[0], &programs[2]}, options, [](const OutputState&) {}),
               core::InputError);
}

TEST(Simulation, TheChillerFollowsTheReadingOfItsSensor) {
  // A guide sensor that reads 5 K high warms the machine through the coolant.
  const auto final_temperature = [](double offset) {
    mesh::Machine machine = test::slide_machine();
    machine.sensors[0].offset = offset;
    const mesh::MachineMesh mesh = test::slide_mesh(1, machine);
    const ThermalSystem system = assemble_thermal(mesh);
    const OperatingModel model(machine, system.layout);
    const LoadProgram program = LoadProgram::parse("schema = 1\n[[phase]]\nduration_h = 2\n", "still.toml", machine);
    ThermalIntegrator integrator(system);
    SimulationOptions options;
    options.progress = false;
    double slide = 0.0;
    simulate(integrator, model, {&program}, options, [&](const OutputState& out) { slide = out.sensors_K[1]; });
    return slide;
  };
  const double rise = final_temperature(5.0) - final_temperature(0.0);
  EXPECT_GT(rise, 3.0);
  EXPECT_LT(rise, 7.0);
}

TEST(LoadProgram, TimeSchemeIsReadAndChecked) {
  const mesh::Machine machine = test::slide_machine();
  const auto read = [&](const std::string& time) {
    return LoadProgram::parse("schema = 1\n" + time + "[[phase]]\nduration_h = 2\n", "p.toml", machine);
  };
  EXPECT_FALSE(read("").has_time());
  EXPECT_EQ(read("").time().scheme, TimeScheme::fixed);
  EXPECT_EQ(read("[time]\n").time().scheme, TimeScheme::adaptive);
  const TimeOptions time =
      read("[time]\nscheme = \"adaptive\"\ntolerance_K = 0.002\nlongest_step_s = 900\nshortest_step_s = 0.5\n").time();
  EXPECT_EQ(time.tolerance_K, 0.002);
  EXPECT_EQ(time.longest_step, 900.0);
  EXPECT_EQ(time.shortest_step, 0.5);
  EXPECT_EQ(read("[time]\nscheme = \"backward_euler\"\n").time().scheme, TimeScheme::backward_euler);
  const auto message = [&](const std::string& text) -> std::string {
    try {
      read(text);
    } catch (const core::InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message("[time]\nscheme = \"rk4\"\n").find("adaptive"), std::string::npos);
  EXPECT_NE(message("[time]\ntolerance_K = -1\n").find("time.tolerance_K"), std::string::npos);
  EXPECT_NE(message("[time]\nscheme = \"fixed\"\ntolerance_K = 0.1\n").find("adaptive"), std::string::npos);
  EXPECT_NE(message("[time]\nlongest_step_s = 0.001\nshortest_step_s = 0.5\n").find("longest_step_s"),
            std::string::npos);
}

TEST(LoadProgram, AdaptiveProgramsRunAlone) {
  const mesh::Machine machine = test::slide_machine();
  const auto read = [&](const std::string& time) {
    return LoadProgram::parse("schema = 1\n" + time + "[[phase]]\nduration_h = 2\n", "p.toml", machine);
  };
  const std::vector<LoadProgram> programs{read(""), read("[time]\n"), read(""), read("[time]\n"),
                                          read("[time]\nscheme = \"backward_euler\"\n")};
  const auto blocks = blocks_of_equal_grid(programs);
  ASSERT_EQ(blocks.size(), 4u);
  EXPECT_EQ(blocks[0].size(), 2u);
}

}  // namespace thermotwin::solver
