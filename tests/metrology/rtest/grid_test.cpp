// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/grid.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "core/error.h"
#include "core/units.h"
#include "metrology/rtest/analysis.h"
#include "metrology/rtest/error_terms.h"
#include "metrology/rtest/record_keys.h"
#include "tests/core/reference_page.h"

namespace thermotwin::metrology {
namespace {

using core::units::um;
constexpr const char* grid_head = "schema = 1\nchain = \"V [w C' B' b Y X Z (C1) t]\"\nstd_um = 0.5\n";

/// Two cycles over 3 x 3 x 3 positions without deviations.
core::Table still_grid() {
  std::string text = "time_s,cycle,X_mm,Y_mm,Z_mm,x_mm,y_mm,z_mm,dx_um,dy_um,dz_um\n";
  int time = 0;
  for (int cycle = 1; cycle <= 2; ++cycle) {
    for (const double x : {-300, 0, 300})
      for (const double y : {-200, 0, 200})
        for (const double z : {100, 300, 500})
          text += fmt::format("{},{},{},{},{},{},{},{},0,0,0\n", time += 10, cycle, x, y, z, x, y, z);
  }
  return core::parse_csv(text, "points.csv");
}

TEST(Grid, DistinguishedErrorsAreObservable) {
  const RTestRecord record = parse_grid(grid_head, still_grid(), "grid.toml");
  const Estimates found = analyse(record);
  EXPECT_TRUE(found.not_observable.empty());
  for (const char* name : {"X0T", "C0T", "EXX1", "EZZ1", "EBX1"})
    EXPECT_NE(std::find(found.errors.begin(), found.errors.end(), name), found.errors.end()) << name;
  // A turn of what Y carries is a turn of the table.
  EXPECT_EQ(std::find(found.errors.begin(), found.errors.end(), "C0Y"), found.errors.end());
  EXPECT_EQ(found.cycles[0].rank, found.cycles[0].parameters);
  const RTestRecord higher = parse_grid(std::string(grid_head) + "order = 2\n", still_grid(), "grid.toml");
  EXPECT_GT(higher.errors.size(), record.errors.size());
}

TEST(Grid, ErrorsWithTheSameEffectAreNamed) {
  const RTestRecord record =
      parse_grid(std::string(grid_head) + "errors = ['C0Y', 'C0T', 'EXX1']\n", still_grid(), "grid.toml");
  const Estimates found = analyse(record);
  ASSERT_EQ(found.not_observable.size(), 2u);
  EXPECT_NE(found.not_observable[0].find("C0T"), std::string::npos) << found.not_observable[0];
  EXPECT_EQ(found.observed(), std::vector<std::size_t>{2});
  EXPECT_THROW(analyse(parse_grid(std::string(grid_head) + "errors = ['C0Y', 'C0T']\n", still_grid(), "grid.toml")),
               core::InputError);
}

TEST(Grid, UnitsFollowThePower) {
  const std::vector<std::pair<const char*, const char*>> known{{"X0T", "um"},     {"R0T", "um"},     {"A0C", "um/m"},
                                                               {"EXX1", "um/m"},  {"EYX2", "um/m2"}, {"EAX1", "um/m2"},
                                                               {"ECX3", "um/m4"}, {"rb", "um/m"},    {"dx", "um"}};
  for (const auto& [name, unit] : known) EXPECT_EQ(unit_of_error(name), unit) << name;
}

TEST(Grid, ExpandedUncertaintyCovers) {
  RTestRecord record = parse_grid(grid_head, still_grid(), "grid.toml");
  std::mt19937_64 engine(11);
  std::normal_distribution<double> noise(0.0, record.std);
  long inside = 0, all = 0;
  for (int draw = 0; draw < 200; ++draw) {
    for (RTestCycle& cycle : record.cycles)
      for (RTestPoint& point : cycle.points) point.deviation = {noise(engine), noise(engine), noise(engine)};
    const CycleResult last = analyse(record).cycles.back();
    for (Eigen::Index e = 0; e < last.value.size(); ++e, ++all) inside += std::abs(last.value[e]) <= 2.0 * last.std[e];
  }
  const double covered = 100.0 * static_cast<double>(inside) / static_cast<double>(all);
  EXPECT_GT(covered, 90.0);
  EXPECT_LT(covered, 98.0);
}

// A curved guide acts as a rotation along it: the default errors name it beside what they estimate.
TEST(Grid, ErrorsThatAreAssumedToBeNoneAreNamed) {
  const RTestRecord record = parse_grid(grid_head, still_grid(), "grid.toml");
  const auto find = [&](const std::string& name) {
    return std::find_if(record.left_out.begin(), record.left_out.end(),
                        [&](const std::string& words) { return words.starts_with(name + " from "); });
  };
  ASSERT_NE(find("C0Y"), record.left_out.end());
  EXPECT_EQ(*find("C0Y"), "C0Y from C0T");
  const RTestRecord higher = parse_grid(std::string(grid_head) + "order = 2\n", still_grid(), "grid.toml");
  const auto curved = std::find_if(higher.left_out.begin(), higher.left_out.end(),
                                   [](const std::string& words) { return words.starts_with("EYX2 from "); });
  ASSERT_NE(curved, higher.left_out.end());
  EXPECT_NE(curved->find("ECX1"), std::string::npos) << *curved;
  EXPECT_EQ(analyse(higher).not_estimated, higher.left_out);
  EXPECT_TRUE(parse_grid(std::string(grid_head) + "errors = ['EXX1']\n", still_grid(), "grid.toml").left_out.empty());
}

TEST(Grid, ReferencePageIsThatOfTheReader) { core::expect_reference_page("grid", grid_keys(), "metrology_tests"); }

}  // namespace
}  // namespace thermotwin::metrology
