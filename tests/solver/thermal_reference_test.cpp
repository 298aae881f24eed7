// SPDX-License-Identifier: GPL-3.0-or-later
// Cases with published or analytic numbers.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>

#include "solver/thermal_system.h"
#include "tests/solver/box_mesh.h"

namespace thermotwin::solver {

namespace {

mesh::Machine one_body(const mesh::Material& material) {
  mesh::Machine m;
  m.reference_C = 0.0;
  m.materials = {material};
  m.bodies = {test::body("bar", material.id)};
  m.ambients = {test::ambient("air", 0.0), test::ambient("hot", 0.0)};
  return m;
}

/// Mean temperature over a surface, from its film's ambient load.
double surface_mean(const ThermalSystem& system, int film, const Eigen::VectorXd& state) {
  for (std::size_t k = 0; k < system.layout.inputs.size(); ++k)
    if (system.layout.inputs[k].kind == InputKind::film_ambient && system.layout.inputs[k].item == film) {
      const Eigen::VectorXd column = system.inputs.col(static_cast<Eigen::Index>(k));
      return state.dot(column) / column.sum();
    }
  throw std::logic_error("no such film");
}

}  // namespace

TEST(ThermalReference, TwoBodiesInContactConductLikeResistancesInSeries) {
  mesh::Machine m = one_body(test::steel());
  m.materials.push_back(test::steel());
  m.materials[1].id = "concrete";
  m.materials[1].conductivity = 2.0;
  m.bodies = {test::body("left", "steel"), test::body("right", "concrete")};
  m.surfaces = {test::surface("left.outside", "left", {"x0"}), test::surface("left.contact", "left", {"x1"}),
                test::surface("right.contact", "right", {"x0"}), test::surface("right.outside", "right", {"x1"})};
  m.ambients = {test::ambient("air", 0.0), test::ambient("hot", 100.0)};
  m.films = {test::constant_film("left", {"left.outside"}, 500.0, "hot"), test::constant_film("right", {"right.outside"}, 80.0)};
  mesh::JointSpec joint;
  joint.id = "bolts";
  joint.kind = "bolted";
  joint.slave = "left.contact";
  joint.master = "right.contact";
  joint.conductance = {300.0, 0.0};
  m.joints = {joint};
  const auto mesh = test::machine_mesh(m, {test::box_mesh({0, 0, 0}, {0.1, 0.1, 0.1}, {3, 4, 3}),
                                           test::box_mesh({0.1, 0, 0}, {0.2, 0.1, 0.1}, {4, 3, 5})});
  const ThermalSystem system = assemble_thermal(mesh);
  const OperatingModel model(m, system.layout);
  const Eigen::VectorXd t = solve_steady(system, model.coefficients(model.channels().defaults(), Eigen::VectorXd()));
  const double flux = 100.0 / (1.0 / 500 + 0.1 / 45 + 1.0 / 300 + 0.1 / 2 + 1.0 / 80);
  EXPECT_NEAR(surface_mean(system, 0, t), 100.0 - flux / 500, 1e-4 * 100);
  EXPECT_NEAR(surface_mean(system, 1, t), flux / 80, 1e-4 * 100);
  // The field is linear in each body; the contact's quadrature across the master's edges disturbs
  // it a little.
  for (Eigen::Index i = 0; i < mesh.bodies[1].nodes(); ++i) {
    const double x = mesh.bodies[1].points(0, i) - 0.1;
    EXPECT_NEAR(t[mesh.first_node[1] + i], flux / 80 + flux / 2.0 * (0.1 - x), 0.2);
  }
}

TEST(ThermalReference, NafemsT3) {
  mesh::Material material = test::steel();
  material.conductivity = 35.0;
  material.specific_heat = {440.5, 0.0};
  material.density = 7200.0;
  mesh::Machine m = one_body(material);
  m.surfaces = {test::surface("cold", "bar", {"x0"}), test::surface("hot", "bar", {"x1"})};
  // Films so large that the faces take the given temperatures.
  m.films = {test::constant_film("cold", {"cold"}, 1e7, "air"), test::constant_film("hot", {"hot"}, 1e7, "hot")};
  const auto mesh = test::machine_mesh(m, {test::box_mesh({0, 0, 0}, {0.1, 0.005, 0.005}, {40, 1, 1})});
  const ThermalSystem system = assemble_thermal(mesh);
  const OperatingModel model(m, system.layout);
  ThermalIntegrator integrator(system);
  Eigen::MatrixXd state = Eigen::MatrixXd::Zero(system.size, 1);
  Eigen::VectorXd row = model.channels().defaults();
  constexpr double h = 0.25, w = std::numbers::pi / 40.0;
  for (int i = 0; i < 128; ++i) {
    row[model.channels().index("hot.T_C")] = 100.0 * (std::cos(w * i * h) - std::cos(w * (i + 1) * h)) / (w * h);
    integrator.advance(state, {model.coefficients(row, Eigen::VectorXd())}, h);
  }
  double value = 0.0;
  int found = 0;
  for (Eigen::Index i = 0; i < mesh.bodies[0].nodes(); ++i)
    if (std::abs(mesh.bodies[0].points(0, i) - 0.08) < 1e-9) {
      value += state(i, 0);
      ++found;
    }
  ASSERT_EQ(found, 4);
  EXPECT_NEAR(value / found, 36.60, 0.05);
}

TEST(ThermalReference, PlateAgainstAnsys) {
  const char* folder = std::getenv("THERMOTWIN_DATA");
  const std::filesystem::path data = folder ? std::filesystem::path(folder)
                                            : std::filesystem::path(THERMOTWIN_SOURCE_DIR) / ".." / "shared" / "data";
  const std::filesystem::path file = data / "verification" / "cuboid_flat_ansys.csv";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "cuboid_flat_ansys.csv is not there";
  mesh::Material material = test::steel();
  material.density = 8000;
  material.specific_heat = {500.0, 0.0};
  material.conductivity = 50;
  mesh::Machine m = one_body(material);
  m.reference_C = 20.0;
  m.ambients = {test::ambient("air", 20.0)};
  m.surfaces = {test::surface("bottom", "bar", {"y0"}), test::surface("top", "bar", {"y1"}),
                test::surface("front", "bar", {"z1"}), test::surface("rest", "bar", {"x0", "x1", "z0"})};
  m.films = {test::constant_film("top", {"top"}, 10.0), test::constant_film("front", {"front"}, 10.0),
             test::constant_film("rest", {"rest"}, 10.0), test::constant_film("bottom", {"bottom"}, 0.0)};
  mesh::SourceSpec heater;
  heater.id = "heater";
  heater.laws = {{"machine.on", {0, 1}, {0, 1000}}};
  mesh::SourcePlace place;
  place.surface = "bottom";
  heater.places = {place};
  m.sources = {heater};
  const auto mesh = test::machine_mesh(m, {test::box_mesh({0, 0, 0}, {0.5, 1.0, 0.05}, {12, 50, 3})});
  const ThermalSystem system = assemble_thermal(mesh);
  const OperatingModel model(m, system.layout);
  const Coefficients c = model.coefficients(model.channels().defaults(), Eigen::VectorXd());
  ThermalIntegrator integrator(system);
  Eigen::MatrixXd state = Eigen::MatrixXd::Zero(system.size, 1);

  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  const auto node_at = [&](const Eigen::Vector3d& p) {
    Eigen::Index node = 0;
    (mesh.bodies[0].points.colwise() - p).colwise().squaredNorm().minCoeff(&node);
    return node;
  };
  const Eigen::Index bottom_vertex = node_at({0, 0, 0.05}), top_vertex = node_at({0.5, 1.0, 0.05});
  // Columns of the reference: time, mean bottom, mean front, mean top, bottom vertex, top vertex. Its
  // front stands 0.4 K above our area mean from the first minutes on while everything else agrees,
  // as a mean of nodes would; it is left out.
  double time = 0.0, last_bottom = 0.0;
  double worst_bottom = 0.0, worst_top = 0.0, worst_bottom_vertex = 0.0, worst_top_vertex = 0.0;
  int compared = 0;
  while (std::getline(in, line)) {
    std::istringstream cells(line);
    std::string cell;
    std::vector<double> values;
    while (std::getline(cells, cell, ';')) values.push_back(std::stod(cell));
    if (values.size() < 6 || values[0] < time + 60.0) continue;
    const int steps = std::max(1, static_cast<int>(std::ceil((values[0] - time) / 60.0)));
    for (int i = 0; i < steps; ++i) integrator.advance(state, {c}, (values[0] - time) / steps);
    time = values[0];
    last_bottom = surface_mean(system, 3, state.col(0)) + 20.0;
    if (time < 600.0) continue;  // the heat is still within the first elements
    worst_bottom = std::max(worst_bottom, std::abs(last_bottom - values[1]));
    worst_top = std::max(worst_top, std::abs(surface_mean(system, 0, state.col(0)) + 20.0 - values[3]));
    worst_bottom_vertex = std::max(worst_bottom_vertex, std::abs(state(bottom_vertex, 0) + 20.0 - values[4]));
    worst_top_vertex = std::max(worst_top_vertex, std::abs(state(top_vertex, 0) + 20.0 - values[5]));
    ++compared;
  }
  EXPECT_GT(compared, 100);
  // The reference is printed with five digits; its bottom ends at 289.50.
  EXPECT_NEAR(last_bottom, 289.50, 0.25);
  EXPECT_LT(worst_bottom, 0.35);
  EXPECT_LT(worst_top, 0.05);
  EXPECT_LT(worst_bottom_vertex, 0.4);
  EXPECT_LT(worst_top_vertex, 0.1);
  std::printf("largest differences: bottom %.4f K, top %.4f K, bottom vertex %.4f K, top vertex %.4f K over %d times\n",
              worst_bottom, worst_top, worst_bottom_vertex, worst_top_vertex, compared);

  // Steady: all power leaves by the films.
  const Eigen::VectorXd steady = solve_steady(system, c);
  EXPECT_NEAR(surface_mean(system, 3, steady) + 20.0, 291.1152, 0.27);  // 1e-3 of the rise
  double lost = 0.0;
  for (int film = 0; film < 3; ++film) {
    double area = 0.0;
    for (const std::string& s : m.films[static_cast<std::size_t>(film)].surfaces)
      for (int f : mesh.surfaces[static_cast<std::size_t>(m.surface_index(s))]) area += mesh.bodies[0].face_area(f);
    lost += 10.0 * area * surface_mean(system, film, steady);
  }
  EXPECT_NEAR(lost, 1000.0, 1e-6);
}

}  // namespace thermotwin::solver
