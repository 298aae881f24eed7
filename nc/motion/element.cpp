// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/motion/element.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace thermotwin::nc {

Element Element::line(const Positions& from, const Positions& to) {
  Element element;
  element.base = from;
  element.slope = to - from;
  element.first = element.second = Positions::Zero(from.size());
  return element;
}

Positions Element::at(double u) const {
  if (angle == 0.0) return base + u * slope;
  const double r = r0 + (r1 - r0) * u, phi = angle * u;
  return base + u * slope + r * std::cos(phi) * first + r * std::sin(phi) * second;
}

Positions Element::derivative(double u) const {
  if (angle == 0.0) return slope;
  const double r = r0 + (r1 - r0) * u, phi = angle * u, c = std::cos(phi), s = std::sin(phi);
  return slope + ((r1 - r0) * c - r * angle * s) * first + ((r1 - r0) * s + r * angle * c) * second;
}

Positions Element::fastest() const {
  if (angle == 0.0) return slope.cwiseAbs();
  const double r = std::max(r0, r1), most = r * angle + std::abs(r1 - r0);
  return slope.cwiseAbs() + most * (first.array().square() + second.array().square()).sqrt().matrix();
}

void Element::sweep(double u0, double u1, Positions& travel, Positions& low, Positions& high) const {
  const auto reach = [&](const Positions& q) {
    low = low.cwiseMin(q);
    high = high.cwiseMax(q);
  };
  Positions before = at(u0);
  reach(before);
  if (angle == 0.0) {
    const Positions after = at(u1);
    travel += (u1 - u0) * slope.cwiseAbs();
    reach(after);
    return;
  }
  // An axis turns where its derivative changes its sign; between turns it covers the difference. Within an eighth of
  // a turn of the arc there is at most one.
  const int parts = std::max(1, static_cast<int>(std::ceil(angle * (u1 - u0) / (0.25 * std::numbers::pi))));
  double left = u0;
  for (int k = 1; k <= parts; ++k) {
    const double right = k == parts ? u1 : u0 + (u1 - u0) * k / parts;
    const Positions after = at(right), slope_left = derivative(left), slope_right = derivative(right);
    for (Eigen::Index i = 0; i < before.size(); ++i) {
      if (!(slope_left[i] * slope_right[i] < 0.0)) {
        travel[i] += std::abs(after[i] - before[i]);
        continue;
      }
      double a = left, b = right;
      for (int step = 0; step < 60; ++step) {
        const double middle = 0.5 * (a + b);
        (derivative(middle)[i] * slope_left[i] > 0.0 ? a : b) = middle;
      }
      const double turn = at(0.5 * (a + b))[i];
      travel[i] += std::abs(turn - before[i]) + std::abs(after[i] - turn);
      low[i] = std::min(low[i], turn);
      high[i] = std::max(high[i], turn);
    }
    reach(after);
    before = after;
    left = right;
  }
}

}  // namespace thermotwin::nc
