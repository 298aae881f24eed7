// SPDX-License-Identifier: GPL-3.0-or-later
// Quadratic tetrahedra: promotion, shape functions, quadrature, files that have edge nodes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mesh/body/shape.h"
#include "mesh/import/import.h"
#include "mesh/import/vtk_mesh_io.h"
#include "mesh/machine/file.h"
#include "mesh/machine_mesh.h"
#include "tests/mesh/samples.h"

using namespace thermotwin;
using samples::message_of;
using samples::replaced;

namespace {

mesh::TetMesh box(int n) {
  mesh::TetMesh made = samples::box_mesh({0.3, 0.2, 0.1}, n);
  mesh::build_boundary(made, "box");
  return made;
}

mesh::ImportOptions options() {
  mesh::ImportOptions o;
  o.body = "bracket";
  o.unit_m = 1.0;
  return o;
}

void expect_edge_nodes_in_the_middle(const mesh::TetMesh& m) {
  ASSERT_EQ(m.order(), 2);
  ASSERT_EQ(m.tet_edges.cols(), m.elements());
  ASSERT_EQ(m.face_edges.cols(), m.face_count());
  for (Eigen::Index e = 0; e < m.elements(); ++e) {
    for (int i = 0; i < 6; ++i) {
      const Eigen::Vector3d middle =
          0.5 * (m.points.col(m.tets(mesh::tet_edge[i][0], e)) + m.points.col(m.tets(mesh::tet_edge[i][1], e)));
      EXPECT_LT((m.points.col(m.tet_edges(i, e)) - middle).norm(), 1e-15);
    }
  }
  for (Eigen::Index f = 0; f < m.face_count(); ++f) {
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d middle =
          0.5 * (m.points.col(m.faces(mesh::face_edge[i][0], f)) + m.points.col(m.faces(mesh::face_edge[i][1], f)));
      EXPECT_LT((m.points.col(m.face_edges(i, f)) - middle).norm(), 1e-15);
    }
  }
}

TEST(Quadratic, PromotionPutsOneNodeOnEachEdge) {
  const int n = 3;
  const mesh::TetMesh linear = box(n);
  mesh::TetMesh made = linear;
  mesh::set_order(made, 2);
  // Edges of Kuhn's box: along the axes, across the cells' sides, through the cells.
  EXPECT_EQ(made.nodes() - linear.nodes(), 3 * n * (n + 1) * (n + 1) + 3 * n * n * (n + 1) + n * n * n);
  EXPECT_TRUE(made.points.leftCols(linear.nodes()) == linear.points);
  EXPECT_TRUE(made.tets == linear.tets);
  EXPECT_TRUE(made.faces == linear.faces);
  expect_edge_nodes_in_the_middle(made);
  EXPECT_NO_THROW(mesh::build_boundary(made, "box"));
  expect_edge_nodes_in_the_middle(made);
  mesh::set_order(made, 1);
  EXPECT_TRUE(made.points == linear.points);
  EXPECT_TRUE(made.tets == linear.tets);
  EXPECT_TRUE(made.faces == linear.faces);
  EXPECT_EQ(made.order(), 1);
}

TEST(Shape, ValuesAndSlopes) {
  mesh::TetMesh made = box(1);
  for (int order : {1, 2}) {
    mesh::set_order(made, order);
    const mesh::TetNodes nodes = mesh::tet_nodes(made, 4);
    for (Eigen::Index i = 0; i < nodes.size(); ++i) {
      const Eigen::Vector4d at = mesh::barycentric(made, 4, made.points.col(nodes[i]));
      EXPECT_LT((mesh::tet_shape(order, at) - Eigen::VectorXd::Unit(nodes.size(), i)).norm(), 1e-14);
    }
    const Eigen::Vector4d at(0.1, 0.2, 0.3, 0.4);
    EXPECT_NEAR(mesh::tet_shape(order, at).sum(), 1.0, 1e-15);
    for (int k = 0; k < 4; ++k) {
      const Eigen::Vector4d step = 1e-3 * Eigen::Vector4d::Unit(k);  // exact: N is quadratic
      const mesh::TetValues slope = (mesh::tet_shape(order, at + step) - mesh::tet_shape(order, at - step)) / 2e-3;
      EXPECT_LT((slope - mesh::tet_slopes(order, at).col(k)).norm(), 1e-12);
    }
    const mesh::FaceNodes corners = mesh::face_nodes(made, 5);
    for (Eigen::Index i = 0; i < corners.size(); ++i) {
      const Eigen::Vector3d on_face = mesh::face_barycentric(made, 5, made.points.col(corners[i]));
      EXPECT_LT((mesh::face_shape(order, on_face) - Eigen::VectorXd::Unit(corners.size(), i)).norm(), 1e-14);
    }
  }
}

TEST(Shape, RulesAreExactAndPositive) {
  const auto factorial = [](int n) { return std::tgamma(n + 1.0); };
  for (int degree : {1, 2, 5}) {
    for (const mesh::TetPoint& p : mesh::tet_rule(degree)) EXPECT_GT(p.share, 0.0);
    for (const mesh::FacePoint& p : mesh::face_rule(degree)) EXPECT_GT(p.share, 0.0);
    for (int a = 0; a <= degree; ++a) {
      for (int b = 0; a + b <= degree; ++b) {
        double face = 0.0;
        for (const mesh::FacePoint& p : mesh::face_rule(degree))
          face += p.share * std::pow(p.at[0], a) * std::pow(p.at[1], b);
        EXPECT_NEAR(face, 2.0 * factorial(a) * factorial(b) / factorial(a + b + 2), 1e-15) << degree << a << b;
        for (int c = 0; a + b + c <= degree; ++c) {
          double tet = 0.0;
          for (const mesh::TetPoint& p : mesh::tet_rule(degree))
            tet += p.share * std::pow(p.at[0], a) * std::pow(p.at[1], b) * std::pow(p.at[3], c);
          EXPECT_NEAR(tet, 6.0 * factorial(a) * factorial(b) * factorial(c) / factorial(a + b + c + 3), 1e-15)
              << degree << a << b << c;
        }
      }
    }
  }
}

constexpr const char* ten_nodes =  // corners, then the middles of 12 23 31 14 24 34 as Abaqus has them
    "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,.5,0,0\n6,.5,.5,0\n7,0,.5,0\n8,0,0,.5\n9,.5,0,.5\n10,0,.5,.5\n"
    "*ELEMENT,TYPE=C3D10\n7,1,2,3,4,5,6,7,8,\n9,10\n*SURFACE,NAME=FOOT\n7,S1\n";

TEST(Quadratic, InpKeepsItsNodes) {
  const samples::Folder folder;
  const auto read = [&](const std::string& text) {
    return mesh::read_tet_mesh(folder.write("ten.inp", text), options());
  };
  const mesh::TetMesh m = read(ten_nodes);
  EXPECT_EQ(m.nodes(), 10);
  expect_edge_nodes_in_the_middle(m);
  EXPECT_EQ(m.groups.at("FOOT").size(), 1u);
  // Two edge nodes in another order: not beside the middle of their edges.
  const std::string swapped = message_of([&] { read(replaced(ten_nodes, "5,6,7,8,\n9,10", "5,6,7,8,\n10,9")); });
  EXPECT_NE(swapped.find("element 7"), std::string::npos) << swapped;
  EXPECT_NE(swapped.find("node 10"), std::string::npos) << swapped;
  // An edge that bows out a little is made straight.
  testing::internal::CaptureStderr();
  expect_edge_nodes_in_the_middle(read(replaced(ten_nodes, "6,.5,.5,0", "6,.55,.55,0")));
  EXPECT_NE(testing::internal::GetCapturedStderr().find("70.7 mm"), std::string::npos);
  EXPECT_NE(message_of([&] { read(replaced(ten_nodes, "6,.5,.5,0", "6,.8,.8,0")); }).find("node 6"), std::string::npos);
}

TEST(Quadratic, NeighboursShareTheirEdgeNodes) {
  const samples::Folder folder;
  const std::string crack = std::string(replaced(ten_nodes, "*SURFACE,NAME=FOOT\n7,S1\n", "")) +
                            "*NODE\n11,0,0,-1\n12,.5,0,0\n13,0,0,-.5\n14,.5,0,-.5\n15,0,.5,-.5\n"
                            "*ELEMENT,TYPE=C3D10\n8,2,1,3,11,12,7,6,14,13,15\n";
  const std::string message = message_of([&] { mesh::read_tet_mesh(folder.write("crack.inp", crack), options()); });
  EXPECT_NE(message.find("element 8"), std::string::npos) << message;
  EXPECT_NE(message.find("neighbour"), std::string::npos) << message;
  const mesh::TetMesh whole = mesh::read_tet_mesh(
      folder.write("whole.inp", replaced(replaced(crack, "8,2,1,3,11,12,7,6", "8,2,1,3,11,5,7,6"), "12,.5,0,0\n", "")),
      options());
  EXPECT_EQ(whole.nodes(), 14);
  expect_edge_nodes_in_the_middle(whole);
}

constexpr const char* ten_msh = R"($MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
10
1 0 0 0
2 1 0 0
3 0 1 0
4 0 0 1
5 .5 0 0
6 .5 .5 0
7 0 .5 0
8 0 0 .5
9 0 .5 .5
10 .5 0 .5
$EndNodes
$Elements
1
1 11 2 9 1 1 2 3 4 5 6 7 8 9 10
$EndElements
)";

TEST(Quadratic, MshHasItsOwnOrder) {
  const samples::Folder folder;
  const mesh::TetMesh m = mesh::read_tet_mesh(folder.write("ten.msh", ten_msh), options());
  EXPECT_EQ(m.nodes(), 10);
  expect_edge_nodes_in_the_middle(m);
}

TEST(Quadratic, VtuRoundTrip) {
  const samples::Folder folder;
  mesh::TetMesh made = box(2);
  made.groups["left"] = {0, 3, 5};
  mesh::set_order(made, 2);
  mesh::write_vtu(folder.path() / "box.vtu", made);
  const mesh::TetMesh back = mesh::read_tet_mesh(folder.path() / "box.vtu", options());
  EXPECT_TRUE(back.points == made.points);
  EXPECT_TRUE(back.tets == made.tets);
  EXPECT_TRUE(back.tet_edges == made.tet_edges);
  EXPECT_TRUE(back.face_edges == made.face_edges);
  EXPECT_EQ(back.groups, made.groups);
}

std::string one_body(const std::string& mesh_lines, const std::string& cad) {
  return "schema = 1\nname = \"one\"\n" + mesh_lines + R"(
[[material]]
id = "iron"
density_kg_m3 = 7200
specific_heat_J_kgK = 500
conductivity_W_mK = 46
expansion_1_K = 11e-6
young_GPa = 120
poisson = 0.26
[[body]]
id = "block"
material = "iron"
cad = ")" +
         cad + R"("
unit = "m"
element_size_mm = 50
[[surface]]
id = "all"
body = "block"
[tcp]
tool_body = "block"
tool_surface = "all"
tool_point_mm = [0, 0, 150]
table_body = "block"
table_surface = "all"
table_point_mm = [0, 0, 0]
)";
}

TEST(Quadratic, TheMachineChoosesTheOrder) {
  const samples::Folder folder;
  mesh::TetMesh quadratic = box(2);
  mesh::write_vtu(folder.path() / "linear.vtu", quadratic);
  mesh::set_order(quadratic, 2);
  mesh::write_vtu(folder.path() / "quadratic.vtu", quadratic);
  const auto built = [&](const std::string& mesh_lines, const std::string& cad) {
    const mesh::MeshOptions with_cache{1.0, folder.path() / "cache"};
    mesh::build_machine_mesh(mesh::parse_machine(one_body(mesh_lines, cad), folder.path() / "machine.toml"),
                             with_cache);
    return mesh::build_machine_mesh(mesh::parse_machine(one_body(mesh_lines, cad), folder.path() / "machine.toml"),
                                    with_cache);
  };
  EXPECT_EQ(built("", "linear.vtu").nodes(), 27);
  const mesh::MachineMesh promoted = built("[mesh]\norder = 2\n", "linear.vtu");
  EXPECT_EQ(promoted.nodes(), quadratic.nodes());
  expect_edge_nodes_in_the_middle(promoted.bodies[0]);
  EXPECT_TRUE(built("[mesh]\norder = 2\n", "quadratic.vtu").bodies[0].tet_edges == quadratic.tet_edges);
  testing::internal::CaptureStderr();
  EXPECT_EQ(built("[mesh]\norder = 1\n", "quadratic.vtu").nodes(), 27);
  EXPECT_NE(testing::internal::GetCapturedStderr().find("order = 2"), std::string::npos);
  EXPECT_NE(message_of([&] { built("[mesh]\norder = 3\n", "linear.vtu"); }).find("order"), std::string::npos);
}

TEST(Machine, ConductivityMayBeATensor) {
  const auto material = [](const std::string& line) {
    return mesh::parse_machine(
        replaced(one_body("[mesh]\ncapacity = \"lumped\"\n", "block.vtu"), "conductivity_W_mK = 46", line),
        "machine.toml");
  };
  EXPECT_TRUE(material("conductivity_W_mK = 46").lumped_capacity);
  EXPECT_FALSE(material("conductivity_W_mK = 46").materials[0].conductivity_tensor.has_value());
  const Eigen::Matrix3d full =
      *material("conductivity_tensor_W_mK = [3, 2, 1, 0.1, 0.2, 0.3]").materials[0].conductivity_tensor;
  EXPECT_TRUE(full.isApprox((Eigen::Matrix3d() << 3, 0.1, 0.3, 0.1, 2, 0.2, 0.3, 0.2, 1).finished()));
  EXPECT_TRUE(material("conductivity_tensor_W_mK = [3, 2, 1]").materials[0].conductivity_tensor->isDiagonal());
  for (const char* bad :
       {"conductivity_tensor_W_mK = [3, 2]", "conductivity_tensor_W_mK = [3, 2, -1]",
        "conductivity_tensor_W_mK = [1, 1, 1, 2, 0, 0]", "conductivity_tensor_W_mK = [1, 1, 1]\nconductivity_W_mK = 1"})
    EXPECT_NE(message_of([&] { material(bad); }).find("machine.toml:"), std::string::npos) << bad;
}

}  // namespace
