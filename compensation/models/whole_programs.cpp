// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/whole_programs.h"

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"

namespace thermotwin::compensation {
namespace {

using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Products of [features, 1, target] of the complete rows, summed over rows.
MatrixXd products_of(const ProgramRows& program) {
  const Index n = program.features.cols();
  MatrixXd sums = MatrixXd::Zero(n + 2, n + 2);
  VectorXd row(n + 2);
  for (Index i = 0; i < program.target.size(); ++i) {
    row << program.features.row(i).transpose(), 1.0, program.target[i];
    if (row.allFinite()) sums.selfadjointView<Eigen::Lower>().rankUpdate(row);
  }
  return sums.selfadjointView<Eigen::Lower>();
}

Line line_of(const MatrixXd& sums, double ridge) {
  const Index n = sums.rows() - 2;
  const double rows = sums(n, n);
  const VectorXd mean = sums.col(n).head(n) / rows;
  const double mean_target = sums(n + 1, n) / rows;
  MatrixXd matrix = sums.topLeftCorner(n, n) / rows - mean * mean.transpose();
  VectorXd right = sums.col(n + 1).head(n) / rows - mean * mean_target, scale(n);
  for (Index k = 0; k < n; ++k) {
    // A feature that does not move has no gain.
    constexpr double least_share = 1e-9;
    const double deviation = std::sqrt(std::max(matrix(k, k), 0.0));
    scale[k] = deviation > least_share * (std::abs(mean[k]) + 1e-12) ? 1.0 / deviation : 0.0;
  }
  matrix = scale.asDiagonal() * matrix * scale.asDiagonal();
  matrix.diagonal().array() += ridge + 1e-12;
  right.array() *= scale.array();
  Line line;
  line.gains = scale.asDiagonal() * matrix.ldlt().solve(right);
  line.intercept = mean_target - mean.dot(line.gains);
  line.rows = static_cast<Index>(rows);
  return line;
}

/// Sum of squared residuals of these rows.
double residual_squares(const MatrixXd& sums, const Line& line) {
  VectorXd with(sums.rows());
  with << -line.gains, -line.intercept, 1.0;
  return std::max(with.dot(sums * with), 0.0);
}

}  // namespace

ProgramLine fit_on_programs(const std::vector<ProgramRows>& programs, const std::vector<double>& ridges,
                            const std::string& place) {
  std::vector<MatrixXd> parts;
  for (const ProgramRows& program : programs) parts.push_back(products_of(program));
  MatrixXd all;
  for (const MatrixXd& part : parts) all = all.size() == 0 ? part : MatrixXd(all + part);
  const Index n = all.rows() - 2;
  if (parts.empty() || !(all(n, n) >= 3.0))
    throw InputError(place, fmt::format("{} complete rows", parts.empty() ? 0.0 : all(n, n)), "at least three");
  ProgramLine best;
  best.held_out_rms = std::numeric_limits<double>::infinity();
  for (const double ridge : ridges) {
    double sum = 0.0, count = 0.0;
    for (const MatrixXd& part : parts) {
      if (!(part(n, n) > 0.0)) continue;
      const bool alone = !(all(n, n) - part(n, n) >= 3.0);
      sum += residual_squares(part, line_of(alone ? all : MatrixXd(all - part), ridge)) / part(n, n);
      count += 1.0;
    }
    const double rms = std::sqrt(sum / count);
    if (!(rms < best.held_out_rms)) continue;
    best = {line_of(all, ridge), ridge, rms};
    best.line.squares = residual_squares(all, best.line);
  }
  if (!std::isfinite(best.held_out_rms))
    throw InputError(place, "no finite fit", "temperatures and displacements of usual size");
  return best;
}

}  // namespace thermotwin::compensation
