// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/elastic/tcp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mesh/machine/kinematics.h"
#include "tests/machines/box_mesh.h"

namespace thermotwin::solver {
namespace {

using Eigen::Vector3d;
constexpr double degree = std::numbers::pi / 180.0;
constexpr double um = 1e-6;

mesh::Axis rotary(const std::string& id, const Vector3d& direction, const Vector3d& origin) {
  mesh::Axis axis;
  axis.id = id;
  axis.kind = mesh::AxisKind::rotary;
  axis.direction = direction;
  axis.origin = origin;
  axis.low = -3.2;
  axis.high = 3.2;
  return axis;
}

/// Tool on X and Z; table on C on a swivel B, whose axis lies 0.05 m below the table's top.
mesh::Machine five_axes() {
  mesh::Machine machine;
  machine.bodies = {test::body("bed"), test::body("slide", "steel", "bed", "X"),
                    test::body("head", "steel", "slide", "Z"), test::body("swivel", "steel", "bed", "B"),
                    test::body("table", "steel", "swivel", "C")};
  machine.axes = {test::linear_axis("X", Vector3d::UnitX(), -1, 1), test::linear_axis("Z", Vector3d::UnitZ(), -1, 1),
                  rotary("B", Vector3d::UnitY(), {0, 0, -0.05}), rotary("C", Vector3d::UnitZ(), {0, 0, 0})};
  machine.tcp.tool_body = "head";
  machine.tcp.tool_point = {0, 0, 0.1};
  machine.tcp.table_body = "table";
  machine.tcp.table_point = {0, 0, 0};
  machine.tcp.table_radius = 0.3;
  return machine;
}

mesh::Pose pose_of(double x, double z, double b, double c) {
  mesh::Pose pose(4);
  pose << x, z, b, c;
  return pose;
}

const Vector6 none6 = Vector6::Zero();
const Vector7 none7 = Vector7::Zero();

TEST(Tcp, PositionFollowsTheToolsAxes) {
  EXPECT_TRUE(tcp_position(five_axes(), pose_of(0.2, 0.3, 1.0, 2.0)).isApprox(Vector3d(0.2, 0, 0.4)));
}

TEST(Tcp, ErrorIsToolMinusTable) {
  Vector6 tool = none6, axis = none6;
  tool << 3 * um, 0, 1 * um, 0, 0, 4 * um;
  axis << 1 * um, 2 * um, 0, 0, 0, 1 * um;
  const TcpError error = tcp_error(five_axes(), pose_of(0, -0.1, 0, 0), tool, axis, none7);
  EXPECT_NEAR(error.error[0], 2 * um, 1e-15);
  EXPECT_NEAR(error.error[1], -2 * um, 1e-15);
  EXPECT_NEAR(error.error[2], 1 * um, 1e-15);
  EXPECT_NEAR(error.error[5], 3 * um, 1e-15);
}

TEST(Tcp, TablesOwnPartTurnsWithCThenB) {
  const mesh::Pose pose = pose_of(0, -0.1, 45 * degree, 90 * degree);
  Vector7 own = none7;
  own[0] = 1 * um;  // x of the table: C = 90 deg makes it y, which B leaves alone
  Vector6 table = tcp_error(five_axes(), pose, none6, none6, own).table;
  EXPECT_TRUE(table.head<3>().isApprox(Vector3d(0, 1 * um, 0), 1e-9));
  own = none7;
  own[1] = 1 * um;  // y of the table: -x of the swivel, tilted by B
  table = tcp_error(five_axes(), pose, none6, none6, own).table;
  EXPECT_TRUE(table.head<3>().isApprox(Vector3d(-std::sqrt(0.5), 0, std::sqrt(0.5)) * um, 1e-9));
}

TEST(Tcp, AxisPartTurnsWithBOnly) {
  Vector6 axis = none6;
  axis[0] = 1 * um;
  const Vector6 table = tcp_error(five_axes(), pose_of(0, -0.1, 45 * degree, 90 * degree), none6, axis, none7).table;
  EXPECT_TRUE(table.head<3>().isApprox(Vector3d(std::sqrt(0.5), 0, -std::sqrt(0.5)) * um, 1e-9));
}

TEST(Tcp, RotationsHaveTheLeverOfTheTool) {
  // Tool at (0.2, 0, 0.3) above the table's centre; the swivel's axis tilts about x, y, z.
  const mesh::Pose pose = pose_of(0.2, 0.2, 0, 90 * degree);
  for (int i = 0; i < 3; ++i) {
    Vector6 axis = none6;
    axis[3 + i] = 10 * um;
    const Vector6 table = tcp_error(five_axes(), pose, none6, axis, none7).table;
    const Vector3d expected = 10 * um * Vector3d::Unit(i).cross(Vector3d(0.2, 0, 0.3));
    EXPECT_LT((table.head<3>() - expected).norm(), 1e-14);
    EXPECT_NEAR(table[3 + i], 10 * um, 1e-15);
  }
  // The table's own tilt about its x, at C = 90 deg about the machine's y.
  Vector7 own = none7;
  own[3] = 10 * um;
  const Vector6 table = tcp_error(five_axes(), pose, none6, none6, own).table;
  EXPECT_LT((table.head<3>() - 10 * um * Vector3d::UnitY().cross(Vector3d(0.2, 0, 0.3))).norm(), 1e-14);
  EXPECT_LT((table.tail<3>() - 10 * um * Vector3d::UnitY()).norm(), 1e-14);
}

TEST(Tcp, GrowthPointsAwayFromTheTablesAxis) {
  Vector7 own = none7;
  own[6] = 3 * um;  // at 0.3 m
  // B = 0: the tool touches at radius 0.2 m, whatever C.
  Vector6 table = tcp_error(five_axes(), pose_of(0.2, -0.1, 0, 70 * degree), none6, none6, own).table;
  EXPECT_LT((table.head<3>() - Vector3d(2 * um, 0, 0)).norm(), 1e-14);
  // B = 90 deg: the table's plane stands upright. A tool 0.05 m in front of the B axis and 0.15 m
  // above it is 0.15 m from the table's axis, upward.
  table = tcp_error(five_axes(), pose_of(0.05, 0.0, 90 * degree, 0), none6, none6, own).table;
  EXPECT_LT((table.head<3>() - Vector3d(0, 0, 1.5 * um)).norm(), 1e-14);
}

TEST(Tcp, ColumnsFitTheValues) {
  TcpError error;
  error.tool << 1, 2, 3, 4, 5, 6;
  error.table << 10, 20, 30, 40, 50, 60;
  error.error = error.tool - error.table;
  const auto columns = tcp_columns();
  const Eigen::VectorXd values = tcp_values(error);
  ASSERT_EQ(columns.size(), 18U);
  ASSERT_EQ(values.size(), 18);
  EXPECT_EQ(columns[0], "dx_um");
  EXPECT_EQ(columns[5], "rc_um_per_m");
  EXPECT_EQ(columns[8], "dz_um_tool");
  EXPECT_EQ(columns[15], "ra_um_per_m_table");
  EXPECT_DOUBLE_EQ(values[0], -9e6);
  EXPECT_DOUBLE_EQ(values[8], 3e6);
  EXPECT_DOUBLE_EQ(values[15], 40e6);
}

}  // namespace
}  // namespace thermotwin::solver
