// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/import.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <numbers>

#include "core/file.h"
#include "mesh/import/raw_mesh.h"
#include "mesh/import/vtk_mesh_io.h"
#include "mesh/selection.h"
#include "mesh/surface/surface.h"
#include "tests/mesh/samples.h"
#include "tests/mesh/surfaces.h"

using namespace thermotwin;
using Eigen::Vector3d;
using samples::box_surface;
using samples::message_of;

namespace {

const std::filesystem::path data = std::filesystem::path(THERMOTWIN_SOURCE_DIR) / "tests/mesh/data";

mesh::ImportOptions options(double size_m, double unit_m = 0.001) {
  mesh::ImportOptions o;
  o.body = "part";
  o.unit_m = unit_m;
  o.element_size_m = size_m;
  return o;
}

void expect_good(const mesh::TetMesh& mesh, double volume, double tolerance) {
  EXPECT_NEAR(mesh.total_volume(), volume, tolerance * volume);
  const mesh::Quality q = mesh::quality(mesh);
  EXPECT_GT(q.minimum, 0.1);
  EXPECT_GT(q.mean, 0.6);
}

double group_area(const mesh::TetMesh& mesh, const std::string& name) {
  double sum = 0.0;
  const auto group = mesh.groups.find(name);
  if (group != mesh.groups.end())
    for (const int f : group->second) sum += mesh.face_area(f);
  return sum;
}

TEST(Import, SizesOutOfRangeAreNamed) {
  EXPECT_NO_THROW(options(0.03).validate());
  mesh::ImportOptions bad = options(-0.03);
  EXPECT_NE(message_of([&] { bad.validate(); }).find("'part': element size (element_size_m): -0.03;"),
            std::string::npos);
  bad = options(0.03, 0.0);
  EXPECT_NE(message_of([&] { mesh::read_tet_mesh("any.msh", bad); }).find("(unit_m): 0;"), std::string::npos);
  bad = options(0.03);
  bad.elements_per_turn = 0;
  EXPECT_NE(message_of([&] { bad.validate(); }).find("elements_per_turn"), std::string::npos);
}

TEST(Import, StepInItsOwnUnit) {
  const mesh::TetMesh block = mesh::import_body(data / "block_with_bore.step", options(0.03));
  const double bore = std::numbers::pi * 0.02 * 0.02 * 0.05;
  expect_good(block, 0.2 * 0.1 * 0.05 - bore, 0.02);
  EXPECT_NEAR(block.points.row(0).maxCoeff(), 0.2, 1e-9);
  EXPECT_LT(mesh::quality(block).longest_edge, 0.06);
  // The same file gives the same bits.
  const mesh::TetMesh again = mesh::import_body(data / "block_with_bore.step", options(0.03));
  EXPECT_TRUE(again.points == block.points);
  EXPECT_TRUE(again.tets == block.tets);
  // Smaller elements, more of them.
  EXPECT_GT(mesh::import_body(data / "block_with_bore.step", options(0.01)).elements(), 4 * block.elements());
  mesh::Rule rule;
  rule.cylinder_point = Vector3d(0.06, 0.05, 0.0);
  rule.cylinder_axis = Vector3d(0, 0, 1);
  rule.cylinder_radius = 0.02;
  double area = 0.0;
  for (const int f : mesh::select_faces(block, rule)) {
    area += block.face_area(f);
    EXPECT_LT(std::abs(block.face_normal(f).z()), 0.3);
  }
  EXPECT_NEAR(area, 2 * std::numbers::pi * 0.02 * 0.05, 0.06 * 2 * std::numbers::pi * 0.02 * 0.05);
}

TEST(Import, SolidsThatTouchAreOneBody) {
  const mesh::TetMesh both = mesh::import_body(data / "two_boxes.brep", options(0.03));
  expect_good(both, 0.1 * 0.1 * 0.05 + 0.05 * 0.05 * 0.05, 1e-9);
  double area = 0.0;  // the wall between is no boundary: the meshes share its nodes
  for (Eigen::Index f = 0; f < both.face_count(); ++f) area += both.face_area(f);
  EXPECT_NEAR(area, 0.04 + 0.015 - 2 * 0.0025, 1e-9);
  // BREP has no unit of its own.
  EXPECT_NEAR(mesh::import_body(data / "two_boxes.brep", options(0.5, 0.0254)).points.row(0).maxCoeff(), 150 * 0.0254,
              1e-6);
}

TEST(Import, CadMistakes) {
  const samples::Folder folder;
  EXPECT_NE(message_of([&] {
              mesh::import_body(folder.write("bad.step", "ISO-10303-21;\nnonsense"), options(0.03));
            }).find("part"),
            std::string::npos);
  EXPECT_NE(message_of([&] { mesh::import_body(folder.path() / "none.step", options(0.03)); }).find("no such file"),
            std::string::npos);
  EXPECT_NE(message_of([&] { mesh::import_body(folder.write("x.sat", ""), options(0.03)); }).find(".step"),
            std::string::npos);
  EXPECT_NE(message_of([&] { mesh::import_body(data / "two_boxes.brep", options(0.5, 1.0)); }).find("unit"),
            std::string::npos);
  EXPECT_NE(message_of([&] { mesh::import_body(data / "two_boxes.brep", options(0.0)); }).find("element size"),
            std::string::npos);
}

TEST(Import, StlPartsBecomeGroups) {
  const samples::Folder folder;
  const auto path = folder.write("box.stl", samples::stl_text(box_surface({0, 0, 0}, {100, 60, 40})));
  const mesh::TetMesh box = mesh::import_body(path, options(0.02));
  expect_good(box, 0.1 * 0.06 * 0.04, 1e-6);
  EXPECT_EQ(box.groups.size(), 6u);
  EXPECT_NEAR(group_area(box, "x_low"), 0.06 * 0.04, 1e-9);
  EXPECT_NEAR(group_area(box, "z_high"), 0.1 * 0.06, 1e-9);
  for (const int f : box.groups.at("y_high")) EXPECT_NEAR(box.face_normal(f).y(), 1.0, 1e-9);
}

TEST(Import, SurfaceFormatsAgree) {
  const samples::Folder folder;
  const mesh::Surface box = box_surface({0, 0, 0}, {3, 2, 1});
  for (const auto& [name, text] : {std::pair<std::string, std::string>{"a.obj", samples::obj_text(box)},
                                   {"a.ply", samples::ply_text(box)},
                                   {"a.STL", samples::stl_text(box)}}) {
    SCOPED_TRACE(name);
    const mesh::TetMesh made = mesh::import_body(folder.write(name, text), options(0.03, 0.0254));
    expect_good(made, 6 * std::pow(0.0254, 3), 1e-6);
  }
}

/// Corners and triangles as glTF stores them, and the JSON that describes them.
std::string gltf_bytes(const mesh::Surface& box) {
  std::string bytes;
  for (Eigen::Index i = 0; i < 8; ++i) {
    for (int k = 0; k < 3; ++k) {
      const float value = static_cast<float>(box.points(k, i));
      bytes.append(reinterpret_cast<const char*>(&value), 4);
    }
  }
  for (Eigen::Index t = 0; t < 12; ++t) {
    for (int k = 0; k < 3; ++k) {
      const std::uint16_t index = box.triangles(k, t);
      bytes.append(reinterpret_cast<const char*>(&index), 2);
    }
  }
  return bytes;
}

std::string gltf_text(const std::string& uri) {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
    "nodes":[{"mesh":0,"name":"housing","scale":[2,2,2],"translation":[5,0,0]}],
    "meshes":[{"name":"housing","primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
    "buffers":[{)" +
         uri + R"("byteLength":168}],
    "bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":96},{"buffer":0,"byteOffset":96,"byteLength":72}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":8,"type":"VEC3","min":[0,0,0],"max":[1,1,1]},
                 {"bufferView":1,"componentType":5123,"count":36,"type":"SCALAR"}]})";
}

void append_u32(std::string& text, std::size_t value) {
  const std::uint32_t number = value;
  text.append(reinterpret_cast<const char*>(&number), 4);
}

TEST(Import, GltfAndGlbApplyTheNodesTransformation) {
  // One triangulated cube of 1 x 1 x 1, doubled by its node and moved by 5.
  const samples::Folder folder;
  const std::string bytes = gltf_bytes(box_surface({0, 0, 0}, {1, 1, 1}));
  folder.write("box.bin", bytes);
  const auto gltf = folder.write("box.gltf", gltf_text(R"("uri":"box.bin",)"));
  std::string json = gltf_text(""), glb = "glTF";
  json.resize((json.size() + 3) / 4 * 4, ' ');
  append_u32(glb, 2);
  append_u32(glb, 12 + 8 + json.size() + 8 + bytes.size());
  append_u32(glb, json.size());
  glb += "JSON" + json;
  append_u32(glb, bytes.size());
  glb += std::string("BIN\0", 4) + bytes;
  for (const auto& path : {gltf, folder.write("box.glb", glb)}) {
    SCOPED_TRACE(path);
    const mesh::TetMesh made = mesh::import_body(path, options(0.5, 1.0));
    expect_good(made, 8.0, 1e-6);
    EXPECT_NEAR(made.points.row(0).minCoeff(), 5.0, 1e-6);
    EXPECT_EQ(std::ssize(made.groups.at("housing")), made.face_count());
  }
}

TEST(Import, ThreeMfAppliesTheBuildTransformation) {
  // 100 x 60 x 40, turned by 90 deg about z and moved by (10, 20, 30).
  const mesh::TetMesh made = mesh::import_body(data / "block.3mf", options(0.02));
  expect_good(made, 0.1 * 0.06 * 0.04, 1e-6);
  EXPECT_NEAR(made.points.row(0).minCoeff(), -0.05, 1e-6);
  EXPECT_NEAR(made.points.row(1).maxCoeff(), 0.12, 1e-6);
  EXPECT_NEAR(made.points.row(2).minCoeff(), 0.03, 1e-6);
}

TEST(Import, ACavityStaysHollow) {
  const samples::Folder folder;
  mesh::Surface inner = box_surface({30, 30, 30}, {70, 70, 70});
  samples::turn_over(inner);
  const auto path =
      folder.write("hollow.stl", samples::stl_text(samples::together(box_surface({0, 0, 0}, {100, 100, 100}), inner)));
  expect_good(mesh::import_body(path, options(0.025)), 1e-3 - 0.064e-3, 1e-6);
}

TEST(Import, TwoSolidsInOneSurfaceFile) {
  const samples::Folder folder;
  const auto path =
      folder.write("two.stl", samples::stl_text(samples::together(box_surface({0, 0, 0}, {50, 50, 50}),
                                                                  box_surface({80, 0, 0}, {120, 40, 40}))));
  expect_good(mesh::import_body(path, options(0.02)), 125e-6 + 64e-6, 1e-6);
}

TEST(Import, BrokenSurfaceFiles) {
  const samples::Folder folder;
  mesh::Surface open = box_surface({0, 0, 0}, {100, 100, 100});
  open.triangles.conservativeResize(3, 11);
  EXPECT_NE(message_of([&] {
              mesh::import_body(folder.write("open.stl", samples::stl_text(open)), options(0.03));
            }).find("holes"),
            std::string::npos);
  const std::string metre = samples::stl_text(box_surface({0, 0, 0}, {0.2, 0.1, 0.3}));
  EXPECT_NE(message_of([&] { mesh::import_body(folder.write("m.stl", metre), options(0.03)); }).find("unit"),
            std::string::npos);
  EXPECT_NE(message_of([&] { mesh::import_body(folder.write("junk.obj", "hello"), options(0.03)); }).find("junk.obj"),
            std::string::npos);
  EXPECT_NE(message_of([&] { mesh::import_body(folder.path() / "absent.stl", options(0.03)); }).find("absent.stl"),
            std::string::npos);
}

TEST(Import, LibrariesKeepTheirOwnEigen) {
  // See cmake/eigen_stays_inside.map.
  if (std::system("command -v nm > /dev/null 2>&1") != 0) GTEST_SKIP() << "nm is not installed";
  const std::string self = std::filesystem::read_symlink("/proc/self/exe").string();
  EXPECT_NE(std::system(("nm -D --defined-only '" + self + "' | grep -q 5Eigen").c_str()), 0);
}

TEST(Import, VtuRoundTripKeepsGroups) {
  const samples::Folder folder;
  mesh::TetMesh box = samples::box_mesh({0.2, 0.1, 0.1}, 2);
  mesh::build_boundary(box, "box");
  box.groups["left side"] = {0, 3, 5};
  box.groups["both"] = {3, 7};
  mesh::write_vtu(folder.path() / "box.vtu", box);
  const mesh::TetMesh back = mesh::import_body(folder.path() / "box.vtu", options(0.1, 1.0));
  EXPECT_TRUE(back.points == box.points);
  EXPECT_TRUE(back.tets == box.tets);
  EXPECT_EQ(back.groups, box.groups);
  // Half a file is no file.
  const std::string text = core::read_file(folder.path() / "box.vtu");
  EXPECT_NE(message_of([&] {
              mesh::import_body(folder.write("half.vtu", text.substr(0, text.size() / 2)), options(0.1, 1.0));
            }).find("half.vtu"),
            std::string::npos);
  EXPECT_NE(message_of([&] { mesh::import_body(folder.write("not.vtu", "hello"), options(0.1, 1.0)); }).find("not.vtu"),
            std::string::npos);
}

const char* tiny_msh2 = R"($MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
2
2 7 "feet"
3 9 "all"
$EndPhysicalNames
$Nodes
4
1 0 0 0
2 100 0 0
3 0 100 0
4 0 0 100
$EndNodes
$Elements
2
1 2 2 7 1 1 2 3
2 4 2 9 1 1 2 3 4
$EndElements
)";

TEST(Import, MshWithPhysicalGroups) {
  const samples::Folder folder;
  const mesh::TetMesh made = mesh::import_body(folder.write("tiny.msh", tiny_msh2), options(0.1));
  EXPECT_EQ(made.elements(), 1);
  EXPECT_NEAR(made.total_volume(), 1e-3 / 6, 1e-12);
  ASSERT_EQ(made.groups.count("feet"), 1u);
  ASSERT_EQ(made.groups.at("feet").size(), 1u);
  EXPECT_NEAR(made.face_normal(made.groups.at("feet")[0]).z(), -1.0, 1e-12);
  EXPECT_EQ(made.groups.at("all").size(), 4u);
  const std::string inverted = samples::replaced(tiny_msh2, "2 4 2 9 1 1 2 3 4", "2 4 2 9 1 2 1 3 4");
  EXPECT_NE(message_of([&] {
              mesh::import_body(folder.write("inv.msh", inverted), options(0.1));
            }).find("element 2 is inverted"),
            std::string::npos);
  // A script must not be run under a mesh's name.
  EXPECT_NE(message_of([&] {
              mesh::import_body(folder.write("s.msh", "SystemCall \"true\";"), options(0.1));
            }).find("$MeshFormat"),
            std::string::npos);
}

}  // namespace
