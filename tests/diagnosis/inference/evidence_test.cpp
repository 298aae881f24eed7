// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/inference/evidence.h"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "core/error.h"
#include "core/thread_pool.h"
#include "diagnosis/statistics/covariance.h"

namespace {

using namespace thermotwin;
using diagnosis::ChannelCovariance;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd random_matrix(Index rows, Index cols, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, cols, [&] { return normal(random); });
}

std::vector<ChannelCovariance> some_channels(std::mt19937_64& random) {
  std::vector<ChannelCovariance> channels;
  for (const Index n : {7, 4, 9}) {
    ChannelCovariance c;
    c.time = VectorXd::LinSpaced(n, 0, 600.0 * (n - 1));
    c.time[n - 1] += 500;  // irregular
    c.noise_variance = random_matrix(n, 1, random).cwiseAbs2().array() + 0.05;
    c.shapes = 0.3 * random_matrix(n, 2, random);
    c.wander = {{0.4, 2000.0}, {0.2, 300.0}};
    channels.push_back(c);
  }
  return channels;
}

MatrixXd dense(const std::vector<ChannelCovariance>& channels) {
  Index n = 0;
  for (const auto& c : channels) n += c.time.size();
  MatrixXd all = MatrixXd::Zero(n, n);
  Index at = 0;
  for (const auto& c : channels) {
    const Index m = c.time.size();
    for (Index i = 0; i < m; ++i) {
      for (Index j = 0; j < m; ++j) {
        double v = c.shapes.row(i).dot(c.shapes.row(j)) + (i == j ? c.noise_variance[i] : 0.0);
        for (const auto& w : c.wander)
          v += w.std * w.std * std::exp(-std::abs(c.time[i] - c.time[j]) / w.time_constant);
        all(at + i, at + j) = v;
      }
    }
    at += m;
  }
  return all;
}

/// log N(r; 0, cov) by the definition.
double log_density(const VectorXd& r, const MatrixXd& cov) {
  const Eigen::FullPivLU<MatrixXd> lu(cov);
  return -0.5 * (r.size() * std::log(2 * std::numbers::pi) + std::log(lu.determinant()) + r.dot(lu.solve(r)));
}

struct Sample {
  std::vector<ChannelCovariance> channels;
  MatrixXd base, columns;
  VectorXd residual, prior;
};
Sample sample() {
  std::mt19937_64 random(7);
  Sample s;
  s.channels = some_channels(random);
  s.base = dense(s.channels);
  s.columns = random_matrix(20, 6, random);
  s.columns.col(4) = 0.9 * s.columns.col(1) + 0.05 * s.columns.col(4);  // nearly the same effect
  s.residual = 2.0 * random_matrix(20, 1, random) + 3.0 * s.columns.col(1);
  s.prior = (VectorXd(6) << 0.1, 0.05, 1.0, 0.3, 0.02, 0.2).finished();
  return s;
}

TEST(Evidence, EqualsTheDenseGaussian) {
  const Sample s = sample();
  const diagnosis::Whitener whitener(s.channels);
  const diagnosis::LinearEvidence evidence(whitener.whiten(s.columns), whitener.whiten(s.residual), s.prior);
  const MatrixXd cov = s.base + s.columns * s.prior.cwiseAbs2().asDiagonal() * s.columns.transpose();
  EXPECT_NEAR(evidence.log_evidence() - 0.5 * whitener.log_determinant(), log_density(s.residual, cov), 1e-8);
  EXPECT_NEAR(evidence.chi_square(), s.residual.dot(cov.inverse() * s.residual), 1e-8);
}

TEST(Evidence, PosteriorEqualsTheConditionalGaussian) {
  const Sample s = sample();
  const diagnosis::Whitener whitener(s.channels);
  const diagnosis::LinearEvidence evidence(whitener.whiten(s.columns), whitener.whiten(s.residual), s.prior);
  const MatrixXd prior = s.prior.cwiseAbs2().asDiagonal();
  const MatrixXd gain = prior * s.columns.transpose() * (s.base + s.columns * prior * s.columns.transpose()).inverse();
  EXPECT_LT((evidence.mean() - gain * s.residual).norm(), 1e-9);
  EXPECT_LT((evidence.covariance() - (prior - gain * s.columns * prior)).norm(), 1e-9);
}

TEST(Evidence, WidenedPriorsEqualANewComputation) {
  const Sample s = sample();
  const diagnosis::Whitener whitener(s.channels);
  const MatrixXd columns = whitener.whiten(s.columns);
  const VectorXd residual = whitener.whiten(s.residual);
  const diagnosis::LinearEvidence evidence(columns, residual, s.prior);
  const std::vector<std::vector<int>> sets = {{1}, {4}, {0}, {1, 4}, {5, 1}, {2, 3}};
  for (const std::vector<int>& which : sets) {
    std::vector<double> wide;
    VectorXd prior = s.prior;
    for (const int i : which) prior[i] *= 12.0, wide.push_back(prior[i]);
    const diagnosis::LinearEvidence direct(columns, residual, prior);
    const auto widened = evidence.widen(which, wide);
    EXPECT_NEAR(widened.log_ratio, direct.log_evidence() - evidence.log_evidence(), 1e-8);
    EXPECT_NEAR(widened.chi_square, direct.chi_square(), 1e-8);
    EXPECT_LT(widened.chi_square, evidence.chi_square());
    for (std::size_t k = 0; k < which.size(); ++k) {
      EXPECT_NEAR(widened.mean[k], direct.mean()[which[k]], 1e-9);
      EXPECT_NEAR(widened.std[k], std::sqrt(direct.covariance()(which[k], which[k])), 1e-9);
    }
  }
}

TEST(Evidence, OfDataDrawnFromTheModelHasTheRightChiSquare) {
  // Mean of chi-square over draws is the number of values; a slip in the covariance shows at once.
  std::mt19937_64 random(3);
  const auto channels = some_channels(random);
  const MatrixXd columns = random_matrix(20, 3, random);
  const VectorXd prior = VectorXd::Constant(3, 0.7);
  const MatrixXd cov = dense(channels) + 0.49 * columns * columns.transpose();
  const MatrixXd root = cov.llt().matrixL();
  const diagnosis::Whitener whitener(channels);
  double sum = 0;
  constexpr int draws = 400;
  for (int i = 0; i < draws; ++i) {
    sum +=
        diagnosis::LinearEvidence(whitener.whiten(columns), whitener.whiten(root * random_matrix(20, 1, random)), prior)
            .chi_square();
  }
  EXPECT_NEAR(sum / draws, 20.0, 4 * std::sqrt(2 * 20.0 / draws));
}

TEST(Covariance, RefusesWhatIsNotPositiveDefinite) {
  ChannelCovariance c;
  c.time = VectorXd::LinSpaced(3, 0, 2);
  c.noise_variance = VectorXd::Constant(3, -1.0);
  c.shapes.setZero(3, 0);
  EXPECT_THROW(diagnosis::Whitener({c}), core::SolverError);
}

TEST(Covariance, WhiteningIsBitwiseTheSameForAnyThreads) {
  const Sample s = sample();
  core::set_thread_count(1);
  const MatrixXd one = diagnosis::Whitener(s.channels).whiten(s.columns);
  core::set_thread_count(4);
  const MatrixXd four = diagnosis::Whitener(s.channels).whiten(s.columns);
  core::set_thread_count(0);
  EXPECT_EQ(one, four);
}

}  // namespace
