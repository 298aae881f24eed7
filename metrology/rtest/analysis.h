// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Location and component errors from the points of an R-Test or of a volumetric grid by least squares on the kinematic
// chain. The deviation of a point is the sum of the motions of all errors there (error_terms.h), of a drift and of
// harmonics:
//   d(p, t) = sum_e M_e(p) (e + tau(t) r_e) + tau(t) v + sum_n Q (a_n cos n theta + b_n sin n theta),
// less a shift of the table's surface across its axis where the cycle has points at several places of the table. v is
// the drift of all points alike over the cycle where it measures a point twice; errors are those in the middle of the
// cycle. r_e is the drift of growth and rotations, of those errors whose drift the points distinguish from all else:
// least_distinct of its effect is no sum of the other effects. The harmonics are
// component errors of the outermost axis that moves, in the frame Q of the body on which it stands. An error is not
// observable where other errors have the same effect on all points; it has no value then. The covariance is s^2 (A^T
// A)^-1 with the stated uncertainty of a coordinate; against a first cycle both add up. Systematic errors of probes
// and linear axes are not in it: they belong into a budget.

#include "metrology/fit/estimates.h"
#include "metrology/rtest/record.h"

namespace thermotwin::metrology {

using RTestAnalysis = Estimates;

/// @throws InputError: a cycle with fewer coordinates than parameters, no error that is observable
RTestAnalysis analyse(const RTestRecord& record);

}  // namespace thermotwin::metrology
