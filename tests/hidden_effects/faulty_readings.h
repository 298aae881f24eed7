// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Faulty readings and what no kind of the diagnosis describes, written without a line of its code.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "compensation/measurement/measurement.h"
#include "solver/operation/layout.h"
#include "specimen.h"

namespace thermotwin::hidden {

/// A lag is two elements in a row, a drift bends, a loose sensor swings a little.
Eigen::VectorXd spoilt_reading(diagnosis::Kind kind, double value, const Eigen::VectorXd& time,
                               const Eigen::VectorXd& air, Eigen::VectorXd values);

/// Whether a faulty reading of `where` is that of the channel: its id, "temperature", "displacement", or
/// "displacement." and its quantity.
bool concerns(const std::string& where, const compensation::MeasuredChannel& channel);

class OutsideEffect {
public:
  /// @param duration_s  of the load: a change comes within its first 20 to 60 %
  OutsideEffect(Outside effect, std::string where, const mesh::Machine& machine, const solver::Layout& layout,
                double duration_s, Random& random);
  /// Changes the coefficients of a step.
  void act(solver::Coefficients& c, const Eigen::VectorXd& row, double time, double step);
  Eigen::VectorXd reading(const std::string& sensor, const Eigen::VectorXd& time, Eigen::VectorXd values);

private:
  Outside effect_;
  std::string where_;
  const mesh::Machine& machine_;
  const solver::Layout& layout_;
  Random& random_;
  double level_ = 1.0, humidity_ = 0.0, last_heat_ = 0.0, most_ = 0.0;
  double begins_ = 0.0, size_ = 1.0;
  bool open_ = false;
};

}  // namespace thermotwin::hidden
