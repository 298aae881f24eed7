// SPDX-License-Identifier: GPL-3.0-or-later
// A machine whose only linear axis is X: what its offsets cannot move stays, and every figure of compensation says so.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>

#include "core/table.h"
#include "tests/cases/nc_programs.h"
#include "tests/cases/own_case.h"
#include "tests/cases/texts.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const std::string words_of_machine = R"(
[[axis]]
id = "X"
kind = "linear"
direction = [1, 0, 0]
travel_mm = [-100, 100]
rapid_mm_min = 8000
[[scale]]
axis = "X"
carrier = "bed"
head_body = "slide"
start_mm = [-150, -120, -10]
end_mm = [280, -120, -10]
fixed_at_mm = [-150, -120, -10]
head_mm = [80, -100, 10]
expansion_1_K = 8e-6
[[surface]]
id = "bed.bottom"
body = "bed"
rule = {normal = [0, 0, -1]}
[[surface]]
id = "bed.top"
body = "bed"
rule = {normal = [0, 0, 1]}
[[surface]]
id = "head.foot"
body = "head"
rule = {normal = [0, 0, -1]}
[[surface]]
id = "head.nose"
body = "head"
rule = {normal = [1, 0, 0]}
[[surface]]
id = "head.skin"
body = "head"
except = ["head.foot", "head.nose"]
[[surface]]
id = "slide.shoes"
body = "slide"
rule = {normal = [0, 0, -1]}
[[surface]]
id = "slide.top"
body = "slide"
rule = {normal = [0, 0, 1]}
[[joint]]
id = "feet"
kind = "mount"
slave = "bed.bottom"
ambient = "air"
conductance_W_m2K = 20
stiffness_normal_N_mm3 = 25
stiffness_tangential_N_mm3 = 4
divide = [2, 2, 1]
[[joint]]
id = "bolts"
kind = "bolted"
slave = "head.foot"
master = "bed.top"
conductance_W_m2K = 3000
stiffness_normal_N_mm3 = 1000
stiffness_tangential_N_mm3 = 600
divide = [2, 2, 1]
[[joint]]
id = "guide"
kind = "guide"
slave = "slide.shoes"
master = "bed.top"
axis = "X"
conductance_W_m2K = 700
stiffness_normal_N_mm3 = 300
stiffness_tangential_N_mm3 = 200
divide = [2, 2, 1]
[[ambient]]
id = "air"
default_C = 20
[[film]]
id = "skin"
surfaces = ["bed.top", "head.skin", "slide.top"]
film_coefficient_W_m2K = {value = 8, std_percent = 15}
[[source]]
id = "spindle"
scale = {value = 1, std_percent = 10}
law = [{input = "spindle.speed_rpm", at = [0, 4000], power_W = [0, 140]}]
place = [{surface = "head.nose"}]
[[sensor]]
id = "nose"
body = "head"
point_mm = [-160, 0, 180]
[[sensor]]
id = "bed"
body = "bed"
point_mm = [0, 100, -60]
[tcp]
tool_body = "head"
tool_surface = "head.nose"
tool_point_mm = [-40, 0, 100]
table_body = "slide"
table_surface = "slide.top"
table_point_mm = [80, 0, 60]
[workspace]
X_mm = [-80, 0, 80]
)";

const std::string check_points = "[check_points]\nposes = [\"X=-40\", \"X=40\"]\n";

/// The spindle works, then rests. @param more  keys of the first phase
std::string work(double rpm, double hours, const std::string& more = "") {
  return fmt::format(
      "schema = 1\ntime_step_s = 120\noutput_s = 600\n[[phase]]\nduration_h = {}\nspindle_rpm = {}\n{}"
      "[[phase.axis]]\nid = \"X\"\nlow_mm = -80\nhigh_mm = 80\nfeed_mm_min = 4000\n"
      "[[phase]]\nduration_h = 1\nspindle_rpm = 0\n",
      hours, rpm, more);
}

struct Bore : OwnCase {
  Bore()
      : OwnCase(body_text("bed", 60) + body_text("head", 50, "parent = \"bed\"") +
                body_text("slide", 50, "parent = \"bed\"\naxis = \"X\"") + words_of_machine) {
    std::string machine = read(path() + "/machine.toml");
    write("machine.toml", machine.insert(machine.find("reference_C"), "spindle_max_rpm = 4000\n"));
    blocks("bed", {{{-300, -120, -120}, {300, 120, 0}}});
    blocks("head", {{{-300, -80, 0}, {-140, 80, 200}}});
    blocks("slide", {{{0, -100, 0}, {160, 100, 60}}});
    write("case.toml",
          "schema = 1\nmachine = \"machine.toml\"\ntrain = [\"spin\", \"hall\"]\nholdout = [\"day\"]\n" + check_points +
              "[measured_machine]\nload = \"day\"\nkind = \"contact_conductance\"\nwhere = \"bolts\"\nfactor = 0.3\n");
    write("loads/spin.toml", work(4000, 3));
    write("loads/hall.toml",
          "schema = 1\ntime_step_s = 300\noutput_s = 600\n[[phase]]\nduration_h = 3\nair_C = [20, 23]\n");
    write("loads/day.toml", work(3200, 2));
  }
};

/// The whole chain on it, run once.
const Bore& bore() {
  static const Bore made;
  static const Result result = made.run({"run", made.path()});
  EXPECT_EQ(result.status, 0) << result.err;
  std::ofstream(made.path() + "/said.txt") << result.out;
  return made;
}

std::string model() { return bore().result("model.rom.h5").string(); }

/// The first number behind the words.
double number_after(const std::string& text, const std::string& words) {
  const std::size_t at = text.find(words);
  EXPECT_NE(at, std::string::npos) << words << " in\n" << text;
  if (at == std::string::npos) return 0.0;
  std::smatch found;
  const std::string rest = text.substr(at + words.size());
  EXPECT_TRUE(std::regex_search(rest, found, std::regex("-?[0-9]+\\.?[0-9]*"))) << words;
  return std::stod(found.str());
}

TEST(OneAxis, RunCountsAsRemovedWhatTheAxisRemoves) {
  const json said = json::parse(read(bore().result("summary.json")))["compensation"];
  const std::string text = read(bore().path() + "/said.txt"), page = read(bore().result("report.html"));
  // The error is along z by far; an offset of X leaves it.
  EXPECT_EQ(said["unmoved_directions"], "y (dy) and z (dz)");
  const double before = number_after(text, "RMS "), after = number_after(text, "um -> "),
               stays = said["unmoved_rms_um"];
  EXPECT_GT(before, 5.0);
  EXPECT_GT(stays, 0.5 * before);
  EXPECT_GE(after, stays - 0.05);
  EXPECT_LT(after, std::hypot(stays, 0.3 * std::sqrt(before * before - stays * stays)) + 0.5);
  EXPECT_NEAR(said["reduction_percent"].get<double>(), 100.0 * (1.0 - after / before), 1.0);
  EXPECT_GT(said["reduction_moved_percent"].get<double>(), said["reduction_percent"].get<double>() + 10.0);
  const std::string stay = fmt::format("No axis moves the tool along y (dy) and z (dz): {:.1f} ", stays);
  EXPECT_SAYS(text, stay + "um RMS stay there");
  EXPECT_SAYS(page, stay + "µm RMS stay there");
  EXPECT_SAYS(text, fmt::format("{:.1f} % removed", said["reduction_moved_percent"].get<double>()));
}

TEST(OneAxis, ValidateTellsWhatNoAxisMoves) {
  const Bore& own = bore();
  const std::vector<std::string> arguments{
      "validate", own.path(), "--model", model(), "--truth", own.result("reference.rom.h5").string(), "--draws", "3"};
  const Result told = own.run(arguments);
  ASSERT_EQ(told.status, 0) << told.err;
  EXPECT_SAYS(told.out, "day: No axis moves the tool along y (dy) and z (dz)");
  EXPECT_SAYS(told.out, "sensors % where axes move");
  std::vector<std::string> in_json = arguments;
  in_json.emplace_back("--json");
  const json found = json::parse(own.run(in_json).out);
  EXPECT_EQ(found["unmoved_directions"], "y (dy) and z (dz)");
  for (const json& row : found["rows"]) {
    const double stays = row["rms_unmoved_um"];
    EXPECT_GT(stays, 0.5 * row["rms_before_um"].get<double>());
    for (const char* left : {"rms_model_um", "rms_told_um", "rms_sensors_um"})
      EXPECT_GE(row[left].get<double>(), stays);
  }
  EXPECT_LT(found["median_reduction_percent"]["day"]["with_sensors"], 60.0);
  EXPECT_GT(found["median_reduction_moved_percent"]["day"], 60.0);
}

// Y and Z have no band at all, and the probe's noise is part of what is left along X.
TEST(OneAxis, CoverageCountsWhatHasAStatedUncertainty) {
  const double share = number_after(read(bore().result("report.html")), "<p class=\"below\">");
  EXPECT_GE(share, 80.0);
  EXPECT_SAYS(read(bore().result("report.html")), "of the residuals in the directions that axes move");
  EXPECT_SAYS(read(bore().result("report.html")), "0.3&#8239;µm");
}

TEST(OneAxis, OtherStudiesKeepToWhatAxesMove) {
  const Bore& own = bore();
  const auto study = [&](const char* flag) {
    const Result result = own.run({"validate", own.path(), "--model", model(), "--truth",
                                   own.result("reference.rom.h5").string(), "--draws", "2", flag, "--json"});
    EXPECT_EQ(result.status, 0) << result.err;
    return json::parse(result.out);
  };
  const json power_off = study("--power-off");
  EXPECT_EQ(power_off["unmoved_directions"], "y (dy) and z (dz)");
  for (const json& row : power_off["rows"])
    for (int k = 0; k < 3; ++k) EXPECT_GE(row["left_um"][k].get<double>(), row["unmoved_um"][k].get<double>() - 1e-9);
  EXPECT_SAYS(read(own.result("validation/report.html")), "No axis moves the tool along");
  // Of the part that the axis moves, not of the whole: else a failed sensor would seem to cost nothing.
  const json failed = study("--failed-sensors");
  for (const json& row : failed["rows"]) {
    EXPECT_GT(row["reduction_percent"], 50.0) << row;
  }
}

// What stays along y and z would choose a sensor for errors that no offset removes.
TEST(OneAxis, SensorsAreChosenForWhatTheAxisMoves) {
  const Bore own;
  const Result result = own.run({"study", "sensors", own.path(), "--count", "1", "--spacing", "80"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_SAYS(result.out, "No linear axis moves y (dy) and z (dz): errors there stay and do not count.");
  const json said = json::parse(read(own.result("study/sensors/sensors.json")));
  // The prediction's error without sensors is mostly along z.
  EXPECT_LT(said["without_um"].get<double>(), 1.5);
  EXPECT_SAYS(read(own.result("study/sensors/report.html")), "--count 1 --load day --spacing 80 --out");
}

TEST(OneAxis, ProbedValuesThatNoAxisMovesAreCountedApart) {
  const std::string rows =
      "time_s,spindle.speed_rpm,probe_dx_um,probe_dz_um\n0,3000,,\n600,3000,,\n1200,3000,2,8\n1800,3000,3,9\n";
  bore().write("rows.csv", rows);
  const auto offsets = bore().result("offsets.csv").string();
  const Result result = thermotwin({"compensate", model(), "--in", bore().path() + "/rows.csv", "--out", offsets});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_SAYS(result.out, "2 probed values in directions that no axis moves: RMS 8.51 um, which stays");
  EXPECT_SAYS(result.out, "2 probed values in those that axes move: RMS 2.55 um");
}

TEST(OneAxis, NcSaysWhatACorrectedProgramLeaves) {
  if (!has_interpreter()) GTEST_SKIP() << "the program was built without LinuxCNC's interpreter";
  const Bore& own = bore();
  own.write("part.ngc", "G21 G90 G54\nM3 S3000\nM8\nG0 X-80\nG1 X80 F500\nG4 P1200\nG1 X-80 F500\nM5\nM9\nM2\n");
  const fs::path out = own.result("nc");
  const Result told = thermotwin({"nc", model(), own.path() + "/part.ngc", "--rewrite", "path", "--out", out.string()});
  ASSERT_EQ(told.status, 0) << told.err;
  const core::Table blocks = core::read_csv(out / "blocks.csv");
  double largest = 0.0;
  for (Eigen::Index i = 0; i < blocks.rows(); ++i) {
    if (blocks.column("rapid")[i] == 0.0)
      largest = std::max(largest, std::hypot(blocks.column("dy_um")[i], blocks.column("dz_um")[i]));
  }
  EXPECT_GT(largest, 1.0);
  EXPECT_NEAR(number_after(told.out, "No axis moves the tool along y (dy) and z (dz): up to "), largest, 0.006);
  EXPECT_SAYS(read(out / "report.html"), "is the corrected program. No axis moves the tool along");
  // The machine has no fluid, and its load program says nothing of one.
  EXPECT_EQ(read(out / "load.toml").find("cutting_fluid = true"), std::string::npos);
}

// Largest of the campaign is `spin`; the last training load is `hall`.
TEST(OneAxis, TheLoadWithTheLargestErrorIsShown) {
  EXPECT_SAYS(read(bore().result("report.html")), "\"first\":0,");
  std::set<std::string> fields;
  for (const auto& entry : fs::directory_iterator(bore().result("fields")))
    if (entry.path().extension() == ".vtu") fields.insert(entry.path().filename().string());
  EXPECT_EQ(fields, std::set<std::string>{"spin.vtu"});
}

TEST(OneAxis, CommandsOfACampaignsPageKeepItsMesh) {
  const Bore own;
  const std::vector<std::string> arguments{"campaign", own.path(), "--load", "spin",         "--size",
                                           "1.25",     "--solver", "direct", "--mesh-order", "1"};
  ASSERT_EQ(own.run(arguments).status, 0);
  const std::string page = read(own.result("campaign/report.html")),
                    mesh = " --size 1.25 --mesh-order 1 --solver direct --out ";
  EXPECT_SAYS(page, "thermotwin reduce " + own.path() + mesh);
  EXPECT_SAYS(page, "thermotwin simulate " + own.path() + " --load spin" + mesh);
  EXPECT_EQ(page.find("not run again"), std::string::npos) << "reduce needs the temperatures of all nodes";
}

TEST(OneAxis, AResumedCampaignSaysWhatBeginsAnew) {
  const Bore own;
  const std::vector<std::string> whole{"campaign", own.path(), "--load", "spin", "hall", "--resume"};
  const Result first = own.run(whole);
  ASSERT_EQ(first.status, 0) << first.err;
  EXPECT_EQ(first.err.find("starts anew"), std::string::npos) << first.err;
  std::vector<std::string> other = whole;
  other.insert(other.end(), {"--size", "1.25"});
  const Result finer = own.run(other);
  ASSERT_EQ(finer.status, 0) << finer.err;
  EXPECT_SAYS(finer.err, "results of spin, hall belong to another machine, mesh, load or options; the run starts anew");
  EXPECT_EQ(own.run(other).err.find("starts anew"), std::string::npos);
  std::ofstream(own.result("campaign/hall/tcp.csv"), std::ios::app) << "\n";
  EXPECT_SAYS(own.run(other).err, "results of hall were changed by hand or are damaged; the run starts anew");
}

TEST(OneAxis, ValidateRefusesBeforeACampaign) {
  const Bore own;
  std::string text = read(own.path() + "/case.toml");
  own.write("case.toml", text.erase(text.find(check_points), check_points.size()));
  const Result result = own.run({"validate", own.path()});
  EXPECT_EQ(result.status, 3);
  EXPECT_SAYS(result.err, "check_points");
  EXPECT_FALSE(fs::exists(own.result("campaign")));
  own.write("case.toml", text + check_points);
  const Result unknown = own.run({"validate", own.path(), "--load", "dya"});
  EXPECT_EQ(unknown.status, 3);
  EXPECT_SAYS(unknown.err, "dya");
  EXPECT_FALSE(fs::exists(own.result("campaign")));
}

TEST(OneAxis, ALoadProgramSwitchesNothingThatTheMachineLacks) {
  const Bore own;
  for (const std::string key : {"coolant", "cutting_fluid"}) {
    own.write("loads/wet.toml", work(3000, 1, key + " = true\n"));
    const Result wet = own.run({"simulate", own.path(), "--load", "wet"});
    EXPECT_EQ(wet.status, 3) << wet.err;
    EXPECT_SAYS(wet.err, "wet.toml:7 phase[1]." + key + ": true");
    EXPECT_SAYS(wet.err, "in machine.toml, which has none");
    own.write("loads/dry.toml", work(3000, 1, key + " = false\n"));
    EXPECT_EQ(own.run({"simulate", own.path(), "--load", "dry"}).status, 0);
  }
}

}  // namespace
}  // namespace thermotwin::cases
