// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/body/tet_mesh.h"

#include <gtest/gtest.h>

#include "tests/mesh/samples.h"

using namespace thermotwin;
using samples::message_of;

namespace {

TEST(TetMesh, BoundaryOfABox) {
  mesh::TetMesh box = samples::box_mesh({0.3, 0.2, 0.1}, 3);
  mesh::build_boundary(box, "box");
  EXPECT_EQ(box.face_count(), 6 * 9 * 2);
  EXPECT_NEAR(box.total_volume(), 0.006, 1e-15);
  double area = 0.0, flux = 0.0;
  for (Eigen::Index f = 0; f < box.face_count(); ++f) {
    area += box.face_area(f);
    flux += box.face_area(f) * box.face_normal(f).dot(box.face_centre(f));
    // The element behind a face lies on the side that the normal points away from.
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (int i = 0; i < 4; ++i) centre += box.points.col(box.tets(i, box.face_tet[f])) / 4.0;
    EXPECT_LT(box.face_normal(f).dot(centre - box.face_centre(f)), 0.0);
  }
  EXPECT_NEAR(area, 2 * (0.06 + 0.03 + 0.02), 1e-14);
  EXPECT_NEAR(flux, 3 * 0.006, 1e-14);  // divergence theorem: all outward
}

TEST(TetMesh, FindsFacesInAnyOrder) {
  mesh::TetMesh box = samples::box_mesh({1, 1, 1}, 2);
  mesh::build_boundary(box, "box");
  Eigen::Matrix3Xi asked(3, 3);
  asked.col(0) = box.faces.col(5).reverse();
  asked.col(1) << box.faces(1, 7), box.faces(2, 7), box.faces(0, 7);
  asked.col(2) << 0, 13, 26;  // the diagonal: no triangle
  EXPECT_EQ(mesh::find_faces(box, asked), (std::vector<int>{5, 7, -1}));
}

TEST(TetMesh, RefusesWhatIsNoMesh) {
  const auto check = [](mesh::TetMesh bad) { return message_of([&] { mesh::build_boundary(bad, "bracket"); }); };
  const mesh::TetMesh good = samples::box_mesh({1, 1, 1}, 1);
  EXPECT_EQ(check(good), "");
  const auto expect = [](const std::string& message, const char* word) {
    EXPECT_NE(message.find("bracket"), std::string::npos) << message;
    EXPECT_NE(message.find(word), std::string::npos) << message;
  };
  mesh::TetMesh bad = good;
  std::swap(bad.tets(0, 3), bad.tets(1, 3));
  expect(check(bad), "element 3");
  expect(check(bad), "inverted");
  bad = good;
  bad.tets(0, 2) = bad.tets(1, 2);
  expect(check(bad), "twice");
  bad = good;
  bad.points.conservativeResize(3, 9);
  bad.points.col(8) << 5, 5, 5;
  expect(check(bad), "node 8");
  bad = good;
  bad.tets(0, 0) = 8;
  expect(check(bad), "node 8");
  bad = good;
  bad.tets.conservativeResize(4, 7);
  bad.tets.col(6) = bad.tets.col(5);
  expect(check(bad), "overlap");
  bad.tets.conservativeResize(4, 8);
  bad.tets.col(7) = bad.tets.col(5);
  expect(check(bad), "belongs to 3 elements");
  bad = good;
  bad.points(2, 7) = std::nan("");
  expect(check(bad), "not a number");
  bad = {};
  expect(check(bad), "without elements");
  // Flat: one corner moved into the plane of the other three.
  mesh::TetMesh flat;
  flat.points.resize(3, 4);
  flat.points << 0, 1, 0, 0.3, 0, 0, 1, 0.3, 0, 0, 0, 0;
  flat.tets.resize(4, 1);
  flat.tets << 0, 1, 2, 3;
  expect(check(flat), "flat");
}

TEST(TetMesh, Quality) {
  mesh::TetMesh one;
  one.points.resize(3, 4);
  one.points << 1, 1, -1, -1, 1, -1, 1, -1, 1, -1, -1, 1;
  one.tets.resize(4, 1);
  one.tets << 0, 1, 2, 3;
  if (one.volume(0) < 0) std::swap(one.tets(0, 0), one.tets(1, 0));
  mesh::Quality q = mesh::quality(one);
  EXPECT_NEAR(q.minimum, 1.0, 1e-14);
  EXPECT_NEAR(q.shortest_edge, std::sqrt(8.0), 1e-14);
  EXPECT_NEAR(q.longest_edge, std::sqrt(8.0), 1e-14);
  EXPECT_EQ(q.below_0_1_percent, 0.0);
  // Corner tetrahedron of a cube: 12 (3/6)^(2/3) / 9.
  one.points << 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1;
  one.tets << 0, 1, 2, 3;
  EXPECT_NEAR(mesh::quality(one).mean, 12.0 * std::pow(0.5, 2.0 / 3.0) / 9.0, 1e-14);
  one.points(2, 3) = 1e-3;
  EXPECT_EQ(mesh::quality(one).below_0_1_percent, 100.0);
}

}  // namespace
