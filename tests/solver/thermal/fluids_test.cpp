// SPDX-License-Identifier: GPL-3.0-or-later
// Coolants along their channels and in networks, volumes with a heat balance, ambients with a
// gradient, what guides and stops a chiller.
#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "mesh/machine/flow_network.h"
#include "solver/operation/layout.h"
#include "tests/machines/one_body.h"

namespace thermotwin::solver {
namespace {

using test::Bench;

constexpr double side = 0.1 * 0.02;  // m^2, of a long side of the bar

mesh::CoolantSegment segment(const std::string& id, const std::string& surface, double film,
                             std::vector<std::string> after = {}, int cells = 1) {
  mesh::CoolantSegment s;
  s.id = id;
  s.surface = surface;
  s.film_coefficient = {film, 0.0};
  s.volume = 1e-5;
  s.cells = cells;
  s.after = std::move(after);
  return s;
}

mesh::CoolantSpec coolant(std::vector<mesh::CoolantSegment> segments, double flow = 0.01) {
  mesh::CoolantSpec c;
  c.id = "main";
  c.flow = {flow, 0.0};
  c.specific_heat = 2000.0;
  c.segments = std::move(segments);
  return c;
}

mesh::SensorSpec return_sensor(const std::string& id = "back") {
  mesh::SensorSpec s;
  s.id = id;
  s.return_of = "main";
  return s;
}

/// A bar held at 20 degC by its surroundings, coolant along its upper side from an inlet of 30 degC.
mesh::Machine held_bar(mesh::CoolantSpec c) {
  mesh::Machine m = test::bar_machine();
  m.materials[0].conductivity = 4e6;
  m.films = {test::constant_film("held", {"z0"}, 1e9)};
  m.coolants = {std::move(c)};
  m.sensors = {return_sensor()};
  return m;
}

double outlet(const mesh::Machine& machine, double inlet_K = 10.0) {
  const Bench bench(test::bar_mesh(machine));
  const Coefficients c =
      bench.model.coefficients(bench.model.channels().defaults(), Eigen::VectorXd::Constant(1, inlet_K));
  return (bench.system.sensors * solve_steady(bench.system, c))[0];
}

TEST(Coolant, LeavesAChannelAsTheExponentialSays) {
  const double film = 20000.0, ntu = film * side / (0.01 * 2000.0);  // 2
  const auto error = [&](int cells, bool path) {
    mesh::CoolantSegment channel = segment("channel", "z1", film, {}, cells);
    if (path) channel.path = {{0, 0.01, 0.02}, {0.1, 0.01, 0.02}};
    return std::abs(outlet(held_bar(coolant({channel}))) / 10.0 - std::exp(-ntu));
  };
  EXPECT_LT(error(1, false), 0.03);
  EXPECT_LT(error(4, false), 1e-3);
  EXPECT_NEAR(std::log2(error(2, false) / error(4, false)), 3.0, 0.3);
  EXPECT_LT(error(4, true), 1.5e-3);
}

TEST(Coolant, WarmsUpAlongAWallThatIsHeatedEvenly) {
  // An insulated bar with a poor conductivity along x: each place of the wall is the local fluid's
  // temperature plus flux over film coefficient, and the fluid's is linear along the path.
  mesh::Machine m = test::bar_machine();
  Eigen::Matrix3d k = Eigen::Vector3d(1e-6, 400.0, 400.0).asDiagonal();
  m.materials[0].conductivity_tensor = k;
  mesh::CoolantSegment channel = segment("channel", "z1", 5000.0, {}, 5);
  channel.path = {{0, 0.01, 0.02}, {0.1, 0.01, 0.02}};
  m.coolants = {coolant({channel})};
  m.sources = {test::heat_source("heater", 100.0, "z0")};
  m.sensors = {return_sensor()};
  const Bench bench(test::bar_mesh(m));
  const Eigen::VectorXd row = bench.model.channels().defaults();
  const Eigen::VectorXd state = solve_steady(bench.system, bench.model.coefficients(row, Eigen::VectorXd::Zero(1)));
  EXPECT_NEAR((bench.system.sensors * state)[0], 5.0, 1e-8);
  double worst = 0.0;
  for (Eigen::Index i = 0; i < bench.system.nodes; ++i) {
    const Eigen::Vector3d p = bench.mesh.bodies[0].points.col(i);
    if (p.x() > 1e-9 && p.x() < 0.1 - 1e-9)
      worst = std::max(worst, std::abs(state[i] - (5.0 * p.x() / 0.1 + 10.0 + 100.0 / side * (0.02 - p.z()) / 400.0)));
  }
  EXPECT_LT(worst, 0.05);
}

TEST(Coolant, BranchesMixByTheirFlows) {
  // Two consumers in parallel, one heated: the return is the mean by flow, the balance exact.
  mesh::CoolantSegment one = segment("one", "z1", 3000.0), two = segment("two", "y1", 3000.0),
                       last = segment("last", "y0", 0.0, {"one", "two"});
  one.share = 0.3;
  mesh::Machine m = test::bar_machine();
  m.coolants = {coolant({one, two, last})};
  m.sources = {test::heat_source("heater", 60.0, "x0")};
  m.sensors = {return_sensor()};
  EXPECT_NEAR(outlet(m, 0.0), 60.0 / (0.01 * 2000.0), 1e-9);
  const mesh::FlowNetwork network = mesh::flow_network(m.coolants[0], "");
  EXPECT_DOUBLE_EQ(network.share[1], 0.7);
  EXPECT_DOUBLE_EQ(network.share[2], 1.0);
  EXPECT_DOUBLE_EQ(network.inflow[2][0].second, 0.3);
  // Transport takes no heat out of a network: G + G^T >= 0.
  const Bench bench(test::bar_mesh(m));
  for (std::size_t t = 0; t < bench.system.layout.terms.size(); ++t) {
    if (bench.system.layout.terms[t].kind == TermKind::coolant_flow) {
      const Eigen::MatrixXd g = Eigen::MatrixXd(bench.system.terms[t]).bottomRightCorner(6, 6);
      EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(g + g.transpose()).eigenvalues()[0], -1e-9);
    }
  }
}

TEST(Coolant, NetworksThatDoNotBalanceAreRefused) {
  const auto message = [](mesh::CoolantSpec c) {
    try {
      mesh::flow_network(c, "here");
    } catch (const core::InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  mesh::CoolantSegment one = segment("one", "z1", 1.0), two = segment("two", "y1", 1.0);
  one.share = 0.3;
  two.share = 0.5;
  EXPECT_NE(message(coolant({one, two})).find("0.8"), std::string::npos);
  EXPECT_NE(message(coolant({segment("one", "z1", 1.0, {"two"}), segment("two", "y1", 1.0)})).find("before"),
            std::string::npos);
  EXPECT_NE(message(coolant({segment("a", "z1", 1.0), segment("b", "y1", 1.0), segment("c", "z0", 1.0, {"a", "b"}),
                             segment("d", "y0", 1.0, {"a"})}))
                .find("another segment"),
            std::string::npos);
}

mesh::Machine with_tank() {
  mesh::Machine m = test::bar_machine();
  mesh::VolumeSpec tank;
  tank.id = "tank";
  tank.capacity = {4180.0 * 50.0, 0.0};
  tank.exchanges = {{"air", {8.0, 0.0}, ""}};
  m.volumes = {tank};
  m.sources = {test::heat_source("pump", 200.0, "", "tank")};
  mesh::SensorSpec in_tank;
  in_tank.id = "in_tank";
  in_tank.volume = "tank";
  m.sensors = {in_tank};
  return m;
}

TEST(Volume, ATankWarmsUpByItsPump) {
  const Bench bench(test::bar_mesh(with_tank()));
  const double tau = 4180.0 * 50.0 / 8.0;
  const auto run = bench.run("time_step_s = 600\noutput_s = 3600\n[[phase]]\nduration_h = 10\n");
  for (std::size_t i = 0; i < run.times.size(); ++i)
    EXPECT_NEAR(run.sensors[i][0], 25.0 * (1.0 - std::exp(-run.times[i] / tau)), 2e-3);
}

TEST(Volume, WetsASurfaceWhileTheFluidRuns) {
  mesh::Machine m = with_tank();
  m.films = {test::constant_film("wet", {"z1"}, 300.0, "tank")};
  m.films[0].state = "cutting_fluid.on";
  const Bench bench(test::bar_mesh(m));
  const auto run = bench.run(
      "time_step_s = 300\noutput_s = 36000\n[[phase]]\nduration_h = 10\n[[phase]]\nduration_h = 10\ncutting_fluid = "
      "true\n");
  EXPECT_NEAR(run.states[1].head(bench.system.nodes).cwiseAbs().maxCoeff(), 0.0, 1e-9);
  EXPECT_NEAR(run.states[2][0], run.sensors[2][0], 0.05);
  // Given by a measurement it is what was measured.
  const auto given = bench.run("time_step_s = 300\noutput_s = 36000\n[[phase]]\nduration_h = 10\ntank_C = 31.0\n");
  EXPECT_NEAR(given.sensors[1][0], 11.0, 1e-3);
}

TEST(Volume, ADoorLetsTheHallIn) {
  mesh::Machine m = test::bar_machine();
  mesh::VolumeSpec area;
  area.id = "working_area";
  area.capacity = {5000.0, 0.0};
  area.exchanges = {{"air", {2.0, 0.0}, ""}, {"air", {50.0, 0.0}, "door.front.open"}};
  m.volumes = {area};
  m.doors = {"front"};
  m.sources = {test::heat_source("lamp", 52.0, "", "working_area")};
  mesh::SensorSpec inside;
  inside.id = "inside";
  inside.volume = "working_area";
  m.sensors = {inside};
  const Bench bench(test::bar_mesh(m));
  const auto run = bench.run(
      "time_step_s = 60\noutput_s = 36000\n[[phase]]\nduration_h = 10\n[[phase]]\nduration_h = 10\ndoors_open = "
      "[\"front\"]\n"
      "[[phase]]\nduration_h = 10\ndoors_open = []\n");
  EXPECT_NEAR(run.sensors[1][0], 26.0, 1e-3);
  EXPECT_NEAR(run.sensors[2][0], 1.0, 1e-3);
  EXPECT_NEAR(run.sensors[3][0], 26.0, 1e-3);
  EXPECT_THROW(bench.program("[[phase]]\nduration_h = 1\ndoors_open = [\"back\"]\n"), core::InputError);
}

TEST(Ambient, IsWarmerFurtherUp) {
  // A tall bar that conducts along z only as much as is needed: it takes the air's temperature.
  mesh::Machine m = test::bar_machine();
  m.ambients[0].has_gradient = true;
  m.ambients[0].gradient = {3.0, 0.0};
  m.ambients[0].height = 0.5;
  m.films = {test::constant_film("sides", {"x0", "x1"}, 10.0)};
  for (int order : {1, 2}) {
    m.order = order;
    Eigen::Matrix3d k = Eigen::Vector3d(45.0, 45.0, 1e-9).asDiagonal();
    m.materials[0].conductivity_tensor = k;
    mesh::TetMesh bar = test::box_mesh({0, 0, 0}, {0.02, 0.02, 2.0}, {1, 1, 20});
    mesh::set_order(bar, order);
    const Bench bench(test::machine_mesh(m, {bar}));
    Eigen::VectorXd row = bench.model.channels().defaults();
    const auto worst = [&](double gradient) {
      const Eigen::VectorXd state = solve_steady(bench.system, bench.model.coefficients(row, Eigen::VectorXd()));
      double off = 0.0;
      for (Eigen::Index i = 0; i < bench.system.nodes; ++i)
        off = std::max(off, std::abs(state[i] - gradient * (bench.mesh.bodies[0].points(2, i) - 0.5)));
      return off;
    };
    EXPECT_LT(worst(3.0), 1e-6);
    row[bench.model.channels().index("air.gradient_K_m")] = -1.0;
    EXPECT_LT(worst(-1.0), 1e-6);
  }
}

/// A bar of good conductivity, heated, with coolant on one side whose chiller has PI control.
mesh::Machine regulated(bool of_return, double power) {
  mesh::Machine m = test::bar_machine();
  m.materials[0].conductivity = 400.0;
  mesh::CoolantSpec c = coolant({segment("channel", "z1", 3000.0)}, 0.05);
  c.control = mesh::ChillerControl::pi;
  c.controls_return = of_return;
  c.guide_offset = 1.5;
  c.time_constant = 60.0;
  c.gain = 1.0;
  c.integral_time = 200.0;
  c.power = 400.0;
  m.coolants = {c};
  m.sensors = {return_sensor()};
  m.sources = {test::heat_source("heater", power, "z0")};
  return m;
}

TEST(Chiller, PiControlEndsAtItsSetPoint) {
  const std::string load = "time_step_s = 20\noutput_s = 20000\n";
  const std::string phases = "[[phase]]\nduration_s = 20000\n";
  {
    const Bench bench(test::bar_mesh(regulated(true, 150.0)));
    EXPECT_NEAR(bench.run(load + phases).sensors[1][0], 1.5, 1e-4);
    EXPECT_NEAR(bench.run(load + "[time]\ntolerance_K = 0.01\n" + phases).sensors[1][0], 1.5, 1e-2);
  }
  {
    // The outlet held: the return is warmer by heat over flow.
    const Bench bench(test::bar_mesh(regulated(false, 150.0)));
    EXPECT_NEAR(bench.run(load + phases).sensors[1][0], 1.5 + 150.0 / (0.05 * 2000.0), 1e-4);
  }
}

TEST(Chiller, PiControlIsLimitedByItsPower) {
  // 600 W come in and 400 W go out: it warms up at the rate of 200 W.
  const Bench bench(test::bar_mesh(regulated(true, 600.0)));
  const auto run = bench.run("time_step_s = 20\noutput_s = 500\n[[phase]]\nduration_s = 4000\n");
  const double heat = bench.system.capacity.toDense().sum();
  const double rise = (bench.system.capacity * (run.states[8] - run.states[6])).sum();
  // The chiller's own content is not in the balance of the bar: its outlet rises too.
  EXPECT_NEAR(rise / 1000.0, 200.0 * heat / (heat + 0.05 * 2000.0 * 60.0), 4.0);
}

TEST(Chiller, FixedStepsConvergeToErrorControlThroughTheReturn) {
  // In a fixed step the inlet is its mean: the quick fluid, and so the return, lags by half a step.
  const Bench bench(test::bar_mesh(regulated(true, 150.0)));
  const std::string phase = "[[phase]]\nduration_s = 600\n";
  const auto at_end = [&](const std::string& step) {
    return bench.run("time_step_s = " + step + "\noutput_s = 600\n" + phase).sensors.back()[0];
  };
  const double exact = bench.run("output_s = 600\n[time]\ntolerance_K = 1e-5\n" + phase).sensors.back()[0];
  const double coarse = std::abs(at_end("8") - exact), fine = std::abs(at_end("4") - exact);
  EXPECT_LT(coarse, 0.02);
  EXPECT_GT(coarse, 1e-6);
  EXPECT_GT(std::log2(coarse / fine), 0.8);
}

TEST(Chiller, TwoPointControlOfTheReturnStaysAboutItsBand) {
  mesh::Machine m = regulated(true, 150.0);
  mesh::CoolantSpec& c = m.coolants[0];
  c.control = mesh::ChillerControl::two_point;
  c.band = 1.0;
  c.pull_down = 4.0;
  c.drift_up = 0.0;
  const Bench bench(test::bar_mesh(m));
  const auto run =
      bench.run("time_step_s = 20\noutput_s = 100\n[time]\ntolerance_K = 0.01\n[[phase]]\nduration_s = 8000\n");
  EXPECT_GT(run.summary.switches.size(), 8u);
  double low = 1e300, high = -1e300;
  for (std::size_t i = run.times.size() / 2; i < run.times.size(); ++i) {
    low = std::min(low, run.sensors[i][0]);
    high = std::max(high, run.sensors[i][0]);
  }
  EXPECT_LT(low, 1.2);
  EXPECT_GT(low, 0.2);
  EXPECT_GT(high, 1.8);
  EXPECT_LT(high, 2.8);
}

TEST(Chiller, TheControlCabinetWarmsItsGuide) {
  mesh::Machine m = test::bar_machine();
  mesh::VolumeSpec cabinet;
  cabinet.id = "cabinet";
  cabinet.capacity = {2e4, 0.0};
  cabinet.exchanges = {{"air", {20.0, 0.0}, ""}};
  m.volumes = {cabinet};
  m.sources = {test::heat_source("electronics", 400.0, "", "cabinet")};
  mesh::CoolantSpec c = coolant({segment("channel", "z1", 3000.0)});
  c.guide_warmed_by = "cabinet";
  c.guide_warmed_share = 0.1;
  m.coolants = {c};
  m.sensors = {return_sensor()};
  const Bench bench(test::bar_mesh(m));
  const auto run = bench.run(
      "time_step_s = 60\noutput_s = 86400\n[[phase]]\nduration_h = 24\n[[phase]]\nduration_h = 24\nmachine_on = "
      "false\n");
  EXPECT_NEAR(run.sensors[1][0], 2.0, 1e-3);  // the cooling warms the machine
}

TEST(CoolantSchedule, RunsOnAndStopsAfterStandstill) {
  mesh::Machine m = test::bar_machine();
  m.spindle_max_rpm = 10000;
  m.coolants = {coolant({segment("channel", "z1", 3000.0)})};
  m.coolants[0].after_run = 600;
  m.coolants[0].standstill_stop = 7200;
  const Bench bench(test::bar_mesh(m));
  const LoadProgram load = bench.program(
      "[[phase]]\nduration_h = 1\nspindle_rpm = 3000\n[[phase]]\nduration_h = 5\nspindle_rpm = 0\nair_C = [20, 30]\n"
      "[[phase]]\nduration_h = 1\nspindle_rpm = 3000\n[[phase]]\nduration_h = 1\nmachine_on = false\nspindle_rpm = "
      "0\n");
  const int on = bench.model.channels().index("coolant.main.on"), air = bench.model.channels().index("air.T_C");
  const auto flows = [&](double hours) { return load.row_at(3600.0 * hours, 3600.0 * hours)[on]; };
  EXPECT_EQ(flows(0.5), 1.0);
  EXPECT_EQ(flows(2.9), 1.0);
  EXPECT_EQ(flows(3.1), 0.0);
  EXPECT_EQ(flows(6.5), 1.0);
  EXPECT_EQ(flows(7.1), 1.0);
  EXPECT_EQ(flows(7.2), 0.0);
  EXPECT_TRUE(load.is_corner(3.0 * 3600.0));
  EXPECT_TRUE(load.is_corner(7.0 * 3600.0 + 600.0));
  EXPECT_NEAR(load.row_at(4.0 * 3600.0, 4.0 * 3600.0)[air], 26.0, 1e-9);
}

}  // namespace
}  // namespace thermotwin::solver
