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

}  // namespace
}  // namespace thermotwin::cases
