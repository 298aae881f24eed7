// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Chooses the blocks of a test and their order by the variance of the TCP's error that the parameters leave after it:
//   tr(M S),  S the parameters' part of (1 + J)^-1,
// with the information J of all blocks (test_run.h) and M of the prediction. Greedy: the block that lowers its
// logarithm most per hour is next; the thermal state goes on. Exchange: a block is replaced by one that promises less
// variance and keeps it (Fedorov 1972); what follows is run anew, since its readings depend on the state.

#include <Eigen/Core>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "study/tests/test_blocks.h"
#include "study/tests/test_run.h"

namespace thermotwin::study {

using TestOrder = std::vector<const TestBlock*>;

/// A test after each of its blocks.
struct TestPath {
  TestOrder blocks;
  std::vector<double> hours;            ///< at the end of each block
  std::vector<double> variance_um2;     ///< tr(M S) there
  std::vector<Eigen::VectorXd> shares;  ///< (parameters) what each block lowers of the diagonal of M S, um^2
  Eigen::MatrixXd covariance;           ///< (parameters x parameters) at the end, per squared prior deviation
  double end_um2() const { return variance_um2.back(); }
  /// @return the hours after which at most so much is left; nothing if it never is
  std::optional<double> hours_until(double variance_um2) const;
};

class TestChoice {
public:
  /// @param run         at the start of a test; with `blocks` must outlive it
  /// @param prediction  M, (parameters x parameters) um^2
  TestChoice(TestRun& run, const std::vector<TestBlock>& blocks, const Eigen::MatrixXd& prediction);

  double prior_um2() const { return prediction_.trace(); }
  TestPath evaluate(const TestOrder& order) const;
  TestOrder greedy(double seconds) const;
  /// @param passes  over the blocks at most
  TestOrder exchanged(TestOrder order, int passes) const;
  /// The order up to the block that reaches a variance, without the blocks that are not needed for it: each is left
  /// out in turn, the longest first, and stays out where the rest still reaches the variance.
  /// @return the order as it is where it never reaches the variance
  TestOrder shortened(TestOrder order, double variance_um2) const;
  /// Blocks drawn with equal probability of those that still fit.
  TestOrder random(double seconds, std::uint64_t seed) const;

private:
  struct Stage {
    std::shared_ptr<const TestRun::Kept> state;
    Eigen::MatrixXd information;
  };
  std::vector<std::size_t> by_length() const;
  double variance(const Eigen::MatrixXd& information) const;
  Eigen::MatrixXd covariance(const Eigen::MatrixXd& information) const;
  double run_on(const Stage& from, const TestOrder& order, std::size_t first) const;

  TestRun& run_;
  const std::vector<TestBlock>& blocks_;
  Eigen::MatrixXd prediction_, root_;  ///< M = root root^T
  Stage start_;
};

}  // namespace thermotwin::study
