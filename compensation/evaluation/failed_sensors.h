// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Sensors that fail while a program runs: what each costs, and how soon it is named.

#include <string>
#include <vector>

#include "compensation/evaluation/validation.h"

namespace thermotwin::compensation {

/// One sensor that fails in one way, from a row in the middle of a program to its end.
struct FailedSensorRow {
  std::string load, sensor, fault;  ///< stuck, offset (2 K), noise (ten times), absent
  int draw = 0;
  double whole_percent = 0;   ///< of the RMS over the check points after the failure, removed with all sensors
  double failed_percent = 0;  ///< with the failed one among them
  double named_min =
      0;  ///< after the failure (stuck: after the true reading has moved by 5 deviations); infinite: not named
  bool told = true;     ///< false: stuck, but the true reading never moved that far
  int false_names = 0;  ///< other sensors named
  double cost_percent() const { return 100.0 * (1.0 - failed_percent / whole_percent); }
};

struct FailedSensorStudy {
  std::vector<FailedSensorRow> rows;
  std::vector<int> alarms;  ///< (draws) sensors named in runs where none had failed
  Eigen::Index measured_nodes = 0;
  int false_alarms() const;   ///< of all draws
  std::string brief() const;  ///< a row for each program and fault
  Rows summary() const;       ///< the same rows
  FailedSensorStudy first(int draws) const;
};

/// Rows come every minute, as from a control. Each sensor fails in each way once a program and machine.
FailedSensorStudy study_failed_sensors(const solver::Case& machine_case, const reduction::ReducedModel& model,
                                       const ValidationOptions& options);

}  // namespace thermotwin::compensation
