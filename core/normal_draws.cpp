// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/normal_draws.h"

#include <cmath>
#include <numbers>

namespace thermotwin::core {

double NormalDraws::operator()() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  const auto uniform = [&] { return ((engine_() >> 11) + 1) * 0x1p-53; };  // in (0, 1]
  const double u = uniform(), v = uniform();
  const double radius = std::sqrt(-2.0 * std::log(u)), angle = 2.0 * std::numbers::pi * v;
  spare_ = radius * std::sin(angle);
  has_spare_ = true;
  return radius * std::cos(angle);
}

}  // namespace thermotwin::core
