// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/variants/variant_results.h"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "core/file.h"
#include "core/statistics.h"
#include "study/units/unit_files.h"
#include "study/variants/variant_unit.h"
#include "tests/core/temporary_folder.h"
#include "tests/machines/box_machine.h"

namespace thermotwin::study {
namespace {

using Eigen::VectorXd;

/// Two poses, two times, three values in [0, 1]. At pose p: dx = 10 + (1 + 2 p) a, dz = 4 b; c tells nothing.
class VariantResults : public ::testing::Test {
protected:
  VariantStudy made(Sampling sampling, int samples) {
    plan_.machine_case.machine = test::box_machine();
    plan_.machine_case.machine.workspace.axes = {"X"};
    plan_.machine_case.machine.workspace.positions = {{-0.2, 0.2}};
    plan_.loads = {"day"};
    plan_.sizes = {"coarse"};
    plan_.sampling = sampling;
    plan_.samples = samples;
    for (const char* name : {"a", "b", "c"}) {
      StudyParameter parameter;
      parameter.name = name;
      parameter.distribution = Distribution::uniform(0.0, 1.0);
      plan_.parameters.push_back(parameter);
    }
    design_ = make_design(plan_);
    VariantUnit unit{{"0123456789abcdef", "day"}, "day", "coarse", "coarse", {}};
    std::vector<VariantTables> tables;
    for (std::size_t v = 0; v < design_.variants.size(); ++v) {
      unit.variants.push_back(v);
      VariantTables of;
      of.tcp.columns = {"time_s", "X_mm",  "Z_mm",        "C_deg",       "dx_um",
                        "dy_um",  "dz_um", "ra_um_per_m", "rb_um_per_m", "rc_um_per_m"};
      of.tcp.values.setZero(4, 10);
      for (int row = 0; row < 4; ++row) {
        of.tcp.values(row, 0) = 60.0 * (row / 2);
        of.tcp.values(row, 1) = row % 2 == 0 ? -200.0 : 200.0;
        of.tcp.values(row, 4) = dx(v, row % 2);
        of.tcp.values(row, 6) = 4.0 * value(v, 1);
      }
      of.sensors.columns = {"time_s"};
      of.sensors.values.setZero(2, 1);
      tables.push_back(of);
    }
    mark_done(folder_.path(), unit, write_tables(unit_folder(folder_.path(), unit), unit, tables));
    const VariantStudy results = gather(folder_.path(), plan_, design_, {unit});
    write_results(folder_.path(), plan_, design_, results);
    return results;
  }
  double value(std::size_t variant, int parameter) const { return design_.variants[variant].values[parameter]; }
  double dx(std::size_t variant, int pose) const { return 10.0 + (1.0 + 2.0 * pose) * value(variant, 0); }
  double length(std::size_t variant, int pose) const { return std::hypot(dx(variant, pose), 4.0 * value(variant, 1)); }

  StudyPlan plan_;
  Design design_;
  core::TemporaryFolder folder_;
};

constexpr double levels[] = {0.05, 0.5, 0.95};
constexpr const char* level_columns[] = {"error_um_q05", "error_um_q50", "error_um_q95"};

TEST_F(VariantResults, QuantilesAreOfTheLengthAndSharesOfEachPose) {
  const VariantStudy results = made(Sampling::latin, 60);
  ASSERT_EQ(results.groups.size(), 1U);
  const LoadStudy& load = results.groups[0].loads.at(0);
  for (int pose = 0; pose < 2; ++pose) {
    std::vector<double> lengths;
    for (std::size_t v = 0; v < 60; ++v) lengths.push_back(length(v, pose));
    for (int level = 0; level < 3; ++level)
      EXPECT_NEAR(load.quantiles.column(level_columns[level])[2 + pose], core::quantile(lengths, levels[level]), 1e-9);
  }
  // Variances of a and b at one time: 1/12 times 1 or 9, and times 16.
  ASSERT_TRUE(load.sensitivity.has_value());
  EXPECT_NEAR(load.sensitivity->first[0].value, 10.0 / 42.0, 1e-3);
  EXPECT_NEAR(load.sensitivity->first[1].value, 32.0 / 42.0, 1e-3);
  ASSERT_EQ(load.at_poses.size(), 2U);
  EXPECT_NEAR(load.at_poses[0].first[0].value, 1.0 / 17.0, 1e-3);
  EXPECT_NEAR(load.at_poses[1].first[0].value, 9.0 / 25.0, 1e-3);
  EXPECT_EQ(by_total(*load.sensitivity), (std::vector<std::size_t>{1, 0, 2}));
  EXPECT_EQ(that_matter(*load.sensitivity), (std::vector<std::size_t>{1, 0}));

  std::istringstream table(core::read_file(folder_ / "coarse/day/sensitivities_by_pose.csv"));
  std::string line;
  std::getline(table, line);
  EXPECT_EQ(line, "parameter,X_mm,Z_mm,C_deg,std_um,first,first_low,first_high,total,total_low,total_high");
  for (int pose = 0; pose < 2; ++pose) {
    ASSERT_TRUE(std::getline(table, line));
    double x = 0, std_um = 0, first = 0;
    ASSERT_EQ(std::sscanf(line.c_str(), "a,%lf,%*f,%*f,%lf,%lf", &x, &std_um, &first), 3) << line;
    EXPECT_EQ(x, pose == 0 ? -200.0 : 200.0);
    EXPECT_NEAR(std_um, std::sqrt((pose == 0 ? 17.0 : 25.0) / 12.0), 2e-3) << line;
    EXPECT_NEAR(first, pose == 0 ? 1.0 / 17.0 : 9.0 / 25.0, 1e-3) << line;
  }
}

TEST_F(VariantResults, QuantilesLeaveOutTheChangedRowsOfPickFreeze) {
  const VariantStudy results = made(Sampling::pick_freeze, 20);
  const LoadStudy& load = results.groups.at(0).loads.at(0);
  for (int pose = 0; pose < 2; ++pose) {
    std::vector<double> lengths;
    for (std::size_t sample = 0; sample < 20; ++sample)
      for (const std::size_t row : {5 * sample, 5 * sample + 1}) lengths.push_back(length(row, pose));
    for (int level = 0; level < 3; ++level)
      EXPECT_NEAR(load.quantiles.column(level_columns[level])[pose], core::quantile(lengths, levels[level]), 1e-9);
  }
}

}  // namespace
}  // namespace thermotwin::study
