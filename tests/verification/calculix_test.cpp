// SPDX-License-Identifier: GPL-3.0-or-later
// An independent code on the same mesh: steady temperatures and the displacements they cause.

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "solver/elastic_assembly.h"
#include "solver/sparse_factor.h"
#include "solver/thermal_system.h"
#include "tests/solver/box_mesh.h"
#include "tests/verification/calculix_deck.h"
#include "tests/verification/table.h"

namespace thermotwin::solver {
namespace {

/// L-shaped body: an upright wall on a foot, cut from a structured box.
mesh::TetMesh angle_bracket(int order) {
  const mesh::TetMesh box = order == 1 ? test::box_mesh({0, 0, 0}, {0.32, 0.12, 0.4}, {16, 6, 20})
                                       : test::box_mesh({0, 0, 0}, {0.32, 0.12, 0.4}, {16, 3, 20});
  std::vector<int> number(static_cast<std::size_t>(box.nodes()), -1);
  mesh::TetMesh bracket;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index e = 0; e < box.elements(); ++e) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (int i = 0; i < 4; ++i) centre += 0.25 * box.points.col(box.tets(i, e));
    if (centre.x() < 0.1 || centre.z() < 0.1) kept.push_back(e);
  }
  bracket.tets.resize(4, static_cast<Eigen::Index>(kept.size()));
  int nodes = 0;
  for (std::size_t k = 0; k < kept.size(); ++k)
    for (int i = 0; i < 4; ++i) {
      int& of = number[static_cast<std::size_t>(box.tets(i, kept[k]))];
      if (of < 0) of = nodes++;
      bracket.tets(i, static_cast<Eigen::Index>(k)) = of;
    }
  bracket.points.resize(3, nodes);
  for (Eigen::Index i = 0; i < box.nodes(); ++i)
    if (number[static_cast<std::size_t>(i)] >= 0) bracket.points.col(number[static_cast<std::size_t>(i)]) = box.points.col(i);
  mesh::build_boundary(bracket, "bracket");
  for (int f = 0; f < static_cast<int>(bracket.face_count()); ++f) {
    const Eigen::Vector3d normal = bracket.face_normal(f), centre = bracket.face_centre(f);
    if (normal.z() < -0.9) bracket.groups["foot"].push_back(f);
    else if (normal.z() > 0.9 && centre.z() > 0.39) bracket.groups["top"].push_back(f);
    else if (normal.y() > 0.9) bracket.groups["side"].push_back(f);
    else if (normal.x() > 0.9) bracket.groups["front"].push_back(f);
  }
  mesh::set_order(bracket, order);
  return bracket;
}

void compare(int order) {
  if (!test::have_ccx()) GTEST_SKIP() << "CalculiX (ccx) is not installed";
  const double reference_C = 20.0, power = 60.0, side_film = 25.0, foot_film = 150.0;
  mesh::Machine machine;
  machine.reference_C = reference_C;
  machine.materials = {test::steel()};
  machine.bodies = {test::body("bracket")};
  machine.surfaces = {test::surface("foot", "bracket", {"foot"}), test::surface("side", "bracket", {"side"}),
                      test::surface("top", "bracket", {"top"}), test::surface("front", "bracket", {"front"})};
  machine.ambients = {test::ambient("air", 23.0), test::ambient("foundation", 18.0)};
  machine.films = {test::constant_film("side", {"side", "front"}, side_film),
                   test::constant_film("foot", {"foot"}, foot_film, "foundation")};
  mesh::SourceSpec source;
  source.id = "motor";
  source.laws = {{"machine.on", {0.0, 1.0}, {0.0, power}}};
  source.places.resize(1);
  source.places[0].surface = "top";
  machine.sources = {source};
  const mesh::MachineMesh mesh = test::machine_mesh(machine, {angle_bracket(order)});
  const mesh::TetMesh& body = mesh.bodies[0];

  const ThermalSystem system = assemble_thermal(mesh);
  const OperatingModel model(mesh.machine, system.layout);
  const Eigen::VectorXd temperature =
      solve_steady(system, model.coefficients(model.channels().defaults(), Eigen::VectorXd(0)));
  const ElasticBody elastic = assemble_elastic(body, machine.materials[0], "bracket");
  Eigen::MatrixXd load = elastic.thermal_load * temperature;
  clear_fixed(elastic, load);
  const Eigen::VectorXd motion = SparseFactor(elastic.stiffness).solve(load).col(0);

  const auto folder = std::filesystem::temp_directory_path() / ("thermotwin_ccx_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  const std::string start = test::ccx_model(body, machine.materials[0], reference_C);
  std::string heat = start + "*STEP\n*HEAT TRANSFER, STEADY STATE\n*FILM\n";
  const auto film = [&](const char* group, double sink, double coefficient) {
    for (int face : body.groups.at(group))
      heat += fmt::format("{}, F{}, {:.6f}, {:.9e}\n", body.face_tet[face] + 1, test::ccx_face(body, face), sink, coefficient);
  };
  film("side", 23.0, side_film);
  film("front", 23.0, side_film);
  film("foot", 18.0, foot_film);
  heat += "*DFLUX\n";
  for (int face : body.groups.at("top"))
    heat += fmt::format("{}, S{}, {:.9e}\n", body.face_tet[face] + 1, test::ccx_face(body, face), power / mesh.surface_area(2));
  heat += "*NODE PRINT, NSET=NALL\nNT\n*END STEP\n";
  const Eigen::MatrixXd ccx_temperature = test::run_ccx(folder.string(), "heat", heat, body.nodes(), 1);
  ASSERT_EQ(ccx_temperature.cols(), body.nodes()) << "ccx failed, see " << folder << "/heat.log";

  const Eigen::VectorXd mine_C = temperature.array() + reference_C;
  const double temperature_difference = (ccx_temperature.row(0).transpose() - mine_C).cwiseAbs().maxCoeff();
  const std::string element = order == 1 ? "C3D4" : "C3D10";
  const test::Figure of_heat{"bracket, P" + std::to_string(order), "CalculiX, the same mesh of " + element,
                             "largest difference of steady T, K"};
  test::expect_value(of_heat, 0.0, temperature_difference, 0.01);
  EXPECT_GT(mine_C.maxCoeff() - mine_C.minCoeff(), 5.0);  // a case with something to compare

  // The same supports and the temperatures of ccx itself.
  std::string bend = start + "*BOUNDARY\n";
  for (Eigen::Index dof : elastic.fixed) bend += fmt::format("{}, {}, {}\n", dof / 3 + 1, dof % 3 + 1, dof % 3 + 1);
  bend += "*STEP\n*STATIC\n*TEMPERATURE\n";
  for (Eigen::Index i = 0; i < body.nodes(); ++i) bend += fmt::format("{}, {:.9e}\n", i + 1, ccx_temperature(0, i));
  bend += "*NODE PRINT, NSET=NALL\nU\n*END STEP\n";
  const Eigen::MatrixXd ccx_motion = test::run_ccx(folder.string(), "bend", bend, body.nodes(), 3);
  ASSERT_EQ(ccx_motion.cols(), body.nodes()) << "ccx failed, see " << folder << "/bend.log";
  const Eigen::Map<const Eigen::MatrixXd> mine(motion.data(), 3, body.nodes());
  const double largest = ccx_motion.colwise().norm().maxCoeff();
  const double difference = (ccx_motion - mine).colwise().norm().maxCoeff();
  EXPECT_GT(largest, 10e-6);
  test::expect_value({of_heat.name, of_heat.source, "largest difference of displacement, % of the largest"}, 0.0,
                     100.0 * difference / largest, 0.5);
  std::filesystem::remove_all(folder);
}

TEST(CalculiX, LinearTetrahedra) { compare(1); }
TEST(CalculiX, QuadraticTetrahedra) { compare(2); }

}  // namespace
}  // namespace thermotwin::solver
