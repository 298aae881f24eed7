// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// First-order lags tau y' + y = u of several inputs, row by row, at any sampling. Exact for
// temperatures that are linear between their readings and for other inputs that hold from row to
// row; a gap in a temperature is bridged by a straight line once the next reading has come. A
// temperature starts in equilibrium (y = u), a speed or power from rest (y = 0).

#include <Eigen/Core>

#include <vector>

#include "compensation/measurement/dataset.h"
#include "core/first_order_lag.h"

namespace thermotwin::compensation {

class LagBank {
public:
  /// @param tau  s, > 0, or 0: the input itself  @param averaged  every input is linear between rows
  LagBank(std::vector<InputInfo> info, std::vector<double> tau, bool averaged = false);

  /// (inputs x tau) outputs at this time; NaN in the rows of inputs that are missing
  const Eigen::MatrixXd& step(double time, const Eigen::Ref<const Eigen::RowVectorXd>& inputs);

private:
  std::vector<InputInfo> info_;
  std::vector<double> tau_;
  bool averaged_;
  Eigen::MatrixXd state_, output_;
  Eigen::VectorXd last_value_, last_time_;  ///< (inputs) NaN before the first reading
  double steps_for_ = -1.0;                 ///< duration that steps_ are for
  std::vector<core::LagStep> steps_;        ///< by tau
};

/// Features of a whole record: column tau_index * inputs + input.
Eigen::MatrixXd lagged_features(const TrainingData& data, const std::vector<double>& tau, bool averaged);

}  // namespace thermotwin::compensation
