// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Time, loads and offsets of each operation: what a tool did between two tool changes or program stops.

#include <Eigen/Core>

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "nc/prediction/prediction.h"

namespace thermotwin::nc {

struct Operation {
  int tool = 0;
  std::uint32_t first_line = 0, last_line = 0;
  double start = 0, end = 0, cutting_s = 0, rapid_s = 0, pause_s = 0;  ///< s
  double feed_length = 0, feed_s = 0;                                  ///< m and s, without moves of rotary axes alone
  double rpm_s = 0, fluid_s = 0;                                       ///< integrals over time
  long moves = 0, cuts = 0;
  double offset_s = 0;                        ///< s, of the moves with offsets
  Eigen::ArrayXd largest_um, sum_um, std_um;  ///< (linear axes) of the offsets along cutting moves; sum over time
  bool any = false;

  double duration() const { return end - start; }
  double mean_feed() const { return feed_s > 0 ? feed_length / feed_s : 0.0; }  ///< m/s
};

class Operations {
public:
  void add(const Timed& timed);
  void add(const PredictedMove& move);
  /// @param axes  with offsets; empty: no prediction
  std::string csv(const std::vector<std::string>& axes) const;
  std::size_t count() const;
  /// By part and number, those with motion or a pause.
  std::vector<std::pair<std::pair<int, int>, const Operation*>> all() const;

private:
  Operation& at(const MoveState& state) { return operations_[{state.part, state.operation}]; }
  std::map<std::pair<int, int>, Operation> operations_;
};

}  // namespace thermotwin::nc
