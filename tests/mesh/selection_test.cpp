// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/selection.h"

#include <gtest/gtest.h>

#include <numbers>

#include "samples.h"

using namespace thermotwin;
using Eigen::Vector3d;
using samples::message_of;

namespace {

/// 400 x 200 x 100 mm, 4 cells a side.
mesh::TetMesh block() {
  mesh::TetMesh m = samples::box_mesh({0.4, 0.2, 0.1}, 4);
  mesh::build_boundary(m, "block");
  for (int f = 0; f < m.face_count(); ++f)
    if (m.face_normal(f).x() > 0.99) m.groups["RIGHT"].push_back(f);
  return m;
}

double area(const mesh::TetMesh& m, const mesh::Rule& rule) {
  double sum = 0.0;
  for (const int f : mesh::select_faces(m, rule)) sum += m.face_area(f);
  return sum;
}

TEST(Selection, ConditionsHoldTogether) {
  const mesh::TetMesh m = block();
  mesh::Rule rule;
  rule.plane_point = Vector3d(9, 9, 0.1);
  rule.plane_normal = Vector3d(0, 0, -1);
  EXPECT_NEAR(area(m, rule), 0.08, 1e-12);
  rule.box_min = Vector3d(0, 0, 0);
  rule.box_max = Vector3d(0.2, 0.2, 0.2);
  EXPECT_NEAR(area(m, rule), 0.04, 1e-12);
  mesh::Rule normal;
  normal.normal = Vector3d(0, 0, 1);
  normal.max_angle = 0.1;
  EXPECT_NEAR(area(m, normal), 0.08, 1e-12);
  normal.max_angle = std::numbers::pi;
  EXPECT_EQ(std::ssize(mesh::select_faces(m, normal)), m.face_count());
  mesh::Rule group;
  group.group = "right";  // as the machine file may write it
  EXPECT_NEAR(area(m, group), 0.02, 1e-12);
}

TEST(Selection, APlaneTakesNoFacesAtRightAnglesToIt) {
  mesh::TetMesh strip =
      samples::box_mesh({0.2, 0.01, 0.003}, 4);  // triangles' centres on the sides from 0.25 mm above the plane
  mesh::build_boundary(strip, "strip");
  mesh::Rule rule;
  rule.plane_point = Vector3d(0, 0, 0);
  rule.plane_normal = Vector3d(0, 0, 1);
  EXPECT_NEAR(area(strip, rule), 0.002, 1e-12);
  rule.tolerance = 0.001;  // even where their corners lie within it
  EXPECT_NEAR(area(strip, rule), 0.002, 1e-12);
}

TEST(Selection, APlaneTakesOneSideOfASheet) {
  mesh::TetMesh sheet = samples::box_mesh({0.2, 0.01, 0.0004}, 4);
  mesh::build_boundary(sheet, "sheet");
  mesh::Rule rule;
  rule.plane_normal = Vector3d(0, 0, 1);
  for (const double plane : {0.0, 0.0004}) {
    rule.plane_point = Vector3d(0, 0, plane);
    testing::internal::CaptureStderr();
    EXPECT_NEAR(area(sheet, rule), 0.002, 1e-12) << plane;
    const std::string said = testing::internal::GetCapturedStderr();
    EXPECT_NE(said.find("0.4 mm behind the plane"), std::string::npos) << said;
  }
  // From the middle nothing tells the sides apart, and a face that is there is never lost.
  rule.plane_point = Vector3d(0, 0, 0.0002);
  EXPECT_NEAR(area(sheet, rule), 0.004, 1e-12);
  rule.plane_point = Vector3d(0, 0, -0.0004);
  EXPECT_NEAR(area(sheet, rule), 0.002, 1e-12);
}

TEST(Selection, AnEmptyRuleSaysHowNear) {
  const mesh::TetMesh m = block();
  mesh::Rule rule;
  rule.place = "machine.toml:7 surface[2].rule";
  const auto fails = [&](const std::vector<const char*>& words) {
    const std::string message = message_of([&] { mesh::select_faces(m, rule); });
    EXPECT_NE(message.find(rule.place), std::string::npos) << message;
    for (const char* word : words)
      EXPECT_NE(message.find(word), std::string::npos) << "'" << message << "' lacks " << word;
  };
  rule.plane_point = Vector3d(0, 0, 0.1123);
  rule.plane_normal = Vector3d(0, 0, 1);
  fails({"12.3 mm from the plane", "0.5"});
  rule.plane_point = Vector3d(0, 0, 0.1);
  rule.normal = Vector3d(0, 0, -1);
  fails({"plane: holds for 32 triangles", "normal: holds for 32 triangles", "all conditions together"});
  rule = {};
  rule.place = "m.toml:1";
  rule.box_min = Vector3d(0.45, 0, 0);
  rule.box_max = Vector3d(0.5, 1, 1);
  fails({"50 mm outside the box"});
  rule = {};
  rule.place = "m.toml:1";
  rule.group = "rigth";
  fails({"rigth", "RIGHT"});
  rule = {};
  rule.place = "m.toml:1";
  rule.cylinder_point = Vector3d(0, 0, 0);
  rule.cylinder_axis = Vector3d(0, 0, 1);
  rule.cylinder_radius = 2.0;
  fails({"from the cylinder"});
}

}  // namespace
