// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/measurement/stretch.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/statistics.h"

namespace thermotwin::compensation {

double usual_interval(const Eigen::VectorXd& time) {
  if (time.size() < 2) return 0.0;
  std::vector<double> gaps;
  for (Eigen::Index i = 1; i < time.size(); ++i) gaps.push_back(time[i] - time[i - 1]);
  return core::median(std::move(gaps));
}

double longest_stretch(const TrainingData& data) {
  std::vector<double> times, gaps;
  for (Eigen::Index i = 0; i < data.target.size(); ++i) {
    if (std::isfinite(data.target[i])) times.push_back(data.time[i]);
  }
  if (times.size() < 2) return 0.0;
  for (std::size_t i = 1; i < times.size(); ++i) gaps.push_back(times[i] - times[i - 1]);
  const double allowed = std::max(10.0 * core::median(std::move(gaps)), 3600.0);
  double longest = 0.0, begin = times.front();
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (times[i] - times[i - 1] > allowed) begin = times[i];
    longest = std::max(longest, times[i] - begin);
  }
  // Rare readings with nothing but gaps: all of them together.
  return longest > 0.0 ? longest : times.back() - times.front();
}

}  // namespace thermotwin::compensation
