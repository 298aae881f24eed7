// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Models that predict a displacement from measured temperatures alone: a static regression
// (ordinary least squares, all temperatures, intercept) and first-order transfer functions, one an
// axis (sum of gain_i / (1 + tau s) applied to each temperature, one tau an axis, exact for
// piecewise linear inputs; irregular sampling allowed). One interface, so that `evaluate` compares.

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

namespace thermotwin::compensation {

class DataModel {
 public:
  virtual ~DataModel() = default;
  virtual std::string name() const = 0;
  /// @param time (n) s  @param inputs (n x temperatures)  @param target (n), NaN rows left out
  virtual void fit(const Eigen::VectorXd& time, const Eigen::MatrixXd& inputs,
                   const Eigen::VectorXd& target) = 0;
  /// Prediction for a whole record that starts where the fit's record started.
  virtual Eigen::VectorXd predict(const Eigen::VectorXd& time,
                                  const Eigen::MatrixXd& inputs) const = 0;
  /// Parameters in words with units.
  virtual std::string explain() const = 0;
};

std::unique_ptr<DataModel> make_static_regression();
std::unique_ptr<DataModel> make_first_order();

}  // namespace thermotwin::compensation
