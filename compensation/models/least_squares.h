// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Least squares with intercept and ridge, the choice of its strength on blocks of the training data,
// and searches for the few parameters that enter nonlinearly.

#include <Eigen/Core>

#include <functional>
#include <string>
#include <vector>

namespace thermotwin::compensation {

/// target = intercept + features * gains
struct Line {
  Eigen::VectorXd gains;
  double intercept = 0.0;
  double squares = 0.0;  ///< sum of squared residuals
  Eigen::Index rows = 0;
};

/// Ordinary least squares; the smallest gains where features depend on each other (a constant
/// temperature says nothing beside the intercept). Rows with NaN are left out.
/// @throws InputError (place) unless there are at least two rows more than features
Line fit_line(const Eigen::MatrixXd& features, const Eigen::VectorXd& target, const std::string& place);

/// Minimises |target - line|^2 + ridge * rows * sum (scale_k gain_k)^2, scale_k the standard
/// deviation of feature k; needs three rows only.
Line fit_ridge(const Eigen::MatrixXd& features, const Eigen::VectorXd& target, double ridge, const std::string& place);

/// Fits on all but one of `folds` consecutive segments of the complete rows, tests on that one, for
/// each ridge. @return (ridges) mean squared residual
Eigen::VectorXd block_errors(const Eigen::MatrixXd& features, const Eigen::VectorXd& target,
                             const std::vector<double>& ridges, int folds, const std::string& place);

struct Minimum {
  Eigen::VectorXd at;
  double value = 0;
  int evaluations = 0;
};
/// Simplex search (Nelder and Mead 1965). @param step  (n) first edge lengths
Minimum simplex_search(const std::function<double(const Eigen::VectorXd&)>& function, const Eigen::VectorXd& start,
                       const Eigen::VectorXd& step, int most_evaluations, double tolerance);

/// Gradient search for a sum of squares (Levenberg and Marquardt). The function returns residuals
/// and fills their Jacobian; `admit` (optional) moves a trial point into what is allowed.
struct SquaresProblem {
  std::function<Eigen::VectorXd(const Eigen::VectorXd&, Eigen::MatrixXd*)> residuals;
  std::function<void(Eigen::VectorXd&)> admit;
};
Minimum least_squares_search(const SquaresProblem& problem, const Eigen::VectorXd& start, int most_iterations);

}  // namespace thermotwin::compensation
