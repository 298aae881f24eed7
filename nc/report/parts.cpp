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
  if (part.moves == 0) {
    part.sum = Eigen::ArrayXd::Zero(move.mean_um.size());
    part.low = move.low_um;
    part.high = move.high_um;
    part.start = move.time;
  }
  ++part.moves;
  if (move.ahead_um.size() > 0) {
    if (part.ahead.size() == 0) part.ahead = Eigen::ArrayXd::Zero(move.ahead_um.size());
    part.ahead += move.ahead_um.array();
  }
  const double seconds = std::max(move.duration(), 1e-9);
  part.seconds += seconds;
  part.sum += seconds * move.mean_um.array();
  part.low = part.low.min(move.low_um.array());
  part.high = part.high.max(move.high_um.array());
  part.end = move.time;
}

std::string Parts::csv(const std::vector<std::string>& axes) const {
  std::string text = "part,start_s,end_s";
  for (const std::string& axis : axes) text += fmt::format(",mean_offset_{0}_um,low_{0}_um,high_{0}_um", axis);
  text += "\n";
  for (const auto& [number, part] : parts_) {
    text += fmt::format("{},{:.6f},{:.6f}", number + 1, part.start, part.end);
    for (Eigen::Index i = 0; i < part.sum.size(); ++i)
      text += fmt::format(",{:.5g},{:.5g},{:.5g}", part.mean()[i], part.low[i], part.high[i]);
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
  const Part* last = parts_.empty() ? nullptr : &parts_.rbegin()->second;
  if (parts_.size() < 2 || last->ahead.size() == 0) return std::numeric_limits<double>::infinity();
  // It counts from the period before the last part.
  const Eigen::ArrayXd before = std::next(parts_.rbegin())->second.mean();
  return (before + last->ahead / (1.0 * last->moves) - last->mean()).abs().maxCoeff();
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
