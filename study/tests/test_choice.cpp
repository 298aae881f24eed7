// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/tests/test_choice.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <utility>

#include "core/error.h"
#include "core/progress.h"
#include "core/units.h"

namespace thermotwin::study {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double fits_s = 1e-3;
constexpr std::size_t promising = 2;  ///< replacements of a block that are run to the end
constexpr double least_gain = 1e-3;
constexpr double long_block = 2.0;  ///< times the shortest one: looked at again only while it may still be the best
constexpr double may_gain = 2.0;    ///< times its last rate, since the thermal state has changed

/// @param sum  without entries: none yet
void add(MatrixXd& sum, const MatrixXd& more) {
  if (sum.size() > 0) {
    sum += more;
  } else {
    sum = more;
  }
}

}  // namespace

std::optional<double> TestPath::hours_until(double wanted_um2) const {
  for (std::size_t i = 0; i < hours.size(); ++i)
    if (variance_um2[i] <= wanted_um2) return hours[i];
  return std::nullopt;
}

TestChoice::TestChoice(TestRun& run, const std::vector<TestBlock>& blocks, const MatrixXd& prediction)
    : run_(run),
      blocks_(blocks),
      prediction_(prediction) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> modes(prediction);
  root_ = modes.eigenvectors() * modes.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  start_.state = run.keep();
}

double TestChoice::variance(const MatrixXd& information) const {
  MatrixXd posterior = information;
  posterior.diagonal().array() += 1.0;
  MatrixXd right = MatrixXd::Zero(information.rows(), root_.cols());
  right.topRows(root_.rows()) = root_;
  const Eigen::LLT<MatrixXd> factor(posterior);
  factor.matrixL().solveInPlace(right);
  return right.squaredNorm();
}

MatrixXd TestChoice::covariance(const MatrixXd& information) const {
  MatrixXd posterior = information;
  posterior.diagonal().array() += 1.0;
  const Index count = prediction_.rows();
  MatrixXd right = MatrixXd::Zero(information.rows(), count);
  right.topRows(count).setIdentity();
  return posterior.llt().solve(right).topRows(count);
}

TestPath TestChoice::evaluate(const TestOrder& order) const {
  TestPath path;
  path.blocks = order;
  run_.take_up(*start_.state);
  MatrixXd information, before = MatrixXd::Identity(prediction_.rows(), prediction_.cols());
  double seconds = 0.0;
  for (const TestBlock* block : order) {
    add(information, run_.run(*block));
    const MatrixXd after = covariance(information);
    seconds += block->seconds();
    path.hours.push_back(seconds / core::units::hour);
    path.variance_um2.push_back(prediction_.cwiseProduct(after).sum());
    path.shares.push_back((prediction_.diagonal().array() * (before - after).diagonal().array()).matrix());
    before = after;
  }
  path.covariance = before;
  return path;
}

std::vector<std::size_t> TestChoice::by_length() const {
  std::vector<std::size_t> order(blocks_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return blocks_[a].seconds() < blocks_[b].seconds(); });
  return order;
}

TestOrder TestChoice::greedy(double seconds) const {
  TestOrder order;
  Stage at = start_;
  double left = seconds, now = prior_um2();
  double shortest = std::numeric_limits<double>::infinity();
  for (const TestBlock& block : blocks_) shortest = std::min(shortest, block.seconds());
  std::vector<double> last_rate(blocks_.size(), std::numeric_limits<double>::infinity());
  core::Progress progress("choosing blocks", std::max(1L, std::lround(seconds / 60.0)));
  while (true) {
    const TestBlock* best = nullptr;
    double best_rate = -std::numeric_limits<double>::infinity(), best_variance = now;
    Stage next;
    // Short blocks first: most long ones then need no run.
    for (const std::size_t i : by_length()) {
      const TestBlock& block = blocks_[i];
      if (block.seconds() > left + fits_s) continue;
      if (block.seconds() > long_block * shortest && may_gain * last_rate[i] < best_rate) continue;
      run_.take_up(*at.state);
      MatrixXd information = at.information;
      add(information, run_.run(block));
      const double after = variance(information);
      const double rate = std::log(now / std::max(after, std::numeric_limits<double>::min())) / block.seconds();
      last_rate[i] = rate;
      if (rate <= best_rate) continue;
      best = &block;
      best_rate = rate;
      best_variance = after;
      next = {run_.keep(), std::move(information)};
    }
    if (best == nullptr) break;
    order.push_back(best);
    at = std::move(next);
    now = best_variance;
    left -= best->seconds();
    progress.advance(std::lround(best->seconds() / 60.0));
  }
  if (order.empty()) {
    throw core::InputError("length of a test", std::to_string(seconds / core::units::hour) + " h",
                           "at least the length of one block");
  }
  return order;
}

double TestChoice::run_on(const Stage& from, const TestOrder& order, std::size_t first) const {
  run_.take_up(*from.state);
  MatrixXd information = from.information;
  for (std::size_t i = first; i < order.size(); ++i) add(information, run_.run(*order[i]));
  return variance(information);
}

TestOrder TestChoice::exchanged(TestOrder order, int passes) const {
  for (int pass = 0; pass < passes; ++pass) {
    // The information of what follows each block, as it is now.
    std::vector<MatrixXd> own;
    std::vector<Stage> stages;
    run_.take_up(*start_.state);
    MatrixXd sum;
    for (const TestBlock* block : order) {
      const auto state = run_.keep();
      own.push_back(run_.run(*block));
      if (sum.size() == 0) sum = MatrixXd::Zero(own.back().rows(), own.back().cols());
      stages.push_back({state, sum});
      sum += own.back();
    }
    double now = variance(sum);
    bool changed = false;
    core::Progress progress("exchanging blocks", std::max<std::size_t>(1, order.size()));
    Stage at = stages.front();
    for (std::size_t i = 0; i < order.size(); ++i) {
      MatrixXd after = MatrixXd::Zero(sum.rows(), sum.cols());
      for (std::size_t k = i + 1; k < order.size(); ++k) after += own[k];
      std::vector<std::pair<double, const TestBlock*>> replacements;
      for (const TestBlock& block : blocks_) {
        if (&block == order[i] || std::abs(block.seconds() - order[i]->seconds()) > fits_s) continue;
        run_.take_up(*at.state);
        replacements.emplace_back(variance(at.information + run_.run(block) + after), &block);
      }
      std::sort(replacements.begin(), replacements.end(),
                [](const auto& a, const auto& b) { return a.first < b.first; });
      if (replacements.size() > promising) replacements.resize(promising);
      for (const auto& [promise, block] : replacements) {
        if (promise >= now) break;
        TestOrder other = order;
        other[i] = block;
        const double then = run_on(at, other, i);
        if (then >= (1.0 - least_gain) * now) continue;
        order = std::move(other);
        now = then;
        changed = true;
        break;
      }
      run_.take_up(*at.state);
      own[i] = run_.run(*order[i]);
      at = {run_.keep(), at.information + own[i]};
      progress.advance();
    }
    if (!changed) break;
  }
  return order;
}

TestOrder TestChoice::shortened(TestOrder order, double variance_um2) const {
  const TestPath path = evaluate(order);
  const auto reached = std::find_if(path.variance_um2.begin(), path.variance_um2.end(),
                                    [&](double left) { return left <= variance_um2; });
  if (reached == path.variance_um2.end()) return order;
  order.resize(reached - path.variance_um2.begin() + 1);
  std::vector<std::size_t> longest_first(order.size());
  std::iota(longest_first.begin(), longest_first.end(), std::size_t{0});
  std::stable_sort(longest_first.begin(), longest_first.end(),
                   [&](std::size_t a, std::size_t b) { return order[a]->seconds() > order[b]->seconds(); });
  std::vector<char> kept(order.size(), 1);
  const auto rest = [&] {
    TestOrder blocks;
    for (std::size_t i = 0; i < order.size(); ++i)
      if (kept[i]) blocks.push_back(order[i]);
    return blocks;
  };
  for (const std::size_t i : longest_first) {
    kept[i] = 0;
    const TestOrder without = rest();
    kept[i] = without.empty() || run_on(start_, without, 0) > variance_um2;
  }
  return rest();
}

TestOrder TestChoice::random(double seconds, std::uint64_t seed) const {
  std::mt19937_64 engine(seed);
  TestOrder order;
  for (double left = seconds;;) {
    std::vector<const TestBlock*> fitting;
    for (const TestBlock& block : blocks_)
      if (block.seconds() <= left + fits_s) fitting.push_back(&block);
    if (fitting.empty()) return order;
    order.push_back(fitting[engine() % fitting.size()]);
    left -= order.back()->seconds();
  }
}

}  // namespace thermotwin::study
