// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/measurement/measures.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"

namespace thermotwin::compensation {
namespace {

constexpr double undefined = std::numeric_limits<double>::quiet_NaN();

double reduction_percent(double before, double after) {
  return before > 0.0 ? (1.0 - after / before) * 100.0 : undefined;
}

}  // namespace

Measures measure(const Eigen::VectorXd& measured, const Eigen::VectorXd& predicted) {
  if (measured.size() != predicted.size()) {
    throw core::InputError(
        "measures",
        std::to_string(measured.size()) + " measured and " + std::to_string(predicted.size()) + " predicted values",
        "series of equal length");
  }
  Measures result;
  double sum_z = 0.0, sum_e = 0.0, squares_z = 0.0, squares_e = 0.0;
  double low_z = 0.0, high_z = 0.0, low_e = 0.0, high_e = 0.0;
  for (Eigen::Index i = 0; i < measured.size(); ++i) {
    const double z = measured[i], e = z - predicted[i];
    if (!std::isfinite(e)) continue;
    if (result.count == 0) {
      low_z = high_z = z;
      low_e = high_e = e;
    }
    ++result.count;
    sum_z += z;
    sum_e += e;
    squares_z += z * z;
    squares_e += e * e;
    low_z = std::min(low_z, z);
    high_z = std::max(high_z, z);
    low_e = std::min(low_e, e);
    high_e = std::max(high_e, e);
  }
  if (result.count == 0) {
    for (double* value : {&result.fit, &result.peak_to_peak, &result.rms, &result.maximum, &result.mean,
                          &result.rms_before, &result.peak_to_peak_before, &result.maximum_before, &result.mean_before,
                          &result.rms_reduction_percent, &result.peak_to_peak_reduction_percent}) {
      *value = undefined;
    }
    return result;
  }
  const double n = result.count;
  // About the mean in a second pass: sum of squares minus n mean^2 cancels for a small drift.
  double spread = 0.0;
  const double mean_z = sum_z / n;
  for (Eigen::Index i = 0; i < measured.size(); ++i) {
    if (std::isfinite(measured[i] - predicted[i])) spread += (measured[i] - mean_z) * (measured[i] - mean_z);
  }
  result.fit = spread > 0.0 ? (1.0 - std::sqrt(squares_e / spread)) * 100.0 : undefined;
  result.peak_to_peak = high_e - low_e;
  result.rms = std::sqrt(squares_e / n);
  result.maximum = std::max(std::abs(low_e), std::abs(high_e));
  result.mean = sum_e / n;
  result.mean_before = mean_z;
  result.rms_before = std::sqrt(squares_z / n);
  result.peak_to_peak_before = high_z - low_z;
  result.maximum_before = std::max(std::abs(low_z), std::abs(high_z));
  result.rms_reduction_percent = reduction_percent(result.rms_before, result.rms);
  result.peak_to_peak_reduction_percent = reduction_percent(result.peak_to_peak_before, result.peak_to_peak);
  return result;
}

}  // namespace thermotwin::compensation
