// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/load_program.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace thermotwin::solver {

namespace {

/// Whole number of steps of at most `longest` in `length`; a hair over a whole number is rounding.
int steps_in(double length, double longest) { return std::max(1, static_cast<int>(std::ceil(length / longest - 1e-9))); }

}  // namespace

double LoadProgram::duration() const { return corners_.back(); }

std::vector<double> LoadProgram::output_times() const {
  std::vector<double> times;
  const double end = duration(), tolerance = 1e-9 * end;
  for (long i = 0; static_cast<double>(i) * output_ < end - tolerance; ++i) times.push_back(static_cast<double>(i) * output_);
  times.push_back(end);
  return times;
}

std::vector<double> LoadProgram::step_ends(double refine) const {
  std::vector<double> stops = output_times();
  stops.insert(stops.end(), corners_.begin(), corners_.end());
  std::sort(stops.begin(), stops.end());
  const double tolerance = 1e-9 * duration();
  std::vector<double> kept;
  for (double stop : stops)
    if (kept.empty() || stop - kept.back() > tolerance) kept.push_back(stop);
  kept.back() = duration();
  std::vector<double> ends;
  for (std::size_t i = 1; i < kept.size(); ++i) {
    const double length = kept[i] - kept[i - 1];
    const int steps = steps_in(length, time_step_ * refine);
    for (int k = 1; k <= steps; ++k) ends.push_back(k == steps ? kept[i] : kept[i - 1] + length * k / steps);
  }
  return ends;
}

Eigen::VectorXd LoadProgram::row(double from, double to) const {
  const double middle = 0.5 * (from + to);
  const auto after = std::upper_bound(corners_.begin(), corners_.end(), middle) - corners_.begin();
  const auto phase = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(after - 1, 0, static_cast<std::ptrdiff_t>(start_.size()) - 1));
  const double s = (middle - corners_[phase]) / (corners_[phase + 1] - corners_[phase]);
  Eigen::VectorXd values = start_[phase];
  for (Eigen::Index i = 0; i < values.size(); ++i)
    if (end_[phase][i] != values[i] && std::isfinite(values[i])) values[i] += s * (end_[phase][i] - values[i]);
  return values;
}

std::string LoadProgram::phase_at(double time) const {
  const auto after = std::upper_bound(corners_.begin(), corners_.end(), time) - corners_.begin();
  return phase_names_[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(after - 1, 0, static_cast<std::ptrdiff_t>(phase_names_.size()) - 1))];
}

}  // namespace thermotwin::solver
