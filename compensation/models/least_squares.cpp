// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/least_squares.h"

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/error.h"
#include "core/minimum_norm.h"

namespace thermotwin::compensation {

using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

namespace {

std::vector<Index> complete(const MatrixXd& features, const VectorXd& target) {
  std::vector<Index> rows;
  for (Index i = 0; i < target.size(); ++i) {
    if (std::isfinite(target[i]) && features.row(i).allFinite()) rows.push_back(i);
  }
  return rows;
}

/// Ridge lines through one set of normal equations.
class Normal {
public:
  Normal(const MatrixXd& x, const VectorXd& z) : rows_(x.rows()) {
    mean_ = x.colwise().mean();
    mean_z_ = z.mean();
    const MatrixXd centred = x.rowwise() - mean_;
    scale_ = (centred.colwise().squaredNorm() / rows_).cwiseSqrt();
    // A feature that does not move has no gain to tell.
    const double least = 1e-9 * (mean_.cwiseAbs().maxCoeff() + 1e-30);
    for (Index k = 0; k < scale_.size(); ++k)
      scale_[k] = scale_[k] > least ? scale_[k] : std::numeric_limits<double>::infinity();
    scaled_ = centred * scale_.cwiseInverse().asDiagonal();
    products_ = scaled_.transpose() * scaled_;
    right_ = scaled_.transpose() * (z.array() - mean_z_).matrix();
  }

  Line line(double ridge) const {
    MatrixXd matrix = products_;
    matrix.diagonal().array() += (ridge + 1e-12) * rows_;
    Line line;
    line.rows = rows_;
    line.gains = matrix.ldlt().solve(right_).cwiseQuotient(scale_.transpose());
    line.intercept = mean_z_ - mean_.dot(line.gains);
    return line;
  }

private:
  Index rows_;
  RowVectorXd mean_, scale_;
  double mean_z_ = 0;
  MatrixXd scaled_, products_;
  VectorXd right_;
};

double squares_of(const Line& line, const MatrixXd& x, const VectorXd& z) {
  return (z - x * line.gains - VectorXd::Constant(z.size(), line.intercept)).squaredNorm();
}

void require_rows(Index found, Index needed, const std::string& place) {
  if (found < needed)
    throw InputError(place, fmt::format("{} complete rows", found), fmt::format("at least {}", needed));
}

}  // namespace

Line fit_line(const MatrixXd& features, const VectorXd& target, const std::string& place) {
  const std::vector<Index> good = complete(features, target);
  const Index n = std::ssize(good), k = features.cols();
  if (n < k + 2) {
    throw InputError(place, fmt::format("{} complete rows to fit {} parameters", n, k + 1),
                     "more rows than parameters");
  }
  const MatrixXd x = features(good, Eigen::all);
  const VectorXd z = target(good);
  const RowVectorXd mean = x.colwise().mean();
  const MatrixXd centred = x.rowwise() - mean;
  Line line;
  line.rows = n;
  line.gains = core::minimum_norm_solution(centred, (z.array() - z.mean()).matrix());
  line.intercept = z.mean() - mean.dot(line.gains);
  line.squares = squares_of(line, x, z);
  return line;
}

Line fit_ridge(const MatrixXd& features, const VectorXd& target, double ridge, const std::string& place) {
  const std::vector<Index> good = complete(features, target);
  require_rows(std::ssize(good), 3, place);
  const MatrixXd x = features(good, Eigen::all);
  const VectorXd z = target(good);
  Line line = Normal(x, z).line(ridge);
  line.squares = squares_of(line, x, z);
  return line;
}

VectorXd block_errors(const MatrixXd& features, const VectorXd& target, const std::vector<double>& ridges, int folds,
                      const std::string& place) {
  const std::vector<Index> good = complete(features, target);
  const auto n = std::ssize(good);
  require_rows(n, 4 * folds, place);
  const MatrixXd x = features(good, Eigen::all);
  const VectorXd z = target(good);
  VectorXd errors = VectorXd::Zero(std::ssize(ridges));
  for (int f = 0; f < folds; ++f) {
    const Index from = f * n / folds, to = (f + 1) * n / folds, out = to - from;
    MatrixXd kept(n - out, x.cols());
    VectorXd kept_z(n - out);
    kept << x.topRows(from), x.bottomRows(n - to);
    kept_z << z.head(from), z.tail(n - to);
    const Normal normal(kept, kept_z);
    for (std::size_t r = 0; r < ridges.size(); ++r) {
      errors[r] += squares_of(normal.line(ridges[r]), x.middleRows(from, out), z.segment(from, out)) / n;
    }
  }
  return errors;
}

Minimum simplex_search(const std::function<double(const VectorXd&)>& function, const VectorXd& start,
                       const VectorXd& step, int most_evaluations, double tolerance) {
  const Index n = start.size();
  std::vector<std::pair<double, VectorXd>> simplex;
  Minimum result;
  const auto add = [&](const VectorXd& at) {
    ++result.evaluations;
    const double value = function(at);
    return std::pair{std::isnan(value) ? std::numeric_limits<double>::infinity() : value, at};
  };
  simplex.push_back(add(start));
  for (Index i = 0; i < n; ++i) {
    VectorXd corner = start;
    corner[i] += step[i];
    simplex.push_back(add(corner));
  }
  const auto by_value = [](const auto& a, const auto& b) { return a.first < b.first; };
  while (true) {
    std::stable_sort(simplex.begin(), simplex.end(), by_value);
    const double best = simplex.front().first, worst = simplex.back().first;
    if (result.evaluations >= most_evaluations || worst - best <= tolerance * (std::abs(best) + 1e-300)) break;
    VectorXd centre = VectorXd::Zero(n);
    const double corners = n;
    for (std::size_t i = 0; i + 1 < simplex.size(); ++i) centre += simplex[i].second / corners;
    const VectorXd away = centre - simplex.back().second;
    auto reflected = add(centre + away);
    if (reflected.first < best) {
      auto expanded = add(centre + 2.0 * away);
      simplex.back() = expanded.first < reflected.first ? std::move(expanded) : std::move(reflected);
    } else if (reflected.first < simplex[simplex.size() - 2].first) {
      simplex.back() = std::move(reflected);
    } else {
      const bool outside = reflected.first < worst;
      auto contracted = add(centre + (outside ? 0.5 : -0.5) * away);
      if (contracted.first < std::min(reflected.first, worst)) {
        simplex.back() = std::move(contracted);
      } else {
        for (std::size_t i = 1; i < simplex.size(); ++i)
          simplex[i] = add(0.5 * (simplex[i].second + simplex[0].second));
      }
    }
  }
  result.value = simplex.front().first;
  result.at = simplex.front().second;
  return result;
}

Minimum least_squares_search(const SquaresProblem& problem, const VectorXd& start, int most_iterations) {
  Minimum result{start, 0.0, 1};
  if (problem.admit) problem.admit(result.at);
  MatrixXd jacobian;
  VectorXd residual = problem.residuals(result.at, &jacobian);
  result.value = residual.squaredNorm();
  double damping = 1e-3;
  for (int i = 0; i < most_iterations && std::isfinite(result.value); ++i) {
    const MatrixXd products = jacobian.transpose() * jacobian;
    const VectorXd gradient = jacobian.transpose() * residual;
    bool moved = false;
    double change = 0.0;
    while (!moved && damping < 1e12) {
      MatrixXd matrix = products;
      matrix.diagonal().array() +=
          damping * (products.diagonal().array() + 1e-12 * products.diagonal().maxCoeff() + 1e-300);
      VectorXd trial = result.at - matrix.ldlt().solve(gradient);
      if (!trial.allFinite()) {
        damping *= 10.0;
        continue;
      }
      if (problem.admit) problem.admit(trial);
      MatrixXd trial_jacobian;
      VectorXd trial_residual = problem.residuals(trial, &trial_jacobian);
      ++result.evaluations;
      const double value = trial_residual.squaredNorm();
      if (value < result.value) {
        change = (result.value - value) / result.value;
        result.at = trial;
        result.value = value;
        residual = std::move(trial_residual);
        jacobian = std::move(trial_jacobian);
        damping = std::max(damping * 0.2, 1e-12);
        moved = true;
      } else {
        damping *= 5.0;
      }
    }
    if (!moved || change < 1e-10) break;
  }
  return result;
}

}  // namespace thermotwin::compensation
