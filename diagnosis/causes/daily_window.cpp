// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/causes/daily_window.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace thermotwin::diagnosis {

namespace {

constexpr double day_h = 24.0;

double of_day(double hour) { return hour - day_h * std::floor(hour / day_h); }

std::string clock_time(double hour) {
  const long minutes = std::lround(60.0 * of_day(hour)) % (24 * 60);
  return fmt::format("{:02}:{:02}", minutes / 60, minutes % 60);
}

}  // namespace

double height(const DailyWindow& window, double hour) {
  const double length = window.to_h - window.from_h, ramp = std::min(window.ramp_h, length);
  double most = 0.0;
  // Hours since the middle of the rise, on the day and on those beside it.
  for (double since = of_day(hour - window.from_h) - day_h; since < 2.0 * day_h; since += day_h) {
    const double inside = std::min(since, length - since);
    most = std::max(most, ramp > 0.0 ? std::clamp(0.5 + inside / ramp, 0.0, 1.0) : inside >= 0.0 ? 1.0 : 0.0);
  }
  return most;
}

mesh::PowerLaw law_of(const DailyWindow& window, double power_W) {
  const double half = 0.5 * std::clamp(window.ramp_h, 1e-3, window.to_h - window.from_h);
  std::set<double> corners{0.0, day_h};
  for (const double edge : {window.from_h, window.to_h})
    for (const double corner : {edge - half, edge + half}) corners.insert(std::round(1e6 * of_day(corner)) / 1e6);
  mesh::PowerLaw law;
  law.input = mesh::time_of_day;
  for (const double hour : corners) {
    law.at.push_back(hour);
    law.power.push_back(power_W * height(window, hour));
  }
  return law;
}

std::string in_words(const DailyWindow& window) {
  return "from " + clock_time(window.from_h) + " to " + clock_time(window.to_h) + " every day";
}

}  // namespace thermotwin::diagnosis
