// SPDX-License-Identifier: GPL-3.0-or-later
// When coolants flow in a load program: a pump runs on for after_run_s once it is switched off, and
// stops by itself after standstill_stop_s in which nothing moved. Online the control says so itself.
#include <algorithm>

#include "solver/load_program.h"

namespace thermotwin::solver {

namespace {

bool moves(const Channels& channels, const Eigen::VectorXd& row) {
  for (Eigen::Index i = 0; i < row.size(); ++i) {
    const std::string& name = channels.names()[static_cast<std::size_t>(i)];
    const bool speed = name == "spindle.speed_rpm" || (name.starts_with("axis.") && name.find(".feed_") != std::string::npos);
    if (speed && row[i] != 0.0) return true;
  }
  return false;
}

}  // namespace

void LoadProgram::divide_phase(std::size_t phase, double time) {
  const Eigen::VectorXd middle = row_at(time, 0.5 * (corners_[phase] + corners_[phase + 1]));
  const auto at = static_cast<std::ptrdiff_t>(phase);
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
        until = still && coolant.standstill_stop > 0.0 ? std::clamp(moved_until + coolant.standstill_stop, from, to) : to;
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

}  // namespace thermotwin::solver
