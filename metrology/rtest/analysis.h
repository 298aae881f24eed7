// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Location and component errors from the points of an R-Test or of a volumetric grid by least squares on the kinematic
// chain. The deviation of a point is the sum of the motions of all errors there (error_terms.h), of harmonics and of a
// drift:
//   d(p, t) = sum_e M_e(p) e + sign sum_n Q (a_n cos n theta + b_n sin n theta) + drift(p, t).
// If the cycle has points at several places of the table, a shift of the table's surface across its axis is estimated
// too, and its effect is subtracted.
//
// Harmonics: component errors of the outermost axis that moves, theta its position, in the frame Q of the body on which
// it stands. Like location errors they are motions of what the axis carries: sign is -1 where it carries the workpiece
// and 1 where it carries the tool.
//
// Drift: 0 in the middle of the cycle. It is estimated where the cycle measures points twice: first a drift that is
// common to all points and linear in time, then the drift of growth and of rotations and a common one of second order,
// as far as the repeated points distinguish them. Only differences between visits of the same place determine it. In a
// joint fit with the errors, axis errors that are not estimated would be taken for drift.
//
// Covariance: std^2 W W^T, with std the stated uncertainty of a coordinate and W the map from the deviations to the
// errors. A cycle without a repeated point also has the mean square of the other cycles' drift. Errors against the
// first cycle have the sum of both covariances. Systematic errors of probes and linear axes are not contained: they
// belong into a budget. An error has no value (it is not observable) where other errors have the same effect on all
// points.

#include "metrology/fit/estimates.h"
#include "metrology/rtest/record.h"

namespace thermotwin::metrology {

using RTestAnalysis = Estimates;

/// @throws InputError: a cycle with fewer coordinates than parameters, no error that is observable
RTestAnalysis analyse(const RTestRecord& record);

}  // namespace thermotwin::metrology
