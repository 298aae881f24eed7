// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Law of propagation of uncertainty (JCGM 100:2008, 5.1 and 5.2) of a budget: u^2 = c^T S c with the sensitivities c
// and the covariance S of the inputs. Effective degrees of freedom by Welch and Satterthwaite; inputs that correlate
// count as one term with the fewest degrees of freedom among them. The expanded uncertainty is that of a t
// distribution.

#include <Eigen/Core>

#include "metrology/budget/budget.h"

namespace thermotwin::metrology {

struct GumResult {
  Eigen::VectorXd value, std;          ///< (quantities) estimate, combined standard uncertainty
  Eigen::MatrixXd sensitivity;         ///< (quantities x inputs) c, by central differences
  Eigen::MatrixXd contribution;        ///< (quantities x inputs) c u
  Eigen::MatrixXd correlation;         ///< (quantities x quantities); 0 beside a quantity without uncertainty
  Eigen::VectorXd degrees_of_freedom;  ///< (quantities) effective, may be infinite
  Eigen::VectorXd factor, expanded;    ///< (quantities) k, U = k u
};

/// @throws InputError where a formula has no finite value beside the estimates
GumResult gum(const Budget& budget);

}  // namespace thermotwin::metrology
