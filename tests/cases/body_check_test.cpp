// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies in pieces, bodies in one place, poor elements, and what `mesh` says of joints.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/cases/own_case.h"

namespace thermotwin::cases {
namespace {

constexpr Block low{{0, 0, 0}, {100, 100, 50}}, high{{0, 0, 50.2}, {100, 60, 100}};

TEST(BodyCheck, UnconnectedPiecesAreAnErrorUnlessStated) {
  const OwnCase own(body_text("block", 60));
  own.blocks("block", {low, high});
  const Result two = own.run({"mesh", own.path()});
  EXPECT_EQ(two.status, 3);
  for (const char* words : {"machine.toml", "body 'block' falls into 2 pieces", "(298.8 cm3", "around [50, 30, 75.1] mm", "0.2 mm from the others", "pieces = 2"})
    EXPECT_SAYS(two.err, words);
  const OwnCase stated(body_text("block", 60, "pieces = 2"));
  stated.blocks("block", {low, high});
  const Result meant = stated.run({"mesh", stated.path(), "--json", "--quiet"});
  ASSERT_EQ(meant.status, 0) << meant.err;
  EXPECT_EQ(nlohmann::json::parse(meant.out)["bodies"][0]["pieces"], 2);
  stated.blocks("block", {low});
  const Result one = stated.run({"mesh", stated.path()});
  EXPECT_EQ(one.status, 3);
  EXPECT_SAYS(one.err, "body 'block' has 1 unconnected piece; allowed: pieces = 2 as machine.toml states, or pieces = 1");
}

TEST(BodyCheck, APartThatNothingTakesHeatFromIsWarnedOf) {
  const std::string film = R"(
[[surface]]
id = "floor"
body = "block"
rule = {normal = [0, 0, -1], box_min_mm = [-1, -1, -1], box_max_mm = [101, 101, 1]}
[[ambient]]
id = "air"
default_C = 20
[[film]]
id = "floor"
surfaces = ["floor"]
film_coefficient_W_m2K = 20
)";
  const OwnCase own(body_text("block", 60, "pieces = 2\nelastic = false") + film);
  own.blocks("block", {low, high});
  const Result two = own.run({"simulate", own.path(), "--load", "hour"});
  ASSERT_EQ(two.status, 0) << two.err;
  EXPECT_SAYS(two.err, "nothing takes heat from a part of 'block'");
  EXPECT_SAYS(two.err, "75.1] mm");
  const OwnCase one(body_text("block", 60, "elastic = false") + film);
  one.blocks("block", {low});
  const Result whole = one.run({"simulate", one.path(), "--load", "hour"});
  ASSERT_EQ(whole.status, 0) << whole.err;
  EXPECT_EQ(whole.err.find("nothing takes heat"), std::string::npos) << whole.err;
}

TEST(BodyCheck, TwoBodiesInOnePlaceAreAnError) {
  const OwnCase own(body_text("bed", 60) + body_text("ram", 60));
  own.blocks("bed", {low});
  own.blocks("ram", {{{20, 20, 40}, {80, 80, 90}}});  // 10 mm deep in the bed
  const Result result = own.run({"mesh", own.path()});
  EXPECT_EQ(result.status, 3);
  for (const char* words : {"bodies 'bed' and 'ram'", "fill the same place around [", "% of the smaller one", "bed.stl"}) EXPECT_SAYS(result.err, words);
  own.blocks("ram", {high});
  EXPECT_EQ(own.run({"mesh", own.path()}).status, 0);
}

const std::string stacked = body_text("bed", 60) + body_text("ram", 60) + R"(
[[surface]]
id = "bed.top"
body = "bed"
rule = {normal = [0, 0, 1]}
[[surface]]
id = "ram.bottom"
body = "ram"
rule = {normal = [0, 0, -1]}
[[joint]]
id = "seat"
kind = "bolted"
slave = "ram.bottom"
master = "bed.top"
conductance_W_m2K = 1000
)";

TEST(BodyCheck, JointsAreListedWithAreaAndGap) {
  const OwnCase own(stacked);
  own.blocks("bed", {low});
  own.blocks("ram", {high});
  const Result text = own.run({"mesh", own.path()});
  ASSERT_EQ(text.status, 0) << text.err;
  EXPECT_SAYS(text.out, "contact cm2");
  const auto joint = nlohmann::json::parse(own.run({"mesh", own.path(), "--json", "--quiet"}).out)["joints"][0];
  EXPECT_NEAR(joint["contact_area_m2"].get<double>(), 60e-4, 1e-9);
  EXPECT_NEAR(joint["share_of_slave_percent"].get<double>(), 100.0, 1e-6);
  EXPECT_NEAR(joint["gap_mean_m"].get<double>(), 0.2e-3, 1e-9);
  own.blocks("ram", {{{0, 0, 80}, {100, 60, 130}}});  // 30 mm away, beyond reach
  const Result apart = own.run({"mesh", own.path()});
  EXPECT_SAYS(apart.err, "joint 'seat': 'ram.bottom' and 'bed.top' do not touch");
  EXPECT_SAYS(apart.err, "reach_mm = 5");
}

TEST(BodyCheck, PoorElementsAreWarnedOf) {
  std::string machine = body_text("plate", 60);
  machine.replace(machine.find(".stl"), 4, ".inp");
  const OwnCase own(machine);
  // One tetrahedron of 100 mm and one on its base that is 0.02 mm high.
  own.write("cad/plate.inp", "*NODE\n1, 0, 0, 0\n2, 100, 0, 0\n3, 0, 100, 0\n4, 0, 0, 100\n5, 30, 30, -0.02\n*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n2, 1, 3, 2, 5\n");
  const Result result = own.run({"mesh", own.path()});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_SAYS(result.err, "body 'plate': the worst element has a quality of 0.0");
  EXPECT_SAYS(result.out, " poor");
}

/// Files that crash a library, or hold it for ever, end in an error that names them.
TEST(Import, DamagedFilesAreErrors) {
  std::string machine = body_text("plate", 60);
  machine.replace(machine.find(".stl"), 4, ".vtu");
  const OwnCase own(machine);
  // Cells that refer to points which do not exist.
  own.write("cad/plate.vtu", R"(<?xml version="1.0"?><VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian"><UnstructuredGrid>
<Piece NumberOfPoints="4" NumberOfCells="1"><Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points>
<Cells><DataArray type="Int64" Name="connectivity" format="ascii">0 1 2 900000000000</DataArray><DataArray type="Int64" Name="offsets" format="ascii">-400000000</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">10</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>)");
  const Result result = own.run({"mesh", own.path()});
  EXPECT_EQ(result.status, 3) << result.err;
  EXPECT_SAYS(result.err, "plate");
}

TEST(Import, AMeshThatWouldBeTooLargeIsRefusedBefore) {
  const OwnCase own(body_text("block", 0.1));
  own.blocks("block", {low});
  const Result result = own.run({"mesh", own.path()});
  EXPECT_EQ(result.status, 3) << result.err;
  for (const char* words : {"body 'block'", "about 3.5e+09 tetrahedra", "element_size_mm = 0.1", "max_elements = 4e+06", "element_size_mm of 0.956"}) EXPECT_SAYS(result.err, words);
}

TEST(Import, SlipsOfASurfaceFileAreRepaired) {
  const OwnCase own(body_text("block", 60));
  std::string stl = stl_of({low});
  const std::size_t first = stl.find("facet"), second = stl.find("facet normal", first + 5), end = stl.rfind("endsolid");
  const std::string triangle = stl.substr(first, second - first);
  own.write("cad/block.stl", std::string(stl).insert(end, triangle));
  const Result twice = own.run({"mesh", own.path()});
  EXPECT_EQ(twice.status, 0) << twice.err;
  EXPECT_SAYS(twice.err, "body 'block': the surface was repaired: 1 duplicate triangles dropped");
  // The edge from (0,0,0) to (100,100,0) of the bottom's two triangles, with a corner in its middle on one side only.
  const std::string split = "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 100 0\nvertex 50 50 0\nendloop\nendfacet\n"
                            "facet normal 0 0 0\nouter loop\nvertex 50 50 0\nvertex 0 100 0\nvertex 100 100 0\nendloop\nendfacet\n"
                            "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 50 50 0\nvertex 100 100 0\nendloop\nendfacet\n";
  own.write("cad/block.stl", std::string(stl).replace(first, second - first, split));
  const Result sliver = own.run({"mesh", own.path()});
  EXPECT_EQ(sliver.status, 0) << sliver.err;
  EXPECT_SAYS(sliver.err, "1 triangles without area merged into a neighbour");
}

}  // namespace
}  // namespace thermotwin::cases
