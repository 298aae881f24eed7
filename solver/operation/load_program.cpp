// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/operation/load_program.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/config.h"
#include "core/error.h"
#include "solver/operation/load_keys.h"
#include "solver/operation/load_reader.h"

namespace thermotwin::solver {

namespace {

/// Whole number of steps of at most `longest` in `length`; a hair over a whole number is rounding.
int steps_in(double length, double longest) {
  return std::max(1, static_cast<int>(std::ceil(length / longest - 1e-9)));
}

bool moves(const Channels& channels, const Eigen::VectorXd& row) {
  for (Eigen::Index i = 0; i < row.size(); ++i) {
    const std::string& name = channels.names()[i];
    const bool speed =
        name == "spindle.speed_rpm" || (name.starts_with("axis.") && name.find(".feed_") != std::string::npos);
    if (speed && row[i] != 0.0) return true;
  }
  return false;
}

}  // namespace

double LoadProgram::duration() const { return corners_.back(); }

std::vector<double> LoadProgram::output_times() const {
  if (!chosen_outputs_.empty()) return chosen_outputs_;
  std::vector<double> times;
  const double end = duration(), tolerance = 1e-9 * end;
  for (long i = 0; i * output_ < end - tolerance; ++i) times.push_back(i * output_);
  times.push_back(end);
  return times;
}

void LoadProgram::choose_outputs(std::vector<double> times, const std::string& place) {
  const double end = duration(), tolerance = 1e-9 * end;
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!(times[i] >= 0.0 && times[i] <= end + tolerance)) {
      throw core::InputError(place, fmt::format("output at {} s", times[i]),
                             fmt::format("0 to {} s, the length of '{}'", end, name_));
    }
    if (i > 0 && !(times[i] > times[i - 1] + tolerance))
      throw core::InputError(place, fmt::format("{} s after {} s", times[i], times[i - 1]), "rising times");
    times[i] = std::min(times[i], end);
  }
  if (!times.empty() && !(times.back() > 0.0))
    throw core::InputError(place, "no output after the start", "at least one time above 0");
  chosen_outputs_ = std::move(times);
}

std::vector<double> LoadProgram::stops() const {
  std::vector<double> all = output_times();
  all.insert(all.end(), corners_.begin(), corners_.end());
  std::sort(all.begin(), all.end());
  const double tolerance = 1e-9 * duration(), end = chosen_outputs_.empty() ? duration() : chosen_outputs_.back();
  std::vector<double> kept;
  for (double stop : all) {
    if (stop > tolerance && stop <= end + tolerance && (kept.empty() || stop - kept.back() > tolerance))
      kept.push_back(stop);
  }
  kept.back() = end;
  return kept;
}

bool LoadProgram::is_corner(double time) const {
  return std::any_of(corners_.begin(), corners_.end(),
                     [&](double corner) { return std::abs(corner - time) <= 1e-9 * duration(); });
}

std::vector<double> LoadProgram::step_ends(double refine) const {
  std::vector<double> ends;
  double from = 0.0;
  for (double stop : stops()) {
    const double length = stop - from;
    const int steps = steps_in(length, time_step_ * refine);
    for (int k = 1; k <= steps; ++k) ends.push_back(k == steps ? stop : from + length * k / steps);
    from = stop;
  }
  return ends;
}

std::size_t LoadProgram::phase_index(double time) const {
  const auto after = std::upper_bound(corners_.begin(), corners_.end(), time) - corners_.begin();
  return std::clamp<std::ptrdiff_t>(after - 1, 0, std::ssize(start_) - 1);
}

Eigen::VectorXd LoadProgram::row(double from, double to) const {
  const double middle = 0.5 * (from + to);
  return row_at(middle, middle);
}

Eigen::VectorXd LoadProgram::row_at(double time, double inside) const {
  const std::size_t phase = phase_index(inside);
  const double s = (time - corners_[phase]) / (corners_[phase + 1] - corners_[phase]);
  Eigen::VectorXd values = start_[phase];
  for (Eigen::Index i = 0; i < values.size(); ++i)
    if (end_[phase][i] != values[i] && std::isfinite(values[i])) values[i] += s * (end_[phase][i] - values[i]);
  return values;
}

std::string LoadProgram::phase_at(double time) const { return phase_names_[phase_index(time)]; }

// When coolants flow: a pump runs on for after_run_s once it is switched off, and stops by itself after
// standstill_stop_s in which nothing moved. Online the control says so itself.
void LoadProgram::divide_phase(std::size_t phase, double time) {
  const Eigen::VectorXd middle = row_at(time, 0.5 * (corners_[phase] + corners_[phase + 1]));
  const std::ptrdiff_t at = phase;
  corners_.insert(corners_.begin() + at + 1, time);
  start_.insert(start_.begin() + at + 1, middle);
  end_.insert(end_.begin() + at, middle);
  phase_names_.insert(phase_names_.begin() + at, phase_names_[phase]);
}

void LoadProgram::schedule_coolants(const mesh::Machine& machine, const Channels& channels) {
  const double crumb = 1e-9 * duration();
  for (const mesh::CoolantSpec& coolant : machine.coolants) {
    if (coolant.after_run <= 0.0 && coolant.standstill_stop <= 0.0) continue;
    const int on = channels.index("coolant." + coolant.id + ".on");
    double moved_until = 0.0, ran_until = -1e300;  // the pump: by command, not by running on
    for (std::size_t phase = 0; phase < start_.size(); ++phase) {
      const double from = corners_[phase], to = corners_[phase + 1];
      double until = from;  // the pump runs in [from, until]
      if (start_[phase][on] > 0.0) {
        const bool still = !moves(channels, start_[phase]);
        if (!still) moved_until = to;
        until =
            still && coolant.standstill_stop > 0.0 ? std::clamp(moved_until + coolant.standstill_stop, from, to) : to;
        // One that has stopped by itself does not run on.
        ran_until = until >= to ? to : -1e300;
      } else if (coolant.after_run > 0.0) {
        until = std::clamp(ran_until + coolant.after_run, from, to);
      }
      const bool part = until > from + crumb && until < to - crumb;
      if (part) divide_phase(phase, until);
      start_[phase][on] = end_[phase][on] = until > from + crumb ? 1.0 : 0.0;
      if (part) {
        ++phase;
        start_[phase][on] = end_[phase][on] = 0.0;
      }
    }
  }
}

LoadProgram LoadProgram::read(const std::filesystem::path& path, const mesh::Machine& machine) {
  return LoadReader::read(core::Config::load(path, &load_keys()), path, machine);
}

LoadProgram LoadProgram::parse(const std::string& text, const std::filesystem::path& path,
                               const mesh::Machine& machine) {
  return LoadReader::read(core::Config::parse(text, path.string(), &load_keys()), path, machine);
}

}  // namespace thermotwin::solver
