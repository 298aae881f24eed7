// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The simulation of data that no machine model belongs to, fitted on the first part of the record. Each displacement
// is a sum of first-order elements
//   d(t) = c + sum_i sum_k g_ik y_ik(t),   tau_k dy_ik/dt = u_i - y_ik,
// with every time constant of a grid for each measured temperature (or other input), since heat reaches
// a tool by several ways. Gains have independent Gaussian priors, one width for all elements of an input;
// what is left is an Ornstein-Uhlenbeck process and noise. Widths, process and noise have the largest
// marginal likelihood; gains keep their whole posterior, so that what the first part does not tell widens
// what is expected of the others. The grey box of compensation has the same elements for another end: it predicts
// online with the mean of each gain, from fewer time constants, and takes a start out of balance into account.

#include <Eigen/Core>

#include <vector>

#include "diagnosis/data/data_record.h"
#include "diagnosis/statistics/covariance.h"

namespace thermotwin::diagnosis {

/// One target's elements with the process that is left.
struct LagModel {
  std::vector<double> time_constants;      ///< s, of each input's elements; 0: follows at once
  Eigen::VectorXd prior_std;               ///< (inputs * time constants + 1) of the gains, the constant last
  double wander_std = 0, wander_time = 0;  ///< um (or the target's unit), s
  Eigen::VectorXd noise_std;               ///< (n) of each interval's mean
  Eigen::VectorXd gains;                   ///< posterior means
  Eigen::MatrixXd covariance;              ///< of the gains
  double log_evidence = 0, chi_square = 0;
  Eigen::Index fitted = 0;  ///< values

  /// (n x gains) columns of the elements and of the constant.
  Eigen::MatrixXd columns(const DataRecord& record) const;
  /// What the elements leave over in these rows, without the uncertainty of gains.
  ChannelCovariance left_over(const DataRecord& record, const std::vector<Eigen::Index>& rows) const;
  /// What the target moves, seconds after a step of one unit of the input.
  double step_response(Eigen::Index input, double seconds) const;
};

/// @param rows  of the record that are fitted (NaN targets are left out). No time constant is longer than they last
LagModel fit_lag_model(const DataRecord& record, Eigen::Index target, const std::vector<Eigen::Index>& rows);

}  // namespace thermotwin::diagnosis
