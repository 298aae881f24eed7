// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/report/beyond_limits.h"

#include <algorithm>

namespace thermotwin::nc {

void BeyondLimits::note(Kind kind, const PredictedMove& move, double value) {
  const auto k = static_cast<std::size_t>(kind);
  if (last_.empty()) {
    last_.assign(3, -2);
    open_.assign(3, 0);
  }
  const std::uint32_t line = move.timed->element.state.line;
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

void BeyondLimits::add(const PredictedMove& move) {
  ++number_;
  if (move.outside) note(Kind::workspace, move, 0.0);
  const double size = move.offset_um.cwiseAbs().maxCoeff();
  if (size > limits_.largest_um) note(Kind::size, move, size);
  if (before_ && move.time > before_->time) {
    const double duration = move.time - before_->time,
                 changed = (move.offset_um - before_->offset_um).cwiseAbs().maxCoeff(),
                 rate = (changed - limits_.motion_um(before_->end, move.end, duration)) / duration;
    if (rate > limits_.rate_um_s) note(Kind::rate, move, rate);
  }
  before_ = {move.end, move.time, move.offset_um};
}

}  // namespace thermotwin::nc
