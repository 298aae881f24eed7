// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Evidence of a linear-Gaussian model with nuisance parameters. The whitened residual is r = A u + e with e ~ N(0, 1)
// and the deviations u ~ N(0, S) of the parameters from nominal, S diagonal. By Woodbury's identity only
// (parameters x parameters) matrices are factorised:
//   -2 log p(r) = n log 2 pi + log det(1 + S^1/2 A^T A S^1/2) + r^T r - b^T (S^-1 + A^T A)^-1 b,
//   b = A^T r.
// A cause is a parameter whose prior is widened from its nominal to a cause's standard deviation.
// That changes the precision by a diagonal of one or two entries, so the evidence of every single
// cause and every pair follows from the posterior under nominal priors at no cost.

#include <Eigen/Core>

#include <span>

namespace thermotwin::diagnosis {

class LinearEvidence {
public:
  /// @param sensitivity  (n x p) whitened, per unit of each parameter
  /// @param residual     (n) whitened
  /// @param prior_std    (p) > 0
  LinearEvidence(const Eigen::MatrixXd& sensitivity, const Eigen::VectorXd& residual, const Eigen::VectorXd& prior_std);

  /// log p(r) of the whitened residual (without the whitening's own determinant).
  double log_evidence() const { return log_evidence_; }
  /// Posterior of the deviations under the priors given.
  const Eigen::VectorXd& mean() const { return mean_; }
  const Eigen::MatrixXd& covariance() const { return covariance_; }

  /// The same data with some priors widened.
  struct Widened {
    double log_ratio = 0;       ///< log evidence minus that of the priors given
    double chi_square = 0;      ///< of the residual under these priors, see chi_square()
    Eigen::VectorXd mean, std;  ///< posterior of the widened ones, in the order asked for
  };
  /// @param which  indices of parameters, distinct   @param std  their new prior
  Widened widen(std::span<const int> which, std::span<const double> std) const;

  /// r^T r - b^T (..)^-1 b: chi-square of n degrees of freedom if the model holds.
  double chi_square() const { return chi_square_; }

private:
  Eigen::VectorXd prior_std_, mean_;
  Eigen::MatrixXd covariance_;
  double log_evidence_ = 0, chi_square_ = 0;
};

}  // namespace thermotwin::diagnosis
