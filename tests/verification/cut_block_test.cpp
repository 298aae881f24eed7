// SPDX-License-Identifier: GPL-3.0-or-later
// A block cut in two, the halves meshed so that nothing matches, joined as firmly as a joint can be:
// it must come to be the uncut block, in heat and in elasticity, and no heat is lost in the cut.
#include <gtest/gtest.h>

#include <cmath>
#include <iterator>

#include "solver/elastic/model.h"
#include "solver/thermal/assembly.h"
#include "solver/thermal/elements.h"
#include "tests/machines/box_machine.h"
#include "tests/machines/slide_machine.h"
#include "tests/verification/rig.h"
#include "tests/verification/table.h"

namespace thermotwin::test {
namespace {

const Vector3d corner(0.3, 0.1, 0.12);
constexpr double cut = 0.13;

mesh::Machine block_machine(bool in_two, int order, int pads) {
  const std::string left = in_two ? "left" : "block", right = in_two ? "right" : "block";
  mesh::Machine m;
  m.order = order;
  m.path = "block/machine.toml";
  m.reference_C = 20.0;
  m.materials = {steel()};
  m.bodies = {body(left)};
  if (in_two) m.bodies.push_back(body(right));
  m.surfaces = {surface("cold", left, {"x0"}), surface("hot", right, {"x1"}), surface("side.left", left, {"y1"}),
                surface("side.right", right, {"y1"})};
  m.ambients = {ambient("air", 30.0), ambient("foundation", 15.0)};
  m.films = {
      constant_film("cold", {"cold"}, 800.0, "foundation"),
      constant_film(
          "side", in_two ? std::vector<std::string>{"side.left", "side.right"} : std::vector<std::string>{"side.left"},
          200.0)};
  m.sources = {source("heater", "machine.on", {0, 1}, {0, 150}, {on_surface("hot")})};
  mesh::JointSpec mount = elastic_joint("mount", "mount", "cold", "", "", {1, 2, 2});
  mount.conductance = {0.0, 0.0};
  m.joints = {mount};
  if (in_two) {
    m.surfaces.push_back(surface("left.cut", "left", {"x1"}));
    m.surfaces.push_back(surface("right.cut", "right", {"x0"}));
    mesh::JointSpec joint = elastic_joint("cut", "bolted", "right.cut", "left.cut", "", {1, pads, pads});
    joint.conductance = {1e8, 0.0};
    joint.stiffness_normal = joint.stiffness_tangential = {1e15, 0.0};
    m.joints.push_back(joint);
  }
  m.tcp.tool_body = right;
  m.tcp.tool_surface = "hot";
  m.tcp.tool_point = corner;
  m.tcp.table_body = left;
  m.tcp.table_surface = "cold";
  m.tcp.table_radius = 0.05;
  return m;
}

mesh::MachineMesh uncut_block(int order, const Eigen::Vector3i& cells) {
  return machine_mesh(block_machine(false, order, 1), {box_of_order(Vector3d::Zero(), corner, cells, order)});
}

mesh::MachineMesh cut_block(int order, int finer) {
  return machine_mesh(
      block_machine(true, order, 2 * finer),
      {box_of_order(Vector3d::Zero(), {cut, corner.y(), corner.z()}, finer * Eigen::Vector3i(4, 3, 3), order),
       box_of_order({cut, 0, 0}, corner, finer * Eigen::Vector3i(5, 4, 4), order)});
}

/// A field's value at a place, whatever the mesh.
double value_at(const mesh::MachineMesh& mesh, const Eigen::VectorXd& field, const Vector3d& place) {
  const std::size_t b = mesh.bodies.size() > 1 && place.x() > cut ? 1 : 0;
  double value = 0.0;
  for (const auto& [node, weight] : solver::interpolation_at(mesh.bodies[b], place))
    value += weight * field[mesh.first_node[b] + node];
  return value;
}

std::vector<Vector3d> places() {
  std::vector<Vector3d> all;
  for (const double x : {0.02, 0.07, 0.11, 0.129, 0.131, 0.16, 0.21, 0.29}) {
    for (const double y : {0.013, 0.052, 0.091})
      for (const double z : {0.011, 0.067, 0.113}) all.emplace_back(x, y, z);
  }
  return all;
}

/// Root mean square over the places, of the range or the largest.
double error(const Eigen::MatrixXd& values, const Eigen::MatrixXd& exact, double size) {
  return (values - exact).norm() / std::sqrt(values.cols()) / size;
}

Eigen::RowVectorXd temperatures(const mesh::MachineMesh& mesh, double* unbalanced = nullptr) {
  const solver::ThermalSystem system = solver::assemble_thermal(mesh);
  const solver::OperatingModel model(mesh.machine, system.layout);
  const solver::Coefficients c = model.coefficients(model.channels().defaults(), Eigen::VectorXd(0));
  const Eigen::VectorXd temperature = solver::solve_steady(system, c);
  if (unbalanced) {
    // What leaves one half less what enters the other, over the sum of all that is exchanged.
    const solver::SparseMatrix& joint = system.terms.back();
    const Eigen::VectorXd heat = joint * temperature;
    *unbalanced = std::abs(heat.sum()) / (joint.cwiseAbs() * temperature.cwiseAbs()).sum();
    EXPECT_GT((joint.cwiseAbs() * temperature.cwiseAbs()).sum(), 0.0);
  }
  Eigen::RowVectorXd values(std::ssize(places()));
  for (Index i = 0; i < values.size(); ++i) values[i] = value_at(mesh, temperature, places()[i]);
  return values;
}

Eigen::MatrixXd displacements(const mesh::MachineMesh& mesh) {
  const solver::ThermalSystem system = solver::assemble_thermal(mesh);
  const solver::ElasticModel elastic(mesh, system);
  Eigen::VectorXd temperature(mesh.nodes());  // one that bends, K
  for (std::size_t b = 0; b < mesh.bodies.size(); ++b) {
    for (Index i = 0; i < mesh.bodies[b].nodes(); ++i) {
      const Vector3d p = mesh.bodies[b].points.col(i).cwiseQuotient(corner);
      temperature[mesh.first_node[b] + i] = 10.0 * p.z() * (1.0 + p.x()) + 5.0 * std::sin(2.0 * p.x()) * p.y();
    }
  }
  const Eigen::Matrix3Xd u = elastic.displacement(temperature, mesh::home_pose(mesh.machine));
  Eigen::MatrixXd values(3, std::ssize(places()));
  for (Index i = 0; i < values.cols(); ++i)
    for (int k = 0; k < 3; ++k) values(k, i) = value_at(mesh, u.row(k).transpose(), places()[i]);
  return values;
}

template <class Values>
void expect_convergence(const std::string& quantity, const Eigen::MatrixXd& exact, double size, const Values& values,
                        double tolerance, double order_tolerance) {
  double before = 0.0;
  for (const int finer : {1, 2, 4}) {
    const double now = error(values(finer), exact, size);
    const std::string mesh = std::to_string(4 * finer) + " and " + std::to_string(5 * finer) + " cells along";
    expect_value({"block cut in two, P1", "the uncut block, P2, fine", "error of " + quantity + ", %, " + mesh}, 0.0,
                 100.0 * now, tolerance);
    if (before > 0.0) {
      expect_value(
          {"block cut in two, P1", "the uncut block, P2, fine", "order of the error of " + quantity + ", " + mesh}, 2.0,
          std::log2(before / now), order_tolerance);
    }
    before = now;
  }
}

TEST(CutBlock, HeatConvergesToTheUncutOne) {
  const Eigen::RowVectorXd exact = temperatures(uncut_block(2, {18, 8, 8}));
  double worst = 0.0;
  expect_convergence(
      "T", exact, exact.maxCoeff() - exact.minCoeff(),
      [&](int finer) {
        double unbalanced = 0.0;
        const Eigen::RowVectorXd values = temperatures(cut_block(1, finer), &unbalanced);
        worst = std::max(worst, unbalanced);
        return values;
      },
      1.0, 0.1);
  expect_below({"block cut in two, P1", "exact", "heat lost in the joint, over all that its nodes exchange"}, 1e-14,
               worst);
}

TEST(CutBlock, DisplacementConvergesToTheUncutOne) {
  const Eigen::MatrixXd exact = displacements(uncut_block(2, {14, 6, 6}));
  expect_convergence(
      "u", exact, exact.colwise().norm().maxCoeff(), [&](int finer) { return displacements(cut_block(1, finer)); },
      10.0, 0.4);  // few pads at first
}

}  // namespace
}  // namespace thermotwin::test
