// SPDX-License-Identifier: GPL-3.0-or-later
// What follows the temperature: films of the temperature difference, radiation by fourth powers,
// conductivity and specific heat over temperature.
#include <gtest/gtest.h>

#include <cmath>

#include "solver/operation/film_laws.h"
#include "tests/machines/one_body.h"

namespace thermotwin::solver {
namespace {

constexpr double sigma = 5.670374419e-8;

/// Area of the bar's skin, its volume.
constexpr double skin = 4 * 0.1 * 0.02 + 2 * 0.02 * 0.02, volume = 0.1 * 0.02 * 0.02;

/// Copper as good as isothermal.
mesh::Material quick() {
  mesh::Material m = test::steel();
  m.conductivity = 4e6;
  return m;
}

mesh::FilmSpec plate(mesh::Orientation orientation) {
  mesh::FilmSpec film = test::constant_film("plate", {"z1"}, 0.0);
  film.kind = mesh::FilmKind::free_convection;
  film.coefficient = {1.0, 0.0};
  film.orientation = orientation;
  film.length = 0.05;
  film.of_temperature = true;
  return film;
}

TEST(FilmOfTemperature, CarriesThePowerAtTheDifferenceThatItHas) {
  mesh::Machine m = test::bar_machine(quick());
  m.films = {plate(mesh::Orientation::up)};
  m.sources = {test::heat_source("heater", 0.5, "x0")};
  const test::Bench bench(test::bar_mesh(m));
  const auto run = bench.run("time_step_s = 2000\noutput_s = 200000\n[[phase]]\nduration_s = 400000\n");
  const double over = run.states.back()[0];
  EXPECT_GT(over, 5.0);
  EXPECT_NEAR(free_convection(mesh::Orientation::up, 0.05, over, 293.15) * 0.002 * over, 0.5, 1e-5);
  EXPECT_GT(run.summary.passes, run.summary.steps);
  EXPECT_EQ(run.summary.unconverged, 0);
}

TEST(FilmOfTemperature, AColdPlateLooksTheOtherWay) {
  mesh::Machine m = test::bar_machine(quick());
  m.films = {plate(mesh::Orientation::up)};
  const test::Bench bench(test::bar_mesh(m));
  const Eigen::VectorXd row = bench.model.channels().defaults();
  EXPECT_NEAR(bench.model.film_coefficient(0, row, Eigen::VectorXd::Constant(1, 8.0)),
              free_convection(mesh::Orientation::up, 0.05, 8.0, 293.15), 1e-12);
  EXPECT_NEAR(bench.model.film_coefficient(0, row, Eigen::VectorXd::Constant(1, -8.0)),
              free_convection(mesh::Orientation::down, 0.05, 8.0, 293.15), 1e-12);
  // Without readings: at the nominal difference.
  EXPECT_NEAR(bench.model.film_coefficient(0, row), free_convection(mesh::Orientation::up, 0.05, 3.0, 293.15), 1e-12);
}

TEST(FilmTable, FollowsItsChannel) {
  mesh::Machine m = test::bar_machine();
  m.films = {test::constant_film("blown", {"skin"}, 0.0)};
  m.films[0].kind = mesh::FilmKind::table;
  m.films[0].coefficient = {2.0, 0.0};
  m.films[0].table = {"spindle.speed_rpm", {0, 6000, 12000}, {5, 20, 30}};
  const test::Bench bench(test::bar_mesh(m));
  Eigen::VectorXd row = bench.model.channels().defaults();
  EXPECT_DOUBLE_EQ(bench.model.film_coefficient(0, row), 10.0);
  row[bench.model.channels().index("spindle.speed_rpm")] = -3000;
  EXPECT_DOUBLE_EQ(bench.model.film_coefficient(0, row), 25.0);
}

TEST(JointOfTemperature, CarriesThePowerAtTheTemperatureThatItHas) {
  mesh::Machine m = test::bar_machine(quick());
  m.ambients.push_back(test::ambient("foundation", 20.0));
  mesh::JointSpec mount;
  mount.id = "mount";
  mount.kind = "mount";
  mount.slave = "z0";
  mount.ambient = "foundation";
  mount.conductance = {100.0, 0.0};
  mount.law.by_temperature = {{20.0, 60.0}, {1.0, 3.0}};
  m.joints = {mount};
  m.sources = {test::heat_source("heater", 6.0, "z1")};
  const test::Bench bench(test::bar_mesh(m));
  const auto run = bench.run("time_step_s = 500\noutput_s = 50000\n[[phase]]\nduration_s = 50000\n");
  const double over = run.states.back()[0];
  EXPECT_GT(over, 10.0);
  EXPECT_NEAR(100.0 * (1.0 + over / 20.0) * 0.002 * over, 6.0, 1e-5);
}

mesh::Machine radiating(double start_margin = 0.0) {
  mesh::Machine m = test::bar_machine(quick());
  m.films = {test::constant_film("skin", {"skin"}, 0.0)};
  m.films[0].emissivity.value = 0.9;
  m.films[0].exact_radiation = true;
  m.ambients[0].default_C = {-273.15 + start_margin, 0.0};  // nothing comes back from 0 K
  return m;
}

TEST(Radiation, CoolsAnEvenBodyAsTheFormulaSaysWithSecondOrder) {
  // dT/dt = -a T^4 from T0: T = T0 (1 + 3 a T0^3 t)^(-1/3).
  mesh::Machine machine = radiating();
  machine.plausible_high_C = 600.0;
  const test::Bench bench(test::bar_mesh(machine));
  const double a = 0.9 * sigma * skin / (7800.0 * 470.0 * volume), start = 773.15, time = 3600.0;
  const double exact = start * std::pow(1.0 + 3.0 * a * start * start * start * time, -1.0 / 3.0);
  const auto error = [&](int step) {
    const auto run = bench.run("initial_C = 500\noutput_s = 3600\ntime_step_s = " + std::to_string(step) +
                               "\n[[phase]]\nduration_s = 3600\n");
    return std::abs(run.states.back().head(bench.system.nodes).mean() + 293.15 - exact);
  };
  const double coarse = error(600), fine = error(300);
  EXPECT_LT(fine, 1.0);
  EXPECT_NEAR(std::log2(coarse / fine), 2.0, 0.15);
  const auto adaptive =
      bench.run("initial_C = 500\noutput_s = 3600\n[time]\ntolerance_K = 0.001\n[[phase]]\nduration_s = 3600\n");
  EXPECT_NEAR(adaptive.states.back()[0] + 293.15, exact, 0.05);
}

TEST(Radiation, BalancesThePowerPlaceByPlace) {
  // A poor conductor, hot at one end: the fourth power of the mean is not the mean of fourth powers.
  for (int order : {1, 2}) {
    mesh::Machine m = radiating(293.15);
    m.materials[0].conductivity = 5.0;
    m.sources = {test::heat_source("heater", 30.0, "x0")};
    const test::Bench bench(test::bar_mesh(m, order));
    const auto run =
        bench.run("initial_C = 20\noutput_s = 2000000\ntime_step_s = 20000\n[[phase]]\nduration_s = 2000000\n");
    const Eigen::VectorXd& state = run.states.back();
    EXPECT_GT(state.maxCoeff() - state.minCoeff(), 200.0);
    const mesh::TetMesh& bar = bench.mesh.bodies[0];
    double out = 0.0;
    for (int f = 0; f < bar.face_count(); ++f) {
      const mesh::FaceNodes nodes = mesh::face_nodes(bar, f);
      for (const mesh::FacePoint& point : mesh::face_rule(5)) {
        const mesh::FaceValues n = mesh::face_shape(order, point.at);
        double T = 293.15;
        for (Eigen::Index i = 0; i < nodes.size(); ++i) T += n[i] * state[nodes[i]];
        out += bar.face_area(f) * point.share * 0.9 * sigma * (std::pow(T, 4) - std::pow(293.15, 4));
      }
    }
    EXPECT_NEAR(out, 30.0, 1e-6);
  }
}

TEST(Radiation, ToSurroundingsThatAreNotTheAir) {
  mesh::Machine m = radiating(293.15);
  m.ambients.push_back(test::ambient("walls", 60.0));
  m.films[0].surroundings = "walls";
  m.films[0].coefficient = {10.0, 0.0};
  const test::Bench bench(test::bar_mesh(m));
  const auto run = bench.run("initial_C = 20\noutput_s = 200000\ntime_step_s = 2000\n[[phase]]\nduration_s = 200000\n");
  const double T = run.states.back()[0] + 293.15;
  EXPECT_NEAR(10.0 * (T - 293.15), 0.9 * sigma * (std::pow(333.15, 4) - std::pow(T, 4)), 1e-4);
}

TEST(Material, ConductivityOverTemperatureFollowsKirchhoff) {
  // k = 40 (1 + 0.004 (T - 20)), ends at 20 and 320 degC: T + 0.002 T^2 over 20 degC is linear.
  for (int order : {1, 2}) {
    mesh::Machine m = test::bar_machine();
    m.materials[0].conductivity = 40.0;
    m.materials[0].conductivity_table = {{20.0, 320.0}, {40.0, 88.0}};
    m.films = {test::constant_film("cold", {"x0"}, 1e8), test::constant_film("hot", {"x1"}, 1e8, "hot")};
    m.ambients.push_back(test::ambient("hot", 320.0));
    const auto error = [&](int finer) {
      const test::Bench bench(test::bar_mesh(m, order, finer));
      const auto run =
          bench.run("initial_C = 20\noutput_s = 200000\ntime_step_s = 5000\n[[phase]]\nduration_s = 200000\n");
      EXPECT_EQ(run.summary.unconverged, 0);
      double worst = 0.0;
      for (Eigen::Index i = 0; i < bench.system.nodes; ++i) {
        const double theta = (300.0 + 0.002 * 300.0 * 300.0) * bench.mesh.bodies[0].points(0, i) / 0.1;
        worst = std::max(worst, std::abs(run.states.back()[i] - (-1.0 + std::sqrt(1.0 + 0.008 * theta)) / 0.004));
      }
      return worst;
    };
    const double coarse = error(1), fine = error(2);
    EXPECT_LT(fine, order == 1 ? 0.1 : 0.01);
    EXPECT_GT(std::log2(coarse / fine), order == 1 ? 1.3 : 2.0);
  }
}

TEST(Material, HeatIsConservedWithSpecificHeatOverTemperature) {
  for (const bool lumped : {false, true}) {
    for (int order : {1, 2}) {
      mesh::Machine m = test::bar_machine(quick());
      m.lumped_capacity = lumped;
      m.materials[0].specific_heat_table = {{20.0, 60.0, 200.0}, {400.0, 500.0, 900.0}};
      m.materials[0].specific_heat.value = 400.0;
      m.sources = {test::heat_source("heater", 100.0, "x0")};
      const test::Bench bench(test::bar_mesh(m, order));
      // From 20 to 60: 18,000 J/kg; from there to 110 with 500 to 642.857: 28,571.4 J/kg.
      const double mass = 7800.0 * volume, time = mass * (18000.0 + 0.5 * 50.0 * (500.0 + 642.857142857)) / 100.0;
      const std::string seconds = std::to_string(time);
      for (const std::string scheme : {"", "[time]\nscheme = \"backward_euler\"\n", "[time]\ntolerance_K = 0.01\n"}) {
        const auto run = bench.run("initial_C = 20\noutput_s = " + seconds + "\ntime_step_s = 300\n" + scheme +
                                   "[[phase]]\nduration_s = " + seconds + "\n");
        EXPECT_NEAR(run.states.back().head(bench.system.nodes).mean(), 90.0, 2e-3) << scheme;
      }
    }
  }
}

}  // namespace
}  // namespace thermotwin::solver
