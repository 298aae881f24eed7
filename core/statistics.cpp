// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/statistics.h"

#include <algorithm>
#include <cassert>
#include <iterator>
#include <limits>

namespace thermotwin::core {

double nth_smallest(std::vector<double> values, std::ptrdiff_t n) {
  assert(n >= 0 && n < std::ssize(values));
  const auto at = values.begin() + n;
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double median(std::vector<double> values) {
  const std::ptrdiff_t middle = std::ssize(values) / 2;
  return nth_smallest(std::move(values), middle);
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const double at = std::clamp(share, 0.0, 1.0) * (values.size() - 1);
  const auto low = static_cast<std::size_t>(at), high = std::min(low + 1, values.size() - 1);
  return values[low] + (at - low) * (values[high] - values[low]);
}

}  // namespace thermotwin::core
