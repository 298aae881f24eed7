// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/judge/detectability.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/diagnose.h"
#include "tests/diagnosis/diagnosed_rods.h"

namespace {

using namespace thermotwin;
using diagnosis::Kind;

TEST(Detectability, ASizeIsSeenAtFourAndAHalfDeviationsOfItsEstimate) {
  diagnosis::Problem problem;
  diagnosis::SearchResult found;
  found.hypotheses.resize(1);
  const auto add = [&](Kind kind, const std::string& where, double std) {
    problem.parameters.push_back(diagnosis::make_parameter(kind, where));
    const int index = static_cast<int>(std::ssize(problem.parameters)) - 1;
    if (std <= 0.0) return found.invisible.push_back(index);
    diagnosis::Hypothesis h;
    h.members = {index};
    h.std = Eigen::VectorXd::Constant(1, std);
    found.hypotheses.push_back(h);
  };
  add(Kind::film_coefficient, "skin", 0.1);
  add(Kind::film_coefficient, "table", 0.02);
  add(Kind::film_coefficient, "cover", 0.0);
  add(Kind::sensor_offset, "T1", 0.0);
  const std::vector<diagnosis::Detectable> rows = diagnosis::detectability(problem, found);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].kind, Kind::film_coefficient);
  EXPECT_NEAR(rows[0].least, 0.02 * std::sqrt(20.0), 1e-12);
  EXPECT_EQ(rows[0].best, "table");
  EXPECT_NEAR(rows[0].most, 0.1 * std::sqrt(20.0), 1e-12);
  EXPECT_EQ(rows[0].worst, "skin");
  EXPECT_EQ(rows[0].invisible, 1);
  EXPECT_EQ(rows[1].kind, Kind::sensor_offset);
  EXPECT_TRUE(rows[1].best.empty());
  EXPECT_EQ(rows[1].invisible, 1);
}

/// What is said to be visible is named, and what is said to be far below is not.
TEST(Detectability, IsWhatADiagnosisNames) {
  const auto diagnosed = [](double factor) {
    return diagnosis::diagnose(lumped::coarse_model(),
                               lumped::measure({{lumped::find(Kind::source_power, "motor"), factor}}, {.hours = 30}),
                               {});
  };
  const diagnosis::Diagnosis clean = diagnosed(1.0);
  const auto row = std::find_if(clean.detectable.begin(), clean.detectable.end(),
                                [](const auto& kind) { return kind.kind == Kind::source_power; });
  ASSERT_NE(row, clean.detectable.end());
  const double size = row->best == "motor" ? row->least : row->most;
  ASSERT_LT(size, 1.0);
  const diagnosis::Diagnosis seen = diagnosed(1.0 + 2.0 * std::max(size, 0.15));
  ASSERT_FALSE(seen.causes.empty()) << seen.sentence;
  EXPECT_EQ(seen.causes.front().parameter.where, "motor");
  EXPECT_EQ(diagnosed(1.0 + 0.2 * size).verdict, diagnosis::Verdict::no_discrepancy);
}

}  // namespace
