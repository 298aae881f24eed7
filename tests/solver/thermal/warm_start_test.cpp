// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/thermal/warm_start.h"

#include <gtest/gtest.h>

namespace thermotwin::solver {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Two loads of 300 unknowns with a diagonal each.
class WarmStarts : public ::testing::Test {
protected:
  static constexpr Index size = 300, loads = 2;
  WarmStarts() {
    for (Index i = 0; i < size; ++i)
      for (Index l = 0; l < loads; ++l) a_(i, l) = 1.0 + 0.01 * i * (l + 1);
  }
  SideBySide times_a(const SideBySide& d) const { return a_.cwiseProduct(d); }

  /// Guesses, then solves but for a share of what is left. @return the residual's norm after the guess, of each load
  Eigen::VectorXd solve(WarmStart& warm, const SideBySide& solution, double left = 0.0) const {
    SideBySide d = SideBySide::Zero(size, loads), r = times_a(solution);
    warm.guess(d, r);
    EXPECT_LE((r + times_a(d) - times_a(solution)).norm(), 1e-12 * times_a(solution).norm());
    const Eigen::VectorXd after = norms(r);
    d += (1.0 - left) * r.cwiseQuotient(a_);
    r *= left;
    warm.remember(d, r);
    return after;
  }

  SideBySide a_ = SideBySide(size, loads);
};

TEST_F(WarmStarts, FindTheSolutionsThatEarlierOnesSpan) {
  WarmStart warm(4);
  const SideBySide one = SideBySide::Random(size, loads), two = SideBySide::Random(size, loads);
  SideBySide both = 3.0 * one - 0.5 * two;
  both.col(1) = -2.0 * one.col(1) + 1e-3 * two.col(1);
  EXPECT_DOUBLE_EQ(solve(warm, one, 1e-6)[0], norms(times_a(one))[0]);
  solve(warm, two, 1e-6);
  const Eigen::VectorXd left = solve(warm, both);
  for (Index l = 0; l < loads; ++l) EXPECT_LT(left[l], 1e-5 * norms(times_a(both))[l]) << l;
  warm.clear();
  EXPECT_DOUBLE_EQ(solve(warm, both)[1], norms(times_a(both))[1]);
}

TEST_F(WarmStarts, BeginAnewFromTheWholeSolutionWhereTheyAreFull) {
  WarmStart warm(2);
  const SideBySide one = SideBySide::Random(size, loads), two = SideBySide::Random(size, loads),
                   three = SideBySide::Random(size, loads);
  solve(warm, one);
  solve(warm, two);
  solve(warm, three);
  EXPECT_LT(solve(warm, 2.0 * three)[0], 1e-12 * norms(times_a(three))[0]);
  EXPECT_GT(solve(warm, one)[0], 0.1 * norms(times_a(one))[0]);
}

TEST_F(WarmStarts, ARepetitionOrNothingAtAllSpoilsNothing) {
  WarmStart warm(6);
  const SideBySide one = SideBySide::Random(size, loads), none = SideBySide::Zero(size, loads);
  for (int again = 0; again < 3; ++again) solve(warm, one);
  EXPECT_EQ(solve(warm, none)[0], 0.0);
  const Eigen::VectorXd left = solve(warm, 5.0 * one);
  EXPECT_LT(left[1], 1e-12 * norms(times_a(one))[1]);
}

}  // namespace
}  // namespace thermotwin::solver
