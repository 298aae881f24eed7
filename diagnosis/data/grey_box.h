// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The simulation of data that no machine model belongs to: a grey box, fitted on the first part of the
// record. Each displacement is a sum of first-order elements
//   d(t) = c + sum_i sum_k g_ik y_ik(t),   tau_k dy_ik/dt = u_i - y_ik,
// with every time constant of a grid for each measured temperature (or other input), since heat reaches
// a tool by several ways. Gains have independent Gaussian priors, one width for all elements of an input;
// what is left is an Ornstein-Uhlenbeck process and noise. Widths, process and noise have the largest
// marginal likelihood; gains keep their whole posterior, so that what the first part does not tell widens
// what is expected of the others.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "compensation/measurement/measurement.h"
#include "diagnosis/statistics/covariance.h"

namespace thermotwin::diagnosis {

/// Inputs and targets on one grid of interval means; NaN where nothing was measured.
struct DataRecord {
  Eigen::VectorXd time;    ///< (n) s, middle of each interval
  Eigen::MatrixXd inputs;  ///< (n x inputs); temperatures interpolated over gaps, others with the last value
  std::vector<std::string> input_names, input_units;
  Eigen::MatrixXd targets, counts;                      ///< (n x targets); the second: readings in each mean
  std::vector<compensation::MeasuredChannel> channels;  ///< of the targets
  double interval = 0;                                  ///< s
};

/// @throws InputError: no input, no displacement, a record too short to be divided
DataRecord data_record(const compensation::Measurement& measurement, double interval_s);

/// Standard deviation of the finite values; 0 of fewer than two.
double spread_of(const Eigen::VectorXd& values);

/// One target's elements with the process that is left.
struct GreyBox {
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
GreyBox fit_grey_box(const DataRecord& record, Eigen::Index target, const std::vector<Eigen::Index>& rows);

}  // namespace thermotwin::diagnosis
