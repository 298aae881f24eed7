// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/export/machine_scene.h"

#include <gtest/gtest.h>

#include "core/table.h"
#include "solver/export/scene_file.h"
#include "tests/core/temporary_folder.h"
#include "tests/machines/box_machine.h"
#include "tests/mesh/samples.h"

namespace thermotwin::solver {
namespace {

using Eigen::Index;

TEST(Skin, KeepsNodesOfTheBoundaryAndTheShapeOfBodies) {
  const mesh::MachineMesh mesh = test::box_machine_mesh({.finer = 3});
  for (const Index most : {500, 3000}) {
    const Skin skin = make_skin(mesh, most);
    EXPECT_LE(skin.vertices(), most);
    ASSERT_EQ(skin.first.size(), mesh.bodies.size() + 1);
    EXPECT_EQ(skin.first.back(), skin.vertices());
    EXPECT_LT(skin.triangles.maxCoeff(), skin.vertices());
    EXPECT_GE(skin.triangles.minCoeff(), 0);
    for (std::size_t b = 0; b < mesh.bodies.size(); ++b) {
      const Eigen::Matrix3Xd& all = mesh.bodies[b].points;
      const auto own = skin.points.middleCols(skin.first[b], skin.first[b + 1] - skin.first[b]);
      ASSERT_GT(own.cols(), 7) << b;
      EXPECT_EQ(own.rowwise().maxCoeff(), all.rowwise().maxCoeff());
      EXPECT_EQ(own.rowwise().minCoeff(), all.rowwise().minCoeff());
      for (Index v = skin.first[b]; v < skin.first[b + 1]; ++v)
        EXPECT_EQ(skin.points.col(v), all.col(skin.nodes[v] - mesh.first_node[b]));
    }
  }
}

/// Volume that the skin of the only body encloses, m^3.
double volume_in(const Skin& skin) {
  double six = 0.0;
  for (Index t = 0; t < skin.triangles.cols(); ++t) {
    const auto corner = [&](int c) -> Eigen::Vector3d { return skin.points.col(skin.triangles(c, t)); };
    six += corner(0).cross(corner(1)).dot(corner(2));
  }
  return six / 6.0;
}

// Teeth whose edges lie side by side, with few vertices beside their corners.
TEST(Skin, EdgesAndCornersStay) {
  mesh::MachineMesh mesh;
  mesh.bodies.push_back(samples::box_mesh({1.0, 1.0, 1.0}, 15));
  mesh::TetMesh& comb = mesh.bodies.front();
  Index kept = 0;
  for (Index e = 0; e < comb.tets.cols(); ++e) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const int node : comb.tets.col(e)) centre += 0.25 * comb.points.col(node);
    const bool slot = centre.z() > 0.2 && static_cast<int>(15.0 * centre.x()) % 2 == 1;
    if (!slot) comb.tets.col(kept++) = comb.tets.col(e);
  }
  comb.tets.conservativeResize(4, kept);
  mesh::build_boundary(comb, "comb");
  mesh.first_node = {0, comb.nodes()};
  const Skin skin = make_skin(mesh, 400);
  EXPECT_LE(skin.vertices(), 400);
  EXPECT_GT(skin.vertices(), 390);
  EXPECT_NEAR(volume_in(skin), comb.total_volume(), 1e-9 * comb.total_volume());
}

TEST(KeyPoses, AreCornersWhoseWeightsAreLinearInEachAxis) {
  const mesh::Machine machine = test::box_machine();
  std::vector<mesh::Pose> grid;
  for (const double x : {-0.2, 0.0, 0.1})
    for (const double z : {-0.1, 0.1}) grid.push_back(test::box_pose(x, z, 0.0));
  const KeyPoses keys = key_poses(machine, grid);
  ASSERT_EQ(keys.poses.size(), 4U);
  for (std::size_t p = 0; p < grid.size(); ++p) {
    EXPECT_NEAR(keys.weights.row(p).sum(), 1.0, 1e-12);
    mesh::Pose mean = mesh::Pose::Zero(grid[p].size());
    for (std::size_t k = 0; k < keys.poses.size(); ++k) mean += keys.weights(p, k) * keys.poses[k];
    EXPECT_LT((mean - grid[p]).norm(), 1e-12);
  }
}

core::Table table_of(Index times, Index poses) {
  core::Table tcp{"test", {"time_s", "dx_um", "dy_um", "dz_um"}, Eigen::MatrixXd::Zero(times * poses, 4)};
  for (Index t = 0; t < times; ++t) {
    for (Index p = 0; p < poses; ++p) tcp.values.row(t * poses + p) << 600.0 * t, 1.0 * t, 2.0 * t + p, -3.0 * t;
  }
  return tcp;
}

TEST(SceneLoad, HasErrorsOfAllPosesAtThinnedTimes) {
  const SceneLoad load = scene_load("a", table_of(500, 3), 3, {});
  ASSERT_EQ(load.hours.size(), LoadFields::most_times);
  EXPECT_NEAR(load.hours.tail(1)[0], 499.0 / 6.0, 1e-9);
  EXPECT_EQ(load.errors_um.rows(), 9);
  EXPECT_EQ(load.errors_um(3 * 2 + 1, load.hours.size() - 1), 2.0 * 499.0 + 2.0);
}

TEST(MachineScene, NamesStayAsTheyAreWritten) {
  const mesh::MachineMesh mesh = test::box_machine_mesh();
  MachineScene scene;
  scene.machine = mesh.machine;
  scene.poses = {test::box_pose(0.0, 0.0, 0.0)};
  scene.keys = key_poses(scene.machine, scene.poses);
  scene.loads = {scene_load("mill & drill </script>", table_of(3, 1), 1, {})};
  const std::string page = machine_scene_html(scene);
  EXPECT_NE(page.find(R"("name":"mill & drill \u003c/script\u003e")"), std::string::npos);
}

TEST(SceneFile, ComesBackForTheSameModelOnly) {
  const mesh::MachineMesh mesh = test::box_machine_mesh();
  MachineScene scene;
  scene.machine = mesh.machine;
  scene.machine.hash = "abc";
  scene.skin = make_skin(mesh, 300);
  scene.temperature = Eigen::MatrixXd::Random(scene.skin.vertices(), 3);
  scene.displacement.assign(2, Eigen::MatrixXd::Random(3 * scene.skin.vertices(), 3));
  scene.turn = Eigen::MatrixXd::Random(8, 3);
  const core::TemporaryFolder folder;
  const auto file = folder.path() / "scene.bin";
  EXPECT_FALSE(read_scene(file, scene.machine, "model").has_value());
  write_scene(file, scene, "model");
  EXPECT_FALSE(read_scene(file, scene.machine, "another").has_value());
  const auto back = read_scene(file, scene.machine, "model");
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->skin.triangles, scene.skin.triangles);
  EXPECT_EQ(back->skin.first, scene.skin.first);
  EXPECT_LT((back->temperature - scene.temperature).norm(), 1e-5);
  EXPECT_LT((back->displacement[1] - scene.displacement[1]).norm(), 1e-4);
  EXPECT_LT((back->turn - scene.turn).norm(), 1e-5);
}

}  // namespace
}  // namespace thermotwin::solver
