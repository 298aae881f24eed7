// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// First-order and total sensitivities (Sobol 1993) of many outputs together: the variance is the sum of the variances
// of all outputs (Lamboni, Monod and Makowski 2011), so that directions, poses and times count by their size in um^2.
//
// pick_freeze: rows of B and AB_i have parameter i in common, rows of A and AB_i all others. The correlation of the
// former is the first-order share (Janon et al. 2014); that of A and B, which is by chance, is taken away from it times
// that of A and AB_i (Glen and Isaacs 2012). 1 less the latter is the total share (Jansen 1999). All are from 0 to 1.
// by_regression: polynomials of degree 2 in each parameter, with the products of the parameters that matter most,
// fitted to any sample of independent parameters. The variance that they leave counts to the upper ends.
// 95 % intervals of both are by the jackknife over samples: of pick_freeze on Fisher's scale of a correlation, with
// Student's quantile; of a regression on the scale of the square root, where a share near 0 is symmetric. An estimate
// lies in its interval.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "study/plan/distribution.h"

namespace thermotwin::study {

struct Share {
  double value = 0, low = 0, high = 0;  ///< share of the variance, 95 % interval
};

struct Sensitivity {
  std::vector<Share> first, total;  ///< one a parameter
  double variance = 0;              ///< sum over the outputs, unit^2
  double unexplained = 0;           ///< share of the variance that a regression leaves in samples it has not seen
  int products = 0;                 ///< pairs of parameters in the regression
};

/// @param outputs  rows A, B, AB_1 ... AB_d of each sample, (samples (d + 2) x outputs)
/// @throws InputError for fewer than 4 samples
Sensitivity pick_freeze(const Eigen::MatrixXd& outputs, int parameters);

/// @param values   (samples x parameters), drawn from the distributions
/// @param outputs  (samples x outputs)
/// @throws InputError where the samples are not more than twice the parameters
Sensitivity by_regression(const Eigen::MatrixXd& values, const std::vector<Distribution>& distributions,
                          const Eigen::MatrixXd& outputs);

/// @return the smallest number of samples that by_regression() takes
inline int least_samples(int parameters) { return 2 * parameters + 4; }

/// Fewer columns with the same inner products of rows, after their mean is taken away: the sums of variances and of
/// products over all outputs are those of the scores. @return (rows x at most rows)
Eigen::MatrixXd scores_of(const Eigen::MatrixXd& outputs);

}  // namespace thermotwin::study
