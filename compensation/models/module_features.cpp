// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/module_features.h"

#include <algorithm>
#include <cmath>

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;

constexpr double edge_K = 1.6;  ///< of the stable mode, (8)

/// Of temperatures. A bank needs a time constant even where nothing of it is used.
LagBank bank_of(std::size_t inputs, const std::vector<double>& times) {
  return {std::vector<InputInfo>(inputs, InputInfo{}), times.empty() ? std::vector<double>{0.0} : times};
}

}  // namespace

ModuleFeatures::ModuleFeatures(const ModuleLayout& layout, bool fixed)
    : layout_(layout),
      fixed_(fixed),
      memories_(bank_of(2, layout.memories)) {}

bool ModuleFeatures::step(double time, const Eigen::Ref<const RowVectorXd>& inputs, ModuleRow& row) {
  const double first = inputs[layout_.ambient[0]], second = inputs[layout_.ambient[1]];
  bool known = std::isfinite(first) && std::isfinite(second);
  for (const Index i : layout_.internal) known = known && std::isfinite(inputs[i]);
  if (!known) return false;
  histories_[0].add(time, first);
  histories_[1].add(time, second);
  if (!started_) start_ = first;
  started_ = true;
  row.baseline = !layout_.baseline ? layout_.reference : fixed_ ? start_ : histories_[0].mean();
  row.deviation = {first - row.baseline, second - row.baseline};
  put_ambient(time, first, second, row);
  row.above.resize(std::ssize(layout_.internal));
  for (std::size_t k = 0; k < layout_.internal.size(); ++k) row.above[k] = inputs[layout_.internal[k]] - row.baseline;
  return true;
}

void ModuleFeatures::put_ambient(double time, double first, double second, ModuleRow& row) {
  std::array<double, 2> smooth = row.deviation;
  for (std::size_t i = 0; layout_.sigma_s > 0.0 && i < 2; ++i)
    smooth[i] = histories_[i].filtered(layout_.sigma_s) - row.baseline;
  RowVectorXd pair(2);
  pair << first, second;
  const MatrixXd past = memories_.step(time, pair);
  row.ambient.resize(ambient_size(layout_));
  Index at = 0;
  const auto put = [&](double value) { row.ambient[at++] = value; };
  const double u = row.deviation[0], b = smooth[0], a = smooth[1];
  const double stable = std::max(0.0, 1.0 - std::pow(u / edge_K, 6));
  const double x = std::clamp(a / edge_K, -2.0, 2.0), y = std::clamp(b / edge_K, -2.0, 2.0);
  for (const double value : {x, y, x * y, std::abs(x), std::abs(y), 1.0}) put(stable * value);
  for (const bool cold : {true, false}) {
    const double share = (u < 0.0) == cold ? 1.0 - stable : 0.0, size = std::abs(b);
    for (const double value : {size, std::sqrt(size), size * std::sqrt(size), a, 1.0}) put(share * value);
  }
  for (std::size_t m = 0; m < layout_.memories.size(); ++m) {
    for (Index i = 0; i < 2; ++i) {
      const double late = past(i, m) - pair[i];
      put(stable * late);
      put(u < 0.0 ? (1.0 - stable) * late : 0.0);
      put(u >= 0.0 ? (1.0 - stable) * late : 0.0);
    }
  }
}

InternalFeatures::InternalFeatures(const ModuleLayout& layout, const Eigen::VectorXd& bend)
    : bend_(bend),
      lags_(bank_of(layout.internal.size(), layout.lags)),
      lagged_(std::ssize(layout.lags)) {}

RowVectorXd InternalFeatures::step(double time, const RowVectorXd& warm) {
  const Index n = warm.size();
  RowVectorXd row(n * (2 + lagged_));
  const MatrixXd& past = lags_.step(time, warm);
  row.head(n) = warm;
  for (Index k = 0; k < n; ++k) row[n + k] = std::max(0.0, warm[k] - bend_[k]);
  for (Index m = 0; m < lagged_; ++m) row.segment((2 + m) * n, n) = past.col(m).transpose();
  return row;
}

}  // namespace thermotwin::compensation
