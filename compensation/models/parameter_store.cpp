// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/parameter_store.h"

#include <fmt/format.h>

#include "core/error.h"

namespace thermotwin::compensation {

Eigen::MatrixXd Archive::matrix(const std::string& key, Eigen::Index rows, Eigen::Index cols) const {
  const auto found = values_.find(key);
  const auto side = [](Eigen::Index n) { return n < 0 ? std::string("any") : std::to_string(n); };
  if (found == values_.end())
    throw core::InputError(place_, "no parameter '" + key + "'", "every parameter that the model was saved with");
  const Eigen::MatrixXd& values = found->second;
  if ((rows >= 0 && values.rows() != rows) || (cols >= 0 && values.cols() != cols)) {
    throw core::InputError(place_ + " " + key, fmt::format("{} x {} values", values.rows(), values.cols()),
                           fmt::format("{} x {}", side(rows), side(cols)));
  }
  return values;
}

double Archive::number(const std::string& key, double low, double high) const {
  const double value = matrix(key, 1, 1)(0, 0);
  if (!(value >= low && value <= high))
    throw core::InputError(place_ + " " + key, fmt::format("{}", value), fmt::format("{} to {}", low, high));
  return value;
}

}  // namespace thermotwin::compensation
