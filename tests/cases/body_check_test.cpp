// SPDX-License-Identifier: GPL-3.0-or-later
// Bodies in pieces, bodies in one place, poor elements, and what `mesh` says of joints.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <sstream>

#include "tests/cases/own_case.h"

namespace thermotwin::cases {
namespace {

constexpr Block low{{0, 0, 0}, {100, 100, 50}}, high{{0, 0, 50.2}, {100, 60, 100}};

TEST(BodyCheck, UnconnectedPiecesAreAnErrorUnlessStated) {
  const OwnCase own(body_text("block", 60));
  own.blocks("block", {low, high});
  const Result two = own.run({"mesh", own.path()});
  EXPECT_EQ(two.status, 3);
  for (const char* words : {"machine.toml", "body 'block' falls into 2 pieces", "(298.8 cm3",
                            "around [50, 30, 75.1] mm", "0.2 mm from the others", "pieces = 2"})
    EXPECT_SAYS(two.err, words);
  const OwnCase stated(body_text("block", 60, "pieces = 2"));
  stated.blocks("block", {low, high});
  const Result meant = stated.run({"mesh", stated.path(), "--json", "--quiet"});
  ASSERT_EQ(meant.status, 0) << meant.err;
  EXPECT_EQ(nlohmann::json::parse(meant.out)["bodies"][0]["pieces"], 2);
  stated.blocks("block", {low});
  const Result one = stated.run({"mesh", stated.path()});
  EXPECT_EQ(one.status, 3);
  EXPECT_SAYS(one.err,
              "body 'block' has 1 unconnected piece; allowed: pieces = 2 as machine.toml states, or pieces = 1");
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
  // A film that takes nothing is none.
  const OwnCase still(body_text("block", 60, "elastic = false") +
                      std::string(film).replace(film.find("K = 20"), 6, "K = 0"));
  still.blocks("block", {low});
  const Result kept = still.run({"simulate", still.path(), "--load", "hour"});
  ASSERT_EQ(kept.status, 0) << kept.err;
  EXPECT_SAYS(kept.err, "nothing takes heat from a part of 'block'");
  const OwnCase noughts(body_text("block", 60, "elastic = false") +
                        std::string(film).replace(film.find("film_coefficient"), std::string::npos,
                                                  "kind = \"table\"\ninput = \"air.T_C\"\nat = [10, 30]\n"
                                                  "film_coefficient_W_m2K = [0, 0]\n"));
  noughts.blocks("block", {low});
  const Result nought = noughts.run({"simulate", noughts.path(), "--load", "hour"});
  ASSERT_EQ(nought.status, 0) << nought.err;
  EXPECT_SAYS(nought.err, "nothing takes heat from a part of 'block'");
}

TEST(BodyCheck, AnElasticBodyIsOnePiece) {
  const OwnCase own(body_text("block", 60, "pieces = 2"));
  own.blocks("block", {low, high});
  const Result result = own.run({"simulate", own.path(), "--load", "hour"});
  EXPECT_EQ(result.status, 3);
  EXPECT_SAYS(result.err, "machine.toml body 'block': elastic, of 2 unconnected pieces");
  EXPECT_SAYS(result.err, "a body for each piece");
}

TEST(BodyCheck, TwoBodiesInOnePlaceAreAnError) {
  const OwnCase own(body_text("bed", 60) + body_text("ram", 60));
  own.blocks("bed", {low});
  own.blocks("ram", {{{20, 20, 40}, {80, 80, 90}}});  // 10 mm deep in the bed
  const Result result = own.run({"mesh", own.path()});
  EXPECT_EQ(result.status, 3);
  for (const char* words :
       {"bodies 'bed' and 'ram'", "fill the same place around [", "% of the smaller one", "bed.stl"})
    EXPECT_SAYS(result.err, words);
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

TEST(BodyCheck, AnAxisThatNothingHoldsIsWarnedOf) {
  std::string machine = body_text("bed", 60) + body_text("ram", 60, "parent = \"bed\"\naxis = \"X\"") +
                        "[[axis]]\nid = \"X\"\nkind = \"linear\"\ndirection = [1, 0, 0]\ntravel_mm = [-10, 10]\n" +
                        stacked.substr(stacked.find("[[surface]]"));
  const std::string bolted = "kind = \"bolted\"\n";
  machine.replace(machine.find(bolted), bolted.size(),
                  "kind = \"guide\"\naxis = \"X\"\nstiffness_normal_N_mm3 = 100\n");
  const auto meshed = [](const OwnCase& own) {
    own.blocks("bed", {low});
    own.blocks("ram", {high});
    return own.run({"mesh", own.path()});
  };
  const OwnCase free(machine);
  const Result unheld = meshed(free);
  EXPECT_EQ(unheld.status, 0) << unheld.err;
  EXPECT_SAYS(unheld.err, "machine.toml axis 'X': nothing holds body 'ram' along it; displacements need a [[scale]]");
  const Result refused = free.run({"simulate", free.path(), "--load", "hour"});
  EXPECT_EQ(refused.status, 3);
  EXPECT_SAYS(refused.err, "axis X: nothing holds body 'ram' along it");
  const OwnCase held(
      machine +
      "[[scale]]\naxis = \"X\"\ncarrier = \"bed\"\nhead_body = \"ram\"\nstart_mm = [0, 0, 50]\n"
      "end_mm = [100, 0, 50]\nfixed_at_mm = [0, 0, 50]\nhead_mm = [50, 0, 50.2]\nexpansion_1_K = 1e-5\n");
  const Result quiet = meshed(held);
  EXPECT_EQ(quiet.status, 0) << quiet.err;
  EXPECT_EQ(quiet.err.find("nothing holds"), std::string::npos) << quiet.err;
}

TEST(BodyCheck, PoorElementsAreWarnedOf) {
  std::string machine = body_text("plate", 60);
  machine.replace(machine.find(".stl"), 4, ".inp");
  const OwnCase own(machine);
  // One tetrahedron of 100 mm and one on its base that is 0.02 mm high.
  own.write("cad/plate.inp",
            "*NODE\n1, 0, 0, 0\n2, 100, 0, 0\n3, 0, 100, 0\n4, 0, 0, 100\n5, 30, 30, -0.02\n*ELEMENT, TYPE=C3D4\n1, 1, "
            "2, 3, 4\n2, 1, 3, 2, 5\n");
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
  own.write(
      "cad/plate.vtu",
      R"(<?xml version="1.0"?><VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian"><UnstructuredGrid>
<Piece NumberOfPoints="4" NumberOfCells="1"><Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points>
<Cells><DataArray type="Int64" Name="connectivity" format="ascii">0 1 2 900000000000</DataArray><DataArray type="Int64" Name="offsets" format="ascii">-400000000</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">10</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>)");
  const Result result = own.run({"mesh", own.path()});
  EXPECT_EQ(result.status, 3) << result.err;
  EXPECT_SAYS(result.err, "plate");
}

TEST(Import, AnExtentThatCannotBeNamesItsFile) {
  const OwnCase surface(body_text("block", 60, "unit = \"m\""));
  surface.blocks("block", {low});
  std::string machine = body_text("plate", 60, "unit = \"m\"");
  machine.replace(machine.find(".stl"), 4, ".inp");
  const OwnCase mesh(machine);
  mesh.write("cad/plate.inp",
             "*NODE\n1, 0, 0, 0\n2, 100, 0, 0\n3, 0, 100, 0\n4, 0, 0, 100\n*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n");
  for (const auto& [own, file] : {std::pair{&surface, "cad/block.stl: "}, {&mesh, "cad/plate.inp: "}}) {
    const Result result = own->run({"mesh", own->path()});
    EXPECT_EQ(result.status, 3) << result.err;
    EXPECT_SAYS(result.err, std::string(file) + "a largest extent of 100 m; the unit may be wrong");
    EXPECT_SAYS(result.err, "0.001 m .. 50 m (key unit");
  }
}

TEST(Import, AMeshThatWouldBeTooLargeIsRefusedBefore) {
  const OwnCase own(body_text("block", 0.1));
  own.blocks("block", {low});
  const Result result = own.run({"mesh", own.path()});
  EXPECT_EQ(result.status, 3) << result.err;
  for (const char* words : {"body 'block'", "about 3.5e+09 tetrahedra", "element_size_mm = 0.1", "max_elements = 4e+06",
                            "element_size_mm of 0.956"})
    EXPECT_SAYS(result.err, words);
}

TEST(Import, BlocksThatRunThroughEachOtherAreFilledWithALattice) {
  const Block through{{50, 20, 20}, {150, 80, 40}};
  const OwnCase refused(body_text("block", 12));
  refused.blocks("block", {low, through});
  const Result first = refused.run({"mesh", refused.path()});
  EXPECT_EQ(first.status, 3);
  EXPECT_SAYS(first.err, "cad/block.stl: ");
  EXPECT_SAYS(first.err, "(or key mesher = \"lattice\" of the body, which chamfers edges)");
  const OwnCase own(body_text("block", 12, "mesher = \"lattice\""));
  own.blocks("block", {low, through});
  const Result filled = own.run({"mesh", own.path(), "--json", "--quiet"});
  ASSERT_EQ(filled.status, 0) << filled.err;
  EXPECT_SAYS(filled.err, "body 'block': filled with a lattice");
  EXPECT_SAYS(filled.err, "edges are chamfered by up to an element");
  const auto body = nlohmann::json::parse(filled.out)["bodies"][0];
  // The chamfers of 12 mm elements cost 3 % of the volume.
  EXPECT_NEAR(body["mass_kg"].get<double>(), 7850 * (500e-6 + 60e-6), 0.04 * 7850 * 560e-6);
  EXPECT_EQ(body["pieces"], 1);
  EXPECT_GT(body["quality_min"].get<double>(), 0.02);
}

TEST(Import, ALatticeThatWouldBeTooLargeIsRefusedBefore) {
  const OwnCase own(body_text("block", 0.1, "mesher = \"lattice\""));
  own.blocks("block", {low});
  const Result result = own.run({"mesh", own.path()});
  EXPECT_EQ(result.status, 3) << result.err;
  for (const char* words : {"body 'block': about 3.5e+09 tetrahedra, cut from", "element_size_mm = 0.1",
                            "at most max_elements = 4e+06", "element_size_mm of 0.95"})
    EXPECT_SAYS(result.err, words);
}

TEST(Import, AMeshIsNotFilledWithALattice) {
  std::string machine = body_text("block", 12, "mesher = \"lattice\"");
  machine.replace(machine.find(".stl"), 4, ".inp");
  const OwnCase own(machine);
  own.write("cad/block.inp",
            "*NODE\n1, 0, 0, 0\n2, 100, 0, 0\n3, 0, 100, 0\n4, 0, 0, 100\n*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n");
  const Result result = own.run({"mesh", own.path()});
  EXPECT_EQ(result.status, 3) << result.err;
  EXPECT_SAYS(result.err, "cad/block.inp: mesher = \"lattice\" for a mesh; allowed: CAD or a surface");
}

TEST(Import, AnOpenSurfaceIsNotFilledWithALattice) {
  const OwnCase own(body_text("block", 12, "mesher = \"lattice\""));
  const std::string stl = stl_of({low});
  std::size_t half = 0;
  for (int n = 0; n < 7; ++n) half = stl.find("facet normal", half + 5);
  own.write("cad/block.stl", stl.substr(0, half) + "endsolid\n");
  const Result result = own.run({"mesh", own.path()});
  EXPECT_EQ(result.status, 3) << result.err;
  EXPECT_SAYS(result.err, "body 'block': an open surface: inside and outside cannot be distinguished");
}

TEST(Import, SlipsOfASurfaceFileAreRepaired) {
  const OwnCase own(body_text("block", 60));
  std::string stl = stl_of({low});
  const std::size_t first = stl.find("facet"), second = stl.find("facet normal", first + 5),
                    end = stl.rfind("endsolid");
  const std::string triangle = stl.substr(first, second - first);
  own.write("cad/block.stl", std::string(stl).insert(end, triangle));
  const Result twice = own.run({"mesh", own.path()});
  EXPECT_EQ(twice.status, 0) << twice.err;
  EXPECT_SAYS(twice.err, "body 'block': the surface was repaired: 1 duplicate triangles dropped");
  // The edge from (0,0,0) to (100,100,0) of the bottom's two triangles, with a corner in its middle on one side only.
  const std::string split =
      "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 100 0\nvertex 50 50 0\nendloop\nendfacet\n"
      "facet normal 0 0 0\nouter loop\nvertex 50 50 0\nvertex 0 100 0\nvertex 100 100 0\nendloop\nendfacet\n"
      "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 50 50 0\nvertex 100 100 0\nendloop\nendfacet\n";
  own.write("cad/block.stl", std::string(stl).replace(first, second - first, split));
  const Result sliver = own.run({"mesh", own.path()});
  EXPECT_EQ(sliver.status, 0) << sliver.err;
  EXPECT_SAYS(sliver.err, "1 triangles without area merged into a neighbour");
}

/// Volume in cm3 that `mesh` reports of the only body, by the mass of steel.
double volume_cm3(const OwnCase& own) {
  const Result result = own.run({"mesh", own.path(), "--json", "--quiet"});
  if (result.status != 0) ADD_FAILURE() << result.err;
  return result.status != 0 ? 0.0
                            : nlohmann::json::parse(result.out)["bodies"][0]["mass_kg"].get<double>() / 7850 * 1e6;
}

std::string facet(const std::string& corners) {
  return "facet normal 0 0 0\nouter loop\n" + corners + "endloop\nendfacet\n";
}

/// The STL with some of its facets turned over.
std::string turned(const std::string& stl, const std::vector<int>& which) {
  std::vector<std::string> lines;
  std::istringstream in(stl);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  for (const int number : which) std::swap(lines[7 * number + 4], lines[7 * number + 5]);
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

TEST(Import, FlippedAndInsideOutTrianglesAreTurned) {
  const OwnCase own(body_text("block", 60));
  own.write("cad/block.stl", turned(stl_of({low}), {2, 5, 7}));
  const Result flipped = own.run({"mesh", own.path()});
  EXPECT_EQ(flipped.status, 0) << flipped.err;
  EXPECT_SAYS(flipped.err, "3 flipped triangles turned over");
  EXPECT_NEAR(volume_cm3(own), 500.0, 1e-6);
  own.write("cad/block.stl", turned(stl_of({low}), {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}));
  const Result over = own.run({"mesh", own.path()});
  EXPECT_EQ(over.status, 0) << over.err;
  EXPECT_SAYS(over.err, "1 shells that were inside out turned over");
  EXPECT_NEAR(volume_cm3(own), 500.0, 1e-6);
}

// A cavity turns inwards: it is judged by where it lies, whatever its outer shell does.
TEST(Import, ACavityIsTurnedAsItsDepthAsks) {
  const OwnCase own(body_text("block", 30));
  const std::string text = stl_of({low, {{30, 30, 15}, {70, 70, 35}}});
  std::vector<int> outer(12), all(24);
  std::iota(outer.begin(), outer.end(), 0);
  std::iota(all.begin(), all.end(), 0);
  for (const auto& facets : {all, outer}) {
    own.write("cad/block.stl", turned(text, facets));
    const Result result = own.run({"mesh", own.path()});
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_NEAR(volume_cm3(own), 500.0 - 32.0, 1e-6);
  }
}

TEST(Import, TrianglesBackToBackAreDropped) {
  // Two blocks that touch on a whole side: the wall between them goes.
  const OwnCase own(body_text("block", 60));
  // The sides in x have their diagonals in one place.
  own.blocks("block", {{{0, 0, 0}, {100, 100, 50}}});
  const std::string left = stl_of({low});
  std::string right = stl_of({{{100, 0, 0}, {200, 100, 50}}});
  // The last four facets are those at low and high x; the diagonal of low x runs from (0,0) to (1,1) as that of high x
  // does.
  const std::string mirrored = facet("vertex 100 0 0\nvertex 100 0 50\nvertex 100 100 50\n") +
                               facet("vertex 100 0 0\nvertex 100 100 50\nvertex 100 100 0\n");
  const auto facets_of = [](const std::string& text) {
    std::vector<std::size_t> starts;
    for (std::size_t at = text.find("facet normal"); at != std::string::npos; at = text.find("facet normal", at + 1))
      starts.push_back(at);
    return starts;
  };
  std::vector<std::size_t> starts = facets_of(right);
  right.replace(starts[8], starts[10] - starts[8], mirrored);
  std::string both = left.substr(0, left.rfind("endsolid"));
  starts = facets_of(both);
  both.replace(starts[10], both.size() - starts[10],
               facet("vertex 100 0 0\nvertex 100 100 50\nvertex 100 0 50\n") +
                   facet("vertex 100 0 0\nvertex 100 100 0\nvertex 100 100 50\n"));
  own.write("cad/block.stl", both + right.substr(right.find("facet")));
  const Result result = own.run({"mesh", own.path()});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_SAYS(result.err, "2 pairs of opposite triangles in one place dropped");
  EXPECT_NEAR(volume_cm3(own), 1000.0, 1e-6);
}

TEST(Import, CracksAreClosed) {
  const OwnCase own(body_text("block", 60));
  // The top (facets 2 and 3) with corners 0.004 mm off, and split along one side in the middle: corners of its own.
  std::string stl = stl_of({low});
  std::vector<std::size_t> starts;
  for (std::size_t at = stl.find("facet normal"); at != std::string::npos; at = stl.find("facet normal", at + 1))
    starts.push_back(at);
  stl.replace(starts[2], starts[4] - starts[2],
              facet("vertex 0 0 50.004\nvertex 50 0 50\nvertex 100 100.004 50\n") +
                  facet("vertex 50 0 50\nvertex 100 0 50\nvertex 100 100.004 50\n") +
                  facet("vertex 0 0 50.004\nvertex 100 100.004 50\nvertex 0 100 50\n"));
  own.write("cad/block.stl", stl);
  const Result result = own.run({"mesh", own.path()});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_SAYS(result.err, "cracks closed at 4 corners and edges");
  EXPECT_NEAR(volume_cm3(own), 500.0, 0.05);
}

/// A block of 100 x 100 x 50 mm, its sides cut into 20 x 20 fields of two triangles, with its corners moved as told.
std::string fields_of(const std::function<void(std::array<double, 3>&)>& move) {
  constexpr int n = 20;
  std::string text = "solid fields\n";
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const bool upper : {false, true}) {
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
          std::array<std::array<double, 3>, 4> corner{};
          for (std::size_t c = 0; c < 4; ++c) {
            const int u = i + (c == 1 || c == 2 ? 1 : 0), v = j + (c >= 2 ? 1 : 0);
            auto& p = corner[c];
            p[axis] = upper ? 1.0 : 0.0;
            p[(axis + 1) % 3] = static_cast<double>(u) / n;
            p[(axis + 2) % 3] = static_cast<double>(v) / n;
            p = {100 * p[0], 100 * p[1], 50 * p[2]};
            move(p);
          }
          // The higher diagonal, so that ridges stay.
          const bool other = corner[1][2] + corner[3][2] > corner[0][2] + corner[2][2];
          using Two = std::array<std::array<std::size_t, 3>, 2>;
          for (const auto& triangle : other ? Two{{{0, 1, 3}, {1, 2, 3}}} : Two{{{0, 1, 2}, {0, 2, 3}}}) {
            std::string corners;
            for (std::size_t k = 0; k < 3; ++k) {
              const auto& p = corner[triangle[upper ? k : 2 - k]];
              corners += fmt::format("vertex {} {} {}\n", p[0], p[1], p[2]);
            }
            text += facet(corners);
          }
        }
      }
    }
  }
  return text + "endsolid fields\n";
}

TEST(Import, AFewTrianglesThatCutEachOtherAreReplaced) {
  const OwnCase own(body_text("block", 60));
  // One corner in the middle of the top lies beyond its neighbour: a fold.
  own.write("cad/block.stl", fields_of([](std::array<double, 3>& p) {
              if (p == std::array<double, 3>{50, 50, 50}) p = {57, 51, 50};
            }));
  const Result result = own.run({"mesh", own.path()});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_SAYS(result.err, "triangles that cut each other, or are next to such, replaced");
  EXPECT_NEAR(volume_cm3(own), 500.0, 1e-3);
  // Two solids that overlap stay an error that says so.
  own.blocks("block", {low, {{50, 50, 20}, {150, 150, 70}}});
  const Result overlap = own.run({"mesh", own.path()});
  EXPECT_EQ(overlap.status, 3);
  EXPECT_SAYS(overlap.err, "of two shells, whose solids overlap");
}

/// A block as an IGES file in mm: six bilinear patches, no solid.
std::string iges_of(const Block& block) {
  constexpr int sides[6][4] = {{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 4, 5}, {2, 3, 6, 7}, {0, 2, 4, 6}, {1, 3, 5, 7}};
  std::string directory, parameters;
  int lines = 0;
  for (int side = 0; side < 6; ++side) {
    std::string data = "128,1,1,1,1,0,0,1,0,0,0.,0.,1.,1.,0.,0.,1.,1.,1.,1.,1.,1.,";
    for (const int corner : sides[side]) {
      for (std::size_t k = 0; k < 3; ++k)
        data += fmt::format("{:.3f},", (corner >> k & 1) != 0 ? block.high[k] : block.low[k]);
    }
    data += "0.,1.,0.,1.;";
    const int first = lines + 1, entry = 2 * side + 1;
    while (!data.empty()) {
      const std::size_t cut = data.size() <= 64 ? data.size() : data.rfind(',', 63) + 1;
      parameters += fmt::format("{:<64}{:>8}P{:>7}\n", data.substr(0, cut), entry, ++lines);
      data.erase(0, cut);
    }
    directory += fmt::format("{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}D{:>7}\n", 128, first, 0, 0, 0, 0, 0, 0,
                             "00000000", entry);
    directory += fmt::format("{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}D{:>7}\n", 128, 0, 0, lines - first + 1, 0,
                             "", "", "", 0, entry + 1);
  }
  const std::string global = "1H,,1H;,5Hblock,5Hblock,4Htest,4Htest,32,38,6,308,15,5Hblock,1.,2,2HMM,";
  const std::string more = "1,0.01,13H260101.000000,1E-6,1000.,4Htest,4Htest,10,0,13H260101.000000;";
  return fmt::format("{:<72}S{:>7}\n", "a block of six patches", 1) +
         fmt::format("{:<72}G{:>7}\n{:<72}G{:>7}\n", global, 1, more, 2) + directory + parameters +
         fmt::format("{:<72}T{:>7}\n", fmt::format("S{:>7}G{:>7}D{:>7}P{:>7}", 1, 2, 12, lines), 1);
}

TEST(Import, FacesOfAnIgesFileAreSewn) {
  std::string machine = body_text("block", 60);
  machine.replace(machine.find(".stl"), 4, ".igs");
  const OwnCase own(machine);
  own.write("cad/block.igs", iges_of(low));
  const Result result = own.run({"mesh", own.path()});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_SAYS(result.err, "body 'block': 6 faces were sewn into 1 solids");
  EXPECT_NEAR(volume_cm3(own), 500.0, 1e-6);
}

}  // namespace
}  // namespace thermotwin::cases
