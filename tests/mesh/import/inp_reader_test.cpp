// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/inp_reader.h"

#include <gtest/gtest.h>

#include "mesh/import/import.h"
#include "mesh/import/raw_mesh.h"
#include "mesh/surface/surface.h"
#include "tests/mesh/samples.h"
#include "tests/mesh/surfaces.h"

using namespace thermotwin;
using samples::message_of;
using samples::replaced;

namespace {

mesh::ImportOptions options() {
  mesh::ImportOptions o;
  o.body = "bracket";
  o.unit_m = 1.0;
  return o;
}

mesh::TetMesh box() { return samples::box_mesh({0.1, 0.1, 0.1}, 1); }

mesh::TetMesh made(const std::string& text) { return mesh::finish(mesh::parse_inp(text, "box.inp"), options()); }

TEST(Inp, MeshAndSets) {
  // Element 1 of the box: nodes 1 2 4 8 (walk x, y, z); its side S1 = 1-2-3 lies in z = 0.
  const std::string text =
      samples::inp_text(box()) +
      "*NSET, NSET=Bottom, GENERATE\n1, 4, 1\n*nset, nset=BottomToo\n bottom,\n*ELSET, ELSET=First\n1,\n"
      "*SURFACE, TYPE=ELEMENT, NAME=Foot\nFIRST, s1\n*Surface, name=Two\n1, S1\n2, S2\n*STEP\n*STATIC\n1., "
      "1.\n*END STEP\n";
  const mesh::TetMesh m = made(text);
  EXPECT_EQ(m.nodes(), 8);
  EXPECT_EQ(m.elements(), 6);
  EXPECT_NEAR(m.total_volume(), 1e-3, 1e-15);
  EXPECT_EQ(m.groups.at("Bottom").size(), 2u);
  EXPECT_EQ(m.groups.at("BottomToo"), m.groups.at("Bottom"));
  ASSERT_EQ(m.groups.at("Foot").size(), 1u);
  EXPECT_NEAR(m.face_normal(m.groups.at("Foot")[0]).z(), -1.0, 1e-12);
  EXPECT_EQ(m.groups.at("Everything").size(), 12u);
  EXPECT_EQ(m.groups.at("Nall").size(), 12u);
  EXPECT_EQ(m.groups.at("First").size(), 2u);
}

TEST(Inp, SidesInTheManualsNumbering) {
  const std::string text =
      "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT,TYPE=C3D4\n7,1,2,3,4\n"
      "*SURFACE,NAME=A\n7,S1\n*SURFACE,NAME=B\n7,S2\n*SURFACE,NAME=C\n7,S3\n*SURFACE,NAME=D\n7,S4\n*SURFACE,"
      "NAME=ALL\n7,\n";
  const mesh::TetMesh m = made(text);
  const auto normal = [&](const char* name) { return m.face_normal(m.groups.at(name).at(0)); };
  EXPECT_TRUE(normal("A").isApprox(-Eigen::Vector3d::UnitZ(), 1e-12));
  EXPECT_TRUE(normal("B").isApprox(-Eigen::Vector3d::UnitY(), 1e-12));
  EXPECT_TRUE(normal("C").isApprox(Eigen::Vector3d::Ones().normalized(), 1e-12));
  EXPECT_TRUE(normal("D").isApprox(-Eigen::Vector3d::UnitX(), 1e-12));
  EXPECT_EQ(m.groups.at("ALL").size(), 4u);
}

TEST(Inp, QuadraticAcrossLinesAndShellsThatNameFaces) {
  std::string text = "*NODE\n1,0,0,0\n2,1.,0,0\n3,0,1D0,0\n4,0,0,+1\n";
  text += "5,.5,0,0\n6,.5,.5,0\n7,0,.5,0\n8,0,0,.5\n9,.5,0,.5\n10,0,.5,.5\n";
  text += "*ELEMENT,TYPE=C3D10\n1,1,2,3,4,5,6,\n 7,8,9,10\n*ELEMENT,TYPE=CPS3,ELSET=Skin\n2,1,2,3\n";
  const mesh::TetMesh m = made(text);
  EXPECT_EQ(m.nodes(), 10);
  EXPECT_EQ(m.order(), 2);
  EXPECT_EQ(m.groups.at("Skin").size(), 1u);
}

TEST(Inp, MistakesNameTheLine) {
  const std::string good = samples::inp_text(box());
  const auto fails = [](const std::string& text, const std::vector<const char*>& words) {
    const std::string message = message_of([&] { made(text); });
    EXPECT_NE(message.find("box.inp:"), std::string::npos) << message;
    for (const char* word : words)
      EXPECT_NE(message.find(word), std::string::npos) << "'" << message << "' lacks " << word;
  };
  // Lines: 4 heading, 8 nodes (5 .. 12), keyword 13, elements from 14.
  fails(replaced(good, "\n1, 1, 2, 4, 8\n", "\n1, 2, 1, 4, 8\n"), {"box.inp:14", "element 1 is inverted", "bracket"});
  fails(replaced(good, "\n1, 1, 2, 4, 8\n", "\n1, 1, 1, 4, 8\n"), {"node 1 twice"});
  fails(replaced(good, "\n1, 1, 2, 4, 8\n", "\n1, 1, 2, 4, 99\n"), {"box.inp:14", "node 99"});
  fails(replaced(good, "\n1, 1, 2, 4, 8\n", "\n1, 1, 2, 4\n"), {"box.inp:14", "nodes"});
  fails(replaced(good, "\n1, 1, 2, 4, 8\n", "\n1, 1, 2, x, 8\n"), {"box.inp:14", "'x'"});
  fails(replaced(good, "type=c3d4", "type=C3D8"), {"box.inp:13", "C3D8", "C3D10"});
  fails(replaced(good, "\n2, ", "\n1, "), {"box.inp:6", "node 1 again"});
  fails(good + "*NSET, NSET=A\n77\n", {"node 77"});
  fails(good + "*NSET, NSET=A\nNOWHERE\n", {"NOWHERE"});
  fails(good + "*NSET, NSET=A, GENERATE\n1, 2000000000, 1\n", {"2000000000 entries"});
  fails(good + "*SURFACE, NAME=A\n1, S5\n", {"S5", "S4"});
  fails(good + "*SURFACE, NAME=A\n100, S1\n", {"element 100"});
  fails(good + "*INCLUDE, INPUT=more.inp\n", {"*INCLUDE"});
  EXPECT_NE(message_of([&] { made("*NODE\n1,0,0,0\n"); }).find("no tetrahedra"), std::string::npos);
}

}  // namespace
