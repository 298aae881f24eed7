// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/fit/estimates.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/dense_algebra.h"
#include "core/text.h"
#include "diagnosis/statistics/statistics.h"

namespace thermotwin::metrology {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<std::size_t> Estimates::observed() const {
  std::vector<std::size_t> found;
  for (std::size_t e = 0; e < errors.size(); ++e) {
    if (std::none_of(cycles.begin(), cycles.end(),
                     [&](const CycleResult& cycle) { return std::isnan(cycle.value[e]); })) {
      found.push_back(e);
    }
  }
  return found;
}

LinearFit fit_linear(const MatrixXd& rows, const VectorXd& right) {
  VectorXd scale = rows.colwise().norm();
  const double largest = scale.size() > 0 ? scale.maxCoeff() : 0.0;
  for (double& value : scale)
    if (!(value > 1e-12 * largest)) value = std::max(largest, 1e-300);
  const MatrixXd scaled = rows * scale.cwiseInverse().asDiagonal();
  const Eigen::JacobiSVD<MatrixXd> parts(scaled, Eigen::ComputeThinU | Eigen::ComputeFullV);
  const VectorXd singular = parts.singularValues();
  Index rank = 0;
  while (rank < singular.size() && singular[rank] > weakest * singular[0]) ++rank;
  const MatrixXd v = parts.matrixV().leftCols(rank);
  const VectorXd inverse = singular.head(rank).cwiseInverse();
  LinearFit fit;
  const MatrixXd root = scale.cwiseInverse().asDiagonal() * v * inverse.asDiagonal();
  fit.inverse = root * parts.matrixU().leftCols(rank).transpose();
  fit.value = fit.inverse * right;
  fit.cofactor = root * root.transpose();
  fit.unobserved = parts.matrixV().rightCols(rows.cols() - rank);
  fit.residual = right - rows * fit.value;
  return fit;
}

bool LinearFit::hides(Index parameter) const {
  return unobserved.cols() > 0 && unobserved.row(parameter).norm() > 1e-5;
}

std::string LinearFit::same_effect(const std::vector<std::string>& names, Index parameter,
                                   const std::string& others) const {
  const VectorXd together = unobserved * unobserved.row(parameter).transpose();
  std::vector<std::string> found;
  for (Index i = 0; i < together.size(); ++i) {
    if (i == parameter || std::abs(together[i]) < 1e-5) continue;
    if (i < std::ssize(names)) {
      found.push_back(names[i]);
    } else if (found.empty() || found.back() != others) {
      found.push_back(others);
    }
  }
  return found.empty() ? "no point shows it" : "the points do not distinguish it from " + core::join(found);
}

CycleResult cycle_result(const LinearFit& fit, Index errors, double variance) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  CycleResult result;
  result.parameters = fit.value.size();
  result.rank = result.parameters - fit.unobserved.cols();
  result.degrees_of_freedom = fit.residual.size() - result.rank;
  result.residual = fit.residual;
  result.residual_rms = std::sqrt(fit.residual.squaredNorm() / fit.residual.size());
  result.value = fit.value.head(errors);
  result.covariance = variance * fit.cofactor.topLeftCorner(errors, errors);
  if (fit.inverse.cols() <= most_functional_rows) result.functional = fit.inverse.topRows(errors);
  for (Index e = 0; e < errors; ++e) {
    if (!fit.hides(e)) continue;
    result.value[e] = nan;
    result.covariance.row(e).setConstant(nan);
    result.covariance.col(e).setConstant(nan);
    if (result.functional.size() > 0) result.functional.row(e).setConstant(nan);
  }
  return result;
}

ResidualTest residual_test(const Estimates& estimates, double std) {
  ResidualTest test;
  double squares = 0.0;
  for (const CycleResult& cycle : estimates.cycles) {
    squares += cycle.residual.squaredNorm();
    test.degrees += cycle.degrees_of_freedom;
  }
  if (test.degrees < 1) {
    test.ratio = std::numeric_limits<double>::quiet_NaN();
    return test;
  }
  const double degrees = test.degrees;
  test.ratio = std::sqrt(squares / degrees) / std;
  test.exceeds = diagnosis::chi_square_tail(squares / (std * std), degrees) < residual_probability;
  return test;
}

void complete(std::vector<CycleResult>& cycles, bool against_first) {
  if (against_first) {
    const VectorXd first = cycles.front().value;
    const MatrixXd covariance = cycles.front().covariance;
    for (CycleResult& cycle : cycles) {
      const bool is_first = &cycle == &cycles.front();
      cycle.value -= first;
      if (is_first) {
        cycle.covariance -= covariance;
      } else {
        cycle.covariance += covariance;
      }
    }
  }
  for (CycleResult& cycle : cycles) {
    cycle.std = cycle.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
    for (Index e = 0; e < cycle.std.size(); ++e)
      if (std::isnan(cycle.value[e])) cycle.std[e] = std::numeric_limits<double>::quiet_NaN();
  }
}

}  // namespace thermotwin::metrology
