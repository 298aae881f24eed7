// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/workspace_weights.h"

#include <Eigen/QR>

#include <algorithm>
#include <cstdlib>
#include <set>

namespace thermotwin::compensation {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

std::map<std::string, double> pose_of_text(const std::string& text) {
  std::map<std::string, double> pose;
  std::size_t start = 0;
  while (start < text.size()) {
    const std::size_t comma = std::min(text.find(',', start), text.size()), equals = text.find('=', start);
    if (equals < comma) pose[text.substr(start, equals - start)] = std::strtod(text.c_str() + equals + 1, nullptr);
    start = comma + 1;
  }
  return pose;
}

namespace {

enum class Basis { triquadratic, quadratic, multilinear, linear, constant };

/// Exponents 0 to 2 an axis; which products belong to the basis.
RowVectorXd row_of(Basis basis, const RowVectorXd& x) {
  std::vector<double> values;
  std::vector<int> power(x.size(), 0);
  while (true) {
    int sum = 0, highest = 0;
    double value = 1.0;
    for (Index i = 0; i < x.size(); ++i) {
      const int p = power[i];
      sum += p;
      highest = std::max(highest, p);
      for (int j = 0; j < p; ++j) value *= x[i];
    }
    const bool taken = basis == Basis::triquadratic || (basis == Basis::quadratic && sum <= 2) ||
                       (basis == Basis::multilinear && highest <= 1) || (basis == Basis::linear && sum <= 1) ||
                       sum == 0;
    if (taken) values.push_back(value);
    std::size_t axis = 0;
    while (axis < power.size() && power[axis] == 2) power[axis++] = 0;
    if (axis == power.size()) break;
    ++power[axis];
  }
  return Eigen::Map<RowVectorXd>(values.data(), std::ssize(values));
}

}  // namespace

VectorXd workspace_weights(const std::vector<std::string>& known, const std::string& at) {
  const auto n = std::ssize(known);
  std::vector<std::map<std::string, double>> poses;
  std::set<std::string> named;
  for (const std::string& text : known) poses.push_back(pose_of_text(text));
  std::map<std::string, double> target = pose_of_text(at);
  for (auto& pose : poses) {
    for (const auto& [axis, value] : pose) named.insert(axis);
  }
  // Only axes along which the known poses differ carry anything.
  std::vector<std::string> axes;
  std::vector<double> low, high;
  for (const std::string& axis : named) {
    double least = poses.front()[axis], most = least;
    for (auto& pose : poses) {
      least = std::min(least, pose[axis]);
      most = std::max(most, pose[axis]);
    }
    if (most > least) {
      axes.push_back(axis);
      low.push_back(least);
      high.push_back(most);
    }
  }
  constexpr std::size_t most_axes = 6;
  if (axes.size() > most_axes) axes.resize(most_axes);
  MatrixXd x(n + 1, std::ssize(axes));
  for (Index i = 0; i <= n; ++i) {
    auto& pose = i < n ? poses[i] : target;
    for (std::size_t k = 0; k < axes.size(); ++k) {
      const double share = (pose[axes[k]] - low[k]) / (high[k] - low[k]);
      x(i, k) = 2.0 * std::clamp(share, 0.0, 1.0) - 1.0;  // beyond the poses: as at their edge
    }
  }
  for (const Basis basis :
       {Basis::triquadratic, Basis::quadratic, Basis::multilinear, Basis::linear, Basis::constant}) {
    const RowVectorXd wanted = row_of(basis, x.row(n));
    if (wanted.size() > n) continue;
    MatrixXd rows(n, wanted.size());
    for (Index i = 0; i < n; ++i) rows.row(i) = row_of(basis, x.row(i));
    const Eigen::CompleteOrthogonalDecomposition<MatrixXd> factor(MatrixXd(rows.transpose()));
    if (factor.rank() < wanted.size()) continue;
    return factor.solve(wanted.transpose());
  }
  return VectorXd::Constant(n, 1.0 / n);
}

}  // namespace thermotwin::compensation
