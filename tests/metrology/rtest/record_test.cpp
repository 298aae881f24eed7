// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/record.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "metrology/rtest/analysis.h"
#include "metrology/rtest/record_keys.h"
#include "tests/core/reference_page.h"

namespace thermotwin::metrology {
namespace {

namespace units = core::units;

TEST(RTestRecord, UsualErrorsOfTheAxesThatMove) {
  const mesh::KinematicChain chain = mesh::KinematicChain::parse("V [w C' B' b Y X Z t]", "test");
  const auto errors = [&](const std::vector<std::string>& moved) { return usual_errors(chain, moved); };
  using Names = std::vector<std::string>;
  EXPECT_EQ(errors({"C"}), (Names{"X0C", "Y0C", "Z0T", "A0C", "B0C", "C0C", "R0T"}));
  EXPECT_EQ(errors({"B"}), (Names{"X0B", "Y0T", "Z0B", "A0B", "B0B", "C0B"}));
  EXPECT_EQ(errors({"B", "C"}), (Names{"X0B", "Z0B", "A0B", "C0B", "X0C", "Y0C", "Z0T", "A0C", "B0C", "C0C", "R0T"}));
  const mesh::KinematicChain head = mesh::KinematicChain::parse("V [w b X Y Z C A t]", "test");
  EXPECT_EQ(usual_errors(head, {"C", "A"}),
            (Names{"X0C", "Y0C", "A0C", "B0C", "X0A", "Y0A", "Z0A", "A0A", "B0A", "C0A"}));
}

/// A table C and a head B, with their first points at 0, 90, 180, 270 deg of C and -60, 0, 60 deg of B.
RTestRecord table_and_head(int count) {
  std::string points = "time_s,cycle,C_deg,B_deg,X_mm,Y_mm,Z_mm,x_mm,y_mm,z_mm,dx_um,dy_um,dz_um\n";
  int time = 0;
  for (const double c : {0.0, 90.0, 180.0, 270.0}) {
    for (const double b : {-60.0, 0.0, 60.0}) {
      const double turn = c * units::deg, tilt = b * units::deg;  // C turns the workpiece against its letter
      const double x = 150.0 * std::cos(turn), y = -150.0 * std::sin(turn);
      // The tool is 300 mm below the axis of B, which the linear axes carry to the sphere.
      if (time < count)
        points += fmt::format("{},1,{},{},{},{},{},{},{},80,0,0,0\n", ++time, c, b, x + 300.0 * std::sin(tilt), y,
                              80.0 + 300.0 * std::cos(tilt), x, y);
    }
  }
  return RTestRecord::parse("schema = 1\nchain = \"V [w C' b X Y Z B t]\"\nstd_um = 1\n",
                            core::parse_csv(points, "points.csv"), "rtest.toml");
}

// Shifts of a table's axis and of the head's act alike; a rotation of the head's axis about itself does not.
TEST(RTestRecord, DefaultErrorsOfTableAndHeadAreDistinguished) {
  const RTestRecord record = table_and_head(12);
  const auto has = [](const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  EXPECT_TRUE(has(record.errors, "X0C"));
  EXPECT_FALSE(has(record.errors, "X0B"));
  EXPECT_TRUE(has(record.errors, "B0B"));
  EXPECT_TRUE(has(record.left_out, "X0B from X0C"));
  const RTestAnalysis found = analyse(record);
  EXPECT_TRUE(found.not_observable.empty());
}

// Errors beyond half of the coordinates are assumed to be 0, and said to be.
TEST(RTestRecord, DefaultErrorsOfFewPointsAreAllNamed) {
  const RTestRecord all = table_and_head(12), few = table_and_head(4);
  EXPECT_LE(2 * few.errors.size(), 12U + 1U);
  EXPECT_LT(few.errors.size(), all.errors.size());
  for (const std::string& name : all.errors) {
    const auto names = [&](const std::string& words) {
      return words.starts_with(name + " ") || words.starts_with(name + ":");
    };
    EXPECT_TRUE(std::find(few.errors.begin(), few.errors.end(), name) != few.errors.end() ||
                std::any_of(few.left_out.begin(), few.left_out.end(), names))
        << name;
  }
  EXPECT_TRUE(std::any_of(few.left_out.begin(), few.left_out.end(),
                          [](const std::string& words) { return words.ends_with(": too few points"); }));
}

TEST(RTestRecord, ReferencePageIsThatOfTheReader) {
  core::expect_reference_page("rtest", record_keys(), "metrology_tests");
}

}  // namespace
}  // namespace thermotwin::metrology
