// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/plan/design.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace thermotwin::study {
namespace {

StudyParameter parameter(const std::string& name, const Distribution& distribution) {
  StudyParameter made;
  made.name = name;
  made.distribution = distribution;
  return made;
}

StudyPlan plan_of(Sampling sampling) {
  StudyPlan plan;
  plan.sizes = {"coarse", "0.8"};
  plan.samples = 16;
  plan.sampling = sampling;
  plan.parameters = {parameter("a", Distribution::fixed({0.5, 1.0, 2.0})), parameter("b", Distribution::normal(1, 0.1)),
                     parameter("c", Distribution::uniform(0, 4))};
  return plan;
}

TEST(StudyDesign, CombinesSizesFixedValuesAndDraws) {
  const Design design = make_design(plan_of(Sampling::latin));
  EXPECT_EQ(design.drawn, (std::vector<int>{1, 2}));
  ASSERT_EQ(design.groups.size(), 6U);
  EXPECT_EQ(design.variants.size(), 6U * 16U);
  std::set<std::string> names;
  for (const Group& group : design.groups) names.insert(group.name);
  EXPECT_EQ(names.size(), 6U);
  std::set<double> fixed;
  for (std::size_t g = 0; g < 6; ++g) {
    const auto members = design.of_group(g), first = design.of_group(0);
    for (std::size_t i = 0; i < members.size(); ++i) {
      EXPECT_EQ(design.variants[members[i]].values[0], design.groups[g].fixed[0]);
      fixed.insert(design.variants[members[i]].values[0]);
      // Every group has the same draws.
      EXPECT_EQ(design.variants[members[i]].values.tail(2), design.variants[first[i]].values.tail(2));
    }
  }
  EXPECT_EQ(fixed, (std::set<double>{0.5, 1.0, 2.0}));
}

TEST(StudyDesign, ALatinHypercubeHasOneDrawInEachInterval) {
  const Eigen::MatrixXd shares = drawn_shares(50, 3, 7, true);
  for (int d = 0; d < 3; ++d) {
    std::vector<int> seen(50, 0);
    for (int i = 0; i < 50; ++i) ++seen[static_cast<int>(shares(i, d) * 50)];
    EXPECT_EQ(*std::min_element(seen.begin(), seen.end()), 1);
  }
  // Draws of two values have nothing to do with each other.
  const Eigen::MatrixXd centred = shares.rowwise() - shares.colwise().mean();
  for (int d = 0; d < 3; ++d) {
    const Eigen::VectorXd a = centred.col(d), b = centred.col((d + 1) % 3);
    EXPECT_LT(std::abs(a.dot(b)), 0.4 * a.norm() * b.norm()) << d;
  }
  EXPECT_EQ(drawn_shares(50, 3, 7, true), shares);
  EXPECT_NE(drawn_shares(50, 3, 8, true), shares);
}

TEST(StudyDesign, PickFreezeChangesOneValueARow) {
  StudyPlan plan = plan_of(Sampling::pick_freeze);
  plan.sizes = {"coarse"};
  plan.parameters.erase(plan.parameters.begin());
  const Design design = make_design(plan);
  ASSERT_EQ(design.variants.size(), 16U * 4U);
  for (int s = 0; s < 16; ++s) {
    const auto at = [&](int k) -> const Eigen::VectorXd& { return design.variants[4 * s + k].values; };
    EXPECT_NE(at(0)[0], at(1)[0]);
    EXPECT_EQ(at(2)[0], at(1)[0]);
    EXPECT_EQ(at(2)[1], at(0)[1]);
    EXPECT_EQ(at(3)[0], at(0)[0]);
    EXPECT_EQ(at(3)[1], at(1)[1]);
  }
}

}  // namespace
}  // namespace thermotwin::study
