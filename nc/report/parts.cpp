// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/report/parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace thermotwin::nc {

void Parts::add(const PredictedMove& move) {
  if (move.timed->element.rapid) return;
  Part& part = parts_[move.timed->element.state.part];
  const Eigen::ArrayXd offset = move.offset_um.array();
  if (part.moves == 0) {
    part.sum = Eigen::ArrayXd::Zero(offset.size());
    part.low = part.high = offset;
    part.start = move.time;
  }
  ++part.moves;
  part.sum += offset;
  part.low = part.low.min(offset);
  part.high = part.high.max(offset);
  part.end = move.time;
}

std::string Parts::csv(const std::vector<std::string>& axes) const {
  std::string text = "part,start_s,end_s";
  for (const std::string& axis : axes) text += fmt::format(",mean_offset_{0}_um,low_{0}_um,high_{0}_um", axis);
  text += "\n";
  for (const auto& [number, part] : parts_) {
    text += fmt::format("{},{:.6f},{:.6f}", number + 1, part.start, part.end);
    for (Eigen::Index i = 0; i < part.sum.size(); ++i)
      text += fmt::format(",{:.5g},{:.5g},{:.5g}", part.sum[i] / part.moves, part.low[i], part.high[i]);
    text += "\n";
  }
  return text;
}

int Parts::first_good(double within_um) const {
  int good = 0;
  for (auto part = parts_.rbegin(); part != parts_.rend(); ++part) {
    const Eigen::ArrayXd apart = part->second.mean() - parts_.rbegin()->second.mean();
    if (apart.abs().maxCoeff() > within_um) break;
    good = part->first + 1;
  }
  return good;
}

double Parts::drift_ahead() const {
  constexpr double infinite = std::numeric_limits<double>::infinity(), slowest = 0.95, still_um = 1e-3;
  const auto count = std::ssize(parts_);
  if (count < 3) return infinite;
  const auto mean = [&](Eigen::Index i) { return std::next(parts_.begin(), i)->second.mean(); };
  const Eigen::Index half = (count - 1) / 2, last = count - 1;
  const Eigen::ArrayXd before = (mean(last - half) - mean(last - 2 * half)).abs();
  const Eigen::ArrayXd after = (mean(last) - mean(last - half)).abs();
  double most = 0.0;
  for (Eigen::Index i = 0; i < after.size(); ++i) {
    if (after[i] < still_um) continue;
    const double ratio = after[i] / before[i];
    most = std::max(most, ratio < slowest ? after[i] * ratio / (1.0 - ratio) : infinite);
  }
  return most;
}

std::string unsettled_text(double drift_ahead_um, double tolerance_um, const std::string& unit) {
  const std::string drift =
      std::isfinite(drift_ahead_um) ? fmt::format("about {:.2g} {}", drift_ahead_um, unit) : "an unknown amount";
  return fmt::format(
      "The series has not settled: {} of drift lies ahead of its last part, and the tolerance is {:.3g} "
      "{}. A series with more parts (--repeat) finds the first good one.",
      drift, tolerance_um, unit);
}

}  // namespace thermotwin::nc
