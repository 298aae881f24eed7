// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/tool_places.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <functional>
#include <utility>

#include "core/units.h"
#include "metrology/rtest/grid.h"

namespace thermotwin::metrology {
namespace {

using Row = std::array<double, 6>;  ///< X, Y, Z of the axes; x, y, z

ToolPlaces places_of(const std::function<void(Row&, int)>& slip) {
  std::string text = "time_s,cycle,X_mm,Y_mm,Z_mm,x_mm,y_mm,z_mm,dx_um,dy_um,dz_um\n";
  int time = 0;
  for (const double x : {-300, 0, 300}) {
    for (const double y : {-200, 10, 200}) {
      for (const double z : {100, 300, 500}) {
        Row row{x, y, z, x, y, z - 20.0};
        slip(row, time++);
        text += fmt::format("{},1,{},{},{},{},{},{},0,0,0\n", time, row[0], row[1], row[2], row[3], row[4], row[5]);
      }
    }
  }
  return tool_places(parse_grid("schema = 1\nchain = \"V [w C' B' b Y X Z (C1) t]\"\nstd_um = 0.5\nerrors = ['X0T']\n",
                                core::parse_csv(text, "points.csv"), "grid.toml"));
}

TEST(ToolPlaces, PointsThatFollowTheAxesMeanOne) {
  const ToolPlaces one = places_of([](Row&, int) {});
  EXPECT_EQ(one.count, 1);
  EXPECT_EQ(one.doubt, "");
  EXPECT_NEAR(one.first.z(), -0.02, 1e-9);
  // A longer tool for some of the points.
  const ToolPlaces two = places_of([](Row& row, int i) { row[5] -= i % 2 == 0 ? 0.0 : 80.0; });
  EXPECT_EQ(two.count, 2);
  EXPECT_EQ(two.doubt, "");
}

TEST(ToolPlaces, ContradictionsAreNamed) {
  const std::vector<std::pair<std::function<void(Row&, int)>, const char*>> slips{
      {[](Row& row, int) { row[0] = -row[0]; }, "with the sign of X_mm reversed they mean 1;"},
      {[](Row& row, int) { row[0] *= 1e-3; }, "with X_mm in m they mean 1;"},
      {[](Row& row, int) { std::swap(row[0], row[1]); }, "with X_mm and Y_mm exchanged they mean 1;"},
      {[](Row& row, int) { row[5] = -row[5] - 40.0; }, "with the sign of Z_mm reversed they mean 1;"},
      {[](Row& row, int i) { row[3] += 3.0 * i; }, "27 places of the tool point;"}};
  for (const auto& [slip, words] : slips)
    EXPECT_NE(places_of(slip).doubt.find(words), std::string::npos) << words << ": " << places_of(slip).doubt;
}

}  // namespace
}  // namespace thermotwin::metrology
