// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/contact.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/solver/small_machine.h"

namespace thermotwin::solver {

namespace {

double total_area(const std::vector<ContactPoint>& contact) {
  double area = 0.0;
  for (const ContactPoint& c : contact) area += c.area;
  return area;
}

Eigen::Isometry3d moved(double x, double y = 0, double z = 0) {
  Eigen::Isometry3d t = Eigen::Isometry3d::Identity();
  t.translation() = Eigen::Vector3d(x, y, z);
  return t;
}

const Eigen::Isometry3d home = Eigen::Isometry3d::Identity();

}  // namespace

TEST(Contact, AWholePadTouchesWithItsWholeArea) {
  const mesh::MachineMesh mesh = test::slide_mesh();
  const mesh::JointSpec& guide = mesh.machine.joints[0];
  for (double x : {-0.2, -0.0371, 0.0, 0.2}) {
    const auto contact = find_contact(mesh, guide, moved(x), home);
    EXPECT_NEAR(total_area(contact), 0.01, 1e-12);
    for (const ContactPoint& c : contact) {
      const Eigen::Vector3i master_nodes = mesh.bodies[0].faces.col(c.master_face);
      const Eigen::Vector3d on_master = mesh.bodies[0].points(Eigen::all, master_nodes) * c.master_weights;
      const Eigen::Vector3d on_slave = moved(x) * c.position;
      EXPECT_NEAR((on_slave - on_master - Eigen::Vector3d(0, 0, 0.001)).norm(), 0.0, 1e-12);
      EXPECT_NEAR(c.slave_weights.sum(), 1.0, 1e-12);
      EXPECT_NEAR(c.master_weights.sum(), 1.0, 1e-12);
      EXPECT_GE(c.master_weights.minCoeff(), 0.0);
      EXPECT_NEAR(c.normal.z(), -1.0, 1e-12);
    }
  }
}

TEST(Contact, NothingTouchesBeyondTheRim) {
  const mesh::MachineMesh mesh = test::slide_mesh();
  const mesh::JointSpec& guide = mesh.machine.joints[0];
  // Half of the pad hangs over the end of the bed.
  EXPECT_NEAR(total_area(find_contact(mesh, guide, moved(0.3), home)), 0.005, 0.0005);
  EXPECT_EQ(find_contact(mesh, guide, moved(0.46), home).size(), 0u);
  EXPECT_EQ(find_contact(mesh, guide, moved(0, 0, 0.006), home).size(), 0u);
}

TEST(Contact, ARailNarrowerThanTheSlavesTriangles) {
  mesh::Machine machine = test::slide_machine();
  const mesh::MachineMesh mesh =
      test::machine_mesh(machine, {test::box_mesh({0, 0.05, 0}, {0.6, 0.07, 0.1}, {30, 1, 2}),
                                   test::box_mesh({0.25, 0.01, 0.101}, {0.35, 0.11, 0.16}, {1, 1, 1})});
  EXPECT_NEAR(total_area(find_contact(mesh, machine.joints[0], home, home)), 0.002, 0.0003);
}

TEST(Contact, SidesThatFaceAlikeDoNotTouch) {
  mesh::Machine machine = test::slide_machine();
  machine.joints[0].master = "bed.feet";  // its normal points down, as the pad's does
  machine.joints[0].reach = 0.2;
  const mesh::MachineMesh mesh = test::slide_mesh(1, machine);
  EXPECT_TRUE(find_contact(mesh, machine.joints[0], home, home).empty());
}

TEST(Contact, TheGroundTouchesEverywhere) {
  const mesh::MachineMesh mesh = test::slide_mesh();
  const auto contact = find_contact(mesh, mesh.machine.joints[1], home, home);
  EXPECT_NEAR(total_area(contact), 0.6 * 0.12, 1e-12);
  for (const ContactPoint& c : contact) EXPECT_EQ(c.master_face, -1);
}

TEST(Contact, GridOfALinearAxisIsHalfAPadFine) {
  mesh::Machine machine = test::slide_machine();
  machine.workspace.positions = {{-0.13, 0.0, 0.2}};
  const mesh::MachineMesh mesh = test::slide_mesh(1, machine);
  const std::vector<double> grid = contact_grid(mesh, machine.joints[0]);
  EXPECT_DOUBLE_EQ(grid.front(), -0.2);
  EXPECT_DOUBLE_EQ(grid.back(), 0.2);
  for (std::size_t i = 1; i < grid.size(); ++i) {
    EXPECT_GT(grid[i], grid[i - 1]);
    EXPECT_LE(grid[i] - grid[i - 1], 0.05 + 1e-12);
  }
  for (double x : {-0.13, 0.0})
    EXPECT_TRUE(std::any_of(grid.begin(), grid.end(), [&](double g) { return std::abs(g - x) < 1e-12; })) << x;
  EXPECT_EQ(contact_grid(mesh, machine.joints[1]), std::vector<double>{0.0});
}

TEST(Contact, GridOfAnEndlessAxisClosesItself) {
  mesh::Machine machine = test::slide_machine();
  machine.axes[0].kind = mesh::AxisKind::rotary;
  machine.axes[0].endless = true;
  machine.workspace = {};
  const std::vector<double> grid = contact_grid(test::slide_mesh(1, machine), machine.joints[0]);
  ASSERT_EQ(grid.size(), 12u);
  for (std::size_t i = 0; i < grid.size(); ++i)
    EXPECT_NEAR(grid[i], std::numbers::pi / 6.0 * static_cast<double>(i), 1e-12);
}

TEST(Contact, PadsAreDividedByCellsAndSectors) {
  mesh::Machine machine = test::slide_machine();
  mesh::JointSpec& guide = machine.joints[0];
  const mesh::MachineMesh mesh = test::slide_mesh(1, machine);
  EXPECT_EQ(find_pads(mesh, guide).count, 1);
  guide.divide = {2, 1, 1};
  const Pads halves = find_pads(mesh, guide);
  ASSERT_EQ(halves.count, 2);
  double area[2] = {0, 0};
  const std::vector<int>& faces = mesh.surfaces[3];
  for (std::size_t f = 0; f < faces.size(); ++f)
    area[halves.of_face[f]] += mesh.bodies[1].face_area(faces[f]);
  EXPECT_NEAR(area[0], area[1], 1e-12);
  guide.sectors = 4;
  guide.sector_point = {0.3, 0.06, 0.1};
  EXPECT_EQ(find_pads(mesh, guide).count, 4);
}

}  // namespace thermotwin::solver
