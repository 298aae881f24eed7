// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/drift_watch.h"

#include <algorithm>
#include <cmath>

namespace thermotwin::compensation {
namespace {

constexpr double watched_s = 16.0 * 3600.0, spacing_s = 600.0;
constexpr int quarters = 4;
constexpr double drifted = 6.0, apart = 5.0, least_spread_K = 0.03;
constexpr double least_share = 0.16, most_share = 0.34;  ///< of a quarter; a settling lag puts more into the first

}  // namespace

DriftWatch::DriftWatch(const Eigen::VectorXd& deviation_K)
    : deviation_(deviation_K.cwiseMax(least_spread_K)),
      sensors_(deviation_K.size()) {}

Eigen::Index DriftWatch::judge(double time, const Eigen::VectorXd& value, const Eigen::VectorXd& deviation) {
  Eigen::Index furthest = -1, found = -1;
  for (Eigen::Index i = 0; i < value.size(); ++i) {
    if (!std::isfinite(value[i]) || !std::isfinite(deviation[i]) || drifts(i)) continue;
    if (furthest < 0 || std::abs(value[i]) * deviation[furthest] > std::abs(value[furthest]) * deviation[i])
      furthest = i;
  }
  for (Eigen::Index i = 0; i < value.size(); ++i) {
    if (grows_steadily(i, time, value[i], deviation[i]) && i == furthest) found = i;
  }
  if (found >= 0) sensors_[found].drifts = true;
  return found;
}

bool DriftWatch::grows_steadily(Eigen::Index sensor, double time, double value, double deviation) {
  Sensor& s = sensors_[sensor];
  if (s.drifts || !std::isfinite(value) || !std::isfinite(deviation)) return false;
  if (!s.samples.empty() && time - s.samples.back().time < spacing_s) return false;
  s.samples.push_back({time, value});
  while (s.samples.size() > 1 && time - s.samples[1].time >= watched_s) s.samples.pop_front();
  const Sample first = s.samples.front();
  if (time - first.time < watched_s) return false;
  const double change = value - first.value;
  if (std::abs(change) < drifted * deviation_[sensor] || std::abs(value) < apart * deviation) return false;
  double last = first.value;
  for (int quarter = 1; quarter <= quarters; ++quarter) {
    const double until = first.time + (time - first.time) * quarter / quarters;
    const auto at = std::find_if(s.samples.begin(), s.samples.end(),
                                 [&](const Sample& sample) { return sample.time >= until - 1e-6; });
    const double reached = quarter == quarters || at == s.samples.end() ? value : at->value;
    const double share = (reached - last) / change;
    if (share < least_share || share > most_share) return false;
    last = reached;
  }
  return true;
}

}  // namespace thermotwin::compensation
