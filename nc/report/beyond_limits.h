// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Moves at which the model or the offsets leave their limits: a pose outside of the model's workspace, an offset above
// the largest one that a control is given, an offset that changes faster than its limit (compensation/online/
// offset_limits.h). Neighbouring moves of one kind are one entry.

#include <array>
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
  /// All moves of one kind.
  struct Total {
    long moves = 0;
    std::uint32_t first_line = 0;  ///< of the first move
    double largest = 0;            ///< as of an entry
  };
  /// An offset of a move beyond a limit.
  struct Excess {
    Kind kind;
    double value;  ///< as Entry::largest
  };
  static constexpr std::size_t most_entries = 200;

  explicit BeyondLimits(compensation::OffsetLimits limits) : limits_(std::move(limits)) {}
  /// The offsets at the end of the move and at the moments within it. @return the first limit that they pass
  std::optional<Excess> add(const PredictedMove& move);
  const std::vector<Entry>& entries() const { return entries_; }
  const Total& total(Kind kind) const { return totals_[static_cast<std::size_t>(kind)]; }
  long not_listed() const { return not_listed_; }  ///< moves beyond the most entries
  const compensation::OffsetLimits& limits() const { return limits_; }

private:
  void note(Kind kind, const PredictedMove& move, double value);
  /// @return the rate since the last moment, um/s; 0 of the first one
  double rate_until(const Positions& positions, double time, const Eigen::VectorXd& offset_um);

  compensation::OffsetLimits limits_;
  std::vector<Entry> entries_;
  std::array<Total, 3> totals_;              ///< (kinds)
  std::array<long, 3> last_ = {-2, -2, -2};  ///< (kinds) number of the last move of the kind's last entry
  std::array<std::size_t, 3> open_ = {0, 0, 0};
  long number_ = 0, not_listed_ = 0;
  struct Before {
    Positions positions;
    double time = 0;
    Eigen::VectorXd offset_um;
  };
  std::optional<Before> before_;
};

}  // namespace thermotwin::nc
