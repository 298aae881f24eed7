// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Features of the composite correlative model (compensation/models/three_modules.h), row by row: the baseline, features
// of the surroundings by (8) to (10) of Naumann et al. (2023), and features of the other sensors.

#include <Eigen/Core>

#include <array>
#include <vector>

#include "compensation/models/lag_bank.h"
#include "compensation/models/temperature_history.h"

namespace thermotwin::compensation {

/// Inputs and time constants of the modules. An input is the index of a temperature of the machine, or of the air.
struct ModuleLayout {
  std::array<Eigen::Index, 2> ambient{};  ///< inputs; the first gives mode and baseline
  std::vector<Eigen::Index> internal;     ///< inputs of module 3
  double sigma_s = 0;                     ///< of the Gaussian filter; 0: none
  std::vector<double> memories;           ///< s, of module 2
  std::vector<double> lags;               ///< s, of module 3
  bool baseline = true;
  double reference = 0;  ///< degC, in place of the baseline where `baseline` is false: no module 1
};

struct ModuleRow {
  double baseline = 0;                ///< degC
  Eigen::RowVectorXd ambient;         ///< features of module 2
  std::array<double, 2> deviation{};  ///< K, ambient sensors less the baseline
  Eigen::RowVectorXd above;           ///< (internal) K, sensors less the baseline
};

/// Features of one row after the other.
class ModuleFeatures {
public:
  /// @param layout  has to outlive the features  @param fixed  baseline at the first reading, as in training
  ModuleFeatures(const ModuleLayout& layout, bool fixed);

  static Eigen::Index ambient_size(const ModuleLayout& layout) { return 16 + 6 * std::ssize(layout.memories); }

  /// @param time  s, rising  @return whether all inputs are finite; else `row` is unchanged
  bool step(double time, const Eigen::Ref<const Eigen::RowVectorXd>& inputs, ModuleRow& row);

private:
  void put_ambient(double time, double first, double second, ModuleRow& row);

  const ModuleLayout& layout_;
  bool fixed_, started_ = false;
  double start_ = 0;
  std::array<TemperatureHistory, 2> histories_;
  LagBank memories_;
};

/// Features of module 3, of the sensors less baseline and offsets: the value, its excess above the bend, and the value
/// past first-order elements. At the bend the gain of a sensor changes.
class InternalFeatures {
public:
  /// @param layout, bend  have to outlive the features; bend: (internal) K
  InternalFeatures(const ModuleLayout& layout, const Eigen::VectorXd& bend);

  static Eigen::Index size(const ModuleLayout& layout) {
    return std::ssize(layout.internal) * (2 + std::ssize(layout.lags));
  }
  /// @param time  s, rising  @param warm  (internal) K, sensors less baseline and offsets
  Eigen::RowVectorXd step(double time, const Eigen::RowVectorXd& warm);

private:
  const Eigen::VectorXd& bend_;
  LagBank lags_;
  Eigen::Index lagged_;
};

}  // namespace thermotwin::compensation
