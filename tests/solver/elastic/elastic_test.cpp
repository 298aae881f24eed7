// SPDX-License-Identifier: GPL-3.0-or-later
// One elastic body against exact solutions.
#include <gtest/gtest.h>

#include <random>

#include "core/error.h"
#include "solver/elastic/assembly.h"
#include "solver/elastic/functionals.h"
#include "solver/linear/sparse_factor.h"
#include "tests/machines/box_mesh.h"

namespace thermotwin::solver {
namespace {

/// Box with its inner nodes moved at random, so that no symmetry helps.
mesh::TetMesh shaken_box(int order = 1) {
  mesh::TetMesh box = test::box_mesh({0, 0, 0}, {0.4, 0.3, 0.2}, {4, 3, 3});
  std::vector<char> skin(box.nodes(), 0);
  for (Eigen::Index i = 0; i < box.faces.size(); ++i) skin[box.faces.data()[i]] = 1;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shift(-0.015, 0.015);
  for (Eigen::Index i = 0; i < box.nodes(); ++i) {
    if (!skin[i])
      for (int k = 0; k < 3; ++k) box.points(k, i) += shift(random);
  }
  mesh::set_order(box, order);
  return box;
}

/// Linear and quadratic tetrahedra.
class ElasticOfOrder : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Orders, ElasticOfOrder, ::testing::Values(1, 2));

TEST_P(ElasticOfOrder, ThermalLoadIsInEquilibrium) {
  const mesh::TetMesh box = shaken_box(GetParam());
  const ElasticBody body = assemble_elastic(box, test::steel(), "box");
  const Eigen::MatrixXd resultants = body.thermal_load.transpose() * body.rigid;
  EXPECT_LT(resultants.cwiseAbs().maxCoeff(), 1e-9 * Eigen::MatrixXd(body.thermal_load).cwiseAbs().maxCoeff());
}

TEST_P(ElasticOfOrder, SupportsCarryNothingUnderALoadInEquilibrium) {
  // Pull the two ends of the box apart: uniform stress, whatever the supports are.
  const mesh::TetMesh box = shaken_box(GetParam());
  const mesh::Material material = test::steel();
  const ElasticBody body = assemble_elastic(box, material, "box");
  Eigen::MatrixXd load = Eigen::MatrixXd::Zero(3 * box.nodes(), 1);
  const double pressure = 1e6;
  for (const auto& [group, sign] : {std::pair{"x0", -1.0}, std::pair{"x1", 1.0}}) {
    for (int face : box.groups.at(group)) {
      for (int i = 0; i < 3; ++i) {
        const int node = GetParam() == 1 ? box.faces(i, face) : box.face_edges(i, face);
        load(3 * node, 0) += sign * pressure * box.face_area(face) / 3.0;
      }
    }
  }
  clear_fixed(body, load);
  const Eigen::VectorXd motion = SparseFactor(body.stiffness).solve(load).col(0);
  const Eigen::VectorXd cold = Eigen::VectorXd::Zero(box.nodes());
  Eigen::MatrixXd stress(6, box.elements());
  for (Eigen::Index e = 0; e < box.elements(); ++e)
    stress.col(e) = stress_at(box, material, motion, cold, e, Eigen::Vector4d::Constant(0.25));
  EXPECT_LT((stress.row(0).array() - pressure).abs().maxCoeff(), 1e-7 * pressure);
  EXPECT_LT(stress.bottomRows(5).cwiseAbs().maxCoeff(), 1e-7 * pressure);
}

TEST_P(ElasticOfOrder, RigidMotionIsRecovered) {
  const mesh::TetMesh box = shaken_box(GetParam());
  const Eigen::Vector3d point(0.7, -0.2, 0.4), shift(1e-6, -2e-6, 3e-6), turn(4e-6, 5e-6, -6e-6);
  const auto fit = rigid_motion(box, box.groups.at("z1"), point, "z1");
  Eigen::VectorXd motion(3 * box.nodes());
  for (Eigen::Index i = 0; i < box.nodes(); ++i)
    motion.segment<3>(3 * i) = shift + turn.cross(box.points.col(i) - point);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(evaluate(fit[i], motion), shift[i], 1e-16);
    EXPECT_NEAR(evaluate(fit[3 + i], motion), turn[i], 1e-16);
  }
  const Functional growth = radial_growth(box, box.groups.at("z1"), {0.1, 0.2, 0.0}, Eigen::Vector3d::UnitZ());
  EXPECT_NEAR(evaluate(growth, motion), 0.0, 1e-16);
  for (Eigen::Index i = 0; i < box.nodes(); ++i) motion.segment<3>(3 * i) += 2e-5 * box.points.col(i);
  EXPECT_NEAR(evaluate(growth, motion), 2e-5, 1e-15);
}

TEST(ElasticFunctionals, SurfaceOnALineIsRefused) {
  mesh::TetMesh needle;  // its two triangles are so thin that rotation about the line is lost
  needle.points.resize(3, 4);
  needle.points << 0, 1, 2, 3, 0, 1e-7, 0, 1e-7, 0, 0, 1e-7, 0;
  needle.faces.resize(3, 2);
  needle.faces << 0, 1, 1, 2, 2, 3;
  EXPECT_THROW(rigid_motion(needle, {0, 1}, Eigen::Vector3d::Zero(), "needle"), core::MeshError);
  EXPECT_THROW(rigid_motion(needle, {}, Eigen::Vector3d::Zero(), "nothing"), core::MeshError);
}

}  // namespace
}  // namespace thermotwin::solver
