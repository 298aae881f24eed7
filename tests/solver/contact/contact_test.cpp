// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/contact/contact.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mesh/body/shape.h"
#include "solver/contact/grid.h"
#include "tests/machines/slide_machine.h"

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

Eigen::Isometry3d turned(const Eigen::Vector3d& about, const Eigen::Vector3d& axis, double angle) {
  return Eigen::Translation3d(about) * Eigen::AngleAxisd(angle, axis) * Eigen::Translation3d(-about);
}

/// Place of the point on the master's triangle.
Eigen::Vector3d on_master(const mesh::TetMesh& master, const ContactPoint& c) {
  return master.points(Eigen::all, Eigen::Vector3i(master.faces.col(c.master_face))) * c.master_weights;
}

/// Two bodies without a gap of their own; surfaces are groups.
mesh::MachineMesh pair_mesh(const std::string& slave_group, const std::string& master_group, mesh::TetMesh slave,
                            mesh::TetMesh master) {
  mesh::Machine m;
  m.materials = {test::steel()};
  m.bodies = {test::body("slave"), test::body("master")};
  m.surfaces = {test::surface("slave", "slave", {slave_group}), test::surface("master", "master", {master_group})};
  m.joints.resize(1);
  m.joints[0].slave = "slave";
  m.joints[0].master = "master";
  return test::machine_mesh(m, {std::move(slave), std::move(master)});
}

/// A sector of a tube: r, angle and height instead of x, y and z.
mesh::TetMesh tube(const Eigen::Vector3d& low, const Eigen::Vector3d& high, const Eigen::Vector3i& cells) {
  mesh::TetMesh box = test::box_mesh(low, high, cells);
  for (Eigen::Index i = 0; i < box.nodes(); ++i) {
    const Eigen::Vector3d p = box.points.col(i);
    box.points.col(i) << p[0] * std::cos(p[1]), p[0] * std::sin(p[1]), p[2];
  }
  return box;
}

/// Two bodies as one.
mesh::TetMesh both(const mesh::TetMesh& a, const mesh::TetMesh& b) {
  mesh::TetMesh sum;
  sum.points.resize(3, a.nodes() + b.nodes());
  sum.points << a.points, b.points;
  sum.tets.resize(4, a.elements() + b.elements());
  sum.tets << a.tets, (b.tets.array() + static_cast<int>(a.nodes())).matrix();
  mesh::build_boundary(sum, "both");
  for (int f = 0; f < sum.face_count(); ++f)
    if (sum.face_normal(f).z() > 0.9) sum.groups["up"].push_back(f);
  return sum;
}

}  // namespace

TEST(Contact, AWholePadTouchesWithItsWholeArea) {
  const mesh::MachineMesh mesh = test::slide_mesh();
  const mesh::JointSpec& guide = mesh.machine.joints[0];
  for (double x : {-0.2, -0.0371, 0.0, 0.2}) {
    const auto contact = find_contact(mesh, guide, moved(x), home);
    EXPECT_NEAR(total_area(contact), 0.01, 1e-12);
    for (const ContactPoint& c : contact) {
      const Eigen::Vector3d on_slave = moved(x) * c.position;
      EXPECT_NEAR((on_slave - on_master(mesh.bodies[0], c) - Eigen::Vector3d(0, 0, 0.001)).norm(), 0.0, 1e-12);
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
  EXPECT_NEAR(total_area(find_contact(mesh, guide, moved(0.3), home)), 0.005, 1e-12);
  EXPECT_EQ(find_contact(mesh, guide, moved(0.46), home).size(), 0u);
  EXPECT_EQ(find_contact(mesh, guide, moved(0, 0, 0.006), home).size(), 0u);
}

// The gap of 1 mm is one only up to the rounding of the corners.
TEST(Contact, AGapOfJustTheReachTouches) {
  mesh::MachineMesh mesh = test::slide_mesh(3);
  mesh::JointSpec guide = mesh.machine.joints[0];
  const double whole = total_area(find_contact(mesh, guide, home, home));
  guide.reach = 0.101 - 0.1;
  for (const double z : {0.0, 0.1, 0.3, 1.7})  // rounding differs from height to height
    EXPECT_NEAR(total_area(find_contact(mesh, guide, moved(0, 0, z), moved(0, 0, z))), whole, 1e-12) << z;
}

TEST(Contact, ARailNarrowerThanTheSlavesTriangles) {
  mesh::Machine machine = test::slide_machine();
  const mesh::MachineMesh mesh =
      test::machine_mesh(machine, {test::box_mesh({0, 0.05, 0}, {0.6, 0.07, 0.1}, {30, 1, 2}),
                                   test::box_mesh({0.25, 0.01, 0.101}, {0.35, 0.11, 0.16}, {1, 1, 1})});
  EXPECT_NEAR(total_area(find_contact(mesh, machine.joints[0], home, home)), 0.002, 1e-12);
}

TEST(Contact, TheRimIsCutExactlyAtAnyAngle) {
  const mesh::MachineMesh mesh = test::slide_mesh();
  // A square of 0.1 on a bed of 0.12, turned so that two corners hang over its sides.
  const auto contact = find_contact(mesh, mesh.machine.joints[0],
                                    turned({0.3, 0.06, 0}, Eigen::Vector3d::UnitZ(), std::numbers::pi / 4), home);
  EXPECT_NEAR(total_area(contact), 0.01 - 2.0 * std::pow(0.05 * std::sqrt(2.0) - 0.06, 2), 1e-12);
}

TEST(Contact, AnOpenGapEndsWhereTheReachDoes) {
  const mesh::MachineMesh mesh = test::slide_mesh();
  const mesh::JointSpec& guide = mesh.machine.joints[0];
  const double angle = 0.1;  // lifts the pad's far end to 11 mm; the gap is along the pad's normal
  const auto contact = find_contact(mesh, guide, turned({0.25, 0.06, 0.101}, Eigen::Vector3d::UnitY(), -angle), home);
  EXPECT_NEAR(total_area(contact), 0.1 * (guide.reach * std::cos(angle) - 0.001) / std::sin(angle), 1e-12);
}

TEST(Contact, ShapeFunctionsOfBothSidesAreIntegratedExactly) {
  // Of a quadratic polynomial squared on either side, and of the product: nodal values give it back.
  for (const int order : {1, 2}) {
    const mesh::MachineMesh mesh = test::with_order(test::slide_mesh(), order);
    const auto f = [&](const Eigen::Vector3d& p) {
      return order == 1 ? 1.0 + 7.0 * p.x() - 5.0 * p.y() : 1.0 + 30.0 * p.x() * p.x() - 40.0 * p.x() * p.y();
    };
    const auto value = [&](std::size_t body, int face, const Eigen::Vector3d& at) {
      const mesh::FaceNodes nodes = mesh::face_nodes(mesh.bodies[body], face);
      const mesh::FaceValues shape = mesh::face_shape(order, at);
      double sum = 0.0;
      for (Eigen::Index i = 0; i < nodes.size(); ++i) sum += shape[i] * f(mesh.bodies[body].points.col(nodes[i]));
      return sum;
    };
    double product = 0.0, reference = 0.0;
    for (const ContactPoint& c : find_contact(mesh, mesh.machine.joints[0], home, home))
      product += c.area * value(1, c.slave_face, c.slave_weights) * value(0, c.master_face, c.master_weights);
    constexpr int n = 4;  // Gauss points, exact to degree 7
    const double at[n] = {-0.8611363115940526, -0.3399810435848563, 0.3399810435848563, 0.8611363115940526};
    const double weight[n] = {0.3478548451374538, 0.6521451548625461, 0.6521451548625461, 0.3478548451374538};
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        const double once = f({0.3 + 0.05 * at[i], 0.06 + 0.05 * at[j], 0.1});
        reference += 0.25 * 0.01 * weight[i] * weight[j] * once * once;
      }
    }
    EXPECT_NEAR(product, reference, 1e-12 * reference) << order;
  }
}

TEST(Contact, AllOfAShaftTouchesItsBore) {
  // Facets of a shaft and of its bore, at any angle to each other: neither gaps nor double cover.
  const mesh::MachineMesh mesh = pair_mesh("x1", "x0", tube({0.03, 0.2, 0.01}, {0.05, 1.3, 0.04}, {1, 7, 3}),
                                           tube({0.0502, 0.0, 0.0}, {0.07, 1.5, 0.05}, {1, 11, 4}));
  double area = 0.0;
  for (const int face : mesh.surfaces[0]) area += mesh.bodies[0].face_area(face);
  for (const double angle : {0.0, 0.031, -0.05}) {
    const auto contact = find_contact(mesh, mesh.machine.joints[0],
                                      turned(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ(), angle), home);
    EXPECT_NEAR(total_area(contact), area, 1e-12 * area);
    for (const ContactPoint& c : contact) {
      const Eigen::Vector3d from = turned(Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ(), angle) * c.position;
      EXPECT_LT((on_master(mesh.bodies[1], c) - from).norm(), 0.002);
    }
  }
}

TEST(Contact, OfTwoLayersTheNearerCounts) {
  // A thin plate over a part of the base, both within reach of the pad above.
  const mesh::TetMesh base = test::box_mesh({0, 0, 0}, {0.3, 0.2, 0.098}, {7, 4, 1}),
                      plate = test::box_mesh({0.05, 0.02, 0.0985}, {0.17, 0.11, 0.1}, {5, 3, 1});
  const mesh::MachineMesh mesh =
      pair_mesh("z0", "up", test::box_mesh({0.1, 0.01, 0.101}, {0.2, 0.11, 0.15}, {4, 5, 1}), both(base, plate));
  double near = 0.0, far = 0.0;
  for (const ContactPoint& c : find_contact(mesh, mesh.machine.joints[0], home, home)) {
    const double gap = c.position.z() - on_master(mesh.bodies[1], c).z();
    (gap < 0.002 ? near : far) += c.area;
  }
  EXPECT_NEAR(near, 0.07 * 0.09, 1e-12);
  EXPECT_NEAR(far, 0.01 - 0.07 * 0.09, 1e-12);
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
  for (std::size_t i = 0; i < grid.size(); ++i) EXPECT_NEAR(grid[i], std::numbers::pi / 6.0 * i, 1e-12);
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
  for (std::size_t f = 0; f < faces.size(); ++f) area[halves.of_face[f]] += mesh.bodies[1].face_area(faces[f]);
  EXPECT_NEAR(area[0], area[1], 1e-12);
  guide.sectors = 4;
  guide.sector_point = {0.3, 0.06, 0.1};
  EXPECT_EQ(find_pads(mesh, guide).count, 4);
}

}  // namespace thermotwin::solver
