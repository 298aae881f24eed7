// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/record/pauses.h"

#include <algorithm>
#include <cmath>

namespace thermotwin::diagnosis {

using Eigen::Index;

namespace {

constexpr double last_part_s = 300;  ///< and each part before it this many times as long:
constexpr double growth = 3.0;
constexpr double any_share = 0.5773502691896258;  ///< root mean square of a share between 0 and 1, any alike
constexpr std::size_t most_columns = 64;

/// Bounds of the parts of a pause, s before its end, rising from 0 to its length.
std::vector<double> parts_of(double length) {
  std::vector<double> bounds = {0.0};
  for (double part = last_part_s; bounds.back() + part < length; part *= growth) bounds.push_back(bounds.back() + part);
  if (bounds.size() > 1 && length - bounds.back() < 0.5 * (bounds.back() - bounds[bounds.size() - 2]))
    bounds.back() = length;
  else
    bounds.push_back(length);
  return bounds;
}

/// The value of the largest magnitude, with its sign.
double fastest(const Eigen::MatrixXd& rows, Index channel) {
  double value = 0.0;
  for (const double each : rows.col(channel))
    if (std::isfinite(each) && std::abs(each) > std::abs(value)) value = each;
  return value;
}

}  // namespace

void add_pauses(const Eigen::VectorXd& time, const Eigen::MatrixXd& rows, const std::vector<Watched>& watched,
                std::vector<Index> begins, Observations& out) {
  const auto length = [&](Index i) { return time[i + 1] - time[i]; };
  std::stable_sort(begins.begin(), begins.end(), [&](Index a, Index b) { return length(a) > length(b); });
  std::size_t columns = 0;
  for (const Index i : begins) {
    out.pauses.push_back({time[i], time[i + 1]});
    const std::vector<double> bounds = parts_of(length(i));
    columns += watched.size() * (bounds.size() - 1);
    if (columns > most_columns) continue;
    for (const Watched& w : watched) {
      const double before = rows(i, w.channel);
      if (!std::isfinite(before)) continue;
      Observations::MayHold other{.from = 0,
                                  .to = 0,
                                  .row = rows.row(i).transpose(),
                                  .std = any_share,
                                  .shown = time[i + 1],
                                  .earlier = true,
                                  .channel = w.channel};
      other.row[w.channel] = std::abs(before) < 0.5 * w.largest ? fastest(rows, w.channel) : 0.0;
      for (std::size_t k = 0; k + 1 < bounds.size(); ++k) {
        other.from = time[i + 1] - bounds[k + 1];
        other.to = time[i + 1] - bounds[k];
        out.may_hold.push_back(other);
      }
    }
  }
}

}  // namespace thermotwin::diagnosis
