// SPDX-License-Identifier: GPL-3.0-or-later
// NAFEMS T2 and exact cases of what is not linear or not a body: radiation by fourth powers,
// conductivity over temperature, a coolant along its channel, a tank.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/machines/one_body.h"
#include "tests/verification/rig.h"
#include "tests/verification/table.h"

namespace thermotwin::test {
namespace {

TEST(Nafems, T2RadiationFromTheEndOfABar) {
  for (int order : {1, 2}) {
    mesh::Machine m = bar_machine(heat_material(55.6, 7850.0, 460.0));
    m.plausible_high_C = 1000.0;
    m.order = order;
    m.ambients = {ambient("hot", 1000.0 - 273.15), ambient("air", 300.0 - 273.15)};
    m.films = {constant_film("held", {"x0"}, as_good_as_given, "hot"), constant_film("end", {"x1"}, 0.0)};
    m.films[1].emissivity.value = 0.98;
    m.films[1].exact_radiation = true;
    const Bench bench(machine_mesh(m, {box_of_order({0, 0, 0}, {0.1, 0.02, 0.02}, {10, 2, 2}, order)}));
    const auto run =
        bench.run("initial_C = 480\ntime_step_s = 1000\noutput_s = 20000\n[[phase]]\nduration_s = 20000\n");
    double end = 0.0;
    int count = 0;
    for (Index i = 0; i < bench.system.nodes; ++i)
      if (bench.mesh.bodies[0].points(0, i) > 0.1 - 1e-9) end += run.states.back()[i] + 293.15, ++count;
    expect_value({of_order("NAFEMS T2", order), "NAFEMS; own solution 927.008", "T of the end that radiates, K"}, 927.0,
                 end / count, 0.05);
  }
}

TEST(Exact, ConductivityOverTemperature) {
  // k = 40 (1 + 0.004 (T - 20)) between 20 and 320 degC: T + 0.002 T^2 (over 20 degC) is linear.
  for (int order : {1, 2}) {
    mesh::Machine m = bar_machine();
    m.materials[0].conductivity = 40.0;
    m.materials[0].conductivity_table = {{20.0, 320.0}, {40.0, 88.0}};
    m.films = {constant_film("cold", {"x0"}, as_good_as_given), constant_film("hot", {"x1"}, as_good_as_given, "hot")};
    m.ambients.push_back(ambient("hot", 320.0));
    const auto error = [&](int finer) {
      const Bench bench(bar_mesh(m, order, finer));
      const auto run =
          bench.run("initial_C = 20\noutput_s = 100000\ntime_step_s = 5000\n[[phase]]\nduration_s = 100000\n");
      double square = 0.0;
      for (Index i = 0; i < bench.system.nodes; ++i) {
        const double theta = 480.0 * bench.mesh.bodies[0].points(0, i) / 0.1;
        square += std::pow(run.states.back()[i] - (-1.0 + std::sqrt(1.0 + 0.008 * theta)) / 0.004, 2);
      }
      return std::sqrt(square / bench.system.nodes);
    };
    expect_value(
        {of_order("bar, conductivity over temperature", order), "exact (Kirchhoff)", "RMS error of T over 300 K, %"},
        0.0, error(2) / 3.0, order == 1 ? 0.02 : 0.002);
  }
}

TEST(Exact, CoolantAlongAWallOfOneTemperature) {
  // Film 20,000 W/(m^2 K), 0.01 kg/s of 2000 J/(kg K): two transfer units.
  const auto outlet = [&](int cells) {
    mesh::Machine m = bar_machine();
    m.materials[0].conductivity = 4e9;
    m.films = {constant_film("held", {"z0"}, 1e12)};
    mesh::CoolantSpec c;
    c.id = "main";
    c.flow = {0.01, 0.0};
    c.specific_heat = 2000.0;
    c.segments.resize(1);
    c.segments[0].id = "channel";
    c.segments[0].surface = "z1";
    c.segments[0].film_coefficient = {20000.0, 0.0};
    c.segments[0].cells = cells;
    m.coolants = {c};
    mesh::SensorSpec back;
    back.id = "back";
    back.return_of = "main";
    m.sensors = {back};
    const Bench bench(bar_mesh(m));
    const auto of = bench.model.coefficients(bench.model.channels().defaults(), Eigen::VectorXd::Constant(1, 100.0));
    return (bench.system.sensors * solver::solve_steady(bench.system, of))[0];
  };
  const double exact = 100.0 * std::exp(-2.0);
  expect_value(
      {"coolant along a wall, four cells", "exact: exp(-NTU), NTU = 2", "outlet less wall, % of inlet less wall"},
      exact, outlet(4), 0.05);
  expect_order({"coolant along a wall", "exact: exp(-NTU), NTU = 2", "order of the outlet's error in the cells"}, 3.0,
               std::log2((outlet(8) - exact) / (outlet(16) - exact)));
}

TEST(Exact, TankWithAPump) {
  mesh::Machine m = bar_machine();
  mesh::VolumeSpec tank;
  tank.id = "tank";
  tank.capacity = {4180.0 * 50.0, 0.0};
  tank.exchanges = {{"air", {8.0, 0.0}, ""}};
  m.volumes = {tank};
  m.sources = {heat_source("pump", 200.0, "", "tank")};
  mesh::SensorSpec inside;
  inside.id = "inside";
  inside.volume = "tank";
  m.sensors = {inside};
  const Bench bench(bar_mesh(m));
  const double exact = 25.0 * (1.0 - std::exp(-8.0 * 18000.0 / tank.capacity.value));
  expect_value({"tank with a pump of 200 W", "exact: P/G (1 - exp(-G t / C))", "K above the air after 5 h"}, exact,
               bench.run("time_step_s = 300\noutput_s = 18000\n[[phase]]\nduration_h = 5\n").sensors.back()[0], 1e-3);
}

}  // namespace
}  // namespace thermotwin::test
