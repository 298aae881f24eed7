// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/statistics/sensitivity.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"

namespace thermotwin::study {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double deviations95 = 1.959963984540054;
constexpr double nearly_one = 1.0 - 1e-15;
constexpr double nothing_varies = 1e-18;  // share of the outputs' squares below which variance is rounding
constexpr double kept_variance = 1e-10;   // share of the outputs' squares that scores may leave out

double clip(double share) { return std::clamp(share, 0.0, 1.0); }

/// Standard error of each column by the jackknife. @param without  (samples x values) estimates without a sample
VectorXd jackknife(const MatrixXd& without) {
  const double n = without.rows();
  const Eigen::RowVectorXd mean = without.colwise().mean();
  return ((n - 1.0) / n * (without.rowwise() - mean).colwise().squaredNorm()).cwiseSqrt().transpose();
}

/// The quantile of Student's distribution that holds 95 % on both sides (Abramowitz and Stegun 1964, 26.7.5).
double deviations95_of(double degrees) {
  const double z = deviations95, z2 = z * z;
  return z * (1.0 + (z2 + 1.0) / (4.0 * degrees) + ((5.0 * z2 + 16.0) * z2 + 3.0) / (96.0 * std::pow(degrees, 2)) +
              (((3.0 * z2 + 19.0) * z2 + 17.0) * z2 - 15.0) / (384.0 * std::pow(degrees, 3)));
}

/// Two series of samples with equal distributions: sums for their correlation, with and without a sample.
class Correlation {
public:
  Correlation(const MatrixXd& u, const MatrixXd& v)
      : products_(u.cwiseProduct(v).rowwise().sum()),
        squares_(0.5 * (u.rowwise().squaredNorm() + v.rowwise().squaredNorm())),
        means_(0.5 * (u + v)),
        product_(products_.sum()),
        square_(squares_.sum()),
        mean_(means_.colwise().sum()) {}
  double all() const { return of(product_, square_, mean_.squaredNorm(), products_.size()); }
  double without(Index s) const {
    const double mean = (mean_ - means_.row(s)).squaredNorm();
    return of(product_ - products_[s], square_ - squares_[s], mean, products_.size() - 1);
  }

private:
  double of(double product, double square, double mean, Index count) const {
    const double level = mean / count, variance = square - level;
    // Samples that are all alike correlate: what makes no difference has a total share of 0.
    return variance > 1e-14 * square_ ? std::clamp((product - level) / variance, -1.0, 1.0) : 1.0;
  }
  VectorXd products_, squares_;
  MatrixXd means_;
  double product_, square_;
  Eigen::RowVectorXd mean_;
};

/// A correlation with its 95 % interval: by the jackknife on Fisher's scale. @param without  (samples)
Share with_interval(double value, const VectorXd& without) {
  const auto scaled = [](double r) { return std::atanh(std::clamp(r, -nearly_one, nearly_one)); };
  const double half = deviations95_of(without.size() - 1) * jackknife(without.unaryExpr(scaled))[0];
  const double at = scaled(value);
  return {value, std::min(value, std::tanh(at - half)), std::max(value, std::tanh(at + half))};
}

/// Two parameters, by their indices.
struct Pair {
  int i, j;
};

/// The matrix of a regression: 1, first and second degree of each parameter, products.
class Regression {
public:
  Regression(const MatrixXd& values, const std::vector<Distribution>& distributions) {
    const Index n = values.rows(), d = values.cols();
    first_.resize(n, d);
    matrix_.resize(n, 1 + 2 * d);
    matrix_.col(0).setOnes();
    for (Index p = 0; p < d; ++p) {
      const Polynomials of(distributions[p]);
      for (Index k = 0; k < n; ++k) {
        first_(k, p) = of.first(values(k, p));
        matrix_(k, 1 + 2 * p) = first_(k, p);
        matrix_(k, 2 + 2 * p) = of.second(values(k, p));
      }
    }
    // Too few samples for curvature: straight lines.
    curved_ = n >= 3 * (1 + 2 * d);
    if (!curved_) {
      MatrixXd straight(n, 1 + d);
      straight.col(0).setOnes();
      straight.rightCols(d) = first_;
      matrix_ = std::move(straight);
    }
  }

  const MatrixXd& matrix() const { return matrix_; }
  Index parameters() const { return first_.cols(); }
  bool curved() const { return curved_; }
  const std::vector<Pair>& pairs() const { return pairs_; }

  /// Adds products while they are worth more than noise, the best first. @param outputs  (n x r) scores
  void add_products(const MatrixXd& outputs) {
    const Index n = matrix_.rows(), d = first_.cols();
    const Index most = std::max<Index>(0, n / 3 - matrix_.cols());
    std::vector<std::pair<double, Pair>> found;
    const Eigen::LDLT<MatrixXd> factor(MatrixXd(matrix_.transpose() * matrix_));
    const MatrixXd left = outputs - matrix_ * factor.solve(matrix_.transpose() * outputs);
    const double size = left.squaredNorm();
    if (!(size > 0.0)) return;
    for (int i = 0; i < d; ++i) {
      for (int j = i + 1; j < d; ++j) {
        VectorXd product = first_.col(i).cwiseProduct(first_.col(j));
        product -= matrix_ * factor.solve(matrix_.transpose() * product);
        const double square = product.squaredNorm();
        if (square > 1e-9 * n) found.push_back({(left.transpose() * product).squaredNorm() / square / size, {i, j}});
      }
    }
    std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    // By chance alone a product explains 1 / n of what is left.
    const double worth = 8.0 / n;
    for (const auto& [gain, pair] : found) {
      if (gain < worth || std::ssize(pairs_) >= most) break;
      pairs_.push_back(pair);
    }
    MatrixXd wider(n, matrix_.cols() + std::ssize(pairs_));
    wider.leftCols(matrix_.cols()) = matrix_;
    for (std::size_t k = 0; k < pairs_.size(); ++k)
      wider.col(matrix_.cols() + k) = first_.col(pairs_[k].i).cwiseProduct(first_.col(pairs_[k].j));
    matrix_ = std::move(wider);
  }

  /// First-order and total variances from coefficients (columns x r), each (parameters).
  std::pair<VectorXd, VectorXd> variances(const MatrixXd& coefficients) const {
    const Index d = first_.cols(), each = curved_ ? 2 : 1;
    VectorXd first(d);
    for (Index p = 0; p < d; ++p) first[p] = coefficients.middleRows(1 + each * p, each).squaredNorm();
    VectorXd total = first;
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      const double both = coefficients.row(1 + each * d + k).squaredNorm();
      total[pairs_[k].i] += both;
      total[pairs_[k].j] += both;
    }
    return {first, total};
  }

  double products(const MatrixXd& coefficients) const {
    return coefficients.bottomRows(std::ssize(pairs_)).squaredNorm();
  }

private:
  MatrixXd first_, matrix_;
  bool curved_ = true;
  std::vector<Pair> pairs_;
};

/// Whether the samples differ by rounding alone.
bool are_alike(const MatrixXd& outputs) {
  return (outputs.rowwise() - outputs.colwise().mean()).squaredNorm() <= nothing_varies * outputs.squaredNorm();
}

/// Nothing varies, so that nothing has a share of it.
Sensitivity no_shares(Index parameters) {
  Sensitivity none;
  none.first.assign(parameters, {0.0, 0.0, 0.0});
  none.total = none.first;
  return none;
}

}  // namespace

MatrixXd scores_of(const MatrixXd& outputs) {
  const MatrixXd centred = outputs.rowwise() - outputs.colwise().mean();
  const Index n = centred.rows();
  if (centred.cols() <= n) return centred;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(MatrixXd(centred * centred.transpose()));
  const VectorXd squares = eigen.eigenvalues().cwiseMax(0.0);
  const double all = squares.sum();
  Index kept = 0;
  for (double left = all; kept < n && left > kept_variance * all; ++kept) left -= squares[n - 1 - kept];
  MatrixXd scores(n, std::max<Index>(kept, 1));
  for (Index k = 0; k < scores.cols(); ++k)
    scores.col(k) = eigen.eigenvectors().col(n - 1 - k) * std::sqrt(squares[n - 1 - k]);
  return scores;
}

Sensitivity pick_freeze(const MatrixXd& outputs, int parameters) {
  const Index each = parameters + 2, n = outputs.rows() / each;
  if (n < 4 || n * each != outputs.rows()) {
    throw core::InputError("sensitivities", fmt::format("{} rows of {} parameters", outputs.rows(), parameters),
                           fmt::format("4 samples or more of {} rows each", each));
  }
  if (are_alike(outputs)) return no_shares(parameters);
  const MatrixXd scores = scores_of(outputs);
  const auto series = [&](Index row) { return MatrixXd(scores(Eigen::seqN(row, n, each), Eigen::all)); };
  const MatrixXd a = series(0), b = series(1);
  const Correlation by_chance(a, b);
  Sensitivity result;
  const double count = n;
  result.variance =
      (a.squaredNorm() + b.squaredNorm() - (a + b).colwise().sum().squaredNorm() / (2.0 * count)) / (2.0 * count - 1.0);
  for (Index i = 0; i < parameters; ++i) {
    const MatrixXd ab = series(2 + i);
    const Correlation alone(b, ab), others(a, ab);
    VectorXd first(n), rest(n);
    for (Index s = 0; s < n; ++s) {
      rest[s] = others.without(s);
      first[s] = alone.without(s) - rest[s] * by_chance.without(s);
    }
    const Share of_first = with_interval(alone.all() - others.all() * by_chance.all(), first);
    const Share of_rest = with_interval(others.all(), rest);
    result.first.push_back({clip(of_first.value), clip(of_first.low), clip(of_first.high)});
    result.total.push_back({clip(1.0 - of_rest.value), clip(1.0 - of_rest.high), clip(1.0 - of_rest.low)});
  }
  return result;
}

Sensitivity by_regression(const MatrixXd& values, const std::vector<Distribution>& distributions,
                          const MatrixXd& outputs) {
  const Index n = values.rows(), d = values.cols();
  if (n < least_samples(d) || outputs.rows() != n) {
    throw core::InputError("sensitivities", fmt::format("{} samples of {} parameters", n, d),
                           fmt::format("{} samples or more", least_samples(d)));
  }
  if (are_alike(outputs)) return no_shares(d);
  const MatrixXd scores = scores_of(outputs);
  Regression regression(values, distributions);
  regression.add_products(scores);
  const MatrixXd& x = regression.matrix();
  const Eigen::LDLT<MatrixXd> factor(MatrixXd(x.transpose() * x));
  const MatrixXd inverse_x = factor.solve(x.transpose());  // (columns x n)
  const MatrixXd coefficients = inverse_x * scores;
  const MatrixXd left = scores - x * coefficients;
  const VectorXd leverage = x.cwiseProduct(inverse_x.transpose()).rowwise().sum();
  const double degrees = n - x.cols();
  const double noise = left.squaredNorm() / degrees;  // of all outputs together
  // A squared coefficient is too large by its variance.
  const VectorXd column_variance = inverse_x.rowwise().squaredNorm();
  const auto shares = [&](const MatrixXd& b, double rest) {
    const auto [first, total] = regression.variances(b);
    const auto [first_bias, total_bias] = regression.variances((rest * column_variance).cwiseMax(0.0).cwiseSqrt());
    const VectorXd one = (first - first_bias).cwiseMax(0.0), all = (total - total_bias).cwiseMax(0.0);
    const double pairs = regression.products(b) - regression.products((rest * column_variance).cwiseSqrt());
    const double variance = std::max(one.sum() + std::max(pairs, 0.0) + rest, 1e-300);
    VectorXd found(2 * d + 1);
    found << one / variance, all / variance, variance;
    return found;
  };
  const VectorXd found = shares(coefficients, noise);
  double unseen = 0.0;
  MatrixXd without(n, 2 * d);
  for (Index k = 0; k < n; ++k) {
    const double keep = std::max(1.0 - leverage[k], 1e-9);
    const Eigen::RowVectorXd miss = left.row(k) / keep;
    unseen += miss.squaredNorm();
    const double rest = (left.squaredNorm() - left.row(k).squaredNorm() / keep) / std::max(degrees - 1.0, 1.0);
    const MatrixXd b = coefficients - inverse_x.col(k) * miss;
    without.row(k) = shares(b, std::max(rest, 0.0)).head(2 * d).cwiseSqrt().transpose();
  }
  const VectorXd error = jackknife(without);
  Sensitivity result;
  result.variance = found[2 * d];
  result.unexplained = std::min(1.0, unseen / n / result.variance);
  result.products = regression.pairs().size();
  for (Index i = 0; i < 2 * d; ++i) {
    const double root = std::sqrt(found[i]), half = deviations95 * error[i];
    const double low = std::pow(std::max(0.0, root - half), 2), high = std::pow(root + half, 2);
    // What the polynomials leave may be of a parameter alone, or of several.
    (i < d ? result.first : result.total).push_back({found[i], low, clip(high + result.unexplained)});
  }
  return result;
}

}  // namespace thermotwin::study
