// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Moves at which the model or the offsets leave their limits: a pose outside of the model's workspace, an offset above
// the largest one that a control is given, an offset that changes faster than its limit (compensation/online/
// offset_limits.h). Neighbouring moves of one kind are one entry.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compensation/online/offset_limits.h"
#include "nc/prediction/prediction.h"

namespace thermotwin::nc {

class BeyondLimits {
public:
  enum class Kind { workspace, size, rate };
  struct Entry {
    Kind kind;
    std::uint32_t first_line, last_line;
    double start_s, end_s;  ///< ends of the first and the last move
    long moves;
    double largest;  ///< um, um/s above what the axes' motion allows; 0 of workspace
  };
  static constexpr std::size_t most_entries = 200;

  explicit BeyondLimits(compensation::OffsetLimits limits) : limits_(std::move(limits)) {}
  void add(const PredictedMove& move);
  const std::vector<Entry>& entries() const { return entries_; }
  long not_listed() const { return not_listed_; }  ///< moves beyond the most entries
  const compensation::OffsetLimits& limits() const { return limits_; }

private:
  void note(Kind kind, const PredictedMove& move, double value);

  compensation::OffsetLimits limits_;
  std::vector<Entry> entries_;
  std::vector<long> last_;  ///< (kinds) number of the last move of the kind's last entry
  std::vector<std::size_t> open_;
  long number_ = 0, not_listed_ = 0;
  struct Before {
    Positions end;
    double time;
    Eigen::VectorXd offset_um;
  };
  std::optional<Before> before_;
};

}  // namespace thermotwin::nc
