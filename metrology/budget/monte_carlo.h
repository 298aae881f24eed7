// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Propagation of distributions (JCGM 101:2008, clause 7) of a budget, and its comparison with the law of propagation
// of uncertainty (clause 8). Inputs with finite degrees of freedom are drawn from scaled t distributions (6.4.9);
// correlated inputs from joint normal scores, which is the joint normal or t distribution where all of them are normal.
// Results are the same for any number of threads.

#include <Eigen/Core>

#include <cstdint>
#include <vector>

#include "metrology/budget/budget.h"
#include "metrology/budget/gum.h"

namespace thermotwin::metrology {

struct CoverageInterval {
  double low = 0, high = 0;
};

struct MonteCarloResult {
  Eigen::VectorXd mean, std;                ///< (quantities)
  Eigen::MatrixXd correlation;              ///< (quantities x quantities)
  std::vector<CoverageInterval> symmetric;  ///< (quantities) of equal probability on both sides
  std::vector<CoverageInterval> shortest;   ///< (quantities)
  Eigen::VectorXd end_std;                  ///< (quantities) of the ends of the symmetric interval, from blocks
  Eigen::MatrixXd draws;                    ///< (draws x quantities)
};

/// @throws InputError where a draw of the inputs gives no finite value, with their share
MonteCarloResult monte_carlo(const Budget& budget);

/// undecided: the ends of the draws are not known well enough to say so.
enum class Agreement { agree, disagree, undecided };

/// Clause 8 for one measurand: the intervals y +- U and that of the draws agree within the tolerance of u.
struct Comparison {
  double tolerance = 0;                  ///< half a unit of the last significant digit of u; of 0 that of rounding
  double low_apart = 0, high_apart = 0;  ///< between the ends of both intervals
  Agreement agreement = Agreement::agree;
  bool enough_draws = false;  ///< the ends of the draws are known to a fifth of the tolerance, 2 standard deviations
};
Comparison compare(const Budget& budget, const GumResult& gum, const MonteCarloResult& draws, Eigen::Index quantity);

/// Half a unit of the last of so many significant digits of a standard uncertainty; 0 of 0.
double numerical_tolerance(double std, int digits);

}  // namespace thermotwin::metrology
