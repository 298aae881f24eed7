// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The lag model, which replaces the simulation where no machine is given. It is fitted to the first part of the record.
// Each displacement is a sum of first-order elements
//   d(t) = c + sum_i sum_k g_ik y_ik(t),   tau_k dy_ik/dt = u_i - y_ik,
// with every time constant of a grid for each measured temperature (or other input), since heat reaches
// a tool by several ways. Gains have independent Gaussian priors, one width for all elements of an input;
// the residual is an Ornstein-Uhlenbeck process and noise. Widths, process and noise maximise the marginal likelihood
// on a grid. Gains keep their whole posterior, so that gains which the first part does not determine widen the
// predicted spread of the rest. The grey box of compensation/models has the same elements for prediction: with the
// mean of each gain, fewer time constants, and a start out of equilibrium.

#include <Eigen/Core>

#include <vector>

#include "diagnosis/data/data_record.h"
#include "diagnosis/statistics/covariance.h"

namespace thermotwin::diagnosis {

/// The elements of one target, and the process of its residual.
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
  /// @return the covariance of the residual process and the noise in these rows, without the uncertainty of the gains
  ChannelCovariance left_over(const DataRecord& record, const std::vector<Eigen::Index>& rows) const;
  /// @return the change of the target some seconds after a unit step of the input, in the target's unit
  double step_response(Eigen::Index input, double seconds) const;
};

/// @param rows  of the record that are fitted (NaN targets are left out). No time constant is longer than they last
LagModel fit_lag_model(const DataRecord& record, Eigen::Index target, const std::vector<Eigen::Index>& rows);

}  // namespace thermotwin::diagnosis
