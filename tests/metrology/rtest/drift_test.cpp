// SPDX-License-Identifier: GPL-3.0-or-later
// Repeated points of an R-Test: encoder jitter, sweeps, cycles without one, a cycle alone, points of a long sweep.
#include "metrology/rtest/drift.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "compensation/chain/location_offsets.h"
#include "core/units.h"
#include "metrology/rtest/analysis.h"
#include "metrology/rtest/test_points.h"

namespace thermotwin::metrology {
namespace {

using core::units::deg;
using core::units::um;
using Eigen::Index;
using Eigen::Vector3d;

const std::map<std::string, double> known = {{"X0C", 100 * um},  {"Y0C", -72 * um}, {"Z0T", 43 * um}, {"A0C", 500 * um},
                                             {"B0C", -310 * um}, {"C0C", 120 * um}, {"R0T", 66 * um}};

/// Cycles at positions of C with the known errors and a drift of 8, -5 and 6 um over each.
RTestRecord turned(const std::vector<std::vector<double>>& cycles, bool against_first, double drift = 1.0) {
  RTestRecord record;
  record.source = "rtest.toml";
  record.chain = mesh::KinematicChain::parse("V [w C' B' b Y X Z (C1) t]", "test");
  record.chain.find("C")->direction = Vector3d::UnitZ();
  record.chain.find("C")->origin = Vector3d(0.01, -0.005, 0);
  for (const auto& [name, value] : known) record.errors.push_back(name);
  record.std = 0.5 * um;
  record.against_first = against_first;
  compensation::OffsetOptions options;
  options.table_radius = record.table_radius;
  const compensation::LocationOffsets map(record.chain, options);
  for (const std::vector<double>& angles : cycles) {
    RTestCycle cycle;
    cycle.place = "cycle";
    for (std::size_t i = 0; i < angles.size(); ++i) {
      RTestPoint point;
      point.time = 360.0 * std::ssize(record.cycles) + 10.0 * i;
      point.positions = {{"B", 0.0}, {"C", angles[i] * deg}};
      point.nominal =
          mesh::KinematicChain::frame(record.chain.table, 1, point.positions) * Vector3d(0.21, -0.005, 0.025);
      point.deviation = drift * um * Vector3d(8, -5, 6) * (i / (angles.size() - 1.0) - 0.5);
      for (const auto& [name, value] : known)
        point.deviation += map.motion_of(name, value, point.positions, point.nominal).shift;
      cycle.points.push_back(point);
    }
    record.cycles.push_back(cycle);
  }
  return record;
}

const std::vector<double> whole{0, 90, 180, 270, 360}, without{0, 90, 180, 270};

void expect_known(const RTestAnalysis& found, std::size_t cycle) {
  for (std::size_t e = 0; e < found.errors.size(); ++e)
    EXPECT_NEAR(found.cycles[cycle].value[e] / um, known.at(found.errors[e]) / um, found.turns(e) ? 0.05 : 0.01)
        << found.errors[e];
}

// Visits up to 0.4 deg apart are visits of one place; what the errors differ between them is no drift.
TEST(RTestDrift, JitterHidesNoRepeatedPoint) {
  const RTestAnalysis found = analyse(turned({{0, 90, 180, 270, 360},
                                              {0.02, 90.1, 179.9, 270.1, 360.0001},
                                              {0.1, 89.9, 180.2, 270, 359.8},
                                              {-0.2, 90, 180, 270, 360.2}},
                                             false));
  for (std::size_t cycle = 0; cycle < 4; ++cycle) {
    EXPECT_TRUE(found.cycles[cycle].drift_estimated) << cycle;
    EXPECT_NEAR(found.cycles[cycle].drift[0] / um, 8.0, 0.01);
    expect_known(found, cycle);
  }
}

TEST(RTestDrift, NeighboursOfASweepAreNoRepeatedPoints) {
  std::vector<double> sweep;
  for (int i = 0; i < 400; ++i) sweep.push_back(0.05 * i);
  EXPECT_FALSE(analyse(turned({sweep}, false)).cycles[0].drift_estimated);
}

// The drift of a cycle that repeats no point is that of the others, in U: in its own, and in that of all cycles where
// it is the reference.
TEST(RTestDrift, AnUnknownDriftIsInTheUncertainty) {
  const RTestAnalysis first = analyse(turned({without, whole, whole, whole}, true));
  double largest = 0.0;
  for (std::size_t cycle = 1; cycle < 4; ++cycle) {
    for (Index e = 0; e < std::ssize(first.errors); ++e) {
      const double error = std::abs(first.cycles[cycle].value[e]);
      EXPECT_LE(error, 2.0 * first.cycles[cycle].std[e]) << first.errors[e];
      largest = std::max(largest, error / um);
    }
  }
  EXPECT_GT(largest, 5.0) << "the drift does harm";
  const RTestAnalysis third = analyse(turned({whole, whole, without, whole}, false));
  for (Index e = 0; e < std::ssize(third.errors); ++e) {
    EXPECT_LE(std::abs(third.cycles[2].value[e] - known.at(third.errors[e])), 2.0 * third.cycles[2].std[e]);
    EXPECT_DOUBLE_EQ(third.cycles[1].std[e], third.cycles[3].std[e]);
  }
  EXPECT_GT(third.cycles[2].std[0], 2.0 * third.cycles[1].std[0]);
}

TEST(RTestDrift, ACycleAloneIsAbsolute) {
  const std::string head =
      "schema = 1\nchain = \"V [w C' B' b Y X Z (C1) t]\"\nstd_um = 0.5\nerrors = ['X0C', 'Y0C', 'Z0T']\n";
  const core::Table one = core::parse_csv(
      "time_s,cycle,C_deg,x_mm,y_mm,z_mm,dx_um,dy_um,dz_um\n0,1,0,200,0,50,-7,0,0\n1,1,-90,0,200,50,-7,0,0\n"
      "2,1,-180,-200,0,50,-7,0,0\n",
      "points.csv");
  const RTestRecord record = RTestRecord::parse(head, one, "rtest.toml");
  EXPECT_TRUE(record.alone);
  const RTestAnalysis found = analyse(record);
  EXPECT_NEAR(found.cycles[0].value[0] / um, 7.0, 0.01);
  EXPECT_GT(found.cycles[0].std[0], 0.1 * um);
}

// A sweep of the plan's own default has 7,202 points a cycle.
TEST(RTestDrift, ALongSweepHasItsPoints) {
  std::vector<double> sweep;
  for (int i = 0; i < 7202; ++i) sweep.push_back(0.05 * i);
  const RTestRecord record = turned({sweep, sweep}, true, 0.0);
  const TestPoints points = common_points(record, analyse(record));
  EXPECT_EQ(std::ssize(points.poses), most_poses);
  EXPECT_FALSE(points.too_many);
}

// A thousand degrees of freedom show noise of 1.5 times the stated one; noise as stated is no cause for words.
TEST(RTestDrift, ResidualsAreTestedByTheirDegreesOfFreedom) {
  Estimates estimates;
  CycleResult cycle;
  cycle.residual = Eigen::VectorXd::Constant(1000, 0.75 * um);
  cycle.degrees_of_freedom = 1000;
  estimates.cycles.push_back(cycle);
  EXPECT_TRUE(residual_test(estimates, 0.5 * um).exceeds);
  EXPECT_NEAR(residual_test(estimates, 0.5 * um).ratio, 1.5, 1e-9);
  EXPECT_FALSE(residual_test(estimates, 0.71 * um).exceeds);
  // Quantile of 99.9 % for five degrees of freedom: 20.52.
  for (const double chi_square : {20.3, 20.8}) {
    estimates.cycles[0].degrees_of_freedom = 5;
    estimates.cycles[0].residual = Eigen::VectorXd::Constant(5, std::sqrt(chi_square / 5.0) * um);
    EXPECT_EQ(residual_test(estimates, um).exceeds, chi_square > 20.5) << chi_square;
  }
}

}  // namespace
}  // namespace thermotwin::metrology
