// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/report/operations.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace thermotwin::nc {

namespace units = core::units;

void Operations::add(const Timed& timed) {
  Operation& operation = at(timed.element.state);
  const double duration = timed.duration(), end = timed.start + duration;
  if (!operation.any) {
    operation.start = timed.start;
    operation.first_line = timed.element.state.line;
    operation.any = true;
  }
  operation.end = end;
  operation.tool = timed.element.state.tool;
  operation.last_line = std::max(operation.last_line, timed.element.state.line);
  operation.rpm_s += std::abs(timed.element.state.spindle_rpm) * duration;
  if (timed.element.state.flood || timed.element.state.mist) operation.fluid_s += duration;
  if (timed.element.last) ++operation.moves;
  if (timed.element.pause > 0.0) {
    operation.pause_s += duration;
  } else if (timed.element.rapid) {
    operation.rapid_s += duration;
  } else {
    operation.cutting_s += duration;
    if (timed.element.angular) return;
    operation.feed_length += timed.element.length;
    operation.feed_s += duration;
  }
}

void Operations::add(const PredictedMove& move) {
  if (move.timed->element.rapid) return;
  Operation& operation = at(move.timed->element.state);
  if (operation.cuts == 0)
    operation.largest_um = operation.sum_um = operation.std_um = Eigen::ArrayXd::Zero(move.mean_um.size());
  ++operation.cuts;
  for (const Eigen::VectorXd* end : {&move.low_um, &move.high_um})
    for (Eigen::Index i = 0; i < end->size(); ++i)
      if (std::abs((*end)[i]) > std::abs(operation.largest_um[i])) operation.largest_um[i] = (*end)[i];
  const double seconds = std::max(move.duration(), 1e-9);
  operation.offset_s += seconds;
  operation.sum_um += seconds * move.mean_um.array();
  operation.std_um = operation.std_um.max(move.std_um.array());
}

std::vector<std::pair<std::pair<int, int>, const Operation*>> Operations::all() const {
  std::vector<std::pair<std::pair<int, int>, const Operation*>> list;
  for (const auto& [key, operation] : operations_)
    if (operation.any) list.emplace_back(key, &operation);
  return list;
}

std::string Operations::csv(const std::vector<std::string>& axes) const {
  std::string text =
      "part,operation,tool,first_line,last_line,start_s,end_s,cutting_s,rapid_s,pause_s,feed_length_mm,"
      "mean_feed_mm_min,mean_spindle_rpm,fluid_share,moves";
  for (const std::string& axis : axes)
    text += fmt::format(",mean_offset_{0}_um,largest_offset_{0}_um,std_{0}_um", axis);
  text += "\n";
  for (const auto& [key, operation] : all()) {
    const Operation& o = *operation;
    const double duration = std::max(o.duration(), 1e-12);
    text += fmt::format("{},{},{},{},{},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.6g},{:.6g},{:.6g},{}",
                        key.first + 1, key.second, o.tool, o.first_line, o.last_line, o.start, o.end, o.cutting_s,
                        o.rapid_s, o.pause_s, o.feed_length / units::mm, o.mean_feed() / units::mm_min,
                        o.rpm_s / duration, o.fluid_s / duration, o.moves);
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const Eigen::Index k = i;
      text += o.cuts == 0
                  ? ",,,"
                  : fmt::format(",{:.5g},{:.5g},{:.4g}", o.sum_um[k] / o.offset_s, o.largest_um[k], o.std_um[k]);
    }
    text += "\n";
  }
  return text;
}

std::size_t Operations::count() const {
  return std::count_if(operations_.begin(), operations_.end(), [](const auto& one) { return one.second.any; });
}

}  // namespace thermotwin::nc
