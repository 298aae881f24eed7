// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Location and component errors from the points of an R-Test or of a volumetric grid by least squares on the kinematic
// chain. The deviation of a point is the sum of the motions of all errors there (error_terms.h), of a drift and of
// harmonics:
//   d(p, t) = sum_e M_e(p) e + s sum_n Q (a_n cos n theta + b_n sin n theta) + drift(p, t),
// less a shift of the table's surface across its axis where the cycle has points at several places of the table. The
// drift over the cycle is 0 in its middle. It is a common one of all points, linear in time, where the cycle measures a
// point twice; then the drift of growth and of rotations, and a common one of the second order, as far as the repeated
// points distinguish them. Only differences between visits of the same place count: with columns of drift in the same
// fit, errors of the axis that are not estimated would be taken for drift. The harmonics are component errors of the
// outermost axis that moves, in the frame Q of the body on which it stands; like its location errors they are motions
// of what the axis carries, so that s is -1 where it carries the workpiece and 1 where it carries the tool. An error is
// not observable where other errors have the same effect on all points; it has no value then. The covariance is s^2 W
// W^T with the stated uncertainty of a coordinate and the map W from the deviations to the errors. A cycle without a
// repeated point has the mean square of the drift of the others in it. Against a first cycle both add up. Systematic
// errors of probes and linear axes are not in it: they belong into a budget.

#include "metrology/fit/estimates.h"
#include "metrology/rtest/record.h"

namespace thermotwin::metrology {

using RTestAnalysis = Estimates;

/// @throws InputError: a cycle with fewer coordinates than parameters, no error that is observable
RTestAnalysis analyse(const RTestRecord& record);

}  // namespace thermotwin::metrology
