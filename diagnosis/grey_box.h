// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Diagnosis of data that no machine model belongs to. The simulation is a grey box fitted on the first
// part of the record (the first day): each displacement is a sum of first-order elements
//   d(t) = c + sum_i g_i y_i(t),   tau_i dy_i/dt = u_i - y_i,
// one for each measured temperature (or other input), gains with a Gaussian prior, time constants from
// a grid by marginal likelihood, what is left as an Ornstein-Uhlenbeck process and noise. The parts
// after it tell what is wrong; hypotheses are fitted on all but the last part, and judged there.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "diagnosis/diagnose.h"

namespace thermotwin::diagnosis {

/// Inputs and targets on one grid of interval means; NaN where nothing was measured.
struct DataRecord {
  Eigen::VectorXd time;                  ///< (n) s, middle of each interval
  Eigen::MatrixXd inputs;                ///< (n x inputs), gaps filled with the last value
  std::vector<std::string> input_names, input_units;
  Eigen::MatrixXd targets;               ///< (n x targets)
  std::vector<compensation::MeasuredChannel> channels;  ///< of the targets
  double interval = 0;                   ///< s
};

/// @throws InputError: no input, no displacement, a record too short to be divided
DataRecord data_record(const compensation::Measurement& measurement, double interval_s);

/// One target's elements with the process that is left.
struct GreyBox {
  Eigen::VectorXd time_constants;        ///< (inputs) s, 0: follows at once
  double wander_std = 0, wander_time = 0, noise_std = 0;
  Eigen::VectorXd gains;                 ///< (inputs + 1) posterior means, the constant last
  Eigen::MatrixXd covariance;            ///< of the gains
  double log_evidence = 0;

  /// (n x inputs + 1) columns of the elements and of the constant.
  Eigen::MatrixXd columns(const DataRecord& record) const;
};
/// @param rows  of the record that are fitted (NaN targets are left out)
/// @param start  time constants to begin with; empty: half an hour. None is longer than the rows last
GreyBox fit_grey_box(const DataRecord& record, Eigen::Index target, const std::vector<Eigen::Index>& rows,
                     const Eigen::VectorXd& start = {});

struct TimeConstant {
  double value = 0, std = 0;             ///< s
};
/// Of one element, over the grid of the search and with the spacing of that grid in its deviation; all others as fitted.
TimeConstant time_constant_of(const DataRecord& record, Eigen::Index target, const std::vector<Eigen::Index>& rows, const GreyBox& box,
                              Eigen::Index input);

/// @param options  interval_s is used; the parts are days, or thirds of a shorter record
Diagnosis diagnose_data(const compensation::Measurement& measurement, const DiagnoseOptions& options);

}  // namespace thermotwin::diagnosis
