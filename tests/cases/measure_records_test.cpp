// SPDX-License-Identifier: GPL-3.0-or-later
// `measure analyse` on records of a volumetric grid, of probes around a mandrel and of a table's surface: known errors
// come back, `evaluate` reads the result, slips leave nothing behind. `measure simulate` writes the same records.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>
#include <functional>

#include "core/table.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json analyse(const Toy& toy, const std::string& folder, const std::vector<std::string>& more = {}) {
  std::vector<std::string> words{"measure", "analyse", toy.file(folder), "--json"};
  words.insert(words.end(), more.begin(), more.end());
  const Result result = toy.run(words);
  EXPECT_EQ(result.status, 0) << result.err;
  return result.status == 0 ? json::parse(result.out) : json();
}

double value_of(const json& found, const std::string& error) {
  return found["cycles"].back()["errors"][error]["value"].get<double>();
}

/// Refused, and nothing of it is left. @param words  that the message has
void expect_refused(const Toy& toy, const std::string& folder, const std::vector<std::string>& words) {
  const Result result = toy.run({"measure", "analyse", toy.file(folder)});
  EXPECT_EQ(result.status, 3) << result.out;
  for (const std::string& word : words) EXPECT_SAYS(result.err, word.c_str());
  EXPECT_FALSE(fs::exists(toy.result("analysis.json")));
  EXPECT_FALSE(fs::exists(toy.result("measurement")));
}

constexpr const char* grid_head = "schema = 1\nchain = \"V [w C' B' b Y X Z (C1) t]\"\nstd_um = 0.5\n";

/// Deviations at 27 positions and the first again, in um for mm, by hand; each cycle is worse by the same: the table
/// shifts by 30 um in x and tilts by 400 um/m about x, X grows by 100 um/m, Y by -50 um/m, X is out of square to
/// Y by 500 um/m, Z to X by -200 um/m, and the X slide pitches by 300 um/m a metre. On a cycle of 270 s lies a drift of
/// 9 um in z.
std::string grid_points(const std::function<std::string(int, int, const std::string&)>& change) {
  std::string text = "time_s,cycle,X_mm,Y_mm,Z_mm,x_mm,y_mm,z_mm,dx_um,dy_um,dz_um\n";
  for (int cycle = 0; cycle < 3; ++cycle) {
    for (int i = 0; i < 28; ++i) {
      const int n = i % 27;
      const double x = 250.0 * (n % 3 - 1), y = 180.0 * (n / 3 % 3 - 1), z = 100.0 + 150.0 * (n / 9);
      const double worse = cycle, drift = cycle > 0 ? 9.0 * (i - 13.5) / 27.0 : 0.0;
      const double pitch = 300e-3 * x * 1e-3;  // um per mm
      const double dx = worse * (-30.0 + 0.1 * x + -200e-3 * z + pitch * z);
      const double dy = worse * (400e-3 * z - 50e-3 * y + 500e-3 * x);
      const double dz = worse * (-400e-3 * y - pitch * x) + drift;
      text += change(cycle, i,
                     fmt::format("{},{},{},{},{},{},{},{},{:.9f},{:.9f},{:.9f}", 3600 * cycle + 10 * i, cycle + 1, x, y,
                                 z, x, y, z, dx, dy, dz)) +
              "\n";
    }
  }
  return text;
}

std::string as_it_is(int, int, const std::string& row) { return row; }

TEST(MeasureRecords, GridErrorsComeBack) {
  const Toy toy;
  toy.write("grid/grid.toml", grid_head);
  toy.write("grid/points.csv", grid_points(as_it_is));
  const json chosen = analyse(toy, "grid");
  toy.write("grid/grid.toml",
            std::string(grid_head) +
                "errors = ['X0T', 'Y0T', 'Z0T', 'A0T', 'B0T', 'C0T', 'EXX1', 'EYY1', 'EZZ1', 'C0X', 'B0Z', 'EBX1']\n");
  const json stated = analyse(toy, "grid");
  for (const json* found : {&chosen, &stated}) {
    const std::vector<std::pair<const char*, double>> known{{"X0T", 60}, {"Y0T", 0},    {"A0T", 800},   {"B0T", 0},
                                                            {"C0T", 0},  {"EXX1", 200}, {"EYY1", -100}, {"C0X", 1000}};
    for (const auto& [error, value] : known)
      EXPECT_NEAR(value_of(*found, error), value, error[1] == '0' && error[0] > 'C' ? 0.01 : 0.05) << error;
    EXPECT_NEAR(value_of(*found, "EBX1"), 600.0, 0.2);
    EXPECT_TRUE((*found)["not_observable"].empty());
    EXPECT_NEAR((*found)["cycles"][1]["drift_um"][2].get<double>(), 9.0, 0.01);
    EXPECT_LT((*found)["cycles"][2]["residual_rms_um"].get<double>(), 1e-4);
  }
  EXPECT_NEAR(value_of(stated, "B0Z"), -400.0, 0.05);
  EXPECT_EQ(core::read_csv(toy.result("residuals.csv")).rows(), 84);
  for (const char* picture : {"residuals.svg", "errors.svg"}) EXPECT_TRUE(fs::exists(toy.result(picture))) << picture;
  // The folder has the deviations themselves, at 27 poses.
  const core::Table data = core::read_csv(toy.result("measurement") / "data.csv");
  EXPECT_EQ(data.columns.size(), 1u + 3u * 27u);
}

TEST(MeasureRecords, AResidualTellsOfOtherErrors) {
  const Toy toy;
  toy.write("grid/grid.toml", std::string(grid_head) + "errors = ['X0T', 'Y0T', 'Z0T']\n");
  toy.write("grid/points.csv", grid_points(as_it_is));
  const Result result = toy.run({"measure", "analyse", toy.file("grid")});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_SAYS(result.out, "times the stated uncertainty");
}

TEST(MeasureRecords, GridSlipsLeaveNothingBehind) {
  const Toy toy;
  toy.write("grid/grid.toml", grid_head);
  toy.write("grid/points.csv", grid_points([](int cycle, int i, const std::string& row) {
              return cycle == 1 && i == 5 ? row.substr(0, row.rfind(',') + 1) : row;
            }));
  expect_refused(toy, "grid", {"points.csv:35", "dz_um", "a missing point", "leave out the row"});
  toy.write("grid/points.csv", grid_points([](int cycle, int i, const std::string& row) {
              return cycle == 1 && i == 5 ? "7" + row.substr(row.find(',')) : row;
            }));
  expect_refused(toy, "grid", {"points.csv:35", "time_s"});
  toy.write("grid/points.csv", grid_points(as_it_is));
  toy.write("grid/grid.toml", std::string(grid_head) + "errors = ['EXX9']\n");
  expect_refused(toy, "grid", {"grid.toml", "'EXX9'", "nearest: EXX"});
  toy.write("grid/grid.toml", std::string(grid_head) + "errors = ['C0Y', 'C0T']\n");
  expect_refused(toy, "grid", {"grid.toml", "do not distinguish", "distinguish at least one error"});
  toy.write("grid/rtest.toml", grid_head);
  expect_refused(toy, "grid", {"rtest.toml", "grid.toml", "a folder with one of"});
}

void write_mandrel(const Toy& toy, const std::string& more = "", const std::string& bad_row = "") {
  std::string text = "schema = 1\npoint_mm = [0, 0, -20]\n" + more;
  const struct {
    const char* id;
    double z;
    const char* direction;
  } probes[] = {{"X1", 80, "1, 0, 0"},
                {"X2", -20, "1, 0, 0"},
                {"Y1", 80, "0, 1, 0"},
                {"Y2", -20, "0, 1, 0"},
                {"Z1", -20, "0, 0, 1"}};
  for (const auto& probe : probes) {
    text += fmt::format("[[probe]]\nid = '{}'\nat_mm = [0, 0, {}]\ndirection = [{}]\nstd_um = 0.2\n", probe.id, probe.z,
                        probe.direction);
  }
  toy.write("mandrel/mandrel.toml", text);
  std::string readings = "time_s,X1_um,X2_um,Y1_um,Y2_um,Z1_um\n";
  for (int i = 0; i < 40; ++i) {
    // At the functional point 100, -60 and 80 um; turns of -500 and 300 um/m about x and y; all in 40 rows.
    const double share = i / 39.0, level = 0.1;
    readings += fmt::format("{},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f}\n", 300 * i, 5 + share * (100 + 300 * level),
                            share * 100, 2 + share * (-60 + 500 * level), share * -60, share * 80);
  }
  toy.write("mandrel/readings.csv", readings + bad_row);
}

TEST(MeasureRecords, MandrelBecomesAFolderThatEvaluateReads) {
  const Toy toy;
  write_mandrel(toy);
  std::string loads = "time_s,n,air\n";
  for (int i = 0; i < 60; ++i) loads += fmt::format("{},{},21\n", 200 * i, i < 30 ? 3000 : 0);
  toy.write("loads/data.csv", loads);
  toy.write("loads/channels.toml",
            "[[channel]]\nid = 'n'\nkind = 'speed'\nunit = 'rpm'\n[[channel]]\nid = 'air'\nkind = "
            "'temperature'\nunit = 'degC'\nuncertainty = 0.1\n");
  const json found = analyse(toy, "mandrel", {"--record", toy.file("loads")});
  const std::vector<std::pair<const char*, double>> known{
      {"dx", 100}, {"dy", -60}, {"dz", 80}, {"ra", -500}, {"rb", 300}};
  for (const auto& [quantity, value] : known)
    EXPECT_NEAR(value_of(found, quantity), value, quantity[0] == 'd' ? 0.01 : 0.05) << quantity;
  ASSERT_EQ(found["not_observable"].size(), 1u);
  EXPECT_SAYS(found["not_observable"][0].get<std::string>().c_str(), "rc: not observable");
  EXPECT_TRUE(fs::exists(toy.result("displacements.svg")));
  const Result evaluated = thermotwin({"evaluate", "--data", toy.result("measurement").string(), "--out",
                                       toy.result("e").string(), "--models", "static_regression", "--json", "--quiet"});
  EXPECT_EQ(evaluated.status, 0) << evaluated.err;
}

TEST(MeasureRecords, MandrelSlipsLeaveNothingBehind) {
  const Toy toy;
  write_mandrel(toy, "", "12000,1,,3,4,5\n");
  expect_refused(toy, "mandrel", {"readings.csv:42 X2_um", "a missing reading"});
  write_mandrel(toy, "", "11000,1,2,3,4,5\n");
  expect_refused(toy, "mandrel", {"readings.csv:42", "time_s"});
  write_mandrel(toy, "quantities = ['dx', 'rc']\n");
  expect_refused(toy, "mandrel", {"mandrel.toml:3", "singular arrangement", "rc"});
  write_mandrel(toy, "pose = 'B equals 0'\n");
  expect_refused(toy, "mandrel", {"mandrel.toml:3", "'B equals 0'", "X=0,B=90"});
}

/// Heights on a centre and two circles of a disc of 300 mm, each cycle worse by: 40 um up, a tilt of 200 um/m about x
/// and -500 about y, a rim 25 um above the centre, and up by 12 um along x where it is down along y.
std::string heights(int spokes, double far_y = 1.0) {
  std::string text = "time_s,cycle,x_mm,y_mm,height_um\n";
  for (int cycle = 0; cycle < 3; ++cycle) {
    int time = 3600 * cycle;
    for (const double r : {0.0, 150.0, 300.0}) {
      for (int k = 0; k < (r > 0 ? spokes : 1); ++k) {
        const double phi = 2 * 3.14159265358979323846 * k / spokes, x = r * std::cos(phi),
                     y = far_y * r * std::sin(phi);
        const double square = (x * x + y * y) / 9e4;
        const double height = 40 + 0.2 * y + 0.5 * x + 25 * (square - 0.5) + 12 * (x * x - y * y) / 9e4;
        text += fmt::format("{},{},{:.9f},{:.9f},{:.9f}\n", time += 10, cycle + 1, x, y, 7 + cycle * height);
      }
    }
  }
  return text;
}

TEST(MeasureRecords, SurfaceModesComeBackWithAMap) {
  const Toy toy;
  toy.write("surface/surface.toml", "schema = 1\nradius_mm = 300\nstd_um = 0.5\norder = 3\npose = 'B=0,C=0'\n");
  toy.write("surface/points.csv", heights(12));
  const json found = analyse(toy, "surface");
  const std::vector<std::pair<const char*, double>> known{{"Z0T", 80},   {"A0T", 400},    {"B0T", -1000},
                                                          {"dome", 50},  {"saddle", 24},  {"twist", 0},
                                                          {"coma_x", 0}, {"trefoil_y", 0}};
  for (const auto& [mode, value] : known)
    EXPECT_NEAR(value_of(found, mode), value, mode[1] == '0' && mode[0] != 'Z' ? 0.05 : 0.01) << mode;
  const core::Table map = core::read_csv(toy.result("map.csv"));
  const Eigen::VectorXd x = map.column("x_mm"), y = map.column("y_mm"), height = map.column("height_um"),
                        bending = map.column("bending_um"), cycle = map.column("cycle");
  int seen = 0;
  for (Eigen::Index i = 0; i < map.rows(); ++i) {
    if (cycle[i] != 3 || std::abs(x[i] - 150) > 1e-6 || std::abs(y[i] + 60) > 1e-6) continue;
    ++seen;
    const double bent = 50 * ((22500 + 3600) / 9e4 - 0.5) + 24 * (22500 - 3600) / 9e4;
    EXPECT_NEAR(bending[i], bent, 0.01);
    EXPECT_NEAR(height[i], 80 + 0.4 * -60 + 1.0 * 150 + bent, 0.01);
  }
  EXPECT_EQ(seen, 1);
  EXPECT_TRUE(fs::exists(toy.result("map.svg")));
  EXPECT_LT(core::read_csv(toy.result("residuals.csv")).column("residual_um").cwiseAbs().maxCoeff(), 1e-4);
  EXPECT_EQ(core::read_csv(toy.result("measurement") / "data.csv").columns,
            (std::vector<std::string>{"time_s", "Z0T", "A0T", "B0T"}));
}

TEST(MeasureRecords, SurfaceSlipsLeaveNothingBehind) {
  const Toy toy;
  const std::string head = "schema = 1\nradius_mm = 300\nstd_um = 0.5\n";
  toy.write("surface/surface.toml", head);
  toy.write("surface/points.csv", heights(12) + "9000,3,0,0,\n");
  expect_refused(toy, "surface", {"points.csv:77 height_um", "a missing point"});
  toy.write("surface/points.csv", heights(12) + "10,3,0,0,1\n");
  expect_refused(toy, "surface", {"points.csv:77", "time_s"});
  toy.write("surface/points.csv", heights(12, 0.0));
  expect_refused(toy, "surface", {"points.csv cycle 1", "on a line", "span the surface"});
  toy.write("surface/points.csv", heights(2));
  expect_refused(toy, "surface", {"points.csv cycle 1", "5 points for 6 modes"});
  toy.write("surface/surface.toml", "schema = 1\nradius_mm = 200\nstd_um = 0.5\n");
  toy.write("surface/points.csv", heights(12));
  expect_refused(toy, "surface", {"points.csv:15", "300 mm", "radius_mm = 200"});
}

/// @param more  options of the plan
void plan_and_simulate(const Toy& toy, const std::string& kind, const std::vector<std::string>& planned,
                       const std::vector<std::string>& simulated, const std::string& out) {
  std::vector<std::string> words{"measure",        "plan",    kind,        "--case", toy.path(),    "--out",
                                 toy.file("plan"), "--quiet", "--warm-up", "0.34",   "--cool-down", "0",
                                 "--interval",     "10"};
  words.insert(words.end(), planned.begin(), planned.end());
  const Result plan = thermotwin(words);
  ASSERT_EQ(plan.status, 0) << plan.err;
  words = {"measure", "simulate",    toy.file("plan"), "--case",         toy.path(), "--quiet",
           "--out",   toy.file(out), "--no-noise",     "--machine-seed", "2"};
  words.insert(words.end(), simulated.begin(), simulated.end());
  const Result result = thermotwin(words);
  ASSERT_EQ(result.status, 0) << result.err;
}

TEST(MeasureRecords, KnownErrorsOfASimulatedGridComeBack) {
  const Toy toy;
  plan_and_simulate(toy, "volumetric_grid", {"--load", "spindle", "--speed", "9000"}, {}, "own");
  plan_and_simulate(toy, "volumetric_grid", {"--load", "spindle", "--speed", "9000"},
                    {"--add", "X0T=100", "--add", "EYY1=300", "--add", "B0Z=-500", "--add", "A0T=120"}, "worse");
  const json own = analyse(toy, "own"), worse = analyse(toy, "worse");
  const std::vector<std::pair<const char*, double>> known{{"X0T", 100},  {"Y0T", 0},  {"Z0T", 0},
                                                          {"A0T", 120},  {"B0T", 0},  {"C0T", 0},
                                                          {"EYY1", 300}, {"EXX1", 0}, {"B0Z", -500}};
  for (const auto& [error, value] : known) {
    const bool length = error[1] == '0' && error[0] > 'C';
    EXPECT_NEAR(value_of(worse, error) - value_of(own, error), value, length ? 0.01 : 0.05) << error;
  }
  EXPECT_EQ(thermotwin({"measure", "simulate", toy.file("plan"), "--case", toy.path(), "--add", "X0T", "--out",
                        toy.file("none")})
                .status,
            3);
  EXPECT_FALSE(fs::exists(toy.file("none")));
}

TEST(MeasureRecords, SimulatedMandrelAndSurface) {
  const Toy toy;
  plan_and_simulate(toy, "spindle", {"--speed", "9000"}, {"--surface"}, "record");
  const core::Table data = core::read_csv(toy.file("record") + "/data.csv");
  const json mandrel = analyse(toy, "record/mandrel");
  for (const char* quantity : {"dx", "dy", "dz", "ra", "rb"}) {
    const Eigen::VectorXd column = data.column(std::string(quantity) + "@1");
    double first = std::nan(""), last = first;
    for (const double value : column) {
      if (std::isnan(value)) continue;
      if (std::isnan(first)) first = value;
      last = value;
    }
    EXPECT_NEAR(value_of(mandrel, quantity), last - first, quantity[0] == 'd' ? 0.01 : 0.05) << quantity;
  }
  EXPECT_GT(std::abs(value_of(mandrel, "dz")), 1.0);
  const json surface = analyse(toy, "record/surface");
  EXPECT_EQ(surface["cycles"].size(), 3u);
}

TEST(MeasureRecords, TheSimulatedSurfaceIsThatOfTheTable) {
  const Toy toy;
  plan_and_simulate(toy, "rtest", {"--radius", "35", "--height", "60", "--clearance", "10"}, {"--surface"}, "record");
  const json surface = analyse(toy, "record/surface");
  const core::Table own = core::read_csv(toy.file("record") + "/functionals.csv");
  const Eigen::VectorXd z = own.column("Z0T_um"), a = own.column("A0C_um_per_m");
  // Its plane is the mean motion of the surface, that of the model an average over its area.
  EXPECT_NEAR(value_of(surface, "Z0T"), z[z.size() - 1] - z[0], 0.3);
  EXPECT_GT(std::abs(value_of(surface, "dome")), 0.01);
}

}  // namespace
}  // namespace thermotwin::cases
