// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/budget/monte_carlo.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <random>

#include "core/dense_algebra.h"
#include "core/error.h"
#include "core/statistics.h"
#include "core/thread_pool.h"

namespace thermotwin::metrology {

using core::InputError;
using core::uniform;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double rounding = 1e-13;  ///< of the largest eigenvalue
constexpr Index least_blocks = 10, least_of_block = 100;
constexpr Index block = 10000;  ///< draws with random numbers of their own

/// Normal random numbers, the same with every standard library.
class Normal {
public:
  explicit Normal(std::uint64_t seed) : engine_(seed) {}
  double operator()() {
    if (kept_) {
      kept_ = false;
      return other_;
    }
    const double radius = std::sqrt(-2.0 * std::log1p(-uniform(engine_)));
    const double angle = 2.0 * std::numbers::pi * uniform(engine_);
    other_ = radius * std::sin(angle);
    kept_ = true;
    return radius * std::cos(angle);
  }
  double flat() { return uniform(engine_); }
  /// Chi-square over its degrees of freedom (Marsaglia and Tsang, 2000); degrees >= 1.
  double mean_square(double degrees) {
    const double shape = 0.5 * degrees, boosted = shape < 1.0 ? shape + 1.0 : shape;
    const double d = boosted - 1.0 / 3.0, c = 1.0 / std::sqrt(9.0 * d);
    for (;;) {
      const double x = (*this)(), root = 1.0 + c * x;
      if (root <= 0.0) continue;
      const double v = root * root * root;
      if (std::log1p(-flat()) >= 0.5 * x * x + d - d * v + d * std::log(v)) continue;
      const double gamma = d * v * (shape < 1.0 ? std::pow(1.0 - flat(), 1.0 / shape) : 1.0);
      return gamma / shape;
    }
  }

private:
  std::mt19937_64 engine_;
  double other_ = 0;
  bool kept_ = false;
};

/// Correlation of normal scores whose uniforms have this one (exact for a pair of rectangular distributions).
MatrixXd scores_correlation(const Budget& budget) {
  MatrixXd scores = budget.correlation;
  for (Index i = 0; i < scores.rows(); ++i) {
    for (Index k = 0; k < scores.cols(); ++k) {
      const bool flat = budget.inputs[i].distribution == Distribution::rectangular &&
                        budget.inputs[k].distribution == Distribution::rectangular;
      if (i != k && flat) scores(i, k) = 2.0 * std::sin(std::numbers::pi / 6.0 * scores(i, k));
    }
  }
  return scores;
}

class Drawing {
public:
  explicit Drawing(const Budget& budget) : budget_(budget) {
    const Eigen::SelfAdjointEigenSolver<MatrixXd> parts(scores_correlation(budget));
    // An eigenvalue that is rounding alone would be a share of its root: 1e-8 of two inputs with the correlation -1.
    const VectorXd variances = parts.eigenvalues(),
                   own = (variances.array() > rounding * variances.maxCoeff()).select(variances, 0.0);
    root_ = parts.eigenvectors() * own.cwiseSqrt().asDiagonal();
    for (Index i = 0; i < root_.rows(); ++i) {  // scores of variance 1 where an eigenvalue was cut off
      const double norm = root_.row(i).norm();
      if (norm > 0.0) root_.row(i) /= norm;
    }
    independent_ = budget.correlation.isIdentity(0.0);
    mean_squares_.resize(budget.inputs.size());
    for (const BudgetInput& input : budget.inputs) {
      const auto same = [&](const BudgetInput& other) {
        return other.group == input.group && other.degrees_of_freedom == input.degrees_of_freedom;
      };
      pools_.push_back(std::find_if(budget.inputs.begin(), budget.inputs.end(), same) - budget.inputs.begin());
    }
  }

  void operator()(Normal& random, VectorXd& x) {
    const Index n = x.size();
    for (Index i = 0; i < n; ++i) x[i] = random();
    if (!independent_) x = (root_ * x).eval();
    std::fill(mean_squares_.begin(), mean_squares_.end(), 0.0);
    for (Index i = 0; i < n; ++i) {
      const BudgetInput& input = budget_.inputs[i];
      x[i] = input.value + input.std * standard(input, x[i], mean_squares_[pools_[i]], random);
    }
  }

private:
  /// Of variance 1 from a normal score.
  /// @param mean_square  one for correlated inputs of the same degrees of freedom; 0: not yet drawn
  static double standard(const BudgetInput& input, double score, double& mean_square, Normal& random) {
    if (input.distribution == Distribution::normal) {
      if (std::isinf(input.degrees_of_freedom)) return score;
      if (mean_square == 0.0) mean_square = random.mean_square(input.degrees_of_freedom);
      return score / std::sqrt(mean_square);
    }
    const double share = 0.5 * std::erfc(-score * std::numbers::sqrt2 / 2.0), width = half_width(input, random);
    if (input.distribution == Distribution::rectangular) return width * std::sqrt(3.0) * (2.0 * share - 1.0);
    if (input.distribution == Distribution::arcsine)
      return width * std::numbers::sqrt2 * std::sin(std::numbers::pi * (share - 0.5));
    return width * std::sqrt(6.0) * (share < 0.5 ? std::sqrt(2.0 * share) - 1.0 : 1.0 - std::sqrt(2.0 * (1.0 - share)));
  }

  /// Limits that are known inexactly (JCGM 101, 6.4.3): the half width in units of the stated one, rectangular, with
  /// the relative standard uncertainty 1 / sqrt(2 nu) that its degrees of freedom stand for (GUM, G.4.2).
  static double half_width(const BudgetInput& input, Normal& random) {
    if (std::isinf(input.degrees_of_freedom)) return 1.0;
    return 1.0 + std::sqrt(1.5 / input.degrees_of_freedom) * (2.0 * random.flat() - 1.0);
  }

  const Budget& budget_;
  MatrixXd root_;
  bool independent_ = true;
  std::vector<double> mean_squares_;
  std::vector<Index> pools_;  ///< (inputs) place of its mean square
};

MatrixXd drawn(const Budget& budget) {
  const Index draws = budget.draws, quantities = std::ssize(budget.quantities);
  MatrixXd values(draws, quantities);
  core::parallel_for(0, (draws + block - 1) / block, [&](std::size_t b) {
    const Budget::Model model(budget);
    Drawing drawing(budget);
    Normal random(budget.seed * 0x9E3779B97F4A7C15ULL + b + 1);
    VectorXd x(std::ssize(budget.inputs));
    const Index first = b * block, last = std::min(draws, first + block);
    for (Index i = first; i < last; ++i) {
      drawing(random, x);
      values.row(i) = model(x).transpose();
    }
  });
  return values;
}

/// @param sorted  rising @return with the end that JCGM 101, 7.7.2 takes: q = p M rounded
CoverageInterval interval_at(const VectorXd& sorted, Index first, Index width) {
  return {sorted[first], sorted[std::min(sorted.size() - 1, first + width)]};
}

void find_intervals(const VectorXd& values, double probability, CoverageInterval& symmetric,
                    CoverageInterval& shortest) {
  VectorXd sorted = values;
  std::sort(sorted.begin(), sorted.end());
  const Index n = sorted.size(), width = std::lround(probability * n);
  symmetric = interval_at(sorted, std::max<Index>(0, (n - width + 1) / 2 - 1), width);
  shortest = symmetric;
  for (Index first = 0; first + width < n; ++first) {
    const CoverageInterval at = interval_at(sorted, first, width);
    if (at.high - at.low < shortest.high - shortest.low) shortest = at;
  }
}

/// Of the ends of an interval of all draws, from the spread between blocks.
double end_deviation(const VectorXd& values, double probability) {
  const Index blocks = std::max(least_blocks, values.size() / block), size = values.size() / blocks;
  if (size < least_of_block) return std::numeric_limits<double>::infinity();
  Eigen::MatrixX2d ends(blocks, 2);
  for (Index b = 0; b < blocks; ++b) {
    CoverageInterval symmetric, shortest;
    find_intervals(values.segment(b * size, size), probability, symmetric, shortest);
    ends.row(b) << symmetric.low, symmetric.high;
  }
  const Eigen::MatrixX2d about = ends.rowwise() - ends.colwise().mean();
  return std::sqrt(about.colwise().squaredNorm().maxCoeff() / (blocks - 1) / blocks);
}

}  // namespace

MonteCarloResult monte_carlo(const Budget& budget) {
  MonteCarloResult result;
  result.draws = drawn(budget);
  const Index n = result.draws.rows(), quantities = result.draws.cols();
  for (Index i = 0; i < quantities; ++i) {
    const Index lost = n - result.draws.col(i).array().isFinite().count();
    if (lost > 0) {
      throw InputError(fmt::format("{} quantity[{}].formula", budget.source, i + 1),
                       fmt::format("no finite value for {} of {} draws", lost, n),
                       "a formula that is defined for all values that the inputs may have");
    }
  }
  result.mean = result.draws.colwise().mean();
  const MatrixXd about = result.draws.rowwise() - result.mean.transpose();
  const MatrixXd covariance = about.transpose() * about / (n - 1);
  result.std = covariance.diagonal().cwiseSqrt();
  result.correlation = MatrixXd::Identity(quantities, quantities);
  result.symmetric.resize(quantities);
  result.shortest.resize(quantities);
  result.end_std.resize(quantities);
  for (Index i = 0; i < quantities; ++i) {
    for (Index k = 0; k < quantities; ++k) {
      const double product = result.std[i] * result.std[k];
      if (i != k) result.correlation(i, k) = product > 0.0 ? covariance(i, k) / product : 0.0;
    }
    find_intervals(result.draws.col(i), budget.probability, result.symmetric[i], result.shortest[i]);
    result.end_std[i] = end_deviation(result.draws.col(i), budget.probability);
  }
  return result;
}

double numerical_tolerance(double std, int digits) {
  if (!(std > 0.0)) return 0.0;
  // u = c 10^l with c of so many digits, rounded as it would be stated.
  double exponent = std::floor(std::log10(std)) - (digits - 1);
  if (std::round(std / std::pow(10.0, exponent)) >= std::pow(10.0, digits)) exponent += 1.0;
  return 0.5 * std::pow(10.0, exponent);
}

Comparison compare(const Budget& budget, const GumResult& gum, const MonteCarloResult& draws, Index quantity) {
  Comparison result;
  // Where contributions cancel each other, u and the ends of both intervals are their rounding.
  const double rounding = 256.0 * std::numeric_limits<double>::epsilon() *
                          (std::abs(gum.value[quantity]) + gum.contribution.row(quantity).cwiseAbs().sum());
  result.tolerance = std::max(numerical_tolerance(gum.std[quantity], budget.digits), rounding);
  const CoverageInterval& interval = draws.symmetric[quantity];
  result.low_apart = std::abs(gum.value[quantity] - gum.expanded[quantity] - interval.low);
  result.high_apart = std::abs(gum.value[quantity] + gum.expanded[quantity] - interval.high);
  const double apart = std::max(result.low_apart, result.high_apart), end_std = draws.end_std[quantity];
  if (apart + end_std > result.tolerance)
    result.agreement = apart - 2.0 * end_std > result.tolerance ? Agreement::disagree : Agreement::undecided;
  result.enough_draws = 2.0 * draws.end_std[quantity] <= 0.2 * result.tolerance;
  return result;
}

}  // namespace thermotwin::metrology
