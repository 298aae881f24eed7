// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Readings of one temperature over the last three days, in cells of ten minutes, as Naumann et al. (2023) use them: the
// mean, and a one-sided Gaussian filter. Nothing looks ahead.

#include <deque>
#include <utility>

namespace thermotwin::compensation {

class TemperatureHistory {
public:
  static constexpr double cell_s = 600.0, longest_s = 3 * 86400.0;

  /// @param time  s, rising; a gap counts as the reading before it, one of more than three days begins anew
  void add(double time, double value);
  /// Mean over up to three days before now, of the unit of the readings; at least one reading is needed.
  double mean() const;
  /// Weighted by exp(-age^2 / (2 sigma^2)), the oldest cell standing for all before it. @param sigma  s, > 0
  double filtered(double sigma) const;

private:
  std::deque<std::pair<double, double>> cells_;  ///< sum and count, newest first
  double begin_ = 0;
};

}  // namespace thermotwin::compensation
