// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What the modules of the composite correlative model (compensation/models/three_modules.h) read from one row after the
// other: the baseline, features of the surroundings by (8) to (10) of Naumann et al. (2023), features of the sensors.

#include <Eigen/Core>

#include <array>
#include <vector>

#include "compensation/models/lag_bank.h"
#include "compensation/models/temperature_history.h"

namespace thermotwin::compensation {

/// What all modules share. Inputs: temperatures of the machine (and the air).
struct ModuleLayout {
  std::array<Eigen::Index, 2> ambient{};  ///< inputs; the first guides the modes and is the baseline
  std::vector<Eigen::Index> internal;     ///< inputs of module 3
  double sigma_s = 0;                     ///< of the Gaussian filter; 0: none
  std::vector<double> memories;           ///< s, of module 2
  std::vector<double> lags;               ///< s, of module 3
  bool baseline = true;
  double reference = 0;  ///< of T without module 1
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

  /// @param time  s, rising  @return whether all inputs are there; the row is as it was where they are not
  bool step(double time, const Eigen::Ref<const Eigen::RowVectorXd>& inputs, ModuleRow& row);

private:
  void put_ambient(double time, double first, double second, ModuleRow& row);

  const ModuleLayout& layout_;
  bool fixed_, started_ = false;
  double start_ = 0;
  std::array<TemperatureHistory, 2> histories_;
  LagBank memories_;
};

/// Features of module 3 from the sensors less baseline and offsets: as they are, what lies above their bend, and past
/// first-order elements.
class InternalFeatures {
public:
  /// @param layout, bend  have to outlive the features; bend: (internal) K
  InternalFeatures(const ModuleLayout& layout, const Eigen::VectorXd& bend);

  static Eigen::Index size(const ModuleLayout& layout) {
    return std::ssize(layout.internal) * (2 + std::ssize(layout.lags));
  }
  /// @param time  s, rising  @param warm  (internal) K
  Eigen::RowVectorXd step(double time, const Eigen::RowVectorXd& warm);

private:
  const Eigen::VectorXd& bend_;
  LagBank lags_;
  Eigen::Index lagged_;
};

}  // namespace thermotwin::compensation
