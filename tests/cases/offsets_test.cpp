// SPDX-License-Identifier: GPL-3.0-or-later
// `offsets`: location errors in a table become offsets of the axes of a chain.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/table.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

constexpr const char* chain = "V [w C' B' b Y X Z (C1) t]";

TEST(Offsets, TablesOfErrorsBecomeTablesOfOffsets) {
  const Toy toy;
  toy.write("errors.csv",
            "time_s,B_deg,point_x_mm,point_y_mm,point_z_mm,Y0C_um,Z0T_um,A0C_um_per_m\n0,0,0,200,0,10,5,0\n60,90,0,200,"
            "0,10,5,20\n");
  const std::string file = toy.result("offsets.csv").string();
  const Result result = thermotwin(
      {"offsets", "--chain", chain, "--with-letter", "B,C", "--in", toy.file("errors.csv"), "--out", file, "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const nlohmann::json summary = nlohmann::json::parse(result.out);
  EXPECT_NEAR(summary["largest_orientation_left_um_per_m"].get<double>(), 20.0, 1e-6)
      << "no axis turns the table about X";
  const core::Table offsets = core::read_csv(file);
  EXPECT_NEAR(offsets.column("offset_Y_um")[0], 10.0, 1e-6);
  EXPECT_NEAR(offsets.column("offset_Z_um")[0], 5.0, 1e-6);
  // B has turned the table's normal to +X; A0C then turns about the machine's -Z, 20 um/m at 200 mm.
  EXPECT_NEAR(offsets.column("offset_X_um")[1], 5.0 + 4.0, 1e-6);
  EXPECT_NEAR(offsets.column("offset_Z_um")[1], 0.0, 1e-6);
  EXPECT_NEAR(offsets.column("left_a_um_per_m")[1], 0.0, 1e-6);
  EXPECT_NEAR(std::abs(offsets.column("left_c_um_per_m")[1]), 20.0, 1e-6);
}

TEST(Offsets, MistakesAreNamed) {
  const Toy toy;
  toy.write("errors.csv", "time_s,Y0A_um\n0,1\n");
  const Result column = thermotwin({"offsets", "--chain", chain, "--in", toy.file("errors.csv")});
  EXPECT_EQ(column.status, 3);
  for (const char* words : {"errors.csv:1 column 2", "'Y0A_um'", "nearest: Y0"}) EXPECT_SAYS(column.err, words);
  const Result wrong = thermotwin({"offsets", "--chain", "V [w C' b X", "--in", toy.file("errors.csv")});
  EXPECT_EQ(wrong.status, 3);
  for (const char* words : {"--chain", "without [ ]", "V [w C' B' b Y X Z (C1) t]"}) EXPECT_SAYS(wrong.err, words);
  toy.write("errors.csv", "time_s,Y0C_um\n0,1\n60,\n");
  const Result gap = thermotwin({"offsets", "--chain", chain, "--in", toy.file("errors.csv")});
  EXPECT_EQ(gap.status, 3);
  for (const char* words : {"errors.csv:3 Y0C_um", "missing"}) EXPECT_SAYS(gap.err, words);
}

}  // namespace
}  // namespace thermotwin::cases
