// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/analysis.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "compensation/chain/location_offsets.h"
#include "core/error.h"
#include "core/statistics.h"
#include "core/units.h"

namespace thermotwin::metrology {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
namespace units = core::units;
using units::deg;
using units::um;

using Errors = std::map<std::string, double>;  // m and rad; R0T in m at the radius

const std::string toml = R"toml(schema = 1
chain = "V [w C' B' b Y X Z (C1) t]"
std_um = 0.5
table_radius_mm = 200
axis = [{id = "B", with_letter = true, x_mm = 20, z_mm = -60}, {id = "C", with_letter = true, x_mm = 10, y_mm = -5}]
)toml";

/// Points of one cycle by B and C, the sphere on the table at 200 mm from the C axis, 25 mm above it.
core::Table points_table(const std::vector<std::array<double, 2>>& poses, const std::vector<Errors>& cycles,
                         const Vector3d& drift_um = Vector3d::Zero(), double noise_um = 0.0) {
  core::Table table;
  table.source = "points.csv";
  table.columns = {"time_s", "cycle", "B_deg", "C_deg", "x_mm", "y_mm", "z_mm", "dx_um", "dy_um", "dz_um"};
  table.values.resize(std::ssize(poses) * std::ssize(cycles), 10);
  mesh::KinematicChain chain = mesh::KinematicChain::parse("V [w C' B' b Y X Z (C1) t]", "test");
  chain.find("B")->direction = Vector3d::UnitY();
  chain.find("B")->origin = Vector3d(0.02, 0, -0.06);
  chain.find("C")->direction = Vector3d::UnitZ();
  chain.find("C")->origin = Vector3d(0.01, -0.005, 0);
  compensation::OffsetOptions options;
  options.table_radius = 0.2;
  const compensation::LocationOffsets map(chain, options);
  std::mt19937_64 random(5);
  Index row = 0;
  for (std::size_t i = 0; i < cycles.size(); ++i) {
    for (std::size_t k = 0; k < poses.size(); ++k, ++row) {
      const std::map<std::string, double> at{{"B", poses[k][0] * deg}, {"C", poses[k][1] * deg}};
      const Vector3d nominal = mesh::KinematicChain::frame(chain.table, 1, at) * Vector3d(0.21, -0.005, 0.025);
      Vector3d deviation = drift_um * um * (k / (poses.size() - 1.0) - 0.5);
      for (const auto& [name, value] : cycles[i]) deviation += map.motion_of(name, value, at, nominal).shift;
      for (double& value : deviation) value += noise_um * um * std::sqrt(12.0) * (core::uniform(random) - 0.5);
      table.values.row(row) << 360.0 * i + 10.0 * k, i + 1.0, poses[k][0], poses[k][1], nominal.transpose() / units::mm,
          deviation.transpose() / um;
    }
  }
  return table;
}

const std::vector<std::array<double, 2>> discrete = {{0, 0}, {0, 90}, {0, 180}, {0, 270}, {0, 360}};
std::vector<std::array<double, 2>> grid() {
  std::vector<std::array<double, 2>> poses;
  for (const double b : {-90.0, -45.0, 0.0, 45.0, 90.0})
    for (const double c : {0.0, 60.0, 120.0, 180.0, 240.0, 300.0}) poses.push_back({b, c});
  return poses;
}

const Errors table_errors = {{"X0C", 100 * um},  {"Y0C", -72 * um}, {"Z0T", 43 * um}, {"A0C", 500 * um},
                             {"B0C", -310 * um}, {"C0C", 120 * um}, {"R0T", 66 * um}};

void expect_errors(const RTestAnalysis& found, std::size_t cycle, const Errors& expected) {
  for (std::size_t e = 0; e < found.errors.size(); ++e) {
    const auto at = expected.find(found.errors[e]);
    const double value = at == expected.end() ? 0.0 : at->second;
    EXPECT_NEAR(found.cycles[cycle].value[e] / um, value / um, found.turns(e) ? 0.05 : 0.01) << found.errors[e];
  }
}

// Rigid motions up to 100 um and 500 um/m, and growth, come back within 0.01 um and 0.05 um/m.
TEST(RTestAnalysis, RigidMotionsAndGrowthComeBack) {
  const RTestRecord record = RTestRecord::parse(toml, points_table(discrete, {{}, table_errors}), "rtest.toml");
  EXPECT_EQ(record.errors, (std::vector<std::string>{"X0C", "Y0C", "Z0T", "A0C", "B0C", "C0C", "R0T"}));
  const RTestAnalysis found = analyse(record);
  EXPECT_TRUE(found.not_observable.empty());
  expect_errors(found, 0, {});
  expect_errors(found, 1, table_errors);
  EXPECT_LT(found.cycles[1].residual_rms, 1e-12);
}

// A table whose surface shifts by 4 um against its axis: with one sphere it is taken for a zero angle, with a second
// one on the other side it is not.
TEST(RTestAnalysis, AShiftOfTheTableIsNoZeroAngle) {
  for (const int spheres : {1, 2}) {
    core::Table table = points_table(discrete, {{}, {}});
    const Eigen::MatrixXd one = table.values;
    table.values.resize(spheres * one.rows(), one.cols());
    for (Index i = 0; i < table.values.rows(); ++i) {
      const Index point = i / spheres;
      const double side = i % spheres == 0 ? 1.0 : -1.0, angle = one(point, 3) * deg;
      const Eigen::AngleAxisd turn(angle, Vector3d::UnitZ());
      const Vector3d centre(0.01, -0.005, 0.0), nominal = centre + turn * Vector3d(side * 0.2, 0.0, 0.025);
      const Vector3d shift = one(point, 1) > 1 ? Vector3d(turn * Vector3d(0, -4, 0)) : Vector3d::Zero();
      table.values.row(i) << one(point, 0) + 2.0 * (i % spheres), one(point, 1), 0.0, one(point, 3),
          nominal.transpose() / units::mm, shift.transpose();
    }
    const RTestAnalysis found = analyse(RTestRecord::parse(toml, table, "rtest.toml"));
    expect_errors(found, 1, spheres == 2 ? Errors{} : Errors{{"C0C", 20 * um}});
  }
}

TEST(RTestAnalysis, BothAxesTogetherOnAGrid) {
  Errors errors = table_errors;
  errors["X0B"] = -38 * um;
  errors["Z0B"] = 25 * um;
  errors["A0B"] = 90 * um;
  errors["C0B"] = -140 * um;
  const RTestAnalysis found = analyse(RTestRecord::parse(toml, points_table(grid(), {{}, errors}), "rtest.toml"));
  EXPECT_EQ(found.errors.size(), 11U);
  EXPECT_TRUE(found.not_observable.empty()) << found.not_observable.front();
  expect_errors(found, 1, errors);
}

// A shift along B is one of C as well; the other errors keep their values.
TEST(RTestAnalysis, ErrorsThatThePointsDoNotDistinguishAreNamed) {
  const std::string with = toml + "errors = [\"X0C\", \"Z0T\", \"Y0B\", \"Y0C\", \"A0C\"]\n";
  const Errors errors{{"X0C", 10 * um}, {"Y0C", 20 * um}, {"Z0T", -7 * um}, {"A0C", 50 * um}};
  const RTestAnalysis found = analyse(RTestRecord::parse(with, points_table(grid(), {{}, errors}), "rtest.toml"));
  ASSERT_EQ(found.not_observable.size(), 2U);
  EXPECT_NE(found.not_observable[0].find("Y0B"), std::string::npos);
  EXPECT_NE(found.not_observable[0].find("from Y0C"), std::string::npos) << found.not_observable[0];
  EXPECT_TRUE(std::isnan(found.cycles[1].value[2]) && std::isnan(found.cycles[1].std[3]));
  EXPECT_NEAR(found.cycles[1].value[0] / um, 10.0, 0.01);
  EXPECT_NEAR(found.cycles[1].value[4] / um, 50.0, 0.05);
}

/// Errors of both cycles of a table whose second one has additions by the share of its time, -1/2 to 1/2.
template <class Added>
Eigen::MatrixXd with_added(core::Table table, const std::string& more, const Added& added) {
  const Index count = table.rows() / 2;
  for (Index i = 0; i < count; ++i)
    table.values.row(count + i).tail<3>() += added(count + i, static_cast<double>(i) / (count - 1.0) - 0.5).transpose();
  const RTestAnalysis found = analyse(RTestRecord::parse(toml + more, table, "rtest.toml"));
  return found.cycles[1].value.transpose() / um;
}

// What a place has of its own is no drift: with a deviation of 3 um by cos 2 theta the errors are the same with a drift
// of all points and without.
TEST(RTestAnalysis, WhatAPlaceHasOfItsOwnIsNoDrift) {
  const core::Table table = points_table(discrete, {{}, table_errors});
  const auto own = [&](Index row, double) {
    const double angle = 2.0 * table.values(row, 3) * deg;
    return Vector3d(3.0 * std::cos(angle), -2.0 * std::cos(angle), std::sin(0.5 * angle));
  };
  const auto drifting = [&](Index row, double tau) { return Vector3d(own(row, tau) + tau * Vector3d(8, -5, 6)); };
  const Eigen::MatrixXd still = with_added(table, "drift = \"none\"\n", own);
  EXPECT_LT((with_added(table, "", drifting) - still).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_GT((with_added(table, "drift = \"none\"\n", drifting) - still).cwiseAbs().maxCoeff(), 1.0);
}

// A table that grows and tilts while it is measured, and a drift that slows down: two passes show both.
TEST(RTestAnalysis, TwoPassesShowTheDriftOfErrors) {
  std::vector<std::array<double, 2>> passes;
  for (int i = 0; i < 9; ++i) passes.push_back({0.0, 90.0 * i});
  const core::Table table = points_table(passes, {{}, table_errors});
  const auto added = [&](Index row, double tau) {
    const Vector3d at(table.values(row, 4) - 10.0, table.values(row, 5) + 5.0, table.values(row, 6));  // mm
    const Vector3d turn(0.03, -0.02, 0.01);                                                            // um/mm: 30 um/m
    return Vector3d(tau * (-turn.cross(at) - 0.02 * Vector3d(at[0], at[1], 0.0)) + tau * Vector3d(4, 2, -3) +
                    tau * tau * Vector3d(2, -3, 1));
  };
  const Eigen::MatrixXd without =
      with_added(table, "drift = \"none\"\n", [](Index, double) { return Vector3d(0, 0, 0); });
  EXPECT_LT((with_added(table, "", added) - without).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_GT((with_added(table, "drift = \"none\"\n", added) - without).cwiseAbs().maxCoeff(), 1.0);
}

// There and back, visits at almost mirrored times: what they hardly show of a drift is not estimated from them.
TEST(RTestAnalysis, ThereAndBackCostsNoCertainty) {
  core::Table table =
      points_table({{0, 0}, {0, 90}, {0, 180}, {0, 270}, {0, 180}, {0, 90}, {0, 0}}, {{}, table_errors});
  for (Index i = 0; i < table.rows(); ++i) table.values(i, 0) += 0.2 * std::sin(2.0 * i);
  const RTestAnalysis with = analyse(RTestRecord::parse(toml, table, "rtest.toml")),
                      without = analyse(RTestRecord::parse(toml + "drift = \"none\"\n", table, "rtest.toml"));
  EXPECT_TRUE(with.cycles[1].drift_estimated);
  for (Index e = 0; e < 7; ++e) EXPECT_LT(with.cycles[1].std[e], 1.1 * without.cycles[1].std[e]) << with.errors[e];
}

// A drift of 8 um over the cycle: the repeated point shows it; without the correction it enters the errors.
TEST(RTestAnalysis, RepeatedPointCorrectsTheDrift) {
  const core::Table table = points_table(discrete, {{}, table_errors}, Vector3d(8, -5, 6));
  const RTestAnalysis found = analyse(RTestRecord::parse(toml + "reference = \"absolute\"\n", table, "rtest.toml"));
  expect_errors(found, 1, table_errors);
  EXPECT_TRUE(found.cycles[1].drift_estimated);
  EXPECT_NEAR(found.cycles[1].drift[0] / um, 8.0, 1e-6);
  const RTestAnalysis without =
      analyse(RTestRecord::parse(toml + "reference = \"absolute\"\ndrift = \"none\"\n", table, "rtest.toml"));
  EXPECT_GT(std::abs(without.cycles[1].value[3] - table_errors.at("A0C")) / um, 5.0);
}

// The machine cools while it is measured: an exponential of 10 min and up to 12 um in any direction. The RMS error
// that it adds to the location errors falls by at least 90 % over 20 draws.
TEST(RTestAnalysis, ErrorByDriftFallsOverTwentyDraws) {
  std::mt19937_64 random(11);
  double with = 0.0, without = 0.0;
  for (int draw = 0; draw < 20; ++draw) {
    core::Table table = points_table(discrete, {table_errors});
    for (Index axis = 0; axis < 3; ++axis) {
      const double size = 24.0 * (core::uniform(random) - 0.5), first = 1.0;
      for (Index i = 0; i < table.rows(); ++i)
        table.values(i, 7 + axis) += size * (std::exp(-(table.values(i, 0) - 20.0) / 600.0) - first);
    }
    for (const bool corrected : {true, false}) {
      const RTestAnalysis found = analyse(RTestRecord::parse(
          toml + "reference = \"absolute\"\n" + (corrected ? "" : "drift = \"none\"\n"), table, "rtest.toml"));
      for (std::size_t e = 0; e < found.errors.size(); ++e) {
        const double error = (found.cycles[0].value[e] - table_errors.at(found.errors[e])) / um;
        (corrected ? with : without) += error * error;
      }
    }
  }
  EXPECT_LT(std::sqrt(with / without), 0.10);
  EXPECT_GT(std::sqrt(without / 140.0), 0.2) << "um and um/m: the drift does harm";
}

// The stated uncertainty is the spread of the results: 300 cycles with noise of the stated size.
TEST(RTestAnalysis, StatedUncertaintyIsTheSpread) {
  const std::vector<Errors> cycles(300, table_errors);
  const RTestAnalysis found = analyse(RTestRecord::parse(
      toml + "reference = \"absolute\"\n", points_table(discrete, cycles, Vector3d::Zero(), 0.5), "rtest.toml"));
  int inside = 0;
  for (std::size_t e = 0; e < found.errors.size(); ++e) {
    double squares = 0.0;
    for (const CycleResult& cycle : found.cycles) {
      const double error = cycle.value[e] - table_errors.at(found.errors[e]);
      squares += error * error;
      inside += std::abs(error) <= 2.0 * cycle.std[e] ? 1 : 0;
    }
    EXPECT_NEAR(std::sqrt(squares / 300.0) / found.cycles[0].std[e], 1.0, 0.15) << found.errors[e];
  }
  EXPECT_GT(inside, 0.90 * 300 * 7);
  EXPECT_LT(inside, 0.98 * 300 * 7);
}

TEST(RTestAnalysis, HarmonicsStandBesideLocationErrors) {
  std::vector<std::array<double, 2>> turn;
  for (int i = 0; i < 72; ++i) turn.push_back({30.0, 5.0 * i});
  core::Table table = points_table(turn, {table_errors});
  const double b = 30 * deg;
  for (Index i = 0; i < table.rows(); ++i) {
    const double c = table.values(i, 3) * deg, radial = -3.0 * std::cos(2 * c), axial = -2.0 * std::sin(3 * c);
    table.values(i, 7) += radial * std::cos(b) + axial * std::sin(b);
    table.values(i, 9) += -radial * std::sin(b) + axial * std::cos(b);
  }
  const RTestAnalysis found =
      analyse(RTestRecord::parse(toml + "reference = \"absolute\"\nharmonics = 3\n", table, "rtest.toml"));
  expect_errors(found, 0, table_errors);
  ASSERT_EQ(found.cycles[0].harmonics.size(), 2U);
  EXPECT_NEAR(found.cycles[0].harmonics[0].cosine[0] / um, 3.0, 1e-6);
  EXPECT_NEAR(found.cycles[0].harmonics[1].sine[2] / um, 2.0, 1e-6);
  EXPECT_NEAR(found.cycles[0].harmonics[1].cosine.norm() / um, 0.0, 1e-6);
}

// 000, (4.13) and (4.14) beside rigid motion: with the points +y, +x, -y, -x as 1 to 4, C0C is 0 for any turn and R0T
// is right; with +y, -x, -y, +x, R0T is 0 for any growth.
TEST(RTestAnalysis, PrintedFormulasFitNoCommonNumbering) {
  const auto printed = [](const std::array<Vector3d, 4>& p, const auto& moved, double& c0c, double& r0t) {
    std::array<Vector3d, 4> d;
    for (int i = 0; i < 4; ++i) d[i] = moved(p[i]);
    c0c = (d[2][0] + d[3][1] - d[0][0] - d[1][1]) / (2 * 0.4);
    r0t = 0.25 * (d[0][1] + d[1][0] - d[2][1] - d[3][0]);
  };
  const Vector3d x(0.2, 0, 0), y(0, 0.2, 0);
  const auto turned = [](const Vector3d& p) { return Vector3d(50 * um * Vector3d::UnitZ().cross(p)); };
  const auto grown = [](const Vector3d& p) { return Vector3d(p / 0.2 * 10 * um); };
  double c0c = 0, r0t = 0;
  printed({y, x, -y, -x}, turned, c0c, r0t);
  EXPECT_NEAR(c0c, 0.0, 1e-15) << "no turn is seen";
  printed({y, x, -y, -x}, grown, c0c, r0t);
  EXPECT_NEAR(r0t / um, 10.0, 1e-9);
  printed({y, -x, -y, x}, turned, c0c, r0t);
  EXPECT_NEAR(c0c / um, 50.0, 1e-9);
  printed({y, -x, -y, x}, grown, c0c, r0t);
  EXPECT_NEAR(r0t, 0.0, 1e-15) << "no growth is seen";
}

TEST(RTestAnalysis, SlipsInARecordAreNamed) {
  const auto refused = [](const std::string& text, const core::Table& table, const std::vector<std::string>& words) {
    try {
      analyse(RTestRecord::parse(text, table, "rtest.toml"));
      ADD_FAILURE() << "accepted: " << words.front();
    } catch (const core::InputError& error) {
      for (const std::string& word : words)
        EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << word << " in: " << error.what();
    }
  };
  const core::Table good = points_table(discrete, {{}, table_errors});
  core::Table table = good;
  table.values(3, 8) = std::nan("");
  refused(toml, table, {"points.csv:5 dy_um", "a missing point"});
  table = good;
  table.values(4, 0) = 1.0;
  refused(toml, table, {"points.csv:6", "time_s"});
  table = good;
  table.values(7, 1) = 1.0;
  refused(toml, table, {"points.csv:9 cycle", "rising order"});
  table = good;
  table.columns[3] = "D_deg";
  refused(toml, table, {"points.csv:1 column 4", "'D_deg'", "nearest: "});
  refused(toml, points_table({{0, 0}, {0, 90}}, {table_errors}),
          {"cycle 1", "2 points for 7 parameters", "at least 3"});
  refused(toml + "errors = [\"X0A\"]\n", good, {"'X0A'", "nearest: X0"});
  refused(toml + "errors = [\"X0C\", \"X0C\"]\n", good, {"'X0C' a second time"});
  refused(toml + "errors = [\"X0B\", \"X0C\"]\n", good, {"no observable error", "from X0C"});
  refused(toml, points_table({{0, 0}, {0, 0}, {0, 0}}, {table_errors}), {"no rotary axis that moves"});
}

}  // namespace
}  // namespace thermotwin::metrology
