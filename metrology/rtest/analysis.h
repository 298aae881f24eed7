// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Location errors from the points of an R-Test by least squares on the kinematic chain. The deviation of a
// point is the sum of the motions of all errors there (compensation/chain/location_offsets.h has their definition), of
// a drift and of harmonics:  d(p, t) = sum_e M_e(p) e + tau(t) v + sum_n Q (a_n cos n theta + b_n sin n theta), less a
// shift of the table's surface across its axis where the cycle has points at several places of the table. v is the
// drift over the cycle where it measures a point twice, stated for the middle of the cycle. The harmonics are
// component errors of the outermost axis that moves, in the frame Q of the body on which it stands. An error is not
// observable where other errors have the same effect on all points; it has no value then. The covariance is s^2 (A^T
// A)^-1 with the stated uncertainty of a coordinate; against a first cycle both add up. Systematic errors of probes
// and linear axes are not in it: they belong into a budget.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "metrology/rtest/record.h"

namespace thermotwin::metrology {

struct Harmonic {
  int order = 0;
  Eigen::Vector3d cosine, sine;  ///< m, frame of the body on which the axis stands
};

struct CycleResult {
  double time = 0;             ///< s, middle of the cycle
  Eigen::VectorXd value, std;  ///< (errors) m or rad; NaN: not observable
  Eigen::MatrixXd covariance;  ///< (errors x errors) m^2, m rad, rad^2; NaN as value
  bool drift_estimated = false;
  Eigen::Vector3d drift = Eigen::Vector3d::Zero();      ///< m, over the cycle; 0: not estimated
  Eigen::Vector3d drift_std = Eigen::Vector3d::Zero();  ///< m
  std::vector<Harmonic> harmonics;
  double residual_rms = 0;  ///< m, of a coordinate
  int rank = 0, parameters = 0;
  Eigen::Index degrees_of_freedom = 0;
};

struct RTestAnalysis {
  std::vector<std::string> errors;
  std::vector<CycleResult> cycles;  ///< against the first cycle there is one row of zeros for it
  /// Errors that at least one cycle cannot observe, with those that have the same effect: "Y0B: not observable beside
  /// Y0C". Empty: all are observable.
  std::vector<std::string> not_observable;
  bool turns(std::size_t error) const;  ///< rad rather than m
};

/// @throws InputError: a cycle with fewer coordinates than parameters, no error that is observable
RTestAnalysis analyse(const RTestRecord& record);

}  // namespace thermotwin::metrology
