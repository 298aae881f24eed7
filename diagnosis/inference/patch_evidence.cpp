// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/inference/patch_evidence.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double unseen = 3e-4;  ///< of the combination of patches that outputs see best
constexpr Index most_combinations = 60;
constexpr double shifts[] = {1e-7, 1.0 / 86400.0, 1.0 / 10800.0, 1.0 / 1200.0};  ///< 1/s

double log_positive_share(double mean, double std) {
  return std::log(std::max(std::erfc(-mean / (std * std::numbers::sqrt2)), 1e-12));
}

}  // namespace

Combinations combinations(const reduction::ReducedModel& model, const MatrixXd& patches, const MatrixXd& rows,
                          const VectorXd& scale, const VectorXd& p) {
  MatrixXd a = model.system.conduction;
  for (Index j = 0; j < p.size(); ++j)
    if (p[j] != 0.0) a += p[j] * model.system.terms[j];
  const Index outputs = rows.rows();
  MatrixXd seen(outputs * std::ssize(shifts), patches.cols());
  for (Index i = 0; i < std::ssize(shifts); ++i) {
    seen.middleRows(outputs * i, outputs) =
        scale.cwiseInverse().asDiagonal() * rows *
        Eigen::PartialPivLU<MatrixXd>(a + shifts[i] * model.system.capacity).solve(patches);
  }
  // Right singular vectors by way of the left ones, which are fewer.
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(MatrixXd(seen * seen.transpose()));
  const VectorXd& squares = eigen.eigenvalues();  // rising
  const Index count = squares.size();
  Index kept = 0;
  while (kept < std::min(count, most_combinations) && squares[count - 1 - kept] > unseen * unseen * squares[count - 1])
    ++kept;
  const MatrixXd directions = seen.transpose() * eigen.eigenvectors().rightCols(kept) *
                              squares.tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
  return {patches * directions, directions.transpose()};
}

MatrixXd between(const MatrixXd& both) {
  const Index patches = both.cols() / 2;
  MatrixXd all(both.rows(), 0);
  for (const double share : spread_shares) {
    all.conservativeResize(Eigen::NoChange, all.cols() + patches);
    all.rightCols(patches) = (1.0 - share) * both.leftCols(patches) + share * both.rightCols(patches);
  }
  return all;
}

MatrixXd over_shares(const MatrixXd& evidence) {
  const Index shares = std::ssize(spread_shares), patches = evidence.rows() / shares;
  MatrixXd mean(patches, evidence.cols());
  for (Index k = 0; k < patches; ++k) {
    for (Index j = 0; j < mean.cols(); ++j) {
      double top = evidence(k, j), sum = 0.0;
      for (Index s = 1; s < shares; ++s) top = std::max(top, evidence(k + s * patches, j));
      for (Index s = 0; s < shares; ++s) sum += std::exp(evidence(k + s * patches, j) - top);
      mean(k, j) = top + std::log(sum / shares);
    }
  }
  return mean;
}

SearchData::SearchData(const Problem& problem, const MatrixXd& responses) {
  const Whitener whitener(problem.fitted_covariance());
  nuisances = whitener.whiten(problem.fitted(problem.columns)) * problem.prior_std.asDiagonal();
  residual = whitener.whiten(problem.fitted(problem.measured - problem.predicted));
  white = whitener.whiten(problem.fitted(responses));
  MatrixXd precision = MatrixXd::Identity(nuisances.cols(), nuisances.cols());
  precision.selfadjointView<Eigen::Lower>().rankUpdate(nuisances.transpose());
  factor.compute(precision);
}

VectorXd evidence_of(const SearchData& seen, const MatrixXd& own, const MatrixXd& weights) {
  const MatrixXd taken = seen.taken(own), gram = own.transpose() * own - taken.transpose() * taken;
  const VectorXd product = own.transpose() * seen.residual - taken.transpose() * seen.taken(seen.residual);
  VectorXd evidence(weights.cols());
  for (Index k = 0; k < weights.cols(); ++k) {
    const VectorXd z = weights.col(k);
    const double square = prior_source_W * prior_source_W * std::max(0.0, z.dot(gram * z)),
                 variance = prior_source_W * prior_source_W / (1.0 + square), mean = variance * z.dot(product);
    evidence[k] =
        -0.5 * std::log1p(square) + 0.5 * mean * mean / variance + log_positive_share(mean, std::sqrt(variance));
  }
  return evidence;
}

MatrixXd all_evidence(const SearchData& seen, const MatrixXd& weights, Index inputs) {
  const Index m = weights.rows();
  MatrixXd evidence(weights.cols(), inputs);
  for (Index j = 0; j < inputs; ++j) evidence.col(j) = evidence_of(seen, seen.white.middleCols(j * m, m), weights);
  return evidence;
}

}  // namespace thermotwin::diagnosis
