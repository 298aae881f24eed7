// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Parameters of a fitted model by name, as they stand in a model file (see fitted_model.h).

#include <Eigen/Core>

#include <map>
#include <string>

#include "core/config.h"

namespace thermotwin::compensation {

class ParameterStore {
public:
  explicit ParameterStore(std::string place = "model") : place_(std::move(place)) {}

  void put(const std::string& key, const Eigen::MatrixXd& values) { values_[key] = values; }
  void put(const std::string& key, double value) { values_[key] = Eigen::MatrixXd::Constant(1, 1, value); }

  bool has(const std::string& key) const { return values_.contains(key); }
  /// @param rows, cols  what is allowed; -1: any  @throws InputError if absent or of another shape
  Eigen::MatrixXd matrix(const std::string& key, Eigen::Index rows = -1, Eigen::Index cols = -1) const;
  Eigen::VectorXd vector(const std::string& key, Eigen::Index size = -1) const { return matrix(key, size, 1); }
  double number(const std::string& key, double low = -1e300, double high = 1e300) const;

  const std::map<std::string, Eigen::MatrixXd>& values() const { return values_; }
  const std::string& place() const { return place_; }

private:
  std::string place_;
  std::map<std::string, Eigen::MatrixXd> values_;
};

/// A parameter as it stands in a model file: rows, columns, then the numbers row by row, at full precision.
std::string parameter_text(const Eigen::MatrixXd& values);
/// @throws InputError (no such key, no shape, another number of values)
Eigen::MatrixXd read_parameter(const core::Node& node, const std::string& key);

}  // namespace thermotwin::compensation
