// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Study of a restart: a load program is interrupted by an hour in which machine and computer are off. The compensator
// goes on from its saved state and is compared with one that ran through the hour.

#include <string>
#include <vector>

#include "compensation/evaluation/validation.h"

namespace thermotwin::compensation {

/// RMS of the TCP error over the check points and the hour after the return, with the offsets as the guard lets them
/// through: those of a restart move from 0 at the guard's rate.
struct RestartRow {
  std::string load;
  int draw = 0;
  double off_at_h = 0;      ///< time at which the hour begins
  double before_um = 0;     ///< without compensation
  double through_um = 0;    ///< of a compensator that never stopped
  double restarted_um = 0;  ///< of one that went on from its state
  double at_once_um = 0;    ///< the same, with its offsets without the guard: what its state alone costs
  double rate_um_s = 0;     ///< of the guard while the axes stand
};

struct RestartStudy {
  std::vector<RestartRow> rows;
  Eigen::Index measured_nodes = 0;
  std::vector<std::string> loads() const;  ///< names, each once
  /// RMS over the machines of a load after a restart, over that of compensators that never stopped.
  double ratio(const std::string& load) const;
  double ratio_at_once(const std::string& load) const;  ///< the same without the guard
  Rows table() const;                                   ///< a row for each machine and load
  Rows summary() const;                                 ///< a row for each load
  std::string brief() const;
  RestartStudy first(int draws) const;
};

/// The text of a load program with an hour off between two of its phases: of those that leave an hour after it, the one
/// nearest to the middle. @param text  of a load program with two phases or more  @throws InputError
std::string with_hour_off(const std::string& text, const std::string& name, const mesh::Machine& machine);

/// The load programs of the options with an hour off and rows of a minute; in the first minute after it, of a second.
/// @throws InputError
std::vector<MeasuredLoad> restart_loads(const solver::Case& machine_case, const ValidationOptions& options);

RestartStudy study_restart(const solver::Case& machine_case, const reduction::ReducedModel& model,
                           const ValidationOptions& options);

}  // namespace thermotwin::compensation
