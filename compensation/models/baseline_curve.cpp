// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/baseline_curve.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <utility>

#include "core/error.h"

namespace thermotwin::compensation {

namespace {

constexpr double uniform_K = 0.25;  ///< a machine whose temperatures differ by less is in its steady state

}  // namespace

BaselineCurve fit_baseline(const TrainingData& data, const std::vector<ModuleProgram>& stretches,
                           const ModuleLayout& layout) {
  std::vector<std::pair<double, double>> steady;
  for (const ModuleProgram& stretch : stretches) {
    for (Eigen::Index i = stretch.from; stretch.kind == ProgramKind::baseline && i < stretch.to; ++i) {
      const double at = data.inputs(i, layout.ambient[0]);
      bool uniform = std::isfinite(at) && std::isfinite(data.target[i]);
      for (const Eigen::Index k : layout.internal) uniform = uniform && std::abs(data.inputs(i, k) - at) < uniform_K;
      if (uniform) steady.emplace_back(at, data.target[i]);
    }
  }
  std::sort(steady.begin(), steady.end());
  std::vector<double> at, value;
  for (std::size_t i = 0; i < steady.size();) {
    constexpr double apart_K = 0.5;
    double sum = 0.0, sum_value = 0.0, count = 0.0;
    const double first = steady[i].first;
    for (; i < steady.size() && steady[i].first - first < apart_K; ++i) {
      sum += steady[i].first;
      sum_value += steady[i].second;
      count += 1.0;
    }
    at.push_back(sum / count);
    value.push_back(sum_value / count);
  }
  if (at.size() < 2) {
    throw core::InputError(data.label, fmt::format("{} steady temperature with the machine off", at.size()),
                           "at least two, at which all its temperatures lie within 0.25 K");
  }
  return {Eigen::Map<Eigen::VectorXd>(at.data(), std::ssize(at)),
          Eigen::Map<Eigen::VectorXd>(value.data(), std::ssize(value))};
}

}  // namespace thermotwin::compensation
