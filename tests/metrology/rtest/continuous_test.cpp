// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/continuous.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "compensation/chain/location_offsets.h"
#include "core/error.h"
#include "core/units.h"
#include "metrology/rtest/analysis.h"

namespace thermotwin::metrology {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using core::units::deg;
using core::units::um;

const std::string cradle_toml = R"toml(schema = 1
chain = "V [w C' A' b Y X Z t]"
std_um = 1
axis = [{id = "A", with_letter = true, y_mm = 30, z_mm = -80}]
)toml";

/// The A axis of a cradle swings from -90 deg to 60 deg with the sphere 190 mm away; every second cycle has the errors.
core::Table swing(const std::map<std::string, double>& errors, double to_deg = 60.0) {
  mesh::KinematicChain chain = mesh::KinematicChain::parse("V [w C' A' b Y X Z t]", "test");
  chain.find("A")->direction = Vector3d::UnitX();
  chain.find("A")->origin = Vector3d(0, 0.03, -0.08);
  const compensation::LocationOffsets map(chain);
  core::Table table;
  table.source = "points.csv";
  table.columns = {"time_s", "cycle", "A_deg", "x_mm", "y_mm", "z_mm", "dx_um", "dy_um", "dz_um"};
  constexpr Index n = 151;
  table.values.resize(2 * n, 9);
  for (Index i = 0; i < 2 * n; ++i) {
    const double angle = -90.0 + (to_deg + 90.0) * (i % n) / (n - 1);
    const std::map<std::string, double> at{{"A", angle * deg}};
    const Vector3d nominal = mesh::KinematicChain::frame(chain.table, 0, at) * Vector3d(0.07, 0.03, 0.11);
    Vector3d deviation = Vector3d::Zero();
    if (i >= n)
      for (const auto& [name, value] : errors) deviation += map.motion_of(name, value, at, nominal).shift;
    table.values.row(i) << 10.0 + i, i / n + 1, angle, nominal.transpose() * 1e3, deviation.transpose() / um;
  }
  return table;
}

// Plane and circle give the location errors that the least squares on the chain give, at the same point.
TEST(ContinuousRTest, CircleAndChainAgree) {
  const std::map<std::string, double> errors{{"X0T", 9 * um},  {"Y0A", 12 * um},  {"Z0A", -25 * um},
                                             {"A0A", 40 * um}, {"B0A", 110 * um}, {"C0A", -60 * um}};
  const RTestRecord record = RTestRecord::parse(cradle_toml, swing(errors), "rtest.toml");
  EXPECT_EQ(record.errors, (std::vector<std::string>{"X0T", "Y0A", "Z0A", "A0A", "B0A", "C0A"}));
  ASSERT_TRUE(is_continuous(record));
  const RTestAnalysis chain = analyse(record);
  for (std::size_t e = 0; e < record.errors.size(); ++e)
    EXPECT_NEAR(chain.cycles[1].value[e] / um, errors.at(record.errors[e]) / um, 1e-6) << record.errors[e];
  for (const CircleMethod method : {CircleMethod::kasa, CircleMethod::taubin, CircleMethod::geometric}) {
    const std::vector<ArcFit> fits = fit_cycles(record, method);
    ASSERT_EQ(fits.size(), 2U);
    const ArcNames names = arc_names(record);
    for (int i = 0; i < 2; ++i) {
      EXPECT_NEAR((fits[1].centre - fits[0].centre)[i] / um, errors.at(names.centre[i]) / um, 0.02) << names.centre[i];
      EXPECT_NEAR((fits[1].tilt - fits[0].tilt)[i] / um, errors.at(names.tilt[i]) / um, 0.02) << names.tilt[i];
    }
  }
}

TEST(ContinuousRTest, ShortArcsAreRefused) {
  EXPECT_EQ(fit_cycles(RTestRecord::parse(cradle_toml, swing({}, -80.0), "rtest.toml"), CircleMethod::kasa).size(), 2U);
  for (const auto& [to_deg, words] : {std::pair{-84.0, "an arc of 6 deg"}, {-80.1, "an arc of 9.9 deg"}}) try {
      fit_cycles(RTestRecord::parse(cradle_toml, swing({}, to_deg), "rtest.toml"), CircleMethod::geometric);
      ADD_FAILURE();
    } catch (const core::InputError& error) {
      for (const char* word : {"points.csv cycle 1", words, "at least 10 deg"})
        EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
}

// A head turns the tool about a sphere that stands still: no circle, but location errors.
TEST(ContinuousRTest, ASphereThatStandsStillIsNoSweep) {
  std::string points = "time_s,cycle,B_deg,x_mm,y_mm,z_mm,dx_um,dy_um,dz_um\n";
  for (int i = 0; i < 40; ++i) points += fmt::format("{},1,{},100,20,80,0,0,0\n", i + 1, -80 + 4 * i);
  const RTestRecord record = RTestRecord::parse("schema = 1\nchain = \"V [w b X Y Z B t]\"\nstd_um = 1\n",
                                                core::parse_csv(points, "points.csv"), "rtest.toml");
  EXPECT_FALSE(is_continuous(record));
}

}  // namespace
}  // namespace thermotwin::metrology
