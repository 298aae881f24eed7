// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/parameter_store.h"

#include <fmt/format.h>

#include <vector>

#include "core/error.h"

namespace thermotwin::compensation {

Eigen::MatrixXd ParameterStore::matrix(const std::string& key, Eigen::Index rows, Eigen::Index cols) const {
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

double ParameterStore::number(const std::string& key, double low, double high) const {
  const double value = matrix(key, 1, 1)(0, 0);
  if (!(value >= low && value <= high))
    throw core::InputError(place_ + " " + key, fmt::format("{}", value), fmt::format("{} to {}", low, high));
  return value;
}

std::string parameter_text(const Eigen::MatrixXd& values) {
  std::string text = fmt::format("[{}.0, {}.0", values.rows(), values.cols());
  for (Eigen::Index i = 0; i < values.rows(); ++i) {
    for (Eigen::Index j = 0; j < values.cols(); ++j) text += fmt::format(", {:.17e}", values(i, j));
  }
  return text + "]";
}

Eigen::MatrixXd read_parameter(const core::Node& node, const std::string& key) {
  const std::vector<double> numbers = node.numbers(key);
  const auto refuse = [&](const std::string& found) {
    throw core::InputError(node.place(key), found, "rows, columns, then as many numbers, row by row");
  };
  constexpr double largest = 1e6;
  if (numbers.size() < 2 || !(numbers[0] >= 0 && numbers[0] <= largest) || !(numbers[1] >= 0 && numbers[1] <= largest))
    refuse("no shape");
  const auto rows = static_cast<Eigen::Index>(numbers[0]), cols = static_cast<Eigen::Index>(numbers[1]);
  if (std::ssize(numbers) != rows * cols + 2)
    refuse(fmt::format("{} numbers for {} x {}", numbers.size() - 2, rows, cols));
  Eigen::MatrixXd matrix(rows, cols);
  for (Eigen::Index i = 0; i < rows; ++i) {
    for (Eigen::Index j = 0; j < cols; ++j) matrix(i, j) = numbers[2 + i * cols + j];
  }
  return matrix;
}

}  // namespace thermotwin::compensation
