// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A measurement as means over equal intervals of time, for models of the record alone.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "compensation/measurement/measurement.h"

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

/// @throws InputError for a record without displacement or changing input, or of less than 36 intervals
DataRecord data_record(const compensation::Measurement& measurement, double interval_s);

}  // namespace thermotwin::diagnosis
