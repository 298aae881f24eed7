// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/report/beyond_limits.h"

#include <algorithm>

namespace thermotwin::nc {

void BeyondLimits::note(Kind kind, const PredictedMove& move, double value) {
  const auto k = static_cast<std::size_t>(kind);
  const std::uint32_t line = move.timed->element.state.line;
  Total& total = totals_[k];
  if (total.moves++ == 0) total.first_line = line;
  total.largest = std::max(total.largest, value);
  if (last_[k] + 1 == number_) {
    Entry& entry = entries_[open_[k]];
    entry.first_line = std::min(entry.first_line, line);
    entry.last_line = std::max(entry.last_line, line);
    entry.end_s = move.time;
    entry.largest = std::max(entry.largest, value);
    ++entry.moves;
  } else if (entries_.size() < most_entries) {
    open_[k] = entries_.size();
    entries_.push_back({kind, line, line, move.time, move.time, 1, value});
  } else {
    ++not_listed_;
    return;
  }
  last_[k] = number_;
}

double BeyondLimits::rate_until(const Positions& positions, double time, const Eigen::VectorXd& offset_um) {
  double rate = 0.0;
  if (before_ && time > before_->time) {
    const double duration = time - before_->time, changed = (offset_um - before_->offset_um).cwiseAbs().maxCoeff();
    rate = (changed - limits_.motion_um(before_->positions, positions, duration)) / duration;
  }
  before_ = Before{positions, time, offset_um};
  return rate;
}

std::optional<BeyondLimits::Excess> BeyondLimits::add(const PredictedMove& move) {
  ++number_;
  if (move.outside) note(Kind::workspace, move, 0.0);
  double size = move.offset_um.cwiseAbs().maxCoeff(), rate = 0.0;
  for (const MoveSample& sample : move.inside) {
    size = std::max(size, sample.offset_um.cwiseAbs().maxCoeff());
    rate = std::max(rate, rate_until(sample.positions, sample.time, sample.offset_um));
  }
  rate = std::max(rate, rate_until(move.end, move.time, move.offset_um));
  std::optional<Excess> excess;
  if (rate > limits_.rate_um_s) {
    note(Kind::rate, move, rate);
    excess = {Kind::rate, rate};
  }
  if (size > limits_.largest_um) {
    note(Kind::size, move, size);
    excess = {Kind::size, size};
  }
  return excess;
}

}  // namespace thermotwin::nc
