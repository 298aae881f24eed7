// SPDX-License-Identifier: GPL-3.0-or-later
// `measure analyse` on an R-Test of a table that turns against its letter (C'): circle, harmonics and least squares
// have one frame, and nominal places that contradict the axis positions are named. The motions are worked out by hand
// here.
#include <Eigen/Geometry>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "core/units.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

using Eigen::Vector3d;

using core::units::deg;

/// A row of points.csv.
struct Point {
  double C_deg;
  Vector3d place_mm, deviation_um;
};

/// The C axis is at x = 2 mm, y = -3 mm. Its errors: 8 and -5 um, 20 and -15 um/m; the table rises by 4 um.
Vector3d motion_um(const Vector3d& place_mm) {
  const Vector3d arm = place_mm - Vector3d(2, -3, 0);
  return Vector3d(8, -5, 4) + 1e-3 * Vector3d(20, -15, 0).cross(arm);
}

class MeasureRTest : public testing::Test {
protected:
  /// Two cycles of a turn, the second one with what `motion` says that the table does.
  void write(int points, const std::function<Vector3d(const Point&)>& motion, const std::string& more = "",
             const std::function<void(Point&)>& slip = {}) const {
    toy.write("rtest/rtest.toml",
              "schema = 1\nchain = \"V [w C' B' b Y X Z (C1) t]\"\nstd_um = 0.5\nreference = \"absolute\"\ndrift = "
              "\"none\"\nerrors = ['X0C', 'Y0C', 'Z0T', 'A0C', 'B0C']\naxis = [{id = \"C\", x_mm = 2, y_mm = -3}]\n" +
                  more);
    std::string text = "time_s,cycle,C_deg,x_mm,y_mm,z_mm,dx_um,dy_um,dz_um\n";
    for (int cycle = 0; cycle < 2; ++cycle) {
      for (int i = 0; i < points; ++i) {
        Point point;
        point.C_deg = 360.0 * i / points;
        const double turn = -point.C_deg * deg;  // the workpiece turns against the letter
        point.place_mm = Vector3d(2.0 + 150.0 * std::cos(turn), -3.0 + 150.0 * std::sin(turn), 120.0);
        point.deviation_um = cycle == 0 ? Vector3d(0, 0, 0) : Vector3d(-motion(point));
        if (slip) slip(point);
        text += fmt::format("{},{},{:.9f}", 1000 * cycle + i, cycle + 1, point.C_deg);
        for (const double value : point.place_mm) text += fmt::format(",{:.9f}", value);
        for (const double value : point.deviation_um) text += fmt::format(",{:.9f}", value);
        text += "\n";
      }
    }
    toy.write("rtest/points.csv", text);
  }
  Result analyse(const std::vector<std::string>& more = {"--json"}) const {
    std::vector<std::string> words{"measure", "analyse", toy.file("rtest")};
    words.insert(words.end(), more.begin(), more.end());
    Result result = toy.run(words);
    EXPECT_EQ(result.status, 0) << result.err;
    return result;
  }
  static Vector3d of_axis(const Point& point) { return motion_um(point.place_mm); }
  Toy toy;
};

TEST_F(MeasureRTest, CircleAndLeastSquaresHaveOneFrame) {
  write(200, of_axis);
  const nlohmann::json found = nlohmann::json::parse(analyse().out);
  const std::vector<std::string> names{"X0C", "Y0C", "A0C", "B0C"};
  EXPECT_EQ(found["arcs"]["names"], nlohmann::json(names));
  const std::vector<double> known{8, -5, 20, -15};
  for (const char* method : {"kasa", "taubin", "geometric"}) {
    const nlohmann::json fit = found["arcs"][method][1];
    for (std::size_t i = 0; i < 4; ++i) {
      const nlohmann::json& value = i < 2 ? fit["centre_um"][i] : fit["tilt_um_per_m"][i - 2];
      EXPECT_NEAR(value.get<double>(), known[i], 0.02) << method << names[i];
      EXPECT_NEAR(found["cycles"][1]["errors"][names[i]]["value"].get<double>(), known[i], 0.02) << names[i];
    }
    EXPECT_NEAR(fit["along_um"].get<double>() - found["arcs"][method][0]["along_um"].get<double>(), 4.0, 0.01);
    EXPECT_NEAR(fit["along_um"].get<double>(), 120004.0, 0.01);
  }
  EXPECT_SAYS(analyse({}).out, "circle and plane of cycle 2: X0C 8.00 um, Y0C -5.00 um, A0C 20.00 um/m, B0C -15.00");
}

// Harmonics are motions of what the axis carries, as its location errors are.
TEST_F(MeasureRTest, HarmonicsHaveTheSignOfLocationErrors) {
  write(
      24,
      [](const Point& point) {
        const double angle = 2.0 * point.C_deg * deg;
        return Vector3d(of_axis(point) + Vector3d(3.0 * std::cos(angle), 0.7 * std::sin(angle), 0.0));
      },
      "harmonics = 2\n");
  const nlohmann::json cycle = nlohmann::json::parse(analyse().out)["cycles"][1];
  EXPECT_NEAR(cycle["errors"]["X0C"]["value"].get<double>(), 8.0, 1e-6);
  EXPECT_EQ(cycle["harmonics"][0]["order"], 2);
  EXPECT_NEAR(cycle["harmonics"][0]["cos_um"][0].get<double>(), 3.0, 1e-6);
  EXPECT_NEAR(cycle["harmonics"][0]["sin_um"][1].get<double>(), 0.7, 1e-6);
}

TEST_F(MeasureRTest, PlacesThatContradictTheAxesAreNamed) {
  write(6, of_axis);
  const Result good = analyse();
  EXPECT_EQ(nlohmann::json::parse(good.out)["places_on_table"], 1);
  EXPECT_EQ(good.err.find("warning"), std::string::npos) << good.err;
  EXPECT_SAYS(analyse({}).out, "the points mean 1 place of the sphere on the table");
  struct Case {
    std::function<void(Point&)> slip;
    const char* says;
  };
  for (const Case& one : {Case{[](Point& point) { point.C_deg = -point.C_deg; }, "with the sign of C reversed"},
                          {[](Point& point) { point.C_deg *= deg; }, "with C in rad they mean 1;"},
                          {[](Point& point) { point.place_mm *= 1e-3; }, "change by 0.3"},
                          {[](Point& point) { point.place_mm = Vector3d(152, -3, 120 + 0.1 * point.C_deg); },
                           "6 points mean 6 places"}}) {
    write(6, of_axis, "", one.slip);
    const Result result = analyse();
    EXPECT_SAYS(result.err, "warning: ");
    EXPECT_SAYS(result.err, one.says);
  }
  // An axis that carries the tool turns about a sphere that stands.
  const std::string tool_side = "schema = 1\nchain = \"V [w b X Y Z C t]\"\nstd_um = 0.5\nerrors = ['X0C', 'Y0C']\n";
  toy.write("rtest/rtest.toml", tool_side);
  toy.write("rtest/points.csv",
            "time_s,cycle,C_deg,x_mm,y_mm,z_mm,dx_um,dy_um,dz_um\n0,1,0,9,9,9,0,0,0\n1,1,90,9,9,9,0,0,0\n"
            "2,1,180,9,9,9,1,0,0\n");
  const Result standing = analyse();
  EXPECT_EQ(nlohmann::json::parse(standing.out)["places_on_table"], 1);
  EXPECT_EQ(standing.err.find("warning"), std::string::npos) << standing.err;
  // Two spheres on opposite sides are no contradiction.
  write(6, of_axis, "", [](Point& point) {
    const int i = static_cast<int>(std::lround(point.C_deg / 60.0));
    if (i % 2 == 1) point.place_mm.head<2>() = Eigen::Vector2d(4, -6) - point.place_mm.head<2>();
  });
  const Result two = analyse();
  EXPECT_EQ(nlohmann::json::parse(two.out)["places_on_table"], 2);
  EXPECT_EQ(two.err.find("warning"), std::string::npos) << two.err;
}

// The first cycle, the reference, ends before its repeated point; U of the table is the largest.
TEST_F(MeasureRTest, CyclesWithoutARepeatedPointAreNamed) {
  const std::string head =
      "schema = 1\nchain = \"V [w C' B' b Y X Z (C1) t]\"\nstd_um = 0.5\nerrors = ['X0C', 'Y0C', 'Z0T']\n";
  const auto rows = [](int cycle, int points) {
    std::string text;
    for (int i = 0; i < points; ++i) {
      const double turn = -90.0 * i * deg;
      text += fmt::format("{},{},{},{:.9f},{:.9f},50,{},0,0\n", 1000 * cycle + 10 * i, cycle, 90 * i,
                          200.0 * std::cos(turn), 200.0 * std::sin(turn), 2 * i);
    }
    return text;
  };
  const std::string columns = "time_s,cycle,C_deg,x_mm,y_mm,z_mm,dx_um,dy_um,dz_um\n";
  toy.write("rtest/rtest.toml", head);
  toy.write("rtest/points.csv", columns + rows(1, 4) + rows(2, 5) + rows(3, 4) + rows(4, 4));
  const Result mixed = analyse({});
  EXPECT_SAYS(mixed.out, "cycles 1, 3 to 4 of 4 repeat no point: drift is not corrected there, and U has that of the");
  EXPECT_SAYS(mixed.out, "cycle 1 is the reference");
  toy.write("rtest/points.csv", columns + rows(1, 4));
  EXPECT_SAYS(analyse({}).out, "no cycle repeats a point");
  EXPECT_SAYS(analyse({}).out, "one cycle: there is none to compare it with; the errors are absolute");
}

}  // namespace
}  // namespace thermotwin::cases
