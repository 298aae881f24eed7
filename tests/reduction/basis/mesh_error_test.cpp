// SPDX-License-Identifier: GPL-3.0-or-later
// The estimate of a mesh error from two meshes, on tables whose error is known.
#include "reduction/basis/mesh_error.h"

#include <gtest/gtest.h>

#include <cmath>

namespace thermotwin::reduction {
namespace {

constexpr Eigen::Index time_count = 9, pose_count = 3;

/// A run whose sensors rise and whose TCP moves by 1 to 6 in its directions; sensor s is off by s percent of itself and
/// direction k by k percent of the motion in its three directions, times `error`.
solver::LoadResult run(Eigen::Index sensors, double error) {
  const Eigen::Array<double, 6, 1> motion{1, 2, 3, 4, 5, 6};
  const double all[] = {motion.head<3>().matrix().norm(), motion.tail<3>().matrix().norm()};
  solver::LoadResult result;
  result.sensors.values.resize(time_count, 1 + sensors);
  result.tcp.values.setZero(time_count * pose_count, 3 + 18);
  for (Eigen::Index t = 0; t < time_count; ++t) {
    result.sensors.values(t, 0) = 60.0 * t;
    for (Eigen::Index s = 0; s < sensors; ++s) result.sensors.values(t, 1 + s) = 20 + t * (1 + 0.01 * s * error);
    for (Eigen::Index p = 0; p < pose_count; ++p)
      for (Eigen::Index k = 0; k < 6; ++k)
        result.tcp.values(t * pose_count + p, 3 + k) = 7 + p + t * (motion[k] + 0.01 * k * all[k / 3] * error);
  }
  return result;
}

mesh::Machine machine_with(Eigen::Index sensors) {
  mesh::Machine machine;
  machine.sensors.resize(sensors);
  return machine;
}

TEST(MeshErrorEstimate, IsTheErrorOfTheFirstMesh) {
  for (const double ratio : {1.4, 0.7}) {
    // Both meshes are off by what their edge length makes; the first is the one to judge.
    const double factor = error_of_difference(2, 2, ratio);
    const MeshError found =
        estimate_mesh_error(machine_with(4), {run(4, 0.0)}, {run(4, std::pow(ratio, assumed_rate) - 1.0)}, factor);
    for (Eigen::Index s = 0; s < 4; ++s) EXPECT_NEAR(found.sensors[s], 0.01 * s, 1e-9) << ratio;
    for (Eigen::Index k = 0; k < 6; ++k) EXPECT_NEAR(found.tcp[k], 0.01 * k, 1e-9) << ratio;
  }
}

TEST(MeshErrorEstimate, OfASensorThatHardlyMovesIsTheMedianOfTheOthers) {
  solver::LoadResult first = run(3, 0.0), second = run(3, 1.0);
  first.sensors.values.col(1) = Eigen::VectorXd::LinSpaced(time_count, 20.0, 20.1);
  second.sensors.values.col(1) = Eigen::VectorXd::LinSpaced(time_count, 20.0, 20.05);
  const MeshError found = estimate_mesh_error(machine_with(3), {first}, {second}, 1.0);
  EXPECT_DOUBLE_EQ(found.sensors[0], std::max(found.sensors[1], found.sensors[2]));
}

TEST(MeshErrorEstimate, IsLimited) {
  solver::LoadResult second = run(2, 0.0);
  second.tcp.values *= 3.0;
  const MeshError found = estimate_mesh_error(machine_with(2), {run(2, 0.0)}, {second}, 1.0);
  EXPECT_EQ(found.tcp.maxCoeff(), largest_mesh_error);
}

TEST(MeshErrorEstimate, OfTwoErrorsIsTheRootOfTheirSquares) {
  MeshError of_mesh{Eigen::Vector2d(0.03, 0.15), Eigen::VectorXd::Constant(6, 0.01), "another mesh"}, of_pads = of_mesh;
  of_pads.sensors << 0.04, 0.19;
  of_pads.tcp[2] = 0.0;
  const MeshError both = both_errors(of_mesh, of_pads);
  EXPECT_DOUBLE_EQ(both.sensors[0], 0.05);
  EXPECT_EQ(both.sensors[1], largest_mesh_error);
  EXPECT_DOUBLE_EQ(both.tcp[0], std::sqrt(2.0) * 0.01);
  EXPECT_DOUBLE_EQ(both.tcp[2], 0.01);
  EXPECT_EQ(both.second, "another mesh");
}

TEST(MeshErrorEstimate, NeedsMeshesThatDiffer) {
  EXPECT_EQ(error_of_difference(2, 2, 1.0), 0.0);
  EXPECT_EQ(error_of_difference(2, 2, edge_ratio(1000, 1300)), 0.0);
  EXPECT_NEAR(error_of_difference(2, 2, 2.0), 1.0 / 7.0, 1e-12);  // the second mesh is off by eight times as much
  EXPECT_GT(error_of_difference(2, 2, edge_ratio(1000, 365)), 0.5);
  EXPECT_GT(error_of_difference(2, 2, edge_ratio(1000, 2900)), 1.0);
  EXPECT_EQ(error_of_difference(1, 2, 1.0), 1.0);
  EXPECT_NEAR(edge_ratio(8000, 1000), 2.0, 1e-12);
  for (const int order : {1, 2})
    for (const SecondMesh& second : second_meshes(order)) EXPECT_EQ(second.order, 2);
}

}  // namespace
}  // namespace thermotwin::reduction
