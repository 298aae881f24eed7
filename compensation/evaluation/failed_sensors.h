// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Study of sensors that fail while a load program runs: the loss of compensation by each fault, and the time until the
// sensor is named.

#include <string>
#include <vector>

#include "compensation/evaluation/validation.h"

namespace thermotwin::compensation {

/// One sensor that fails in one way, from a row in the middle of a program to its end.
struct FailedSensorRow {
  std::string load, sensor, fault;  ///< stuck, offset (2 K), noise (ten times), absent
  int draw = 0;
  /// Share of the RMS at the check points after the failure that the offsets remove with all sensors, in the directions
  /// that linear axes move.
  double whole_percent = 0;
  double failed_percent = 0;  ///< the same with the failed sensor among them
  /// Minutes from the failure (stuck: from a change of the true reading by 5 deviations) until it is named; infinite:
  /// never.
  double named_min = 0;
  bool told = true;     ///< false: stuck, but the true reading never changed that far
  int false_names = 0;  ///< number of other sensors named
  double cost_percent() const { return 100.0 * (1.0 - failed_percent / whole_percent); }
};

struct FailedSensorStudy {
  std::vector<FailedSensorRow> rows;
  std::vector<int> alarms;  ///< (draws) number of sensors named in runs without a failure
  Eigen::Index measured_nodes = 0;
  int false_alarms() const;   ///< of all draws
  std::string brief() const;  ///< a row for each program and fault
  Rows summary() const;       ///< the same rows
  FailedSensorStudy first(int draws) const;
};

/// The load programs of the case with the rows of a control. @throws InputError if one is unknown
std::vector<MeasuredLoad> failed_sensor_loads(const solver::Case& machine_case, const ValidationOptions& options);

/// Each sensor fails in each way once for each program and machine. Rows have an interval of one minute.
FailedSensorStudy study_failed_sensors(const solver::Case& machine_case, const reduction::ReducedModel& model,
                                       const ValidationOptions& options);

}  // namespace thermotwin::compensation
