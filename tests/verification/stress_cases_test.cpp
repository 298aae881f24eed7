// SPDX-License-Identifier: GPL-3.0-or-later
// Published cases of thermal stress: NAFEMS T1 and LE11, VPCS HPLA100 and HSLA303. Stresses are read
// at nodes, recovered as for the output files; symmetry is held by elimination here.
#include <gtest/gtest.h>

#include "solver/elastic/stress.h"
#include "tests/verification/rig.h"
#include "tests/verification/table.h"

namespace thermotwin::test {
namespace {

mesh::Material elastic_material(double young, double poisson, double expansion) {
  mesh::Material m = steel();
  m.young = young;
  m.poisson = poisson;
  m.expansion = {expansion, 0.0};
  return m;
}

/// The box with its nodes moved by a map of [0, 1]^3.
template <class Map>
mesh::TetMesh mapped(const Eigen::Vector3i& cells, int order, const Map& map) {
  mesh::TetMesh mesh = box_mesh({0, 0, 0}, {1, 1, 1}, cells);
  for (Index i = 0; i < mesh.nodes(); ++i) mesh.points.col(i) = map(Vector3d(mesh.points.col(i)));
  for (Index e = 0; e < mesh.elements(); ++e)
    if (mesh.volume(e) < 0) std::swap(mesh.tets(2, e), mesh.tets(3, e));
  mesh::build_boundary(mesh, "mapped");
  mesh::set_order(mesh, order);
  return mesh;
}

template <class Field>
Eigen::VectorXd at_nodes(const mesh::TetMesh& mesh, const Field& field) {
  Eigen::VectorXd values(mesh.nodes());
  for (Index i = 0; i < mesh.nodes(); ++i) values[i] = field(Vector3d(mesh.points.col(i)));
  return values;
}

/// Unknowns of one direction at nodes where a condition holds.
template <class Condition>
void hold(const mesh::TetMesh& mesh, int direction, const Condition& condition, std::vector<Index>& held) {
  for (const Index node : nodes_where(mesh, condition)) held.push_back(3 * node + direction);
}

/// The elements whose centres fulfil a condition, with all nodes of the mesh.
template <class Condition>
mesh::TetMesh part_of(const mesh::TetMesh& mesh, const Condition& condition) {
  mesh::TetMesh part;
  part.points = mesh.points;
  std::vector<Index> kept;
  for (Index e = 0; e < mesh.elements(); ++e) {
    Vector3d centre = Vector3d::Zero();
    for (int i = 0; i < 4; ++i) centre += 0.25 * mesh.points.col(mesh.tets(i, e));
    if (condition(centre)) kept.push_back(e);
  }
  part.tets = mesh.tets(Eigen::all, kept);
  if (mesh.order() == 2) part.tet_edges = mesh.tet_edges(Eigen::all, kept);
  return part;
}

TEST(Nafems, T1MembraneWithAHotSpot) {
  // 20 x 20 mm, thin; a spot of 1 mm radius would expand by 1e-3. In mm and MPa. The answer of plane
  // stress, E alpha T / 2, does not depend on Poisson's ratio; a solid has it for 0 alone, since at
  // the rim the two sides hold each other across the plate too.
  const mesh::Material m = elastic_material(100e3, 0.0, 1e-3);
  for (int order : {1, 2}) {
    const int inner = order == 1 ? 6 : 4, outer = order == 1 ? 12 : 8, cells = 2 * (inner + outer);
    const auto distance = [&](double t) {  // of grid lines from the centre; 1 is the spot's rim
      const double line = std::abs(t) * (inner + outer);
      return line <= inner ? line / inner : std::pow(10.0, (line - inner) / outer);
    };
    const mesh::TetMesh plate = mapped({cells, cells, 1}, order, [&](const Vector3d& p) {
      const double a = 2 * p.x() - 1, b = 2 * p.y() - 1, line = std::max(std::abs(a), std::abs(b));
      if (line < 1e-12) return Vector3d(0, 0, 0.05 * p.z());
      // Squares in the middle and outside, the circle of the spot between.
      const double r = distance(line);
      const Eigen::Vector2d square = r * Eigen::Vector2d(a, b) / line, circle = r * Eigen::Vector2d(a, b).normalized();
      const double round = r <= 1.0 ? r : std::max(0.0, (4.0 - r) / 3.0);
      const Eigen::Vector2d q = round * circle + (1 - round) * square;
      return Vector3d(q.x(), q.y(), 0.05 * p.z());
    });
    const auto is_hot = [](const Vector3d& p) { return p.head<2>().norm() < 1.0; };
    const mesh::TetMesh hot = part_of(plate, is_hot),
                        cold = part_of(plate, [&](const Vector3d&p) { return !is_hot(p); });
    const Eigen::VectorXd warm = Eigen::VectorXd::Ones(plate.nodes());
    const solver::ElasticBody body = solver::assemble_elastic(plate, m, "plate");
    Eigen::MatrixXd load = solver::thermal_load(hot, m) * warm;  // the temperature jumps at the rim
    solver::clear_fixed(body, load);
    const Eigen::VectorXd u = solver::SparseFactor(body.stiffness).solve(load).col(0);
    // On the cold side, whose nodes are numbered anew.
    mesh::TetMesh side = cold;
    std::vector<Index> old;
    std::vector<int> number(plate.nodes(), -1);
    for (Index e = 0; e < cold.elements(); ++e) {
      for (const int node : mesh::tet_nodes(cold, e))
        if (int& n = number[node]; n < 0) n = std::ssize(old), old.push_back(node);
    }
    const auto renumber = [&](int node) { return number[node]; };
    side.tets = cold.tets.unaryExpr(renumber);
    if (order == 2) side.tet_edges = cold.tet_edges.unaryExpr(renumber);
    side.points = plate.points(Eigen::all, old);
    Eigen::VectorXd motion(3 * side.nodes());
    for (std::size_t i = 0; i < old.size(); ++i) motion.segment<3>(3 * i) = u.segment<3>(3 * old[i]);
    const Eigen::MatrixXd stress = solver::StressRecovery(side).nodal(m, motion, Eigen::VectorXd::Zero(side.nodes()));
    expect_value({of_order("NAFEMS T1", order), "NAFEMS, plane stress", "sigma_yy at D, MPa"}, 50.0,
                 stress(1, node_at(side, {1.0, 0.0, 0.025})), 1.5);
  }
}

TEST(Nafems, Le11SolidCylinderTaperSphere) {
  const mesh::Material m = elastic_material(210e9, 0.3, 2.3e-4);
  for (int order : {1, 2}) {
    const Eigen::Vector3i cells = order == 1 ? Eigen::Vector3i(8, 33, 20) : Eigen::Vector3i(5, 22, 12);
    const double root = std::sqrt(0.5);
    const mesh::TetMesh body = mapped(cells, order, [&](const Vector3d& p) {
      // Up the wall: arcs to s = 1, taper to s = 2, cylinder from there; r and z of its two sides.
      // Its cells are a multiple of 11, so that the kinks are on grid lines.
      const double s = 2.75 * p.y();
      Eigen::Vector2d inside, outside;
      if (s <= 1.0) {
        inside = {std::cos(s * M_PI / 4), std::sin(s * M_PI / 4)};
        const double top = std::asin(root / 1.4) * s;
        outside = 1.4 * Eigen::Vector2d(std::cos(top), std::sin(top));
      } else if (s <= 2.0) {
        inside = {root, root + 0.69 * (s - 1)};
        outside = (2 - s) * Eigen::Vector2d(std::sqrt(1.96 - 0.5), root) + (s - 1) * Eigen::Vector2d(1.0, root + 0.69);
      } else {
        const double up = (s - 2.0) / 0.75;
        inside = {root, root + 0.69 + 0.4 * up};
        outside = {1.0, root + 0.69 + 0.4 * up};
      }
      const Eigen::Vector2d q = inside + p.x() * (outside - inside);
      const double turn = p.z() * M_PI / 2;
      return Vector3d(q.x() * std::cos(turn), q.x() * std::sin(turn), q.y());
    });
    const Eigen::VectorXd warm = at_nodes(body, [](const Vector3d& p) { return p.head<2>().norm() + p.z(); });
    const double top = root + 1.09, near = 1e-9;
    std::vector<Index> held;
    hold(
        body, 0, [&](const Vector3d& p) { return std::abs(p.x()) < near; }, held);
    hold(
        body, 1, [&](const Vector3d& p) { return std::abs(p.y()) < near; }, held);
    hold(
        body, 2, [&](const Vector3d& p) { return std::abs(p.z()) < near || std::abs(p.z() - top) < near; }, held);
    const Eigen::VectorXd u =
        solve_held(solver::elastic_stiffness(body, m), solver::thermal_load(body, m) * warm, held);
    const Eigen::MatrixXd stress = solver::StressRecovery(body).nodal(m, u, warm);
    expect_value({of_order("NAFEMS LE11", order), "NAFEMS", "sigma_zz at A, MPa"}, -105.0,
                 stress(2, node_at(body, {1, 0, 0})) / 1e6, order == 1 ? 10.0 : 3.5);
  }
}

TEST(Vpcs, Hpla100HollowCylinder) {
  // In mm and MPa; a quarter of a ring, its ends held along the axis. T = r - 20: the mean strain
  // nearly vanishes, so the facets of the ring must be fine.
  const mesh::Material m = elastic_material(2e5, 0.3, 1e-5);
  const mesh::TetMesh ring = mapped({2, 640, 1}, 2, [](const Vector3d& p) {
    const double r = 19.5 + p.x(), turn = 0.5 * M_PI * p.y();
    return Vector3d(r * std::cos(turn), r * std::sin(turn), 0.1 * p.z());
  });
  const double near = 1e-9;
  std::vector<Index> held;
  hold(
      ring, 0, [&](const Vector3d& p) { return std::abs(p.x()) < near; }, held);
  hold(
      ring, 1, [&](const Vector3d& p) { return std::abs(p.y()) < near; }, held);
  hold(
      ring, 2, [&](const Vector3d& p) { return std::abs(p.z()) < near || std::abs(p.z() - 0.1) < near; }, held);
  const solver::SparseMatrix stiffness = solver::elastic_stiffness(ring, m), load = solver::thermal_load(ring, m);
  const Index inside = node_at(ring, {19.5, 0, 0}), outside = node_at(ring, {20.5, 0, 0});
  const Figure figure{"HPLA100, P2", "VPCS; exact formula", ""};
  const auto check = [&](const char* quantity, double reference, double ours, double tolerance) {
    expect_value({figure.name, figure.source, quantity}, reference, ours, tolerance);
  };
  const Eigen::VectorXd gradient = at_nodes(ring, [](const Vector3d& p) { return p.head<2>().norm() - 20.0; });
  Eigen::VectorXd u = solve_held(stiffness, load * gradient, held);
  check("u_r at Ri, T = r - 20, mm", 1.05625e-6, u[3 * inside], 1e-8);
  check("u_r at Re, T = r - 20, mm", 1.110417e-6, u[3 * outside], 1e-8);
  check("sigma_z at Ri, T = r - 20, MPa", 1.4321429, solver::StressRecovery(ring).nodal(m, u, gradient)(2, inside),
        0.01);
  const Eigen::VectorXd even = Eigen::VectorXd::Constant(ring.nodes(), 0.1);
  u = solve_held(stiffness, load * even, held);
  check("u_r at Ri, T = 0.1, mm", 2.535e-5, u[3 * inside], 1e-9);
  check("sigma_z at Ri, T = 0.1, MPa", -0.2, solver::StressRecovery(ring).nodal(m, u, even)(2, inside), 1e-4);
}

TEST(Vpcs, Hsla303FreeExpansion) {
  const mesh::Material m = elastic_material(2.1e11, 0.3, 1.2e-5);
  for (int order : {1, 2}) {
    const mesh::TetMesh box = shaken_box({0.4, 0.3, 0.2}, {4, 3, 3}, order);
    std::vector<Index> held;
    for (int k = 0; k < 3; ++k) {
      hold(
          box, k, [&](const Vector3d& p) { return p[k] < 1e-12; }, held);
    }
    const Eigen::VectorXd warm = Eigen::VectorXd::Constant(box.nodes(), 100.0);
    const Eigen::VectorXd u = solve_held(solver::elastic_stiffness(box, m), solver::thermal_load(box, m) * warm, held);
    double error = 0.0;
    for (Index i = 0; i < box.nodes(); ++i)
      error = std::max(error, (u.segment<3>(3 * i) - 1.2e-3 * box.points.col(i)).norm());
    expect_below({of_order("HSLA303", order), "VPCS; u = 1.2e-3 x", "largest error of u over largest u"}, 1e-10,
                 error / (1.2e-3 * 0.538));
    expect_below({of_order("HSLA303", order), "VPCS; no stress", "largest stress, Pa"}, 10.0,
                 solver::StressRecovery(box).nodal(m, u, warm).cwiseAbs().maxCoeff());
  }
}

}  // namespace
}  // namespace thermotwin::test
