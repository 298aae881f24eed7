// SPDX-License-Identifier: GPL-3.0-or-later
// First steps with a machine of one's own: heat alone, without [tcp] and elastic bodies; a body that one pad cannot
// hold.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "core/table.h"
#include "tests/cases/own_case.h"
#include "tests/cases/texts.h"

namespace thermotwin::cases {
namespace {

const std::string heated_skin = R"(
[[surface]]
id = "skin"
body = "block"
[[ambient]]
id = "air"
default_C = 20
[[film]]
id = "skin"
surfaces = ["skin"]
film_coefficient_W_m2K = 20
[[source]]
id = "heater"
law = [{input = "machine.on", at = [0, 1], power_W = [0, 10]}]
place = [{surface = "skin"}]
[[sensor]]
id = "T1"
body = "block"
point_mm = [5, 5, 5]
)";

constexpr Block cube{{0, 0, 0}, {100, 100, 100}};

struct HeatedCube : OwnCase {
  explicit HeatedCube(const std::string& more, const std::string& of_body = "")
      : OwnCase(body_text("block", 60, of_body) + heated_skin + more) {
    blocks("block", {cube});
  }
};

TEST(OwnMachine, HeatNeedsNoTcpAndNoElasticBody) {
  const HeatedCube own("", "elastic = false");
  ASSERT_EQ(own.run({"mesh", own.path()}).status, 0);
  const Result simulated = own.run({"simulate", own.path(), "--load", "hour"});
  ASSERT_EQ(simulated.status, 0) << simulated.err;
  EXPECT_SAYS(simulated.out, "no [tcp] in machine.toml");
  const auto folder = own.result("simulate/hour");
  for (const char* file : {"fields.pvd", "heat.csv", "sensors.csv"})
    EXPECT_TRUE(std::filesystem::exists(folder / file)) << file;
  EXPECT_FALSE(std::filesystem::exists(folder / "tcp.csv"));
  EXPECT_EQ(read(folder / "fields/000000.vtu").find("displacement"), std::string::npos);
  // A lumped capacity of 0.001 m^3 steel behind a film of 20 W/(m^2 K) on 0.06 m^2, heated by 10 W.
  const double conductance = 20 * 0.06, capacity = 7850 * 470 * 1e-3;
  const core::Table sensors = core::read_csv(folder / "sensors.csv");
  const double rise = sensors.column("T1_C")(sensors.rows() - 1) - 20.0;
  EXPECT_NEAR(rise, 10 / conductance * (1 - std::exp(-3600 * conductance / capacity)), 0.02 * rise);
}

TEST(OwnMachine, SmallMassesPrintInGramsAndALightDensityIsWarnedOf) {
  const HeatedCube own("");
  own.blocks("block", {{{0, 0, 0}, {10, 10, 10}}});  // 1 cm^3
  const Result heavy = own.run({"mesh", own.path()});
  ASSERT_EQ(heavy.status, 0) << heavy.err;
  EXPECT_SAYS(heavy.out, "7.85 g");
  EXPECT_EQ(heavy.err.find("density"), std::string::npos) << heavy.err;
  std::string machine = read(own.path() + "/machine.toml");
  machine.replace(machine.find("= 7850"), 6, "= 7.85");
  own.write("machine.toml", machine);
  const Result light = own.run({"mesh", own.path()});
  EXPECT_EQ(light.status, 0);
  EXPECT_SAYS(light.err, "material[1] density_kg_m3: 7.85");
  EXPECT_SAYS(light.err, "7850 kg/m3");
}

/// Edits the one place of a file that reads so.
void edit(const std::filesystem::path& file, const std::string& old, const std::string& with) {
  std::string text = read(file);
  const std::size_t at = text.find(old);
  ASSERT_NE(at, std::string::npos) << old;
  text.replace(at, old.size(), with);
  std::ofstream(file, std::ios::binary) << text;
}

TEST(OwnMachine, PointsInMetresExchangedSidesAndKilowattsAreWarnedOf) {
  const core::TemporaryFolder folder;
  const std::filesystem::path mill = folder / "mill";
  std::filesystem::copy(source_tree() / "cases/mill", mill, std::filesystem::copy_options::recursive);
  const std::vector<std::string> mesh{"mesh", mill.string(), "--out", (folder / "out").string()};
  const Result clean = thermotwin(mesh);
  ASSERT_EQ(clean.status, 0) << clean.err;
  EXPECT_EQ(clean.err.find("warning"), std::string::npos) << clean.err;
  edit(mill / "machine.toml", "tool_point_mm = [0, 0, 50]", "tool_point_mm = [0.06, 0.2, 0.3]");
  edit(mill / "machine.toml", "table_point_mm = [0, 0, 0]", "table_point_mm = [0, 0, 2000]");
  edit(mill / "machine.toml", "slave = \"head.carriages\"\nmaster = \"frame.column\"",
       "slave = \"frame.column\"\nmaster = \"head.carriages\"");
  edit(mill / "machine.toml", "power_W = [0, 150]", "power_W = [0, 90000]");
  const Result wrong = thermotwin(mesh);
  EXPECT_EQ(wrong.status, 0) << wrong.err;
  for (const char* words : {"tcp.tool_point_mm: [0.06, 0.2, 0.3] is ",
                            "from the box of body 'head', and in it or close to it when the "
                            "numbers are metres",
                            "tcp.table_point_mm: [0, 0, 2000] is 2000 mm from the box of body 'table'; allowed",
                            "axis Z moves 'head', the body of master, and not 'frame'", "Exchange slave and master",
                            "law[1].power_W: 90000 W of heat", "up to 30000 W", "machine.toml:"})
    EXPECT_SAYS(wrong.err, words);
}

TEST(OwnMachine, ATablePointOffItsAxisAndAChainWithMoreAxesAreWarnedOf) {
  const Toy toy;
  toy.edit("machine.toml", "table_point_mm = [0, 0, 0]", "table_point_mm = [50, 0, 0]");
  toy.edit("machine.toml", "b Y X Z (C1) t]", "b Y X Z W (C1) t]");
  const Result result = toy.run({"mesh", toy.path()});
  EXPECT_EQ(result.status, 0) << result.err;
  for (const char* words : {"tcp.table_point_mm: [50, 0, 0] is 50 mm from axis C of the table", "at most 30 mm",
                            "axis 'W' of the chain is no [[axis]] of the machine"})
    EXPECT_SAYS(result.err, words);
}

TEST(OwnMachine, HeatAloneIsADeckThatCalculiXRuns) {
  const HeatedCube own("", "elastic = false");
  const Result exported =
      own.run({"export", own.path(), "--calculix", "--load", "hour", "--time-step", "600", "--json"});
  ASSERT_EQ(exported.status, 0) << exported.err;
  const auto json = nlohmann::json::parse(exported.out);
  EXPECT_EQ(json["files"], nlohmann::json({"mesh.inp", "heat_only.inp", "heat.inp"}));
  EXPECT_SAYS(json["notes"].dump(), "no static.inp");
  if (std::system("command -v ccx > /dev/null 2>&1") != 0) GTEST_SKIP() << "CalculiX (ccx) is not installed";
  const std::string folder = own.result("calculix").string();
  EXPECT_EQ(std::system(("cd '" + folder + "' && OMP_NUM_THREADS=1 ccx heat > heat.log 2>&1").c_str()), 0);
  EXPECT_SAYS(read(folder + "/heat.log"), "Job finished");
}

TEST(OwnMachine, DisplacementsNeedNoTcp) {
  const HeatedCube own(R"(
[[surface]]
id = "feet"
body = "block"
rule = {plane_point_mm = [0, 0, 0], plane_normal = [0, 0, 1]}
[[joint]]
id = "feet"
kind = "mount"
slave = "feet"
ambient = "air"
conductance_W_m2K = 10
stiffness_normal_N_mm3 = 20
stiffness_tangential_N_mm3 = 20
divide = [2, 2, 1]
)");
  const Result simulated = own.run({"simulate", own.path(), "--load", "hour"});
  ASSERT_EQ(simulated.status, 0) << simulated.err;
  EXPECT_NE(read(own.result("simulate/hour/fields/000000.vtu")).find("displacement_um"), std::string::npos);
}

TEST(OwnMachine, VerbsOfTheTcpErrorNameWhatTheyNeed) {
  const HeatedCube own("", "elastic = false");
  for (const std::vector<std::string>& verb : std::vector<std::vector<std::string>>{
           {"run"}, {"campaign"}, {"reduce"}, {"validate"}, {"diagnose", "--data", own.path()}}) {
    std::vector<std::string> arguments = verb;
    arguments.insert(arguments.begin() + 1, own.path());
    if (verb[0] == "diagnose") {
      own.write("channels.toml",
                "schema = 1\n[[channel]]\nid = \"T1\"\nkind = \"temperature\"\nunit = \"degC\"\nuncertainty = "
                "0.1\nsensor = \"T1\"\n");
      own.write("data.csv", "time_s,T1\n0,20\n600,21\n1200,22\n");
    }
    const Result result = own.run(arguments);
    EXPECT_EQ(result.status, 3) << verb[0] << result.err;
    EXPECT_SAYS(result.err, "machine.toml [tcp]: missing") << verb[0];
    EXPECT_SAYS(result.err, "simulate and export work without") << verb[0];
  }
}

TEST(OwnMachine, OnePadThatCannotHoldARotationIsExplained) {
  const HeatedCube own(R"(
[[surface]]
id = "bottom"
body = "block"
rule = {normal = [0, 0, -1]}
[[joint]]
id = "feet"
kind = "mount"
slave = "bottom"
ambient = "air"
conductance_W_m2K = 10
stiffness_normal_N_mm3 = 20
stiffness_tangential_N_mm3 = 20
)");
  const Result result = own.run({"simulate", own.path(), "--load", "hour"});
  EXPECT_NE(result.status, 0);
  for (const char* words : {"body 'block'", "about ", "'feet' with divide = [1, 1, 1]", "one pad holds no rotation",
                            "2 x 2", "[2, 2, 1]", "sectors"})
    EXPECT_SAYS(result.err, words);
}

/// A table of 700 x 300 x 60 mm under which a box takes 120 x 30 mm for the nut; a second box lies a millimetre within
/// the whole top.
struct NutUnderATable : OwnCase {
  NutUnderATable()
      : OwnCase(body_text("table", 55) + R"(
[[surface]]
id = "nut"
body = "table"
rule = {normal = [0, 0, -1], box_min_mm = [290, -1, -1], box_max_mm = [410, 30, 1]}
[[surface]]
id = "top"
body = "table"
rule = {normal = [0, 0, 1], box_min_mm = [1, 1, 59], box_max_mm = [699, 299, 61]}
[[surface]]
id = "skin"
body = "table"
except = ["nut"]
)") {
    blocks("table", {{{0, 0, 0}, {700, 300, 60}}});
  }
};

TEST(OwnMachine, TheAreaOfABoxThatDependsOnTheMeshStandsBesideTheDrawnOne) {
  const NutUnderATable own;
  int warned = 0;
  for (const char* size : {"1", "0.8", "0.7", "0.5"}) {
    const Result result = own.run({"mesh", own.path(), "--size", size, "--json"});
    ASSERT_EQ(result.status, 0) << result.err;
    const nlohmann::json surfaces = nlohmann::json::parse(result.out)["surfaces"];
    const double whole = 2 * (0.7 * 0.3 + 0.7 * 0.06 + 0.3 * 0.06), nut = surfaces[0]["area_m2"];
    EXPECT_NEAR(surfaces[0]["cut_area_m2"].get<double>(), 0.0036, 1e-8) << size;
    EXPECT_NEAR(surfaces[1]["cut_area_m2"].get<double>(), 0.21, 1e-8) << "the face that the box encloses";
    EXPECT_NEAR(surfaces[2]["cut_area_m2"].get<double>(), whole - 0.0036, 1e-8) << size;
    const bool off = std::abs(nut - 0.0036) > 0.1 * 0.0036;
    warned += off;
    EXPECT_EQ(result.err.find("'nut': its ") != std::string::npos, off) << size << " " << nut << result.err;
    EXPECT_EQ(result.err.find("'top': its ") != std::string::npos, false) << result.err;
    if (!off) continue;
    for (const char* said : {"machine.toml:", "cover ", "cuts 36 cm2", "a face of its own", "element_size_mm",
                             "'table' (55 at size factor 1)"})
      EXPECT_SAYS(result.err, said);
  }
  EXPECT_GT(warned, 0) << "one of the meshes differs by more than a tenth";
  EXPECT_SAYS(own.run({"mesh", own.path()}).out, "cut at its box cm2");
}

// Centres of triangles on the narrow sides lie within the rule's tolerance of 0.5 mm.
TEST(OwnMachine, APlaneOfAThinStripHasItsFaceAlone) {
  const OwnCase own(body_text("strip", 5, "elastic = false") + R"(
[[surface]]
id = "bottom"
body = "strip"
rule = {plane_point_mm = [0, 0, 0], plane_normal = [0, 0, 1]}
)");
  own.blocks("strip", {{{0, 0, 0}, {200, 10, 3}}});
  for (const char* size : {"1", "0.5", "0.25"}) {
    const Result result = own.run({"mesh", own.path(), "--size", size, "--json"});
    ASSERT_EQ(result.status, 0) << result.err;
    EXPECT_NEAR(nlohmann::json::parse(result.out)["surfaces"][0]["area_m2"].get<double>(), 20e-4, 1e-9) << size;
  }
}

TEST(OwnMachine, AToolBesideTheMiddleOfItsSurfaceIsWarnedOf) {
  const core::TemporaryFolder folder;
  const std::filesystem::path mill = folder / "mill";
  std::filesystem::copy(source_tree() / "cases/mill", mill, std::filesystem::copy_options::recursive);
  edit(mill / "machine.toml", "rule = {plane_point_mm = [0, 0, 150], plane_normal = [0, 0, 1]}",
       "rule = {normal = [0, 0, -1]}");
  const Result result = thermotwin({"mesh", mill.string(), "--out", (folder / "out").string()});
  EXPECT_EQ(result.status, 0) << result.err;
  for (const char* words : {"machine.toml:", "tcp.tool_surface", "lies 70 mm sideways of the middle of 'head.nose'",
                            "[0, 70, 160.769]", "10 %", "growth over that distance is not in the TCP error"})
    EXPECT_SAYS(result.err, words);
}

TEST(OwnMachine, ANutFarBesideItsScrewIsWarnedOf) {
  const std::string nut = "nut_mm = [100, 0, 75]";
  const OwnCase own(body_text("base", 60) + body_text("slide", 60, "parent = \"base\"\naxis = \"X\"") +
                    body_text("screw", 20, "parent = \"base\"\nelastic = false") + R"(
[[axis]]
id = "X"
kind = "linear"
direction = [1, 0, 0]
travel_mm = [0, 50]
[[screw]]
axis = "X"
body = "screw"
nut_body = "slide"
fixed_bearing_mm = [0, 0, 75]
nut_mm = [100, 0, 75]
expansion_1_K = 11.5e-6
)");
  own.blocks("base", {{{-100, -100, 0}, {300, 100, 50}}});
  own.blocks("slide", {{{0, -100, 100}, {200, 100, 150}}});
  own.blocks("screw", {{{-50, -10, 65}, {250, 10, 85}}});
  const Result right = own.run({"mesh", own.path()});
  ASSERT_EQ(right.status, 0) << right.err;
  EXPECT_EQ(right.err.find("screw of axis"), std::string::npos) << right.err;
  edit(own.path() + "/machine.toml", nut, "nut_mm = [100, 326, 75]");
  const Result wrong = own.run({"mesh", own.path()});
  EXPECT_EQ(wrong.status, 0) << wrong.err;
  EXPECT_SAYS(wrong.err, "screw of axis 'X' nut_mm: [100, 326, 75] is 316 mm from body 'screw'");
  EXPECT_SAYS(wrong.err, "its thickness, 20 mm");
}

/// A head bolted on a bed, with a film over surfaces of it.
struct BoltedHead : OwnCase {
  explicit BoltedHead(const std::string& filmed)
      : OwnCase(body_text("bed", 60) + body_text("head", 40, "parent = \"bed\"") + R"(
[[surface]]
id = "bed.top"
body = "bed"
rule = {normal = [0, 0, 1]}
[[surface]]
id = "head.foot"
body = "head"
rule = {normal = [0, 0, -1]}
[[surface]]
id = "head.skin"
body = "head"
except = ["head.foot"]
[[joint]]
id = "bolts"
kind = "bolted"
slave = "head.foot"
master = "bed.top"
conductance_W_m2K = 3000
[[ambient]]
id = "air"
default_C = 20
[[film]]
id = "fan"
surfaces = [)" + filmed +
                R"(]
film_coefficient_W_m2K = 20
)") {
    blocks("bed", {{{0, 0, 0}, {200, 100, 100}}});
    blocks("head", {{{0, 0, 100}, {100, 100, 200}}});
  }
};

TEST(OwnMachine, AFilmUnderABoltedJointIsWarnedOf) {
  const BoltedHead foot("\"head.foot\""), skin("\"head.skin\""), both("\"head.skin\", \"bed.top\"");
  const Result covered = foot.run({"mesh", foot.path()});
  ASSERT_EQ(covered.status, 0) << covered.err;
  EXPECT_SAYS(covered.err,
              "film 'fan': 100 % of its 100.0 cm2 lie under joints that do not move. The film cools this "
              "area although no air reaches it");
  EXPECT_SAYS(covered.out, "under fixed joints %");
  const Result free = skin.run({"mesh", skin.path(), "--json"});
  ASSERT_EQ(free.status, 0) << free.err;
  EXPECT_EQ(free.err.find("film 'fan'"), std::string::npos) << free.err;
  EXPECT_EQ(nlohmann::json::parse(free.out)["films"][0]["under_fixed_joints_percent"], 0.0);
  // Half of the bed's top: 100 of 700 cm2.
  const Result half = both.run({"mesh", both.path(), "--json"});
  ASSERT_EQ(half.status, 0) << half.err;
  const nlohmann::json film = nlohmann::json::parse(half.out)["films"][0];
  EXPECT_NEAR(film["under_fixed_joints_percent"].get<double>(), 100.0 / 7.0, 0.01);
  EXPECT_EQ(film["under_moving_joints_percent"], 0.0);
}

TEST(OwnMachine, ASliverOfAPlainPlateIsAvoidedByAnotherAttempt) {
  const OwnCase own(body_text("plate", 50));
  own.blocks("plate", {{{0, 0, 0}, {600, 350, 60}}});
  const Result result = own.run({"mesh", own.path(), "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_GT(nlohmann::json::parse(result.out)["bodies"][0]["quality_min"].get<double>(), 0.05);
  EXPECT_EQ(result.err.find("worst element"), std::string::npos) << result.err;
}

TEST(OwnMachine, ACheckPointOnTheGridIsWarnedOf) {
  const Toy toy;
  EXPECT_EQ(toy.run({"simulate", toy.path(), "--load", "no_such"}).err.find("workspace grid"), std::string::npos);
  toy.edit("case.toml", "X=-60,Y=20,Z=30,B=0", "X=-120,Y=40,Z=50,B=45");
  const Result result = toy.run({"simulate", toy.path(), "--load", "no_such"});
  EXPECT_SAYS(result.err, "case.toml:");
  EXPECT_SAYS(result.err, "is a pose of the workspace grid");
  EXPECT_SAYS(result.err, "between the positions of [workspace]");
}

}  // namespace
}  // namespace thermotwin::cases
