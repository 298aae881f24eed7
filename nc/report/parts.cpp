// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/report/parts.h"

#include <fmt/format.h>

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

}  // namespace thermotwin::nc
