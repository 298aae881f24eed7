// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/machine_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/file.h"
#include "mesh/import/import.h"
#include "mesh/import/vtk_mesh_io.h"
#include "mesh/machine/file.h"
#include "mesh/machine/kinematics.h"
#include "samples.h"

using namespace thermotwin;
using Eigen::Vector3d;

namespace {

constexpr double degree = std::numbers::pi / 180.0;

mesh::Machine small() { return mesh::parse_machine(samples::machine_text(), "/there/machine.toml"); }

TEST(Kinematics, ChainOfParents) {
  const mesh::Machine m = small();
  mesh::Pose pose = mesh::home_pose(m);
  ASSERT_EQ(pose.size(), 3);
  EXPECT_TRUE(mesh::body_transform(m, m.body_index("table"), pose).isApprox(Eigen::Isometry3d::Identity(), 1e-15));
  pose << 0.1, 45 * degree, 90 * degree;
  // By hand: C turns (0.01 + 0.3, 0, 0.1) about (0.01, 0) to (0.01, 0.3, 0.1); B about y through
  // z = 0.1 turns (0.01, 0) in x, z - 0.1 to (0.01 cos 45, -0.01 sin 45); X adds 0.1.
  const double half = std::sqrt(0.5);
  const Vector3d moved = mesh::body_transform(m, m.body_index("table"), pose) * Vector3d(0.31, 0.0, 0.1);
  EXPECT_NEAR(moved.x(), 0.1 + 0.01 * half, 1e-15);
  EXPECT_NEAR(moved.y(), 0.3, 1e-15);
  EXPECT_NEAR(moved.z(), 0.1 - 0.01 * half, 1e-15);
  // A point straight above the swivel axis goes towards +x for a positive turn about +y.
  const Vector3d above = mesh::body_transform(m, m.body_index("swivel"), pose) * Vector3d(0.0, 0.2, 1.1);
  EXPECT_TRUE(above.isApprox(Vector3d(0.1 + half, 0.2, 0.1 + half), 1e-14)) << above.transpose();
  EXPECT_TRUE(mesh::body_transform(m, m.body_index("bed"), pose).isApprox(Eigen::Isometry3d::Identity(), 0.0));
}

TEST(Kinematics, Poses) {
  mesh::Machine m = small();
  EXPECT_EQ(mesh::workspace_poses(m).size(), 3u);
  EXPECT_DOUBLE_EQ(mesh::workspace_poses(m)[2][0], 0.4);
  m.axes[0].low = 0.1;  // home lies out of travel then
  EXPECT_DOUBLE_EQ(mesh::home_pose(m)[0], 0.1);
  // Two linear axes: the product, the first axis slowest; B becomes a linear axis here.
  const std::string linear =
      samples::replaced(samples::machine_text(),
                        "kind = \"rotary\"\ndirection = [0, 1, 0]\norigin_mm = [0, 0, 100]\ntravel_deg = "
                        "[-30, 110]\nrapid_deg_min = 18000",
                        "kind = \"linear\"\ndirection = [0, 1, 0]\ntravel_mm = [0, 100]");
  m = mesh::parse_machine(samples::replaced(linear, "B_deg = [0, 45, 90]", "B_mm = [10, 20]"), "m.toml");
  const std::vector<mesh::Pose> grid = mesh::workspace_poses(m);
  ASSERT_EQ(grid.size(), 6u);
  EXPECT_TRUE(grid[1].isApprox(Eigen::Vector3d(-0.4, 0.02, 0.0)));
  EXPECT_TRUE(grid[2].isApprox(Eigen::Vector3d(0.0, 0.01, 0.0)));
}

TEST(Kinematics, PoseText) {
  const mesh::Machine m = small();
  const mesh::Pose pose = mesh::parse_pose(m, "X=-250, B=+45,C=-90", "here");
  EXPECT_DOUBLE_EQ(pose[0], -0.25);
  EXPECT_DOUBLE_EQ(pose[1], 45 * degree);
  EXPECT_DOUBLE_EQ(pose[2], 270 * degree);
  EXPECT_EQ(mesh::format_pose(m, pose), "X=-250,B=45,C=270");
  EXPECT_TRUE(mesh::parse_pose(m, mesh::format_pose(m, pose), "here").isApprox(pose, 1e-12));
  EXPECT_TRUE(mesh::parse_pose(m, "", "here").isZero());
  EXPECT_EQ(mesh::pose_columns(m), (std::vector<std::string>{"X_mm", "B_deg", "C_deg"}));
  EXPECT_NEAR(mesh::pose_values(m, pose)[2], 270.0, 1e-12);
  for (const char* bad : {"X", "Q=1", "X=abc", "X=1,X=2", "X=500", "B=111", "X=1,,B=2", "X=nan", "X=1 B=2"}) {
    const std::string message = samples::message_of([&] { mesh::parse_pose(m, bad, "--pose"); });
    EXPECT_NE(message.find("--pose"), std::string::npos) << bad << ": " << message;
  }
}

TEST(MeshSize, WordsAndNumbers) {
  const mesh::Machine m = small();
  EXPECT_DOUBLE_EQ(mesh::size_factor(m, "coarse"), 1.2);
  EXPECT_DOUBLE_EQ(mesh::size_factor(m, "fine"), 0.32);
  EXPECT_DOUBLE_EQ(mesh::size_factor(m, "0.7"), 0.7);
  for (const char* bad : {"big", "", "0", "-1", "nan", "1.0x"})
    EXPECT_THROW(mesh::size_factor(m, bad), core::InputError) << bad;
}

TEST(MeshSize, FactorOutOfRangeIsNamed) {
  EXPECT_NO_THROW(mesh::MeshOptions{}.validate());
  for (const double bad : {0.0, -1.0, std::nan("")}) {
    mesh::MeshOptions options;
    options.size_factor = bad;
    EXPECT_THROW(options.validate(), core::InputError) << bad;
  }
}

std::string two_blocks() {
  return R"(
schema = 1
name = "blocks"
[[material]]
id = "iron"
density_kg_m3 = 7200
specific_heat_J_kgK = 500
conductivity_W_mK = 46
expansion_1_K = 11e-6
young_GPa = 120
poisson = 0.26
[[body]]
id = "low"
material = "iron"
cad = "low.vtu"
unit = "m"
element_size_mm = 50
[[body]]
id = "high"
material = "iron"
cad = "high.vtu"
unit = "m"
element_size_mm = 50
parent = "low"
[[surface]]
id = "low.all"
body = "low"
[[surface]]
id = "low.top"
body = "low"
rule = { plane_point_mm = [0, 0, 100], plane_normal = [0, 0, -1] }
[[surface]]
id = "low.rest"
body = "low"
except = ["low.top"]
[[surface]]
id = "high.bottom"
body = "high"
rule = { normal = [0, 0, -1], max_angle_deg = 1 }
[[joint]]
id = "bolts"
kind = "bolted"
slave = "high.bottom"
master = "low.top"
conductance_W_m2K = 3000
[tcp]
tool_body = "high"
tool_surface = "high.bottom"
tool_point_mm = [0, 0, 150]
table_body = "low"
table_surface = "low.top"
table_point_mm = [0, 0, 0]
)";
}

void write_blocks(const samples::Folder& folder) {
  mesh::TetMesh low = samples::box_mesh({0.4, 0.2, 0.1}, 3), high = samples::box_mesh({0.1, 0.1, 0.3}, 2);
  high.points.row(2).array() += 0.1;  // stands on low
  mesh::write_vtu(folder.path() / "low.vtu", low);
  mesh::write_vtu(folder.path() / "high.vtu", high);
}

TEST(MachineMesh, ResolvesSurfaces) {
  const samples::Folder folder;
  write_blocks(folder);
  const mesh::Machine m = mesh::read_machine(folder.write("machine.toml", two_blocks()));
  const mesh::MachineMesh built = mesh::build_machine_mesh(m, {});
  ASSERT_EQ(built.bodies.size(), 2u);
  EXPECT_EQ(built.first_node, (std::vector<Eigen::Index>{0, 64, 64 + 27}));
  EXPECT_EQ(built.nodes(), 91);
  EXPECT_NEAR(built.surface_area(0), 2 * (0.08 + 0.04 + 0.02), 1e-12);
  EXPECT_NEAR(built.surface_area(1), 0.08, 1e-12);
  EXPECT_NEAR(built.surface_area(2), 0.20, 1e-12);
  EXPECT_NEAR(built.surface_area(3), 0.01, 1e-12);
  EXPECT_EQ(&built.body_of_surface(3), &built.bodies[1]);
  EXPECT_EQ(mesh::workspace_poses(m).size(), 1u);  // no [workspace]: home alone
}

TEST(MachineMesh, ARuleThatPicksNothingSaysWhatIsNear) {
  const samples::Folder folder;
  write_blocks(folder);
  const auto error = [&](const std::string& text) {
    const mesh::Machine m = mesh::parse_machine(text, folder.path() / "machine.toml");
    return samples::message_of([&] { mesh::build_machine_mesh(m, {}); });
  };
  const std::string message = error(samples::replaced(two_blocks(), "[0, 0, 100], plane", "[0, 0, 112.3], plane"));
  EXPECT_NE(message.find("12.3 mm from the plane"), std::string::npos) << message;
  EXPECT_NE(message.find("machine.toml:"), std::string::npos) << message;
  const std::string nothing_left =
      error(samples::replaced(two_blocks(), "except = [\"low.top\"]", "except = [\"low.all\"]"));
  EXPECT_NE(nothing_left.find("low.rest"), std::string::npos) << nothing_left;
}

TEST(MachineMesh, CacheKeepsAndDamageIsNoticed) {
  const samples::Folder folder;
  write_blocks(folder);
  const mesh::Machine m = mesh::read_machine(folder.write("machine.toml", two_blocks()));
  const mesh::MeshOptions options{1.0, folder.path() / "cache"};
  const mesh::MachineMesh first = mesh::build_machine_mesh(m, options);
  std::vector<std::filesystem::path> kept;
  for (const auto& entry : std::filesystem::directory_iterator(options.cache)) kept.push_back(entry.path());
  ASSERT_EQ(kept.size(), 2u);
  const auto same = [&](const mesh::MachineMesh& other) {
    for (std::size_t b = 0; b < 2; ++b) {
      EXPECT_TRUE(other.bodies[b].points == first.bodies[b].points);
      EXPECT_TRUE(other.bodies[b].tets == first.bodies[b].tets);
      EXPECT_TRUE(other.bodies[b].faces == first.bodies[b].faces);
      EXPECT_TRUE(other.bodies[b].face_tet == first.bodies[b].face_tet);
      EXPECT_EQ(other.bodies[b].groups, first.bodies[b].groups);
    }
    EXPECT_EQ(other.surfaces, first.surfaces);
  };
  same(mesh::build_machine_mesh(m, options));
  for (const auto& path : kept) {  // one flipped byte in the first file, half of the second
    std::string text = core::read_file(path);
    if (path == kept[0])
      text[text.size() / 2] = static_cast<char>(text[text.size() / 2] ^ 1);
    else
      text.resize(text.size() / 2);
    std::ofstream(path, std::ios::binary) << text;
  }
  same(mesh::build_machine_mesh(m, options));
  // Another file content is another mesh.
  mesh::TetMesh finer = samples::box_mesh({0.1, 0.1, 0.3}, 3);
  finer.points.row(2).array() += 0.1;
  mesh::write_vtu(folder.path() / "high.vtu", finer);
  EXPECT_EQ(mesh::build_machine_mesh(m, options).bodies[1].nodes(), 64);
}

}  // namespace
